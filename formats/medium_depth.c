#include "medium_depth.h"

#include <assert.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "half.h"
#include "kinds.h"
#include "record.h"

enum { EDGE_LIMIT = 256 };

static const al_field fields[] = {
    AL_FIELD(al_medium_depth, size, AL_FIELD_U32, 3, 2, EDGE_LIMIT),
    AL_FIELD(al_medium_depth, order, AL_FIELD_U32, 1, 1, AL_DEPTH_ORDER_LIMIT),
};
static const al_record record = {"DEPI", sizeof(al_medium_depth), fields, sizeof fields / sizeof *fields};

static size_t value_count(const al_medium_depth *depth)
{
    return (size_t)depth->order * depth->order * depth->size[0] * depth->size[1] * depth->size[2];
}

double al_medium_depth_unit_m(const al_medium_info *info, float density_max)
{
    double squared = 0;
    for (int k = 0; k < 3; k++) {
        double edge = (double)info->bounds_max_m[k] - info->bounds_min_m[k];
        squared += edge * edge;
    }
    return density_max * sqrt(squared) / AL_DEPTH_UNIT;
}

/* --- reading --- */

static void read_info(const al_file *file, const al_medium_info *info, al_medium_depth *depth, al_report *report)
{
    const void *data;
    size_t size;
    uint32_t frames = 0;
    uint64_t before = report->count;
    ptrdiff_t chunk = al_file_find(file, "DEPI", 0);
    *depth = (al_medium_depth){0};
    while (al_file_find(file, "DEPL", frames) >= 0) frames++;
    if (frames != (chunk < 0 ? 0 : info->frame_count))
        al_report_finding(report, AL_RULE_MEDIUM_DEPTH, "there are %" PRIu32 " DEPL chunks for %" PRIu32 " frames%s", frames,
                          info->frame_count, chunk < 0 ? " and no DEPI" : "");
    if (chunk < 0 || !al_report_data(report, file, (size_t)chunk, &data, &size)) return;
    if (size != al_record_size(&record))
        al_report_finding(report, AL_RULE_RECORD_SIZE, "DEPI: has %zu bytes, should have %zu", size, al_record_size(&record));
    else
        al_record_decode(&record, data, 1, "", 1, depth, report);
    if (report->count != before) *depth = (al_medium_depth){0};
}

static const uint16_t *read_frame(const al_file *file, const al_medium_depth *depth, uint32_t frame, al_report *report)
{
    const void *data;
    size_t size, count = value_count(depth);
    if (!al_report_data(report, file, (size_t)al_file_find(file, "DEPL", frame), &data, &size)) return NULL;
    if (size != 2 * count) {
        al_report_finding(report, AL_RULE_MEDIUM_DEPTH_SIZE, "DEPL of frame %" PRIu32 ": has %zu bytes, should have %zu",
                          frame, size, 2 * count);
        return NULL;
    }
    const uint16_t *values = data;
    for (size_t i = 0; i < count; i++)
        if ((values[i] & 0x7c00) == 0x7c00) {
            al_report_finding(report, AL_RULE_FINITE, "DEPL of frame %" PRIu32 ": number %zu is the half %04x", frame, i,
                              values[i]);
            return NULL;
        }
    return values;
}

void al_medium_depth_check(const al_file *file, const al_medium_info *info, al_report *report)
{
    al_medium_depth depth;
    read_info(file, info, &depth, report);
    for (uint32_t i = 0; depth.order && i < info->frame_count; i++) read_frame(file, &depth, i, report);
}

al_status al_medium_read_depth(const al_file *file, const al_medium_info *info, al_medium_depth *depth, al_error *error)
{
    al_report report = {.name = al_file_name(file), .error = error};
    read_info(file, info, depth, &report);
    return report.status;
}

al_status al_medium_read_depths(const al_file *file, const al_medium_depth *depth, uint32_t frame, const uint16_t **values,
                                al_error *error)
{
    al_report report = {.name = al_file_name(file), .error = error};
    *values = read_frame(file, depth, frame, &report);
    return report.status;
}

/* --- values --- */

void al_medium_depth_at(const al_medium_info *info, const al_medium_depth *depth, const uint16_t *values,
                        float density_max, const double position[3], double sh[AL_DEPTH_TERMS_LIMIT])
{
    size_t cell[3], points = (size_t)depth->size[0] * depth->size[1] * depth->size[2];
    double share[3];
    for (int k = 0; k < 3; k++) {
        double edge = (double)info->bounds_max_m[k] - info->bounds_min_m[k];
        double at = fmin(fmax((position[k] - info->bounds_min_m[k]) / edge, 0), 1) * (depth->size[k] - 1);
        cell[k] = (size_t)fmin(at, depth->size[k] - 2);
        share[k] = at - (double)cell[k];
    }
    for (uint32_t n = 0; n < depth->order * depth->order; n++) {
        sh[n] = 0;
        for (size_t i = 0; i < 8; i++) {
            double weight = al_medium_depth_unit_m(info, density_max);
            for (int k = 0; k < 3; k++) weight *= i >> k & 1 ? share[k] : 1 - share[k];
            size_t point = ((cell[2] + (i >> 2)) * depth->size[1] + cell[1] + (i >> 1 & 1)) * depth->size[0] + cell[0] +
                           (i & 1);
            sh[n] += weight * al_half_to_float(values[n * points + point]);
        }
    }
}

/* --- writing --- */

/* A coefficient is at most the root of 4 pi times the largest depth (Cauchy and Schwarz), so that halfs hold it. */
static void encode(const float *coefficients, size_t count, double unit_m, uint16_t *out)
{
    for (size_t i = 0; i < count; i++) out[i] = unit_m > 0 ? al_half_from_float((float)(coefficients[i] / unit_m)) : 0;
}

al_status al_medium_depth_write(al_writer *writer, const char *path, const al_medium_data *data,
                                const float *densities_max, al_error *error)
{
    uint8_t bytes[64];
    size_t count = value_count(data->depth);
    float *coefficients = malloc(count * sizeof *coefficients);
    uint16_t *halfs = malloc(count * sizeof *halfs);
    al_status status = AL_OK;
    if (!coefficients || !halfs) status = al_fail(error, AL_IO, "%s: out of memory for its optical depths", path);
    assert(al_record_size(&record) <= sizeof bytes);
    al_record_encode(&record, data->depth, 1, NULL, bytes);
    if (status == AL_OK)
        status = al_writer_add(writer, "DEPI", 1, AL_CHUNK_OPTIONAL, bytes, al_record_size(&record), error);
    for (uint32_t i = 0; i < data->info.frame_count && status == AL_OK; i++) {
        status = data->depths(data->depths_user, i, coefficients, error);
        if (status != AL_OK) break;
        encode(coefficients, count, al_medium_depth_unit_m(&data->info, densities_max[i]), halfs);
        status = al_writer_add(writer, "DEPL", 1, AL_CHUNK_OPTIONAL, halfs, 2 * count, error);
    }
    free(coefficients);
    free(halfs);
    return status;
}
