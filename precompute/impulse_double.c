/* Step 2 of the impulse tables in double precision: the device's kernels, compiled for the host. */
#include <math.h>
#include <stdlib.h>

#include "impulse_steps.h"
#include "parallel.h"

static _Thread_local int work_id[3], work_size[3];

#define AL_REAL double
#define kernel static
#define global
#define get_global_id(i) work_id[i]
#define get_global_size(i) work_size[i]
#include "../opencl/impulse_halfspace.cl"
#include "../opencl/impulse_scatter.cl"
#undef kernel
#undef global

typedef struct job {
    const al_impulse_rule *rule;
    const al_impulse_source *source;
    const double *distances;
    uint32_t distance_count;
    double *values;
} job;

/* All distances and cosines of one angle. */
static bool run_angle(void *user, unsigned angle, unsigned thread)
{
    const job *j = user;
    const al_impulse_rule *r = j->rule;
    const al_impulse_source *s = j->source;
    (void)thread;
    work_size[0] = (int)j->distance_count;
    work_size[1] = (int)r->cosine_count;
    work_size[2] = (int)r->angle_count;
    work_id[2] = (int)angle;
    for (work_id[1] = 0; work_id[1] < work_size[1]; work_id[1]++)
        for (work_id[0] = 0; work_id[0] < work_size[0]; work_id[0]++)
            if (r->emitter == AL_IMPULSE_DIRECTIONAL)
                impulse_halfspace(r->rays, r->turns, r->columns, s->values, j->distances, (int)r->step_count,
                                  (int)r->bands, (int)s->axis.count, (int)s->event, s->axis.first,
                                  1 / s->axis.step, j->values);
            else
                impulse_scatter(r->rays, r->columns, r->turns, r->spans, s->values, j->distances,
                                (int)r->step_count, (int)r->bands, (int)r->m_count, (int)s->axis.count,
                                (int)s->event, s->axis.first, 1 / s->axis.step, j->values);
    return true;
}

al_status al_impulse_scatter_double(const al_impulse_rule *rule, const al_impulse_source *source,
                                    const double *distances, uint32_t distance_count, unsigned threads,
                                    double *values, al_error *error)
{
    (void)error;
    job j = {rule, source, distances, distance_count, values};
    al_parallel(threads, rule->angle_count, run_angle, &j);
    al_impulse_divide(rule, source->event + 1, distances, distance_count, values);
    return AL_OK;
}
