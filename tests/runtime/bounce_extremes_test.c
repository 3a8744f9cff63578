/* The extremes of light between surfaces and ambient occlusion: prints the rows of docs/accuracy.md. A room of a floor, a wall
 * and a ball, small pictures. Where nothing can be said but that a picture is finite and never negative, that is asked of
 * ambient occlusion by every carrier and of the composite with both effects and history. */
#include <epoxy/gl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../../runtime/state.h"
#include "../test.h"
#include "sphere.h"
#include "stage.h"

enum { EDGE = 24, COUNT = EDGE * EDGE, PIXELS = 3 * COUNT };

static const char *folder;
static al_runtime *runtime; /* one, as its shaders are what takes time; a room begins at frame 0 */

typedef enum subject { ROOM, FLOOR, BALL, TRIANGLE } subject;

typedef struct room { /* zero: the value in brackets */
    subject subject;
    float unit;              /* m (1) */
    float lamp, sun;         /* W/sr; W/m2 */
    float glow;              /* of the wall and floor, W/(m2 sr) */
    float roughness, metallic, ior; /* of both; ior (1.5) */
    int copies;              /* of the lamp (1) */
    bool flat;               /* and triangles without area */
} room;

/* --- scenes and pictures --- */

static void add_square(sphere_scene *s, float unit, float size, const float place[3], int axis)
{
    const float at[3] = {unit * place[0], unit * place[1], unit * place[2]};
    sphere_scene_add_floor(s, unit * size, at);
    float *world = s->instances[s->scene.instance_count - 1].world;
    memset(world, 0, 12 * sizeof *world);
    world[(axis + 2) % 3] = world[4 + axis] = world[8 + (axis + 1) % 3] = unit * size;
}

static void add_surfaces(sphere_scene *s, const room *r, float unit)
{
    if (r->subject == TRIANGLE) s->meshes[1].index_count = s->submeshes[1].index_count = 3;
    if (r->subject != BALL) add_square(s, unit, 4, (float[3]){0, 0, 0}, 1);
    if (r->subject == FLOOR) add_square(s, unit, 4, (float[3]){0, 0, 0}, 1); /* coplanar */
    if (r->subject == ROOM) add_square(s, unit, 2, (float[3]){0, 1, -1}, 2);
    if (r->subject == ROOM || r->subject == BALL) {
        sphere_scene_add_floor(s, 0.4f * unit, (float[3]){0.3f * unit, 0.5f * unit, 0});
        s->instances[s->scene.instance_count - 1].mesh = 0;
    }
    if (r->flat) { /* its first axis is nothing */
        add_square(s, unit, 0.5f, (float[3]){-0.5f, 0.4f, 0}, 1);
        for (int k = 0; k < 4; k++) s->instances[s->scene.instance_count - 1].world[k] = 0;
    }
}

static void load(sphere_scene *s)
{
    CHECK(sphere_scene_write(folder, s) && stage_load(runtime, folder));
    sphere_scene_end(s);
    runtime->frame_number = 0;
}

static void open_room(const room *r)
{
    sphere_scene s;
    const float unit = r->unit > 0 ? r->unit : 1;
    sphere_scene_begin(&s);
    s.scene.baked = (al_baked_light){"", ""};
    for (int m = 0; m < 2; m++) {
        s.materials[m].ior = r->ior > 0 ? r->ior : 1.5f;
        s.materials[m].roughness = r->roughness;
        s.materials[m].metallic = r->metallic;
        for (int c = 0; c < 3; c++) s.materials[m].base_color[c] = c ? 0.6f : 0.8f;
    }
    for (int c = 0; c < 3; c++) {
        s.materials[1].emission_w_m2_sr[c] = r->glow;
        s.scene.environment.sh[c][0] = 0.1f * 3.5449077f; /* 0.1 W/(m2 sr) from everywhere */
    }
    add_surfaces(&s, r, unit);
    for (int i = 0; i < (r->copies ? r->copies : 1) && r->lamp > 0; i++)
        sphere_scene_add_light(&s, AL_LIGHT_POINT, (float[3]){-0.5f * unit, 1.2f * unit, 0.5f * unit}, r->lamp);
    if (r->sun > 0) sphere_scene_add_light(&s, AL_LIGHT_DIRECTIONAL, (float[3]){0.24f, -0.72f, -0.65115f}, r->sun);
    load(&s);
}

