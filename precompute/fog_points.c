/* L(x, w), the radiance that arrives at a point x of the fog, obeys
 *
 *   L(x, w) = T Lo(y, -w) + integral over [0, s] of T sigma_s J(x + t w, w) dt,   J = integral of p L,
 *
 * y where the ray meets a surface. Each point traces paths over surfaces (Lo) once; wherever such a path
 * crosses fog it takes one place at random and records what J there would count. With J interpolated between
 * the points, L is linear in itself, and Jacobi's iteration adds one order of scattering each time. Weights
 * add up to at most what absorption leaves: were all positive, it would have to converge as the light does.
 * Some are not, beside walls (below); light that grows is refused.
 *
 * L is kept as spherical harmonics. A Henyey-Greenstein phase function takes band l times g^l, so that bands
 * are kept until |g|^l is below 1/50, at most ORDER_LIMIT: isotropic fog keeps one number a channel.
 *
 * Points that see many backs of surfaces are inside something and left out. Between the points values are
 * trilinear over those of the eight corners that are seen from the middle of an eighth of the cell: light
 * does not leak through walls. In the place of a corner behind a wall stands what the two points before it
 * continue to. The scattered light alone is kept too, for surfaces to reflect. What comes straight from lamps
 * is not in L; their transmittance is kept beside it. */
#include "fog_points.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/formulas.h"
#include "airlight/sh.h"
#include "gather_path.h"
#include "parallel.h"

enum {
    POINTS_DEFAULT = 16,
    SAMPLES_LEAST = 32,
    SAMPLES_MOST = 128,
    ORDER_LIMIT = 6,
    ITERATION_LIMIT = 256,
    CORNERS = 8,
    ARRIVING_ORDER = 3,
    ARRIVING_TERMS = ARRIVING_ORDER * ARRIVING_ORDER,
    LOOK_COUNT = 32
};
static const double back_limit = 0.25;      /* of the sphere */
static const double margin_share = 0.1;     /* of the scene's diagonal, around its box */
static const double converged_share = 1e-3; /* of all light, still to come */
static const double depth_limit = 4;        /* optical, from point to point */
static const double edge_cells = 0.25;      /* around the lattice's box */

struct al_fog_points {
    const al_gather *gather;
    uint32_t size[3], count;
    double low[3], spacing_m[3]; /* of the lattice's cells; points are in their middles */
    double per_m[3];             /* 1 / spacing_m */
    uint32_t stride[3];          /* of a point's index */
    uint32_t order, terms;       /* SH bands, numbers a channel */
    uint32_t lamps;
    bool *is_inside;      /* something solid: left out */
    float *sh;            /* [point][channel][terms]; spread into left-out points at the end */
    float *arriving;      /* [point][channel][ARRIVING_TERMS], SH of scattered light alone */
    float *transmittance; /* [point][lamp][channel] */
    uint8_t *seen;        /* [cell][eighth]: one bit a corner; cells from -1 to size-1 */
    uint16_t *beyond;     /* [cell][eighth]: two bits a corner that is not seen, 1 + its axis_beyond or 0 */
};

bool al_fog_record_push(al_fog_records *records, const al_fog_record *record)
{
    if (records->count == records->room) {
        uint32_t wanted = records->room ? 2 * records->room : 256;
        al_fog_record *grown = realloc(records->list, wanted * sizeof *grown);
        if (!grown) return false;
        records->list = grown;
        records->room = wanted;
    }
    records->list[records->count++] = *record;
    return true;
}

/* --- the lattice --- */

static void fog_bounds(const al_fog_media *fog, double low[3], double high[3])
{
    for (int k = 0; k < 3; k++) low[k] = INFINITY, high[k] = -INFINITY;
    for (uint32_t i = 0; i < fog->count; i++)
        for (int k = 0; k < 3; k++) {
            low[k] = fmin(low[k], fog->media[i].bounded ? fog->media[i].low[k] : -INFINITY);
            high[k] = fmax(high[k], fog->media[i].bounded ? fog->media[i].high[k] : INFINITY);
        }
}

/* Of the surfaces and, for fog glows around them, of the point lamps, but at most a diagonal away. */
static void lit_bounds(const al_gather *gather, double low[3], double high[3])
{
    const al_scene *scene = gather->lights.scene;
    double diagonal = 0, least[3], most[3];
    al_ray_scene_bounds(gather->rays, low, high);
    for (int k = 0; k < 3; k++) diagonal += (high[k] - low[k]) * (high[k] - low[k]);
    for (int k = 0; k < 3; k++) least[k] = low[k] - sqrt(diagonal), most[k] = high[k] + sqrt(diagonal);
    for (uint32_t i = 0; i < scene->light_count; i++)
        for (int k = 0; k < 3 && scene->lights[i].type == AL_LIGHT_POINT; k++) {
            double at = fmin(fmax(scene->lights[i].vector[k], least[k]), most[k]);
            low[k] = fmin(low[k], at);
            high[k] = fmax(high[k], at);
        }
}

