/* Light gathered piece by piece (tiles of texels, probes) on all threads, kept on disk as it comes, so that a
 * bake that was stopped goes on where it was. */
#ifndef AIRLIGHT_GATHER_JOB_H
#define AIRLIGHT_GATHER_JOB_H

#include "bake_step.h"
#include "gather.h"

typedef struct al_gather_job {
    const char *name;         /* of the step */
    const char *partial;      /* path of the file of finished pieces; it stays until the caller removes it */
    uint64_t key;             /* of what is baked: finished pieces of another key are not used */
    al_gather_options gather; /* threads and progress are those of the bake */
    uint32_t piece_count, items; /* items: what report.json counts */
    size_t piece_floats;
    /* Looks at the scene before the first piece. May be NULL. */
    al_status (*check)(void *user, const al_gather *gather, al_gather_scratch *scratch, al_error *error);
    /* Fills one piece, from its index alone. False: without memory. */
    bool (*fill)(void *user, const al_gather *gather, al_gather_scratch *scratch, uint32_t piece, float *out);
    void *user;
} al_gather_job;

/* Opens the gather and fills every piece: pieces[piece_count][piece_floats], free() it. Adds its steps.
 */
al_status al_gather_job_run(const al_gather_job *job, const al_import *import,
                            const al_impulse_tables *tables, const al_bake_options *options, al_steps *steps,
                            float **pieces, al_error *error);

#endif
