/* Light of surfaces that the fog scatters to the eye: the view's transmittance interval map against its closed form,
 * the mean over many deals against the sum over all pairs of surfel and sample in double precision, what epsilon
 * leaves out, and that the ways of weighing samples agree. */
#include <epoxy/gl.h>
#include <stdlib.h>
#include <string.h>

#include "../../runtime/state.h"
#include "../test.h"
#include "airlight/formulas.h"
#include "sphere.h"
#include "stage.h"

enum { SAMPLES = 15, MAP_EDGE = 9 };

static const char *folder;

/* Fogs as boxes along z in a scene with one white square below them, lit by a point light. */
typedef struct slab {
    float from, to; /* z of the box; x and y from -half to half */
    float half, sigma_s[3], sigma_a[3], g;
} slab;

static al_runtime *open_slabs(const slab *slabs, uint32_t count, const float light[3])
{
    al_runtime *runtime = NULL;
    al_error error = {0};
    sphere_scene s;
    al_fog fogs[AL_FOG_LIMIT] = {{0}};
    al_medium media[AL_FOG_LIMIT] = {{0}};
    sphere_scene_begin(&s);
    for (uint32_t i = 0; i < count; i++) {
        fogs[i] = (al_fog){.medium = i, .bounded = true, .density = 1, .asset = ""};
        media[i] = (al_medium){.name = "", .g = slabs[i].g};
        for (int k = 0; k < 3; k++) {
            fogs[i].bounds_min_m[k] = k == 2 ? slabs[i].from : -slabs[i].half;
            fogs[i].bounds_max_m[k] = k == 2 ? slabs[i].to : slabs[i].half;
            media[i].sigma_s_per_m[k] = slabs[i].sigma_s[k];
            media[i].sigma_a_per_m[k] = slabs[i].sigma_a[k];
        }
    }
    s.scene.fogs = fogs;
    s.scene.fog_count = s.scene.medium_count = count;
    s.scene.media = media;
    s.scene.baked = (al_baked_light){"", ""};
    sphere_scene_add_floor(&s, 2, (float[3]){0, -0.8f, 0});
    sphere_scene_add_floor(&s, 0.5f, (float[3]){0.3f, -0.1f, 0.2f});
    sphere_scene_add_light(&s, AL_LIGHT_POINT, light, 1);
    CHECK(sphere_scene_write(folder, &s));
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK);
    CHECK(stage_load(runtime, folder));
    sphere_scene_end(&s);
    return runtime;
}

/* The interval map of the last frame, as distances from the eye; ends: [4] a pixel. */
typedef struct interval_map {
    uint32_t width, height;
    float *ends;     /* [height][width][4] */
    double *samples; /* [height][width][SAMPLES], m */
    double *bounds;  /* likewise: half of what the next byte is apart, which rounding cannot exceed */
} interval_map;

static interval_map read_map(const al_runtime *runtime)
{
    const al_shells *shells = &runtime->shells;
    interval_map map = {.width = shells->ends.width, .height = shells->ends.height};
    size_t count = (size_t)map.width * map.height;
    uint32_t(*words)[4] = malloc(count * 16);
    map.ends = malloc(count * 16);
    map.samples = malloc(count * SAMPLES * sizeof *map.samples);
    map.bounds = malloc(count * SAMPLES * sizeof *map.bounds);
    glGetTextureImage(shells->ends.id, 0, GL_RGBA, GL_FLOAT, (GLsizei)(count * 16), map.ends);
    glGetTextureImage(shells->steps.id, 0, GL_RGBA_INTEGER, GL_UNSIGNED_INT, (GLsizei)(count * 16), words);
    for (size_t i = 0; i < count; i++) {
        double t = map.ends[4 * i];
        for (int k = 0; k < SAMPLES; k++) {
            double root = words[i][k / 4] >> 8 * (k % 4) & 255, unit = map.ends[4 * i + 1];
            t += root * root * unit;
            map.samples[i * SAMPLES + k] = t;
            map.bounds[i * SAMPLES + k] = (root + 0.5) * unit;
        }
    }
    free(words);
    return map;
}

static void free_map(interval_map *map)
{
    free(map->ends);
    free(map->samples);
    free(map->bounds);
}

/* Homogeneous medium of length L that starts at d1, n = 16: distances at which the transmittance has fallen in
 * n - 1 equal steps, xi = 0. By formula, double precision. */
