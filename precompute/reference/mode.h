/* What airlight-reference can compute: one mode per file. */
#ifndef AIRLIGHT_MODE_H
#define AIRLIGHT_MODE_H

#include <math.h>

#include "ray_scene.h"

typedef struct al_mode_options {
    /* volume-path: which paths count, to look at a part of the light alone. */
    uint32_t min_events, max_events; /* scattering events in media */
    uint32_t max_bounces;            /* reflections off surfaces; 0: surfaces are black */
    /* surface-to-volume and indirect: what is left out between the surface and its receiver. */
    bool no_visibility;  /* no surface is in the way */
    bool no_attenuation; /* no medium is */
    double radius_m;     /* ambient-occlusion: how far surfaces count */
} al_mode_options;

static const al_mode_options al_mode_defaults = {
    .max_events = UINT32_MAX, .max_bounces = UINT32_MAX, .radius_m = INFINITY};

enum { AL_PROBE_ORDER = 3, AL_PROBE_COUNT = AL_PROBE_ORDER * AL_PROBE_ORDER };

/* A place that receives light: a surface with a unit normal, or a probe with the normal 0. */
typedef struct al_receiver {
    double position[3], normal[3];
} al_receiver;

typedef struct al_mode {
    const char *name, *summary;
    /* The import must outlive the state. */
    al_status (*open)(const al_import *import, const al_mode_options *options, void **state, al_error *error);
    void (*close)(void *state);
    /* Random numbers one call of `radiance` or `receive` takes. */
    uint32_t (*dimensions)(const void *state);
    /* Memory of one thread; NULL without memory. */
    void *(*scratch_new)(void);
    void (*scratch_free)(void *scratch);
    /* An unbiased estimate of the radiance that arrives along an eye ray, W/(m2 sr), from uniform random
     * numbers in [0, 1). False without memory. */
    bool (*radiance)(const void *state, void *scratch, const al_ray *eye, const double *random,
                     double radiance[3]);
    /* The same of a receiver: irradiance in out[0], W/m2, of a surface; the SH coefficients of incident
     * radiance, out[AL_PROBE_COUNT], of a probe. NULL: the mode has none. */
    bool (*receive)(const void *state, void *scratch, const al_receiver *receiver, const double *random,
                    double (*out)[3]);
} al_mode;

extern const al_mode al_mode_ambient_occlusion, al_mode_indirect, al_mode_single_scatter,
    al_mode_surface_to_volume, al_mode_volume_path;

#endif
