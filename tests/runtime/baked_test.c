/* Baked light on surfaces: lightmapped quads against the irradiance in their asset, probe-lit ones against
 * the closed form of their SH; no light counts twice; layers by fog and by choice. */
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../test.h"
#include "airlight/formulas.h"
#include "airlight/lightmap.h"
#include "airlight/probes.h"
#include "sphere.h"
#include "stage.h"

enum { EDGE = 33, WIDTH = 8, HEIGHT = 4 };

static const char *folder;

/* Irradiance of a layer at page uv: linear, so that bilinear filtering keeps it between texel centres. */
static double irradiance(int layer, int channel, double u, double v)
{
    static const double base[AL_LAYER_COUNT] = {8, 4, 1};
    return base[layer] * (1 + 0.5 * channel + u * 0.75 + v * 0.25);
}

static void write_lightmap(al_lightmap_format format)
{
    static float texels[AL_LAYER_COUNT * WIDTH * HEIGHT * 3];
    static uint8_t state[WIDTH * HEIGHT];
    static const float vertices[4][5] = {{-1, 0, -1, 0.25f, 0.25f},
                                         {-1, 0, 1, 0.25f, 0.75f},
                                         {1, 0, 1, 0.75f, 0.75f},
                                         {1, 0, -1, 0.75f, 0.25f}};
    static const uint32_t triangles[2][3] = {{0, 1, 2}, {0, 2, 3}};
    char path[512];
    al_error error = {0};
    for (int layer = 0; layer < AL_LAYER_COUNT; layer++)
        for (int i = 0; i < WIDTH * HEIGHT * 3; i++)
            texels[layer * WIDTH * HEIGHT * 3 + i] = (float)irradiance(
                layer, i % 3, (i / 3 % WIDTH + 0.5) / WIDTH, ((double)(i / 3 / WIDTH) + 0.5) / HEIGHT);
    memset(state, AL_TEXEL_BAKED, sizeof state);
    const al_lightmap_instance instance = {
        .scale = {0.5f, 0.5f}, .offset = {0.25f, 0.25f}, .triangle_count = 2};
    const al_lightmap_source page = {WIDTH, HEIGHT, texels, NULL, state};
    const al_lightmap_data data = {.info = {.page_count = 1,
                                            .instance_count = 1,
                                            .format = format,
                                            .vertex_count = 4,
                                            .triangle_count = 2,
                                            .texel_m = 0.5f},
                                   .instances = &instance,
                                   .pages = &page,
                                   .vertices = vertices[0],
                                   .triangles = triangles[0]};
    snprintf(path, sizeof path, "%s/room.lightmap.air", folder);
    al_status status = al_lightmap_write(path, &data, NULL, &error);
    if (status) fprintf(stderr, "%s\n", error.message);
    CHECK(!status);
}

/* A tetrahedron of probes from the origin: layer l at probe i holds an even radiance (l + 1)(i + 1) and a
 * slope of a tenth of that along +y. */
static void write_probes(void)
{
    static const float positions[4][3] = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {0, 0, 4}};
    static const uint32_t tetrahedron[4] = {0, 1, 2, 3};
    static float coefficients[4][AL_LAYER_COUNT][3][9];
    char path[512];
    al_error error = {0};
    for (int i = 0; i < 4; i++)
        for (int l = 0; l < AL_LAYER_COUNT; l++)
            for (int c = 0; c < 3; c++) {
                coefficients[i][l][c][0] = (float)((l + 1) * (i + 1) * (c + 1) * sqrt(4 * AL_PI));
                coefficients[i][l][c][1] = 0.1f * coefficients[i][l][c][0];
            }
    const al_probes_data data = {.info = {4, 1, 3},
                                 .positions = positions[0],
                                 .tetrahedra = tetrahedron,
                                 .coefficients = coefficients[0][0][0]};
    snprintf(path, sizeof path, "%s/room.probes.air", folder);
    al_status status = al_probes_write(path, &data, NULL, &error);
    if (status) fprintf(stderr, "%s\n", error.message);
    CHECK(!status);
}

