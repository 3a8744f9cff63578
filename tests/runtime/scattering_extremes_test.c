/* Extremes of the light that surfaces send into fog: each case's mean over frames against the sum over all surfels and a
 * quadrature along every ray, double precision, which knows nothing of the interval map, the deal and the shells; wrong
 * input; tiles; that the same frame twice is the same. Prints rows of docs/accuracy.md. */
#include <epoxy/gl.h>
#include <stdlib.h>
#include <string.h>

#include "../test.h"
#include "airlight/formulas.h"
#include "readback.h"
#include "sphere.h"
#include "stage.h"

enum { EDGE = 16, BLOCKS = 4 }; /* pixels, and blocks of 8 x 8 of them */

static const char *folder;

/* A fog in a box of x and y in [-half, half]. */
typedef struct slab {
    float from, to, half; /* z; m, before the scale */
    float sigma_s[3], sigma_a[3], g;
} slab;

typedef struct room { /* zero: the value in brackets */
    slab slabs[AL_FOG_LIMIT];
    uint32_t count;
    float scale;    /* (1) of all lengths; coefficients are over it */
    float light;    /* W/sr (1) of one lamp, before the scale's square */
    float lamp[3];  /* (0.1, 0.5, 0) */
    float glow;     /* W/(m2 sr) of the squares */
    bool no_lamp, no_floor, endless;
    uint32_t voxels;        /* along each axis of the first fog's box (0: constant) */
    float density, dense;   /* of all voxels, of the one that is nearest to the middle */
    bool extended;          /* al_medium_info's */
} room;

static al_status slice(void *user, uint32_t frame, uint32_t z, float *density, al_error *error)
{
    const room *r = user;
    uint32_t n = r->voxels, middle = n / 2;
    (void)frame, (void)error;
    for (uint32_t i = 0; i < n * n; i++) density[i] = z == middle && i == middle * n + middle ? r->dense : r->density;
    return AL_OK;
}

static const char *grid_path(void)
{
    static char path[512];
    snprintf(path, sizeof path, "%s/grid.medium.air", folder);
    return path;
}

static void write_grid(const room *r, const al_fog *fog, const al_medium *medium)
{
    al_error error = {0};
    al_medium_data data = {.info = {.size = {r->voxels, r->voxels, r->voxels},
                                    .frame_count = 1,
                                    .extended = r->extended},
                           .slice = slice,
                           .user = (void *)r};
    sphere_lay_grid(&data, fog, medium);
    CHECK(al_medium_write(grid_path(), &data, NULL, &error) == AL_OK);
}

static al_runtime *open_room(const room *r)
{
    al_runtime *runtime = NULL;
    al_error error = {0};
    sphere_scene s;
    al_fog fogs[AL_FOG_LIMIT] = {{0}};
    al_medium media[AL_FOG_LIMIT] = {{0}};
    float scale = r->scale > 0 ? r->scale : 1, lamp[3] = {0.1f * scale, 0.5f * scale, 0};
    sphere_scene_begin(&s);
    for (uint32_t i = 0; i < r->count; i++) {
        const slab *b = &r->slabs[i];
        fogs[i] = (al_fog){
            .medium = i, .bounded = !r->endless, .density = 1, .asset = i || !r->voxels ? "" : "grid.medium.air"};
        media[i] = (al_medium){.name = "", .g = b->g};
        for (int k = 0; k < 3; k++) {
            fogs[i].bounds_min_m[k] = r->endless ? 0 : (k == 2 ? b->from : -b->half) * scale;
            fogs[i].bounds_max_m[k] = r->endless ? 0 : (k == 2 ? b->to : b->half) * scale;
            media[i].sigma_s_per_m[k] = b->sigma_s[k] / scale;
            media[i].sigma_a_per_m[k] = b->sigma_a[k] / scale;
        }
        if (!i && r->voxels) write_grid(r, &fogs[i], &media[i]);
    }
    s.scene.fogs = fogs;
    s.scene.fog_count = s.scene.medium_count = r->count;
    s.scene.media = media;
    s.scene.baked = (al_baked_light){"", ""};
    for (int k = 0; k < 3; k++) s.materials[1].emission_w_m2_sr[k] = r->glow;
    if (!r->no_floor) {
        sphere_scene_add_floor(&s, 2 * scale, (float[3]){0, -0.8f * scale, 0});
        sphere_scene_add_floor(&s, 0.5f * scale, (float[3]){0.3f * scale, -0.1f * scale, 0.2f * scale});
    }
    for (int k = 0; k < 3 && (r->lamp[0] != 0 || r->lamp[1] != 0 || r->lamp[2] != 0); k++) lamp[k] = r->lamp[k] * scale;
    if (!r->no_lamp)
        sphere_scene_add_light(&s, AL_LIGHT_POINT, lamp, (r->light > 0 ? r->light : 1) * scale * scale);
    CHECK(sphere_scene_write(folder, &s));
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK);
    CHECK(stage_load(runtime, folder));
    sphere_scene_end(&s);
    return runtime;
}

/* stage_look with all lengths times `scale`. */
static al_view look(uint32_t width, uint32_t height, const float eye[3], float scale)
{
    al_view view = stage_look(width, height, eye, (float[3]){eye[0] - 0.2f, eye[1] - 0.1f, eye[2] - 3}, 0.7f);
    for (int k = 12; k < 15; k++) view.view[k] *= scale;
    view.projection[14] *= scale;
    return view;
}

static const float front[3] = {0.2f, 0.1f, 3};

