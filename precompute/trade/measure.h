/* Bakes, plays and holds points against the truth; keeps all of it in the folder. */
#ifndef AIRLIGHT_MEASURE_H
#define AIRLIGHT_MEASURE_H

#include <jansson.h>

#include "trade.h"

/* A scene's picture without approximation, from one of the two cameras, in DIR/truth; *stem is the path without ".exr". What is
 * there is used again. */
al_status al_truth_make(al_trade *trade, int camera, char stem[PATH_MAX], al_error *error);

/* Both plans, of the scene at medium settings, which is baked for it. */
typedef struct al_plans {
    json_t *bake;
    char *play;
} al_plans;
al_status al_plans_make(al_trade *trade, const json_t *root, al_plans *plans, al_error *error);
void al_plans_free(al_plans *plans);
bool al_plans_need(const void *plans, bool bake, const char *step); /* an al_step_needed_fn */

/* Fills in what a point costs and how wrong it is, or that it is left out; at once when DIR/points has it. */
al_status al_point_measure(al_trade *trade, const json_t *root, const char *truth, al_point *point, al_error *error);
/* The error of the other view. */
al_status al_point_hold_out(al_trade *trade, const json_t *root, const char *truth, al_point *point, al_error *error);

/* "samples=5000, march-step=2": what differs from medium. */
void al_point_describe(const al_trade *trade, const al_point *point, char *text, size_t size);

#endif
