/* A second reader, written from docs/formats.md alone and sharing nothing with the library but XXH64: reads
 * the golden files' header, table, checksums and fields. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "../test.h"

typedef struct source {
    unsigned char bytes[1 << 16];
    size_t size;
} source;

static uint64_t number(const source *s, size_t at, int count)
{
    uint64_t value = 0;
    for (int i = count - 1; i >= 0; i--)
        value = 256 * value + (at + (size_t)i < s->size ? s->bytes[at + (size_t)i] : 0);
    return value;
}

/* binary32 by its definition, not by its bits in memory. */
static double real(const source *s, size_t at)
{
    uint32_t bits = (uint32_t)number(s, at, 4);
    int exponent = (int)(bits >> 23 & 255), fraction = (int)(bits & 0x7fffff);
    double value = exponent ? ldexp(0x800000 + fraction, exponent - 150) : ldexp(fraction, -149);
    return bits >> 31 ? -value : value;
}

/* binary16 by its definition. */
static double half(const source *s, size_t at)
{
    int bits = (int)number(s, at, 2), exponent = bits >> 10 & 31, fraction = bits & 1023;
    double value = exponent ? ldexp(1024 + fraction, exponent - 25) : ldexp(fraction, -24);
    return bits >> 15 ? -value : value;
}

static source *load(const char *name)
{
    static source s;
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", AIRLIGHT_GOLDEN, name);
    FILE *file = fopen(path, "rb");
    if (!file) {
        fprintf(stderr, "%s: missing\n", path);
        exit(1);
    }
    s.size = fread(s.bytes, 1, sizeof s.bytes, file);
    fclose(file);
    return &s;
}

/* Offset of the nth chunk of a type; its size in *size. */
static size_t chunk(const source *s, const char *type, int n, size_t *size)
{
    size_t table = number(s, 24, 8), count = number(s, 32, 4);
    for (size_t i = 0; i < count; i++) {
        size_t entry = table + 48 * i;
        if (memcmp(s->bytes + entry, type, 4) || n--) continue;
        *size = number(s, entry + 24, 8);
        return number(s, entry + 16, 8);
    }
    *size = 0;
    return 0;
}

static unsigned is_optional(const unsigned char *type)
{
    static const char types[] = "PROV INLI FOGS BAKD NODE CHAN BIND JONT DEFM KEYS SHAP SKYI SKYL SKYC DEPI DEPL";
    for (size_t i = 0; i < sizeof types - 1; i += 5)
        if (!memcmp(type, types + i, 4)) return 1;
    return 0;
}

static void check_container(const source *s, unsigned kind)
{
    static const unsigned char magic[] = {0x8b, 0x41, 0x49, 0x52, 0x0d, 0x0a, 0x1a, 0x0a};
    size_t table = number(s, 24, 8), count = number(s, 32, 4), next = 128;
    CHECK(!memcmp(s->bytes, magic, 8) && number(s, 8, 2) == 1 && number(s, 10, 2) == 0 &&
          number(s, 12, 4) == kind);
    CHECK(number(s, 16, 8) == s->size && table + 48 * count == s->size && number(s, 36, 4) == 0);
    CHECK(!strncmp((const char *)s->bytes + 40, "airlight ", 9) && s->bytes[103] == 0);
    CHECK(number(s, 120, 8) == XXH64(s->bytes + table, 48 * count, XXH64(s->bytes, 120, 0)));
    for (size_t entry = table; entry < s->size; entry += 48) {
        size_t size = number(s, entry + 24, 8), padded = (size + 63) & ~(size_t)63;
        CHECK(number(s, entry + 16, 8) == next && number(s, entry + 32, 8) == size &&
              number(s, entry + 4, 2) == 1);
        CHECK(number(s, entry + 40, 8) == XXH64(s->bytes + next, padded, 0));
        CHECK(number(s, entry + 8, 4) == is_optional(s->bytes + entry));
        for (size_t i = size; i < padded; i++) CHECK(s->bytes[next + i] == 0);
        next += padded;
    }
    CHECK(next == table);
}

static size_t up(size_t size)
{
    return (size + 63) / 64 * 64;
}

