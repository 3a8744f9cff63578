#include "bake_lightmap.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <xxhash.h>

#include "airlight/image.h"
#include "airlight/lightmap.h"
#include "gather_job.h"
#include "geometry.h"
#include "light_key.h"
#include "light_page.h"
#include "measure.h"
#include "texels.h"

/* Part of every key: raise it when a step's result changes for the same input. */
static const uint32_t bake_version = 6;

enum {
    TILE_TEXELS = 64,
    IRRADIANCE_CHANNELS = 3 * AL_LAYER_COUNT /* layer by layer, R G B; then SH: layer, coefficient, R G B */
};

/* A texel is taken to lie behind a surface when most of its first rays meet backs: in a solid all do, in
 * front of one none, and the few in between are those whose point lies on the border. */
#define BEHIND_SHARE 0.5f

typedef struct lightmap_work {
    const al_import *import;
    const al_lightmap_settings *settings;
    const al_atlas *atlas;
    const al_bake_options *options;
    al_steps *steps;
    uint64_t key;
    char path[1200], partial_path[1210];
    al_texels texels;
    uint32_t channel_count;
    /* [tile][TILE_TEXELS + 1][channel_count + 1]: light, then the share of backs; the last of a tile is its
     * first texel once more, by other paths */
    float *results;
    al_light_page *pages; /* [page_count] */
    al_seams *seams;      /* [page_count] */
    uint32_t replaced, fixed;
} lightmap_work;

void al_bake_lightmap_file(const al_import *import, char *name, size_t size)
{
    al_scene_asset_file(import, "lightmap", name, size);
}

void al_bake_lightmap_page_file(uint32_t page, char *name, size_t size)
{
    snprintf(name, size, "lightmap_%u.exr", page);
}

al_status al_bake_lightmap_key(const al_import *import, uint64_t tables_key, uint64_t *key, al_error *error)
{
    const al_lightmap_settings *s = &import->description->lightmap;
    const uint32_t counts[] = {bake_version,       s->texels_across, s->samples,      s->bounces,
                               (uint32_t)s->walls, s->back_scatter,  (uint32_t)s->uv, s->directional_order,
                               s->padding_texels,  s->page_size,     s->seed,         s->fog_points};
    const double lengths[] = {s->texel_m, s->back_scatter_shift_m};
    uint64_t light;
    al_status status = al_light_key(import, &light, error);
    *key = XXH64(counts, sizeof counts, light);
    *key = XXH64(lengths, sizeof lengths, *key);
    *key = XXH64(&tables_key, sizeof tables_key, *key);
    return status;
}

/* --- lights that could light nothing --- */

static double area_m2(const al_mesh *mesh, const al_submesh *part, const double world[16])
{
    double sum = 0;
    for (uint32_t i = part->first_index; i < part->first_index + part->index_count; i += 3) {
        double p[3][3], square = 0;
        for (uint32_t k = 0; k < 3; k++) {
            const float *from = mesh->positions + 3 * (size_t)mesh->indices[i + k];
            al_matrix_point(world, (double[3]){from[0], from[1], from[2]}, p[k]);
        }
        for (int k = 0; k < 3; k++) {
            int a = (k + 1) % 3, b = (k + 2) % 3;
            double n = (p[1][a] - p[0][a]) * (p[2][b] - p[0][b]) - (p[1][b] - p[0][b]) * (p[2][a] - p[0][a]);
            square += n * n;
        }
        sum += sqrt(square) / 2;
    }
    return sum;
}

static bool emits(const al_material *material)
{
    const float *e = material->emission_w_m2_sr;
    return e[0] > 0 || e[1] > 0 || e[2] > 0;
}

static al_status check_emitters(const al_scene *scene, al_error *error)
{
    for (uint32_t i = 0; i < scene->instance_count; i++) {
        const al_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        double world[16];
        for (int k = 0; k < 16; k++) world[k] = scene->instances[i].world[k];
        for (uint32_t k = 0; k < mesh->submesh_count; k++) {
            const al_submesh *part = &mesh->submeshes[k];
            if (part->index_count && emits(&scene->materials[part->material]) &&
                !(area_m2(mesh, part, world) > 0))
                return al_fail(
                    error, AL_BAD_INPUT,
                    "mesh \"%s\" has no area and cannot emit as its material \"%s\" says; triangles with an "
                    "area or no emission are right",
                    mesh->name, scene->materials[part->material].name);
        }
    }
    return AL_OK;
}

