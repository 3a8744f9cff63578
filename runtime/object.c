/* Translucent objects: their samples and grids on the GPU, and what of them a frame draws. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "matrix.h"
#include "state.h"

enum {
    FEWEST = 256, /* samples of an object, if it has so many */
    LIT_SIZE = 32 /* bytes a sample: its light and the light's slope */
};

uint64_t al_object_coefficient_size(const al_translucent_info *info)
{
    static const uint32_t size[] = {4, 2, 1};
    return (uint64_t)info->channel_count * info->order * info->order * size[info->format];
}

static float sigma_t(const al_translucent_info *info, int channel)
{
    return info->sigma_s_per_m[channel] + info->sigma_a_per_m[channel];
}

static float largest_sigma_t(const al_translucent_info *info)
{
    return fmaxf(sigma_t(info, 0), fmaxf(sigma_t(info, 1), sigma_t(info, 2)));
}

static al_status create(al_runtime *runtime, al_object *object, const al_translucent_info *info,
                        al_error *error)
{
    uint64_t count = info->sample_count;
    al_gl_memory *memory = &runtime->memory;
    GLint64 largest = 0;
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &largest);
    if (count * LIT_SIZE > (uint64_t)largest)
        return al_fail(error, AL_BAD_INPUT, "%s: %u samples; this OpenGL's storage blocks hold at most %lld",
                       runtime->scene.translucents[object - runtime->objects].asset, info->sample_count,
                       (long long)(largest / LIT_SIZE));
    object->info = *info;
    /* Shaders read whole words, so the last coefficients are padded to one. */
    al_status status = al_gl_buffer_create(memory, count * 12, NULL, &object->positions, error);
    if (!status) status = al_gl_buffer_create(memory, count * 16, NULL, &object->gaussians, error);
    if (!status)
        status = al_gl_buffer_create(memory, (count * al_object_coefficient_size(info) + 3) / 4 * 4, NULL,
                                     &object->coefficients, error);
    if (!status && info->format == AL_COEFFICIENT_BYTE)
        status = al_gl_buffer_create(memory, count * info->channel_count * 4, NULL, &object->scales, error);
    if (!status) status = al_gl_buffer_create(memory, count * LIT_SIZE, NULL, &object->lit, error);
    if (!status)
        status = al_gl_buffer_create(memory, sizeof(al_object_block), NULL, &object->constants, error);
    if (!status)
        status = al_gl_texture_create(memory, GL_TEXTURE_3D, info->has_blockers ? GL_RG16 : GL_R16,
                                      info->grid_size[0], info->grid_size[1], info->grid_size[2], 1,
                                      &object->density, error);
    if (status) return status;
    static const float outside[4] = {0};
    GLuint id = object->density.id;
    glTextureParameteri(id, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(id, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(id, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
    glTextureParameteri(id, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
    glTextureParameteri(id, GL_TEXTURE_WRAP_R, GL_CLAMP_TO_BORDER);
    glTextureParameterfv(id, GL_TEXTURE_BORDER_COLOR, outside);
    float reference = largest_sigma_t(info);
    for (int c = 0; c < 3; c++)
        if (sigma_t(info, c) > 0 && sigma_t(info, c) < reference) object->chromatic = true;
    return AL_OK;
}

/* Uploads `count` slices from `first` on; a grid with blockers goes as pairs. */
static al_status upload_slices(al_object *object, const al_arrival *arrival, uint64_t first, uint64_t count,
                               al_error *error)
{
    const uint32_t *size = arrival->info.grid_size;
    uint64_t slice = (uint64_t)size[0] * size[1];
    const uint16_t *density = arrival->density + first * slice;
    if (!arrival->info.has_blockers) {
        glTextureSubImage3D(object->density.id, 0, 0, 0, (GLint)first, (GLsizei)size[0], (GLsizei)size[1],
                            (GLsizei)count, GL_RED, GL_UNSIGNED_SHORT, density);
        return AL_OK;
    }
    const uint8_t *blockers = arrival->blockers + first * slice;
    uint16_t *pairs = malloc(slice * count * 2 * sizeof *pairs);
    if (!pairs) return al_fail(error, AL_IO, "no memory for the density grid of an object");
    for (uint64_t i = 0; i < slice * count; i++) {
        pairs[2 * i] = density[i];
        pairs[2 * i + 1] = (uint16_t)(blockers[i] * 257);
    }
    glTextureSubImage3D(object->density.id, 0, 0, 0, (GLint)first, (GLsizei)size[0], (GLsizei)size[1],
                        (GLsizei)count, GL_RG, GL_UNSIGNED_SHORT, pairs);
    free(pairs);
    return AL_OK;
}

static al_status accept_object(al_runtime *runtime, al_object *object, const al_arrival *arrival,
                               uint64_t *budget, bool *done, al_error *error)
{
    const uint32_t *size = arrival->info.grid_size;
    al_status status = object->density.id ? AL_OK : create(runtime, object, &arrival->info, error);
    if (!status) {
        uint64_t texel = arrival->info.has_blockers ? 4 : 2;
        uint64_t count =
            al_budget_share(budget, (uint64_t)size[0] * size[1] * texel, size[2] - object->slices);
        status = upload_slices(object, arrival, object->slices, count, error);
        object->slices += count;
    }
    *done = status || object->slices == size[2];
    object->present = !status && *done;
    object->failed = status != AL_OK;
    return status;
}

static void accept_page(al_runtime *runtime, al_object *object, const al_arrival *arrival, uint64_t *budget,
                        bool *done)
{
    const al_translucent_page *page = &arrival->page;
    uint64_t size = al_object_coefficient_size(&object->info),
             scales = object->scales.id ? 4 * object->info.channel_count : 0;
    uint64_t at = runtime->arrived, first = page->first + at;
    *done = !object->present || at >= page->count;
    if (*done) return;
    uint64_t count = al_budget_share(budget, size + scales + 28, page->count - at);
    glNamedBufferSubData(object->positions.id, (GLintptr)(first * 12), (GLsizeiptr)(count * 12),
                         page->positions + 3 * at);
    glNamedBufferSubData(object->gaussians.id, (GLintptr)(first * 16), (GLsizeiptr)(count * 16),
                         page->gaussians + 4 * at);
    glNamedBufferSubData(object->coefficients.id, (GLintptr)(first * size), (GLsizeiptr)(count * size),
                         (const uint8_t *)page->coefficients + at * size);
    if (scales)
        glNamedBufferSubData(object->scales.id, (GLintptr)(first * scales), (GLsizeiptr)(count * scales),
                             page->scales + object->info.channel_count * at);
    runtime->arrived += (uint32_t)count;
    object->loaded = (uint32_t)(first + count);
    *done = runtime->arrived == page->count;
}

al_status al_object_accept(al_runtime *runtime, const al_arrival *arrival, uint64_t *budget, bool *done,
                           al_error *error)
{
    al_object *object = &runtime->objects[arrival->object];
    if (arrival->kind == AL_ARRIVAL_OBJECT)
        return accept_object(runtime, object, arrival, budget, done, error);
    accept_page(runtime, object, arrival, budget, done);
    return AL_OK;
}

void al_object_free(al_runtime *runtime, al_object *object)
{
    al_gl_memory *memory = &runtime->memory;
    al_gl_buffer_free(memory, &object->positions);
    al_gl_buffer_free(memory, &object->gaussians);
    al_gl_buffer_free(memory, &object->coefficients);
    al_gl_buffer_free(memory, &object->scales);
    al_gl_buffer_free(memory, &object->lit);
    al_gl_buffer_free(memory, &object->constants);
    al_gl_texture_free(memory, &object->density);
    memset(object, 0, sizeof *object);
}

/* Pixels per metre at the object's middle, or infinity when the eye is inside its bounding sphere. */
static double pixels_per_metre(const al_draw *draw, const double middle[4], double radius)
{
    double clip[4];
    al_matrix_transform(draw->view_projection, middle, clip);
    if (draw->eye[3] > 0) {
        double squared = 0;
        for (int k = 0; k < 3; k++) squared += (middle[k] - draw->eye[k]) * (middle[k] - draw->eye[k]);
        if (squared < radius * radius || !(clip[3] > 0)) return INFINITY;
    }
    return 0.5 * draw->view->height * fabs(draw->view->projection[5]) / clip[3];
}

/* Level of detail by distance. Where the mean spacing of all samples, cbrt(volume / count), falls below half
 * a pixel, only as many are drawn as keep it there, but no fewer than FEWEST, for the light inside varies
 * with the mean free path and not with pixels; an object of few pixels loses bands too: of D pixels across
 * three and one more per 16. Returns the share of the samples. */
static double detail(const al_draw *draw, const al_object *object, const double middle[4], uint32_t *order)
{
    const al_translucent_info *info = &object->info;
    double radius = 0;
    for (int k = 0; k < 3; k++) {
        double half = 0.5 * ((double)info->bounds_max_m[k] - info->bounds_min_m[k]);
        radius += half * half;
    }
    radius = sqrt(radius);
    double scale = pixels_per_metre(draw, middle, radius);
    if (!isfinite(scale)) return 1;
    double bands = 3 + floor(2 * radius * scale / 16);
    if (bands < *order) *order = (uint32_t)bands;
    return fmin(1, fmax(8 * info->volume_m3 * scale * scale * scale, FEWEST) / info->sample_count);
}

/* How many samples are drawn, how many bands, and how much wider the Gaussians of a prefix are: a share f of
 * the samples, well spread, stands f^(-1/3) times farther apart, so radii grow by that and a = 1/(2 s^2)
 * shrinks by f^(2/3); the sum of the Gaussians stays about one, and normalisation does the rest. */
static void choose_detail(const al_draw *draw, al_object *object, const double middle[4])
{
    const al_settings *settings = &draw->settings;
    object->order = object->info.order;
    object->drawn = object->loaded;
    if (settings->sh_order && settings->sh_order < object->order) object->order = settings->sh_order;
    if (settings->sample_limit && settings->sample_limit < object->drawn)
        object->drawn = settings->sample_limit;
    if (!settings->detail_off && object->info.sample_count) {
        double count = ceil(detail(draw, object, middle, &object->order) * object->info.sample_count);
        if (count < object->drawn) object->drawn = (uint32_t)count;
    }
    if (!draw->needs_light) object->drawn = 0;
    double share_drawn = object->drawn ? (double)object->drawn / object->info.sample_count : 1;
    object->block.prefix[0] = (float)pow(share_drawn, 2.0 / 3);
    object->block.prefix[1] = (float)pow(share_drawn, -1.0 / 3);
}

/* Bounds in the view of the grid's box: the whole view when a corner is not in front of the eye. */
static void find_rectangle(const al_draw *draw, al_object *object, const double *world)
{
    const float *low = object->block.box_min, *size = object->block.box_size;
    double all[16], bounds[4] = {INFINITY, INFINITY, -INFINITY, -INFINITY};
    double width = draw->view->width, height = draw->view->height, margin = 0.5 * low[3];
    al_matrix_multiply(draw->view_projection, world, all);
    for (int corner = 0; corner < 8; corner++) {
        double place[4] = {0, 0, 0, 1}, clip[4];
        for (int k = 0; k < 3; k++) place[k] = low[k] + (corner >> k & 1 ? size[k] + margin : -margin);
        al_matrix_transform(all, place, clip);
        if (!(clip[3] > 0)) {
            bounds[0] = bounds[1] = -INFINITY;
            bounds[2] = bounds[3] = INFINITY;
            break;
        }
        for (int k = 0; k < 2; k++) {
            bounds[k] = fmin(bounds[k], clip[k] / clip[3]);
            bounds[k + 2] = fmax(bounds[k + 2], clip[k] / clip[3]);
        }
    }
    int32_t x0 = (int32_t)fmax(0, floor((fmax(bounds[0], -1) * 0.5 + 0.5) * width) - 1);
    int32_t y0 = (int32_t)fmax(0, floor((fmax(bounds[1], -1) * 0.5 + 0.5) * height) - 1);
    int32_t x1 = (int32_t)fmin(width, ceil((fmin(bounds[2], 1) * 0.5 + 0.5) * width) + 1);
    int32_t y1 = (int32_t)fmin(height, ceil((fmin(bounds[3], 1) * 0.5 + 0.5) * height) + 1);
    bool seen = x0 < x1 && y0 < y1;
    object->rectangle[0] = x0;
    object->rectangle[1] = y0;
    object->rectangle[2] = seen ? x1 - x0 : 0;
    object->rectangle[3] = seen ? y1 - y0 : 0;
}

static void fill_box(const al_translucent_info *info, float low[4], float size[4])
{
    for (int k = 0; k < 3; k++) {
        low[k] = info->grid_origin_m[k];
        size[k] = (float)info->grid_size[k] * info->voxel_m;
    }
    low[3] = info->voxel_m;
    size[3] = info->has_blockers ? 1 : 0;
}

static void fill_medium(al_object_block *block, const al_translucent_info *info)
{
    float reference = largest_sigma_t(info);
    block->ratio[3] = 0;
    for (int c = 0; c < 3; c++) {
        float extinction = sigma_t(info, c);
        block->sigma_s[c] = info->sigma_s_per_m[c];
        block->albedo[c] = extinction > 0 ? info->sigma_s_per_m[c] / extinction : 0;
        block->ratio[c] = reference > 0 ? extinction / reference : 0;
        if (extinction > 0) block->ratio[3] += 1;
    }
    block->albedo[3] = info->g;
    block->march[0] = reference * info->density_max;
    block->march[2] = reference;
}

static void fill_rays(const al_draw *draw, al_object_block *block, const double *inverse)
{
    for (int i = 0; i < 6; i++) {
        double ray[4] = {draw->block.ray[i][0], draw->block.ray[i][1], draw->block.ray[i][2], i == 0};
        al_matrix_transform(inverse, ray, ray);
        for (int k = 0; k < 3; k++) block->ray[i][k] = (float)ray[k];
    }
}

static void fill_caster(al_draw *draw, const al_object *object)
{
    al_caster_block *caster = &draw->block.casters[object->block.sizes[2]];
    memcpy(caster->to_object, object->block.world_to_object, sizeof caster->to_object);
    memcpy(caster->box_min, object->block.box_min, sizeof caster->box_min);
    memcpy(caster->box_size, object->block.box_size, sizeof caster->box_size);
    for (int c = 0; c < 3; c++) caster->sigma_t[c] = sigma_t(&object->info, c) * object->info.density_max;
    al_gl_bind_texture(AL_UNIT_CASTERS + (uint32_t)object->block.sizes[2], object->density.id);
}

static void prepare(al_draw *draw, al_object *object, const al_translucent_object *source)
{
    const al_settings *settings = &draw->settings;
    const al_instance *instance = &draw->runtime->scene.instances[source->instance];
    al_object_block *block = &object->block;
    double world[16], inverse[16], middle[4] = {0, 0, 0, 1};
    al_matrix_from_float(instance->world, world);
    al_matrix_inverse(world, inverse);
    al_matrix_to_float(world, block->object_to_world);
    al_matrix_to_float(inverse, block->world_to_object);
    fill_rays(draw, block, inverse);
    fill_box(&object->info, block->box_min, block->box_size);
    fill_medium(block, &object->info);
    block->march[1] = settings->march_voxels * object->info.voxel_m;
    block->sizes[1] = (int32_t)settings->interval_count;
    block->sizes[2] = -1;
    if (draw->block.counts[1] < AL_CASTER_LIMIT) {
        block->sizes[2] = draw->block.counts[1]++;
        fill_caster(draw, object);
    }
    block->sizes[3] = (int32_t)draw->runtime->frame_number;
    block->toggles[0] = !settings->clip_off;
    block->toggles[1] = !settings->normalise_off;
    block->toggles[2] = !settings->shadows_off;
    block->toggles[3] = draw->block.counts[2] != 0;
    al_environment_for_object(draw, object);
    for (int k = 0; k < 3; k++)
        middle[k] = 0.5 * ((double)object->info.bounds_min_m[k] + object->info.bounds_max_m[k]);
    al_matrix_transform(world, middle, middle);
    choose_detail(draw, object, middle);
    block->sizes[0] = (int32_t)object->drawn;
    find_rectangle(draw, object, world);
    double along = 0, squared = 0;
    for (int k = 0; k < 3; k++) {
        double path = middle[k] - draw->eye[k];
        squared += path * path;
        along -= middle[k] * draw->eye[k];
    }
    object->distance_m = draw->eye[3] > 0 ? sqrt(squared) : along;
    glNamedBufferSubData(object->constants.id, 0, sizeof *block, block);
}

void al_objects_prepare(al_draw *draw)
{
    al_runtime *runtime = draw->runtime;
    uint32_t count = 0;
    draw->block.counts[1] = 0;
    runtime->samples_drawn = 0;
    for (uint32_t i = 0; i < runtime->scene.translucent_count; i++) {
        al_object *object = &runtime->objects[i];
        if (!object->present) continue;
        prepare(draw, object, &runtime->scene.translucents[i]);
        runtime->samples_drawn += object->drawn;
        uint32_t place = count++; /* insertion: far before near, ties by index */
        for (; place > 0 && runtime->objects[runtime->sorted[place - 1]].distance_m < object->distance_m;
             place--)
            runtime->sorted[place] = runtime->sorted[place - 1];
        runtime->sorted[place] = i;
    }
    for (uint32_t i = count; i < runtime->scene.translucent_count; i++) runtime->sorted[i] = UINT32_MAX;
}
