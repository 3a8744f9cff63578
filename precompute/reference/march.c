#include "march.h"

#include <math.h>
#include <stdlib.h>

#include "geometry.h"

enum { CELLS_PER_VOXEL = 4, LAYER_LIMIT = 1 << 20 };
static const double cell_depth = 0.05,
                    nothing_left = 50; /* optical depths: of a cell, where exp(-tau) is 2e-22 */

al_march_medium al_march_medium_of(const al_import *import, uint32_t index)
{
    const al_medium *from = &import->scene.media[index];
    al_march_medium medium = {.density = import->densities[index], .step_m = INFINITY, .g = from->g};
    medium.description = &import->description->media[index].density;
    al_density_voxels voxels;
    if (al_density_grid(medium.density, &voxels)) {
        medium.step_m = al_density_detail_m(medium.density) / CELLS_PER_VOXEL;
        al_matrix_invert(voxels.index_to_world, medium.to_index);
        for (int k = 0; k < 3; k++) medium.size[k] = voxels.size[k];
    }
    for (int c = 0; c < 3; c++) {
        medium.sigma_s_per_m[c] = from->sigma_s_per_m[c];
        medium.sigma_t_per_m[c] = (double)from->sigma_s_per_m[c] + from->sigma_a_per_m[c];
    }
    return medium;
}

static double density_at(const al_march_medium *medium, const al_ray *ray, double distance_m)
{
    double position[3];
    for (int k = 0; k < 3; k++) position[k] = ray->origin[k] + distance_m * ray->direction[k];
    return al_density_at(medium->density, position);
}

/* Cuts [begin, end] to the medium's bounds; false when nothing is left. */
static bool clip(const al_march_medium *medium, const al_ray *ray, double *begin_m, double *end_m)
{
    const al_density_description *from = medium->description;
    for (int k = 0; from->has_bounds && k < 3; k++) {
        double low = from->bounds_min_m[k] - ray->origin[k], high = from->bounds_max_m[k] - ray->origin[k];
        if (ray->direction[k] == 0) {
            if (low > 0 || high < 0) return false;
            continue;
        }
        double a = low / ray->direction[k], b = high / ray->direction[k];
        *begin_m = fmax(*begin_m, fmin(a, b));
        *end_m = fmin(*end_m, fmax(a, b));
    }
    return *begin_m < *end_m;
}

/* --- grids --- */

/* The planes at which a grid's density has a kink, in the order in which a ray meets them. Along each axis of
 * index space plane 0 is the box's lower face at -1/2, planes 1 to size the voxel centres, plane size + 1 the
 * upper face. */
typedef struct plane_walk {
    const uint32_t *size;
    double from[3], slope[3]; /* index = from + distance * slope */
    int64_t plane[3];         /* the next one of each axis */
} plane_walk;

static double plane_index(const plane_walk *w, int axis)
{
    int64_t plane = w->plane[axis];
    return plane == 0 ? -0.5 : plane > w->size[axis] ? w->size[axis] - 0.5 : (double)plane - 1;
}

/* The next planes are the first beyond begin_m. */
static plane_walk walk_planes(const al_march_medium *medium, const al_ray *ray, double begin_m)
{
    plane_walk w = {.size = medium->size};
    double ahead[3];
    al_matrix_point(medium->to_index, ray->origin, w.from);
    for (int k = 0; k < 3; k++) ahead[k] = ray->origin[k] + ray->direction[k];
    al_matrix_point(medium->to_index, ahead, w.slope);
    for (int k = 0; k < 3; k++) {
        w.slope[k] -= w.from[k];
        double x = fmin(fmax(w.from[k] + begin_m * w.slope[k], -1), w.size[k]), last = w.size[k];
        if (w.slope[k] > 0)
            w.plane[k] = x < -0.5 ? 0 : x >= last - 0.5 ? (int64_t)last + 2 : (int64_t)floor(x) + 2;
        else
            w.plane[k] = x > last - 0.5 ? (int64_t)last + 1 : x <= -0.5 ? -1 : (int64_t)ceil(x);
    }
    return w;
}

/* The distance of the next plane, INFINITY behind the last; goes on to the one behind it. */
static double next_plane(plane_walk *w)
{
    double nearest = INFINITY;
    int first = 0;
    for (int k = 0; k < 3; k++) {
        if (w->slope[k] == 0 || w->plane[k] < 0 || w->plane[k] > (int64_t)w->size[k] + 1) continue;
        double distance_m = (plane_index(w, k) - w->from[k]) / w->slope[k];
        if (distance_m < nearest) nearest = distance_m, first = k;
    }
    if (nearest < INFINITY) w->plane[first] += w->slope[first] > 0 ? 1 : -1;
    return nearest;
}

/* Between two planes: Gauss's rule of two points. */
static double cubic_length(const al_march_medium *medium, const al_ray *ray, double begin_m, double end_m)
{
    double middle = 0.5 * (begin_m + end_m), off = 0.5 * (end_m - begin_m) / sqrt(3);
    return 0.5 * (end_m - begin_m) *
           (density_at(medium, ray, middle - off) + density_at(medium, ray, middle + off));
}

