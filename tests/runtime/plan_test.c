/* The plan says what ran: over a list of settings, rows that are needed are those of the stages that were timed, every byte
 * is in one row at most, and a frame with the first settings holds what it held before. */
#include <epoxy/gl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../test.h"
#include "airlight/runtime.h"
#include "sphere.h"
#include "stage.h"

enum { EDGE = 32, TIMES = 64 };

/* Stages of the rows that every frame runs anew. */
static const struct {
    const char *row, *stages; /* between spaces */
} rows[] = {
    {"light", " light "},
    {"surface", " surface "},
    {"direct-scattering", " direct-scattering "},
    {"surfels", " surfels surfel-light "},
    {"interval-map", " interval-map "},
    {"surface-scattering", " span legs shells unshuffle blur gather "},
    {"visibility", " bounce-rays bounce bounce-light "},
    {"ambient-occlusion", " occlusion-rays occlusion-hits occlusion-arrive occlusion-filter "},
    {"indirect", " indirect-rays indirect-hits indirect-arrive indirect-filter "},
    {"temporal", " occlusion-history indirect-history "},
    {"intervals", " intervals "},
    {"splat", " splat "},
    {"composite", " composite "},
};
enum { ROWS = sizeof rows / sizeof *rows };

static const al_settings cases[] = {
    {.visibility = true},
    {.fog_off = true},
    {.surface_scattering_off = true},
    {.shadows_off = true},
    {.ambient_occlusion = true},
    {.indirect = true},
    {.ambient_occlusion = true, .indirect = true, .surface_scattering_off = true},
    {.ambient_occlusion = true, .indirect = true, .visibility = true},
    {.ambient_occlusion = true, .fog_off = true, .occlusion_carrier = AL_CARRIER_VOLUMES},
    {.ambient_occlusion = true, .fog_off = true, .occlusion_carrier = AL_CARRIER_VOLUMES_BLENDED},
    {.ambient_occlusion = true, .fog_off = true, .occlusion_carrier = AL_CARRIER_SCREEN},
    {.indirect = true, .fog_off = true, .indirect_carrier = AL_CARRIER_VOLUMES},
    {.indirect = true, .fog_off = true, .indirect_carrier = AL_CARRIER_SURFELS_BLENDED},
    {.indirect = true, .fog_off = true, .indirect_carrier = AL_CARRIER_SCREEN},
    {.interval_weights = AL_INTERVAL_WEIGHTS_COEFFICIENTS},
    {.second_leg_off = true, .shell_levels = 3, .blur_off = true},
    {.view_leg = AL_VIEW_LEG_SH},
    {.pass = AL_PASS_TRANSLUCENT},
    {.pass = AL_PASS_SURFACE},
    {.pass = AL_PASS_NORMAL},
    {.pass = AL_PASS_DEPTH},
    {.pass = AL_PASS_INTERVALS},
    {.pass = AL_PASS_UNITY},
    {.pass = AL_PASS_DIRECT_SCATTERING},
    {.pass = AL_PASS_SURFACE_SCATTERING},
    {.pass = AL_PASS_SURFELS},
    {.pass = AL_PASS_INTERVAL_MAP},
    {.pass = AL_PASS_DEPLETION},
    {.pass = AL_PASS_SHELLS},
    {.pass = AL_PASS_UNSHUFFLED},
    {.pass = AL_PASS_BLURRED},
    {.pass = AL_PASS_SHADOW_MAP},
    {.pass = AL_PASS_AMBIENT_OCCLUSION},
    {.pass = AL_PASS_INDIRECT},
    {.pass = AL_PASS_BOUNCE_RAYS},
    {.pass = AL_PASS_BOUNCE_HITS, .visibility = true},
    {.pass = AL_PASS_BOUNCE_HITS, .indirect = true},
};

static const al_plan_row *find(const al_plan_row *plan, uint32_t count, const char *step)
{
    for (uint32_t i = 0; i < count; i++)
        if (!strcmp(plan[i].step, step)) return &plan[i];
    return NULL;
}

static bool lists(const char *stages, const char *name)
{
    char word[64];
    snprintf(word, sizeof word, " %s ", name);
    for (char *c = word + 1; c[1]; c++)
        if (*c == ' ') *c = '-'; /* "surfel light" */
    return strstr(stages, word) != NULL;
}

