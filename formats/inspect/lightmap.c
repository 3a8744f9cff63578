/* Statistics, answers and pictures of lightmaps. */
#include "airlight/lightmap.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "canvas.h"
#include "inspect.h"

static const char *const layer_names[AL_LAYER_COUNT] = {"surface", "attenuated", "scattered"};

/* --- statistics --- */

typedef struct statistics {
    double mean[AL_LAYER_COUNT][3], largest[AL_LAYER_COUNT]; /* over baked and replaced texels */
    uint64_t texels[4];                                      /* by al_texel_state */
} statistics;

static void gather_page(const al_lightmap_info *info, const al_lightmap_page *page, statistics *s)
{
    for (size_t i = 0; i < (size_t)page->width * page->height; i++) {
        s->texels[page->state[i]]++;
        if (page->state[i] < AL_TEXEL_REPLACED) continue;
        for (int layer = 0; layer < AL_LAYER_COUNT; layer++) {
            float value[3];
            al_lightmap_texel(info, page, (al_lightmap_layer)layer, i, value);
            for (int c = 0; c < 3; c++) {
                s->mean[layer][c] += value[c];
                s->largest[layer] = fmax(s->largest[layer], value[c]);
            }
        }
    }
}

static json_t *describe_layers(const statistics *s)
{
    json_t *layers = json_object();
    double count = (double)(s->texels[AL_TEXEL_REPLACED] + s->texels[AL_TEXEL_BAKED]);
    for (int layer = 0; layer < AL_LAYER_COUNT; layer++) {
        json_t *mean = json_array();
        for (int c = 0; c < 3; c++) json_array_append_new(mean, json_number(s->mean[layer][c] / count));
        json_object_set_new(
            layers, layer_names[layer],
            json_pack("{s:o,s:o}", "mean_w_m2", mean, "largest_w_m2", json_number(s->largest[layer])));
    }
    return layers;
}

static al_status describe_pages(const al_file *file, const al_lightmap_info *info, json_t *pages,
                                statistics *s, al_error *error)
{
    al_lightmap_page page;
    for (uint32_t i = 0; i < info->page_count; i++) {
        al_status status = al_lightmap_read_page(file, info, i, &page, error);
        if (status != AL_OK) return status;
        json_array_append_new(pages, json_pack("[i,i]", (int)page.width, (int)page.height));
        gather_page(info, &page, s);
    }
    return AL_OK;
}

static al_status summary(const al_file *file, json_t **out, al_error *error)
{
    al_lightmap_info info;
    statistics s = {0};
    json_t *pages = json_array();
    al_status status = al_lightmap_read(file, &info, error);
    if (status == AL_OK) status = describe_pages(file, &info, pages, &s, error);
    if (status != AL_OK) {
        json_decref(pages);
        return status;
    }
    json_t *o = json_object();
    json_object_set_new(o, "pages", pages);
    json_object_set_new(o, "instances", json_integer(info.instance_count));
    json_object_set_new(o, "format", json_string(info.format == AL_LIGHTMAP_FLOAT ? "float" : "half"));
    json_object_set_new(o, "directional_order", json_integer(info.directional_order));
    json_object_set_new(o, "texel_m", json_number(info.texel_m));
    json_object_set_new(o, "triangles", json_integer(info.triangle_count));
    json_object_set_new(o, "texels_baked", json_integer((json_int_t)s.texels[AL_TEXEL_BAKED]));
    json_object_set_new(o, "texels_replaced", json_integer((json_int_t)s.texels[AL_TEXEL_REPLACED]));
    json_object_set_new(o, "texels_dilated", json_integer((json_int_t)s.texels[AL_TEXEL_DILATED]));
    json_object_set_new(o, "texels_empty", json_integer((json_int_t)s.texels[AL_TEXEL_EMPTY]));
    json_object_set_new(o, "layers", describe_layers(&s));
    json_object_set_new(o, "provenance", json_provenance(file));
    *out = o;
    return AL_OK;
}

/* --- answers --- */

