/* A list of receivers from a file, what they receive, and how sure it is. */
#ifndef AIRLIGHT_POINTS_H
#define AIRLIGHT_POINTS_H

#include "mode.h"

typedef struct al_points {
    al_receiver *receivers;
    uint32_t count;
    bool are_probes; /* all of them, or none */
} al_points;

/* Text, a line each: x,y,z,nx,ny,nz in metres, the normal unit or 0,0,0 for a probe; further columns, a first
 * line of names, empty lines and those that begin with # are left out. AL_BAD_INPUT names file and line. */
al_status al_points_read(const char *path, al_points *points, al_error *error);
void al_points_free(al_points *points);

typedef struct al_points_options {
    uint32_t samples; /* per point, 2 or more */
    unsigned threads; /* 0: one per core */
    /* Called by the calling thread now and then; true stops. May be NULL. */
    bool (*on_progress)(void *user, double done, double total);
    void *user;
} al_points_options;

/* Values a point has: 1, or AL_PROBE_COUNT. */
uint32_t al_points_width(const al_points *points);

/* `values` and `errors`, [count][width][3]: means of the samples and their standard errors. The same numbers
 * for any number of threads. The mode must have `receive`. */
al_status al_points_estimate(const al_mode *mode, const void *state, const al_points *points,
                             const al_points_options *options, double (*values)[3], double (*errors)[3],
                             al_error *error);

/* Writes x,y,z,nx,ny,nz,r,g,b,se_r,se_g,se_b for surfaces, x,y,z,index,sh_r,sh_g,sh_b,se_r,se_g,se_b for
 * probes. */
al_status al_points_write(const char *path, const al_points *points, double (*values)[3], double (*errors)[3],
                          al_error *error);

#endif
