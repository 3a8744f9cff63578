#include "record.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "layout.h"

static size_t element_size(al_field_type type)
{
    return type == AL_FIELD_F64 ? 8 : 4;
}

size_t al_record_size(const al_record *record)
{
    size_t size = 0;
    for (size_t i = 0; i < record->field_count; i++)
        size += element_size(record->fields[i].type) * record->fields[i].count;
    return size;
}

/* --- writing --- */

static bool add_text(al_text_table *texts, const char *text, uint32_t *offset)
{
    size_t size = strlen(text) + 1, needed = (texts->size ? texts->size : 1) + size;
    *offset = 0;
    if (needed > UINT32_MAX) return false;
    if (needed > texts->capacity) {
        size_t capacity = 2 * needed;
        char *bytes = realloc(texts->bytes, capacity);
        if (!bytes) return false;
        texts->bytes = bytes;
        texts->capacity = capacity;
    }
    if (!texts->size) texts->bytes[texts->size++] = 0;
    if (size == 1) return true;
    *offset = (uint32_t)texts->size;
    memcpy(texts->bytes + texts->size, text, size);
    texts->size += size;
    return true;
}

static bool encode_element(al_field_type type, const char *value, al_text_table *texts, uint8_t *bytes)
{
    uint64_t bits = 0;
    uint32_t small = 0;
    bool flag;
    char *text;
    switch (type) {
    case AL_FIELD_U32:
    case AL_FIELD_F32:
        memcpy(&small, value, 4);
        break;
    case AL_FIELD_BOOL:
        memcpy(&flag, value, sizeof flag);
        small = flag;
        break;
    case AL_FIELD_F64:
        memcpy(&bits, value, 8);
        break;
    case AL_FIELD_TEXT:
        memcpy(&text, value, sizeof text);
        if (!add_text(texts, text, &small)) return false;
        break;
    }
    al_put_bytes(bytes, type == AL_FIELD_F64 ? bits : small, (unsigned)element_size(type));
    return true;
}

static size_t memory_size(al_field_type type)
{
    switch (type) {
    case AL_FIELD_U32:
    case AL_FIELD_F32:
        return 4;
    case AL_FIELD_BOOL:
        return sizeof(bool);
    case AL_FIELD_F64:
        return 8;
    case AL_FIELD_TEXT:
        break;
    }
    return sizeof(char *);
}

bool al_record_encode(const al_record *record, const void *values, size_t count, al_text_table *texts,
                      uint8_t *bytes)
{
    for (size_t r = 0; r < count; r++)
        for (const al_field *f = record->fields; f < record->fields + record->field_count; f++)
            for (uint32_t e = 0; e < f->count; e++, bytes += element_size(f->type)) {
                const char *value =
                    (const char *)values + r * record->stride + f->offset + e * memory_size(f->type);
                if (!encode_element(f->type, value, texts, bytes)) return false;
            }
    return true;
}

/* --- reading --- */

typedef struct place {
    const al_record *record;
    const al_field *field;
    size_t index;
    al_report *report;
} place;

static void check_number(const place *at, double value)
{
    const al_field *f = at->field;
    if (!isfinite(value))
        al_report_finding(at->report, AL_RULE_FINITE, "%s %zu: %s is not finite", at->record->type, at->index,
                          f->name);
    else if (f->minimum <= f->maximum && !(value >= f->minimum && value <= f->maximum))
        al_report_finding(at->report, AL_RULE_RANGE, "%s %zu: %s is %.9g, its range is %.9g to %.9g",
                          at->record->type, at->index, f->name, value, f->minimum, f->maximum);
}

static void decode_element(const place *at, const uint8_t *bytes, const char *text, size_t text_size,
                           char *value)
{
    uint32_t small = al_get_u32(bytes);
    float real;
    double big_real;
    bool flag;
    switch (at->field->type) {
    case AL_FIELD_U32:
        memcpy(value, &small, 4);
        check_number(at, small);
        break;
    case AL_FIELD_F32:
        memcpy(value, &small, 4);
        memcpy(&real, &small, 4);
        check_number(at, real);
        break;
    case AL_FIELD_F64: {
        uint64_t bits = al_get_u64(bytes);
        memcpy(value, &bits, 8);
        memcpy(&big_real, &bits, 8);
        check_number(at, big_real);
        break;
    }
    case AL_FIELD_BOOL:
        flag = small != 0;
        memcpy(value, &flag, sizeof flag);
        if (small > 1)
            al_report_finding(at->report, AL_RULE_RANGE, "%s %zu: %s is %" PRIu32 ", its range is 0 to 1",
                              at->record->type, at->index, at->field->name, small);
        break;
    case AL_FIELD_TEXT:
        if (small >= text_size) {
            al_report_finding(at->report, AL_RULE_TEXT,
                              "%s %zu: %s begins at offset %" PRIu32 ", the texts have %zu bytes",
                              at->record->type, at->index, at->field->name, small, text_size);
            text = "";
            small = 0;
        }
        text += small;
        memcpy(value, &text, sizeof text);
        break;
    }
}

void al_record_decode(const al_record *record, const uint8_t *bytes, size_t count, const char *text,
                      size_t text_size, void *values, al_report *report)
{
    place at = {.record = record, .report = report};
    for (at.index = 0; at.index < count; at.index++)
        for (at.field = record->fields; at.field < record->fields + record->field_count; at.field++)
            for (uint32_t e = 0; e < at.field->count; e++, bytes += element_size(at.field->type)) {
                char *value = (char *)values + at.index * record->stride + at.field->offset +
                              e * memory_size(at.field->type);
                decode_element(&at, bytes, text, text_size, value);
            }
}
