/* Light of one bounce and ambient occlusion averaged over frames, in a box with a ball and two lamps. Errors are relative, against
 * the mean of frames without history, drawn with other random numbers; of K of them it is wrong by e/sqrt(K), e being one
 * frame's error.
 *
 * Bounds. Undoubted, n frames are their plain mean, and their error is e/sqrt(n) at most, less where the sequence of rays is
 * evener than chance. A weight of at most N frames leaves e/sqrt(2N + 1). With doubt, no frame's expected error is above e
 * (shaders/history.comp); 5 % are added for one picture's chance. What is left of a change,
 * as a mean around, is 0.63 of a frame's noise at most (likewise). */
#include <epoxy/gl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../../runtime/state.h"
#include "../test.h"
#include "sphere.h"
#include "stage.h"

enum { EDGE = 48, COUNT = EDGE * EDGE, PIXELS = 3 * COUNT, LIMIT = 32 };

static const char *folder;

/* --- the scene --- */

static void add_square(sphere_scene *s, float size, const float place[3], int axis, float side)
{
    sphere_scene_add_floor(s, size, place);
    float *world = s->instances[s->scene.instance_count - 1].world;
    memset(world, 0, 12 * sizeof *world);
    world[(axis + 2) % 3] = size * side;
    world[4 + axis] = size * side;
    world[8 + (axis + 1) % 3] = size;
}

static void add_ball(sphere_scene *s, float radius, const float place[3])
{
    sphere_scene_add_floor(s, radius, place);
    s->instances[s->scene.instance_count - 1].mesh = 0;
}

/* A box of 2 m without its front, a ball of 0.35 m in it, two lamps. */
static void write_box(void)
{
    sphere_scene s;
    sphere_scene_begin(&s);
    for (int i = 0; i < 6; i++) {
        float place[3] = {0, 0, 0}, side = i % 2 ? 1 : -1;
        place[i / 2] = -side;
        if (i != 4) add_square(&s, 2, place, i / 2, side);
    }
    add_ball(&s, 0.35f, (float[3]){0.2f, -0.65f, 0.1f});
    sphere_scene_add_light(&s, AL_LIGHT_POINT, (float[3]){-0.6f, 0.5f, 0.2f}, 1);
    sphere_scene_add_light(&s, AL_LIGHT_POINT, (float[3]){0.5f, 0.6f, 0.5f}, 0.3f);
    for (int i = 0; i < 2; i++)
        for (int c = 0; c < 3; c++) s.materials[i].base_color[c] = c ? 0.6f : 0.8f;
    for (int c = 0; c < 3; c++) s.scene.environment.sh[c][0] = 0.1f * 3.5449077f; /* 0.1 W/(m2 sr) from everywhere */
    s.scene.baked = (al_baked_light){"", ""};
    CHECK(sphere_scene_write(folder, &s));
    sphere_scene_end(&s);
}

static al_runtime *open_box(void)
{
    al_runtime *runtime = NULL;
    al_error error = {0};
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK);
    CHECK(stage_load(runtime, folder));
    return runtime;
}

/* --- pictures --- */

static const al_settings usual = {.pass = AL_PASS_INDIRECT, .surfel_pixels = 3, .shell_levels = 4, .bounce_radius_m = 0.25f,
                                  .surfel_limit = 10000};

static al_view look(float x, float y)
{
    return stage_look(EDGE, EDGE, (float[3]){x, y, 3.4f}, (float[3]){0, 0, 0}, 0.7f);
}

static float *draw(al_runtime *runtime, const al_view *view, const al_settings *settings)
{
    float *pixels = stage_draw(runtime, view, settings, 0);
    CHECK(pixels && !stage_bad(pixels, (uint64_t)view->width * view->height * 3));
    if (!pixels) exit(test_end());
    return pixels;
}

