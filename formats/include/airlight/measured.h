/* Measured errors: what an asset says compared with a truth that was computed another way, while it was baked.
 * An asset of any kind that is baked may hold some, each in a chunk MEAS. */
#ifndef AIRLIGHT_MEASURED_H
#define AIRLIGHT_MEASURED_H

#include "airlight/container.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct al_measured {
    const char *compared; /* what with what, UTF-8 */
    const char *settings; /* of the bake whose error it is */
    const char *unit;     /* of the figures; empty: they have none */
    uint32_t count;       /* numbers compared, from 1 */
    double rmse;
    double truth_rms;      /* root mean square of the truth: rmse / truth_rms is the relative error */
    double largest;        /* deviation */
    double standard_error; /* of one number of the truth, root mean square; 0: the truth is not random */
} al_measured;

uint32_t al_measured_count(const al_file *file);
/* Reads and validates number `index`. Its texts are valid until al_file_close. */
al_status al_measured_read(const al_file *file, uint32_t index, al_measured *measured, al_error *error);
/* For the writers of the kinds. */
al_status al_measured_write(al_writer *writer, const al_measured *measured, uint32_t count, al_error *error);

#ifdef __cplusplus
}
#endif
#endif
