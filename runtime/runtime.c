/* The library's life: create, load, update, and what it answers about itself. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "matrix.h"
#include "state.h"

const char *al_pass_name(al_pass pass)
{
    static const char *const names[AL_PASS_COUNT] = {
        "composite", "translucent", "surface",           "normal",             "depth",
        "intervals", "unity",       "direct-scattering", "surface-scattering", "surfels",
        "interval-map", "depletion", "shells", "unshuffled", "blurred", "shadow-map",
        "ambient-occlusion", "indirect", "bounce-rays", "bounce-hits"};
    return (unsigned)pass < AL_PASS_COUNT ? names[pass] : "unknown";
}

al_status al_runtime_create(const al_runtime_options *options, al_runtime **runtime, al_error *error)
{
    *runtime = NULL;
    int version = epoxy_gl_version();
    if (!epoxy_is_desktop_gl() || version < 45)
        return al_fail(error, AL_NO_DEVICE, "OpenGL %d.%d: the runtime needs a core context of 4.5",
                       version / 10, version % 10);
    al_runtime *made = calloc(1, sizeof *made);
    if (!made) return al_fail(error, AL_IO, "no memory for the runtime");
    al_status status = al_shaders_create(options ? options->shader_folder : NULL, &made->shaders, error);
    if (!status)
        status = al_gl_buffer_create(&made->memory, sizeof(al_frame_block), NULL, &made->frame_block, error);
    if (status) {
        al_runtime_destroy(made);
        return status;
    }
    glCreateVertexArrays(1, &made->empty_vertex_array);
    *runtime = made;
    return AL_OK;
}

void al_runtime_sweep(al_runtime *runtime)
{
    al_shells_sweep(runtime);
    al_bounce_sweep(runtime);
    al_legs_sweep(runtime);
    al_targets_sweep(runtime);
}

static void unload(al_runtime *runtime)
{
    al_loader_free(runtime->loader);
    runtime->loader = NULL;
    for (uint32_t i = 0; runtime->objects && i < runtime->scene.translucent_count; i++)
        al_object_free(runtime, &runtime->objects[i]);
    free(runtime->objects);
    free(runtime->sorted);
    runtime->objects = NULL;
    runtime->sorted = NULL;
    al_model_free(runtime);
    al_motion_free(runtime);
    al_fog_free(runtime);
    al_history_free(runtime);
    al_lightmap_free(runtime);
    al_probes_free(runtime);
    al_gl_texture_free(&runtime->memory, &runtime->environment);
    runtime->environment_levels = 0;
    al_shadow_free(runtime);
    al_surfels_free(runtime);
    runtime->memory.frame++; /* no frame asks for anything */
    al_runtime_sweep(runtime);
    memset(runtime->timing.ran, 0, sizeof runtime->timing.ran);
    al_scene_free(&runtime->scene);
    memset(&runtime->scene, 0, sizeof runtime->scene);
    if (runtime->scene_file) al_file_close(runtime->scene_file);
    runtime->scene_file = NULL;
    runtime->loaded = runtime->ended = runtime->arriving = runtime->drawn = false;
    runtime->samples_drawn = 0;
}

void al_runtime_destroy(al_runtime *runtime)
{
    if (!runtime) return;
    unload(runtime);
    al_timing_free(&runtime->timing);
    al_shaders_free(runtime->shaders);
    al_gl_buffer_free(&runtime->memory, &runtime->frame_block);
    if (runtime->empty_vertex_array) glDeleteVertexArrays(1, &runtime->empty_vertex_array);
    free(runtime);
}

