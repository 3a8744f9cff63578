/* Light that is scattered once, in a translucent object, on its way from a light to the eye:
 *
 *   L = integral over the eye ray of sum over lights of
 *       sigma_s(x) p(cos) T(eye, x) T(x, light) E_light(x) dt
 *
 * with T the transmittance through every medium on the leg, 0 behind opaque surfaces. Boundaries are
 * index-matched: light passes them straight on. One scattering point per light and call, from the mixture of
 *   - distances in proportion to sigma_t T(eye, x): most of the light comes from near the front;
 *   - distances in proportion to sigma_t: for objects lit from behind;
 *   - for point lights, equal angles seen from the light (Kulla and Fajardo 2012), which cancel 1/r^2.
 * The density that was drawn from is the whole mixture's, so the estimate is unbiased and bounded where any
 * of the three is good (balance heuristic, Veach and Guibas 1995). */
#include <math.h>
#include <stdlib.h>

#include "airlight/formulas.h"
#include "environment_sampler.h"
#include "march.h"
#include "mode.h"

typedef struct single_scatter {
    al_ray_scene *scene;
    al_march_medium *media; /* [translucent_count] */
    const al_light *lights;
    uint32_t light_count;
    al_environment_sampler environment;
} single_scatter;

typedef struct scratch {
    al_line eye, light;
    al_cells cells;
} scratch;

static void close_state(void *user)
{
    single_scatter *state = user;
    if (!state) return;
    al_ray_scene_free(state->scene);
    al_environment_sampler_free(&state->environment);
    free(state->media);
    free(state);
}

static al_status open_state(const al_import *import, const al_mode_limits *limits, void **out,
                            al_error *error)
{
    (void)limits;
    *out = NULL;
    single_scatter *state = calloc(1, sizeof *state);
    uint32_t count = import->scene.translucent_count;
    if (state) state->media = calloc(count + (size_t)1, sizeof *state->media);
    if (!state || !state->media) {
        close_state(state);
        return al_fail(error, AL_IO, "out of memory for %u media", count);
    }
    for (uint32_t i = 0; i < count; i++)
        state->media[i] = al_march_medium_of(import, import->scene.translucents[i].medium);
    state->lights = import->scene.lights;
    state->light_count = import->scene.light_count;
    al_status status = al_environment_sampler_create(&import->scene.environment, &state->environment, error);
    if (!status) status = al_ray_scene_create(import, AL_RAY_SCENE_ALL, &state->scene, error);
    if (status)
        close_state(state);
    else
        *out = state;
    return status;
}

/* One per light; two for the environment's direction and one for its scattering point. */
static uint32_t dimensions(const void *user)
{
    const single_scatter *state = user;
    return state->light_count + (state->environment.map ? 3 : 0);
}

static void *scratch_new(void)
{
    return calloc(1, sizeof(scratch));
}

static void scratch_free(void *user)
{
    scratch *s = user;
    if (!s) return;
    al_line_free(&s->eye);
    al_line_free(&s->light);
    al_cells_free(&s->cells);
    free(s);
}

/* --- the scattering point --- */

typedef struct scatter_point {
    const al_cell *cell;
    double distance_m, density_per_m; /* along the eye ray, and how densely it was drawn */
    double position[3];
    double transmittance[3]; /* to the eye */
} scatter_point;

/* The three ways to draw a distance, as one distribution. Equal angles are those about a light whose foot on
 * the ray lies at foot_m, height_m from it: distance = foot + height tan(angle). */
typedef struct mixture {
    const al_cells *cells;
    int channels;      /* to draw from: 1 when all are alike */
    double mean_depth; /* of the whole ray */
    double share;      /* of each way: 1/2 without a point light, 1/3 with */
    bool by_angle;
    double foot_m, height_m, first, last; /* angles at the ends of the media */
} mixture;

static double mean_of(const double v[3])
{
    return (v[0] + v[1] + v[2]) / 3;
}

