/* What airlight-inspect says about each kind of asset. A new kind is one file and one row in main.c. */
#ifndef AIRLIGHT_INSPECT_H
#define AIRLIGHT_INSPECT_H

#include <jansson.h>
#include <stdbool.h>

#include "airlight/container.h"

typedef struct inspected_kind {
    al_kind kind;
    /* A new object with the asset's statistics. */
    al_status (*summary)(const al_file *file, json_t **summary, al_error *error);
    /* Answers `query`, an object; AL_USAGE when it asks wrongly. NULL: the kind answers nothing. */
    al_status (*evaluate)(const al_file *file, const json_t *query, json_t **answer, al_error *error);
    al_status (*draw)(const al_file *file, const char *png_path, al_error *error);
} inspected_kind;

extern const inspected_kind inspected_translucent, inspected_scene, inspected_impulse_tables, inspected_lightmap, inspected_probes,
    inspected_medium;

/* Numbers as JSON; what is not finite becomes null. Decimals enough to tell every float apart. */
json_t *json_number(double value);
json_t *json_numbers(const float *values, size_t count);
/* A text that need not be UTF-8: foreign bytes become '?'. */
json_t *json_text(const char *text);
/* The object in chunk PROV, or null. */
json_t *json_provenance(const al_file *file);

/* The measured errors in chunks MEAS, in their order. */
json_t *json_measured(const al_file *file);

/* Key `key` of `query` as three finite numbers; AL_USAGE when it is not. */
al_status query_vector(const json_t *query, const char *key, float vector[3], al_error *error);
/* AL_USAGE when the query has a key that is not among `keys` (NULL ends them). */
al_status query_keys(const json_t *query, const char *const *keys, al_error *error);

#endif