static double error_of(const float *pixels, const float *truth)
{
    double sum = 0, all = 0;
    for (int i = 0; i < PIXELS; i++) {
        double d = (double)pixels[i] - (double)truth[i];
        sum += d * d;
        all += (double)truth[i] * (double)truth[i];
    }
    return sqrt(sum / all);
}

/* The mean of `frames` frames without history; to be freed. */
static float *converge(al_runtime *runtime, const al_view *view, const al_settings *settings, int frames)
{
    float *mean = calloc(PIXELS, sizeof *mean);
    CHECK(mean != NULL);
    if (!mean) exit(test_end());
    for (int f = 0; f < frames; f++) {
        float *pixels = draw(runtime, view, settings);
        for (int i = 0; i < PIXELS; i++) mean[i] += pixels[i] / (float)frames;
        free(pixels);
    }
    return mean;
}

/* The same scene three times: without history, with it, and, with other random numbers, for the truth. */
typedef struct trio {
    al_runtime *plain, *kept, *truth;
    al_settings without, with;
} trio;

static trio open_trio(al_pass pass)
{
    trio t = {open_box(), open_box(), open_box(), usual, usual};
    t.truth->frame_number = 100000;
    t.without.pass = t.with.pass = pass;
    t.with.temporal = LIMIT;
    return t;
}

static void close_trio(trio *t)
{
    al_runtime_destroy(t->plain);
    al_runtime_destroy(t->kept);
    al_runtime_destroy(t->truth);
}

static void read_history(const al_runtime *runtime, al_bounce_effect effect, float light[COUNT][4])
{
    glGetTextureImage(runtime->history.light[effect][runtime->history.now].id, 0, GL_RGBA, GL_FLOAT,
                      COUNT * 4 * sizeof(float), light);
}

/* --- a still view --- */

static void test_mean(al_pass pass)
{
    trio t = open_trio(pass);
    al_view view = look(0, 0);
    static float mean[PIXELS];
    memset(mean, 0, sizeof mean);
    t.with.temporal_undoubted = true;
    for (int n = 1; n <= 6; n++) {
        float *one = draw(t.plain, &view, &t.without), *kept = draw(t.kept, &view, &t.with);
        for (int i = 0; i < PIXELS; i++) mean[i] += (one[i] - mean[i]) / (float)n;
        CHECK(error_of(kept, mean) < 1e-3); /* places are projected within some 1e-4 pixels */
        free(one), free(kept);
    }
    close_trio(&t);
}

static void test_still(al_pass pass)
{
    enum { K = 64, FRAMES = 30 };
    trio t = open_trio(pass);
    al_view view = look(0, 0);
    al_runtime *brief = open_box();
    al_settings short_history = t.with;
    short_history.temporal = 4;
    float *truth = converge(t.truth, &view, &t.without, K);
    double e2 = 0, least = 0, sum = 0;
    for (int n = 1; n <= FRAMES; n++) {
        float *one = draw(t.plain, &view, &t.without), *kept = draw(t.kept, &view, &t.with),
              *few = draw(brief, &view, &short_history);
        double e = error_of(one, truth), k = error_of(kept, truth), s = error_of(few, truth);
        e2 += (e * e - e2) / n;
        sum += stage_sum(kept, PIXELS) / stage_sum(truth, PIXELS) / FRAMES;
        if (n <= 16) CHECK(k * k < e2 * (1.0 / n + 1.0 / K) * 1.3); /* e2 of n frames scatters */
        if (n > 20) CHECK(s * s < e2 * (1.0 / 9 + 1.0 / K) * 1.3);
        if (n == 1) CHECK_NEAR(k, e, 1e-5);
        if (n == FRAMES) printf("%s, still: error %.3f, of history %.3f, of 4 frames' %.3f; sum %.4f\n",
                                al_pass_name(pass), sqrt(e2), k, s, sum);
        least = k;
        free(one), free(kept), free(few);
    }
    CHECK(least * least < e2 * (1.0 / 20 + 1.0 / K)); /* the mean of 30 frames, but for doubts */
    CHECK_NEAR(sum, 1, 0.02);
    free(truth);
    al_runtime_destroy(brief);
    close_trio(&t);
}

