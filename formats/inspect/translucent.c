/* Statistics, answers and pictures of translucent assets. */
#include "airlight/translucent.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/formulas.h"
#include "canvas.h"
#include "inspect.h"

/* --- statistics --- */

typedef struct statistics {
    double low[4], high[4];  /* of a, weight, radius, density */
    double transmittance[3]; /* mean over samples and directions */
    uint64_t bytes;          /* of all pages' numbers */
} statistics;

static al_status gather(const al_file *file, const al_translucent_info *info, statistics *s, al_error *error)
{
    float coefficients[AL_SH_MAX_COUNT];
    al_translucent_page page;
    *s = (statistics){.low = {INFINITY, INFINITY, INFINITY, INFINITY},
                      .high = {-INFINITY, -INFINITY, -INFINITY, -INFINITY}};
    for (uint32_t p = 0; p < al_translucent_page_count(info); p++) {
        al_status status = al_translucent_read_page(file, info, p, &page, error);
        if (status != AL_OK) return status;
        for (uint32_t i = 0; i < page.count; i++) {
            for (int k = 0; k < 4; k++) {
                s->low[k] = fmin(s->low[k], page.gaussians[4 * (size_t)i + k]);
                s->high[k] = fmax(s->high[k], page.gaussians[4 * (size_t)i + k]);
            }
            for (uint32_t c = 0; c < info->channel_count; c++) { /* band 0 is sqrt(4 pi) times the mean */
                al_translucent_decode(info, &page, i, c, coefficients);
                s->transmittance[c] += coefficients[0] / sqrt(4 * AL_PI) / info->sample_count;
            }
        }
        s->bytes += al_file_chunk(file, (size_t)al_file_find(file, "PAGE", p))->size;
    }
    return AL_OK;
}

static json_t *range(double low, double high)
{
    return json_pack("[o,o]", json_number(low), json_number(high));
}

static al_status summary(const al_file *file, json_t **out, al_error *error)
{
    static const char *const formats[] = {"float", "half", "byte"};
    al_translucent_info info;
    statistics s;
    al_status status = al_translucent_read(file, &info, error);
    if (status == AL_OK) status = gather(file, &info, &s, error);
    if (status != AL_OK) return status;
    json_t *o = json_object();
    json_object_set_new(o, "samples", json_integer(info.sample_count));
    json_object_set_new(o, "pages", json_integer(al_translucent_page_count(&info)));
    json_object_set_new(o, "page_size", json_integer(info.page_size));
    json_object_set_new(o, "page_bytes", json_integer((json_int_t)s.bytes));
    json_object_set_new(o, "sh_order", json_integer(info.order));
    json_object_set_new(o, "channels", json_integer(info.channel_count));
    json_object_set_new(o, "coefficients", json_string(formats[info.format]));
    json_object_set_new(o, "directions", json_integer(info.direction_count));
    json_object_set_new(
        o, "grid",
        json_pack("[i,i,i]", (int)info.grid_size[0], (int)info.grid_size[1], (int)info.grid_size[2]));
    json_object_set_new(o, "grid_origin_m", json_numbers(info.grid_origin_m, 3));
    json_object_set_new(o, "voxel_m", json_number(info.voxel_m));
    json_object_set_new(o, "density_max", json_number(info.density_max));
    json_object_set_new(o, "blockers", json_boolean(info.has_blockers));
    json_object_set_new(o, "sigma_s_per_m", json_numbers(info.sigma_s_per_m, 3));
    json_object_set_new(o, "sigma_a_per_m", json_numbers(info.sigma_a_per_m, 3));
    json_object_set_new(o, "g", json_number(info.g));
    json_object_set_new(o, "ior", json_number(info.ior));
    json_object_set_new(o, "bounds_min_m", json_numbers(info.bounds_min_m, 3));
    json_object_set_new(o, "bounds_max_m", json_numbers(info.bounds_max_m, 3));
    json_object_set_new(o, "volume_m3", json_number(info.volume_m3));
    json_object_set_new(o, "sampling_radius_m", json_number(info.radius_m));
    json_object_set_new(o, "rho_quantile_per_m", json_number(info.rho_quantile));
    json_object_set_new(o, "unity_mean", json_number(info.unity_mean));
    json_object_set_new(o, "unity_deviation", json_number(info.unity_deviation));
    json_object_set_new(o, "unity_worst", json_number(info.unity_worst));
    json_object_set_new(o, "gaussian_a_per_m2", range(s.low[0], s.high[0]));
    json_object_set_new(o, "gaussian_weight", range(s.low[1], s.high[1]));
    json_object_set_new(o, "gaussian_radius_m", range(s.low[2], s.high[2]));
    json_object_set_new(o, "gaussian_density", range(s.low[3], s.high[3]));
    json_t *transmittance = json_array();
    for (uint32_t c = 0; c < info.channel_count; c++)
        json_array_append_new(transmittance, json_number(info.sample_count ? s.transmittance[c] : NAN));
    json_object_set_new(o, "mean_transmittance", transmittance);
    json_object_set_new(o, "provenance", json_provenance(file));
    *out = o;
    return AL_OK;
}