static const struct {
    double start, sigma_t, length, depths[SAMPLES];
} oracle[] = {
    {2, 0.5, 4, {2.11874498033, 2.24498764304, 2.37973900606, 2.5242294615, 2.67997722598, 2.8488857647,
                 3.03338627855, 3.23665284011, 3.46293972717, 3.71813504489, 4.01072186609, 4.35357001888,
                 4.76760364305, 5.29034161426, 6}},
    {0, 3, 2, {0.0229386111441, 0.0475731899487, 0.0741746850658, 0.10308465662, 0.134742166471,
               0.169724828731, 0.208814033318, 0.253103732467, 0.304193166254, 0.364555677426,
               0.438320799753, 0.533190578306, 0.666306516778, 0.891312075289, 2}},
};

/* One cell, exact but for the bytes' rounding and the last digits. Cut into two boxes
 * that meet, marched, the same but for the fog that a cell across the joint blends: nothing, both are alike. */
static void check_oracle(void)
{
    const al_settings settings = {
        .pass = AL_PASS_SURFACE_SCATTERING, .interval_jitter_off = true, .surfel_pixels = 4.6f};
    for (int row = 0; row < 2; row++)
        for (uint32_t parts = 1; parts <= 2; parts++) {
            float sigma = (float)oracle[row].sigma_t, start = (float)oracle[row].start,
                  length = (float)oracle[row].length;
            float front = 3 - start, cut = parts == 1 ? front - length : front - 0.3f * length;
            slab slabs[2] = {{cut, front, 3, {sigma, sigma, sigma}, {0, 0, 0}, 0},
                             {front - length, cut, 3, {sigma, sigma, sigma}, {0, 0, 0}, 0}};
            al_runtime *runtime = open_slabs(slabs, parts, (float[3]){0, 0.5f, 0});
            al_view view = stage_look(MAP_EDGE, MAP_EDGE, (float[3]){0, 0, 3}, (float[3]){0, 0, 0}, 0.01f);
            free(stage_draw(runtime, &view, &settings, 0));
            interval_map map = read_map(runtime);
            size_t middle = MAP_EDGE / 2 * MAP_EDGE + MAP_EDGE / 2;
            const float *ends = map.ends + 4 * middle;
            CHECK_NEAR(ends[0], oracle[row].start, 1e-6);
            CHECK_NEAR(ends[2], -expm1(-oracle[row].sigma_t * oracle[row].length), 1e-6);
            for (int k = 0; k < SAMPLES; k++)
                CHECK_NEAR(map.samples[middle * SAMPLES + k], oracle[row].depths[k],
                           map.bounds[middle * SAMPLES + k] + 2e-5);
            free_map(&map);
            al_runtime_destroy(runtime);
        }
}

/* Two thin slabs a thousand of their thicknesses apart: more than 255 march steps between samples. Those of the
 * second slab must not move: by a 255th of the gap at most, as everywhere. */
static void check_gap(void)
{
    const al_settings settings = {
        .pass = AL_PASS_SURFACE_SCATTERING, .interval_jitter_off = true, .surfel_pixels = 4.6f};
    const slab slabs[2] = {{0, 0.01f, 3, {30, 30, 30}, {0, 0, 0}, 0}, {-10, -9.99f, 3, {30, 30, 30}, {0, 0, 0}, 0}};
    al_runtime *runtime = open_slabs(slabs, 2, (float[3]){0, 0.5f, 0});
    al_view view = stage_look(MAP_EDGE, MAP_EDGE, (float[3]){0, 0, 3}, (float[3]){0, 0, 0}, 0.01f);
    free(stage_draw(runtime, &view, &settings, 0));
    interval_map map = read_map(runtime);
    size_t middle = MAP_EDGE / 2 * MAP_EDGE + MAP_EDGE / 2;
    double total = -expm1(-0.6), unit = map.ends[4 * middle + 1];
    CHECK_NEAR(map.ends[4 * middle + 2], total, 1e-5);
    CHECK_NEAR(unit, 10 / 65025.0, 1e-3 / 255);
    for (int k = 0; k < SAMPLES; k++) {
        double tau = -log1p(-total * (k + 1) / SAMPLES);
        double expected = tau < 0.3 ? 2.99 + tau / 30 : 12.99 + (tau - 0.3) / 30;
        /* The march has at most 512 cells and blends what lies in one of them. */
        CHECK(map.bounds[middle * SAMPLES + k] < 256 * unit);
        CHECK_NEAR(map.samples[middle * SAMPLES + k], expected, map.bounds[middle * SAMPLES + k] + 10.0 / 512 + 1e-5);
    }
    free_map(&map);
    al_runtime_destroy(runtime);
}

