#include "import.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "environment.h"
#include "geometry.h"
#include "inputs.h"
#include "mesh_file.h"
#include "motion_import.h"

enum { LIGHT_LIMIT = 64, NAME_ROOM = 1024, PATH_ROOM = 4096 };

static al_status out_of_memory(const al_import *import, al_error *error)
{
    return al_fail(error, AL_IO, "%s: out of memory while importing the scene", import->description->path);
}

/* --- what the scene file says itself --- */

static al_status copy_materials(al_import *import, al_error *error)
{
    al_scene *scene = &import->scene;
    for (uint32_t i = 0; i < import->description->material_count; i++) {
        al_material *material =
            al_scene_append(scene, &scene->materials, &scene->material_count, sizeof *material);
        if (!material) return out_of_memory(import, error);
        *material = import->description->materials[i];
        material->name = al_scene_text(scene, material->name);
        if (!material->name) return out_of_memory(import, error);
    }
    return AL_OK;
}

static al_status copy_lights(al_import *import, al_error *error)
{
    al_scene *scene = &import->scene;
    for (uint32_t i = 0; i < import->description->light_count; i++) {
        al_light *light = al_scene_append(scene, &scene->lights, &scene->light_count, sizeof *light);
        if (!light) return out_of_memory(import, error);
        *light = import->description->lights[i];
        light->name = al_scene_text(scene, light->name);
        if (!light->name) return out_of_memory(import, error);
    }
    return AL_OK;
}

static al_status copy_cameras(al_import *import, al_error *error)
{
    al_scene *scene = &import->scene;
    for (uint32_t i = 0; i < import->description->camera_count; i++) {
        al_camera *camera = al_scene_append(scene, &scene->cameras, &scene->camera_count, sizeof *camera);
        if (!camera) return out_of_memory(import, error);
        *camera = import->description->cameras[i];
        camera->name = al_scene_text(scene, camera->name);
        if (!camera->name) return out_of_memory(import, error);
    }
    return AL_OK;
}

static al_status copy_media(al_import *import, al_error *error)
{
    al_scene *scene = &import->scene;
    uint32_t count = import->description->medium_count;
    scene->media = al_scene_array(scene, count, sizeof *scene->media);
    if (!scene->media) return out_of_memory(import, error);
    for (uint32_t i = 0; i < count; i++) {
        const al_medium_description *from = &import->description->media[i];
        al_medium *medium = &scene->media[i];
        medium->name = al_scene_text(scene, from->name);
        if (!medium->name) return out_of_memory(import, error);
        medium->g = (float)from->g;
        for (int k = 0; k < 3; k++) {
            medium->sigma_s_per_m[k] = (float)from->sigma_s_per_m[k];
            medium->sigma_a_per_m[k] = (float)from->sigma_a_per_m[k];
        }
    }
    scene->medium_count = count;
    return AL_OK;
}

/* A grid's own bounds are known to its density; the asset's name to the bake. */
static al_status copy_fogs(al_import *import, al_error *error)
{
    al_scene *scene = &import->scene;
    const al_scene_description *description = import->description;
    scene->fogs = al_scene_array(scene, description->fog_count, sizeof *scene->fogs);
    scene->baked = (al_baked_light){al_scene_text(scene, ""), al_scene_text(scene, "")};
    if (!scene->fogs || !scene->baked.lightmap || !scene->baked.probes) return out_of_memory(import, error);
    for (uint32_t i = 0; i < description->fog_count; i++) {
        al_fog *fog = &scene->fogs[i];
        double low[3], high[3];
        fog->medium = description->fogs[i];
        fog->bounded = al_density_bounds(import->densities[fog->medium], low, high);
        fog->density = (float)al_density_max(import->densities[fog->medium]);
        fog->asset = scene->baked.lightmap;
        for (int k = 0; k < 3 && fog->bounded; k++) {
            fog->bounds_min_m[k] = (float)low[k];
            fog->bounds_max_m[k] = (float)high[k];
        }
    }
    scene->fog_count = description->fog_count;
    return AL_OK;
}

static al_status open_densities(al_import *import, al_error *error)
{
    const al_scene_description *description = import->description;
    import->densities = calloc(description->medium_count + (size_t)1, sizeof(al_density *));
    if (!import->densities) return out_of_memory(import, error);
    for (uint32_t i = 0; i < description->medium_count; i++) {
        const al_medium_description *medium = &description->media[i];
        al_status status = AL_OK;
        for (uint32_t k = 0; k < medium->density.frame_count && medium->density.type == AL_DENSITY_GRID && !status; k++) {
            char path[PATH_ROOM];
            al_density_frame_file(&medium->density, k, path, sizeof path);
            status = al_inputs_hash(import, path, error);
        }
        if (!status) status = al_density_open(description, medium, &import->densities[i], error);
        if (status) return status;
    }
    return AL_OK;
}

/* --- meshes --- */

static uint32_t find_mesh(const al_scene_description *description, const char *name)
{
    for (uint32_t i = 0; i < description->mesh_count; i++)
        if (strcmp(description->meshes[i].name, name) == 0) return i;
    return AL_NO_INDEX;
}