static void place_lattice(al_fog_points *points)
{
    const al_gather *gather = points->gather;
    double low[3], high[3], diagonal = 0, longest = 0, size[3];
    lit_bounds(gather, points->low, high);
    for (int k = 0; k < 3; k++) diagonal += (high[k] - points->low[k]) * (high[k] - points->low[k]);
    double margin_m = margin_share * sqrt(diagonal), fog_high[3];
    fog_bounds(&gather->fog, low, fog_high);
    for (int k = 0; k < 3; k++) {
        points->low[k] = fmax(low[k], points->low[k] - margin_m);
        size[k] = fmin(fog_high[k], high[k] + margin_m) - points->low[k];
        longest = fmax(longest, size[k]);
    }
    uint32_t wanted = gather->options.fog_points ? gather->options.fog_points : POINTS_DEFAULT;
    points->count = 1;
    for (int k = 0; k < 3; k++) {
        if (!(size[k] > 0)) size[k] = longest > 0 ? 1e-3 * longest : 1; /* fog and scene apart, or flat */
        points->size[k] = (uint32_t)fmax(1, ceil(wanted * fmin(1, size[k] / longest) - 1e-9));
        points->spacing_m[k] = size[k] / points->size[k];
        points->per_m[k] = 1 / points->spacing_m[k];
        points->stride[k] = points->count;
        points->count *= points->size[k];
    }
}

static uint32_t max_size(const al_fog_points *points)
{
    uint32_t largest = points->size[0];
    for (int k = 1; k < 3; k++)
        if (points->size[k] > largest) largest = points->size[k];
    return largest;
}

static void place_point(const al_fog_points *points, uint32_t index, double position[3])
{
    for (int k = 0; k < 3; k++) {
        position[k] = points->low[k] + (index % points->size[k] + 0.5) * points->spacing_m[k];
        index /= points->size[k];
    }
}

static uint32_t cell_count(const al_fog_points *points)
{
    return (points->size[0] + 1) * (points->size[1] + 1) * (points->size[2] + 1);
}

/* The corner of a cell; beyond the lattice its outermost points stand in. */
static uint32_t corner_of(const al_fog_points *points, const int32_t cell[3], int corner)
{
    uint32_t index = 0;
    for (int k = 2; k >= 0; k--) {
        int32_t at = cell[k] + (corner >> k & 1), last = (int32_t)points->size[k] - 1;
        index = index * points->size[k] + (uint32_t)(at < 0 ? 0 : at > last ? last : at);
    }
    return index;
}

/* What a place takes from the points around it: the corners of its cell first, then what some continue to. */
typedef struct corners {
    uint32_t index[2 * CORNERS];
    double weight[2 * CORNERS];
    int count;
    bool outside; /* of the lattice's box, whose nearest place stands in */
} corners;

/* The axis along which a hidden corner is continued from the two points before it, 0 to 2; -1: none. */
static int axis_beyond(uint16_t beyond, int corner)
{
    return (beyond >> 2 * corner & 3) - 1;
}

/* One bit for each corner in air, or all where none is. */
static uint8_t corners_in_air(const al_fog_points *points, const int32_t cell[3])
{
    uint8_t air = 0;
    for (int i = 0; i < CORNERS; i++) air |= (uint8_t)(!points->is_inside[corner_of(points, cell, i)] << i);
    return air ? air : 0xff;
}

/* Where a place lies among the points. */
typedef struct spot {
    int32_t cell[3];
    uint32_t eighth; /* [cell][eighth] as in `seen` */
} spot;

/* All corners with their trilinear weights. */
static void take_all(const al_fog_points *points, const double position[3], spot *s, corners *c)
{
    uint32_t eighth = 0, number = 0, first = 0, up[3];
    double share[3];
    c->outside = false;
    for (int k = 2; k >= 0; k--) {
        double at = (position[k] - points->low[k]) * points->per_m[k] + 0.5, end = points->size[k] + 0.5;
        double inside = !(at > 0.5) ? 0.5 : at > end ? end : at;
        int32_t cell = (int32_t)inside - 1, last = (int32_t)points->size[k] - 1;
        c->outside |= inside != at;
        share[k] = inside - (cell + 1);
        first += cell > 0 ? points->stride[k] * (uint32_t)cell : 0;
        up[k] = cell >= 0 && cell < last ? points->stride[k] : 0;
        eighth = eighth << 1 | (share[k] >= 0.5);
        number = number * (points->size[k] + 1) + (uint32_t)(cell + 1);
        s->cell[k] = cell;
    }
    s->eighth = number * CORNERS + eighth;
    for (int i = 0; i < 4; i++) {
        uint32_t index = first + (i & 1 ? up[1] : 0) + (i & 2 ? up[2] : 0);
        double weight = (i & 1 ? share[1] : 1 - share[1]) * (i & 2 ? share[2] : 1 - share[2]);
        c->index[2 * i] = index;
        c->index[2 * i + 1] = index + up[0];
        c->weight[2 * i] = weight * (1 - share[0]);
        c->weight[2 * i + 1] = weight * share[0];
    }
    c->count = CORNERS;
}

