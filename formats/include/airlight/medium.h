/* The medium asset: a density that varies in space, as bricks of voxels, one frame or a sequence of them.
 *
 * Index space has voxel centres at whole numbers, (0, 0, 0) the first; the density is trilinear between
 * centres and, inside the grid's box [-1/2, size - 1/2], beyond the outermost ones what it is there. Outside
 * that box it is 0, or, in an extended medium, goes on up to the bounds. Outside the bounds it is 0.
 *
 * A brick holds the 9^3 densities at the corners of 8^3 cells: neighbours share a layer, so that each is
 * filtered without the others. Bricks that are 0 everywhere are left out. They lie in pages (one chunk each,
 * verified one by one), so that a reader can take frame by frame and page by page.
 *
 * Thread safety and lifetime: as al_file; every pointer is valid until al_file_close. */
#ifndef AIRLIGHT_MEDIUM_H
#define AIRLIGHT_MEDIUM_H

#include <stdbool.h>

#include "airlight/measured.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    AL_BRICK_CELLS = 8,                                            /* along an edge */
    AL_BRICK_EDGE = AL_BRICK_CELLS + 1,                            /* densities along an edge */
    AL_BRICK_SIZE = AL_BRICK_EDGE * AL_BRICK_EDGE * AL_BRICK_EDGE, /* densities */
    AL_MEDIUM_UNIT = 32768                                         /* stored value of a frame's maximum */
};

#define AL_NO_BRICK UINT32_MAX

typedef struct al_medium_info {
    uint32_t size[3];        /* voxels along x, y, z of index space */
    uint32_t page_size;      /* bricks per page; the last page of a frame may hold fewer */
    uint32_t frame_count;    /* at least 1 */
    bool extended;           /* the outermost densities hold up to the bounds */
    float grid_to_world[16]; /* column-major; takes index space to metres in world axes */
    float bounds_min_m[3];   /* world axes */
    float bounds_max_m[3];
    float sigma_s_per_m[3]; /* at density 1 */
    float sigma_a_per_m[3];
    float g; /* Henyey-Greenstein asymmetry, in (-1, 1) */
} al_medium_info;

typedef struct al_medium_frame {
    float time_s;      /* rises from frame to frame; between frames the density is linear in time */
    float density_max; /* stored values are binary16 of density / density_max * AL_MEDIUM_UNIT */
    uint32_t brick_count;
    const uint32_t *bricks; /* [z][y][x] of al_medium_cells: number of the brick or AL_NO_BRICK */
} al_medium_frame;

typedef struct al_medium_page {
    uint32_t first, count;  /* bricks of the frame */
    const uint16_t *values; /* [count][9][9][9], x fastest, binary16, 0 to AL_MEDIUM_UNIT */
} al_medium_page;

enum { AL_SKY_ORDER_LIMIT = 6, AL_SKY_TERMS_LIMIT = AL_SKY_ORDER_LIMIT * AL_SKY_ORDER_LIMIT };

/* Light of the environment that arrives inside the medium, at a lattice of points that spans its bounds:
 *   SH of incident radiance, W/(m2 sr) = unit_w_m2_sr * coefficient * exp(-optical depth),
 * both trilinear between points; light that is thinned out by the media falls off like an exponential. Along
 * an axis of n points, point i lies at the share al_graded_place(grade, i / (n - 1)) of the bounds' edge. */
typedef struct al_medium_sky {
    uint32_t size[3];   /* points along x, y, z; 0: the medium has no such light */
    uint32_t order;     /* SH bands, to AL_SKY_ORDER_LIMIT */
    float grade[3];     /* 0: evenly spaced */
    float unit_w_m2_sr;
    bool walled;        /* surfaces stand between points */
    const uint16_t *values; /* [1 + order^2][z][y][x][3] binary16: optical depths, then coefficients */
    /* [z][y][x][8] of the size - 1 cells: of which of the planes of points around it each eighth takes
     * coefficients, bits 0 to 2 the lower one along x, y, z, bits 3 to 5 the upper one. Where one of the two is
     * left out, a surface stands before some of its points. The eighth is x + 2 y + 4 z, 1 the upper half.
     * NULL unless walled. */
    const uint8_t *planes;
} al_medium_sky;

enum { AL_DEPTH_UNIT = 4096, AL_DEPTH_ORDER_LIMIT = 5, AL_DEPTH_TERMS_LIMIT = AL_DEPTH_ORDER_LIMIT * AL_DEPTH_ORDER_LIMIT };

/* Optical depth from points inside the medium to its bounds, for light between two points of it: spherical harmonics
 * over the direction w of
 *   tau(x, w) = integral of the density from x to the bounds along w, in m,
 * so that sigma_t at density 1 times it is an optical depth. The points are a lattice over the bounds, point i of n along
 * an axis at the share i / (n - 1) of its edge; coefficients are trilinear between them. A set for each frame:
 *   coefficient in m = stored half * al_medium_depth_unit_m(info, density_max of the frame). */