/* A white 2 m floor at `place` that is lit so, under a sun of 5 W/m2; with a box of fog that no ray meets. */
static al_runtime *open_floor(al_lighting lighting, const float place[3], bool fog)
{
    static float uv1[8] = {0, 0, 0, 1, 1, 1, 1, 0};
    al_runtime *runtime = NULL;
    al_error error = {0};
    sphere_scene s;
    al_fog aside = {.bounded = true,
                    .bounds_min_m = {50, 50, 50},
                    .bounds_max_m = {51, 51, 51},
                    .density = 1,
                    .asset = ""};
    sphere_scene_begin(&s);
    s.meshes[1].uv1 = uv1;
    sphere_scene_add_floor(&s, 2, place);
    s.instances[0].lighting = lighting;
    sphere_scene_add_light(&s, AL_LIGHT_DIRECTIONAL, (float[3]){0, -1, 0}, 5);
    s.scene.baked = (al_baked_light){lighting == AL_LIGHTING_LIGHTMAP ? "room.lightmap.air" : "",
                                     lighting == AL_LIGHTING_PROBES ? "room.probes.air" : ""};
    s.scene.fogs = &aside;
    s.scene.fog_count = fog;
    CHECK(sphere_scene_write(folder, &s));
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK);
    CHECK(stage_load(runtime, folder));
    sphere_scene_end(&s);
    return runtime;
}

/* Straight down from 4 m: +x to the right, -z upwards; 2 m fill 60 % of the picture. */
static al_view down_view(const float place[3])
{
    al_view view = stage_look(EDGE, EDGE, (float[3]){0, 0, 4}, (float[3]){0, 0, 0}, 2 * atanf(1 / 2.4f));
    static const float turned[16] = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, -4, 1};
    memcpy(view.view, turned, sizeof turned);
    view.view[12] = -place[0];
    view.view[13] = place[2];
    view.view[14] = -4 - place[1];
    return view;
}

static float *draw(al_runtime *runtime, const al_view *view, const al_settings *settings)
{
    float *pixels = stage_draw(runtime, view, settings, 0);
    CHECK(pixels && stage_bad(pixels, EDGE * EDGE * 3) == 0);
    if (!pixels) exit(1);
    return pixels;
}

/* Radiance 1 + 0.8 x over the sphere of directions as SH of order 2: the fold with the cosine at n is
 * pi (1 + 2/3 0.8 n_x). A normal map turns the floor's normal by 30 degrees towards +x. */
