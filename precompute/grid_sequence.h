/* A sequence of OpenVDB grids as the frames of a medium asset. Every frame has a box of its own, of voxels of one
 * lattice; the asset's box holds all of them, and a frame is 0 there beyond its own. One frame is in memory at a time;
 * each file is read twice, once for its box. */
#ifndef AIRLIGHT_GRID_SEQUENCE_H
#define AIRLIGHT_GRID_SEQUENCE_H

#include <xxhash.h>

#include "airlight/medium.h"
#include "import.h"

typedef struct al_grid_sequence al_grid_sequence;

/* `data` describes the first frame alone; size, place, bounds, frames, times and slices become those of the sequence,
 * which must outlive it. Refuses frames of other voxels. */
al_status al_grid_sequence_open(const al_import *import, const al_medium_description *medium, al_medium_data *data,
                                al_grid_sequence **sequence, al_error *error);
void al_grid_sequence_close(al_grid_sequence *sequence); /* NULL is allowed */

/* Adds what a sequence's asset depends on beyond its first frame; nothing where there is no sequence. */
void al_grid_sequence_hash(XXH64_state_t *state, const al_import *import, const al_density_description *density);

#endif
