#include "airlight/lightmap.h"

#include <assert.h>
#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "half.h"
#include "kinds.h"
#include "layout.h"
#include "record.h"

enum { PAGE_EDGE_LIMIT = 16384, VERTEX_FLOATS = 5 };

#define COUNT_LIMIT (UINT32_MAX / 2)
#define SCALE_LIMIT 0x1p111 /* times the largest half is finite */
#define FIELD(record, member, type, count, minimum, maximum) \
    AL_FIELD(record, member, type, count, minimum, maximum)

static const al_field info_fields[] = {
    FIELD(al_lightmap_info, page_count, AL_FIELD_U32, 1, 0, COUNT_LIMIT),
    FIELD(al_lightmap_info, instance_count, AL_FIELD_U32, 1, 0, COUNT_LIMIT),
    FIELD(al_lightmap_info, format, AL_FIELD_U32, 1, AL_LIGHTMAP_FLOAT, AL_LIGHTMAP_HALF),
    FIELD(al_lightmap_info, directional_order, AL_FIELD_U32, 1, 0, AL_LIGHTMAP_MAX_ORDER),
    FIELD(al_lightmap_info, vertex_count, AL_FIELD_U32, 1, 0, COUNT_LIMIT),
    FIELD(al_lightmap_info, triangle_count, AL_FIELD_U32, 1, 0, COUNT_LIMIT),
    FIELD(al_lightmap_info, texel_m, AL_FIELD_F32, 1, FLT_TRUE_MIN, FLT_MAX),
};

static const al_field instance_fields[] = {
    FIELD(al_lightmap_instance, instance, AL_FIELD_U32, 1, 0, COUNT_LIMIT),
    FIELD(al_lightmap_instance, page, AL_FIELD_U32, 1, 0, COUNT_LIMIT),
    FIELD(al_lightmap_instance, scale, AL_FIELD_F32, 2, 0, 1),
    FIELD(al_lightmap_instance, offset, AL_FIELD_F32, 2, 0, 1),
    FIELD(al_lightmap_instance, first_triangle, AL_FIELD_U32, 1, 0, COUNT_LIMIT),
    FIELD(al_lightmap_instance, triangle_count, AL_FIELD_U32, 1, 0, COUNT_LIMIT),
};

/* What chunk PAGS says of a page. */
typedef struct page_head {
    uint32_t width, height;
    float scale[AL_LAYER_COUNT], sh_scale[AL_LAYER_COUNT];
} page_head;

static const al_field page_fields[] = {
    FIELD(page_head, width, AL_FIELD_U32, 1, 1, PAGE_EDGE_LIMIT),
    FIELD(page_head, height, AL_FIELD_U32, 1, 1, PAGE_EDGE_LIMIT),
    FIELD(page_head, scale, AL_FIELD_F32, AL_LAYER_COUNT, FLT_TRUE_MIN, SCALE_LIMIT),
    FIELD(page_head, sh_scale, AL_FIELD_F32, AL_LAYER_COUNT, FLT_TRUE_MIN, SCALE_LIMIT),
};

#define RECORD(type, struct_type, fields) \
    { \
        type, sizeof(struct_type), fields, sizeof fields / sizeof *fields \
    }
static const al_record info_record = RECORD("INFO", al_lightmap_info, info_fields);
static const al_record instance_record = RECORD("INST", al_lightmap_instance, instance_fields);
static const al_record page_record = RECORD("PAGS", page_head, page_fields);

/* --- sizes --- */

static uint64_t number_size(const al_lightmap_info *info)
{
    return info->format == AL_LIGHTMAP_FLOAT ? 4 : 2;
}

/* Byte offsets of a page's arrays, each a multiple of 64, and the size of the chunk: at most 2^28 texels x
 * (3 x 17 x 3 x 4 + 1) bytes. */
typedef struct page_layout {
    uint64_t irradiance_size, sh_size; /* of one layer */
    uint64_t irradiance[AL_LAYER_COUNT], sh[AL_LAYER_COUNT], state, size;
} page_layout;

