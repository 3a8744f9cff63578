/* The voxel grid of a translucent object and the step that makes it (1. voxelise). */
#ifndef AIRLIGHT_GRID_H
#define AIRLIGHT_GRID_H

#include "import.h"

/* Cubic voxels in object space; one layer of empty voxels all around. Arrays [z][y][x], x fastest. */
typedef struct al_grid {
    uint32_t size[3];
    double origin_m[3]; /* lower corner of voxel (0, 0, 0) */
    double voxel_m;
    float *density;  /* mean density of the voxel: density where inside the boundary and no blocker, else 0 */
    float *blockers; /* opaque share of the voxel, 0 to 1; NULL without blockers */
    uint8_t *inside; /* 1: more than half of the voxel is medium */
    float density_max;
} al_grid;

typedef struct al_density_field { /* density as seen from object space */
    const al_density *density;
    double to_world[16];
} al_density_field;

/* Voxelises with `resolution` voxels along the longest axis of the boundary's box. The share of each voxel
 * inside is exact along z on 4 x 4 lines per voxel; density is averaged over 2^3 (4^3 where its detail is
 * finer than the voxel) points of the inside share. `threads` >= 1; the result does not depend on it. */
al_status al_grid_voxelise(const char *name, const al_triangles *boundary, const al_triangles *blockers,
                           const al_density_field *field, uint32_t resolution, unsigned threads,
                           al_grid *grid, al_error *error);
void al_grid_free(al_grid *grid);

static inline size_t al_grid_count(const al_grid *grid)
{
    return (size_t)grid->size[0] * grid->size[1] * grid->size[2];
}

#endif
