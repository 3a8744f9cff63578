/* Random small scenes over all that the runtime allows: fogs, translucent objects, meshes, lights, eyes and settings. */
#ifndef AIRLIGHT_TEST_RANDOM_SCENE_H
#define AIRLIGHT_TEST_RANDOM_SCENE_H

#include <stdbool.h>
#include <stdint.h>

#include "airlight/runtime.h"

enum { RANDOM_FRAMES = 3 };

typedef enum random_kind {
    RANDOM_ANY,     /* everything */
    RANDOM_FURNACE, /* no light but an environment of 1 W/(m2 sr) from everywhere */
    RANDOM_BLACK    /* fogs that only absorb */
} random_kind;

typedef struct random_scene {
    uint64_t seed;
    random_kind kind;
    al_settings settings;
    al_view views[RANDOM_FRAMES];
    uint32_t frames;
    float unit;       /* m, about the scene's size */
    uint32_t surfaces, fogs, objects, lights; /* objects: translucent ones */
    bool sky, probes;
} random_scene;

/* What is changed of the scene and its settings: strengths and sizes are multiplied by powers of two. */
typedef struct random_change {
    int strength, size;
    bool fog_left_out;
} random_change;

/* Draws scene `index` of `seed` and writes it into `folder`; the same numbers are the same scene. Prints the error and
 * answers false where it cannot be written. */
bool random_scene_write(const char *folder, uint64_t seed, uint32_t index, const random_change *change, random_scene *scene);

#endif
