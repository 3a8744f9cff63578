#include "airlight/medium.h"

#include <assert.h>
#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "half.h"
#include "kinds.h"
#include "layout.h"
#include "medium_depth.h"
#include "medium_sky.h"
#include "record.h"

enum { EDGE_LIMIT = 65536, DEFAULT_PAGE_SIZE = 256, UNIT_HALF = 0x7800 /* 32768 */ };

#define COUNT_LIMIT (UINT32_MAX / 2)
#define G_LIMIT 0.99999994 /* |g| below 1: the float before it */
#define FIELD(member, type, count, minimum, maximum) \
    AL_FIELD(al_medium_info, member, type, count, minimum, maximum)

static const al_field info_fields[] = {
    FIELD(size, AL_FIELD_U32, 3, 1, EDGE_LIMIT),
    FIELD(page_size, AL_FIELD_U32, 1, 1, COUNT_LIMIT / AL_BRICK_SIZE),
    FIELD(frame_count, AL_FIELD_U32, 1, 1, COUNT_LIMIT),
    FIELD(extended, AL_FIELD_BOOL, 1, 0, 1),
    FIELD(grid_to_world, AL_FIELD_F32, 16, 1, 0),
    FIELD(bounds_min_m, AL_FIELD_F32, 3, 1, 0),
    FIELD(bounds_max_m, AL_FIELD_F32, 3, 1, 0),
    FIELD(sigma_s_per_m, AL_FIELD_F32, 3, 0, FLT_MAX),
    FIELD(sigma_a_per_m, AL_FIELD_F32, 3, 0, FLT_MAX),
    FIELD(g, AL_FIELD_F32, 1, -G_LIMIT, G_LIMIT),
};
static const al_record info_record = {"INFO", sizeof(al_medium_info), info_fields,
                                      sizeof info_fields / sizeof *info_fields};

typedef struct frame_record {
    float time_s, density_max;
    uint32_t brick_count;
} frame_record;

static const al_field frame_fields[] = {
    AL_FIELD(frame_record, time_s, AL_FIELD_F32, 1, 1, 0),
    AL_FIELD(frame_record, density_max, AL_FIELD_F32, 1, 0, FLT_MAX),
    AL_FIELD(frame_record, brick_count, AL_FIELD_U32, 1, 0, COUNT_LIMIT),
};
static const al_record frame_record_type = {"FRAM", sizeof(frame_record), frame_fields,
                                            sizeof frame_fields / sizeof *frame_fields};
enum { FRAME_SIZE = 12 };

/* --- sizes --- */

void al_medium_cells(const al_medium_info *info, uint32_t cells[3])
{
    for (int k = 0; k < 3; k++) {
        uint32_t spans = info->size[k] - 1;
        cells[k] = spans ? (spans + AL_BRICK_CELLS - 1) / AL_BRICK_CELLS : 1;
    }
}

static uint64_t cell_count(const al_medium_info *info)
{
    uint32_t cells[3];
    al_medium_cells(info, cells);
    return (uint64_t)cells[0] * cells[1] * cells[2];
}

static uint32_t pages_of(const al_medium_info *info, uint32_t brick_count)
{
    return (uint32_t)(((uint64_t)brick_count + info->page_size - 1) / info->page_size);
}

uint32_t al_medium_page_count(const al_medium_info *info, const al_medium_frame *frame)
{
    return pages_of(info, frame->brick_count);
}

static uint32_t page_bricks(const al_medium_info *info, uint32_t brick_count, uint32_t page)
{
    uint32_t rest = brick_count - page * info->page_size;
    return rest < info->page_size ? rest : info->page_size;
}

/* --- checking and reading --- */

static double determinant(const float m[16])
{
    return m[0] * ((double)m[5] * m[10] - (double)m[9] * m[6]) -
           m[4] * ((double)m[1] * m[10] - (double)m[9] * m[2]) +
           m[8] * ((double)m[1] * m[6] - (double)m[5] * m[2]);
}

