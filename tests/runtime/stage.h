/* A headless OpenGL context and a float framebuffer for the runtime's tests. */
#ifndef AIRLIGHT_TEST_STAGE_H
#define AIRLIGHT_TEST_STAGE_H

#include <stdbool.h>
#include <stdint.h>

#include "airlight/runtime.h"

/* Makes a surfaceless EGL context of core 4.5 current; false when there is none. Kept until the process ends.
 */
bool stage_open(void);

/* Symmetric perspective view from `eye` at `target`, +y up; fov in radians, vertical. */
al_view stage_look(uint32_t width, uint32_t height, const float eye[3], const float target[3], float fov);
/* Orthographic, looking along -z from z = 5, x and y in [-half, half]. */
al_view stage_ortho(uint32_t width, uint32_t height, float half);

/* Updates until everything is loaded; false on an error, which is printed. */
bool stage_load(al_runtime *runtime, const char *folder);

/* Draws a frame and answers its pixels, [height][width][3], first row at the bottom; to be freed. NULL on an
 * error, which is printed. depth: 0, or a depth texture as al_runtime_draw takes it. */
float *stage_draw(al_runtime *runtime, const al_view *view, const al_settings *settings, uint32_t depth);

/* A new empty folder under the temporary one, removed at exit; once a process. NULL when it cannot be made.
 */
const char *stage_folder(void);

/* How many numbers are not finite or negative. */
uint64_t stage_bad(const float *pixels, uint64_t count);
double stage_sum(const float *pixels, uint64_t count);

#endif
