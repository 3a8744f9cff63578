/* Reading, checking and writing of impulse tables; looking up is impulse_response.c. */
#include <assert.h>
#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "impulse.h"
#include "kinds.h"
#include "layout.h"
#include "record.h"

enum { AXIS_LIMIT = 65536, COSINES_MINIMUM = 7, DISTANCES_MINIMUM = 4, TABLE_LIMIT = 4096 };

#define G_LIMIT 0.99999994 /* the float before 1 */
#define COUNT_OF(array) (sizeof(array) / sizeof *(array))
#define INFO(member, type, minimum, maximum) AL_FIELD(al_impulse_info, member, type, 1, minimum, maximum)
#define TABLE(member, type, minimum, maximum) AL_FIELD(al_impulse_table, member, type, 1, minimum, maximum)

static const al_field info_fields[] = {
    INFO(band_count, AL_FIELD_U32, 3, AL_IMPULSE_BAND_LIMIT),
    INFO(event_count, AL_FIELD_U32, 1, AL_IMPULSE_EVENT_LIMIT),
    INFO(table_count, AL_FIELD_U32, 1, TABLE_LIMIT),
    INFO(distance_min, AL_FIELD_F64, DBL_MIN, 1e9),
    INFO(distance_max, AL_FIELD_F64, DBL_MIN, 1e9),
    INFO(rounding_error, AL_FIELD_F64, 0, DBL_MAX),
    INFO(interpolation_error, AL_FIELD_F64, 0, DBL_MAX),
};

static const al_field table_fields[] = {
    TABLE(emitter, AL_FIELD_U32, AL_IMPULSE_POINT, AL_IMPULSE_AREA),
    TABLE(axis, AL_FIELD_U32, AL_IMPULSE_AXIS_EMITTER, AL_IMPULSE_AXIS_FITTED),
    TABLE(first_event, AL_FIELD_U32, 0, AL_IMPULSE_EVENT_LIMIT),
    TABLE(last_event, AL_FIELD_U32, 1, AL_IMPULSE_EVENT_LIMIT),
    TABLE(distance_count, AL_FIELD_U32, DISTANCES_MINIMUM, AXIS_LIMIT),
    TABLE(cosine_count, AL_FIELD_U32, 1, AXIS_LIMIT),
    TABLE(angle_count, AL_FIELD_U32, 0, AXIS_LIMIT),
    TABLE(number_count, AL_FIELD_U32, 1, AL_IMPULSE_NUMBER_LIMIT),
    TABLE(g, AL_FIELD_F32, -G_LIMIT, G_LIMIT),
};

static const al_record info_record = {"INFO", sizeof(al_impulse_info), info_fields, COUNT_OF(info_fields)};
static const al_record table_record = {"TABL", sizeof(al_impulse_table), table_fields,
                                       COUNT_OF(table_fields)};

uint32_t al_impulse_number_count(uint32_t emitter, uint32_t axis, uint32_t band_count)
{
    if (axis == AL_IMPULSE_AXIS_FITTED) return band_count + 1;
    return emitter == AL_IMPULSE_AREA ? 3 * band_count - 3 : band_count;
}

/* --- sizes --- */

/* Byte offsets in a TABL chunk, and its size: at most 2^48 values of 48 x 4 bytes, below 2^64. */
typedef struct table_layout {
    uint64_t angles, angles_end, values, size;
} table_layout;

static uint64_t value_count(const al_impulse_table *t)
{
    return (uint64_t)(t->angle_count ? t->angle_count : 1) * t->cosine_count * t->distance_count *
           t->number_count;
}

static table_layout layout_of(const al_impulse_table *t)
{
    table_layout l;
    l.angles = al_padded(al_record_size(&table_record));
    l.angles_end = l.angles + 4 * (uint64_t)t->angle_count;
    l.values = al_padded(l.angles_end);
    l.size = l.values + 4 * value_count(t);
    return l;
}

/* --- checking and reading --- */

