/* Collects what a checker finds. The same checks serve the readers (the first finding becomes the error) and
 * al_file_check (every finding is handed on). */
#ifndef AIRLIGHT_REPORT_H
#define AIRLIGHT_REPORT_H

#include <stdbool.h>

#include "airlight/container.h"
#include "rules.h"

typedef struct al_report {
    const char *name;          /* of the file */
    al_finding_fn *on_finding; /* may be NULL */
    void *user;
    al_error *error;
    al_status status; /* of the first finding or failure */
    uint64_t count;   /* findings and failures so far */
} al_report;

void al_report_finding(al_report *report, enum al_rule rule, const char *format, ...) AL_PRINTF(3, 4);
void al_report_out_of_memory(al_report *report);
/* Verified bytes of a chunk. A failure becomes the status and the error when it is the first, but is not
 * handed on as a finding: al_file_check looks at every checksum itself, before anything else. */
bool al_report_data(al_report *report, const al_file *file, size_t index, const void **data, size_t *size);

#endif
