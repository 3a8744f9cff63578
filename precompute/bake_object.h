/* The bake of one translucent object: voxelise, optical depth, moment, divergence, sample, project, write. */
#ifndef AIRLIGHT_BAKE_OBJECT_H
#define AIRLIGHT_BAKE_OBJECT_H

#include <xxhash.h>

#include "airlight/program.h"
#include "device.h"
#include "import.h"

enum { AL_STEP_LIMIT = 16 };

typedef struct al_step { /* what report.json says of a step */
    const char *name;
    double seconds;
    uint64_t bytes_written, items;
} al_step;

typedef struct al_steps {
    al_step steps[AL_STEP_LIMIT];
    unsigned count;
} al_steps;

typedef struct al_bake_options {
    const al_program *program;
    const char *folder;
    unsigned threads;
    size_t memory_limit; /* bytes for the sweep's fields */
} al_bake_options;

/* Name of the asset's file in the folder, at most `size` (160 are enough) bytes with its terminator. Names
 * that differ give files that differ: where the object's own cannot stand in a file name, its hash is added.
 */
void al_bake_object_file(const al_translucent_object *object, char *name, size_t size);

/* NAME.KIND.air, made safe in the same way. */
void al_asset_file(const char *name, const char *kind, char *file, size_t size);
/* The same for the one asset of a kind that a scene has: named after the scene file. */
void al_scene_asset_file(const al_import *import, const char *kind, char *file, size_t size);

/* Adds what a density depends on, the contents of its file included. */
void al_hash_density(XXH64_state_t *state, const al_import *import, const al_density_description *density);

/* Content hash of everything the asset depends on. */
al_status al_bake_object_key(const al_import *import, uint32_t index, uint64_t *key, al_error *error);

/* Bakes object `index` into the folder. Cancelled: what is done is kept beside the asset as NAME.partial and
 * the next call with the same key goes on from there, to the same bytes. */
al_status al_bake_object(const al_import *import, uint32_t index, uint64_t key, al_device *device,
                         const al_bake_options *options, al_steps *steps, al_error *error);

#endif
