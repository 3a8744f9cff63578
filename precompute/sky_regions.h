/* An environment map cut into regions, each asked for along one direction. */
#ifndef AIRLIGHT_SKY_REGIONS_H
#define AIRLIGHT_SKY_REGIONS_H

#include "airlight/medium.h"
#include "airlight/scene.h"

typedef struct al_sky_region {
    double direction[3];              /* unit, where its light arrives from */
    double power[3];                  /* integral of its radiance over its solid angle, W/m2 */
    double sh[3][AL_SKY_TERMS_LIMIT]; /* of its radiance, world axes */
} al_sky_region;

/* At most `limit` regions; together they are the map, whatever its shape. `order` bands of SH are filled. To
 * be freed. AL_IO without memory. */
al_status al_sky_regions_create(const al_environment *map, uint32_t order, uint32_t limit,
                                al_sky_region **regions, uint32_t *count, al_error *error);

#endif