/* --- motion --- */

static void test_camera(al_pass pass, float roughness, double factor)
{
    enum { K = 16, FRAMES = 14, WARM = 8 };
    trio t = open_trio(pass);
    al_runtime *all[] = {t.plain, t.kept, t.truth};
    for (int i = 0; i < 3; i++)
        for (int m = 0; m < 2 && roughness < 1; m++) {
            al_material *material = &al_runtime_scene(all[i])->materials[m];
            material->metallic = 1;
            material->roughness = roughness;
        }
    double worst = 0, mean = 0;
    for (int f = 0; f < FRAMES; f++) { /* a third to 1.5 pixels a frame */
        al_view view = look(0.02f * (float)f - 0.2f, 0.01f * (float)f);
        float *one = draw(t.plain, &view, &t.without), *kept = draw(t.kept, &view, &t.with);
        if (f >= WARM) {
            float *truth = converge(t.truth, &view, &t.without, K);
            double ratio = error_of(kept, truth) / error_of(one, truth);
            worst = fmax(worst, ratio);
            mean += ratio / (FRAMES - WARM);
            free(truth);
        }
        free(one), free(kept);
    }
    printf("%s, roughness %g, moving camera: error %.2f of that without history, at most %.2f\n", al_pass_name(pass),
           (double)roughness, mean, worst);
    CHECK(worst < factor);
    close_trio(&t);
}

/* Lamp 0 runs along the ceiling, then goes out; then lamp 1 too. */
static void test_lamps(void)
{
    enum { K = 8, OFF = 14, FRAMES = 17 };
    trio t = open_trio(AL_PASS_INDIRECT);
    al_runtime *ghosting = open_box(), *all[] = {t.plain, t.kept, t.truth, ghosting};
    al_settings undoubted = t.with;
    undoubted.temporal_undoubted = true;
    al_view view = look(0, 0);
    double worst = 0, ghost = 0, after = 0;
    for (int f = 0; f <= FRAMES; f++) {
        for (int i = 0; i < 4; i++) {
            al_light *lamps = al_runtime_scene(all[i])->lights;
            lamps[0].vector[0] = 0.1f * (float)f - 0.7f;
            for (int c = 0; c < 3 && f >= OFF; c++) lamps[0].intensity[c] = 0;
            for (int c = 0; c < 3 && f == FRAMES; c++) lamps[1].intensity[c] = 0;
        }
        float *one = draw(t.plain, &view, &t.without), *kept = draw(t.kept, &view, &t.with),
              *ghosts = draw(ghosting, &view, &undoubted);
        if (f == FRAMES) {
            CHECK(stage_sum(kept, PIXELS) == 0); /* no light, no noise: nothing is left */
            CHECK(stage_sum(ghosts, PIXELS) > 0);
        } else {
            float *truth = converge(t.truth, &view, &t.without, K);
            double e = error_of(one, truth), k = error_of(kept, truth);
            CHECK(k <= 1.05 * e);
            worst = fmax(worst, f ? k / e : 0);
            ghost = fmax(ghost, error_of(ghosts, truth) / e);
            if (f >= OFF) after = fmax(after, fabs(stage_sum(kept, PIXELS) - stage_sum(one, PIXELS)) / stage_sum(truth, PIXELS) / e);
            free(truth);
        }
        free(one), free(kept), free(ghosts);
    }
    printf("lamps: error of history at most %.3f of that without, undoubted %.1f; once one is out the sum is off by %.3f of the error\n", worst, ghost, after);
    CHECK(ghost > 2); /* there was something to find */
    CHECK(after < 0.63);
    al_runtime_destroy(ghosting);
    close_trio(&t);
}