static void aim_at_light(const al_ray *eye, const double light[3], mixture *m)
{
    const al_cells *cells = m->cells;
    double to[3], square = 0, begin_m = cells->cells[0].begin_m, end_m = cells->cells[cells->count - 1].end_m;
    for (int k = 0; k < 3; k++) {
        to[k] = light[k] - eye->origin[k];
        m->foot_m += to[k] * eye->direction[k];
    }
    for (int k = 0; k < 3; k++) {
        double off = to[k] - m->foot_m * eye->direction[k];
        square += off * off;
    }
    /* A light on the ray itself would make every angle the same. */
    m->height_m = fmax(sqrt(square), 1e-6 * (end_m - begin_m));
    m->first = atan2(begin_m - m->foot_m, m->height_m);
    m->last = atan2(end_m - m->foot_m, m->height_m);
    m->by_angle = m->last > m->first;
}

/* `light` is the position of a point light, else NULL. */
static mixture make_mixture(const al_cells *cells, const al_ray *eye, const double *light)
{
    bool alike = cells->depth[0] == cells->depth[1] && cells->depth[0] == cells->depth[2];
    mixture m = {.cells = cells, .channels = alike ? 1 : 3, .mean_depth = mean_of(cells->depth)};
    if (light) aim_at_light(eye, light, &m);
    m.share = m.by_angle ? 1.0 / 3 : 0.5;
    return m;
}

/* Probability per metre of a distance within a cell, and in `cumulative` the probability of drawing less:
 *   transmittance:  F = (1 - exp(-tau(t))) / (1 - exp(-tau)), mean over the channels (0 where tau is 0)
 *   optical depth:  F = tau(t) / tau, of the mean over the channels
 *   equal angles:   F = (angle(t) - first) / (last - first) */
static double mixture_density(const mixture *m, const al_cell *cell, double distance_m, double *cumulative)
{
    double into = distance_m - cell->begin_m, density = 0;
    *cumulative = 0;
    for (int c = 0; c < m->channels; c++) {
        double depth = cell->depth[c] + into * cell->sigma_t_per_m[c], all = -expm1(-m->cells->depth[c]);
        if (!(all > 0)) continue;
        *cumulative += -expm1(-depth) / all / m->channels;
        density += cell->sigma_t_per_m[c] * exp(-depth) / all / m->channels;
    }
    *cumulative += (mean_of(cell->depth) + into * mean_of(cell->sigma_t_per_m)) / m->mean_depth;
    density += mean_of(cell->sigma_t_per_m) / m->mean_depth;
    if (m->by_angle) {
        double off = distance_m - m->foot_m, width = m->last - m->first;
        *cumulative += (atan2(off, m->height_m) - m->first) / width;
        density += m->height_m / (width * (m->height_m * m->height_m + off * off));
    }
    *cumulative *= m->share;
    return density * m->share;
}

/* The distance in a cell where the cumulative probability is u: Newton's method, kept within the bracket. One
 * distribution inverted as a whole, and not a way picked at random, lets strata of u be strata of distance.
 */
static double invert_in_cell(const mixture *m, const al_cell *cell, double u)
{
    enum { STEPS = 60 };
    double low = cell->begin_m, high = cell->end_m, at = 0.5 * (low + high);
    for (int i = 0; i < STEPS && high - low > 1e-12 * cell->end_m; i++) {
        double cumulative, density = mixture_density(m, cell, at, &cumulative);
        if (fabs(cumulative - u) < 1e-13) break;
        if (cumulative < u)
            low = at;
        else
            high = at;
        at -= (cumulative - u) / density;
        if (!(at > low && at < high)) at = 0.5 * (low + high);
    }
    return at;
}

/* Draws the point for u in [0,1). False where there is no medium: equal angles reach into gaps. */
static bool draw_point(const mixture *m, const al_ray *eye, double u, scatter_point *out)
{
    double cumulative;
    uint32_t low = 0, high = m->cells->count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        const al_cell *cell = &m->cells->cells[middle];
        mixture_density(m, cell, cell->begin_m, &cumulative);
        if (cumulative <= u)
            low = middle;
        else
            high = middle;
    }
    out->cell = &m->cells->cells[low];
    mixture_density(m, out->cell, out->cell->end_m, &cumulative);
    if (u > cumulative && low + 1 < m->cells->count) return false;
    out->distance_m = invert_in_cell(m, out->cell, u);
    out->density_per_m = mixture_density(m, out->cell, out->distance_m, &cumulative);
    for (int c = 0; c < 3; c++) {
        double into = out->distance_m - out->cell->begin_m;
        out->transmittance[c] = exp(-(out->cell->depth[c] + into * out->cell->sigma_t_per_m[c]));
        out->position[c] = eye->origin[c] + out->distance_m * eye->direction[c];
    }
    return out->density_per_m > 0;
}

