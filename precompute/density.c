#include "density.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "geometry.h"
#include "vdb_bridge.h"

static const uint64_t grid_size_limit = 1u << 30; /* bytes of one dense grid */

struct al_density {
    al_density_description from; /* its strings belong to the description and are not used here */
    al_vdb_grid grid;
    double world_to_index[16];          /* index space: voxel centres at whole numbers */
    double low_index[3], high_index[3]; /* the active box, whole voxels */
    double maximum, detail_m;
};

/* Rounding of world positions must not lose the voxels' own faces. */
static const double face_slack = 1e-9;

static double largest(double a, double b)
{
    return a > b ? a : b;
}

static al_status open_grid(const al_scene_description *scene, const al_medium_description *medium,
                           al_density *density, al_error *error)
{
    double to_world[16], edge = INFINITY;
    al_status status =
        al_vdb_read(density->from.file, density->from.grid, grid_size_limit, &density->grid, error);
    if (status) return status;
    if (!(density->grid.largest > 0))
        return al_fail(error, AL_BAD_INPUT,
                       "%s:%d: medium \"%s\": the grid in %s is 0 everywhere: there is no medium",
                       scene->path, medium->line, medium->name, density->from.file);
    al_matrix_multiply(density->from.grid_to_world, density->grid.index_to_world, to_world);
    if (!(fabs(al_matrix_determinant(to_world)) > 0))
        return al_fail(error, AL_BAD_INPUT, "%s:%d: medium \"%s\": the transform of the grid in %s is flat",
                       scene->path, medium->line, medium->name, density->from.file);
    al_matrix_invert(to_world, density->world_to_index);
    for (int i = 0; i < 3; i++) {
        const double *axis = to_world + i * 4;
        edge = fmin(edge, sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]));
        density->low_index[i] = -0.5 - face_slack * density->grid.size[i];
        density->high_index[i] = density->grid.size[i] - 0.5 + face_slack * density->grid.size[i];
    }
    density->detail_m = edge;
    density->maximum = density->from.scale * density->grid.largest;
    return AL_OK;
}

static void open_layers(al_density *density)
{
    const al_density_description *from = &density->from;
    double gap = from->period_m - from->thickness_m;
    bool striped = from->thickness_m > 0 && gap > 0;
    density->detail_m = striped ? fmin(from->thickness_m, gap) : 0;
    density->maximum = from->scale * largest(gap > 0 ? from->low : 0, from->thickness_m > 0 ? from->high : 0);
}

al_status al_density_open(const al_scene_description *scene, const al_medium_description *medium,
                          al_density **density, al_error *error)
{
    *density = NULL;
    al_density *made = calloc(1, sizeof *made);
    if (!made)
        return al_fail(error, AL_IO, "%s: out of memory for the density of \"%s\"", scene->path,
                       medium->name);
    made->from = medium->density;
    al_status status = AL_OK;
    if (made->from.type == AL_DENSITY_GRID)
        status = open_grid(scene, medium, made, error);
    else if (made->from.type == AL_DENSITY_LAYERS)
        open_layers(made);
    else
        made->maximum = made->from.scale;
    if (!status && !(made->maximum > 0))
        status =
            al_fail(error, AL_BAD_INPUT, "%s:%d: medium \"%s\" has density 0 everywhere: there is no medium",
                    scene->path, medium->line, medium->name);
    if (!status && !isfinite(made->maximum))
        status = al_fail(error, AL_BAD_INPUT, "%s:%d: medium \"%s\" has a density beyond all numbers",
                         scene->path, medium->line, medium->name);
    if (status)
        al_density_free(made);
    else
        *density = made;
    return status;
}

void al_density_free(al_density *density)
{
    if (!density) return;
    free(density->grid.values);
    free(density);
}