/* The ball jumps: what comes into view, the ball and the wall behind it, has no history, and is drawn as without. */
static void test_disocclusion(al_pass pass)
{
    trio t = open_trio(pass);
    al_view view = look(0, 0);
    al_bounce_effect effect = pass == AL_PASS_INDIRECT ? AL_BOUNCE_INDIRECT : AL_BOUNCE_OCCLUSION;
    static float before[COUNT][4], now[COUNT][4], light[COUNT][4];
    for (int f = 0; f < 4; f++) {
        free(draw(t.plain, &view, &t.without));
        free(draw(t.kept, &view, &t.with));
    }
    glGetTextureImage(t.kept->targets.geometry.id, 0, GL_RGBA, GL_FLOAT, sizeof before, before);
    al_runtime *both[] = {t.plain, t.kept};
    for (int i = 0; i < 2; i++) {
        al_scene *scene = al_runtime_scene(both[i]);
        scene->instances[scene->instance_count - 1].world[12] -= 0.3f;
    }
    float *one = draw(t.plain, &view, &t.without), *kept = draw(t.kept, &view, &t.with);
    glGetTextureImage(t.kept->targets.geometry.id, 0, GL_RGBA, GL_FLOAT, sizeof now, now);
    read_history(t.kept, effect, light);
    int fresh = 0, old = 0;
    for (int i = 0; i < COUNT; i++) {
        /* a pixel is 0.05 m wide and 0.1 m deep at most where it is not seen at a graze */
        if (fabsf(before[i][3] - now[i][3]) > 0.25f) {
            fresh++;
            CHECK(light[i][3] == 1);
            for (int c = 3 * i; c < 3 * i + 3; c++) CHECK_NEAR((double)kept[c], (double)one[c], 1e-5 * (double)one[c]);
        }
        old += light[i][3] > 1;
    }
    printf("%s: %d of %d pixels come into view\n", al_pass_name(pass), fresh, COUNT);
    CHECK(fresh > 50 && old > COUNT / 2);
    free(one), free(kept);
    close_trio(&t);
}

/* --- life --- */

static const al_plan_row *plan_row(al_runtime *runtime)
{
    uint32_t count = 0;
    const al_plan_row *rows = al_runtime_plan(runtime, &count);
    for (uint32_t i = 0; i < count; i++)
        if (!strcmp(rows[i].step, "temporal")) return &rows[i];
    return NULL;
}

static void test_life(void)
{
    trio t = open_trio(AL_PASS_COMPOSITE);
    t.without.indirect = t.with.indirect = t.without.ambient_occlusion = t.with.ambient_occlusion = true;
    al_view view = look(0, 0), small = stage_look(EDGE / 2, EDGE / 3, (float[3]){0, 0, 3}, (float[3]){0, 0, 0}, 0.7f);
    free(draw(t.kept, &view, &t.without)), free(draw(t.kept, &view, &t.without));
    uint64_t off = al_runtime_memory(t.kept);
    const al_plan_row *row = plan_row(t.kept);
    CHECK(row && !row->needed && !row->bytes);
    free(draw(t.kept, &view, &t.with));
    row = plan_row(t.kept);
    CHECK(row && row->needed && row->bytes == al_runtime_memory(t.kept) - off);
    CHECK(row->bytes == COUNT * (2 * 2 * 16 + 2 * 8) + sizeof(al_history_block));
    for (int step = 0; step < 4; step++) { /* each begins anew: another size, after a pause, after a load, a jump of frames */
        const al_view *seen = step == 0 ? &small : &view;
        if (step == 1) free(draw(t.kept, &view, &t.without));
        if (step == 1) CHECK(al_runtime_memory(t.kept) == off);
        if (step == 2) CHECK(stage_load(t.kept, folder));
        if (step == 3) t.kept->frame_number += 5;
        t.plain->frame_number = t.kept->frame_number;
        float *one = draw(t.plain, seen, &t.without), *kept = draw(t.kept, seen, &t.with);
        for (uint32_t i = 0; i < 3 * seen->width * seen->height; i++) CHECK_NEAR((double)kept[i], (double)one[i], 1e-5 * (double)one[i]);
        free(one), free(kept);
        free(draw(t.kept, &view, &t.with));
    }
    al_settings wrong = t.with;
    al_error error = {0};
    wrong.temporal = 1025;
    CHECK(al_runtime_draw(t.kept, &view, &wrong, 0, 0, &error) == AL_USAGE);
    close_trio(&t);
}