static void check_info(const al_medium_info *info, al_report *report)
{
    const float *m = info->grid_to_world;
    double size = determinant(m);
    if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1 || size == 0 || !isfinite(size))
        al_report_finding(report, AL_RULE_MEDIUM_TRANSFORM,
                          "INFO: grid_to_world has the determinant %g and the last row %g %g %g %g", size,
                          (double)m[3], (double)m[7], (double)m[11], (double)m[15]);
    for (int i = 0; i < 3; i++)
        if (!(info->bounds_min_m[i] < info->bounds_max_m[i]))
            al_report_finding(report, AL_RULE_MEDIUM_BOUNDS,
                              "INFO: bounds_min_m[%d] is %g, not below bounds_max_m[%d], %g", i,
                              (double)info->bounds_min_m[i], i, (double)info->bounds_max_m[i]);
}

/* The bytes of a chunk of records that the kind asks for once; NULL after a finding. */
static const uint8_t *read_records(const al_file *file, const al_record *record, uint64_t count,
                                   al_report *report)
{
    const void *data;
    size_t size;
    ptrdiff_t index = al_file_find(file, record->type, 0);
    assert(index >= 0);
    if (!al_report_data(report, file, (size_t)index, &data, &size)) return NULL;
    if (size == count * al_record_size(record)) return data;
    al_report_finding(report, AL_RULE_RECORD_SIZE, "%s: has %zu bytes, should have %" PRIu64, record->type,
                      size, count * al_record_size(record));
    return NULL;
}

static frame_record decode_frame(const uint8_t *records, uint32_t index)
{
    frame_record frame;
    al_report unused = {.name = ""}; /* read_info has reported already */
    al_record_decode(&frame_record_type, records + (size_t)FRAME_SIZE * index, 1, "", 1, &frame, &unused);
    return frame;
}

static uint32_t count_chunks(const al_file *file, const char type[5])
{
    uint32_t count = 0;
    for (size_t i = 0; i < al_file_chunk_count(file); i++) count += al_chunk_is(file, i, type);
    return count;
}

/* Records of all frames, their order, and that their chunks are there. */
static void check_frames(const al_file *file, const al_medium_info *info, const uint8_t *records,
                         al_report *report)
{
    uint64_t pages = 0;
    float before = -FLT_MAX;
    for (uint32_t i = 0; i < info->frame_count; i++) {
        frame_record frame;
        al_record_decode(&frame_record_type, records + (size_t)FRAME_SIZE * i, 1, "", 1, &frame, report);
        if (i && !(frame.time_s > before))
            al_report_finding(report, AL_RULE_MEDIUM_TIMES,
                              "FRAM: frame %" PRIu32 " is at %g s, the one before at %g s", i,
                              (double)frame.time_s, (double)before);
        before = frame.time_s;
        pages += pages_of(info, frame.brick_count);
    }
    if (count_chunks(file, "INDX") != info->frame_count)
        al_report_finding(report, AL_RULE_MEDIUM_INDICES,
                          "there are %" PRIu32 " INDX chunks for %" PRIu32 " frames",
                          count_chunks(file, "INDX"), info->frame_count);
    if (count_chunks(file, "PAGE") != pages)
        al_report_finding(report, AL_RULE_MEDIUM_PAGES,
                          "the bricks of all frames fill %" PRIu64 " pages, there are %" PRIu32, pages,
                          count_chunks(file, "PAGE"));
}

/* True when sizes and numbers of chunks can be relied on; *records are those of FRAM. */
static bool read_info(const al_file *file, al_medium_info *info, const uint8_t **records, al_report *report)
{
    uint64_t before = report->count;
    *info = (al_medium_info){0};
    const uint8_t *bytes = read_records(file, &info_record, 1, report);
    if (!bytes) return false;
    al_record_decode(&info_record, bytes, 1, "", 1, info, report);
    check_info(info, report);
    if (report->count != before) return false;
    *records = read_records(file, &frame_record_type, info->frame_count, report);
    if (*records) check_frames(file, info, *records, report);
    return report->count == before;
}

al_status al_medium_read(const al_file *file, al_medium_info *info, al_error *error)
{
    const uint8_t *records;
    *info = (al_medium_info){0};
    if (al_file_kind(file) != AL_KIND_MEDIUM)
        return al_fail(error, AL_BAD_INPUT, "%s: is an asset of kind %s, wanted is medium",
                       al_file_name(file), al_kind_name(al_file_kind(file)));
    al_report report = {.name = al_file_name(file), .error = error};
    if (!read_info(file, info, &records, &report)) *info = (al_medium_info){0};
    return report.status;
}