/* --- answers --- */

static al_status evaluate(const al_file *file, const json_t *query, json_t **answer, al_error *error)
{
    static const char *const keys[] = {"position", "direction", NULL};
    float position[3], direction[3], transmittance[3];
    uint32_t used;
    al_translucent_info info;
    al_status status = query_keys(query, keys, error);
    if (status == AL_OK) status = query_vector(query, "position", position, error);
    if (status == AL_OK) status = query_vector(query, "direction", direction, error);
    if (status == AL_OK && direction[0] == 0 && direction[1] == 0 && direction[2] == 0)
        status = al_fail(error, AL_USAGE, "--eval: \"direction\" has no length; any other length is fine");
    if (status == AL_OK) status = al_translucent_read(file, &info, error);
    if (status == AL_OK)
        status = al_translucent_evaluate(file, &info, position, direction, transmittance, &used, error);
    if (status == AL_OK)
        *answer = json_pack("{s:o,s:i}", "transmittance", json_numbers(transmittance, 3), "samples_used",
                            (int)used);
    return status;
}

/* --- picture: one column for each axis that is looked along, from its positive end --- */

enum { EDGE = 320, ROWS = 3 };

typedef struct dot {
    double place[2], depth; /* depth grows towards the eye */
    double transmittance;
} dot;

typedef struct view {
    int right, up, towards; /* axes of the picture and of the eye */
    double right_sign;      /* -1 where the axis runs to the left, so that the view is no mirror image */
} view;

static const view views[3] = {{2, 1, 0, -1}, {0, 2, 1, -1}, {0, 1, 2, 1}};

static void project(const view *v, const float position[3], double place[2])
{
    place[0] = v->right_sign * position[v->right];
    place[1] = position[v->up];
}

static void draw_slice(const al_translucent_info *info, const uint16_t *density, const uint8_t *blockers,
                       const view *v, const panel *p)
{
    for (int y = 0; y < p->edge; y++)
        for (int x = 0; x < p->edge; x++) {
            double point[2];
            float rgb[3];
            int64_t cell[3];
            panel_point(p, x, y, point);
            double place[3] = {0};
            place[v->right] = v->right_sign * point[0];
            place[v->up] = point[1];
            place[v->towards] =
                0.5 * ((double)info->bounds_min_m[v->towards] + info->bounds_max_m[v->towards]);
            bool inside = true;
            for (int k = 0; k < 3; k++) {
                double at = floor((place[k] - info->grid_origin_m[k]) / info->voxel_m);
                inside = inside && at >= 0 && at < info->grid_size[k];
                cell[k] = inside ? (int64_t)at : 0;
            }
            if (!inside) continue;
            size_t index = ((size_t)cell[2] * info->grid_size[1] + (size_t)cell[1]) * info->grid_size[0] +
                           (size_t)cell[0];
            float grey = (float)density[index] / 65535, opaque = blockers ? (float)blockers[index] / 255 : 0;
            for (int c = 0; c < 3; c++) rgb[c] = grey * (1 - opaque);
            rgb[0] += 0.8f * opaque;
            panel_set(p, x, y, rgb);
        }
}

static int by_depth(const void *a, const void *b)
{
    double left = ((const dot *)a)->depth, right = ((const dot *)b)->depth;
    return (left > right) - (left < right);
}

