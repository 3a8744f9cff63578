/* A page made whole: texels behind surfaces, padding, seams; and files that others read. */
#include "light_page.h"

#include <stdlib.h>
#include <unistd.h>

#include "../import/files.h"
#include "airlight/image.h"
#include "glb.h"
#include "second_uv.h"
#include "texels.h"

static al_light_page page_of(uint32_t width, uint32_t height, uint32_t channels)
{
    al_light_page page;
    CHECK(al_light_page_make(width, height, channels, &page, NULL) == AL_OK);
    return page;
}

/* Two charts of constant light, 2 and 6, a column of padding between; a block behind surfaces in each, and a
 * third chart that is behind surfaces altogether. */
static void test_replace(void)
{
    al_light_page page = page_of(15, 5, 1);
    uint32_t replaced;
    for (uint32_t i = 0; i < 15 * 5; i++) {
        uint32_t x = i % 15, y = i / 15, chart = x / 5;
        if (x % 5 == 4) continue;
        page.chart[i] = chart;
        page.light[i] = chart == 0 ? 2 : chart == 1 ? 6 : 9;
        bool behind = chart == 2 || (x % 5 > 1 && y > 1);
        page.state[i] = behind ? AL_TEXEL_REPLACED : AL_TEXEL_BAKED;
        if (behind && chart < 2) page.light[i] = 100;
    }
    CHECK(al_light_page_replace(&page, &replaced, NULL) == AL_OK);
    CHECK(replaced == 2 * 2 * 3);
    for (uint32_t i = 0; i < 15 * 5; i++) {
        uint32_t chart = i % 15 / 5;
        if (page.state[i] == AL_TEXEL_EMPTY) continue;
        CHECK(page.light[i] == (chart == 0 ? 2 : chart == 1 ? 6 : 9)); /* each from its own chart */
        if (chart == 2) CHECK(page.state[i] == AL_TEXEL_BAKED);
    }
    al_light_page_free(&page);
}

/* One texel of light: `rings` squares around it, nothing beyond. */
static void test_dilate(void)
{
    al_light_page page = page_of(9, 9, 2);
    page.state[4 * 9 + 4] = AL_TEXEL_BAKED;
    page.chart[4 * 9 + 4] = 7;
    page.light[2 * (4 * 9 + 4)] = 3;
    page.light[2 * (4 * 9 + 4) + 1] = -1;
    CHECK(al_light_page_dilate(&page, 2, NULL) == AL_OK);
    for (int i = 0; i < 81; i++) {
        int distance = abs(i % 9 - 4) > abs(i / 9 - 4) ? abs(i % 9 - 4) : abs(i / 9 - 4);
        CHECK(page.state[i] == (distance == 0   ? AL_TEXEL_BAKED
                                : distance <= 2 ? AL_TEXEL_DILATED
                                                : AL_TEXEL_EMPTY));
        CHECK(page.light[2 * i] == (distance <= 2 ? 3 : 0) &&
              page.light[2 * i + 1] == (distance <= 2 ? -1 : 0));
        if (distance <= 2) CHECK(page.chart[i] == 7);
    }
    al_light_page_free(&page);
}

static al_import *import_text(const char *path, const char *json)
{
    al_import *import = NULL;
    al_error error = {0};
    write_text(path, json);
    if (al_import_scene(path, AL_QUALITY_PREVIEW, &import, &error) != AL_OK) {
        fprintf(stderr, "%s\n", error.message);
        CHECK(!"the scene is imported");
    }
    return import;
}

/* A sphere lit as 1.5 + y: smooth in space, read at texels whose points differ on both sides of a seam, and
 * noise of 5 % on each texel. Stitching must take most of the jump away and leave the light what it was: a
 * texel moves by about the noise. */
