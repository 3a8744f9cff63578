#include "sweep.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct knob_row {
    const char *name, *step; /* of the plan; the first one that is needed counts, separated by | */
    const char *values;      /* from the fastest to the most exact, separated by spaces */
    int preview, medium, final;
} knob_row;

/* Values beside the defaults are a factor of two to four away: docs/accuracy.md has finer curves of single knobs. Light between
 * surfaces by surfels takes minutes a picture without a graphics card: --knob indirect=off,surfels asks for it. */
static const knob_row rows[] = {
    {"bake.samples", "sample", "5000 20000 50000", 0, 1, 2},
    {"bake.directions", "project", "32 128 512", 1, 1, 2},
    {"bake.sh_order", "project", "3 5 8", 1, 1, 2},
    {"bake.grid_resolution", "voxelise", "32 64 128", 0, 1, 2},
    {"lightmap.samples", "lightmap", "32 128 512", 0, 1, 2},
    {"lightmap.bounces", "lightmap|probes", "2 4 8", 0, 1, 2},
    {"lightmap.fog_points", "gather fog", "8 16 32", 0, 1, 1},
    {"probes.samples", "probes", "256 1024 4096", 0, 1, 2},
    {"samples", "splat", "1000 4000 all", 1, 2, 2},
    {"sh-order", "splat", "2 4 all", 2, 2, 2},
    {"view-leg", "intervals", "sh marched", 0, 1, 1},
    {"intervals", "intervals", "8 16 32", 0, 1, 2},
    {"march-step", "intervals", "2 1 0.5 0.25", 1, 2, 3},
    {"fog-steps", "direct-scattering", "8 16 32 64", 1, 2, 3},
    {"surfel-size", "surface-scattering", "18 9 4.6", 0, 2, 2},
    {"shell-levels", "surface-scattering", "4 5 6 7", 0, 2, 2},
    {"shell-epsilon", "surface-scattering", "0.24 0.06 0.015", 0, 1, 2},
    {"visibility", "visibility", "off on", 0, 0, 1},
    {"ambient-occlusion", "ambient-occlusion", "off screen", 0, 0, 1},
    {"indirect", "indirect", "off screen", 0, 0, 1},
};

static bool row_needed(const knob_row *row, al_step_needed_fn *needed, const void *plans)
{
    bool bake = strchr(row->name, '.') != NULL;
    if (!strcmp(row->step, "gather fog"))
        return (needed(plans, true, "lightmap") || needed(plans, true, "probes")) && needed(plans, false, "direct-scattering");
    char steps[AL_NAME_SIZE], *rest = steps;
    snprintf(steps, sizeof steps, "%s", row->step);
    for (char *step; (step = strsep(&rest, "|"));)
        if (needed(plans, bake, step)) return true;
    return false;
}

/* Sets values from words between `separator`; false: too many or too long. */
static bool split_values(al_knob *knob, const char *text, char separator)
{
    for (knob->count = 0; *text;) {
        size_t length = strcspn(text, (char[]){separator, 0});
        if (!length || length >= AL_VALUE_SIZE || knob->count == AL_VALUE_LIMIT) return false;
        memcpy(knob->values[knob->count], text, length);
        knob->values[knob->count++][length] = 0;
        text += length + (text[length] == separator);
    }
    return knob->count > 0;
}

/* The index of `text`, put in its order among the numbers when it is not there. */
static int place_value(al_knob *knob, const char *text)
{
    int at = 0;
    double number = strtod(text, NULL);
    while (at < knob->count && strtod(knob->values[at], NULL) < number) at++;
    if (at < knob->count && strtod(knob->values[at], NULL) == number) return at;
    if (knob->count == AL_VALUE_LIMIT) return knob->medium;
    memmove(knob->values + at + 1, knob->values + at, (size_t)(knob->count - at) * AL_VALUE_SIZE);
    snprintf(knob->values[at], AL_VALUE_SIZE, "%s", text);
    knob->count++;
    if (at <= knob->preview) knob->preview++;
    if (at <= knob->final) knob->final++;
    return at;
}

