#include "bake_probes.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <xxhash.h>

#include "airlight/probes.h"
#include "gather_job.h"
#include "light_key.h"
#include "measure.h"
#include "place_probes.h"
#include "tetrahedra.h"

/* Part of every key: raise it when a step's result changes for the same input. */
static const uint32_t bake_version = 6;

/* A probe that sees more backs of surfaces than this is inside a wall, or on it, where it sees half of them.
 * Outside, backs are seen only where meshes are open. */
static const float inside_share = 0.25f;

enum { MEASURE_STRIDE = 16 };

typedef struct probe_work {
    const al_import *import;
    const al_probe_settings *settings;
    const al_bake_options *options;
    al_steps *steps;
    uint64_t key;
    char path[1200], partial_path[1210];
    al_probe_places places;
    size_t set;     /* floats of a probe: [layer][channel][order^2] */
    uint32_t again; /* probes that are gathered a second time: every MEASURE_STRIDE-th */
    float *results; /* [places.count + again][set + 1]: coefficients, then the share of backs */
    /* of the probes that stay */
    uint32_t kept;
    double *kept_points;
    float *positions, *coefficients;
} probe_work;

void al_bake_probes_file(const al_import *import, char *name, size_t size)
{
    al_scene_asset_file(import, "probes", name, size);
}

al_status al_bake_probes_key(const al_import *import, uint64_t tables_key, uint64_t *key, al_error *error)
{
    const al_probe_settings *s = &import->description->probes;
    const al_lightmap_settings *l = &import->description->lightmap;
    const uint32_t counts[] = {bake_version, s->order,           s->samples, s->point_count,
                               l->bounces,   (uint32_t)l->walls, l->seed,    l->fog_points};
    uint64_t light;
    al_status status = al_light_key(import, &light, error);
    *key = XXH64(counts, sizeof counts, light);
    *key = XXH64(&s->spacing_m, sizeof s->spacing_m, *key);
    *key = XXH64(&tables_key, sizeof tables_key, *key);
    if (s->point_count) *key = XXH64(s->points, s->point_count * sizeof *s->points, *key);
    return status;
}

/* --- gather --- */

/* A probe whose light is not finite counts as one inside a wall. */
static void keep_result(const probe_work *w, const al_gathered *g, float *out)
{
    uint32_t count = w->settings->order * w->settings->order;
    bool finite = true;
    float *at = out;
    for (int layer = 0; layer < AL_GATHER_LAYER_COUNT; layer++)
        for (int channel = 0; channel < 3; channel++)
            for (uint32_t k = 0; k < count; k++) {
                *at = (float)g->sh[layer][channel][k];
                finite = finite && isfinite(*at);
                at++;
            }
    *at = finite ? (float)g->back_share : 1;
}

static bool gather_probe(void *user, const al_gather *gather, al_gather_scratch *scratch, uint32_t index,
                         float *out)
{
    const probe_work *w = user;
    const uint32_t place[] = {w->import->description->lightmap.seed, index};
    uint32_t probe = index < w->places.count ? index : (index - w->places.count) * MEASURE_STRIDE;
    al_gathered gathered;
    if (!al_gather_point(gather, scratch, w->places.points[probe], NULL, 0, XXH64(place, sizeof place, 0),
                         &gathered))
        return false;
    keep_result(w, &gathered, out);
    return true;
}

/* What lamps send straight to a probe is left out: the player adds it, with shadows. */
static al_status gather_probes(probe_work *w, const al_impulse_tables *tables, al_error *error)
{
    const al_lightmap_settings *l = &w->import->description->lightmap;
    const al_gather_job job = {.name = "probes",
                               .partial = w->partial_path,
                               .key = w->key,
                               .gather = {.samples = w->settings->samples,
                                          .bounces = l->bounces,
                                          .fog = w->import->scene.fog_count > 0,
                                          .walls = l->walls,
                                          .fog_points = l->fog_points,
                                          .sh_order = w->settings->order,
                                          .lamps_apart = true,
                                          .seed = l->seed},
                               .piece_count = w->places.count + w->again,
                               .items = w->places.count,
                               .piece_floats = w->set + 1,
                               .fill = gather_probe,
                               .user = w};
    return al_gather_job_run(&job, w->import, tables, w->options, w->steps, &w->results, error);
}