static al_status evaluate(const al_file *file, const json_t *query, json_t **answer, al_error *error)
{
    static const char *const keys[] = {"position", "normal", NULL};
    float position[3], normal[3];
    al_lightmap_info info;
    al_lightmap_answer a;
    al_status status = query_keys(query, keys, error);
    if (status == AL_OK) status = query_vector(query, "position", position, error);
    if (status == AL_OK) status = query_vector(query, "normal", normal, error);
    if (status == AL_OK) status = al_lightmap_read(file, &info, error);
    if (status == AL_OK) status = al_lightmap_evaluate(file, &info, position, normal, &a, error);
    if (status != AL_OK) return status;
    json_t *o = json_object();
    for (int layer = 0; layer < AL_LAYER_COUNT; layer++)
        json_object_set_new(o, layer_names[layer], json_numbers(a.irradiance[layer], 3));
    json_object_set_new(o, "distance_m", json_number(a.distance_m));
    json_object_set_new(o, "instance", json_integer(a.instance));
    *answer = o;
    return AL_OK;
}

/* --- picture: a column for each page, a row for each layer, then the states. Each layer is shown as
 * E / (E + its page's mean), so that nothing is cut off --- */

enum { EDGE_LIMIT = 1024, STATE_ROW = AL_LAYER_COUNT, ROWS = STATE_ROW + 1 };

static double mean_of(const al_lightmap_info *info, const al_lightmap_page *page, int layer)
{
    double sum = 0, count = 0;
    for (size_t i = 0; i < (size_t)page->width * page->height; i++) {
        if (page->state[i] < AL_TEXEL_REPLACED) continue;
        float value[3];
        al_lightmap_texel(info, page, (al_lightmap_layer)layer, i, value);
        sum += ((double)value[0] + value[1] + value[2]) / 3;
        count++;
    }
    return sum > 0 ? sum / count : 1;
}

static void draw_row(const al_lightmap_info *info, const al_lightmap_page *page, int row, const panel *p)
{
    static const float states[4][3] = {
        {0, 0, 0}, {0.02f, 0.05f, 0.2f}, {0.8f, 0.1f, 0.05f}, {0.3f, 0.5f, 0.3f}};
    uint32_t longest = page->width > page->height ? page->width : page->height;
    double mean = row < STATE_ROW ? mean_of(info, page, row) : 0;
    for (int y = 0; y < p->edge; y++)
        for (int x = 0; x < p->edge; x++) {
            uint32_t column = (uint32_t)((x + 0.5) * longest / p->edge),
                     line = (uint32_t)((y + 0.5) * longest / p->edge);
            float rgb[3];
            if (column >= page->width || line >= page->height) continue;
            size_t texel = (size_t)line * page->width + column;
            if (row < STATE_ROW) {
                al_lightmap_texel(info, page, (al_lightmap_layer)row, texel, rgb);
                for (int c = 0; c < 3; c++) rgb[c] = (float)(rgb[c] / (rgb[c] + mean));
            }
            panel_set(p, x, y, row < STATE_ROW ? rgb : states[page->state[texel]]);
        }
}

static int panel_edge(const al_lightmap_info *info)
{
    int fitting = (int)(16384 / (info->page_count ? info->page_count : 1));
    return fitting < 16 ? 16 : fitting > EDGE_LIMIT ? EDGE_LIMIT : fitting;
}

static al_status draw(const al_file *file, const char *png_path, al_error *error)
{
    al_lightmap_info info;
    al_lightmap_page page;
    canvas on = {0};
    al_status status = al_lightmap_read(file, &info, error);
    int edge = panel_edge(&info);
    if (status == AL_OK && info.page_count > 1000)
        status = al_fail(error, AL_BAD_INPUT, "%s: %u pages are too many for one picture, 1000 fit",
                         al_file_name(file), info.page_count);
    if (status == AL_OK)
        status = canvas_create((int)info.page_count * (edge + CANVAS_MARGIN) + CANVAS_MARGIN,
                               ROWS * (edge + CANVAS_MARGIN) + CANVAS_MARGIN, &on, error);
    for (uint32_t i = 0; status == AL_OK && i < info.page_count; i++) {
        status = al_lightmap_read_page(file, &info, i, &page, error);
        for (int row = 0; status == AL_OK && row < ROWS; row++) {
            panel p = canvas_panel(&on, (int)i, row, edge);
            draw_row(&info, &page, row, &p);
        }
    }
    if (status == AL_OK) status = canvas_write(&on, png_path, error);
    canvas_free(&on);
    return status;
}

const inspected_kind inspected_lightmap = {AL_KIND_LIGHTMAP, summary, evaluate, draw};
