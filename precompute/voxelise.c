/* Step 1: voxelise. How much of each voxel is medium, how dense it is there, how much is opaque.
 *
 * Lines parallel to z, LINES x LINES per voxel column, are cut by the surface. Along a line the indicator
 * of the inside is a sum of steps, +1 where a face is entered and -1 where one is left, so that the inside
 * share of each slab of a voxel needs no sorting: each cut adds its step to a difference array whose running
 * sum is the share, exact along z. A point on the common edge of two faces is given to exactly one of them
 * (edge functions are evaluated with the edge's vertices in one fixed order), so that no line leaks. */
#include "grid.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "parallel.h"

enum { LINES = 4, SLABS_FINE = 4, SLABS_COARSE = 2 };

/* Lines lie off the voxels' symmetry planes, where modelled faces and edges like to be. */
static const double line_shift = 0.5 + 0.0117;

typedef struct solid { /* a closed surface, its triangles listed by voxel row (y) */
    const al_triangles *triangles;
    uint32_t *row_start; /* [rows + 1] into `listed` */
    uint32_t *listed;
} solid;

typedef struct voxeliser {
    al_grid *grid;
    const al_density_field *field;
    solid boundary, blockers;
    unsigned slabs; /* per voxel along z; sub-cells per edge of the density's average */
    float *scratch; /* per thread: shares of boundary and of blockers, [line_y][line_x][slab + 1] each */
    size_t scratch_size;
    double low[3], high[3]; /* the boundary's box, a little shrunk: where density is asked for */
    bool constant;
    double constant_density;
} voxeliser;

static bool row_range(const voxeliser *v, const al_triangles *mesh, uint32_t triangle, uint32_t range[2])
{
    double low = INFINITY, high = -INFINITY;
    for (int corner = 0; corner < 3; corner++) {
        double y = mesh->positions[3 * mesh->indices[3 * triangle + corner] + 1];
        low = fmin(low, y);
        high = fmax(high, y);
    }
    double first = floor((low - v->grid->origin_m[1]) / v->grid->voxel_m);
    double last = floor((high - v->grid->origin_m[1]) / v->grid->voxel_m);
    if (last < 0 || first >= v->grid->size[1]) return false;
    range[0] = (uint32_t)fmax(first, 0);
    range[1] = (uint32_t)fmin(last, v->grid->size[1] - 1);
    return true;
}

static bool list_by_row(const voxeliser *v, const al_triangles *mesh, solid *out)
{
    uint32_t rows = v->grid->size[1], range[2];
    *out = (solid){.triangles = mesh};
    out->row_start = calloc(rows + 2, sizeof *out->row_start);
    if (!out->row_start) return false;
    for (uint32_t t = 0; t < mesh->triangle_count; t++)
        if (row_range(v, mesh, t, range))
            for (uint32_t row = range[0]; row <= range[1]; row++) out->row_start[row + 2]++;
    for (uint32_t row = 0; row < rows; row++) out->row_start[row + 2] += out->row_start[row + 1];
    out->listed = malloc((out->row_start[rows + 1] + 1) * sizeof *out->listed);
    if (!out->listed) return false;
    for (uint32_t t = 0; t < mesh->triangle_count; t++)
        if (row_range(v, mesh, t, range))
            for (uint32_t row = range[0]; row <= range[1]; row++) out->listed[out->row_start[row + 1]++] = t;
    return true;
}

/* Twice the signed area of (a, b, p), the same number up to its sign for (b, a, p); 0 counts as positive in
 * the order of the indices. */
static double edge(const double *positions, uint32_t a, uint32_t b, double x, double y)
{
    double sign = a < b ? 1 : -1;
    const double *p = positions + 3 * (a < b ? a : b), *q = positions + 3 * (a < b ? b : a);
    double value = (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]);
    return sign * (value == 0 ? 1e-300 : value);
}

static void cut_line(const voxeliser *v, const double *positions, const uint32_t *corner, double x, double y,
                     float *line)
{
    double e0 = edge(positions, corner[1], corner[2], x, y);
    double e1 = edge(positions, corner[2], corner[0], x, y);
    double e2 = edge(positions, corner[0], corner[1], x, y);
    bool counter_clockwise = e0 > 0 && e1 > 0 && e2 > 0;
    if (!counter_clockwise && !(e0 < 0 && e1 < 0 && e2 < 0)) return;
    double z = (e0 * positions[3 * corner[0] + 2] + e1 * positions[3 * corner[1] + 2] +
                e2 * positions[3 * corner[2] + 2]) /
               (e0 + e1 + e2);
    double slab = (z - v->grid->origin_m[2]) / v->grid->voxel_m * v->slabs;
    double whole = fmin(fmax(floor(slab), 0), (double)v->grid->size[2] * v->slabs - 1);
    float step = counter_clockwise ? -1 : 1; /* a face that looks along +z is left */
    float share = (float)fmin(fmax(whole + 1 - slab, 0), 1);
    line[(size_t)whole] += step * share;
    line[(size_t)whole + 1] += step * (1 - share);
}

