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
 * The density that was drawn from is the whole mixture's, so the estimate is unbiased and bounded where any of
 * the three is good (balance heuristic, Veach and Guibas 1995). */
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

static al_status open_state(const al_import *import, void **out, al_error *error)
{
    *out = NULL;
    single_scatter *state = calloc(1, sizeof *state);
    uint32_t count = import->scene.translucent_count;
    if (state) state->media = calloc(count + (size_t)1, sizeof *state->media);
    if (!state || !state->media) {
        close_state(state);
        return al_fail(error, AL_IO, "out of memory for %u media", count);
    }
    for (uint32_t i = 0; i < count; i++) state->media[i] = al_march_medium_of(import, i);
    state->lights = import->scene.lights;
    state->light_count = import->scene.light_count;
    al_status status = al_environment_sampler_create(&import->scene.environment, &state->environment, error);
    if (!status) status = al_ray_scene_create(import, &state->scene, error);
    if (status) close_state(state);
    else *out = state;
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

/* Optical depth at the start of a cell: of one channel, or with channel 3 the mean. */
static double depth_of(const double depth[3], int channel)
{
    return channel < 3 ? depth[channel] : (depth[0] + depth[1] + depth[2]) / 3;
}

/* The distance at which the optical depth reaches `target`. */
static double invert_depth(const al_cells *cells, int channel, double target)
{
    uint32_t low = 0, high = cells->count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (depth_of(cells->cells[middle].depth, channel) <= target) low = middle;
        else high = middle;
    }
    const al_cell *cell = &cells->cells[low];
    double sigma = depth_of(cell->sigma_t_per_m, channel), length = cell->end_m - cell->begin_m;
    double into = sigma > 0 ? (target - depth_of(cell->depth, channel)) / sigma : 0.5 * length;
    return cell->begin_m + fmin(fmax(into, 0), length);
}

static const al_cell *cell_at(const al_cells *cells, double distance_m)
{
    uint32_t low = 0, high = cells->count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (cells->cells[middle].begin_m <= distance_m) low = middle;
        else high = middle;
    }
    const al_cell *cell = &cells->cells[low];
    return distance_m >= cell->begin_m && distance_m <= cell->end_m ? cell : NULL;
}

/* T-proportional in one of the channels that see anything: tau = -log(1 - u (1 - exp(-tau_total))). */
static double sample_transmittance(const al_cells *cells, double u)
{
    int channels[3], count = 0;
    for (int c = 0; c < 3; c++)
        if (cells->depth[c] > 0) channels[count++] = c;
    int pick = (int)(u * count);
    double place = u * count - pick;
    return invert_depth(cells, channels[pick], -log1p(place * expm1(-cells->depth[channels[pick]])));
}

/* Probability per metre of sample_transmittance and, in `uniform`, of sampling in proportion to sigma_t. */
static double transmittance_density(const al_cells *cells, const al_cell *cell, double distance_m, double *uniform)
{
    double sum = 0;
    int count = 0;
    for (int c = 0; c < 3; c++) {
        if (!(cells->depth[c] > 0)) continue;
        double depth = cell->depth[c] + (distance_m - cell->begin_m) * cell->sigma_t_per_m[c];
        sum += cell->sigma_t_per_m[c] * exp(-depth) / -expm1(-cells->depth[c]);
        count++;
    }
    *uniform = depth_of(cell->sigma_t_per_m, 3) / depth_of(cells->depth, 3);
    return sum / count;
}

/* Equal angles about a light whose foot on the ray lies at foot_m, `height_m` from it: t = foot + h tan(theta). */
typedef struct equal_angles {
    double foot_m, height_m, first, last; /* angles at the ends of the media */
} equal_angles;

static equal_angles angles_about(const al_cells *cells, const al_ray *eye, const double light[3])
{
    equal_angles a = {0};
    double to[3], square = 0;
    for (int k = 0; k < 3; k++) {
        to[k] = light[k] - eye->origin[k];
        a.foot_m += to[k] * eye->direction[k];
    }
    for (int k = 0; k < 3; k++) {
        double off = to[k] - a.foot_m * eye->direction[k];
        square += off * off;
    }
    double begin_m = cells->cells[0].begin_m, end_m = cells->cells[cells->count - 1].end_m;
    /* A light on the ray itself would make every angle the same. */
    a.height_m = fmax(sqrt(square), 1e-6 * (end_m - begin_m));
    a.first = atan2(begin_m - a.foot_m, a.height_m);
    a.last = atan2(end_m - a.foot_m, a.height_m);
    return a;
}