static bool read_record(const al_file *file, size_t chunk, const al_record *record, bool exact, void *values,
                        al_report *report)
{
    const void *data;
    size_t size, wanted = al_record_size(record);
    if (!al_report_data(report, file, chunk, &data, &size)) return false;
    if (exact ? size != wanted : size < wanted) {
        al_report_finding(report, AL_RULE_RECORD_SIZE, "%s: has %zu bytes, should have %zu", record->type,
                          size, wanted);
        return false;
    }
    uint64_t before = report->count;
    al_record_decode(record, data, 1, "", 1, values, report);
    return report->count == before;
}

static bool read_info(const al_file *file, al_impulse_info *info, al_report *report)
{
    ptrdiff_t index = al_file_find(file, "INFO", 0);
    assert(index >= 0); /* the kind asks for it */
    if (!read_record(file, (size_t)index, &info_record, true, info, report)) return false;
    uint64_t before = report->count;
    if (!(info->distance_min < info->distance_max))
        al_report_finding(report, AL_RULE_IMPULSE_RANGE, "INFO: distance_min is %g, distance_max %g",
                          info->distance_min, info->distance_max);
    uint32_t found = 0;
    for (size_t i = 0; i < al_file_chunk_count(file); i++) found += al_chunk_is(file, i, "TABL");
    if (found != info->table_count)
        al_report_finding(report, AL_RULE_IMPULSE_COUNT,
                          "INFO: table_count is %" PRIu32 ", there are %" PRIu32 " TABL chunks",
                          info->table_count, found);
    return report->count == before;
}

static void check_counts(const al_impulse_info *info, const al_impulse_table *t, uint32_t index,
                         al_report *report)
{
    uint32_t numbers = al_impulse_number_count(t->emitter, t->axis, info->band_count);
    bool area = t->emitter == AL_IMPULSE_AREA;
    if (t->number_count != numbers || (t->axis == AL_IMPULSE_AXIS_FITTED && !area))
        al_report_finding(report, AL_RULE_IMPULSE_NUMBERS,
                          "table %" PRIu32 ": %" PRIu32 " numbers about axis %" PRIu32 " of emitter %" PRIu32
                          ", %" PRIu32 " bands need %" PRIu32 "%s",
                          index, t->number_count, t->axis, t->emitter, info->band_count, numbers,
                          area ? "" : " about axis 0");
    if (area ? t->cosine_count % 2 == 0 || t->cosine_count < COSINES_MINIMUM : t->cosine_count != 1)
        al_report_finding(report, AL_RULE_IMPULSE_COSINES,
                          "table %" PRIu32 ": %" PRIu32 " cosines for emitter %" PRIu32, index,
                          t->cosine_count, t->emitter);
    if (t->first_event > t->last_event || t->last_event > info->event_count)
        al_report_finding(report, AL_RULE_IMPULSE_EVENTS,
                          "table %" PRIu32 ": events %" PRIu32 " to %" PRIu32 " of %" PRIu32, index,
                          t->first_event, t->last_event, info->event_count);
    if ((t->angle_count || t->g != 0) && (t->first_event != 1 || t->last_event != 1))
        al_report_finding(report, AL_RULE_IMPULSE_ANGLES,
                          "table %" PRIu32 ": events %" PRIu32 " to %" PRIu32 " with %" PRIu32
                          " angles, g %g",
                          index, t->first_event, t->last_event, t->angle_count, (double)t->g);
}

static void check_numbers(const al_impulse_table *t, uint32_t index, al_report *report)
{
    uint64_t count = value_count(t), bad = 0;
    while (bad < t->angle_count && isfinite(t->angles[bad])) bad++;
    if (bad < t->angle_count)
        al_report_finding(report, AL_RULE_FINITE, "table %" PRIu32 ": angle %" PRIu64 " is not finite", index,
                          bad);
    for (bad = 0; bad < count && isfinite(t->values[bad]);) bad++;
    if (bad < count)
        al_report_finding(report, AL_RULE_FINITE, "table %" PRIu32 ": value %" PRIu64 " is not finite", index,
                          bad);
}

