/* Whether a point lies inside a closed surface. */
#ifndef AIRLIGHT_SOLID_H
#define AIRLIGHT_SOLID_H

#include "import.h"

typedef struct al_solid al_solid;

/* The triangles may be freed afterwards; without any, the solid is empty. */
al_status al_solid_create(const al_triangles *triangles, al_solid **solid, al_error *error);
void al_solid_free(al_solid *solid); /* NULL is allowed */

/* Positions as of the triangles. Within 1e-6 of the surface's size the answer is either. Any number of
 * threads may ask. */
bool al_solid_contains(const al_solid *solid, const double point[3]);

#endif