/* --- the sum over all surfels, double precision --- */

/* Radiance scattered per metre at r(t) towards the eye, before extinction on the way to it. */
static void source_at(const readback *s, const ray *r, double t, double light[3])
{
    double sigma[AL_FOG_LIMIT];
    memset(light, 0, 3 * sizeof *light);
    for (int32_t i = 0; i < s->fogs.counts[0]; i++) {
        double span[2];
        sigma[i] = 0;
        if (readback_clip(&s->fogs.fogs[i], r, 1e30, span) && t >= span[0] && t < span[1])
            sigma[i] = readback_density(s, i, r, t);
    }
    for (uint32_t j = 0; j < s->surfel_count; j++) {
        const surfel *f = &s->surfels[j];
        ray leg;
        double squared = 0, cosine = 0, turn = 0, tau[3];
        for (int k = 0; k < 3; k++) {
            leg.origin[k] = f->place[k];
            leg.direction[k] = r->origin[k] + t * r->direction[k] - f->place[k];
            squared += leg.direction[k] * leg.direction[k];
        }
        double distance = sqrt(squared);
        for (int k = 0; k < 3; k++) {
            leg.direction[k] /= distance;
            cosine += leg.direction[k] * f->facing[k];
            turn -= leg.direction[k] * r->direction[k];
        }
        const float *sent = cosine > 0 ? f->front : f->back;
        if (!(sent[0] > 0 || sent[1] > 0 || sent[2] > 0)) continue;
        double angle = al_disc_angle(f->place[3], fabs(cosine) * distance, squared);
        readback_depth(s, &leg, distance, tau);
        for (int32_t i = 0; i < s->fogs.counts[0]; i++)
            for (int c = 0; c < 3 && sigma[i] > 0; c++)
                light[c] += sigma[i] * s->fogs.fogs[i].sigma_s[c] * al_phase(s->fogs.fogs[i].sigma_t[3], turn) * angle * sent[c] *
                            exp(-tau[c]);
    }
}

/* The largest optical depth over [from, to] of the channels that are not gone before it. */
static double depth_between(const readback *s, const ray *r, double from, double to)
{
    double before[3], after[3], largest = 0;
    readback_depth(s, r, from, before);
    readback_depth(s, r, to, after);
    for (int c = 0; c < 3; c++)
        if (before[c] < 40) largest = fmax(largest, after[c] - before[c]);
    return largest;
}

/* Gauss-Legendre of three places a step; steps end at every fog's surface and take at most 32 shares of an
 * optical depth of the channels that are not gone, nor more than a share of the ray. */
static void integrate(const readback *s, uint32_t pixel, int shares, double light[3])
{
    static const double place[3] = {0.1127016653792583, 0.5, 0.8872983346207417}, weight[3] = {5 / 18.0, 4 / 9.0, 5 / 18.0};
    double ends[2 * AL_FOG_LIMIT + 1], longest = 0;
    int end_count = 0;
    ray r = readback_ray(&s->frame, pixel % s->width + 0.5, pixel / s->width + 0.5);
    float surface = s->geometry[4 * pixel + 3];
    memset(light, 0, 3 * sizeof *light);
    for (int32_t i = 0; i < s->fogs.counts[0]; i++) {
        double span[2];
        if (!readback_clip(&s->fogs.fogs[i], &r, surface > 0 ? surface : 1e30, span)) continue;
        memcpy(ends + end_count, span, sizeof span);
        end_count += 2;
        longest = fmax(longest, span[1]);
    }
    double t = 0, tau[3] = {0};
    while (t < longest && fmin(fmin(tau[0], tau[1]), tau[2]) < 40) {
        double next = longest, depth;
        for (int i = 0; i < end_count; i++)
            if (ends[i] > t) next = fmin(next, ends[i]);
        depth = depth_between(s, &r, t, next);
        if (depth > 0) next = fmin(next, t + longest / shares);
        while (depth > 0 && (depth = depth_between(s, &r, t, next)) > 32.0 / shares)
            next = t + (next - t) * fmax(0.8 * 32 / shares / depth, 1e-3);
        for (int k = 0; k < 3 && depth > 0; k++) {
            double at = t + place[k] * (next - t), here[3], source[3];
            readback_depth(s, &r, at, here);
            source_at(s, &r, at, source);
            for (int c = 0; c < 3; c++) light[c] += weight[k] * (next - t) * exp(-here[c]) * source[c];
        }
        t = next;
        readback_depth(s, &r, t, tau);
    }
}

/* --- comparing --- */

static double square(double x)
{
    return x * x;
}

typedef struct picture {
    double mean[EDGE * EDGE * 3], error[EDGE * EDGE * 3]; /* and its standard error */
} picture;

static void average(al_runtime *runtime, const al_view *view, const al_settings *settings, int frames, picture *p)
{
    memset(p, 0, sizeof *p);
    for (int frame = 0; frame < frames; frame++) {
        float *pixels = stage_draw(runtime, view, settings, 0);
        CHECK(pixels && stage_bad(pixels, EDGE * EDGE * 3) == 0);
        for (int i = 0; pixels && i < EDGE * EDGE * 3; i++) {
            p->mean[i] += pixels[i] / (double)frames;
            p->error[i] += square(pixels[i]) / frames;
        }
        free(pixels);
    }
    for (int i = 0; i < EDGE * EDGE * 3; i++)
        p->error[i] = sqrt(fmax(p->error[i] - square(p->mean[i]), 0) / (frames - 1));
}