static void test_stitch(void)
{
    al_import *import =
        import_text("page_test.json",
                    "{\"meshes\": [{\"name\": \"ball\", \"shape\": {\"type\": \"sphere\", \"radius_m\": "
                    "1, \"subdivisions\": 4}, \"lighting\": \"lightmap\"}], \"lightmap\": {\"texel_m\": "
                    "0.05}}");
    al_atlas atlas;
    al_texels texels;
    al_seams seams;
    if (!import) return;
    CHECK(al_atlas_make(import, &atlas, NULL) == AL_OK && atlas.page_count == 1);
    CHECK(al_texels_make(&import->scene, &atlas, &texels, NULL) == AL_OK);
    al_light_page page = page_of(atlas.pages[0][0], atlas.pages[0][1], 2);
    uint64_t state = 1;
    double moved = 0, sum = 0, before_sum = 0;
    float *before = malloc(texels.count * sizeof *before);
    for (uint32_t i = 0; i < texels.count; i++) {
        const al_texel *t = &texels.texels[i];
        state = state * 6364136223846793005u + 1442695040888963407u;
        double noise = ((double)(state >> 33) / 0x1p31 - 0.5) * sqrt(12) * 0.05;
        before[i] = (float)((1.5 + t->position[1]) * (1 + noise));
        page.light[2 * (size_t)t->cell] = before[i];
        page.light[2 * (size_t)t->cell + 1] =
            -1; /* a channel that may be negative, already the same everywhere */
        page.state[t->cell] = AL_TEXEL_BAKED;
        page.chart[t->cell] = t->chart;
    }
    CHECK(al_light_page_dilate(&page, 2, NULL) == AL_OK);
    CHECK(al_light_page_stitch(&import->scene, &atlas, 0, 1, &page, &seams, NULL) == AL_OK);
    CHECK(seams.places > 100 && seams.jump_before > 0.02);
    CHECK(seams.jump_after < 0.1 * seams.jump_before);
    for (uint32_t i = 0; i < texels.count; i++) {
        float after = page.light[2 * (size_t)texels.texels[i].cell];
        moved += (after - before[i]) * (double)(after - before[i]);
        sum += after;
        before_sum += before[i];
        CHECK(after >= 0);
        CHECK_NEAR(page.light[2 * (size_t)texels.texels[i].cell + 1], -1, 1e-6);
    }
    CHECK(sqrt(moved / texels.count) < 0.05);
    CHECK_NEAR(sum / before_sum, 1, 0.005);
    printf("seams: %u places, jump %.4f before, %.4f after\n", seams.places, seams.jump_before,
           seams.jump_after);
    free(before);
    al_light_page_free(&page);
    al_texels_free(&texels);
    al_atlas_free(&atlas);
    al_import_free(import);
}

/* --- the scene as glTF, read by our own importer --- */

static const char *const scene_json =
    "{\"meshes\": [{\"name\": \"ball\", \"shape\": {\"type\": \"sphere\", \"radius_m\": 1, \"subdivisions\": "
    "2}, "
    "\"lighting\": \"lightmap\", \"material\": \"red\", \"transform\": {\"translate_m\": [1, 2, 3]}}, "
    "{\"name\": \"panel\", \"shape\": {\"type\": \"plane\", \"width_m\": 2, \"depth_m\": 1}, \"lighting\": "
    "\"lightmap\", \"material\": \"hot\"}], \"materials\": [{\"name\": \"red\", \"base_color\": [0.75, 0.25, "
    "0.125], "
    "\"roughness\": 0.25}, {\"name\": \"hot\", \"emission_w_m2_sr\": [8, 4, 2], \"double_sided\": true}], "
    "\"lights\": "
    "[{\"name\": \"sun\", \"type\": \"directional\", \"direction\": [0.6, -0.8, 0], \"irradiance_w_m2\": [4, "
    "2, 1]}, "
    "{\"name\": \"lamp\", \"type\": \"point\", \"position_m\": [1, 5, 2], \"intensity_w_sr\": 7}], "
    "\"cameras\": "
    "[{\"name\": \"eye\", \"position_m\": [4, 3, 5], \"target_m\": [0, 1, 0], \"fov_y_degrees\": 50}], "
    "\"lightmap\": "
    "{\"texel_m\": 0.1}}";

static void bounds(const al_scene *scene, double low[3], double high[3], double *area_uv1)
{
    *area_uv1 = 0;
    for (int k = 0; k < 3; k++) low[k] = INFINITY, high[k] = -INFINITY;
    for (uint32_t i = 0; i < scene->instance_count; i++) {
        const al_instance *instance = &scene->instances[i];
        const al_mesh *mesh = &scene->meshes[instance->mesh];
        for (size_t v = 0; v < mesh->vertex_count; v++)
            for (size_t k = 0; k < 3; k++) {
                double at = instance->world[12 + k];
                for (size_t j = 0; j < 3; j++)
                    at += (double)instance->world[4 * j + k] * mesh->positions[3 * v + j];
                low[k] = fmin(low[k], at);
                high[k] = fmax(high[k], at);
            }
        for (size_t t = 0; mesh->uv1 && t < mesh->index_count; t += 3) {
            const float *a = mesh->uv1 + 2 * (size_t)mesh->indices[t],
                        *b = mesh->uv1 + 2 * (size_t)mesh->indices[t + 1],
                        *c = mesh->uv1 + 2 * (size_t)mesh->indices[t + 2];
            *area_uv1 += fabs(((double)b[0] - a[0]) * ((double)c[1] - a[1]) -
                              ((double)b[1] - a[1]) * ((double)c[0] - a[0]));
        }
    }
}

