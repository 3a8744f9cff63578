#include "point_grid.h"

#include <stdlib.h>
#include <string.h>

static const double cell_limit = 64e6;

al_status al_point_grid_create(const float *positions, uint32_t capacity, const double low[3],
                               const double high[3], double cell_m, al_point_grid *grid, al_error *error)
{
    *grid = (al_point_grid){.positions = positions, .cell_m = cell_m};
    double cells = 1;
    do {
        if (cells > cell_limit) grid->cell_m *= 1.26;
        cells = 1;
        for (int i = 0; i < 3; i++) cells *= floor((high[i] - low[i]) / grid->cell_m) + 1;
    } while (cells > cell_limit);
    for (int i = 0; i < 3; i++) {
        grid->low[i] = low[i];
        grid->size[i] = (int32_t)floor((high[i] - low[i]) / grid->cell_m) + 1;
    }
    grid->first = malloc((size_t)cells * sizeof *grid->first);
    grid->next = malloc(((size_t)capacity + 1) * sizeof *grid->next);
    if (!grid->first || !grid->next) {
        al_point_grid_free(grid);
        return al_fail(error, AL_IO, "out of memory for a grid of %u points", capacity);
    }
    memset(grid->first, 0xff, (size_t)cells * sizeof *grid->first);
    return AL_OK;
}

void al_point_grid_insert(al_point_grid *grid, uint32_t point)
{
    int32_t cell[3];
    for (int i = 0; i < 3; i++) cell[i] = al_point_grid_cell(grid, i, grid->positions[3 * (size_t)point + i]);
    uint32_t *first = &grid->first[((int64_t)cell[2] * grid->size[1] + cell[1]) * grid->size[0] + cell[0]];
    grid->next[point] = *first;
    *first = point;
}

void al_point_grid_free(al_point_grid *grid)
{
    free(grid->first);
    free(grid->next);
    *grid = (al_point_grid){0};
}
