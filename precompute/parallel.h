/* Runs independent pieces of work on threads. What a piece computes may depend on its index only. */
#ifndef AIRLIGHT_PARALLEL_H
#define AIRLIGHT_PARALLEL_H

#include <stdbool.h>

/* One piece; false stops handing out pieces. `thread` in [0, threads) selects scratch memory. */
typedef bool al_piece_fn(void *user, unsigned piece, unsigned thread);

/* Calls `work` for every piece in [0, count) on `threads` threads (0: one per core), the caller's included.
 * Returns false when a piece said so. */
bool al_parallel(unsigned threads, unsigned count, al_piece_fn *work, void *user);

/* `threads`, or the number of cores when it is 0. */
unsigned al_parallel_threads(unsigned threads);

#endif
