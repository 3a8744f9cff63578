/* Media along rays: optical lengths, and the cells that single scattering is sampled from.
 *
 * Constant media and layers are integrated in closed form. So are the optical lengths of grids: between the
 * planes through voxel centres a trilinear density is a cubic along a ray, which Gauss's rule of two points
 * integrates exactly. The cells of a grid are at most a quarter of a voxel long and, as far as light comes
 * through, at most a twentieth of optical depth thick; their density is that of their middle, so the error
 * falls with the square of their length. World space, metres. */
#ifndef AIRLIGHT_MARCH_H
#define AIRLIGHT_MARCH_H

#include "ray_scene.h"

typedef struct al_march_medium {
    const al_density *density;
    const al_density_description *description;
    double step_m;                                /* longest cell of a grid; INFINITY else */
    uint32_t size[3];                             /* of a grid, voxels; 0 else */
    double to_index[16];                          /* world to the grid's index space, voxel centres whole */
    double sigma_s_per_m[3], sigma_t_per_m[3], g; /* at density 1 */
} al_march_medium;

/* `index` into scene.media. */
al_march_medium al_march_medium_of(const al_import *import, uint32_t index);

/* Integral of the density along the ray from begin_m to end_m, in metres. */
double al_march_length(const al_march_medium *medium, const al_ray *ray, double begin_m, double end_m);

/* A piece of a ray on which every coefficient is taken as constant. */
typedef struct al_cell {
    double begin_m, end_m;
    double sigma_t_per_m[3]; /* of all media together */
    double depth[3];         /* optical depth from the ray's origin to begin_m */
    uint32_t first_part, part_count;
} al_cell;

typedef struct al_cell_part { /* one of the media that overlap in a cell */
    const al_march_medium *medium;
    double density;
} al_cell_part;

/* A stretch of a ray, of finite length, on which a medium may be. */
typedef struct al_march_part {
    const al_march_medium *medium;
    double begin_m, end_m;
} al_march_part;

/* Memory of one thread, reused from ray to ray. Zero before the first use. */
typedef struct al_cells {
    al_cell *cells; /* in order, gaps of vacuum between them left out */
    uint32_t count, room;
    al_cell_part *parts;
    uint32_t part_count, part_room;
    double depth[3]; /* of the whole ray */
    double *breaks;
    uint32_t break_count, break_room;
    double *ends;
    uint32_t end_count, end_room;
} al_cells;
void al_cells_free(al_cells *cells);

/* Fills `cells` for the parts of a ray, which may overlap, in any order. False without memory. */
bool al_march_cells(const al_ray *ray, const al_march_part *parts, uint32_t count, al_cells *cells);

#endif
