/* Light that an endless fog scatters from an emitter to a vertex, from tables: walls `published`. */
#ifndef AIRLIGHT_GATHER_RESPONSE_H
#define AIRLIGHT_GATHER_RESPONSE_H

#include "gather_path.h"

/* Collapses the tables for the scene's fog. The gather must hold fog and tables. */
al_status al_gather_responses_create(al_gather *gather, al_error *error);
void al_gather_responses_free(al_gather *gather);

/* An emitter as a vertex sees it. Pointers go into the light or way that it was made of. */
typedef struct al_gather_source {
    al_impulse_emitter emitter;
    const double *direction; /* towards it */
    double normal[3];        /* of an area, on the vertex' side where cos_normal is above 0 */
    double cos_normal;
    const al_fog_mean *fog; /* in between; its length is the distance */
    const double *transmittance;
} al_gather_source;
/* Of a light, or of the far end of a way; what the response is to be multiplied with: `power` of the light,
 * or the radiance that the far end sends over its density_per_sr times *scale. False: nothing comes of it. */
al_gather_source al_gather_source_of_light(const al_gather_straight *straight);
bool al_gather_source_of_way(const al_gather_way *way, al_gather_source *source, double *scale);

/* Irradiance about a normal, per channel, for a unit emitter. */
void al_gather_response(const al_gather *gather, const al_gather_source *source, const double normal[3],
                        double irradiance[3]);
/* Adds power times the response as incident radiance in world axes, order * order numbers a channel. */
void al_gather_response_sh(const al_gather *gather, const al_gather_source *source, const double power[3],
                           uint32_t order, double sh[3][AL_GATHER_SH_COUNT]);

/* By how much light grows from surface to surface when it is followed without end, in the channel where it
 * grows most: at 1 and above there is no limit. */
bool al_gather_gain(const al_gather *gather, al_gather_scratch *scratch, double *gain);

#endif
