/* The chunks of a medium's sky light, for medium.c. */
#ifndef AIRLIGHT_MEDIUM_SKY_H
#define AIRLIGHT_MEDIUM_SKY_H

#include "airlight/medium.h"
#include "report.h"

void al_medium_sky_check(const al_file *file, al_report *report);
/* sky and values as in al_medium_data; `path` is for messages. */
al_status al_medium_sky_write(al_writer *writer, const char *path, const al_medium_sky *sky,
                              const float *values, al_error *error);

#endif
