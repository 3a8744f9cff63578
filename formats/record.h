/* Records: structs stored field by field, little-endian, one after the other, as a table of fields says. The
 * same table writes, reads and checks; docs/formats.md shows it with types and ranges. */
#ifndef AIRLIGHT_RECORD_H
#define AIRLIGHT_RECORD_H

#include "report.h"

typedef enum al_field_type {
    AL_FIELD_U32,
    AL_FIELD_BOOL, /* u32, 0 or 1; bool in memory */
    AL_FIELD_F32,
    AL_FIELD_F64,
    AL_FIELD_TEXT /* u32, offset into chunk TEXT; char * in memory */
} al_field_type;

typedef struct al_field {
    const char *name;
    al_field_type type;
    size_t offset;           /* in the struct */
    uint32_t count;          /* array elements */
    double minimum, maximum; /* numbers; both included; minimum > maximum: anything finite */
} al_field;

#define AL_FIELD(record, member, type, count, minimum, maximum) \
    { \
#member, type, offsetof(record, member), count, minimum, maximum \
    }

typedef struct al_record {
    const char *type; /* of the chunk, and in messages */
    size_t stride;    /* of the struct in memory */
    const al_field *fields;
    size_t field_count;
} al_record;

size_t al_record_size(const al_record *record); /* bytes of one record as stored */

/* Texts being collected for chunk TEXT; the first byte is the empty text. */
typedef struct al_text_table {
    char *bytes;
    size_t size, capacity;
} al_text_table;

/* Encodes `count` structs into `bytes` (count * al_record_size). False when out of memory or when there are
 * more than 4 GiB of texts. texts may be NULL for records without any. */
bool al_record_encode(const al_record *record, const void *values, size_t count, al_text_table *texts,
                      uint8_t *bytes);

/* Decodes `count` records and checks every field. text: chunk TEXT, checked to end with a zero byte. What is
 * found wrong is left as it is (texts: ""). */
void al_record_decode(const al_record *record, const uint8_t *bytes, size_t count, const char *text,
                      size_t text_size, void *values, al_report *report);

#endif
