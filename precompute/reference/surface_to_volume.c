/* Light that goes from a lamp to a surface, off it, is scattered once in a medium, and reaches the eye:
 *
 *   L = integral over the eye ray, to the first surface, and over all surfaces, of sum over lamps of
 *       T(eye, x) sigma_s(x) p(cos) T(x, y) V(x, y) cos_y / |x - y|^2 albedo(y) / pi E(y) dA dt
 *
 * E is the lamps' irradiance on the side of y that faces x, attenuated and shadowed. What emissive surfaces
 * send straight into the medium is direct light, not this; as lamps they light other surfaces. T(x, y) and
 * V(x, y) can be left out: then every surface shines through all the others.
 *
 * A path (point of a lamp, y, x) is drawn in both ways of bounce.h:
 *   gathered: x by its mixture along the eye ray (scatter_point.h), the direction by the phase functions;
 *   shot:     y by the lamp's light, then x by equal angles seen from y (Kulla and Fajardo 2012), which
 *             cancel 1 / |x - y|^2.
 * With f the integrand, p_x and p_w the densities of distance and direction, p_y and p_angle those of y per
 * area and of x per metre, either way adds, by the balance heuristic (Veach and Guibas 1995),
 *   f / (p_x p_w cos_y / |x - y|^2 + p_y p_angle).
 * Gathering alone bounds the light beside a surface, shooting alone finds the bright spot beside a lamp. */
#include <math.h>
#include <stdlib.h>

#include "bounce.h"
#include "directions.h"
#include "scatter_point.h"

typedef struct scratch {
    al_media_line eye, leg;
    al_cells cells;
} scratch;

/* Random numbers of a path of either way. */
enum {
    SEED,
    GATHERED_LAMP,
    GATHERED_AT = GATHERED_LAMP + AL_LAMP_NUMBERS,
    GATHERED_TOWARDS,
    SHOT = GATHERED_TOWARDS + 2,
    SHOT_AT = SHOT + AL_BOUNCE_SHOT_NUMBERS,
    DIMENSIONS
};

/* Paths of either way that share an eye ray and its cells. */
enum { PATHS = 32 };

static void close_state(void *user)
{
    if (user) al_bounce_free(user);
    free(user);
}

static al_status open_state(const al_import *import, const al_mode_options *options, void **out,
                            al_error *error)
{
    *out = NULL;
    al_bounce *bounce = malloc(sizeof *bounce);
    if (!bounce) return al_fail(error, AL_IO, "out of memory");
    al_status status = al_bounce_create(import, options, bounce, error);
    if (status)
        free(bounce);
    else
        *out = bounce;
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

static bool aim(const al_scatter_mixture *m, const al_surface_hit *surface, al_angles *angles)
{
    const al_cell *cells = m->cells->cells;
    return al_angles_aim(m->eye, cells[0].begin_m, cells[m->cells->count - 1].end_m, surface->position,
                         angles);
}

/* Adds the light of a path. */
static bool add_path(const al_bounce *bounce, scratch *s, const al_scatter_mixture *m,
                     const al_scatter_point *point, const al_bounce_link *link, al_random *random,
                     double radiance[3])
{
    al_angles angles;
    double gathered = point->density_per_m * al_scatter_direction_density(m, point, link->towards), power[3],
           shot = 0;
    if (aim(m, link->surface, &angles))
        shot = link->shot_per_m2 * al_angles_density(&angles, point->distance_m) * link->m2_per_sr;
    if (!(gathered + shot > 0)) return true;
    al_scatter_towards(m, point, link->towards, power);
    for (int c = 0; c < 3; c++) power[c] *= point->transmittance[c] / (gathered + shot);
    if (!al_bounce_carry(bounce, link, &s->leg, random, power)) return false;
    for (int c = 0; c < 3; c++) radiance[c] += power[c];
    return true;
}

static bool add_gathered(const al_bounce *bounce, scratch *s, const al_scatter_mixture *m, const double *u,
                         al_random *random, double radiance[3])
{
    al_lamp lamp;
    al_ray ray;
    al_scatter_point point;
    al_surface_hit surface;
    al_bounce_link link;
    if (!al_lamps_draw(&bounce->lamps, u + GATHERED_LAMP, &lamp) ||
        !al_scatter_point_draw(m, u[GATHERED_AT], &point) ||
        !(al_scatter_draw_direction(m, &point, u + GATHERED_TOWARDS, ray.direction) > 0))
        return true;
    for (int k = 0; k < 3; k++) ray.origin[k] = point.position[k];
    for (uint32_t met = 0; al_bounce_gather(bounce, &ray, met, &surface); met++)
        if (al_bounce_connect(bounce, &lamp, &surface, point.position, &link) &&
            !add_path(bounce, s, m, &point, &link, random, radiance))
            return false;
    return true;
}

static bool add_shot(const al_bounce *bounce, scratch *s, const al_scatter_mixture *m, const double *u,
                     al_random *random, double radiance[3])
{
    al_lamp lamp;
    al_scatter_point point;
    al_surface_hit surface;
    al_angles angles;
    al_bounce_link link;
    if (!al_bounce_shoot(bounce, u + SHOT, &lamp, &surface) || !aim(m, &surface, &angles) ||
        !al_scatter_point_at(m, al_angles_draw(&angles, u[SHOT_AT]), &point) ||
        !al_bounce_connect(bounce, &lamp, &surface, point.position, &link) ||
        al_bounce_is_hidden(bounce, &link))
        return true;
    return add_path(bounce, s, m, &point, &link, random, radiance);
}

static bool radiance(const void *user, void *memory, const al_ray *eye, const double *random, double out[3])
{
    const al_bounce *bounce = user;
    scratch *s = memory;
    al_scatter_mixture m;
    al_random numbers = al_random_for((uint64_t)(random[SEED] * 0x1p53), 0);
    out[0] = out[1] = out[2] = 0;
    double end_m = al_ray_scene_opaque_m(bounce->scene, eye), u[DIMENSIONS];
    if (!al_media_line_fill(&bounce->media, bounce->scene, eye, end_m, &s->eye)) return false;
    if (!al_media_cells(&s->eye, &s->cells)) return false;
    if (!al_scatter_mixture_create(eye, &s->cells, NULL, &m)) return true;
    for (uint32_t i = 0; i < PATHS; i++) {
        al_sample_turned(random, DIMENSIONS, i, u);
        if (!add_gathered(bounce, s, &m, u, &numbers, out) || !add_shot(bounce, s, &m, u, &numbers, out))
            return false;
    }
    for (int c = 0; c < 3; c++) out[c] /= PATHS;
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
