/* What the steps of airlight-trade share: the knobs of a sweep, its points, and what was measured at each. */
#ifndef AIRLIGHT_TRADE_H
#define AIRLIGHT_TRADE_H

#include <limits.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "airlight/program.h"

enum { AL_KNOB_LIMIT = 24, AL_VALUE_LIMIT = 6, AL_VALUE_SIZE = 24, AL_POINT_LIMIT = 256, AL_NAME_SIZE = 64 };

/* A name with a dot is a key of the scene file, "bake.samples"; one without an option of airlight-play. */
typedef struct al_knob {
    const char *name;
    char values[AL_VALUE_LIMIT][AL_VALUE_SIZE]; /* from the fastest to the most exact */
    int count, preview, medium, final;          /* indices of values; medium is the scene's own, where it has one */
} al_knob;

typedef struct al_knobs {
    al_knob knobs[AL_KNOB_LIMIT];
    int count;
} al_knobs;

typedef struct al_point {
    const char *preset; /* "preview", "medium", "final" or "" */
    uint8_t chosen[AL_KNOB_LIMIT];
    bool left_out; /* the bake refused it */
    double relative_rmse, flip_ldr, seconds, frame_ms, memory_bytes, asset_bytes;
    double held_out_relative_rmse; /* NAN where it was not measured */
    bool front;
    char picture[AL_NAME_SIZE]; /* stem of its pictures in DIR/points */
} al_point;

typedef struct al_points {
    al_point points[AL_POINT_LIMIT];
    int count;
} al_points;

typedef struct al_trade {
    const al_program *program;
    const char *scene, *folder;
    int size[2], spp, frames, combinations;
    al_option_list only; /* NAME or NAME=V,V */
    al_knobs knobs;
    al_points points;
    al_progress progress;
    char cameras[2][AL_NAME_SIZE]; /* of the comparison, and held out */
    uint64_t content;              /* hash of what the truth depends on in the scene but its camera */
    uint64_t camera_content[2];    /* hash of each camera's place */
    float exposure_ev;
    int max_events, max_bounces; /* of the truth; -1: no limit */
} al_trade;

#endif
