/* Rectangles into a box. */
#ifndef AIRLIGHT_PACK_H
#define AIRLIGHT_PACK_H

#include <stdbool.h>
#include <stdint.h>

#include "airlight/status.h"

typedef struct al_pack_rectangle {
    uint32_t width, height; /* with what must stay free to the right and below */
    uint32_t x, y;          /* where it went */
    bool packed;            /* false: there was no room; true: it has a place */
} al_pack_rectangle;

/* Puts the rectangles that are not yet packed into the smallest square, nearly, that takes them all, or as many
 * as go into a square of edge `limit`. Answers how many. Deterministic. Fails only without memory. */
al_status al_pack(al_pack_rectangle *rectangles, uint32_t count, uint32_t limit, uint32_t *packed,
                  al_error *error);

#endif
