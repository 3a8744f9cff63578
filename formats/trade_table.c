#include "airlight/trade_table.h"

#include <errno.h>
#include <jansson.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { COLUMN_LIMIT = AL_TRADE_KNOB_LIMIT + 16, LINE_SIZE = 4096 };

typedef struct line {
    char text[LINE_SIZE];
    char *cells[COLUMN_LIMIT];
    int count;
} line;

typedef enum figure { RELATIVE_RMSE, SECONDS, FRAME_MS, FRONT, HELD_OUT, FIGURE_COUNT } figure;
static const char *const figure_names[FIGURE_COUNT] = {"relative_rmse", "seconds", "frame_ms", "front", "held_out_relative_rmse"};

typedef struct table {
    const char *path;
    FILE *file;
    unsigned number; /* of the line */
    line head, row;
    int columns[FIGURE_COUNT], knob_count; /* knobs come before relative_rmse */
    json_t *report;                        /* of the bake that points must be of; NULL: any of the front */
} table;

/* False at the end of the file; a line that is too long has no cells. */
static bool next_line(table *t, line *l)
{
    if (!fgets(l->text, LINE_SIZE, t->file)) return false;
    t->number++;
    size_t length = strlen(l->text);
    l->count = 0;
    if (length && l->text[length - 1] != '\n' && !feof(t->file)) return true;
    l->text[strcspn(l->text, "\r\n")] = 0;
    for (char *cell = l->text; l->count < COLUMN_LIMIT;) {
        l->cells[l->count++] = cell;
        if (!(cell = strchr(cell, ','))) break;
        *cell++ = 0;
    }
    return true;
}

static al_status read_head(table *t, al_error *error)
{
    if (!next_line(t, &t->head)) t->head.count = 0;
    for (int f = 0; f < FIGURE_COUNT; f++) {
        t->columns[f] = -1;
        for (int i = 0; i < t->head.count; i++)
            if (!strcmp(t->head.cells[i], figure_names[f])) t->columns[f] = i;
        if (t->columns[f] < 0)
            return al_fail(error, AL_BAD_INPUT, "%s:1: has no column %s; airlight-trade writes it", t->path, figure_names[f]);
    }
    t->knob_count = t->columns[RELATIVE_RMSE];
    for (int i = 0; i < t->knob_count; i++)
        if (t->knob_count > AL_TRADE_KNOB_LIMIT || strlen(t->head.cells[i]) >= AL_TRADE_TEXT_SIZE)
            return al_fail(error, AL_BAD_INPUT, "%s:1: more than %d knobs, or a name of more than %d bytes", t->path,
                           AL_TRADE_KNOB_LIMIT, AL_TRADE_TEXT_SIZE - 1);
    return AL_OK;
}

static al_status read_figures(const table *t, double figures[FIGURE_COUNT], al_error *error)
{
    if (t->row.count != t->head.count)
        return al_fail(error, AL_BAD_INPUT, "%s:%u: %d cells; the first line names %d", t->path, t->number, t->row.count,
                       t->head.count);
    for (int f = 0; f < FIGURE_COUNT; f++) {
        const char *cell = t->row.cells[t->columns[f]];
        char *end;
        figures[f] = strtod(cell, &end);
        if (f == HELD_OUT && !*cell) figures[f] = NAN;
        if (*end || (f != HELD_OUT && (!*cell || !isfinite(figures[f]))))
            return al_fail(error, AL_BAD_INPUT, "%s:%u: %s is '%s'; a number is right", t->path, t->number, figure_names[f], cell);
    }
    for (int i = 0; i < t->knob_count; i++)
        if (strlen(t->row.cells[i]) >= AL_TRADE_TEXT_SIZE)
            return al_fail(error, AL_BAD_INPUT, "%s:%u: %s has more than %d bytes", t->path, t->number, t->head.cells[i],
                           AL_TRADE_TEXT_SIZE - 1);
    return AL_OK;
}

static void take(const table *t, const double figures[FIGURE_COUNT], al_trade_pick *pick)
{
    *pick = (al_trade_pick){.knob_count = t->knob_count, .relative_rmse = figures[RELATIVE_RMSE],
                            .held_out_relative_rmse = figures[HELD_OUT], .seconds = figures[SECONDS],
                            .frame_ms = figures[FRAME_MS]};
    for (int i = 0; i < t->knob_count; i++) {
        strcpy(pick->knobs[i].name, t->head.cells[i]);
        strcpy(pick->knobs[i].value, t->row.cells[i]);
    }
}

