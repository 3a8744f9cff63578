/* What a frame was drawn from, read back from the GPU, and rays through its fogs in double precision. */
#ifndef AIRLIGHT_TEST_READBACK_H
#define AIRLIGHT_TEST_READBACK_H

#include "../../runtime/state.h"
#include "airlight/medium.h"

typedef struct surfel { /* shaders/surfels.glsl */
    float place[4], facing[4], front[4], back[4];
    uint32_t edges[4];
} surfel;

typedef struct readback { /* of the frame drawn last */
    al_frame_block frame;
    al_fog_block fogs;
    surfel *surfels;
    uint32_t surfel_count, width, height;
    float *geometry;              /* [height][width][4] */
    const al_medium_field *field; /* density of the first fog where it is a grid along the axes; the caller's */
    double grid_low[3], grid_voxel[3], grid_unit; /* of it: first voxel's centre and edges in m, and density where
                                                   * fog_density (shaders/fogs.glsl) is 1 */
} readback;

readback readback_take(const al_runtime *runtime);
void readback_free(readback *r);

typedef struct ray {
    double origin[3], direction[3];
} ray;

/* Through a place of the picture, in pixels. */
ray readback_ray(const al_frame_block *frame, double x, double y);
/* The part of the ray within [0, to] that lies in a fog's bounds. */
bool readback_clip(const al_fog_entry *fog, const ray *r, double to, double span[2]);
/* Density of fog i at r(t), inside its span: 1, or the grid's in its unit. */
double readback_density(const readback *r, int32_t i, const ray *along, double t);
/* Optical depth of all fogs over [0, to]. */
void readback_depth(const readback *r, const ray *along, double to, double tau[3]);

#endif