static const al_material *find_material(const al_scene *scene, const char *name)
{
    for (uint32_t i = 0; i < scene->material_count; i++)
        if (!strcmp(scene->materials[i].name, name)) return &scene->materials[i];
    return NULL;
}

static void check_lights(const al_scene *a, const al_scene *b)
{
    CHECK(a->light_count == b->light_count);
    for (uint32_t i = 0; i < a->light_count && i < b->light_count; i++) {
        CHECK(a->lights[i].type == b->lights[i].type);
        for (int k = 0; k < 3; k++) {
            CHECK_NEAR(b->lights[i].vector[k], a->lights[i].vector[k], 1e-5);
            CHECK_NEAR(b->lights[i].intensity[k], a->lights[i].intensity[k], 1e-5);
        }
    }
}

/* Written with our atlas, read again with "uv": "file": the second UV set serves as it stands. */
static void test_glb(void)
{
    al_import *import = import_text("page_test.json", scene_json);
    al_atlas atlas, second;
    al_error error = {0};
    uint64_t bytes;
    double low[2][3], high[2][3], area[2];
    if (!import) return;
    CHECK(al_atlas_make(import, &atlas, &error) == AL_OK);
    CHECK(al_glb_write("page_test.glb", &import->scene, &bytes, &error) == AL_OK && bytes > 1000);
    al_import *again =
        import_text("page_test_glb.json",
                    "{\"meshes\": [{\"name\": \"all\", \"file\": \"page_test.glb\", \"lighting\": "
                    "\"lightmap\", \"import_lights\": true, \"import_cameras\": true}], \"lightmap\": "
                    "{\"texel_m\": 0.1, \"uv\": \"file\"}}");
    if (!again) return;
    const al_scene *a = &import->scene, *b = &again->scene;
    CHECK(b->instance_count == a->instance_count && b->camera_count == 1);
    bounds(a, low[0], high[0], &area[0]);
    bounds(b, low[1], high[1], &area[1]);
    for (int k = 0; k < 3; k++) {
        CHECK_NEAR(low[1][k], low[0][k], 1e-5);
        CHECK_NEAR(high[1][k], high[0][k], 1e-5);
        CHECK_NEAR(b->cameras[0].position[k], a->cameras[0].position[k], 1e-5);
    }
    CHECK_NEAR(area[1], area[0], 1e-5 * area[0]);
    CHECK_NEAR(b->cameras[0].fov_y_radians, a->cameras[0].fov_y_radians, 1e-5);
    check_lights(a, b);
    const al_material *red = find_material(b, "red"), *hot = find_material(b, "hot");
    CHECK(red && hot);
    if (red && hot) {
        CHECK_NEAR(red->base_color[0], 0.75, 1e-6);
        CHECK_NEAR(red->roughness, 0.25, 1e-6);
        CHECK(hot->double_sided && !red->double_sided);
        for (int k = 0; k < 3; k++) CHECK_NEAR(hot->emission_w_m2_sr[k], k == 0 ? 8 : k == 1 ? 4 : 2, 1e-5);
    }
    al_status status = al_atlas_make(again, &second, &error);
    CHECK(status == AL_OK && second.own_count == 0);
    if (status != AL_OK) fprintf(stderr, "%s\n", error.message);
    al_atlas_free(&second);
    al_atlas_free(&atlas);
    al_import_free(import);
    al_import_free(again);
}

/* Nine channels in three layers: the root layer is empty, so nothing of it is taken for a picture, and a
 * layer named as the root's is. */
static void test_layers(void)
{
    static const char *const names[] = {"b.R", "a.Y", "R", "G", "B"};
    float pixels[2 * 3 * 5];
    al_image image;
    al_error error = {0};
    for (int i = 0; i < 30; i++) pixels[i] = (float)i;
    const al_image_channels channels = {3, 2, 5, names, pixels};
    CHECK(al_image_write_exr_channels("page_test.exr", &channels, &error) == AL_OK);
    CHECK(al_image_read_exr("page_test.exr", &image, &error) == AL_OK);
    CHECK(image.width == 3 && image.height == 2 && image.channels == 3);
    for (int i = 0; image.pixels && i < 18; i++) CHECK(image.pixels[i] == (float)(i / 3 * 5 + 2 + i % 3));
    al_image_free(&image);
    const char *const twice[] = {"R", "R"};
    const al_image_channels wrong = {3, 2, 2, twice, pixels};
    CHECK(al_image_write_exr_channels("page_test.exr", &wrong, &error) == AL_IO);
    CHECK(!strchr(error.message, '\n') && strstr(error.message, "page_test.exr"));
}

int main(void)
{
    test_replace();
    test_dilate();
    test_stitch();
    test_glb();
    test_layers();
    return test_end();
}
