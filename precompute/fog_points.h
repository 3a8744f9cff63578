/* The light inside the fog, known at a coarse lattice of points: for walls `bounded` and `traced`. */
#ifndef AIRLIGHT_FOG_POINTS_H
#define AIRLIGHT_FOG_POINTS_H

#include "gather_state.h"

/* A place where a path asks what the fog scatters into it. */
typedef struct al_fog_record {
    float position[3], direction[3]; /* the ray's, away from where the light arrives */
    float g;
    float weight[3]; /* what the light is multiplied with on its way to the path's first point */
    float first[3];  /* the path's first direction */
} al_fog_record;

typedef struct al_fog_records {
    al_fog_record *list;
    uint32_t count, room;
} al_fog_records;
bool al_fog_record_push(al_fog_records *records, const al_fog_record *record); /* false without memory */

/* Fills gather->points; everything else in the gather must be there. AL_CANCELLED when on_progress says so.
 */
al_status al_fog_points_create(al_gather *gather, al_error *error);
void al_fog_points_free(al_fog_points *points);

/* J = integral of p L over the sphere, for light that goes on against `direction`: W/(m2 sr). L leaves out
 * what comes straight from lamps; with traced walls also what comes straight from emissive surfaces and the
 * sky. */
void al_fog_points_scatter(const al_fog_points *points, const double position[3], const double direction[3],
                           double g, double radiance[3]);
/* Irradiance, W/m2, of light scattered once or more often on a surface at `position` with its unit `normal`.
 * False where no point knows. */
bool al_fog_points_irradiance(const al_fog_points *points, const double position[3], const double normal[3],
                              double irradiance[3]);
/* The longest edge of the lattice's cells. */
double al_fog_points_cell_m(const al_fog_points *points);
/* Transmittance from a lamp of the scene, shadows included. False where no point knows. */
bool al_fog_points_lamp(const al_fog_points *points, uint32_t lamp, const double position[3],
                        double transmittance[3]);

#endif