/* --- the leg to the light --- */

/* Transmittance from a point towards a light `distance_m` away; 0 behind opaque surfaces. */
static bool light_transmittance(const single_scatter *state, const al_ray *ray, double distance_m,
                                al_line *line, double transmittance[3])
{
    double depth[3] = {0};
    for (int c = 0; c < 3; c++) transmittance[c] = 0;
    if (al_ray_scene_is_blocked(state->scene, ray, distance_m)) return true;
    if (!al_ray_scene_segments(state->scene, ray, distance_m, line)) return false;
    for (uint32_t i = 0; i < line->segment_count; i++) {
        const al_segment *segment = &line->segments[i];
        const al_march_medium *medium = &state->media[segment->object];
        double length = al_march_length(medium, ray, segment->begin_m, segment->end_m);
        for (int c = 0; c < 3; c++) depth[c] += length * medium->sigma_t_per_m[c];
    }
    for (int c = 0; c < 3; c++) transmittance[c] = exp(-depth[c]);
    return true;
}

/* sigma_s p of every medium at the point, for light that arrives from `towards`. */
static void scattering(const single_scatter *state, const scratch *s, const scatter_point *point,
                       const al_ray *eye, const double towards[3], double out[3])
{
    /* Light travels along -towards, then along -eye. */
    double cosine =
        towards[0] * eye->direction[0] + towards[1] * eye->direction[1] + towards[2] * eye->direction[2];
    out[0] = out[1] = out[2] = 0;
    for (uint32_t i = 0; i < point->cell->part_count; i++) {
        const al_cell_part *part = &s->cells.parts[point->cell->first_part + i];
        const al_march_medium *medium = &state->media[part->object];
        double phase = al_phase(medium->g, cosine);
        for (int c = 0; c < 3; c++) out[c] += medium->sigma_s_per_m[c] * part->density * phase;
    }
}

/* Adds what a light of incident `power` (irradiance, or radiance over its probability) sends to the eye. */
static bool add_light(const single_scatter *state, scratch *s, const scatter_point *point, const al_ray *eye,
                      const double towards[3], double distance_m, const double power[3], double radiance[3])
{
    double transmittance[3], scattered[3];
    al_ray ray;
    for (int k = 0; k < 3; k++) {
        ray.origin[k] = point->position[k];
        ray.direction[k] = towards[k];
    }
    if (!light_transmittance(state, &ray, distance_m, &s->light, transmittance)) return false;
    scattering(state, s, point, eye, towards, scattered);
    for (int c = 0; c < 3; c++)
        radiance[c] +=
            scattered[c] * point->transmittance[c] * transmittance[c] * power[c] / point->density_per_m;
    return true;
}

static bool add_directional(const single_scatter *state, scratch *s, const al_light *light, const al_ray *eye,
                            double u, double radiance[3])
{
    scatter_point point;
    double towards[3], power[3], length = hypot(hypot(light->vector[0], light->vector[1]), light->vector[2]);
    mixture m = make_mixture(&s->cells, eye, NULL);
    if (!draw_point(&m, eye, u, &point)) return true;
    for (int k = 0; k < 3; k++) {
        towards[k] = -light->vector[k] / length;
        power[k] = light->intensity[k];
    }
    return add_light(state, s, &point, eye, towards, INFINITY, power, radiance);
}

static bool add_point(const single_scatter *state, scratch *s, const al_light *light, const al_ray *eye,
                      double u, double radiance[3])
{
    scatter_point point;
    double position[3] = {light->vector[0], light->vector[1], light->vector[2]}, towards[3], power[3],
           square = 0;
    mixture m = make_mixture(&s->cells, eye, position);
    if (!draw_point(&m, eye, u, &point)) return true;
    for (int k = 0; k < 3; k++) {
        towards[k] = position[k] - point.position[k];
        square += towards[k] * towards[k];
    }
    if (!(square > 0)) return true;
    for (int k = 0; k < 3; k++) {
        towards[k] /= sqrt(square);
        power[k] = light->intensity[k] / square;
    }
    return add_light(state, s, &point, eye, towards, sqrt(square), power, radiance);
}

/* A direction of the phase function about `axis`, the way straight on: the inverse of its cumulative,
 * cos = (1 + g^2 - ((1 - g^2) / (1 - g + 2 g u))^2) / (2 g). */
