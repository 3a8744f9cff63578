/* A scene from a few words of JSON, and estimates along single rays. */
#ifndef AIRLIGHT_SCENE_FOR_TEST_H
#define AIRLIGHT_SCENE_FOR_TEST_H

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "mode.h"
#include "sampling.h"

typedef struct test_scene {
    const al_mode *mode;
    al_import *import;
    void *state;
    void *scratch;
} test_scene;

static inline void close_scene(test_scene *scene)
{
    scene->mode->scratch_free(scene->scratch);
    scene->mode->close(scene->state);
    al_import_free(scene->import);
    *scene = (test_scene){0};
}

/* `json` is the scene file with ' for ". Ends the test program when it cannot be read. */
static inline al_import *import_scene(const char *json)
{
    char path[64];
    snprintf(path, sizeof path, "scene_of_test_%ld.json", (long)getpid());
    al_import *import = NULL;
    al_error error = {0};
    FILE *file = fopen(path, "w");
    for (const char *c = json; file && *c; c++) fputc(*c == '\'' ? '"' : *c, file);
    if (!file || fclose(file)) {
        perror(path);
        exit(1);
    }
    if (al_import_scene(path, AL_QUALITY_FINAL, &import, &error)) {
        fprintf(stderr, "%s\n", error.message);
        exit(1);
    }
    remove(path);
    return import;
}

static inline test_scene open_scene_for(const al_mode *mode, const al_mode_options *limits, const char *json)
{
    test_scene scene = {.mode = mode, .import = import_scene(json)};
    al_error error = {0};
    if (mode->open(scene.import, limits, &scene.state, &error)) {
        fprintf(stderr, "%s\n", error.message);
        exit(1);
    }
    scene.scratch = mode->scratch_new();
    return scene;
}

static inline test_scene open_scene(const char *json)
{
    return open_scene_for(&al_mode_single_scatter, &al_mode_defaults, json);
}

static inline al_ray ray_along(double x, double y, double z, double dx, double dy, double dz)
{
    double length = sqrt(dx * dx + dy * dy + dz * dz);
    return (al_ray){{x, y, z}, {dx / length, dy / length, dz / length}};
}

/* Mean of 16 independent batches of `count` stratified samples, and its standard error, of one channel. */
static inline double estimate(const test_scene *scene, const al_ray *ray, uint32_t count, int channel,
                              double *error)
{
    enum { BATCHES = 16 };
    uint32_t dimensions = scene->mode->dimensions(scene->state);
    double *points = malloc(sizeof(double) * count * (dimensions + 1)), means[BATCHES], mean = 0, square = 0;
    for (uint32_t b = 0; b < BATCHES; b++) {
        al_random random = al_random_for(1234, b);
        al_sample_hypercube(&random, count, dimensions, points);
        means[b] = 0;
        for (uint32_t i = 0; i < count; i++) {
            double radiance[3];
            if (!scene->mode->radiance(scene->state, scene->scratch, ray, points + (size_t)i * dimensions,
                                       radiance))
                exit(1);
            means[b] += radiance[channel] / count;
        }
        mean += means[b] / BATCHES;
    }
    for (uint32_t b = 0; b < BATCHES; b++) square += (means[b] - mean) * (means[b] - mean);
    *error = sqrt(square / (BATCHES * (BATCHES - 1)));
    free(points);
    return mean;
}

#endif
