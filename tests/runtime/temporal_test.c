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

/* The ball grows a tip of its own length in the first second. */
static void deform_ball(sphere_scene *s)
{
    static float times[2] = {0, 1}, shares[2] = {0, 1};
    static al_motion_node node = {"", AL_NO_INDEX, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, {0}, {0, 0, 0, 1}, {1, 1, 1}};
    static al_motion_channel channel = {0, AL_MOTION_WEIGHTS, AL_MOTION_LINEAR, 2, 1, times, shares};
    static al_motion_deform deform;
    const al_mesh *mesh = &s->meshes[0];
    float *deltas = calloc(mesh->vertex_count, 12);
    CHECK(deltas != NULL);
    if (!deltas) exit(test_end());
    for (uint32_t i = 0; i < mesh->vertex_count; i++) deltas[3 * i + 1] = fmaxf(mesh->positions[3 * i + 1], 0);
    deform = (al_motion_deform){s->scene.instance_count - 1, 0, 0, 0, 1, false, mesh->positions, mesh->normals, NULL, NULL, deltas, NULL};
    s->scene.motion = (al_motion){1, 1, 0, 0, 1, &node, &channel, NULL, NULL, &deform};
}

/* A box of 2 m without its front, a ball of 0.35 m in it, two lamps; fog of mean free paths of 5 m and the ball's growth, if
 * asked for. */
static void write_box(bool foggy, bool grows)
{
    sphere_scene s;
    al_fog fog = {.density = 1, .asset = ""};
    sphere_scene_begin(&s);
    for (int c = 0; c < 3; c++) s.medium.sigma_s_per_m[c] = s.medium.sigma_a_per_m[c] = 0.1f;
    s.scene.fogs = &fog;
    s.scene.fog_count = foggy;
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
    if (grows) deform_ball(&s);
    CHECK(sphere_scene_write(folder, &s));
    if (grows) free(s.scene.motion.deforms->position_deltas);
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

/* --- beside the rest of the frame --- */

/* In fog, whose own light is drawn anew in each frame: what --indirect adds to the picture is the mean over frames of what it
 * adds without history, both effects at once. */
static void test_fog(void)
{
    trio t = open_trio(AL_PASS_COMPOSITE);
    al_settings bare = t.without;
    al_view view = look(0, 0);
    al_runtime *none = open_box();
    static float mean[PIXELS];
    memset(mean, 0, sizeof mean);
    t.with.temporal_undoubted = true;
    t.without.indirect = t.with.indirect = t.without.ambient_occlusion = t.with.ambient_occlusion = true;
    for (int n = 1; n <= 5; n++) {
        float *one = draw(t.plain, &view, &t.without), *kept = draw(t.kept, &view, &t.with), *base = draw(none, &view, &bare);
        for (int i = 0; i < PIXELS; i++) {
            mean[i] += (one[i] - base[i] - mean[i]) / (float)n;
            kept[i] -= base[i];
        }
        CHECK(error_of(kept, mean) < 1e-3);
        free(one), free(kept), free(base);
    }
    al_runtime_destroy(none);
    close_trio(&t);
}

/* The ball grows in fog: no frame is worse than without history; when the lamps go out nothing is left. */
static void test_growth(void)
{
    enum { K = 8, FRAMES = 9 };
    trio t = open_trio(AL_PASS_INDIRECT);
    al_runtime *all[] = {t.plain, t.kept, t.truth};
    al_view view = look(0, 0);
    double worst = 0, last = 0;
    for (int f = 0; f <= FRAMES; f++) {
        for (int i = 0; i < 3; i++) {
            al_runtime_set_time(all[i], fmin(0.15 * f, 0.9));
            for (int k = 0; k < 6 && f == FRAMES; k++) al_runtime_scene(all[i])->lights[k / 3].intensity[k % 3] = 0;
        }
        float *one = draw(t.plain, &view, &t.without), *kept = draw(t.kept, &view, &t.with);
        if (f == FRAMES) {
            CHECK(stage_sum(kept, PIXELS) == 0);
        } else {
            float *truth = converge(t.truth, &view, &t.without, K);
            last = error_of(kept, truth) / error_of(one, truth);
            worst = fmax(worst, f ? last : 0);
            CHECK(last <= 1.05);
            free(truth);
        }
        free(one), free(kept);
    }
    printf("ball that grows in fog: error of history at most %.3f of that without, %.3f at rest\n", worst, last);
    CHECK(last < 1.05 * sqrt(1.0 / 3 + 1.0 / K) / sqrt(1 + 1.0 / K)); /* the last three frames are alike */
    close_trio(&t);
}

/* As a host draws: its own picture is 5, its own geometry hides ours from pixel `edge` on. To be freed. */
static float *draw_hosted(al_runtime *runtime, const al_view *view, const al_settings *settings, int edge)
{
    static float depths[COUNT];
    GLuint textures[2], framebuffer;
    al_error error = {0};
    float *pixels = malloc(PIXELS * sizeof *pixels), near = 0.01f, far = 100, z = 1.5f;
    CHECK(pixels != NULL);
    if (!pixels) exit(test_end());
    for (int i = 0; i < COUNT; i++) depths[i] = i % EDGE < edge ? 1 : far * (z - near) / (z * (far - near));
    glCreateTextures(GL_TEXTURE_2D, 2, textures);
    glTextureStorage2D(textures[0], 1, GL_RGBA32F, EDGE, EDGE);
    glTextureStorage2D(textures[1], 1, GL_DEPTH_COMPONENT32F, EDGE, EDGE);
    glTextureSubImage2D(textures[1], 0, 0, 0, EDGE, EDGE, GL_DEPTH_COMPONENT, GL_FLOAT, depths);
    glCreateFramebuffers(1, &framebuffer);
    glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, textures[0], 0);
    glClearNamedFramebufferfv(framebuffer, GL_COLOR, 0, (float[4]){5, 5, 5, 1});
    CHECK(al_runtime_draw(runtime, view, settings, framebuffer, textures[1], &error) == AL_OK);
    glGetTextureImage(textures[0], 0, GL_RGB, GL_FLOAT, PIXELS * sizeof *pixels, pixels);
    CHECK(!stage_bad(pixels, PIXELS));
    glDeleteFramebuffers(1, &framebuffer);
    glDeleteTextures(2, textures);
    return pixels;
}