static void draw(al_runtime *runtime, const al_settings *settings)
{
    al_view view = stage_look(EDGE, EDGE, (float[3]){0, 0.3f, 3}, (float[3]){0, -0.3f, 0}, 0.8f);
    for (int i = 0; i < 2; i++) {
        float *pixels = stage_draw(runtime, &view, settings, 0);
        CHECK(pixels && stage_bad(pixels, EDGE * EDGE * 3) == 0);
        free(pixels);
        glFinish(); /* so that its times have come back */
    }
}

static void check_plan(al_runtime *runtime, int number)
{
    al_pass_time times[TIMES];
    uint32_t count, timed = al_runtime_times(runtime, times, TIMES), listed = 0;
    const al_plan_row *plan = al_runtime_plan(runtime, &count);
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < count; i++) {
        bytes += plan[i].bytes;
        CHECK(plan[i].why[0] && (plan[i].needed || plan[i].seconds == 0));
    }
    CHECK(bytes == al_runtime_memory(runtime));
    for (int r = 0; r < ROWS; r++) {
        const al_plan_row *row = find(plan, count, rows[r].row);
        bool ran = false;
        for (uint32_t i = 0; i < timed; i++) {
            if (!lists(rows[r].stages, times[i].name)) continue;
            ran = true;
            listed++;
        }
        CHECK(row && row->needed == ran);
        if (row && row->needed != ran) printf("settings %d: %s says %d: %s\n", number, row->step, row->needed, row->why);
        bool loaded = !strcmp(rows[r].row, "light") || !strcmp(rows[r].row, "intervals") ||
                      !strcmp(rows[r].row, "splat") || !strcmp(rows[r].row, "direct-scattering");
        CHECK(row && (row->needed || loaded || row->bytes == 0));
    }
    for (uint32_t i = 0; i < timed; i++)
        if (!strcmp(times[i].name, "shadow") || !strcmp(times[i].name, "skin")) listed++;
    CHECK(listed == timed);
    CHECK(find(plan, count, "shadow")->needed == (number < 0 || !cases[number].shadows_off));
}

int main(void)
{
    static float sky[4 * 2 * 3];
    al_fog fog = {.bounded = true, .bounds_min_m = {-1, -1, -1}, .bounds_max_m = {1, 1, 1}, .density = 1, .asset = ""};
    al_runtime *runtime = NULL;
    al_error error = {0};
    sphere_scene s;
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    const char *folder = stage_folder();
    if (!folder) return test_skip("no temporary folder");
    sphere_scene_begin(&s);
    for (int k = 0; k < 3; k++) s.medium.sigma_s_per_m[k] = 0.7f;
    for (size_t i = 0; i < sizeof sky / sizeof *sky; i++) sky[i] = 1;
    s.scene.environment = (al_environment){.width = 4, .height = 2, .pixels = sky};
    s.scene.fogs = &fog;
    s.scene.fog_count = 1;
    s.scene.baked = (al_baked_light){"", ""};
    CHECK(sphere_write_asset(folder, "sphere.air", &(sphere_options){.samples = 200, .grid = 16}));
    sphere_scene_add(&s, "sphere.air", 0.3f, (float[3]){0.4f, -0.2f, 0.3f});
    sphere_scene_add_floor(&s, 2, (float[3]){0, -0.8f, 0});
    sphere_scene_add_floor(&s, 0.5f, (float[3]){-0.4f, -0.4f, 0});
    sphere_scene_add_light(&s, AL_LIGHT_POINT, (float[3]){0, 0.8f, 0}, 1);
    CHECK(sphere_scene_write(folder, &s));
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK && stage_load(runtime, folder));
    sphere_scene_end(&s);
    uint32_t count;
    const al_plan_row *plan = al_runtime_plan(runtime, &count); /* before the first frame */
    for (int r = 0; r < ROWS; r++) CHECK(find(plan, count, rows[r].row) && !find(plan, count, rows[r].row)->needed);
    draw(runtime, NULL);
    check_plan(runtime, -1);
    uint64_t memory = al_runtime_memory(runtime);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        draw(runtime, &cases[i]);
        check_plan(runtime, (int)i);
        draw(runtime, NULL);
        check_plan(runtime, -1);
        CHECK(al_runtime_memory(runtime) == memory);
    }
    al_runtime_destroy(runtime);
    return test_end();
}
