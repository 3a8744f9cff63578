#include "airlight/translucent.h"

#include <assert.h>
#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/formulas.h"
#include "half.h"
#include "kinds.h"
#include "layout.h"
#include "record.h"

enum { GRID_EDGE_LIMIT = 4096, DEFAULT_PAGE_SIZE = 4096, BYTE_STEPS = 127 };

#define COUNT_LIMIT (UINT32_MAX / 2)
#define FIELD(member, type, count, minimum, maximum) \
    AL_FIELD(al_translucent_info, member, type, count, minimum, maximum)

/* |g| below 1: the float before it. */
#define G_LIMIT 0.99999994

static const al_field info_fields[] = {
    FIELD(sample_count, AL_FIELD_U32, 1, 0, COUNT_LIMIT),
    FIELD(page_size, AL_FIELD_U32, 1, 1, COUNT_LIMIT),
    FIELD(order, AL_FIELD_U32, 1, 1, AL_SH_MAX_ORDER),
    FIELD(channel_count, AL_FIELD_U32, 1, 1, 3),
    FIELD(format, AL_FIELD_U32, 1, AL_COEFFICIENT_FLOAT, AL_COEFFICIENT_BYTE),
    FIELD(direction_count, AL_FIELD_U32, 1, 2, COUNT_LIMIT),
    FIELD(grid_size, AL_FIELD_U32, 3, 1, GRID_EDGE_LIMIT),
    FIELD(has_blockers, AL_FIELD_U32, 1, 0, 1),
    FIELD(grid_origin_m, AL_FIELD_F32, 3, 1, 0),
    FIELD(voxel_m, AL_FIELD_F32, 1, FLT_TRUE_MIN, FLT_MAX),
    FIELD(density_max, AL_FIELD_F32, 1, 0, FLT_MAX),
    FIELD(sigma_s_per_m, AL_FIELD_F32, 3, 0, FLT_MAX),
    FIELD(sigma_a_per_m, AL_FIELD_F32, 3, 0, FLT_MAX),
    FIELD(g, AL_FIELD_F32, 1, -G_LIMIT, G_LIMIT),
    FIELD(ior, AL_FIELD_F32, 1, 1, FLT_MAX),
    FIELD(bounds_min_m, AL_FIELD_F32, 3, 1, 0),
    FIELD(bounds_max_m, AL_FIELD_F32, 3, 1, 0),
    FIELD(volume_m3, AL_FIELD_F64, 1, 0, DBL_MAX),
    FIELD(radius_m, AL_FIELD_F64, 1, 0, DBL_MAX),
    FIELD(rho_quantile, AL_FIELD_F32, 1, 0, FLT_MAX),
    FIELD(unity_mean, AL_FIELD_F32, 1, 0, FLT_MAX),
    FIELD(unity_deviation, AL_FIELD_F32, 1, 0, FLT_MAX),
    FIELD(unity_worst, AL_FIELD_F32, 1, 0, FLT_MAX),
};

static const al_record info_record = {"INFO", sizeof(al_translucent_info), info_fields,
                                      sizeof info_fields / sizeof *info_fields};

/* --- sizes --- */

static uint32_t coefficient_size(uint32_t format)
{
    return format == AL_COEFFICIENT_FLOAT ? 4 : format == AL_COEFFICIENT_HALF ? 2 : 1;
}

/* Byte offsets of a page's arrays, each a multiple of 64, and the size of the chunk. At most
 * 2^31 samples x (12 + 16 + 12 + 3 x 64 x 4 bytes): far below 2^64. */
typedef struct page_layout {
    uint64_t gaussians, scales, coefficients, size;
} page_layout;

static page_layout layout_of(const al_translucent_info *info, uint32_t count)
{
    page_layout l;
    uint64_t scales_size =
        info->format == AL_COEFFICIENT_BYTE ? (uint64_t)count * info->channel_count * 4 : 0;
    l.gaussians = al_padded((uint64_t)count * 12);
    l.scales = l.gaussians + al_padded((uint64_t)count * 16);
    l.coefficients = l.scales + al_padded(scales_size);
    l.size = l.coefficients + (uint64_t)count * info->channel_count * info->order * info->order *
                                  coefficient_size(info->format);
    return l;
}

