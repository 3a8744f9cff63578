/* Density sequences: every frame at its time, in any order; the nearest one; the loop; frames without bricks; what is not
 * there yet is not waited for, and nothing is seen in part. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "../test.h"
#include "airlight/medium.h"
#include "sphere.h"
#include "stage.h"

enum { EDGE = 9, VOXELS = 20, FRAMES = 5 };

static const float densities[FRAMES] = {0, 1, 2, 0, 3}; /* of all voxels, frame by frame, every half second */
static const double sigma_t = 0.5, depth_m = 2;

static const char *folder;

static al_status slice(void *user, uint32_t frame, uint32_t z, float *density, al_error *error)
{
    (void)user, (void)z, (void)error;
    for (int i = 0; i < VOXELS * VOXELS; i++) density[i] = densities[frame];
    return AL_OK;
}

/* Absorbs only, a box of 2 m, before a background of 1: what is seen is exp(-sigma_t density 2 m). */
static al_runtime *open_sequence(void)
{
    static const float times[FRAMES] = {0, 0.5f, 1, 1.5f, 2};
    al_runtime *runtime = NULL;
    al_error error = {0};
    char path[512];
    sphere_scene s;
    al_fog fog = {.bounded = true, .bounds_min_m = {-1, -1, -1}, .bounds_max_m = {1, 1, 1}, .asset = "smoke.medium.air"};
    al_medium_data data = {.info = {.size = {VOXELS, VOXELS, VOXELS}, .page_size = 5, .frame_count = FRAMES,
                                    .grid_to_world = {0.1f, 0, 0, 0, 0, 0.1f, 0, 0, 0, 0, 0.1f, 0, -0.95f, -0.95f, -0.95f, 1},
                                    .bounds_min_m = {-1, -1, -1}, .bounds_max_m = {1, 1, 1},
                                    .sigma_a_per_m = {(float)sigma_t, (float)sigma_t, (float)sigma_t}},
                           .times_s = times,
                           .slice = slice};
    snprintf(path, sizeof path, "%s/smoke.medium.air", folder);
    CHECK(al_medium_write(path, &data, NULL, &error) == AL_OK);
    sphere_scene_begin(&s);
    for (int k = 0; k < 3; k++) s.medium.sigma_a_per_m[k] = (float)sigma_t, s.scene.play.background[k] = 1;
    s.scene.fogs = &fog;
    s.scene.fog_count = 1;
    CHECK(sphere_scene_write(folder, &s));
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK);
    CHECK(stage_load(runtime, folder));
    sphere_scene_end(&s);
    return runtime;
}

static double middle(al_runtime *runtime)
{
    const al_settings settings = {0};
    al_view view = stage_ortho(EDGE, EDGE, 0.5f);
    float *pixels = stage_draw(runtime, &view, &settings, 0);
    double value = pixels ? pixels[3 * (EDGE / 2 * EDGE + EDGE / 2)] : NAN, least = value, most = value;
    for (int i = 0; pixels && i < EDGE * EDGE * 3; i++) least = fmin(least, pixels[i]), most = fmax(most, pixels[i]);
    CHECK(most - least < 1e-5); /* every ray is as long, and of one frame */
    free(pixels);
    return value;
}

static void wait_for_frame(al_runtime *runtime)
{
    al_error error = {0};
    al_load_state state = {0};
    const struct timespec pause = {0, 100000};
    for (int i = 0; i < 100000 && !state.complete; i++) {
        CHECK(al_runtime_update(runtime, 0, &state, &error) == AL_OK);
        if (!state.complete) nanosleep(&pause, NULL);
    }
    CHECK(state.complete);
}

/* Densities are halfs of a frame's maximum, which all voxels have: exact. The march adds up 30 steps or so in
 * floats. */
static void check_frame(al_runtime *runtime, double time_s, int frame)
{
    al_runtime_set_time(runtime, time_s);
    wait_for_frame(runtime);
    CHECK_NEAR(middle(runtime), exp(-sigma_t * densities[frame] * depth_m), 1e-5);
}

static void test_frames(void)
{
    al_runtime *runtime = open_sequence();
    CHECK_NEAR(al_runtime_duration_s(runtime), 2.5, 1e-12); /* the last frame lasts as long as the others */
    CHECK_NEAR(middle(runtime), 1, 1e-5);
    for (int loop = 0; loop < 2; loop++)
        for (int i = 0; i < FRAMES; i++) check_frame(runtime, 2.5 * loop + 0.5 * i, i);
    for (int i = FRAMES - 1; i >= 0; i--) check_frame(runtime, 0.5 * i, i);
    uint64_t memory = al_runtime_memory(runtime);
    check_frame(runtime, 0.24, 0);
    check_frame(runtime, 0.26, 1);
    check_frame(runtime, 0.75, 2); /* of two as near, the later */
    check_frame(runtime, 2.49, 4);
    check_frame(runtime, 2.5, 0);
    check_frame(runtime, -0.5, 4);
    check_frame(runtime, 1.0, 2);
    CHECK(al_runtime_memory(runtime) == memory);
    al_runtime_destroy(runtime);
}

