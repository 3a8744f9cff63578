/* Statistics, answers and pictures of impulse tables. */
#include "airlight/impulse_tables.h"

#include <math.h>
#include <string.h>

#include "airlight/formulas.h"
#include "canvas.h"
#include "inspect.h"

static const char *const emitters[] = {"point", "directional", "area"};

static al_status summary(const al_file *file, json_t **out, al_error *error)
{
    al_impulse_tables *tables;
    al_status status = al_impulse_tables_read(file, &tables, error);
    if (status != AL_OK) return status;
    const al_impulse_info *info = al_impulse_tables_info(tables);
    json_t *o = json_object(), *list = json_array();
    for (uint32_t i = 0; i < info->table_count; i++) {
        const al_impulse_table *t = al_impulse_tables_table(tables, i);
        json_t *table =
            json_pack("{s:s,s:s,s:[i,i],s:i,s:i,s:i,s:o}", "emitter", emitters[t->emitter], "axis",
                      t->axis == AL_IMPULSE_AXIS_FITTED ? "fitted" : "emitter", "events", (int)t->first_event,
                      (int)t->last_event, "distances", (int)t->distance_count, "cosines",
                      (int)t->cosine_count, "angles", (int)t->angle_count, "g", json_number(t->g));
        json_array_append_new(list, table);
    }
    json_object_set_new(o, "bands", json_integer(info->band_count));
    json_object_set_new(o, "events", json_integer(info->event_count));
    json_object_set_new(o, "distance_min", json_number(info->distance_min));
    json_object_set_new(o, "distance_max", json_number(info->distance_max));
    json_object_set_new(o, "rounding_error", json_number(info->rounding_error));
    json_object_set_new(o, "interpolation_error", json_number(info->interpolation_error));
    json_object_set_new(o, "tables", list);
    json_object_set_new(o, "provenance", json_provenance(file));
    *out = o;
    al_impulse_tables_free(tables);
    return AL_OK;
}

/* --- answers --- */

/* Key `key` as a number in [low, high]; `other` where it is missing (NAN: it must be there). */
static al_status query_number(const json_t *query, const char *key, double low, double high, double other,
                              double *number, al_error *error)
{
    const json_t *value = json_object_get(query, key);
    *number = value ? json_number_value(value) : other;
    if (value ? json_is_number(value) && *number >= low && *number <= high : !isnan(other)) return AL_OK;
    return al_fail(error, AL_USAGE, "--eval: \"%s\" should be a number from %g to %g", key, low, high);
}

static al_status query_choice(const json_t *query, const char *key, const char *const *names, int count,
                              int other, int *choice, al_error *error)
{
    const json_t *value = json_object_get(query, key);
    const char *text = json_string_value(value);
    *choice = other;
    if (!value && other >= 0) return AL_OK;
    for (int i = 0; text && i < count; i++)
        if (!strcmp(text, names[i])) return *choice = i, AL_OK;
    return count == 2 ? al_fail(error, AL_USAGE, "--eval: \"%s\" should be \"%s\" or \"%s\"", key, names[0],
                                names[1])
                      : al_fail(error, AL_USAGE, "--eval: \"%s\" should be \"%s\", \"%s\" or \"%s\"", key,
                                names[0], names[1], names[2]);
}

static al_status query_events(const json_t *query, uint32_t last, al_impulse_query *q, al_error *error)
{
    const json_t *value = json_object_get(query, "events");
    const char *text = json_string_value(value);
    size_t count = json_array_size(value);
    bool good = count > 0;
    if (text && !strcmp(text, "direct")) return q->first_event = q->last_event = 0, AL_OK;
    if (text && !strcmp(text, "all")) return q->first_event = 1, q->last_event = last, AL_OK;
    for (size_t i = 0; i < count; i++) {
        const json_t *event = json_array_get(value, i);
        json_int_t number = json_integer_value(event);
        good = good && json_is_integer(event) && number >= 0 && number <= last &&
               number == json_integer_value(json_array_get(value, 0)) + (json_int_t)i;
        if (good && i == 0) q->first_event = (uint32_t)number;
        if (good) q->last_event = (uint32_t)number;
    }
    return good ? AL_OK
                : al_fail(error, AL_USAGE,
                          "--eval: \"events\" should be \"direct\", \"all\" or numbers from 0 (the beam) to "
                          "%u one after "
                          "the other, such as [1] or [1, 2, 3]",
                          last);
}

