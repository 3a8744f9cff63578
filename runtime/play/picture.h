/* The picture the runtime draws into, and pictures on their way to files. */
#ifndef AIRLIGHT_PICTURE_H
#define AIRLIGHT_PICTURE_H

#include "airlight/image.h"
#include "airlight/runtime.h"

typedef struct al_target {
    uint32_t framebuffer, texture; /* GL names; RGBA32F */
    uint32_t width, height;
} al_target;

al_status al_target_create(uint32_t width, uint32_t height, al_target *target, al_error *error);
void al_target_destroy(al_target *target); /* safe on a zeroed one */
/* Reads R, G, B into a new image, first row on top. */
al_status al_target_read(const al_target *target, al_image *image, al_error *error);

/* False for passes that hold normals, distances and the like: shown without exposure and tone mapping. */
bool al_pass_is_light(al_pass pass);

/* By the ending of `path`: .exr as it is; .png exposed by 2^exposure_ev, tone-mapped (light only), in sRGB.
 */
al_status al_picture_write(const char *path, const al_image *image, bool is_light, double exposure_ev,
                           al_error *error);
bool al_picture_has_ending(const char *path, const char *ending);

#endif
