/* Light of one bounce beside the rest of the frame: fog, a translucent object with its tinted shadow and a glossy boundary,
 * meshes lit by a lightmap, by probes and by the lights alone, all in one picture. */
#include <epoxy/gl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../../runtime/state.h"
#include "../test.h"
#include "airlight/lightmap.h"
#include "airlight/probes.h"
#include "sphere.h"
#include "stage.h"

enum { EDGE = 48, COUNT = EDGE * EDGE, PIXELS = 3 * COUNT, FLOOR = 0, WALL, MAPPED, PROBED, TEXELS = 4 };

static const float fog_per_m[3] = {0.02f, 0.05f, 0.1f};
static const char *folder;

/* --- the scene --- */

/* The square with its front towards `axis` (0 to 2), its middle at `place`. */
static void add_square(sphere_scene *s, float size, const float place[3], int axis)
{
    sphere_scene_add_floor(s, size, place);
    float *world = s->instances[s->scene.instance_count - 1].world;
    memset(world, 0, 12 * sizeof *world);
    world[(axis + 2) % 3] = world[4 + axis] = world[8 + (axis + 1) % 3] = size;
}

/* An even light of 2 W/m2 on whichever squares have a lightmap. */
static void write_lightmap(void)
{
    static float texels[AL_LAYER_COUNT * TEXELS * TEXELS * 3];
    static uint8_t state[TEXELS * TEXELS];
    static const float vertices[3][5] = {{-1, 0, -1, 0, 0}, {-1, 0, 1, 0, 1}, {1, 0, 1, 1, 1}};
    static const uint32_t triangles[4][3] = {{0, 1, 2}, {0, 1, 2}, {0, 1, 2}, {0, 1, 2}};
    al_lightmap_instance instances[4];
    al_error error = {0};
    char path[512];
    for (size_t i = 0; i < sizeof texels / sizeof *texels; i++) texels[i] = 2;
    memset(state, AL_TEXEL_BAKED, sizeof state);
    for (uint32_t i = 0; i < 4; i++)
        instances[i] = (al_lightmap_instance){.instance = i, .scale = {1, 1}, .first_triangle = i, .triangle_count = 1};
    const al_lightmap_source page = {TEXELS, TEXELS, texels, NULL, state};
    const al_lightmap_data data = {.info = {.page_count = 1, .instance_count = 4, .format = AL_LIGHTMAP_FLOAT,
                                            .vertex_count = 3, .triangle_count = 4, .texel_m = 0.5f},
                                   .instances = instances, .pages = &page, .vertices = vertices[0], .triangles = triangles[0]};
    snprintf(path, sizeof path, "%s/room.lightmap.air", folder);
    if (al_lightmap_write(path, &data, NULL, &error)) fprintf(stderr, "%s\n", error.message);
    CHECK(!*error.message);
}

/* 0.3 W/(m2 sr) from everywhere. */
static void write_probes(void)
{
    static const float positions[4][3] = {{-4, -4, -4}, {8, -4, -4}, {-4, 8, -4}, {-4, -4, 8}};
    static const uint32_t tetrahedron[4] = {0, 1, 2, 3};
    static float coefficients[4][AL_LAYER_COUNT][3][9];
    al_error error = {0};
    char path[512];
    for (int i = 0; i < 4 * AL_LAYER_COUNT * 3; i++) (&coefficients[0][0][0][0])[9 * i] = 0.3f * 3.5449077f;
    const al_probes_data data = {.info = {4, 1, 3}, .positions = positions[0], .tetrahedra = tetrahedron,
                                 .coefficients = coefficients[0][0][0]};
    snprintf(path, sizeof path, "%s/room.probes.air", folder);
    CHECK(al_probes_write(path, &data, NULL, &error) == AL_OK);
}

/* A floor and a wall, two tables before it of which one has a lightmap and one probes, and a glossy translucent sphere before
 * everything; a sun, a lamp, a sky. `lighting`: of the four squares. */
