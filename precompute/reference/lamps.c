#include "lamps.h"

#include <math.h>
#include <string.h>

#include "directions.h"

al_status al_lamps_create(const al_import *import, const al_ray_scene *scene, al_lamps *lamps,
                          al_error *error)
{
    double low[3], high[3], square = 0;
    *lamps = (al_lamps){.lights = import->scene.lights, .light_count = import->scene.light_count};
    al_status status = al_environment_sampler_create(&import->scene.environment, &lamps->environment, error);
    if (!status) status = al_emitters_create(import, scene, &lamps->emitters, error);
    if (status) {
        al_lamps_free(lamps);
        return status;
    }
    lamps->count = lamps->light_count + (al_emitters_count(lamps->emitters) > 0) + !!lamps->environment.map;
    al_ray_scene_bounds(scene, low, high);
    for (int k = 0; k < 3; k++) {
        lamps->center[k] = 0.5 * (low[k] + high[k]);
        square += 0.25 * (high[k] - low[k]) * (high[k] - low[k]);
    }
    lamps->radius_m = 1.001 * sqrt(square);
    return AL_OK;
}

void al_lamps_free(al_lamps *lamps)
{
    al_emitters_free(lamps->emitters);
    al_environment_sampler_free(&lamps->environment);
    *lamps = (al_lamps){0};
}

/* --- drawing --- */

static void draw_light(const al_light *light, double scale, al_lamp *lamp)
{
    double length = hypot(hypot(light->vector[0], light->vector[1]), light->vector[2]);
    lamp->kind = light->type == AL_LIGHT_POINT ? AL_LAMP_POINT : AL_LAMP_FAR;
    for (int k = 0; k < 3; k++) {
        lamp->power[k] = scale * light->intensity[k];
        lamp->position[k] = light->vector[k];
        lamp->towards[k] = length > 0 ? -light->vector[k] / length : 0;
    }
}

static void draw_emitter(const al_lamps *lamps, const double u[3], double scale, al_lamp *lamp)
{
    lamp->kind = AL_LAMP_EMITTER;
    double per_m2 = al_emitters_sample(lamps->emitters, u, &lamp->emitter);
    for (int c = 0; c < 3; c++) lamp->power[c] = scale * lamp->emitter.emission_w_m2_sr[c] / per_m2;
}

static bool draw_sky(const al_lamps *lamps, const double u[2], double scale, al_lamp *lamp)
{
    double radiance[3];
    lamp->kind = AL_LAMP_FAR;
    al_environment_sample(&lamps->environment, u, lamp->towards);
    double density = al_environment_density(&lamps->environment, lamp->towards, radiance);
    for (int c = 0; c < 3; c++) lamp->power[c] = density > 0 ? scale * radiance[c] / density : 0;
    return density > 0;
}

bool al_lamps_draw(const al_lamps *lamps, const double u[AL_LAMP_NUMBERS], al_lamp *lamp)
{
    uint32_t index = (uint32_t)(u[0] * lamps->count);
    double scale = lamps->count; /* each has one chance in `count` */
    if (!lamps->count) return false;
    if (index < lamps->light_count)
        draw_light(&lamps->lights[index], scale, lamp);
    else if (index == lamps->light_count && al_emitters_count(lamps->emitters))
        draw_emitter(lamps, u + 1, scale, lamp);
    else
        return draw_sky(lamps, u + 1, scale, lamp);
    return true;
}

/* --- light at a place --- */

bool al_lamp_shine(const al_lamp *lamp, const double position[3], al_lamp_light *light)
{
    double source[3], back[3], square = 0, cosine = 1;
    if (lamp->kind == AL_LAMP_FAR) {
        light->end_m = INFINITY;
        memcpy(light->towards, lamp->towards, sizeof light->towards);
        memcpy(light->irradiance, lamp->power, sizeof light->irradiance);
        return true;
    }
    memcpy(source, lamp->position, sizeof source);
    if (lamp->kind == AL_LAMP_EMITTER) {
        for (int k = 0; k < 3; k++) back[k] = position[k] - lamp->emitter.position[k];
        al_surface_offset(&lamp->emitter, back, source);
    }
    for (int k = 0; k < 3; k++) {
        light->towards[k] = source[k] - position[k];
        square += light->towards[k] * light->towards[k];
    }
    if (!(square > 0)) return false;
    light->end_m = sqrt(square);
    for (int k = 0; k < 3; k++) light->towards[k] /= light->end_m;
    if (lamp->kind == AL_LAMP_EMITTER) {
        cosine = -al_dot(lamp->emitter.normal, light->towards);
        if (lamp->emitter.material->double_sided) cosine = fabs(cosine);
    }
    for (int c = 0; c < 3; c++) light->irradiance[c] = lamp->power[c] * cosine / square;
    return cosine > 0;
}

/* --- shooting --- */

static void shoot_emitter(const al_surface_hit *emitter, const double u[2], al_ray *ray)
{
    double side = 1, up = u[0], axis[3];
    if (emitter->material->double_sided) {
        side = u[0] < 0.5 ? 1 : -1;
        up = 2 * u[0] - (u[0] < 0.5 ? 0 : 1);
    }
    for (int k = 0; k < 3; k++) axis[k] = side * emitter->normal[k];
    al_direction_about(axis, sqrt(1 - up), 2 * AL_PI * u[1], ray->direction);
    al_surface_offset(emitter, ray->direction, ray->origin);
}

/* From a disc before the ball around all surfaces. */
static void shoot_far(const al_lamps *lamps, const double towards[3], const double u[2], al_ray *ray)
{
    double a[3], b[3], radius = lamps->radius_m * sqrt(u[0]), phi = 2 * AL_PI * u[1];
    al_axes_across(towards, a, b);
    for (int k = 0; k < 3; k++) {
        ray->direction[k] = -towards[k];
        ray->origin[k] =
            lamps->center[k] + lamps->radius_m * towards[k] + radius * (cos(phi) * a[k] + sin(phi) * b[k]);
    }
}

void al_lamps_shoot(const al_lamps *lamps, const al_lamp *lamp, const double u[AL_LAMP_SHOT_NUMBERS],
                    al_ray *ray)
{
    static const double up[3] = {0, 0, 1};
    switch (lamp->kind) {
    case AL_LAMP_POINT:
        memcpy(ray->origin, lamp->position, sizeof ray->origin);
        al_direction_about(up, 1 - 2 * u[0], 2 * AL_PI * u[1], ray->direction);
        break;
    case AL_LAMP_EMITTER:
        shoot_emitter(&lamp->emitter, u, ray);
        break;
    case AL_LAMP_FAR:
        shoot_far(lamps, lamp->towards, u, ray);
        break;
    }
}

/* Rays per steradian of a point light and of an emitter, per square metre of a disc far away. */
double al_lamps_shot_density(const al_lamps *lamps, const al_lamp *lamp, const al_lamp_light *light,
                             double cosine)
{
    double rays = 1 / (4 * AL_PI);
    if (lamp->kind == AL_LAMP_FAR) return cosine / (AL_PI * lamps->radius_m * lamps->radius_m);
    if (lamp->kind == AL_LAMP_EMITTER) {
        double sides = lamp->emitter.material->double_sided ? 2 : 1;
        rays = fabs(al_dot(lamp->emitter.normal, light->towards)) / (sides * AL_PI);
    }
    return rays * cosine / (light->end_m * light->end_m);
}
