/* Where light probes stand. */
#ifndef AIRLIGHT_PLACE_PROBES_H
#define AIRLIGHT_PLACE_PROBES_H

#include "import.h"

typedef struct al_probe_places {
    uint32_t count;
    double (*points)[3]; /* world space, m */
    double spacing_m;    /* 0 for given points */
} al_probe_places;

/* The scene file's points, or a body-centred lattice over the box of the lightmapped meshes (of all opaque
 * ones that stand still when there are none): its Delaunay tetrahedra are all alike and fill space.
 * The outermost layers lie a twentieth of a cell inside the box. AL_BAD_INPUT when there is nothing to
 * place them in, or when there would be more than 2^24. */
al_status al_probe_places_make(const al_import *import, al_probe_places *places, al_error *error);
/* How many there will be; 0 where al_probe_places_make refuses. */
double al_probe_count(const al_import *import);
void al_probe_places_free(al_probe_places *places);

#endif
