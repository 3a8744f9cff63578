/* Content hash of what baked light depends on, settings apart. */
#ifndef AIRLIGHT_LIGHT_KEY_H
#define AIRLIGHT_LIGHT_KEY_H

#include "import.h"

/* Surfaces and where they stand, materials and textures, lights, environment, fogs. As imported. */
al_status al_light_key(const al_import *import, uint64_t *key, al_error *error);

#endif