/* Bricks are numbered in the order of their cells. */
static void check_numbers(const al_medium_frame *frame, uint64_t cells, uint32_t index, al_report *report)
{
    uint32_t next = 0;
    for (uint64_t i = 0; i < cells; i++) {
        if (frame->bricks[i] == AL_NO_BRICK) continue;
        if (frame->bricks[i] != next) {
            al_report_finding(report, AL_RULE_MEDIUM_NUMBERS,
                              "frame %" PRIu32 ": cell %" PRIu64 " names brick %" PRIu32 ", next is %" PRIu32,
                              index, i, frame->bricks[i], next);
            return;
        }
        next++;
    }
    if (next != frame->brick_count)
        al_report_finding(report, AL_RULE_MEDIUM_NUMBERS,
                          "frame %" PRIu32 ": its cells name %" PRIu32 " bricks, it has %" PRIu32, index,
                          next, frame->brick_count);
}

static void read_frame(const al_file *file, const al_medium_info *info, const uint8_t *records,
                       uint32_t index, al_medium_frame *frame, al_report *report)
{
    const void *data;
    size_t size;
    uint64_t cells = cell_count(info);
    frame_record record = decode_frame(records, index);
    *frame = (al_medium_frame){record.time_s, record.density_max, record.brick_count, NULL};
    ptrdiff_t chunk = al_file_find(file, "INDX", index);
    assert(chunk >= 0); /* read_info has counted them */
    if (!al_report_data(report, file, (size_t)chunk, &data, &size)) return;
    if (size != 4 * cells) {
        al_report_finding(report, AL_RULE_MEDIUM_INDEX_SIZE,
                          "frame %" PRIu32 ": INDX has %zu bytes, %" PRIu64 " cells need %" PRIu64, index,
                          size, cells, 4 * cells);
        return;
    }
    frame->bricks = data;
    check_numbers(frame, cells, index, report);
}

al_status al_medium_read_frame(const al_file *file, const al_medium_info *info, uint32_t index,
                               al_medium_frame *frame, al_error *error)
{
    al_report report = {.name = al_file_name(file), .error = error};
    assert(index < info->frame_count);
    *frame = (al_medium_frame){0};
    const uint8_t *records = read_records(file, &frame_record_type, info->frame_count, &report);
    if (records) read_frame(file, info, records, index, frame, &report);
    if (report.status != AL_OK) *frame = (al_medium_frame){0};
    return report.status;
}

al_status al_medium_read_times(const al_file *file, const al_medium_info *info, float *times_s,
                               uint32_t *brick_counts, al_error *error)
{
    al_report report = {.name = al_file_name(file), .error = error};
    const uint8_t *records = read_records(file, &frame_record_type, info->frame_count, &report);
    for (uint32_t i = 0; records && i < info->frame_count; i++) {
        frame_record frame = decode_frame(records, i);
        times_s[i] = frame.time_s;
        brick_counts[i] = frame.brick_count;
    }
    return report.status;
}

/* `chunk` is the PAGE; `index` and `number` are for messages. */
static void read_page(const al_file *file, size_t chunk, uint32_t index, uint32_t number,
                      al_medium_page *page, al_report *report)
{
    const void *data;
    size_t size, wanted = (size_t)page->count * AL_BRICK_SIZE;
    if (!al_report_data(report, file, chunk, &data, &size)) return;
    if (size != 2 * wanted) {
        al_report_finding(report, AL_RULE_MEDIUM_PAGE_SIZE,
                          "frame %" PRIu32 ", page %" PRIu32 ": has %zu bytes, %" PRIu32 " bricks need %zu",
                          index, number, size, page->count, 2 * wanted);
        return;
    }
    page->values = data;
    for (size_t i = 0; i < wanted; i++)
        if (page->values[i] > UNIT_HALF) {
            al_report_finding(report, AL_RULE_MEDIUM_VALUE,
                              "frame %" PRIu32 ", page %" PRIu32 ": value %zu is the half %04x, above 7800",
                              index, number, i, page->values[i]);
            return;
        }
}

