/* A point of an eye ray at which light is scattered towards the eye: drawing it, and what it scatters. */
#ifndef AIRLIGHT_SCATTER_POINT_H
#define AIRLIGHT_SCATTER_POINT_H

#include "directions.h"
#include "march.h"

/* How distances are drawn, as one distribution: one half each
 *   - in proportion to sigma_t T(eye, x): most of the light comes from near the front;
 *   - in proportion to sigma_t: for media lit from behind;
 * or with a point light one third each, and the last third by equal angles seen from there (Kulla and Fajardo
 * 2012), which cancel 1/r^2. A distribution inverted as a whole, and not a way picked at random, lets strata
 * of random numbers be strata of distance. */
typedef struct al_scatter_mixture {
    const al_ray *eye;
    const al_cells *cells;
    int channels;      /* to draw from: 1 when all are alike */
    double mean_depth; /* of the whole ray */
    double share;      /* of each way */
    bool by_angle;
    al_angles angles;
} al_scatter_mixture;

/* `light` is the position of a point light, or NULL. Eye and cells must outlive the mixture. False where the
 * ray meets no medium. */
bool al_scatter_mixture_create(const al_ray *eye, const al_cells *cells, const double *light,
                               al_scatter_mixture *mixture);

typedef struct al_scatter_point {
    const al_cell *cell;
    double distance_m, density_per_m; /* along the eye ray; how densely the mixture draws here */
    double position[3];
    double transmittance[3]; /* to the eye */
} al_scatter_point;

/* The point for u in [0,1). False where there is no medium: equal angles reach into gaps. */
bool al_scatter_point_draw(const al_scatter_mixture *mixture, double u, al_scatter_point *point);
/* The point at a distance. False where there is no medium. */
bool al_scatter_point_at(const al_scatter_mixture *mixture, double distance_m, al_scatter_point *point);

/* sigma_s p, summed over the media at the point, for light that arrives from `towards`; per metre and
 * steradian. */
void al_scatter_towards(const al_scatter_mixture *mixture, const al_scatter_point *point,
                        const double towards[3], double out[3]);

/* A direction from which light arrives, for u in [0,1)^2, and its probability per steradian: the media's
 * phase functions, each by its share of sigma_s. 0: nothing scatters here. */
double al_scatter_draw_direction(const al_scatter_mixture *mixture, const al_scatter_point *point,
                                 const double u[2], double towards[3]);
double al_scatter_direction_density(const al_scatter_mixture *mixture, const al_scatter_point *point,
                                    const double towards[3]);

#endif