/* --- leave out, join, write --- */

/* Probes inside walls go, and all but the first of those at one place. */
static al_status keep_probes(probe_work *w, al_error *error)
{
    uint32_t count = w->places.count;
    w->kept_points = malloc(count * sizeof(double[3]));
    w->positions = malloc(count * sizeof(float[3]));
    w->coefficients = malloc(count * w->set * sizeof(float));
    if (!w->kept_points || !w->positions || !w->coefficients)
        return al_fail(error, AL_IO, "%s: out of memory for %u probes", w->path, count);
    for (uint32_t i = 0; i < count; i++) {
        const float *result = w->results + i * (w->set + 1);
        if (result[w->set] > inside_share) continue;
        for (int k = 0; k < 3; k++) {
            w->positions[3 * (size_t)w->kept + k] = (float)w->places.points[i][k];
            w->kept_points[3 * (size_t)w->kept + k] = w->positions[3 * (size_t)w->kept + k];
        }
        memcpy(w->coefficients + w->kept * w->set, result, w->set * sizeof(float));
        w->kept++;
    }
    if (!w->kept)
        return al_fail(error, AL_BAD_INPUT,
                       "all %u probes are inside walls: they see the backs of surfaces; points in front of "
                       "them are right, or double-sided materials",
                       count);
    if (w->kept < count)
        al_program_say(w->options->program, "%u of %u probes are inside walls and left out", count - w->kept,
                       count);
    return AL_OK;
}

/* Six times the volume, from positions as they are stored. */
static double volume6(const float *positions, const uint32_t *corners)
{
    const float *a = positions + 3 * (size_t)corners[0];
    double e[3][3];
    for (int n = 0; n < 3; n++)
        for (int i = 0; i < 3; i++) e[n][i] = (double)positions[3 * (size_t)corners[n + 1] + i] - a[i];
    return e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) +
           e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
           e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
}

static double longest_edge(const float *positions, const uint32_t *corners)
{
    double longest = 0;
    for (int a = 0; a < 4; a++)
        for (int b = 0; b < a; b++) {
            double square = 0;
            for (int i = 0; i < 3; i++)
                square += pow(
                    (double)positions[3 * (size_t)corners[a] + i] - positions[3 * (size_t)corners[b] + i], 2);
            longest = fmax(longest, sqrt(square));
        }
    return longest;
}

/* Points at the same height make flat tetrahedra, which hold no point and have no barycentric coordinates. */
static uint32_t drop_flat(const probe_work *w, al_tetrahedra *mesh)
{
    uint32_t count = 0;
    for (uint32_t t = 0; t < mesh->count; t++) {
        const uint32_t *corners = mesh->corners + 4 * (size_t)t;
        if (volume6(w->positions, corners) > 1e-6 * pow(longest_edge(w->positions, corners), 3))
            memmove(mesh->corners + 4 * (size_t)count++, corners, sizeof(uint32_t[4]));
    }
    return count;
}

static bool spans_space(const probe_work *w)
{
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < 3 * (size_t)w->kept; i++) {
        low[i % 3] = fmin(low[i % 3], w->kept_points[i]);
        high[i % 3] = fmax(high[i % 3], w->kept_points[i]);
    }
    return w->kept >= 4 && low[0] < high[0] && low[1] < high[1] && low[2] < high[2];
}

#define COMPARED(layer) \
    "coefficients of layer " layer ", every 16th probe, with a second set of paths, whose own noise is in the figure"

