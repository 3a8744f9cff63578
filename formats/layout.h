/* Numbers of the container's layout and little-endian access, byte by byte. Specification: docs/formats.md.
 */
#ifndef AIRLIGHT_LAYOUT_H
#define AIRLIGHT_LAYOUT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* Arrays of numbers are handed out as they lie in the file. */
#if !defined(__BYTE_ORDER__) || __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "airlight reads its arrays in place: a big-endian host needs a copying reader"
#endif

enum {
    AL_FORMAT_MAJOR = 1,
    AL_FORMAT_MINOR = 0,
    AL_ALIGNMENT = 64,
    AL_MAGIC_SIZE = 8,
    AL_HEADER_SIZE = 128,
    AL_HEADER_CHECKED_SIZE = 120, /* what the checksum in the header covers of the header */
    AL_ENTRY_SIZE = 48,
    AL_WRITER_OFFSET = 40,
    AL_WRITER_SIZE = 64,
    AL_RESERVED_OFFSET = 104,
    AL_RESERVED_SIZE = 16
};

#define AL_FLAGS_IGNORABLE 0xffff0000u /* a reader may ignore flags it does not know among these */

extern const uint8_t al_magic[AL_MAGIC_SIZE];

/* Covers every byte of header and table but the checksum itself. */
uint64_t al_header_checksum(const uint8_t header[AL_HEADER_SIZE], const uint8_t *table, size_t table_size);

/* Smallest multiple of the alignment that is not below `size`; sizes near UINT64_MAX are the caller's bug. */
static inline uint64_t al_padded(uint64_t size)
{
    return (size + AL_ALIGNMENT - 1) & ~(uint64_t)(AL_ALIGNMENT - 1);
}

static inline uint64_t al_get_bytes(const uint8_t *bytes, unsigned count)
{
    uint64_t value = 0;
    for (unsigned i = 0; i < count; i++) value |= (uint64_t)bytes[i] << 8 * i;
    return value;
}

static inline uint16_t al_get_u16(const uint8_t *bytes)
{
    return (uint16_t)al_get_bytes(bytes, 2);
}
static inline uint32_t al_get_u32(const uint8_t *bytes)
{
    return (uint32_t)al_get_bytes(bytes, 4);
}
static inline uint64_t al_get_u64(const uint8_t *bytes)
{
    return al_get_bytes(bytes, 8);
}

static inline void al_put_bytes(uint8_t *bytes, uint64_t value, unsigned count)
{
    for (unsigned i = 0; i < count; i++) bytes[i] = (uint8_t)(value >> 8 * i);
}

static inline bool al_all_zero(const uint8_t *bytes, uint64_t count)
{
    for (uint64_t i = 0; i < count; i++)
        if (bytes[i]) return false;
    return true;
}

#endif
