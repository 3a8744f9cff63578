/* Pictures that users bring: PNG and JPEG textures, Radiance HDR and OpenEXR (any compression) radiance maps.
 */
#ifndef AIRLIGHT_PICTURE_H
#define AIRLIGHT_PICTURE_H

#include <stddef.h>
#include <stdint.h>

#include "airlight/status.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { AL_PICTURE_EDGE_LIMIT = 16384 };

/* PNG or JPEG to 8-bit RGBA, first row on top; free() the pixels. `name` is for messages. */
al_status al_picture_decode_bytes(const char *name, const uint8_t *data, size_t size, uint32_t *width,
                                  uint32_t *height, uint8_t **rgba, al_error *error);
/* Radiance .hdr to linear float RGB. */
al_status al_picture_decode_hdr(const char *name, const uint8_t *data, size_t size, uint32_t *width,
                                uint32_t *height, float **rgb, al_error *error);
/* OpenEXR to linear float RGB: R, G, B, else Y for all three. Its own C++ bridge: exr_bridge.cpp. */
al_status al_picture_decode_exr(const char *name, const uint8_t *data, size_t size, uint32_t *width,
                                uint32_t *height, float **rgb, al_error *error);

#ifdef __cplusplus
}
#endif
#endif
