/* Meshes and textures of the scene, uploaded at load. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "state.h"

enum { VERTEX_FLOATS = 8 };

/* Interleaves the mesh's vertices and finds their box. */
static void pack_vertices(const al_mesh *mesh, float *vertices, al_model_mesh *out)
{
    for (int k = 0; k < 3; k++) out->low[k] = INFINITY, out->high[k] = -INFINITY;
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        float *v = vertices + i * VERTEX_FLOATS;
        memcpy(v, mesh->positions + 3 * i, 3 * sizeof *v);
        memcpy(v + 3, mesh->normals + 3 * i, 3 * sizeof *v);
        v[6] = mesh->uv0 ? mesh->uv0[2 * i] : 0;
        v[7] = mesh->uv0 ? mesh->uv0[2 * i + 1] : 0;
        for (int k = 0; k < 3; k++) {
            out->low[k] = fminf(out->low[k], v[k]);
            out->high[k] = fmaxf(out->high[k], v[k]);
        }
    }
}

static float longest_edge(const al_mesh *mesh)
{
    float longest = 0;
    for (size_t i = 0; i < mesh->index_count; i++) {
        const float *a = mesh->positions + 3 * (size_t)mesh->indices[i],
                    *b = mesh->positions + 3 * (size_t)mesh->indices[i % 3 == 2 ? i - 2 : i + 1];
        float x = b[0] - a[0], y = b[1] - a[1], z = b[2] - a[2];
        longest = fmaxf(longest, x * x + y * y + z * z);
    }
    return sqrtf(longest);
}

static void make_vertex_array(al_model_mesh *out)
{
    glCreateVertexArrays(1, &out->vertex_array);
    glVertexArrayVertexBuffer(out->vertex_array, 0, out->vertices.id, 0, VERTEX_FLOATS * sizeof(float));
    glVertexArrayElementBuffer(out->vertex_array, out->indices.id);
    for (GLuint attribute = 0; attribute < 3; attribute++) {
        glEnableVertexArrayAttrib(out->vertex_array, attribute);
        glVertexArrayAttribFormat(out->vertex_array, attribute, attribute < 2 ? 3 : 2, GL_FLOAT, GL_FALSE,
                                  attribute * 3 * (GLuint)sizeof(float));
        glVertexArrayAttribBinding(out->vertex_array, attribute, 0);
    }
}