/* Means over 8 x 8 blocks within four standard errors or `bound`, relative: 0.5 % is what counts as right; where samples
 * keep weights of 8 bits it is 0.3 % more. Prints the picture's relative difference and the worst block's: as a row of the
 * table of extremes where it is one of its list. */
static void compare_as(const char *extreme, const char *name, al_runtime *runtime, const al_view *view, const al_settings *settings, int frames,
                       double bound, int shares)
{
    static picture p;
    double sums[2] = {0}, worst = 0;
    average(runtime, view, settings, frames, &p);
    readback s = readback_take(runtime);
    al_file *file = NULL;
    al_medium_field *field = NULL;
    if (s.fogs.fogs[0].cells[0]) {
        al_medium_info info;
        al_error error = {0};
        CHECK(al_file_open(grid_path(), NULL, &file, &error) == AL_OK && al_medium_read(file, &info, &error) == AL_OK &&
              al_medium_field_open(file, &info, &field, &error) == AL_OK);
        s.field = field;
    }
    double blocks[BLOCKS * 3][3] = {{0}};
    for (uint32_t i = 0; i < EDGE * EDGE; i++) {
        double light[3];
        integrate(&s, i, shares, light);
        for (uint32_t c = 0; c < 3; c++) {
            double *block = blocks[(i / EDGE / 8 * 2 + i % EDGE / 8) * 3 + c];
            block[0] += p.mean[3 * i + c];
            block[1] += light[c];
            block[2] += square(p.error[3 * i + c]);
            sums[0] += p.mean[3 * i + c];
            sums[1] += light[c];
        }
    }
    for (int i = 0; i < BLOCKS * 3; i++) {
        if (!(blocks[i][1] > 1e-30)) continue;
        worst = fmax(worst, fabs(blocks[i][0] / blocks[i][1] - 1));
        CHECK_NEAR(blocks[i][0] / blocks[i][1], 1, fmax(4 * sqrt(blocks[i][2]) / blocks[i][1], bound));
    }
    CHECK(s.surfel_count > 0 && sums[1] > 0);
    if (extreme)
        test_extreme(extreme, sums[0] / (EDGE * EDGE * 3), sums[1] / (EDGE * EDGE * 3), bound * sums[1] / (EDGE * EDGE * 3),
                     "surfaces into fog: mean radiance, %s; worst block %.2f %%", name, 100 * worst);
    else
        printf("| %s | %.2f %%, worst block %.2f %% (%u surfels) |\n", name, 100 * (sums[0] / sums[1] - 1), 100 * worst,
               s.surfel_count);
    readback_free(&s);
    al_medium_field_close(field);
    al_file_close(file);
}

/* All pairs in one level, so that only the samples' places on the rays are drawn. */
static const al_settings plain = {
    .pass = AL_PASS_SURFACE_SCATTERING, .surfel_pixels = 1.2f, .shell_levels = 1, .interval_count = 32, .blur_off = true};

static void compare(const char *extreme, const char *name, const room *r, double bound)
{
    al_runtime *runtime = open_room(r);
    al_view view = look(EDGE, EDGE, front, r->scale > 0 ? r->scale : 1);
    compare_as(extreme, name, runtime, &view, &plain, 12, bound, r->endless ? 640 : 64);
    al_runtime_destroy(runtime);
}

static slab grey(float sigma_s, float sigma_a, float g)
{
    return (slab){-1, 1, 1, {sigma_s, sigma_s, sigma_s}, {sigma_a, sigma_a, sigma_a}, g};
}

static void test_media(void)
{
    static const float sigmas[] = {5e-7f, 5e-4f, 0.5f, 5, 50, 5e3f};
    char name[96];
    for (size_t i = 0; i < sizeof sigmas / sizeof *sigmas; i++) {
        snprintf(name, sizeof name, "sigma_t times size %g", 2.0 * (double)sigmas[i]);
        slab fog = grey(0.75f * sigmas[i], 0.25f * sigmas[i], 0.2f);
        if (sigmas[i] > 1) fog.from = -3.05f, fog.to = -1.05f; /* behind the surfaces and the lamp, which light its face */
        compare(sigmas[i] < 1e-6f   ? "sigma_t times size 1e-6"
                : sigmas[i] < 1e-3f ? "sigma_t times size 1e-3"
                : sigmas[i] < 1e3f  ? "sigma_t times size 1 to 100"
                                    : "sigma_t times size 1e4",
                name, &(room){.slabs = {fog}, .count = 1}, 0.005);
    }
    compare("albedo 1", "albedo 1", &(room){.slabs = {grey(0.8f, 0, 0)}, .count = 1}, 0.005);
    compare("albedo 1 - 1e-6", "albedo 1 - 1e-6", &(room){.slabs = {grey(0.8f, 0.8e-6f, 0)}, .count = 1}, 0.005);
    compare(NULL, "albedo 1e-6", &(room){.slabs = {grey(0.8e-6f, 0.8f, 0)}, .count = 1}, 0.005);
    compare(NULL, "endless fog", &(room){.slabs = {grey(0.4f, 0.1f, 0.3f)}, .count = 1, .endless = true}, 0.005);
    compare(NULL, "extinction 20, 1 and 0.05 per metre in one fog",
            &(room){.slabs = {{-3.05f, -1.05f, 1, {16, 0.8f, 0.04f}, {4, 0.2f, 0.01f}, 0}}, .count = 1}, 0.008);
    compare(NULL, "extinction 500, 0.5 and 5e-4 per metre in one fog",
            &(room){.slabs = {{-3.05f, -1.05f, 1, {400, 0.4f, 4e-4f}, {100, 0.1f, 1e-4f}, 0}}, .count = 1}, 0.008);
    compare(NULL, "extinction 5000, 0.5 and 5e-5 per metre in one fog",
            &(room){.slabs = {{-3.05f, -1.05f, 1, {4e3f, 0.4f, 4e-5f}, {1e3f, 0.1f, 1e-5f}, 0}}, .count = 1}, 0.008);
    compare("g 0.99", "g 0.99", &(room){.slabs = {grey(0.5f, 0.1f, 0.99f)}, .count = 1}, 0.005);
    compare("g -0.99", "g -0.99", &(room){.slabs = {grey(0.5f, 0.1f, -0.99f)}, .count = 1}, 0.005);
    compare(NULL, "two coloured fogs in one place, g 0.95 and -0.95",
            &(room){.slabs = {{-1, 1, 1, {0.6f, 0.1f, 0}, {0, 0.1f, 0.1f}, 0.95f},
                              {-1, 1, 1, {0.1f, 0.1f, 0.5f}, {0.2f, 0, 0}, -0.95f}},
                    .count = 2},
            0.008);
    room eight = {.count = 8};
    for (int i = 0; i < 8; i++) {
        eight.slabs[i] = grey(0.1f + 0.05f * (float)i, 0.1f, 0.2f * (float)i - 0.7f);
        eight.slabs[i].from = -1 + 0.2f * (float)i;
        eight.slabs[i].to = eight.slabs[i].from + 0.3f;
        eight.slabs[i].sigma_s[i % 3] = 0;
    }
    compare(NULL, "8 coloured fogs that overlap, g -0.7 to 0.7", &eight, 0.008);
}

