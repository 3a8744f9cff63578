/* Light that is scattered once, in a fog or a translucent object, on its way from a light to the eye:
 *
 *   L = integral over the eye ray of sum over lights of
 *       sigma_s(x) p(cos) T(eye, x) T(x, light) E_light(x) dt
 *
 * with T the transmittance through every medium on the leg, 0 behind opaque surfaces. Boundaries are
 * index-matched: light passes them straight on. One scattering point per light and call, from the mixture of
 * scatter_point.h. The density that was drawn from is the whole mixture's, so the estimate is unbiased and
 * bounded where any of its ways is good (balance heuristic, Veach and Guibas 1995).
 *
 * Emissive surfaces are asked, at a point drawn by power that the mixture aims at, and met, by a direction of
 * the phase functions from a point of the mixture without a light; the two share in the same way. */
#include <math.h>
#include <stdlib.h>

#include "airlight/formulas.h"
#include "directions.h"
#include "emitters.h"
#include "environment_sampler.h"
#include "media.h"
#include "mode.h"
#include "scatter_point.h"

typedef struct single_scatter {
    al_ray_scene *scene;
    al_media media;
    const al_light *lights;
    uint32_t light_count;
    al_emitters *emitters;
    al_environment_sampler environment;
} single_scatter;

typedef struct scratch {
    al_media_line eye, light;
    al_cells cells;
} scratch;

static void close_state(void *user)
{
    single_scatter *state = user;
    if (!state) return;
    al_emitters_free(state->emitters);
    al_ray_scene_free(state->scene);
    al_environment_sampler_free(&state->environment);
    al_media_free(&state->media);
    free(state);
}

static al_status open_state(const al_import *import, const al_mode_options *options, void **out,
                            al_error *error)
{
    (void)options;
    *out = NULL;
    single_scatter *state = calloc(1, sizeof *state);
    if (!state) return al_fail(error, AL_IO, "out of memory");
    state->lights = import->scene.lights;
    state->light_count = import->scene.light_count;
    al_status status = al_environment_sampler_create(&import->scene.environment, &state->environment, error);
    if (!status) status = al_media_create(import, &state->media, error);
    if (!status) status = al_ray_scene_create(import, AL_RAY_SCENE_ALL, &state->scene, error);
    if (!status) status = al_emitters_create(import, state->scene, &state->emitters, error);
    if (status)
        close_state(state);
    else
        *out = state;
    return status;
}

/* One per light; an environment's scattering point and direction; an emitter's point and its scattering
 * point, and a scattering point and direction to meet one. */
enum { OF_ENVIRONMENT = 3, ASKED = 0, MET = 4, OF_EMITTERS = 7 };

static uint32_t dimensions(const void *user)
{
    const single_scatter *state = user;
    return state->light_count + (state->environment.map ? OF_ENVIRONMENT : 0) +
           (al_emitters_count(state->emitters) ? OF_EMITTERS : 0);
}

static void *scratch_new(void)
{
    return calloc(1, sizeof(scratch));
}

static void scratch_free(void *user)
{
    scratch *s = user;
    if (!s) return;
    al_media_line_free(&s->eye);
    al_media_line_free(&s->light);
    al_cells_free(&s->cells);
    free(s);
}

/* --- lights --- */

/* Adds what a light of incident `power` (irradiance, or radiance over its probability) sends to the eye. */
static bool add_light(const single_scatter *state, scratch *s, const al_scatter_mixture *m,
                      const al_scatter_point *point, const double towards[3], double distance_m,
                      const double power[3], double radiance[3])
{
    double transmittance[3], scattered[3];
    al_ray ray;
    for (int k = 0; k < 3; k++) {
        ray.origin[k] = point->position[k];
        ray.direction[k] = towards[k];
    }
    /* A lamp on a surface is in front of it. */
    if (al_ray_scene_is_blocked(state->scene, &ray, distance_m - al_ray_scene_offset_m(state->scene)))
        return true;
    if (!al_media_line_fill(&state->media, state->scene, &ray, distance_m, &s->light)) return false;
    al_media_transmittance(&s->light, distance_m, transmittance);
    al_scatter_towards(m, point, towards, scattered);
    for (int c = 0; c < 3; c++)
        radiance[c] +=
            scattered[c] * point->transmittance[c] * transmittance[c] * power[c] / point->density_per_m;
    return true;
}

static bool add_directional(const single_scatter *state, scratch *s, const al_light *light, const al_ray *eye,
                            double u, double radiance[3])
{
    al_scatter_point point;
    double towards[3], power[3], length = hypot(hypot(light->vector[0], light->vector[1]), light->vector[2]);
    al_scatter_mixture m;
    if (!al_scatter_mixture_create(eye, &s->cells, NULL, &m)) return true;
    if (!al_scatter_point_draw(&m, u, &point)) return true;
    for (int k = 0; k < 3; k++) {
        towards[k] = -light->vector[k] / length;
        power[k] = light->intensity[k];
    }
    return add_light(state, s, &m, &point, towards, INFINITY, power, radiance);
}

static bool add_point(const single_scatter *state, scratch *s, const al_light *light, const al_ray *eye,
                      double u, double radiance[3])
{
    al_scatter_point point;
    double position[3] = {light->vector[0], light->vector[1], light->vector[2]}, towards[3], power[3],
           square = 0;
    al_scatter_mixture m;
    if (!al_scatter_mixture_create(eye, &s->cells, position, &m)) return true;
    if (!al_scatter_point_draw(&m, u, &point)) return true;
    for (int k = 0; k < 3; k++) {
        towards[k] = position[k] - point.position[k];
        square += towards[k] * towards[k];
    }
    if (!(square > 0)) return true;
    for (int k = 0; k < 3; k++) {
        towards[k] /= sqrt(square);
        power[k] = light->intensity[k] / square;
    }
    return add_light(state, s, &m, &point, towards, sqrt(square), power, radiance);
}

