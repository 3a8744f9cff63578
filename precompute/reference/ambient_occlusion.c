/* The share of the cosine-weighted hemisphere over the surface that the eye sees which meets no surface, or
 * none within a radius; 0 where the eye sees none. The hemisphere is that of the interpolated normal. */
#include <math.h>
#include <stdlib.h>

#include "directions.h"
#include "mode.h"
#include "sampling.h"

typedef struct ambient_occlusion {
    al_ray_scene *scene;
    double radius_m;
} ambient_occlusion;

enum { DIMENSIONS = 2, RAYS = 32 /* of an eye ray */ };

static void close_state(void *user)
{
    ambient_occlusion *state = user;
    if (state) al_ray_scene_free(state->scene);
    free(state);
}

static al_status open_state(const al_import *import, const al_mode_options *options, void **out,
                            al_error *error)
{
    *out = NULL;
    ambient_occlusion *state = malloc(sizeof *state);
    if (!state) return al_fail(error, AL_IO, "out of memory");
    state->radius_m = options->radius_m;
    al_status status = al_ray_scene_create(import, AL_RAY_SCENE_ALL, &state->scene, error);
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
    return malloc(1); /* none is needed */
}

static bool radiance(const void *user, void *memory, const al_ray *eye, const double *random, double out[3])
{
    (void)memory;
    const ambient_occlusion *state = user;
    al_surface_hit hit;
    al_ray ray;
    double back[3], normal[3], u[DIMENSIONS];
    uint32_t open = 0;
    out[0] = out[1] = out[2] = 0;
    if (!al_ray_scene_hit(state->scene, eye, INFINITY, &hit)) return true;
    for (int k = 0; k < 3; k++) {
        back[k] = -eye->direction[k];
        normal[k] = (hit.front ? 1 : -1) * hit.shading_normal[k];
    }
    al_surface_offset(&hit, back, ray.origin);
    for (uint32_t i = 0; i < RAYS; i++) {
        al_sample_turned(random, DIMENSIONS, i, u);
        al_direction_about(normal, sqrt(1 - u[0]), 2 * AL_PI * u[1], ray.direction);
        open += !al_ray_scene_is_blocked(state->scene, &ray, state->radius_m);
    }
    for (int c = 0; c < 3; c++) out[c] = open / (double)RAYS;
    return true;
}

const al_mode al_mode_ambient_occlusion = {
    .name = "ambient-occlusion",
    .summary = "share of the hemisphere over the surface that is seen which meets no surface",
    .open = open_state,
    .close = close_state,
    .dimensions = dimensions,
    .scratch_new = scratch_new,
    .scratch_free = free,
    .radiance = radiance,
};
