/* Fog to the eye: closed forms, a constant density against the same given as a grid, scenes without fog, what
 * stands in it, and the extremes. */
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../test.h"
#include "airlight/formulas.h"
#include "airlight/medium.h"
#include "sphere.h"
#include "stage.h"

enum { EDGE = 17 };

static const char *folder;

typedef struct fog_options {
    const float *sigma_s, *sigma_a; /* [3]; NULL: 0.5 and 0 */
    float g, half;                  /* edge of the box / 2, 0: endless */
    float center[3];
    bool grid, floor; /* as an asset; a white floor at y = -1 */
    int spheres;      /* translucent, of radius 0.5, 1.1 m apart, each behind the one before */
    int lights;       /* the first one directional towards -z, further ones points */
} fog_options;

static al_status slice(void *user, uint32_t frame, uint32_t z, float *density, al_error *error)
{
    (void)user, (void)frame, (void)z, (void)error;
    for (int i = 0; i < 12 * 12; i++) density[i] = 1;
    return AL_OK;
}

/* 12^3 voxels of density 1 in the fog's box: two bricks along each axis. */
static void write_grid(const al_fog *fog, const al_medium *medium)
{
    char path[512];
    al_error error = {0};
    al_medium_data data = {.info = {.size = {12, 12, 12}, .page_size = 3, .frame_count = 1, .g = medium->g},
                           .slice = slice};
    for (int k = 0; k < 3; k++) {
        data.info.bounds_min_m[k] = fog->bounds_min_m[k];
        data.info.bounds_max_m[k] = fog->bounds_max_m[k];
        data.info.sigma_s_per_m[k] = medium->sigma_s_per_m[k];
        data.info.sigma_a_per_m[k] = medium->sigma_a_per_m[k];
        data.info.grid_to_world[5 * k] = (fog->bounds_max_m[k] - fog->bounds_min_m[k]) / 12;
        data.info.grid_to_world[12 + k] = fog->bounds_min_m[k] + data.info.grid_to_world[5 * k] / 2;
    }
    data.info.grid_to_world[15] = 1;
    snprintf(path, sizeof path, "%s/fog.medium.air", folder);
    CHECK(al_medium_write(path, &data, NULL, &error) == AL_OK);
}

static al_runtime *open_fog(const fog_options *o)
{
    static const float plain[3] = {0.5f, 0.5f, 0.5f};
    al_runtime *runtime = NULL;
    al_error error = {0};
    sphere_scene s;
    al_fog fog = {.bounded = o->half > 0, .density = 1, .asset = o->grid ? "fog.medium.air" : ""};
    sphere_scene_begin(&s);
    for (int k = 0; k < 3; k++) {
        if (fog.bounded) {
            fog.bounds_min_m[k] = o->center[k] - o->half;
            fog.bounds_max_m[k] = o->center[k] + o->half;
        }
        s.medium.sigma_s_per_m[k] = (o->sigma_s ? o->sigma_s : plain)[k];
        s.medium.sigma_a_per_m[k] = o->sigma_a ? o->sigma_a[k] : 0;
    }
    s.medium.g = o->g;
    s.scene.fogs = &fog;
    s.scene.fog_count = 1;
    s.scene.baked = (al_baked_light){"", ""};
    if (o->grid) write_grid(&fog, &s.medium);
    if (o->floor) sphere_scene_add_floor(&s, 4, (float[3]){0, -1, 0});
    if (o->spheres) {
        CHECK(sphere_write_asset(folder, "sphere.air",
                                 &(sphere_options){.radius = 0.5f, .samples = 500, .grid = 32}));
        for (int i = 0; i < o->spheres; i++)
            sphere_scene_add(&s, "sphere.air", 0.5f, (float[3]){0.3f * (float)i, 0, -1.1f * (float)i});
        if (o->spheres > 1) s.materials[0].ior = 1.5f; /* its reflection needs every texture unit */
    }
    for (int i = 0; i < o->lights; i++)
        sphere_scene_add_light(&s, i ? AL_LIGHT_POINT : AL_LIGHT_DIRECTIONAL,
                               i ? (float[3]){0.7f, 0.4f, 0.3f} : (float[3]){0, 0, -1}, 1);
    CHECK(sphere_scene_write(folder, &s));
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK);
    CHECK(stage_load(runtime, folder));
    sphere_scene_end(&s);
    return runtime;
}

