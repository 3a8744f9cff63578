/* Lights as a point in the scene meets them: one place to shine from, drawn with its probability. */
#ifndef AIRLIGHT_GATHER_LIGHT_H
#define AIRLIGHT_GATHER_LIGHT_H

#include "emitters.h"
#include "environment_sampler.h"
#include "sequence.h"

typedef struct al_gather_lights {
    const al_scene *scene;
    const al_ray_scene *rays;
    al_emitters *emitters;
    al_environment_sampler environment;
} al_gather_lights;

al_status al_gather_lights_create(const al_import *import, const al_ray_scene *rays, al_gather_lights *lights,
                                  al_error *error);
void al_gather_lights_free(al_gather_lights *lights);

/* Kinds of light that are drawn from one at a time. */
typedef enum al_light_kind {
    AL_LIGHT_KIND_LAMP = 0,    /* one of the scene's point and directional lights */
    AL_LIGHT_KIND_EMITTER = 1, /* a point of an emissive surface */
    AL_LIGHT_KIND_SKY = 2,     /* a direction of the environment */
    AL_LIGHT_KIND_COUNT = 3
} al_light_kind;

typedef struct al_light_sample {
    al_light_kind kind;
    uint32_t lamp;       /* index into scene.lights */
    double direction[3]; /* unit, towards the light */
    double distance_m;   /* INFINITY for directional lights and the sky */
    double target[3];    /* where a shadow ray ends, when the distance is finite */
    /* What shines, over the probability of drawing it: intensity, W/sr (emitters: along their normal), or
     * irradiance facing it, W/m2. */
    double power[3];
    double facing;     /* irradiance facing the light is power times this: 1/d2, cos_normal/d2 or 1 */
    double cos_normal; /* emitters: their normal . direction to the point; 1 */
    double normal[3];  /* of emitters */
    bool double_sided;
    double density_per_sr; /* of drawing the direction; 0 for lamps, which no ray meets */
} al_light_sample;

/* Draws a light of a kind for a point, in proportion to an estimate of what it does there. `normal` may be
 * NULL. False when there is none, or none on the normal's side. */
bool al_gather_light_sample(const al_gather_lights *lights, al_light_kind kind, const double position[3],
                            const double *normal, al_sequence *sequence, al_light_sample *sample);
/* The lamp alone, with certainty. False where the point is on it. */
bool al_gather_lamp(const al_gather_lights *lights, uint32_t lamp, const double position[3],
                    al_light_sample *sample);
/* The same light, drawn already, as another point meets it; density_per_sr is none of that point's. False
 * where the point is on it. */
bool al_gather_light_move(al_light_sample *sample, const double position[3]);
/* density_per_sr of a hit emitter, or of a direction of the sky whose radiance is given out. */
double al_gather_emitter_density(const al_gather_lights *lights, const al_ray *ray,
                                 const al_surface_hit *hit);
double al_gather_sky_density(const al_gather_lights *lights, const double direction[3], double radiance[3]);

/* Whether nothing opaque stands between an origin off its surface and the light. A lamp on a surface is in
 * front of it, from whichever side it is seen. */
bool al_gather_light_is_seen(const al_gather_lights *lights, const double origin[3],
                             const al_light_sample *sample);

#endif
