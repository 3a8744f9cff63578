/* Light that goes from a lamp to a surface, off it, is scattered once in a medium, and reaches the eye:
 *
 *   L = integral over the eye ray, to the first surface, and over all surfaces, of sum over lamps of
 *       T(eye, x) sigma_s(x) p(cos) T(x, y) V(x, y) cos_y / |x - y|^2 albedo(y) / pi E(y) dA dt
 *
 * E is the lamps' irradiance on the side of y that faces x, attenuated and shadowed; surfaces are two-sided
 * Lambert of base colour times 1 - metallic, as in volume-path. What emissive surfaces send straight into the
 * medium is direct light, not this; as lamps they light other surfaces. T(x, y) and V(x, y) can be left out:
 * then every surface shines through all the others.
 *
 * A path (point of a lamp, y, x) is drawn in two ways:
 *   gathered: x by its mixture along the eye ray (scatter_point.h), the direction by the phase functions, y
 *             where it meets a surface;
 *   shot:     y where a ray of the lamp's light meets a surface, which draws in proportion to E, then x by
 *             equal angles seen from y (Kulla and Fajardo 2012), which cancel 1 / |x - y|^2.
 * The point of the lamp is drawn alike, so its probability drops out of the balance heuristic (Veach and
 * Guibas 1995). With f the integrand, p_x and p_w the densities of distance and direction, p_y and p_angle
 * those of y per area and of x per metre, either way adds
 *   f / (p_x p_w cos_y / |x - y|^2 + p_y p_angle).
 * Gathering alone bounds the light beside a surface, shooting alone finds the bright spot beside a lamp. */
#include <math.h>
#include <stdlib.h>

#include "directions.h"
#include "lamps.h"
#include "media.h"
#include "mode.h"
#include "scatter_point.h"

typedef struct surface_to_volume {
    al_mode_options options;
    al_ray_scene *scene;
    al_media media;
    al_lamps lamps;
} surface_to_volume;

typedef struct scratch {
    al_media_line eye, leg;
    al_cells cells;
} scratch;

/* Random numbers of one call. */
enum {
    SEED,
    GATHERED_LAMP,
    GATHERED_AT = GATHERED_LAMP + AL_LAMP_NUMBERS,
    GATHERED_TOWARDS,
    SHOT_LAMP = GATHERED_TOWARDS + 2,
    SHOT_RAY = SHOT_LAMP + AL_LAMP_NUMBERS,
    SHOT_AT = SHOT_RAY + AL_LAMP_SHOT_NUMBERS,
    DIMENSIONS
};

static void close_state(void *user)
{
    surface_to_volume *state = user;
    if (!state) return;
    al_lamps_free(&state->lamps);
    al_media_free(&state->media);
    al_ray_scene_free(state->scene);
    free(state);
}

static al_status open_state(const al_import *import, const al_mode_options *options, void **out,
                            al_error *error)
{
    *out = NULL;
    surface_to_volume *state = calloc(1, sizeof *state);
    if (!state) return al_fail(error, AL_IO, "out of memory");
    state->options = *options;
    al_status status = al_ray_scene_create(import, AL_RAY_SCENE_ALL, &state->scene, error);
    if (!status) status = al_media_create(import, &state->media, error);
    if (!status) status = al_lamps_create(import, state->scene, &state->lamps, error);
    if (status)
        close_state(state);
    else
        *out = state;
    return status;
}

static uint32_t dimensions(const void *user)
{
    (void)user;
    return DIMENSIONS;
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
    al_media_line_free(&s->leg);
    al_cells_free(&s->cells);
    free(s);
}

static bool is_black(const double v[3])
{
    return !(v[0] > 0 || v[1] > 0 || v[2] > 0);
}

