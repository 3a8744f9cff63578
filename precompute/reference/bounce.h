/* Light that goes from a lamp to a surface and off it to a receiver: the legs that modes of one bounce share.
 *
 * Surfaces are two-sided Lambert of base colour times 1 - metallic, with geometric normals. The first leg is
 * shadowed and attenuated; of the second, surface to receiver, either can be left out. A path (point of a
 * lamp, surface, receiver) is drawn from the receiver, where a direction meets a surface ("gathered"), or
 * from the lamp, where a ray of its light meets a surface ("shot"), which draws in proportion to the
 * irradiance. The point of the lamp is drawn alike in both. */
#ifndef AIRLIGHT_BOUNCE_H
#define AIRLIGHT_BOUNCE_H

#include "lamps.h"
#include "media.h"
#include "mode.h"

typedef struct al_bounce {
    al_mode_options options;
    al_ray_scene *scene;
    al_media media;
    al_lamps lamps;
} al_bounce;

/* The import must outlive the bounce. */
al_status al_bounce_create(const al_import *import, const al_mode_options *options, al_bounce *bounce,
                           al_error *error);
void al_bounce_free(al_bounce *bounce);

/* A surface that a ray of a lamp's light meets, and that lamp, for u in [0,1)^AL_BOUNCE_SHOT_NUMBERS. False
 * where there is none. */
enum { AL_BOUNCE_SHOT_NUMBERS = AL_LAMP_NUMBERS + AL_LAMP_SHOT_NUMBERS };
bool al_bounce_shoot(const al_bounce *bounce, const double u[AL_BOUNCE_SHOT_NUMBERS], al_lamp *lamp,
                     al_surface_hit *surface);
/* The next surface along a gathered ray, which moves on behind it: without visibility all of them count, else
 * the first, and a ray that has moved meets nothing. */
bool al_bounce_gather(const al_bounce *bounce, al_ray *ray, uint32_t met, al_surface_hit *surface);

typedef struct al_bounce_link {
    const al_surface_hit *surface;
    double place[3];                       /* on the surface, off it to the lit side */
    double receiver[3], towards[3], end_m; /* from the receiver to the place */
    double m2_per_sr;                      /* of the surface, as the receiver sees it */
    double shot_per_m2;                    /* how densely al_bounce_shoot draws here */
    double cosine;                         /* towards the lamp */
    al_lamp_light light;
} al_bounce_link;

/* False where the lamp does not shine on the side of the surface that the receiver sees. Both must outlive
 * the link. */
bool al_bounce_connect(const al_bounce *bounce, const al_lamp *lamp, const al_surface_hit *surface,
                       const double receiver[3], al_bounce_link *link);
/* Whether a surface is in the way of the second leg. */
bool al_bounce_is_hidden(const al_bounce *bounce, const al_bounce_link *link);
/* Multiplies by the radiance that arrives at the receiver, all but the second leg's shadow. False without
 * memory. */
bool al_bounce_carry(const al_bounce *bounce, const al_bounce_link *link, al_media_line *line,
                     al_random *random, double power[3]);

#endif
