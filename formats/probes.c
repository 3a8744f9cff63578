#include "airlight/probes.h"

#include <assert.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/scene.h"
#include "kinds.h"
#include "layout.h"
#include "record.h"

#define COUNT_LIMIT (UINT32_MAX / 2)

static const al_field info_fields[] = {
    AL_FIELD(al_probes_info, probe_count, AL_FIELD_U32, 1, 1, COUNT_LIMIT),
    AL_FIELD(al_probes_info, tetrahedron_count, AL_FIELD_U32, 1, 0, COUNT_LIMIT),
    AL_FIELD(al_probes_info, order, AL_FIELD_U32, 1, 1, AL_PROBES_MAX_ORDER),
};
static const al_record info_record = {"INFO", sizeof(al_probes_info), info_fields,
                                      sizeof info_fields / sizeof *info_fields};

/* Below 2^31 probes of at most 3 x 3 x 64 floats: far below 2^64. */
static uint64_t coefficient_count(const al_probes_info *info)
{
    return (uint64_t)info->probe_count * AL_LAYER_COUNT * 3 * info->order * info->order;
}

/* --- where a point lies --- */

/* Six times the signed volume of (a, b, c, d). */
static double volume6(const float *a, const float *b, const float *c, const float *d)
{
    double e[3][3];
    for (int i = 0; i < 3; i++) {
        e[0][i] = (double)b[i] - a[i];
        e[1][i] = (double)c[i] - a[i];
        e[2][i] = (double)d[i] - a[i];
    }
    return e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) +
           e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
           e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
}

static const float *corner(const al_probes *probes, uint32_t tetrahedron, int k)
{
    return probes->positions + 3 * (size_t)probes->tetrahedra[4 * (size_t)tetrahedron + k];
}

/* Barycentric coordinates of a point; answers the least one's index. */
static int barycentric(const al_probes *probes, uint32_t tetrahedron, const float point[3], double b[4])
{
    const float *p[4];
    for (int k = 0; k < 4; k++) p[k] = corner(probes, tetrahedron, k);
    double whole = volume6(p[0], p[1], p[2], p[3]);
    b[0] = volume6(point, p[1], p[2], p[3]) / whole;
    b[1] = volume6(p[0], point, p[2], p[3]) / whole;
    b[2] = volume6(p[0], p[1], point, p[3]) / whole;
    b[3] = volume6(p[0], p[1], p[2], point) / whole;
    int least = 0;
    for (int k = 1; k < 4; k++)
        if (b[k] < b[least]) least = k;
    return least;
}

/* Walks towards the point; false when the way ends before it. The visibility walk ends in a Delaunay mesh
 * (Devillers, Pion and Teillaud 2002); the limit is for meshes that are none. */
static bool walk(const al_probes *probes, const float point[3], uint32_t *tetrahedron)
{
    double b[4];
    for (uint32_t steps = 0; steps <= probes->info.tetrahedron_count; steps++) {
        int least = barycentric(probes, *tetrahedron, point, b);
        if (b[least] >= -1e-6) return true;
        uint32_t next = probes->neighbours[4 * (size_t)*tetrahedron + least];
        if (next == AL_NO_INDEX) return false;
        *tetrahedron = next;
    }
    return false;
}

/* Where the mesh has a hole the walk may end although a tetrahedron holds the point. */
static bool search(const al_probes *probes, const float point[3], uint32_t *tetrahedron)
{
    double b[4];
    for (uint32_t t = 0; t < probes->info.tetrahedron_count; t++)
        if (b[barycentric(probes, t, point, b)] >= -1e-6) {
            *tetrahedron = t;
            return true;
        }
    return false;
}

/* Barycentric coordinates (1 - v - w, v, w) of the nearest point of a triangle: inside, the foot of the
 * perpendicular; else on the nearest of the edges. Answers its squared distance. */
