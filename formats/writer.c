/* Writes containers: chunks as they come, then the table, then the header, whose place is zero until then. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "airlight/container.h"
#include "file_check.h"
#include "layout.h"
#include "replacement.h"

_Static_assert(sizeof AL_WRITER_NAME + sizeof AIRLIGHT_VERSION <= AL_WRITER_SIZE,
               "the writer's name fits the header");

struct al_writer {
    al_replacement file;
    al_kind kind;
    uint64_t offset; /* where the next chunk goes */
    uint8_t *table;  /* entries as stored */
    size_t count, capacity;
    XXH64_state_t *hash;
};

al_status al_writer_open(const char *path, al_kind kind, al_writer **writer, al_error *error)
{
    al_writer *made = calloc(1, sizeof *made);
    XXH64_state_t *hash = XXH64_createState();
    al_status status = made && hash ? al_replacement_open(path, &made->file, error)
                                    : al_fail(error, AL_IO, "%s: out of memory", path);
    *writer = NULL;
    if (status != AL_OK) {
        XXH64_freeState(hash);
        free(made);
        return status;
    }
    made->hash = hash;
    made->kind = kind;
    made->offset = AL_HEADER_SIZE;
    *writer = made;
    return AL_OK;
}

static al_status grow_table(al_writer *writer, al_error *error)
{
    if (writer->count < writer->capacity) return AL_OK;
    size_t capacity = writer->capacity ? 2 * writer->capacity : 16;
    uint8_t *table = capacity <= UINT32_MAX ? realloc(writer->table, capacity * AL_ENTRY_SIZE) : NULL;
    if (!table)
        return al_fail(error, AL_IO, "%s: out of memory for a table of %zu chunks", writer->file.path,
                       capacity);
    writer->table = table;
    writer->capacity = capacity;
    return AL_OK;
}

static uint64_t chunk_checksum(XXH64_state_t *hash, const void *data, size_t size, const uint8_t *padding,
                               size_t padding_size)
{
    XXH64_reset(hash, 0);
    if (size) XXH64_update(hash, data, size);
    XXH64_update(hash, padding, padding_size);
    return XXH64_digest(hash);
}

al_status al_writer_add(al_writer *writer, const char type[5], uint16_t version, uint32_t flags,
                        const void *data, size_t size, al_error *error)
{
    static const uint8_t padding[AL_ALIGNMENT];
    if (size > (uint64_t)INT64_MAX - AL_ALIGNMENT - writer->offset)
        return al_fail(error, AL_IO, "%s: a chunk of %zu bytes makes the file too large", writer->file.path,
                       size);
    size_t padding_size = (size_t)(al_padded(size) - size);
    al_status status = grow_table(writer, error);
    if (status == AL_OK) status = al_replacement_write(&writer->file, writer->offset, data, size, error);
    if (status == AL_OK)
        status = al_replacement_write(&writer->file, writer->offset + size, padding, padding_size, error);
    if (status != AL_OK) return status;
    uint8_t *entry = writer->table + writer->count++ * AL_ENTRY_SIZE;
    memset(entry, 0, AL_ENTRY_SIZE);
    memcpy(entry, type, 4);
    al_put_bytes(entry + 4, version, 2);
    al_put_bytes(entry + 8, flags, 4);
    al_put_bytes(entry + 16, writer->offset, 8);
    al_put_bytes(entry + 24, size, 8);
    al_put_bytes(entry + 32, size, 8);
    al_put_bytes(entry + 40, chunk_checksum(writer->hash, data, size, padding, padding_size), 8);
    writer->offset += al_padded(size);
    return AL_OK;
}

static void make_header(const al_writer *writer, uint64_t file_size, uint8_t header[AL_HEADER_SIZE])
{
    memset(header, 0, AL_HEADER_SIZE);
    memcpy(header, al_magic, AL_MAGIC_SIZE);
    al_put_bytes(header + 8, AL_FORMAT_MAJOR, 2);
    al_put_bytes(header + 10, AL_FORMAT_MINOR, 2);
    al_put_bytes(header + 12, writer->kind, 4);
    al_put_bytes(header + 16, file_size, 8);
    al_put_bytes(header + 24, writer->offset, 8);
    al_put_bytes(header + 32, writer->count, 4);
    snprintf((char *)header + AL_WRITER_OFFSET, AL_WRITER_SIZE, "%s %s", AL_WRITER_NAME, AIRLIGHT_VERSION);
    uint64_t checksum = al_header_checksum(header, writer->table, writer->count * AL_ENTRY_SIZE);
    al_put_bytes(header + AL_HEADER_CHECKED_SIZE, checksum, 8);
}

al_status al_writer_commit(al_writer *writer, uint64_t *bytes, al_error *error)
{
    uint8_t header[AL_HEADER_SIZE];
    size_t table_size = writer->count * AL_ENTRY_SIZE;
    uint64_t file_size = writer->offset + table_size;
    make_header(writer, file_size, header);
    al_status status = al_replacement_write(&writer->file, writer->offset, writer->table, table_size, error);
    if (status == AL_OK) status = al_replacement_write(&writer->file, 0, header, sizeof header, error);
    /* Nothing that a reader would refuse takes the name of an asset. */
    if (status == AL_OK)
        status = al_file_check_as(writer->file.temporary, writer->file.path, NULL, NULL, error);
    if (status == AL_OK) status = al_replacement_commit(&writer->file, error);
    if (bytes) *bytes = status == AL_OK ? file_size : 0;
    al_writer_discard(writer);
    return status;
}

void al_writer_discard(al_writer *writer)
{
    if (!writer) return;
    al_replacement_discard(&writer->file);
    XXH64_freeState(writer->hash);
    free(writer->table);
    free(writer);
}