/* What scatters in a dense voxel is its skin, thinner than a step of the march and a cell of the second leg's grid: the
 * brighter the denser, here within what was measured, rounded up: at most as bright as without its own skin before it on
 * the second leg, 1 + ratio of the two legs' cosines, some three times. The haze beside it is right, as far as the
 * second leg's steps find the voxel: measured at 64 of them too. */
static void test_grids(void)
{
    slab fog = grey(0.4f, 0.1f, 0.3f);
    compare("one voxel", "a grid of one voxel", &(room){.slabs = {fog}, .count = 1, .voxels = 1, .dense = 1}, 0.005);
    compare("one voxel", "a grid of one voxel that holds up to the bounds",
            &(room){.slabs = {fog}, .count = 1, .voxels = 1, .dense = 1, .extended = true}, 0.005);
    compare(NULL, "5^3 voxels of one density", &(room){.slabs = {fog}, .count = 1, .voxels = 5, .dense = 1, .density = 1}, 0.005);
    static const struct {
        uint32_t voxels, steps;
        float dense, haze;
        double bound;
    } cases[] = {{5, 4, 10, 0, 0.015},  {5, 4, 100, 0, 0.06},  {5, 4, 1e3f, 0, 0.3},     {5, 4, 1e6f, 0, 2},
                 {5, 4, 1e6f, 1, 0.12}, {5, 64, 1e6f, 1, 0.06}, {25, 4, 1e6f, 1, 0.02}, {25, 64, 1e6f, 1, 0.01}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        room r = {.slabs = {fog}, .count = 1, .voxels = cases[i].voxels, .dense = cases[i].dense, .density = cases[i].haze,
                  .lamp = {-0.2f, 0.9f, 0.8f}};
        char name[96];
        snprintf(name, sizeof name, "a voxel of %g among %u^3 of %g, `--second-leg-steps %u`", (double)r.dense, r.voxels,
                 (double)r.density, cases[i].steps);
        al_settings settings = plain;
        settings.surfel_pixels = 2.4f;
        settings.second_leg_steps = cases[i].steps;
        al_runtime *runtime = open_room(&r);
        al_view view = look(EDGE, EDGE, front, 1);
        compare_as(r.dense >= 1e6f && r.density > 0 ? "one voxel of 1e6" : NULL, name, runtime, &view, &settings, 8, cases[i].bound, 32);
        al_runtime_destroy(runtime);
    }
}

static void test_scales(void)
{
    room r = {.slabs = {grey(0.5f, 0.1f, 0.3f)}, .count = 1};
    r.scale = 1e-4f;
    compare("scene of 1e-4 m", "a scene of 1e-4 m", &r, 0.005);
    r.scale = 1e4f;
    compare("scene of 1e4 m", "a scene of 1e4 m", &r, 0.005);
    r.scale = 1;
    r.light = 1e-6f;
    compare("radiosity 1e-6", "a lamp of 1e-6", &r, 0.005);
    r.light = 1e6f;
    compare("radiosity 1e6", "a lamp of 1e6", &r, 0.005);
    r.light = 1;
    r.lamp[0] = 0.3f, r.lamp[1] = -0.1f, r.lamp[2] = 0.2f;
    compare("light on a surface", "a lamp on a surface", &r, 0.005);
}

/* --- views, knobs, sizes --- */

static void compare_view(const char *extreme, const char *name, al_runtime *runtime, const al_view *view, const al_settings *changes, int frames)
{
    al_settings settings = plain;
    if (changes->shell_levels) settings.shell_levels = changes->shell_levels;
    if (changes->interval_count) settings.interval_count = changes->interval_count;
    settings.shell_radius_m = changes->shell_radius_m;
    compare_as(extreme, name, runtime, view, &settings, frames, 0.005, 128);
}

