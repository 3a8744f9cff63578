/* The Pareto front against brute force, its knee, and which points a sweep takes. */
#include "front.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "sweep.h"
#include "test.h"

enum { LIMIT = 64 };

static uint32_t next(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 16;
}

/* The definition the other way round: what a walk from the fastest point on leaves, which lets only falling errors pass. */
static void walk(const double *error, const double *time, size_t count, bool *on_front)
{
    for (size_t i = 0; i < count; i++) {
        double least_before = INFINITY, least_here = INFINITY;
        for (size_t k = 0; k < count; k++) {
            if (time[k] < time[i]) least_before = fmin(least_before, error[k]);
            if (time[k] == time[i]) least_here = fmin(least_here, error[k]);
        }
        on_front[i] = isfinite(error[i]) && isfinite(time[i]) && error[i] == least_here && error[i] < least_before;
    }
}

static void test_random(void)
{
    uint32_t state = 1;
    for (int round = 0; round < 2000; round++) {
        double error[LIMIT], time[LIMIT];
        bool found[LIMIT], expected[LIMIT];
        size_t count = next(&state) % LIMIT;
        for (size_t i = 0; i < count; i++) { /* few values, so that many are equal */
            error[i] = next(&state) % 12;
            time[i] = next(&state) % 12;
            if (next(&state) % 20 == 0) error[i] = NAN;
        }
        al_front(error, time, count, found);
        walk(error, time, count, expected);
        CHECK(memcmp(found, expected, count * sizeof *found) == 0);
    }
}

static void test_knee(void)
{
    const double error[] = {0.9, 0.2, 0.1, 0.5}, time[] = {1, 2, 100, 50};
    bool front[4];
    al_front(error, time, 4, front);
    CHECK(front[0] && front[1] && front[2] && !front[3]);
    CHECK(al_front_knee(error, time, front, 4) == 1);
    CHECK(al_front_knee(error, time, (bool[4]){false}, 4) == SIZE_MAX);
    CHECK(al_front_knee(error, time, (bool[4]){false, false, true, false}, 4) == 2);
}

/* --- the sweep, of a scene that needs two knobs --- */

static bool needs(const void *plans, bool bake, const char *step)
{
    (void)plans;
    return bake ? !strcmp(step, "voxelise") : !strcmp(step, "direct-scattering");
}

static const char *own_value(const void *scene, const char *key, char text[AL_VALUE_SIZE])
{
    (void)scene;
    if (strcmp(key, "bake.grid_resolution")) return NULL;
    return strcpy(text, "48");
}

static const al_option_list everything = {0};

static void test_knobs(void)
{
    al_knobs knobs;
    al_error error = {0};
    CHECK(al_knobs_choose(&knobs, needs, NULL, own_value, NULL, &everything, &error) == AL_OK);
    CHECK(knobs.count == 2);
    const al_knob *grid = &knobs.knobs[0], *fog = &knobs.knobs[1];
    CHECK(!strcmp(grid->name, "bake.grid_resolution") && !strcmp(fog->name, "fog-steps"));
    CHECK(grid->count == 4 && !strcmp(grid->values[grid->medium], "48"));
    CHECK(!strcmp(grid->values[grid->preview], "32") && !strcmp(grid->values[grid->final], "128"));
    al_option_list wrong = {{"intervals"}, 1};
    CHECK(al_knobs_choose(&knobs, needs, NULL, own_value, NULL, &wrong, &error) == AL_USAGE);
    CHECK(strstr(error.message, "bake.grid_resolution, fog-steps") != NULL);
    al_option_list one = {{"fog-steps=4,32"}, 1};
    CHECK(al_knobs_choose(&knobs, needs, NULL, own_value, NULL, &one, &error) == AL_OK);
    CHECK(knobs.knobs[0].count == 1 && !strcmp(knobs.knobs[0].values[0], "48"));
    CHECK(knobs.knobs[1].count == 2 && knobs.knobs[1].medium == 1);
}

/* Squared errors and times that do add up: the combinations reach the fastest and the most exact choice of each knob, whose
 * points were not measured. */
static void measure(const al_knobs *knobs, al_points *points)
{
    for (int i = 0; i < points->count; i++) {
        al_point *p = &points->points[i];
        double square = 0;
        p->frame_ms = 0;
        for (int k = 0; k < knobs->count; k++) {
            square += pow(0.25, p->chosen[k]) / (k + 1);
            p->frame_ms += pow(2, p->chosen[k]);
        }
        p->relative_rmse = sqrt(square);
    }
}

static bool has_point(const al_points *points, int first, int second)
{
    for (int i = 0; i < points->count; i++)
        if (points->points[i].chosen[0] == first && points->points[i].chosen[1] == second) return true;
    return false;
}

static void test_sweep(void)
{
    static al_points points;
    al_knobs knobs;
    al_error error = {0};
    al_knobs_choose(&knobs, needs, NULL, own_value, NULL, &everything, &error);
    al_sweep_begin(&points, &knobs, false);
    CHECK(points.count == 9); /* medium and 3 + 3 others, preview, final */
    CHECK(!strcmp(points.points[0].preset, "medium") && !strcmp(points.points[1].preset, "preview"));
    measure(&knobs, &points);
    CHECK(!has_point(&points, 0, 0));
    al_sweep_combine(&points, &knobs, 3);
    CHECK(points.count <= 12 && has_point(&points, 0, 0) && has_point(&points, 3, 3));
}

int main(void)
{
    test_random();
    test_knee();
    test_knobs();
    test_sweep();
    return test_end();
}