static double grid_length(const al_march_medium *medium, const al_ray *ray, double begin_m, double end_m)
{
    plane_walk walk = walk_planes(medium, ray, begin_m);
    double sum = 0;
    for (double at = begin_m; at < end_m;) {
        double to = fmin(fmax(next_plane(&walk), at), end_m);
        sum += cubic_length(medium, ray, at, to);
        at = to;
    }
    return sum;
}

/* --- layers --- */

/* In periods: the layers' phase at a distance along the ray, and its slope. */
static double layer_phase(const al_density_description *from, const al_ray *ray, double distance_m,
                          double *slope)
{
    double along = 0;
    *slope = 0;
    for (int k = 0; k < 3; k++) {
        along += from->axis[k] * (ray->origin[k] + distance_m * ray->direction[k]);
        *slope += from->axis[k] * ray->direction[k] / from->period_m;
    }
    return (along - from->offset_m) / from->period_m;
}

/* The share of high layers between two phases: with f = thickness / period, the integral of the indicator
 * from 0 to p is floor(p) f + min(p - floor(p), f). */
static double layers_length(const al_march_medium *medium, const al_ray *ray, double begin_m, double end_m)
{
    const al_density_description *from = medium->description;
    double slope, share, f = fmin(from->thickness_m / from->period_m, 1);
    double a = layer_phase(from, ray, begin_m, &slope), b = layer_phase(from, ray, end_m, &slope);
    if (fabs(b - a) < 1e-9) return (end_m - begin_m) * density_at(medium, ray, 0.5 * (begin_m + end_m));
    share = (floor(b) - floor(a)) * f + fmin(b - floor(b), f) - fmin(a - floor(a), f);
    share = fmin(fmax(share / (b - a), 0), 1);
    return (end_m - begin_m) * from->scale * (from->low + share * (from->high - from->low));
}

double al_march_length(const al_march_medium *medium, const al_ray *ray, double begin_m, double end_m)
{
    if (!clip(medium, ray, &begin_m, &end_m)) return 0;
    if (medium->description->type == AL_DENSITY_LAYERS) return layers_length(medium, ray, begin_m, end_m);
    if (medium->size[0]) return grid_length(medium, ray, begin_m, end_m);
    return (end_m - begin_m) * density_at(medium, ray, 0.5 * (begin_m + end_m));
}

/* --- cells --- */

void al_cells_free(al_cells *cells)
{
    free(cells->cells);
    free(cells->parts);
    free(cells->breaks);
    free(cells->ends);
    *cells = (al_cells){0};
}

static bool make_room(void *array, uint32_t count, uint32_t *room, size_t size)
{
    if (count < *room) return true;
    uint32_t wanted = *room ? 2 * *room : 64;
    void *grown = wanted > *room ? realloc(*(void **)array, wanted * size) : NULL;
    if (!grown) return false;
    *(void **)array = grown;
    *room = wanted;
    return true;
}

static bool push(double **list, uint32_t *count, uint32_t *room, double value)
{
    if (!make_room(list, *count, room, sizeof **list)) return false;
    (*list)[(*count)++] = value;
    return true;
}

static bool push_break(al_cells *cells, double distance_m, double begin_m, double end_m)
{
    if (!(distance_m > begin_m && distance_m < end_m)) return true;
    return push(&cells->breaks, &cells->break_count, &cells->break_room, distance_m);
}

/* Where a layer begins or ends: phases k and k + f. */
static bool break_layers(const al_march_medium *medium, const al_ray *ray, double begin_m, double end_m,
                         al_cells *cells)
{
    const al_density_description *from = medium->description;
    double slope, f = from->thickness_m / from->period_m;
    double a = layer_phase(from, ray, begin_m, &slope), b = layer_phase(from, ray, end_m, &slope);
    if (fabs(b - a) < 1e-9 || fabs(b - a) > LAYER_LIMIT) return true;
    for (double k = floor(fmin(a, b)); k <= ceil(fmax(a, b)); k++)
        if (!push_break(cells, begin_m + (k - a) / slope, begin_m, end_m) ||
            !push_break(cells, begin_m + (k + f - a) / slope, begin_m, end_m))
            return false;
    return true;
}

/* Whether a piece of a grid holds too much for one cell, in a channel that has not died out before it. */
static bool too_thick(const al_march_medium *medium, double before_m, double piece_m)
{
    for (int c = 0; c < 3; c++)
        if (medium->sigma_t_per_m[c] * before_m < nothing_left &&
            medium->sigma_t_per_m[c] * piece_m > cell_depth)
            return true;
    return false;
}