static al_status read_query(const json_t *query, const al_impulse_info *info, al_impulse_query *q,
                            al_error *error)
{
    static const char *const keys[] = {"emitter", "distance", "cos_normal", "sigma_s", "sigma_a",
                                       "g",       "events",   "variant",    NULL};
    static const char *const variants[] = {"best", "published"};
    int emitter = 0, variant = 0;
    al_status status = query_keys(query, keys, error);
    if (status == AL_OK) status = query_choice(query, "emitter", emitters, 3, -1, &emitter, error);
    if (status == AL_OK) status = query_choice(query, "variant", variants, 2, 0, &variant, error);
    if (status == AL_OK) status = query_number(query, "distance", 1e-30, 1e30, NAN, &q->distance_m, error);
    if (status == AL_OK) status = query_number(query, "sigma_s", 0, 1e30, NAN, &q->sigma_s_per_m, error);
    if (status == AL_OK) status = query_number(query, "sigma_a", 0, 1e30, 0, &q->sigma_a_per_m, error);
    if (status == AL_OK) status = query_number(query, "g", -0.99, 0.99, 0, &q->g, error);
    q->cos_normal = 1;
    if (status == AL_OK && emitter == AL_IMPULSE_AREA)
        status = query_number(query, "cos_normal", -1, 1, NAN, &q->cos_normal, error);
    if (status == AL_OK) status = query_events(query, info->event_count, q, error);
    q->emitter = (al_impulse_emitter)emitter;
    q->variant = (al_impulse_variant)variant;
    return status;
}

static json_t *json_doubles(const double *values, size_t count)
{
    json_t *array = json_array();
    for (size_t i = 0; i < count; i++) json_array_append_new(array, json_number(values[i]));
    return array;
}

static al_status evaluate(const al_file *file, const json_t *query, json_t **reply, al_error *error)
{
    al_impulse_tables *tables;
    al_impulse_query q = {0};
    al_impulse_answer a;
    double zh[AL_IMPULSE_BAND_LIMIT];
    al_status status = al_impulse_tables_read(file, &tables, error);
    if (status == AL_OK) status = read_query(query, al_impulse_tables_info(tables), &q, error);
    if (status == AL_OK) {
        al_impulse_response(tables, &q, &a);
        double angle = al_impulse_zonal(&a, zh);
        *reply =
            json_pack("{s:o,s:o}", "zh", json_doubles(zh, a.band_count), "axis_angle", json_number(angle));
        if (a.m_count > 1) { /* about the direction to the emitter: m = 0, 1, 2, each from band m on */
            json_t *list = json_array();
            for (uint32_t m = 0; m < a.m_count; m++)
                json_array_append_new(list, json_doubles(a.sh[m] + m, a.band_count - m));
            json_object_set_new(*reply, "sh_m", list);
        }
    }
    al_impulse_tables_free(tables);
    return status;
}

/* --- picture: coefficients over distance, as figure 10 of the paper, one panel each for events 1, 2 and the
 * last of a point, event 1 of a directional light, events 1 and the last of an area that faces the receiver
 * --- */

enum { EDGE = 320, COLUMNS = 3, ROWS = 2 };

static const double decades[2] = {-2, 2};    /* of distances, mean free paths */
static const double magnitudes[2] = {-6, 3}; /* of coefficients */