static page_layout layout_of(const al_lightmap_info *info, uint32_t width, uint32_t height)
{
    uint64_t texels = (uint64_t)width * height, at = 0;
    page_layout l = {.irradiance_size = 3 * texels * number_size(info)};
    l.sh_size = l.irradiance_size * info->directional_order * info->directional_order;
    for (int layer = 0; layer < AL_LAYER_COUNT; layer++, at += al_padded(l.irradiance_size))
        l.irradiance[layer] = at;
    for (int layer = 0; layer < AL_LAYER_COUNT; layer++, at += al_padded(l.sh_size)) l.sh[layer] = at;
    l.state = at;
    l.size = at + texels;
    return l;
}

/* --- checking and reading --- */

/* The bytes of the one chunk of records; read_info has checked the size of all but its own. */
static const uint8_t *read_records(const al_file *file, const al_record *record, al_report *report)
{
    const void *data;
    size_t size;
    ptrdiff_t index = al_file_find(file, record->type, 0);
    assert(index >= 0); /* the kind asks for it */
    if (!al_report_data(report, file, (size_t)index, &data, &size)) return NULL;
    return size ? data : (const uint8_t *)"";
}

static void check_page_count(const al_file *file, const al_lightmap_info *info, al_report *report)
{
    uint32_t found = 0;
    for (size_t i = 0; i < al_file_chunk_count(file); i++) found += al_chunk_is(file, i, "PAGE");
    if (found != info->page_count)
        al_report_finding(report, AL_RULE_LIGHTMAP_PAGES,
                          "INFO: page_count is %" PRIu32 ", there are %" PRIu32 " PAGE chunks",
                          info->page_count, found);
}

static void check_records(const al_file *file, const al_record *record, uint32_t count, al_report *report)
{
    const al_chunk *chunk = al_file_chunk(file, (size_t)al_file_find(file, record->type, 0));
    uint64_t wanted = (uint64_t)al_record_size(record) * count;
    if (chunk->size != wanted)
        al_report_finding(report, AL_RULE_RECORD_SIZE, "%s: has %" PRIu64 " bytes, should have %" PRIu64,
                          record->type, chunk->size, wanted);
}

/* True when the counts can be relied on. */
static bool read_info(const al_file *file, al_lightmap_info *info, al_report *report)
{
    *info = (al_lightmap_info){0};
    uint64_t before = report->count;
    check_records(file, &info_record, 1, report);
    const uint8_t *bytes = report->count == before ? read_records(file, &info_record, report) : NULL;
    if (!bytes) return false;
    al_record_decode(&info_record, bytes, 1, "", 1, info, report);
    if (report->count != before) return false;
    check_page_count(file, info, report);
    check_records(file, &instance_record, info->instance_count, report);
    check_records(file, &page_record, info->page_count, report);
    return report->count == before;
}

al_status al_lightmap_read(const al_file *file, al_lightmap_info *info, al_error *error)
{
    *info = (al_lightmap_info){0};
    if (al_file_kind(file) != AL_KIND_LIGHTMAP)
        return al_fail(error, AL_BAD_INPUT, "%s: is an asset of kind %s, wanted is lightmap",
                       al_file_name(file), al_kind_name(al_file_kind(file)));
    al_report report = {.name = al_file_name(file), .error = error};
    if (!read_info(file, info, &report)) *info = (al_lightmap_info){0};
    return report.status;
}

static void check_instance(const al_lightmap_info *info, const al_lightmap_instance *i, uint32_t index,
                           al_report *report)
{
    if (i->page >= info->page_count)
        al_report_finding(report, AL_RULE_LIGHTMAP_INDEX,
                          "INST[%" PRIu32 "]: page is %" PRIu32 ", there are %" PRIu32, index, i->page,
                          info->page_count);
    for (int k = 0; k < 2; k++)
        if ((double)i->scale[k] + i->offset[k] > 1 + (double)FLT_EPSILON)
            al_report_finding(report, AL_RULE_LIGHTMAP_RECTANGLE, "INST[%" PRIu32 "]: reaches from %g to %g",
                              index, (double)i->offset[k], (double)i->offset[k] + i->scale[k]);
}

