/* Statistics, answers and pictures of medium assets. */
#include "airlight/medium.h"

#include <math.h>
#include <stdlib.h>

#include "canvas.h"
#include "inspect.h"

/* --- statistics --- */

static json_t *frame_list(const al_file *file, const al_medium_info *info, uint64_t *bricks, al_error *error)
{
    json_t *list = json_array();
    *bricks = 0;
    for (uint32_t i = 0; i < info->frame_count; i++) {
        al_medium_frame frame;
        if (al_medium_read_frame(file, info, i, &frame, error) != AL_OK) {
            json_decref(list);
            return NULL;
        }
        *bricks += frame.brick_count;
        json_array_append_new(list, json_pack("{s:o,s:o,s:I}", "time_s", json_number(frame.time_s),
                                              "density_max", json_number(frame.density_max), "bricks",
                                              (json_int_t)frame.brick_count));
    }
    return list;
}

static json_t *sky_facts(const al_medium_sky *sky)
{
    if (!sky->size[0]) return json_null();
    return json_pack("{s:[i,i,i],s:i,s:o,s:o,s:o}", "points", (int)sky->size[0], (int)sky->size[1],
                     (int)sky->size[2], "order", (int)sky->order, "grade", json_numbers(sky->grade, 3),
                     "unit_w_m2_sr", json_number(sky->unit_w_m2_sr), "walled", json_boolean(sky->walled));
}

static json_t *depth_facts(const al_medium_depth *depth)
{
    if (!depth->size[0]) return json_null();
    return json_pack("{s:[i,i,i],s:i}", "points", (int)depth->size[0], (int)depth->size[1], (int)depth->size[2], "order",
                     (int)depth->order);
}

static al_status summary(const al_file *file, json_t **out, al_error *error)
{
    al_medium_info info;
    uint32_t cells[3];
    uint64_t bricks;
    al_medium_sky sky;
    al_medium_depth depth;
    al_status status = al_medium_read(file, &info, error);
    if (status == AL_OK) status = al_medium_read_sky(file, &sky, error);
    if (status == AL_OK) status = al_medium_read_depth(file, &info, &depth, error);
    if (status != AL_OK) return status;
    json_t *frames = frame_list(file, &info, &bricks, error);
    if (!frames) return error->status;
    al_medium_cells(&info, cells);
    double all = (double)cells[0] * cells[1] * cells[2] * info.frame_count;
    json_t *o = json_object();
    json_object_set_new(o, "size",
                        json_pack("[i,i,i]", (int)info.size[0], (int)info.size[1], (int)info.size[2]));
    json_object_set_new(o, "brick_cells", json_pack("[i,i,i]", (int)cells[0], (int)cells[1], (int)cells[2]));
    json_object_set_new(o, "bricks", json_integer((json_int_t)bricks));
    json_object_set_new(o, "bricks_left_out", json_number(1 - (double)bricks / all));
    json_object_set_new(o, "brick_bytes", json_integer((json_int_t)(bricks * AL_BRICK_SIZE * 2)));
    json_object_set_new(o, "page_size", json_integer(info.page_size));
    json_object_set_new(o, "extended", json_boolean(info.extended));
    json_object_set_new(o, "grid_to_world", json_numbers(info.grid_to_world, 16));
    json_object_set_new(o, "bounds_min_m", json_numbers(info.bounds_min_m, 3));
    json_object_set_new(o, "bounds_max_m", json_numbers(info.bounds_max_m, 3));
    json_object_set_new(o, "sigma_s_per_m", json_numbers(info.sigma_s_per_m, 3));
    json_object_set_new(o, "sigma_a_per_m", json_numbers(info.sigma_a_per_m, 3));
    json_object_set_new(o, "g", json_number(info.g));
    json_object_set_new(o, "frames", frames);
    json_object_set_new(o, "sky", sky_facts(&sky));
    json_object_set_new(o, "optical_depth", depth_facts(&depth));
    json_object_set_new(o, "provenance", json_provenance(file));
    *out = o;
    return AL_OK;
}

/* --- answers --- */

static al_status open_field(const al_file *file, al_medium_info *info, al_medium_field **field,
                            al_error *error)
{
    *field = NULL;
    al_status status = al_medium_read(file, info, error);
    return status == AL_OK ? al_medium_field_open(file, info, field, error) : status;
}

/* Seconds; 0 when the key is missing. */
static al_status query_time(const json_t *query, double *time_s, al_error *error)
{
    const json_t *given = json_object_get(query, "time");
    *time_s = given ? json_number_value(given) : 0;
    bool good = !given || (json_is_number(given) && isfinite(*time_s));
    return good ? AL_OK : al_fail(error, AL_USAGE, "--eval: \"time\" should be a finite number");
}