static void test_normal_map(void)
{
    static float texels[AL_LAYER_COUNT * WIDTH * HEIGHT * 3], sh[AL_LAYER_COUNT * 4 * WIDTH * HEIGHT * 3];
    static uint8_t state[WIDTH * HEIGHT], bent[4] = {191, 128, 238, 255}; /* (1/2, 0, sqrt(3)/2) */
    static float uv[8] = {0, 0, 0, 1, 1, 1, 1, 0};
    static const float vertices[3][5] = {{-1, 0, -1, 0, 0}, {-1, 0, 1, 0, 1}, {1, 0, 1, 1, 1}};
    static const uint32_t triangle[3] = {0, 1, 2};
    al_texture map = {"bent", 1, 1, false, bent};
    char path[512];
    al_error error = {0};
    const size_t plane = WIDTH * HEIGHT * 3;
    for (size_t i = 0; i < AL_LAYER_COUNT * plane; i++) texels[i] = (float)AL_PI;
    for (size_t i = 0; i < AL_LAYER_COUNT * plane; i++) {
        sh[(i / plane * 4) * plane + i % plane] = (float)sqrt(4 * AL_PI);
        sh[(i / plane * 4 + 3) * plane + i % plane] = (float)(0.8 * sqrt(4 * AL_PI / 3));
    }
    memset(state, AL_TEXEL_BAKED, sizeof state);
    const al_lightmap_instance instance = {.scale = {1, 1}, .triangle_count = 1};
    const al_lightmap_source page = {WIDTH, HEIGHT, texels, sh, state};
    const al_lightmap_data data = {.info = {.page_count = 1,
                                            .instance_count = 1,
                                            .format = AL_LIGHTMAP_HALF,
                                            .directional_order = 2,
                                            .vertex_count = 3,
                                            .triangle_count = 1,
                                            .texel_m = 0.5f},
                                   .instances = &instance,
                                   .pages = &page,
                                   .vertices = vertices[0],
                                   .triangles = triangle};
    snprintf(path, sizeof path, "%s/room.lightmap.air", folder);
    CHECK(al_lightmap_write(path, &data, NULL, &error) == AL_OK);
    for (int turned = 0; turned < 2; turned++) {
        al_runtime *runtime = NULL;
        sphere_scene s;
        sphere_scene_begin(&s);
        s.meshes[1].uv0 = s.meshes[1].uv1 = uv;
        sphere_scene_add_floor(&s, 2, (float[3]){0, 0, 0});
        s.instances[0].lighting = AL_LIGHTING_LIGHTMAP;
        s.scene.baked = (al_baked_light){"room.lightmap.air", ""};
        s.scene.textures = &map;
        s.scene.texture_count = 1;
        if (turned) s.materials[1].normal_texture = 0;
        CHECK(sphere_scene_write(folder, &s) && al_runtime_create(NULL, &runtime, &error) == AL_OK);
        CHECK(stage_load(runtime, folder));
        sphere_scene_end(&s);
        al_view view = down_view((float[3]){0, 0, 0});
        float *pixels = draw(runtime, &view, NULL);
        /* 8 bits turn the normal by up to 0.4 %. */
        CHECK_NEAR(pixels[3 * (EDGE / 2 * EDGE + EDGE / 2)], turned ? 1 + 0.8 * 2 / 3 * 0.5 : 1, 3e-3);
        free(pixels);
        al_runtime_destroy(runtime);
    }
}

/* Radiance is irradiance / pi on white, bilinear between texels. Half texels: 2^-11; the texture unit's
 * weights have 8 bits or more of a texel's difference of at most a tenth. */
static void check_map(al_runtime *runtime, const al_settings *settings, const double shares[AL_LAYER_COUNT])
{
    al_view view = down_view((float[3]){0, 0, 0});
    float *pixels = draw(runtime, &view, settings);
    double worst = 0;
    for (int y = 0; y < EDGE; y++)
        for (int x = 0; x < EDGE; x++) {
            double px = (2 * (x + 0.5) / EDGE - 1) * 4 / 2.4, pz = -(2 * (y + 0.5) / EDGE - 1) * 4 / 2.4;
            if (fabs(px) > 0.98 || fabs(pz) > 0.98) continue;
            for (int c = 0; c < 3; c++) {
                double wanted = 0;
                for (int l = 0; l < AL_LAYER_COUNT; l++)
                    wanted += shares[l] * irradiance(l, c, 0.5 + px / 4, 0.5 + pz / 4) / AL_PI;
                worst = fmax(worst, fabs(pixels[3 * (y * EDGE + x) + c] / wanted - 1));
            }
        }
    printf("lightmap: relative error %.1e\n", worst);
    CHECK(worst < 1e-3);
    free(pixels);
}

static void test_lightmap(void)
{
    for (int format = AL_LIGHTMAP_FLOAT; format <= AL_LIGHTMAP_HALF; format++) {
        write_lightmap((al_lightmap_format)format);
        al_runtime *runtime = open_floor(AL_LIGHTING_LIGHTMAP, (float[3]){0, 0, 0}, false);
        check_map(runtime, NULL, (double[3]){1, 0, 0}); /* no fog; and the sun adds nothing */
        check_map(runtime, &(al_settings){.scattered_off = true}, (double[3]){1, 0, 0});
        al_runtime_destroy(runtime);
        runtime = open_floor(AL_LIGHTING_LIGHTMAP, (float[3]){0, 0, 0}, true);
        check_map(runtime, NULL, (double[3]){0, 1, 1});
        check_map(runtime, &(al_settings){.scattered_off = true}, (double[3]){0, 1, 0});
        check_map(runtime, &(al_settings){.fog_off = true}, (double[3]){1, 0, 0});
        al_runtime_destroy(runtime);
    }
}