static al_view front_view(uint32_t edge)
{
    return stage_look(edge, edge, (float[3]){0, 0, 3}, (float[3]){0, 0, 0}, 0.6f);
}

/* The mean of `frames` frames; every one is checked. */
static void average(al_runtime *runtime, const al_view *view, const al_settings *settings, int frames,
                    double *image)
{
    size_t count = (size_t)view->width * view->height * 3;
    memset(image, 0, count * sizeof *image);
    for (int frame = 0; frame < frames; frame++) {
        float *pixels = stage_draw(runtime, view, settings, 0);
        CHECK(pixels && stage_bad(pixels, count) == 0);
        for (size_t i = 0; pixels && i < count; i++) image[i] += pixels[i] / frames;
        free(pixels);
    }
}

static const double *middle(const double *image, uint32_t edge)
{
    return image + 3 * (edge / 2 * edge + edge / 2);
}

/* The mean of the middle 3 x 3 pixels. */
static double around(const double *image, uint32_t edge, int channel)
{
    double sum = 0;
    for (int y = -1; y <= 1; y++)
        for (int x = -1; x <= 1; x++) sum += middle(image, edge)[3 * (y * (int)edge + x) + channel] / 9;
    return sum;
}

/* A box of 2 m, the sun from behind the eye: at depth t light has come through t and goes back through t, so
 * L = sigma_s p(-1) (1 - exp(-2 sigma_t 2)) / (2 sigma_t), p(-1) of light that is sent back; the background 1
 * is left exp(-2 sigma_t). Per channel. 32 cells of at most 1/8 in optical depth: the draw in each
 * costs a standard error of 1/8/sqrt(12)/sqrt(32) = 0.6 % a pixel, 0.1 % for 9 pixels and 8 frames; rays at
 * the rim of the 9 pixels are 0.1 % longer. Four standard errors. */
static void test_sun(float g)
{
    static double image[EDGE * EDGE * 3];
    const float sigma_s[3] = {0.2f, 0.8f, 1.5f}, sigma_a[3] = {0.3f, 0, 0.5f};
    al_runtime *runtime = open_fog(&(fog_options){sigma_s, sigma_a, g, 1, {0, 0, 0}, .lights = 1});
    al_view view = front_view(EDGE);
    average(runtime, &view, &(al_settings){.pass = AL_PASS_DIRECT_SCATTERING}, 8, image);
    for (int c = 0; c < 3; c++) {
        double t = sigma_s[c] + sigma_a[c],
               wanted = sigma_s[c] * al_phase(g, -1) * (1 - exp(-4 * t)) / (2 * t);
        CHECK_NEAR(around(image, EDGE, c) / wanted, 1, 4e-3);
    }
    al_runtime_scene(runtime)->lights[0].intensity[0] = al_runtime_scene(runtime)->lights[0].intensity[1] =
        al_runtime_scene(runtime)->lights[0].intensity[2] = 0;
    for (int c = 0; c < 3; c++) al_runtime_scene(runtime)->play.background[c] = 1;
    average(runtime, &view, NULL, 1, image);
    for (int c = 0; c < 3; c++) CHECK_NEAR(middle(image, EDGE)[c], exp(-2 * (sigma_s[c] + sigma_a[c])), 1e-4);
    average(runtime, &view, &(al_settings){.fog_off = true}, 1, image);
    CHECK_NEAR(middle(image, EDGE)[0], 1, 1e-6);
    al_runtime_destroy(runtime);
}

/* A point light beside the ray, thin fog: L = sigma_s I / (4 pi D) (phi_b - phi_a), the angle that the box's
 * part of the ray is seen under (the airlight integral without extinction). sigma_t d <= 4e-3. */