/* Of the frame that is shown at the time, the nearest: coefficients of the density's integral to the bounds, m. */
static al_status add_depth(const al_file *file, const al_medium_info *info, const float position[3], double time_s,
                           json_t *answer, al_error *error)
{
    al_medium_depth depth;
    al_medium_frame frame, nearest = {0};
    uint32_t index = 0;
    const uint16_t *values;
    double sh[AL_DEPTH_TERMS_LIMIT];
    float numbers[AL_DEPTH_TERMS_LIMIT];
    al_status status = al_medium_read_depth(file, info, &depth, error);
    if (status != AL_OK || !depth.size[0]) return status;
    for (uint32_t i = 0; i < info->frame_count && status == AL_OK; i++) {
        status = al_medium_read_frame(file, info, i, &frame, error);
        if (i && fabs(frame.time_s - time_s) > fabs(nearest.time_s - time_s)) break;
        nearest = frame;
        index = i;
    }
    if (status == AL_OK) status = al_medium_read_depths(file, &depth, index, &values, error);
    if (status != AL_OK) return status;
    al_medium_depth_at(info, &depth, values, nearest.density_max, (double[3]){position[0], position[1], position[2]}, sh);
    for (uint32_t k = 0; k < depth.order * depth.order; k++) numbers[k] = (float)sh[k];
    json_object_set_new(answer, "depth_sh_m", json_numbers(numbers, depth.order * depth.order));
    return AL_OK;
}

static al_status evaluate(const al_file *file, const json_t *query, json_t **answer, al_error *error)
{
    static const char *const keys[] = {"position", "time", NULL};
    float position[3], scattering[3], absorption[3];
    double time_s;
    double sh[3][AL_SKY_TERMS_LIMIT];
    al_medium_info info;
    al_medium_field *field;
    al_medium_sky sky;
    al_status status = query_keys(query, keys, error);
    if (status == AL_OK) status = query_vector(query, "position", position, error);
    if (status == AL_OK) status = query_time(query, &time_s, error);
    if (status == AL_OK) status = open_field(file, &info, &field, error);
    if (status != AL_OK) return status;
    status = al_medium_read_sky(file, &sky, error);
    if (status != AL_OK) {
        al_medium_field_close(field);
        return status;
    }
    double density = al_medium_evaluate(field, (double[3]){position[0], position[1], position[2]}, time_s);
    for (int c = 0; c < 3; c++) {
        scattering[c] = (float)(density * info.sigma_s_per_m[c]);
        absorption[c] = (float)(density * info.sigma_a_per_m[c]);
    }
    *answer = json_pack("{s:o,s:o,s:o}", "sigma_s_per_m", json_numbers(scattering, 3), "sigma_a_per_m",
                        json_numbers(absorption, 3), "g", json_number(info.g));
    if (sky.size[0]) {
        json_t *channels = json_array();
        float numbers[AL_SKY_TERMS_LIMIT];
        al_medium_sky_at(&info, &sky, (double[3]){position[0], position[1], position[2]}, sh);
        for (int c = 0; c < 3; c++) {
            for (uint32_t k = 0; k < sky.order * sky.order; k++) numbers[k] = (float)sh[c][k];
            json_array_append_new(channels, json_numbers(numbers, sky.order * sky.order));
        }
        json_object_set_new(*answer, "sky_sh", channels);
    }
    al_medium_field_close(field);
    status = add_depth(file, &info, position, time_s, *answer, error);
    if (status != AL_OK) {
        json_decref(*answer);
        *answer = NULL;
    }
    return status;
}

/* --- picture: the first frame in the middle planes of its bounds, seen from +x, +y, +z --- */

enum { EDGE = 320 };

static void draw_slice(const al_medium_info *info, const al_medium_field *field, double time_s,
                       double density_max, int towards, canvas *on)
{
    static const struct {
        int right, up;
        double sign;
    } views[3] = {{2, 1, -1}, {0, 2, -1}, {0, 1, 1}};
    int right = views[towards].right, up = views[towards].up;
    double sign = views[towards].sign, low[2] = {sign * info->bounds_min_m[right], info->bounds_min_m[up]},
           high[2] = {sign * info->bounds_max_m[right], info->bounds_max_m[up]}, point[2], place[3];
    if (low[0] > high[0]) {
        double swap = low[0];
        low[0] = high[0];
        high[0] = swap;
    }
    panel p = canvas_panel(on, towards, 0, EDGE);
    panel_show(&p, low, high);
    place[towards] = 0.5 * ((double)info->bounds_min_m[towards] + info->bounds_max_m[towards]);
    for (int y = 0; y < EDGE; y++)
        for (int x = 0; x < EDGE; x++) {
            float rgb[3];
            panel_point(&p, x, y, point);
            place[right] = sign * point[0];
            place[up] = point[1];
            if (point[0] < low[0] || point[0] > high[0] || point[1] < low[1] || point[1] > high[1]) continue;
            heat_color(density_max > 0 ? al_medium_evaluate(field, place, time_s) / density_max : 0, rgb);
            panel_set(&p, x, y, rgb);
        }
}

static al_status draw(const al_file *file, const char *png_path, al_error *error)
{
    al_medium_info info;
    al_medium_field *field;
    al_medium_frame frame;
    canvas on = {0};
    al_status status = open_field(file, &info, &field, error);
    if (status == AL_OK) status = al_medium_read_frame(file, &info, 0, &frame, error);
    if (status == AL_OK)
        status = canvas_create(3 * EDGE + 4 * CANVAS_MARGIN, EDGE + 2 * CANVAS_MARGIN, &on, error);
    for (int axis = 0; axis < 3 && status == AL_OK; axis++)
        draw_slice(&info, field, frame.time_s, frame.density_max, axis, &on);
    if (status == AL_OK) status = canvas_write(&on, png_path, error);
    canvas_free(&on);
    al_medium_field_close(field);
    return status;
}

const inspected_kind inspected_medium = {AL_KIND_MEDIUM, summary, evaluate, draw};
