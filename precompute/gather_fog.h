/* The fog along a ray: what all media of the scene's air do there together.
 *
 * Overlapping media add up. Constant ones are integrated in closed form; others by the midpoint rule in steps
 * of two voxels or half a layer, longer only where a stretch would take more than AL_FOG_STEP_LIMIT. Layers
 * without end are followed for that many steps. */
#ifndef AIRLIGHT_GATHER_FOG_H
#define AIRLIGHT_GATHER_FOG_H

#include "ray_scene.h"

typedef struct al_fog_medium {
    const al_density *density; /* NULL: constant, the coefficients are what they are inside the bounds */
    double sigma_s_per_m[3], sigma_t_per_m[3], g; /* at density 1 where there is one */
    double step_m;
    bool bounded;
    double low[3], high[3];
} al_fog_medium;

typedef struct al_fog_media {
    al_fog_medium *media; /* media that neither scatter nor absorb are left out */
    uint32_t count;
    bool grey; /* every coefficient is the same in the three channels */
    bool scatters;
    double g_limit; /* the largest |g| */
} al_fog_media;

al_status al_fog_media_create(const al_import *import, al_fog_media *fog, al_error *error);
void al_fog_media_free(al_fog_media *fog);

/* A stretch of a ray on which coefficients are taken as constant. */
typedef struct al_fog_cell {
    double begin_m, end_m; /* the end may be INFINITY */
    double sigma_s_per_m[3], sigma_t_per_m[3];
    double g;        /* mean, weighted by scattering */
    double depth[3]; /* optical depth from the ray's origin to begin_m */
} al_fog_cell;

enum { AL_FOG_STEP_LIMIT = 4096 };

/* The fog of one ray. Memory is reused from ray to ray; zero before the first use. */
typedef struct al_fog_path {
    al_fog_cell *cells; /* in order; vacuum between them is left out */
    uint32_t count, room;
    double depth[3]; /* optical depth of the whole */
    double *spans;   /* [medium][2]: from where to where each medium reaches */
} al_fog_path;
void al_fog_path_free(al_fog_path *path);

/* The fog from the ray's origin to end_m (INFINITY allowed). False without memory. */
bool al_fog_along(const al_fog_media *fog, const al_ray *ray, double end_m, al_fog_path *path);
/* The transmittance of an optical depth, per channel: one exponential in grey fog. */
void al_fog_transmit(const al_fog_media *fog, const double depth[3], double transmittance[3]);
/* Only the transmittance of that fog, per channel. */
void al_fog_transmittance(const al_fog_media *fog, const al_ray *ray, double end_m, double transmittance[3]);

/* The mean over the ray's first length_m, the last place with fog if it is INFINITY: what a table of
 * responses of an even medium is asked with. */
typedef struct al_fog_mean {
    double length_m;
    double sigma_s_per_m[3], sigma_t_per_m[3], g;
} al_fog_mean;
/* And the transmittance; `path` is memory. False without memory. */
bool al_fog_mean_along(const al_fog_media *fog, const al_ray *ray, double length_m, al_fog_path *path,
                       double transmittance[3], al_fog_mean *mean);

#endif