static al_view ortho(float scale)
{
    al_view view = stage_ortho(EDGE, EDGE, 1.2f * scale);
    view.view[14] *= scale;
    view.projection[10] /= scale;
    return view;
}

static void test_views(void)
{
    room r = {.slabs = {grey(0.5f, 0.1f, 0.3f)}, .count = 1};
    al_runtime *runtime = open_room(&r);
    al_view view = look(EDGE, EDGE, (float[3]){0, 0.2f, 0.9f}, 1);
    compare_view("camera inside the medium", "camera inside the fog", runtime, &view, &(al_settings){0}, 16);
    view = look(EDGE, EDGE, front, 1);
    compare_view(NULL, "7 levels", runtime, &view, &(al_settings){.shell_levels = 7, .shell_radius_m = 0.03f}, 64);
    compare_view(NULL, "4 interval knots", runtime, &view, &(al_settings){.interval_count = 4}, 64);
    view = ortho(1);
    compare_view(NULL, "orthographic view", runtime, &view, &(al_settings){0}, 16);
    al_runtime_destroy(runtime);
    for (int i = 0; i < 2; i++) {
        r.scale = i ? 1e4f : 1e-4f;
        runtime = open_room(&r);
        view = ortho(r.scale);
        compare_view(i ? "scene of 1e4 m" : "scene of 1e-4 m", i ? "orthographic view of 1e4 m" : "orthographic view of 1e-4 m", runtime, &view, &(al_settings){0}, 16);
        al_runtime_destroy(runtime);
    }
}

/* Strips of the largest width and height, in tiles. Light that the fog scatters is smooth: from the last column or row of
 * a tile to the first of the next it changes by no more than between others near by, or half as much more. */
static void test_tiles(void)
{
    enum { NEAR = 64 };
    static const struct {
        uint32_t width, height, part; /* pixels of a tile that are kept, along the strip: runtime/frame.c, part_length */
        bool visibility;
    } cases[] = {{2112, 64, 1088, false}, {2112, 64, 1088, true}, {8192, 64, 1664, false}, {64, 8192, 704, false}};
    room r = {.slabs = {grey(0.5f, 0.1f, 0.3f)}, .count = 1};
    al_runtime *runtime = open_room(&r);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        bool wide = cases[i].width > cases[i].height;
        uint32_t along = wide ? cases[i].width : cases[i].height, across = wide ? cases[i].height : cases[i].width;
        size_t step = wide ? 3 : 3 * (size_t)across, row = wide ? 3 * (size_t)along : 3, count = (size_t)along * across * 3;
        al_view view = stage_ortho(cases[i].width, cases[i].height, 0.9f);
        view.projection[wide ? 5 : 0] *= (float)along / (float)across;
        const al_settings settings = {.pass = AL_PASS_SURFACE_SCATTERING,
                                      .surfel_pixels = 60 * (float)along / 2112,
                                      .visibility = cases[i].visibility};
        double worst[2] = {0, 1}; /* at a border, and the largest near it: rms of all across */
        float *p = stage_draw(runtime, &view, &settings, 0);
        CHECK(p && stage_bad(p, count) == 0 && stage_sum(p, count) > 0);
        CHECK((wide ? runtime->targets.radiance.width : runtime->targets.radiance.height) < along);
        for (size_t border = cases[i].part; p && border < along; border += cases[i].part) {
            double jumps[2] = {0};
            for (size_t x = border - NEAR; x <= border + NEAR && x < along; x++) {
                double sum = 0;
                for (size_t y = 0; y < across; y++) sum += square(p[x * step + y * row] / p[(x - 1) * step + y * row] - 1);
                jumps[x != border] = fmax(jumps[x != border], sqrt(sum / across));
            }
            CHECK(jumps[0] <= 1.5 * jumps[1]);
            if (jumps[0] * worst[1] > worst[0] * jumps[1]) memcpy(worst, jumps, sizeof worst);
        }
        printf("| %stiles of %u x %u | light changes by %.2f %% from one to the other, by at most %.2f %% near by |\n",
               cases[i].visibility ? "with `--visibility`, " : "", cases[i].width, cases[i].height, 100 * worst[0], 100 * worst[1]);
        free(p);
    }
    al_runtime_destroy(runtime);
}

/* Every pass of both ways, by every kind of weights: nothing negative, nothing that is not finite. Answers the light. */
static double check_finite(al_runtime *runtime, const al_view *view)
{
    double sum = 0;
    size_t count = (size_t)view->width * view->height * 3;
    for (int i = 0; i < 6; i++) {
        const al_settings settings = {.pass = i == 5 ? AL_PASS_SHELLS : i == 4 ? AL_PASS_COMPOSITE : AL_PASS_SURFACE_SCATTERING,
                                      .visibility = i == 3, .interval_weights = i < 3 ? (al_interval_weights)i : 0};
        float *pixels = stage_draw(runtime, view, &settings, 0);
        CHECK(pixels && stage_bad(pixels, count) == 0);
        if (pixels && !i) sum = stage_sum(pixels, count) / (double)count;
        free(pixels);
    }
    return sum;
}