typedef struct al_medium_depth {
    uint32_t size[3]; /* points along x, y, z; 0: the medium keeps none */
    uint32_t order;   /* SH bands, to AL_DEPTH_ORDER_LIMIT */
} al_medium_depth;

/* Reads and validates the info; `file` must be of kind medium. */
al_status al_medium_read(const al_file *file, al_medium_info *info, al_error *error);
/* Bricks along each axis: those that the voxel centres span, at least one. */
void al_medium_cells(const al_medium_info *info, uint32_t cells[3]);
/* Verifies and answers a frame's index of bricks; `index` below frame_count. */
al_status al_medium_read_frame(const al_file *file, const al_medium_info *info, uint32_t index,
                               al_medium_frame *frame, al_error *error);
/* Times and numbers of bricks of all frames, [frame_count] each. */
al_status al_medium_read_times(const al_file *file, const al_medium_info *info, float *times_s,
                               uint32_t *brick_counts, al_error *error);
uint32_t al_medium_page_count(const al_medium_info *info, const al_medium_frame *frame);
/* Verifies and answers page `page` of frame `index`. */
al_status al_medium_read_page(const al_file *file, const al_medium_info *info, uint32_t index, uint32_t page,
                              al_medium_page *out, al_error *error);

/* Verifies and answers the sky's light; size 0 where there is none. */
al_status al_medium_read_sky(const al_file *file, al_medium_sky *sky, al_error *error);
/* Its coefficients at a world position, which counts as clamped to the bounds. */
void al_medium_sky_at(const al_medium_info *info, const al_medium_sky *sky, const double position[3],
                      double sh[3][AL_SKY_TERMS_LIMIT]);

/* Verifies and answers how optical depths are kept; size 0 where none are. */
al_status al_medium_read_depth(const al_file *file, const al_medium_info *info, al_medium_depth *depth, al_error *error);
/* Those of a frame, [order^2][z][y][x] binary16, x fastest; `depth` is kept. */
al_status al_medium_read_depths(const al_file *file, const al_medium_depth *depth, uint32_t frame, const uint16_t **values,
                                al_error *error);
/* What a stored 1 stands for, m: density_max times the diagonal of the bounds / AL_DEPTH_UNIT. */
double al_medium_depth_unit_m(const al_medium_info *info, float density_max);
/* Coefficients in m at a world position, which counts as clamped to the bounds. */
void al_medium_depth_at(const al_medium_info *info, const al_medium_depth *depth, const uint16_t *values,
                        float density_max, const double position[3], double sh[AL_DEPTH_TERMS_LIMIT]);

/* The whole medium as a function of place and time. Opening verifies every page; evaluating is thread-safe.
 */
typedef struct al_medium_field al_medium_field;
al_status al_medium_field_open(const al_file *file, const al_medium_info *info, al_medium_field **field,
                               al_error *error);
void al_medium_field_close(al_medium_field *field); /* before al_file_close; NULL is allowed */
/* Density at a world position; before the first and after the last frame it is that frame's. */
double al_medium_evaluate(const al_medium_field *field, const double position[3], double time_s);

/* Fills slice z of frame `frame`: density [y][x], x fastest, finite and 0 or more. */
typedef al_status al_medium_slice_fn(void *user, uint32_t frame, uint32_t z, float *density, al_error *error);

/* Fills the coefficients of frame `frame`, [order^2][z][y][x] in m. */
typedef al_status al_medium_depths_fn(void *user, uint32_t frame, float *coefficients, al_error *error);

typedef struct al_medium_data {
    al_medium_info info;  /* page_size 0: 256 */
    const float *times_s; /* [frame_count]; NULL: 0, for one frame */
    al_medium_slice_fn *slice;
    void *user;
    const al_medium_sky *sky;    /* NULL: none; its unit and values are made from those of the next line */
    const float *sky_values;     /* [1 + order^2][z][y][x][3]: optical depths to 64, coefficients in W/(m2 sr) */
    const al_medium_depth *depth; /* NULL: none */
    al_medium_depths_fn *depths;
    void *depths_user;
    const char *provenance_json; /* kept as chunk PROV; may be NULL */
    const al_measured *measured; /* chunks MEAS */
    uint32_t measured_count;
} al_medium_data;

/* Asks for every slice twice, in order (its maximum, then its bricks; nine slices are kept), and writes the
 * asset atomically. Error of a stored density: 2^-11 of it, below 2^-29 of the frame's maximum 2^-40 of that.
 * bytes may be NULL. */
al_status al_medium_write(const char *path, const al_medium_data *data, uint64_t *bytes, al_error *error);

#ifdef __cplusplus
}
#endif
#endif
