/* Light of the environment inside a fog, for the player's fog to the eye. */
#ifndef AIRLIGHT_SKY_LIGHT_H
#define AIRLIGHT_SKY_LIGHT_H

#include "airlight/medium.h"
#include "bake_step.h"

/* Whether light of an environment reaches the fog and is scattered there. NULL: yes; else why not. */
const char *al_sky_light_missing(const al_import *import, uint32_t fog);

typedef struct al_sky_light {
    al_medium_sky sky; /* planes point to those below */
    float *values;     /* as al_medium_data.sky_values */
    uint8_t *planes;
} al_sky_light;

/* The lattice spans the bounds of `info`; of a density that moves its first frame counts. AL_CANCELLED when the
 * program is. */
al_status al_sky_light_make(const al_import *import, uint32_t fog, const al_medium_info *info,
                            const al_bake_options *options, al_sky_light *light, al_error *error);
void al_sky_light_free(al_sky_light *light); /* safe on a zeroed one */

#endif