static void hold_at_medium(al_knob *knob)
{
    memmove(knob->values[0], knob->values[knob->medium], AL_VALUE_SIZE);
    knob->count = 1;
    knob->preview = knob->medium = knob->final = 0;
}

/* Values given by hand: medium is its own where it is among them, else the first. */
static al_status take_values(al_knob *knob, const char *text, al_error *error)
{
    char medium[AL_VALUE_SIZE];
    memcpy(medium, knob->values[knob->medium], sizeof medium);
    if (!split_values(knob, text, ','))
        return al_fail(error, AL_USAGE, "--knob %s takes up to %d values of up to %d characters with commas between, not '%s'",
                       knob->name, AL_VALUE_LIMIT, AL_VALUE_SIZE - 1, text);
    knob->medium = 0;
    for (int i = 0; i < knob->count; i++)
        if (!strcmp(knob->values[i], medium)) knob->medium = i;
    knob->preview = 0;
    knob->final = knob->count - 1;
    return AL_OK;
}

static al_status keep_only(al_knobs *knobs, const al_option_list *only, al_error *error)
{
    bool kept[AL_KNOB_LIMIT] = {false};
    for (int i = 0; i < only->count; i++) {
        size_t length = strcspn(only->values[i], "=");
        int k = 0;
        while (k < knobs->count && (strlen(knobs->knobs[k].name) != length || memcmp(knobs->knobs[k].name, only->values[i], length)))
            k++;
        if (k == knobs->count) {
            char names[512] = "";
            for (k = 0; k < knobs->count; k++)
                snprintf(names + strlen(names), sizeof names - strlen(names), "%s%s", k ? ", " : "", knobs->knobs[k].name);
            return al_fail(error, AL_USAGE, "--knob: '%.*s' is no knob that this scene needs; it is one of %s", (int)length,
                           only->values[i], names);
        }
        kept[k] = true;
        if (only->values[i][length]) {
            al_status status = take_values(&knobs->knobs[k], only->values[i] + length + 1, error);
            if (status) return status;
        }
    }
    for (int k = 0; k < knobs->count && only->count; k++)
        if (!kept[k]) hold_at_medium(&knobs->knobs[k]);
    return AL_OK;
}

al_status al_knobs_choose(al_knobs *knobs, al_step_needed_fn *needed, const void *plans, al_scene_value_fn *value,
                          const void *scene, const al_option_list *only, al_error *error)
{
    _Static_assert(sizeof rows / sizeof *rows <= AL_KNOB_LIMIT, "room for every knob");
    knobs->count = 0;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        if (!row_needed(&rows[i], needed, plans)) continue;
        al_knob *knob = &knobs->knobs[knobs->count++];
        char text[AL_VALUE_SIZE];
        *knob = (al_knob){.name = rows[i].name, .preview = rows[i].preview, .medium = rows[i].medium, .final = rows[i].final};
        split_values(knob, rows[i].values, ' ');
        const char *own = strchr(knob->name, '.') ? value(scene, knob->name, text) : NULL;
        if (own) knob->medium = place_value(knob, own);
    }
    return keep_only(knobs, only, error);
}

static void add_point(al_points *points, const al_knobs *knobs, const uint8_t *chosen, const char *preset)
{
    size_t size = (size_t)knobs->count;
    for (int i = 0; i < points->count; i++)
        if (!memcmp(points->points[i].chosen, chosen, size)) return;
    if (points->count == AL_POINT_LIMIT) return;
    al_point *point = &points->points[points->count++];
    *point = (al_point){.preset = preset, .held_out_relative_rmse = NAN};
    memcpy(point->chosen, chosen, size);
}

