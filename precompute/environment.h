/* The environment map: reading, rotation, projection to spherical harmonics. Convention: docs/scene.md. */
#ifndef AIRLIGHT_ENVIRONMENT_H
#define AIRLIGHT_ENVIRONMENT_H

#include "import.h"

/* Fills import->scene.environment from the description; none: zeros. */
al_status al_environment_import(al_import *import, al_error *error);

/* Coefficients (order AL_ENVIRONMENT_ORDER, world axes) of the map's pixels taken as constant over their own
 * solid angles; exact but for rounding. pixels: [height][width][3]. */
al_status al_environment_project(uint32_t width, uint32_t height, const float *pixels,
                                 float sh[3][AL_ENVIRONMENT_ORDER * AL_ENVIRONMENT_ORDER], al_error *error);

#endif