/* Without an update the old frame stays; with one brick a call it changes at once and as a whole. */
static void test_not_waiting(void)
{
    al_runtime *runtime = open_sequence();
    al_error error = {0};
    al_load_state state = {0};
    const struct timespec pause = {0, 100000};
    double wanted = exp(-sigma_t * densities[4] * depth_m), before = exp(-sigma_t * densities[1] * depth_m);
    check_frame(runtime, 0.5, 1);
    al_runtime_set_time(runtime, 2);
    CHECK_NEAR(middle(runtime), before, 1e-5);
    int old = 0;
    for (int i = 0; i < 100000 && !state.complete; i++) {
        CHECK(al_runtime_update(runtime, 1, &state, &error) == AL_OK);
        if (i % 8 == 0 || state.complete) {
            double now = middle(runtime);
            CHECK(fabs(now - before) < 1e-5 || fabs(now - wanted) < 1e-5);
            old += fabs(now - before) < 1e-5;
            CHECK(!state.complete || fabs(now - wanted) < 1e-5);
        }
        nanosleep(&pause, NULL);
    }
    CHECK(state.complete && old > 0);
    al_runtime_destroy(runtime); /* while the loader is busy with the frames ahead */
}

/* The box of the last frame, moved: beside it the background is seen whole; turned by 45 degrees, from edge to edge,
 * sqrt(2) times the way of its middle. The march ends within a step of a twentieth of a metre of where the fog does, at
 * each end: 2 x 0.05 m / 2.83 m of an optical depth of 4.2. */
static void test_moved(void)
{
    al_runtime *runtime = open_sequence();
    float *moved = al_runtime_scene(runtime)->fogs[0].moved;
    check_frame(runtime, 2, 4);
    moved[12] = 10;
    CHECK_NEAR(middle(runtime), 1, 1e-6);
    moved[12] = 0.25f;
    CHECK_NEAR(middle(runtime), exp(-sigma_t * densities[4] * depth_m), 1e-5);
    moved[12] = 0;
    moved[0] = moved[10] = (float)sqrt(0.5);
    moved[2] = -(float)sqrt(0.5);
    moved[8] = (float)sqrt(0.5);
    const al_settings settings = {0};
    al_view view = stage_ortho(EDGE, EDGE, 0.01f);
    float *pixels = stage_draw(runtime, &view, &settings, 0);
    CHECK(pixels != NULL);
    double depth = sigma_t * densities[4] * depth_m * sqrt(2);
    if (pixels) CHECK_NEAR(-log(pixels[3 * (EDGE / 2 * EDGE + EDGE / 2)]), depth, depth * 0.1 / 2.83);
    free(pixels);
    memset(moved, 0, 16 * sizeof *moved); /* flat: left where it was */
    CHECK_NEAR(middle(runtime), exp(-sigma_t * densities[4] * depth_m), 1e-5);
    al_runtime_destroy(runtime);
}

/* A frame that is damaged behind the first one: its error, once, and no fog. */
static void test_damaged(void)
{
    char path[512];
    al_error error = {0};
    al_load_state state = {0};
    al_runtime *runtime = open_sequence();
    al_runtime_destroy(runtime);
    snprintf(path, sizeof path, "%s/smoke.medium.air", folder);
    FILE *file = fopen(path, "r+b");
    CHECK(file != NULL);
    if (!file) return;
    fseek(file, -4096, SEEK_END); /* in the bricks of the last frame, before the table */
    fputc(0x55, file);
    fclose(file);
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK);
    CHECK(stage_load(runtime, folder));
    check_frame(runtime, 0, 0);
    al_runtime_set_time(runtime, 2);
    int failures = 0;
    for (int i = 0; i < 100000 && !state.complete; i++) {
        const struct timespec pause = {0, 100000};
        failures += al_runtime_update(runtime, 0, &state, &error) == AL_BAD_INPUT;
        nanosleep(&pause, NULL);
    }
    CHECK(failures == 1 && state.complete && strstr(error.message, "smoke.medium.air"));
    CHECK_NEAR(middle(runtime), 1, 1e-5);
    al_runtime_destroy(runtime);
}

int main(void)
{
    if (!stage_open()) return test_skip("no OpenGL 4.5");
    folder = stage_folder();
    if (!folder) return test_skip("no temporary folder");
    test_frames();
    test_not_waiting();
    test_moved();
    test_damaged();
    return test_end();
}