uint32_t al_translucent_page_count(const al_translucent_info *info)
{
    return (uint32_t)(((uint64_t)info->sample_count + info->page_size - 1) / info->page_size);
}

static uint32_t page_samples(const al_translucent_info *info, uint32_t index)
{
    uint32_t rest = info->sample_count - index * info->page_size;
    return rest < info->page_size ? rest : info->page_size;
}

static uint64_t voxel_count(const al_translucent_info *info)
{
    return (uint64_t)info->grid_size[0] * info->grid_size[1] * info->grid_size[2];
}

/* --- checking and reading --- */

static void check_info(const al_translucent_info *info, al_report *report)
{
    if (info->channel_count == 2)
        al_report_finding(report, AL_RULE_TRANSLUCENT_CHANNELS, "INFO: channel_count is 2, it can be 1 or 3");
    if (info->direction_count % 2)
        al_report_finding(report, AL_RULE_TRANSLUCENT_DIRECTIONS,
                          "INFO: direction_count is %" PRIu32 ", it must be even", info->direction_count);
    for (int i = 0; i < 3; i++)
        if (info->bounds_min_m[i] > info->bounds_max_m[i])
            al_report_finding(report, AL_RULE_TRANSLUCENT_BOUNDS,
                              "INFO: bounds_min_m[%d] is %g, above bounds_max_m[%d], %g", i,
                              (double)info->bounds_min_m[i], i, (double)info->bounds_max_m[i]);
}

static void check_page_count(const al_file *file, const al_translucent_info *info, al_report *report)
{
    uint32_t expected = al_translucent_page_count(info), found = 0;
    for (size_t i = 0; i < al_file_chunk_count(file); i++)
        found += al_chunk_is(file, i, "PAGE");
    if (found != expected)
        al_report_finding(report, AL_RULE_TRANSLUCENT_PAGES,
                          "%" PRIu32 " samples in pages of %" PRIu32 " fill %" PRIu32
                          " pages, there are %" PRIu32,
                          info->sample_count, info->page_size, expected, found);
}

/* True when sizes and the number of pages can be relied on. */
static bool read_info(const al_file *file, al_translucent_info *info, al_report *report)
{
    const void *data;
    size_t size, wanted = al_record_size(&info_record);
    *info = (al_translucent_info){0};
    ptrdiff_t index = al_file_find(file, "INFO", 0);
    assert(index >= 0); /* the kind asks for it */
    if (!al_report_data(report, file, (size_t)index, &data, &size)) return false;
    if (size != wanted) {
        al_report_finding(report, AL_RULE_RECORD_SIZE, "INFO: has %zu bytes, should have %zu", size, wanted);
        return false;
    }
    uint64_t before = report->count;
    al_record_decode(&info_record, data, 1, "", 1, info, report);
    check_info(info, report);
    if (report->count == before) check_page_count(file, info, report);
    return report->count == before;
}

al_status al_translucent_read(const al_file *file, al_translucent_info *info, al_error *error)
{
    *info = (al_translucent_info){0};
    if (al_file_kind(file) != AL_KIND_TRANSLUCENT)
        return al_fail(error, AL_BAD_INPUT, "%s: is an asset of kind %s, wanted is translucent",
                       al_file_name(file), al_kind_name(al_file_kind(file)));
    al_report report = {.name = al_file_name(file), .error = error};
    if (!read_info(file, info, &report)) *info = (al_translucent_info){0};
    return report.status;
}

/* The first of the numbers that is not finite, or `count`. */
static size_t first_not_finite(const float *numbers, size_t count)
{
    size_t i = 0;
    while (i < count && isfinite(numbers[i])) i++;
    return i;
}

