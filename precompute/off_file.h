/* OFF meshes. assimp's reader loses faces where lines are blank, so that closed surfaces come out open. */
#ifndef AIRLIGHT_OFF_FILE_H
#define AIRLIGHT_OFF_FILE_H

#include "geometry.h"

/* Text OFF, with or without the word OFF, comments (#) and blank lines; what follows positions and corners on
 * their lines (normals, colours) is left out; polygons are cut into fans. `text` is terminated; `name` begins
 * messages. */
al_status al_off_corners(const char *name, const char *text, al_corners *corners, al_error *error);

#endif
