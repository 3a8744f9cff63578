/* The check of a file under another name than its own, for the writer's temporary one. */
#ifndef AIRLIGHT_FILE_CHECK_H
#define AIRLIGHT_FILE_CHECK_H

#include "airlight/container.h"

al_status al_file_check_as(const char *path, const char *name, al_finding_fn *on_finding, void *user,
                           al_error *error);

#endif
