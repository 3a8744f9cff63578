/* Loading while drawing: a first picture from a prefix, the byte budget, failures said once, loading anew,
 * and what the runtime says about itself. */
#include <epoxy/gl.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "../test.h"
#include "sphere.h"
#include "stage.h"

enum { EDGE = 32, SAMPLES = 6000, PAGE = 256, SAMPLE_BYTES = 28 + 25 * 4 };

static void pause_ms(long ms)
{
    struct timespec pause = {0, ms * 1000000};
    nanosleep(&pause, NULL);
}

static void write_scene(const char *folder, const char *first, const char *second)
{
    sphere_scene s;
    sphere_scene_begin(&s);
    sphere_scene_add(&s, first, 1, (float[3]){0, 0, 0});
    if (second) sphere_scene_add(&s, second, 1, (float[3]){3, 0, 0});
    sphere_scene_add_light(&s, AL_LIGHT_DIRECTIONAL, (float[3]){0, 0, -1}, 1);
    CHECK(sphere_scene_write(folder, &s));
    sphere_scene_end(&s);
}

static double brightness(al_runtime *runtime)
{
    al_view view = stage_ortho(EDGE, EDGE, 1.1f);
    float *pixels = stage_draw(runtime, &view, &(al_settings){.pass = AL_PASS_TRANSLUCENT}, 0);
    CHECK(pixels && stage_bad(pixels, EDGE * EDGE * 3) == 0);
    double sum = pixels ? stage_sum(pixels, EDGE * EDGE * 3) : 0;
    free(pixels);
    return sum;
}

/* Every update stays within its bytes; the first picture that is ready is nearly as bright as the last. */
static void test_prefix(const char *folder)
{
    al_runtime *runtime = NULL;
    al_error error = {0};
    al_load_state state = {0};
    uint64_t before = 0, budget = 160 * SAMPLE_BYTES;
    double first = 0;
    write_scene(folder, "sphere.air", NULL);
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK);
    CHECK(al_runtime_scene(runtime) == NULL);
    CHECK(brightness(runtime) == 0);
    CHECK(al_runtime_load(runtime, folder, &error) == AL_OK);
    for (int i = 0; i < 20000 && !state.complete; i++) {
        CHECK(al_runtime_update(runtime, budget, &state, &error) == AL_OK);
        CHECK(state.samples_loaded - before <= budget / SAMPLE_BYTES);
        if (state.ready && first == 0) {
            CHECK(state.samples_loaded < SAMPLES / 10);
            first = brightness(runtime);
            CHECK(al_runtime_samples(runtime) == state.samples_loaded);
        }
        if (state.samples_loaded == before) pause_ms(1);
        before = state.samples_loaded;
    }
    CHECK(state.complete && state.samples_loaded == SAMPLES && state.samples_total == SAMPLES);
    /* Light is followed from each sample to first order in the optical distance: what is left out is half of
     * its square. 160 samples stand 0.30 m apart, the mean free path is 0.5 m. */
    CHECK_NEAR(first / brightness(runtime), 1, 0.5 * (0.30 / 0.5) * (0.30 / 0.5));
    al_runtime_destroy(runtime);
}

/* A missing or damaged asset is said once, by name; the other object is drawn. */
static void test_failure(const char *folder, const char *bad)
{
    al_runtime *runtime = NULL;
    al_error error = {0}, ignored;
    al_load_state state = {0};
    int failures = 0;
    write_scene(folder, "sphere.air", bad);
    CHECK(al_runtime_create(NULL, &runtime, &ignored) == AL_OK);
    CHECK(al_runtime_load(runtime, folder, &ignored) == AL_OK);
    for (int i = 0; i < 5000 && !state.complete; i++) {
        al_error here = {0};
        if (al_runtime_update(runtime, 0, &state, &here)) {
            failures++;
            error = here;
        }
        pause_ms(1);
    }
    CHECK(state.complete && state.ready && failures == 1);
    CHECK(error.status == AL_BAD_INPUT && strstr(error.message, bad) != NULL);
    CHECK(brightness(runtime) > 0);
    al_runtime_destroy(runtime);
}