/* What the runtime asks of a scene beyond what the format does. */
static al_status check_scene(const char *path, const al_scene *scene, al_error *error)
{
    if (scene->light_count > AL_LIGHT_LIMIT)
        return al_fail(error, AL_BAD_INPUT, "%s: %u lights; the runtime draws at most %d", path,
                       scene->light_count, AL_LIGHT_LIMIT);
    if (scene->fog_count > AL_FOG_LIMIT)
        return al_fail(error, AL_BAD_INPUT, "%s: %u fogs; the runtime draws at most %d", path,
                       scene->fog_count, AL_FOG_LIMIT);
    for (uint32_t i = 0; i < scene->translucent_count; i++) {
        const al_translucent_object *object = &scene->translucents[i];
        if (!al_matrix_is_rigid(scene->instances[object->instance].world, 1e-3))
            return al_fail(
                error, AL_BAD_INPUT,
                "%s: translucent object \"%s\": its instance is scaled or sheared; only rotation and "
                "translation are allowed",
                path, object->name);
        if (!object->asset[0])
            return al_fail(error, AL_BAD_INPUT,
                           "%s: translucent object \"%s\": no asset; bake the scene first", path,
                           object->name);
    }
    return AL_OK;
}

static al_status start(al_runtime *runtime, const char *folder, al_error *error)
{
    uint32_t count = runtime->scene.translucent_count;
    runtime->objects = calloc(count + 1, sizeof *runtime->objects);
    runtime->sorted = calloc(count + 1, sizeof *runtime->sorted);
    if (!runtime->objects || !runtime->sorted)
        return al_fail(error, AL_IO, "%s: no memory for its objects", folder);
    for (uint32_t i = 0; i < count; i++) runtime->sorted[i] = AL_NO_INDEX;
    al_gl_reset_state();
    al_status status = al_model_create(runtime, error);
    if (!status) status = al_motion_create(runtime, error);
    if (!status) status = al_environment_upload(runtime, error);
    if (!status) status = al_fog_create(runtime, error);
    if (!status) status = al_loader_create(folder, &runtime->scene, &runtime->loader, error);
    runtime->loaded = !status;
    return status;
}

al_status al_runtime_load(al_runtime *runtime, const char *folder, al_error *error)
{
    char path[4096];
    al_file *file = NULL;
    al_scene scene = {0};
    al_open_options options = {.kind = AL_KIND_SCENE};
    if (snprintf(path, sizeof path, "%s/scene.air", folder) >= (int)sizeof path)
        return al_fail(error, AL_USAGE, "%s: the path is longer than %zu characters", folder,
                       sizeof path - 11);
    if (access(path, F_OK) && (errno == ENOENT || errno == ENOTDIR))
        return al_fail(error, AL_BAD_INPUT, "%s: no scene.air in it; airlight-bake SCENE.json -o %s makes it",
                       folder, folder);
    al_status status = al_file_open(path, &options, &file, error);
    if (status) return status;
    status = al_scene_read(file, &scene, error);
    if (!status) status = check_scene(path, &scene, error);
    if (status) {
        al_scene_free(&scene);
        al_file_close(file);
        return status;
    }
    unload(runtime);
    runtime->scene = scene;
    runtime->scene_file = file;
    status = start(runtime, folder, error);
    if (status) unload(runtime);
    return status;
}

uint64_t al_budget_share(uint64_t *budget, uint64_t size, uint64_t left)
{
    uint64_t count = size ? *budget / size : left;
    count = count < 1 ? 1 : count;
    count = count > left ? left : count;
    *budget = count * size < *budget ? *budget - count * size : 0;
    return count;
}