static bool read_table(const al_file *file, const al_impulse_info *info, uint32_t index, size_t chunk,
                       al_impulse_table *t, al_report *report)
{
    const void *data;
    size_t size;
    uint64_t before = report->count;
    if (!read_record(file, chunk, &table_record, false, t, report)) return false;
    check_counts(info, t, index, report);
    if (report->count != before || !al_report_data(report, file, chunk, &data, &size)) return false;
    table_layout l = layout_of(t);
    if (size != l.size) {
        al_report_finding(report, AL_RULE_IMPULSE_SIZE,
                          "table %" PRIu32 ": has %zu bytes, its counts need %" PRIu64, index, size, l.size);
        return false;
    }
    const uint8_t *bytes = data;
    uint64_t head = al_record_size(&table_record);
    if (!al_all_zero(bytes + head, l.angles - head) ||
        !al_all_zero(bytes + l.angles_end, l.values - l.angles_end))
        al_report_finding(report, AL_RULE_IMPULSE_PADDING,
                          "table %" PRIu32 ": bytes between its arrays are not zero", index);
    t->angles = t->angle_count ? (const float *)(const void *)(bytes + l.angles) : NULL;
    t->values = (const float *)(const void *)(bytes + l.values);
    check_numbers(t, index, report);
    return report->count == before;
}

static bool same_content(const al_impulse_table *a, const al_impulse_table *b)
{
    return a->emitter == b->emitter && a->axis == b->axis && a->first_event == b->first_event &&
           a->last_event == b->last_event && !a->angle_count == !b->angle_count && a->g == b->g;
}

/* Event 1 of another g goes into the list of its emitter and axis, g rising; false when there is no room. */
static bool add_phase(al_impulse_tables *tables, const al_impulse_table *t)
{
    uint32_t *count = &tables->phase_counts[t->emitter][t->axis], at = *count;
    const al_impulse_table **list = tables->phases[t->emitter][t->axis];
    if (*count == AL_IMPULSE_G_LIMIT) return false;
    for (; at > 0 && list[at - 1]->g > t->g; at--) list[at] = list[at - 1];
    list[at] = t;
    ++*count;
    return true;
}

static void place_table(al_impulse_tables *tables, uint32_t index, al_report *report)
{
    const al_impulse_table *t = &tables->tables[index];
    for (uint32_t i = 0; i < index; i++)
        if (same_content(&tables->tables[i], t))
            al_report_finding(report, AL_RULE_IMPULSE_TWICE,
                              "tables %" PRIu32 " and %" PRIu32 " hold the same events of emitter %" PRIu32,
                              i, index, t->emitter);
    bool one = t->first_event == t->last_event && !t->angle_count;
    if (t->angle_count && t->axis == AL_IMPULSE_AXIS_EMITTER)
        tables->resolved[t->emitter] = t;
    else if (one && t->first_event == 1 && !add_phase(tables, t))
        al_report_finding(report, AL_RULE_IMPULSE_TWICE,
                          "table %" PRIu32 ": more than %d values of g for one emitter", index,
                          AL_IMPULSE_G_LIMIT);
    else if (!one && t->first_event == 1 && t->last_event == tables->info.event_count)
        tables->summed[t->emitter][t->axis] = t;
    else if (!one && t->first_event == 0 && t->last_event == tables->info.event_count)
        tables->all_in_one[t->emitter][t->axis] = t;
    if (one && t->g == 0) tables->events[t->emitter][t->axis][t->first_event] = t;
}

static void check_complete(const al_impulse_tables *tables, al_report *report)
{
    for (uint32_t emitter = 0; emitter < 3; emitter++)
        for (uint32_t event = 1; event <= tables->info.event_count; event++)
            if (!tables->events[emitter][AL_IMPULSE_AXIS_EMITTER][event])
                al_report_finding(report, AL_RULE_IMPULSE_MISSING,
                                  "no table of event %" PRIu32 " of emitter %" PRIu32, event, emitter);
}

static void read_tables(const al_file *file, al_impulse_tables *tables, al_report *report)
{
    if (!read_info(file, &tables->info, report)) return;
    uint64_t before = report->count;
    uint32_t index = 0;
    tables->tables = calloc(tables->info.table_count, sizeof *tables->tables);
    if (!tables->tables) {
        al_report_out_of_memory(report);
        return;
    }
    for (size_t i = 0; i < al_file_chunk_count(file); i++) {
        if (!al_chunk_is(file, i, "TABL")) continue;
        if (read_table(file, &tables->info, index, i, &tables->tables[index], report))
            place_table(tables, index, report);
        index++;
    }
    if (report->count == before) check_complete(tables, report);
}

