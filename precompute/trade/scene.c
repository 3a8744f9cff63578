#include "scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "import.h"

/* Every "file" of the scene, relative to its folder so far. */
static void make_paths_whole(json_t *value, const char *folder)
{
    const char *key;
    json_t *inner;
    size_t i;
    json_array_foreach(value, i, inner) make_paths_whole(inner, folder);
    json_object_foreach(value, key, inner) {
        make_paths_whole(inner, folder);
        const char *path = strcmp(key, "file") ? NULL : json_string_value(inner);
        if (path && *path != '/') json_object_set_new(value, key, json_sprintf("%s/%s", folder, path));
    }
}

static json_t *three(const double v[3])
{
    return json_pack("[f, f, f]", v[0], v[1], v[2]);
}

/* A camera as the scene file writes it, turned by `degrees` about the target's vertical axis. */
static json_t *describe_camera(const al_camera *camera, const char *name, double degrees)
{
    double turn = degrees * acos(-1) / 180, c = cos(turn), s = sin(turn), position[3], target[3], up[3];
    for (int i = 0; i < 3; i++) position[i] = camera->position[i], target[i] = camera->target[i], up[i] = camera->up[i];
    double x = position[0] - target[0], z = position[2] - target[2], ux = up[0], uz = up[2];
    position[0] = target[0] + c * x + s * z;
    position[2] = target[2] - s * x + c * z;
    up[0] = c * ux + s * uz;
    up[2] = c * uz - s * ux;
    return json_pack("{s:s, s:o, s:o, s:o, s:f}", "name", name, "position_m", three(position), "target_m", three(target),
                     "up", three(up), "fov_y_degrees", camera->fov_y_radians * 180 / acos(-1));
}

static al_status set_cameras(al_trade *trade, const al_scene *scene, json_t *root, al_error *error)
{
    const char *first = scene->cameras[0].name, *second = scene->camera_count > 1 ? scene->cameras[1].name : "held out";
    if (strlen(first) >= AL_NAME_SIZE || strlen(second) >= AL_NAME_SIZE)
        return al_fail(error, AL_BAD_INPUT, "%s: a camera's name is longer than %d characters; give it a shorter one",
                       trade->scene, AL_NAME_SIZE - 1);
    snprintf(trade->cameras[0], AL_NAME_SIZE, "%s", first);
    snprintf(trade->cameras[1], AL_NAME_SIZE, "%s", second);
    if (scene->camera_count > 1) return AL_OK;
    json_t *cameras = json_object_get(root, "cameras");
    if (!json_array_size(cameras)) {
        json_object_set_new(root, "cameras", cameras = json_array());
        json_array_append_new(cameras, describe_camera(&scene->cameras[0], first, 0));
    }
    json_array_append_new(cameras, describe_camera(&scene->cameras[0], second, 30));
    return AL_OK;
}

/* Of the camera's object in the scene file; 0: it is in a mesh file, which counts itself. */
static uint64_t hash_camera(const json_t *root, const char *name)
{
    json_t *camera;
    size_t i;
    uint64_t hash = 0;
    json_array_foreach(json_object_get(root, "cameras"), i, camera) {
        const char *other = json_string_value(json_object_get(camera, "name"));
        char *text = other && !strcmp(other, name) ? json_dumps(camera, JSON_SORT_KEYS | JSON_COMPACT) : NULL;
        if (text) hash = XXH64(text, strlen(text), 0);
        free(text);
    }
    return hash;
}

/* What ground truth depends on but the camera: all but what only bakes and the player use, and every file. */
static uint64_t hash_content(const al_import *import, const json_t *root)
{
    static const char *const without[] = {"bake", "lightmap", "probes", "play", "cameras", "comment", "$schema"};
    json_t *copy = json_copy((json_t *)root);
    for (size_t i = 0; i < sizeof without / sizeof *without; i++) json_object_del(copy, without[i]);
    char *text = json_dumps(copy, JSON_SORT_KEYS | JSON_COMPACT);
    uint64_t hash = text ? XXH64(text, strlen(text), 0) : 0;
    for (uint32_t i = 1; i < import->input_count; i++) hash = XXH64(&import->inputs[i].xxh64, sizeof(uint64_t), hash);
    free(text);
    json_decref(copy);
    return hash;
}

al_status al_scene_open(al_trade *trade, json_t **root, al_error *error)
{
    al_import *import = NULL;
    char whole[PATH_MAX];
    *root = NULL;
    al_status status = al_import_scene(trade->scene, AL_QUALITY_MEDIUM, &import, error);
    if (status) return status;
    if (!realpath(trade->scene, whole) || !(*root = json_load_file(whole, 0, NULL))) {
        status = al_fail_errno(error, trade->scene, "read");
        goto cleanup;
    }
    *strrchr(whole, '/') = 0;
    trade->exposure_ev = import->scene.play.exposure_ev;
    status = set_cameras(trade, &import->scene, *root, error);
    for (int i = 0; i < 2; i++) trade->camera_content[i] = hash_camera(*root, trade->cameras[i]);
    trade->content = hash_content(import, *root); /* before paths, so that a folder that moved keeps its truth */
    make_paths_whole(*root, whole);
cleanup:
    al_import_free(import);
    if (status) json_decref(*root), *root = NULL;
    return status;
}

const char *al_scene_value(const void *scene, const char *key, char text[AL_VALUE_SIZE])
{
    const char *dot = strchr(key, '.');
    char block[AL_NAME_SIZE];
    snprintf(block, sizeof block, "%.*s", (int)(dot - key), key);
    json_t *value = json_object_get(json_object_get(scene, block), dot + 1);
    if (!json_is_number(value)) return NULL;
    snprintf(text, AL_VALUE_SIZE, "%.12g", json_number_value(value));
    return text;
}

char *al_scene_derive(const json_t *root, const al_knobs *knobs, const al_point *point)
{
    json_t *copy = json_deep_copy(root);
    for (int k = 0; k < knobs->count; k++) {
        const char *name = knobs->knobs[k].name, *dot = strchr(name, '.'), *value = knobs->knobs[k].values[point->chosen[k]];
        if (!dot) continue;
        char block[AL_NAME_SIZE];
        snprintf(block, sizeof block, "%.*s", (int)(dot - name), name);
        json_t *settings = json_object_get(copy, block);
        if (!settings) json_object_set_new(copy, block, settings = json_object());
        if (!strcmp(name, "bake.samples")) json_object_del(settings, "radius_m"); /* the other way to say it */
        json_object_set_new(settings, dot + 1, json_integer(strtoll(value, NULL, 10)));
    }
    char *text = json_dumps(copy, JSON_INDENT(2) | JSON_REAL_PRECISION(17));
    json_decref(copy);
    return text;
}