/* Shares of `body` on the lines of one row: `shares` [line_y][line_x][slabs of the grid + 1]. */
static void cut_row(const voxeliser *v, const solid *body, uint32_t row, float *shares)
{
    const al_triangles *mesh = body->triangles;
    size_t slabs = (size_t)v->grid->size[2] * v->slabs;
    int columns = (int)v->grid->size[0] * LINES;
    double pitch = v->grid->voxel_m / LINES;
    memset(shares, 0, (size_t)columns * LINES * (slabs + 1) * sizeof *shares);
    for (uint32_t n = body->row_start[row]; n < body->row_start[row + 1]; n++) {
        const uint32_t *corner = mesh->indices + 3 * body->listed[n];
        double low = INFINITY, high = -INFINITY;
        for (int i = 0; i < 3; i++) {
            low = fmin(low, mesh->positions[3 * corner[i]]);
            high = fmax(high, mesh->positions[3 * corner[i]]);
        }
        int first = (int)fmax(ceil((low - v->grid->origin_m[0]) / pitch - line_shift), 0);
        int last = (int)fmin(floor((high - v->grid->origin_m[0]) / pitch - line_shift), columns - 1);
        for (int line_y = 0; line_y < LINES; line_y++) {
            double y = v->grid->origin_m[1] + (row * (double)LINES + line_y + line_shift) * pitch;
            for (int line_x = first; line_x <= last; line_x++)
                cut_line(v, mesh->positions, corner, v->grid->origin_m[0] + (line_x + line_shift) * pitch, y,
                         shares + ((size_t)line_y * columns + line_x) * (slabs + 1));
        }
    }
    for (size_t line = 0; line < (size_t)columns * LINES; line++) {
        float *share = shares + line * (slabs + 1), sum = 0;
        for (size_t s = 0; s < slabs; s++) {
            sum += share[s];
            /* The running sum of floats returns to 0 only within rounding: 1e-5 of a slab is nothing. */
            share[s] = sum < 1e-5f ? 0 : sum > 1 ? 1 : sum;
        }
    }
}

static double density_at(const voxeliser *v, const double object[3])
{
    if (v->constant) return v->constant_density;
    double clamped[3], world[3];
    const double *m = v->field->to_world;
    for (int i = 0; i < 3; i++) clamped[i] = fmin(fmax(object[i], v->low[i]), v->high[i]);
    for (int i = 0; i < 3; i++)
        world[i] = m[i] * clamped[0] + m[4 + i] * clamped[1] + m[8 + i] * clamped[2] + m[12 + i];
    return al_density_at(v->field->density, world);
}

static void fill_voxel(const voxeliser *v, uint32_t x, uint32_t y, uint32_t z, const float *inside,
                       const float *opaque)
{
    al_grid *grid = v->grid;
    size_t slabs = (size_t)grid->size[2] * v->slabs, columns = (size_t)grid->size[0] * LINES;
    unsigned cells = v->slabs, lines = LINES / cells;
    double density = 0, medium = 0, blocked = 0;
    for (unsigned cy = 0; cy < cells; cy++)
        for (unsigned cx = 0; cx < cells; cx++)
            for (unsigned cz = 0; cz < cells; cz++) {
                double weight = 0;
                for (unsigned ly = 0; ly < lines; ly++)
                    for (unsigned lx = 0; lx < lines; lx++) {
                        size_t line = (cy * lines + ly) * columns + x * LINES + cx * lines + lx;
                        size_t at = line * (slabs + 1) + (size_t)z * cells + cz;
                        double share = inside[at], block = opaque ? fmin(opaque[at], share) : 0;
                        weight += share - block;
                        blocked += block;
                    }
                if (weight <= 0) continue;
                double point[3] = {grid->origin_m[0] + (x + (cx + 0.5) / cells) * grid->voxel_m,
                                   grid->origin_m[1] + (y + (cy + 0.5) / cells) * grid->voxel_m,
                                   grid->origin_m[2] + (z + (cz + 0.5) / cells) * grid->voxel_m};
                density += weight * density_at(v, point);
                medium += weight;
            }
    double count = (double)LINES * LINES * cells;
    size_t at = ((size_t)z * grid->size[1] + y) * grid->size[0] + x;
    grid->density[at] = (float)(density / count);
    grid->inside[at] = medium > 0.5 * count;
    if (grid->blockers) grid->blockers[at] = (float)(blocked / count);
}

