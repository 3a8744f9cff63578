/* What a point x of the fog gets from the environment, in the direction w it arrives from:
 *   L(x, w) = L_sky(w) T(x, w) V(x, w),
 * T the transmittance of all fogs from x to outside, V 1 where no surface stands in the way. Scattered
 * towards the eye, on a ray of direction d, it is sigma_s J with J = integral of p(w . d) L(x, w) dw = sum
 * over l, m of g^l L_lm(x) Y_lm(d) for a Henyey-Greenstein phase function (its Legendre moments are g^l;
 * addition theorem), so that SH of L at a lattice of points is all the player asks for. Bands are kept until
 * |g|^l is below 1/20, at most AL_SKY_ORDER_LIMIT: that limit is the error in strongly forward fogs under a
 * sun.
 *
 * Between points light falls off like T does. So what is stored is -log of the light's mean transmittance,
 *   t(x) = -log (integral of L_sky T / integral of L_sky),
 * which surfaces have no part in, and L_lm exp(t), which then varies with visibility alone; both are read
 * trilinear. Where a fog of constant density is thick, the planes of points crowd towards its faces.
 *
 * Walls: points that see many backs of surfaces are inside something solid and left out. In a cell that
 * surfaces cut, each eighth takes those of the corners that all its test points see; where these are on two
 * sides of a wall, the corners of the darker side; where no corner is seen, the darkest one in air. Of these,
 * the most that lie in a cell, face or edge alone are kept: the player reads each with one look-up. So light
 * never passes a wall; the price is a dark skin, at most an eighth thick, on the lit side of a thin wall that
 * has a dark room behind it. */
#include "sky_light.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/formulas.h"
#include "airlight/program.h"
#include "airlight/sh.h"
#include "gather_fog.h"
#include "parallel.h"
#include "sky_regions.h"

enum { CELLS_LEAST = 8, CELLS_MOST = 32, REGIONS = 256, CORNERS = 8, LOOK_COUNT = 32, ALL_PLANES = 63 };
static const double band_limit = 0.05;  /* of |g|^l: what is left out is about half as much of the light */
static const double cell_depth = 0.1;   /* optical, wanted of the cells at the faces of a constant fog */
static const double grade_limit = 6;    /* al_graded_place */
static const double back_limit = 0.25;  /* of the sphere */
static const double depth_limit = 60;   /* optical; exp(-60) of the sky is nothing */
static const double inset_cells = 1e-3; /* of the outermost points: surfaces often end where the fog does */
static const double spread = 0.2; /* in cells, of an eighth's test points about its middle; 0.25 its face */

const char *al_sky_light_missing(const al_import *import, uint32_t fog)
{
    const al_scene *scene = &import->scene;
    const al_fog *f = &scene->fogs[fog];
    const float *s = scene->media[f->medium].sigma_s_per_m;
    if (!scene->environment.width) return "the scene has no environment light";
    if (!f->bounded) return "the fogs have no end: no environment light gets through";
    if (!(f->density * (s[0] + s[1] + s[2]) > 0)) return "no fog scatters";
    return NULL;
}

typedef struct making {
    al_medium_sky *sky;
    al_ray_scene *rays;
    al_fog_media fog;
    al_sky_region *regions;
    uint32_t region_count, points, cells, terms;
    double low[3], edge[3], power[3]; /* of the fog's bounds; of the whole sky */
    bool has_surfaces;
    bool *is_inside; /* [point] */
    float *values;   /* al_sky_light */
    uint8_t *planes;
    al_progress progress;
} making;

/* --- the lattice --- */

