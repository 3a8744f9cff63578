#include "light_key.h"

#include <xxhash.h>

#include "bake_object.h"

static void hash(XXH64_state_t *state, const void *data, size_t size)
{
    if (data && size) XXH64_update(state, data, size);
}

static void hash_mesh(XXH64_state_t *state, const al_mesh *mesh)
{
    const uint32_t counts[] = {mesh->vertex_count, mesh->index_count, mesh->submesh_count, mesh->uv0 != NULL,
                               mesh->uv1 != NULL};
    size_t vertices = mesh->vertex_count;
    hash(state, counts, sizeof counts);
    hash(state, mesh->positions, vertices * sizeof(float[3]));
    hash(state, mesh->normals, vertices * sizeof(float[3]));
    hash(state, mesh->uv0, mesh->uv0 ? vertices * sizeof(float[2]) : 0);
    hash(state, mesh->uv1, mesh->uv1 ? vertices * sizeof(float[2]) : 0);
    hash(state, mesh->indices, mesh->index_count * sizeof *mesh->indices);
    hash(state, mesh->submeshes, mesh->submesh_count * sizeof *mesh->submeshes);
}

static void hash_material(XXH64_state_t *state, const al_material *m)
{
    const uint32_t numbers[] = {m->double_sided, m->base_color_texture, m->emission_texture,
                                m->metallic_roughness_texture, m->normal_texture};
    const float shades[] = {m->metallic, m->roughness, m->ior};
    hash(state, m->base_color, sizeof m->base_color);
    hash(state, m->emission_w_m2_sr, sizeof m->emission_w_m2_sr);
    hash(state, shades, sizeof shades);
    hash(state, numbers, sizeof numbers);
}

static void hash_surfaces(XXH64_state_t *state, const al_scene *scene)
{
    for (uint32_t i = 0; i < scene->mesh_count; i++) hash_mesh(state, &scene->meshes[i]);
    for (uint32_t i = 0; i < scene->instance_count; i++) {
        const al_instance *instance = &scene->instances[i];
        const uint32_t numbers[] = {instance->mesh, instance->role, instance->lighting}, moving = 1;
        hash(state, numbers, sizeof numbers);
        hash(state, &moving, al_motion_moves(&scene->motion, i) ? sizeof moving : 0);
        hash(state, instance->world, sizeof instance->world);
    }
    for (uint32_t i = 0; i < scene->material_count; i++) hash_material(state, &scene->materials[i]);
    for (uint32_t i = 0; i < scene->texture_count; i++) {
        const al_texture *texture = &scene->textures[i];
        const uint32_t numbers[] = {texture->width, texture->height, texture->srgb};
        hash(state, numbers, sizeof numbers);
        hash(state, texture->pixels, (size_t)texture->width * texture->height * 4);
    }
}

static void hash_lights(XXH64_state_t *state, const al_scene *scene)
{
    for (uint32_t i = 0; i < scene->light_count; i++) {
        hash(state, &scene->lights[i].type, sizeof scene->lights[i].type);
        hash(state, scene->lights[i].vector, sizeof scene->lights[i].vector);
        hash(state, scene->lights[i].intensity, sizeof scene->lights[i].intensity);
    }
    const al_environment *environment = &scene->environment;
    const uint32_t size[] = {environment->width, environment->height};
    hash(state, size, sizeof size);
    hash(state, environment->pixels, (size_t)environment->width * environment->height * sizeof(float[3]));
    hash(state, environment->sh, sizeof environment->sh);
}

static void hash_fogs(XXH64_state_t *state, const al_import *import)
{
    const al_scene *scene = &import->scene;
    for (uint32_t i = 0; i < scene->fog_count; i++) {
        const al_medium *medium = &scene->media[scene->fogs[i].medium];
        hash(state, medium->sigma_s_per_m, sizeof medium->sigma_s_per_m);
        hash(state, medium->sigma_a_per_m, sizeof medium->sigma_a_per_m);
        hash(state, &medium->g, sizeof medium->g);
        al_hash_density(state, import, &import->description->media[scene->fogs[i].medium].density);
    }
}

al_status al_light_key(const al_import *import, uint64_t *key, al_error *error)
{
    XXH64_state_t *state = XXH64_createState();
    *key = 0;
    if (!state) return al_fail(error, AL_IO, "out of memory");
    XXH64_reset(state, 0);
    hash_surfaces(state, &import->scene);
    hash_lights(state, &import->scene);
    hash_fogs(state, import);
    *key = XXH64_digest(state);
    XXH64_freeState(state);
    return AL_OK;
}
