/* The last scattering event before the origin o of a ray lies on the ray, inside its free length s:
 *
 *   S(o, w) = integral over t in [0, s] of T(t) sigma_s(t) J(x(t), w) dt,
 *   J(x, w) = integral of p(w . w') L(x, w') dw',
 *
 * L(x, w') what arrives at x from w'. So whatever a wall hides is hidden, and without absorption light is
 * neither lost nor gained. The integral is estimated by one distance t, drawn in proportion to T sigma_t. L
 * is split by where it comes from:
 *   - straight from a lamp (point, sun): L = lamp's irradiance times its transmittance; a point's is sharp,
 *     so that t is drawn anew, half the time by equal angles about the lamp (Kulla and Fajardo 2012). The
 *     transmittance, shadows included, is interpolated between the fog points: no ray is traced but where
 *     none knows it;
 *   - all else: interpolated between the fog points as spherical harmonics, of which a Henyey-Greenstein
 *     phase function takes band l times g^l.
 * Traced walls ask a shadow ray for the first and take emissive surfaces and the sky out of the second the
 * same way, so that light scattered once is exact. */
#include "gather_scatter.h"

#include <math.h>

#include "airlight/formulas.h"
#include "fog_points.h"

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

typedef struct place {
    const al_fog_cell *cell; /* NULL: in vacuum */
    double distance_m;
    double position[3];
    double power[3]; /* transmittance to the ray's origin times sigma_s, over the density of drawing it */
} place;

/* --- drawing distances --- */

static double depth_at(const al_fog_cell *cell, double distance_m, int c)
{
    return cell->depth[c] +
           (cell->sigma_t_per_m[c] > 0 ? (distance_m - cell->begin_m) * cell->sigma_t_per_m[c] : 0);
}

/* The cell that holds a distance, NULL in vacuum. */
static const al_fog_cell *cell_at(const al_fog_path *fog, double distance_m)
{
    uint32_t low = 0, high = fog->count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (fog->cells[middle].begin_m <= distance_m)
            low = middle;
        else
            high = middle;
    }
    const al_fog_cell *cell = &fog->cells[low];
    return distance_m >= cell->begin_m && distance_m <= cell->end_m ? cell : NULL;
}

/* How distances on a ray are drawn: in proportion to sigma_t T, the mean over the channels with any depth;
 * one stands for all in grey fog. */
typedef struct flight {
    const al_fog_path *fog;
    const al_ray *ray;
    int channels[3], count;
    double lost[3]; /* per channel: 1 - T of the whole ray */
} flight;

/* For the channels from `first` to before `end`. */
static flight flight_along(const al_fog_path *fog, const al_ray *ray, int first, int end)
{
    flight f = {.fog = fog, .ray = ray};
    for (int c = first; c < end; c++) {
        f.lost[c] = -expm1(-fog->depth[c]);
        if (f.lost[c] > 0) f.channels[f.count++] = c;
    }
    return f;
}

/* Per metre: the mean over the channels of sigma_t T / (1 - T of the whole ray). */
static double flight_density(const flight *f, const al_fog_cell *cell, double distance_m)
{
    double density = 0;
    for (int i = 0; i < f->count; i++) {
        int c = f->channels[i];
        density += cell->sigma_t_per_m[c] * exp(-depth_at(cell, distance_m, c)) / f->lost[c];
    }
    return density / f->count;
}

static void find_position(const flight *f, place *out)
{
    for (int k = 0; k < 3; k++) out->position[k] = f->ray->origin[k] + out->distance_m * f->ray->direction[k];
}

/* A distance with that density: the channel by the first digits of u, then the depth's inverse. */
static void draw_flight(const flight *f, double u, place *out)
{
    const al_fog_path *fog = f->fog;
    int drawn = (int)(u * f->count), picked = drawn < f->count ? drawn : f->count - 1,
        c = f->channels[picked];
    double depth = -log1p(-(u * f->count - picked) * f->lost[c]);
    uint32_t low = 0, high = fog->count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (fog->cells[middle].depth[c] <= depth)
            low = middle;
        else
            high = middle;
    }
    out->cell = &fog->cells[low];
    double into = (depth - out->cell->depth[c]) / out->cell->sigma_t_per_m[c];
    out->distance_m = out->cell->begin_m + (into > 0 ? into : 0); /* a NaN of 0/0 is 0 */
    if (out->distance_m > out->cell->end_m) out->distance_m = out->cell->end_m;
    find_position(f, out);
}

static void fill_power(place *out, double density_per_m)
{
    const al_fog_cell *cell = out->cell;
    for (int c = 0; c < 3; c++)
        out->power[c] = cell->sigma_s_per_m[c] * exp(-depth_at(cell, out->distance_m, c)) / density_per_m;
}

/* A place drawn by u. Of one channel T and sigma_t cancel, and grey fog's power is that of every channel.
 * False in vacuum. */
static bool fly(const flight *f, double u, place *out)
{
    draw_flight(f, u, out);
    if (f->count > 1) {
        double density_per_m = flight_density(f, out->cell, out->distance_m);
        if (density_per_m > 0) fill_power(out, density_per_m);
        return density_per_m > 0;
    }
    int c = f->channels[0];
    double sigma_t = out->cell->sigma_t_per_m[c];
    double scale = sigma_t > 0 ? f->lost[c] / sigma_t : 0;
    for (int k = 0; k < 3; k++) out->power[k] = out->cell->sigma_s_per_m[k] * scale;
    return sigma_t > 0;
}

/* Equal angles about a light whose foot on the ray is foot_m away and height_m off it. */
typedef struct angles {
    double foot_m, height_m, first, last;
} angles;

