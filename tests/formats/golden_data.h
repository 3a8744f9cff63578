/* What the golden files hold: small, every array and field with a value of its own, no library functions in
 * the numbers, so that every machine makes the same bytes. */
#ifndef AIRLIGHT_GOLDEN_DATA_H
#define AIRLIGHT_GOLDEN_DATA_H

#include "airlight/impulse_tables.h"
#include "airlight/lightmap.h"
#include "airlight/medium.h"
#include "airlight/probes.h"
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

/* The float one with two measured errors: 3 numbers without a unit, one in W/m2 of a random truth. */
void golden_fill_measured(golden_translucent *golden);

typedef struct golden_lightmap {
    al_lightmap_data data;
    al_lightmap_instance instances[2];
    al_lightmap_source pages[2];
    float irradiance[2][3 * 12 * 3], sh[2][3 * 4 * 12 * 3], vertices[8 * 5];
    uint8_t state[2][12];
    uint32_t triangles[4 * 3];
} golden_lightmap;

/* float: one instance on a page of 3 x 2 texels, no SH. half: two instances on pages of 4 x 3 and 2 x 2
 * texels, SH of order 2. Each instance is a square metre that faces +y. */
void golden_fill_lightmap(al_lightmap_format format, golden_lightmap *golden);

/* Five probes of order 2 and the two tetrahedra between them; every pointer is to static memory. */
void golden_fill_probes(al_probes_data *data);

/* A translucent tetrahedron with a blocker over a textured quad; every pointer is to static memory. */
void golden_fill_scene(al_scene *scene);
/* The same with a floor that has a lightmap, two fogs and the names of baked light. */
void golden_fill_lit_scene(al_scene *scene);

/* The first one with a floor, a lamp and a camera on nodes, and a tetrahedron with two joints and a morph target. */
void golden_fill_moving_scene(al_scene *scene);

/* Impulse tables of 3 bands, 2 events, 4 distances and 7 cosines: all that must be there, and one of each kind
 * that may be. */
enum { GOLDEN_TABLES = 10 };
typedef struct golden_impulse {
    al_impulse_data data;
    al_impulse_table tables[GOLDEN_TABLES];
    float angles[2], values[GOLDEN_TABLES][7 * 4 * 6];
} golden_impulse;
void golden_fill_impulse(golden_impulse *golden);
/* Two frames of 10 x 2 x 9 voxels in two bricks, of which the first frame lacks one; pages of one brick. */
void golden_fill_medium(al_medium_data *data);
void golden_fill_medium_sky(al_medium_data *data); /* the same with light of the sky */
void golden_fill_medium_depth(al_medium_data *data); /* the first with optical depths */
/* The density the golden medium has in voxel x, y, z of a frame. */
float golden_density(uint32_t frame, uint32_t x, uint32_t y, uint32_t z);

#endif
