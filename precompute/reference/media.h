/* Fogs and the media of translucent objects along rays, by random tracking: unbiased, whatever the density.
 */
#ifndef AIRLIGHT_MEDIA_H
#define AIRLIGHT_MEDIA_H

#include "march.h"
#include "sampling.h"

typedef struct al_media {
    struct al_tracked_medium *media; /* [fog_count + object_count]: fogs, then translucent objects */
    uint32_t fog_count, object_count;
} al_media;

al_status al_media_create(const al_import *import, al_media *media, al_error *error);
void al_media_free(al_media *media);

typedef struct al_media_part { /* a stretch of a ray on which a medium may be */
    uint32_t medium;
    double begin_m, end_m;
    double next_m; /* private to al_media_fly */
} al_media_part;

/* Media along one ray, and memory of one thread, reused from ray to ray. Zero before the first use. */
typedef struct al_media_line {
    const al_media *media;
    const al_ray *ray;    /* must outlive the line's use */
    al_media_part *parts; /* they overlap where media do, and are in no order */
    uint32_t part_count, part_room;
    al_line segments;
    al_march_part *marched; /* [part_room] */
} al_media_line;
void al_media_line_free(al_media_line *line);

/* Fills the line for the ray from its origin to `end_m` (INFINITY allowed). False without memory. */
bool al_media_line_fill(const al_media *media, const al_ray_scene *scene, const al_ray *ray, double end_m,
                        al_media_line *line);

typedef struct al_flight {
    bool scattered; /* in `medium` at `distance_m`; else the end was reached */
    double distance_m;
    uint32_t medium;
} al_flight;

/* Flies along the line until it scatters or reaches the end; `throughput` is multiplied by what that is
 * worth. */
al_flight al_media_fly(al_media_line *line, double end_m, al_random *random, double throughput[3]);

/* Multiplies `throughput` by an unbiased estimate of the transmittance from the line's origin to `end_m`. */
void al_media_attenuate(const al_media_line *line, double end_m, al_random *random, double throughput[3]);

/* The same in closed form, without noise: the integrals of march.h. */
void al_media_transmittance(const al_media_line *line, double end_m, double transmittance[3]);
/* Fills `cells` for the line; a medium without bounds ends where nothing comes through it any more. False
 * without memory. */
bool al_media_cells(al_media_line *line, al_cells *cells);

/* What a part of the line scatters with at a distance; false where it is not or is empty. */
bool al_media_part_scatters(const al_media_line *line, uint32_t part, double distance_m,
                            double sigma_s_per_m[3], double *g);
/* About the probability per metre with which al_media_fly scatters at a distance: the same number every time.
 */
double al_media_flight_density(const al_media_line *line, double distance_m);
double al_media_asymmetry(const al_media *media, uint32_t medium);

#endif
