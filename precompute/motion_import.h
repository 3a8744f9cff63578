/* What moves, on its way into the scene: nodes, what hangs on them, and keys of the scene file. */
#ifndef AIRLIGHT_MOTION_IMPORT_H
#define AIRLIGHT_MOTION_IMPORT_H

#include "import.h"

al_status al_motion_add_node(al_import *import, const al_motion_node *node, uint32_t *index, al_error *error);
/* `name` is copied; parent and pivot as said at al_motion_add_keys. */
al_status al_motion_add_channel(al_import *import, const al_motion_channel *channel, al_error *error);
/* Hangs an instance, light or camera on a node. */
al_status al_motion_bind(al_import *import, al_motion_kind kind, uint32_t index, uint32_t node,
                         const double local[16], al_error *error);

/* Keys of the scene file as a node that turns and scales about `pivot`: world = move(pivot) T R S, to be bound
 * with local = move(-pivot) (what the object's matrix is without motion). */
al_status al_motion_add_keys(al_import *import, const char *name, const al_motion_description *motion,
                             const double pivot[3], uint32_t *node, al_error *error);

/* Lights, cameras and fogs of the scene file that have keys; fogs turn about the middle of their bounds. */
al_status al_motion_bind_described(al_import *import, al_error *error);

/* Brings channels and bindings into their order, puts everything where it is at time 0, lets go of deforms that
 * nothing moves, and gives what moves a lighting that allows it. */
al_status al_motion_finish(al_import *import, al_error *error);

#endif