/* Uploads a part of what has arrived; *done when nothing of it is left. */
static al_status accept(al_runtime *runtime, uint64_t *budget, bool *done, al_error *error)
{
    const al_arrival *arrival = &runtime->arrival;
    *done = true;
    switch (arrival->kind) {
    case AL_ARRIVAL_OBJECT:
    case AL_ARRIVAL_PAGE:
        return al_object_accept(runtime, arrival, budget, done, error);
    case AL_ARRIVAL_MEDIUM:
    case AL_ARRIVAL_FRAME:
    case AL_ARRIVAL_BRICKS:
        return al_fog_accept(runtime, arrival, budget, done, error);
    case AL_ARRIVAL_LIGHTMAP:
    case AL_ARRIVAL_TEXELS:
        return al_lightmap_accept(runtime, arrival, budget, done, error);
    case AL_ARRIVAL_PROBES:
        return al_probes_accept(runtime, arrival, error);
    case AL_ARRIVAL_FAILURE:
        if (arrival->asset == AL_KIND_TRANSLUCENT) runtime->objects[arrival->object].failed = true;
        if (arrival->asset == AL_KIND_MEDIUM) al_fog_fail(runtime, arrival->object);
        return al_fail(error, arrival->error.status, "%s", arrival->error.message);
    case AL_ARRIVAL_END:
        runtime->ended = true;
        break;
    }
    return AL_OK;
}

static void fill_state(const al_runtime *runtime, al_load_state *state)
{
    *state = (al_load_state){.ready = runtime->loaded};
    for (uint32_t i = 0; runtime->loaded && i < runtime->scene.translucent_count; i++) {
        const al_object *object = &runtime->objects[i];
        state->samples_loaded += object->loaded;
        state->samples_total += object->info.sample_count;
        bool shows = object->present && (object->loaded || !object->info.sample_count);
        if (!shows && !object->failed) state->ready = false;
    }
    state->complete = runtime->loaded && runtime->ended && !runtime->arriving && al_fog_is_current(runtime);
}

al_status al_runtime_update(al_runtime *runtime, uint64_t byte_budget, al_load_state *state, al_error *error)
{
    uint64_t left = byte_budget ? byte_budget : UINT64_MAX;
    al_status status = al_gl_check_lost(error);
    if (runtime->loader && !status) al_gl_reset_state();
    while (runtime->loader && left && !status) {
        bool done = false;
        if (!runtime->arriving) {
            runtime->arriving = al_loader_take(runtime->loader, &runtime->arrival);
            runtime->arrived = 0;
        }
        if (!runtime->arriving) break;
        status = accept(runtime, &left, &done, error);
        if (done) runtime->arriving = false;
    }
    if (runtime->ended && !status) al_fog_follow(runtime);
    if (state) fill_state(runtime, state);
    return status;
}

al_scene *al_runtime_scene(al_runtime *runtime)
{
    return runtime->loaded ? &runtime->scene : NULL;
}

bool al_runtime_bounds(const al_runtime *runtime, float low[3], float high[3])
{
    bool any = false;
    for (uint32_t i = 0; runtime->loaded && i < runtime->scene.instance_count; i++) {
        const al_instance *instance = &runtime->scene.instances[i];
        float box[2][3];
        if (instance->role == AL_ROLE_BLOCKER || !runtime->model.meshes[instance->mesh].vertex_array) continue;
        al_model_world_box(runtime, instance, box[0], box[1]);
        for (int k = 0; k < 3; k++) {
            low[k] = any ? fminf(low[k], box[0][k]) : box[0][k];
            high[k] = any ? fmaxf(high[k], box[1][k]) : box[1][k];
        }
        any = true;
    }
    return any;
}

uint32_t al_runtime_times(al_runtime *runtime, al_pass_time *times, uint32_t limit)
{
    uint32_t count = 0;
    al_timing_collect(&runtime->timing);
    for (int stage = 0; stage < AL_STAGE_COUNT && count < limit; stage++)
        if (runtime->timing.runs[stage])
            times[count++] = (al_pass_time){al_stage_name((al_stage)stage), runtime->timing.ms[stage]};
    return count;
}

uint64_t al_runtime_memory(const al_runtime *runtime)
{
    return runtime->memory.bytes;
}

uint64_t al_runtime_samples(const al_runtime *runtime)
{
    return runtime->samples_drawn;
}

uint64_t al_runtime_surfels(al_runtime *runtime)
{
    return al_surfels_count(runtime);
}