static void test_point(void)
{
    static double image[EDGE * EDGE * 3];
    const float thin[3] = {1e-3f, 1e-3f, 1e-3f};
    al_runtime *runtime = open_fog(&(fog_options){.sigma_s = thin, .half = 1, .lights = 2});
    al_view view = front_view(EDGE);
    al_scene *scene = al_runtime_scene(runtime);
    memset(scene->lights[0].intensity, 0, sizeof scene->lights[0].intensity);
    for (double away = 0.01; away < 1; away *= 3) {
        scene->lights[1].vector[0] = (float)away;
        scene->lights[1].vector[1] = 0;
        scene->lights[1].vector[2] = 0.3f;
        average(runtime, &view, &(al_settings){.pass = AL_PASS_DIRECT_SCATTERING}, 1, image);
        double wanted = 1e-3 / (4 * AL_PI * away) * (atan(0.7 / away) + atan(1.3 / away));
        CHECK_NEAR(middle(image, EDGE)[0] / wanted, 1, 4e-3);
    }
    al_runtime_destroy(runtime);
}

/* The same fog as an asset of bricks: noise of the jitter apart the same picture. */
static void test_grid(void)
{
    static double constant[EDGE * EDGE * 3], grid[EDGE * EDGE * 3];
    const float sigma_s[3] = {0.5f, 1, 2};
    double difference = 0, sum = 0;
    for (int pass = 0; pass < 2; pass++) {
        al_runtime *runtime = open_fog(&(fog_options){.sigma_s = sigma_s,
                                                      .g = 0.4f,
                                                      .half = 0.9f,
                                                      .center = {0.1f, 0, -0.2f},
                                                      .grid = pass == 1,
                                                      .floor = true,
                                                      .spheres = 2,
                                                      .lights = 2});
        al_view view = front_view(EDGE);
        /* Light of surfaces is dealt at random: shell_test.c has it. */
        average(runtime, &view, &(al_settings){.surface_scattering_off = true}, 4, pass ? grid : constant);
        al_runtime_destroy(runtime);
    }
    for (int i = 0; i < EDGE * EDGE * 3; i++) {
        difference += (grid[i] - constant[i]) * (grid[i] - constant[i]);
        sum += constant[i] * constant[i];
    }
    printf("constant density as a grid: relative RMSE %.5f\n", sqrt(difference / sum));
    CHECK(sqrt(difference / sum) < 2e-3 &&
          sum > 0); /* halfs of 2^-11, and midpoint cells on the box's faces */
}

/* Behind 1 m of fog and in front of a translucent sphere, the sphere's light and what shines through it lose
 * exp(-sigma_t 1 m), and the fog's own light comes on top; fog behind the sphere changes it by what passes
 * the sphere alone. All from linearity: with fog that only absorbs, composite = T (fogless picture). */
static void test_translucent(void)
{
    static double clear[EDGE * EDGE * 3], seen[EDGE * EDGE * 3];
    const float none[3] = {0, 0, 0}, sigma_a[3] = {0.4f, 0.8f, 1.6f};
    al_runtime *runtime =
        open_fog(&(fog_options){none, sigma_a, 0, 0.5f, {0, 0, 1.6f}, .spheres = 1, .lights = 1});
    al_view view = front_view(EDGE);
    al_scene *scene = al_runtime_scene(runtime);
    scene->lights[0].vector[0] = -1; /* from the side: not through the fog */
    scene->lights[0].vector[2] = 0;
    for (int c = 0; c < 3; c++) scene->play.background[c] = 0.2f;
    average(runtime, &view, &(al_settings){.fog_off = true}, 4, clear);
    average(runtime, &view, NULL, 4, seen);
    for (int c = 0; c < 3; c++)
        CHECK_NEAR(middle(seen, EDGE)[c] / middle(clear, EDGE)[c], exp(-sigma_a[c]),
                   0.01); /* jitter of the march */
    al_runtime_destroy(runtime);

    /* Scattering fog between eye and sphere alone: the fog's light is the same with the sphere as before the
     * empty background, and lies over the sphere's. */
    const float sigma_s[3] = {0.5f, 0.5f, 0.5f};
    static double fog[EDGE * EDGE * 3];
    runtime = open_fog(&(fog_options){sigma_s, NULL, 0, 0.5f, {0, 0, 1.6f}, .spheres = 1, .lights = 2});
    average(runtime, &view, &(al_settings){.pass = AL_PASS_DIRECT_SCATTERING}, 8, fog);
    average(runtime, &view, NULL, 8, seen);
    scene = al_runtime_scene(runtime);
    average(runtime, &view, &(al_settings){.fog_off = true}, 8, clear);
    /* Light on its way to the sphere loses up to exp(-0.5) in the fog, so that the rest lies between. */
    double rest = (middle(seen, EDGE)[0] - middle(fog, EDGE)[0]) / middle(clear, EDGE)[0];
    CHECK(rest > exp(-1.0) - 0.02 && rest < exp(-0.5) + 0.02 && middle(fog, EDGE)[0] > 0.005);
    al_runtime_destroy(runtime);
}

