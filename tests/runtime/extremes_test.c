/* usage: runtime_extremes_test [FOLDER]: with a baked folder, only that its pictures are finite and not
 * negative.
 *
 * The extremes: optical depths from 1e-6 to 1e4, eyes inside, no and 64 lights, lights of 1e-6 and 1e6, on
 * the boundary, no samples, one pixel, a large view in tiles. Nothing may be negative or not finite; where a
 * closed form exists it is met. */
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "../test.h"
#include "airlight/formulas.h"
#include "sphere.h"
#include "stage.h"

enum { EDGE = 33 };

static al_runtime *open_sphere(const char *folder, const sphere_options *options, int lights)
{
    al_runtime *runtime = NULL;
    al_error error = {0};
    sphere_scene s;
    sphere_scene_begin(&s);
    sphere_scene_add(&s, "sphere.air", 1, (float[3]){0, 0, 0});
    for (int i = 0; i < lights; i++)
        sphere_scene_add_light(&s, i % 2 ? AL_LIGHT_POINT : AL_LIGHT_DIRECTIONAL,
                               i % 2 ? (float[3]){3, 0, 3} : (float[3]){0, 0, -1}, 1);
    CHECK(sphere_write_asset(folder, "sphere.air", options) && sphere_scene_write(folder, &s));
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK);
    CHECK(stage_load(runtime, folder));
    sphere_scene_end(&s);
    return runtime;
}

/* The middle pixel's mean over frames; every pixel is checked. */
static double middle_of(al_runtime *runtime, const al_view *view, const al_settings *settings, int frames)
{
    double sum = 0;
    size_t count = (size_t)view->width * view->height * 3;
    for (int i = 0; i < frames; i++) {
        float *pixels = stage_draw(runtime, view, settings, 0);
        CHECK(pixels && stage_bad(pixels, count) == 0);
        if (pixels) sum += pixels[3 * (view->height / 2 * view->width + view->width / 2)] / frames;
        free(pixels);
    }
    return sum;
}

/* Thin: L = albedo sigma chord E / (4 pi), whatever the depth; marched, by SH, and by SH as published. The
 * background loses 1 - exp(-tau) in every case. */
static void test_optical_depths(const char *folder)
{
    static const char *const leg_names[] = {"marched", "by SH", "by SH as published"};
    al_view view = stage_ortho(EDGE, EDGE, 1.1f);
    for (int exponent = -6; exponent <= 4; exponent++) {
        float sigma = powf(10, (float)exponent) / 2; /* times 2 m */
        al_runtime *runtime = open_sphere(folder, &(sphere_options){.sigma_t = {sigma}, .samples = 1500}, 1);
        al_settings settings = {.surface_off = true};
        al_runtime_scene(runtime)->play.background[0] = 1;
        for (int leg = 0; leg < 3; leg++) {
            settings.view_leg = leg == 0 ? AL_VIEW_LEG_MARCHED : AL_VIEW_LEG_SH;
            settings.normalise_off = leg == 2;
            settings.pass = AL_PASS_TRANSLUCENT;
            double scattered = middle_of(runtime, &view, &settings, 4), thin = 0.9 * sigma * 2 / (4 * AL_PI);
            /* A voxel of 64 across; as published nothing makes up for what the Gaussians miss at the ends. */
            const double bound = leg == 2 ? 0.15 : 0.03;
            const char *what = exponent == -6 ? "sigma_t times size 1e-6" : "sigma_t times size 1e-3";
            if (exponent == -6 || exponent == -3)
                test_extreme(what, scattered, thin, bound * thin, "object in the player, %s: radiance of a sphere's middle",
                             leg_names[leg]);
            else if (exponent < -3)
                CHECK_NEAR(scattered / thin, 1, bound);
            CHECK(scattered < 0.9 / (8 * AL_PI) * 1.2); /* a half-space of it sends albedo E / (8 pi) back */
            settings.pass = AL_PASS_COMPOSITE;
            double through = middle_of(runtime, &view, &settings, 1) - scattered;
            if (leg == 0 && exponent >= 0 && exponent != 3)
                test_extreme(exponent == 4 ? "sigma_t times size 1e4" : "sigma_t times size 1 to 100", through, exp(-2 * sigma),
                             exponent > 1 ? 0.005 : 0.02, "object in the player: a background of 1 through sigma_t times size 1e%d",
                             exponent);
            else
                CHECK_NEAR(through, exp(-2 * sigma), exponent > 1 ? 0.005 : 0.02);
        }
        al_runtime_destroy(runtime);
    }
}

