#include "gather_light.h"

#include <math.h>

al_status al_gather_lights_create(const al_import *import, const al_ray_scene *rays, al_gather_lights *lights,
                                  al_error *error)
{
    *lights = (al_gather_lights){.scene = &import->scene, .rays = rays};
    al_status status = al_environment_sampler_create(&import->scene.environment, &lights->environment, error);
    return status ? status : al_emitters_create(import, rays, &lights->emitters, error);
}

void al_gather_lights_free(al_gather_lights *lights)
{
    al_environment_sampler_free(&lights->environment);
    al_emitters_free(lights->emitters);
    *lights = (al_gather_lights){0};
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* --- lamps --- */

bool al_gather_lamp(const al_gather_lights *lights, uint32_t lamp, const double position[3],
                    al_light_sample *sample)
{
    const al_light *light = &lights->scene->lights[lamp];
    double square = 0;
    *sample = (al_light_sample){.kind = AL_LIGHT_KIND_LAMP, .lamp = lamp, .cos_normal = 1};
    for (int k = 0; k < 3; k++) {
        sample->direction[k] =
            light->type == AL_LIGHT_POINT ? light->vector[k] - position[k] : -(double)light->vector[k];
        sample->target[k] = light->vector[k];
        sample->power[k] = light->intensity[k];
        square += sample->direction[k] * sample->direction[k];
    }
    if (!(square > 0)) return false;
    for (int k = 0; k < 3; k++) sample->direction[k] /= sqrt(square);
    sample->distance_m = light->type == AL_LIGHT_POINT ? sqrt(square) : INFINITY;
    sample->facing = light->type == AL_LIGHT_POINT ? 1 / square : 1;
    return isfinite(sample->facing);
}

/* Irradiance of an unshadowed lamp, all channels together; fluence without a normal. */
static double lamp_weight(const al_gather_lights *lights, uint32_t lamp, const double position[3],
                          const double *normal)
{
    al_light_sample sample;
    if (!al_gather_lamp(lights, lamp, position, &sample)) return 0;
    double cosine = normal ? fmax(0, dot(normal, sample.direction)) : 1;
    return cosine * sample.facing * (sample.power[0] + sample.power[1] + sample.power[2]);
}

/* One lamp in proportion to its weight. Two passes: lamps are few (64 at most), memory none. */
static bool sample_lamp(const al_gather_lights *lights, const double position[3], const double *normal,
                        double u, al_light_sample *sample)
{
    uint32_t count = lights->scene->light_count, chosen = 0;
    double total = 0, weight = 0, before = 0;
    if (count == 1) return al_gather_lamp(lights, 0, position, sample);
    for (uint32_t i = 0; i < count; i++) total += lamp_weight(lights, i, position, normal);
    if (!(total > 0 && isfinite(total))) return false;
    for (uint32_t i = 0; i < count && before <= u * total; i++) {
        double here = lamp_weight(lights, i, position, normal);
        if (!(here > 0)) continue;
        chosen = i;
        weight = here;
        before += here;
    }
    if (!al_gather_lamp(lights, chosen, position, sample)) return false;
    for (int c = 0; c < 3; c++) sample->power[c] *= total / weight;
    return true;
}

/* --- emissive surfaces --- */

static bool sample_emitter(const al_gather_lights *lights, const double position[3], const double u[3],
                           al_light_sample *sample)
{
    al_surface_hit point;
    double density_per_m2 = al_emitters_sample(lights->emitters, u, &point), towards[3];
    *sample = (al_light_sample){
        .kind = AL_LIGHT_KIND_EMITTER, .distance_m = 1, .double_sided = point.material->double_sided};
    if (!(density_per_m2 > 0)) return false;
    for (int k = 0; k < 3; k++) {
        towards[k] = position[k] - point.position[k];
        sample->normal[k] = point.normal[k];
        sample->power[k] = point.emission_w_m2_sr[k] / density_per_m2;
    }
    al_surface_offset(&point, towards, sample->target);
    if (!al_gather_light_move(sample, position)) return false;
    double square = sample->distance_m * sample->distance_m;
    sample->density_per_sr = sample->cos_normal > 0 ? density_per_m2 * square / sample->cos_normal : INFINITY;
    return true;
}

double al_gather_emitter_density(const al_gather_lights *lights, const al_ray *ray, const al_surface_hit *hit)
{
    double cosine = fabs(dot(hit->normal, ray->direction));
    if (!al_emitters_count(lights->emitters) || !(cosine > 0)) return 0;
    return al_emitters_density(lights->emitters, hit->material) * hit->distance_m * hit->distance_m / cosine;
}

/* --- the sky --- */

static bool sample_sky(const al_gather_lights *lights, const double u[2], al_light_sample *sample)
{
    if (!lights->environment.map) return false;
    *sample =
        (al_light_sample){.kind = AL_LIGHT_KIND_SKY, .distance_m = INFINITY, .facing = 1, .cos_normal = 1};
    al_environment_sample(&lights->environment, u, sample->direction);
    sample->density_per_sr = al_environment_density(&lights->environment, sample->direction, sample->power);
    if (!(sample->density_per_sr > 0)) return false;
    for (int c = 0; c < 3; c++) sample->power[c] /= sample->density_per_sr;
    return true;
}

double al_gather_sky_density(const al_gather_lights *lights, const double direction[3], double radiance[3])
{
    radiance[0] = radiance[1] = radiance[2] = 0;
    return lights->environment.map ? al_environment_density(&lights->environment, direction, radiance) : 0;
}

/* --- any --- */

bool al_gather_light_move(al_light_sample *sample, const double position[3])
{
    double square = 0, cosine = 0;
    if (isinf(sample->distance_m)) return true;
    for (int k = 0; k < 3; k++) {
        sample->direction[k] = sample->target[k] - position[k];
        square += sample->direction[k] * sample->direction[k];
    }
    sample->distance_m = sqrt(square);
    if (!(square > 0)) return false;
    for (int k = 0; k < 3; k++) {
        sample->direction[k] /= sample->distance_m;
        cosine -= sample->normal[k] * sample->direction[k];
    }
    if (sample->kind == AL_LIGHT_KIND_EMITTER)
        sample->cos_normal = sample->double_sided ? fabs(cosine) : cosine;
    sample->facing = fmax(0, sample->cos_normal) / square;
    return isfinite(sample->facing);
}

bool al_gather_light_sample(const al_gather_lights *lights, al_light_kind kind, const double position[3],
                            const double *normal, al_sequence *sequence, al_light_sample *sample)
{
    double u[2] = {0}, which[2] = {0};
    bool drawn = false;
    if (kind == AL_LIGHT_KIND_LAMP && lights->scene->light_count) {
        if (lights->scene->light_count > 1) al_sequence_pair(sequence, which);
        drawn = sample_lamp(lights, position, normal, which[0], sample);
    } else if (kind == AL_LIGHT_KIND_EMITTER && al_emitters_count(lights->emitters)) {
        al_sequence_pair(sequence, u);
        if (al_emitters_count(lights->emitters) > 1) al_sequence_pair(sequence, which);
        drawn = sample_emitter(lights, position, (double[]){which[0], u[0], u[1]}, sample);
    } else if (kind == AL_LIGHT_KIND_SKY && lights->environment.map) {
        al_sequence_pair(sequence, u);
        drawn = sample_sky(lights, u, sample);
    }
    return drawn && (!normal || dot(normal, sample->direction) > 0);
}

bool al_gather_light_is_seen(const al_gather_lights *lights, const double origin[3],
                             const al_light_sample *sample)
{
    al_ray ray;
    double length_m = sample->distance_m, square = 0;
    for (int k = 0; k < 3; k++) {
        ray.origin[k] = origin[k];
        ray.direction[k] = isinf(length_m) ? sample->direction[k] : sample->target[k] - origin[k];
        square += ray.direction[k] * ray.direction[k];
    }
    if (isinf(length_m)) return !al_ray_scene_is_blocked(lights->rays, &ray, INFINITY);
    if (!(square > 0)) return true;
    for (int k = 0; k < 3; k++) ray.direction[k] /= sqrt(square);
    /* A lamp on a surface is in front of it. Emitters' targets are off theirs already. */
    double step_m = sample->kind == AL_LIGHT_KIND_LAMP ? al_ray_scene_offset_m(lights->rays) : 0;
    return !al_ray_scene_is_blocked(lights->rays, &ray, sqrt(square) - step_m);
}
