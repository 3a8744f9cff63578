/* Media that fill the air: their bricks on the GPU, and the fog between eye and surfaces. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "matrix.h"
#include "state.h"

enum { ATLAS_EDGE = 16, BRICK_BYTES = AL_BRICK_SIZE * 2 };

al_status al_fog_create(al_runtime *runtime, al_error *error)
{
    al_fogs *fogs = &runtime->fogs;
    uint32_t count = runtime->scene.fog_count;
    if (!count) return AL_OK;
    fogs->media = calloc(count, sizeof *fogs->media);
    if (!fogs->media) return al_fail(error, AL_IO, "scene.air: no memory for its fogs");
    return al_gl_buffer_create(&runtime->memory, sizeof(al_fog_block), NULL, &fogs->constants, error);
}

void al_fog_fail(al_runtime *runtime, uint32_t index)
{
    runtime->fogs.media[index].failed = true;
}

void al_fog_free(al_runtime *runtime)
{
    al_fogs *fogs = &runtime->fogs;
    al_gl_buffer_free(&runtime->memory, &fogs->constants);
    al_gl_buffer_free(&runtime->memory, &fogs->cells);
    al_gl_texture_free(&runtime->memory, &fogs->bricks);
    al_gl_texture_free(&runtime->memory, &fogs->depth);
    al_fog_sky_free(runtime);
    free(fogs->media);
    memset(fogs, 0, sizeof *fogs);
}

uint64_t al_fog_bytes(const al_runtime *runtime)
{
    const al_fogs *fogs = &runtime->fogs;
    return fogs->constants.size + runtime->targets.fog_light.bytes + runtime->targets.fog_kept.bytes;
}

uint64_t al_fog_grid_bytes(const al_runtime *runtime)
{
    return runtime->fogs.cells.size + runtime->fogs.bricks.bytes;
}

/* --- bricks --- */

/* One voxel that holds for all of the bounds: such a medium needs no bricks. */
static bool is_constant(const al_medium_info *info)
{
    return info->extended && info->size[0] == 1 && info->size[1] == 1 && info->size[2] == 1;
}

static uint64_t cell_count(const al_medium_info *info)
{
    uint32_t cells[3];
    al_medium_cells(info, cells);
    return (uint64_t)cells[0] * cells[1] * cells[2];
}

static al_status make_bricks(al_runtime *runtime, uint64_t cells, al_error *error)
{
    al_fogs *fogs = &runtime->fogs;
    al_status status = al_gl_buffer_create(&runtime->memory, cells * 4, NULL, &fogs->cells, error);
    if (!status)
        status = al_gl_texture_create(&runtime->memory, GL_TEXTURE_3D, GL_R16F,
                                      (uint32_t)fogs->atlas[0] * AL_BRICK_EDGE,
                                      (uint32_t)fogs->atlas[1] * AL_BRICK_EDGE,
                                      (uint32_t)fogs->atlas[2] * AL_BRICK_EDGE, 1, &fogs->bricks, error);
    if (status) return status;
    glTextureParameteri(fogs->bricks.id, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(fogs->bricks.id, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    return AL_OK;
}

/* The loader hands out every medium before the first brick, so that sizes are known. */
static al_status make_atlas(al_runtime *runtime, al_error *error)
{
    al_fogs *fogs = &runtime->fogs;
    uint64_t bricks = 0, cells = 0;
    for (uint32_t i = 0; i < runtime->scene.fog_count; i++) {
        al_fog_medium *medium = &fogs->media[i];
        if (!medium->present || is_constant(&medium->info)) continue;
        for (uint32_t s = 0; s < al_fog_slot_count(&medium->info); s++) {
            medium->slots[s].first_brick = (uint32_t)bricks;
            medium->slots[s].first_cell = cells;
            bricks += medium->brick_limit;
            cells += cell_count(&medium->info);
        }
        medium->first_brick = medium->slots[medium->shown].first_brick;
        medium->first_cell = medium->slots[medium->shown].first_cell;
    }
    GLint edge = 0;
    GLint64 block = 0;
    glGetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &edge);
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &block);
    fogs->atlas[0] = fogs->atlas[1] = ATLAS_EDGE;
    while ((uint64_t)fogs->atlas[0] * fogs->atlas[1] * (uint64_t)(edge / AL_BRICK_EDGE) < bricks &&
           (fogs->atlas[0] + 1) * AL_BRICK_EDGE <= edge)
        fogs->atlas[0] = ++fogs->atlas[1];
    uint64_t layer = (uint64_t)fogs->atlas[0] * fogs->atlas[1], layers = (bricks + layer - 1) / layer;
    if (layers * AL_BRICK_EDGE > (uint64_t)edge || cells * 4 > (uint64_t)block || cells > INT32_MAX)
        return al_fail(
            error, AL_BAD_INPUT,
            "fogs: %llu bricks in %llu cells are more than this OpenGL's textures and buffers hold",
            (unsigned long long)bricks, (unsigned long long)cells);
    fogs->atlas[2] = (int32_t)layers;
    al_status status = bricks ? make_bricks(runtime, cells, error) : AL_OK;
    fogs->placed = !status;
    return status ? status : al_fog_sky_upload(runtime, error);
}

