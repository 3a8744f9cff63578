/* The versioned binary container of every .air file. Layout and rules: docs/formats.md.
 *
 * Reading never copies: chunk data point into the mapping (64-byte aligned), valid until al_file_close.
 * Thread safety: an al_file may be read from many threads at once; a writer belongs to one thread. */
#ifndef AIRLIGHT_CONTAINER_H
#define AIRLIGHT_CONTAINER_H

#include <stddef.h>
#include <stdint.h>

#include "airlight/status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define AL_WRITER_NAME "airlight"

typedef enum al_kind {
    AL_KIND_NONE = 0,
    AL_KIND_SCENE = 1,
    AL_KIND_TRANSLUCENT = 2,
    AL_KIND_IMPULSE_TABLES = 3,
    AL_KIND_LIGHTMAP = 4,
    AL_KIND_PROBES = 5,
    AL_KIND_MEDIUM = 6
} al_kind;

const char *al_kind_name(al_kind kind); /* "scene", "translucent", ...; "unknown" else */

enum { AL_CHUNK_OPTIONAL = 1 }; /* a reader that does not know the type may skip the chunk */

typedef struct al_chunk {
    char type[5]; /* four ASCII characters and a terminator */
    uint16_t version;
    uint32_t flags;    /* AL_CHUNK_... */
    uint64_t offset;   /* from the start of the file, bytes, a multiple of 64 */
    uint64_t size;     /* bytes as stored */
    uint64_t raw_size; /* bytes after decoding; equal to size: format 1 stores no compressed chunks */
    uint64_t checksum; /* XXH64, seed 0, of the stored bytes and the zero padding behind them */
} al_chunk;

/* --- writing: beside, then sync, then rename. A kill at any moment leaves the old file or the new one --- */
typedef struct al_writer al_writer;

/* Opens a temporary file beside `path`. */
al_status al_writer_open(const char *path, al_kind kind, al_writer **writer, al_error *error);
/* Appends one chunk; `data` may be NULL when size is 0. */
al_status al_writer_add(al_writer *writer, const char type[5], uint16_t version, uint32_t flags,
                        const void *data, size_t size, al_error *error);
/* Writes the table and header, reads the file back with every check of its kind (AL_BAD_INPUT when the chunks
 * make no valid asset), syncs and renames. Frees the writer in every case. bytes may be NULL. */
al_status al_writer_commit(al_writer *writer, uint64_t *bytes, al_error *error);
/* Removes the temporary file and frees the writer. NULL is allowed. */
void al_writer_discard(al_writer *writer);

/* Writes a whole small file (JSON, CSV) with the same guarantee. */
al_status al_write_file(const char *path, const void *data, size_t size, al_error *error);

/* --- reading --- */
typedef struct al_file al_file;

typedef struct al_open_options {
    uint64_t size_limit; /* refuse larger files; 0: no limit */
    al_kind kind;        /* refuse other kinds; AL_KIND_NONE: any */
} al_open_options;

/* Maps a file and validates header and chunk table (not the chunks' own checksums: see al_file_data).
 * options may be NULL. */
al_status al_file_open(const char *path, const al_open_options *options, al_file **file, al_error *error);
/* The same on memory that outlives the al_file and is 8-byte aligned; `name` is used in messages. */
al_status al_file_from_memory(const char *name, const void *data, size_t size, const al_open_options *options,
                              al_file **file, al_error *error);
void al_file_close(al_file *file);

const char *al_file_name(const al_file *file);
al_kind al_file_kind(const al_file *file);
uint64_t al_file_size(const al_file *file);
uint16_t al_file_major(const al_file *file);
uint16_t al_file_minor(const al_file *file);
const char *al_file_writer(const al_file *file); /* name and version of the program that wrote it */
size_t al_file_chunk_count(const al_file *file);
const al_chunk *al_file_chunk(const al_file *file, size_t index);
/* Index of the nth chunk of `type` (n from 0) in a version that is known, or -1. */
ptrdiff_t al_file_find(const al_file *file, const char type[5], size_t n);
/* Verifies the chunk's checksum and answers its bytes. */
al_status al_file_data(const al_file *file, size_t index, const void **data, size_t *size, al_error *error);

/* --- validation: one checker for tests, fuzzers and airlight-inspect --- */
/* Called once per finding. `rule` is the permanent number of docs/formats.md. */
typedef void al_finding_fn(void *user, int rule, const char *message);
/* Checks every rule, the asset kind's own included; lists all it can find. Returns AL_OK when valid, else
 * AL_BAD_INPUT (error: the first finding), or AL_IO when it could not be read. */
al_status al_file_check(const char *path, al_finding_fn *on_finding, void *user, al_error *error);
al_status al_file_check_memory(const char *name, const void *data, size_t size, al_finding_fn *on_finding,
                               void *user, al_error *error);

#ifdef __cplusplus
}
#endif
#endif