/* Leaves those that are taken and puts what others continue to, 2 before - next, in their places. The share
 * of all that is left. */
static double take_some(const al_fog_points *points, const spot *s, uint8_t taken, corners *c)
{
    uint16_t beyond = points->beyond[s->eighth];
    double left = 1;
    for (int i = 0; i < CORNERS; i++) {
        double weight = c->weight[i];
        if (taken >> i & 1) continue;
        c->weight[i] = 0;
        int k = axis_beyond(beyond, i);
        if (k < 0) {
            left -= weight;
            continue;
        }
        int before = i ^ 1 << k;
        uint32_t next = c->index[before];
        if (i >> k & 1)
            next -= s->cell[k] > 0 ? points->stride[k] : 0;
        else
            next += s->cell[k] + 2 < (int32_t)points->size[k] ? points->stride[k] : 0;
        c->weight[before] += 2 * weight;
        c->index[c->count] = next;
        c->weight[c->count++] = -weight;
    }
    double scale = left > 1e-6 ? 1 / left : 0;
    for (int i = 0; i < c->count && left < 1; i++) c->weight[i] *= scale;
    return left;
}

/* False where no corner is seen; then all that are in air count, or all where none is. */
static bool find_corners(const al_fog_points *points, const double position[3], corners *c)
{
    spot s;
    take_all(points, position, &s, c);
    uint8_t seen = points->seen[s.eighth];
    if (seen == 0xff) return true;
    double left = take_some(points, &s, seen ? seen : corners_in_air(points, s.cell), c);
    return seen && left > 1e-6;
}

/* Beyond the lattice light thins out as it does around a body of its size. */
static double thinning(const al_fog_points *points, const double position[3])
{
    double away = 0, size = 0;
    for (int k = 0; k < 3; k++) {
        double edge = points->spacing_m[k] * points->size[k], in = position[k] - points->low[k];
        double off = in < 0 ? -in : in > edge ? in - edge : 0;
        away += off * off;
        size += 0.25 * edge * edge;
    }
    double factor = 1 / (1 + sqrt(away / size));
    return factor * factor;
}

/* One number a channel, as isotropic fog keeps. A fourth is read and dropped, so that one instruction serves
 * all channels: the list is one longer than its numbers. */
static void add_means(const float *sh, const corners *c, double sums[3])
{
    float lanes[4] = {0};
    for (int i = 0; i < c->count; i++) {
        float from[4], weight = (float)c->weight[i];
        memcpy(from, sh + (size_t)c->index[i] * 3, sizeof from);
        for (int k = 0; k < 4; k++) lanes[k] += weight * from[k];
    }
    for (int k = 0; k < 3; k++) sums[k] = 0.28209479177387814 * lanes[k];
}

static void add_bands(const al_fog_points *points, const float *sh, const corners *c,
                      const double direction[3], double g, double sums[3])
{
    double basis[AL_SH_MAX_COUNT], band = 1;
    al_sh_basis((int)points->order, direction[0], direction[1], direction[2], basis);
    for (uint32_t l = 0; l < points->order; l++, band *= g)
        for (uint32_t k = l * l; k < (l + 1) * (l + 1); k++) basis[k] *= band;
    for (int i = 0; i < c->count; i++) {
        const float *from = sh + (size_t)c->index[i] * 3 * points->terms;
        for (int channel = 0; channel < 3; channel++, from += points->terms) {
            double sum = 0;
            for (uint32_t k = 0; k < points->terms; k++) sum += basis[k] * from[k];
            sums[channel] += c->weight[i] * sum;
        }
    }
}

/* The same as al_fog_points_scatter, from any set of coefficients. */
static void scatter(const al_fog_points *points, const float *sh, const double position[3],
                    const double direction[3], double g, double radiance[3])
{
    double sums[3] = {0};
    corners c;
    find_corners(points, position, &c);
    if (points->order == 1)
        add_means(sh, &c, sums);
    else
        add_bands(points, sh, &c, direction, g, sums);
    double factor = c.outside ? thinning(points, position) : 1;
    /* Few bands of a narrow lobe may swing below 0. */
    for (int k = 0; k < 3; k++) radiance[k] = sums[k] > 0 ? factor * sums[k] : 0;
}

void al_fog_points_scatter(const al_fog_points *points, const double position[3], const double direction[3],
                           double g, double radiance[3])
{
    scatter(points, points->sh, position, direction, g, radiance);
}

double al_fog_points_cell_m(const al_fog_points *points)
{
    return fmax(fmax(points->spacing_m[0], points->spacing_m[1]), points->spacing_m[2]);
}

static bool is_seen(const al_gather *gather, const double from[3], const double to[3])
{
    al_ray ray;
    double square = 0;
    for (int k = 0; k < 3; k++) {
        ray.origin[k] = from[k];
        ray.direction[k] = to[k] - from[k];
        square += ray.direction[k] * ray.direction[k];
    }
    for (int k = 0; k < 3; k++) ray.direction[k] /= sqrt(square);
    return !al_ray_scene_is_blocked(gather->rays, &ray, sqrt(square));
}