/* Light reaches a floor through the fog and goes on through it to the eye: exp(-sigma_t (d1 + d2)). */
static void test_floor(void)
{
    static double clear[EDGE * EDGE * 3], seen[EDGE * EDGE * 3];
    const float none[3] = {0, 0, 0}, sigma_a[3] = {0.2f, 0.4f, 0.8f};
    al_runtime *runtime =
        open_fog(&(fog_options){none, sigma_a, 0, 1.5f, {0, 0.5f, 0}, .floor = true, .lights = 1});
    al_scene *scene = al_runtime_scene(runtime);
    memcpy(scene->lights[0].vector, (float[3]){0, -1, 0}, 12); /* through 3 m of fog to the floor */
    al_view view = stage_look(EDGE, EDGE, (float[3]){0, 3, 4}, (float[3]){0, -1, 0}, 0.2f);
    average(runtime, &view, &(al_settings){.fog_off = true}, 1, clear);
    average(runtime, &view, NULL, 1, seen);
    /* The ray rises by 1 in y for each 1 in z from the floor's middle: it leaves the box at z = 1.5. */
    double path = 3 + 1.5 * sqrt(2);
    for (int c = 0; c < 3; c++)
        CHECK_NEAR(middle(seen, EDGE)[c] / middle(clear, EDGE)[c], exp(-sigma_a[c] * path), 2e-3);
    al_runtime_destroy(runtime);
}

/* A box behind the eye is not there; the eye inside sees its own part: 0.4 m. */
static void test_eye(void)
{
    static double image[EDGE * EDGE * 3];
    al_runtime *runtime = open_fog(&(fog_options){.half = 1});
    for (int c = 0; c < 3; c++) al_runtime_scene(runtime)->play.background[c] = 1;
    al_view view = stage_look(EDGE, EDGE, (float[3]){0, 0, -1.5f}, (float[3]){0, 0, -2}, 0.6f);
    average(runtime, &view, NULL, 1, image);
    CHECK(middle(image, EDGE)[0] == 1);
    view = stage_look(EDGE, EDGE, (float[3]){0, 0, -0.6f}, (float[3]){0, 0, -2}, 0.6f);
    average(runtime, &view, NULL, 1, image);
    test_extreme("camera inside the medium", middle(image, EDGE)[0], exp(-0.5 * 0.4), 1e-4,
                 "fog: a background of 1 through the 0.4 m before an eye in it");
    al_runtime_destroy(runtime);
}

static bool find_row(al_runtime *runtime, const char *step, al_plan_row *row)
{
    uint32_t count;
    const al_plan_row *rows = al_runtime_plan(runtime, &count);
    for (uint32_t i = 0; i < count; i++)
        if (!strcmp(rows[i].step, step)) return *row = rows[i], true;
    return false;
}

static bool was_timed(al_runtime *runtime, const char *name)
{
    al_pass_time times[32];
    uint32_t count = al_runtime_times(runtime, times, 32);
    for (uint32_t i = 0; i < count; i++)
        if (!strcmp(times[i].name, name)) return true;
    return false;
}

/* Without fog there is no pass, no row that asks for one and not a byte; switched off, no pass, and no byte but what was
 * loaded. */