/* Probes inside walls do not count; without fog one layer. */
static uint32_t measure(const probe_work *w, const char *settings, al_measured measured[AL_GATHER_LAYER_COUNT])
{
    static const char *const compared[] = {COMPARED("surface"), COMPARED("attenuated"), COMPARED("scattered")};
    size_t layer_set = w->set / AL_GATHER_LAYER_COUNT;
    uint32_t count = 0;
    for (uint32_t layer = 0; layer < (w->import->scene.fog_count ? AL_GATHER_LAYER_COUNT : 1u); layer++) {
        al_measure sums = {0};
        for (uint32_t i = 0; i < w->again; i++) {
            const float *a = w->results + (size_t)i * MEASURE_STRIDE * (w->set + 1),
                        *b = w->results + ((size_t)w->places.count + i) * (w->set + 1);
            if (a[w->set] > inside_share || b[w->set] > inside_share) continue;
            for (size_t k = layer * layer_set; k < (layer + 1) * layer_set; k++)
                al_measure_add(&sums, (double)a[k] - b[k], b[k]);
        }
        if (sums.count) measured[count++] = al_measure_twice(&sums, compared[layer], settings, "W/(m2 sr)");
    }
    return count;
}

static al_status write_asset(probe_work *w, const al_tetrahedra *mesh, uint32_t tetrahedron_count,
                             al_error *error)
{
    char provenance[256], settings[160];
    al_measured measured[AL_GATHER_LAYER_COUNT];
    double started = al_program_seconds();
    uint64_t bytes;
    snprintf(provenance, sizeof provenance,
             "{\"key\":\"%016llx\",\"samples\":%u,\"bounces\":%u,\"walls\":%d,\"spacing_m\":%.9g}",
             (unsigned long long)w->key, w->settings->samples, w->import->description->lightmap.bounces,
             (int)w->import->description->lightmap.walls, w->places.spacing_m);
    al_probes_data data = {.info = {w->kept, tetrahedron_count, w->settings->order},
                           .positions = w->positions,
                           .tetrahedra = mesh->corners,
                           .coefficients = w->coefficients,
                           .provenance_json = provenance};
    snprintf(settings, sizeof settings, "%u paths a probe, %u bounces, order %u", w->settings->samples,
             w->import->description->lightmap.bounces, w->settings->order);
    data.measured_count = measure(w, settings, measured);
    data.measured = measured;
    al_status status = al_probes_write(w->path, &data, &bytes, error);
    if (status == AL_OK) al_steps_add(w->steps, "write probes", started, bytes, w->kept);
    return status;
}

/* Points that TetGen finds to lie in one plane stay without a mesh: the nearest probe answers. */
static al_status join_and_write(probe_work *w, al_error *error)
{
    double started = al_program_seconds();
    al_tetrahedra mesh = {0};
    uint32_t count = 0;
    al_status status = AL_OK;
    if (spans_space(w)) {
        al_triangles points = {.vertex_count = w->kept, .positions = w->kept_points};
        status = al_tetrahedralise("probes", &points, &mesh, error);
        if (status == AL_BAD_INPUT) status = AL_OK;
        if (status == AL_OK) count = drop_flat(w, &mesh);
        al_steps_add(w->steps, "tetrahedra of probes", started, 0, count);
    }
    if (status == AL_OK) status = write_asset(w, &mesh, count, error);
    al_tetrahedra_free(&mesh);
    return status;
}

al_status al_bake_probes(const al_import *import, uint64_t key, const al_impulse_tables *tables,
                         const al_bake_options *options, al_steps *steps, al_error *error)
{
    probe_work *w = calloc(1, sizeof *w);
    if (!w) return al_fail(error, AL_IO, "out of memory");
    w->import = import;
    w->settings = &import->description->probes;
    w->options = options;
    w->steps = steps;
    w->key = key;
    w->set = (size_t)AL_GATHER_LAYER_COUNT * 3 * w->settings->order * w->settings->order;
    snprintf(w->path, sizeof w->path, "%s/%s", options->folder, import->scene.baked.probes);
    snprintf(w->partial_path, sizeof w->partial_path, "%s.partial", w->path);
    al_status status = al_probe_places_make(import, &w->places, error);
    w->again = (w->places.count + MEASURE_STRIDE - 1) / MEASURE_STRIDE;
    if (status == AL_OK) status = gather_probes(w, tables, error);
    if (status == AL_OK) status = keep_probes(w, error);
    if (status == AL_OK) status = join_and_write(w, error);
    if (status == AL_OK) unlink(w->partial_path);

    al_probe_places_free(&w->places);
    free(w->results);
    free(w->kept_points);
    free(w->positions);
    free(w->coefficients);
    free(w);
    return status;
}
