/* What reading and looking up impulse tables share. */
#ifndef AIRLIGHT_IMPULSE_H
#define AIRLIGHT_IMPULSE_H

#include <stdbool.h>

#include "airlight/impulse_tables.h"

enum { AL_IMPULSE_G_LIMIT = 16 }; /* tables of one emitter that differ in g */

struct al_impulse_tables {
    al_impulse_info info;
    al_impulse_table *tables; /* [info.table_count], pointing into the file */
    /* Where they are, by emitter and axis; NULL: not there. */
    const al_impulse_table *events[3][2][AL_IMPULSE_EVENT_LIMIT + 1]; /* isotropic, of one event */
    const al_impulse_table *resolved[3];                              /* event 1 by its angle of scattering */
    const al_impulse_table *summed[3][2];                             /* isotropic, events 1 to event_count */
    const al_impulse_table *all_in_one[3][2];                         /* the same with the beam */
    const al_impulse_table *phases[3][2][AL_IMPULSE_G_LIMIT];         /* event 1, g rising, 0 included */
    uint32_t phase_counts[3][2];
};

/* The numbers of one event in the query's medium, all factors but the sines of m in them. False: nothing is
 * left, they are 0. */
bool al_impulse_event_numbers(const al_impulse_tables *tables, const al_impulse_query *q, uint32_t axis,
                              uint32_t event, double *numbers);
/* Of max(0, cos), as integrals over directions. */
void al_impulse_cosine_bands(uint32_t count, double bands[AL_IMPULSE_BAND_LIMIT]);

#endif