/* translucent_byte: five samples in pages of two, RGB, order 2; values as in golden_data.c. */
static void check_translucent(void)
{
    const source *s = load("translucent_byte_1_0.air");
    size_t size, info = chunk(s, "INFO", 0, &size);
    check_container(s, 2);
    CHECK(size == 148 && number(s, info, 4) == 5 && number(s, info + 4, 4) == 2 &&
          number(s, info + 8, 4) == 2);
    CHECK(number(s, info + 12, 4) == 3 && number(s, info + 16, 4) == 2 && number(s, info + 20, 4) == 128);
    CHECK(number(s, info + 24, 4) == 3 && number(s, info + 32, 4) == 2 && number(s, info + 36, 4) == 1);
    CHECK(real(s, info + 40) == -0.75 && real(s, info + 52) == 0.5 && real(s, info + 56) == 2 &&
          real(s, info + 68) == 4);
    CHECK(real(s, info + 72) == 0.5 && real(s, info + 84) == -0.25 && real(s, info + 88) == 1.5 &&
          real(s, info + 96) == -0.375);
    CHECK(real(s, info + 112) == 0.625 && number(s, info + 116, 8) == 0x3fe0000000000000 &&
          number(s, info + 124, 8) == 0x3fb0000000000000);
    CHECK(real(s, info + 132) == 3 && real(s, info + 136) == 0.9375 && real(s, info + 140) == 0.0625 &&
          real(s, info + 144) == 0.5);
    size_t grid = chunk(s, "GRID", 0, &size);
    CHECK(size == 24 && number(s, grid + 2 * 11, 2) == 65535 - 55000);
    size_t blockers = chunk(s, "BLOK", 0, &size);
    CHECK(size == 12 && number(s, blockers + 11, 1) == 220);
    for (int i = 0; i < 5; i++) {
        int count = i < 4 ? 2 : 1, in_page = i % 2;
        size_t page = chunk(s, "PAGE", i / 2, &size), gaussians = up(12 * (size_t)count);
        size_t scales = up(gaussians + 16 * (size_t)count), coefficients = up(scales + 12 * (size_t)count);
        CHECK(size == coefficients + 12 * (size_t)count);
        CHECK(real(s, page + 12 * (size_t)in_page) == -0.25 + 0.125 * i &&
              real(s, page + gaussians + 16 * (size_t)in_page + 4) == 1 - 0.125 * i);
        for (int k = 0; k < 12; k++) {
            double scale = real(s, page + scales + 4 * (size_t)(3 * in_page + k / 4));
            double value =
                (double)(int8_t)number(s, page + coefficients + (size_t)(12 * in_page + k), 1) / 127 * scale;
            double wanted = k % 4 == 0 ? 2.5 - 0.125 * i : 0.375 / (k + 1) * (k % 2 ? 1 : -1);
            CHECK(scale == 2.5 - 0.125 * i);
            CHECK_NEAR(value, wanted, scale / 254 + 1e-6);
        }
    }
    chunk(s, "PAGE", 3, &size);
    CHECK(size == 0);
}

/* f16 of translucent_half: one page of four samples, order 3. */
static void check_half(void)
{
    const source *s = load("translucent_half_1_0.air");
    size_t size, page = chunk(s, "PAGE", 0, &size), coefficients = up(up(12 * 4) + 16 * 4);
    check_container(s, 2);
    CHECK(size == coefficients + 4 * 9 * 2);
    for (int i = 0; i < 4 * 9; i++) {
        double value = half(s, page + coefficients + 2 * (size_t)i);
        double wanted = i % 9 == 0 ? 2.5 - 0.125 * (i / 9) : 0.375 / (i % 9 + 1) * (i % 9 % 2 ? 1 : -1);
        CHECK_NEAR(value, wanted, fabs(wanted) * 0x1p-11);
    }
}

static int text_is(const source *s, size_t at, const char *text)
{
    size_t size, texts = chunk(s, "TEXT", 0, &size);
    return !strcmp((const char *)s->bytes + texts + number(s, at, 4), text);
}