/* Band 0 dark red, the last one blue. */
static void band_color(uint32_t band, uint32_t count, float rgb[3])
{
    float share = (float)band / (float)(count - 1);
    rgb[0] = 0.55f * (1 - share) + 0.02f;
    rgb[1] = 0.5f * share * (1 - share) * 2;
    rgb[2] = 0.9f * share + 0.01f;
}

static void plot_point(double distance, double value, double point[2])
{
    const double *const ranges[2] = {decades, magnitudes};
    double logs[2] = {log10(distance), log10(fmax(fabs(value), 1e-300))};
    for (int i = 0; i < 2; i++) point[i] = (logs[i] - ranges[i][0]) / (ranges[i][1] - ranges[i][0]);
}

static void draw_grid(const panel *p)
{
    const float grey[3] = {0.06f, 0.06f, 0.06f};
    for (double x = decades[0]; x <= decades[1]; x++) {
        double share = (x - decades[0]) / (decades[1] - decades[0]);
        panel_line(p, (double[]){share, 0}, (double[]){share, 1}, grey);
    }
    for (double y = magnitudes[0]; y <= magnitudes[1]; y++) {
        double share = (y - magnitudes[0]) / (magnitudes[1] - magnitudes[0]);
        panel_line(p, (double[]){0, share}, (double[]){1, share}, grey);
    }
}

static void draw_panel(const al_impulse_tables *tables, al_impulse_emitter emitter, uint32_t event,
                       const panel *p)
{
    uint32_t bands = al_impulse_tables_info(tables)->band_count;
    double before[AL_IMPULSE_BAND_LIMIT][2], here[2];
    draw_grid(p);
    for (int i = 0; i <= EDGE; i++) {
        al_impulse_answer a;
        double distance = pow(10, decades[0] + (decades[1] - decades[0]) * i / EDGE);
        al_impulse_query q = {.emitter = emitter,
                              .first_event = event,
                              .last_event = event,
                              .distance_m = distance,
                              .cos_normal = 1,
                              .sigma_s_per_m = 1};
        al_impulse_response(tables, &q, &a);
        for (uint32_t l = bands; l-- > 0;) {
            float rgb[3];
            band_color(l, bands, rgb);
            plot_point(distance, a.sh[0][l], here);
            if (i > 0) panel_line(p, before[l], here, rgb);
            memcpy(before[l], here, sizeof here);
        }
    }
}

static al_status draw(const al_file *file, const char *png_path, al_error *error)
{
    al_impulse_tables *tables;
    canvas on = {0};
    al_status status = al_impulse_tables_read(file, &tables, error);
    if (status != AL_OK) return status;
    uint32_t last = al_impulse_tables_info(tables)->event_count;
    const struct {
        al_impulse_emitter emitter;
        uint32_t event;
    } panels[COLUMNS * ROWS] = {{AL_IMPULSE_POINT, 1},    {AL_IMPULSE_POINT, last > 1 ? 2 : 1},
                                {AL_IMPULSE_POINT, last}, {AL_IMPULSE_DIRECTIONAL, 1},
                                {AL_IMPULSE_AREA, 1},     {AL_IMPULSE_AREA, last}};
    status = canvas_create(COLUMNS * EDGE + (COLUMNS + 1) * CANVAS_MARGIN,
                           ROWS * EDGE + (ROWS + 1) * CANVAS_MARGIN, &on, error);
    for (int i = 0; i < COLUMNS * ROWS && status == AL_OK; i++) {
        panel p = canvas_panel(&on, i % COLUMNS, i / COLUMNS, EDGE);
        panel_show(&p, (double[]){0, 0}, (double[]){1, 1});
        draw_panel(tables, panels[i].emitter, panels[i].event, &p);
    }
    if (status == AL_OK) status = canvas_write(&on, png_path, error);
    canvas_free(&on);
    al_impulse_tables_free(tables);
    return status;
}

const inspected_kind inspected_impulse_tables = {AL_KIND_IMPULSE_TABLES, summary, evaluate, draw};