static double nearest_on_triangle(const float *const p[3], const float point[3], double weights[3])
{
    double e[2][3], to[3], d[2], nearest = INFINITY;
    double g00 = 0, g01 = 0, g11 = 0;
    d[0] = d[1] = 0;
    for (int i = 0; i < 3; i++) {
        e[0][i] = (double)p[1][i] - p[0][i];
        e[1][i] = (double)p[2][i] - p[0][i];
        to[i] = (double)point[i] - p[0][i];
        g00 += e[0][i] * e[0][i];
        g01 += e[0][i] * e[1][i];
        g11 += e[1][i] * e[1][i];
        d[0] += e[0][i] * to[i];
        d[1] += e[1][i] * to[i];
    }
    double determinant = g00 * g11 - g01 * g01;
    double v = (g11 * d[0] - g01 * d[1]) / determinant, w = (g00 * d[1] - g01 * d[0]) / determinant;
    /* The foot itself, then the nearest point of each edge: (v, w) on w = 0, on v = 0, on v + w = 1. */
    double along = (g00 - g01 + d[1] - d[0]) / (g00 - 2 * g01 + g11);
    const double candidates[4][2] = {{v, w},
                                     {fmin(fmax(d[0] / g00, 0), 1), 0},
                                     {0, fmin(fmax(d[1] / g11, 0), 1)},
                                     {1 - fmin(fmax(along, 0), 1), fmin(fmax(along, 0), 1)}};
    for (int n = v >= 0 && w >= 0 && v + w <= 1 ? 0 : 1; n < 4; n++) {
        double square = 0;
        for (int i = 0; i < 3; i++)
            square += pow(candidates[n][0] * e[0][i] + candidates[n][1] * e[1][i] - to[i], 2);
        if (!(square < nearest)) continue;
        nearest = square;
        weights[0] = 1 - candidates[n][0] - candidates[n][1];
        weights[1] = candidates[n][0];
        weights[2] = candidates[n][1];
    }
    return nearest;
}

/* The nearest point of the mesh's outer faces. */
static void take_outer_face(const al_probes *probes, const float point[3], al_probe_place *place)
{
    double nearest = INFINITY, weights[3] = {0};
    for (uint32_t side = 0; side < 4 * probes->info.tetrahedron_count; side++) {
        const float *p[3];
        uint32_t names[3];
        int count = 0;
        if (probes->neighbours[side] != AL_NO_INDEX) continue;
        for (uint32_t k = 0; k < 4; k++)
            if (k != side % 4) names[count++] = probes->tetrahedra[side / 4 * 4 + k];
        for (int k = 0; k < 3; k++) p[k] = probes->positions + 3 * (size_t)names[k];
        double square = nearest_on_triangle(p, point, weights);
        if (!(square < nearest)) continue;
        nearest = square;
        *place = (al_probe_place){.tetrahedron = side / 4};
        for (int k = 0; k < 3; k++) {
            place->probes[k] = names[k];
            place->weights[k] = (float)fmax(weights[k], 0);
        }
        place->probes[3] = names[0];
    }
}

static void take_nearest(const al_probes *probes, const float point[3], al_probe_place *place)
{
    double nearest = INFINITY;
    *place = (al_probe_place){.weights = {1}};
    for (uint32_t i = 0; i < probes->info.probe_count; i++) {
        double square = 0;
        for (int k = 0; k < 3; k++) square += pow((double)probes->positions[3 * (size_t)i + k] - point[k], 2);
        if (square >= nearest) continue;
        nearest = square;
        for (int k = 0; k < 4; k++) place->probes[k] = i;
    }
}