/* --- the sum over all pairs --- */

typedef struct surfel {
    float place[4], facing[4], front[4], back[4];
    uint32_t edges[4];
} surfel;

static surfel *read_surfels(const al_runtime *runtime, uint32_t *count)
{
    *count = (uint32_t)al_surfels_count(runtime);
    surfel *surfels = malloc((*count + 1) * sizeof *surfels);
    glGetNamedBufferSubData(runtime->surfels.cloud.id, 0, (GLsizeiptr)(*count * sizeof *surfels), surfels);
    return surfels;
}

/* What surfel s adds to a sample at `place` that weighs 1: radiance towards -direction. */
static double pair_light(const surfel *s, const double place[3], const double direction[3], double g, int channel,
                         double sigma_t)
{
    double path[3], squared = 0, cosine = 0, turn = 0;
    for (int k = 0; k < 3; k++) {
        path[k] = place[k] - s->place[k];
        squared += path[k] * path[k];
        cosine += path[k] * s->facing[k];
        turn -= path[k] * direction[k];
    }
    double distance = sqrt(squared), angle = al_disc_angle(s->place[3], fabs(cosine), squared);
    return (cosine > 0 ? s->front : s->back)[channel] * angle * al_phase(g, turn / distance) *
           exp(-sigma_t * distance);
}

static void view_ray(const al_frame_block *frame, double x, double y, double origin[3], double direction[3])
{
    double length = 0;
    for (int k = 0; k < 3; k++) {
        origin[k] = frame->ray[0][k] + x * frame->ray[1][k] + y * frame->ray[2][k];
        direction[k] = frame->ray[3][k] + x * frame->ray[4][k] + y * frame->ray[5][k];
        length += direction[k] * direction[k];
    }
    for (int k = 0; k < 3; k++) direction[k] /= sqrt(length);
}

static al_frame_block read_frame(const al_runtime *runtime)
{
    al_frame_block frame;
    glGetNamedBufferSubData(runtime->frame_block.id, 0, sizeof frame, &frame);
    return frame;
}

/* One channel of the sum over all surfels and samples: [height][width]. The fog of one albedo and g covers everything. */
static double *sum_pairs(const al_runtime *runtime, double albedo, double g, double sigma_t, int channel)
{
    interval_map map = read_map(runtime);
    al_frame_block frame = read_frame(runtime);
    uint32_t count;
    surfel *surfels = read_surfels(runtime, &count);
    double *image = calloc((size_t)map.width * map.height, sizeof *image);
    for (uint32_t i = 0; i < map.width * map.height; i++) {
        double origin[3], direction[3], place[3];
        view_ray(&frame, i % map.width + 0.5, i / map.width + 0.5, origin, direction);
        if (map.ends[4 * i + 2] <= 0) continue;
        for (int k = 0; k < SAMPLES; k++) {
            double t = map.samples[i * SAMPLES + k], sum = 0;
            for (int j = 0; j < 3; j++) place[j] = origin[j] + t * direction[j];
            for (uint32_t s = 0; s < count; s++)
                if (surfels[s].front[channel] > 0 || surfels[s].back[channel] > 0)
                    sum += pair_light(&surfels[s], place, direction, g, channel, sigma_t);
            image[i] += sum * albedo * map.ends[4 * i + 2] / SAMPLES;
        }
    }
    free(surfels);
    free_map(&map);
    return image;
}

enum { EDGE = 32, DEALS = 256, BLOCK = 16 };

static double square(double x)
{
    return x * x;
}

/* Right as random figures are: the mean squared deviation in units of the standard error below 2, means over 16 x 16
 * blocks within four of theirs or 0.5 %. */