static al_view look(uint32_t width, uint32_t height, float unit)
{
    al_view view = stage_look(width, height, (float[3]){0, 1.5f, 3.5f}, (float[3]){0, 0.5f, 0}, 0.8f);
    for (int k = 12; k < 15; k++) view.view[k] *= unit;
    view.projection[14] *= unit;
    return view;
}

static float *draw(const al_view *view, const al_settings *settings)
{
    float *pixels = stage_draw(runtime, view, settings, 0);
    CHECK(pixels && !stage_bad(pixels, 3 * (uint64_t)view->width * view->height));
    if (!pixels) exit(test_end());
    return pixels;
}

/* To be freed. */
static float *draw_room(const room *r, const al_settings *settings)
{
    open_room(r);
    al_view view = look(EDGE, EDGE, r->unit > 0 ? r->unit : 1);
    float *pixels = draw(&view, settings);
    return pixels;
}

/* Ambient occlusion by every carrier, if asked for, then two frames of everything with history; answers the mean of the last. Few surfels: near
 * the eye there would be very many. */
static double check_finite(const al_view *view, bool carriers)
{
    const al_settings few = {.bounce_samples = 1, .shell_levels = 3, .surfel_limit = 1000};
    const uint64_t count = 3 * (uint64_t)view->width * view->height;
    double mean = 0;
    al_settings settings = few;
    settings.pass = AL_PASS_AMBIENT_OCCLUSION;
    for (int i = 0; i < AL_CARRIER_COUNT && carriers; i++) {
        settings.occlusion_carrier = (al_carrier)i;
        free(draw(view, &settings));
    }
    settings = few;
    settings.indirect = settings.ambient_occlusion = true;
    settings.temporal = 8;
    for (int i = 0; i < 2; i++) {
        float *pixels = draw(view, &settings);
        mean = stage_sum(pixels, count) / (double)count;
        free(pixels);
    }
    return mean;
}

static bool same(const float *a, const float *b)
{
    return !memcmp(a, b, PIXELS * sizeof *a);
}

/* --- rows --- */

static void test_sizes(void)
{
    static const uint32_t sizes[][2] = {{1, 1}, {1, 37}, {61, 1}, {33, 17}};
    open_room(&(room){.lamp = 1, .roughness = 0.5f});
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        al_view view = look(sizes[i][0], sizes[i][1], 1);
        const int failures = test_failures;
        const double mean = check_finite(&view, true);
        if (i == 0)
            test_extreme("1 x 1 pixels", test_failures - failures, 0, 0,
                         "between surfaces: pictures with a pixel negative or not finite, mean %.3f", mean);
        else
            printf("| %u x %u pixels | finite, mean %.3f |\n", sizes[i][0], sizes[i][1], mean);
    }
}

/* Eyes: on a wall and before it by the near plane's distance, which is 0.01 m, below the floor, along it, inside of the ball and
 * in its surface, in the lamp. */
static void test_eyes(void)
{
    static const float eyes[][6] = {{0, 1, -1, 0, 1, -2},       {0, 1, -0.99f, 0, 1, -2},   {0, 1, -1, 1, 1, -1},
                                    {0, -0.5f, 0, 0, 1, 0.1f},  {0, 1e-4f, 2, 0, 0, 0},     {0.3f, 0.5f, 0, 1, 0.5f, 0},
                                    {0.3f, 0.5f, 0.4f, 0, 0, 0}, {-0.5f, 1.2f, 0.5f, 0, 0, 0}};
    for (int metal = 0; metal < 2; metal++) {
        open_room(&(room){.lamp = 1, .metallic = (float)metal});
        for (size_t i = 0; i < sizeof eyes / sizeof *eyes; i++) {
            al_view view = stage_look(EDGE, EDGE, eyes[i], eyes[i] + 3, 1.2f);
            check_finite(&view, !metal);
        }
    }
    printf("| eye on a wall, before it by the near plane, along it, below the floor, in the ball, in the lamp; mirrors and smooth "
           "dielectrics | finite, never negative |\n");
}

/* What is open at least of what is seen; *mean: in the mean. */
static double least_open(const al_view *view, const al_settings *settings, double *mean)
{
    static float places[COUNT][4];
    double least = 1, sum = 0;
    int seen = 0;
    float *pixels = draw(view, settings);
    glGetTextureImage(runtime->targets.geometry.id, 0, GL_RGBA, GL_FLOAT, sizeof places, places);
    for (int k = 0; k < COUNT; k++) {
        if (places[k][3] <= 0) continue;
        least = fmin(least, (double)pixels[3 * k]);
        sum += (double)pixels[3 * k];
        seen++;
    }
    *mean = sum / seen;
    free(pixels);
    return least;
}

