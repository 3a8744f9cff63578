/* The bake of one fog: its voxels as the bricks of a medium asset, and the sky's light in it. */
#ifndef AIRLIGHT_BAKE_MEDIUM_H
#define AIRLIGHT_BAKE_MEDIUM_H

#include "bake_step.h"

/* Whether the fog's density is another than a constant one. */
bool al_fog_varies(const al_import *import, uint32_t fog);
/* Whether the fog needs an asset: its density varies, or light of an environment is scattered in it. */
bool al_fog_has_asset(const al_import *import, uint32_t fog);

/* Name of the fog's file in the folder, as al_bake_object_file. */
void al_bake_medium_file(const al_import *import, uint32_t fog, char *name, size_t size);

/* Content hash of everything the asset depends on. */
al_status al_bake_medium_key(const al_import *import, uint32_t fog, uint64_t *key, al_error *error);

/* Writes the asset into the folder. A grid keeps its own voxels and transform; layers are sampled (docs/
 * scene.md); a constant density is one voxel. AL_BAD_INPUT when the density as floats takes more than options->memory_limit. */
al_status al_bake_medium(const al_import *import, uint32_t fog, uint64_t key, const al_bake_options *options,
                         al_steps *steps, al_error *error);

#endif
