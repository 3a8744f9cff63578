#include "gltf_extras.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static float number(const json_t *object, const char *key, float otherwise)
{
    const json_t *value = json_object_get(object, key);
    float number = json_is_number(value) ? (float)json_number_value(value) : otherwise;
    return isfinite(number) ? number : otherwise;
}

al_status al_gltf_extras_read(const char *name, const json_t *root, al_gltf_extras *extras, al_error *error)
{
    *extras = (al_gltf_extras){0};
    const json_t *materials = json_object_get(root, "materials"), *cameras = json_object_get(root, "cameras");
    size_t material_count = json_array_size(materials), camera_count = json_array_size(cameras);
    extras->emissive_strength = calloc(material_count + 1, sizeof(float));
    extras->fov_y_radians = calloc(camera_count + 1, sizeof(float));
    if (!extras->emissive_strength || !extras->fov_y_radians) {
        al_gltf_extras_free(extras);
        return al_fail(error, AL_IO, "%s: out of memory", name);
    }
    extras->material_count = (uint32_t)material_count;
    extras->camera_count = (uint32_t)camera_count;
    for (size_t i = 0; i < material_count; i++) {
        const json_t *extensions = json_object_get(json_array_get(materials, i), "extensions");
        const json_t *strength = json_object_get(extensions, "KHR_materials_emissive_strength");
        extras->emissive_strength[i] = fmaxf(0, number(strength, "emissiveStrength", 1));
    }
    for (size_t i = 0; i < camera_count; i++)
        extras->fov_y_radians[i] =
            number(json_object_get(json_array_get(cameras, i), "perspective"), "yfov", 0);
    return AL_OK;
}

void al_gltf_extras_free(al_gltf_extras *extras)
{
    free(extras->emissive_strength);
    free(extras->fov_y_radians);
    *extras = (al_gltf_extras){0};
}