static void compare(const double *mean, const double *error, const double *expected)
{
    double squared = 0, counted = 0, blocks[3][EDGE / BLOCK * EDGE / BLOCK] = {{0}};
    for (int i = 0; i < EDGE * EDGE; i++) {
        if (expected[i] <= 0) continue;
        squared += square(mean[i] - expected[i]) / square(error[i]);
        counted++;
        int block = i / EDGE / BLOCK * (EDGE / BLOCK) + i % EDGE / BLOCK;
        blocks[0][block] += mean[i];
        blocks[1][block] += expected[i];
        blocks[2][block] += square(error[i]);
    }
    printf("deals: mean squared deviation %.3f standard errors over %.0f pixels", squared / counted, counted);
    CHECK(counted > EDGE * EDGE / 2);
    CHECK(squared / counted < 2);
    for (int block = 0; block < EDGE / BLOCK * EDGE / BLOCK; block++) {
        printf(", block %+.2f", (blocks[0][block] - blocks[1][block]) / sqrt(blocks[2][block]));
        CHECK_NEAR(blocks[0][block], blocks[1][block], fmax(4 * sqrt(blocks[2][block]), 0.005 * blocks[1][block]));
    }
    printf("\n");
}

/* The mean over many deals, unblurred, is the sum over all pairs. The radius is such that every level is used. */
static void check_deals(bool leg, float g)
{
    const slab fog = {-1, 1, 1, {0.6f, 0.6f, 0.6f}, {0.2f, 0.2f, 0.2f}, g};
    const al_settings settings = {.pass = AL_PASS_SURFACE_SCATTERING,
                                  .interval_jitter_off = true,
                                  .surfel_pixels = 1.2f,
                                  .shell_levels = 5,
                                  .shell_radius_m = 0.15f,
                                  .second_leg_off = !leg,
                                  .blur_off = true};
    static double mean[EDGE * EDGE], error[EDGE * EDGE];
    memset(mean, 0, sizeof mean);
    memset(error, 0, sizeof error);
    al_runtime *runtime = open_slabs(&fog, 1, (float[3]){0.1f, 0.5f, 0});
    al_view view = stage_look(EDGE, EDGE, (float[3]){0.2f, 0.1f, 3}, (float[3]){0, 0, 0}, 0.7f);
    for (int deal = 0; deal < DEALS; deal++) {
        float *pixels = stage_draw(runtime, &view, &settings, 0);
        CHECK(pixels && stage_bad(pixels, EDGE * EDGE * 3) == 0);
        for (int i = 0; pixels && i < EDGE * EDGE; i++) {
            mean[i] += pixels[3 * i + 1] / (double)DEALS;
            error[i] += square(pixels[3 * i + 1]) / (double)DEALS;
        }
        free(pixels);
    }
    for (int i = 0; i < EDGE * EDGE; i++) error[i] = sqrt(fmax(error[i] - square(mean[i]), 1e-30) / DEALS);
    double *expected = sum_pairs(runtime, 0.75, g, leg ? 0.8 : 0, 1);
    compare(mean, error, expected);
    free(expected);
    al_runtime_destroy(runtime);
}

/* --- what epsilon leaves out --- */

/* Shells that end by epsilon give, on average, the pairs within the outermost radius; each of the rest is below epsilon
 * over 4^(levels - 1), as there a surfel stands for that many. */