static void check_scene(void)
{
    const source *s = load("scene_1_0.air");
    size_t size, head = chunk(s, "SCEN", 0, &size);
    static const unsigned counts[] = {1, 2, 2, 3, 1, 1, 2, 1, 2, 1};
    check_container(s, 1);
    CHECK(size == 824);
    for (size_t i = 0; i < 10; i++) CHECK(number(s, head + 4 * i, 4) == counts[i]);
    CHECK(real(s, head + 40 + 4 * 64) == 2 && real(s, head + 808) == 0.5 && real(s, head + 820) == 0.5);
    size_t at = chunk(s, "TEXR", 0, &size);
    CHECK(size == 16 && text_is(s, at, "checker") && number(s, at + 4, 4) == 2 && number(s, at + 12, 4) == 1);
    at = chunk(s, "MATL", 0, &size) + 60;
    CHECK(size == 120 && text_is(s, at, "wax") && real(s, at + 16) == 0.25 && real(s, at + 28) == 2 &&
          real(s, at + 36) == 1.25);
    CHECK(number(s, at + 40, 4) == 0 && number(s, at + 44, 4) == 0xffffffff && number(s, at + 48, 4) == 0);
    at = chunk(s, "MESH", 0, &size);
    CHECK(size == 48 && text_is(s, at, "quad") && number(s, at + 4, 4) == 4 && number(s, at + 8, 4) == 6 &&
          number(s, at + 12, 4) == 2);
    CHECK(number(s, at + 16, 4) == 1 && number(s, at + 24 + 16, 4) == 0);
    at = chunk(s, "SUBM", 0, &size);
    CHECK(size == 36 && number(s, at + 12, 4) == 3 && number(s, at + 20, 4) == 1 &&
          number(s, at + 28, 4) == 12);
    at = chunk(s, "INST", 0, &size) + 160;
    CHECK(size == 240 && text_is(s, at, "wick") && number(s, at + 4, 4) == 1 && number(s, at + 8, 4) == 2 &&
          number(s, at + 12, 4) == 0);
    CHECK(real(s, at + 16) == 0.25 && real(s, at + 16 + 4 * 12) == 0.125);
    at = chunk(s, "MEDI", 0, &size);
    CHECK(size == 32 && text_is(s, at, "wax") && real(s, at + 4) == 8 && real(s, at + 24) == 1 &&
          real(s, at + 28) == 0.5);
    at = chunk(s, "TRAN", 0, &size);
    CHECK(size == 16 && text_is(s, at, "candle") && number(s, at + 4, 4) == 1 &&
          text_is(s, at + 12, "candle.translucent.air"));
    at = chunk(s, "LITE", 0, &size) + 32;
    CHECK(size == 64 && text_is(s, at, "lamp") && number(s, at + 4, 4) == 1 && real(s, at + 16) == 3 &&
          real(s, at + 28) == 30);
    at = chunk(s, "CAMR", 0, &size);
    CHECK(size == 44 && text_is(s, at, "main") && real(s, at + 4) == 2 && real(s, at + 20) == 0.25 &&
          real(s, at + 32) == 1 && real(s, at + 40) == 0.75);
    at = chunk(s, "GEOM", 0, &size);
    CHECK(size == 4 * 64 + 24 && real(s, at) == -1 && real(s, at + 64 + 4) == 1 &&
          real(s, at + 128 + 12) == 1 && real(s, at + 192 + 12) == 0.75);
    CHECK(number(s, at + 256 + 16, 4) == 2);
    at = chunk(s, "GEOM", 1, &size);
    CHECK(size == 128 + 48 && number(s, at + 128 + 4, 4) == 2);
    at = chunk(s, "PIXL", 0, &size);
    CHECK(size == 16 && s->bytes[at + 15] == 128);
    at = chunk(s, "ENVM", 0, &size);
    CHECK(size == 24 && real(s, at + 4) == 0.75);
}

static void check_lit_scene(void)
{
    const source *s = load("scene_lit_1_0.air");
    size_t size, at = chunk(s, "INLI", 0, &size);
    check_container(s, 1);
    CHECK(size == 12 && number(s, at, 4) == 1 && number(s, at + 4, 4) == 0);
    at = chunk(s, "FOGS", 0, &size);
    CHECK(size == 80 && number(s, at + 4, 4) == 0 && real(s, at + 32) == 0.5 && text_is(s, at + 36, ""));
    at += 40;
    CHECK(number(s, at, 4) == 0 && number(s, at + 4, 4) == 1 && real(s, at + 8) == -2 &&
          real(s, at + 28) == 0.5 && text_is(s, at + 36, "smoke.medium.air"));
    at = chunk(s, "BAKD", 0, &size);
    CHECK(size == 8 && text_is(s, at, "room.lightmap.air") && text_is(s, at + 4, "room.probes.air"));
}