static void test_sizes(void)
{
    static const uint32_t sizes[][2] = {{1, 1}, {1, 37}, {61, 1}, {33, 17}};
    room r = {.slabs = {grey(0.5f, 0.1f, 0.3f)}, .count = 1};
    al_runtime *runtime = open_room(&r);
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        al_view view = look(sizes[i][0], sizes[i][1], front, 1);
        const int failures = test_failures;
        double light = check_finite(runtime, &view);
        if (i == 0)
            test_extreme("1 x 1 pixels", test_failures - failures, 0, 0,
                         "surfaces into fog: pictures with a pixel negative or not finite, of 6 kinds, mean %.4f", light);
        else
            printf("| %u x %u pixels | finite, mean %.4f |\n", sizes[i][0], sizes[i][1], light);
        CHECK(light > 0);
    }
    al_runtime_destroy(runtime);
}

/* --- wrong input --- */

static const al_plan_row *plan_row(al_runtime *runtime, const char *step)
{
    uint32_t count;
    const al_plan_row *rows = al_runtime_plan(runtime, &count);
    for (uint32_t i = 0; i < count; i++)
        if (!strcmp(rows[i].step, step)) return &rows[i];
    CHECK(!"no such row");
    return rows;
}

/* Nothing to scatter, to light or to be lit: black, and the plan says why. */
static void test_nothing(void)
{
    const slab fog = grey(0.5f, 0.1f, 0.3f);
    const struct {
        const char *name, *why;
        room room;
    } cases[] = {{"an empty scene", "no fog takes light from surfaces", {.no_floor = true, .no_lamp = true}},
                 {"no light, no emission", "no light and no emission", {.slabs = {fog}, .count = 1, .no_lamp = true}},
                 {"no surface", "no opaque object sends light into the fog", {.slabs = {fog}, .count = 1, .no_floor = true}}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        al_runtime *runtime = open_room(&cases[i].room);
        al_view view = look(EDGE, EDGE, front, 1);
        CHECK(check_finite(runtime, &view) == 0);
        const al_plan_row *row = plan_row(runtime, "surface-scattering");
        CHECK(!row->needed && row->bytes == 0 && !strcmp(row->why, cases[i].why));
        printf("| %s | black; plan: %s |\n", cases[i].name, row->why);
        al_runtime_destroy(runtime);
    }
    const struct {
        const char *name;
        room room;
    } dark[] = {{"albedo 0", {.slabs = {grey(0, 0.5f, 0)}, .count = 1}},
                {"density 0", {.slabs = {fog}, .count = 1, .voxels = 5}}};
    for (size_t i = 0; i < sizeof dark / sizeof *dark; i++) {
        al_runtime *runtime = open_room(&dark[i].room);
        al_view view = look(EDGE, EDGE, front, 1);
        const uint32_t voxels = dark[i].room.voxels;
        test_extreme(dark[i].name, check_finite(runtime, &view), 0, 0, "surfaces into fog: mean radiance%s",
                     voxels ? ", a grid of 5^3 zeros (no pass runs)" : "");
        const al_plan_row *row = plan_row(runtime, "surface-scattering");
        if (voxels) CHECK(row->bytes == 0 && row->seconds == 0 && al_runtime_surfels(runtime) == 0);
        al_runtime_destroy(runtime);
    }
    room behind = {.slabs = {fog}, .count = 1};
    behind.slabs[0].from = 4, behind.slabs[0].to = 5;
    al_runtime *runtime = open_room(&behind);
    al_view view = look(EDGE, EDGE, front, 1);
    CHECK(check_finite(runtime, &view) == 0);
    printf("| fog outside the view | black |\n");
    al_runtime_destroy(runtime);
}

/* In the plane of a wall, behind it, in the fog's corner, in the lamp, on a surfel. */
static void test_eyes(void)
{
    float eyes[][3] = {{0, -0.8f, 0.3f}, {0, -0.9f, 0}, {0.3f, -0.1f, 0.2f}, {1, 1, 1}, {0.1f, 0.5f, 0}, {0, 0, 0}};
    enum { COUNT = sizeof eyes / sizeof *eyes };
    const int failures = test_failures;
    room r = {.slabs = {grey(0.5f, 0.1f, 0.3f)}, .count = 1};
    al_runtime *runtime = open_room(&r);
    for (int i = 0; i < COUNT; i++) {
        al_view view = look(EDGE, EDGE, eyes[i], 1);
        double away = INFINITY;
        for (int go = 0; i + 1 == COUNT && go < 8; go++) { /* surfels stay where they are when there are more of them */
            free(stage_draw(runtime, &view, &plain, 0));
            readback s = readback_take(runtime);
            const surfel *nearest = s.surfels;
            away = INFINITY;
            for (uint32_t j = 0; j < s.surfel_count; j++) {
                double squared = 0;
                for (int k = 0; k < 3; k++) squared += square((double)s.surfels[j].place[k] - eyes[i][k]);
                if (squared < away) away = squared, nearest = &s.surfels[j];
            }
            if (away > 0) memcpy(eyes[i], nearest->place, 12);
            readback_free(&s);
            view = look(EDGE, EDGE, eyes[i], 1);
            if (away == 0) break;
        }
        if (i + 1 == COUNT) CHECK(away == 0);
        CHECK(check_finite(runtime, &view) >= 0);
    }
    test_extreme("camera inside a sample", test_failures - failures, 0, 0,
                 "surfaces into fog: pictures with a pixel negative or not finite, eyes on a surfel, in the lamp, in a wall's plane, behind "
                 "it, in a corner of the fog");
    al_runtime_destroy(runtime);
}

