#include "material_file.h"

#include <assimp/GltfMaterial.h>
#include <assimp/material.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "geometry.h"
#include "inputs.h"
#include "picture.h"

enum { PATH_ROOM = 4096, NAME_ROOM = 1024 };

static const al_material plain = {.base_color = {0.8f, 0.8f, 0.8f},
                                  .roughness = 1,
                                  .ior = 1.5f,
                                  .base_color_texture = AL_NO_INDEX,
                                  .emission_texture = AL_NO_INDEX,
                                  .metallic_roughness_texture = AL_NO_INDEX,
                                  .normal_texture = AL_NO_INDEX};

static al_status add_material(al_scene *scene, const al_material *material, const char *name, uint32_t *index,
                              al_error *error)
{
    *index = scene->material_count;
    al_material *place = al_scene_append(scene, &scene->materials, &scene->material_count, sizeof *place);
    if (!place) return al_fail(error, AL_IO, "out of memory for material \"%s\"", name);
    *place = *material;
    place->name = al_scene_text(scene, name);
    return place->name ? AL_OK : al_fail(error, AL_IO, "out of memory for material \"%s\"", name);
}

al_status al_material_default(al_scene *scene, uint32_t *material, al_error *error)
{
    for (uint32_t i = 0; i < scene->material_count; i++)
        if (strcmp(scene->materials[i].name, "default") == 0) {
            *material = i;
            return AL_OK;
        }
    return add_material(scene, &plain, "default", material, error);
}

/* --- properties --- */

static float number(const struct aiMaterial *from, const char *key, float otherwise)
{
    float value;
    return aiGetMaterialFloatArray(from, key, 0, 0, &value, NULL) == aiReturn_SUCCESS && isfinite(value)
               ? value
               : otherwise;
}

static void color(const struct aiMaterial *from, const char *key, float out[3])
{
    struct aiColor4D value;
    if (aiGetMaterialColor(from, key, 0, 0, &value) != aiReturn_SUCCESS) return;
    const float rgb[3] = {value.r, value.g, value.b};
    for (int i = 0; i < 3; i++)
        if (isfinite(rgb[i]) && rgb[i] >= 0) out[i] = rgb[i];
}

static float clamp(float value, float low, float high)
{
    return value < low ? low : value > high ? high : value;
}

static void read_gltf(const struct aiMaterial *from, al_material *out)
{
    int twosided = 0;
    out->base_color[0] = out->base_color[1] = out->base_color[2] = 1;
    color(from, "$clr.base", out->base_color);
    out->metallic = clamp(number(from, "$mat.metallicFactor", 1), 0, 1);
    out->roughness = clamp(number(from, "$mat.roughnessFactor", 1), 0, 1);
    out->ior = clamp(number(from, "$mat.refracti", 1.5f), 1, 10);
    color(from, "$clr.emissive", out->emission_w_m2_sr);
    aiGetMaterialIntegerArray(from, AI_MATKEY_TWOSIDED, &twosided, NULL);
    out->double_sided = twosided != 0;
}

/* Phong's exponent n and the microfacet width: alpha^2 = 2 / (n + 2) (Walter et al. 2007, eq. 25 ff.), and
 * alpha = roughness^2. A black Ks means that there is no specular lobe: ior 1. */
static void read_obj(const struct aiMaterial *from, al_material *out)
{
    float specular[3] = {0};
    color(from, "$clr.diffuse", out->base_color);
    for (int i = 0; i < 3; i++) out->base_color[i] = clamp(out->base_color[i], 0, 1);
    color(from, "$clr.specular", specular);
    color(from, "$clr.emissive", out->emission_w_m2_sr);
    bool shiny = specular[0] > 0 || specular[1] > 0 || specular[2] > 0;
    float exponent = number(from, "$mat.shininess", 0), ior = number(from, "$mat.refracti", 1);
    float from_exponent = exponent > 0 ? sqrtf(sqrtf(2 / (exponent + 2))) : 1;
    out->roughness = clamp(number(from, "$mat.roughnessFactor", from_exponent), 0, 1);
    out->metallic = clamp(number(from, "$mat.metallicFactor", 0), 0, 1);
    out->ior = !shiny ? 1 : ior > 1 ? clamp(ior, 1, 10) : 1.5f;
}

/* --- textures --- */

static al_status decode(al_scene *scene, const uint8_t *bytes, size_t size, const char *name, bool srgb,
                        uint32_t *index, al_error *error)
{
    uint32_t width, height;
    uint8_t *pixels;
    al_status status = al_picture_decode_bytes(name, bytes, size, &width, &height, &pixels, error);
    if (status) return status;
    *index = scene->texture_count;
    al_texture *texture = al_scene_append(scene, &scene->textures, &scene->texture_count, sizeof *texture);
    if (texture) {
        *texture = (al_texture){al_scene_text(scene, name), width, height, srgb,
                                al_scene_array(scene, (size_t)width * height, 4)};
        if (texture->pixels) memcpy(texture->pixels, pixels, (size_t)width * height * 4);
    }
    if (!texture || !texture->name || !texture->pixels)
        status = al_fail(error, AL_IO, "%s: out of memory for a texture of %u x %u", name, width, height);
    free(pixels);
    return status;
}

/* File names inside mesh files may use backslashes and lie beside the mesh file. */
static void texture_path(const char *mesh_path, const char *texture, char out[PATH_ROOM])
{
    const char *slash = strrchr(mesh_path, '/');
    int folder = slash && *texture != '/' ? (int)(slash - mesh_path + 1) : 0;
    snprintf(out, PATH_ROOM, "%.*s%s", folder, mesh_path, texture);
    for (char *at = out; *at; at++)
        if (*at == '\\') *at = '/';
}