static void test_plan(void)
{
    static double image[EDGE * EDGE * 3];
    al_plan_row row = {0};
    static const char *const of_surfaces[] = {"surfels", "interval-map", "surface-scattering"};
    uint64_t bytes[2];
    al_view view = front_view(EDGE);
    for (int pass = 0; pass < 2; pass++) {
        al_runtime *runtime = NULL;
        al_error error = {0};
        if (pass) {
            runtime = open_fog(&(fog_options){.half = 1, .floor = true, .lights = 1});
        } else {
            sphere_scene s;
            sphere_scene_begin(&s);
            sphere_scene_add_floor(&s, 4, (float[3]){0, -1, 0});
            sphere_scene_add_light(&s, AL_LIGHT_DIRECTIONAL, (float[3]){0, 0, -1}, 1);
            CHECK(sphere_scene_write(folder, &s));
            CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK && stage_load(runtime, folder));
            sphere_scene_end(&s);
        }
        average(runtime, &view, NULL, 6, image);
        CHECK(find_row(runtime, "direct-scattering", &row) && row.needed == (pass == 1) &&
              (row.bytes > 0) == row.needed);
        CHECK(was_timed(runtime, "direct-scattering") == (pass == 1));
        average(runtime, &view, &(al_settings){.fog_off = true}, 6, image);
        CHECK(!was_timed(runtime, "direct-scattering"));
        bytes[pass] = al_runtime_memory(runtime);
        uint64_t sum = row.bytes;
        for (int i = 0; i < 3; i++) {
            CHECK(find_row(runtime, of_surfaces[i], &row) && !row.needed && row.bytes == 0);
        }
        if (pass) CHECK(bytes[1] - bytes[0] == sum);
        al_runtime_destroy(runtime);
    }
}

/* Lobes of 0.01 radians, looked into and away from: the sun ahead, so that light goes 2 m through the fog
 * wherever it turns, L = sigma_s p(1) 2 exp(-2 sigma_t); and the sun behind the eye as in test_sun. A view so
 * narrow that the angle changes p by less than 3e-4; in floats (1 - |g|)^2 is 1e-4 within 6e-8 twice, so p
 * within 1.5 x 1.2e-3. */
static void test_narrow(float g)
{
    static double image[EDGE * EDGE * 3];
    const float sigma_s[3] = {0.2f, 0.8f, 1.5f}, sigma_a[3] = {0.3f, 0, 0.5f};
    al_runtime *runtime = open_fog(&(fog_options){sigma_s, sigma_a, g, 1, {0, 0, 0}, .lights = 1});
    al_view view = stage_look(EDGE, EDGE, (float[3]){0, 0, 3}, (float[3]){0, 0, 0}, 1e-3f);
    for (int ahead = 0; ahead < 2; ahead++) {
        al_runtime_scene(runtime)->lights[0].vector[2] = ahead ? 1 : -1;
        average(runtime, &view, &(al_settings){.pass = AL_PASS_DIRECT_SCATTERING}, 8, image);
        for (int c = 0; c < 3; c++) {
            double t = sigma_s[c] + sigma_a[c];
            double length = ahead ? 2 * exp(-2 * t) : (1 - exp(-4 * t)) / (2 * t);
            double wanted = sigma_s[c] * al_phase(g, ahead ? 1 : -1) * length, value = around(image, EDGE, c);
            if (c)
                CHECK_NEAR(value / wanted, 1, 4e-3 + 1.8e-3);
            else
                test_extreme(g > 0 ? "g 0.99" : "g -0.99", value, wanted, (4e-3 + 1.8e-3) * wanted,
                             "fog: radiance, the sun %s", ahead ? "ahead" : "behind the eye");
        }
    }
    al_runtime_destroy(runtime);
}

/* A sun and points over a floor, `points` in one place; all lights times `factor`. */
static void draw_lights(int points, float sun, float point, double *image)
{
    al_runtime *runtime = open_fog(&(fog_options){.g = 0.5f, .half = 1, .floor = true, .lights = 1 + points});
    al_scene *scene = al_runtime_scene(runtime);
    al_view view = front_view(EDGE);
    for (int i = 0; i <= points; i++)
        for (int c = 0; c < 3; c++) scene->lights[i].intensity[c] *= i ? point : sun;
    average(runtime, &view, &(al_settings){.surface_scattering_off = true}, 1, image);
    al_runtime_destroy(runtime);
}