/* Every ray from a point light that meets only backs is a light shut into a solid, or behind a wall. */
static al_status check_places(void *user, const al_gather *gather, al_gather_scratch *scratch,
                              al_error *error)
{
    lightmap_work *w = user;
    const al_scene *scene = &w->import->scene;
    for (uint32_t i = 0; i < scene->light_count; i++) {
        const al_light *light = &scene->lights[i];
        const double position[] = {light->vector[0], light->vector[1], light->vector[2]};
        al_gathered around;
        if (light->type != AL_LIGHT_POINT) continue;
        if (!al_gather_point(gather, scratch, position, NULL, 0, w->settings->seed, &around))
            return al_fail(error, AL_IO, "%s: out of memory", w->path);
        if (around.back_share > 0.999)
            return al_fail(
                error, AL_BAD_INPUT,
                "light \"%s\" at (%g, %g, %g) stands inside walls: all it sees are the backs of surfaces; "
                "a place in front of them is right, or a double-sided material",
                light->name, position[0], position[1], position[2]);
    }
    return AL_OK;
}

/* --- gathering --- */

static float finite_or_zero(double value)
{
    return isfinite(value) ? (float)value : 0;
}

/* Light, then the share of backs; a texel whose light is not finite counts as behind a surface. */
static void keep(const lightmap_work *w, const al_gathered *g, float *out)
{
    const double *layers[] = {g->surface, g->attenuated, g->scattered};
    uint32_t coefficients = w->settings->directional_order * w->settings->directional_order;
    bool finite = true;
    for (int layer = 0; layer < AL_LAYER_COUNT; layer++)
        for (int c = 0; c < 3; c++) {
            finite = finite && isfinite(layers[layer][c]);
            *out++ = fmaxf(finite_or_zero(layers[layer][c]), 0);
        }
    for (int layer = 0; layer < AL_LAYER_COUNT; layer++)
        for (uint32_t k = 0; k < coefficients; k++)
            for (int c = 0; c < 3; c++) *out++ = finite_or_zero(g->sh[layer][c][k]);
    *out = finite ? (float)g->back_share : 1;
}

static uint32_t tile_count(const lightmap_work *w)
{
    return (w->texels.count + TILE_TEXELS - 1) / TILE_TEXELS;
}

static size_t tile_floats(const lightmap_work *w)
{
    return (size_t)(TILE_TEXELS + 1) * (w->channel_count + 1);
}

static const float *result_of(const lightmap_work *w, uint32_t tile, uint32_t texel)
{
    return w->results + tile * tile_floats(w) + texel * (size_t)(w->channel_count + 1);
}

/* `paths` tells one set of paths from another. */
static bool bake_texel(const lightmap_work *w, const al_gather *gather, al_gather_scratch *scratch,
                       const al_texel *t, uint32_t paths, float *out)
{
    const uint32_t place[] = {w->settings->seed, t->page, t->cell, paths};
    const double normal[3] = {t->normal[0], t->normal[1], t->normal[2]};
    al_gathered gathered;
    if (al_program_cancelled() || !al_gather_point(gather, scratch, t->position, normal, t->edge_m,
                                                   XXH64(place, sizeof place, 0), &gathered))
        return false;
    keep(w, &gathered, out);
    return true;
}

static bool bake_tile(void *user, const al_gather *gather, al_gather_scratch *scratch, uint32_t tile,
                      float *out)
{
    const lightmap_work *w = user;
    const al_texel *texels = w->texels.texels + (size_t)tile * TILE_TEXELS;
    size_t stride = w->channel_count + 1;
    for (uint32_t i = 0; i < TILE_TEXELS && tile * TILE_TEXELS + i < w->texels.count; i++)
        if (!bake_texel(w, gather, scratch, &texels[i], 0, out + i * stride)) return false;
    return bake_texel(w, gather, scratch, &texels[0], 1, out + TILE_TEXELS * stride);
}

