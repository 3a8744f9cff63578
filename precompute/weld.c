#include "weld.h"

#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

al_status al_weld(const void *records, size_t size, uint32_t count, uint32_t *map, uint32_t *distinct_count,
                  al_error *error)
{
    const char *bytes = records;
    size_t slots = 16;
    while (slots < (size_t)count * 2) slots *= 2;
    uint32_t *table = calloc(slots, sizeof *table); /* 1 + index of a record's first appearance; 0: free */
    *distinct_count = 0;
    if (!table) return al_fail(error, AL_IO, "out of memory while joining %u vertices", count);
    for (uint32_t i = 0; i < count; i++) {
        const char *record = bytes + i * size;
        size_t slot = XXH64(record, size, 0) & (slots - 1);
        while (table[slot] && memcmp(bytes + (table[slot] - 1) * size, record, size) != 0)
            slot = (slot + 1) & (slots - 1);
        if (table[slot]) {
            map[i] = map[table[slot] - 1];
        } else {
            table[slot] = i + 1;
            map[i] = (*distinct_count)++;
        }
    }
    free(table);
    return AL_OK;
}
