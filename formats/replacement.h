/* A file that takes its name only when it is whole: written beside it, synced, renamed, the folder synced. */
#ifndef AIRLIGHT_REPLACEMENT_H
#define AIRLIGHT_REPLACEMENT_H

#include <stddef.h>
#include <stdint.h>

#include "airlight/status.h"

typedef struct al_replacement {
    char *path, *temporary; /* temporary: PATH.PID-N.tmp; a killed writer leaves it, nothing ever reads it */
    int descriptor;
} al_replacement;

/* Every failure is AL_IO: what cannot be written is no bad input. */
al_status al_replacement_open(const char *path, al_replacement *replacement, al_error *error);
al_status al_replacement_write(al_replacement *replacement, uint64_t offset, const void *data, size_t size,
                               al_error *error);
/* Frees the replacement in every case; on failure the old file stands and the temporary one is gone. */
al_status al_replacement_commit(al_replacement *replacement, al_error *error);
void al_replacement_discard(al_replacement *replacement); /* safe on a discarded one */

#endif