static angles angles_about(const al_fog_path *fog, const al_ray *ray, const double target[3])
{
    angles a;
    double begin_m = fog->cells[0].begin_m, end_m = fog->cells[fog->count - 1].end_m, to[3], square = 0;
    for (int k = 0; k < 3; k++) to[k] = target[k] - ray->origin[k];
    a.foot_m = dot(to, ray->direction);
    for (int k = 0; k < 3; k++) {
        double off = to[k] - a.foot_m * ray->direction[k];
        square += off * off;
    }
    a.height_m = fmax(sqrt(square), 1e-6 * (isinf(end_m) ? fabs(a.foot_m) : end_m - begin_m));
    a.first = atan2(begin_m - a.foot_m, a.height_m);
    a.last = atan2(end_m - a.foot_m, a.height_m);
    return a;
}

/* Draws the distance anew, half by equal angles, for light from a point. False in vacuum. */
static bool redraw(const flight *f, const double target[3], const double u[2], place *out)
{
    angles a = angles_about(f->fog, f->ray, target);
    double width = a.last - a.first;
    if (!(width > 0)) return true; /* from very far: the place stands */
    if (u[1] < 0.5) {
        draw_flight(f, u[0], out);
    } else {
        out->distance_m = a.foot_m + a.height_m * tan(a.first + u[0] * width);
        out->cell = cell_at(f->fog, out->distance_m);
        if (!out->cell) return false;
        find_position(f, out);
    }
    double off = out->distance_m - a.foot_m,
           by_angle = a.height_m / (width * (a.height_m * a.height_m + off * off));
    double density_per_m = 0.5 * (flight_density(f, out->cell, out->distance_m) + by_angle);
    fill_power(out, density_per_m);
    return density_per_m > 0;
}

/* --- light --- */

/* Transmittance from the place to the light, by a shadow ray. */
static void trace_transmittance(const al_gather *gather, const double position[3],
                                const al_light_sample *light, double transmittance[3])
{
    al_ray ray;
    for (int k = 0; k < 3; k++) {
        transmittance[k] = 0;
        ray.origin[k] = position[k];
        ray.direction[k] = light->direction[k];
    }
    if (al_gather_light_is_seen(&gather->lights, position, light))
        al_fog_transmittance(&gather->fog, &ray, light->distance_m, transmittance);
}

/* Light of one kind, scattered once, at or near the place that `along` draws. */
static void add_once(const al_gather *gather, const flight *f, al_light_kind kind, double along,
                     al_sequence *sequence, al_gather_way *way)
{
    place at;
    al_light_sample light;
    double transmittance[3], u[2];
    if (!fly(f, along, &at)) return;
    if (!al_gather_light_sample(&gather->lights, kind, at.position, NULL, sequence, &light)) return;
    if (isfinite(light.distance_m)) {
        al_sequence_pair(sequence, u);
        if (!redraw(f, light.target, u, &at)) return;
        if (!al_gather_light_move(&light, at.position)) return;
    }
    if (gather->options.walls == AL_WALLS_TRACED ||
        !al_fog_points_lamp(gather->points, light.lamp, at.position, transmittance))
        trace_transmittance(gather, at.position, &light, transmittance);
    double phase = al_phase(at.cell->g, dot(light.direction, way->ray.direction));
    for (int c = 0; c < 3; c++)
        way->scattered[c] += at.power[c] * phase * light.power[c] * light.facing * transmittance[c];
}

/* Each channel has a place of its own where fog is not grey: then each counts exactly what it scatters, and
 * no point gains light. */
static bool record(const al_gather *gather, al_gather_scratch *scratch, const double carried[3], double u,
                   const al_gather_way *way)
{
    for (int c = 0; c < (gather->fog.grey ? 1 : 3); c++) {
        place at;
        flight f = flight_along(&scratch->fog, &way->ray, c, c + 1);
        if (!f.count || !fly(&f, u, &at)) continue;
        al_fog_record made = {.g = (float)at.cell->g};
        for (int k = 0; k < 3; k++) {
            made.position[k] = (float)at.position[k];
            made.direction[k] = (float)way->ray.direction[k];
            made.weight[k] = gather->fog.grey || k == c ? (float)(carried[k] * at.power[k]) : 0;
        }
        if (!al_fog_record_push(scratch->record, &made)) return false;
    }
    return true;
}

/* Light that the fog points know, at evenly dealt distances. */
static void add_others(const al_gather *gather, const flight *f, double u, al_gather_way *way)
{
    for (uint32_t i = 0; i < way->places; i++) {
        place at;
        double radiance[3];
        if (!fly(f, (i + u) / way->places, &at)) continue;
        al_fog_points_scatter(gather->points, at.position, way->ray.direction, at.cell->g, radiance);
        for (int c = 0; c < 3; c++) way->scattered[c] += at.power[c] * radiance[c] / way->places;
    }
}

bool al_gather_scatter(const al_gather *gather, al_gather_scratch *scratch, const double carried[3],
                       al_sequence *sequence, al_gather_way *way)
{
    double u[2];
    flight f = flight_along(&scratch->fog, &way->ray, 0, gather->fog.grey ? 1 : 3);
    if (!f.count) return true;
    al_sequence_pair(sequence, u);
    if (gather->lights.scene->light_count) add_once(gather, &f, AL_LIGHT_KIND_LAMP, u[0], sequence, way);
    if (scratch->record) return record(gather, scratch, carried, u[1], way);
    if (gather->options.walls == AL_WALLS_TRACED) {
        add_once(gather, &f, AL_LIGHT_KIND_EMITTER, u[0], sequence, way);
        add_once(gather, &f, AL_LIGHT_KIND_SKY, u[0], sequence, way);
    }
    add_others(gather, &f, u[0], way);
    return true;
}