static void check_finite(const float *numbers, size_t count, const char *what, uint32_t page,
                         al_report *report)
{
    size_t bad = first_not_finite(numbers, count);
    if (bad < count)
        al_report_finding(report, AL_RULE_FINITE, "page %" PRIu32 ": number %zu of the %s is not finite",
                          page, bad, what);
}

static void check_coefficients(const al_translucent_info *info, const al_translucent_page *page,
                               uint32_t index, al_report *report)
{
    size_t sets = (size_t)page->count * info->channel_count, count = sets * info->order * info->order,
           bad = 0;
    if (info->format == AL_COEFFICIENT_FLOAT) {
        check_finite(page->coefficients, count, "coefficients", index, report);
    } else if (info->format == AL_COEFFICIENT_HALF) {
        const uint16_t *halves = page->coefficients;
        while (bad < count && (halves[bad] & 0x7c00) != 0x7c00) bad++;
        if (bad < count)
            al_report_finding(report, AL_RULE_FINITE,
                              "page %" PRIu32 ": number %zu of the coefficients is not finite", index, bad);
    } else {
        check_finite(page->scales, sets, "scales", index, report);
        for (size_t i = 0; i < sets; i++)
            if (page->scales[i] < 0) {
                al_report_finding(report, AL_RULE_TRANSLUCENT_SCALE, "page %" PRIu32 ": scale %zu is %g",
                                  index, i, (double)page->scales[i]);
                break;
            }
        if (memchr(page->coefficients, 0x80, count))
            al_report_finding(report, AL_RULE_TRANSLUCENT_BYTE, "page %" PRIu32 ": a coefficient is -128",
                              index);
    }
}

static bool gaussian_is_good(const float g[4])
{
    return g[0] > 0 && g[1] >= 0 && g[2] > 0 && g[3] >= 0;
}

static bool sample_is_inside(const al_translucent_info *info, const float position[3], float radius)
{
    for (int i = 0; i < 3; i++)
        if (position[i] < (double)info->bounds_min_m[i] - radius ||
            position[i] > (double)info->bounds_max_m[i] + radius)
            return false;
    return true;
}

static void check_samples(const al_translucent_info *info, const al_translucent_page *page, uint32_t index,
                          al_report *report)
{
    check_finite(page->positions, 3 * (size_t)page->count, "positions", index, report);
    check_finite(page->gaussians, 4 * (size_t)page->count, "gaussians", index, report);
    bool shapes = true, places = true;
    for (uint32_t i = 0; i < page->count && (shapes || places); i++) {
        const float *b = page->positions + 3 * (size_t)i, *g = page->gaussians + 4 * (size_t)i;
        if (shapes && !gaussian_is_good(g)) {
            al_report_finding(report, AL_RULE_TRANSLUCENT_GAUSSIAN,
                              "page %" PRIu32 ", sample %" PRIu32 ": a %g, weight %g, radius %g, density %g",
                              index, page->first + i, (double)g[0], (double)g[1], (double)g[2], (double)g[3]);
            shapes = false;
        }
        if (places && !sample_is_inside(info, b, g[2])) {
            al_report_finding(report, AL_RULE_TRANSLUCENT_INSIDE,
                              "page %" PRIu32 ", sample %" PRIu32 ": (%g, %g, %g) lies outside the bounds",
                              index, page->first + i, (double)b[0], (double)b[1], (double)b[2]);
            places = false;
        }
    }
}

/* The arrays in the bytes of a page. */
static al_translucent_page split_page(const al_translucent_info *info, uint32_t index, const uint8_t *bytes)
{
    uint32_t count = page_samples(info, index);
    page_layout l = layout_of(info, count);
    bool has_scales = info->format == AL_COEFFICIENT_BYTE;
    return (al_translucent_page){.first = index * info->page_size,
                                 .count = count,
                                 .positions = (const float *)(const void *)bytes,
                                 .gaussians = (const float *)(const void *)(bytes + l.gaussians),
                                 .scales = has_scales ? (const float *)(const void *)(bytes + l.scales) : NULL,
                                 .coefficients = bytes + l.coefficients};
}