/* Multiplies by an unbiased estimate of what comes through the media. */
static bool attenuate(const surface_to_volume *state, scratch *s, const double from[3],
                      const double direction[3], double end_m, al_random *random, double throughput[3])
{
    al_ray ray;
    for (int k = 0; k < 3; k++) {
        ray.origin[k] = from[k];
        ray.direction[k] = direction[k];
    }
    if (!al_media_line_fill(&state->media, state->scene, &ray, end_m, &s->leg)) return false;
    al_media_attenuate(&s->leg, end_m, random, throughput);
    return true;
}

/* Whether a surface is nearer than `end_m`; one at the end itself does not count. */
static bool is_blocked(const surface_to_volume *state, const double from[3], const double direction[3],
                       double end_m)
{
    al_ray ray;
    for (int k = 0; k < 3; k++) {
        ray.origin[k] = from[k];
        ray.direction[k] = direction[k];
    }
    return al_ray_scene_is_blocked(state->scene, &ray, end_m - al_ray_scene_offset_m(state->scene));
}

/* Adds the light of a path: lamp, surface, scattering point. */
static bool add_path(const surface_to_volume *state, scratch *s, const al_scatter_mixture *m,
                     const al_lamp *lamp, const al_surface_hit *surface, const al_scatter_point *point,
                     al_random *random, double radiance[3])
{
    double to_surface[3], to_point[3], from[3], power[3], square = 0;
    al_lamp_light light;
    for (int k = 0; k < 3; k++) to_point[k] = point->position[k] - surface->position[k];
    al_surface_offset(surface, to_point, from);
    for (int k = 0; k < 3; k++) {
        to_surface[k] = from[k] - point->position[k];
        square += to_surface[k] * to_surface[k];
    }
    if (!(square > 0) || !al_lamp_shine(lamp, from, &light)) return true;
    double distance_m = sqrt(square);
    for (int k = 0; k < 3; k++) to_surface[k] /= distance_m;
    double cosine = -al_dot(surface->normal, to_surface), lit = al_dot(surface->normal, light.towards);
    if (!(cosine * lit > 0)) return true; /* lit on the other side */
    cosine = fabs(cosine);
    lit = fabs(lit);

    al_angles angles;
    const al_cells *cells = &s->cells;
    double gathered = point->density_per_m * al_scatter_direction_density(m, point, to_surface), shot = 0;
    if (al_angles_aim(m->eye, cells->cells[0].begin_m, cells->cells[cells->count - 1].end_m, from, &angles))
        shot = al_lamps_shot_density(&state->lamps, lamp, &light, lit) *
               al_angles_density(&angles, point->distance_m) * square / cosine;
    al_scatter_towards(m, point, to_surface, power);
    for (int c = 0; c < 3; c++)
        power[c] *= point->transmittance[c] * surface->albedo[c] / AL_PI * lit * light.irradiance[c] /
                    (gathered + shot);
    if (is_black(power) || is_blocked(state, from, light.towards, light.end_m)) return true;
    if (!attenuate(state, s, from, light.towards, light.end_m, random, power)) return false;
    if (!state->options.no_attenuation &&
        !attenuate(state, s, point->position, to_surface, distance_m, random, power))
        return false;
    for (int c = 0; c < 3; c++) radiance[c] += power[c];
    return true;
}

/* Every surface along the ray counts when there is no visibility, else the first. */
static bool add_gathered(const surface_to_volume *state, scratch *s, const al_scatter_mixture *m,
                         const double *u, al_random *random, double radiance[3])
{
    al_lamp lamp;
    al_ray ray;
    al_scatter_point point;
    al_surface_hit hit;
    if (!al_lamps_draw(&state->lamps, u + GATHERED_LAMP, &lamp) ||
        !al_scatter_point_draw(m, u[GATHERED_AT], &point) ||
        !(al_scatter_draw_direction(m, &point, u + GATHERED_TOWARDS, ray.direction) > 0))
        return true;
    for (int k = 0; k < 3; k++) ray.origin[k] = point.position[k];
    while (al_ray_scene_hit(state->scene, &ray, INFINITY, &hit)) {
        if (!add_path(state, s, m, &lamp, &hit, &point, random, radiance)) return false;
        if (!state->options.no_visibility) break;
        al_surface_offset(&hit, ray.direction, ray.origin);
    }
    return true;
}

