/* What each kind of asset consists of. A new kind is one file that defines its al_kind_rules and one row in
 * kinds.c. */
#ifndef AIRLIGHT_KINDS_H
#define AIRLIGHT_KINDS_H

#include "report.h"

typedef struct al_chunk_rules {
    char type[5];
    uint16_t version;          /* the newest that is read */
    uint32_t minimum, maximum; /* how often; maximum 0: any number */
} al_chunk_rules;

typedef struct al_kind_rules {
    al_kind kind;
    const char *name;
    const al_chunk_rules *chunks;
    size_t chunk_count;
    void (*check)(const al_file *file, al_report *report); /* NULL: this version has no reader for the kind */
} al_kind_rules;

extern const al_kind_rules al_scene_rules, al_translucent_rules, al_impulse_tables_rules, al_lightmap_rules, al_probes_rules,
    al_medium_rules;

const al_kind_rules *al_kind_find(al_kind kind); /* NULL when there is no such kind */
const al_chunk_rules *al_chunk_find(const al_kind_rules *kind, const char type[5]);

/* The chunk has the type, in a version that this reader knows: an optional one of a newer version is skipped. */
bool al_chunk_is(const al_file *file, size_t index, const char type[5]);

/* PROV of any kind: a JSON object, optional. */
void al_check_provenance(const al_file *file, al_report *report);

/* MEAS of any kind: optional. */
void al_check_measured(const al_file *file, al_report *report);

#endif