static bool read_page(const al_file *file, const al_translucent_info *info, uint32_t index, size_t chunk,
                      al_translucent_page *page, al_report *report)
{
    const void *data;
    size_t size;
    uint32_t count = page_samples(info, index);
    page_layout l = layout_of(info, count);
    *page = (al_translucent_page){0};
    if (!al_report_data(report, file, chunk, &data, &size)) return false;
    if (size != l.size) {
        al_report_finding(report, AL_RULE_TRANSLUCENT_PAGE_SIZE,
                          "page %" PRIu32 ": has %zu bytes, %" PRIu32 " samples need %" PRIu64, index, size,
                          count, l.size);
        return false;
    }
    const uint8_t *bytes = data;
    uint64_t scales_end =
        l.scales + (info->format == AL_COEFFICIENT_BYTE ? (uint64_t)count * info->channel_count * 4 : 0);
    if (!al_all_zero(bytes + (uint64_t)count * 12, l.gaussians - (uint64_t)count * 12) ||
        !al_all_zero(bytes + l.gaussians + (uint64_t)count * 16,
                     l.scales - l.gaussians - (uint64_t)count * 16) ||
        !al_all_zero(bytes + scales_end, l.coefficients - scales_end))
        al_report_finding(report, AL_RULE_TRANSLUCENT_PAGE_PADDING,
                          "page %" PRIu32 ": bytes between its arrays are not zero", index);
    *page = split_page(info, index, bytes);
    check_samples(info, page, index, report);
    check_coefficients(info, page, index, report);
    return true;
}

al_status al_translucent_read_page(const al_file *file, const al_translucent_info *info, uint32_t index,
                                   al_translucent_page *page, al_error *error)
{
    assert(index < al_translucent_page_count(info));
    *page = (al_translucent_page){0};
    ptrdiff_t chunk = al_file_find(file, "PAGE", index);
    al_report report = {.name = al_file_name(file), .error = error};
    assert(chunk >= 0); /* al_translucent_read has counted the pages */
    read_page(file, info, index, (size_t)chunk, page, &report);
    if (report.status != AL_OK) *page = (al_translucent_page){0};
    return report.status;
}

static void read_grid(const al_file *file, const al_translucent_info *info, const uint16_t **density,
                      const uint8_t **blockers, al_report *report)
{
    const void *data;
    size_t size;
    uint64_t voxels = voxel_count(info);
    ptrdiff_t grid = al_file_find(file, "GRID", 0), plane = al_file_find(file, "BLOK", 0);
    assert(grid >= 0); /* the kind asks for it */
    if (al_report_data(report, file, (size_t)grid, &data, &size)) {
        if (size == 2 * voxels)
            *density = data;
        else
            al_report_finding(report, AL_RULE_TRANSLUCENT_GRID,
                              "GRID: has %zu bytes, %" PRIu64 " voxels need %" PRIu64, size, voxels,
                              2 * voxels);
    }
    if ((plane >= 0) != (info->has_blockers == 1)) {
        al_report_finding(report, AL_RULE_TRANSLUCENT_BLOCKERS, "BLOK is %s, has_blockers is %" PRIu32,
                          plane < 0 ? "missing" : "there", info->has_blockers);
    } else if (plane >= 0 && al_report_data(report, file, (size_t)plane, &data, &size)) {
        if (size == voxels)
            *blockers = data;
        else
            al_report_finding(report, AL_RULE_TRANSLUCENT_BLOCKERS,
                              "BLOK: has %zu bytes, there are %" PRIu64 " voxels", size, voxels);
    }
}

