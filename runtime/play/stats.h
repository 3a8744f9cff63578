/* Times and sizes of a headless run, written as stats.json. */
#ifndef AIRLIGHT_STATS_H
#define AIRLIGHT_STATS_H

#include "airlight/runtime.h"
#include "airlight/trade_table.h"

enum { AL_STATS_PASS_LIMIT = 64 };

typedef struct al_pass_series {
    char name[64];
    double *ms;
    size_t count, room;
} al_pass_series;

typedef struct al_stats {
    al_pass_series frame; /* wall clock of whole frames */
    al_pass_series passes[AL_STATS_PASS_LIMIT];
    size_t pass_count;
    double first_picture_ms, last_sample_ms; /* since the folder was opened; NaN: not measured */
    uint32_t width, height;
    const char *renderer; /* GL_RENDERER */
    const al_trade_pick *pick; /* what is expected, if anything; may be NULL */
} al_stats;

/* Adds one frame; AL_IO when out of memory. */
al_status al_stats_add(al_stats *stats, double frame_ms, const al_pass_time *times, uint32_t count,
                       al_error *error);
al_status al_stats_write(const char *path, const al_stats *stats, al_runtime *runtime, al_error *error);
void al_stats_free(al_stats *stats);

#endif
