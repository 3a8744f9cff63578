/* The default impulse tables, which the test tables.bake made, and questions to them. */
#ifndef AIRLIGHT_TABLES_H
#define AIRLIGHT_TABLES_H

#include <stdlib.h>

#include "../test.h"
#include "airlight/formulas.h"
#include "airlight/impulse_tables.h"

static al_impulse_tables *tables_open(const char *path)
{
    al_error error;
    al_file *file; /* open until the program ends */
    al_impulse_tables *tables;
    FILE *there = fopen(path, "rb");
    if (!there) exit(test_skip("there are no tables: tables.bake found no OpenCL device"));
    fclose(there);
    al_status status = al_file_open(path, NULL, &file, &error);
    if (status == AL_OK) status = al_impulse_tables_read(file, &tables, &error);
    if (status == AL_OK) return tables;
    fprintf(stderr, "%s\n", error.message);
    exit(1);
}

/* Event 1 to `last` in the canonical medium. */
static inline al_impulse_query canonical(al_impulse_emitter emitter, double distance, uint32_t first,
                                         uint32_t last)
{
    return (al_impulse_query){.emitter = emitter, .first_event = first, .last_event = last,
                              .distance_m = distance, .cos_normal = 1, .sigma_s_per_m = 1};
}

static inline double fluence(const al_impulse_answer *a)
{
    return sqrt(4 * AL_PI) * a->sh[0][0];
}

static inline double flux_z(const al_impulse_answer *a)
{
    return sqrt(4 * AL_PI / 3) * a->sh[0][1];
}

/* Largest difference of the bands over band 0 of `expected`. */
static inline double band_error(const al_impulse_answer *a, const double *expected)
{
    double worst = 0;
    for (uint32_t l = 0; l < a->band_count; l++) worst = fmax(worst, fabs(a->sh[0][l] - expected[l]));
    return worst / expected[0];
}

#endif