/* More surfels than they may be: coarser, said in the plan, and right for what they are. */
static void test_limit(void)
{
    room r = {.slabs = {grey(0.5f, 0.1f, 0.3f)}, .count = 1};
    al_runtime *runtime = open_room(&r);
    al_view view = look(EDGE, EDGE, front, 1);
    al_settings settings = plain;
    settings.surfel_pixels = 0.1f;
    settings.surfel_limit = 64;
    compare_as(NULL, "at most 64 surfels where 7500 were wanted", runtime, &view, &settings, 16, 0.005, 96);
    uint64_t count = al_runtime_surfels(runtime);
    CHECK(count > 32 && count <= 64 && runtime->surfels.cloud.size <= 64 * AL_SURFEL_SIZE);
    CHECK(strstr(plan_row(runtime, "surfels")->why, "larger surfels, to stay below their limit"));
    al_runtime_destroy(runtime);
}

/* As many surfels as there may be, and some more wanted. */
static void test_million(void)
{
    enum { WIDE = 200 };
    room r = {.slabs = {grey(0.5f, 0.1f, 0.3f)}, .count = 1};
    r.slabs[0].half = r.slabs[0].to = 0.25f, r.slabs[0].from = -0.25f; /* few pixels: what takes long are splats */
    al_runtime *runtime = open_room(&r);
    al_view view = look(WIDE, WIDE, front, 1);
    const al_settings settings = {.pass = AL_PASS_SURFACE_SCATTERING, .surfel_pixels = 0.1f, .shell_levels = 7};
    float *pixels = stage_draw(runtime, &view, &settings, 0);
    CHECK(pixels && stage_bad(pixels, WIDE * WIDE * 3) == 0 && stage_sum(pixels, WIDE * WIDE * 3) > 0);
    uint64_t count = al_surfels_count(runtime), bytes = runtime->surfels.cloud.size;
    CHECK(count > 950000 && count <= 1 << 20 && bytes <= (uint64_t)(1 << 20) * AL_SURFEL_SIZE);
    CHECK(strstr(plan_row(runtime, "surfels")->why, "larger surfels, to stay below their limit"));
    printf("| more surfels wanted than the limit of 2^20 | finite, %llu surfels, larger ones, which the plan says; %.0f MiB |\n",
           (unsigned long long)count, (double)bytes / 1048576);
    free(pixels);
    al_runtime_destroy(runtime);
}

/* A new runtime: the same frame, to the last bit. */
static void test_repeat(void)
{
    room r = {.slabs = {grey(0.5f, 0.1f, 0.3f)}, .count = 1};
    float *same[2][2];
    for (int i = 0; i < 2; i++) {
        al_runtime *runtime = open_room(&r);
        al_view view = look(EDGE, EDGE, front, 1);
        for (int visibility = 0; visibility < 2; visibility++) {
            const al_settings settings = {.pass = AL_PASS_SURFACE_SCATTERING, .visibility = visibility > 0};
            same[i][visibility] = stage_draw(runtime, &view, &settings, 0);
            CHECK(same[i][visibility] && stage_sum(same[i][visibility], EDGE * EDGE * 3) > 0);
        }
        al_runtime_destroy(runtime);
    }
    for (int visibility = 0; visibility < 2; visibility++) {
        CHECK(same[0][visibility] && same[1][visibility] &&
              !memcmp(same[0][visibility], same[1][visibility], EDGE * EDGE * 3 * sizeof(float)));
        for (int i = 0; i < 2; i++) free(same[i][visibility]);
    }
    printf("| the same frame of two runtimes | the same bytes |\n");
}

/* 64 lamps in one place are one of their sum, but for rounding; none is black. */
static void test_lamps(void)
{
    room r = {.slabs = {grey(0.5f, 0.1f, 0.3f)}, .count = 1};
    al_settings still = plain;
    still.interval_jitter_off = true;
    still.shadows_off = true; /* maps are coarser the more lamps there are */
    float *pictures[2];
    al_runtime *runtime = NULL;
    for (int i = 0; i < 2; i++) {
        runtime = open_room(&r);
        al_view view = look(EDGE, EDGE, front, 1);
        al_scene *scene = al_runtime_scene(runtime);
        for (int c = 0; c < 3; c++) scene->lights[0].intensity[c] = i ? 1 : 64;
        al_light *one = scene->lights, lamps[64];
        for (int k = 0; k < 64; k++) lamps[k] = *one;
        if (i) scene->lights = lamps, scene->light_count = 64;
        pictures[i] = stage_draw(runtime, &view, &still, 0);
        scene->lights = one;
        scene->light_count = i ? 0 : 1;
        if (i) test_extreme("0 lights", check_finite(runtime, &view), 0, 0, "surfaces into fog: mean radiance");
        scene->light_count = 1;
        al_runtime_destroy(runtime);
    }
    double worst = 0;
    for (int i = 0; i < EDGE * EDGE * 3 && pictures[0] && pictures[1]; i++)
        worst = fmax(worst, fabs(pictures[1][i] - pictures[0][i]) / fmax(pictures[0][i], 1e-30));
    CHECK(pictures[0] && stage_sum(pictures[0], EDGE * EDGE * 3) > 0);
    test_extreme("64 lights", worst, 0, 64 * 0x1p-23,
                 "surfaces into fog: 64 lamps in one place against one of their sum, largest relative difference");
    free(pictures[0]);
    free(pictures[1]);
}

/* Light is linear: a picture of one level and no drawn numbers, for light over 1e12, shifted by powers of two to the last
 * bit, by others within the rounding of some thousand additions, 2^-24 each, which add up like a walk. */