void al_probes_locate(const al_probes *probes, const float position[3], al_probe_place *place)
{
    double b[4], sum = 0;
    if (!probes->info.tetrahedron_count) {
        take_nearest(probes, position, place);
        return;
    }
    uint32_t t = place->tetrahedron < probes->info.tetrahedron_count ? place->tetrahedron : 0;
    if (!walk(probes, position, &t) && !search(probes, position, &t)) {
        take_outer_face(probes, position, place);
        return;
    }
    barycentric(probes, t, position, b);
    place->tetrahedron = t;
    for (int k = 0; k < 4; k++) sum += b[k] = fmax(b[k], 0);
    for (int k = 0; k < 4; k++) {
        place->probes[k] = probes->tetrahedra[4 * (size_t)t + k];
        place->weights[k] = (float)(b[k] / sum);
    }
}

void al_probes_blend(const al_probes *probes, const al_probe_place *place, al_lightmap_layer layer,
                     float sh[3][AL_PROBES_MAX_COUNT])
{
    size_t set = (size_t)probes->info.order * probes->info.order;
    for (int channel = 0; channel < 3; channel++)
        for (size_t i = 0; i < set; i++) {
            float sum = 0;
            for (int k = 0; k < 4; k++) {
                size_t first = (((size_t)place->probes[k] * AL_LAYER_COUNT + layer) * 3 + channel) * set;
                sum += place->weights[k] * probes->coefficients[first + i];
            }
            sh[channel][i] = sum;
        }
}

/* --- reading --- */

static const void *read_array(const al_file *file, const char *type, uint64_t wanted, al_report *report)
{
    const void *data;
    size_t size;
    ptrdiff_t index = al_file_find(file, type, 0);
    assert(index >= 0); /* the kind asks for it */
    if (!al_report_data(report, file, (size_t)index, &data, &size)) return NULL;
    if (size == wanted) return size ? data : "";
    al_report_finding(report, AL_RULE_PROBES_SIZE, "%s: has %zu bytes, should have %" PRIu64, type, size,
                      wanted);
    return NULL;
}

static bool read_info(const al_file *file, al_probes_info *info, al_report *report)
{
    uint64_t before = report->count;
    const void *bytes = NULL;
    const al_chunk *chunk = al_file_chunk(file, (size_t)al_file_find(file, "INFO", 0));
    if (chunk->size != al_record_size(&info_record))
        al_report_finding(report, AL_RULE_RECORD_SIZE, "INFO: has %" PRIu64 " bytes, should have %zu",
                          chunk->size, al_record_size(&info_record));
    else
        bytes = read_array(file, "INFO", al_record_size(&info_record), report);
    if (bytes) al_record_decode(&info_record, bytes, 1, "", 1, info, report);
    return bytes && report->count == before;
}

static void check_finite(const float *numbers, uint64_t count, const char *type, al_report *report)
{
    for (uint64_t i = 0; i < count; i++)
        if (!isfinite(numbers[i])) {
            al_report_finding(report, AL_RULE_FINITE, "%s: number %" PRIu64 " is not finite", type, i);
            return;
        }
}

static bool check_corners(const al_probes *p, al_report *report)
{
    for (size_t i = 0; i < 4 * (size_t)p->info.tetrahedron_count; i++)
        if (p->tetrahedra[i] >= p->info.probe_count) {
            al_report_finding(report, AL_RULE_PROBES_INDEX,
                              "TETR: tetrahedron %zu names probe %" PRIu32 " of %" PRIu32, i / 4,
                              p->tetrahedra[i], p->info.probe_count);
            return false;
        }
    return true;
}

static bool has_volume(const al_probes *p, uint32_t tetrahedron)
{
    const float *c[4];
    for (int k = 0; k < 4; k++) c[k] = corner(p, tetrahedron, k);
    return volume6(c[0], c[1], c[2], c[3]) > 0;
}

static bool has_corner(const uint32_t *tetrahedron, uint32_t probe)
{
    for (int k = 0; k < 4; k++)
        if (tetrahedron[k] == probe) return true;
    return false;
}