/* The second UV set as attribute 3, for meshes that an instance with a lightmap shows. */
static al_status upload_uv1(al_runtime *runtime, const al_mesh *mesh, al_model_mesh *out, al_error *error)
{
    const uint64_t stride = 2 * sizeof(float);
    al_status status =
        al_gl_buffer_create(&runtime->memory, mesh->vertex_count * stride, mesh->uv1, &out->uv1, error);
    if (status) return status;
    glVertexArrayVertexBuffer(out->vertex_array, 1, out->uv1.id, 0, (GLsizei)stride);
    glEnableVertexArrayAttrib(out->vertex_array, 3);
    glVertexArrayAttribFormat(out->vertex_array, 3, 2, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribBinding(out->vertex_array, 3, 1);
    return AL_OK;
}

static al_status upload_second_sets(al_runtime *runtime, al_error *error)
{
    const al_scene *scene = &runtime->scene;
    al_status status = AL_OK;
    for (uint32_t i = 0; i < scene->instance_count && *scene->baked.lightmap && !status; i++) {
        const al_instance *instance = &scene->instances[i];
        al_model_mesh *mesh = &runtime->model.meshes[instance->mesh];
        if (instance->lighting == AL_LIGHTING_LIGHTMAP && scene->meshes[instance->mesh].uv1 &&
            mesh->vertex_array && !mesh->uv1.id)
            status = upload_uv1(runtime, &scene->meshes[instance->mesh], mesh, error);
    }
    return status;
}

static al_status upload_mesh(al_runtime *runtime, const al_mesh *mesh, al_model_mesh *out, al_error *error)
{
    uint64_t size = (uint64_t)mesh->vertex_count * VERTEX_FLOATS * sizeof(float);
    if (!mesh->vertex_count || !mesh->index_count) return AL_OK;
    float *vertices = malloc(size);
    if (!vertices)
        return al_fail(error, AL_IO, "%s: no memory for %u vertices", mesh->name, mesh->vertex_count);
    pack_vertices(mesh, vertices, out);
    out->longest_edge = longest_edge(mesh);
    al_status status = al_gl_buffer_create(&runtime->memory, size, vertices, &out->vertices, error);
    if (!status)
        status = al_gl_buffer_create(&runtime->memory, (uint64_t)mesh->index_count * sizeof(uint32_t),
                                     mesh->indices, &out->indices, error);
    if (!status) make_vertex_array(out);
    free(vertices);
    return status;
}

static al_status upload_texture(al_runtime *runtime, const al_texture *texture, al_gl_texture *out,
                                al_error *error)
{
    uint32_t levels = 1, edge = texture->width > texture->height ? texture->width : texture->height;
    if (!texture->width || !texture->height) return AL_OK;
    while (edge >> levels) levels++;
    al_status status =
        al_gl_texture_create(&runtime->memory, GL_TEXTURE_2D, texture->srgb ? GL_SRGB8_ALPHA8 : GL_RGBA8,
                             texture->width, texture->height, 1, levels, out, error);
    if (status) return status;
    glTextureSubImage2D(out->id, 0, 0, 0, (GLsizei)texture->width, (GLsizei)texture->height, GL_RGBA,
                        GL_UNSIGNED_BYTE, texture->pixels);
    glGenerateTextureMipmap(out->id);
    glTextureParameteri(out->id, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    glTextureParameteri(out->id, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(out->id, GL_TEXTURE_WRAP_S, GL_REPEAT);
    glTextureParameteri(out->id, GL_TEXTURE_WRAP_T, GL_REPEAT);
    return AL_OK;
}

al_status al_model_create(al_runtime *runtime, al_error *error)
{
    const al_scene *scene = &runtime->scene;
    al_model *model = &runtime->model;
    al_status status = AL_OK;
    model->meshes = calloc(scene->mesh_count + 1, sizeof *model->meshes);
    model->textures = calloc(scene->texture_count + 1, sizeof *model->textures);
    if (!model->meshes || !model->textures)
        return al_fail(error, AL_IO, "scene.air: no memory for its meshes");
    model->mesh_count = scene->mesh_count;
    model->texture_count = scene->texture_count;
    for (uint32_t i = 0; i < scene->mesh_count && !status; i++)
        status = upload_mesh(runtime, &scene->meshes[i], &model->meshes[i], error);
    if (!status) status = upload_second_sets(runtime, error);
    for (uint32_t i = 0; i < scene->texture_count && !status; i++)
        status = upload_texture(runtime, &scene->textures[i], &model->textures[i], error);
    model->has_opaque = model->has_blockers = model->has_emission = false;
    for (uint32_t i = 0; i < scene->instance_count; i++) {
        if (scene->instances[i].role == AL_ROLE_OPAQUE) model->has_opaque = true;
        if (scene->instances[i].role == AL_ROLE_BLOCKER) model->has_blockers = true;
    }
    for (uint32_t i = 0; i < scene->material_count; i++)
        for (int k = 0; k < 3; k++)
            if (scene->materials[i].emission_w_m2_sr[k] > 0) model->has_emission = true;
    return status;
}

void al_model_free(al_runtime *runtime)
{
    al_model *model = &runtime->model;
    for (uint32_t i = 0; i < model->mesh_count; i++) {
        if (model->meshes[i].vertex_array) glDeleteVertexArrays(1, &model->meshes[i].vertex_array);
        al_gl_buffer_free(&runtime->memory, &model->meshes[i].vertices);
        al_gl_buffer_free(&runtime->memory, &model->meshes[i].indices);
        al_gl_buffer_free(&runtime->memory, &model->meshes[i].uv1);
    }
    for (uint32_t i = 0; i < model->texture_count; i++)
        al_gl_texture_free(&runtime->memory, &model->textures[i]);
    free(model->meshes);
    free(model->textures);
    memset(model, 0, sizeof *model);
}

static bool is_glossy(const al_scene *scene, uint32_t material)
{
    return material >= scene->material_count || scene->materials[material].metallic > 0 ||
           scene->materials[material].ior != 1;
}

bool al_model_is_glossy(const al_runtime *runtime)
{
    const al_scene *scene = &runtime->scene;
    for (uint32_t i = 0; i < scene->instance_count; i++) {
        const al_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        for (uint32_t k = 0; k < mesh->submesh_count && scene->instances[i].role == AL_ROLE_OPAQUE; k++)
            if (is_glossy(scene, mesh->submeshes[k].material)) return true;
    }
    return false;
}

uint64_t al_model_bytes(const al_runtime *runtime)
{
    const al_model *model = &runtime->model;
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < model->mesh_count; i++)
        bytes += model->meshes[i].vertices.size + model->meshes[i].indices.size;
    for (uint32_t i = 0; i < model->texture_count; i++) bytes += model->textures[i].bytes;
    return bytes;
}

void al_model_world_box(const al_runtime *runtime, const al_instance *instance, float low[3], float high[3])
{
    const al_model_mesh *mesh = &runtime->model.meshes[instance->mesh];
    const float *m = instance->world;
    for (int row = 0; row < 3; row++) {
        low[row] = high[row] = m[12 + row];
        for (int k = 0; k < 3; k++) {
            float a = m[4 * k + row] * mesh->low[k], b = m[4 * k + row] * mesh->high[k];
            low[row] += fminf(a, b);
            high[row] += fmaxf(a, b);
        }
    }
}