/* A floor that lies in the plane of another and a triangle alone, seen at the slope of 1/1000 too: nothing of themselves. Screen's
 * pixels stand for all of a slope that they see; surfels without the z-buffer round. */
static void test_alone(void)
{
    static const char *const names[] = {[FLOOR] = "two floors in one plane", [TRIANGLE] = "a triangle"};
    for (int what = FLOOR; what <= TRIANGLE; what += TRIANGLE - FLOOR) {
        open_room(&(room){.subject = (subject)what, .lamp = 1, .roughness = 0.5f});
        al_view views[2] = {look(EDGE, EDGE, 1), stage_look(EDGE, EDGE, (float[3]){0, 2e-3f, 2}, (float[3]){0, 0, 0}, 0.6f)};
        double screen = 1, least_all = 1;
        for (int i = 0; i < 2; i++) {
            float *pixels = draw(&views[i], &(al_settings){.pass = AL_PASS_INDIRECT});
            CHECK(stage_sum(pixels, PIXELS) == 0);
            free(pixels);
            for (int carrier = 0; carrier < AL_CARRIER_COUNT; carrier++) {
                double mean, least = least_open(&views[i],
                                                &(al_settings){.pass = AL_PASS_AMBIENT_OCCLUSION,
                                                               .occlusion_carrier = (al_carrier)carrier}, &mean);
                if (carrier == AL_CARRIER_SCREEN)
                    screen = fmin(screen, least);
                else {
                    least_all = fmin(least_all, least);
                    CHECK_NEAR(least, 1, carrier == AL_CARRIER_SURFELS_BLENDED ? 1e-3 : 1e-6); /* as measured, 9e-4 */
                }
            }
        }
        if (what == TRIANGLE)
            test_extreme("one triangle", least_all, 1, 1e-3, /* as measured, by surfels-blended; all others 1e-6 */
                         "between surfaces: what the least open pixel of it is open, by every carrier but `screen` (%.2f)", screen);
        else
            printf("| %s, seen at a slope of 1/1000 too | all open within 1e-6 (`surfels-blended` 1e-3), exactly no light; by `screen` a "
                   "pixel is down to %.2f |\n", names[what], screen);
    }
}

/* Discs of 0.3 of a ball's radius touch it, and others of their rims float above it. */
static void test_ball(void)
{
    al_view view = look(EDGE, EDGE, 1);
    const float pixel_m = 2 * 3.7f * tanf(0.4f) / EDGE, pixels = 0.3f * 0.4f / pixel_m;
    al_settings settings = {.pass = AL_PASS_INDIRECT, .surfel_pixels = pixels, .shell_levels = 1};
    open_room(&(room){.subject = BALL, .lamp = 1, .roughness = 0.5f});
    float *light = draw(&view, &settings);
    settings.pass = AL_PASS_AMBIENT_OCCLUSION;
    double mean, least = least_open(&view, &settings, &mean);
    CHECK(stage_sum(light, PIXELS) == 0);
    printf("| a ball, discs of 0.3 of its radius | exactly no light; %.3f open, a pixel at its rim %.2f |\n", mean, least);
    free(light);
}

static void test_flat(void)
{
    int differ = 0;
    for (int i = 0; i <= AL_CARRIER_COUNT; i++) {
        al_settings settings = {.pass = i ? AL_PASS_AMBIENT_OCCLUSION : AL_PASS_INDIRECT, .occlusion_carrier = (al_carrier)(i ? i - 1 : 0)};
        float *without = draw_room(&(room){.lamp = 1, .roughness = 1}, &settings),
              *with = draw_room(&(room){.lamp = 1, .roughness = 1, .flat = true}, &settings);
        int off = 0;
        for (int k = 0; k < PIXELS; k++) off += memcmp(&with[k], &without[k], sizeof *with) != 0;
        differ += off;
        free(with), free(without);
    }
    test_extreme("triangles without area", differ, 0, 0,
                 "between surfaces: numbers of the picture that they change, one bounce and ambient occlusion by every carrier");
}