/* The index of bricks of the frame that comes in, with the atlas's numbers. */
static al_status upload_cells(const al_fogs *fogs, const al_fog_medium *medium, al_error *error)
{
    if (is_constant(&medium->info)) return AL_OK;
    const al_fog_slot *slot = &medium->slots[medium->incoming];
    uint64_t count = cell_count(&medium->info);
    uint32_t *cells = malloc(count * sizeof *cells);
    if (!cells) return al_fail(error, AL_IO, "no memory for the bricks of a fog");
    for (uint64_t i = 0; i < count; i++) {
        uint32_t brick = slot->frame.bricks[i];
        cells[i] = brick == AL_NO_BRICK ? AL_NO_BRICK : brick + slot->first_brick;
    }
    glNamedBufferSubData(fogs->cells.id, (GLintptr)(slot->first_cell * 4), (GLsizeiptr)(count * 4), cells);
    free(cells);
    return AL_OK;
}

static void upload_brick(const al_fogs *fogs, uint32_t number, const uint16_t *values)
{
    int32_t x = (int32_t)number % fogs->atlas[0], y = (int32_t)number / fogs->atlas[0] % fogs->atlas[1],
            z = (int32_t)number / (fogs->atlas[0] * fogs->atlas[1]);
    glTextureSubImage3D(fogs->bricks.id, 0, x * AL_BRICK_EDGE, y * AL_BRICK_EDGE, z * AL_BRICK_EDGE,
                        AL_BRICK_EDGE, AL_BRICK_EDGE, AL_BRICK_EDGE, GL_RED, GL_HALF_FLOAT, values);
}

al_status al_fog_accept(al_runtime *runtime, const al_arrival *arrival, uint64_t *budget, bool *done,
                        al_error *error)
{
    al_fogs *fogs = &runtime->fogs;
    al_fog_medium *medium = &fogs->media[arrival->object];
    *done = true;
    if (arrival->kind == AL_ARRIVAL_MEDIUM) {
        medium->info = arrival->medium;
        medium->times_s = arrival->times_s;
        medium->brick_limit = arrival->brick_limit;
        medium->sky = arrival->sky;
        medium->depth = arrival->depth;
        medium->present = true;
        medium->slots[medium->incoming].depths = arrival->depths;
        al_fog_begin_frame(medium, 0, &arrival->frame);
        runtime->moving.length_s = fmax(runtime->moving.length_s, al_fog_length_s(runtime));
        return AL_OK;
    }
    if (medium->failed) return AL_OK;
    if (arrival->kind == AL_ARRIVAL_FRAME) {
        medium->slots[medium->incoming].depths = arrival->depths;
        al_fog_begin_frame(medium, arrival->frame_index, &arrival->frame);
        return AL_OK;
    }
    al_status status = fogs->placed ? AL_OK : make_atlas(runtime, error);
    al_fog_slot *slot = &medium->slots[medium->incoming];
    if (!status && !slot->loaded) status = upload_cells(fogs, medium, error);
    if (status) {
        medium->failed = true;
        return status;
    }
    uint64_t at = runtime->arrived, count = al_budget_share(budget, BRICK_BYTES, arrival->bricks.count - at);
    for (uint64_t i = at; i < at + count && !is_constant(&medium->info); i++)
        upload_brick(fogs, slot->first_brick + arrival->bricks.first + (uint32_t)i,
                     arrival->bricks.values + i * AL_BRICK_SIZE);
    runtime->arrived += (uint32_t)count;
    al_fog_take_bricks(medium, (uint32_t)count);
    *done = runtime->arrived == arrival->bricks.count;
    return AL_OK;
}

/* --- what a frame draws --- */

static void fill_constant(const al_fog *fog, const al_medium *medium, al_fog_entry *entry)
{
    for (int k = 0; k < 3; k++) {
        entry->low[k] = fog->bounds_min_m[k];
        entry->extent[k] = fog->bounds_max_m[k] - fog->bounds_min_m[k];
        entry->sigma_s[k] = fog->density * medium->sigma_s_per_m[k];
        entry->sigma_t[k] = fog->density * (medium->sigma_s_per_m[k] + medium->sigma_a_per_m[k]);
    }
    entry->low[3] = fog->bounded;
    entry->sigma_t[3] = medium->g;
    entry->sigma_s[3] = 1;
}