void al_impulse_tables_free(al_impulse_tables *tables)
{
    if (!tables) return;
    free(tables->tables);
    free(tables);
}

al_status al_impulse_tables_read(const al_file *file, al_impulse_tables **tables, al_error *error)
{
    *tables = NULL;
    if (al_file_kind(file) != AL_KIND_IMPULSE_TABLES)
        return al_fail(error, AL_BAD_INPUT, "%s: is an asset of kind %s, wanted is impulse-tables",
                       al_file_name(file), al_kind_name(al_file_kind(file)));
    al_report report = {.name = al_file_name(file), .error = error};
    al_impulse_tables *made = calloc(1, sizeof *made);
    if (made)
        read_tables(file, made, &report);
    else
        al_report_out_of_memory(&report);
    if (report.status == AL_OK)
        *tables = made;
    else
        al_impulse_tables_free(made);
    return report.status;
}

const al_impulse_info *al_impulse_tables_info(const al_impulse_tables *tables)
{
    return &tables->info;
}

const al_impulse_table *al_impulse_tables_table(const al_impulse_tables *tables, uint32_t index)
{
    assert(index < tables->info.table_count);
    return &tables->tables[index];
}

static void check_impulse_tables(const al_file *file, al_report *report)
{
    al_impulse_tables *tables = calloc(1, sizeof *tables);
    if (tables)
        read_tables(file, tables, report);
    else
        al_report_out_of_memory(report);
    al_impulse_tables_free(tables);
}

static const al_chunk_rules chunks[] = {{"INFO", 1, 1, 1}, {"TABL", 1, 0, 0}, {"MEAS", 1, 0, 0}, {"PROV", 1, 0, 1}};

const al_kind_rules al_impulse_tables_rules = {AL_KIND_IMPULSE_TABLES, "impulse-tables", chunks,
                                               COUNT_OF(chunks), check_impulse_tables};

/* --- writing --- */

static al_status add_table(al_writer *writer, const char *path, const al_impulse_table *t, al_error *error)
{
    table_layout l = layout_of(t);
    uint8_t *bytes = calloc(l.size, 1);
    if (!bytes) return al_fail(error, AL_IO, "%s: out of memory for a table", path);
    al_record_encode(&table_record, t, 1, NULL, bytes);
    if (t->angle_count) memcpy(bytes + l.angles, t->angles, 4 * (size_t)t->angle_count);
    memcpy(bytes + l.values, t->values, 4 * value_count(t));
    al_status status = al_writer_add(writer, "TABL", 1, 0, bytes, l.size, error);
    free(bytes);
    return status;
}

al_status al_impulse_tables_write(const char *path, const al_impulse_data *data, uint64_t *bytes,
                                  al_error *error)
{
    al_writer *writer;
    uint8_t info[64];
    if (bytes) *bytes = 0;
    assert(al_record_size(&info_record) <= sizeof info);
    al_record_encode(&info_record, &data->info, 1, NULL, info);
    al_status status = al_writer_open(path, AL_KIND_IMPULSE_TABLES, &writer, error);
    if (status != AL_OK) return status;
    status = al_writer_add(writer, "INFO", 1, 0, info, al_record_size(&info_record), error);
    for (uint32_t i = 0; status == AL_OK && i < data->info.table_count; i++)
        status = add_table(writer, path, &data->tables[i], error);
    if (status == AL_OK) status = al_measured_write(writer, data->measured, data->measured_count, error);
    if (status == AL_OK && data->provenance_json)
        status = al_writer_add(writer, "PROV", 1, AL_CHUNK_OPTIONAL, data->provenance_json,
                               strlen(data->provenance_json), error);
    if (status == AL_OK) return al_writer_commit(writer, bytes, error);
    al_writer_discard(writer);
    return status;
}
