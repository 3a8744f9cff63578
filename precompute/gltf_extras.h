/* What assimp 5.2 leaves out of glTF files or changes on the way. */
#ifndef AIRLIGHT_GLTF_EXTRAS_H
#define AIRLIGHT_GLTF_EXTRAS_H

#include <jansson.h>
#include <stdint.h>

#include "airlight/status.h"

typedef struct al_gltf_extras {
    uint32_t material_count, camera_count;
    float *emissive_strength; /* [material_count] KHR_materials_emissive_strength, 1 without it */
    float *fov_y_radians;     /* [camera_count] 0 where it is not a perspective camera */
} al_gltf_extras;

/* Reads them from the file's JSON. */
al_status al_gltf_extras_read(const char *name, const json_t *root, al_gltf_extras *extras, al_error *error);
void al_gltf_extras_free(al_gltf_extras *extras);

#endif