static void check_moving_scene(void)
{
    const source *s = load("scene_moving_1_0.air");
    size_t size, at = chunk(s, "NODE", 0, &size);
    check_container(s, 1);
    CHECK(size == 224 && text_is(s, at, "root") && number(s, at + 4, 4) == 0xffffffff && real(s, at + 8) == 2 &&
          real(s, at + 56) == 0.5);
    at += 112;
    CHECK(text_is(s, at, "hand") && number(s, at + 4, 4) == 0 && real(s, at + 76) == 1 && real(s, at + 84 + 12) > 0.79 &&
          real(s, at + 104) == 0.5);
    at = chunk(s, "CHAN", 0, &size) + 20;
    CHECK(size == 60 && number(s, at, 4) == 1 && number(s, at + 4, 4) == 1 && number(s, at + 8, 4) == 2 &&
          number(s, at + 12, 4) == 2 && number(s, at + 16, 4) == 4);
    /* 3 keys of 3 numbers, 2 of 3 x 4, 2 of 1: the cubic's first value is (0, 0, 0, 1) */
    at = chunk(s, "KEYS", 0, &size);
    CHECK(size == 4 * (3 * 4 + 2 * 13 + 2 * 2) && real(s, at + 8) == 2 && real(s, at + 4 * 14) == 0 &&
          real(s, at + 4 * (12 + 2 + 7)) == 1 && real(s, at + 4 * 41) == 0.75);
    at = chunk(s, "BIND", 0, &size);
    CHECK(size == 3 * 76 && number(s, at + 76, 4) == 1 && number(s, at + 80, 4) == 1 && number(s, at + 84, 4) == 1 &&
          real(s, at + 12) == 0.5);
    at = chunk(s, "JONT", 0, &size);
    CHECK(size == 2 * 68 && number(s, at + 68, 4) == 1 && real(s, at + 68 + 4 + 52) == -1);
    at = chunk(s, "DEFM", 0, &size);
    CHECK(size == 24 && number(s, at, 4) == 3 && number(s, at + 4, 4) == 1 && number(s, at + 12, 4) == 2 &&
          number(s, at + 16, 4) == 1 && number(s, at + 20, 4) == 1);
    at = chunk(s, "SHAP", 0, &size);
    CHECK(size == 320 + 48 && real(s, at + 12) == 1 && number(s, at + 128 + 8, 2) == 1 && real(s, at + 192 + 16) == 0.75 &&
          real(s, at + 256 + 12) == 0.25 && real(s, at + 320 + 16) == 0.5);
}

/* Tables of 3 bands at 4 distances; the area emitter's at 7 cosines with m <= 2; the eighth is resolved by two
 * angles. */
static void check_impulse_tables(void)
{
    const source *s = load("impulse_tables_1_0.air");
    size_t size, at = chunk(s, "INFO", 0, &size);
    check_container(s, 3);
    CHECK(size == 44 && number(s, at, 4) == 3 && number(s, at + 4, 4) == 2 && number(s, at + 8, 4) == 10);
    CHECK(number(s, at + 12, 8) == 0x3f50000000000000 && number(s, at + 20, 8) == 0x4090000000000000 &&
          number(s, at + 28, 8) == 0x3ef0000000000000 && number(s, at + 36, 8) == 0x3f20000000000000);
    for (int t = 0; t < 10; t++) {
        static const unsigned numbers[] = {3, 3, 3, 3, 6, 6, 4, 3, 3, 3};
        at = chunk(s, "TABL", t, &size);
        unsigned cosines = t >= 4 && t <= 6 ? 7 : 1, angles = t == 7 ? 2 : 0;
        size_t values = 64 + up(4 * angles), count = (size_t)(angles ? 2 : 1) * cosines * 4 * numbers[t];
        CHECK(size == values + 4 * count && number(s, at + 16, 4) == 4 && number(s, at + 20, 4) == cosines &&
              number(s, at + 24, 4) == angles && number(s, at + 28, 4) == numbers[t]);
        CHECK(real(s, at + 32) == (t == 8 ? -0.5 : 0) && number(s, at + 4, 4) == (t == 6));
        for (size_t i = 0; i < count; i++)
            CHECK_NEAR(real(s, at + values + 4 * i),
                       i % numbers[t] == 0 ? 1 + (double)i / 64 : (t + 1) / (i + 2.0), 1e-6);
    }
    at = chunk(s, "TABL", 7, &size);
    CHECK(number(s, at, 4) == 0 && number(s, at + 8, 4) == 1 && number(s, at + 12, 4) == 1 &&
          real(s, at + 64) == -1.5 && real(s, at + 68) == 0.75);
    at = chunk(s, "TABL", 9, &size);
    CHECK(number(s, at + 8, 4) == 1 && number(s, at + 12, 4) == 2);
}