al_status al_medium_read_page(const al_file *file, const al_medium_info *info, uint32_t index, uint32_t page,
                              al_medium_page *out, al_error *error)
{
    al_report report = {.name = al_file_name(file), .error = error};
    *out = (al_medium_page){0};
    const uint8_t *records = read_records(file, &frame_record_type, info->frame_count, &report);
    if (!records) return report.status;
    size_t number = page;
    for (uint32_t i = 0; i < index; i++) number += pages_of(info, decode_frame(records, i).brick_count);
    uint32_t bricks = decode_frame(records, index).brick_count;
    assert(page < pages_of(info, bricks));
    *out = (al_medium_page){page * info->page_size, page_bricks(info, bricks, page), NULL};
    read_page(file, (size_t)al_file_find(file, "PAGE", number), index, page, out, &report);
    if (report.status != AL_OK) *out = (al_medium_page){0};
    return report.status;
}

/* Hands every page of the file, in order, to `take` (which may be NULL). */
static void read_pages(const al_file *file, const al_medium_info *info, const uint8_t *records,
                       void (*take)(void *user, uint32_t frame, const al_medium_page *page), void *user,
                       al_report *report)
{
    uint32_t frame = 0, number = 0;
    for (size_t i = 0; i < al_file_chunk_count(file); i++) {
        if (!al_chunk_is(file, i, "PAGE")) continue;
        uint32_t bricks = decode_frame(records, frame).brick_count;
        while (number == pages_of(info, bricks)) {
            bricks = decode_frame(records, ++frame).brick_count;
            number = 0;
        }
        al_medium_page page = {number * info->page_size, page_bricks(info, bricks, number), NULL};
        read_page(file, i, frame, number, &page, report);
        if (take && page.values) take(user, frame, &page);
        number++;
    }
}

static void check_medium(const al_file *file, al_report *report)
{
    al_medium_info info;
    al_medium_frame frame;
    const uint8_t *records;
    if (!read_info(file, &info, &records, report)) return;
    for (uint32_t i = 0; i < info.frame_count; i++) read_frame(file, &info, records, i, &frame, report);
    read_pages(file, &info, records, NULL, NULL, report);
    al_medium_sky_check(file, report);
    al_medium_depth_check(file, &info, report);
}

static const al_chunk_rules chunks[] = {
    {"INFO", 1, 1, 1}, {"FRAM", 1, 1, 1}, {"INDX", 1, 1, 0}, {"PAGE", 1, 0, 0},
    {"SKYI", 1, 0, 1}, {"SKYL", 1, 0, 1}, {"SKYC", 1, 0, 1}, {"DEPI", 1, 0, 1}, {"DEPL", 1, 0, 0}, {"MEAS", 1, 0, 0}, {"PROV", 1, 0, 1}};

const al_kind_rules al_medium_rules = {AL_KIND_MEDIUM, "medium", chunks, sizeof chunks / sizeof *chunks,
                                       check_medium};

/* --- values --- */

typedef struct field_frame {
    al_medium_frame frame;
    const uint16_t **pages;
} field_frame;

struct al_medium_field {
    al_medium_info info;
    uint32_t cells[3];
    double to_grid[12]; /* rows of the inverse of grid_to_world */
    field_frame *frames;
};

static void keep_page(void *user, uint32_t frame, const al_medium_page *page)
{
    al_medium_field *field = user;
    field->frames[frame].pages[page->first / field->info.page_size] = page->values;
}

/* Cramer's rule; the determinant has been checked. */
static void invert(const float m[16], double rows[12])
{
    double scale = 1 / determinant(m);
    for (int r = 0; r < 3; r++) {
        int a = (r + 1) % 3, b = (r + 2) % 3;
        for (int c = 0; c < 3; c++) {
            int i = (c + 1) % 3, j = (c + 2) % 3;
            rows[4 * r + c] =
                ((double)m[4 * a + i] * m[4 * b + j] - (double)m[4 * a + j] * m[4 * b + i]) * scale;
        }
        rows[4 * r + 3] = -(rows[4 * r] * m[12] + rows[4 * r + 1] * m[13] + rows[4 * r + 2] * m[14]);
    }
}

