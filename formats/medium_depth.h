/* The chunks of a medium's optical depths, for medium.c. */
#ifndef AIRLIGHT_MEDIUM_DEPTH_H
#define AIRLIGHT_MEDIUM_DEPTH_H

#include "airlight/medium.h"
#include "report.h"

void al_medium_depth_check(const al_file *file, const al_medium_info *info, al_report *report);
/* What `data` says of them; `densities_max` [frame_count] are those of the frames as stored, `path` is for messages. */
al_status al_medium_depth_write(al_writer *writer, const char *path, const al_medium_data *data,
                                const float *densities_max, al_error *error);

#endif
