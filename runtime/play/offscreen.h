/* An OpenGL context without a display, through EGL. */
#ifndef AIRLIGHT_OFFSCREEN_H
#define AIRLIGHT_OFFSCREEN_H

#include <stdbool.h>

#include "airlight/status.h"

typedef struct al_offscreen {
    void *display, *surface, *context; /* EGL handles */
} al_offscreen;

/* Makes a core 4.5 context current: on the first EGL device that can, else on Mesa's surfaceless platform,
 * else on the default display. AL_NO_DEVICE when none can. */
al_status al_offscreen_create(bool debug, al_offscreen *offscreen, al_error *error);
void al_offscreen_destroy(al_offscreen *offscreen); /* safe on a zeroed one */

#endif