static double largest_difference(const double *image, const double *expected, double factor)
{
    double worst = 0;
    for (int i = 0; i < EDGE * EDGE * 3; i++) {
        CHECK(expected[i] > 0);
        worst = fmax(worst, fabs(image[i] / (factor * expected[i]) - 1));
    }
    return worst;
}

/* Light is linear: 64 lamps are one of 64 times their strength, and lights of 1e-6 and 1e6 draw the same
 * picture. Floats add up 2 lights in 32 cells each. By a power of two nothing rounds differently. Each lamp
 * draws its own places in its cells: 0.6 % a pixel, see test_sun, its 17th part on average; four standard
 * errors. */
static void test_linear(void)
{
    static double plain[EDGE * EDGE * 3], other[EDGE * EDGE * 3];
    static const float factors[] = {0x1p-20f, 0x1p20f, 1e-6f, 1e6f};
    draw_lights(1, 1, 1, plain);
    for (int i = 0; i < 4; i++) {
        draw_lights(1, factors[i], factors[i], other);
        double worst = largest_difference(other, plain, factors[i]);
        if (i < 2)
            CHECK(worst == 0);
        else
            test_extreme(i == 2 ? "radiosity 1e-6" : "radiosity 1e6", worst, 0, 2 * 32 * 0x1p-23,
                         "fog: lights times that, largest relative difference (times 2^-20, 2^20: the same bits)");
    }
    draw_lights(63, 1, 1.0f / 63, other);
    double worst = largest_difference(other, plain, 1);
    double sum = 0, expected = 0;
    for (int i = 0; i < EDGE * EDGE * 3; i++) sum += other[i], expected += plain[i];
    printf("63 lamps as one: %.1e a pixel, %.1e in all\n", worst, fabs(sum / expected - 1));
    CHECK(worst <= 4 * 6e-3);
    test_extreme("64 lights", sum, expected, 4 * 6e-3 / EDGE * expected,
                 "fog: a sun and 63 lamps in one place against one of their sum, sum of all pixels");
}

/* The box of test_sun times `size`, of sigma_t times its 2 m and of an albedo: what it sends back to the eye. Thin, and as
 * far as cells are no longer than a mean free path, within what test_sun derives. */
static void test_box(const char *what, double depth, double albedo, float size)
{
    static double image[EDGE * EDGE * 3];
    const float sigma = (float)(depth / 2) / size, s = (float)albedo * sigma, a = (float)((1 - albedo) * (depth / 2)) / size;
    al_runtime *runtime = open_fog(&(fog_options){(float[3]){s, s, s}, (float[3]){a, a, a}, 0, size, .lights = 1});
    al_view view = front_view(EDGE);
    for (int k = 12; k < 15; k++) view.view[k] *= size;
    view.projection[14] *= size;
    average(runtime, &view, &(al_settings){.pass = AL_PASS_DIRECT_SCATTERING}, 8, image);
    double wanted = -albedo * expm1(-2 * depth) / (8 * AL_PI);
    test_extreme(what, around(image, EDGE, 0), wanted, 4e-3 * wanted, "fog: radiance of a box of %g m, sigma_t times size %g, albedo %.7g",
                 2 * (double)size, depth, albedo);
    al_runtime_destroy(runtime);
}

