/* The scene of a sweep, with the cameras of the comparison, and scene files derived from it for bakes. */
#ifndef AIRLIGHT_TRADE_SCENE_H
#define AIRLIGHT_TRADE_SCENE_H

#include <jansson.h>

#include "sweep.h"

/* Reads the scene and all it names, fills trade->cameras, content and exposure. *root is the scene with whole paths and a second
 * camera: the first one turned 30 degrees about its target's vertical axis, where the scene has no second. */
al_status al_scene_open(al_trade *trade, json_t **root, al_error *error);
/* For al_knobs_choose; `scene` is the root. */
const char *al_scene_value(const void *scene, const char *key, char text[AL_VALUE_SIZE]);
/* The scene with a point's bake knobs set, as text; free() it. NULL when memory runs out. */
char *al_scene_derive(const json_t *root, const al_knobs *knobs, const al_point *point);

#endif