/* The middle of the eighth of a cell that holds a place. */
static void middle_of_eighth(const al_fog_points *points, const double position[3], double middle[3])
{
    for (int k = 0; k < 3; k++) {
        double half_m = 0.5 * points->spacing_m[k];
        middle[k] = points->low[k] + (floor((position[k] - points->low[k]) / half_m) + 0.5) * half_m;
    }
}

static bool is_within(const al_fog_points *points, const double position[3])
{
    for (int k = 0; k < 3; k++) {
        double at = (position[k] - points->low[k]) / points->spacing_m[k];
        if (!(at >= -edge_cells && at <= points->size[k] + edge_cells)) return false;
    }
    return true;
}

bool al_fog_points_lamp(const al_fog_points *points, uint32_t lamp, const double position[3],
                        double transmittance[3])
{
    corners c;
    if (!is_within(points, position) || !find_corners(points, position, &c)) return false;
    transmittance[0] = transmittance[1] = transmittance[2] = 0;
    for (int i = 0; i < c.count; i++) {
        const float *t = points->transmittance + ((size_t)c.index[i] * points->lamps + lamp) * 3;
        for (int k = 0; k < 3; k++) transmittance[k] += c.weight[i] * t[k];
    }
    for (int k = 0; k < 3; k++) transmittance[k] = fmin(fmax(transmittance[k], 0), 1);
    return true;
}

/* The clamped cosine's coefficients are pi, 2 pi/3 and pi/4. */
bool al_fog_points_irradiance(const al_fog_points *points, const double position[3], const double normal[3],
                              double irradiance[3])
{
    double basis[AL_SH_MAX_COUNT], off[3], before[3], middle[3];
    corners c;
    for (int k = 0; k < 3; k++) {
        off[k] = position[k] + 1e-3 * points->spacing_m[k] * normal[k];
        before[k] = position[k] + 0.5 * points->spacing_m[k] * normal[k];
    }
    if (!is_within(points, position) || !find_corners(points, before, &c)) return false;
    middle_of_eighth(points, before, middle);
    if (!is_seen(points->gather, off, middle)) return false;
    al_sh_basis(ARRIVING_ORDER, normal[0], normal[1], normal[2], basis);
    for (int k = 0; k < ARRIVING_TERMS; k++) basis[k] *= k < 1 ? AL_PI : k < 4 ? 2 * AL_PI / 3 : AL_PI / 4;
    for (int channel = 0; channel < 3; channel++) {
        double sum = 0;
        for (int i = 0; i < c.count; i++) {
            const float *from =
                points->arriving + ((size_t)c.index[i] * 3 + (size_t)channel) * ARRIVING_TERMS;
            double part = 0;
            for (int k = 0; k < ARRIVING_TERMS; k++) part += basis[k] * from[k];
            sum += c.weight[i] * part;
        }
        irradiance[channel] = sum > 0 ? sum : 0;
    }
    return true;
}

/* --- building --- */

typedef struct building {
    al_fog_points *points;
    const al_gather *gather;
    al_gather_scratch **scratches; /* [thread] */
    al_fog_records *records;       /* [point] */
    /* [point][channel][terms]: without fog's own light; straight from lights; of the next step */
    float *fixed, *straight, *next;
    bool *known; /* [point]: has a value of its own, or was given one */
    uint32_t samples;
    double done, total; /* pieces of work of all passes, about */
    bool cancelled;
    bool grows; /* the light of the points never settles */
} building;

/* Counts a piece; only the caller's thread asks whether to stop. */
static bool go_on(building *b, unsigned piece, unsigned count, unsigned thread)
{
    const al_gather_options *options = &b->gather->options;
    if (thread || !options->on_progress || piece % 16) return true;
    b->cancelled = options->on_progress(options->user, b->done + (double)piece / count, b->total);
    return !b->cancelled;
}

/* Whether many directions meet the back of a one-sided surface. */
static bool look_around(void *user, unsigned index, unsigned thread)
{
    building *b = user;
    uint32_t backs = 0;
    al_ray ray;
    al_surface_hit hit;
    place_point(b->points, index, ray.origin);
    for (uint32_t i = 0; i < LOOK_COUNT; i++) {
        al_direction_set(LOOK_COUNT, i, ray.direction);
        if (al_ray_scene_hit(b->gather->rays, &ray, INFINITY, &hit))
            backs += !hit.front && !hit.material->double_sided;
    }
    b->points->is_inside[index] = backs > back_limit * LOOK_COUNT;
    return go_on(b, index, b->points->count, thread);
}