static void test_linear(void)
{
    static const float factors[] = {1, 0x1p-20f, 0x1p20f, 1e-6f, 1e6f};
    al_settings still = plain;
    still.interval_jitter_off = true;
    for (int emission = 0; emission < 2; emission++) {
        float *one = NULL;
        double worst[5] = {0};
        for (int i = 0; i < 5; i++) {
            room r = {.slabs = {grey(0.5f, 0.1f, 0.3f)}, .count = 1, .light = factors[i]};
            if (emission) r.no_lamp = true, r.glow = factors[i];
            al_runtime *runtime = open_room(&r);
            al_view view = look(EDGE, EDGE, front, 1);
            float *pixels = stage_draw(runtime, &view, &still, 0);
            CHECK(pixels && stage_bad(pixels, EDGE * EDGE * 3) == 0 && stage_sum(pixels, EDGE * EDGE * 3) > 0);
            for (int j = 0; i && one && pixels && j < EDGE * EDGE * 3; j++)
                worst[i] = fmax(worst[i], fabs(pixels[j] / (double)factors[i] / fmax(one[j], 1e-30) - 1));
            if (i)
                free(pixels);
            else
                one = pixels;
            al_runtime_destroy(runtime);
        }
        CHECK(worst[1] == 0 && worst[2] == 0);
        for (int i = 3; i < 5; i++)
            test_extreme(i == 3 ? "radiosity 1e-6" : "radiosity 1e6", worst[i], 0, 64 * 0x1p-24,
                         "surfaces into fog: %s times that, largest relative difference (times 2^-20, 2^20: the same bits)",
                         emission ? "emission" : "a lamp");
        free(one);
    }
}

/* Each knob out of its range: refused in a line that names it. */
static void test_settings(void)
{
    const struct {
        const char *words;
        al_settings settings;
    } cases[] = {
        {"interval knots", {.interval_count = 3}},
        {"interval knots", {.interval_count = 33}},
        {"march step", {.march_voxels = NAN}},
        {"march step", {.march_voxels = 1000}},
        {"surfels of", {.surfel_pixels = 0.01f}},
        {"surfels of", {.surfel_pixels = NAN}},
        {"at most 63 surfels", {.surfel_limit = 63}},
        {"at most 4194305 surfels", {.surfel_limit = (1 << 22) + 1}},
        {"shell epsilon", {.shell_epsilon_w_m2_sr = -1}},
        {"shell epsilon", {.shell_epsilon_w_m2_sr = INFINITY}},
        {"shell radius", {.shell_radius_m = 1e-7f}},
        {"8 shell levels", {.shell_levels = 8}},
        {"number 6 is shown of 6", {.pass = AL_PASS_SHELLS, .shown_level = 6}},
        {"blur of 5 mips", {.blur_mips = 5}},
        {"65 steps of the second leg", {.second_leg_steps = 65}},
        {"bounce of 65 samples", {.bounce_samples = 65}},
        {"radius 1e+07 m", {.bounce_radius_m = 1e7f}},
        {"overlap 0.5", {.bounce_overlap = 0.5f}},
        {"interval weights", {.interval_weights = AL_INTERVAL_WEIGHTS_COUNT}},
        {"no such pass", {.pass = AL_PASS_COUNT}},
    };
    room r = {.slabs = {grey(0.5f, 0.1f, 0.3f)}, .count = 1};
    al_runtime *runtime = open_room(&r);
    al_view view = look(EDGE, EDGE, front, 1);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        al_error error = {0};
        CHECK(al_runtime_draw(runtime, &view, &cases[i].settings, 0, 0, &error) == AL_USAGE);
        CHECK(glGetError() == GL_NO_ERROR); /* without a window framebuffer 0 cannot even be cleared */
        if (!strstr(error.message, cases[i].words)) printf("says: %s\n", error.message);
        CHECK(strstr(error.message, cases[i].words) && !strchr(error.message, '\n'));
    }
    printf("| each of %zu knobs out of its range | refused in one line that names it |\n", sizeof cases / sizeof *cases);
    al_runtime_destroy(runtime);
}

static GLenum guilty(void)
{
    return GL_GUILTY_CONTEXT_RESET;
}

/* A context that is lost, as far as its status says: an error, not a picture. */
static void test_lost(void)
{
    room r = {.slabs = {grey(0.5f, 0.1f, 0.3f)}, .count = 1};
    al_runtime *runtime = open_room(&r);
    al_view view = look(EDGE, EDGE, front, 1);
    PFNGLGETGRAPHICSRESETSTATUSPROC before = epoxy_glGetGraphicsResetStatus;
    al_error error = {0};
    epoxy_glGetGraphicsResetStatus = guilty;
    CHECK(al_runtime_draw(runtime, &view, NULL, 0, 0, &error) == AL_NO_DEVICE);
    CHECK(strstr(error.message, "context is lost"));
    CHECK(al_runtime_update(runtime, 0, NULL, &error) == AL_NO_DEVICE);
    epoxy_glGetGraphicsResetStatus = before;
    printf("| context lost, as glGetGraphicsResetStatus answers | %s |\n", error.message);
    CHECK(check_finite(runtime, &view) > 0);
    al_runtime_destroy(runtime);
}

int main(void)
{
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    folder = stage_folder();
    if (!folder) return test_skip("no temporary folder");
    test_media();
    test_grids();
    test_scales();
    test_views();
    test_tiles();
    test_sizes();
    test_nothing();
    test_eyes();
    test_limit();
    test_million();
    test_repeat();
    test_lamps();
    test_linear();
    test_settings();
    test_lost();
    return test_end();
}