/* Nothing of a ball counts that lies outside of the object, in front of it or behind: then a ray through a
 * thin medium carries the same light both ways, whatever the Gaussians add up to. */
static void test_both_ways(const char *folder)
{
    al_runtime *runtime = open_sphere(folder, &(sphere_options){.sigma_t = {1e-4f}, .samples = 3}, 1);
    const al_settings settings = {.surface_off = true,
                                  .view_leg = AL_VIEW_LEG_SH,
                                  .normalise_off = true,
                                  .pass = AL_PASS_TRANSLUCENT,
                                  .detail_off = true};
    double seen[2];
    for (int side = 0; side < 2; side++) {
        al_view view = stage_look(EDGE, EDGE, (float[3]){0, 0, side ? -5 : 5}, (float[3]){0, 0, 0}, 0.5f);
        seen[side] = middle_of(runtime, &view, &settings, 1);
    }
    CHECK(seen[0] > 0);
    CHECK_NEAR(seen[1] / seen[0], 1, 1e-3); /* the mesh's facets, 4 sigma_t of transmittance */
    al_runtime_destroy(runtime);
}

static void test_inside(const char *folder)
{
    al_runtime *runtime = open_sphere(folder, &(sphere_options){.samples = 1500}, 2);
    static const float eyes[][3] = {
        {0, 0, 0}, {0.3f, 0.2f, 0.1f}, {0, 0, 0.999f}, {0, 0, 1.0001f}, {0, 0, 1.02f}};
    const int failures = test_failures;
    for (size_t i = 0; i < sizeof eyes / sizeof eyes[0]; i++) {
        al_view view =
            stage_look(EDGE, EDGE, eyes[i], (float[3]){eyes[i][0], eyes[i][1], eyes[i][2] - 1}, 1.2f);
        for (int pass = 0; pass < AL_PASS_COUNT; pass++)
            middle_of(runtime, &view, &(al_settings){.surface_off = true, .pass = (al_pass)pass}, 1);
        double seen = middle_of(runtime, &view, &(al_settings){.pass = AL_PASS_TRANSLUCENT}, 4);
        CHECK(seen > 0.005);
    }
    test_extreme("camera inside a sample", test_failures - failures, 0, 0,
                 "object in the player, every pass, 5 eyes in it, on its boundary and before: frames with a pixel negative or not finite");
    /* From the middle outwards along -z with the sun in the back, at distance t from the eye: light came
     * through 1 + t, goes back t: L = albedo sigma / (4 pi) times the integral of exp(-2 (1 + 2 t)), t from 0
     * to 1. The second light stands off by 3 m each in x and z, its share is taken out. */
    al_runtime_scene(runtime)->lights[1].intensity[0] = 0;
    al_view view = stage_look(EDGE, EDGE, (float[3]){0, 0, 0}, (float[3]){0, 0, -1}, 0.1f);
    double seen = middle_of(runtime, &view, &(al_settings){.pass = AL_PASS_TRANSLUCENT}, 4);
    double wanted = 0.9 * 2 / (4 * AL_PI) * exp(-2) * (1 - exp(-4)) / 4;
    test_extreme("camera inside the medium", seen, wanted, 0.25 * wanted, /* 1500 samples, 0.14 m apart: a quarter of the mean free path */
                 "object in the player: radiance seen from its middle");
    /* A light in the same place as the eye, inside a sample. */
    al_runtime_scene(runtime)->lights[1].intensity[0] = 1;
    memset(al_runtime_scene(runtime)->lights[1].vector, 0, 12);
    CHECK(middle_of(runtime, &view, &(al_settings){.pass = AL_PASS_TRANSLUCENT}, 1) > seen);
    al_runtime_destroy(runtime);
}

