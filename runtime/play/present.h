/* Shows a linear picture in the window: exposure, tone mapping, sRGB. */
#ifndef AIRLIGHT_PRESENT_H
#define AIRLIGHT_PRESENT_H

#include <stdbool.h>
#include <stdint.h>

#include "airlight/status.h"

typedef struct al_present {
    uint32_t program, vertex_array; /* GL names */
} al_present;

al_status al_present_create(al_present *present, al_error *error);
void al_present_destroy(al_present *present); /* safe on a zeroed one */
/* Draws the texture pixel for pixel into the window's framebuffer. */
void al_present_draw(const al_present *present, uint32_t texture, uint32_t width, uint32_t height,
                     double exposure_ev, bool is_light);

#endif