static void place_planes(making *m, const al_fog *fog, const al_medium *medium, const al_medium_info *info,
                         bool constant)
{
    double sigma_t = 0, longest = 0;
    for (int c = 0; c < 3; c++)
        sigma_t = fmax(sigma_t, fog->density * ((double)medium->sigma_s_per_m[c] + medium->sigma_a_per_m[c]));
    for (int k = 0; k < 3; k++) {
        m->low[k] = info->bounds_min_m[k];
        m->edge[k] = (double)info->bounds_max_m[k] - info->bounds_min_m[k];
        longest = fmax(longest, m->edge[k]);
    }
    m->points = m->cells = 1;
    for (int k = 0; k < 3; k++) {
        double depth = constant ? sigma_t * m->edge[k] : 0, low = 0, high = grade_limit;
        double wanted = fmax(CELLS_MOST * m->edge[k] / longest, depth / cell_depth);
        uint32_t cells = (uint32_t)ceil(fmin(fmax(wanted, CELLS_LEAST), CELLS_MOST) - 1e-6);
        for (int i = 0; i < 30 && depth > cell_depth * cells; i++) {
            double middle = 0.5 * (low + high);
            *(depth * al_graded_place(middle, 1.0 / cells) > cell_depth ? &low : &high) = middle;
        }
        m->sky->grade[k] = depth > cell_depth * cells ? (float)high : 0;
        m->sky->size[k] = cells + 1;
        m->points *= cells + 1;
        m->cells *= cells;
    }
}

/* At a place of the lattice, 0 to size - 1 along each axis. */
static void place_at(const making *m, const double at[3], double position[3])
{
    for (int k = 0; k < 3; k++) {
        double last = m->sky->size[k] - 1.0, in = fmin(fmax(at[k], inset_cells), last - inset_cells);
        position[k] = m->low[k] + m->edge[k] * al_graded_place(m->sky->grade[k], in / last);
    }
}

static void place_point(const making *m, uint32_t index, double position[3])
{
    double at[3];
    for (int k = 0; k < 3; index /= m->sky->size[k], k++) at[k] = index % m->sky->size[k];
    place_at(m, at, position);
}

/* The point at corner i of a cell. */
static uint32_t corner_of(const making *m, const uint32_t cell[3], int i)
{
    uint32_t index = 0;
    for (int k = 2; k >= 0; k--) index = index * m->sky->size[k] + cell[k] + (uint32_t)(i >> k & 1);
    return index;
}

static bool go_on(making *m, unsigned done, unsigned count, unsigned thread)
{
    if (al_program_cancelled()) return false;
    return thread || done % 16 || !al_progress_update(&m->progress, done, count);
}

/* --- light at the points --- */

static void look_around(making *m, uint32_t index, al_ray *ray)
{
    uint32_t backs = 0;
    al_surface_hit hit;
    for (uint32_t i = 0; i < LOOK_COUNT && m->has_surfaces; i++) {
        al_direction_set(LOOK_COUNT, i, ray->direction);
        if (al_ray_scene_hit(m->rays, ray, INFINITY, &hit))
            backs += !hit.front && !hit.material->double_sided;
    }
    m->is_inside[index] = backs > back_limit * LOOK_COUNT;
}

static bool light_point(void *user, unsigned index, unsigned thread)
{
    making *m = user;
    al_ray ray;
    double through[3] = {0}, sh[3][AL_SKY_TERMS_LIMIT] = {{0}}, transmittance[3];
    place_point(m, index, ray.origin);
    look_around(m, index, &ray);
    for (uint32_t r = 0; r < m->region_count && !m->is_inside[index]; r++) {
        const al_sky_region *region = &m->regions[r];
        memcpy(ray.direction, region->direction, sizeof ray.direction);
        al_fog_transmittance(&m->fog, &ray, INFINITY, transmittance);
        bool seen = !m->has_surfaces || !al_ray_scene_is_blocked(m->rays, &ray, INFINITY);
        for (int c = 0; c < 3; c++) {
            through[c] += transmittance[c] * region->power[c];
            for (uint32_t k = 0; k < m->terms && seen; k++) sh[c][k] += transmittance[c] * region->sh[c][k];
        }
    }
    for (int c = 0; c < 3; c++) {
        bool any = through[c] > 0 && m->power[c] > 0;
        double depth = any ? fmin(fmax(log(m->power[c] / through[c]), 0), depth_limit) : 0;
        m->values[3 * index + (size_t)c] = (float)depth;
        for (uint32_t k = 0; k < m->terms; k++)
            m->values[((k + (size_t)1) * m->points + index) * 3 + (size_t)c] = (float)(exp(depth) * sh[c][k]);
    }
    return go_on(m, index, m->points + m->cells, thread);
}

