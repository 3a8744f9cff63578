/* The density of a medium as a function of position: constant, an OpenVDB grid, or procedural layers.
 * A grid is trilinear between voxel centres, clamped to the outermost ones inside the medium's bounds, zero
 * outside. Evaluation is thread-safe and deterministic. */
#ifndef AIRLIGHT_DENSITY_H
#define AIRLIGHT_DENSITY_H

#include "airlight/scene_description.h"

typedef struct al_density al_density;

al_status al_density_open(const al_scene_description *scene, const al_medium_description *medium,
                          al_density **density, al_error *error);
void al_density_free(al_density *density);

/* Density at a world position; scale applied, never negative or NaN. */
double al_density_at(const al_density *density, const double position[3]);
/* An upper bound of the density everywhere. */
double al_density_max(const al_density *density);
/* World edge of the finest detail: the voxel of a grid, the thinnest layer; 0 for a constant. */
double al_density_detail_m(const al_density *density);
/* The voxels of a grid, as they are in the file. */
typedef struct al_density_voxels {
    uint32_t size[3];
    const float *values;       /* [z][y][x], x fastest; density = scale * value; the density's own */
    double scale;
    double index_to_world[16]; /* column-major, affine; (i, j, k) is the centre of values[k][j][i] */
    bool extended;             /* the outermost values hold up to the medium's bounds */
} al_density_voxels;
/* False, and zeros: the density is no grid. */
bool al_density_grid(const al_density *density, al_density_voxels *voxels);
bool al_density_is_constant(const al_density *density);
/* World box outside of which the density is 0: of a turned grid the box around it. False: it has none. */
bool al_density_bounds(const al_density *density, double low[3], double high[3]);

#endif