static al_status gather_texels(lightmap_work *w, const al_impulse_tables *tables, al_error *error)
{
    const al_lightmap_settings *s = w->settings;
    const al_gather_job job = {.name = "lightmap",
                               .partial = w->partial_path,
                               .key = w->key,
                               .gather = {.samples = s->samples,
                                          .bounces = s->bounces,
                                          .fog = w->import->scene.fog_count > 0,
                                          .walls = s->walls,
                                          .fog_points = s->fog_points,
                                          .back_scatter = s->back_scatter,
                                          .back_scatter_shift_m = s->back_scatter_shift_m,
                                          .sh_order = s->directional_order,
                                          .seed = s->seed},
                               .piece_count = tile_count(w),
                               .items = w->texels.count,
                               .piece_floats = tile_floats(w),
                               .check = check_places,
                               .fill = bake_tile,
                               .user = w};
    return al_gather_job_run(&job, w->import, tables, w->options, w->steps, &w->results, error);
}

/* --- pages --- */

static al_status fill_pages(lightmap_work *w, al_error *error)
{
    uint32_t pages = w->atlas->page_count, i = 0;
    w->pages = calloc(pages + (size_t)1, sizeof *w->pages);
    w->seams = calloc(pages + (size_t)1, sizeof *w->seams);
    if (!w->pages || !w->seams)
        return al_fail(error, AL_IO, "%s: out of memory for %u pages", w->path, pages);
    for (uint32_t p = 0; p < pages; p++) {
        al_light_page *page = &w->pages[p];
        al_status status =
            al_light_page_make(w->atlas->pages[p][0], w->atlas->pages[p][1], w->channel_count, page, error);
        if (status != AL_OK) return status;
        for (; i < w->texels.count && w->texels.texels[i].page == p; i++) {
            const al_texel *t = &w->texels.texels[i];
            const float *result = result_of(w, i / TILE_TEXELS, i % TILE_TEXELS);
            bool behind = result[w->channel_count] > BEHIND_SHARE;
            memcpy(page->light + (size_t)t->cell * w->channel_count, result,
                   w->channel_count * sizeof(float));
            page->state[t->cell] = behind ? AL_TEXEL_REPLACED : AL_TEXEL_BAKED;
            page->chart[t->cell] = t->chart;
        }
    }
    return AL_OK;
}

static al_status finish_pages(lightmap_work *w, al_error *error)
{
    double started = al_program_seconds();
    al_status status = fill_pages(w, error);
    for (uint32_t p = 0; status == AL_OK && p < w->atlas->page_count; p++) {
        uint32_t replaced;
        status = al_light_page_replace(&w->pages[p], &replaced, error);
        if (status == AL_OK) status = al_light_page_dilate(&w->pages[p], w->settings->padding_texels, error);
        w->replaced += replaced;
    }
    al_steps_add(w->steps, "texels behind surfaces, padding", started, 0, w->replaced);
    started = al_program_seconds();
    uint64_t places = 0;
    for (uint32_t p = 0; status == AL_OK && p < w->atlas->page_count; p++) {
        status = al_light_page_stitch(&w->import->scene, w->atlas, p, IRRADIANCE_CHANNELS, &w->pages[p],
                                      &w->seams[p], error);
        places += w->seams[p].places;
    }
    al_steps_add(w->steps, "seams", started, 0, places);
    return status;
}

/* --- the asset --- */

#define COMPARED(layer) \
    "irradiance of layer " layer ", a texel of each tile, with a second set of paths, whose own noise is in the figure"

static void copy_layer(const al_light_page *page, uint32_t first, uint32_t count, float *out)
{
    size_t texels = (size_t)page->width * page->height;
    for (size_t i = 0; i < texels; i++)
        for (uint32_t k = 0; k < count; k++)
            memcpy(out + (k * texels + i) * 3, page->light + i * page->channel_count + first + 3 * (size_t)k,
                   3 * sizeof *out);
}

