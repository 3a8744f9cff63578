/* Materials and textures of a mesh file, as glTF metallic-roughness. */
#ifndef AIRLIGHT_MATERIAL_FILE_H
#define AIRLIGHT_MATERIAL_FILE_H

#include <assimp/scene.h>

#include "import.h"

typedef enum al_mesh_format {
    AL_MESH_PLAIN = 0 /* PLY, STL: no materials */,
    AL_MESH_OBJ,
    AL_MESH_GLTF
} al_mesh_format;

/* Index of the scene's material for material `index` of the file: the scene file's own of that name, else
 * made from the file. `path` is the mesh file, for its textures. `map` remembers: [file->mNumMaterials], all
 * AL_NO_INDEX at first. The emission is the file's times `strength`. */
al_status al_material_import(al_import *import, const struct aiScene *file, al_mesh_format format,
                             const char *path, uint32_t index, float strength, uint32_t *map,
                             uint32_t *material, al_error *error);

/* The material of meshes that name none. */
al_status al_material_default(al_scene *scene, uint32_t *material, al_error *error);

/* sigma_a per metre of a file's material with KHR_materials_volume: the colour that white light has after the
 * attenuation distance is exp(-sigma_a distance). */
al_status al_material_absorption(const struct aiScene *file, const char *name, double unit_m,
                                 const char *where, float sigma_a_per_m[3], al_error *error);

#endif
