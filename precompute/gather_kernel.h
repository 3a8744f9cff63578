/* Irradiance of responses in one medium, for very many look-ups: walls `published`. */
#ifndef AIRLIGHT_GATHER_KERNEL_H
#define AIRLIGHT_GATHER_KERNEL_H

#include <stdbool.h>

#include "airlight/impulse_tables.h"

typedef struct al_gather_kernel al_gather_kernel;

/* All events of a medium with sigma_s = albedo sigma_t and Henyey-Greenstein g. NULL without memory.
 * Independent of the tables once it is made. */
al_gather_kernel *al_gather_kernel_create(const al_impulse_tables *tables, double albedo, double g);
void al_gather_kernel_free(al_gather_kernel *kernel); /* NULL is allowed */

/* W/m2 about a normal with components normal_z (towards the emitter) and normal_x (towards the side of its
 * normal), for a unit emitter. sigma_t_per_m is above 0. */
double al_gather_kernel_irradiance(const al_gather_kernel *kernel, al_impulse_emitter emitter,
                                   double distance_m, double cos_normal, double sigma_t_per_m,
                                   double normal_z, double normal_x);

#endif
