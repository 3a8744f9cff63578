/* Points in a uniform grid of cells, for "which points lie within this distance". */
#ifndef AIRLIGHT_POINT_GRID_H
#define AIRLIGHT_POINT_GRID_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "airlight/status.h"

typedef struct al_point_grid {
    double low[3], cell_m;
    int32_t size[3];
    const float *positions; /* [capacity][3], owned by the caller */
    uint32_t *first;        /* newest point of each cell, or UINT32_MAX */
    uint32_t *next;         /* [capacity] older point of the same cell */
} al_point_grid;

/* An empty grid over a box; cells are made larger than asked where there would be too many. */
al_status al_point_grid_create(const float *positions, uint32_t capacity, const double low[3],
                               const double high[3], double cell_m, al_point_grid *grid, al_error *error);
void al_point_grid_insert(al_point_grid *grid, uint32_t point);
void al_point_grid_free(al_point_grid *grid);

static inline int32_t al_point_grid_cell(const al_point_grid *grid, int axis, double at)
{
    double cell = floor((at - grid->low[axis]) / grid->cell_m);
    return (int32_t)fmin(fmax(cell, 0), grid->size[axis] - 1);
}

/* Walks the points of all cells that a ball touches, in an order that depends on the insertions only.
 */
typedef struct al_point_walk {
    const al_point_grid *grid;
    int32_t low[3], high[3], at[3];
    uint32_t point;
} al_point_walk;

static inline al_point_walk al_point_walk_begin(const al_point_grid *grid, const double centre[3],
                                                double radius)
{
    al_point_walk walk = {.grid = grid, .point = UINT32_MAX};
    for (int i = 0; i < 3; i++) {
        walk.low[i] = walk.at[i] = al_point_grid_cell(grid, i, centre[i] - radius);
        walk.high[i] = al_point_grid_cell(grid, i, centre[i] + radius);
    }
    walk.at[0]--;
    return walk;
}

/* The next point, or UINT32_MAX at the end. */
static inline uint32_t al_point_walk_next(al_point_walk *walk)
{
    const al_point_grid *grid = walk->grid;
    if (walk->point != UINT32_MAX) walk->point = grid->next[walk->point];
    while (walk->point == UINT32_MAX) {
        if (++walk->at[0] > walk->high[0]) {
            walk->at[0] = walk->low[0];
            if (++walk->at[1] > walk->high[1]) {
                walk->at[1] = walk->low[1];
                if (++walk->at[2] > walk->high[2]) return UINT32_MAX;
            }
        }
        walk->point =
            grid->first[((int64_t)walk->at[2] * grid->size[1] + walk->at[1]) * grid->size[0] + walk->at[0]];
    }
    return walk->point;
}

#endif
