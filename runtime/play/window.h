/* airlight-play in a window. */
#ifndef AIRLIGHT_WINDOW_H
#define AIRLIGHT_WINDOW_H

#include "options.h"

/* Runs until the user closes the window; returns the exit code. */
int al_window_run(const al_program *program, const al_play_options *options);

#endif
