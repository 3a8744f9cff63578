/* Optical depths inside a fog whose density varies, for the player's light from surfaces to places in it. */
#ifndef AIRLIGHT_FOG_DEPTH_H
#define AIRLIGHT_FOG_DEPTH_H

#include "airlight/medium.h"
#include "bake_step.h"

/* Why the fog keeps no optical depths; NULL: the scene file asks for them and they serve. */
const char *al_fog_depth_missing(const al_import *import, uint32_t fog);

typedef struct al_fog_depths {
    al_medium_depth depth;
    const al_medium_data *data; /* the densities */
    const al_bake_options *options;
    double seconds; /* that al_fog_depths_make took */
} al_fog_depths;

/* The lattice, with the order that the scene file asks for; data's info is complete. Adds the depths to *data. */
void al_fog_depths_place(const al_import *import, uint32_t fog, const al_bake_options *options, al_medium_data *data,
                         al_fog_depths *depths);
/* al_medium_depths_fn; the user is an al_fog_depths. AL_CANCELLED when the program is. */
al_status al_fog_depths_make(void *user, uint32_t frame, float *coefficients, al_error *error);

#endif