static void check_epsilon(void)
{
    enum { LEVELS = 3 };
    const double epsilon = 2e-4;
    const slab fog = {-1, 1, 1, {0.6f, 0.6f, 0.6f}, {0, 0, 0}, 0.3f};
    const al_settings settings = {.pass = AL_PASS_SURFACE_SCATTERING,
                                  .interval_jitter_off = true,
                                  .second_leg_off = true,
                                  .surfel_pixels = 0.7f,
                                  .shell_levels = LEVELS,
                                  .shell_epsilon_w_m2_sr = (float)epsilon,
                                  .shells_closed = true,
                                  .blur_off = true};
    al_runtime *runtime = open_slabs(&fog, 1, (float[3]){0.1f, 0.5f, 0});
    al_view view = stage_look(EDGE, EDGE, (float[3]){0.2f, 0.1f, 3}, (float[3]){0, 0, 0}, 0.7f);
    free(stage_draw(runtime, &view, &settings, 0));
    interval_map map = read_map(runtime);
    al_frame_block frame = read_frame(runtime);
    uint32_t count, cut = 0;
    surfel *surfels = read_surfels(runtime, &count);
    double largest = 0;
    for (uint32_t i = 0; i < EDGE * EDGE; i += 7)
        for (uint32_t s = 0; s < count; s++) {
            double brightest = fmax(surfels[s].front[0], surfels[s].back[0]), p_max = al_phase(0.3, 1), missing = 0;
            double reach = 4 * sqrt(surfels[s].place[3] * brightest * p_max / epsilon);
            double origin[3], direction[3], place[3], squared;
            view_ray(&frame, i % EDGE + 0.5, i / EDGE + 0.5, origin, direction);
            for (int k = 0; k < SAMPLES; k++) {
                squared = 0;
                for (int j = 0; j < 3; j++) {
                    place[j] = origin[j] + map.samples[i * SAMPLES + k] * direction[j];
                    squared += square(place[j] - surfels[s].place[j]);
                }
                if (squared < square(reach)) continue;
                missing += pair_light(&surfels[s], place, direction, 0.3, 0, 0) * map.ends[4 * i + 2] / SAMPLES;
            }
            largest = fmax(largest, missing);
            cut += missing > 0;
        }
    printf("epsilon: at most %.3g of %.3g is left out, in %u pairs\n", largest, epsilon / 16, cut);
    CHECK(cut > 0 && largest > 0);
    CHECK(largest <= epsilon / 16);
    free(surfels);
    free_map(&map);
    al_runtime_destroy(runtime);
}

/* --- ways to weigh samples --- */

/* The mean of some deals, so that no sample's weight hides behind the noise of one deal; the same deals for all. */
static void draw_weighed(const slab *slabs, al_interval_weights weights, uint32_t knots, double image[EDGE * EDGE * 3])
{
    const al_settings settings = {.pass = AL_PASS_SURFACE_SCATTERING, .interval_weights = weights,
                                  .interval_count = knots, .surfel_pixels = 1.2f, .shell_radius_m = 1,
                                  .blur_off = true};
    al_runtime *runtime = open_slabs(slabs, 1, (float[3]){0.1f, 0.5f, 0});
    al_view view = stage_look(EDGE, EDGE, (float[3]){0.2f, 0.1f, 3}, (float[3]){0, 0, 0}, 0.7f);
    memset(image, 0, EDGE * EDGE * 3 * sizeof *image);
    for (int deal = 0; deal < 8; deal++) {
        float *pixels = stage_draw(runtime, &view, &settings, 0);
        for (int i = 0; pixels && i < EDGE * EDGE * 3; i++) image[i] += pixels[i] / 8.0;
        free(pixels);
    }
    al_runtime_destroy(runtime);
}

static double difference(const double *a, const double *b)
{
    double squared = 0, scale = 0;
    for (int i = 0; i < EDGE * EDGE * 3; i++) {
        squared += square(a[i] - b[i]);
        scale += square(b[i]);
    }
    return sqrt(squared / scale);
}

/* One albedo for all: a stored weight is off by one step of 3/255 at most, dithered, so by that over sqrt(12).
 * Published coefficients, a sum over the lengths between samples, err by the first order of their distance: half with
 * twice the samples. */
static void check_weights(void)
{
    static double plain[2][EDGE * EDGE * 3], coloured[EDGE * EDGE * 3], published[2][EDGE * EDGE * 3];
    const slab fog = {-1, 1, 1, {0.6f, 0.6f, 0.6f}, {0.2f, 0.2f, 0.2f}, 0.4f};
    for (uint32_t i = 0; i < 2; i++) {
        draw_weighed(&fog, AL_INTERVAL_WEIGHTS_AUTO, 16 << i, plain[i]);
        draw_weighed(&fog, AL_INTERVAL_WEIGHTS_COEFFICIENTS, 16 << i, published[i]);
    }
    draw_weighed(&fog, AL_INTERVAL_WEIGHTS_COLOURED, 16, coloured);
    double first = difference(published[0], plain[0]), second = difference(published[1], plain[1]);
    printf("weights: stored %.4f, published coefficients %.4f, of twice the samples %.4f from none\n",
           difference(coloured, plain[0]), first, second);
    CHECK(difference(coloured, plain[0]) < 3 / 255.0 / sqrt(12));
    CHECK(second < 0.6 * first);
}

/* Chromatic extinction: each channel as in a grey fog of its own extinction. Samples are placed otherwise, so the two
 * differ by their noise, which the sum over a picture and 8 deals keeps below a percent. */