static bool look_at_lamps(void *user, unsigned index, unsigned thread)
{
    building *b = user;
    al_fog_points *points = b->points;
    al_ray ray;
    place_point(points, index, ray.origin);
    for (uint32_t lamp = 0; lamp < points->lamps; lamp++) {
        float *out = points->transmittance + ((size_t)index * points->lamps + lamp) * 3;
        al_light_sample light;
        double transmittance[3] = {1, 1, 1};
        if (al_gather_lamp(&b->gather->lights, lamp, ray.origin, &light)) {
            for (int k = 0; k < 3; k++) ray.direction[k] = light.direction[k];
            al_fog_transmittance(&b->gather->fog, &ray, light.distance_m, transmittance);
            if (!al_gather_light_is_seen(&b->gather->lights, ray.origin, &light))
                transmittance[0] = transmittance[1] = transmittance[2] = 0;
        }
        for (int k = 0; k < 3; k++) out[k] = (float)transmittance[k];
    }
    return go_on(b, index, points->count, thread);
}

static bool look_at_corners(void *user, unsigned number, unsigned thread)
{
    building *b = user;
    al_fog_points *points = b->points;
    int32_t cell[3];
    uint32_t rest = number;
    for (int k = 0; k < 3; k++) {
        cell[k] = (int32_t)(rest % (points->size[k] + 1)) - 1;
        rest /= points->size[k] + 1;
    }
    for (int eighth = 0; eighth < CORNERS; eighth++) {
        double middle[3], corner[3];
        uint8_t mask = 0;
        for (int k = 0; k < 3; k++)
            middle[k] =
                points->low[k] + (cell[k] + 0.5 + (eighth >> k & 1 ? 0.75 : 0.25)) * points->spacing_m[k];
        for (int i = 0; i < CORNERS; i++) {
            uint32_t index = corner_of(points, cell, i);
            place_point(points, index, corner);
            if (!points->is_inside[index] && is_seen(b->gather, middle, corner)) mask |= (uint8_t)(1 << i);
        }
        points->seen[(size_t)number * CORNERS + (size_t)eighth] = mask;
    }
    return go_on(b, number, cell_count(points), thread);
}

/* A corner behind a wall is continued from the one before it and the next in line, where both are seen from
 * this side: in the next cell the first of them stands where the corner stands in its own. */
static bool look_beyond(void *user, unsigned number, unsigned thread)
{
    building *b = user;
    al_fog_points *points = b->points;
    uint32_t stride = 1, rest = number;
    for (int k = 0; k < 3; rest /= points->size[k] + 1, stride *= points->size[k] + 1, k++)
        for (uint32_t place = number * CORNERS; place < (number + 1) * CORNERS; place++)
            for (int i = 0; i < CORNERS; i++) {
                uint32_t at = rest % (points->size[k] + 1), side = (uint32_t)i >> k & 1;
                if (points->seen[place] >> i & 1 || !(points->seen[place] >> (i ^ 1 << k) & 1)) continue;
                if (points->beyond[place] >> 2 * i & 3 || (side ? at == 0 : at == points->size[k])) continue;
                uint32_t eighth = (place % CORNERS & ~(1u << k)) | side << k;
                uint8_t next = points->seen[(side ? number - stride : number + stride) * CORNERS + eighth];
                if (next >> i & 1 && next >> (i ^ 1 << k) & 1)
                    points->beyond[place] |= (uint16_t)((k + 1) << 2 * i);
            }
    return go_on(b, number, cell_count(points), thread);
}

/* Adds radiance from a direction, times solid angle. */
static void project(uint32_t order, const double direction[3], const double power[3], float *sh)
{
    double basis[AL_SH_MAX_COUNT];
    uint32_t terms = order * order;
    al_sh_basis((int)order, direction[0], direction[1], direction[2], basis);
    for (uint32_t c = 0; c < 3; c++)
        for (uint32_t k = 0; k < terms; k++) sh[c * terms + k] += (float)(basis[k] * power[c]);
}

static void add_lights(building *b, al_gather_scratch *scratch, const al_gather_vertex *vertex,
                       al_sequence *sequence, float *straight)
{
    for (int kind = AL_LIGHT_KIND_EMITTER; kind < AL_LIGHT_KIND_COUNT; kind++) {
        al_gather_straight found;
        double power[3];
        if (!al_gather_look(b->gather, scratch, vertex, (al_light_kind)kind, sequence, &found)) continue;
        for (int c = 0; c < 3; c++)
            power[c] =
                found.share * found.light.power[c] * found.light.facing * found.transmittance[c] / b->samples;
        project(b->points->order, found.light.direction, power, straight);
    }
}