/* Texel by texel becomes plane by plane. */
static al_status make_source(const lightmap_work *w, const al_light_page *page, float **planes,
                             al_lightmap_source *source, al_error *error)
{
    size_t texels = (size_t)page->width * page->height;
    uint32_t coefficients = w->settings->directional_order * w->settings->directional_order;
    *planes = malloc((texels * page->channel_count + 1) * sizeof(float));
    if (!*planes) return al_fail(error, AL_IO, "%s: out of memory for a page", w->path);
    float *sh = *planes + texels * IRRADIANCE_CHANNELS;
    for (uint32_t layer = 0; layer < AL_LAYER_COUNT; layer++) {
        copy_layer(page, 3 * layer, 1, *planes + 3 * texels * layer);
        copy_layer(page, IRRADIANCE_CHANNELS + 3 * coefficients * layer, coefficients,
                   sh + 3 * texels * coefficients * layer);
    }
    *source = (al_lightmap_source){page->width, page->height, *planes, coefficients ? sh : NULL, page->state};
    return AL_OK;
}

typedef struct asset { /* what al_lightmap_write takes */
    al_lightmap_data data;
    al_lightmap_instance *instances;
    al_lightmap_source *sources;
    float **planes;
    float *vertices;
    uint32_t *triangles;
    char *provenance;
} asset;

static void free_asset(asset *a, uint32_t pages)
{
    for (uint32_t p = 0; a->planes && p < pages; p++) free(a->planes[p]);
    free(a->instances);
    free(a->sources);
    free(a->planes);
    free(a->vertices);
    free(a->triangles);
    free(a->provenance);
}

static void describe_instance(const lightmap_work *w, uint32_t index, asset *a)
{
    const al_atlas_instance *from = &w->atlas->instances[index];
    const al_instance *instance = &w->import->scene.instances[from->instance];
    const al_mesh *mesh = &w->import->scene.meshes[instance->mesh];
    const uint32_t *page = w->atlas->pages[from->page];
    al_lightmap_info *info = &a->data.info;
    al_lightmap_instance *to = &a->instances[index];
    double world[16], at[2];
    for (int i = 0; i < 16; i++) world[i] = instance->world[i];
    *to = (al_lightmap_instance){
        .instance = from->instance,
        .page = from->page,
        .scale = {(float)from->width / (float)page[0], (float)from->height / (float)page[1]},
        .offset = {(float)from->x / (float)page[0], (float)from->y / (float)page[1]},
        .first_triangle = info->triangle_count,
        .triangle_count = mesh->index_count / 3};
    for (uint32_t i = 0; i < mesh->index_count; i++)
        a->triangles[3 * (size_t)info->triangle_count + i] = info->vertex_count + mesh->indices[i];
    for (uint32_t v = 0; v < mesh->vertex_count; v++) {
        float *out = a->vertices + 5 * (size_t)(info->vertex_count + v);
        const float *p = mesh->positions + 3 * (size_t)v;
        double point[3];
        al_matrix_point(world, (double[3]){p[0], p[1], p[2]}, point);
        al_texels_corner(mesh, from, v, at);
        for (int k = 0; k < 3; k++) out[k] = (float)point[k];
        for (int k = 0; k < 2; k++) out[3 + k] = (float)fmin(fmax(at[k] / page[k], 0), 1);
    }
    info->vertex_count += mesh->vertex_count;
    info->triangle_count += mesh->index_count / 3;
}

static bool describe_geometry(const lightmap_work *w, asset *a)
{
    size_t vertices = 0, corners = 0;
    for (uint32_t i = 0; i < w->atlas->instance_count; i++) {
        const al_instance *instance = &w->import->scene.instances[w->atlas->instances[i].instance];
        vertices += w->import->scene.meshes[instance->mesh].vertex_count;
        corners += w->import->scene.meshes[instance->mesh].index_count;
    }
    a->instances = calloc(w->atlas->instance_count + (size_t)1, sizeof *a->instances);
    a->vertices = malloc((vertices * 5 + 1) * sizeof *a->vertices);
    a->triangles = malloc((corners + 1) * sizeof *a->triangles);
    if (!a->instances || !a->vertices || !a->triangles) return false;
    for (uint32_t i = 0; i < w->atlas->instance_count; i++) describe_instance(w, i, a);
    return true;
}

