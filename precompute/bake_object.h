/* The bake of one translucent object: voxelise, optical depth, moment, divergence, sample, project, write. */
#ifndef AIRLIGHT_BAKE_OBJECT_H
#define AIRLIGHT_BAKE_OBJECT_H

#include <xxhash.h>

#include "bake_step.h"
#include "device.h"

/* Name of the asset's file in the folder, as al_asset_file. */
void al_bake_object_file(const al_translucent_object *object, char *name, size_t size);

/* Adds what a density depends on, the contents of its file included. */
void al_hash_density(XXH64_state_t *state, const al_import *import, const al_density_description *density);

/* Content hash of everything the asset depends on. */
al_status al_bake_object_key(const al_import *import, uint32_t index, uint64_t *key, al_error *error);

/* Bakes object `index` into the folder. Cancelled: what is done is kept beside the asset as NAME.partial and
 * the next call with the same key goes on from there, to the same bytes. */
al_status al_bake_object(const al_import *import, uint32_t index, uint64_t key, al_device *device,
                         const al_bake_options *options, al_steps *steps, al_error *error);

#endif
