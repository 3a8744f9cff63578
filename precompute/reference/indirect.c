/* Light that goes from a lamp to a surface, off it to the surface that the eye sees, and to the eye:
 *
 *   L = T(eye, x) integral over all surfaces of sum over lamps of
 *       f(x, y) cos_x T(x, y) V(x, y) cos_y / |x - y|^2 albedo(y) / pi E(y) dA
 *
 * The sender y is Lambert (bounce.h), so metals send nothing; the receiver x reflects by f, Lambert and GGX
 * (reflection.h). Neither direct light nor emission is shown. A path is drawn in both ways of bounce.h,
 * gathered by the directions of f cos_x; with p_w their density and p_y that of shots per area either way
 * adds, by the balance heuristic (Veach and Guibas 1995), integrand / (p_w cos_y / |x - y|^2 + p_y). */
#include <math.h>
#include <stdlib.h>

#include "bounce.h"
#include "reflection.h"

typedef struct indirect {
    al_bounce bounce;
    al_surface_colors colors;
} indirect;

/* Random numbers of a path of either way. */
enum {
    SEED,
    GATHERED_LAMP,
    GATHERED_TOWARDS = GATHERED_LAMP + AL_LAMP_NUMBERS,
    SHOT = GATHERED_TOWARDS + 3,
    DIMENSIONS = SHOT + AL_BOUNCE_SHOT_NUMBERS
};

/* Paths of either way that share an eye ray. */
enum { PATHS = 32 };

static void close_state(void *user)
{
    indirect *state = user;
    if (state) al_bounce_free(&state->bounce);
    free(state);
}

static al_status open_state(const al_import *import, const al_mode_options *options, void **out,
                            al_error *error)
{
    *out = NULL;
    indirect *state = malloc(sizeof *state);
    if (!state) return al_fail(error, AL_IO, "out of memory");
    state->colors = al_surface_colors_of(&import->scene);
    al_status status = al_bounce_create(import, options, &state->bounce, error);
    if (status)
        free(state);
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
    return calloc(1, sizeof(al_media_line));
}

static void scratch_free(void *line)
{
    if (line) al_media_line_free(line);
    free(line);
}

typedef struct receiver {
    al_reflection reflection;
    double position[3]; /* off the surface */
} receiver;

/* Adds the light of a path. */
static bool add_path(const al_bounce *bounce, al_media_line *line, const receiver *at,
                     const al_bounce_link *link, al_random *random, double sum[3])
{
    double power[3], gathered = al_reflection_density(&at->reflection, link->towards),
                     shot = link->shot_per_m2 * link->m2_per_sr;
    if (!(gathered + shot > 0)) return true;
    al_reflection_value(&at->reflection, link->towards, power);
    for (int c = 0; c < 3; c++) power[c] /= gathered + shot;
    if (!al_bounce_carry(bounce, link, line, random, power)) return false;
    for (int c = 0; c < 3; c++) sum[c] += power[c];
    return true;
}

static bool add_gathered(const al_bounce *bounce, al_media_line *line, const receiver *at, const double *u,
                         al_random *random, double sum[3])
{
    al_lamp lamp;
    al_ray ray;
    al_surface_hit surface;
    al_bounce_link link;
    if (!al_lamps_draw(&bounce->lamps, u + GATHERED_LAMP, &lamp)) return true;
    al_reflection_draw(&at->reflection, u + GATHERED_TOWARDS, ray.direction);
    for (int k = 0; k < 3; k++) ray.origin[k] = at->position[k];
    for (uint32_t met = 0; al_bounce_gather(bounce, &ray, met, &surface); met++)
        if (al_bounce_connect(bounce, &lamp, &surface, at->position, &link) &&
            !add_path(bounce, line, at, &link, random, sum))
            return false;
    return true;
}

static bool add_shot(const al_bounce *bounce, al_media_line *line, const receiver *at, const double *u,
                     al_random *random, double sum[3])
{
    al_lamp lamp;
    al_surface_hit surface;
    al_bounce_link link;
    if (!al_bounce_shoot(bounce, u + SHOT, &lamp, &surface) ||
        !al_bounce_connect(bounce, &lamp, &surface, at->position, &link) ||
        al_bounce_is_hidden(bounce, &link))
        return true;
    return add_path(bounce, line, at, &link, random, sum);
}

static bool radiance(const void *user, void *memory, const al_ray *eye, const double *random, double out[3])
{
    const indirect *state = user;
    const al_bounce *bounce = &state->bounce;
    al_surface_hit hit;
    al_random numbers = al_random_for((uint64_t)(random[SEED] * 0x1p53), 0);
    double back[3], u[DIMENSIONS], transmittance[3] = {1, 1, 1};
    out[0] = out[1] = out[2] = 0;
    if (!al_ray_scene_hit(bounce->scene, eye, INFINITY, &hit)) return true;
    for (int k = 0; k < 3; k++) back[k] = -eye->direction[k];
    receiver at = {.reflection = al_reflection_of(&state->colors, &hit, back)};
    al_surface_offset(&hit, back, at.position);
    for (uint32_t i = 0; i < PATHS; i++) {
        al_sample_turned(random, DIMENSIONS, i, u);
        if (!add_gathered(bounce, memory, &at, u, &numbers, out) ||
            !add_shot(bounce, memory, &at, u, &numbers, out))
            return false;
    }
    if (!al_media_line_fill(&bounce->media, bounce->scene, eye, hit.distance_m, memory)) return false;
    al_media_attenuate(memory, hit.distance_m, &numbers, transmittance);
    for (int c = 0; c < 3; c++) out[c] *= transmittance[c] / PATHS;
    return true;
}

const al_mode al_mode_indirect = {
    .name = "indirect",
    .summary = "light off one surface onto the surface that is seen",
    .open = open_state,
    .close = close_state,
    .dimensions = dimensions,
    .scratch_new = scratch_new,
    .scratch_free = scratch_free,
    .radiance = radiance,
};