/* --- walls --- */

static bool is_seen(const making *m, const double from[3], uint32_t point)
{
    al_ray ray;
    double square = 0, to[3];
    place_point(m, point, to);
    for (int k = 0; k < 3; k++) {
        ray.origin[k] = from[k];
        ray.direction[k] = to[k] - from[k];
        square += ray.direction[k] * ray.direction[k];
    }
    for (int k = 0; k < 3; k++) ray.direction[k] /= sqrt(square);
    return !al_ray_scene_is_blocked(m->rays, &ray, sqrt(square));
}

/* One bit for each corner in air that a place of the cell, 0 to 1 along each axis, sees. */
static unsigned corners_seen(const making *m, const uint32_t cell[3], const double place[3])
{
    double at[3] = {cell[0] + place[0], cell[1] + place[1], cell[2] + place[2]}, position[3];
    unsigned seen = 0;
    place_at(m, at, position);
    for (int i = 0; i < CORNERS; i++) {
        uint32_t point = corner_of(m, cell, i);
        if (!m->is_inside[point] && is_seen(m, position, point)) seen |= 1u << i;
    }
    return seen;
}

/* Mean over the corners of the light they get, in arbitrary units. */
static double brightness(const making *m, const uint32_t cell[3], unsigned corners)
{
    double sum = 0;
    int count = 0;
    for (int i = 0; i < CORNERS; i++) {
        const float *depth = m->values + 3 * (size_t)corner_of(m, cell, i),
                    *mean = depth + 3 * (size_t)m->points;
        if (!(corners >> i & 1)) continue;
        for (int c = 0; c < 3; c++) sum += exp(-depth[c]) * mean[c];
        count++;
    }
    return sum / count;
}

static unsigned darkest_in_air(const making *m, const uint32_t cell[3])
{
    unsigned darkest = 0;
    for (int i = 0; i < CORNERS; i++) {
        if (m->is_inside[corner_of(m, cell, i)]) continue;
        if (!darkest || brightness(m, cell, 1u << i) < brightness(m, cell, darkest)) darkest = 1u << i;
    }
    return darkest ? darkest : 0xff; /* all inside, and black */
}

static unsigned corners_of_eighth(const making *m, const uint32_t cell[3], int eighth)
{
    unsigned common = 0xff, darker = 0;
    for (int test = 0; test < 8; test++) {
        double place[3];
        for (int k = 0; k < 3; k++)
            place[k] = (eighth >> k & 1 ? 0.75 : 0.25) + (test >> k & 1 ? spread : -spread);
        unsigned seen = corners_seen(m, cell, place);
        if (!seen) continue;
        common &= seen;
        if (!darker || brightness(m, cell, seen) < brightness(m, cell, darker)) darker = seen;
    }
    return !darker ? darkest_in_air(m, cell) : common ? common : darker;
}

/* The planes whose corners are the most of those given, all of them given; of several, ones with the eighth's
 * own corner. So the player reads them as it reads whole cells. */
static uint8_t planes_of(unsigned corners, int eighth)
{
    unsigned best = 0;
    int most = 0;
    for (unsigned planes = 1; planes <= ALL_PLANES; planes++) {
        int count = 0;
        for (int i = 0; i < CORNERS; i++) {
            unsigned own = ((unsigned)~i & 7) | (unsigned)i << 3;
            if ((planes & own) != own) continue;
            count += !(corners >> i & 1) ? -100 : i == eighth ? 3 : 2;
        }
        if (count > most) best = planes, most = count;
    }
    return (uint8_t)best;
}

