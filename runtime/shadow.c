/* Shadow maps of the opaque instances: one layer per directional light, six per point light, all of one size.
 * Drawn anew only when lights or opaque instances have changed. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "state.h"

enum { LARGEST_EDGE = 2048, SMALLEST_EDGE = 128 };
static const uint64_t map_budget = 64u << 20; /* bytes of all layers */

static bool casts(const al_runtime *runtime, const al_instance *instance)
{
    return instance->role == AL_ROLE_OPAQUE && runtime->model.meshes[instance->mesh].vertex_array;
}

/* Largest power of two whose layers fit the budget. */
static uint32_t map_edge(uint64_t layers)
{
    uint32_t edge = LARGEST_EDGE;
    while (edge > SMALLEST_EDGE && layers * edge * edge * 4 > map_budget) edge /= 2;
    return edge;
}

/* Two unit vectors perpendicular to the unit vector `along`. */
static void across(const float along[3], float right[3], float up[3])
{
    int smallest = 0;
    for (int k = 1; k < 3; k++)
        if (fabsf(along[k]) < fabsf(along[smallest])) smallest = k;
    int a = (smallest + 1) % 3, b = (smallest + 2) % 3;
    float length = sqrtf(along[a] * along[a] + along[b] * along[b]);
    right[smallest] = 0;
    right[a] = along[b] / length;
    right[b] = -along[a] / length;
    for (int k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        up[k] = along[i] * right[j] - along[j] * right[i];
    }
}

