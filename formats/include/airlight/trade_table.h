/* trade.csv, which airlight-trade measured, and the point of its front that meets what is asked. Part of airlight_program. */
#ifndef AIRLIGHT_TRADE_TABLE_H
#define AIRLIGHT_TRADE_TABLE_H

#include <stdbool.h>
#include <stddef.h>

#include "airlight/status.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { AL_TRADE_KNOB_LIMIT = 32, AL_TRADE_TEXT_SIZE = 48 };

/* A name with a dot is a key of the scene file, "bake.samples"; one without an option of airlight-play. */
typedef struct al_trade_knob {
    char name[AL_TRADE_TEXT_SIZE], value[AL_TRADE_TEXT_SIZE];
} al_trade_knob;

typedef struct al_trade_pick {
    int knob_count; /* 0: none was asked for */
    al_trade_knob knobs[AL_TRADE_KNOB_LIMIT];
    double relative_rmse, held_out_relative_rmse, seconds, frame_ms;
} al_trade_pick;

/* Of the front in FOLDER/trade.csv: with target_error > 0 the fastest frame that is at most this wrong; with frame_ms > 0 the most
 * exact one that takes at most so long; with both the fastest that meets both. `as_baked`: of all points whose bake had the
 * settings that FOLDER/report.json states. AL_BAD_INPUT without a table or report or in a broken one, AL_CHECK_FAILED when
 * no point meets what is asked. */
al_status al_trade_pick_point(const char *folder, double target_error, double frame_ms, bool as_baked, al_trade_pick *pick,
                              al_error *error);

/* What a knob of the player is on its command line: words[0 .. count). None for what the player does by itself. */
int al_trade_knob_words(const char *name, const char *value, char words[2][2 * AL_TRADE_TEXT_SIZE]);

/* "relative error 0.05 (0.06 in a view that was held out), 12 ms a frame; bake.samples=5000 march-step=2" */
void al_trade_pick_describe(const al_trade_pick *pick, char *text, size_t size);

#ifdef __cplusplus
}
#endif
#endif