static bool add_shot(const surface_to_volume *state, scratch *s, const al_scatter_mixture *m, const double *u,
                     al_random *random, double radiance[3])
{
    al_lamp lamp;
    al_ray ray;
    al_scatter_point point;
    al_surface_hit hit;
    al_angles angles;
    const al_cells *cells = &s->cells;
    double from[3], back[3], towards[3], square = 0;
    if (!al_lamps_draw(&state->lamps, u + SHOT_LAMP, &lamp)) return true;
    al_lamps_shoot(&state->lamps, &lamp, u + SHOT_RAY, &ray);
    if (!al_ray_scene_hit(state->scene, &ray, INFINITY, &hit) || is_black(hit.albedo)) return true;
    for (int k = 0; k < 3; k++) back[k] = -ray.direction[k];
    al_surface_offset(&hit, back, from);
    if (!al_angles_aim(m->eye, cells->cells[0].begin_m, cells->cells[cells->count - 1].end_m, from,
                       &angles) ||
        !al_scatter_point_at(m, al_angles_draw(&angles, u[SHOT_AT]), &point))
        return true;
    for (int k = 0; k < 3; k++) {
        towards[k] = point.position[k] - from[k];
        square += towards[k] * towards[k];
    }
    if (!(square > 0)) return true;
    for (int k = 0; k < 3; k++) towards[k] /= sqrt(square);
    if (!state->options.no_visibility && is_blocked(state, from, towards, sqrt(square))) return true;
    return add_path(state, s, m, &lamp, &hit, &point, random, radiance);
}

/* Paths of either way that share an eye ray and its cells. Their numbers are Weyl's sequence (multiples of
 * square roots of primes, modulo 1), which fills space evenly, from a random start: each is uniform. */
enum { PATHS = 32 };

static void turn_numbers(const double *random, int path, double u[DIMENSIONS])
{
    static const double primes[DIMENSIONS] = {2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47};
    for (int d = 0; d < DIMENSIONS; d++) {
        double turned = random[d] + path * sqrt(primes[d]);
        u[d] = fmin(turned - floor(turned), 0x1.fffffffffffffp-1);
    }
}

static bool radiance(const void *user, void *memory, const al_ray *eye, const double *random, double out[3])
{
    const surface_to_volume *state = user;
    scratch *s = memory;
    al_scatter_mixture m;
    al_random numbers = al_random_for((uint64_t)(random[SEED] * 0x1p53), 0);
    out[0] = out[1] = out[2] = 0;
    double end_m = al_ray_scene_opaque_m(state->scene, eye);
    if (!al_media_line_fill(&state->media, state->scene, eye, end_m, &s->eye)) return false;
    if (!al_media_cells(&s->eye, &s->cells)) return false;
    if (!al_scatter_mixture_create(eye, &s->cells, NULL, &m)) return true;
    for (int i = 0; i < PATHS; i++) {
        double u[DIMENSIONS], sum[3] = {0};
        turn_numbers(random, i, u);
        if (!add_gathered(state, s, &m, u, &numbers, sum) || !add_shot(state, s, &m, u, &numbers, sum))
            return false;
        for (int c = 0; c < 3; c++) out[c] += sum[c] / PATHS;
    }
    return true;
}

const al_mode al_mode_surface_to_volume = {
    .name = "surface-to-volume",
    .summary = "light off one surface, then scattered once in fogs and translucent objects",
    .open = open_state,
    .close = close_state,
    .dimensions = dimensions,
    .scratch_new = scratch_new,
    .scratch_free = scratch_free,
    .radiance = radiance,
};