void al_sweep_begin(al_points *points, const al_knobs *knobs, bool only)
{
    uint8_t medium[AL_KNOB_LIMIT] = {0}, preview[AL_KNOB_LIMIT] = {0}, final[AL_KNOB_LIMIT] = {0};
    points->count = 0;
    for (int k = 0; k < knobs->count; k++) {
        medium[k] = (uint8_t)knobs->knobs[k].medium;
        preview[k] = (uint8_t)knobs->knobs[k].preview;
        final[k] = (uint8_t)knobs->knobs[k].final;
    }
    add_point(points, knobs, medium, "medium");
    if (!only) add_point(points, knobs, preview, "preview");
    for (int k = 0; k < knobs->count; k++)
        for (int v = 0; v < knobs->knobs[k].count; v++) {
            uint8_t chosen[AL_KNOB_LIMIT];
            memcpy(chosen, medium, sizeof chosen);
            chosen[k] = (uint8_t)v;
            add_point(points, knobs, chosen, "");
        }
    if (!only) add_point(points, knobs, final, "final");
}

/* gain[k][v]: what value v of knob k adds to medium's squared error and time; NAN where that was not measured. */
typedef struct effect {
    double square, ms;
} effect;

static void find_effects(const al_points *points, const al_knobs *knobs, effect effects[AL_KNOB_LIMIT][AL_VALUE_LIMIT])
{
    const al_point *medium = &points->points[0];
    for (int k = 0; k < knobs->count; k++)
        for (int v = 0; v < knobs->knobs[k].count; v++) {
            uint8_t chosen[AL_KNOB_LIMIT];
            memcpy(chosen, medium->chosen, sizeof chosen);
            chosen[k] = (uint8_t)v;
            effects[k][v] = (effect){NAN, NAN};
            for (int i = 0; i < points->count; i++) {
                const al_point *p = &points->points[i];
                if (p->left_out || memcmp(p->chosen, chosen, (size_t)knobs->count)) continue;
                effects[k][v] = (effect){p->relative_rmse * p->relative_rmse - medium->relative_rmse * medium->relative_rmse,
                                         p->frame_ms - medium->frame_ms};
            }
        }
}

/* The next change of one knob: less error, and the most of it for its time. False when none brings anything. */
static bool improve(uint8_t *chosen, const al_knobs *knobs, effect effects[AL_KNOB_LIMIT][AL_VALUE_LIMIT])
{
    double best = 0;
    int knob = -1, value = 0;
    for (int k = 0; k < knobs->count; k++)
        for (int v = 0; v < knobs->knobs[k].count; v++) {
            const effect *now = &effects[k][chosen[k]], *then = &effects[k][v];
            double less = now->square - then->square, more = fmax(then->ms - now->ms, 1e-3);
            if (less > 0 && less / more > best) best = less / more, knob = k, value = v;
        }
    if (knob >= 0) chosen[knob] = (uint8_t)value;
    return knob >= 0;
}

void al_sweep_combine(al_points *points, const al_knobs *knobs, int limit)
{
    enum { STEPS = AL_KNOB_LIMIT * AL_VALUE_LIMIT };
    effect effects[AL_KNOB_LIMIT][AL_VALUE_LIMIT];
    uint8_t path[STEPS][AL_KNOB_LIMIT] = {{0}};
    int steps = 0;
    if (points->count == 0 || limit == 0) return;
    find_effects(points, knobs, effects);
    for (int k = 0; k < knobs->count; k++) {
        path[0][k] = points->points[0].chosen[k];
        for (int v = 0; v < knobs->knobs[k].count; v++)
            if (effects[k][v].ms < effects[k][path[0][k]].ms) path[0][k] = (uint8_t)v;
    }
    for (steps = 1; steps < STEPS; steps++) {
        memcpy(path[steps], path[steps - 1], AL_KNOB_LIMIT);
        if (!improve(path[steps], knobs, effects)) break;
    }
    int taken = limit < steps ? limit : steps;
    for (int i = 0; i < taken; i++)
        add_point(points, knobs, path[taken > 1 ? i * (steps - 1) / (taken - 1) : steps - 1], "");
}
