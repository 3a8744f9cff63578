/* Pictures: round trips, what other programs write (half, tiles, other compressions), and refused files. */
#define _POSIX_C_SOURCE 200809L
#include "airlight/image.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <openexr.h>

#include "../test.h"

enum { WIDTH = 37, HEIGHT = 41 }; /* not a multiple of a chunk or a tile */

static float value_at(uint32_t x, uint32_t y, uint32_t channel)
{
    /* Multiples of 1/64 below 8: exact in half. */
    return (float)((x * 7 + y * 13 + channel * 31) % 512) / 64;
}

static al_image make_image(uint32_t channels)
{
    al_image image = {WIDTH, HEIGHT, channels, malloc(sizeof(float) * WIDTH * HEIGHT * channels)};
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++)
        for (uint32_t c = 0; c < channels; c++)
            image.pixels[i * channels + c] = value_at(i % WIDTH, i / WIDTH, c);
    return image;
}

static int same_pixels(const al_image *a, const al_image *b)
{
    return a->width == b->width && a->height == b->height && a->channels == b->channels &&
           !memcmp(a->pixels, b->pixels, sizeof(float) * a->width * a->height * a->channels);
}

static void test_round_trip(uint32_t channels)
{
    al_error error;
    al_image written = make_image(channels), read;
    written.pixels[5] = INFINITY;
    written.pixels[6] = -1e-30f;
    written.pixels[7] = 3e38f;
    CHECK(al_image_write_exr("image_test.exr", &written, &error) == AL_OK);
    CHECK(al_image_read_exr("image_test.exr", &read, &error) == AL_OK);
    CHECK(same_pixels(&written, &read));
    al_image_free(&written);
    al_image_free(&read);
    CHECK(read.pixels == NULL && read.width == 0);
}

/* One chunk of ever more bytes of noise: at some count its deflated bytes are as many as its pixels'. */
static void test_incompressible(void)
{
    uint32_t bits = 1, lost = 0;
    al_error error;
    al_image written = {16, 16, 1, calloc(256, sizeof(float))}, read;
    for (uint32_t count = 0; count < 4 * 256; count++) {
        bits = bits * 1664525 + 1013904223;
        uint8_t byte = (uint8_t)(bits >> 24);
        if (count % 4 == 3) byte &= 0xbf; /* below 2 */
        memcpy((uint8_t *)written.pixels + count, &byte, 1);
        CHECK(al_image_write_exr("image_test.exr", &written, &error) == AL_OK);
        CHECK(al_image_read_exr("image_test.exr", &read, &error) == AL_OK);
        lost += !same_pixels(&written, &read);
        al_image_free(&read);
    }
    CHECK(lost == 0);
    al_image_free(&written);
}

typedef struct variant {
    exr_storage_t storage;
    exr_compression_t compression;
    exr_pixel_type_t type;
} variant;

static uint16_t half_of(float value) /* exact multiples of 1/64 from 0 to below 8 */
{
    if (value == 0) return 0;
    int exponent;
    float fraction = frexpf(value, &exponent); /* [0.5, 1) */
    return (uint16_t)(((exponent - 1 + 15) << 10) | (int)((fraction * 2 - 1) * 1024));
}