static bool trace_path(building *b, al_gather_scratch *scratch, const al_gather_vertex *vertex,
                       uint32_t index, al_sequence *sequence)
{
    double u[2], straight[3], others[3], scattered[3], carried[3];
    al_gather_way way;
    way.asks = false;
    way.scatters = true;
    way.places = 0; /* recorded instead */
    way.surfaces = true;
    al_sequence_pair(sequence, u);
    al_gather_draw(vertex, u, way.ray.direction, &way.density_per_sr);
    al_gather_origin(vertex, way.ray.direction, way.ray.origin);
    uint32_t before = b->records[index].count;
    for (int c = 0; c < 3; c++) carried[c] = 1 / (way.density_per_sr * b->samples);
    if (!al_gather_follow(b->gather, scratch, b->gather->options.bounces, carried, 1, sequence, &way))
        return false;
    for (uint32_t i = before; i < b->records[index].count; i++)
        for (int k = 0; k < 3; k++) b->records[index].list[i].first[k] = (float)way.ray.direction[k];
    for (int c = 0; c < 3; c++) {
        straight[c] = carried[c] * way.transmittance[c] * way.emitted[c];
        others[c] = carried[c] * (way.transmittance[c] * (way.sent[AL_GATHER_TOTAL][c] - way.emitted[c]) +
                                  way.scattered[c]);
        scattered[c] = carried[c] * (way.transmittance[c] *
                                         (way.sent[AL_GATHER_TOTAL][c] - way.sent[AL_GATHER_ATTENUATED][c]) +
                                     way.scattered[c]);
    }
    size_t at = (size_t)index * 3 * b->points->terms;
    project(b->points->order, way.ray.direction, straight, b->straight + at);
    project(b->points->order, way.ray.direction, others, b->fixed + at);
    project(ARRIVING_ORDER, way.ray.direction, scattered,
            b->points->arriving + (size_t)index * 3 * ARRIVING_TERMS);
    return true;
}

static bool trace_point(void *user, unsigned index, unsigned thread)
{
    building *b = user;
    al_gather_scratch *scratch = b->scratches[thread];
    al_gather_vertex vertex = {.in_air = true, .scatters = true};
    place_point(b->points, index, vertex.position);
    scratch->record = &b->records[index];
    for (uint32_t i = 0; i < b->samples && !b->points->is_inside[index]; i++) {
        al_sequence sequence = {.index = i,
                                .seed = al_mix_bits(index + ((uint64_t)b->gather->options.seed << 32))};
        add_lights(b, scratch, &vertex, &sequence, b->straight + (size_t)index * 3 * b->points->terms);
        if (!trace_path(b, scratch, &vertex, index, &sequence)) return false;
    }
    return go_on(b, index, b->points->count, thread);
}

/* Adds what the fog scatters into a point's paths. */
static void add_records(const building *b, unsigned index, uint32_t order, float *sh)
{
    const al_fog_records *records = &b->records[index];
    for (uint32_t i = 0; i < records->count && !b->points->is_inside[index]; i++) {
        const al_fog_record *r = &records->list[i];
        double position[3], direction[3], first[3], radiance[3];
        for (int k = 0; k < 3; k++) {
            position[k] = r->position[k];
            direction[k] = r->direction[k];
            first[k] = r->first[k];
        }
        scatter(b->points, b->points->sh, position, direction, r->g, radiance);
        for (int k = 0; k < 3; k++) radiance[k] *= r->weight[k];
        project(order, first, radiance, sh);
    }
}

/* One step of the iteration at one point. */
static bool collect(void *user, unsigned index, unsigned thread)
{
    building *b = user;
    size_t numbers = 3 * (size_t)b->points->terms, at = index * numbers;
    for (size_t k = 0; k < numbers; k++) b->next[at + k] = b->fixed[at + k] + b->straight[at + k];
    add_records(b, index, b->points->order, b->next + at);
    return go_on(b, index, b->points->count, thread);
}

/* Light that goes through the fog's last event on the way to a point, when all of it is known. */
static bool collect_arriving(void *user, unsigned index, unsigned thread)
{
    building *b = user;
    add_records(b, index, ARRIVING_ORDER, b->points->arriving + (size_t)index * 3 * ARRIVING_TERMS);
    return go_on(b, index, b->points->count, thread);
}

/* Fluence of all points that count in one channel, but for a factor. */
static double all_light(const al_fog_points *points, const float *sh, size_t c)
{
    double sum = 0;
    for (uint32_t i = 0; i < points->count; i++)
        sum += points->is_inside[i] ? 0 : sh[(i * 3 + c) * points->terms];
    return sum;
}

/* Change of a step in one channel, summed over all points that count. */
static double all_change(const al_fog_points *points, const float *from, const float *to, size_t c)
{
    double sum = 0;
    for (uint32_t i = 0; i < points->count; i++) {
        size_t at = (i * 3 + c) * points->terms;
        sum += points->is_inside[i] ? 0 : fabs((double)to[at] - from[at]);
    }
    return sum;
}

/* Puts F + f A L(n) in the place of F + A L(n), one channel. */
static void rebalance(building *b, size_t c)
{
    const al_fog_points *points = b->points;
    double fixed = all_light(points, b->fixed, c) + all_light(points, b->straight, c);
    double light = all_light(points, points->sh, c), answer = all_light(points, b->next, c) - fixed;
    if (!(light > answer)) return;
    for (uint32_t i = 0; i < points->count; i++)
        for (size_t k = 0; k < points->terms; k++) {
            size_t at = (i * 3 + c) * points->terms + k;
            double source = (double)b->fixed[at] + b->straight[at];
            b->next[at] = (float)(source + fixed / (light - answer) * (b->next[at] - source));
        }
}

