/* The lamps of a scene as light that comes to surfaces: one point, or one direction, of one lamp at a time.
 *
 * A lamp is a point light, a directional light, all emissive surfaces together, or the environment. World
 * space, metres. */
#ifndef AIRLIGHT_LAMPS_H
#define AIRLIGHT_LAMPS_H

#include "emitters.h"
#include "environment_sampler.h"

typedef struct al_lamps {
    const al_light *lights;
    uint32_t light_count, count; /* of point and directional lights; of all lamps */
    al_emitters *emitters;
    al_environment_sampler environment;
    double center[3], radius_m; /* of a ball around all surfaces */
} al_lamps;

/* Import and scene must outlive the lamps. */
al_status al_lamps_create(const al_import *import, const al_ray_scene *scene, al_lamps *lamps,
                          al_error *error);
void al_lamps_free(al_lamps *lamps);

typedef enum al_lamp_kind { AL_LAMP_POINT, AL_LAMP_EMITTER, AL_LAMP_FAR } al_lamp_kind;

/* What was drawn. `power` is divided by the probability of drawing it: its expectation over draws is the
 * lamps' light. */
typedef struct al_lamp {
    al_lamp_kind kind;
    double power[3];        /* POINT: W/sr; EMITTER: W/(m2 sr) times m2; FAR: W/m2 facing it */
    double position[3];     /* POINT */
    double towards[3];      /* FAR: directional light or environment */
    al_surface_hit emitter; /* EMITTER */
} al_lamp;

enum { AL_LAMP_NUMBERS = 4, AL_LAMP_SHOT_NUMBERS = 2 };

/* For u in [0,1)^AL_LAMP_NUMBERS. False where there is nothing that shines. */
bool al_lamps_draw(const al_lamps *lamps, const double u[AL_LAMP_NUMBERS], al_lamp *lamp);

/* The unshadowed light of a lamp at a place: where it comes from, from how far, and its irradiance on a plane
 * that faces it, W/m2. False where the lamp does not shine there. */
typedef struct al_lamp_light {
    double towards[3], end_m, irradiance[3];
} al_lamp_light;
bool al_lamp_shine(const al_lamp *lamp, const double position[3], al_lamp_light *light);

/* A ray of the lamp's light, for u in [0,1)^2: what surfaces it meets is drawn in proportion to their
 * unshadowed irradiance. */
void al_lamps_shoot(const al_lamps *lamps, const al_lamp *lamp, const double u[AL_LAMP_SHOT_NUMBERS],
                    al_ray *ray);
/* Probability per square metre of meeting a visible surface there whose normal makes the angle of this cosine
 * (> 0) with the direction to the lamp. `light` is al_lamp_shine's answer there. */
double al_lamps_shot_density(const al_lamps *lamps, const al_lamp *lamp, const al_lamp_light *light,
                             double cosine);

#endif
