/* Tetrahedra that fill a closed surface, made by the program airlight-tetrahedra (TetGen). */
#ifndef AIRLIGHT_TETRAHEDRA_H
#define AIRLIGHT_TETRAHEDRA_H

#include "import.h"

typedef struct al_tetrahedra {
    uint32_t point_count, count;
    double *points;    /* [point_count][3] metres */
    uint32_t *corners; /* [count][4] */
    bool exact;        /* false: the surface cuts itself and is filled within 1/512 of its box */
} al_tetrahedra;

/* Starts airlight-tetrahedra, found beside the running program. The volumes sum to the surface's, if that does
 * not cut itself; else to about that of what it winds around. Failures have `name` in the message. */
al_status al_tetrahedralise(const char *name, const al_triangles *surface, al_tetrahedra *tetrahedra, al_error *error);
void al_tetrahedra_free(al_tetrahedra *tetrahedra);

#endif