/* With L(n+1) = F + A L(n), thick fog would take very many steps to fill. So each step is rebalanced as
 * neutron transport is (whole-system rebalance, Lewis and Miller 1984): L(n+1) = F + f A L(n), f such that f
 * L(n) as a whole would balance, f sum L = sum F + f sum A L. The fixed point stays the same. Changes fall
 * like a geometric series: what is still to come is change * ratio / (1 - ratio). */
static bool iterate(building *b)
{
    al_fog_points *points = b->points;
    size_t numbers = 3 * (size_t)points->terms * points->count;
    double before[3] = {INFINITY, INFINITY, INFINITY};
    bool moving = true;
    for (int i = 0; i < ITERATION_LIMIT && moving; i++) {
        if (!al_parallel(b->gather->options.threads, points->count, collect, b)) return false;
        moving = i < 2;
        for (size_t c = 0; c < 3; c++) {
            if (i > 0) rebalance(b, c);
            double moved = all_change(points, points->sh, b->next, c), ratio = moved / before[c];
            double to_come = ratio < 1 ? moved * ratio / (1 - ratio) : INFINITY;
            moving = moving || (moved > 0 && to_come > converged_share * all_light(points, b->next, c));
            b->grows = b->grows || !isfinite(moved) || (i + 1 == ITERATION_LIMIT && ratio >= 1 && moved > 0);
            before[c] = moved;
        }
        memcpy(points->sh, b->next, sizeof(float) * numbers);
    }
    if (b->gather->options.walls != AL_WALLS_TRACED)
        return al_parallel(b->gather->options.threads, points->count, collect_arriving, b);
    for (size_t k = 0; k < numbers; k++) points->sh[k] -= b->straight[k];
    return true;
}

/* Left-out points take the mean of their neighbours that have a value, ring by ring. */
static void spread(al_fog_points *points, bool *known)
{
    size_t numbers = 3 * (size_t)points->terms;
    bool changed = true;
    for (uint32_t i = 0; i < points->count; i++) known[i] = !points->is_inside[i];
    while (changed) {
        changed = false;
        for (uint32_t i = 0; i < points->count; i++) {
            uint32_t stride = 1, rest = i, neighbours = 0;
            if (known[i]) continue;
            memset(points->sh + i * numbers, 0, sizeof(float) * numbers);
            for (int k = 0; k < 3; stride *= points->size[k], rest /= points->size[k], k++)
                for (int side = -1; side <= 1; side += 2) {
                    uint32_t at = rest % points->size[k];
                    if (side < 0 ? at == 0 : at + 1 == points->size[k]) continue;
                    uint32_t other = side < 0 ? i - stride : i + stride;
                    if (!known[other]) continue;
                    neighbours++;
                    for (size_t n = 0; n < numbers; n++)
                        points->sh[i * numbers + n] += points->sh[other * numbers + n];
                }
            for (size_t n = 0; n < numbers && neighbours; n++)
                points->sh[i * numbers + n] /= (float)neighbours;
            if (neighbours) changed = known[i] = true;
        }
    }
}

static void choose_order(al_fog_points *points)
{
    double band = points->gather->fog.g_limit;
    points->order = 1;
    for (; points->order < ORDER_LIMIT && band > 0.02; band *= points->gather->fog.g_limit) points->order++;
    points->terms = points->order * points->order;
}

static bool allocate(building *b, unsigned threads)
{
    al_fog_points *points = b->points;
    size_t numbers = 3 * (size_t)points->terms * points->count;
    points->is_inside = calloc(points->count, sizeof *points->is_inside);
    points->sh = calloc(numbers + 1, sizeof *points->sh);
    points->arriving = calloc((size_t)points->count * 3 * ARRIVING_TERMS, sizeof *points->arriving);
    points->transmittance = calloc((size_t)points->count * points->lamps * 3 + 1, sizeof(float));
    points->seen = calloc((size_t)cell_count(points) * CORNERS, sizeof *points->seen);
    points->beyond = calloc((size_t)cell_count(points) * CORNERS, sizeof *points->beyond);
    b->records = calloc(points->count, sizeof *b->records);
    b->fixed = calloc(numbers, sizeof(float));
    b->straight = calloc(numbers, sizeof(float));
    b->next = calloc(numbers, sizeof(float));
    b->known = calloc(points->count, sizeof *b->known);
    b->scratches = calloc(threads, sizeof *b->scratches);
    bool done = points->is_inside && points->sh && points->arriving && points->transmittance &&
                points->seen && points->beyond && b->records && b->fixed && b->straight && b->next &&
                b->known && b->scratches;
    for (unsigned i = 0; done && i < threads; i++)
        done = (b->scratches[i] = al_gather_scratch_new(b->gather)) != NULL;
    return done;
}