/* The texture holds densities in units of their maximum / AL_MEDIUM_UNIT. */
static void fill_grid(const al_fog_medium *medium, float march_voxels, al_fog_entry *entry)
{
    const al_medium_info *info = &medium->info;
    double world[16], inverse[16], voxel = INFINITY;
    float unit = medium->frame.density_max / AL_MEDIUM_UNIT;
    al_matrix_from_float(info->grid_to_world, world);
    al_matrix_inverse(world, inverse);
    al_matrix_to_float(inverse, entry->to_index);
    uint32_t cells[3];
    al_medium_cells(info, cells);
    for (int k = 0; k < 3; k++) {
        double *axis = world + 4 * k;
        voxel = fmin(voxel, sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]));
        entry->low[k] = info->bounds_min_m[k];
        entry->extent[k] = info->bounds_max_m[k] - info->bounds_min_m[k];
        entry->sigma_s[k] = unit * info->sigma_s_per_m[k];
        entry->sigma_t[k] = unit * (info->sigma_s_per_m[k] + info->sigma_a_per_m[k]);
        entry->size[k] = (int32_t)info->size[k];
        entry->cells[k] = (int32_t)cells[k];
    }
    entry->low[3] = 1;
    entry->extent[3] = info->extended;
    entry->sigma_t[3] = info->g;
    entry->sigma_s[3] = AL_MEDIUM_UNIT;
    entry->size[3] = (int32_t)medium->first_cell;
    entry->march[0] = (float)(voxel * 2 * march_voxels); /* 0.5: a voxel, as shadows are marched */
}

void al_fog_prepare(al_draw *draw)
{
    al_runtime *runtime = draw->runtime;
    al_fogs *fogs = &runtime->fogs;
    al_fog_block *block = &fogs->block;
    int32_t count = 0;
    fogs->drawn = false;
    if (!runtime->scene.fog_count || draw->settings.fog_off) return;
    memset(block, 0, sizeof *block);
    for (uint32_t i = 0; i < runtime->scene.fog_count; i++) {
        const al_fog *fog = &runtime->scene.fogs[i];
        const al_fog_medium *medium = &fogs->media[i];
        bool complete = medium->present && !medium->failed && medium->loaded &&
                        medium->loaded == medium->frame.brick_count;
        if (!*fog->asset || (complete && is_constant(&medium->info)))
            fill_constant(fog, &runtime->scene.media[fog->medium], &block->fogs[count]);
        else if (complete)
            fill_grid(medium, draw->settings.march_voxels, &block->fogs[count]);
        else
            continue;
        if (complete) al_fog_sky_fill(runtime, medium, &block->fogs[count]);
        al_fog_move(fog, &block->fogs[count]);
        fogs->shown[count] = i;
        count++;
    }
    fogs->drawn = count > 0;
    if (!count) return;
    block->counts[0] = count;
    block->counts[1] = (int32_t)draw->settings.fog_steps;
    block->counts[2] = (int32_t)runtime->frame_number;
    block->counts[3] = !draw->settings.shadows_off;
    block->atlas[2] = al_fog_sky_exists(runtime);
    block->atlas[3] = fogs->sky_stride;
    for (int k = 0; k < 3 && fogs->bricks.id; k++) {
        if (k < 2) block->atlas[k] = fogs->atlas[k];
        block->texel[k] = 1.0f / (float)(fogs->atlas[k] * AL_BRICK_EDGE);
    }
    glNamedBufferSubData(fogs->constants.id, 0, sizeof *block, block);
    glBindBufferBase(GL_UNIFORM_BUFFER, 2, fogs->constants.id);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 5, fogs->cells.id);
    al_gl_bind_texture(AL_UNIT_FOG, fogs->bricks.id);
}

const char *al_fog_define(const al_draw *draw)
{
    return draw->runtime->fogs.drawn ? "#define AL_FOG\n" : "";
}

static bool shows_fog(const al_draw *draw)
{
    return draw->runtime->fogs.drawn &&
           (draw->settings.pass == AL_PASS_COMPOSITE || draw->settings.pass == AL_PASS_DIRECT_SCATTERING);
}

static al_status run(al_draw *draw, const char *defines, GLuint framebuffer)
{
    al_runtime *runtime = draw->runtime;
    GLuint program;
    al_status status =
        al_shaders_get(runtime->shaders, "fullscreen.vert fog.frag", defines, &program, draw->error);
    if (status) return status;
    al_timing_begin(&runtime->timing, AL_STAGE_FOG);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glViewport(0, 0, draw->tile[2], draw->tile[3]);
    glUseProgram(program);
    al_gl_bind_texture(AL_UNIT_PASS, runtime->targets.geometry.id);
    al_gl_bind_texture(AL_UNIT_PASS + 1, runtime->targets.boundary.id);
    al_gl_bind_texture(AL_UNIT_FOG, runtime->fogs.bricks.id);
    al_fog_sky_bind(runtime);
    glBindVertexArray(runtime->empty_vertex_array);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    al_timing_end(&runtime->timing);
    return AL_OK;
}

al_status al_fog_draw(al_draw *draw)
{
    if (!shows_fog(draw)) return AL_OK;
    glDisable(GL_SCISSOR_TEST);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_SRC1_COLOR);
    al_status status = run(draw, "", draw->runtime->targets.radiance_framebuffer);
    glDisable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ZERO);
    return status;
}

al_status al_fog_draw_front(al_draw *draw)
{
    return shows_fog(draw) ? run(draw, "#define AL_FRONT\n", draw->runtime->targets.fog_framebuffer) : AL_OK;
}