/* lightmap_half: pages of 4 x 3 and 2 x 2 texels, SH of order 2; the scale is a power of two. */
static void check_lightmap(void)
{
    const source *s = load("lightmap_half_1_0.air");
    size_t size, at = chunk(s, "INFO", 0, &size);
    check_container(s, 4);
    CHECK(size == 28 && number(s, at, 4) == 2 && number(s, at + 4, 4) == 2 && number(s, at + 8, 4) == 1 &&
          number(s, at + 12, 4) == 2 && number(s, at + 16, 4) == 8 && number(s, at + 20, 4) == 4 &&
          real(s, at + 24) == 0.25);
    at = chunk(s, "INST", 0, &size) + 32;
    CHECK(size == 64 && number(s, at, 4) == 2 && number(s, at + 4, 4) == 1 && real(s, at + 8) == 0.5 &&
          real(s, at + 12) == 0.75 && real(s, at + 16) == 0.25 && real(s, at + 20) == 0.125 &&
          number(s, at + 24, 4) == 2 && number(s, at + 28, 4) == 2);
    at = chunk(s, "VERT", 0, &size) + 20 * 6;
    CHECK(size == 160 && real(s, at) == 3 && real(s, at + 4) == 0.5 && real(s, at + 8) == 1 &&
          real(s, at + 12) == 0.75 && real(s, at + 16) == 0.875);
    at = chunk(s, "TRIS", 0, &size);
    CHECK(size == 48 && number(s, at + 4 * 11, 4) == 7);
    for (int p = 0; p < 2; p++) {
        size_t head = chunk(s, "PAGS", 0, &size) + 32 * (size_t)p;
        size_t texels = number(s, head, 4) * number(s, head + 4, 4);
        CHECK(size == 64 && texels == (p ? 4 : 12));
        at = chunk(s, "PAGE", p, &size);
        size_t layer_size = up(6 * texels), sh_size = up(24 * texels);
        CHECK(size == 3 * layer_size + 3 * sh_size + texels);
        for (size_t layer = 0; layer < 3; layer++)
            for (size_t i = 0; i < 3 * texels; i++) {
                double wanted = 0.125 * (double)(layer + 1) * (double)(i / 3 + 1) + 0.25 * (double)(i % 3);
                double value = half(s, at + layer * layer_size + 2 * i) * real(s, head + 8 + 4 * layer);
                CHECK(value == wanted);
                size_t sh = at + 3 * layer_size + layer * sh_size;
                CHECK_NEAR(half(s, sh + 2 * (3 * texels * 3 + i)) * real(s, head + 20 + 4 * layer),
                           -0.125 * (double)(layer + 1), 1e-9);
            }
        for (size_t i = 0; i < texels; i++)
            CHECK(s->bytes[at + 3 * layer_size + 3 * sh_size + i] == 3 - i % 3);
    }
}

/* medium: 10 x 2 x 9 voxels in two cells; values as in golden_data.c. */
static void check_medium(void)
{
    const source *s = load("medium_1_0.air");
    size_t size, at = chunk(s, "INFO", 0, &size);
    check_container(s, 6);
    CHECK(size == 140 && number(s, at, 4) == 10 && number(s, at + 4, 4) == 2 && number(s, at + 8, 4) == 9);
    CHECK(number(s, at + 12, 4) == 1 && number(s, at + 16, 4) == 2 && number(s, at + 20, 4) == 1);
    CHECK(real(s, at + 24) == 0.5 && real(s, at + 24 + 4 * 12) == -2 && real(s, at + 84) == 1);
    CHECK(real(s, at + 88) == -2.5 && real(s, at + 100) == 2.75 && real(s, at + 112 + 8) == 4 &&
          real(s, at + 124) == 0.5 && real(s, at + 136) == 0.75);
    at = chunk(s, "FRAM", 0, &size);
    CHECK(size == 24 && real(s, at) == 0.5 && real(s, at + 4) == 2 && number(s, at + 8, 4) == 1);
    CHECK(real(s, at + 12) == 1 && real(s, at + 16) == 4 && number(s, at + 20, 4) == 2);
    at = chunk(s, "INDX", 0, &size);
    CHECK(size == 8 && number(s, at, 4) == 0xffffffff && number(s, at + 4, 4) == 0);
    at = chunk(s, "INDX", 1, &size);
    CHECK(size == 8 && number(s, at, 4) == 0 && number(s, at + 4, 4) == 1);
    for (int page = 0; page < 3; page++) {
        at = chunk(s, "PAGE", page, &size);
        CHECK(size == 2 * 9 * 9 * 9);
        for (int i = 0; i < 729; i++) {
            int x = i % 9 + (page == 1 ? 0 : 8), y = i / 9 % 9, z = i / 81;
            if (x > 9 || y > 1) continue; /* beyond the last voxel nothing counts */
            double wanted = page == 0 ? (x == 9 ? 2 : 0) : x < 8 ? 4 : 1 + y / 2.0 + z / 8.0;
            CHECK(half(s, at + 2 * (size_t)i) / 32768 * (page ? 4 : 2) == wanted);
        }
    }
    chunk(s, "PAGE", 3, &size);
    CHECK(size == 0);
}

