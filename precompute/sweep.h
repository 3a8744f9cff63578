/* The sweep behind steps 2 (optical depth), 3 (moment) and 6 (project): parallel rays through the grid along
 * a batch of direction pairs. Derivation and layout: opencl/sweep.cl. Memory does not grow with the number
 * of directions. */
#ifndef AIRLIGHT_SWEEP_H
#define AIRLIGHT_SWEEP_H

#include "airlight/program.h"
#include "device.h"
#include "grid.h"

typedef struct al_sweep {
    al_device *device;
    const al_grid *grid;
    cl_kernel kernel;
    cl_mem density;           /* of the current axis, padded */
    cl_mem forward, backward; /* absorbance towards +w and -w: [batch][nv + 2][na][width] */
    cl_mem shifts, fractions, rays, lengths;
    uint32_t batch;         /* direction pairs at a time */
    size_t buffer_size;     /* floats of one padded field, the largest over the axes */
    float *staging;         /* host copy of one padded field */
    double blocker_density; /* density that stands for one nat of blocking per voxel */

    /* of the current axis */
    uint32_t axis[3]; /* world axes of u, v, a */
    cl_int4 shape;    /* nu, nv, na, padded width */
    cl_ulong stride;  /* floats of one padded field */
    uint32_t direction_count;
    uint32_t *pairs; /* indices of the directions whose dominant axis this is */
    uint32_t pair_count;
    double seconds; /* spent marching rays, all runs together */
} al_sweep;

/* memory_limit in bytes bounds the batch. sigma_smallest: the least positive extinction that will be swept,
 * 1/m at density 1: blockers stop light for it too. */
al_status al_sweep_create(al_device *device, const al_grid *grid, uint32_t direction_count,
                          double sigma_smallest, size_t memory_limit, al_sweep *sweep, al_error *error);
void al_sweep_free(al_sweep *sweep);

/* Lays the density out for dominant axis `a` (0 x, 1 y, 2 z) and lists its pairs. */
al_status al_sweep_set_axis(al_sweep *sweep, uint32_t a, al_error *error);

/* Direction w of pair `index` of the axis, oriented so that its component along the axis is positive. */
void al_sweep_direction(const al_sweep *sweep, uint32_t index, double w[3]);

/* Fills forward and backward for pairs [first, first + count) of the axis at extinction `sigma` (1/m at
 * density 1), count <= batch. */
al_status al_sweep_run(al_sweep *sweep, uint32_t first, uint32_t count, double sigma, al_error *error);

/* Adds one padded field of the current axis to values [z][y][x] of the grid. */
void al_sweep_unpad_add(const al_sweep *sweep, const float *padded, float *grid_values);

/* 3. First moment T [3][z][y][x] of psi at extinction `sigma`. `state` continues an interrupted call. */
typedef struct al_moment_state {
    uint32_t axis, next; /* axes before `axis` are done, and pairs before `next` of it */
    float *total;        /* [3][z][y][x] sums of the axes that are done */
    float *planes;       /* [3][padded] sums of the current axis */
    size_t plane_size;   /* floats of one of them */
} al_moment_state;
al_status al_moment_begin(const al_sweep *sweep, al_moment_state *state, al_error *error);
/* AL_CANCELLED leaves a state that can be saved and continued. */
al_status al_moment_run(al_sweep *sweep, double sigma, al_moment_state *state, al_progress *progress,
                        al_error *error);
/* Once after the last al_moment_run: state->total becomes T. */
void al_moment_finish(const al_sweep *sweep, al_moment_state *state);
void al_moment_free(al_moment_state *state);

/* 4. rho [z][y][x] = |div T| in 1/m. */
al_status al_divergence(al_device *device, const al_grid *grid, const float *moment, float *rho,
                        al_error *error);

/* 6. SH coefficients of psi at points in object space, one extinction: coefficients [point][order^2]. */
typedef struct al_project_state {
    uint32_t axis, next;
    float *sums; /* [point][blocks * 8] */
    size_t sum_count;
} al_project_state;
al_status al_project_begin(uint32_t point_count, uint32_t order, al_project_state *state, al_error *error);
al_status al_project_run(al_sweep *sweep, double sigma, uint32_t order, const float *points,
                         uint32_t point_count, al_project_state *state, al_progress *progress,
                         al_error *error);
/* coefficients [point][stride], this extinction's order^2 numbers at the start of each. */
void al_project_finish(const al_project_state *state, uint32_t direction_count, uint32_t order,
                       uint32_t point_count, float *coefficients, size_t stride);
void al_project_free(al_project_state *state);

#endif
