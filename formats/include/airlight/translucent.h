/* The translucent asset: a heterogeneous object as weighted Gaussians with SH transmittance.
 *
 * Each sample i at b_i keeps psi_i(w) = exp(-tau(b_i, w)), the transmittance from b_i to the object's
 * boundary in direction w (from the sample outwards, towards where light comes from), as SH coefficients,
 * and gamma_i(x) = weight * exp(-a |x - b_i|^2) for |x - b_i| <= radius. The sum of all gamma_i is about 1
 * inside the object. Samples are ordered so that every prefix is well spread. All in object space, metres.
 *
 * Samples lie in pages (one chunk each, verified one by one), so that a reader can start with a prefix.
 * Thread safety and lifetime: as al_file; every pointer is valid until al_file_close. */
#ifndef AIRLIGHT_TRANSLUCENT_H
#define AIRLIGHT_TRANSLUCENT_H

#include "airlight/measured.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum al_coefficient_format {
    AL_COEFFICIENT_FLOAT = 0, /* float32 */
    AL_COEFFICIENT_HALF = 1,  /* IEEE binary16 */
    AL_COEFFICIENT_BYTE = 2   /* int8: value = byte / 127 * scale of its sample and channel */
} al_coefficient_format;

typedef struct al_translucent_info {
    uint32_t sample_count;
    uint32_t page_size;     /* samples per page, the last page may hold fewer */
    uint32_t order;         /* SH bands 0 to order-1, 1 to 8 */
    uint32_t channel_count; /* sets of coefficients per sample: 1 (grey extinction) or 3 (RGB) */
    uint32_t format;        /* al_coefficient_format */
    uint32_t direction_count;
    uint32_t grid_size[3];  /* x, y, z voxels of the density grid */
    float grid_origin_m[3]; /* lower corner of voxel (0,0,0) */
    float voxel_m;          /* edge of a voxel */
    float density_max;      /* the grid's unit: stored values are density / density_max, at most 1 */
    float sigma_s_per_m[3]; /* at density 1 */
    float sigma_a_per_m[3];
    float g;                /* Henyey-Greenstein asymmetry, in (-1, 1) */
    float ior;              /* refractive index of the boundary, 1: index-matched */
    float bounds_min_m[3];  /* of the boundary mesh */
    float bounds_max_m[3];
    double volume_m3;       /* of the interior without blockers */
    double radius_m;        /* the base radius r of the Poisson-disk sampling */
    float rho_quantile;     /* 98th percentile of |div T| inside, 1/m */
    float unity_mean;       /* of the sum of gamma_i over the interior: mean, */
    float unity_deviation;  /* standard deviation about that mean, */
    float unity_worst;      /* and largest |sum - 1| */
    uint32_t has_blockers;  /* 1: the grid has a second plane with the share of opaque matter */
} al_translucent_info;

typedef struct al_translucent_page {
    uint32_t first, count;
    const float *positions;   /* [count][3] b_i, metres */
    const float *gaussians;   /* [count][4] a in 1/m^2, weight, radius in m, density at b_i */
    const float *scales;      /* [count][channel_count]; NULL unless AL_COEFFICIENT_BYTE */
    const void *coefficients; /* [count][channel_count][order*order] in info.format */
} al_translucent_page;

/* Reads and validates the info; `file` must be of kind translucent. */
al_status al_translucent_read(const al_file *file, al_translucent_info *info, al_error *error);
uint32_t al_translucent_page_count(const al_translucent_info *info);
/* Verifies and answers one page. Values are checked finite. */
al_status al_translucent_read_page(const al_file *file, const al_translucent_info *info, uint32_t index,
                                   al_translucent_page *page, al_error *error);
/* Density relative to info.density_max as unorm16 [z][y][x], x fastest: density times the share of the
 * voxel inside the boundary. `blockers` is the opaque share as unorm8 [z][y][x], or NULL. */
al_status al_translucent_read_grid(const al_file *file, const al_translucent_info *info,
                                   const uint16_t **density, const uint8_t **blockers, al_error *error);
/* Decodes coefficient set `channel` of the page's sample `index` into order*order floats. */
void al_translucent_decode(const al_translucent_info *info, const al_translucent_page *page, uint32_t index,
                           uint32_t channel, float *coefficients);
/* What the asset says of the transmittance at a point: the gamma-weighted mean of psi_i(direction), clamped
 * to [0, 1]; samples_used counts the Gaussians that reach the point (0: transmittance is 1, vacuum). The
 * direction may have any length but 0 (AL_USAGE). Reads and verifies every page: not for each frame. */
al_status al_translucent_evaluate(const al_file *file, const al_translucent_info *info,
                                  const float position[3], const float direction[3],
                                  float transmittance[3], uint32_t *samples_used, al_error *error);

/* What a writer hands over; arrays as in al_translucent_page but whole, coefficients as float32. */
typedef struct al_translucent_data {
    al_translucent_info info;
    const float *positions;
    const float *gaussians;
    const float *coefficients;   /* [sample_count][channel_count][order*order] */
    const uint16_t *density;     /* [z][y][x] unorm16 of density_max */
    const uint8_t *blockers;     /* [z][y][x] or NULL */
    const char *provenance_json; /* settings and content hashes of the inputs: kept as chunk PROV */
    const al_measured *measured; /* chunks MEAS */
    uint32_t measured_count;
} al_translucent_data;

/* What al_translucent_evaluate will say, once `data` is written, at `count` points towards as many directions:
 * [count][3] each. */
al_status al_translucent_foretell(const al_translucent_data *data, uint32_t count, const float *positions,
                                  const float *directions, float *transmittances, al_error *error);

/* Encodes (info.format), pages (info.page_size; 0: 4096) and writes the whole asset atomically; has_blockers
 * follows `blockers`. Errors of the encodings: docs/formats.md. bytes may be NULL. */
al_status al_translucent_write(const char *path, const al_translucent_data *data, uint64_t *bytes,
                               al_error *error);

#ifdef __cplusplus
}
#endif
#endif
