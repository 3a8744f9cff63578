/* Statistics, answers and pictures of probes. */
#include "airlight/probes.h"

#include <math.h>

#include "canvas.h"
#include "inspect.h"

static const char *const layer_names[AL_LAYER_COUNT] = {"surface", "attenuated", "scattered"};

static void bounds_of(const al_probes *probes, float low[3], float high[3])
{
    for (int k = 0; k < 3; k++) {
        low[k] = INFINITY;
        high[k] = -INFINITY;
        for (uint32_t i = 0; i < probes->info.probe_count; i++) {
            low[k] = fminf(low[k], probes->positions[3 * (size_t)i + k]);
            high[k] = fmaxf(high[k], probes->positions[3 * (size_t)i + k]);
        }
    }
}

/* Mean radiance over all directions: band 0 times sqrt(1/(4 pi)). */
static double mean_radiance(const al_probes *probes, uint32_t probe, int layer, int channel)
{
    size_t set = (size_t)probes->info.order * probes->info.order;
    size_t at = (((size_t)probe * AL_LAYER_COUNT + layer) * 3 + channel) * set;
    return 0.28209479177387814 * (double)probes->coefficients[at];
}

static double all_light(const al_probes *probes, uint32_t probe, int channel)
{
    return mean_radiance(probes, probe, AL_LAYER_ATTENUATED, channel) +
           mean_radiance(probes, probe, AL_LAYER_SCATTERED, channel);
}

/* --- statistics --- */

static json_t *describe_layers(const al_probes *probes)
{
    json_t *layers = json_object();
    for (int layer = 0; layer < AL_LAYER_COUNT; layer++) {
        json_t *mean = json_array();
        for (int c = 0; c < 3; c++) {
            double sum = 0;
            for (uint32_t i = 0; i < probes->info.probe_count; i++) sum += mean_radiance(probes, i, layer, c);
            json_array_append_new(mean, json_number(sum / probes->info.probe_count));
        }
        json_object_set_new(layers, layer_names[layer], json_pack("{s:o}", "mean_w_m2_sr", mean));
    }
    return layers;
}

static al_status summary(const al_file *file, json_t **out, al_error *error)
{
    al_probes probes;
    float low[3], high[3];
    al_status status = al_probes_read(file, &probes, error);
    if (status != AL_OK) return status;
    bounds_of(&probes, low, high);
    json_t *o = json_object();
    json_object_set_new(o, "probes", json_integer(probes.info.probe_count));
    json_object_set_new(o, "tetrahedra", json_integer(probes.info.tetrahedron_count));
    json_object_set_new(o, "order", json_integer(probes.info.order));
    json_object_set_new(o, "bounds_min_m", json_numbers(low, 3));
    json_object_set_new(o, "bounds_max_m", json_numbers(high, 3));
    json_object_set_new(o, "layers", describe_layers(&probes));
    json_object_set_new(o, "provenance", json_provenance(file));
    *out = o;
    return AL_OK;
}

/* --- answers: all light (attenuated + scattered) and each layer, [channel][l(l+1)+m] --- */

static json_t *coefficient_lists(float sh[3][AL_PROBES_MAX_COUNT], size_t count)
{
    json_t *lists = json_array();
    for (int c = 0; c < 3; c++) json_array_append_new(lists, json_numbers(sh[c], count));
    return lists;
}

static al_status evaluate(const al_file *file, const json_t *query, json_t **answer, al_error *error)
{
    static const char *const keys[] = {"position", NULL};
    float position[3], sh[AL_LAYER_COUNT][3][AL_PROBES_MAX_COUNT], all[3][AL_PROBES_MAX_COUNT];
    al_probes probes;
    al_probe_place place = {0};
    al_status status = query_keys(query, keys, error);
    if (status == AL_OK) status = query_vector(query, "position", position, error);
    if (status == AL_OK) status = al_probes_read(file, &probes, error);
    if (status != AL_OK) return status;
    size_t count = (size_t)probes.info.order * probes.info.order;
    al_probes_locate(&probes, position, &place);
    for (int layer = 0; layer < AL_LAYER_COUNT; layer++)
        al_probes_blend(&probes, &place, (al_lightmap_layer)layer, sh[layer]);
    for (int c = 0; c < 3; c++)
        for (size_t i = 0; i < count; i++)
            all[c][i] = sh[AL_LAYER_ATTENUATED][c][i] + sh[AL_LAYER_SCATTERED][c][i];
    json_t *o = json_object(), *names = json_array();
    json_object_set_new(o, "sh", coefficient_lists(all, count));
    for (int layer = 0; layer < AL_LAYER_COUNT; layer++)
        json_object_set_new(o, layer_names[layer], coefficient_lists(sh[layer], count));
    for (int k = 0; k < 4; k++) json_array_append_new(names, json_integer(place.probes[k]));
    json_object_set_new(o, "probes", names);
    json_object_set_new(o, "weights", json_numbers(place.weights, 4));
    *answer = o;
    return AL_OK;
}

/* --- picture: the mesh from the right, from above and from the front; discs of each probe's mean light ---
 */

enum { EDGE = 640 };

static void draw_probes(const al_probes *probes, const panel *p, int across, int up, double middle)
{
    static const float thread[3] = {0.003f, 0.004f, 0.006f};
    for (size_t t = 0; t < probes->info.tetrahedron_count; t++)
        for (int a = 0; a < 4; a++)
            for (int b = 0; b < a; b++) {
                const float *from = probes->positions + 3 * (size_t)probes->tetrahedra[4 * t + a];
                const float *to = probes->positions + 3 * (size_t)probes->tetrahedra[4 * t + b];
                panel_line(p, (double[]){from[across], from[up]}, (double[]){to[across], to[up]}, thread);
            }
    for (uint32_t i = 0; i < probes->info.probe_count; i++) {
        const float *at = probes->positions + 3 * (size_t)i;
        float rgb[3];
        for (int c = 0; c < 3; c++) {
            double light = fmax(all_light(probes, i, c), 0);
            rgb[c] = (float)(light / (light + middle));
        }
        panel_disc(p, (double[]){at[across], at[up]}, 4, rgb);
    }
}

static double mean_of_all(const al_probes *probes)
{
    double sum = 0;
    for (uint32_t i = 0; i < probes->info.probe_count; i++)
        for (int c = 0; c < 3; c++) sum += fmax(all_light(probes, i, c), 0) / 3;
    return sum > 0 ? sum / probes->info.probe_count : 1;
}

static al_status draw(const al_file *file, const char *png_path, al_error *error)
{
    static const int axes[3][2] = {{2, 1}, {0, 2}, {0, 1}};
    al_probes probes;
    float low[3], high[3];
    canvas on = {0};
    al_status status = al_probes_read(file, &probes, error);
    if (status == AL_OK)
        status =
            canvas_create(3 * (EDGE + CANVAS_MARGIN) + CANVAS_MARGIN, EDGE + 2 * CANVAS_MARGIN, &on, error);
    if (status != AL_OK) return status;
    bounds_of(&probes, low, high);
    for (int view = 0; view < 3; view++) {
        int across = axes[view][0], up = axes[view][1];
        panel p = canvas_panel(&on, view, 0, EDGE);
        panel_show(&p, (double[]){low[across], low[up]}, (double[]){high[across], high[up]});
        draw_probes(&probes, &p, across, up, mean_of_all(&probes));
    }
    status = canvas_write(&on, png_path, error);
    canvas_free(&on);
    return status;
}

const inspected_kind inspected_probes = {AL_KIND_PROBES, summary, evaluate, draw};