static al_status load_texture(al_import *import, const struct aiScene *file, const char *mesh_path,
                              const char *texture, bool srgb, uint32_t *index, al_error *error)
{
    const struct aiTexture *embedded = NULL;
    char path[PATH_ROOM];
    uint8_t *bytes = NULL;
    size_t size;
    if (*texture == '*' && strtoul(texture + 1, NULL, 10) < file->mNumTextures)
        embedded = file->mTextures[strtoul(texture + 1, NULL, 10)];
    if (embedded)
        snprintf(path, sizeof path, "%s%s", mesh_path, texture);
    else
        texture_path(mesh_path, texture, path);
    for (uint32_t i = 0; i < import->scene.texture_count; i++)
        if (strcmp(import->scene.textures[i].name, path) == 0 && import->scene.textures[i].srgb == srgb) {
            *index = i;
            return AL_OK;
        }
    if (embedded && embedded->mHeight)
        return al_fail(error, AL_BAD_INPUT, "%s: the texture is stored as raw pixels; PNG or JPEG is right",
                       path);
    if (embedded)
        return decode(&import->scene, (const uint8_t *)embedded->pcData, embedded->mWidth, path, srgb, index,
                      error);
    al_status status = al_inputs_read(import, path, &bytes, &size, error);
    if (!status) status = decode(&import->scene, bytes, size, path, srgb, index, error);
    free(bytes);
    return status;
}

static al_status read_textures(al_import *import, const struct aiScene *file, const char *path,
                               const struct aiMaterial *from, al_mesh_format format, al_material *out,
                               al_error *error)
{
    const struct {
        enum aiTextureType type;
        bool srgb;
        uint32_t *index;
    } slots[] = {
        {format == AL_MESH_GLTF ? aiTextureType_BASE_COLOR : aiTextureType_DIFFUSE, true,
         &out->base_color_texture},
        {aiTextureType_EMISSIVE, true, &out->emission_texture},
        {aiTextureType_UNKNOWN, false, &out->metallic_roughness_texture}, /* where assimp puts glTF's */
        {aiTextureType_NORMALS, false, &out->normal_texture}};
    al_status status = AL_OK;
    for (size_t i = 0; i < sizeof slots / sizeof slots[0] && !status; i++) {
        struct aiString name;
        if (aiGetMaterialTexture(from, slots[i].type, 0, &name, NULL, NULL, NULL, NULL, NULL, NULL) ==
            aiReturn_SUCCESS)
            status = load_texture(import, file, path, name.data, slots[i].srgb, slots[i].index, error);
    }
    return status;
}

static void name_of(const struct aiMaterial *from, uint32_t index, char out[NAME_ROOM])
{
    struct aiString name;
    if (aiGetMaterialString(from, AI_MATKEY_NAME, &name) == aiReturn_SUCCESS && name.length)
        snprintf(out, NAME_ROOM, "%s", name.data);
    else
        snprintf(out, NAME_ROOM, "material %u", index);
}

al_status al_material_import(al_import *import, const struct aiScene *file, al_mesh_format format,
                             const char *path, uint32_t index, float strength, uint32_t *map,
                             uint32_t *material, al_error *error)
{
    const al_scene_description *description = import->description;
    const struct aiMaterial *from = file->mMaterials[index];
    al_material made = plain;
    char name[NAME_ROOM];
    al_status status = AL_OK;
    name_of(from, index, name);
    for (uint32_t i = 0; i < description->material_count && map[index] == AL_NO_INDEX; i++)
        if (strcmp(description->materials[i].name, name) == 0) map[index] = i;
    /* what assimp makes up for OBJ files that name no material goes by its own name */
    bool none =
        format == AL_MESH_PLAIN || (format == AL_MESH_OBJ && strcmp(name, AI_DEFAULT_MATERIAL_NAME) == 0);
    if (map[index] == AL_NO_INDEX && none) {
        status = al_material_default(&import->scene, &map[index], error);
    } else if (map[index] == AL_NO_INDEX) {
        if (format == AL_MESH_GLTF)
            read_gltf(from, &made);
        else
            read_obj(from, &made);
        for (int i = 0; i < 3; i++) made.emission_w_m2_sr[i] *= strength;
        status = read_textures(import, file, path, from, format, &made, error);
        if (!status) status = add_material(&import->scene, &made, name, &map[index], error);
    }
    *material = map[index];
    return status;
}

al_status al_material_absorption(const struct aiScene *file, const char *name, double unit_m,
                                 const char *where, float sigma_a_per_m[3], al_error *error)
{
    for (unsigned i = 0; i < file->mNumMaterials; i++) {
        float white[3] = {1, 1, 1};
        char found[NAME_ROOM];
        name_of(file->mMaterials[i], i, found);
        if (strcmp(found, name) != 0) continue;
        double distance_m = number(file->mMaterials[i], "$mat.volume.attenuationDistance", INFINITY) * unit_m;
        color(file->mMaterials[i], "$mat.volume.attenuationColor", white);
        if (!(distance_m > 0) || !isfinite(distance_m))
            return al_fail(error, AL_BAD_INPUT,
                           "%s: material \"%s\" has no attenuation distance "
                           "(KHR_materials_volume)",
                           where, name);
        for (int k = 0; k < 3; k++) {
            if (!(white[k] > 0 && white[k] <= 1))
                return al_fail(error, AL_BAD_INPUT,
                               "%s: material \"%s\" has the attenuation colour %g; above 0 and "
                               "at most 1 is right",
                               where, name, white[k]);
            sigma_a_per_m[k] = (float)(-log(white[k]) / distance_m);
        }
        return AL_OK;
    }
    return al_fail(error, AL_BAD_INPUT, "%s: no material is named \"%s\"", where, name);
}
