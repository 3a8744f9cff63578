/* airlight-compare's numbers: by hand where that can be done, FLIP against its authors' tool. Ends by writing
 * the pictures that compare_cli.sh compares. */
#define _POSIX_C_SOURCE 200809L
#include "metrics.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "../test.h"
#include "flip.h"

static al_metrics measure(const al_image *a, const al_image *b, const al_image *error_a,
                          const al_image *error_b)
{
    al_comparison comparison = {a, b, error_a, error_b};
    al_metrics metrics;
    al_error error;
    CHECK(al_compare(&comparison, &metrics, NULL, &error) == AL_OK);
    return metrics;
}

static void test_by_hand(void)
{
    al_image a = {2, 2, 1, (float[]){1, 2, 3, 4}}, b = {2, 2, 1, (float[]){1, 1, 1, 1}};
    al_image one = {2, 2, 1, (float[]){1, 1, 1, 1}}, three = {2, 2, 1, (float[]){3, 3, 3, 3}};
    al_metrics m = measure(&a, &b, &one, &one);
    const double *v = m.values;
    CHECK(m.count == AL_METRIC_COUNT);
    CHECK_NEAR(v[AL_METRIC_RMSE], sqrt(14.0 / 4), 1e-12); /* differences 0 1 2 3 */
    CHECK_NEAR(v[AL_METRIC_RELATIVE_RMSE], sqrt(14.0 / 4), 1e-12);
    CHECK_NEAR(v[AL_METRIC_PSNR_DB], 10 * log10(4 / 14.0), 1e-12);
    CHECK_NEAR(v[AL_METRIC_MEAN_RATIO], 2.5, 1e-12);
    CHECK_NEAR(v[AL_METRIC_MAX_ABS], 3, 0);
    CHECK_NEAR(v[AL_METRIC_RELATIVE_RMSE_WITHOUT_NOISE], sqrt((14.0 - 4) / 4), 1e-12);
    CHECK_NEAR(v[AL_METRIC_CHI2_MEAN], 14.0 / 8, 1e-12);
    CHECK_NEAR(v[AL_METRIC_BLOCK_WORST_SIGMA], 6 / sqrt(8), 1e-12);
    m = measure(&a, &b, NULL, &three);
    CHECK(m.count == AL_METRIC_CHI2_MEAN && isnan(v[AL_METRIC_CHI2_MEAN]));
    CHECK_NEAR(v[AL_METRIC_RELATIVE_RMSE_WITHOUT_NOISE], 0, 0); /* 4 * 9 is more than 14 */
    m = measure(&a, &b, NULL, NULL);
    CHECK(m.count == AL_METRIC_RELATIVE_RMSE_WITHOUT_NOISE);
}

static void test_channels(void)
{
    al_image grey = {1, 1, 1, (float[]){2}}, color = {1, 1, 3, (float[]){1, 2, 4}};
    const double rmse = sqrt(5.0 / 3); /* (2-1, 2-2, 2-4) */
    CHECK_NEAR(measure(&grey, &color, NULL, NULL).values[AL_METRIC_RMSE], rmse, 1e-12);
    CHECK_NEAR(measure(&color, &grey, NULL, NULL).values[AL_METRIC_RMSE], rmse, 1e-12);
}