/* Whether the row's bake had the settings of the one that is there. */
static bool was_baked(const table *t)
{
    const json_t *settings = json_object_get(t->report, "settings");
    for (int i = 0; i < t->knob_count; i++) {
        const char *name = t->head.cells[i];
        if (strchr(name, '.') && json_integer_value(json_object_get(settings, name)) != strtoll(t->row.cells[i], NULL, 10))
            return false;
    }
    return true;
}

static al_status open_report(table *t, const char *folder, al_error *error)
{
    char path[4096];
    json_error_t reason;
    snprintf(path, sizeof path, "%s/report.json", folder);
    t->report = json_load_file(path, 0, &reason);
    if (json_is_object(json_object_get(t->report, "settings"))) return AL_OK;
    return al_fail(error, AL_BAD_INPUT, "%s: %s; airlight-bake SCENE.json -o %s writes it", path,
                   t->report ? "says no settings" : reason.text, folder);
}

static al_status pick_row(table *t, double target_error, double frame_ms, al_trade_pick *pick, al_error *error)
{
    double figures[FIGURE_COUNT], least_error = INFINITY, least_ms = INFINITY;
    al_status status = read_head(t, error);
    while (!status && next_line(t, &t->row)) {
        status = read_figures(t, figures, error);
        if (status || !(t->report ? was_baked(t) : figures[FRONT] != 0)) continue;
        least_error = fmin(least_error, figures[RELATIVE_RMSE]);
        least_ms = fmin(least_ms, figures[FRAME_MS]);
        if ((target_error > 0 && figures[RELATIVE_RMSE] > target_error) || (frame_ms > 0 && figures[FRAME_MS] > frame_ms)) continue;
        bool better = target_error > 0 ? figures[FRAME_MS] < pick->frame_ms : figures[RELATIVE_RMSE] < pick->relative_rmse;
        if (!pick->knob_count || better) take(t, figures, pick);
    }
    if (status || pick->knob_count) return status;
    if (least_error == INFINITY && t->report)
        return al_fail(error, AL_CHECK_FAILED, "%s: no point was baked with the settings of report.json; airlight-bake SCENE.json -o DIR "
                       "--target-error E takes those of one", t->path);
    return al_fail(error, AL_CHECK_FAILED, "%s: no point meets what is asked; the most exact errs by %.3g, the fastest takes %.3g ms",
                   t->path, least_error, least_ms);
}

al_status al_trade_pick_point(const char *folder, double target_error, double frame_ms, bool as_baked, al_trade_pick *pick,
                              al_error *error)
{
    char path[4096];
    *pick = (al_trade_pick){0};
    table *t = calloc(1, sizeof *t);
    if (!t) return al_fail(error, AL_IO, "%s: out of memory", folder);
    snprintf(path, sizeof path, "%s/trade.csv", folder);
    t->path = path;
    t->file = fopen(path, "r");
    al_status status =
        t->file ? AL_OK
                : al_fail(error, AL_BAD_INPUT, "%s: cannot read: %s; airlight-trade SCENE.json -o %s makes it", path, strerror(errno), folder);
    if (!status && as_baked) status = open_report(t, folder, error);
    if (!status) status = pick_row(t, target_error, frame_ms, pick, error);
    if (t->file) fclose(t->file);
    json_decref(t->report);
    free(t);
    if (status) *pick = (al_trade_pick){0};
    return status;
}

int al_trade_knob_words(const char *name, const char *value, char words[2][2 * AL_TRADE_TEXT_SIZE])
{
    const size_t size = sizeof words[0];
    const char *carrier = !strcmp(name, "ambient-occlusion") ? "--occlusion-carrier" : !strcmp(name, "indirect") ? "--indirect-carrier" : NULL;
    if (strchr(name, '.') || !strcmp(value, "all") || !strcmp(value, "off")) return 0;
    if (carrier) {
        snprintf(words[0], size, "--%s", name);
        snprintf(words[1], size, "%s=%s", carrier, value);
        return 2;
    }
    if (!strcmp(value, "on"))
        snprintf(words[0], size, "--%s", name);
    else
        snprintf(words[0], size, "--%s=%s", name, value);
    return 1;
}

void al_trade_pick_describe(const al_trade_pick *pick, char *text, size_t size)
{
    int used = snprintf(text, size, "relative error %.3g", pick->relative_rmse);
    if (isfinite(pick->held_out_relative_rmse))
        used += snprintf(text + used, size - (size_t)used, " (%.3g in the held-out view)", pick->held_out_relative_rmse);
    used += snprintf(text + used, size - (size_t)used, ", %.3g ms a frame, %.3g s to bake:", pick->frame_ms, pick->seconds);
    for (int i = 0; i < pick->knob_count && used < (int)size; i++)
        used += snprintf(text + used, size - (size_t)used, " %s=%s", pick->knobs[i].name, pick->knobs[i].value);
}
