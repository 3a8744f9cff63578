/* Animations, skins and morph targets of one glTF file into the scene's motion. */
#ifndef AIRLIGHT_GLTF_MOTION_H
#define AIRLIGHT_GLTF_MOTION_H

#include "geometry.h"
#include "gltf_file.h"

typedef struct al_gltf_motion al_gltf_motion;

/* `placement` takes the file's space to the world, as it is under `parent`, a node of the scene's motion or
 * AL_NO_INDEX. `animation`: the only one to take, "" for all; where several move the same property of a node,
 * the first in the file counts. All pointers must outlive the result. */
al_status al_gltf_motion_open(al_import *import, al_gltf *file, const char *name, const char *animation,
                              const double placement[16], uint32_t parent, al_gltf_motion **motion,
                              al_error *error);
void al_gltf_motion_close(al_gltf_motion *motion); /* NULL is allowed */

/* Whether the file's node, or one above it, is animated. */
bool al_gltf_motion_moves(const al_gltf_motion *motion, uint32_t node);
/* The scene's node for a node of the file; made on first use. */
al_status al_gltf_motion_node(al_gltf_motion *motion, uint32_t node, uint32_t *index, al_error *error);
/* The channels of all nodes that were made, once all are. */
al_status al_gltf_motion_finish(al_gltf_motion *motion, al_error *error);

/* --- meshes with a skin or morph targets --- */

bool al_gltf_motion_deforms(const al_gltf_motion *motion, uint32_t node);
/* Appends the triangles of the node's primitive, in the mesh's own space, marked with the file's vertices. Once
 * for each primitive, in order, then al_gltf_motion_deform with the mesh that they have become. */
al_status al_gltf_motion_corners(al_gltf_motion *motion, uint32_t node, uint32_t primitive, al_corners *corners,
                                 al_error *error);
al_status al_gltf_motion_deform(al_gltf_motion *motion, uint32_t node, const al_corners *corners, uint32_t instance,
                                al_error *error);
bool al_gltf_motion_skinned(const al_gltf_motion *motion, uint32_t node);

#endif
