/* The bake's settings that trade speed for accuracy, by their names in the scene file. */
#ifndef AIRLIGHT_SETTING_H
#define AIRLIGHT_SETTING_H

#include <stdbool.h>

#include "airlight/scene_description.h"

typedef struct al_setting {
    const char *name; /* "bake.samples" */
    uint32_t *value;  /* in the description */
    long limit;
} al_setting;

/* The index-th setting; false: there are fewer. */
bool al_setting_at(al_scene_description *description, int index, al_setting *setting);

#endif
