/* Environment maps: projection against closed forms, convention, rotation, refusals. */
#include <math.h>

#include "airlight/formulas.h"
#include "environment.h"
#include "files.h"
#include "import.h"

enum { COUNT = AL_ENVIRONMENT_ORDER * AL_ENVIRONMENT_ORDER };

static void project(uint32_t width, uint32_t height, const float *pixels, float sh[3][COUNT])
{
    al_error error;
    CHECK(al_environment_project(width, height, pixels, sh, &error) == AL_OK);
}

/* A constant sky L has the coefficients sqrt(4 pi) L, 0, 0, ...: whatever its pixels, as the projection is
 * exact. Bound: float output. */
static void test_constant(uint32_t width, uint32_t height)
{
    float *pixels = malloc((size_t)width * height * 3 * sizeof *pixels), sh[3][COUNT];
    for (size_t i = 0; pixels && i < (size_t)width * height * 3; i++) pixels[i] = (float)(i % 3) + 0.5f;
    project(width, height, pixels, sh);
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < COUNT; k++)
            CHECK_NEAR(sh[c][k], k ? 0 : sqrt(4 * AL_PI) * (c + 0.5), 1e-6 * (c + 0.5));
    free(pixels);
}

static void direction_of(double u, double v, double out[3])
{
    double theta = AL_PI * v, phi = 2 * AL_PI * (u - 0.5);
    out[0] = sin(theta) * sin(phi);
    out[1] = cos(theta);
    out[2] = -sin(theta) * cos(phi);
}

/* One lit pixel against a midpoint sum over its solid angle, 200 x 200 points: the midpoint rule errs by
 * h^2/24 of the second derivative, at most l^2 = 49 times the function: (pi/6/200)^2 * 49 / 24 = 1.4e-5
 * relative to the largest |Y| (about 3.9) times the solid angle (0.27): 1.5e-5. */
static void test_pixel(uint32_t column, uint32_t row)
{
    enum { WIDTH = 12, HEIGHT = 6, STEPS = 200 };
    float pixels[WIDTH * HEIGHT * 3] = {0}, sh[3][COUNT];
    double expected[COUNT] = {0}, basis[AL_SH_MAX_COUNT], direction[3];
    pixels[(row * WIDTH + column) * 3 + 1] = 1;
    project(WIDTH, HEIGHT, pixels, sh);
    for (int i = 0; i < STEPS * STEPS; i++) {
        double u = (column + (i % STEPS + 0.5) / STEPS) / WIDTH,
               v = (row + (i / STEPS + 0.5) / STEPS) / HEIGHT;
        double cell = 2 * AL_PI / WIDTH / STEPS * AL_PI / HEIGHT / STEPS * sin(AL_PI * v);
        direction_of(u, v, direction);
        al_sh_basis(AL_ENVIRONMENT_ORDER, direction[0], direction[1], direction[2], basis);
        for (int k = 0; k < COUNT; k++) expected[k] += cell * basis[k];
    }
    for (int k = 0; k < COUNT; k++) {
        CHECK_NEAR(sh[1][k], expected[k], 1.5e-5);
        CHECK(sh[0][k] == 0);
    }
}

/* --- through a scene file; the maps are Radiance files without run lengths --- */