al_status al_medium_field_open(const al_file *file, const al_medium_info *info, al_medium_field **field,
                               al_error *error)
{
    al_report report = {.name = al_file_name(file), .error = error};
    al_medium_field *made = calloc(1, sizeof *made);
    const uint8_t *records = read_records(file, &frame_record_type, info->frame_count, &report);
    *field = NULL;
    if (made) made->frames = calloc(info->frame_count, sizeof *made->frames);
    if (!made || !made->frames) {
        al_report_out_of_memory(&report);
    } else if (records) {
        made->info = *info;
        al_medium_cells(info, made->cells);
        invert(info->grid_to_world, made->to_grid);
        for (uint32_t i = 0; i < info->frame_count; i++) {
            read_frame(file, info, records, i, &made->frames[i].frame, &report);
            made->frames[i].pages =
                calloc(pages_of(info, made->frames[i].frame.brick_count) + 1u, sizeof *made->frames[i].pages);
            if (!made->frames[i].pages) al_report_out_of_memory(&report);
            if (report.status != AL_OK) break;
        }
        if (report.status == AL_OK) read_pages(file, info, records, keep_page, made, &report);
    }
    if (report.status == AL_OK)
        *field = made;
    else
        al_medium_field_close(made);
    return report.status;
}

void al_medium_field_close(al_medium_field *field)
{
    if (!field) return;
    for (uint32_t i = 0; field->frames && i < field->info.frame_count; i++) free(field->frames[i].pages);
    free(field->frames);
    free(field);
}

/* Trilinear in the brick of the cell that `index` (clamped to the voxel centres) falls into. */
static double frame_at(const al_medium_field *field, const field_frame *f, const double index[3])
{
    uint32_t cell[3];
    double share[3];
    size_t at = 0, cell_index = 0;
    static const size_t step[3] = {1, AL_BRICK_EDGE, AL_BRICK_EDGE * AL_BRICK_EDGE};
    for (int k = 2; k >= 0; k--) {
        double x = fmin(fmax(index[k], 0), field->info.size[k] - 1.0);
        cell[k] = (uint32_t)(x / AL_BRICK_CELLS);
        if (cell[k] >= field->cells[k]) cell[k] = field->cells[k] - 1;
        double local = x - (double)cell[k] * AL_BRICK_CELLS;
        uint32_t first = local < AL_BRICK_CELLS ? (uint32_t)local : AL_BRICK_CELLS - 1;
        share[k] = local - first;
        at += first * step[k];
        cell_index = cell_index * field->cells[k] + cell[k];
    }
    uint32_t number = f->frame.bricks[cell_index];
    if (number == AL_NO_BRICK) return 0;
    const uint16_t *v = f->pages[number / field->info.page_size] +
                        (size_t)(number % field->info.page_size) * AL_BRICK_SIZE + at;
    double sum = 0;
    for (int corner = 0; corner < 8; corner++) {
        double weight = 1;
        size_t offset = 0;
        for (int k = 0; k < 3; k++) {
            bool upper = corner >> k & 1;
            weight *= upper ? share[k] : 1 - share[k];
            offset += upper ? step[k] : 0;
        }
        sum += weight * al_half_to_float(v[offset]);
    }
    return sum * f->frame.density_max / AL_MEDIUM_UNIT;
}

double al_medium_evaluate(const al_medium_field *field, const double position[3], double time_s)
{
    const al_medium_info *info = &field->info;
    double index[3];
    for (int k = 0; k < 3; k++) {
        const double *row = field->to_grid + 4 * k;
        if (!(position[k] >= info->bounds_min_m[k] && position[k] <= info->bounds_max_m[k])) return 0;
        index[k] = row[0] * position[0] + row[1] * position[1] + row[2] * position[2] + row[3];
    }
    for (int k = 0; k < 3 && !info->extended; k++) /* rounding must not lose the voxels' own faces */
        if (fabs(index[k] - 0.5 * (info->size[k] - 1.0)) > 0.5 * info->size[k] * (1 + 1e-6)) return 0;
    uint32_t next = 0;
    while (next < info->frame_count && field->frames[next].frame.time_s <= time_s) next++;
    if (!next) return frame_at(field, &field->frames[0], index);
    const field_frame *before = &field->frames[next - 1];
    if (next == info->frame_count) return frame_at(field, before, index);
    const field_frame *after = &field->frames[next];
    double share = (time_s - before->frame.time_s) / ((double)after->frame.time_s - before->frame.time_s);
    return (1 - share) * frame_at(field, before, index) + share * frame_at(field, after, index);
}

/* --- writing --- */

typedef struct encoder {
    const char *path;
    const al_medium_data *data;
    al_medium_info info;
    uint32_t cells[3];
    frame_record *frames;
    float *slices;    /* nine, [z][y][x] */
    uint32_t *bricks; /* index of the frame */
    uint16_t *page;
    uint32_t in_page;
} encoder;