static al_runtime *open_room(const al_lighting lighting[4])
{
    static float uv1[8] = {0, 0, 0, 1, 1, 1, 1, 0};
    al_runtime *runtime = NULL;
    al_error error = {0};
    sphere_scene s;
    al_fog fog = {.bounded = true, .bounds_min_m = {-10, -10, -10}, .bounds_max_m = {10, 10, 10}, .density = 1, .asset = ""};
    sphere_scene_begin(&s);
    s.meshes[1].uv1 = uv1;
    s.materials[0].ior = 1.4f;
    s.materials[0].roughness = 0.3f;
    for (int c = 0; c < 3; c++) {
        s.medium.sigma_s_per_m[c] = s.medium.sigma_a_per_m[c] = 0.5f * fog_per_m[c];
        s.materials[1].base_color[c] = c ? 0.6f : 0.8f;
        s.scene.environment.sh[c][0] = 0.1f * 3.5449077f;
    }
    add_square(&s, 4, (float[3]){0, 0, 0}, 1);
    add_square(&s, 2.5f, (float[3]){0, 1, -1}, 2);
    add_square(&s, 1.1f, (float[3]){-0.8f, 0.4f, 0}, 1);
    add_square(&s, 1.1f, (float[3]){0.8f, 0.4f, 0}, 1);
    for (int i = 0; i < 4; i++) s.instances[i].lighting = lighting[i];
    sphere_scene_add(&s, "sphere.air", 0.35f, (float[3]){0, 0.5f, 0.8f});
    sphere_scene_add_light(&s, AL_LIGHT_DIRECTIONAL, (float[3]){0.24f, -0.72f, -0.65115f}, 3);
    sphere_scene_add_light(&s, AL_LIGHT_POINT, (float[3]){-0.4f, 1.5f, 0.4f}, 1);
    s.scene.baked = (al_baked_light){"room.lightmap.air", "room.probes.air"};
    s.scene.fogs = &fog;
    s.scene.fog_count = 1;
    CHECK(sphere_scene_write(folder, &s));
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK && stage_load(runtime, folder));
    sphere_scene_end(&s);
    return runtime;
}

static const al_lighting mixed[4] = {[MAPPED] = AL_LIGHTING_LIGHTMAP, [PROBED] = AL_LIGHTING_PROBES};

/* Frame 1 of every setting: the same random numbers. */
static float *draw(al_runtime *runtime, const al_settings *settings)
{
    al_view view = stage_look(EDGE, EDGE, (float[3]){0, 1.6f, 3.6f}, (float[3]){0, 0.5f, 0}, 0.8f);
    runtime->frame_number = 1;
    float *pixels = stage_draw(runtime, &view, settings, 0);
    CHECK(pixels && !stage_bad(pixels, PIXELS));
    if (!pixels) exit(test_end());
    return pixels;
}

/* --- one exposure --- */

static void set_glow(al_runtime *runtime, float glow)
{
    for (int c = 0; c < 3; c++) al_runtime_scene(runtime)->materials[1].emission_w_m2_sr[c] = glow;
}

/* What the frame lets through from a surface to the eye, fog and object: the picture with 1 W/(m2 sr) more on all surfaces, less
 * that without; *sum: both together, for their rounding. Surfaces' light into the fog is left out. */
static void read_veil(al_runtime *runtime, double veil[PIXELS], double sum[PIXELS])
{
    const al_settings settings = {.surface_scattering_off = true};
    float *dark = draw(runtime, &settings);
    set_glow(runtime, 1);
    float *bright = draw(runtime, &settings);
    set_glow(runtime, 0);
    for (int i = 0; i < PIXELS; i++) {
        veil[i] = (double)bright[i] - (double)dark[i];
        sum[i] = (double)bright[i] + (double)dark[i];
    }
    free(dark), free(bright);
}

/* With D what --indirect adds to the picture, I what its pass shows, T the fog's share to the surface and V the whole veil's,
 * D T = I V. A picture is a chain of at most 10 sums and products of what is positive, each rounded by u = 2^-24: it is wrong by
 * 10 u of itself. I and V hold T as two shaders compute it, exp of it within 1e-5. */