static void check_instances(const al_lightmap_info *info, const al_lightmap_instance *instances,
                            al_report *report)
{
    uint64_t next = 0;
    bool ordered = true;
    for (uint32_t i = 0; i < info->instance_count; i++) {
        check_instance(info, &instances[i], i, report);
        ordered = ordered && instances[i].first_triangle == next &&
                  (i == 0 || instances[i].instance > instances[i - 1].instance);
        next += instances[i].triangle_count;
    }
    if (!ordered || next != info->triangle_count)
        al_report_finding(report, AL_RULE_LIGHTMAP_ORDER,
                          "INST: instances do not ascend, or do not share %" PRIu32
                          " triangles out one after the other",
                          info->triangle_count);
}

static void read_instances(const al_file *file, const al_lightmap_info *info, al_lightmap_instance *instances,
                           al_report *report)
{
    const uint8_t *bytes = read_records(file, &instance_record, report);
    if (!bytes) return;
    al_record_decode(&instance_record, bytes, info->instance_count, "", 1, instances, report);
    check_instances(info, instances, report);
}

al_status al_lightmap_read_instances(const al_file *file, const al_lightmap_info *info,
                                     al_lightmap_instance *instances, al_error *error)
{
    al_report report = {.name = al_file_name(file), .error = error};
    memset(instances, 0, info->instance_count * sizeof *instances);
    read_instances(file, info, instances, &report);
    if (report.status != AL_OK) memset(instances, 0, info->instance_count * sizeof *instances);
    return report.status;
}

/* Answers the first number that is not finite, or `count`; the first negative one in *negative. */
static size_t first_bad(const al_lightmap_info *info, const void *numbers, size_t count, size_t *negative)
{
    size_t i = 0;
    *negative = count;
    if (info->format == AL_LIGHTMAP_FLOAT) {
        const float *floats = numbers;
        for (; i < count && isfinite(floats[i]); i++)
            if (floats[i] < 0 && *negative == count) *negative = i;
    } else {
        const uint16_t *halves = numbers;
        for (; i < count && (halves[i] & 0x7c00) != 0x7c00; i++)
            if (halves[i] > 0x8000 && *negative == count) *negative = i;
    }
    return i;
}

static void check_layer(const al_lightmap_info *info, const void *numbers, uint64_t size, const char *what,
                        bool may_be_negative, uint32_t page, uint32_t layer, al_report *report)
{
    size_t count = (size_t)(size / number_size(info)), negative;
    size_t bad = first_bad(info, numbers, count, &negative);
    if (bad < count)
        al_report_finding(report, AL_RULE_FINITE,
                          "page %" PRIu32 ", layer %" PRIu32 ": number %zu of the %s is not finite", page,
                          layer, bad, what);
    if (!may_be_negative && negative < count)
        al_report_finding(report, AL_RULE_LIGHTMAP_NEGATIVE,
                          "page %" PRIu32 ", layer %" PRIu32 ": number %zu of the %s is negative", page,
                          layer, negative, what);
}

static void check_state(const al_lightmap_page *page, uint32_t index, al_report *report)
{
    size_t count = (size_t)page->width * page->height, i = 0;
    while (i < count && page->state[i] <= AL_TEXEL_BAKED) i++;
    if (i < count)
        al_report_finding(report, AL_RULE_LIGHTMAP_STATE, "page %" PRIu32 ": state %zu is %d", index, i,
                          page->state[i]);
}

static bool padding_is_zero(const uint8_t *bytes, const page_layout *l)
{
    bool zero = true;
    for (int layer = 0; layer < AL_LAYER_COUNT; layer++) {
        zero = zero && al_all_zero(bytes + l->irradiance[layer] + l->irradiance_size,
                                   al_padded(l->irradiance_size) - l->irradiance_size);
        zero = zero && al_all_zero(bytes + l->sh[layer] + l->sh_size, al_padded(l->sh_size) - l->sh_size);
    }
    return zero;
}