/* The neighbour across from corner k has the three other corners and names this one back, once. */
static bool is_mutual(const al_probes *p, uint32_t t, int k)
{
    uint32_t other = p->neighbours[4 * (size_t)t + k];
    if (other == AL_NO_INDEX) return true;
    if (other >= p->info.tetrahedron_count || other == t) return false;
    const uint32_t *own = p->tetrahedra + 4 * (size_t)t, *theirs = p->tetrahedra + 4 * (size_t)other;
    for (int i = 0; i < 4; i++)
        if (has_corner(theirs, own[i]) != (i != k)) return false;
    for (int i = 0; i < 4; i++)
        if (!has_corner(own, theirs[i])) return p->neighbours[4 * (size_t)other + i] == t;
    return false;
}

static void check_mesh(const al_probes *p, al_report *report)
{
    if (!check_corners(p, report)) return;
    for (uint32_t t = 0; t < p->info.tetrahedron_count; t++)
        if (!has_volume(p, t)) {
            al_report_finding(report, AL_RULE_PROBES_VOLUME,
                              "TETR: tetrahedron %" PRIu32 " is flat or turned inside out", t);
            return;
        }
    for (uint32_t t = 0; t < p->info.tetrahedron_count; t++)
        for (int k = 0; k < 4; k++)
            if (!is_mutual(p, t, k)) {
                al_report_finding(report, AL_RULE_PROBES_NEIGHBOUR,
                                  "NEIG: number %d of tetrahedron %" PRIu32 " is not its neighbour there", k,
                                  t);
                return;
            }
}

static void read_probes(const al_file *file, al_probes *p, al_report *report)
{
    uint64_t before = report->count;
    if (!read_info(file, &p->info, report)) return;
    uint64_t corners = 4ull * p->info.tetrahedron_count;
    p->positions = read_array(file, "POSI", 12ull * p->info.probe_count, report);
    p->tetrahedra = read_array(file, "TETR", 4 * corners, report);
    p->neighbours = read_array(file, "NEIG", 4 * corners, report);
    p->coefficients = read_array(file, "COEF", 4 * coefficient_count(&p->info), report);
    if (report->count != before) return;
    check_finite(p->positions, 3ull * p->info.probe_count, "POSI", report);
    check_finite(p->coefficients, coefficient_count(&p->info), "COEF", report);
    if (report->count == before) check_mesh(p, report);
}

al_status al_probes_read(const al_file *file, al_probes *probes, al_error *error)
{
    *probes = (al_probes){0};
    if (al_file_kind(file) != AL_KIND_PROBES)
        return al_fail(error, AL_BAD_INPUT, "%s: is an asset of kind %s, wanted is probes",
                       al_file_name(file), al_kind_name(al_file_kind(file)));
    al_report report = {.name = al_file_name(file), .error = error};
    read_probes(file, probes, &report);
    if (report.status != AL_OK) *probes = (al_probes){0};
    return report.status;
}

static void check_probes(const al_file *file, al_report *report)
{
    al_probes probes = {0};
    read_probes(file, &probes, report);
}

static const al_chunk_rules chunks[] = {{"INFO", 1, 1, 1}, {"POSI", 1, 1, 1}, {"TETR", 1, 1, 1},
                                        {"NEIG", 1, 1, 1}, {"COEF", 1, 1, 1}, {"MEAS", 1, 0, 0}, {"PROV", 1, 0, 1}};
const al_kind_rules al_probes_rules = {AL_KIND_PROBES, "probes", chunks, sizeof chunks / sizeof *chunks,
                                       check_probes};

/* --- writing --- */

typedef struct face {
    uint32_t corners[3]; /* ascending */
    uint32_t side;       /* 4 tetrahedron + corner across */
} face;

static int compare_faces(const void *a, const void *b)
{
    const face *x = a, *y = b;
    for (int k = 0; k < 3; k++)
        if (x->corners[k] != y->corners[k]) return x->corners[k] < y->corners[k] ? -1 : 1;
    return x->side < y->side ? -1 : x->side > y->side;
}

