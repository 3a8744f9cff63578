#include "gather_fog.h"

#include <math.h>
#include <stdlib.h>

/* Steps over the finest detail. In a grid the mean of many rays counts, not one ray: against half a voxel,
 * two voxels move the attenuated light of the reference room by 0.05 %, in a third of the time. */
static const double voxels_per_step = 2, layers_per_step = 0.5;

/* --- the media --- */

static al_fog_medium medium_of(const al_import *import, const al_fog *fog)
{
    const al_medium *from = &import->scene.media[fog->medium];
    const al_density *density = import->densities[fog->medium];
    al_density_type type = import->description->media[fog->medium].density.type;
    bool constant = type == AL_DENSITY_CONSTANT;
    double per_step = type == AL_DENSITY_GRID ? voxels_per_step : layers_per_step;
    double scale = constant ? al_density_max(density) : 1;
    al_fog_medium medium = {.density = constant ? NULL : density, .g = from->g, .step_m = INFINITY};
    if (al_density_detail_m(density) > 0) medium.step_m = al_density_detail_m(density) * per_step;
    medium.bounded = al_density_bounds(density, medium.low, medium.high);
    for (int c = 0; c < 3; c++) {
        medium.sigma_s_per_m[c] = scale * from->sigma_s_per_m[c];
        medium.sigma_t_per_m[c] = scale * ((double)from->sigma_s_per_m[c] + from->sigma_a_per_m[c]);
    }
    return medium;
}

static bool is_grey(const double v[3])
{
    return v[0] == v[1] && v[0] == v[2];
}

al_status al_fog_media_create(const al_import *import, al_fog_media *fog, al_error *error)
{
    *fog = (al_fog_media){.grey = true};
    fog->media = calloc(import->scene.fog_count + (size_t)1, sizeof *fog->media);
    if (!fog->media) return al_fail(error, AL_IO, "out of memory for the fog");
    for (uint32_t i = 0; i < import->scene.fog_count; i++) {
        al_fog_medium medium = medium_of(import, &import->scene.fogs[i]);
        const double *s = medium.sigma_s_per_m, *t = medium.sigma_t_per_m;
        if (!(t[0] + t[1] + t[2] > 0)) continue;
        fog->grey = fog->grey && is_grey(s) && is_grey(t);
        if (s[0] + s[1] + s[2] > 0) {
            fog->scatters = true;
            fog->g_limit = fmax(fog->g_limit, fabs(medium.g));
        }
        fog->media[fog->count++] = medium;
    }
    return AL_OK;
}

void al_fog_media_free(al_fog_media *fog)
{
    free(fog->media);
    *fog = (al_fog_media){0};
}

/* --- along a ray --- */

void al_fog_path_free(al_fog_path *path)
{
    free(path->cells);
    free(path->spans);
    *path = (al_fog_path){0};
}

/* Of most rays between surfaces the bounds hold both ends, so that nothing is to be divided. */
static bool holds(const al_fog_medium *medium, const al_ray *ray, double distance_m)
{
    bool inside = true;
    for (int k = 0; k < 3; k++) {
        double at = ray->origin[k] + distance_m * ray->direction[k];
        inside = inside & (at >= medium->low[k]) & (at <= medium->high[k]);
    }
    return inside;
}

/* Cuts [begin, end] to the medium's bounds; false when nothing is left. */
static bool clip(const al_fog_medium *medium, const al_ray *ray, double *begin_m, double *end_m)
{
    bool inside = !medium->bounded || (holds(medium, ray, *begin_m) && holds(medium, ray, *end_m));
    for (int k = 0; !inside && k < 3; k++) {
        double low = medium->low[k] - ray->origin[k], high = medium->high[k] - ray->origin[k];
        if (ray->direction[k] == 0) {
            if (low > 0 || high < 0) return false;
            continue;
        }
        double a = low / ray->direction[k], b = high / ray->direction[k];
        double nearer = a < b ? a : b, farther = a < b ? b : a;
        if (nearer > *begin_m) *begin_m = nearer;
        if (farther < *end_m) *end_m = farther;
    }
    return *begin_m < *end_m;
}

static double density_at(const al_fog_medium *medium, const al_ray *ray, double distance_m)
{
    double position[3];
    if (!medium->density) return 1;
    for (int k = 0; k < 3; k++) position[k] = ray->origin[k] + distance_m * ray->direction[k];
    return al_density_at(medium->density, position);
}