static bool voxelise_row(void *user, unsigned row, unsigned thread)
{
    const voxeliser *v = user;
    if (row == 0 || row + 1 == v->grid->size[1]) return true; /* the empty layer */
    float *inside = v->scratch + thread * v->scratch_size, *opaque = NULL;
    cut_row(v, &v->boundary, row, inside);
    if (v->grid->blockers) {
        opaque = inside + v->scratch_size / 2;
        cut_row(v, &v->blockers, row, opaque);
    }
    for (uint32_t z = 1; z + 1 < v->grid->size[2]; z++)
        for (uint32_t x = 1; x + 1 < v->grid->size[0]; x++) fill_voxel(v, x, row, z, inside, opaque);
    return true;
}

static void place_grid(voxeliser *v, const al_triangles *boundary, uint32_t resolution)
{
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, longest = 0;
    for (uint32_t i = 0; i < 3 * boundary->vertex_count; i++) {
        low[i % 3] = fmin(low[i % 3], boundary->positions[i]);
        high[i % 3] = fmax(high[i % 3], boundary->positions[i]);
    }
    for (int i = 0; i < 3; i++) longest = fmax(longest, high[i] - low[i]);
    double voxel = longest / resolution;
    v->grid->voxel_m = voxel;
    for (int i = 0; i < 3; i++) {
        uint32_t count = (uint32_t)fmax(1, ceil((high[i] - low[i]) / voxel - 1e-6));
        v->grid->size[i] = count + 2;
        v->grid->origin_m[i] = 0.5 * (low[i] + high[i]) - 0.5 * voxel * (count + 2);
        v->low[i] = low[i] + 1e-6 * (high[i] - low[i]);
        v->high[i] = high[i] - 1e-6 * (high[i] - low[i]);
    }
}

al_status al_grid_voxelise(const char *name, const al_triangles *boundary, const al_triangles *blockers,
                           const al_density_field *field, uint32_t resolution, unsigned threads,
                           al_grid *grid, al_error *error)
{
    *grid = (al_grid){0};
    voxeliser v = {.grid = grid, .field = field};
    al_status status = AL_OK;
    bool blocked = blockers && blockers->triangle_count > 0;
    threads = al_parallel_threads(threads);
    place_grid(&v, boundary, resolution);
    v.constant = al_density_is_constant(field->density);
    v.constant_density = al_density_max(field->density);
    v.slabs =
        !v.constant && al_density_detail_m(field->density) < 1.5 * grid->voxel_m ? SLABS_FINE : SLABS_COARSE;
    v.scratch_size =
        (blocked ? 2 : 1) * (size_t)grid->size[0] * LINES * LINES * ((size_t)grid->size[2] * v.slabs + 1);
    size_t count = al_grid_count(grid);
    grid->density = calloc(count, sizeof *grid->density);
    grid->inside = calloc(count, 1);
    if (blocked) grid->blockers = calloc(count, sizeof *grid->blockers);
    v.scratch = malloc(threads * v.scratch_size * sizeof *v.scratch);
    if (!grid->density || !grid->inside || (blocked && !grid->blockers) || !v.scratch ||
        !list_by_row(&v, boundary, &v.boundary) || (blocked && !list_by_row(&v, blockers, &v.blockers))) {
        status = al_fail(error, AL_IO,
                         "%s: out of memory for a grid of %u x %u x %u voxels; lower grid_resolution", name,
                         grid->size[0], grid->size[1], grid->size[2]);
        goto cleanup;
    }
    al_parallel(threads, grid->size[1], voxelise_row, &v);
    size_t inside = 0;
    for (size_t i = 0; i < count; i++) {
        grid->density_max = fmaxf(grid->density_max, grid->density[i]);
        inside += grid->inside[i];
    }
    if (inside == 0)
        status = al_fail(error, AL_BAD_INPUT,
                         "%s: no voxel of the grid lies inside the boundary (or its blockers fill it); raise "
                         "grid_resolution",
                         name);
    else if (grid->density_max <= 0)
        status = al_fail(error, AL_BAD_INPUT,
                         "%s: the medium has zero density everywhere inside the boundary; place its grid "
                         "inside or give a density",
                         name);
cleanup:
    free(v.scratch);
    free(v.boundary.row_start);
    free(v.boundary.listed);
    free(v.blockers.row_start);
    free(v.blockers.listed);
    if (status != AL_OK) al_grid_free(grid);
    return status;
}

void al_grid_free(al_grid *grid)
{
    free(grid->density);
    free(grid->blockers);
    free(grid->inside);
    *grid = (al_grid){0};
}