/* Exponent 129 makes a mantissa m the value m / 128 (Ward 1991: (m + 1/2) or m; stb takes m). */
static void write_hdr(const char *path, int width, int height, const unsigned char (*pixels)[4])
{
    char head[128];
    int size =
        snprintf(head, sizeof head, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n", height, width);
    FILE *file = fopen(path, "wb");
    fwrite(head, 1, (size_t)size, file);
    fwrite(pixels, 4, (size_t)(width * height), file);
    fclose(file);
}

static al_import *import_environment(const char *environment)
{
    char json[512];
    al_import *import = NULL;
    al_error error = {0};
    snprintf(json, sizeof json, "{\"environment\": {%s}}", environment);
    write_text("environment_test.json", json);
    CHECK(al_import_scene("environment_test.json", AL_QUALITY_PREVIEW, &import, &error) == AL_OK);
    if (!import) fprintf(stderr, "%s\n", error.message);
    return import;
}

/* Four columns: only the second, which looks along -x on average, shines. */
static void test_convention(void)
{
    const unsigned char pixels[4][4] = {{0, 0, 0, 0}, {128, 64, 0, 129}, {0, 0, 0, 0}, {0, 0, 0, 0}};
    write_hdr("left.hdr", 4, 1, pixels);
    al_import *import = import_environment("\"file\": \"left.hdr\", \"scale\": 2");
    if (import) {
        const al_environment *e = &import->scene.environment;
        CHECK(e->width == 4 && e->height == 1 && e->pixels[3] == 2 && e->pixels[4] == 1 && e->pixels[0] == 0);
        /* columns 1/4 to 1/2 of the way: phi from -pi/2 to 0, so x and z below 0 and equal in size */
        CHECK(e->sh[0][3] < -0.1 && fabsf(e->sh[0][3] - e->sh[0][2]) < 1e-6f && fabsf(e->sh[0][1]) < 1e-6f);
        CHECK(import->input_count == 2);
    }
    al_import_free(import);
    /* a quarter turn counter-clockwise seen from above takes -z to -x and -x to +z */
    import = import_environment("\"file\": \"left.hdr\", \"rotation_degrees\": 90");
    if (import) {
        const al_environment *e = &import->scene.environment;
        CHECK(e->pixels[0] == 1 && e->pixels[3] == 0);
        CHECK(e->sh[0][3] < -0.1 && e->sh[0][2] > 0.1);
    }
    al_import_free(import);
    import = import_environment("\"file\": \"left.hdr\", \"rotation_degrees\": -45");
    if (import) { /* half a column: both neighbours have half, the sum stays */
        const al_environment *e = &import->scene.environment;
        CHECK_NEAR(e->pixels[3], 0.5, 1e-6);
        CHECK_NEAR(e->pixels[6], 0.5, 1e-6);
    }
    al_import_free(import);
}

static void test_sky(void)
{
    al_import *import = import_environment("\"radiance_w_m2_sr\": [1, 2, 3], \"scale\": 2");
    if (import) {
        const al_environment *e = &import->scene.environment;
        CHECK(e->width == 1 && e->height == 1 && e->pixels[2] == 6);
        for (int c = 0; c < 3; c++)
            for (int k = 0; k < COUNT; k++)
                CHECK_NEAR(e->sh[c][k], k ? 0 : sqrt(4 * AL_PI) * 2 * (c + 1), 4e-6);
    }
    al_import_free(import);
    import = import_environment("\"radiance_w_m2_sr\": 0");
    if (import) CHECK(import->scene.environment.width == 0 && !import->scene.environment.pixels);
    al_import_free(import);
}

static void refuse(const char *environment, const char *parts)
{
    char json[512];
    al_import *import = NULL;
    al_error error = {0};
    snprintf(json, sizeof json, "{\"environment\": {%s}}", environment);
    write_text("environment_test.json", json);
    al_status status = al_import_scene("environment_test.json", AL_QUALITY_PREVIEW, &import, &error);
    check_mentions(environment, status, &error, AL_BAD_INPUT, parts);
    al_import_free(import);
}

/* An uncompressed OpenEXR file of 2 x 1 float pixels: https://openexr.com/en/latest/OpenEXRFileLayout.html */
static void write_exr(const char *path, const float rgb[2][3])
{
    static const char head[] = "\x76\x2f\x31\x01\x02\0\0\0"
                               "channels\0chlist\0\x37\0\0\0"
                               "B\0\x02\0\0\0\0\0\0\0\x01\0\0\0\x01\0\0\0"
                               "G\0\x02\0\0\0\0\0\0\0\x01\0\0\0\x01\0\0\0"
                               "R\0\x02\0\0\0\0\0\0\0\x01\0\0\0\x01\0\0\0\0"
                               "compression\0compression\0\x01\0\0\0\0"
                               "dataWindow\0box2i\0\x10\0\0\0\0\0\0\0\0\0\0\0\x01\0\0\0\0\0\0\0"
                               "displayWindow\0box2i\0\x10\0\0\0\0\0\0\0\0\0\0\0\x01\0\0\0\0\0\0\0"
                               "lineOrder\0lineOrder\0\x01\0\0\0\0"
                               "pixelAspectRatio\0float\0\x04\0\0\0\0\0\x80\x3f"
                               "screenWindowCenter\0v2f\0\x08\0\0\0\0\0\0\0\0\0\0\0"
                               "screenWindowWidth\0float\0\x04\0\0\0\0\0\x80\x3f";
    unsigned char bytes[sizeof head + 8 + 8 + 24];
    size_t at = sizeof head; /* with the terminator: the header's end */
    memcpy(bytes, head, sizeof head);
    const uint64_t offset = sizeof head + 8;
    const uint32_t line[2] = {0, 24};
    memcpy(bytes + at, &offset, 8);
    memcpy(bytes + at + 8, line, 8);
    at += 16;
    for (int channel = 2; channel >= 0; channel--)
        for (int x = 0; x < 2; x++, at += 4) memcpy(bytes + at, &rgb[x][channel], 4);
    write_bytes(path, bytes, sizeof bytes);
}

static void test_exr(void)
{
    const float good[2][3] = {{1, 2, 3}, {4, 5, -0.001f}}, nan[2][3] = {{1, 1, 1}, {1, NAN, 1}};
    const float inf[2][3] = {{INFINITY, 1, 1}, {1, 1, 1}}, negative[2][3] = {{1, 1, 1}, {1, 1, -0.5f}};
    write_exr("good.exr", good);
    write_exr("nan.exr", nan);
    write_exr("inf.exr", inf);
    write_exr("negative.exr", negative);
    al_import *import = import_environment("\"file\": \"good.exr\"");
    if (import) {
        const float expected[6] = {1, 2, 3, 4, 5, 0};
        CHECK(import->scene.environment.width == 2);
        for (int i = 0; i < 6; i++) CHECK(import->scene.environment.pixels[i] == expected[i]);
    }
    al_import_free(import);
    refuse("\"file\": \"nan.exr\"", "nan.exr: pixel (1, 0), counted from the upper left, channel G is nan");
    refuse("\"file\": \"inf.exr\"", "inf.exr: pixel (0, 0), counted from the upper left, channel R is inf");
    refuse("\"file\": \"negative.exr\"",
           "negative.exr: pixel (1, 0), counted from the upper left, channel B is -0.5");
    refuse("\"file\": \"none.exr\"", "none.exr: cannot open: No such file or directory");
    refuse("\"file\": \"sky.tiff\"", "sky.tiff: unknown kind of environment map; .exr or .hdr is right");
    write_text("junk.exr", "junk");
    write_text("junk.hdr", "junk");
    refuse("\"file\": \"junk.exr\"", "junk.exr: cannot be read as OpenEXR");
    refuse("\"file\": \"junk.hdr\"", "junk.hdr: cannot be read as a picture; Radiance .hdr is right");
}

int main(void)
{
    test_constant(1, 1);
    test_constant(7, 5);
    test_constant(256, 128);
    test_pixel(0, 0);
    test_pixel(4, 2);
    test_pixel(11, 5);
    test_convention();
    test_sky();
    test_exr();
    return test_end();
}
