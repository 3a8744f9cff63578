/* The bake of a scene's light probes: place, gather, leave out those inside walls, join into tetrahedra,
 * write. */
#ifndef AIRLIGHT_BAKE_PROBES_H
#define AIRLIGHT_BAKE_PROBES_H

#include "airlight/impulse_tables.h"
#include "bake_step.h"

/* Name of the asset's file in the folder, from the scene file's name. */
void al_bake_probes_file(const al_import *import, char *name, size_t size);

/* Content hash of everything the probes depend on; the key of the tables, 0 without. */
al_status al_bake_probes_key(const al_import *import, uint64_t tables_key, uint64_t *key, al_error *error);

/* Bakes the probes into the folder. Probes that are done are kept beside the asset as NAME.partial: after a
 * stop the next call with the same key goes on from there, to the same bytes, on any number of threads.
 * tables may be NULL where the gathering needs none. */
al_status al_bake_probes(const al_import *import, uint64_t key, const al_impulse_tables *tables,
                         const al_bake_options *options, al_steps *steps, al_error *error);

#endif
