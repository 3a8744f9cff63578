/* airlight-play without a display. */
#ifndef AIRLIGHT_HEADLESS_H
#define AIRLIGHT_HEADLESS_H

#include "options.h"

/* Renders what the options ask for; returns the exit code. */
int al_headless_run(const al_program *program, const al_play_options *options);

#endif