static al_fog_cell *push(al_fog_path *path)
{
    if (path->count == path->room) {
        uint32_t wanted = path->room ? 2 * path->room : 64;
        al_fog_cell *grown = realloc(path->cells, wanted * sizeof *grown);
        if (!grown) return NULL;
        path->cells = grown;
        path->room = wanted;
    }
    return &path->cells[path->count++];
}

/* Closes a cell: its place in the order is known only now. An empty one is taken back. */
static void finish_cell(al_fog_path *path, al_fog_cell *cell, double scattered_g)
{
    double scattering = cell->sigma_s_per_m[0] + cell->sigma_s_per_m[1] + cell->sigma_s_per_m[2];
    bool empty = true;
    cell->g = scattering > 0 ? scattered_g / scattering : 0;
    for (int c = 0; c < 3; c++) {
        cell->depth[c] = path->depth[c];
        if (!(cell->sigma_t_per_m[c] > 0)) continue; /* nothing times an endless way is nothing */
        empty = false;
        path->depth[c] += cell->sigma_t_per_m[c] * (cell->end_m - cell->begin_m);
    }
    if (empty) path->count--;
}

static bool is_within(const double span[2], double distance_m)
{
    return distance_m >= span[0] && distance_m <= span[1];
}

/* A cell of the media whose spans hold its middle. */
static bool push_cell(const al_fog_media *fog, const al_ray *ray, double from, double to, al_fog_path *path)
{
    double middle = isinf(to) ? from + 1 : 0.5 * (from + to), scattered_g = 0;
    al_fog_cell *cell = push(path);
    if (!cell) return false;
    *cell = (al_fog_cell){.begin_m = from, .end_m = to};
    for (uint32_t i = 0; i < fog->count; i++) {
        const al_fog_medium *medium = &fog->media[i];
        if (!is_within(path->spans + 2 * i, middle)) continue;
        double density = density_at(medium, ray, middle);
        for (int c = 0; c < 3; c++) {
            cell->sigma_s_per_m[c] += density * medium->sigma_s_per_m[c];
            cell->sigma_t_per_m[c] += density * medium->sigma_t_per_m[c];
            scattered_g += density * medium->sigma_s_per_m[c] * medium->g;
        }
    }
    finish_cell(path, cell, scattered_g);
    return true;
}

/* Steps that a stretch takes at a step length; an endless stretch of a varying medium is cut. */
static uint32_t step_count(double step_m, double from, double *to)
{
    if (isinf(step_m)) return 1;
    if (isinf(*to)) *to = from + AL_FOG_STEP_LIMIT * step_m;
    return (uint32_t)fmin(ceil(fmax((*to - from) / step_m, 1)), AL_FOG_STEP_LIMIT);
}

/* The cells between two neighbouring ends of spans: the same media all along. */
static bool push_stretch(const al_fog_media *fog, const al_ray *ray, double from, double to,
                         al_fog_path *path)
{
    double middle = isinf(to) ? from + 1 : 0.5 * (from + to), step_m = INFINITY;
    for (uint32_t i = 0; i < fog->count; i++)
        if (is_within(path->spans + 2 * i, middle)) step_m = fmin(step_m, fog->media[i].step_m);
    uint32_t count = step_count(step_m, from, &to);
    for (uint32_t i = 0; i < count; i++) {
        double begin_m = from + (to - from) * i / count, end_m = from + (to - from) * (i + 1) / count;
        if (!push_cell(fog, ray, count > 1 ? begin_m : from, count > 1 ? end_m : to, path)) return false;
    }
    return true;
}

/* The least end of a span beyond `from`. */
static double next_end(const al_fog_path *path, uint32_t media_count, double from)
{
    double next = INFINITY;
    for (uint32_t i = 0; i < 2 * media_count; i++)
        if (path->spans[i] > from) next = fmin(next, path->spans[i]);
    return next;
}