static void test_lights(const char *folder)
{
    al_view view = stage_ortho(EDGE, EDGE, 1.1f);
    const al_settings settings = {.surface_off = true, .pass = AL_PASS_TRANSLUCENT};
    al_runtime *none = open_sphere(folder, &(sphere_options){.samples = 500}, 0);
    test_extreme("0 lights", middle_of(none, &view, &settings, 1), 0, 0, "object in the player: radiance");
    al_runtime_destroy(none);
    al_runtime *all = open_sphere(folder, &(sphere_options){.samples = 500}, 64);
    double together = middle_of(all, &view, &settings, 1);
    al_runtime_scene(all)->light_count = 2;
    double two = middle_of(all, &view, &settings, 1);
    /* 32 times the same pair, but for the jitter and its slope in each ball. */
    test_extreme("64 lights", together, 32 * two, 0.1 * two, "object in the player: radiance, against 32 times that of two of them");
    al_runtime_destroy(all);
}

/* --- strengths of light --- */

enum { STRENGTH_EDGE = 48, STRENGTH_COUNT = STRENGTH_EDGE * STRENGTH_EDGE * 3, STRENGTH_SAMPLES = 500 };

typedef struct strengths {
    float sun, lamp, sky;
    bool sun_below;     /* under the floor */
    bool lamp_on_glass; /* in a vertex of the glossy boundary, else beside it */
} strengths;

/* A glossy sphere over a floor, by both view legs; every runtime's frames have the same jitter. */
static void draw_lit(const char *folder, strengths light, al_pass pass, float *pictures[2])
{
    enum { SKY_WIDTH = 8, SKY_HEIGHT = 4 };
    static const float beam[2][3] = {{0.6f, -0.8f, 0}, {0, 1, 0}};
    float sky[SKY_WIDTH * SKY_HEIGHT * 3];
    al_runtime *runtime = NULL;
    al_error error = {0};
    sphere_scene s;
    sphere_scene_begin(&s);
    s.materials[0].ior = 1.5f;
    s.materials[0].roughness = 0.3f;
    sphere_scene_add(&s, "sphere.air", 1, (float[3]){0, 0, 0});
    sphere_scene_add_floor(&s, 20, (float[3]){0, -1.2f, 0});
    sphere_scene_add_light(&s, AL_LIGHT_DIRECTIONAL, beam[light.sun_below], light.sun);
    const float *vertex = s.meshes[0].positions + 3 * (s.meshes[0].vertex_count / 3);
    sphere_scene_add_light(&s, AL_LIGHT_POINT, light.lamp_on_glass ? vertex : (float[3]){-1, 1.5f, 1},
                           light.lamp);
    for (int i = 0; i < SKY_WIDTH * SKY_HEIGHT * 3; i++) sky[i] = light.sky * (float)(1 + i % 7) / 8;
    al_environment *environment = &s.scene.environment;
    if (light.sky > 0) {
        environment->width = SKY_WIDTH;
        environment->height = SKY_HEIGHT;
        environment->pixels = sky;
        for (int c = 0; c < 3; c++) environment->sh[c][0] = light.sky;
    }
    CHECK(sphere_write_asset(folder, "sphere.air", &(sphere_options){.samples = STRENGTH_SAMPLES}));
    CHECK(sphere_scene_write(folder, &s));
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK);
    CHECK(stage_load(runtime, folder));
    al_view view =
        stage_look(STRENGTH_EDGE, STRENGTH_EDGE, (float[3]){1.5f, 1.5f, 4}, (float[3]){0, 0, 0}, 0.8f);
    for (int leg = 0; leg < 2; leg++) {
        const al_settings settings = {.pass = pass, .view_leg = leg ? AL_VIEW_LEG_SH : AL_VIEW_LEG_MARCHED};
        pictures[leg] = stage_draw(runtime, &view, &settings, 0);
        CHECK(pictures[leg] && stage_bad(pictures[leg], STRENGTH_COUNT) == 0);
        if (!pictures[leg]) pictures[leg] = calloc(STRENGTH_COUNT, sizeof(float));
    }
    environment->pixels = NULL;
    al_runtime_destroy(runtime);
    sphere_scene_end(&s);
}