/* Floats are as they are. */
static void check_scales(const al_lightmap_info *info, const page_head *head, uint32_t index,
                         al_report *report)
{
    for (int layer = 0; layer < AL_LAYER_COUNT && info->format == AL_LIGHTMAP_FLOAT; layer++)
        if (head->scale[layer] != 1 || head->sh_scale[layer] != 1) {
            al_report_finding(report, AL_RULE_LIGHTMAP_SCALE,
                              "PAGS[%" PRIu32 "]: layer %d of floats has a scale other than 1", index, layer);
            return;
        }
}

static void read_page(const al_file *file, const al_lightmap_info *info, uint32_t index,
                      const page_head *head, al_lightmap_page *page, al_report *report)
{
    const void *data;
    size_t size;
    page_layout l = layout_of(info, head->width, head->height);
    *page = (al_lightmap_page){.width = head->width, .height = head->height};
    check_scales(info, head, index, report);
    ptrdiff_t chunk = al_file_find(file, "PAGE", index);
    assert(chunk >= 0); /* read_info has counted the pages */
    if (!al_report_data(report, file, (size_t)chunk, &data, &size)) return;
    if (size != l.size) {
        al_report_finding(report, AL_RULE_LIGHTMAP_PAGE_SIZE,
                          "page %" PRIu32 ": has %zu bytes, %" PRIu32 " x %" PRIu32 " texels need %" PRIu64,
                          index, size, head->width, head->height, l.size);
        return;
    }
    const uint8_t *bytes = data;
    memcpy(page->scale, head->scale, sizeof page->scale);
    memcpy(page->sh_scale, head->sh_scale, sizeof page->sh_scale);
    page->state = bytes + l.state;
    for (uint32_t layer = 0; layer < AL_LAYER_COUNT; layer++) {
        page->irradiance[layer] = bytes + l.irradiance[layer];
        page->sh[layer] = info->directional_order ? bytes + l.sh[layer] : NULL;
        check_layer(info, page->irradiance[layer], l.irradiance_size, "irradiance", false, index, layer,
                    report);
        if (page->sh[layer]) check_layer(info, page->sh[layer], l.sh_size, "SH", true, index, layer, report);
    }
    if (!padding_is_zero(bytes, &l))
        al_report_finding(report, AL_RULE_LIGHTMAP_PAGE_PADDING,
                          "page %" PRIu32 ": bytes between its arrays are not zero", index);
    check_state(page, index, report);
}

al_status al_lightmap_read_page(const al_file *file, const al_lightmap_info *info, uint32_t index,
                                al_lightmap_page *page, al_error *error)
{
    assert(index < info->page_count);
    al_report report = {.name = al_file_name(file), .error = error};
    page_head head = {0};
    *page = (al_lightmap_page){0};
    const uint8_t *bytes = read_records(file, &page_record, &report);
    if (bytes)
        al_record_decode(&page_record, bytes + index * al_record_size(&page_record), 1, "", 1, &head,
                         &report);
    if (report.status == AL_OK) read_page(file, info, index, &head, page, &report);
    if (report.status != AL_OK) *page = (al_lightmap_page){0};
    return report.status;
}

static const void *read_array(const al_file *file, const char *type, uint64_t wanted, al_report *report)
{
    const void *data;
    size_t size;
    ptrdiff_t index = al_file_find(file, type, 0);
    assert(index >= 0); /* the kind asks for it */
    if (!al_report_data(report, file, (size_t)index, &data, &size)) return NULL;
    if (size == wanted) return size ? data : "";
    al_report_finding(report, AL_RULE_LIGHTMAP_GEOMETRY, "%s: has %zu bytes, should have %" PRIu64, type,
                      size, wanted);
    return NULL;
}

typedef struct geometry {
    const float *vertices; /* [vertex_count][VERTEX_FLOATS] */
    const uint32_t *triangles;
} geometry;

