/* A mode's picture of a camera, and how sure each pixel is. */
#ifndef AIRLIGHT_RENDER_H
#define AIRLIGHT_RENDER_H

#include "airlight/image.h"
#include "mode.h"

typedef struct al_render_options {
    uint32_t width, height;
    uint32_t samples; /* per pixel, 2 or more */
    unsigned threads; /* 0: one per core */
    const al_camera *camera;
    /* Called by the calling thread now and then; true stops. May be NULL. */
    bool (*on_progress)(void *user, double done, double total);
    void *user;
} al_render_options;

/* `image` gets three channels, mean radiance over each pixel's area; `standard_error` one, the mean over the
 * channels of the standard error of the pixel, from independent batches of samples. The same bytes for any
 * number of threads. AL_CANCELLED when on_progress says so. */
al_status al_render(const al_mode *mode, const void *state, const al_render_options *options, al_image *image,
                    al_image *standard_error, al_error *error);

#endif
