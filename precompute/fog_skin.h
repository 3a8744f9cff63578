/* Whether the grid of a fog resolves where light of surfaces enters it. */
#ifndef AIRLIGHT_FOG_SKIN_H
#define AIRLIGHT_FOG_SKIN_H

#include "airlight/medium.h"
#include "bake_step.h"

/* Whether the scene refuses a fog whose grid does not: it has surfaces, and does not ask for it all the same. */
bool al_fog_skin_refuses(const al_import *import);

typedef struct al_fog_skin {
    const al_medium_description *medium;
    const al_program *program;
    bool refuses, said;
    al_medium_data inner; /* what asks for the slices */
    double depth;         /* optical, of a voxel of density 1 in its densest channel */
    double stopped, thick; /* of the frame so far: shares of light, summed over its voxels; those of thick ones */
} al_fog_skin;

/* Looks at every slice that `data` gives from now on; nothing where the scene has no surface that sends light into the fog.
 * At a frame's last slice, where thick voxels do more than a quarter: AL_BAD_INPUT, or said where the scene file wants it
 * baked. `skin` is kept. */
void al_fog_skin_watch(const al_import *import, uint32_t fog, const al_bake_options *options, al_medium_data *data,
                       al_fog_skin *skin);

#endif
