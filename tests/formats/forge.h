/* Files in memory for the tests: load them, change their bytes, make their checksums right again. Written
 * from docs/formats.md, without the library's own layout. */
#ifndef AIRLIGHT_FORGE_H
#define AIRLIGHT_FORGE_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

typedef struct forged {
    uint8_t *data;
    size_t size;
} forged;

static inline uint64_t forge_get(const uint8_t *at, unsigned count)
{
    uint64_t value = 0;
    while (count--) value = value << 8 | at[count];
    return value;
}

static inline void forge_put(uint8_t *at, uint64_t value, unsigned count)
{
    for (unsigned i = 0; i < count; i++) at[i] = (uint8_t)(value >> 8 * i);
}

/* data is NULL when the file cannot be read. */
static inline forged forge_load(const char *path)
{
    forged f = {0};
    FILE *file = fopen(path, "rb");
    if (!file) return f;
    if (fseek(file, 0, SEEK_END) == 0 && ftell(file) >= 0) {
        f.size = (size_t)ftell(file);
        f.data = malloc(f.size + 1);
        rewind(file);
        if (f.data && fread(f.data, 1, f.size, file) != f.size) {
            free(f.data);
            f.data = NULL;
        }
    }
    fclose(file);
    return f;
}

static inline forged forge_copy(forged from)
{
    forged f = {malloc(from.size + 1), from.size};
    if (f.data && from.size) memcpy(f.data, from.data, from.size);
    return f;
}

static inline bool forge_save(const char *path, forged f)
{
    FILE *file = fopen(path, "wb");
    if (!file) return false;
    bool good = fwrite(f.data, 1, f.size, file) == f.size;
    return fclose(file) == 0 && good;
}

/* Where the table is, or 0 when header and table do not fit the size. */
static inline size_t forge_table(forged f, size_t *count)
{
    *count = 0;
    if (f.size < 128) return 0;
    uint64_t table = forge_get(f.data + 24, 8), chunks = forge_get(f.data + 32, 4);
    if (table < 128 || table > f.size || (f.size - table) / 48 < chunks) return 0;
    *count = (size_t)chunks;
    return (size_t)table;
}

/* The table entry of the nth chunk of `type`, or NULL. */
static inline uint8_t *forge_entry(forged f, const char *type, size_t n)
{
    size_t count, table = forge_table(f, &count);
    for (size_t i = 0; i < count; i++)
        if (!memcmp(f.data + table + 48 * i, type, 4) && n-- == 0) return f.data + table + 48 * i;
    return NULL;
}

static inline uint8_t *forge_chunk(forged f, const char *type, size_t n)
{
    uint8_t *entry = forge_entry(f, type, n);
    return entry ? f.data + forge_get(entry + 16, 8) : NULL;
}

static inline void forge_seal_header(forged f)
{
    size_t count, table = forge_table(f, &count);
    if (table) forge_put(f.data + 120, XXH64(f.data + table, f.size - table, XXH64(f.data, 120, 0)), 8);
}

/* Puts every checksum right whose chunk lies inside the file, and the header's. */
static inline void forge_seal(forged f)
{
    size_t count, table = forge_table(f, &count);
    for (size_t i = 0; i < count; i++) {
        uint8_t *entry = f.data + table + 48 * i;
        uint64_t offset = forge_get(entry + 16, 8), size = forge_get(entry + 24, 8);
        if (offset > f.size || size > f.size - offset) continue;
        size = (size + 63) / 64 * 64;
        if (size <= f.size - offset) forge_put(entry + 40, XXH64(f.data + offset, (size_t)size, 0), 8);
    }
    forge_seal_header(f);
}

#endif
