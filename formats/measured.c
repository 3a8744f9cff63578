#include "airlight/measured.h"

#include <assert.h>
#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "kinds.h"
#include "record.h"

#define FIELD(member, type, minimum, maximum) AL_FIELD(al_measured, member, type, 1, minimum, maximum)

static const al_field fields[] = {
    FIELD(compared, AL_FIELD_TEXT, 0, 0),
    FIELD(settings, AL_FIELD_TEXT, 0, 0),
    FIELD(unit, AL_FIELD_TEXT, 0, 0),
    FIELD(count, AL_FIELD_U32, 1, UINT32_MAX),
    FIELD(rmse, AL_FIELD_F64, 0, DBL_MAX),
    FIELD(truth_rms, AL_FIELD_F64, 0, DBL_MAX),
    FIELD(largest, AL_FIELD_F64, 0, DBL_MAX),
    FIELD(standard_error, AL_FIELD_F64, 0, DBL_MAX),
};

static const al_record record = {"MEAS", sizeof(al_measured), fields, sizeof fields / sizeof *fields};

/* Bytes of the UTF-8 character at `at`, 0 when there is none: no overlong forms, no surrogates. */
static size_t character_size(const uint8_t *at, size_t left)
{
    static const uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
    size_t size = *at < 0x80 ? 1 : *at >> 5 == 6 ? 2 : *at >> 4 == 14 ? 3 : *at >> 3 == 30 ? 4 : 0;
    if (size == 0 || size > left) return 0;
    uint32_t code = size == 1 ? *at : *at & (0x7fu >> size);
    for (size_t i = 1; i < size; i++) {
        if (at[i] >> 6 != 2) return 0;
        code = code << 6 | (at[i] & 0x3f);
    }
    return code >= least[size] && code <= 0x10ffff && code >> 11 != 27 ? size : 0;
}

static bool is_text(const uint8_t *bytes, size_t size)
{
    size_t at = 0, step = 1;
    while (at < size && step) at += step = character_size(bytes + at, size - at);
    return size > 0 && at == size && bytes[0] == 0 && bytes[size - 1] == 0;
}

static void read_measured(const al_file *file, size_t chunk, al_measured *measured, al_report *report)
{
    const void *data;
    size_t size, head = al_record_size(&record);
    *measured = (al_measured){0};
    if (!al_report_data(report, file, chunk, &data, &size)) return;
    if (size < head) {
        al_report_finding(report, AL_RULE_RECORD_SIZE, "MEAS: has %zu bytes, should have %zu and texts", size,
                          head);
        return;
    }
    const uint8_t *bytes = data, *texts = bytes + head;
    if (is_text(texts, size - head))
        al_record_decode(&record, bytes, 1, (const char *)texts, size - head, measured, report);
    else
        al_report_finding(report, AL_RULE_MEASURED_TEXT,
                          "MEAS: the %zu bytes of texts do not begin and end with a zero byte or are not UTF-8",
                          size - head);
}

uint32_t al_measured_count(const al_file *file)
{
    uint32_t count = 0;
    while (al_file_find(file, record.type, count) >= 0) count++;
    return count;
}

al_status al_measured_read(const al_file *file, uint32_t index, al_measured *measured, al_error *error)
{
    al_report report = {.name = al_file_name(file), .error = error};
    ptrdiff_t chunk = al_file_find(file, record.type, index);
    assert(chunk >= 0);
    read_measured(file, (size_t)chunk, measured, &report);
    if (report.status != AL_OK) *measured = (al_measured){0};
    return report.status;
}

void al_check_measured(const al_file *file, al_report *report)
{
    al_measured measured;
    for (size_t i = 0; i < al_file_chunk_count(file); i++)
        if (al_chunk_is(file, i, record.type)) read_measured(file, i, &measured, report);
}

static al_status write_one(al_writer *writer, const al_measured *measured, al_error *error)
{
    al_text_table texts = {0};
    size_t head = al_record_size(&record);
    uint8_t *bytes = malloc(head), *whole = NULL;
    bool good = bytes && al_record_encode(&record, measured, 1, &texts, bytes);
    if (good) whole = realloc(bytes, head + texts.size);
    if (whole) {
        bytes = whole;
        memcpy(bytes + head, texts.bytes, texts.size);
    }
    al_status status = whole ? al_writer_add(writer, record.type, 1, AL_CHUNK_OPTIONAL, bytes,
                                             head + texts.size, error)
                             : al_fail(error, AL_IO, "out of memory for a measured error");
    free(texts.bytes);
    free(bytes);
    return status;
}

al_status al_measured_write(al_writer *writer, const al_measured *measured, uint32_t count, al_error *error)
{
    al_status status = AL_OK;
    for (uint32_t i = 0; i < count && status == AL_OK; i++) status = write_one(writer, &measured[i], error);
    return status;
}
