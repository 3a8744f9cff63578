/* The files an import reads: whole in memory, hashed as read, each listed once. */
#ifndef AIRLIGHT_INPUTS_H
#define AIRLIGHT_INPUTS_H

#include <stddef.h>
#include <stdint.h>

#include "import.h"

/* Reads a whole file into `bytes` (free() it; 16 bytes of zero follow) and notes it in `import`. */
al_status al_inputs_read(al_import *import, const char *path, uint8_t **bytes, size_t *size, al_error *error);

/* Notes a file that another library reads by itself. */
al_status al_inputs_hash(al_import *import, const char *path, al_error *error);

#endif
