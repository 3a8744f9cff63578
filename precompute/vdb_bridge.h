/* OpenVDB behind C: one float grid as a dense box. */
#ifndef AIRLIGHT_VDB_BRIDGE_H
#define AIRLIGHT_VDB_BRIDGE_H

#include <stdint.h>

#include "airlight/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct al_vdb_grid { /* the box of the grid's active voxels */
    uint32_t size[3];
    float *values;             /* [z][y][x], x fastest, all finite and 0 or more; free() it */
    double index_to_world[16]; /* column-major; (i, j, k) is the centre of values[k][j][i] */
    float largest;
} al_vdb_grid;

/* `grid_name` as in the scene file: "" for the file's only float grid, "name", "name[i]". Inactive voxels
 * inside the box count with the value they hold. Refuses boxes of more than `size_limit` bytes. */
typedef al_status al_vdb_reader(const char *path, const char *grid_name, uint64_t size_limit, al_vdb_grid *grid,
                                al_error *error);
al_vdb_reader al_vdb_read; /* in the programs: loads the module of the same function */

#ifdef __cplusplus
}
#endif
#endif