static double angle_density(const equal_angles *a, double distance_m)
{
    double off = distance_m - a->foot_m;
    return a->height_m / ((a->last - a->first) * (a->height_m * a->height_m + off * off));
}

/* A point of the mixture; `light` is the position of a point light, else NULL. False where there is no medium. */
static bool draw_point(const al_cells *cells, const al_ray *eye, const double *light, double u, scatter_point *out)
{
    equal_angles angles = {0};
    if (light) angles = angles_about(cells, eye, light);
    bool by_angle = light && angles.last > angles.first;
    int strategies = by_angle ? 3 : 2, pick = (int)(u * strategies);
    double place = u * strategies - pick, uniform;
    if (pick == 0) out->distance_m = sample_transmittance(cells, place);
    else if (pick == 1) out->distance_m = invert_depth(cells, 3, place * depth_of(cells->depth, 3));
    else
        out->distance_m =
            angles.foot_m + angles.height_m * tan(angles.first + place * (angles.last - angles.first));
    out->cell = cell_at(cells, out->distance_m);
    if (!out->cell) return false;
    double density = transmittance_density(cells, out->cell, out->distance_m, &uniform) + uniform;
    if (by_angle) density += angle_density(&angles, out->distance_m);
    out->density_per_m = density / strategies;
    for (int c = 0; c < 3; c++) {
        double into = out->distance_m - out->cell->begin_m;
        out->transmittance[c] = exp(-(out->cell->depth[c] + into * out->cell->sigma_t_per_m[c]));
        out->position[c] = eye->origin[c] + out->distance_m * eye->direction[c];
    }
    return out->density_per_m > 0;
}

/* --- the leg to the light --- */

/* Transmittance from a point towards a light `distance_m` away; 0 behind opaque surfaces. */
static bool light_transmittance(const single_scatter *state, const al_ray *ray, double distance_m, al_line *line,
                                double transmittance[3])
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
static void scattering(const single_scatter *state, const scratch *s, const scatter_point *point, const al_ray *eye,
                       const double towards[3], double out[3])
{
    /* Light travels along -towards, then along -eye. */
    double cosine = towards[0] * eye->direction[0] + towards[1] * eye->direction[1] + towards[2] * eye->direction[2];
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
        radiance[c] += scattered[c] * point->transmittance[c] * transmittance[c] * power[c] / point->density_per_m;
    return true;
}

static bool add_directional(const single_scatter *state, scratch *s, const al_light *light, const al_ray *eye, double u,
                            double radiance[3])
{
    scatter_point point;
    double towards[3], power[3], length = hypot(hypot(light->vector[0], light->vector[1]), light->vector[2]);
    if (!draw_point(&s->cells, eye, NULL, u, &point)) return true;
    for (int k = 0; k < 3; k++) {
        towards[k] = -light->vector[k] / length;
        power[k] = light->intensity[k];
    }
    return add_light(state, s, &point, eye, towards, INFINITY, power, radiance);
}

static bool add_point(const single_scatter *state, scratch *s, const al_light *light, const al_ray *eye, double u,
                      double radiance[3])
{
    scatter_point point;
    double position[3] = {light->vector[0], light->vector[1], light->vector[2]}, towards[3], power[3], square = 0;
    if (!draw_point(&s->cells, eye, position, u, &point)) return true;
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
        double scatters = part->density * (medium->sigma_s_per_m[0] + medium->sigma_s_per_m[1] + medium->sigma_s_per_m[2]);
        if (scatters > most) most = scatters, g = medium->g;
    }
    return g;
}

/* Directions half from the map and half from the phase function; from the map alone where that is nearly even. */
static bool add_environment(const single_scatter *state, scratch *s, const al_ray *eye, const double u[3],
                            double radiance[3])
{
    scatter_point point;
    if (!draw_point(&s->cells, eye, NULL, u[0], &point)) return true;
    double g = main_asymmetry(state, s, &point), towards[3], power[3], shifted[2] = {u[1], u[2]};
    double phase_share = fabs(g) > 0.05 ? 0.5 : 0;
    if (u[1] < phase_share) {
        shifted[0] = u[1] / phase_share;
        sample_phase(g, eye->direction, shifted, towards);
    } else {
        shifted[0] = (u[1] - phase_share) / (1 - phase_share);
        al_environment_sample(&state->environment, shifted, towards);
    }
    double cosine = towards[0] * eye->direction[0] + towards[1] * eye->direction[1] + towards[2] * eye->direction[2];
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
    if (!(depth_of(s->cells.depth, 3) > 0)) return true;
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