/* Nothing may be negative or not finite. */
static void test_extremes(void)
{
    static double image[EDGE * EDGE * 3];
    static const float eyes[][3] = {{0, 0, 3},          {0, 0, 0},  {0, 0, 1},
                                    {0.7f, 0.4f, 0.3f}, {0, 0, -3}, {1e4f, 0, 0}};
    for (int exponent = -6; exponent <= 4; exponent += 2) {
        float sigma = powf(10, (float)exponent), s[3] = {sigma, 0, sigma / 2}, a[3] = {0, sigma, 0};
        for (int form = 0; form < 3; form++) { /* box, grid, endless */
            al_runtime *runtime =
                open_fog(&(fog_options){s, a, exponent % 4 ? 0.99f : -0.99f, form == 2 ? 0 : 1,
                                        .grid = form == 1, .floor = form == 0, .lights = 2});
            for (size_t i = 0; i < sizeof eyes / sizeof *eyes; i++) {
                al_view view =
                    stage_look(5, 5, eyes[i], (float[3]){eyes[i][0], eyes[i][1], eyes[i][2] - 1}, 1.2f);
                average(runtime, &view, NULL, 1, image);
            }
            al_view view = front_view(5);
            average(runtime, &view, &(al_settings){.pass = AL_PASS_DIRECT_SCATTERING, .fog_steps = 4}, 1,
                    image);
            al_runtime_destroy(runtime);
        }
    }
    /* Thick fog of albedo 1 lit from the eye's side sends back E p(-1) / 2. */
    const float thick[3] = {1e4f, 100, 10};
    al_runtime *runtime = open_fog(&(fog_options){.sigma_s = thick, .half = 1, .lights = 1});
    al_view view = front_view(EDGE), pixel = front_view(1);
    average(runtime, &view, &(al_settings){.pass = AL_PASS_DIRECT_SCATTERING}, 16, image);
    /* The first channel ends inside the first cell, where a third of the draws looks for it. */
    for (int c = 0; c < 3; c++)
        test_extreme(c ? "sigma_t times size 1 to 100" : "sigma_t times size 1e4", around(image, EDGE, c), 1 / (8 * AL_PI),
                     0.25 / (8 * AL_PI), "fog: radiance of a box of 2 m, %g per metre", (double)thick[c]);
    average(runtime, &pixel, NULL, 1, image);
    al_runtime_destroy(runtime);
    runtime = open_fog(&(fog_options){.half = 1, .lights = 64}); /* and none */
    view = front_view(5);
    average(runtime, &view, NULL, 1, image);
    al_runtime_scene(runtime)->light_count = 0;
    average(runtime, &view, NULL, 1, image);
    test_extreme("0 lights", middle(image, 5)[0], 0, 0, "fog: radiance");
    al_runtime_destroy(runtime);
    test_box("sigma_t times size 1e-6", 1e-6, 1, 1);
    test_box("sigma_t times size 1e-3", 1e-3, 1, 1);
    test_box("sigma_t times size 1 to 100", 1, 1, 1);
    test_box("albedo 0", 1, 0, 1);
    test_box("albedo 1 - 1e-6", 1, 1 - 1e-6, 1);
    test_box("albedo 1", 1, 1, 1);
    test_box("scene of 1e-4 m", 1, 1, 1e-4f);
    test_box("scene of 1e4 m", 1, 1, 1e4f);
}

/* A fog's asset that is missing or broken: one line, and the rest is drawn. */
static void test_missing(void)
{
    char path[512];
    al_runtime *runtime = open_fog(&(fog_options){.half = 1, .grid = true, .floor = true, .lights = 1});
    al_error error = {0};
    al_load_state state = {0};
    static double image[EDGE * EDGE * 3];
    snprintf(path, sizeof path, "%s/fog.medium.air", folder);
    CHECK(remove(path) == 0);
    CHECK(al_runtime_load(runtime, folder, &error) == AL_OK);
    al_status status = AL_OK;
    while (!status && !state.complete) status = al_runtime_update(runtime, 0, &state, &error);
    CHECK(status == AL_BAD_INPUT && strstr(error.message, "fog.medium.air"));
    while (!state.complete) CHECK(al_runtime_update(runtime, 0, &state, &error) == AL_OK);
    al_view view = front_view(EDGE);
    average(runtime, &view, NULL, 1, image);
    al_runtime_destroy(runtime);
}

int main(void)
{
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    folder = stage_folder();
    if (!folder) return test_skip("no temporary folder");
    test_sun(0);
    test_sun(0.6f);
    test_narrow(0.99f);
    test_narrow(-0.99f);
    test_linear();
    test_point();
    test_grid();
    test_floor();
    test_translucent();
    test_eye();
    test_plan();
    test_missing();
    test_extremes();
    return test_end();
}