al_status al_translucent_read_grid(const al_file *file, const al_translucent_info *info,
                                   const uint16_t **density, const uint8_t **blockers, al_error *error)
{
    al_report report = {.name = al_file_name(file), .error = error};
    *density = NULL;
    *blockers = NULL;
    read_grid(file, info, density, blockers, &report);
    if (report.status != AL_OK) {
        *density = NULL;
        *blockers = NULL;
    }
    return report.status;
}

static void check_pages(const al_file *file, const al_translucent_info *info, al_report *report)
{
    uint32_t index = 0;
    al_translucent_page page;
    for (size_t i = 0; i < al_file_chunk_count(file); i++)
        if (al_chunk_is(file, i, "PAGE"))
            read_page(file, info, index++, i, &page, report);
}

static void check_translucent(const al_file *file, al_report *report)
{
    al_translucent_info info;
    const uint16_t *density = NULL;
    const uint8_t *blockers = NULL;
    if (!read_info(file, &info, report)) return;
    read_grid(file, &info, &density, &blockers, report);
    check_pages(file, &info, report);
}

static const al_chunk_rules chunks[] = {
    {"INFO", 1, 1, 1}, {"GRID", 1, 1, 1}, {"BLOK", 1, 0, 1}, {"PAGE", 1, 0, 0}, {"MEAS", 1, 0, 0}, {"PROV", 1, 0, 1}};

const al_kind_rules al_translucent_rules = {AL_KIND_TRANSLUCENT, "translucent", chunks,
                                            sizeof chunks / sizeof *chunks, check_translucent};

/* --- values --- */

void al_translucent_decode(const al_translucent_info *info, const al_translucent_page *page, uint32_t index,
                           uint32_t channel, float *coefficients)
{
    size_t set = (size_t)index * info->channel_count + channel, count = (size_t)info->order * info->order;
    assert(index < page->count && channel < info->channel_count);
    if (info->format == AL_COEFFICIENT_FLOAT) {
        memcpy(coefficients, (const float *)page->coefficients + set * count, count * sizeof *coefficients);
    } else if (info->format == AL_COEFFICIENT_HALF) {
        const uint16_t *halves = (const uint16_t *)page->coefficients + set * count;
        for (size_t i = 0; i < count; i++) coefficients[i] = al_half_to_float(halves[i]);
    } else {
        const int8_t *bytes = (const int8_t *)page->coefficients + set * count;
        for (size_t i = 0; i < count; i++) coefficients[i] = (float)bytes[i] / BYTE_STEPS * page->scales[set];
    }
}

/* A point that is asked, and the sums over the samples that reach it. */
typedef struct question {
    double position[3], basis[AL_SH_MAX_COUNT];
    double weighted[3], total; /* of gamma_i psi_i(w), of gamma_i */
    uint32_t used;
} question;

/* False: not finite, or no direction. */
static bool ask(const al_translucent_info *info, const float position[3], const float direction[3], question *q)
{
    double w[3] = {direction[0], direction[1], direction[2]}, length = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    *q = (question){.position = {position[0], position[1], position[2]}};
    if (!(length > 0) || !isfinite(length) || !isfinite(position[0] + position[1] + position[2])) return false;
    al_sh_basis((int)info->order, w[0] / length, w[1] / length, w[2] / length, q->basis);
    return true;
}

/* Adds the page's share. */
static void gather(const al_translucent_info *info, const al_translucent_page *page, question *q)
{
    float coefficients[AL_SH_MAX_COUNT];
    for (uint32_t i = 0; i < page->count; i++) {
        const float *b = page->positions + 3 * (size_t)i, *g = page->gaussians + 4 * (size_t)i;
        double square = 0;
        for (int k = 0; k < 3; k++) square += (q->position[k] - b[k]) * (q->position[k] - b[k]);
        double gamma = square <= (double)g[2] * g[2] ? g[1] * exp(-g[0] * square) : 0;
        if (gamma == 0) continue;
        q->total += gamma;
        q->used++;
        for (uint32_t c = 0; c < info->channel_count; c++) {
            double psi = 0;
            al_translucent_decode(info, page, i, c, coefficients);
            for (uint32_t k = 0; k < info->order * info->order; k++) psi += coefficients[k] * q->basis[k];
            q->weighted[c] += gamma * psi;
        }
    }
}