static void test_special_values(void)
{
    al_image a = {4, 1, 1, (float[]){NAN, INFINITY, 5, 3}}, b = {4, 1, 1, (float[]){1, 2, NAN, 3}};
    al_metrics m = measure(&a, &b, NULL, NULL);
    CHECK(m.values[AL_METRIC_NAN_COUNT] == 2 && m.values[AL_METRIC_INF_COUNT] == 1);
    /* A's count as 0, B's leaves its pair out: differences 1, 2, 0. */
    CHECK_NEAR(m.values[AL_METRIC_RMSE], sqrt(5.0 / 3), 1e-12);
    CHECK(isfinite(m.values[AL_METRIC_FLIP_LDR]) && m.values[AL_METRIC_FLIP_HDR] > 0);

    al_image black = {2, 1, 1, (float[]){0, 0}}, white = {2, 1, 1, (float[]){1, 1}};
    m = measure(&black, &black, &black, &black);
    CHECK(m.values[AL_METRIC_RELATIVE_RMSE] == 0 && m.values[AL_METRIC_MEAN_RATIO] == 1);
    CHECK(m.values[AL_METRIC_CHI2_MEAN] == 0 && m.values[AL_METRIC_BLOCK_WORST_SIGMA] == 0);
    m = measure(&white, &black, &black, &black);
    CHECK(isnan(m.values[AL_METRIC_RELATIVE_RMSE]) && isnan(m.values[AL_METRIC_MEAN_RATIO]));
    /* A difference without any noise is infinitely many standard errors. */
    CHECK(isinf(m.values[AL_METRIC_CHI2_MEAN]) && isinf(m.values[AL_METRIC_BLOCK_WORST_SIGMA]));
}

/* Pictures with noise of the stated error agree: chi2 about 1 (1000 values: standard deviation sqrt(2/1000),
 * so 1 +- 0.25 is more than five), blocks below four. With the errors stated three times too small they do
 * not. */
static void test_noise(void)
{
    enum { WIDTH = 40, HEIGHT = 25, COUNT = WIDTH * HEIGHT };
    static float pixels[3][COUNT], small[COUNT];
    uint32_t state = 1;
    for (int i = 0; i < COUNT; i++) {
        for (int side = 0; side < 2; side++) {
            double sum = 0; /* of twelve uniform numbers: variance 1 */
            for (int k = 0; k < 12; k++)
                sum += (double)((state = state * 1664525u + 1013904223u) >> 8) / (1 << 24);
            pixels[side][i] = (float)(10 + 0.5 * (sum - 6));
        }
        pixels[2][i] = 0.5f;
        small[i] = 0.5f / 3;
    }
    al_image a = {WIDTH, HEIGHT, 1, pixels[0]}, b = {WIDTH, HEIGHT, 1, pixels[1]};
    al_image e = {WIDTH, HEIGHT, 1, pixels[2]}, e3 = {WIDTH, HEIGHT, 1, small};
    al_metrics m = measure(&a, &b, &e, &e);
    CHECK_NEAR(m.values[AL_METRIC_CHI2_MEAN], 1, 0.25);
    CHECK(m.values[AL_METRIC_BLOCK_WORST_SIGMA] < 4);
    CHECK_NEAR(measure(&a, &b, &e3, &e3).values[AL_METRIC_CHI2_MEAN], 9 * m.values[AL_METRIC_CHI2_MEAN],
               1e-3);
}

enum { FLIP_WIDTH = 61, FLIP_HEIGHT = 47, PAIRS = 4 };

static float pattern(int x, int y, int c)
{
    int ramp = (5 * x + 3 * y + 11 * c) % 32, checker = (x / 8 + y / 8 + c) % 2;
    return (float)(ramp + 32 * checker) / 64;
}

static float clamp(float v)
{
    return v < 0 ? 0 : v > 1 ? 1 : v;
}

/* Pair 0: coloured, shifted; 1: grey with a bright block; 2: over 16 stops; 3: mostly black. */
static float reference_value(int pair, int x, int y, int c)
{
    float v = pattern(x, y, pair == 1 ? 0 : c);
    if (pair == 2) return ldexpf(v, x / 5 - 4);
    if (pair == 3) return x > 40 && y > 20 ? 8 * v : 0;
    return v;
}

static float test_value(int pair, int x, int y, int c)
{
    float noise = (float)((x * y + c) % 5 - 2) / 64, noisy = clamp(pattern(x, y, c) + noise);
    if (pair == 0) return clamp(pattern(x + 1, y, c) + noise);
    if (pair == 1) return x > 20 && x < 30 && y > 10 && y < 20 ? 1 : pattern(x, y, 0);
    if (pair == 2) return ldexpf(noisy, x / 5 - 4);
    return x > 40 && y > 20 ? 8 * noisy : 0;
}