/* What a texel of each tile holds, before its seams are stitched, with the same along other paths; without fog one layer. */
static uint32_t measure(const lightmap_work *w, const char *settings, al_measured measured[AL_LAYER_COUNT])
{
    static const char *const compared[] = {COMPARED("surface"), COMPARED("attenuated"), COMPARED("scattered")};
    uint32_t count = 0;
    for (int layer = 0; layer < (w->import->scene.fog_count ? AL_LAYER_COUNT : 1); layer++) {
        al_measure sums = {0};
        for (uint32_t tile = 0; tile < tile_count(w); tile++) {
            const float *a = result_of(w, tile, 0), *b = result_of(w, tile, TILE_TEXELS);
            for (int c = 3 * layer; c < 3 * layer + 3 && a[w->channel_count] <= BEHIND_SHARE; c++)
                al_measure_add(&sums, (double)a[c] - b[c], b[c]);
        }
        if (sums.count) measured[count++] = al_measure_twice(&sums, compared[layer], settings, "W/m2");
    }
    return count;
}

/* The standard error of a texel of a layer over the root mean square of the light: of two independent values
 * a and b of a texel, (a - b)^2 / 2 estimates the variance. */
static double noise_of(const lightmap_work *w, int layer)
{
    double variance = 0, light = 0;
    for (uint32_t tile = 0; tile < tile_count(w); tile++) {
        const float *a = result_of(w, tile, 0), *b = result_of(w, tile, TILE_TEXELS);
        if (a[w->channel_count] > BEHIND_SHARE) continue;
        for (int c = 3 * layer; c < 3 * layer + 3; c++) {
            variance += ((double)a[c] - b[c]) * ((double)a[c] - b[c]) / 2;
            light += ((double)a[c] + b[c]) * ((double)a[c] + b[c]) / 4;
        }
    }
    return light > 0 ? sqrt(variance / light) : 0;
}

static char *provenance(const lightmap_work *w)
{
    static const char *const walls[] = {"published", "bounded", "traced"};
    const al_lightmap_settings *s = w->settings;
    double before = 0, after = 0, places = 0;
    char key[17];
    for (uint32_t p = 0; p < w->atlas->page_count; p++) {
        before += w->seams[p].places * w->seams[p].jump_before * w->seams[p].jump_before;
        after += w->seams[p].places * w->seams[p].jump_after * w->seams[p].jump_after;
        places += w->seams[p].places;
    }
    snprintf(key, sizeof key, "%016llx", (unsigned long long)w->key);
    json_t *root = json_pack(
        "{s:s, s:{s:f, s:i, s:i, s:s, s:i, s:b, s:f, s:i, s:i, s:I}, s:i, s:i, s:{s:f, s:f, s:f}, s:{s:I, "
        "s:f, "
        "s:f}}",
        "key", key, "settings", "texel_m", w->atlas->texel_m, "samples", (int)s->samples, "bounces",
        (int)s->bounces, "walls", walls[s->walls], "fog_points", (int)s->fog_points, "back_scatter",
        (int)s->back_scatter, "back_scatter_shift_m", s->back_scatter_shift_m, "directional_order",
        (int)s->directional_order, "padding_texels", (int)s->padding_texels, "seed", (json_int_t)s->seed,
        "own_uv_meshes", (int)w->atlas->own_count, "coarse_meshes", (int)w->atlas->coarse_count, "noise",
        "surface", noise_of(w, AL_LAYER_SURFACE), "attenuated", noise_of(w, AL_LAYER_ATTENUATED), "scattered",
        noise_of(w, AL_LAYER_SCATTERED), "seams", "places", (json_int_t)places, "jump_before",
        places > 0 ? sqrt(before / places) : 0.0, "jump_after", places > 0 ? sqrt(after / places) : 0.0);
    char *text = root ? json_dumps(root, JSON_COMPACT | JSON_REAL_PRECISION(6)) : NULL;
    json_decref(root);
    return text;
}