static void answer(const al_translucent_info *info, const question *q, float transmittance[3])
{
    for (int c = 0; c < 3; c++) {
        double psi = q->total > 0 ? q->weighted[info->channel_count == 3 ? c : 0] / q->total : 1;
        transmittance[c] = (float)fmin(fmax(psi, 0), 1);
    }
}

al_status al_translucent_evaluate(const al_file *file, const al_translucent_info *info,
                                  const float position[3], const float direction[3], float transmittance[3],
                                  uint32_t *samples_used, al_error *error)
{
    question q;
    al_translucent_page page;
    *samples_used = 0;
    for (int c = 0; c < 3; c++) transmittance[c] = 0;
    if (!ask(info, position, direction, &q))
        return al_fail(error, AL_USAGE,
                       "%s: position and direction must be finite, the direction longer than 0",
                       al_file_name(file));
    for (uint32_t p = 0; p < al_translucent_page_count(info); p++) {
        al_status status = al_translucent_read_page(file, info, p, &page, error);
        if (status != AL_OK) return status;
        gather(info, &page, &q);
    }
    answer(info, &q, transmittance);
    *samples_used = q.used;
    return AL_OK;
}

/* --- writing --- */

static void encode_half(const float *values, size_t count, uint8_t *out)
{
    for (size_t i = 0; i < count; i++) al_put_bytes(out + 2 * i, al_half_from_float(values[i]), 2);
}

/* One set: the largest magnitude becomes 127 steps, so the error is at most scale / 254. */
static float encode_bytes(const float *values, size_t count, uint8_t *out)
{
    float scale = 0;
    for (size_t i = 0; i < count; i++) scale = fmaxf(scale, fabsf(values[i]));
    for (size_t i = 0; i < count; i++)
        out[i] = scale > 0 ? (uint8_t)(int8_t)lrint((double)values[i] / scale * BYTE_STEPS) : 0;
    return scale;
}

static void encode_page(const al_translucent_data *data, const al_translucent_info *info, uint32_t first,
                        uint32_t count, uint8_t *out)
{
    page_layout l = layout_of(info, count);
    size_t set_size = (size_t)info->order * info->order, sets = (size_t)count * info->channel_count;
    const float *values = data->coefficients + (size_t)first * info->channel_count * set_size;
    memset(out, 0, l.size);
    memcpy(out, data->positions + 3 * (size_t)first, (size_t)count * 12);
    memcpy(out + l.gaussians, data->gaussians + 4 * (size_t)first, (size_t)count * 16);
    if (info->format == AL_COEFFICIENT_FLOAT) {
        memcpy(out + l.coefficients, values, sets * set_size * sizeof *values);
    } else if (info->format == AL_COEFFICIENT_HALF) {
        encode_half(values, sets * set_size, out + l.coefficients);
    } else {
        for (size_t s = 0; s < sets; s++) {
            float scale = encode_bytes(values + s * set_size, set_size, out + l.coefficients + s * set_size);
            memcpy(out + l.scales + 4 * s, &scale, 4);
        }
    }
}

al_status al_translucent_foretell(const al_translucent_data *data, uint32_t count, const float *positions,
                                  const float *directions, float *transmittances, al_error *error)
{
    al_translucent_info info = data->info;
    if (!info.page_size) info.page_size = DEFAULT_PAGE_SIZE;
    uint8_t *bytes = malloc(layout_of(&info, page_samples(&info, 0)).size + 1);
    question *questions = calloc((size_t)count + 1, sizeof *questions);
    al_status status = bytes && questions ? AL_OK : al_fail(error, AL_IO, "out of memory for a page");
    for (uint32_t i = 0; i < count && status == AL_OK; i++)
        if (!ask(&info, positions + 3 * (size_t)i, directions + 3 * (size_t)i, &questions[i]))
            status = al_fail(error, AL_USAGE, "point %" PRIu32 " is not finite or has no direction", i);
    for (uint32_t p = 0; p < al_translucent_page_count(&info) && status == AL_OK; p++) {
        encode_page(data, &info, p * info.page_size, page_samples(&info, p), bytes);
        al_translucent_page page = split_page(&info, p, bytes);
        for (uint32_t i = 0; i < count; i++) gather(&info, &page, &questions[i]);
    }
    for (uint32_t i = 0; i < count && status == AL_OK; i++)
        answer(&info, &questions[i], transmittances + 3 * (size_t)i);
    free(questions);
    free(bytes);
    return status;
}