/* Trilinear between voxel centres; clamping the index holds the outermost centres' values beyond them. */
static double sample_grid(const al_density *density, const double index[3])
{
    const al_vdb_grid *grid = &density->grid;
    size_t first[3], step[3] = {1, grid->size[0], (size_t)grid->size[0] * grid->size[1]}, at = 0;
    double share[3];
    for (int i = 0; i < 3; i++) {
        double last = grid->size[i] - 1.0, x = index[i] > 0 ? index[i] : 0;
        if (x > last) x = last;
        first[i] = (size_t)x;
        share[i] = x - (double)first[i];
        at += first[i] * step[i];
        if (first[i] + 1 >= grid->size[i]) step[i] = 0;
    }
    const float *v = grid->values + at;
    double x00 = v[0] + share[0] * ((double)v[step[0]] - v[0]);
    double x10 = v[step[1]] + share[0] * ((double)v[step[1] + step[0]] - v[step[1]]);
    double x01 = v[step[2]] + share[0] * ((double)v[step[2] + step[0]] - v[step[2]]);
    double x11 =
        v[step[2] + step[1]] + share[0] * ((double)v[step[2] + step[1] + step[0]] - v[step[2] + step[1]]);
    double y0 = x00 + share[1] * (x10 - x00), y1 = x01 + share[1] * (x11 - x01);
    return y0 + share[2] * (y1 - y0);
}

static bool is_within(const double point[3], const double low[3], const double high[3])
{
    for (int i = 0; i < 3; i++)
        if (!(point[i] >= low[i] && point[i] <= high[i])) return false; /* NaN is outside */
    return true;
}

static double grid_at(const al_density *density, const double position[3])
{
    double index[3];
    al_matrix_point(density->world_to_index, position, index);
    if (!density->from.has_bounds && !is_within(index, density->low_index, density->high_index)) return 0;
    return largest(0, density->from.scale * sample_grid(density, index));
}

static double layers_at(const al_density *density, const double position[3])
{
    const al_density_description *from = &density->from;
    double along = (position[0] * from->axis[0] + position[1] * from->axis[1] + position[2] * from->axis[2] -
                    from->offset_m) /
                   from->period_m;
    double within = (along - floor(along)) * from->period_m;
    return from->scale * (within < from->thickness_m ? from->high : from->low);
}

double al_density_at(const al_density *density, const double position[3])
{
    const al_density_description *from = &density->from;
    if (from->has_bounds && !is_within(position, from->bounds_min_m, from->bounds_max_m)) return 0;
    switch (from->type) {
    case AL_DENSITY_GRID:
        return grid_at(density, position);
    case AL_DENSITY_LAYERS:
        return layers_at(density, position);
    case AL_DENSITY_CONSTANT:
        break;
    }
    return from->scale;
}

double al_density_max(const al_density *density)
{
    return density->maximum;
}

double al_density_detail_m(const al_density *density)
{
    return density->detail_m;
}

bool al_density_grid(const al_density *density, al_density_voxels *voxels)
{
    *voxels = (al_density_voxels){0};
    if (density->from.type != AL_DENSITY_GRID) return false;
    memcpy(voxels->size, density->grid.size, sizeof voxels->size);
    voxels->values = density->grid.values;
    voxels->scale = density->from.scale;
    al_matrix_multiply(density->from.grid_to_world, density->grid.index_to_world, voxels->index_to_world);
    voxels->extended = density->from.has_bounds;
    return true;
}

bool al_density_is_constant(const al_density *density)
{
    return density->from.type == AL_DENSITY_CONSTANT && !density->from.has_bounds;
}

bool al_density_bounds(const al_density *density, double low[3], double high[3])
{
    const al_density_description *from = &density->from;
    if (from->has_bounds) {
        memcpy(low, from->bounds_min_m, sizeof from->bounds_min_m);
        memcpy(high, from->bounds_max_m, sizeof from->bounds_max_m);
        return true;
    }
    if (from->type != AL_DENSITY_GRID) return false;
    double to_world[16];
    al_matrix_multiply(from->grid_to_world, density->grid.index_to_world, to_world);
    for (int i = 0; i < 3; i++) {
        low[i] = INFINITY;
        high[i] = -INFINITY;
    }
    for (int corner = 0; corner < 8; corner++) {
        double point[3];
        for (int i = 0; i < 3; i++) point[i] = corner >> i & 1 ? density->grid.size[i] - 0.5 : -0.5;
        al_matrix_point(to_world, point, point);
        for (int i = 0; i < 3; i++) {
            low[i] = fmin(low[i], point[i]);
            high[i] = fmax(high[i], point[i]);
        }
    }
    return true;
}