static void check_vertices(const al_lightmap_info *info, const float *vertices, al_report *report)
{
    for (uint32_t i = 0; i < info->vertex_count; i++) {
        const float *v = vertices + VERTEX_FLOATS * (size_t)i;
        if (!isfinite(v[0]) || !isfinite(v[1]) || !isfinite(v[2]) || !isfinite(v[3]) || !isfinite(v[4])) {
            al_report_finding(report, AL_RULE_FINITE, "VERT[%" PRIu32 "]: is not finite", i);
            return;
        }
        if (v[3] < 0 || v[3] > 1 || v[4] < 0 || v[4] > 1) {
            al_report_finding(report, AL_RULE_LIGHTMAP_RECTANGLE, "VERT[%" PRIu32 "]: page uv is (%g, %g)", i,
                              (double)v[3], (double)v[4]);
            return;
        }
    }
}

static void read_geometry(const al_file *file, const al_lightmap_info *info, geometry *g, al_report *report)
{
    g->vertices = read_array(file, "VERT", (uint64_t)info->vertex_count * VERTEX_FLOATS * 4, report);
    g->triangles = read_array(file, "TRIS", (uint64_t)info->triangle_count * 3 * 4, report);
    if (g->vertices) check_vertices(info, g->vertices, report);
    for (uint64_t i = 0; g->triangles && i < 3 * (uint64_t)info->triangle_count; i++)
        if (g->triangles[i] >= info->vertex_count) {
            al_report_finding(report, AL_RULE_LIGHTMAP_INDEX,
                              "TRIS[%" PRIu64 "]: names vertex %" PRIu32 ", there are %" PRIu32, i / 3,
                              g->triangles[i], info->vertex_count);
            break;
        }
}

static void check_lightmap(const al_file *file, al_report *report)
{
    al_lightmap_info info;
    geometry g;
    if (!read_info(file, &info, report)) return;
    read_geometry(file, &info, &g, report);
    al_lightmap_instance *instances = calloc((size_t)info.instance_count + 1, sizeof *instances);
    if (!instances) {
        al_report_out_of_memory(report);
        return;
    }
    read_instances(file, &info, instances, report);
    free(instances);
    const uint8_t *bytes = read_records(file, &page_record, report);
    for (uint32_t i = 0; bytes && i < info.page_count; i++) {
        uint64_t before = report->count;
        page_head head;
        al_lightmap_page page;
        al_record_decode(&page_record, bytes + i * al_record_size(&page_record), 1, "", 1, &head, report);
        if (report->count == before) read_page(file, &info, i, &head, &page, report);
    }
}

static const al_chunk_rules chunks[] = {{"INFO", 1, 1, 1}, {"INST", 1, 1, 1}, {"PAGS", 1, 1, 1},
                                        {"VERT", 1, 1, 1}, {"TRIS", 1, 1, 1}, {"PAGE", 1, 0, 0},
                                        {"MEAS", 1, 0, 0}, {"PROV", 1, 0, 1}};

const al_kind_rules al_lightmap_rules = {AL_KIND_LIGHTMAP, "lightmap", chunks, sizeof chunks / sizeof *chunks,
                                         check_lightmap};

/* --- values --- */

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void subtract(const float a[3], const float b[3], double out[3])
{
    for (int k = 0; k < 3; k++) out[k] = (double)a[k] - b[k];
}

/* The point of a triangle nearest to p as weights of its corners: where p's projection falls, the corner, the
 * edge or the face is nearest (Ericson, Real-Time Collision Detection, 5.1.5: the regions of Voronoi).
 * Answers the square of the distance. */