bool al_fog_along(const al_fog_media *fog, const al_ray *ray, double end_m, al_fog_path *path)
{
    double from = INFINITY, last = 0;
    path->count = 0;
    for (int c = 0; c < 3; c++) path->depth[c] = 0;
    if (!path->spans) path->spans = malloc(sizeof(double) * 2 * (fog->count + (size_t)1));
    if (!path->spans) return false;
    for (uint32_t i = 0; i < fog->count; i++) {
        double *span = path->spans + 2 * i;
        span[0] = 0, span[1] = end_m;
        if (!clip(&fog->media[i], ray, &span[0], &span[1])) span[0] = span[1] = -1; /* nowhere */
        if (span[0] >= 0) from = fmin(from, span[0]);
        last = fmax(last, span[1]);
    }
    while (from < last) {
        double to = next_end(path, fog->count, from);
        if (!push_stretch(fog, ray, from, to, path)) return false;
        from = to;
    }
    return true;
}

void al_fog_transmit(const al_fog_media *fog, const double depth[3], double transmittance[3])
{
    transmittance[0] = exp(-depth[0]);
    for (int c = 1; c < 3; c++) transmittance[c] = fog->grey ? transmittance[0] : exp(-depth[c]);
}

/* Optical depth per unit of sigma_t: the density's integral. */
static double length_of(const al_fog_medium *medium, const al_ray *ray, double from, double to)
{
    if (!medium->density) return to - from;
    uint32_t count = step_count(medium->step_m, from, &to);
    double step = (to - from) / count, sum = 0;
    for (uint32_t i = 0; i < count; i++) sum += density_at(medium, ray, from + (i + 0.5) * step);
    return sum * step;
}

void al_fog_transmittance(const al_fog_media *fog, const al_ray *ray, double end_m, double transmittance[3])
{
    double depth[3] = {0};
    for (uint32_t i = 0; i < fog->count; i++) {
        const al_fog_medium *medium = &fog->media[i];
        double from = 0, to = end_m;
        if (!clip(medium, ray, &from, &to)) continue;
        double length_m = length_of(medium, ray, from, to);
        for (int c = 0; c < 3; c++)
            if (medium->sigma_t_per_m[c] > 0) depth[c] += medium->sigma_t_per_m[c] * length_m;
    }
    al_fog_transmit(fog, depth, transmittance);
}

static al_fog_mean mean_of(const al_fog_path *path, double length_m)
{
    al_fog_mean mean = {.length_m = length_m};
    double scattered_g = 0, scattering = 0;
    if (!path->count) return mean;
    const al_fog_cell *last = &path->cells[path->count - 1];
    mean.length_m = fmin(length_m, isinf(length_m) ? last->end_m : length_m);
    for (uint32_t i = 0; i < path->count; i++) {
        const al_fog_cell *cell = &path->cells[i];
        double share = isinf(mean.length_m) ? cell == last : (cell->end_m - cell->begin_m) / mean.length_m;
        for (int c = 0; c < 3; c++) {
            mean.sigma_s_per_m[c] += share * cell->sigma_s_per_m[c];
            mean.sigma_t_per_m[c] += share * cell->sigma_t_per_m[c];
            scattering += share * cell->sigma_s_per_m[c];
            scattered_g += share * cell->sigma_s_per_m[c] * cell->g;
        }
    }
    mean.g = scattering > 0 ? scattered_g / scattering : 0;
    return mean;
}

/* The mean of one constant medium. */
static void take_mean(const al_fog_medium *medium, const al_ray *ray, double length_m, double depth[3],
                      al_fog_mean *mean)
{
    double from = 0, to = length_m;
    bool inside = clip(medium, ray, &from, &to);
    mean->length_m = isinf(length_m) && inside ? to : length_m;
    mean->g = medium->g;
    double share = !inside                                            ? 0
                   : isinf(to) || (from == 0 && to == mean->length_m) ? 1
                                                                      : (to - from) / mean->length_m;
    for (int c = 0; c < 3; c++) {
        mean->sigma_s_per_m[c] = share * medium->sigma_s_per_m[c];
        mean->sigma_t_per_m[c] = share * medium->sigma_t_per_m[c];
        depth[c] = mean->sigma_t_per_m[c] > 0 ? medium->sigma_t_per_m[c] * (to - from) : 0;
    }
}

bool al_fog_mean_along(const al_fog_media *fog, const al_ray *ray, double length_m, al_fog_path *path,
                       double transmittance[3], al_fog_mean *mean)
{
    if (fog->count == 1 && !fog->media[0].density) {
        take_mean(&fog->media[0], ray, length_m, path->depth, mean);
    } else {
        if (!al_fog_along(fog, ray, length_m, path)) return false;
        *mean = mean_of(path, length_m);
    }
    al_fog_transmit(fog, path->depth, transmittance);
    return true;
}
