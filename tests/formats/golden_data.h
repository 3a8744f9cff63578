/* What the golden files hold: small, every array and field with a value of its own, no library functions in
 * the numbers, so that every machine makes the same bytes. */
#ifndef AIRLIGHT_GOLDEN_DATA_H
#define AIRLIGHT_GOLDEN_DATA_H

#include "airlight/impulse_tables.h"
#include "airlight/scene.h"
#include "airlight/translucent.h"

typedef struct golden_translucent {
    al_translucent_data data;
    float positions[5 * 3], gaussians[5 * 4], coefficients[5 * 3 * 9];
    uint16_t density[3 * 2 * 2];
    uint8_t blockers[3 * 2 * 2];
} golden_translucent;

/* byte: five samples in three pages, RGB, order 2, blockers; half: four samples in one page, grey, order 3;
 * float: one sample, order 1. */
void golden_fill_translucent(al_coefficient_format format, golden_translucent *golden);

/* A translucent tetrahedron with a blocker over a textured quad; every pointer is to static memory. */
void golden_fill_scene(al_scene *scene);
/* The same with a floor that has a lightmap, two fogs and the names of baked light. */
void golden_fill_lit_scene(al_scene *scene);

/* Impulse tables of 3 bands, 2 events, 4 distances and 7 cosines: all that must be there, and one of each kind
 * that may be. */
enum { GOLDEN_TABLES = 10 };
typedef struct golden_impulse {
    al_impulse_data data;
    al_impulse_table tables[GOLDEN_TABLES];
    float angles[2], values[GOLDEN_TABLES][7 * 4 * 6];
} golden_impulse;
void golden_fill_impulse(golden_impulse *golden);

#endif
