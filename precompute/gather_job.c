#include "gather_job.h"

#include <stdatomic.h>
#include <stdlib.h>

#include "journal.h"
#include "parallel.h"

enum { THREAD_LIMIT = 256 };

typedef struct run {
    const al_gather_job *job;
    const al_bake_options *options;
    al_gather *gather;
    al_gather_scratch *scratch[THREAD_LIMIT];
    float *pieces;
    bool *done; /* [piece_count] */
    al_journal *journal;
    al_progress progress;
    atomic_uint finished;
} run;

static al_status out_of_memory(const run *r, al_error *error)
{
    return al_fail(error, AL_IO, "%s: out of memory while gathering light", r->job->partial);
}

static bool on_progress(void *user, double done, double total)
{
    return al_progress_update(user, done, total);
}

static al_status open_gather(run *r, const al_import *import, const al_impulse_tables *tables,
                             al_steps *steps, al_error *error)
{
    double started = al_program_seconds();
    al_gather_options gather = r->job->gather;
    gather.threads = r->options->threads;
    gather.on_progress = on_progress;
    gather.user = &r->progress;
    al_progress_begin(&r->progress, r->options->program, "light in the scene");
    al_status status = al_gather_open(import, tables, &gather, &r->gather, error);
    if (status != AL_OK) return status;
    al_progress_end(&r->progress);
    al_steps_add(steps, "light in the scene", started, 0, import->scene.instance_count);
    return AL_OK;
}

static bool fill_piece(void *user, unsigned piece, unsigned thread)
{
    run *r = user;
    const al_gather_job *job = r->job;
    if (r->done[piece]) return true;
    if (al_program_cancelled() ||
        !job->fill(job->user, r->gather, r->scratch[thread], piece, r->pieces + piece * job->piece_floats) ||
        !al_journal_append(r->journal, piece))
        return false;
    unsigned finished = atomic_fetch_add(&r->finished, 1) + 1;
    if (thread == 0) al_progress_update(&r->progress, finished, job->piece_count);
    return true;
}

/* All pieces that an earlier run has not finished. */
static al_status fill_pieces(run *r, al_error *error)
{
    const al_gather_job *job = r->job;
    unsigned left = 0;
    al_status status = al_journal_open(job->partial, job->key, r->pieces, job->piece_floats * sizeof(float),
                                       r->done, job->piece_count, &r->journal, error);
    if (status != AL_OK) return status;
    for (uint32_t i = 0; i < job->piece_count; i++) left += !r->done[i];
    if (left < job->piece_count)
        al_program_say(r->options->program, "%s: going on with %u of %u pieces", job->name, left,
                       job->piece_count);
    atomic_init(&r->finished, job->piece_count - left);
    al_progress_begin(&r->progress, r->options->program, job->name);
    bool whole = al_parallel(r->options->threads, job->piece_count, fill_piece, r);
    status = al_journal_close(r->journal, error);
    if (status != AL_OK) return status;
    if (al_program_cancelled())
        return al_fail(error, AL_CANCELLED, "stopped; the same command goes on from here");
    if (!whole) return out_of_memory(r, error);
    al_progress_end(&r->progress);
    return AL_OK;
}

static al_status allocate(run *r, al_error *error)
{
    unsigned threads = al_parallel_threads(r->options->threads);
    r->pieces = calloc(r->job->piece_count + (size_t)1, r->job->piece_floats * sizeof(float));
    r->done = calloc(r->job->piece_count + (size_t)1, sizeof *r->done);
    bool memory = r->pieces && r->done;
    for (unsigned i = 0; i < threads && memory; i++)
        memory = (r->scratch[i] = al_gather_scratch_new(r->gather)) != NULL;
    return memory ? AL_OK : out_of_memory(r, error);
}

al_status al_gather_job_run(const al_gather_job *job, const al_import *import,
                            const al_impulse_tables *tables, const al_bake_options *options, al_steps *steps,
                            float **pieces, al_error *error)
{
    run *r = calloc(1, sizeof *r);
    *pieces = NULL;
    if (!r) return al_fail(error, AL_IO, "out of memory");
    r->job = job;
    r->options = options;
    al_status status = open_gather(r, import, tables, steps, error);
    double started = al_program_seconds();
    if (status == AL_OK) status = allocate(r, error);
    if (status == AL_OK && job->check) status = job->check(job->user, r->gather, r->scratch[0], error);
    if (status == AL_OK) status = fill_pieces(r, error);
    if (status == AL_OK) {
        al_steps_add(steps, job->name, started, 0, job->items);
        *pieces = r->pieces;
        r->pieces = NULL;
    }
    for (unsigned i = 0; i < THREAD_LIMIT; i++) al_gather_scratch_free(r->scratch[i]);
    al_gather_close(r->gather);
    free(r->pieces);
    free(r->done);
    free(r);
    return status;
}