static void free_pictures(float *pictures[2])
{
    free(pictures[0]);
    free(pictures[1]);
}

/* The largest relative difference of a picture from `scale` times another. */
static double worst_difference(const float *picture, const float *other, double scale)
{
    double worst = 0;
    for (int i = 0; i < STRENGTH_COUNT; i++) {
        double wanted = scale * other[i], difference = fabs(picture[i] - wanted);
        if (difference > 0) worst = fmax(worst, difference / fmax(fabs(wanted), 1e-30));
    }
    return worst;
}

/* The picture is linear in the lights. Times a power of two every float that it is made of keeps its digits:
 * equal to the last bit, unless something overflows or leaves the normal numbers. Times another number each
 * operation rounds anew, by 2^-24: one for each sample added up, and some 32 before and after. The sky's
 * picture holds halfs, 2^-12 off. */
static const double linear_bound = (STRENGTH_SAMPLES + 32) * 0x1p-23, sky_bound = 0x1p-11;

static void test_strengths(const char *folder)
{
    static const float factors[] = {0x1p-20f, 0x1p20f, 1e-6f, 1e6f};
    float *plain[2], *scaled[2];
    draw_lit(folder, (strengths){.sun = 1, .lamp = 1, .sky = 1}, AL_PASS_COMPOSITE, plain);
    for (int i = 0; i < 4; i++) {
        float f = factors[i];
        draw_lit(folder, (strengths){.sun = f, .lamp = f, .sky = f}, AL_PASS_COMPOSITE, scaled);
        for (int leg = 0; leg < 2; leg++) {
            double worst = worst_difference(scaled[leg], plain[leg], f);
            if (i < 2)
                CHECK(worst == 0);
            else
                test_extreme(i == 2 ? "radiosity 1e-6" : "radiosity 1e6", worst, 0, linear_bound + sky_bound,
                             "object in the player, %s: sun, lamp and sky times that, largest relative difference (times 2^-20, 2^20: "
                             "the same bits)", leg ? "by SH" : "marched");
        }
        free_pictures(scaled);
    }
    free_pictures(plain);
}

/* A light of 1e-6 beside one of 1e6: behind a wall the strong one adds nothing at all; otherwise it is all
 * there is, but for what it does not reach. */
static void test_strong_beside_weak(const char *folder)
{
    float *weak[2], *strong[2], *both[2];
    const al_pass pass = AL_PASS_TRANSLUCENT;
    draw_lit(folder, (strengths){.lamp = 1e-6f, .sun_below = true}, pass, weak);
    draw_lit(folder, (strengths){.sun = 1e6f, .lamp = 1e-6f, .sun_below = true}, pass, both);
    for (int leg = 0; leg < 2; leg++) {
        CHECK(stage_sum(weak[leg], STRENGTH_COUNT) > 0);
        CHECK(memcmp(weak[leg], both[leg], STRENGTH_COUNT * sizeof(float)) == 0);
    }
    free_pictures(both);
    draw_lit(folder, (strengths){.sun = 1e6f}, pass, strong);
    draw_lit(folder, (strengths){.sun = 1e6f, .lamp = 1e-6f}, pass, both);
    for (int leg = 0; leg < 2; leg++)
        for (int i = 0; i < STRENGTH_COUNT; i++)
            CHECK_NEAR(both[leg][i], strong[leg][i], linear_bound * strong[leg][i] + 2 * weak[leg][i]);
    free_pictures(weak);
    free_pictures(strong);
    free_pictures(both);
}