static double nearest(const float *const v[3], const float p[3], double weight[3])
{
    double ab[3], ac[3], ap[3], bp[3], cp[3], square = 0;
    subtract(v[1], v[0], ab);
    subtract(v[2], v[0], ac);
    subtract(p, v[0], ap);
    subtract(p, v[1], bp);
    subtract(p, v[2], cp);
    double d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp),
           d6 = dot(ac, cp);
    double a = d3 * d6 - d5 * d4, b = d5 * d2 - d1 * d6, c = d1 * d4 - d3 * d2, y = 0, z = 0;
    if (d1 <= 0 && d2 <= 0)
        y = z = 0;
    else if (d3 >= 0 && d4 <= d3)
        y = 1;
    else if (d6 >= 0 && d5 <= d6)
        z = 1;
    else if (c <= 0 && d1 >= 0 && d3 <= 0)
        y = d1 / (d1 - d3);
    else if (b <= 0 && d2 >= 0 && d6 <= 0)
        z = d2 / (d2 - d6);
    else if (a <= 0 && d4 >= d3 && d5 >= d6)
        y = 1 - (z = (d4 - d3) / (d4 - d3 + d5 - d6));
    else
        y = b / (a + b + c), z = c / (a + b + c);
    weight[0] = 1 - y - z;
    weight[1] = y;
    weight[2] = z;
    for (int k = 0; k < 3; k++) {
        double distance = ap[k] - y * ab[k] - z * ac[k];
        square += distance * distance;
    }
    return square;
}

/* The cosine between the triangle's normal and `normal`; -1 for one without area. */
static double facing(const float *const v[3], const double normal[3])
{
    double ab[3], ac[3], n[3];
    subtract(v[1], v[0], ab);
    subtract(v[2], v[0], ac);
    for (int k = 0; k < 3; k++) n[k] = ab[(k + 1) % 3] * ac[(k + 2) % 3] - ab[(k + 2) % 3] * ac[(k + 1) % 3];
    double length = sqrt(dot(n, n));
    return length > 0 ? dot(n, normal) / length : -1;
}

typedef struct found {
    double square;
    uint32_t triangle;
    double uv[2];
} found;

/* False when no triangle faces that way. The first of equally near ones wins. */
static bool find_nearest(const al_lightmap_info *info, const geometry *g, const float position[3],
                         const double normal[3], found *best)
{
    *best = (found){.square = INFINITY};
    for (uint32_t t = 0; t < info->triangle_count; t++) {
        const float *v[3];
        double weight[3];
        for (int k = 0; k < 3; k++)
            v[k] = g->vertices + VERTEX_FLOATS * (size_t)g->triangles[3 * (size_t)t + (size_t)k];
        if (facing(v, normal) < 0.5) continue;
        double square = nearest(v, position, weight);
        if (!(square < best->square)) continue;
        *best = (found){.square = square, .triangle = t};
        for (int k = 0; k < 3; k++)
            for (int i = 0; i < 2; i++) best->uv[i] += weight[k] * v[k][3 + i];
    }
    return isfinite(best->square);
}

void al_lightmap_texel(const al_lightmap_info *info, const al_lightmap_page *page, al_lightmap_layer layer,
                       size_t texel, float irradiance[3])
{
    const void *numbers = page->irradiance[layer];
    assert(texel < (size_t)page->width * page->height);
    for (size_t c = 0; c < 3; c++)
        irradiance[c] =
            page->scale[layer] * (info->format == AL_LIGHTMAP_FLOAT
                                      ? ((const float *)numbers)[3 * texel + c]
                                      : al_half_to_float(((const uint16_t *)numbers)[3 * texel + c]));
}

/* Bilinear between the centres of texels that hold something. */
static void sample_page(const al_lightmap_info *info, const al_lightmap_page *page, const double uv[2],
                        float irradiance[AL_LAYER_COUNT][3])
{
    double sum[AL_LAYER_COUNT][3] = {{0}}, total = 0;
    double x = uv[0] * page->width - 0.5, y = uv[1] * page->height - 0.5;
    for (int corner = 0; corner < 4; corner++) {
        double column = floor(x) + corner % 2, row = floor(y) + corner / 2;
        double weight = fmax(1 - fabs(x - column), 0) * fmax(1 - fabs(y - row), 0);
        size_t texel = (size_t)fmin(fmax(row, 0), page->height - 1.0) * page->width +
                       (size_t)fmin(fmax(column, 0), page->width - 1.0);
        if (page->state[texel] == AL_TEXEL_EMPTY) continue;
        total += weight;
        for (int layer = 0; layer < AL_LAYER_COUNT; layer++) {
            float value[3];
            al_lightmap_texel(info, page, (al_lightmap_layer)layer, texel, value);
            for (int c = 0; c < 3; c++) sum[layer][c] += weight * value[c];
        }
    }
    for (int layer = 0; layer < AL_LAYER_COUNT; layer++)
        for (int c = 0; c < 3; c++) irradiance[layer][c] = total > 0 ? (float)(sum[layer][c] / total) : 0;
}