static void test_exposure(al_runtime *runtime, bool ambient)
{
    static double veil[PIXELS], veil_sum[PIXELS];
    static float places[COUNT][4];
    const double u = ldexp(1, -24);
    al_settings with = {.indirect = true, .ambient_occlusion = ambient}, without = {.ambient_occlusion = ambient},
                alone = {.pass = AL_PASS_INDIRECT};
    read_veil(runtime, veil, veil_sum);
    float *all = draw(runtime, &with), *plain = draw(runtime, &without), *light = draw(runtime, &alone);
    glGetTextureImage(runtime->targets.geometry.id, 0, GL_RGBA, GL_FLOAT, sizeof places, places);
    int lit = 0, veiled = 0;
    double worst = 0;
    for (int i = 0; i < PIXELS; i++) {
        double through = exp(-(double)fog_per_m[i % 3] * (double)places[i / 3][3]), added = (double)all[i] - (double)plain[i],
               shown = (double)light[i], bound = 10 * u * ((double)all[i] + (double)plain[i]) * through +
                                                 10 * u * shown * veil_sum[i] + 1e-5 * shown * veil[i];
        CHECK_NEAR(added * through, shown * veil[i], bound);
        if (bound > 0) worst = fmax(worst, fabs(added * through - shown * veil[i]) / bound);
        lit += shown > 0;
        veiled += shown > 0 && veil[i] < 0.7 * through;
    }
    printf("one exposure%s: %d of %d numbers get light, %d behind the object; worst at %.2f of the bound\n",
           ambient ? ", ambient occlusion too" : "", lit, PIXELS, veiled, worst);
    CHECK(lit > PIXELS / 3 && veiled > 100);
    free(all), free(plain), free(light);
}

/* --- baked light --- */

static const al_plan_row *plan_row(al_runtime *runtime, const char *step)
{
    uint32_t count = 0;
    const al_plan_row *rows = al_runtime_plan(runtime, &count);
    for (uint32_t i = 0; i < count; i++)
        if (!strcmp(rows[i].step, step)) return &rows[i];
    return NULL;
}

/* Pixels of the tables, which lie at y = 0.4. */
static bool is_table(const al_frame_block *frame, int i, const float place[4])
{
    double at[3], ray[3], length = 0;
    for (int k = 0; k < 3; k++) {
        ray[k] = (double)frame->ray[3][k] + (i % EDGE + 0.5) * (double)frame->ray[4][k] + (i / EDGE + 0.5) * (double)frame->ray[5][k];
        length += ray[k] * ray[k];
    }
    for (int k = 0; k < 3; k++) at[k] = (double)frame->ray[0][k] + (double)place[3] * ray[k] / sqrt(length);
    return place[3] > 0 && fabs(at[1] - 0.4) < 1e-3 && place[1] > 0.9f;
}

/* Tables with baked light get nothing, to the last bit; what others get of them does not depend on how they are lit: they send
 * what the lights send to them, as any surface, not what is baked. */
static void test_baked(al_runtime *runtime)
{
    static float places[COUNT][4];
    const al_settings off = {0}, on = {.indirect = true}, alone = {.pass = AL_PASS_INDIRECT, .bounce_filter_off = true};
    al_lighting dynamic[4] = {AL_LIGHTING_DYNAMIC};
    al_runtime *other = open_room(dynamic);
    al_frame_block frame;
    float *plain = draw(runtime, &off), *lit = draw(runtime, &on);
    const al_plan_row *row = plan_row(runtime, "indirect");
    CHECK(row && row->needed && strstr(row->why, "hold it already"));
    float *light = draw(runtime, &alone), *anyway = draw(other, &alone);
    glGetTextureImage(runtime->targets.geometry.id, 0, GL_RGBA, GL_FLOAT, sizeof places, places);
    glGetNamedBufferSubData(runtime->frame_block.id, 0, sizeof frame, &frame);
    int tables = 0, gets = 0;
    for (int i = 0; i < COUNT; i++) {
        size_t size = 3 * sizeof *plain;
        if (is_table(&frame, i, places[i])) {
            tables++;
            CHECK(!memcmp(lit + 3 * i, plain + 3 * i, size) && light[3 * i] == 0);
            gets += anyway[3 * i] > 0;
        } else {
            CHECK(!memcmp(light + 3 * i, anyway + 3 * i, size));
        }
    }
    printf("baked light: %d pixels of tables, of which %d get light where the lights alone light them\n", tables, gets);
    CHECK(tables > 100 && gets > 50);
    free(plain), free(lit), free(light), free(anyway);
    al_runtime_destroy(other);
}

