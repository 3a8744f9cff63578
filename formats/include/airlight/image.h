/* Pictures in and out of the programs: OpenEXR through its C interface, PNG. Part of airlight_program. */
#ifndef AIRLIGHT_IMAGE_H
#define AIRLIGHT_IMAGE_H

#include <stddef.h>
#include <stdint.h>

#include "airlight/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct al_image {
    uint32_t width, height, channels; /* channels 1 (Y) or 3 (R, G, B) */
    float *pixels;                    /* [height][width][channels], first row on top, linear */
} al_image;

/* Scan-line and tiled files, half, float and uint, every compression of OpenEXR's C interface (not DWA:
 * refused with a clear word). Reads R, G, B (of the root layer), else Y; other channels are ignored. */
al_status al_image_read_exr(const char *path, al_image *image, al_error *error);
/* float32, ZIP, channels B G R or Y. Atomic. */
al_status al_image_write_exr(const char *path, const al_image *image, al_error *error);
typedef struct al_image_channels {
    uint32_t width, height, count;
    const char *const *names; /* [count] all different, "LAYER.R" */
    const float *pixels;      /* [height][width][count], first row on top */
} al_image_channels;

/* The same with any channels. */
al_status al_image_write_exr_channels(const char *path, const al_image_channels *image, al_error *error);
/* 8 bits, `channels` 1, 3 or 4, sRGB-encoded by the caller. Atomic. */
al_status al_image_write_png(const char *path, uint32_t width, uint32_t height, uint32_t channels,
                             const uint8_t *pixels, al_error *error);
/* The same into memory, free(*bytes); `path` is for messages. */
al_status al_image_encode_png(const char *path, uint32_t width, uint32_t height, uint32_t channels,
                              const uint8_t *pixels, void **bytes, size_t *size, al_error *error);
void al_image_free(al_image *image);

/* Linear to sRGB byte, clamped; NaN becomes 0. IEC 61966-2-1. */
uint8_t al_srgb_byte(float linear);

#ifdef __cplusplus
}
#endif
#endif
