/* report.json: what a bake planned, did, read and wrote. */
#ifndef AIRLIGHT_REPORT_H
#define AIRLIGHT_REPORT_H

#include "airlight/trade_table.h"
#include "bake_object.h"
#include "plan.h"

typedef struct al_report {
    const al_import *import;
    const al_plan *plan;
    al_steps steps;               /* import and scene */
    al_steps light;               /* of probes and lightmap; none when they were up to date */
    uint32_t lightmap_page_count; /* 0 without a lightmap */
    al_steps *objects;            /* [translucent_count]; an object that was up to date has none */
    al_trade_pick pick;           /* of --target-error */
    const char *device;           /* "" when none was needed */
} al_report;

/* One JSON text of the plan, as --plan prints it; free() it. NULL when memory runs out. */
char *al_plan_json(const al_plan *plan);
/* Writes FOLDER/report.json atomically. */
al_status al_report_write(const char *folder, const al_report *report, al_error *error);

#endif