/* Directions half from the map and half from the phase function. */
static bool add_environment(const single_scatter *state, scratch *s, const al_ray *eye, const double u[3],
                            double radiance[3])
{
    al_scatter_mixture m;
    al_scatter_point point;
    if (!al_scatter_mixture_create(eye, &s->cells, NULL, &m)) return true;
    if (!al_scatter_point_draw(&m, u[0], &point)) return true;
    double towards[3], power[3], shifted[2] = {2 * u[1], u[2]};
    if (u[1] < 0.5) {
        if (!(al_scatter_draw_direction(&m, &point, shifted, towards) > 0)) return true;
    } else {
        shifted[0] -= 1;
        al_environment_sample(&state->environment, shifted, towards);
    }
    double density = 0.5 * (al_environment_density(&state->environment, towards, power) +
                            al_scatter_direction_density(&m, &point, towards));
    if (!(density > 0)) return true;
    for (int c = 0; c < 3; c++) power[c] /= density;
    return add_light(state, s, &m, &point, towards, INFINITY, power, radiance);
}

/* Adds what a point of an emitter sends to the point at a distance along the eye's ray, whichever way they
 * were drawn. With p the densities along the ray, either way adds the integrand over p_even p_phase cos / r^2
 * + p_emitter p_aimed. */
static bool add_emission(const single_scatter *state, scratch *s, const al_ray *eye,
                         const al_surface_hit *from, double distance_m, double radiance[3])
{
    al_scatter_mixture even, aimed;
    al_scatter_point point, point_aimed;
    double source[3], back[3], towards[3], power[3], square = 0;
    if (!al_scatter_mixture_create(eye, &s->cells, NULL, &even) ||
        !al_scatter_mixture_create(eye, &s->cells, from->position, &aimed) ||
        !al_scatter_point_at(&even, distance_m, &point) ||
        !al_scatter_point_at(&aimed, distance_m, &point_aimed))
        return true;
    for (int k = 0; k < 3; k++) back[k] = point.position[k] - from->position[k];
    al_surface_offset(from, back, source);
    for (int k = 0; k < 3; k++) {
        towards[k] = source[k] - point.position[k];
        square += towards[k] * towards[k];
    }
    if (!(square > 0)) return true;
    for (int k = 0; k < 3; k++) towards[k] /= sqrt(square);
    double cosine = -al_dot(from->normal, towards);
    if (from->material->double_sided) cosine = fabs(cosine);
    if (!(cosine > 0)) return true;
    double met = point.density_per_m * al_scatter_direction_density(&even, &point, towards),
           asked = point_aimed.density_per_m * al_emitters_density(state->emitters, from->material) * square /
                   cosine;
    if (!(met + asked > 0)) return true;
    for (int c = 0; c < 3; c++) power[c] = from->emission_w_m2_sr[c] * point.density_per_m / (met + asked);
    return add_light(state, s, &even, &point, towards, sqrt(square), power, radiance);
}

static bool add_emitters(const single_scatter *state, scratch *s, const al_ray *eye, const double *u,
                         double radiance[3])
{
    al_scatter_mixture m;
    al_scatter_point point;
    al_surface_hit emitter;
    al_ray ray;
    al_emitters_sample(state->emitters, u + ASKED, &emitter);
    if (al_scatter_mixture_create(eye, &s->cells, emitter.position, &m) &&
        al_scatter_point_draw(&m, u[ASKED + 3], &point) &&
        !add_emission(state, s, eye, &emitter, point.distance_m, radiance))
        return false;
    if (!al_scatter_mixture_create(eye, &s->cells, NULL, &m) || !al_scatter_point_draw(&m, u[MET], &point) ||
        !(al_scatter_draw_direction(&m, &point, u + MET + 1, ray.direction) > 0))
        return true;
    for (int k = 0; k < 3; k++) ray.origin[k] = point.position[k];
    return !al_ray_scene_hit(state->scene, &ray, INFINITY, &emitter) ||
           add_emission(state, s, eye, &emitter, point.distance_m, radiance);
}

static bool radiance(const void *user, void *memory, const al_ray *eye, const double *random, double out[3])
{
    const single_scatter *state = user;
    scratch *s = memory;
    out[0] = out[1] = out[2] = 0;
    double end_m = al_ray_scene_opaque_m(state->scene, eye);
    if (!al_media_line_fill(&state->media, state->scene, eye, end_m, &s->eye)) return false;
    if (!al_media_cells(&s->eye, &s->cells)) return false;
    for (uint32_t i = 0; i < state->light_count; i++) {
        const al_light *light = &state->lights[i];
        bool done = light->type == AL_LIGHT_POINT ? add_point(state, s, light, eye, random[i], out)
                                                  : add_directional(state, s, light, eye, random[i], out);
        if (!done) return false;
    }
    random += state->light_count;
    if (state->environment.map && !add_environment(state, s, eye, random, out)) return false;
    if (state->environment.map) random += OF_ENVIRONMENT;
    return !al_emitters_count(state->emitters) || add_emitters(state, s, eye, random, out);
}

const al_mode al_mode_single_scatter = {
    .name = "single-scatter",
    .summary = "light scattered once, in fogs and translucent objects; no surfaces, black background",
    .open = open_state,
    .close = close_state,
    .dimensions = dimensions,
    .scratch_new = scratch_new,
    .scratch_free = scratch_free,
    .radiance = radiance,
};