/* The same frames, the same bytes. */
static void test_repeat(void)
{
    al_runtime *pair[] = {open_box(), open_box()};
    al_settings settings = usual;
    settings.temporal = LIMIT;
    for (int f = 0; f < 4; f++) {
        al_view view = look(0.03f * (float)f, 0);
        float *a = draw(pair[0], &view, &settings), *b = draw(pair[1], &view, &settings);
        CHECK(!memcmp(a, b, PIXELS * sizeof *a));
        free(a), free(b);
    }
    al_runtime_destroy(pair[0]);
    al_runtime_destroy(pair[1]);
}

/* A view of two tiles: history goes across their border, as the mean of a still view and as the camera turns. */
static void test_tiles(void)
{
    enum { WIDTH = AL_TILE_WIDTH + 64, HEIGHT = 4, NUMBERS = WIDTH * HEIGHT * 3 };
    trio t = open_trio(AL_PASS_AMBIENT_OCCLUSION);
    t.without.surfel_pixels = t.with.surfel_pixels = 100;
    t.with.temporal_undoubted = true;
    al_view view = stage_look(WIDTH, HEIGHT, (float[3]){0, 0, 3.4f}, (float[3]){0, 0, 0}, 0.004f);
    static float mean[NUMBERS], frames[WIDTH * HEIGHT][4];
    for (int n = 1; n <= 3; n++) {
        float *one = draw(t.plain, &view, &t.without), *kept = draw(t.kept, &view, &t.with);
        double far = 0, all = 0;
        for (int i = 0; i < NUMBERS; i++) {
            mean[i] += (one[i] - mean[i]) / (float)n;
            far += fabs((double)mean[i] - (double)kept[i]);
            all += (double)mean[i];
        }
        CHECK(all > 0 && far < 1e-3 * all);
        free(one), free(kept);
    }
    view = stage_look(WIDTH, HEIGHT, (float[3]){0.05f, 0, 3.4f}, (float[3]){0.05f, 0, 0}, 0.004f);
    free(draw(t.kept, &view, &t.with));
    const al_history *history = &t.kept->history;
    glGetTextureImage(history->light[AL_BOUNCE_OCCLUSION][history->now].id, 0, GL_RGBA, GL_FLOAT, sizeof frames, frames);
    int carried = 0; /* around where the tiles meet, which lies in the middle of the back wall */
    for (int x = WIDTH / 2 - 20; x < WIDTH / 2 + 20; x++) carried += frames[WIDTH + x][3] > 3.5f;
    CHECK(carried == 40);
    close_trio(&t);
}

int main(void)
{
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    folder = stage_folder();
    CHECK(folder != NULL);
    if (!folder) return test_end();
    write_box();
    for (int i = 0; i < 2; i++) {
        al_pass pass = i ? AL_PASS_AMBIENT_OCCLUSION : AL_PASS_INDIRECT;
        test_mean(pass);
        test_still(pass);
        test_camera(pass, 1, 0.5); /* as of a quarter of the frames that are there */
        test_disocclusion(pass);
    }
    test_camera(AL_PASS_INDIRECT, 0.4f, 1.05);
    test_camera(AL_PASS_INDIRECT, 0.1f, 1.05);
    test_camera(AL_PASS_INDIRECT, 0, 1.05);
    test_lamps();
    test_life();
    test_repeat();
    test_tiles();
    return test_end();
}
