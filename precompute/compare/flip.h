/* FLIP: how different two pictures look when one is flipped to the other, 0 (same) to 1, at 67.02 pixels per
 * degree (0.7 m from a 0.7 m wide screen of 3840 pixels).
 *
 * LDR: Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astroem, Fairchild 2020, "FLIP: A Difference Evaluator
 * for Alternating Images". HDR: Andersson, Nilsson, Shirley, Akenine-Moeller 2021, "Visualizing Errors in
 * Rendered High Dynamic Range Images". */
#ifndef AIRLIGHT_FLIP_H
#define AIRLIGHT_FLIP_H

#include "airlight/image.h"

/* Both pictures have 3 channels, the same size and finite linear values. `map` has room for width * height
 * values, first row on top; `mean` is its mean. */

/* Values are clamped to [0, 1]: what a display shows of them. */
al_status al_flip_ldr(const al_image *test, const al_image *reference, float *map, double *mean,
                      al_error *error);

/* The largest LDR difference over tone-mapped exposures from the one that shows the reference's brightest
 * pixel to the one that shows its median. Negative values count as 0. */
al_status al_flip_hdr(const al_image *test, const al_image *reference, float *map, double *mean,
                      al_error *error);

#endif
