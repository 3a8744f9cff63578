/* Step 5: sample. Weighted Poisson-disk samples of the interior, and their Gaussians. */
#ifndef AIRLIGHT_SAMPLE_H
#define AIRLIGHT_SAMPLE_H

#include "airlight/program.h"
#include "grid.h"
#include "solid.h"

typedef struct al_interior { /* tetrahedra that fill the boundary, object space, metres */
    const double *points;    /* [..][3] */
    const uint32_t *corners; /* [count][4] */
    uint32_t count;
    const al_solid *blockers; /* NULL: none */
} al_interior;

typedef struct al_sample_options {
    uint32_t count;  /* asked number of samples, met within 2 %; 0: radius_m decides */
    double radius_m; /* base radius r, used when count is 0 */
    uint32_t seed;
    unsigned threads;
} al_sample_options;

typedef struct al_samples {
    uint32_t count;
    float *positions; /* [count][3], every prefix well spread */
    float *distances; /* [count] delta: |xi - xj| >= min(delta_i, delta_j) for every pair */
    float *gaussians; /* [count][4] a in 1/m^2, weight, radius in m, density */
    double radius_m;  /* base radius r */
    double volume_m3; /* V: the interior without blockers */
    float rho_quantile;
    float unity_mean, unity_deviation, unity_worst; /* of the sum of the Gaussians over the interior */
} al_samples;

/* Places the samples: rho [z][y][x] in 1/m. */
al_status al_sample_interior(const char *name, const al_grid *grid, const float *rho,
                             const al_interior *interior, const al_sample_options *options,
                             al_progress *progress, al_samples *samples, al_error *error);

/* Gives each sample its Gaussian: width from its neighbours' distance, weights such that the sum over all
 * samples is 1 inside, density at its place. */
al_status al_sample_gaussians(const char *name, const al_grid *grid, const al_interior *interior,
                              const al_density_field *field, const al_sample_options *options,
                              al_progress *progress, al_samples *samples, al_error *error);
void al_samples_free(al_samples *samples);

/* A point drawn uniformly from the interior without its blockers: number `index` of the sequence of `seed`.
 * prefix: running volumes of the tetrahedra. False when it fell into a blocker. */
typedef struct al_candidates {
    const al_interior *interior;
    double *running_volume; /* [interior.count] */
    uint32_t seed;
} al_candidates;
al_status al_candidates_create(const al_interior *interior, uint32_t seed, al_candidates *candidates,
                               al_error *error);
void al_candidates_free(al_candidates *candidates);
bool al_candidate(const al_candidates *candidates, uint64_t index, double point[3]);

#endif