/* Everything baked: no pass, no memory, the same picture. */
static void test_all_baked(void)
{
    const al_lighting baked[4] = {AL_LIGHTING_LIGHTMAP, AL_LIGHTING_LIGHTMAP, AL_LIGHTING_LIGHTMAP, AL_LIGHTING_PROBES};
    const al_settings off = {0}, on = {.indirect = true, .ambient_occlusion = true, .temporal = 8};
    al_runtime *runtime = open_room(baked);
    float *plain = draw(runtime, &off);
    uint64_t bytes = al_runtime_memory(runtime);
    float *lit = draw(runtime, &on);
    CHECK(!memcmp(plain, lit, PIXELS * sizeof *plain) && al_runtime_memory(runtime) == bytes);
    static const char *const steps[] = {"indirect", "ambient-occlusion", "temporal"};
    for (int i = 0; i < 3; i++) {
        const al_plan_row *row = plan_row(runtime, steps[i]);
        CHECK(row && !row->needed && !row->bytes && (i == 2 || !strcmp(row->why, "no opaque surface without baked light")));
    }
    free(plain), free(lit);
    al_runtime_destroy(runtime);
}

/* --- casters --- */

/* A sun behind a sphere of 0.5 m lights a square of 0.1 m on the axis, which alone lights the floor: its light loses
 * exp(-sigma_t chord), chord 2 sqrt(R^2 - r^2) with r up to half the square's diagonal, known by a voxel at each end. */
static void test_casters(void)
{
    const float sigma_t[3] = {0.5f, 1, 2};
    const double radius = 0.5, voxel = 2 * radius * 1.05 / 64, least = 2 * sqrt(radius * radius - 0.05 * 0.05 * 2);
    float *pictures[2];
    for (int i = 0; i < 2; i++) {
        al_runtime *runtime = NULL;
        al_error error = {0};
        sphere_scene s;
        sphere_scene_begin(&s);
        s.scene.baked = (al_baked_light){"", ""};
        add_square(&s, 2, (float[3]){0, 0, 0}, 1);
        add_square(&s, 0.1f, (float[3]){0, 0.6f, -0.4f}, 2);
        sphere_options options = {.radius = (float)radius, .sigma_t = {sigma_t[0], sigma_t[1], sigma_t[2]}, .samples = 100};
        CHECK(sphere_write_asset(folder, "caster.air", &options));
        if (i) sphere_scene_add(&s, "caster.air", (float)radius, (float[3]){0, 0.6f, 0.5f});
        sphere_scene_add_light(&s, AL_LIGHT_DIRECTIONAL, (float[3]){0, 0, -1}, 5);
        CHECK(sphere_scene_write(folder, &s));
        CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK && stage_load(runtime, folder));
        sphere_scene_end(&s);
        pictures[i] = draw(runtime, &(al_settings){.pass = AL_PASS_INDIRECT, .surfel_pixels = 0.5f, .bounce_samples = 16});
        al_runtime_destroy(runtime);
    }
    for (int c = 0; c < 3; c++) {
        double sums[2] = {0};
        for (int i = c; i < PIXELS; i += 3)
            for (int k = 0; k < 2; k++) sums[k] += (double)pictures[k][i];
        double chord = log(sums[0] / sums[1]) / (double)sigma_t[c];
        printf("through the sphere, channel %d: %.4f m of %.4f to 1\n", c, chord, least);
        CHECK(sums[1] > 0 && chord > least - 2 * voxel && chord < 2 * radius + 2 * voxel);
    }
    free(pictures[0]), free(pictures[1]);
}

int main(void)
{
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    folder = stage_folder();
    CHECK(folder != NULL);
    if (!folder) return test_end();
    CHECK(sphere_write_asset(folder, "sphere.air", &(sphere_options){.radius = 0.35f, .sigma_t = {1, 2, 4}, .samples = 1500}));
    write_lightmap();
    write_probes();
    al_runtime *runtime = open_room(mixed);
    for (int ambient = 0; ambient < 2; ambient++) test_exposure(runtime, ambient);
    test_baked(runtime);
    al_runtime_destroy(runtime);
    test_all_baked();
    test_casters();
    return test_end();
}