/* Expected: flip-evaluator 1.7, the authors' tool, on these pictures, at 67.0206 pixels per degree (LDR with
 * both clamped to [0, 1], linear). It computes in float32 with some tabulated constants: agreement to 1e-4.
 */
static void test_flip(void)
{
    static const double ldr[PAIRS] = {0.3575720, 0.0284462, 0.0596645, 0.0159974};
    static const double hdr[PAIRS] = {0.3141576, 0.0170514, 0.0655235, 0.0226933};
    static float pixels[2][FLIP_HEIGHT * FLIP_WIDTH * 3], map[FLIP_HEIGHT * FLIP_WIDTH];
    al_image reference = {FLIP_WIDTH, FLIP_HEIGHT, 3, pixels[0]},
             test = {FLIP_WIDTH, FLIP_HEIGHT, 3, pixels[1]};
    for (int pair = 0; pair < PAIRS; pair++) {
        for (int i = 0; i < FLIP_WIDTH * FLIP_HEIGHT * 3; i++) {
            int x = i / 3 % FLIP_WIDTH, y = i / 3 / FLIP_WIDTH;
            pixels[0][i] = reference_value(pair, x, y, i % 3);
            pixels[1][i] = test_value(pair, x, y, i % 3);
        }
        double mean;
        al_error error;
        CHECK(al_flip_ldr(&test, &reference, map, &mean, &error) == AL_OK);
        CHECK_NEAR(mean, ldr[pair], 1e-4);
        /* Two single pixels of the same tool's map, one beside and one inside the block. */
        if (pair == 1) CHECK_NEAR(map[12 * FLIP_WIDTH + 25], 0.8380135, 1e-4);
        if (pair == 1) CHECK_NEAR(map[12 * FLIP_WIDTH + 26], 0.9377572, 1e-4);
        CHECK(al_flip_hdr(&test, &reference, map, &mean, &error) == AL_OK);
        CHECK_NEAR(mean, hdr[pair], 1e-4);
        if (pair == 2) CHECK_NEAR(map[25 * FLIP_WIDTH + 45], 0.0890608, 1e-4);
        CHECK(al_flip_hdr(&test, &test, map, &mean, &error) == AL_OK && mean == 0);
    }
}

/* Without edges only colour counts; green against blue is the largest colour difference there is, so 1. */
static void test_flip_extremes(void)
{
    float map[1];
    double mean;
    al_error error;
    al_image green = {1, 1, 3, (float[]){0, 1, 0}}, blue = {1, 1, 3, (float[]){0, 0, 1}};
    al_image huge = {1, 1, 3, (float[]){3e38f, 3e38f, 3e38f}}, tiny = {1, 1, 3, (float[]){1e-38f, 0, -1}};
    CHECK(al_flip_ldr(&green, &blue, map, &mean, &error) == AL_OK);
    CHECK_NEAR(mean, 1, 1e-5);
    CHECK(al_flip_hdr(&huge, &tiny, map, &mean, &error) == AL_OK && mean > 0.5 && mean <= 1);
    CHECK(al_flip_hdr(&tiny, &huge, map, &mean, &error) == AL_OK && mean > 0.5 && mean <= 1);
}

static void write_pictures(void)
{
    al_error error;
    al_image a = {2, 2, 1, (float[]){1, 2, 3, 4}}, b = {2, 2, 1, (float[]){1, 1, 1, 1}};
    al_image wide = {3, 1, 1, (float[]){1, 1, 1}}, special = {2, 2, 1, (float[]){NAN, INFINITY, 1, 1}};
    CHECK(al_image_write_exr("compare_a.exr", &a, &error) == AL_OK);
    CHECK(al_image_write_exr("compare_b.exr", &b, &error) == AL_OK);
    CHECK(al_image_write_exr("compare_wide.exr", &wide, &error) == AL_OK);
    CHECK(al_image_write_exr("compare_special.exr", &special, &error) == AL_OK);
}

int main(void)
{
    test_by_hand();
    test_channels();
    test_special_values();
    test_noise();
    test_flip();
    test_flip_extremes();
    write_pictures();
    return test_end();
}