/* Writes R, G, B and an alpha channel of the type through OpenEXR itself; the window starts at (-3, 5). */
static int write_variant(const char *path, variant v)
{
    static uint8_t data[4][HEIGHT][WIDTH][4];
    int size = v.type == EXR_PIXEL_HALF ? 2 : 4, part, failed = 0;
    for (uint32_t c = 0; c < 4; c++)
        for (uint32_t y = 0; y < HEIGHT; y++)
            for (uint32_t x = 0; x < WIDTH; x++) {
                float value = v.type == EXR_PIXEL_UINT ? (float)(int)value_at(x, y, c) : value_at(x, y, c);
                uint16_t half = half_of(value);
                uint32_t whole = (uint32_t)value;
                const void *source = v.type == EXR_PIXEL_HALF   ? (const void *)&half
                                     : v.type == EXR_PIXEL_UINT ? (const void *)&whole
                                                                : (const void *)&value;
                memcpy(&((uint8_t *)data[c])[(y * WIDTH + x) * (uint32_t)size], source, (size_t)size);
            }
    exr_context_t context;
    exr_context_initializer_t options = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_attr_box2i_t window;
    exr_attr_v2f_t center;
    window.min.x = -3, window.min.y = 5;
    window.max.x = -3 + WIDTH - 1, window.max.y = 5 + HEIGHT - 1;
    center.x = center.y = 0;
    failed |= exr_start_write(&context, path, EXR_WRITE_FILE_DIRECTLY, &options);
    failed |= exr_add_part(context, "p", v.storage, &part);
    failed |= exr_initialize_required_attr(context, part, &window, &window, 1, &center, 1,
                                           EXR_LINEORDER_INCREASING_Y, v.compression);
    if (v.storage == EXR_STORAGE_TILED)
        failed |= exr_set_tile_descriptor(context, part, 16, 8, EXR_TILE_ONE_LEVEL, EXR_TILE_ROUND_DOWN);
    const char *names[] = {"A", "B", "G", "R"};
    for (int i = 0; i < 4; i++)
        failed |= exr_add_channel(context, part, names[i], v.type, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    failed |= exr_write_header(context);
    int32_t step_x = 16, step_y = 8;
    if (v.storage == EXR_STORAGE_SCANLINE) {
        step_x = WIDTH;
        failed |= exr_get_scanlines_per_chunk(context, part, &step_y);
    }
    exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
    for (int y = 0; y < HEIGHT; y += step_y)
        for (int x = 0; x < WIDTH; x += step_x) {
            exr_chunk_info_t chunk;
            failed |= v.storage == EXR_STORAGE_TILED
                          ? exr_write_tile_chunk_info(context, part, x / step_x, y / step_y, 0, 0, &chunk)
                          : exr_write_scanline_chunk_info(context, part, 5 + y, &chunk);
            failed |= x + y == 0 ? exr_encoding_initialize(context, part, &chunk, &pipeline)
                                 : exr_encoding_update(context, part, &chunk, &pipeline);
            for (int i = 0; i < 4; i++) {
                static const int slots[] = {3, 2, 1, 0};
                exr_coding_channel_info_t *channel = &pipeline.channels[i];
                channel->encode_from_ptr = (uint8_t *)data[slots[i]] + (y * WIDTH + x) * size;
                channel->user_data_type = (uint16_t)v.type;
                channel->user_bytes_per_element = (int16_t)size;
                channel->user_pixel_stride = size;
                channel->user_line_stride = WIDTH * size;
            }
            if (x + y == 0) failed |= exr_encoding_choose_default_routines(context, part, &pipeline);
            failed |= exr_encoding_run(context, part, &pipeline);
        }
    failed |= exr_encoding_destroy(context, &pipeline);
    failed |= exr_finish(&context);
    return failed;
}

static void test_variants(void)
{
    static const exr_compression_t lossless[] = {EXR_COMPRESSION_NONE, EXR_COMPRESSION_RLE,
                                                 EXR_COMPRESSION_ZIPS, EXR_COMPRESSION_ZIP,
                                                 EXR_COMPRESSION_PIZ};
    al_error error;
    for (int storage = EXR_STORAGE_SCANLINE; storage <= EXR_STORAGE_TILED; storage++)
        for (int type = EXR_PIXEL_UINT; type <= EXR_PIXEL_FLOAT; type++)
            for (size_t i = 0; i < sizeof lossless / sizeof *lossless; i++) {
                variant v = {(exr_storage_t)storage, lossless[i], (exr_pixel_type_t)type};
                al_image image;
                CHECK(write_variant("image_variant.exr", v) == 0);
                CHECK(al_image_read_exr("image_variant.exr", &image, &error) == AL_OK);
                CHECK(image.width == WIDTH && image.height == HEIGHT && image.channels == 3);
                int wrong = 0;
                for (uint32_t p = 0; image.pixels && p < WIDTH * HEIGHT; p++)
                    for (uint32_t c = 0; c < 3; c++) {
                        float expected = value_at(p % WIDTH, p / WIDTH, c);
                        if (type == EXR_PIXEL_UINT) expected = floorf(expected);
                        wrong += image.pixels[p * 3 + c] != expected;
                    }
                CHECK(wrong == 0);
                if (wrong)
                    fprintf(stderr, "storage %d, type %d, compression %d\n", storage, type, lossless[i]);
                al_image_free(&image);
            }
}

static uint8_t *read_bytes(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    static uint8_t bytes[1 << 16];
    *size = file ? fread(bytes, 1, sizeof bytes, file) : 0;
    if (file) fclose(file);
    return bytes;
}

static void write_bytes(const char *path, const void *bytes, size_t size)
{
    FILE *file = fopen(path, "wb");
    if (!file) return;
    fwrite(bytes, 1, size, file);
    fclose(file);
}

static void check_refused(const char *path, al_status status, const char *word)
{
    al_error error = {0};
    al_image image;
    al_status answer = al_image_read_exr(path, &image, &error);
    CHECK(answer == status && error.status == status);
    CHECK(image.pixels == NULL && image.width == 0);
    CHECK(strstr(error.message, path) && strstr(error.message, word) && !strchr(error.message, '\n'));
    if (!strstr(error.message, word)) fprintf(stderr, "'%s' is not in: %s\n", word, error.message);
}

static void test_refused(void)
{
    al_error error;
    al_image image = make_image(1);
    size_t size;
    CHECK(al_image_write_exr("image_bad.exr", &image, &error) == AL_OK);
    uint8_t *bytes = read_bytes("image_bad.exr", &size);
    CHECK(size > 100);
    for (size_t kept = 0; kept < size; kept += 1 + size / 400) {
        write_bytes("image_bad.exr", bytes, kept);
        check_refused("image_bad.exr", AL_BAD_INPUT, "OpenEXR");
    }
    write_bytes("image_bad.exr", bytes, size - 1);
    check_refused("image_bad.exr", AL_BAD_INPUT, "OpenEXR");

    static const char key[] = "compression\0compression\0\1\0\0";
    size_t place = 0;
    while (place + sizeof key < size && memcmp(bytes + place, key, sizeof key)) place++;
    CHECK(bytes[place + sizeof key] == EXR_COMPRESSION_ZIP);
    for (int dwa = EXR_COMPRESSION_DWAA; dwa <= EXR_COMPRESSION_DWAB; dwa++) {
        bytes[place + sizeof key] = (uint8_t)dwa;
        write_bytes("image_bad.exr", bytes, size);
        check_refused("image_bad.exr", AL_BAD_INPUT, "DWA");
    }
    write_bytes("image_bad.exr", "P6 1 1 255 abc", 14);
    check_refused("image_bad.exr", AL_BAD_INPUT, "not a readable OpenEXR file");
    check_refused("image_that_is_not_there.exr", AL_BAD_INPUT, "No such file");
    check_refused(".", AL_BAD_INPUT, "directory");
    al_image_free(&image);
}

/* Damaged bytes may be read or refused (the format has no checksums), but never crash or leak. */
static void test_damaged(void)
{
    al_error error;
    al_image image = make_image(1);
    size_t size;
    CHECK(al_image_write_exr("image_bad.exr", &image, &error) == AL_OK);
    al_image_free(&image);
    uint8_t *bytes = read_bytes("image_bad.exr", &size);
    int refused = 0;
    for (size_t i = 0; i < size; i += 1 + (i > 400 ? size / 200 : 0))
        for (int bit = 0; bit < 8; bit += 3) {
            bytes[i] ^= (uint8_t)(1 << bit);
            write_bytes("image_bad.exr", bytes, size);
            refused += al_image_read_exr("image_bad.exr", &image, &error) != AL_OK;
            al_image_free(&image);
            bytes[i] ^= (uint8_t)(1 << bit);
        }
    CHECK(refused > 0);
}

static void test_write_failures(void)
{
    al_error error = {0};
    al_image image = make_image(3);
    CHECK(al_image_write_exr("no/such/folder/image.exr", &image, &error) != AL_OK);
    CHECK(strstr(error.message, "no/such/folder") != NULL);
    image.channels = 2;
    CHECK(al_image_write_exr("image_bad.exr", &image, &error) == AL_USAGE);
    al_image_free(&image);
    uint8_t pixels[12] = {0};
    CHECK(al_image_write_png("image_bad.png", 0, 1, 3, pixels, &error) == AL_USAGE);
    CHECK(al_image_write_png("image_bad.png", 2, 2, 2, pixels, &error) == AL_USAGE);
    CHECK(access("image_bad.png", F_OK) != 0);
}

static void test_png(void)
{
    static const uint8_t signature[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    al_error error;
    for (uint32_t channels = 1; channels <= 4; channels++) {
        if (channels == 2) continue;
        uint8_t pixels[3 * 2 * 4];
        for (size_t i = 0; i < sizeof pixels; i++) pixels[i] = (uint8_t)(i * 10);
        CHECK(al_image_write_png("image_test.png", 3, 2, channels, pixels, &error) == AL_OK);
        size_t size;
        uint8_t *bytes = read_bytes("image_test.png", &size);
        CHECK(size > 40 && !memcmp(bytes, signature, 8));
        CHECK(bytes[19] == 3 && bytes[23] == 2 && bytes[24] == 8); /* IHDR: width, height, bit depth */
    }
}

static void test_srgb(void)
{
    /* IEC 61966-2-1: the linear part ends at 0.0031308, 0.5 encodes to 0.735357, 0.18 to 0.461356. */
    CHECK(al_srgb_byte(0) == 0 && al_srgb_byte(1) == 255 && al_srgb_byte(2) == 255 && al_srgb_byte(-1) == 0);
    CHECK(al_srgb_byte(NAN) == 0 && al_srgb_byte(INFINITY) == 255);
    CHECK(al_srgb_byte(0.5f) == 188 && al_srgb_byte(0.18f) == 118 && al_srgb_byte(0.0031308f) == 10);
}

int main(void)
{
    test_round_trip(1);
    test_round_trip(3);
    test_incompressible();
    test_variants();
    test_refused();
    test_damaged();
    test_write_failures();
    test_png();
    test_srgb();
    return test_end();
}