static al_status take_slice(const encoder *e, uint32_t frame, uint32_t z, float *slice, float *largest,
                            al_error *error)
{
    size_t count = (size_t)e->info.size[0] * e->info.size[1];
    al_status status = e->data->slice(e->data->user, frame, z, slice, error);
    for (size_t i = 0; i < count && status == AL_OK; i++) {
        if (!(slice[i] >= 0) || !isfinite(slice[i]))
            return al_fail(error, AL_BAD_INPUT,
                           "%s: frame %" PRIu32 ": density %zu of slice %" PRIu32
                           " is %g; finite and 0 or more is right",
                           e->path, frame, i, z, (double)slice[i]);
        *largest = fmaxf(*largest, slice[i]);
    }
    return status;
}

/* Copies the brick at cell (x, y) of the slices in memory; false when it is 0 everywhere. Beyond the last
 * voxel the last one is repeated, so that it counts for nothing. */
static bool encode_brick(const encoder *e, uint32_t x, uint32_t y, uint32_t layers, float maximum,
                         uint16_t *out)
{
    bool any = false;
    for (uint32_t k = 0; k < AL_BRICK_EDGE; k++)
        for (uint32_t j = 0; j < AL_BRICK_EDGE; j++)
            for (uint32_t i = 0; i < AL_BRICK_EDGE; i++) {
                uint32_t vx = x * AL_BRICK_CELLS + i, vy = y * AL_BRICK_CELLS + j;
                vx = vx < e->info.size[0] ? vx : e->info.size[0] - 1;
                vy = vy < e->info.size[1] ? vy : e->info.size[1] - 1;
                size_t at =
                    ((size_t)(k < layers ? k : layers - 1) * e->info.size[1] + vy) * e->info.size[0] + vx;
                float share = maximum > 0 ? fabsf(e->slices[at]) / maximum : 0; /* no negative zero */
                *out = al_half_from_float(share * AL_MEDIUM_UNIT);
                any = *out++ || any;
            }
    return any;
}

static al_status flush_page(encoder *e, al_writer *writer, al_error *error)
{
    size_t size = (size_t)e->in_page * AL_BRICK_SIZE * sizeof *e->page;
    e->in_page = 0;
    return size ? al_writer_add(writer, "PAGE", 1, 0, e->page, size, error) : AL_OK;
}

static al_status encode_row(encoder *e, al_writer *writer, frame_record *frame, uint32_t z, uint32_t layers,
                            al_error *error)
{
    uint32_t *row = e->bricks + (size_t)z * e->cells[0] * e->cells[1];
    for (uint32_t y = 0; y < e->cells[1]; y++)
        for (uint32_t x = 0; x < e->cells[0]; x++, row++) {
            *row = AL_NO_BRICK;
            uint16_t *brick = e->page + (size_t)e->in_page * AL_BRICK_SIZE;
            if (!encode_brick(e, x, y, layers, frame->density_max, brick)) continue;
            *row = frame->brick_count++;
            al_status status = ++e->in_page == e->info.page_size ? flush_page(e, writer, error) : AL_OK;
            if (status != AL_OK) return status;
        }
    return AL_OK;
}

static al_status encode_frame(encoder *e, al_writer *writer, uint32_t index, al_error *error)
{
    frame_record *frame = &e->frames[index];
    size_t slice = (size_t)e->info.size[0] * e->info.size[1];
    float unused = 0;
    al_status status = AL_OK;
    *frame = (frame_record){.time_s = e->data->times_s ? e->data->times_s[index] : 0};
    for (uint32_t z = 0; z < e->info.size[2] && status == AL_OK; z++)
        status = take_slice(e, index, z, e->slices, &frame->density_max, error);
    uint32_t have = 0; /* slices in memory, the first one at the row's start */
    for (uint32_t row = 0; row < e->cells[2] && status == AL_OK; row++) {
        uint32_t first = row * AL_BRICK_CELLS;
        if (row) { /* the layer both rows share */
            memmove(e->slices, e->slices + AL_BRICK_CELLS * slice, slice * sizeof *e->slices);
            have = 1;
        }
        for (; have < AL_BRICK_EDGE && first + have < e->info.size[2] && status == AL_OK; have++)
            status = take_slice(e, index, first + have, e->slices + have * slice, &unused, error);
        if (status == AL_OK) status = encode_row(e, writer, frame, row, have, error);
    }
    if (status == AL_OK) status = flush_page(e, writer, error);
    if (status == AL_OK)
        status =
            al_writer_add(writer, "INDX", 1, 0, e->bricks, cell_count(&e->info) * sizeof *e->bricks, error);
    return status;
}

