/* What airlight-play was asked to do. */
#ifndef AIRLIGHT_PLAY_OPTIONS_H
#define AIRLIGHT_PLAY_OPTIONS_H

#include "airlight/program.h"
#include "airlight/runtime.h"
#include "airlight/trade_table.h"

typedef struct al_play_options {
    const char *folder; /* NULL: none given, the window waits for a dropped one */
    bool headless, accumulate, plan, watch, first_picture;
    int size[2], frames;
    double fps;
    al_option_list out;
    const char *stats, *camera; /* NULL when not given */
    double exposure_ev;         /* NaN: the scene's own */
    double target_error, frame_ms; /* 0: not asked for */
    al_trade_pick pick;            /* what was picked for them */
    al_settings settings;
} al_play_options;

/* -1 to go on, else the exit code. */
int al_play_options_parse(al_program *program, int argc, char **argv, al_play_options *options);

/* The exposure that counts, and the camera by name (the first one without a name; AL_USAGE for an
 * unknown). */
double al_play_exposure(const al_play_options *options, const al_scene *scene);
al_status al_play_camera(const al_play_options *options, const al_scene *scene, const al_camera **camera,
                         al_error *error);

#endif