/* The sky's light as documented: 3 x 2 x 2 points of order 2, the largest number 4.5. */
static void check_medium_sky(void)
{
    const source *s = load("medium_sky_1_0.air");
    size_t size, at = chunk(s, "SKYI", 0, &size);
    check_container(s, 6);
    CHECK(size == 36 && number(s, at, 4) == 3 && number(s, at + 4, 4) == 2 && number(s, at + 8, 4) == 2);
    CHECK(number(s, at + 12, 4) == 2 && real(s, at + 16) == 0 && real(s, at + 20) == 1.5);
    double unit = real(s, at + 28);
    CHECK(unit == 8.0 / 32768 && number(s, at + 32, 4) == 1);
    at = chunk(s, "SKYL", 0, &size);
    CHECK(size == 2 * 5 * 12 * 3);
    for (size_t k = 0; k < 180; k++) {
        double n = (double)(k / 36), point = (double)(k / 3 % 12), channel = (double)(k % 3);
        double value = half(s, at + 2 * k) * (n > 0 ? unit : 1);
        CHECK(value == (n > 0 ? n + channel / 4 - point / 16 : point / 4));
    }
    at = chunk(s, "SKYC", 0, &size);
    CHECK(size == 16 && number(s, at + 7, 1) == 63 && number(s, at + 8, 1) == 55 && number(s, at + 9, 1) == 62);
}

/* Optical depths as documented: 2 x 2 x 2 points of order 2; the bounds' edges are 5.25, 2 and 1.75 m. */
static void check_medium_depth(void)
{
    const source *s = load("medium_depth_1_0.air");
    size_t size, at = chunk(s, "DEPI", 0, &size);
    check_container(s, 6);
    CHECK(size == 16 && number(s, at, 4) == 2 && number(s, at + 4, 4) == 2 && number(s, at + 8, 4) == 2);
    CHECK(number(s, at + 12, 4) == 2);
    for (int frame = 0; frame < 2; frame++) {
        at = chunk(s, "DEPL", frame, &size);
        CHECK(size == 64);
        for (size_t k = 0; k < 32; k++)
            CHECK(half(s, at + 2 * k) == (double)(k / 8) + 1 - 0.25 * (double)(k % 8) + 8 * frame);
    }
}

/* probes: five probes of order 2, the face 1 2 3 between two tetrahedra. */
static void check_probes(void)
{
    const source *s = load("probes_1_0.air");
    size_t size, at = chunk(s, "INFO", 0, &size);
    check_container(s, 5);
    CHECK(size == 12 && number(s, at, 4) == 5 && number(s, at + 4, 4) == 2 && number(s, at + 8, 4) == 2);
    at = chunk(s, "POSI", 0, &size);
    CHECK(size == 60 && real(s, at + 12) == 1 && real(s, at + 48) == 1);
    at = chunk(s, "TETR", 0, &size);
    CHECK(size == 32 && number(s, at, 4) == 0 && number(s, at + 16, 4) == 1 && number(s, at + 28, 4) == 4);
    at = chunk(s, "NEIG", 0, &size);
    for (size_t i = 0; i < 8; i++)
        CHECK(number(s, at + 4 * i, 4) == (i == 0 ? 1 : i == 7 ? 0 : 0xffffffff));
    CHECK(size == 32);
    at = chunk(s, "COEF", 0, &size);
    CHECK(size == 5 * 3 * 3 * 4 * 4);
    for (size_t i = 0; i < 180; i += 4) {
        CHECK(real(s, at + 4 * i) == 1 + 0.25 * (double)(i / 36) + 0.125 * (double)(i / 12 % 3) + 0.0625 * (double)(i / 4 % 3));
        CHECK(real(s, at + 4 * i + 12) == -0.09375);
    }
}

int main(void)
{
    check_impulse_tables();
    check_lightmap();
    check_medium();
    check_medium_sky();
    check_medium_depth();
    check_probes();
    check_translucent();
    check_half();
    check_scene();
    check_lit_scene();
    check_moving_scene();
    return test_end();
}
