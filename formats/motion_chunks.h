/* The chunks of a scene's motion that are arrays: KEYS and SHAP. Records are scene.c's. */
#ifndef AIRLIGHT_MOTION_CHUNKS_H
#define AIRLIGHT_MOTION_CHUNKS_H

#include "airlight/scene.h"
#include "report.h"

/* Finds the arrays of the scene's channels and deforms in the file, whose records are read, and checks all of
 * the motion. What has findings is not to be used. */
void al_motion_check(const al_file *file, al_scene *scene, al_report *report);

/* Adds KEYS and SHAP, where the motion has any. */
al_status al_motion_add(al_writer *writer, const char *path, const al_scene *scene, al_error *error);

#endif
