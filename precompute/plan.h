/* The plan: which bakes a scene needs, why, and what they will cost; made from the scene alone. */
#ifndef AIRLIGHT_PLAN_H
#define AIRLIGHT_PLAN_H

#include "import.h"

enum { AL_PLAN_LIMIT = 32 };

typedef struct al_plan_step {
    const char *step;
    bool needed;
    const char *why;
    double seconds; /* estimate on two cores */
    uint64_t bytes; /* memory while it runs, estimate */
} al_plan_step;

typedef struct al_plan {
    al_plan_step steps[AL_PLAN_LIMIT];
    unsigned count;
} al_plan;

/* Lightmaps and probes with walls as published look the fog's scattered light up in impulse tables. */
bool al_plan_needs_tables(const al_import *import);
void al_plan_make(const al_import *import, al_plan *plan);

#endif
