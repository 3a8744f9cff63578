/* Light paths over surfaces: what a surface point receives and sends, estimated by one path. */
#ifndef AIRLIGHT_GATHER_PATH_H
#define AIRLIGHT_GATHER_PATH_H

#include "gather_state.h"

/* The first way of a path is seen by the point itself: there places, which cost less than rays, take more
 * noise away than paths do. */
enum { AL_GATHER_FIRST_PLACES = 8, AL_GATHER_LATER_PLACES = 2 };

/* One way along which light arrives at a vertex. */
typedef struct al_gather_way {
    al_ray ray;
    double density_per_sr; /* of drawing the direction */
    bool asks;             /* whether `fog` is wanted */
    bool scatters;         /* whether `scattered` is wanted of the fog points */
    bool surfaces;         /* whether `surface` and `attenuated` are wanted too */
    uint32_t places;       /* distances drawn for the fog points' light: AL_GATHER_FIRST_PLACES or _LATER_ */
    bool met;              /* a surface ends it */
    al_surface_hit hit;
    double transmittance[3];
    al_fog_mean fog;       /* where responses are asked; only if it is not dark */
    double scattered[3];   /* radiance that arrives from the fog on the way */
    double emitted[3];     /* by the far end, its share against being found as a light */
    al_gather_layers sent; /* radiance that leaves the far end along the ray: of surface or sky */
} al_gather_way;

/* Fills the way from its ray, density, `asks`, `scatters`, `surfaces` and `places`. `bounces`: diffuse reflections that
 * may follow, the one at its end included. `carried`: what arriving radiance is multiplied with on its way to
 * the path's first point; `importance`: the share that surfaces leave of it, for Russian roulette. */
bool al_gather_follow(const al_gather *gather, al_gather_scratch *scratch, uint32_t bounces,
                      const double carried[3], double importance, al_sequence *sequence, al_gather_way *way);

/* Whether the far end sends nothing. Without fog points the transmittance of such a way is left at 1. */
bool al_gather_is_dark(const al_gather_way *way);

/* The light of one kind that reaches a vertex straight. */
typedef struct al_gather_straight {
    al_light_sample light;
    double transmittance[3]; /* of the fog */
    al_fog_mean fog;         /* where responses are asked */
    double share;            /* of this way to find the light, against directions drawn at the vertex */
} al_gather_straight;

/* Draws a light and looks whether it is there. False when nothing arrives. */
bool al_gather_look(const al_gather *gather, al_gather_scratch *scratch, const al_gather_vertex *vertex,
                    al_light_kind kind, al_sequence *sequence, al_gather_straight *straight);

/* The side of a surface that a ray met. */
al_gather_vertex al_gather_vertex_of(const al_surface_hit *hit);

/* Where light of the fog points counts: lets directions be drawn about the point lamp that glows brightest
 * there, by its intensity over the distance. */
void al_gather_find_glow(const al_gather *gather, al_gather_vertex *vertex);

/* Where rays from the vertex along `direction` begin. */
void al_gather_origin(const al_gather_vertex *vertex, const double direction[3], double origin[3]);

/* How directions are drawn at a vertex: in proportion to the cosine, or evenly in the air. Where responses
 * are asked a tenth is even over the hemisphere, and for back-scatter a quarter goes behind, in proportion to
 * 1/cosine there. Where a lamp glows in fog a quarter goes about it, some of it below the surface. */
void al_gather_draw(const al_gather_vertex *vertex, const double u[2], double direction[3],
                    double *density_per_sr);
double al_gather_density(const al_gather_vertex *vertex, const double direction[3]);

#endif