/* The samples of every page with psi towards the eye, mean of the channels. */
static al_status collect(const al_file *file, const al_translucent_info *info, const view *v, dot *dots,
                         al_error *error)
{
    double basis[AL_SH_MAX_COUNT], eye[3] = {0};
    float coefficients[AL_SH_MAX_COUNT];
    al_translucent_page page;
    eye[v->towards] = 1;
    al_sh_basis((int)info->order, eye[0], eye[1], eye[2], basis);
    for (uint32_t p = 0; p < al_translucent_page_count(info); p++) {
        al_status status = al_translucent_read_page(file, info, p, &page, error);
        if (status != AL_OK) return status;
        for (uint32_t i = 0; i < page.count; i++) {
            dot *d = &dots[page.first + i];
            const float *position = page.positions + 3 * (size_t)i;
            *d = (dot){.depth = position[v->towards]};
            project(v, position, d->place);
            for (uint32_t c = 0; c < info->channel_count; c++) {
                al_translucent_decode(info, &page, i, c, coefficients);
                for (uint32_t k = 0; k < info->order * info->order; k++)
                    d->transmittance += coefficients[k] * basis[k] / info->channel_count;
            }
        }
    }
    qsort(dots, info->sample_count, sizeof *dots, by_depth);
    return AL_OK;
}

/* Dots as wide as half the mean distance of samples; only those within `reach` of the middle plane. */
static void draw_dots(const al_translucent_info *info, const view *v, const dot *dots, double reach,
                      const panel *p)
{
    double middle = 0.5 * ((double)info->bounds_min_m[v->towards] + info->bounds_max_m[v->towards]);
    double radius = fmax(0.5 * info->radius_m / p->half * 0.5 * p->edge, 0.8);
    for (uint32_t i = 0; i < info->sample_count; i++) {
        float rgb[3];
        if (fabs(dots[i].depth - middle) > reach) continue;
        heat_color(dots[i].transmittance, rgb);
        panel_disc(p, dots[i].place, radius, rgb);
    }
}

static al_status draw_column(const al_file *file, const al_translucent_info *info, const uint16_t *density,
                             const uint8_t *blockers, int column, dot *dots, canvas *on, al_error *error)
{
    const view *v = &views[column];
    double low[2], high[2], other[2];
    project(v, info->bounds_min_m, low);
    project(v, info->bounds_max_m, other);
    for (int i = 0; i < 2; i++) {
        high[i] = fmax(low[i], other[i]);
        low[i] = fmin(low[i], other[i]);
    }
    al_status status = collect(file, info, v, dots, error);
    for (int row = 0; row < ROWS && status == AL_OK; row++) {
        panel p = canvas_panel(on, column, row, EDGE);
        panel_show(&p, low, high);
        if (row == 0)
            draw_slice(info, density, blockers, v, &p);
        else
            draw_dots(info, v, dots, row == 1 ? INFINITY : info->radius_m, &p);
    }
    return status;
}

static al_status draw(const al_file *file, const char *png_path, al_error *error)
{
    al_translucent_info info;
    const uint16_t *density;
    const uint8_t *blockers;
    canvas on = {0};
    dot *dots = NULL;
    al_status status = al_translucent_read(file, &info, error);
    if (status == AL_OK) status = al_translucent_read_grid(file, &info, &density, &blockers, error);
    if (status == AL_OK)
        status =
            canvas_create(3 * EDGE + 4 * CANVAS_MARGIN, ROWS * EDGE + (ROWS + 1) * CANVAS_MARGIN, &on, error);
    if (status != AL_OK) goto cleanup;
    dots = malloc(((size_t)info.sample_count + 1) * sizeof *dots);
    if (!dots)
        status =
            al_fail(error, AL_IO, "%s: out of memory for %u samples", al_file_name(file), info.sample_count);
    for (int column = 0; column < 3 && status == AL_OK; column++)
        status = draw_column(file, &info, density, blockers, column, dots, &on, error);
    if (status == AL_OK) status = canvas_write(&on, png_path, error);
cleanup:
    canvas_free(&on);
    free(dots);
    return status;
}

const inspected_kind inspected_translucent = {AL_KIND_TRANSLUCENT, summary, evaluate, draw};
