/* Directions towards an environment map, drawn in proportion to what its pixels send. */
#ifndef AIRLIGHT_ENVIRONMENT_SAMPLER_H
#define AIRLIGHT_ENVIRONMENT_SAMPLER_H

#include "airlight/scene.h"

typedef struct al_environment_sampler {
    const al_environment *map; /* NULL: no environment, or a black one */
    double *rows;              /* [height + 1] cumulative weight */
    double *columns;           /* [height][width + 1] cumulative weight within the row */
} al_environment_sampler;

al_status al_environment_sampler_create(const al_environment *map, al_environment_sampler *sampler,
                                        al_error *error);
void al_environment_sampler_free(al_environment_sampler *sampler);

/* Direction the light arrives from, for u in [0,1)^2. */
void al_environment_sample(const al_environment_sampler *sampler, const double u[2], double direction[3]);
/* Probability per steradian of drawing a direction, and the radiance that arrives from there. */
double al_environment_density(const al_environment_sampler *sampler, const double direction[3],
                              double radiance[3]);

#endif
