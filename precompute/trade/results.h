/* What a sweep leaves for people and programs: trade.csv and trade.html. */
#ifndef AIRLIGHT_RESULTS_H
#define AIRLIGHT_RESULTS_H

#include "trade.h"

/* One column per knob, then relative_rmse, flip_ldr, seconds, frame_ms, memory_bytes, asset_bytes, front (1 or 0),
 * held_out_relative_rmse (empty but for the front) and preset. */
al_status al_results_csv(const al_trade *trade, al_error *error);
/* Self-contained; `truth` is the stem of the picture that points were held against. */
al_status al_results_page(const al_trade *trade, const char *truth, al_error *error);

#endif
