/* Scenes: every field comes back, large arrays without a copy; scenes that no reader would take are refused.
 */
#include "airlight/scene.h"

#include <stddef.h>
#include <stdlib.h>
#include <unistd.h>

#include "../test.h"
#include "folder.h"
#include "forge.h"
#include "golden_data.h"

static bool same_text(const char *a, const char *b)
{
    return a && b && !strcmp(a, b);
}

static bool same_mesh(const al_mesh *a, const al_mesh *b)
{
    if (a->vertex_count != b->vertex_count || a->index_count != b->index_count ||
        a->submesh_count != b->submesh_count)
        return false;
    if ((a->uv0 != NULL) != (b->uv0 != NULL) || (a->uv1 != NULL) != (b->uv1 != NULL)) return false;
    return same_text(a->name, b->name) && !memcmp(a->positions, b->positions, 12 * a->vertex_count) &&
           !memcmp(a->normals, b->normals, 12 * a->vertex_count) &&
           (!a->uv0 || !memcmp(a->uv0, b->uv0, 8 * a->vertex_count)) &&
           (!a->uv1 || !memcmp(a->uv1, b->uv1, 8 * a->vertex_count)) &&
           !memcmp(a->indices, b->indices, 4 * a->index_count) &&
           !memcmp(a->submeshes, b->submeshes, sizeof *a->submeshes * a->submesh_count);
}

static bool same_material(const al_material *a, const al_material *b)
{
    return same_text(a->name, b->name) && !memcmp(a->base_color, b->base_color, 12) &&
           a->metallic == b->metallic && a->roughness == b->roughness &&
           !memcmp(a->emission_w_m2_sr, b->emission_w_m2_sr, 12) && a->ior == b->ior &&
           a->double_sided == b->double_sided && a->base_color_texture == b->base_color_texture &&
           a->emission_texture == b->emission_texture &&
           a->metallic_roughness_texture == b->metallic_roughness_texture &&
           a->normal_texture == b->normal_texture;
}

static void compare(const al_scene *a, const al_scene *b)
{
    CHECK(a->texture_count == b->texture_count && a->material_count == b->material_count &&
          a->mesh_count == b->mesh_count && a->instance_count == b->instance_count &&
          a->medium_count == b->medium_count && a->translucent_count == b->translucent_count &&
          a->light_count == b->light_count && a->camera_count == b->camera_count);
    for (uint32_t i = 0; i < a->texture_count; i++) {
        const al_texture *s = &a->textures[i], *t = &b->textures[i];
        CHECK(same_text(s->name, t->name) && s->width == t->width && s->height == t->height &&
              s->srgb == t->srgb && !memcmp(s->pixels, t->pixels, 4 * s->width * s->height));
    }
    for (uint32_t i = 0; i < a->material_count; i++) CHECK(same_material(&a->materials[i], &b->materials[i]));
    for (uint32_t i = 0; i < a->mesh_count; i++) CHECK(same_mesh(&a->meshes[i], &b->meshes[i]));
    for (uint32_t i = 0; i < a->instance_count; i++) {
        const al_instance *s = &a->instances[i], *t = &b->instances[i];
        CHECK(same_text(s->name, t->name) && s->mesh == t->mesh && s->role == t->role &&
              s->translucent == t->translucent && !memcmp(s->world, t->world, sizeof s->world));
    }
    for (uint32_t i = 0; i < a->medium_count; i++)
        CHECK(same_text(a->media[i].name, b->media[i].name) &&
              !memcmp(a->media[i].sigma_s_per_m, b->media[i].sigma_s_per_m, 28));
    for (uint32_t i = 0; i < a->translucent_count; i++) {
        const al_translucent_object *s = &a->translucents[i], *t = &b->translucents[i];
        CHECK(same_text(s->name, t->name) && s->instance == t->instance && s->medium == t->medium &&
              same_text(s->asset, t->asset));
    }
    for (uint32_t i = 0; i < a->light_count; i++)
        CHECK(same_text(a->lights[i].name, b->lights[i].name) && a->lights[i].type == b->lights[i].type &&
              !memcmp(a->lights[i].vector, b->lights[i].vector, 24));
    for (uint32_t i = 0; i < a->camera_count; i++)
        CHECK(same_text(a->cameras[i].name, b->cameras[i].name) &&
              !memcmp(a->cameras[i].position, b->cameras[i].position, 40));
    CHECK(a->environment.width == b->environment.width && a->environment.height == b->environment.height);
    CHECK(!a->environment.width || !memcmp(a->environment.pixels, b->environment.pixels,
                                           12 * a->environment.width * a->environment.height));
    CHECK(!memcmp(a->environment.sh, b->environment.sh, sizeof a->environment.sh));
    CHECK(!memcmp(&a->play, &b->play, sizeof a->play));
}