static al_status add_depths(const encoder *e, al_writer *writer, al_error *error)
{
    float *densities_max = malloc(e->info.frame_count * sizeof *densities_max);
    if (!densities_max) return al_fail(error, AL_IO, "%s: out of memory for its frames", e->path);
    for (uint32_t i = 0; i < e->info.frame_count; i++) densities_max[i] = e->frames[i].density_max;
    al_status status = al_medium_depth_write(writer, e->path, e->data, densities_max, error);
    free(densities_max);
    return status;
}

static al_status add_chunks(encoder *e, al_writer *writer, al_error *error)
{
    uint8_t bytes[256];
    const char *provenance = e->data->provenance_json;
    al_status status = AL_OK;
    al_record_encode(&info_record, &e->info, 1, NULL, bytes);
    status = al_writer_add(writer, "INFO", 1, 0, bytes, al_record_size(&info_record), error);
    for (uint32_t i = 0; i < e->info.frame_count && status == AL_OK; i++)
        status = encode_frame(e, writer, i, error);
    if (status != AL_OK) return status;
    uint8_t *records = malloc((size_t)FRAME_SIZE * e->info.frame_count);
    if (!records) return al_fail(error, AL_IO, "%s: out of memory for its frames", e->path);
    al_record_encode(&frame_record_type, e->frames, e->info.frame_count, NULL, records);
    status = al_writer_add(writer, "FRAM", 1, 0, records, (size_t)FRAME_SIZE * e->info.frame_count, error);
    free(records);
    if (status == AL_OK && e->data->sky)
        status = al_medium_sky_write(writer, e->path, e->data->sky, e->data->sky_values, error);
    if (status == AL_OK && e->data->depth) status = add_depths(e, writer, error);
    if (status == AL_OK)
        status = al_measured_write(writer, e->data->measured, e->data->measured_count, error);
    if (status == AL_OK && provenance)
        status = al_writer_add(writer, "PROV", 1, AL_CHUNK_OPTIONAL, provenance, strlen(provenance), error);
    return status;
}

static al_status check_data(const encoder *e, al_error *error)
{
    al_report report = {.name = e->path, .error = error};
    uint8_t bytes[256];
    al_medium_info decoded;
    assert(al_record_size(&info_record) <= sizeof bytes && al_record_size(&frame_record_type) == FRAME_SIZE);
    al_record_encode(&info_record, &e->info, 1, NULL, bytes);
    al_record_decode(&info_record, bytes, 1, "", 1, &decoded, &report);
    if (report.status == AL_OK) check_info(&e->info, &report);
    return report.status;
}

al_status al_medium_write(const char *path, const al_medium_data *data, uint64_t *bytes, al_error *error)
{
    al_writer *writer = NULL;
    encoder e = {.path = path, .data = data, .info = data->info};
    if (bytes) *bytes = 0;
    if (!e.info.page_size) e.info.page_size = DEFAULT_PAGE_SIZE;
    al_status status = check_data(&e, error);
    if (status != AL_OK) return status;
    al_medium_cells(&e.info, e.cells);
    e.frames = calloc(e.info.frame_count, sizeof *e.frames);
    e.slices = malloc((size_t)e.info.size[0] * e.info.size[1] * AL_BRICK_EDGE * sizeof *e.slices);
    e.bricks = malloc(cell_count(&e.info) * sizeof *e.bricks);
    e.page = malloc((size_t)e.info.page_size * AL_BRICK_SIZE * sizeof *e.page);
    if (!e.frames || !e.slices || !e.bricks || !e.page)
        status = al_fail(error, AL_IO, "%s: out of memory for its bricks", path);
    if (status == AL_OK) status = al_writer_open(path, AL_KIND_MEDIUM, &writer, error);
    if (status == AL_OK) status = add_chunks(&e, writer, error);
    if (status == AL_OK)
        status = al_writer_commit(writer, bytes, error);
    else
        al_writer_discard(writer);
    free(e.frames);
    free(e.slices);
    free(e.bricks);
    free(e.page);
    return status;
}
