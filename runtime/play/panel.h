/* The panel of the player's window, behind C: Dear ImGui with its GLFW and OpenGL 3 backends (panel.cpp). */
#ifndef AIRLIGHT_PANEL_H
#define AIRLIGHT_PANEL_H

#include <stdbool.h>
#include <stdint.h>

#include "airlight/runtime.h"

#ifdef __cplusplus
extern "C" {
#endif

struct GLFWwindow;

typedef struct al_panel_state { /* what the panel shows and changes */
    al_runtime *runtime;
    const char *folder;  /* "" before one is loaded */
    const char *message; /* the last error or notice, "" for none */
    al_load_state load;
    al_settings *settings;
    float *exposure_ev;
    int *camera; /* index of the scene's camera; set by the panel, -1 when the user has moved away */
    double *time_s; /* shown; within al_runtime_duration_s */
    bool *paused;
    const al_pass_time *times;
    uint32_t time_count;
    double frame_ms; /* wall clock, smoothed */
    bool help;
} al_panel_state;

/* Installs itself behind the window's callbacks; one panel per process. False when the backends refuse;
 * then nothing is left to destroy. */
bool al_panel_create(struct GLFWwindow *window);
void al_panel_destroy(void);
/* Draws the panel over the current framebuffer. */
void al_panel_draw(al_panel_state *state);
/* Whether the mouse or the keyboard belongs to the panel at the moment. */
bool al_panel_wants_mouse(void);
bool al_panel_wants_keyboard(void);

#ifdef __cplusplus
}
#endif
#endif
