/* Finding equal records: vertices that are the same point, or the same vertex altogether. */
#ifndef AIRLIGHT_WELD_H
#define AIRLIGHT_WELD_H

#include <stddef.h>
#include <stdint.h>

#include "airlight/status.h"

/* `records` holds `count` records of `size` bytes, compared byte by byte (write 0.0 for -0.0 first).
 * map[i] becomes the number of i's record among the distinct ones, counted in order of first appearance;
 * `map` has room for `count`. Fails only without memory. */
al_status al_weld(const void *records, size_t size, uint32_t count, uint32_t *map, uint32_t *distinct_count,
                  al_error *error);

#endif