static al_status check_data(const char *path, const al_translucent_data *data,
                            const al_translucent_info *info, al_error *error)
{
    al_report report = {.name = path, .error = error};
    uint8_t bytes[256];
    al_translucent_info decoded;
    assert(al_record_size(&info_record) <= sizeof bytes);
    al_record_encode(&info_record, info, 1, NULL, bytes);
    al_record_decode(&info_record, bytes, 1, "", 1, &decoded, &report);
    check_info(info, &report);
    size_t coefficients = (size_t)info->sample_count * info->channel_count * info->order * info->order;
    if (report.status == AL_OK && first_not_finite(data->coefficients, coefficients) < coefficients)
        al_report_finding(&report, AL_RULE_FINITE, "a coefficient is not finite");
    return report.status;
}

static al_status add_pages(al_writer *writer, const char *path, const al_translucent_data *data,
                           const al_translucent_info *info, al_error *error)
{
    uint8_t *page = malloc(layout_of(info, page_samples(info, 0)).size + 1);
    al_status status = page ? AL_OK : al_fail(error, AL_IO, "%s: out of memory for a page", path);
    for (uint32_t p = 0; status == AL_OK && p < al_translucent_page_count(info); p++) {
        uint32_t count = page_samples(info, p);
        encode_page(data, info, p * info->page_size, count, page);
        status = al_writer_add(writer, "PAGE", 1, 0, page, layout_of(info, count).size, error);
    }
    free(page);
    return status;
}

static al_status add_chunks(al_writer *writer, const char *path, const al_translucent_data *data,
                            const al_translucent_info *info, al_error *error)
{
    uint8_t bytes[256];
    const char *provenance = data->provenance_json;
    al_record_encode(&info_record, info, 1, NULL, bytes);
    al_status status = al_writer_add(writer, "INFO", 1, 0, bytes, al_record_size(&info_record), error);
    if (status == AL_OK)
        status = al_writer_add(writer, "GRID", 1, 0, data->density, 2 * voxel_count(info), error);
    if (status == AL_OK && info->has_blockers)
        status = al_writer_add(writer, "BLOK", 1, 0, data->blockers, voxel_count(info), error);
    if (status == AL_OK) status = add_pages(writer, path, data, info, error);
    if (status == AL_OK) status = al_measured_write(writer, data->measured, data->measured_count, error);
    if (status == AL_OK && provenance)
        status = al_writer_add(writer, "PROV", 1, AL_CHUNK_OPTIONAL, provenance, strlen(provenance), error);
    return status;
}

al_status al_translucent_write(const char *path, const al_translucent_data *data, uint64_t *bytes,
                               al_error *error)
{
    al_writer *writer;
    al_translucent_info info = data->info;
    if (bytes) *bytes = 0;
    if (!info.page_size) info.page_size = DEFAULT_PAGE_SIZE;
    info.has_blockers = data->blockers != NULL;
    al_status status = check_data(path, data, &info, error);
    if (status == AL_OK) status = al_writer_open(path, AL_KIND_TRANSLUCENT, &writer, error);
    if (status != AL_OK) return status;
    status = add_chunks(writer, path, data, &info, error);
    if (status == AL_OK) return al_writer_commit(writer, bytes, error);
    al_writer_discard(writer);
    return status;
}
