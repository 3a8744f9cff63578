#include "stats.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static al_status append(al_pass_series *series, double ms, al_error *error)
{
    if (series->count == series->room) {
        size_t room = series->room ? 2 * series->room : 64;
        double *grown = realloc(series->ms, room * sizeof *grown);
        if (!grown) return al_fail(error, AL_IO, "out of memory for %zu frame times", room);
        series->ms = grown;
        series->room = room;
    }
    series->ms[series->count++] = ms;
    return AL_OK;
}

static al_pass_series *find_series(al_stats *stats, const char *name)
{
    for (size_t i = 0; i < stats->pass_count; i++)
        if (!strcmp(stats->passes[i].name, name)) return &stats->passes[i];
    if (stats->pass_count == AL_STATS_PASS_LIMIT) return NULL;
    al_pass_series *series = &stats->passes[stats->pass_count++];
    snprintf(series->name, sizeof series->name, "%s", name);
    return series;
}

al_status al_stats_add(al_stats *stats, double frame_ms, const al_pass_time *times, uint32_t count,
                       al_error *error)
{
    al_status status = append(&stats->frame, frame_ms, error);
    for (uint32_t i = 0; i < count && !status; i++) {
        al_pass_series *series = find_series(stats, times[i].name);
        if (series) status = append(series, times[i].ms, error);
    }
    return status;
}

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(const al_pass_series *sorted)
{
    size_t n = sorted->count;
    if (!n) return NAN;
    return n % 2 ? sorted->ms[n / 2] : 0.5 * (sorted->ms[n / 2 - 1] + sorted->ms[n / 2]);
}

static json_t *number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

static json_t *describe_passes(const al_stats *stats)
{
    json_t *passes = json_array();
    for (size_t i = 0; i < stats->pass_count; i++) {
        const al_pass_series *series = &stats->passes[i];
        qsort(series->ms, series->count, sizeof *series->ms, compare);
        json_array_append_new(passes, json_pack("{s:s, s:o, s:o, s:o}", "name", series->name, "ms_median",
                                                number(median(series)), "ms_min", number(series->ms[0]),
                                                "ms_max", number(series->ms[series->count - 1])));
    }
    return passes;
}

static json_t *describe_plan(al_runtime *runtime)
{
    uint32_t count = 0;
    const al_plan_row *rows = al_runtime_plan(runtime, &count);
    json_t *plan = json_array();
    for (uint32_t i = 0; i < count; i++)
        json_array_append_new(plan, json_pack("{s:s, s:b, s:s, s:o, s:I}", "step", rows[i].step, "needed",
                                              rows[i].needed, "why", rows[i].why, "seconds",
                                              number(rows[i].seconds), "bytes", (json_int_t)rows[i].bytes));
    return plan;
}

al_status al_stats_write(const char *path, const al_stats *stats, al_runtime *runtime, al_error *error)
{
    qsort(stats->frame.ms, stats->frame.count, sizeof *stats->frame.ms, compare);
    json_t *root = json_pack(
        "{s:o, s:o, s:I, s:I, s:I, s:i, s:i, s:s, s:o, s:i, s:o, s:o}", "passes", describe_passes(stats),
        "frame_ms_median", number(median(&stats->frame)), "memory_bytes",
        (json_int_t)al_runtime_memory(runtime), "surfels", (json_int_t)al_runtime_surfels(runtime), "samples",
        (json_int_t)al_runtime_samples(runtime), "width", (int)stats->width, "height", (int)stats->height,
        "gl_renderer", stats->renderer, "plan", describe_plan(runtime), "frames", (int)stats->frame.count,
        "first_picture_ms", number(stats->first_picture_ms), "last_sample_ms", number(stats->last_sample_ms));
    if (stats->pick && stats->pick->knob_count)
        json_object_set_new(root, "expected",
                            json_pack("{s:o, s:o, s:o}", "relative_rmse", number(stats->pick->relative_rmse), "held_out_relative_rmse",
                                      number(stats->pick->held_out_relative_rmse), "frame_ms", number(stats->pick->frame_ms)));
    char *text = root ? json_dumps(root, JSON_INDENT(2) | JSON_REAL_PRECISION(9)) : NULL;
    size_t length = text ? strlen(text) : 0;
    if (text) text[length] = '\n'; /* a file ends with a line's end; the terminator is not written */
    al_status status = text ? al_write_file(path, text, length + 1, error)
                            : al_fail(error, AL_IO, "%s: out of memory", path);
    free(text);
    json_decref(root);
    return status;
}

void al_stats_free(al_stats *stats)
{
    free(stats->frame.ms);
    for (size_t i = 0; i < stats->pass_count; i++) free(stats->passes[i].ms);
    *stats = (al_stats){0};
}
