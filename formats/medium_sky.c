#include "medium_sky.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/formulas.h"
#include "half.h"
#include "kinds.h"
#include "record.h"

enum { EDGE_LIMIT = 256, DEPTH_LIMIT_HALF = 0x5400 /* 64 */, EIGHTHS = 8 };

#define FIELD(member, type, count, minimum, maximum) \
    AL_FIELD(al_medium_sky, member, type, count, minimum, maximum)

static const al_field fields[] = {
    FIELD(size, AL_FIELD_U32, 3, 2, EDGE_LIMIT), FIELD(order, AL_FIELD_U32, 1, 1, AL_SKY_ORDER_LIMIT),
    FIELD(grade, AL_FIELD_F32, 3, 0, 6),         FIELD(unit_w_m2_sr, AL_FIELD_F32, 1, FLT_MIN, FLT_MAX),
    FIELD(walled, AL_FIELD_BOOL, 1, 0, 1),
};
static const al_record record = {"SKYI", sizeof(al_medium_sky), fields, sizeof fields / sizeof *fields};

static size_t point_count(const al_medium_sky *sky)
{
    return (size_t)sky->size[0] * sky->size[1] * sky->size[2];
}

static size_t cell_count(const al_medium_sky *sky)
{
    return (size_t)(sky->size[0] - 1) * (sky->size[1] - 1) * (sky->size[2] - 1);
}

static size_t value_count(const al_medium_sky *sky)
{
    return (1 + (size_t)sky->order * sky->order) * point_count(sky) * 3;
}

/* --- reading --- */

/* The bytes of the chunk, `size` of them; NULL after a finding. */
static const void *read_chunk(const al_file *file, const char type[5], size_t wanted, enum al_rule rule,
                              al_report *report)
{
    const void *data;
    size_t size;
    if (!al_report_data(report, file, (size_t)al_file_find(file, type, 0), &data, &size)) return NULL;
    if (size == wanted) return data;
    al_report_finding(report, rule, "%s: has %zu bytes, should have %zu", type, size, wanted);
    return NULL;
}

static void check_values(const al_medium_sky *sky, al_report *report)
{
    size_t depths = 3 * point_count(sky);
    for (size_t i = 0; i < value_count(sky); i++) {
        bool infinite = (sky->values[i] & 0x7c00) == 0x7c00;
        if (i < depths ? sky->values[i] <= DEPTH_LIMIT_HALF : !infinite) continue;
        al_report_finding(report, infinite ? AL_RULE_FINITE : AL_RULE_MEDIUM_SKY_DEPTH,
                          "SKYL: number %zu is the half %04x", i, sky->values[i]);
        return;
    }
}

/* A plane for each axis, and no other bit. */
static bool is_valid(uint8_t planes)
{
    return planes < 64 && ((planes | planes >> 3) & 7) == 7;
}

static void check_planes(const al_medium_sky *sky, al_report *report)
{
    for (size_t i = 0; i < EIGHTHS * cell_count(sky); i++) {
        if (is_valid(sky->planes[i])) continue;
        al_report_finding(report, AL_RULE_MEDIUM_SKY_PLANES, "SKYC: eighth %zu takes the planes %02x", i,
                          sky->planes[i]);
        return;
    }
}

static void read_sky(const al_file *file, al_medium_sky *sky, al_report *report)
{
    bool has[3];
    static const char types[3][5] = {"SKYI", "SKYL", "SKYC"};
    uint64_t before = report->count;
    *sky = (al_medium_sky){0};
    for (int i = 0; i < 3; i++) has[i] = al_file_find(file, types[i], 0) >= 0;
    if (!has[0] && !has[1] && !has[2]) return;
    const void *bytes =
        has[0] ? read_chunk(file, "SKYI", al_record_size(&record), AL_RULE_RECORD_SIZE, report) : NULL;
    if (bytes) al_record_decode(&record, bytes, 1, "", 1, sky, report);
    if (report->count == before && (!has[0] || !has[1] || has[2] != sky->walled))
        al_report_finding(report, AL_RULE_MEDIUM_SKY,
                          "of SKYI, SKYL and SKYC not all are there that should be");
    if (report->count != before) return;
    sky->values = read_chunk(file, "SKYL", 2 * value_count(sky), AL_RULE_MEDIUM_SKY_SIZE, report);
    if (sky->values) check_values(sky, report);
    if (!sky->walled) return;
    sky->planes = read_chunk(file, "SKYC", EIGHTHS * cell_count(sky), AL_RULE_MEDIUM_SKY_SIZE, report);
    if (sky->planes) check_planes(sky, report);
}

void al_medium_sky_check(const al_file *file, al_report *report)
{
    al_medium_sky sky;
    read_sky(file, &sky, report);
}