/* Two walls that coincide, of which one glows: whichever a ray meets, it is the same one in every run. */
static void test_ties(void)
{
    float *pictures[2];
    for (int i = 0; i < 2; i++) {
        sphere_scene s;
        sphere_scene_begin(&s);
        s.scene.baked = (al_baked_light){"", ""};
        memcpy(s.meshes[0].positions, s.meshes[1].positions, 12 * sizeof(float));
        memcpy(s.meshes[0].normals, s.meshes[1].normals, 12 * sizeof(float));
        memcpy(s.meshes[0].indices, s.meshes[1].indices, 6 * sizeof(uint32_t));
        s.meshes[0].vertex_count = 4;
        s.meshes[0].index_count = s.submeshes[0].index_count = 6;
        for (int c = 0; c < 3; c++) s.materials[0].emission_w_m2_sr[c] = 1;
        add_square(&s, 1, 4, (float[3]){0, 0, 0}, 1);
        for (int k = 0; k < 2; k++) add_square(&s, 1, 2, (float[3]){0, 1, -1}, 2);
        s.instances[2].mesh = 0;
        load(&s);
        al_view view = look(EDGE, EDGE, 1);
        pictures[i] = draw(&view, &(al_settings){.pass = AL_PASS_INDIRECT});
        runtime->frame_number = 0;
        float *again = draw(&view, &(al_settings){.pass = AL_PASS_INDIRECT});
        CHECK(same(again, pictures[i]));
        free(again);
    }
    CHECK(same(pictures[0], pictures[1]) && stage_sum(pictures[0], PIXELS) > 0);
    free(pictures[0]), free(pictures[1]);
    printf("| discs that coincide, of one wall that glows and one that does not | the same bytes in every run |\n");
}

static const al_plan_row *plan_row(const char *step)
{
    uint32_t count = 0;
    const al_plan_row *rows = al_runtime_plan(runtime, &count);
    for (uint32_t i = 0; i < count; i++)
        if (!strcmp(rows[i].step, step)) return &rows[i];
    return NULL;
}

/* The largest relative difference of a picture from `factor` times another. */
static double difference(const float *picture, const float *other, double factor)
{
    double worst = 0;
    for (int i = 0; i < PIXELS; i++)
        worst = fmax(worst, fabs((double)picture[i] / factor - (double)other[i]) / fmax((double)other[i], 1e-30));
    return worst;
}

/* None: black, without a pass. 64 in one place are one of their sum, but for the rounding of so many additions and, with a lobe, of
 * differences of what is larger; maps off, as they are coarser the more lamps there are. */
static void test_lamps(void)
{
    const al_settings settings = {.pass = AL_PASS_INDIRECT, .shadows_off = true};
    open_room(&(room){.roughness = 1});
    al_view view = look(EDGE, EDGE, 1);
    float *dark = draw(&view, &settings);
    test_extreme("0 lights", stage_sum(dark, PIXELS), 0, 0, "between surfaces: light of all pixels (no pass runs)");
    const al_plan_row *row = plan_row("indirect");
    CHECK(row && !row->needed && !strcmp(row->why, "no light and no emission"));
    free(dark);
    for (int glossy = 0; glossy < 2; glossy++) {
        const room one = {.lamp = 64, .roughness = glossy ? 0.4f : 1, .ior = glossy ? 1.5f : 1},
                   many = {.lamp = 1, .copies = 64, .roughness = one.roughness, .ior = one.ior};
        float *a = draw_room(&one, &settings), *b = draw_room(&many, &settings);
        double worst = difference(b, a, 1);
        test_extreme("64 lights", worst, 0, glossy ? 64 * 0x1p-20 : 64 * 0x1p-23,
                     "between %s surfaces: 64 lamps in one place against one of their sum, largest relative difference", glossy ? "glossy" : "matt");
        CHECK(stage_sum(a, PIXELS) > 0);
        free(a), free(b);
    }
}

/* Light is linear, also in history: three frames of it. */
static float *draw_strength(bool glow, float factor)
{
    open_room(&(room){.lamp = glow ? 0 : factor, .glow = glow ? factor : 0, .roughness = 0.4f});
    al_view view = look(EDGE, EDGE, 1);
    float *pixels = NULL;
    for (int i = 0; i < 3; i++) {
        free(pixels);
        pixels = draw(&view, &(al_settings){.pass = AL_PASS_INDIRECT, .temporal = 8});
    }
    return pixels;
}