static uint32_t find_medium(const al_scene_description *description, const char *name)
{
    for (uint32_t i = 0; i < description->medium_count; i++)
        if (strcmp(description->media[i].name, name) == 0) return i;
    return AL_NO_INDEX;
}

/* The rigid object-to-world matrix of a boundary, from the scene file alone. */
static void object_matrix(const al_mesh_description *mesh, double object[16])
{
    double placement[16], rest[16];
    memcpy(placement, mesh->transform, sizeof placement);
    al_matrix_split(placement, object, rest);
}

static al_status check_new_meshes(const al_import *import, uint32_t first, const al_mesh_use *use,
                                  al_error *error)
{
    al_status status = AL_OK;
    for (uint32_t i = first; i < import->scene.instance_count && use->role != AL_ROLE_OPAQUE && !status;
         i++) {
        al_triangles triangles;
        status =
            al_triangles_from_mesh(&import->scene.meshes[import->scene.instances[i].mesh], &triangles, error);
        if (status) break;
        status = al_triangles_check(use->name, &triangles, error);
        al_triangles_free(&triangles);
    }
    return status;
}

/* `moved` is the mesh whose motion it follows: its own, or for a blocker that of the boundary. */
static al_status import_mesh(al_import *import, uint32_t index, al_role role, uint32_t translucent,
                             const double object[16], uint32_t moved, al_error *error)
{
    const al_mesh_description *mesh = &import->description->meshes[index];
    char name[NAME_ROOM];
    snprintf(name, sizeof name, "%s:%d: mesh \"%s\"%s%s%s", import->description->path, mesh->line, mesh->name,
             *mesh->file ? " (" : "", mesh->file, *mesh->file ? ")" : "");
    const al_mesh_description *with = &import->description->meshes[moved];
    const al_mesh_use use = {role,
                             translucent,
                             object,
                             &with->motion,
                             {with->transform[12], with->transform[13], with->transform[14]},
                             name};
    uint32_t first = import->scene.instance_count;
    al_status status = al_mesh_file_import(import, mesh, &use, error);
    return status ? status : check_new_meshes(import, first, &use, error);
}

static al_status import_translucent(al_import *import, uint32_t index, bool *taken, al_error *error)
{
    const al_translucent_description *from = &import->description->translucents[index];
    al_scene *scene = &import->scene;
    al_translucent_object *object = &scene->translucents[index];
    uint32_t boundary = find_mesh(import->description, from->mesh);
    double matrix[16];
    object_matrix(&import->description->meshes[boundary], matrix);
    taken[boundary] = true;
    object->instance = scene->instance_count;
    object->medium = find_medium(import->description, from->medium);
    object->name = al_scene_text(scene, from->name);
    object->asset = al_scene_text(scene, "");
    if (!object->name || !object->asset) return out_of_memory(import, error);
    al_status status = import_mesh(import, boundary, AL_ROLE_TRANSLUCENT, index, matrix, boundary, error);
    for (uint32_t i = 0; i < from->blocker_count && !status; i++) {
        uint32_t blocker = find_mesh(import->description, from->blockers[i]);
        taken[blocker] = true;
        status = import_mesh(import, blocker, AL_ROLE_BLOCKER, index, matrix, boundary, error);
    }
    return status;
}

static al_status import_meshes(al_import *import, al_error *error)
{
    const al_scene_description *description = import->description;
    al_scene *scene = &import->scene;
    al_status status = AL_OK;
    bool *taken = calloc(description->mesh_count + (size_t)1, sizeof *taken);
    scene->translucents = al_scene_array(scene, description->translucent_count, sizeof *scene->translucents);
    if (!taken || !scene->translucents) {
        status = out_of_memory(import, error);
        goto cleanup;
    }
    scene->translucent_count = description->translucent_count;
    for (uint32_t i = 0; i < description->translucent_count && !status; i++)
        status = import_translucent(import, i, taken, error);
    for (uint32_t i = 0; i < description->mesh_count && !status; i++)
        if (!taken[i]) status = import_mesh(import, i, AL_ROLE_OPAQUE, AL_NO_INDEX, NULL, i, error);
cleanup:
    free(taken);
    return status;
}

/* --- cameras need to know where things are --- */

static void grow_box(double low[3], double high[3], const double point[3])
{
    for (int i = 0; i < 3; i++) {
        low[i] = fmin(low[i], point[i]);
        high[i] = fmax(high[i], point[i]);
    }
}

/* Centre and half diagonal of everything in the scene; (0, 0, 0) and 1 for an empty one. */
static void measure_scene(const al_scene *scene, double centre[3], double *radius)
{
    double low[3] = {DBL_MAX, DBL_MAX, DBL_MAX}, high[3] = {-DBL_MAX, -DBL_MAX, -DBL_MAX}, square = 0;
    for (uint32_t i = 0; i < scene->instance_count; i++) {
        const al_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        double world[16];
        for (int k = 0; k < 16; k++) world[k] = scene->instances[i].world[k];
        for (size_t v = 0; v < mesh->vertex_count; v++) {
            double point[3] = {mesh->positions[v * 3], mesh->positions[v * 3 + 1],
                               mesh->positions[v * 3 + 2]};
            al_matrix_point(world, point, point);
            grow_box(low, high, point);
        }
    }
    for (int i = 0; i < 3; i++) {
        bool empty = low[i] > high[i];
        centre[i] = empty ? 0 : (low[i] + high[i]) / 2;
        square += empty ? 1.0 / 3 : (high[i] - low[i]) * (high[i] - low[i]) / 4;
    }
    *radius = square > 0 ? sqrt(square) : 1;
}