/* The instance whose triangles hold `triangle`. */
static al_status find_instance(const al_file *file, const al_lightmap_info *info, uint32_t triangle,
                               al_lightmap_instance *holder, al_error *error)
{
    al_lightmap_instance *all = calloc((size_t)info->instance_count + 1, sizeof *all);
    if (!all) return al_fail(error, AL_IO, "%s: out of memory", al_file_name(file));
    al_status status = al_lightmap_read_instances(file, info, all, error);
    for (uint32_t i = 0; status == AL_OK && i < info->instance_count; i++)
        if (triangle - all[i].first_triangle < all[i].triangle_count) *holder = all[i];
    free(all);
    return status;
}

al_status al_lightmap_evaluate(const al_file *file, const al_lightmap_info *info, const float position[3],
                               const float normal[3], al_lightmap_answer *answer, al_error *error)
{
    double direction[3] = {normal[0], normal[1], normal[2]}, length = sqrt(dot(direction, direction));
    geometry g;
    found best;
    al_lightmap_instance instance = {0};
    al_lightmap_page page;
    *answer = (al_lightmap_answer){0};
    if (!(length > 0) || !isfinite(length) || !isfinite(position[0] + position[1] + position[2]))
        return al_fail(error, AL_USAGE, "%s: position and normal must be finite, the normal longer than 0",
                       al_file_name(file));
    for (int k = 0; k < 3; k++) direction[k] /= length;
    al_report report = {.name = al_file_name(file), .error = error};
    read_geometry(file, info, &g, &report);
    if (report.status != AL_OK) return report.status;
    if (!find_nearest(info, &g, position, direction, &best))
        return al_fail(error, AL_USAGE, "%s: no lightmapped surface faces within 60 degrees of (%g, %g, %g)",
                       al_file_name(file), (double)normal[0], (double)normal[1], (double)normal[2]);
    al_status status = find_instance(file, info, best.triangle, &instance, error);
    if (status == AL_OK) status = al_lightmap_read_page(file, info, instance.page, &page, error);
    if (status != AL_OK) return status;
    sample_page(info, &page, best.uv, answer->irradiance);
    answer->distance_m = (float)sqrt(best.square);
    answer->instance = instance.instance;
    return AL_OK;
}

/* --- writing --- */

/* A power of two that brings the largest magnitude into (2^14, 2^15]; 1 for floats and for a layer of zeros.
 * Not below the smallest float that divides without loss. */
static float scale_for(const al_lightmap_info *info, const float *values, size_t count)
{
    float largest = 0;
    int exponent;
    if (info->format == AL_LIGHTMAP_FLOAT) return 1;
    for (size_t i = 0; i < count; i++) largest = fmaxf(largest, fabsf(values[i]));
    if (!(largest > 0)) return 1;
    if (frexpf(largest, &exponent) == 0.5f) exponent--;
    return ldexpf(1, exponent - 15 > -126 ? exponent - 15 : -126);
}

static void encode(const al_lightmap_info *info, const float *values, size_t count, float scale, uint8_t *out)
{
    if (info->format == AL_LIGHTMAP_FLOAT)
        memcpy(out, values, count * sizeof *values);
    else
        for (size_t i = 0; i < count; i++)
            al_put_bytes(out + 2 * i, al_half_from_float(values[i] / scale), 2);
}

static void head_of(const al_lightmap_info *info, const al_lightmap_source *page, page_head *head)
{
    size_t count = 3 * (size_t)page->width * page->height;
    size_t sh_count = count * info->directional_order * info->directional_order;
    *head = (page_head){.width = page->width, .height = page->height};
    for (int layer = 0; layer < AL_LAYER_COUNT; layer++) {
        head->scale[layer] = scale_for(info, page->irradiance + layer * count, count);
        head->sh_scale[layer] = sh_count ? scale_for(info, page->sh + layer * sh_count, sh_count) : 1;
    }
}