static void free_building(building *b, unsigned threads)
{
    for (uint32_t i = 0; b->records && i < b->points->count; i++) free(b->records[i].list);
    for (unsigned i = 0; b->scratches && i < threads; i++) al_gather_scratch_free(b->scratches[i]);
    free(b->records);
    free(b->fixed);
    free(b->straight);
    free(b->next);
    free(b->known);
    free(b->scratches);
}

static bool pass(building *b, uint32_t count, al_piece_fn *work)
{
    bool done = al_parallel(b->gather->options.threads, count, work, b);
    b->done++;
    return done;
}

/* Finds the points in air; where there are none, all are taken for it. */
static bool find_air(building *b)
{
    al_fog_points *points = b->points;
    bool any = false;
    if (!pass(b, points->count, look_around)) return false;
    for (uint32_t i = 0; i < points->count; i++) any = any || !points->is_inside[i];
    if (!any) memset(points->is_inside, 0, sizeof(bool) * points->count);
    return true;
}

static bool build(building *b)
{
    al_fog_points *points = b->points;
    if (!pass(b, cell_count(points), look_at_corners) || !pass(b, cell_count(points), look_beyond) ||
        !pass(b, points->count, look_at_lamps) || !pass(b, points->count, trace_point) || !iterate(b))
        return false;
    spread(points, b->known);
    return true;
}

/* Optical depth from point to point along the widest cells' edge, averaged over the points in air, in the
 * densest channel. */
static double mean_depth(const al_fog_points *points)
{
    double sums[3] = {0}, widest = al_fog_points_cell_m(points);
    uint32_t counted = 0;
    for (uint32_t i = 0; i < points->count; i++) {
        al_ray ray = {.direction = {1, 0, 0}};
        double transmittance[3];
        if (points->is_inside[i]) continue;
        counted++;
        place_point(points, i, ray.origin);
        ray.origin[0] -= 0.5 * points->spacing_m[0];
        al_fog_transmittance(&points->gather->fog, &ray, points->spacing_m[0], transmittance);
        for (int c = 0; c < 3; c++) sums[c] -= log(fmax(transmittance[c], 1e-300));
    }
    double largest = fmax(fmax(sums[0], sums[1]), sums[2]);
    return counted ? largest / counted * widest / points->spacing_m[0] : 0;
}

/* Light that reaches no neighbour before it is scattered is not carried by the points: what they hold would
 * be noise, without absorption of any size. */
static al_status check_depth(const building *b, al_error *error)
{
    double depth = mean_depth(b->points);
    if (depth <= depth_limit) return AL_OK;
    return al_fail(
        error, AL_BAD_INPUT,
        "lightmap.walls: the fog is too dense for %u points along the scene: %.3g mean free paths "
        "from point to point; at most %g are right: more \"fog_points\", or walls \"published\"",
        max_size(b->points), depth, depth_limit);
}

/* The few bands of a narrow lobe swing below 0; what is cut off there is light gained, and without absorption
 * nothing takes it away. */
static al_status check_growth(const building *b, al_error *error)
{
    if (!b->grows) return AL_OK;
    return al_fail(
        error, AL_BAD_INPUT,
        "lightmap.walls: the fog's light does not settle between %u points: hardly anything absorbs and "
        "g is up to %g; more absorption or g nearer to 0 is right, or walls \"published\"",
        b->points->count, b->gather->fog.g_limit);
}

/* The points need not be better than what is gathered from them. */
static uint32_t samples_of(const al_gather_options *options)
{
    if (options->fog_samples) return options->fog_samples;
    if (options->samples < SAMPLES_LEAST) return SAMPLES_LEAST;
    return options->samples < SAMPLES_MOST ? options->samples : SAMPLES_MOST;
}

al_status al_fog_points_create(al_gather *gather, al_error *error)
{
    unsigned threads = al_parallel_threads(gather->options.threads);
    al_fog_points *points = calloc(1, sizeof *points);
    building b = {.points = points, .gather = gather, .total = 6};
    if (!points) return al_fail(error, AL_IO, "out of memory for the light in the fog");
    gather->points = points;
    points->gather = gather;
    points->lamps = gather->lights.scene->light_count;
    b.samples = samples_of(&gather->options);
    place_lattice(points);
    choose_order(points);
    bool done = allocate(&b, threads) && find_air(&b);
    al_status status = done ? check_depth(&b, error) : AL_OK;
    done = done && (status || build(&b));
    if (done && !status) status = check_growth(&b, error);
    free_building(&b, threads);
    if (done) return status;
    if (b.cancelled) return al_fail(error, AL_CANCELLED, "cancelled while spreading light in the fog");
    return al_fail(error, AL_IO, "out of memory for the light in the fog: %u points of %u paths",
                   points->count, b.samples);
}

void al_fog_points_free(al_fog_points *points)
{
    if (!points) return;
    free(points->is_inside);
    free(points->sh);
    free(points->arriving);
    free(points->transmittance);
    free(points->seen);
    free(points->beyond);
    free(points);
}