/* --- a light on the boundary --- */

/* What a lamp of 1 W/sr at `lamp`, on the unit sphere, sends up through (x, y): the straight ways from it to
 * all points of the ray lie inside. */
static double lamp_quadrature(double sigma_t, const double lamp[3], double x, double y)
{
    enum { STEPS = 2000 }; /* of 1 mm: 2e-6 of the integrand's largest curvature, 6 / d^2 with d > 0.3 m */
    double half = sqrt(1 - x * x - y * y), step = 2 * half / STEPS, sum = 0;
    for (int i = 0; i < STEPS; i++) {
        double z = half - (i + 0.5) * step, square = 0, to[3] = {x - lamp[0], y - lamp[1], z - lamp[2]};
        for (int k = 0; k < 3; k++) square += to[k] * to[k];
        sum += exp(-sigma_t * (half - z + sqrt(square))) / square * step;
    }
    return 0.9 * sigma_t / (4 * AL_PI) * sum;
}

/* Relative RMSE over the pixels whose rays pass the lamp by more than 0.3 m. */
static double lamp_error(const char *folder, uint32_t samples, const float lamp[3])
{
    enum { FRAMES = 4 };
    const double place[3] = {lamp[0], lamp[1], lamp[2]};
    const al_settings settings = {.surface_off = true, .pass = AL_PASS_TRANSLUCENT, .detail_off = true};
    al_runtime *runtime =
        open_sphere(folder, &(sphere_options){.samples = samples, .order = 8}, 2); /* the second is a lamp */
    al_runtime_scene(runtime)->lights[0].intensity[0] = 0;
    memcpy(al_runtime_scene(runtime)->lights[1].vector, lamp, 12);
    al_view view = stage_ortho(EDGE, EDGE, 1);
    double picture[EDGE * EDGE] = {0}, sums[2] = {0};
    for (int frame = 0; frame < FRAMES; frame++) {
        float *pixels = stage_draw(runtime, &view, &settings, 0);
        CHECK(pixels && stage_bad(pixels, EDGE * EDGE * 3) == 0);
        for (int i = 0; pixels && i < EDGE * EDGE; i++) picture[i] += pixels[3 * i] / (double)FRAMES;
        free(pixels);
    }
    for (int i = 0; i < EDGE * EDGE; i++) {
        double x = (2 * (i % EDGE) + 1.0) / EDGE - 1, y = (2 * (i / EDGE) + 1.0) / EDGE - 1;
        if (x * x + y * y > 0.81 || hypot(x - lamp[0], y - lamp[1]) < 0.3) continue;
        double wanted = lamp_quadrature(2, place, x, y);
        sums[0] += (picture[i] - wanted) * (picture[i] - wanted);
        sums[1] += wanted * wanted;
    }
    al_runtime_destroy(runtime);
    return sqrt(sums[0] / sums[1]);
}

