/* Writes small OpenVDB files for tests. */
#ifndef AIRLIGHT_VDB_WRITER_H
#define AIRLIGHT_VDB_WRITER_H

#ifdef __cplusplus
extern "C" {
#endif

typedef enum vdb_kind {
    VDB_FLOAT,
    VDB_HALF,      /* float, stored as half */
    VDB_LEVEL_SET,
    VDB_VECTOR,
    VDB_FRUSTUM,   /* float with a perspective transform */
    VDB_CORNERS    /* float, only the first and the last voxel */
} vdb_kind;

typedef struct vdb_grid {
    const char *name;
    vdb_kind kind;
    int first[3], size[3];  /* active voxels */
    const float *values;    /* [z][y][x], or NULL: all 1 */
    float background;
    double index_to_world[16]; /* column-major; all 0: identity */
} vdb_grid;

/* Ends the program when it fails. */
void vdb_write(const char *path, const vdb_grid *grids, int count);

/* A cube of edge_m about the origin in count^3 voxels, count odd: `speck` in the middle one, `rest` in the
 * others. */
void vdb_write_speck(const char *path, int count, double edge_m, float speck, float rest);

#ifdef __cplusplus
}
#endif
#endif