/* Pieces are halved until they are thin enough; the next one starts out twice as long. */
static bool break_grid(const al_march_medium *medium, const al_ray *ray, double begin_m, double end_m,
                       al_cells *cells)
{
    plane_walk walk = walk_planes(medium, ray, begin_m);
    double plane = next_plane(&walk), step = medium->step_m, before = 0, shortest = 1e-14 * end_m;
    for (double at = begin_m; at < end_m;) {
        while (plane <= at) plane = next_plane(&walk);
        double to = fmin(fmin(at + step, plane), end_m), piece = cubic_length(medium, ray, at, to);
        if (to - at > shortest && too_thick(medium, before, piece)) {
            step = 0.5 * (to - at);
            continue;
        }
        if (to < end_m && !push(&cells->breaks, &cells->break_count, &cells->break_room, to)) return false;
        step = fmin(2 * fmax(step, shortest), medium->step_m);
        before += piece;
        at = to;
    }
    return true;
}

/* Distances within (begin, end) between which the medium's density is taken as constant. */
static bool break_medium(const al_march_medium *medium, const al_ray *ray, double begin_m, double end_m,
                         al_cells *cells)
{
    double first = begin_m, last = end_m;
    if (!clip(medium, ray, &first, &last)) return true;
    if (!push_break(cells, first, begin_m, end_m) || !push_break(cells, last, begin_m, end_m)) return false;
    if (medium->description->type == AL_DENSITY_LAYERS) return break_layers(medium, ray, first, last, cells);
    return !medium->size[0] || break_grid(medium, ray, first, last, cells);
}

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The breaks of one medium come nearly sorted: few of them move, and not far. */
static void sort_breaks(al_cells *cells, uint32_t media_count)
{
    double *list = cells->breaks;
    if (media_count > 1 && cells->break_count) {
        qsort(list, cells->break_count, sizeof *list, compare_doubles);
        return;
    }
    for (uint32_t i = 1; i < cells->break_count; i++) {
        double value = list[i];
        uint32_t k = i;
        for (; k > 0 && list[k - 1] > value; k--) list[k] = list[k - 1];
        list[k] = value;
    }
}

/* One cell, unless it is empty. */
static bool push_cell(const al_ray *ray, const al_march_part *parts, uint32_t count, double begin_m,
                      double end_m, al_cells *cells)
{
    if (!(begin_m < end_m)) return true;
    double middle = 0.5 * (begin_m + end_m);
    al_cell cell = {.begin_m = begin_m, .end_m = end_m, .first_part = cells->part_count};
    for (uint32_t i = 0; i < count; i++) {
        if (middle < parts[i].begin_m || middle > parts[i].end_m) continue;
        const al_march_medium *medium = parts[i].medium;
        double density = density_at(medium, ray, middle);
        if (density == 0) continue;
        if (!make_room(&cells->parts, cells->part_count, &cells->part_room, sizeof(al_cell_part)))
            return false;
        cells->parts[cells->part_count++] = (al_cell_part){medium, density};
        cell.part_count++;
        for (int c = 0; c < 3; c++) cell.sigma_t_per_m[c] += density * medium->sigma_t_per_m[c];
    }
    if (!cell.part_count) return true;
    if (!make_room(&cells->cells, cells->count, &cells->room, sizeof(al_cell))) return false;
    for (int c = 0; c < 3; c++) {
        cell.depth[c] = cells->depth[c];
        cells->depth[c] += (end_m - begin_m) * cell.sigma_t_per_m[c];
    }
    cells->cells[cells->count++] = cell;
    return true;
}

/* The cells between two neighbouring ends of parts: the same media all along. */
static bool cut_interval(const al_ray *ray, const al_march_part *parts, uint32_t count, double begin_m,
                         double end_m, al_cells *cells)
{
    uint32_t active = 0;
    double middle = 0.5 * (begin_m + end_m), from = begin_m;
    cells->break_count = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (middle < parts[i].begin_m || middle > parts[i].end_m) continue;
        active++;
        if (!break_medium(parts[i].medium, ray, begin_m, end_m, cells)) return false;
    }
    if (!active) return true;
    sort_breaks(cells, active);
    for (uint32_t i = 0; i <= cells->break_count; i++) {
        double to = i < cells->break_count ? cells->breaks[i] : end_m;
        if (!push_cell(ray, parts, count, from, to, cells)) return false;
        from = to;
    }
    return true;
}

bool al_march_cells(const al_ray *ray, const al_march_part *parts, uint32_t count, al_cells *cells)
{
    cells->count = cells->part_count = cells->end_count = 0;
    for (int c = 0; c < 3; c++) cells->depth[c] = 0;
    if (!count) return true;
    for (uint32_t i = 0; i < count; i++)
        if (!push(&cells->ends, &cells->end_count, &cells->end_room, parts[i].begin_m) ||
            !push(&cells->ends, &cells->end_count, &cells->end_room, parts[i].end_m))
            return false;
    qsort(cells->ends, cells->end_count, sizeof(double), compare_doubles);
    for (uint32_t i = 0; i + 1 < cells->end_count; i++)
        if (cells->ends[i] < cells->ends[i + 1] &&
            !cut_interval(ray, parts, count, cells->ends[i], cells->ends[i + 1], cells))
            return false;
    return true;
}