/* A host's wall moves aside: it keeps its own picture, what comes into view behind it has no history, the rest keeps it. */
static void test_host(void)
{
    trio t = open_trio(AL_PASS_COMPOSITE);
    al_view view = look(0, 0);
    static const int edges[] = {20, 20, 20, 26, 32, EDGE};
    static float light[COUNT][4];
    t.without.indirect = t.with.indirect = t.without.ambient_occlusion = t.with.ambient_occlusion = true;
    t.with.temporal_undoubted = true;
    for (int f = 0; f < 6; f++) {
        int fresh = 0, old = 0, before = f ? edges[f - 1] : 0;
        float *one = draw_hosted(t.plain, &view, &t.without, edges[f]), *kept = draw_hosted(t.kept, &view, &t.with, edges[f]);
        read_history(t.kept, AL_BOUNCE_INDIRECT, light);
        for (int i = 0; i < COUNT; i++) {
            int x = i % EDGE;
            bool host = x >= edges[f], seen = !host && light[i][3] > 0;
            CHECK(x < before ? light[i][3] > 1 || !seen : seen ? light[i][3] == 1 : light[i][3] == 0);
            fresh += seen && light[i][3] == 1;
            old += seen && light[i][3] > 1;
            for (int c = 3 * i; c < 3 * i + 3; c++) {
                if (host) CHECK(kept[c] == 5);
                if (!seen || light[i][3] == 1) CHECK_NEAR((double)kept[c], (double)one[c], 1e-5 * (double)one[c]);
            }
        }
        printf("host's wall from %d: %d pixels new, %d kept\n", edges[f], fresh, old);
        CHECK(fresh > 100 || edges[f] == before);
        CHECK(f == 0 || old > 300);
        free(one), free(kept);
    }
    close_trio(&t);
}

int main(void)
{
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    folder = stage_folder();
    CHECK(folder != NULL);
    if (!folder) return test_end();
    write_box(false, false);
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
    test_host();
    write_box(true, false);
    test_fog();
    write_box(true, true);
    test_growth();
    return test_end();
}