static al_status write_asset(lightmap_work *w, al_error *error)
{
    double started = al_program_seconds();
    uint32_t pages = w->atlas->page_count;
    uint64_t bytes = 0;
    char settings[160];
    al_measured measured[AL_LAYER_COUNT];
    asset a = {.data.info = {.page_count = pages,
                             .instance_count = w->atlas->instance_count,
                             .format = AL_LIGHTMAP_HALF,
                             .directional_order = w->settings->directional_order,
                             .texel_m = (float)w->atlas->texel_m},
               .sources = calloc(pages + (size_t)1, sizeof *a.sources),
               .planes = calloc(pages + (size_t)1, sizeof *a.planes),
               .provenance = provenance(w)};
    al_status status = AL_OK;
    if (!a.sources || !a.planes || !a.provenance || !describe_geometry(w, &a))
        status = al_fail(error, AL_IO, "%s: out of memory", w->path);
    for (uint32_t p = 0; status == AL_OK && p < pages; p++)
        status = make_source(w, &w->pages[p], &a.planes[p], &a.sources[p], error);
    a.data.instances = a.instances;
    a.data.pages = a.sources;
    a.data.vertices = a.vertices;
    a.data.triangles = a.triangles;
    a.data.provenance_json = a.provenance;
    snprintf(settings, sizeof settings, "%u paths a texel, %u bounces, texels of %.3g m", w->settings->samples,
             w->settings->bounces, w->atlas->texel_m);
    a.data.measured_count = measure(w, settings, measured);
    a.data.measured = measured;
    if (status == AL_OK) status = al_lightmap_write(w->path, &a.data, &bytes, error);
    al_steps_add(w->steps, "write", started, bytes, pages);
    free_asset(&a, pages);
    return status;
}

/* --- all of it --- */

static al_status run_steps(lightmap_work *w, const al_impulse_tables *tables, al_error *error)
{
    al_status status = check_emitters(&w->import->scene, error);
    if (status == AL_OK) status = al_texels_make(&w->import->scene, w->atlas, &w->texels, error);
    if (status == AL_OK) status = gather_texels(w, tables, error);
    if (status == AL_OK) status = finish_pages(w, error);
    return status == AL_OK ? write_asset(w, error) : status;
}

al_status al_bake_lightmap(const al_import *import, const al_atlas *atlas, uint64_t key,
                           const al_impulse_tables *tables, const al_bake_options *options, al_steps *steps,
                           al_error *error)
{
    lightmap_work *w = calloc(1, sizeof *w);
    char file[160];
    if (!w) return al_fail(error, AL_IO, "out of memory");
    w->import = import;
    w->settings = &import->description->lightmap;
    w->atlas = atlas;
    w->options = options;
    w->steps = steps;
    w->key = key;
    w->channel_count =
        IRRADIANCE_CHANNELS * (1 + w->settings->directional_order * w->settings->directional_order);
    al_bake_lightmap_file(import, file, sizeof file);
    snprintf(w->path, sizeof w->path, "%s/%s", options->folder, file);
    snprintf(w->partial_path, sizeof w->partial_path, "%s.partial", w->path);
    al_status status = run_steps(w, tables, error);
    if (status == AL_OK) unlink(w->partial_path);

    for (uint32_t p = 0; w->pages && p < atlas->page_count; p++) al_light_page_free(&w->pages[p]);
    al_texels_free(&w->texels);
    free(w->results);
    free(w->pages);
    free(w->seams);
    free(w);
    return status;
}

/* --- pictures --- */

al_status al_bake_lightmap_page(const al_file *file, const al_lightmap_info *info, uint32_t index,
                                const char *path, al_error *error)
{
    static const char *const names[] = {"surface.R",    "surface.G",    "surface.B",
                                        "attenuated.R", "attenuated.G", "attenuated.B",
                                        "scattered.R",  "scattered.G",  "scattered.B"};
    al_lightmap_page page;
    al_status status = al_lightmap_read_page(file, info, index, &page, error);
    if (status != AL_OK) return status;
    size_t texels = (size_t)page.width * page.height;
    float *pixels = malloc(texels * IRRADIANCE_CHANNELS * sizeof *pixels), *out = pixels;
    if (!pixels) return al_fail(error, AL_IO, "%s: out of memory for a page", path);
    for (size_t i = 0; i < texels; i++)
        for (int layer = 0; layer < AL_LAYER_COUNT; layer++, out += 3)
            al_lightmap_texel(info, &page, (al_lightmap_layer)layer, i, out);
    const al_image_channels image = {page.width, page.height, IRRADIANCE_CHANNELS, names, pixels};
    status = al_image_write_exr_channels(path, &image, error);
    free(pixels);
    return status;
}
