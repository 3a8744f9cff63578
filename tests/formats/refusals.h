/* The files that must be refused, and those of newer minor versions that must be read: each is a valid golden
 * file with a few bytes changed and, unless the change is about checksums, its checksums put right. */
#ifndef AIRLIGHT_REFUSALS_H
#define AIRLIGHT_REFUSALS_H

#include "forge.h"

enum { REFUSAL_CHANGES = 5 };

typedef enum change_target {
    CHANGE_NONE,
    CHANGE_HEADER, /* `at` bytes into the file */
    CHANGE_ENTRY,  /* into the table entry of the chunk */
    CHANGE_CHUNK,  /* into the chunk's bytes */
    CHANGE_EMPTY,  /* the chunk loses its bytes */
    CHANGE_SIZE    /* the file gets `value` bytes */
} change_target;

typedef struct change {
    change_target target;
    const char *type; /* of the chunk, and which of them */
    unsigned index;
    unsigned at, count; /* bytes to change */
    uint64_t value;
} change;

typedef enum seal { SEAL_ALL, SEAL_NOTHING } seal;

typedef struct refusal {
    int rule; /* 0: must be read */
    const char *name, *base;
    seal seal;
    change changes[REFUSAL_CHANGES];
} refusal;

extern const refusal refusals[];
extern const size_t refusal_count;

/* A new file in memory; free() its data. data is NULL when a change does not fit the base. */
forged refusal_make(const refusal *r, forged base);

#endif
