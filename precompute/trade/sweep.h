/* Which knobs a scene needs, and which points of them are measured. */
#ifndef AIRLIGHT_SWEEP_H
#define AIRLIGHT_SWEEP_H

#include "trade.h"

/* Says whether a step of the bake's or the player's plan is needed or can be asked for. */
typedef bool al_step_needed_fn(const void *plans, bool bake, const char *step);
/* The scene's own value of a key such as "bake.samples", as text; NULL: it has none. */
typedef const char *al_scene_value_fn(const void *scene, const char *key, char text[AL_VALUE_SIZE]);

/* Knobs of needed steps. `only` holds the others at medium, and may give values: AL_USAGE for what is no knob here. */
al_status al_knobs_choose(al_knobs *knobs, al_step_needed_fn *needed, const void *plans, al_scene_value_fn *value,
                          const void *scene, const al_option_list *only, al_error *error);

/* The three presets, then every other value of each knob with the others at medium. With `only`, medium alone and those. */
void al_sweep_begin(al_points *points, const al_knobs *knobs, bool only);

/* Adds up to `limit` combinations which the measured points say are cheap for their error: squared errors and times
 * over medium's are taken to add up; from the fastest value of each knob on, the change that takes away the most squared
 * error for its time comes next. */
void al_sweep_combine(al_points *points, const al_knobs *knobs, int limit);

#endif