static al_status add_page(al_writer *writer, const char *path, const al_lightmap_info *info,
                          const al_lightmap_source *page, const page_head *head, al_error *error)
{
    page_layout l = layout_of(info, page->width, page->height);
    size_t count = 3 * (size_t)page->width * page->height;
    size_t sh_count = count * info->directional_order * info->directional_order;
    uint8_t *bytes = calloc(1, l.size);
    if (!bytes)
        return al_fail(error, AL_IO, "%s: out of memory for a page of %" PRIu64 " bytes", path, l.size);
    for (int layer = 0; layer < AL_LAYER_COUNT; layer++) {
        encode(info, page->irradiance + layer * count, count, head->scale[layer],
               bytes + l.irradiance[layer]);
        if (sh_count)
            encode(info, page->sh + layer * sh_count, sh_count, head->sh_scale[layer], bytes + l.sh[layer]);
    }
    memcpy(bytes + l.state, page->state, count / 3);
    al_status status = al_writer_add(writer, "PAGE", 1, 0, bytes, l.size, error);
    free(bytes);
    return status;
}

static al_status add_records(al_writer *writer, const char *path, const al_record *record, const void *values,
                             uint32_t count, al_error *error)
{
    size_t size = al_record_size(record) * count;
    uint8_t *bytes = malloc(size + 1);
    if (!bytes) return al_fail(error, AL_IO, "%s: out of memory", path);
    al_record_encode(record, values, count, NULL, bytes);
    al_status status = al_writer_add(writer, record->type, 1, 0, bytes, size, error);
    free(bytes);
    return status;
}

static al_status add_chunks(al_writer *writer, const char *path, const al_lightmap_data *data,
                            const page_head *heads, al_error *error)
{
    const al_lightmap_info *info = &data->info;
    const char *provenance = data->provenance_json;
    al_status status = add_records(writer, path, &info_record, info, 1, error);
    if (status == AL_OK)
        status = add_records(writer, path, &instance_record, data->instances, info->instance_count, error);
    if (status == AL_OK) status = add_records(writer, path, &page_record, heads, info->page_count, error);
    if (status == AL_OK)
        status = al_writer_add(writer, "VERT", 1, 0, data->vertices,
                               (size_t)info->vertex_count * VERTEX_FLOATS * sizeof(float), error);
    if (status == AL_OK)
        status = al_writer_add(writer, "TRIS", 1, 0, data->triangles,
                               (size_t)info->triangle_count * 3 * sizeof(uint32_t), error);
    for (uint32_t i = 0; status == AL_OK && i < info->page_count; i++)
        status = add_page(writer, path, info, &data->pages[i], &heads[i], error);
    if (status == AL_OK) status = al_measured_write(writer, data->measured, data->measured_count, error);
    if (status == AL_OK && provenance)
        status = al_writer_add(writer, "PROV", 1, AL_CHUNK_OPTIONAL, provenance, strlen(provenance), error);
    return status;
}

al_status al_lightmap_write(const char *path, const al_lightmap_data *data, uint64_t *bytes, al_error *error)
{
    al_writer *writer;
    if (bytes) *bytes = 0;
    page_head *heads = calloc((size_t)data->info.page_count + 1, sizeof *heads);
    if (!heads) return al_fail(error, AL_IO, "%s: out of memory", path);
    for (uint32_t i = 0; i < data->info.page_count; i++) head_of(&data->info, &data->pages[i], &heads[i]);
    al_status status = al_writer_open(path, AL_KIND_LIGHTMAP, &writer, error);
    if (status != AL_OK) goto cleanup;
    status = add_chunks(writer, path, data, heads, error);
    if (status == AL_OK)
        status = al_writer_commit(writer, bytes, error);
    else
        al_writer_discard(writer);
cleanup:
    free(heads);
    return status;
}