/* The whole box in view with a tenth to spare: distance = radius / sin(fov / 2). */
static al_status add_default_camera(al_import *import, const double centre[3], double radius, al_error *error)
{
    al_scene *scene = &import->scene;
    const double toward[3] = {0.4, 0.35, 0.85}, fov = 40 * (3.14159265358979323846 / 180);
    double length = sqrt(toward[0] * toward[0] + toward[1] * toward[1] + toward[2] * toward[2]);
    al_camera *camera = al_scene_append(scene, &scene->cameras, &scene->camera_count, sizeof *camera);
    if (!camera) return out_of_memory(import, error);
    camera->name = al_scene_text(scene, "default");
    if (!camera->name) return out_of_memory(import, error);
    for (int i = 0; i < 3; i++) {
        camera->target[i] = (float)centre[i];
        camera->position[i] = (float)(centre[i] + 1.1 * radius / sin(fov / 2) * toward[i] / length);
        camera->up[i] = i == 1;
    }
    camera->fov_y_radians = (float)fov;
    return AL_OK;
}

/* Cameras of mesh files only know a direction: what they look at is as far away as the scene's centre. */
static al_status finish_cameras(al_import *import, al_error *error)
{
    al_scene *scene = &import->scene;
    double centre[3], radius;
    measure_scene(scene, centre, &radius);
    for (uint32_t i = import->description->camera_count; i < scene->camera_count; i++) {
        al_camera *camera = &scene->cameras[i];
        double distance = 0;
        for (int k = 0; k < 3; k++)
            distance += (centre[k] - camera->position[k]) * (centre[k] - camera->position[k]);
        distance = fmax(sqrt(distance), radius / 100);
        for (int k = 0; k < 3; k++)
            camera->target[k] =
                (float)(camera->position[k] + distance * ((double)camera->target[k] - camera->position[k]));
    }
    return scene->camera_count ? AL_OK : add_default_camera(import, centre, radius, error);
}

/* --- all of it --- */

static al_status check_result(const al_import *import, al_error *error)
{
    const al_scene *scene = &import->scene;
    const char *path = import->description->path;
    if (scene->light_count > LIGHT_LIMIT)
        return al_fail(error, AL_BAD_INPUT,
                       "%s: %u lights with those of the mesh files; at most %d are right", path,
                       scene->light_count, LIGHT_LIMIT);
    for (uint32_t i = 0; i < scene->medium_count; i++) {
        const al_medium *medium = &scene->media[i];
        float sum = 0;
        for (int k = 0; k < 3; k++) sum += medium->sigma_s_per_m[k] + medium->sigma_a_per_m[k];
        if (!(sum > 0))
            return al_fail(error, AL_BAD_INPUT, "%s:%d: medium \"%s\" neither scatters nor absorbs", path,
                           import->description->media[i].line, medium->name);
    }
    return AL_OK;
}

static al_status fill_scene(al_import *import, al_error *error)
{
    import->scene.play = import->description->play;
    al_status status = copy_materials(import, error);
    if (!status) status = copy_lights(import, error);
    if (!status) status = copy_cameras(import, error);
    if (!status) status = copy_media(import, error);
    if (!status) status = import_meshes(import, error);
    if (!status) status = open_densities(import, error);
    if (!status) status = copy_fogs(import, error);
    if (!status) status = al_motion_bind_described(import, error);
    if (!status) status = al_motion_finish(import, error);
    if (!status) status = al_environment_import(import, error);
    if (!status) status = finish_cameras(import, error);
    return status ? status : check_result(import, error);
}

al_status al_import_scene(const char *path, al_quality quality, al_import **import, al_error *error)
{
    *import = NULL;
    al_import *made = calloc(1, sizeof *made);
    if (!made) return al_fail(error, AL_IO, "%s: out of memory while importing the scene", path);
    al_status status = al_scene_description_read(path, quality, &made->description, error);
    if (!status) status = al_inputs_hash(made, path, error);
    if (!status) status = fill_scene(made, error);
    if (status)
        al_import_free(made);
    else
        *import = made;
    return status;
}

void al_import_free(al_import *import)
{
    if (!import) return;
    for (uint32_t i = 0; import->densities && i < import->description->medium_count; i++)
        al_density_free(import->densities[i]);
    free(import->densities);
    for (uint32_t i = 0; i < import->input_count; i++) free(import->inputs[i].path);
    free(import->inputs);
    al_scene_free(&import->scene);
    al_scene_description_free(import->description);
    free(import);
}
