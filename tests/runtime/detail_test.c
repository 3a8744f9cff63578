/* Prefixes of the samples, bands and levels of detail keep the brightness; the same input draws the same
 * picture. */
#include <stdlib.h>
#include <string.h>

#include "../test.h"
#include "sphere.h"
#include "stage.h"

enum { EDGE = 64, SAMPLES = 8000 };

static al_runtime *open_sphere(const char *folder, const sphere_options *options)
{
    al_runtime *runtime = NULL;
    al_error error = {0};
    sphere_scene s;
    sphere_scene_begin(&s);
    sphere_scene_add(&s, "sphere.air", 1, (float[3]){0, 0, 0});
    sphere_scene_add_light(&s, AL_LIGHT_DIRECTIONAL, (float[3]){-0.6f, 0, -0.8f}, 1);
    CHECK(sphere_write_asset(folder, "sphere.air", options) && sphere_scene_write(folder, &s));
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK);
    CHECK(stage_load(runtime, folder));
    sphere_scene_end(&s);
    return runtime;
}

static double brightness(al_runtime *runtime, const al_view *view, const al_settings *settings)
{
    float *pixels = stage_draw(runtime, view, settings, 0);
    CHECK(pixels && stage_bad(pixels, (uint64_t)view->width * view->height * 3) == 0);
    double sum = pixels ? stage_sum(pixels, (uint64_t)view->width * view->height * 3) : 0;
    free(pixels);
    return sum;
}

/* Halving the samples again and again: each step changes the sum by little, all together by no more than the
 * blur of the coarsest (125 samples, 0.3 m apart, in a medium of mean free path 0.5 m). */
static void test_prefixes(al_runtime *runtime)
{
    al_view view = stage_ortho(EDGE, EDGE, 1.1f);
    al_settings settings = {.pass = AL_PASS_TRANSLUCENT, .detail_off = true};
    double all = brightness(runtime, &view, &settings), before = all;
    CHECK(al_runtime_samples(runtime) == SAMPLES);
    for (settings.sample_limit = SAMPLES / 2; settings.sample_limit > 100; settings.sample_limit /= 2) {
        double now = brightness(runtime, &view, &settings);
        CHECK(al_runtime_samples(runtime) == settings.sample_limit);
        CHECK_NEAR(now / before, 1, 0.05);
        CHECK_NEAR(now / all, 1, 0.12);
        before = now;
    }
    settings.sample_limit = 0;
    for (settings.sh_order = 3; settings.sh_order <= 5;
         settings.sh_order++) /* order 3 blurs the light's side */
        CHECK_NEAR(brightness(runtime, &view, &settings) / all, 1, 0.06);
}

/* The mean of four draws, each half a pixel from its neighbours: an object of few pixels, finer. */
static double supersampled(al_runtime *runtime, float distance, const al_settings *settings)
{
    al_view view = stage_look(EDGE, EDGE, (float[3]){0, 0, distance}, (float[3]){0, 0, 0}, 0.7f);
    double sum = 0;
    for (int i = 0; i < 4; i++) {
        view.projection[8] = ((float)(i % 2) - 0.5f) / EDGE;
        view.projection[9] = ((float)(i / 2) - 0.5f) / EDGE;
        sum += brightness(runtime, &view, settings) / 4;
    }
    return sum;
}

/* Farther away fewer samples and bands are drawn; the picture's sum stays within 10 % of that of all of them
 * (about 300 of 8000 samples at last, 0.24 m apart in a mean free path of 0.5 m). */
static void test_distance(al_runtime *runtime)
{
    const al_settings chosen = {.pass = AL_PASS_TRANSLUCENT},
                      full = {.pass = AL_PASS_TRANSLUCENT, .detail_off = true};
    uint64_t fewest = SAMPLES;
    for (float distance = 4; distance < 46; distance *= 1.5f) {
        double sum = supersampled(runtime, distance, &chosen);
        CHECK(al_runtime_samples(runtime) <= fewest);
        fewest = al_runtime_samples(runtime);
        double wanted = supersampled(runtime, distance, &full);
        CHECK(al_runtime_samples(runtime) == SAMPLES);
        CHECK_NEAR(sum / wanted, 1, 0.1);
    }
    CHECK(fewest < SAMPLES / 10);
}

/* Half floats and bytes against floats: half a unit in the last place of 11 bits, of 8 bits, on each of the
 * coefficients that the sum of the picture averages. */
static void test_formats(const char *folder, double wanted)
{
    static const double bounds[] = {0, 1e-3, 5e-3};
    al_view view = stage_ortho(EDGE, EDGE, 1.1f);
    for (int format = AL_COEFFICIENT_HALF; format <= AL_COEFFICIENT_BYTE; format++) {
        al_runtime *runtime = open_sphere(
            folder, &(sphere_options){.samples = SAMPLES, .format = (al_coefficient_format)format});
        double sum = brightness(runtime, &view, &(al_settings){.pass = AL_PASS_TRANSLUCENT});
        CHECK_NEAR(sum / wanted, 1, bounds[format]);
        al_runtime_destroy(runtime);
    }
}

/* Three sets of equal coefficients with two extinctions that differ by next to nothing take the coloured
 * path. */
static void test_channels(const char *folder, double wanted)
{
    al_view view = stage_ortho(EDGE, EDGE, 1.1f);
    al_runtime *runtime =
        open_sphere(folder, &(sphere_options){.samples = SAMPLES, .sigma_t = {2, 2.0001f, 1.9999f}});
    CHECK_NEAR(brightness(runtime, &view, &(al_settings){.pass = AL_PASS_TRANSLUCENT}) / wanted, 1, 2e-3);
    al_runtime_destroy(runtime);
}

static void test_deterministic(const char *folder)
{
    float *pictures[2];
    al_view view = stage_look(EDGE, EDGE, (float[3]){0, 0, 3}, (float[3]){0, 0, 0}, 0.7f);
    for (int i = 0; i < 2; i++) {
        al_runtime *runtime = open_sphere(folder, &(sphere_options){.samples = 2000});
        pictures[i] = stage_draw(runtime, &view, &(al_settings){0}, 0);
        al_runtime_destroy(runtime);
    }
    CHECK(memcmp(pictures[0], pictures[1], EDGE * EDGE * 3 * sizeof(float)) == 0);
    free(pictures[0]);
    free(pictures[1]);
}

int main(void)
{
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    const char *folder = stage_folder();
    al_runtime *runtime = open_sphere(folder, &(sphere_options){.samples = SAMPLES});
    al_view view = stage_ortho(EDGE, EDGE, 1.1f);
    double wanted = brightness(runtime, &view, &(al_settings){.pass = AL_PASS_TRANSLUCENT});
    test_prefixes(runtime);
    test_distance(runtime);
    al_runtime_destroy(runtime);
    test_formats(folder, wanted);
    test_channels(folder, wanted);
    test_deterministic(folder);
    return test_end();
}
