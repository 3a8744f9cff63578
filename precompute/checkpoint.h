/* A bake's unfinished work on disk, so that a cancelled bake goes on where it was. */
#ifndef AIRLIGHT_CHECKPOINT_H
#define AIRLIGHT_CHECKPOINT_H

#include <stddef.h>
#include <stdint.h>

#include "airlight/status.h"

enum { AL_CHECKPOINT_ARRAYS = 8 };

typedef struct al_checkpoint {
    uint64_t key; /* of the asset it belongs to */
    uint32_t stage, channel, axis, next;
    double numbers[8];
    struct {
        void *data;
        uint64_t size;
    } arrays[AL_CHECKPOINT_ARRAYS];
} al_checkpoint;

/* Writes atomically; arrays with size 0 are kept empty. */
al_status al_checkpoint_write(const char *path, const al_checkpoint *checkpoint, al_error *error);
/* Reads what belongs to `key`. A missing, foreign or damaged file is no error: stage 0, no arrays. */
void al_checkpoint_read(const char *path, uint64_t key, al_checkpoint *checkpoint);
void al_checkpoint_free(al_checkpoint *checkpoint);
/* Takes array `index` out when it has exactly `size` bytes, else NULL; the caller frees it. */
void *al_checkpoint_take(al_checkpoint *checkpoint, unsigned index, uint64_t size);

#endif
