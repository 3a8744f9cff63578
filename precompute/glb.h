/* The scene as binary glTF 2.0, second UV set included, for other engines. */
#ifndef AIRLIGHT_GLB_H
#define AIRLIGHT_GLB_H

#include "airlight/scene.h"

/* Meshes, materials (emissive strength, ior), textures as PNG, nodes, cameras and KHR_lights_punctual. Fog,
 * translucent media and the environment have no place in glTF and are left out. Atomic; bytes may be NULL. */
al_status al_glb_write(const char *path, const al_scene *scene, uint64_t *bytes, al_error *error);

#endif
