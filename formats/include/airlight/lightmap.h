/* The lightmap asset: light that falls onto surfaces, for each texel of an atlas.
 *
 * Three layers of irradiance in W/m2: `surface` is the light without the fog, `attenuated` the same light
 * after what the fog takes from it, `scattered` what the fog sends onto the surface. Light in the fog is
 * attenuated + scattered. With directional_order above 0 each layer also keeps the incident radiance as SH,
 * in world axes, so that normal maps can be lit.
 *
 * The atlas has pages. An instance lies in one of them: page uv = uv1 of its mesh * scale + offset, (0, 0)
 * the corner of the first texel, whose row is the first in memory. Texel centres are at (column + 1/2) /
 * width, (row + 1/2) / height.
 * Thread safety and lifetime: as al_file; every pointer is valid until al_file_close. */
#ifndef AIRLIGHT_LIGHTMAP_H
#define AIRLIGHT_LIGHTMAP_H

#include "airlight/measured.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum al_lightmap_layer {
    AL_LAYER_SURFACE = 0,
    AL_LAYER_ATTENUATED = 1,
    AL_LAYER_SCATTERED = 2
} al_lightmap_layer;

enum { AL_LAYER_COUNT = 3, AL_LIGHTMAP_MAX_ORDER = 4 };

typedef enum al_lightmap_format {
    AL_LIGHTMAP_FLOAT = 0, /* float32 */
    AL_LIGHTMAP_HALF = 1   /* IEEE binary16 */
} al_lightmap_format;

typedef enum al_texel_state { /* where a texel's light comes from */
    AL_TEXEL_EMPTY = 0,       /* no surface near; all zero */
    AL_TEXEL_DILATED = 1,     /* padding: from the nearest texels of its chart */
    AL_TEXEL_REPLACED = 2,    /* behind a surface: from valid neighbours */
    AL_TEXEL_BAKED = 3
} al_texel_state;

typedef struct al_lightmap_info {
    uint32_t page_count, instance_count;
    uint32_t format;            /* al_lightmap_format */
    uint32_t directional_order; /* SH bands a layer, 0 to 4 */
    uint32_t vertex_count, triangle_count;
    float texel_m;              /* edge of a texel on the surfaces */
} al_lightmap_info;

typedef struct al_lightmap_instance {
    uint32_t instance; /* of the scene */
    uint32_t page;
    float scale[2], offset[2]; /* page uv = uv1 * scale + offset, inside [0, 1] */
    uint32_t first_triangle, triangle_count;
} al_lightmap_instance;

typedef struct al_lightmap_page {
    uint32_t width, height;
    float scale[AL_LAYER_COUNT], sh_scale[AL_LAYER_COUNT];
    const void *irradiance[AL_LAYER_COUNT]; /* [height][width][3] in info.format; W/m2 = value * scale */
    /* [directional_order^2][height][width][3] in info.format; W/(m2 sr) = value * sh_scale. NULL when the
     * order is 0 */
    const void *sh[AL_LAYER_COUNT];
    const uint8_t *state; /* [height][width] al_texel_state */
} al_lightmap_page;

/* Reads and validates the info; `file` must be of kind lightmap. */
al_status al_lightmap_read(const al_file *file, al_lightmap_info *info, al_error *error);
/* Answers every instance; `instances` has room for info.instance_count. */
al_status al_lightmap_read_instances(const al_file *file, const al_lightmap_info *info,
                                     al_lightmap_instance *instances, al_error *error);
/* Verifies and answers one page. */
al_status al_lightmap_read_page(const al_file *file, const al_lightmap_info *info, uint32_t index,
                                al_lightmap_page *page, al_error *error);
/* The irradiance of one texel in W/m2; texel = row * width + column. */
void al_lightmap_texel(const al_lightmap_info *info, const al_lightmap_page *page, al_lightmap_layer layer,
                       size_t texel, float irradiance[3]);

typedef struct al_lightmap_answer {
    float irradiance[AL_LAYER_COUNT][3]; /* W/m2 */
    float distance_m;                    /* from the asked position to the surface that answers */
    uint32_t instance;                   /* of the scene */
} al_lightmap_answer;

/* What the lightmap says at the nearest point of all triangles that face within 60 degrees of the normal,
 * bilinear between texel centres. Positions in world space. AL_USAGE when the normal has no length, a number
 * is not finite, or no triangle faces that way. Looks at every triangle: not for each frame. */
al_status al_lightmap_evaluate(const al_file *file, const al_lightmap_info *info, const float position[3],
                               const float normal[3], al_lightmap_answer *answer, al_error *error);

/* What a writer hands over. */
typedef struct al_lightmap_source {
    uint32_t width, height;
    const float *irradiance; /* [AL_LAYER_COUNT][height][width][3] W/m2, from 0 */
    const float *sh;         /* [AL_LAYER_COUNT][directional_order^2][height][width][3]; NULL for order 0 */
    const uint8_t *state;    /* [height][width] */
} al_lightmap_source;

typedef struct al_lightmap_data {
    al_lightmap_info info;
    const al_lightmap_instance *instances; /* [instance_count], ascending by `instance` */
    const al_lightmap_source *pages;       /* [page_count] */
    const float *vertices;                 /* [vertex_count][5] world position in metres, page uv */
    const uint32_t *triangles;             /* [triangle_count][3] */
    const char *provenance_json;
    const al_measured *measured; /* chunks MEAS */
    uint32_t measured_count;
} al_lightmap_data;

/* Encodes and writes the whole asset atomically. Halfs are scaled by a power of two for each page and layer
 * so that the largest lies in (2^14, 2^15]: the error is at most 2^-11 of the value, or 2^-39 of the layer's
 * largest where that is more. bytes may be NULL. */
al_status al_lightmap_write(const char *path, const al_lightmap_data *data, uint64_t *bytes, al_error *error);

#ifdef __cplusplus
}
#endif
#endif