static void sample_phase(double g, const double axis[3], const double u[2], double direction[3])
{
    double square = (1 - g * g) / (1 - g + 2 * g * u[0]);
    double cosine = fmin(fmax((1 + g * g - square * square) / (2 * g), -1), 1);
    double sine = sqrt(1 - cosine * cosine), phi = 2 * AL_PI * u[1], a[3], b[3];
    /* Two axes across: Duff et al. 2017, "Building an Orthonormal Basis, Revisited". */
    double sign = axis[2] < 0 ? -1 : 1, q = -1 / (sign + axis[2]), r = axis[0] * axis[1] * q;
    a[0] = 1 + sign * axis[0] * axis[0] * q, a[1] = sign * r, a[2] = -sign * axis[0];
    b[0] = r, b[1] = sign + axis[1] * axis[1] * q, b[2] = -axis[1];
    for (int k = 0; k < 3; k++) direction[k] = sine * (cos(phi) * a[k] + sin(phi) * b[k]) + cosine * axis[k];
}

/* The asymmetry of the medium that scatters most at the point. */
static double main_asymmetry(const single_scatter *state, const scratch *s, const scatter_point *point)
{
    double most = -1, g = 0;
    for (uint32_t i = 0; i < point->cell->part_count; i++) {
        const al_cell_part *part = &s->cells.parts[point->cell->first_part + i];
        const al_march_medium *medium = &state->media[part->object];
        double scatters =
            part->density * (medium->sigma_s_per_m[0] + medium->sigma_s_per_m[1] + medium->sigma_s_per_m[2]);
        if (scatters > most) most = scatters, g = medium->g;
    }
    return g;
}

/* Directions half from the map and half from the phase function; from the map alone where that is nearly
 * even. */
static bool add_environment(const single_scatter *state, scratch *s, const al_ray *eye, const double u[3],
                            double radiance[3])
{
    scatter_point point;
    mixture m = make_mixture(&s->cells, eye, NULL);
    if (!draw_point(&m, eye, u[0], &point)) return true;
    double g = main_asymmetry(state, s, &point), towards[3], power[3], shifted[2] = {u[1], u[2]};
    double phase_share = fabs(g) > 0.05 ? 0.5 : 0;
    if (u[1] < phase_share) {
        shifted[0] = u[1] / phase_share;
        sample_phase(g, eye->direction, shifted, towards);
    } else {
        shifted[0] = (u[1] - phase_share) / (1 - phase_share);
        al_environment_sample(&state->environment, shifted, towards);
    }
    double cosine =
        towards[0] * eye->direction[0] + towards[1] * eye->direction[1] + towards[2] * eye->direction[2];
    double density = (1 - phase_share) * al_environment_density(&state->environment, towards, power);
    if (phase_share > 0) density += phase_share * al_phase(g, cosine);
    if (!(density > 0)) return true;
    for (int c = 0; c < 3; c++) power[c] /= density;
    return add_light(state, s, &point, eye, towards, INFINITY, power, radiance);
}

static bool radiance(const void *user, void *memory, const al_ray *eye, const double *random, double out[3])
{
    const single_scatter *state = user;
    scratch *s = memory;
    out[0] = out[1] = out[2] = 0;
    double end_m = al_ray_scene_opaque_m(state->scene, eye);
    if (!al_ray_scene_segments(state->scene, eye, end_m, &s->eye)) return false;
    if (!al_march_cells(state->media, eye, s->eye.segments, s->eye.segment_count, &s->cells)) return false;
    if (!(mean_of(s->cells.depth) > 0)) return true;
    for (uint32_t i = 0; i < state->light_count; i++) {
        const al_light *light = &state->lights[i];
        bool done = light->type == AL_LIGHT_POINT ? add_point(state, s, light, eye, random[i], out)
                                                  : add_directional(state, s, light, eye, random[i], out);
        if (!done) return false;
    }
    return !state->environment.map || add_environment(state, s, eye, random + state->light_count, out);
}

const al_mode al_mode_single_scatter = {
    .name = "single-scatter",
    .summary = "light scattered once inside translucent objects; no surfaces, black background",
    .open = open_state,
    .close = close_state,
    .dimensions = dimensions,
    .scratch_new = scratch_new,
    .scratch_free = scratch_free,
    .radiance = radiance,
};