static void test_round_trip(const char *path, const al_scene *scene)
{
    al_error error = {0};
    al_file *file;
    al_scene back;
    uint64_t bytes;
    CHECK(al_scene_write(path, scene, NULL, &bytes, &error) == AL_OK);
    CHECK(al_file_open(path, NULL, &file, &error) == AL_OK && al_file_size(file) == bytes);
    CHECK(al_scene_read(file, &back, &error) == AL_OK);
    compare(scene, &back);
    al_scene_free(&back);
    CHECK(back.mesh_count == 0 && !back.meshes && !back.storage);
    al_file_close(file);
    unlink(path);
}

/* Arrays lie in the memory that was handed in, 64-byte aligned. */
static void test_in_place(void)
{
    forged f = forge_load(AIRLIGHT_GOLDEN "/scene_1_0.air");
    uint8_t *aligned = aligned_alloc(64, (f.size + 63) / 64 * 64);
    al_error error = {0};
    al_file *file;
    al_scene scene;
    if (!f.data || !aligned) exit(1);
    memcpy(aligned, f.data, f.size);
    CHECK(al_file_from_memory("memory", aligned, f.size, NULL, &file, &error) == AL_OK &&
          al_scene_read(file, &scene, &error) == AL_OK);
    const void *arrays[] = {scene.meshes[0].positions, scene.meshes[0].normals,  scene.meshes[0].uv1,
                            scene.meshes[1].indices,   scene.textures[0].pixels, scene.environment.pixels};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++) {
        const uint8_t *at = arrays[i];
        CHECK(at >= aligned && at < aligned + f.size && (uintptr_t)at % 64 == 0);
    }
    CHECK((const uint8_t *)scene.materials[0].name >= aligned &&
          (const uint8_t *)scene.materials[0].name < aligned + f.size);
    al_scene_free(&scene);
    al_file_close(file);
    free(aligned);
    free(f.data);
}

static void refuse(const char *path, const al_scene *scene, const char *words)
{
    al_error error = {0};
    al_status status = al_scene_write(path, scene, NULL, NULL, &error);
    if (status != AL_BAD_INPUT || !strstr(error.message, words))
        fprintf(stderr, "wanted '%s', got %d: %s\n", words, status, error.message);
    CHECK(status == AL_BAD_INPUT && strstr(error.message, words));
    CHECK(access(path, F_OK) != 0);
}

static void test_refusals(const char *path)
{
    al_scene scene;
    golden_fill_scene(&scene);
    scene.camera_count = 0;
    refuse(path, &scene, "no camera");
    golden_fill_scene(&scene);
    scene.material_count = 1;
    refuse(path, &scene, "names material 1 of 1");
    golden_fill_scene(&scene);
    scene.play.exposure_ev = NAN;
    refuse(path, &scene, "play.exposure_ev is not finite");
    golden_fill_scene(&scene);
    al_light dark = {"night", AL_LIGHT_POINT, {0, 0, 0}, {-1, 0, 0}};
    scene.lights = &dark;
    scene.light_count = 1;
    refuse(path, &scene, "intensity is -1");
    golden_fill_scene(&scene);
    al_translucent_object other = {"candle", 1, 0, "../secret.air"};
    scene.translucents = &other;
    refuse(path, &scene, "(rule 312)");
}

static void test_storage(void)
{
    al_scene scene = {0};
    char *name = al_scene_text(&scene, "a name");
    unsigned char *block = al_scene_allocate(&scene, 1000);
    CHECK(same_text(name, "a name") && block && (uintptr_t)block % _Alignof(max_align_t) == 0);
    for (int i = 0; block && i < 1000; i++) CHECK(block[i] == 0);
    CHECK(al_scene_allocate(&scene, 0) != NULL);
    CHECK(al_scene_allocate(&scene, SIZE_MAX) == NULL);
    al_scene_free(&scene);
    al_scene_free(&scene);
    CHECK(!scene.storage);
}

int main(void)
{
    char folder[256], path[512];
    al_scene scene;
    if (!folder_make(folder, sizeof folder)) return test_skip("no temporary folder");
    snprintf(path, sizeof path, "%s/scene.air", folder);
    golden_fill_scene(&scene);
    test_round_trip(path, &scene);
    al_camera camera = {"only", {0, 0, 1}, {0, 0, 0}, {0, 1, 0}, 1};
    al_scene empty = {.cameras = &camera, .camera_count = 1}; /* nothing to see is a scene too */
    test_round_trip(path, &empty);
    test_in_place();
    test_refusals(path);
    test_storage();
    CHECK(rmdir(folder) == 0);
    return test_end();
}
