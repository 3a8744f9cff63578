/* The step "measure": what an asset says, compared with a truth that is computed another way. The figures go
 * into the asset (airlight/measured.h). They depend on the asset and its inputs alone, not on threads. */
#ifndef AIRLIGHT_MEASURE_H
#define AIRLIGHT_MEASURE_H

#include "airlight/translucent.h"
#include "import.h"

typedef struct al_measure { /* sums over the numbers compared so far */
    uint32_t count;
    double square, truth_square, largest;
} al_measure;
/* deviation: what the asset says less the truth. */
void al_measure_add(al_measure *measure, double deviation, double truth);
/* The texts must outlive the result. There must be at least one number. */
al_measured al_measure_result(const al_measure *measure, const char *compared, const char *settings,
                              const char *unit);

/* The same of light that was gathered twice, along other paths: each number deviates as much as the truth does. */
al_measured al_measure_twice(const al_measure *measure, const char *compared, const char *settings, const char *unit);

typedef struct al_measured_object {
    const al_import *import;
    uint32_t index;                          /* of the translucent object */
    const al_triangles *boundary, *blockers; /* object space, metres */
    uint32_t seed;
    unsigned threads;
} al_measured_object;

/* Transmittance at random points of the object's medium towards random directions against exp(-tau): tau from
 * every triangle that the ray crosses and closed forms of the density between them, in double precision. No
 * number is compared where the medium's share of the boundary's box is too small to be found. */
al_status al_measure_object(const al_measured_object *object, const al_translucent_data *data, al_measure *measure,
                            al_error *error);

#endif
