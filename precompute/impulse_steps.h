/* The steps that make impulse tables. Formulas: opencl/impulse_scatter.cl, opencl/impulse_halfspace.cl. */
#ifndef AIRLIGHT_IMPULSE_STEPS_H
#define AIRLIGHT_IMPULSE_STEPS_H

#include "airlight/impulse_tables.h"
#include "airlight/program.h"
#include "bake_object.h"
#include "device.h"

typedef struct al_impulse_settings {
    uint32_t bands, events;
    uint32_t distances, cosines;       /* cosines: odd, 7 to 33 */
    double distance_min, distance_max; /* mean free paths */
    double g_range;                    /* event 1 is also tabulated at -g_range and g_range */
    bool all_in_one; /* also the paper's single table: beam and all events, nothing absorbed */
} al_impulse_settings;

/* Equal steps of the logarithm of distance. */
typedef struct al_impulse_axis_steps {
    uint32_t count;
    double first, step; /* natural logarithm */
} al_impulse_axis_steps;
double al_impulse_axis_distance(const al_impulse_axis_steps *axis, double place);

/* 1. The quadrature of one emitter: nodes and weights as the kernels take them, in double. */
typedef struct al_impulse_rule {
    al_impulse_emitter emitter;
    uint32_t angle_count, step_count; /* outer sum (angles of scattering), inner sum */
    uint32_t bands, m_count, cosine_count, number_count;
    double *angles;  /* [angle] ln tan(s/2) */
    double *rays;    /* scatter: [angle][step][3]; halfspace: [angle][3] */
    double *columns; /* scatter: [angle][step][number]; halfspace: [angle][band] */
    double *turns;   /* scatter: [angle][step][cosine][m][cosine]; halfspace: steps [step][5] */
    int32_t *spans;  /* scatter: [angle][step][cosine][2], of the turns' last index; else NULL */
    size_t ray_count, column_count, turn_count, span_count;
} al_impulse_rule;
/* Steps of the two trapezoidal sums; distance_min: the smallest distance that is asked. */
al_status al_impulse_rule_make(al_impulse_emitter emitter, uint32_t bands, uint32_t cosine_count,
                               double angle_step, double step, double distance_min, al_impulse_rule *rule,
                               al_error *error);
void al_impulse_rule_free(al_impulse_rule *rule);
void al_impulse_divide(const al_impulse_rule *rule, uint32_t event, const double *distances,
                       uint32_t distance_count, double *values);
/* cos_normal of node i of `count`. */
double al_impulse_cosine(uint32_t count, uint32_t i);

/* 2. One event more: the light of `event` events, as band 0 over the source's axis, scatters once. */
typedef struct al_impulse_source {
    uint32_t event; /* 0: the beam */
    al_impulse_axis_steps axis;
    const double *values; /* [distance][cosine] band 0 over asymptote */
} al_impulse_source;

/* On threads in double precision, or on the device in float32 (rule and source rounded). values
 * [angle][cosine][distance][number]: the share of each angle of scattering, over the asymptote of event + 1.
 */
al_status al_impulse_scatter_double(const al_impulse_rule *rule, const al_impulse_source *source,
                                    const double *distances, uint32_t distance_count, unsigned threads,
                                    double *values, al_error *error);
al_status al_impulse_scatter_device(al_device *device, const al_impulse_rule *rule,
                                    const al_impulse_source *source, const double *distances,
                                    uint32_t distance_count, double *values, al_error *error);

/* 3. The published axis: of an area emitter's numbers (over their asymptote) the angle and bands of the zonal
 * function nearest in the square norm. fitted: [1 + bands]. */
void al_impulse_fit(uint32_t bands, double cos_normal, const double *numbers, double *fitted);

/* All steps; writes the asset. Same bytes for any number of threads on one kind of device. */
al_status al_impulse_tables_bake(const char *path, const al_impulse_settings *settings, uint64_t key,
                                 al_device *device, const al_bake_options *options, al_steps *steps,
                                 al_error *error);
uint64_t al_impulse_tables_key(const al_impulse_settings *settings);

#endif