static void test_light_on_boundary(const char *folder)
{
    float *pictures[2];
    draw_lit(folder, (strengths){.lamp = 1e6f, .lamp_on_glass = true}, AL_PASS_COMPOSITE, pictures);
    for (int leg = 0; leg < 2; leg++) CHECK(stage_sum(pictures[leg], STRENGTH_COUNT) > 0);
    free_pictures(pictures);
    sphere_scene s;
    float lamps[3][3] = {{0, 0, 1}, {1, 0, 0}, {0}};
    sphere_scene_begin(&s);
    const al_mesh *mesh = &s.meshes[0];
    for (int k = 0; k < 2; k++) { /* vertices of the mesh, to the last bit */
        float nearest = INFINITY;
        uint32_t best = 0;
        for (uint32_t v = 0; v < mesh->vertex_count; v++) {
            const float *p = mesh->positions + 3 * v;
            float away = hypotf(hypotf(p[0] - lamps[k][0], p[1] - lamps[k][1]), p[2] - lamps[k][2]);
            if (away < nearest) nearest = away, best = v;
        }
        CHECK(nearest < 1e-6f);
        memcpy(lamps[k], mesh->positions + 3 * best, 12);
    }
    for (int i = 0; i < 3; i++) /* the middle of a face */
        for (int k = 0; k < 3; k++)
            lamps[2][k] += mesh->positions[3 * mesh->indices[mesh->index_count / 2 + i] + k] / 3;
    for (int i = 0; i < 3; i++) {
        double coarse = lamp_error(folder, 1000, lamps[i]), fine = lamp_error(folder, 8000, lamps[i]);
        /* As in analytic_test.c these Gaussians leave an error of first order in the spacing, most of it at
         * the boundary, where the light is: 17 % at 1000 samples, half of it at eight times as many. */
        test_extreme("light on a surface", coarse, 0, 0.19, "object in the player: a lamp %s, error of the picture with 1000 samples",
                     i == 2 ? "in the middle of a face" : "in a vertex");
        test_extreme("light on a surface", fine, 0, 0.55 * coarse, "object in the player: the same with 8000 samples");
    }
    sphere_scene_end(&s);
}

static void test_sizes(const char *folder)
{
    al_runtime *empty = open_sphere(folder, &(sphere_options){.samples = UINT32_MAX}, 1);
    al_view view = stage_ortho(EDGE, EDGE, 1.1f), pixel = stage_ortho(1, 1, 0.1f);
    double lit = 0;
    for (int pass = 0; pass < AL_PASS_COUNT; pass++) {
        double seen = middle_of(empty, &view, &(al_settings){.pass = (al_pass)pass}, 1);
        if (pass == AL_PASS_TRANSLUCENT) lit = seen;
    }
    test_extreme("0 samples", lit, 0, 0, "object in the player: radiance of an asset without samples");
    al_runtime_destroy(empty);
    al_runtime *runtime = open_sphere(folder, &(sphere_options){.samples = 500}, 1);
    double back = 0.9 * (1 - exp(-8)) / (8 * AL_PI); /* of sigma_t 2 and 2 m, to a sun behind the eye; the blend as in analytic_test.c */
    test_extreme("1 x 1 pixels", middle_of(runtime, &pixel, &(al_settings){.pass = AL_PASS_TRANSLUCENT}, 1), back, 0.3 * back,
                 "object in the player: radiance of a sphere of 500 samples");
    al_error error = {0};
    pixel.width = 0;
    CHECK(al_runtime_draw(runtime, &pixel, NULL, 0, 0, &error) == AL_USAGE);
    CHECK(al_runtime_draw(runtime, &view, &(al_settings){.interval_count = 3}, 0, 0, &error) == AL_USAGE);
    CHECK(al_runtime_draw(runtime, &view, &(al_settings){.march_voxels = -1}, 0, 0, &error) == AL_USAGE);
    al_runtime_destroy(runtime);
}

/* A view of three tiles shows in its middle what a small view of that part shows. */
static void test_tiles(const char *folder)
{
    al_runtime *runtime = open_sphere(folder, &(sphere_options){.samples = 200}, 1);
    al_view wide = stage_ortho(4100, 16, 1), narrow = stage_ortho(16, 16, 1);
    wide.projection[0] = 1 / (4100.0f / 16);
    const al_settings settings = {.surface_off = true, .pass = AL_PASS_UNITY, .detail_off = true};
    float *all = stage_draw(runtime, &wide, &settings, 0), *part = stage_draw(runtime, &narrow, &settings, 0);
    CHECK(all && part && stage_bad(all, 4100 * 16 * 3) == 0);
    double worst = 0;
    for (int y = 0; all && part && y < 16; y++)
        for (int x = 0; x < 16; x++)
            worst = fmax(worst, fabs(all[3 * (y * 4100 + 2042 + x)] - part[3 * (y * 16 + x)]));
    /* Jitter moves the medium's ends by up to half a voxel of 1/30 m. */
    CHECK_NEAR(worst, 0, 0.1);
    CHECK(all && stage_sum(all, 4100 * 16 * 3) > 0.5 * stage_sum(part, 16 * 16 * 3));
    free(all);
    free(part);
    al_runtime_destroy(runtime);
}

