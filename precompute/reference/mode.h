/* What airlight-reference can compute: one mode per file. */
#ifndef AIRLIGHT_MODE_H
#define AIRLIGHT_MODE_H

#include "ray_scene.h"

typedef struct al_mode {
    const char *name, *summary;
    /* The import must outlive the state. */
    al_status (*open)(const al_import *import, void **state, al_error *error);
    void (*close)(void *state);
    /* Random numbers one call of `radiance` takes. */
    uint32_t (*dimensions)(const void *state);
    /* Memory of one thread; NULL without memory. */
    void *(*scratch_new)(void);
    void (*scratch_free)(void *scratch);
    /* An unbiased estimate of the radiance that arrives along an eye ray, W/(m2 sr), from uniform random
     * numbers in [0, 1). False without memory. */
    bool (*radiance)(const void *state, void *scratch, const al_ray *eye, const double *random,
                     double radiance[3]);
} al_mode;

extern const al_mode al_mode_single_scatter;

#endif