static void test_linear(void)
{
    static const float factors[] = {0x1p-20f, 0x1p20f, 1e-6f, 1e6f};
    for (int glow = 0; glow < 2; glow++) {
        double worst[4];
        float *one = draw_strength(glow, 1);
        CHECK(stage_sum(one, PIXELS) > 0);
        for (int i = 0; i < 4; i++) {
            float *pixels = draw_strength(glow, factors[i]);
            worst[i] = difference(pixels, one, (double)factors[i]);
            free(pixels);
        }
        CHECK(worst[0] == 0 && worst[1] == 0);
        for (int i = 2; i < 4; i++)
            test_extreme(i == 2 ? "radiosity 1e-6" : "radiosity 1e6", worst[i], 0, 64 * 0x1p-20, /* as of glossy lamps */
                         "between surfaces: %s times that, largest relative difference (times 2^-20, 2^20: the same bits)",
                         glow ? "emission" : "a lamp");
        free(one);
    }
    open_room(&(room){.lamp = 1e30f, .roughness = 0.4f});
    al_view view = look(EDGE, EDGE, 1);
    printf("| a lamp of 1e30 | finite, mean %.1g |\n", check_finite(&view, true));
}

/* Sizes of powers of two are the same to the last bit; others round otherwise, and a ray here and there meets another disc. */
static void test_units(void)
{
    static const float units[] = {1, 0x1p-13f, 0x1p13f, 1e-4f, 1e4f};
    double most[2] = {0};
    for (int i = 0; i < 2 * AL_CARRIER_COUNT; i++) {
        const al_carrier carrier = (al_carrier)(i / 2);
        const al_settings settings = {.pass = i % 2 ? AL_PASS_INDIRECT : AL_PASS_AMBIENT_OCCLUSION, .occlusion_carrier = carrier,
                                      .indirect_carrier = i % 2 ? carrier : AL_CARRIER_SURFELS};
        if (i % 2 && carrier == AL_CARRIER_VOLUMES_BLENDED) continue;
        float *pictures[5];
        for (int u = 0; u < 5; u++) pictures[u] = draw_room(&(room){.sun = 3, .unit = units[u], .roughness = 0.4f}, &settings);
        double sum = stage_sum(pictures[0], PIXELS);
        CHECK(sum > 0);
        for (int u = 1; u < 5; u++) {
            int off = 0;
            for (int k = 0; k < PIXELS; k++) off += fabsf(pictures[u][k] - pictures[0][k]) > 1e-3f * pictures[0][k];
            if (u > 2) most[u - 3] = fmax(most[u - 3], fabs(stage_sum(pictures[u], PIXELS) / sum - 1));
            if (u < 3) CHECK(same(pictures[u], pictures[0]));
            CHECK(off <= PIXELS / 100);
        }
        for (int u = 0; u < 5; u++) free(pictures[u]);
    }
    static const char *const words = "between surfaces: light of all pixels over that in 1 m, every carrier, largest difference (2^-13, 2^13 m: "
                                     "the same bits)";
    test_extreme("scene of 1e-4 m", most[0], 0, 1e-3, "%s", words);
    test_extreme("scene of 1e4 m", most[1], 0, 1e-3, "%s", words);
}

static void test_materials(void)
{
    for (int i = 0; i < 8; i++) {
        open_room(&(room){.lamp = 1, .sun = 1, .roughness = (float)(i & 1), .metallic = (float)(i >> 1 & 1),
                                                .ior = i & 4 ? 1 : 3});
        al_view views[2] = {look(EDGE, EDGE, 1), stage_look(EDGE, EDGE, (float[3]){0, 2e-3f, 2}, (float[3]){0, 0, 0}, 0.6f)};
        for (int k = 0; k < 2; k++) check_finite(&views[k], false);
    }
    printf("| roughness 0 and 1, metal 0 and 1, refractive index 1 and 3, seen from above and at a slope of 1/1000 | finite, never "
           "negative |\n");
}

int main(void)
{
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    folder = stage_folder();
    CHECK(folder != NULL);
    if (!folder) return test_end();
    al_error error = {0};
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK);
    if (!runtime) return test_end();
    test_units();
    test_linear();
    test_lamps();
    test_alone();
    test_ball();
    test_flat();
    test_ties();
    test_sizes();
    test_eyes();
    test_materials();
    al_runtime_destroy(runtime);
    return test_end();
}