static face face_of(const uint32_t *tetrahedra, uint32_t side)
{
    face made = {.side = side};
    int count = 0;
    for (uint32_t k = 0; k < 4; k++)
        if (k != side % 4) made.corners[count++] = tetrahedra[side / 4 * 4 + k];
    for (int i = 1; i < 3; i++)
        for (int k = i; k > 0 && made.corners[k] < made.corners[k - 1]; k--) {
            uint32_t swapped = made.corners[k];
            made.corners[k] = made.corners[k - 1];
            made.corners[k - 1] = swapped;
        }
    return made;
}

/* Faces with the same corners belong to neighbours. free() the answer; NULL without memory. */
static uint32_t *find_neighbours(const uint32_t *tetrahedra, uint32_t count)
{
    uint32_t sides = 4 * count;
    face *faces = malloc((sides + (size_t)1) * sizeof *faces);
    uint32_t *neighbours = malloc((sides + (size_t)1) * sizeof *neighbours);
    if (!faces || !neighbours) {
        free(faces);
        free(neighbours);
        return NULL;
    }
    for (uint32_t side = 0; side < sides; side++) {
        faces[side] = face_of(tetrahedra, side);
        neighbours[side] = AL_NO_INDEX;
    }
    qsort(faces, sides, sizeof *faces, compare_faces);
    for (uint32_t i = 1; i < sides; i++)
        if (!memcmp(faces[i].corners, faces[i - 1].corners, sizeof faces[i].corners)) {
            neighbours[faces[i].side] = faces[i - 1].side / 4;
            neighbours[faces[i - 1].side] = faces[i].side / 4;
        }
    free(faces);
    return neighbours;
}

static al_status add_chunks(al_writer *writer, const char *path, const al_probes_data *data,
                            const uint32_t *neighbours, al_error *error)
{
    const al_probes_info *info = &data->info;
    uint8_t bytes[16];
    size_t corners = 16 * (size_t)info->tetrahedron_count;
    if (!al_record_encode(&info_record, info, 1, NULL, bytes))
        return al_fail(error, AL_IO, "%s: out of memory for chunk INFO", path);
    al_status status = al_writer_add(writer, "INFO", 1, 0, bytes, al_record_size(&info_record), error);
    if (status == AL_OK)
        status = al_writer_add(writer, "POSI", 1, 0, data->positions, 12 * (size_t)info->probe_count, error);
    if (status == AL_OK) status = al_writer_add(writer, "TETR", 1, 0, data->tetrahedra, corners, error);
    if (status == AL_OK) status = al_writer_add(writer, "NEIG", 1, 0, neighbours, corners, error);
    if (status == AL_OK)
        status = al_writer_add(writer, "COEF", 1, 0, data->coefficients, 4 * coefficient_count(info), error);
    if (status == AL_OK) status = al_measured_write(writer, data->measured, data->measured_count, error);
    if (status == AL_OK && data->provenance_json)
        status = al_writer_add(writer, "PROV", 1, AL_CHUNK_OPTIONAL, data->provenance_json,
                               strlen(data->provenance_json), error);
    return status;
}

al_status al_probes_write(const char *path, const al_probes_data *data, uint64_t *bytes, al_error *error)
{
    al_writer *writer;
    if (bytes) *bytes = 0;
    if (data->info.tetrahedron_count > UINT32_MAX / 4)
        return al_fail(error, AL_BAD_INPUT, "%s: %" PRIu32 " tetrahedra; at most 2^30 are right", path,
                       data->info.tetrahedron_count);
    uint32_t *neighbours = find_neighbours(data->tetrahedra, data->info.tetrahedron_count);
    if (!neighbours) return al_fail(error, AL_IO, "%s: out of memory for the probes' mesh", path);
    al_status status = al_writer_open(path, AL_KIND_PROBES, &writer, error);
    if (status == AL_OK) {
        status = add_chunks(writer, path, data, neighbours, error);
        if (status == AL_OK)
            status = al_writer_commit(writer, bytes, error);
        else
            al_writer_discard(writer);
    }
    free(neighbours);
    return status;
}