/* A load that fails leaves the scene as it was; one that works replaces it; leaving mid-way is clean. */
static void test_reload(const char *folder)
{
    al_runtime *runtime = NULL;
    al_error error = {0};
    write_scene(folder, "sphere.air", NULL);
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK);
    CHECK(stage_load(runtime, folder));
    double seen = brightness(runtime);
    uint64_t memory = al_runtime_memory(runtime);
    CHECK(al_runtime_load(runtime, "/nowhere", &error) == AL_BAD_INPUT);
    CHECK(strstr(error.message, "/nowhere: no scene.air") != NULL);
    CHECK_NEAR(brightness(runtime), seen, 0.01 * seen);
    CHECK(stage_load(runtime, folder));
    CHECK_NEAR(brightness(runtime), seen, 0.01 * seen);
    CHECK(al_runtime_memory(runtime) == memory);
    CHECK(al_runtime_load(runtime, folder, &error) == AL_OK);
    al_runtime_destroy(runtime);
}

/* The plan names what is not needed, and that holds no bytes. */
static void test_plan(const char *folder)
{
    al_runtime *runtime = NULL;
    al_error error = {0};
    uint32_t count = 0, unneeded = 0;
    static const char *const others[] = {
        "skin", "density grid", "glossy", "surfels",  "interval-map", "surface-scattering", "visibility",        "sky light", "shadow",
        "environment", "lightmap", "probes",       "direct-scattering",  "ambient-occlusion", "indirect",  "temporal"};
    al_pass_time times[16];
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK);
    al_runtime_plan(runtime, &count);
    CHECK(count == 0);
    CHECK(stage_load(runtime, folder));
    for (int i = 0; i < 4; i++) brightness(runtime);
    const al_plan_row *rows = al_runtime_plan(runtime, &count);
    for (uint32_t i = 0; i < count; i++) {
        CHECK(rows[i].why[0] != 0);
        if (rows[i].needed) continue;
        unneeded++;
        CHECK(rows[i].bytes == 0 && rows[i].seconds == 0);
        bool known = false;
        for (size_t k = 0; k < sizeof others / sizeof *others; k++) known |= !strcmp(rows[i].step, others[k]);
        CHECK(known);
    }
    CHECK(unneeded == sizeof others / sizeof *others);
    uint32_t stages = al_runtime_times(runtime, times, 16);
    CHECK(stages >= 4);
    for (uint32_t i = 0; i < stages; i++) CHECK(times[i].ms >= 0 && times[i].ms < 60000);
    CHECK(strcmp(al_pass_name(AL_PASS_UNITY), "unity") == 0);
    al_runtime_destroy(runtime);
}

/* A shader that does not build: its file's name, and a file with the log. */
static void test_shader_error(const char *folder)
{
    char path[512], log[512] = "";
    al_runtime *runtime = NULL;
    al_error error = {0};
    snprintf(path, sizeof path, "%s/splat.frag", folder);
    FILE *file = fopen(path, "w");
    fputs("#version 450 core\nvoid main() { nonsense; }\n", file);
    fclose(file);
    CHECK(al_runtime_create(&(al_runtime_options){.shader_folder = folder}, &runtime, &error) == AL_OK);
    CHECK(stage_load(runtime, folder));
    al_view view = stage_ortho(EDGE, EDGE, 1.1f);
    GLuint texture, framebuffer;
    glCreateTextures(GL_TEXTURE_2D, 1, &texture);
    glTextureStorage2D(texture, 1, GL_RGBA16F, EDGE, EDGE);
    glCreateFramebuffers(1, &framebuffer);
    glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, texture, 0);
    CHECK(al_runtime_draw(runtime, &view, NULL, framebuffer, 0, &error) == AL_BAD_INPUT);
    glDeleteFramebuffers(1, &framebuffer);
    glDeleteTextures(1, &texture);
    CHECK(strstr(error.message, "splat.frag") != NULL);
    const char *named = strstr(error.message, "whole log: ");
    CHECK(named != NULL);
    if (named) snprintf(log, sizeof log, "%s", named + 11);
    CHECK(access(log, R_OK) == 0);
    unlink(log);
    unlink(path);
    al_runtime_destroy(runtime);
}

int main(void)
{
    char path[512];
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    const char *folder = stage_folder();
    CHECK(sphere_write_asset(folder, "sphere.air",
                             &(sphere_options){.samples = SAMPLES, .page_size = PAGE, .grid = 32}));
    test_prefix(folder);
    test_failure(folder, "missing.air");
    snprintf(path, sizeof path, "%s/cut.air", folder);
    CHECK(sphere_write_asset(folder, "cut.air", &(sphere_options){.samples = 500, .grid = 16}));
    CHECK(truncate(path, 5000) == 0);
    test_failure(folder, "cut.air");
    test_reload(folder);
    test_plan(folder);
    test_shader_error(folder);
    return test_end();
}