static float dot3(const float *a, const float *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Orthographic map that just holds the casters: each row of the matrix maps its extent to [0, 1]. */
static void fit_directional(const al_runtime *runtime, al_light_block *light, uint32_t edge)
{
    float axes[3][3], low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    memcpy(axes[2], light->vector, sizeof axes[2]);
    across(axes[2], axes[0], axes[1]);
    for (uint32_t i = 0; i < runtime->scene.instance_count; i++) {
        float box[2][3];
        if (!casts(runtime, &runtime->scene.instances[i])) continue;
        al_model_world_box(runtime, &runtime->scene.instances[i], box[0], box[1]);
        for (int corner = 0; corner < 8; corner++) {
            float place[3] = {box[corner & 1][0], box[corner >> 1 & 1][1], box[corner >> 2][2]};
            for (int k = 0; k < 3; k++) {
                low[k] = fminf(low[k], dot3(place, axes[k]));
                high[k] = fmaxf(high[k], dot3(place, axes[k]));
            }
        }
    }
    const float largest = fmaxf(fmaxf(high[0] - low[0], high[1] - low[1]), high[2] - low[2]);
    memset(light->to_shadow, 0, sizeof light->to_shadow);
    for (int row = 0; row < 3; row++) {
        /* A little more than the casters, so that flat ones have an extent and borders do not clip. */
        float extent = largest > 0 ? fmaxf((high[row] - low[row]) * 1.01f, largest * 0x1p-20f) : 1,
              start = 0.5f * (low[row] + high[row] - extent);
        for (int k = 0; k < 3; k++) light->to_shadow[4 * k + row] = axes[row][k] / extent;
        light->to_shadow[12 + row] = -start / extent;
        if (row < 2) light->shadow[2] = fmaxf(light->shadow[2], extent / (float)edge);
    }
    light->to_shadow[15] = 1;
}

static void fit_point(const al_runtime *runtime, al_light_block *light, uint32_t edge)
{
    double range = 0;
    for (uint32_t i = 0; i < runtime->scene.instance_count; i++) {
        float low[3], high[3];
        double squared = 0;
        if (!casts(runtime, &runtime->scene.instances[i])) continue;
        al_model_world_box(runtime, &runtime->scene.instances[i], low, high);
        for (int k = 0; k < 3; k++) {
            double far =
                fmax(fabs((double)low[k] - light->vector[k]), fabs((double)high[k] - light->vector[k]));
            squared += far * far;
        }
        range = fmax(range, sqrt(squared));
    }
    light->shadow[1] = range > 0 ? (float)(range * 1.01) : 1;
    light->shadow[2] = 2.0f / (float)edge; /* a face spans 90 degrees */
}

/* The least squared distance, m2, that a light lights from: 2^-20 of the scene's size, 16 roundings of a place in it. */
static float least_distance2(const al_runtime *runtime)
{
    float low[3], high[3], size[3] = {0};
    if (al_runtime_bounds(runtime, low, high))
        for (int k = 0; k < 3; k++) size[k] = high[k] - low[k];
    return fmaxf(dot3(size, size) * 0x1p-40f, 1e-30f);
}

/* Lights as shaders see them; answers how many layers their maps need. */
static uint32_t fill_lights(al_draw *draw)
{
    const al_runtime *runtime = draw->runtime;
    uint32_t layers = 0, count = runtime->scene.light_count;
    const bool shadows = runtime->model.has_opaque && !draw->settings.shadows_off;
    const float least2 = least_distance2(runtime);
    draw->block.counts[0] = (int32_t)count;
    for (uint32_t i = 0; i < count; i++) {
        const al_light *light = &runtime->scene.lights[i];
        al_light_block *block = &draw->block.lights[i];
        memcpy(block->vector, light->vector, sizeof light->vector);
        memcpy(block->intensity, light->intensity, sizeof light->intensity);
        block->vector[3] = light->type == AL_LIGHT_POINT;
        block->intensity[3] = least2;
        if (light->type == AL_LIGHT_DIRECTIONAL) {
            float length = sqrtf(dot3(light->vector, light->vector));
            for (int k = 0; k < 3; k++) block->vector[k] = length > 0 ? light->vector[k] / length : -(k == 1);
        }
        block->shadow[0] = -1;
        if (!shadows) continue;
        block->shadow[0] = (float)layers;
        layers += light->type == AL_LIGHT_POINT ? 6 : 1;
    }
    return layers;
}

static al_status fit_maps(al_draw *draw, uint32_t layers, uint32_t edge)
{
    al_runtime *runtime = draw->runtime;
    al_shadow_maps *maps = &runtime->shadow;
    GLuint before = maps->depth.id;
    al_status status = al_gl_texture_fit(&runtime->memory, GL_TEXTURE_2D_ARRAY, GL_DEPTH_COMPONENT32F, edge,
                                         edge, layers, &maps->depth, draw->error);
    if (status || maps->depth.id == before) return status;
    glTextureParameteri(maps->depth.id, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(maps->depth.id, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(maps->depth.id, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glTextureParameteri(maps->depth.id, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
    if (!maps->framebuffer) glCreateFramebuffers(1, &maps->framebuffer);
    free(maps->key);
    maps->key = NULL;
    return AL_OK;
}

/* Whether lights and casters are those the maps were drawn for; remembers them. */
static bool unchanged(al_draw *draw)
{
    const al_scene *scene = &draw->runtime->scene;
    al_shadow_maps *maps = &draw->runtime->shadow;
    size_t size = 32u * scene->light_count + 17u * scene->instance_count + 1, at = 0;
    float *key = calloc(size, sizeof *key);
    if (!key) return false;
    for (uint32_t i = 0; i < scene->light_count; i++, at += 32) {
        memcpy(key + at, draw->block.lights[i].vector, 4 * sizeof *key);
        memcpy(key + at + 4, draw->block.lights[i].shadow, 4 * sizeof *key);
        memcpy(key + at + 8, draw->block.lights[i].to_shadow, 16 * sizeof *key);
    }
    for (uint32_t i = 0; i < scene->instance_count; i++, at += 17) {
        memcpy(key + at, scene->instances[i].world, 16 * sizeof *key);
        key[at + 16] = (float)scene->instances[i].role;
    }
    memcpy(key + at, &draw->runtime->moving.posed, sizeof *key);
    bool same = maps->key && maps->key_size == size && memcmp(maps->key, key, size * sizeof *key) == 0;
    free(maps->key);
    maps->key = key;
    maps->key_size = size;
    return same;
}

static void draw_layer(const al_draw *draw, uint32_t light, uint32_t face)
{
    const al_runtime *runtime = draw->runtime;
    GLint layer = (GLint)draw->block.lights[light].shadow[0] + (GLint)face;
    glNamedFramebufferTextureLayer(runtime->shadow.framebuffer, GL_DEPTH_ATTACHMENT, runtime->shadow.depth.id,
                                   0, layer);
    glClear(GL_DEPTH_BUFFER_BIT);
    glUniform2i(1, (GLint)light, (GLint)face);
    for (uint32_t i = 0; i < runtime->scene.instance_count; i++) {
        const al_instance *instance = &runtime->scene.instances[i];
        if (!casts(runtime, instance)) continue;
        glUniformMatrix4fv(0, 1, GL_FALSE, instance->world);
        glBindVertexArray(runtime->model.meshes[instance->mesh].vertex_array);
        glDrawElements(GL_TRIANGLES, (GLsizei)runtime->scene.meshes[instance->mesh].index_count,
                       GL_UNSIGNED_INT, NULL);
    }
}

al_status al_shadow_draw(al_draw *draw)
{
    al_runtime *runtime = draw->runtime;
    uint32_t layers = fill_lights(draw), edge = map_edge(layers);
    GLuint program;
    if (!layers) {
        al_shadow_free(runtime);
        glNamedBufferSubData(runtime->frame_block.id, 0, sizeof draw->block, &draw->block);
        return AL_OK;
    }
    al_status status = fit_maps(draw, layers, edge);
    if (!status)
        status = al_shaders_get(runtime->shaders, "shadow.vert shadow.frag", "", &program, draw->error);
    if (status) return status;
    for (int32_t i = 0; i < draw->block.counts[0]; i++) {
        al_light_block *light = &draw->block.lights[i];
        light->shadow[3] = (float)edge;
        if (light->vector[3] > 0)
            fit_point(runtime, light, edge);
        else
            fit_directional(runtime, light, edge);
    }
    glNamedBufferSubData(runtime->frame_block.id, 0, sizeof draw->block, &draw->block);
    al_gl_bind_texture(AL_UNIT_SHADOW, runtime->shadow.depth.id);
    if (unchanged(draw)) return AL_OK;
    al_timing_begin(&runtime->timing, AL_STAGE_SHADOW);
    glUseProgram(program);
    glBindFramebuffer(GL_FRAMEBUFFER, runtime->shadow.framebuffer);
    glViewport(0, 0, (GLsizei)edge, (GLsizei)edge);
    glEnable(GL_DEPTH_TEST);
    glClearDepth(1);
    for (int32_t i = 0; i < draw->block.counts[0]; i++)
        for (uint32_t face = 0; face < (draw->block.lights[i].vector[3] > 0 ? 6u : 1u); face++)
            draw_layer(draw, (uint32_t)i, face);
    glDisable(GL_DEPTH_TEST);
    al_timing_end(&runtime->timing);
    return AL_OK;
}

void al_shadow_free(al_runtime *runtime)
{
    al_gl_texture_free(&runtime->memory, &runtime->shadow.depth);
    if (runtime->shadow.framebuffer) glDeleteFramebuffers(1, &runtime->shadow.framebuffer);
    free(runtime->shadow.key);
    memset(&runtime->shadow, 0, sizeof runtime->shadow);
}