static bool look_at_corners(void *user, unsigned number, unsigned thread)
{
    making *m = user;
    uint32_t cell[3], rest = number;
    uint8_t *out = m->planes + (size_t)CORNERS * number;
    bool open = true;
    for (int k = 0; k < 3; rest /= m->sky->size[k] - 1, k++) cell[k] = rest % (m->sky->size[k] - 1);
    for (int eighth = 0; eighth < 8 && open; eighth++) {
        double middle[3];
        for (int k = 0; k < 3; k++) middle[k] = eighth >> k & 1 ? 0.75 : 0.25;
        open = corners_seen(m, cell, middle) == 0xff;
    }
    for (int eighth = 0; eighth < 8; eighth++)
        out[eighth] = open ? ALL_PLANES : planes_of(corners_of_eighth(m, cell, eighth), eighth);
    return go_on(m, m->points + number, m->points + m->cells, thread);
}

/* --- all of it --- */

static al_status prepare(making *m, const al_import *import, uint32_t fog, const al_medium_info *info,
                         al_sky_light *light, al_error *error)
{
    const al_scene *scene = &import->scene;
    const al_fog *f = &scene->fogs[fog];
    const al_medium *medium = &scene->media[f->medium];
    double band = fabs(medium->g);
    m->sky = &light->sky;
    for (m->sky->order = 1; m->sky->order < AL_SKY_ORDER_LIMIT && band > band_limit; band *= fabs(medium->g))
        m->sky->order++;
    m->terms = m->sky->order * m->sky->order;
    place_planes(m, f, medium, info, !(al_density_detail_m(import->densities[f->medium]) > 0));
    al_status status = al_fog_media_create(import, &m->fog, error);
    if (!status) status = al_ray_scene_create(import, AL_RAY_SCENE_STILL, &m->rays, error);
    if (!status)
        status = al_sky_regions_create(&scene->environment, m->sky->order, REGIONS, &m->regions,
                                       &m->region_count, error);
    if (status) return status;
    for (uint32_t i = 0; i < m->region_count; i++)
        for (int c = 0; c < 3; c++) m->power[c] += m->regions[i].power[c];
    for (uint32_t i = 0; i < scene->instance_count; i++)
        m->has_surfaces = m->has_surfaces || al_ray_scene_triangle_count(m->rays, i) > 0;
    size_t count = (1 + (size_t)m->terms) * m->points * 3;
    m->is_inside = calloc(m->points, sizeof *m->is_inside);
    m->values = light->values = calloc(count, sizeof *m->values);
    if (m->has_surfaces) m->planes = light->planes = malloc(CORNERS * (size_t)m->cells);
    if (!m->is_inside || !m->values || (m->has_surfaces && !light->planes))
        return al_fail(error, AL_IO, "out of memory for the sky's light at %u points", m->points);
    return AL_OK;
}

al_status al_sky_light_make(const al_import *import, uint32_t fog, const al_medium_info *info,
                            const al_bake_options *options, al_sky_light *light, al_error *error)
{
    making m = {0};
    *light = (al_sky_light){0};
    al_status status = prepare(&m, import, fog, info, light, error);
    al_progress_begin(&m.progress, options->program, "sky light");
    if (!status && (!al_parallel(options->threads, m.points, light_point, &m) ||
                    (m.has_surfaces && !al_parallel(options->threads, m.cells, look_at_corners, &m))))
        status = al_fail(error, AL_CANCELLED, "cancelled while the sky's light was spread in the fog");
    al_progress_end(&m.progress);
    for (size_t i = 0; !status && i < CORNERS * (size_t)m.cells && m.has_surfaces; i++)
        light->sky.walled = light->sky.walled || light->planes[i] != ALL_PLANES;
    if (light->sky.walled) light->sky.planes = light->planes;
    if (status) al_sky_light_free(light);
    al_ray_scene_free(m.rays);
    al_fog_media_free(&m.fog);
    free(m.regions);
    free(m.is_inside);
    return status;
}

void al_sky_light_free(al_sky_light *light)
{
    free(light->values);
    free(light->planes);
    *light = (al_sky_light){0};
}