static void check_chromatic(void)
{
    static double mixed[EDGE * EDGE * 3], grey[EDGE * EDGE * 3];
    const slab fog = {-1, 1, 1, {0.9f, 0.5f, 0.1f}, {0.1f, 0.1f, 0.1f}, 0};
    draw_weighed(&fog, AL_INTERVAL_WEIGHTS_AUTO, 16, mixed);
    for (int channel = 0; channel < 3; channel++) {
        float s = fog.sigma_s[channel], a = fog.sigma_a[channel];
        const slab own = {-1, 1, 1, {s, s, s}, {a, a, a}, 0};
        draw_weighed(&own, AL_INTERVAL_WEIGHTS_AUTO, 16, grey);
        double sums[2] = {0};
        for (int i = 0; i < EDGE * EDGE; i++) {
            sums[0] += mixed[3 * i + channel];
            sums[1] += grey[3 * i + channel];
        }
        printf("chromatic: channel %d %.4f of its grey fog\n", channel, sums[0] / sums[1]);
        CHECK_NEAR(sums[0] / sums[1], 1, 0.01);
    }
}

/* --- what stands in it --- */

/* A sphere of no light of its own in the fog: opaque, it leaves the share of the samples before it; clear, everything. */
static void check_object(void)
{
    static const float extinctions[] = {1e-6f, 1e4f};
    for (int i = 0; i < 2; i++) {
        al_runtime *runtime = NULL;
        al_error error = {0};
        sphere_scene s;
        al_fog fog = {.bounded = true, .bounds_min_m = {-1, -1, -1}, .bounds_max_m = {1, 1, 1}, .density = 1, .asset = ""};
        sphere_scene_begin(&s);
        for (int k = 0; k < 3; k++) s.medium.sigma_s_per_m[k] = 0.7f;
        s.scene.fogs = &fog;
        s.scene.fog_count = 1;
        s.scene.baked = (al_baked_light){"", ""};
        sphere_scene_add_floor(&s, 2, (float[3]){0, -0.8f, 0});
        sphere_scene_add_light(&s, AL_LIGHT_POINT, (float[3]){0, 0.9f, 0}, 1);
        CHECK(sphere_write_asset(folder, "sphere.air",
                                 &(sphere_options){.radius = 0.4f, .samples = 100, .grid = 24, .sigma_t = {extinctions[i]}}));
        sphere_scene_add(&s, "sphere.air", 0.4f, (float[3]){0, 0, 0});
        CHECK(sphere_scene_write(folder, &s));
        CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK && stage_load(runtime, folder));
        sphere_scene_end(&s);
        al_settings settings = {.pass = AL_PASS_SURFACE_SCATTERING, .interval_jitter_off = true, .blur_off = true,
                                .shell_radius_m = 4, .shadows_off = true, .surfel_pixels = 4.6f};
        al_view view = stage_look(MAP_EDGE, MAP_EDGE, (float[3]){0, 0, 3}, (float[3]){0, 0, 0}, 0.01f);
        float *with = stage_draw(runtime, &view, &settings, 0);
        interval_map map = read_map(runtime);
        size_t middle = MAP_EDGE / 2 * MAP_EDGE + MAP_EDGE / 2;
        double before = map.ends[4 * middle], share = 0;
        for (int k = 0; k < SAMPLES; k++) {
            double t = map.samples[middle * SAMPLES + k];
            share += fmin(fmax((2.6 - before) / (t - before), 0), 1) / SAMPLES;
            before = t;
        }
        al_runtime_scene(runtime)->instances[1].world[12] = 100; /* the sphere, out of view */
        float *without = stage_draw(runtime, &view, &settings, 0);
        printf("object: %.4f of the light stays, its front has %.4f\n", (double)with[3 * middle] / without[3 * middle], share);
        CHECK_NEAR(with[3 * middle] / without[3 * middle], i ? share : 1, 2e-3);
        CHECK(share > 0.2 && share < 0.9);
        free(with);
        free(without);
        free_map(&map);
        al_runtime_destroy(runtime);
    }
}

int main(void)
{
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    folder = stage_folder();
    CHECK(folder != NULL);
    if (!folder) return test_end();
    check_oracle();
    check_gap();
    check_object();
    check_epsilon();
    check_weights();
    check_chromatic();
    check_deals(true, 0);
    check_deals(false, 0.6f);
    return test_end();
}
