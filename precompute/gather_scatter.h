/* Light that the fog scatters into a ray, for walls `bounded` and `traced`. */
#ifndef AIRLIGHT_GATHER_SCATTER_H
#define AIRLIGHT_GATHER_SCATTER_H

#include "gather_path.h"

/* Estimates the radiance that arrives at the origin of the way's ray from the fog in scratch->fog, and puts
 * it in way->scattered. With scratch->record, light that was not straight from a lamp before goes there
 * instead, times `carried`: what the light is multiplied with on its way to the path's first point. */
bool al_gather_scatter(const al_gather *gather, al_gather_scratch *scratch, const double carried[3],
                       al_sequence *sequence, al_gather_way *way);

#endif