al_status al_medium_read_sky(const al_file *file, al_medium_sky *sky, al_error *error)
{
    al_report report = {.name = al_file_name(file), .error = error};
    read_sky(file, sky, &report);
    if (report.status != AL_OK) *sky = (al_medium_sky){0};
    return report.status;
}

/* --- values --- */

/* Trilinear in a cell: of `count` numbers of three channels each, from number `first` on. */
static void blend(const al_medium_sky *sky, const size_t cell[3], const double share[3], uint32_t first,
                  uint32_t count, double out[3][AL_SKY_TERMS_LIMIT])
{
    for (int c = 0; c < 3; c++) memset(out[c], 0, sizeof out[c]);
    for (size_t i = 0; i < 8; i++) {
        double weight = 1;
        for (int k = 0; k < 3; k++) weight *= i >> k & 1 ? share[k] : 1 - share[k];
        size_t point =
            ((cell[2] + (i >> 2)) * sky->size[1] + cell[1] + (i >> 1 & 1)) * sky->size[0] + cell[0] + (i & 1);
        for (uint32_t n = 0; n < count; n++)
            for (size_t c = 0; c < 3; c++)
                out[c][n] +=
                    weight * al_half_to_float(sky->values[((first + n) * point_count(sky) + point) * 3 + c]);
    }
}

/* As shaders/fog_sky.glsl. */
void al_medium_sky_at(const al_medium_info *info, const al_medium_sky *sky, const double position[3],
                      double sh[3][AL_SKY_TERMS_LIMIT])
{
    size_t cell[3], number = 0;
    double share[3], depth[3][AL_SKY_TERMS_LIMIT];
    unsigned eighth = 0;
    for (int k = 2; k >= 0; k--) {
        double edge = (double)info->bounds_max_m[k] - info->bounds_min_m[k];
        double place = fmin(fmax((position[k] - info->bounds_min_m[k]) / edge, 0), 1);
        double at = al_graded_share(sky->grade[k], place) * (sky->size[k] - 1);
        cell[k] = (size_t)fmin(fmax(at, 0), sky->size[k] - 2);
        share[k] = fmin(fmax(at - (double)cell[k], 0), 1);
        eighth = 2 * eighth + (share[k] >= 0.5);
        number = number * (sky->size[k] - 1) + cell[k];
    }
    blend(sky, cell, share, 0, 1, depth);
    unsigned planes = sky->walled ? sky->planes[EIGHTHS * number + eighth] : 63;
    for (int k = 0; k < 3; k++) share[k] = !(planes >> k & 1) ? 1 : !(planes >> (3 + k) & 1) ? 0 : share[k];
    blend(sky, cell, share, 1, sky->order * sky->order, sh);
    for (int c = 0; c < 3; c++)
        for (uint32_t n = 0; n < sky->order * sky->order; n++)
            sh[c][n] *= sky->unit_w_m2_sr * exp(-depth[c][0]);
}

/* --- writing --- */

/* Stored numbers reach into [2^14, 2^15), below the largest half. */
static float encode(const float *values, size_t depths, size_t count, uint16_t *out)
{
    float largest = 0;
    int exponent = 15;
    for (size_t i = depths; i < count; i++) largest = fmaxf(largest, fabsf(values[i]));
    if (largest > 0x1p-100f) frexpf(largest, &exponent);
    for (size_t i = 0; i < count; i++)
        out[i] = al_half_from_float(i < depths ? values[i] : ldexpf(values[i], 15 - exponent));
    return ldexpf(1, exponent - 15);
}

al_status al_medium_sky_write(al_writer *writer, const char *path, const al_medium_sky *sky,
                              const float *values, al_error *error)
{
    uint8_t bytes[64];
    al_medium_sky made = *sky;
    size_t count = value_count(sky);
    uint16_t *halfs = malloc(count * sizeof *halfs);
    if (!halfs) return al_fail(error, AL_IO, "%s: out of memory for its sky light", path);
    made.unit_w_m2_sr = encode(values, 3 * point_count(sky), count, halfs);
    assert(al_record_size(&record) <= sizeof bytes);
    al_record_encode(&record, &made, 1, NULL, bytes);
    al_status status =
        al_writer_add(writer, "SKYI", 1, AL_CHUNK_OPTIONAL, bytes, al_record_size(&record), error);
    if (status == AL_OK)
        status = al_writer_add(writer, "SKYL", 1, AL_CHUNK_OPTIONAL, halfs, 2 * count, error);
    if (status == AL_OK && sky->walled)
        status = al_writer_add(writer, "SKYC", 1, AL_CHUNK_OPTIONAL, sky->planes, EIGHTHS * cell_count(sky),
                               error);
    free(halfs);
    return status;
}
