/* What the steps of a bake share: its options, the record of what was done, the names of assets. */
#ifndef AIRLIGHT_BAKE_STEP_H
#define AIRLIGHT_BAKE_STEP_H

#include "airlight/program.h"
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

/* Adds what was done since `started_s` (al_program_seconds); beyond the limit it is left out. */
void al_steps_add(al_steps *steps, const char *name, double started_s, uint64_t bytes_written,
                  uint64_t items);

typedef struct al_bake_options {
    const al_program *program;
    const char *folder;
    unsigned threads;
    size_t memory_limit; /* bytes for the sweep's fields */
} al_bake_options;

/* NAME.KIND.air, in at most `size` (160 are enough) bytes with the terminator. Names that differ give files
 * that differ: where a name cannot stand in a file name, its hash is added. */
void al_asset_file(const char *name, const char *kind, char *file, size_t size);
/* The same for the one asset of a kind that a scene has: named after the scene file. */
void al_scene_asset_file(const al_import *import, const char *kind, char *file, size_t size);

#endif
