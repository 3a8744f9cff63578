/* Files that are installed with the program that runs. */
#ifndef AIRLIGHT_BESIDE_H
#define AIRLIGHT_BESIDE_H

#include <limits.h>

#include "airlight/status.h"

/* `name` as seen from the folder of the running program: "airlight-tetrahedra". */
al_status al_find_beside(const char *name, char path[PATH_MAX], al_error *error);

#endif