typedef struct tiles {
    double done, total, stop_at;
} tiles;

static bool on_tile(void *user, double done, double total)
{
    tiles *t = user;
    CHECK(done == t->done + 1 && done <= total);
    t->done = done;
    t->total = total;
    return done >= t->stop_at;
}

/* The largest picture of the player, whole: it holds as much light per area as a small one. The small one's
 * sphere is 51 pixels across; a pixel at its rim is in or out by chance, which is worth 1 % at one in 160. */
static void test_largest(const char *folder)
{
    enum { LARGE = 8192, SMALL = 512 };
    al_runtime *runtime = open_sphere(folder, &(sphere_options){.samples = 200}, 1);
    al_view large = stage_ortho(LARGE, LARGE, 10), small = stage_ortho(SMALL, SMALL, 10);
    tiles all = {.stop_at = INFINITY}, some = {.stop_at = 2};
    al_settings settings = {
        .surface_off = true, .detail_off = true, .progress = on_tile, .progress_user = &some};
    time_t start_s = time(NULL);
    CHECK(stage_draw(runtime, &large, &settings, 0) == NULL);
    CHECK(some.done == 2 && some.total == 4 * 8);
    settings.progress_user = &all;
    float *picture = stage_draw(runtime, &large, &settings, 0);
    CHECK(all.done == 4 * 8);
    printf("8192 x 8192 pixels: %.0f s, %.0f MiB\n", difftime(time(NULL), start_s),
           (double)al_runtime_memory(runtime) / 1048576);
    CHECK(al_runtime_memory(runtime) < (uint64_t)512 << 20); /* tiles, whatever the view's size */
    settings.progress = NULL;
    float *thumbnail = stage_draw(runtime, &small, &settings, 0);
    size_t count = (size_t)LARGE * LARGE * 3;
    CHECK(picture && thumbnail && stage_bad(picture, count) == 0);
    if (picture && thumbnail) {
        double wanted = stage_sum(thumbnail, (size_t)SMALL * SMALL * 3) * (LARGE / SMALL) * (LARGE / SMALL);
        test_extreme("8192 x 8192 pixels", stage_sum(picture, count), wanted, 0.02 * wanted,
                     "object in the player: light of all pixels, against 256 times that of 512 x 512");
    }
    free(picture);
    free(thumbnail);
    al_runtime_destroy(runtime);
}

/* Every pass of a baked folder, by both view legs, from outside and from the middle. */
static void test_folder(const char *folder)
{
    al_runtime *runtime = NULL;
    al_error error = {0};
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK);
    CHECK(stage_load(runtime, folder));
    for (int inside = 0; inside < 2; inside++) {
        al_view view = stage_look(EDGE, EDGE, (float[3]){0, 0, inside ? 0 : 5}, (float[3]){0, 0, -1}, 0.8f);
        for (int leg = 0; leg < 2; leg++)
            for (int pass = 0; pass < AL_PASS_COUNT; pass++)
                middle_of(runtime, &view, &(al_settings){.pass = (al_pass)pass, .view_leg = (al_view_leg)leg},
                          1);
    }
    al_runtime_destroy(runtime);
}

int main(int argc, char **argv)
{
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    if (argc == 2) {
        test_folder(argv[1]);
        return test_end();
    }
    const char *folder = stage_folder();
    test_optical_depths(folder);
    test_both_ways(folder);
    test_inside(folder);
    test_lights(folder);
    test_strengths(folder);
    test_strong_beside_weak(folder);
    test_light_on_boundary(folder);
    test_sizes(folder);
    test_tiles(folder);
    test_largest(folder);
    return test_end();
}
