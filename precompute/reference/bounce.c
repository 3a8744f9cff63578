#include "bounce.h"

#include <math.h>
#include <string.h>

#include "directions.h"

al_status al_bounce_create(const al_import *import, const al_mode_options *options, al_bounce *bounce,
                           al_error *error)
{
    *bounce = (al_bounce){.options = *options};
    al_status status = al_ray_scene_create(import, AL_RAY_SCENE_ALL, &bounce->scene, error);
    if (!status) status = al_media_create(import, &bounce->media, error);
    if (!status) status = al_lamps_create(import, bounce->scene, &bounce->lamps, error);
    if (status) al_bounce_free(bounce);
    return status;
}

void al_bounce_free(al_bounce *bounce)
{
    al_lamps_free(&bounce->lamps);
    al_media_free(&bounce->media);
    al_ray_scene_free(bounce->scene);
    *bounce = (al_bounce){0};
}

/* A lamp on a surface shines to both sides of it and does not light it: such a surface lets the ray pass. */
static bool lies_on(const al_bounce *bounce, const al_lamp *lamp, const al_surface_hit *surface)
{
    double square = 0, near_m = 2 * al_ray_scene_offset_m(bounce->scene);
    for (int k = 0; k < 3; k++) {
        double off = surface->position[k] - lamp->position[k];
        square += off * off;
    }
    return lamp->kind == AL_LAMP_POINT && square < near_m * near_m;
}

bool al_bounce_shoot(const al_bounce *bounce, const double u[AL_BOUNCE_SHOT_NUMBERS], al_lamp *lamp,
                     al_surface_hit *surface)
{
    al_ray ray;
    if (!al_lamps_draw(&bounce->lamps, u, lamp)) return false;
    al_lamps_shoot(&bounce->lamps, lamp, u + AL_LAMP_NUMBERS, &ray);
    while (al_ray_scene_hit(bounce->scene, &ray, INFINITY, surface)) {
        if (!lies_on(bounce, lamp, surface)) return true;
        al_surface_offset(surface, ray.direction, ray.origin);
    }
    return false;
}

bool al_bounce_gather(const al_bounce *bounce, al_ray *ray, uint32_t met, al_surface_hit *surface)
{
    if (met && !bounce->options.no_visibility) return false;
    if (!al_ray_scene_hit(bounce->scene, ray, INFINITY, surface)) return false;
    al_surface_offset(surface, ray->direction, ray->origin);
    return true;
}

bool al_bounce_connect(const al_bounce *bounce, const al_lamp *lamp, const al_surface_hit *surface,
                       const double receiver[3], al_bounce_link *link)
{
    double back[3], square = 0;
    link->surface = surface;
    for (int k = 0; k < 3; k++) back[k] = receiver[k] - surface->position[k];
    al_surface_offset(surface, back, link->place);
    for (int k = 0; k < 3; k++) {
        link->receiver[k] = receiver[k];
        link->towards[k] = link->place[k] - receiver[k];
        square += link->towards[k] * link->towards[k];
    }
    if (!(square > 0) || !al_lamp_shine(lamp, link->place, &link->light)) return false;
    link->end_m = sqrt(square);
    for (int k = 0; k < 3; k++) link->towards[k] /= link->end_m;
    double seen = -al_dot(surface->normal, link->towards), lit = al_dot(surface->normal, link->light.towards);
    link->cosine = fabs(lit);
    link->m2_per_sr = square / fabs(seen);
    link->shot_per_m2 = al_lamps_shot_density(&bounce->lamps, lamp, &link->light, link->cosine);
    return seen * lit > 0;
}

static al_ray ray_from(const double from[3], const double towards[3])
{
    return (al_ray){{from[0], from[1], from[2]}, {towards[0], towards[1], towards[2]}};
}

/* What lies at the end itself is not in the way. */
static bool is_blocked(const al_bounce *bounce, const al_ray *ray, double end_m)
{
    return al_ray_scene_is_blocked(bounce->scene, ray, end_m - al_ray_scene_offset_m(bounce->scene));
}

bool al_bounce_is_hidden(const al_bounce *bounce, const al_bounce_link *link)
{
    al_ray ray = ray_from(link->receiver, link->towards);
    return !bounce->options.no_visibility && is_blocked(bounce, &ray, link->end_m);
}

static bool attenuate(const al_bounce *bounce, const al_ray *ray, double end_m, al_media_line *line,
                      al_random *random, double power[3])
{
    if (!al_media_line_fill(&bounce->media, bounce->scene, ray, end_m, line)) return false;
    al_media_attenuate(line, end_m, random, power);
    return true;
}

bool al_bounce_carry(const al_bounce *bounce, const al_bounce_link *link, al_media_line *line,
                     al_random *random, double power[3])
{
    al_ray first = ray_from(link->place, link->light.towards),
           second = ray_from(link->receiver, link->towards);
    for (int c = 0; c < 3; c++)
        power[c] *= link->surface->albedo[c] / AL_PI * link->cosine * link->light.irradiance[c];
    if (!(power[0] > 0 || power[1] > 0 || power[2] > 0)) return true;
    if (is_blocked(bounce, &first, link->light.end_m)) {
        memset(power, 0, 3 * sizeof *power);
        return true;
    }
    if (!attenuate(bounce, &first, link->light.end_m, line, random, power)) return false;
    return bounce->options.no_attenuation || attenuate(bounce, &second, link->end_m, line, random, power);
}