/* Even radiance B gives B; its slope adds 2/3 of 0.1 sqrt(3) B upwards. Probes' values are linear in place.
 */
static void test_probes(void)
{
    write_probes();
    for (int i = 0; i < 3; i++) {
        const float place[3] = {0.2f + 0.4f * (float)i, 0.5f, 0.8f - 0.2f * (float)i};
        al_view view = down_view(place);
        al_runtime *runtime = open_floor(AL_LIGHTING_PROBES, place, i > 0);
        al_settings settings = {.scattered_off = i == 2};
        float *pixels = draw(runtime, &view, &settings);
        double layers = i == 0 ? 1 : i == 1 ? 2 + 3 : 2;
        double even = layers * (1 + (place[0] + 2 * place[1] + 3 * place[2]) / 4);
        for (int c = 0; c < 3; c++) {
            double wanted = even * (c + 1) * (1 + 0.1 * sqrt(3.0) * 2 / 3) + 5 / AL_PI; /* and the sun */
            CHECK_NEAR(pixels[3 * (EDGE / 2 * EDGE + EDGE / 2) + c], wanted, 1e-4 * wanted);
        }
        free(pixels);
        /* It moves on, past the mesh: the nearest place of it answers. */
        al_runtime_scene(runtime)->instances[0].world[12] = 30;
        float far[3] = {30, place[1], place[2]};
        view = down_view(far);
        free(draw(runtime, &view, NULL));
        al_runtime_destroy(runtime);
    }
}

/* Assets that are missing: said once, and the lights light the floor. */
static void test_missing(void)
{
    static const char *const names[] = {"", "room.lightmap.air", "room.probes.air"};
    for (int lighting = AL_LIGHTING_LIGHTMAP; lighting <= AL_LIGHTING_PROBES; lighting++) {
        char path[512];
        al_error error = {0};
        al_load_state state = {0};
        al_runtime *runtime = open_floor((al_lighting)lighting, (float[3]){0, 0, 0}, false);
        snprintf(path, sizeof path, "%s/%s", folder, names[lighting]);
        CHECK(remove(path) == 0 && al_runtime_load(runtime, folder, &error) == AL_OK);
        al_status status = AL_OK;
        while (!status && !state.complete) status = al_runtime_update(runtime, 0, &state, &error);
        CHECK(status == AL_BAD_INPUT && strstr(error.message, names[lighting]));
        while (!state.complete) CHECK(al_runtime_update(runtime, 0, &state, &error) == AL_OK);
        al_view view = down_view((float[3]){0, 0, 0});
        float *pixels = draw(runtime, &view, NULL);
        CHECK_NEAR(pixels[3 * (EDGE / 2 * EDGE + EDGE / 2)], 5 / AL_PI, 1e-4);
        free(pixels);
        al_runtime_destroy(runtime);
    }
}

/* A byte at a time: the lights until the page is whole, then the lightmap. */
static void test_streaming(void)
{
    write_lightmap(AL_LIGHTMAP_HALF);
    al_runtime *runtime = open_floor(AL_LIGHTING_LIGHTMAP, (float[3]){0, 0, 0}, false);
    al_error error = {0};
    al_load_state state = {0};
    al_view view = down_view((float[3]){0, 0, 0});
    int changes = 0;
    double before = 5 / AL_PI;
    CHECK(al_runtime_load(runtime, folder, &error) == AL_OK);
    while (!state.complete) {
        CHECK(al_runtime_update(runtime, 1, &state, &error) == AL_OK);
        float *pixels = draw(runtime, &view, NULL);
        double here = pixels[3 * (EDGE / 2 * EDGE + EDGE / 2)];
        changes += fabs(here - before) > 1e-3;
        before = here;
        free(pixels);
    }
    CHECK(changes == 1);
    CHECK_NEAR(before, irradiance(0, 0, 0.5, 0.5) / AL_PI, 1e-2);
    al_runtime_destroy(runtime);
}

int main(void)
{
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    folder = stage_folder();
    if (!folder) return test_skip("no temporary folder");
    test_lightmap();
    test_normal_map();
    test_probes();
    test_missing();
    test_streaming();
    return test_end();
}
