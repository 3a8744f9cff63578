#include "kinds.h"

#include <jansson.h>
#include <string.h>

static const al_kind_rules *const kinds[] = {
    &al_scene_rules, &al_translucent_rules, &al_impulse_tables_rules, &al_lightmap_rules, &al_probes_rules, &al_medium_rules};

const al_kind_rules *al_kind_find(al_kind kind)
{
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (kinds[i]->kind == kind) return kinds[i];
    return NULL;
}

const char *al_kind_name(al_kind kind)
{
    const al_kind_rules *rules = al_kind_find(kind);
    return rules ? rules->name : "unknown";
}

const al_chunk_rules *al_chunk_find(const al_kind_rules *kind, const char type[5])
{
    for (size_t i = 0; i < kind->chunk_count; i++)
        if (!memcmp(kind->chunks[i].type, type, 4)) return &kind->chunks[i];
    return NULL;
}

void al_check_provenance(const al_file *file, al_report *report)
{
    const void *data;
    size_t size;
    ptrdiff_t index = al_file_find(file, "PROV", 0);
    if (index < 0 || !al_report_data(report, file, (size_t)index, &data, &size)) return;
    json_t *root = json_loadb(size ? data : "", size, JSON_REJECT_DUPLICATES, NULL);
    if (!json_is_object(root)) al_report_finding(report, AL_RULE_PROVENANCE, "chunk PROV is no JSON object");
    json_decref(root);
}
