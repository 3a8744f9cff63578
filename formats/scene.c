#include "airlight/scene.h"

#include <assert.h>
#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/formulas.h"
#include "kinds.h"
#include "layout.h"
#include "motion_chunks.h"
#include "record.h"

/* --- memory: everything a scene owns hangs on one list --- */

typedef struct block {
    struct block *next;
    max_align_t payload[];
} block;

void *al_scene_allocate(al_scene *scene, size_t size)
{
    if (size > SIZE_MAX - sizeof(block)) return NULL;
    block *made = calloc(1, sizeof(block) + size);
    if (!made) return NULL;
    made->next = scene->storage;
    scene->storage = made;
    return made->payload;
}

char *al_scene_text(al_scene *scene, const char *text)
{
    size_t size = strlen(text) + 1;
    char *copy = al_scene_allocate(scene, size);
    if (copy) memcpy(copy, text, size);
    return copy;
}

void al_scene_free(al_scene *scene)
{
    for (block *here = scene->storage, *next; here; here = next) {
        next = here->next;
        free(here);
    }
    *scene = (al_scene){0};
}

/* --- records --- */

enum { EDGE_LIMIT = 16384 /* pixels */, TARGET_LIMIT = 65536 };

#define COUNT_LIMIT (UINT32_MAX / 2)
#define G_LIMIT 0.99999994 /* the float before 1 */
#define COUNT_OF(array) (sizeof(array) / sizeof *(array))
#define U32(record, member, minimum, maximum) AL_FIELD(record, member, AL_FIELD_U32, 1, minimum, maximum)
#define INDEX(record, member) AL_FIELD(record, member, AL_FIELD_U32, 1, 1, 0) /* checked by its own rule */
#define BOOL(record, member) AL_FIELD(record, member, AL_FIELD_BOOL, 1, 0, 1)
#define TEXT(record, member) AL_FIELD(record, member, AL_FIELD_TEXT, 1, 0, 0)
#define F32(record, member, count, minimum, maximum) \
    AL_FIELD(record, member, AL_FIELD_F32, count, minimum, maximum)
#define FREE(record, member, count) \
    AL_FIELD(record, member, AL_FIELD_F32, count, 1, 0) /* any finite number */

static const al_field scene_fields[] = {
    U32(al_scene, texture_count, 0, COUNT_LIMIT),
    U32(al_scene, material_count, 0, COUNT_LIMIT),
    U32(al_scene, mesh_count, 0, COUNT_LIMIT),
    U32(al_scene, instance_count, 0, COUNT_LIMIT),
    U32(al_scene, medium_count, 0, COUNT_LIMIT),
    U32(al_scene, translucent_count, 0, COUNT_LIMIT),
    U32(al_scene, light_count, 0, COUNT_LIMIT),
    U32(al_scene, camera_count, 0, COUNT_LIMIT),
    U32(al_scene, environment.width, 0, EDGE_LIMIT),
    U32(al_scene, environment.height, 0, EDGE_LIMIT),
    FREE(al_scene, environment.sh, 3 * AL_ENVIRONMENT_ORDER * AL_ENVIRONMENT_ORDER),
    FREE(al_scene, play.exposure_ev, 1),
    F32(al_scene, play.background, 3, 0, FLT_MAX),
};

static const al_field texture_fields[] = {
    TEXT(al_texture, name),
    U32(al_texture, width, 1, EDGE_LIMIT),
    U32(al_texture, height, 1, EDGE_LIMIT),
    BOOL(al_texture, srgb),
};

static const al_field material_fields[] = {
    TEXT(al_material, name),
    F32(al_material, base_color, 3, 0, FLT_MAX),
    F32(al_material, metallic, 1, 0, 1),
    F32(al_material, roughness, 1, 0, 1),
    F32(al_material, emission_w_m2_sr, 3, 0, FLT_MAX),
    F32(al_material, ior, 1, 1, FLT_MAX),
    BOOL(al_material, double_sided),
    INDEX(al_material, base_color_texture),
    INDEX(al_material, emission_texture),
    INDEX(al_material, metallic_roughness_texture),
    INDEX(al_material, normal_texture),
};

typedef struct mesh_head { /* a mesh without its arrays */
    al_mesh mesh;
    bool has_uv0, has_uv1;
} mesh_head;

static const al_field mesh_fields[] = {
    TEXT(mesh_head, mesh.name),
    U32(mesh_head, mesh.vertex_count, 0, UINT32_MAX),
    U32(mesh_head, mesh.index_count, 0, UINT32_MAX),
    U32(mesh_head, mesh.submesh_count, 0, UINT32_MAX),
    BOOL(mesh_head, has_uv0),
    BOOL(mesh_head, has_uv1),
};

static const al_field submesh_fields[] = {
    INDEX(al_submesh, first_index),
    INDEX(al_submesh, index_count),
    INDEX(al_submesh, material),
};

static const al_field instance_fields[] = {
    TEXT(al_instance, name),
    INDEX(al_instance, mesh),
    U32(al_instance, role, AL_ROLE_OPAQUE, AL_ROLE_BLOCKER),
    INDEX(al_instance, translucent),
    FREE(al_instance, world, 16),
};

static const al_field lighting_fields[] = {
    U32(al_instance, lighting, AL_LIGHTING_DYNAMIC, AL_LIGHTING_PROBES),
};

static const al_field fog_fields[] = {
    INDEX(al_fog, medium),
    BOOL(al_fog, bounded),
    FREE(al_fog, bounds_min_m, 3),
    FREE(al_fog, bounds_max_m, 3),
    F32(al_fog, density, 1, 0, FLT_MAX),
    TEXT(al_fog, asset),
};

static const al_field baked_fields[] = {
    TEXT(al_baked_light, lightmap),
    TEXT(al_baked_light, probes),
};

static const al_field medium_fields[] = {
    TEXT(al_medium, name),
    F32(al_medium, sigma_s_per_m, 3, 0, FLT_MAX),
    F32(al_medium, sigma_a_per_m, 3, 0, FLT_MAX),
    F32(al_medium, g, 1, -G_LIMIT, G_LIMIT),
};

static const al_field translucent_fields[] = {
    TEXT(al_translucent_object, name),
    INDEX(al_translucent_object, instance),
    INDEX(al_translucent_object, medium),
    TEXT(al_translucent_object, asset),
};

static const al_field light_fields[] = {
    TEXT(al_light, name),
    U32(al_light, type, AL_LIGHT_DIRECTIONAL, AL_LIGHT_POINT),
    FREE(al_light, vector, 3),
    F32(al_light, intensity, 3, 0, FLT_MAX),
};

static const al_field camera_fields[] = {
    TEXT(al_camera, name),
    FREE(al_camera, position, 3),
    FREE(al_camera, target, 3),
    FREE(al_camera, up, 3),
    F32(al_camera, fov_y_radians, 1, 1e-6, AL_PI - 1e-6),
};

static const al_field node_fields[] = {
    TEXT(al_motion_node, name),          INDEX(al_motion_node, parent),     FREE(al_motion_node, matrix, 16),
    FREE(al_motion_node, translation, 3), FREE(al_motion_node, rotation, 4), FREE(al_motion_node, scale, 3),
};

static const al_field channel_fields[] = {
    INDEX(al_motion_channel, node),
    U32(al_motion_channel, path, AL_MOTION_TRANSLATION, AL_MOTION_WEIGHTS),
    U32(al_motion_channel, interpolation, AL_MOTION_STEP, AL_MOTION_CUBIC),
    U32(al_motion_channel, key_count, 1, COUNT_LIMIT),
    U32(al_motion_channel, width, 1, TARGET_LIMIT),
};

static const al_field binding_fields[] = {
    U32(al_motion_binding, kind, AL_MOTION_INSTANCE, AL_MOTION_FOG),
    INDEX(al_motion_binding, index),
    INDEX(al_motion_binding, node),
    FREE(al_motion_binding, local, 16),
};

static const al_field joint_fields[] = {
    INDEX(al_motion_joint, node),
    FREE(al_motion_joint, inverse_bind, 16),
};

static const al_field deform_fields[] = {
    INDEX(al_motion_deform, instance),       INDEX(al_motion_deform, node),
    INDEX(al_motion_deform, first_joint),    INDEX(al_motion_deform, joint_count),
    U32(al_motion_deform, target_count, 0, TARGET_LIMIT), BOOL(al_motion_deform, has_normals),
};

#define RECORD(type, record, fields) \
    { \
        type, sizeof(record), fields, COUNT_OF(fields) \
    }

static const al_record scene_record = RECORD("SCEN", al_scene, scene_fields);
static const al_record texture_record = RECORD("TEXR", al_texture, texture_fields);
static const al_record material_record = RECORD("MATL", al_material, material_fields);
static const al_record mesh_record = RECORD("MESH", mesh_head, mesh_fields);
static const al_record submesh_record = RECORD("SUBM", al_submesh, submesh_fields);
static const al_record instance_record = RECORD("INST", al_instance, instance_fields);
static const al_record medium_record = RECORD("MEDI", al_medium, medium_fields);
static const al_record translucent_record = RECORD("TRAN", al_translucent_object, translucent_fields);
static const al_record light_record = RECORD("LITE", al_light, light_fields);
static const al_record camera_record = RECORD("CAMR", al_camera, camera_fields);
static const al_record lighting_record = RECORD("INLI", al_instance, lighting_fields);
static const al_record fog_record = RECORD("FOGS", al_fog, fog_fields);
static const al_record baked_record = RECORD("BAKD", al_baked_light, baked_fields);
static const al_record node_record = RECORD("NODE", al_motion_node, node_fields);
static const al_record channel_record = RECORD("CHAN", al_motion_channel, channel_fields);
static const al_record binding_record = RECORD("BIND", al_motion_binding, binding_fields);
static const al_record joint_record = RECORD("JONT", al_motion_joint, joint_fields);
static const al_record deform_record = RECORD("DEFM", al_motion_deform, deform_fields);

static const al_chunk_rules chunks[] = {
    {"TEXT", 1, 1, 1}, {"SCEN", 1, 1, 1}, {"TEXR", 1, 1, 1}, {"MATL", 1, 1, 1}, {"MESH", 1, 1, 1},
    {"SUBM", 1, 1, 1}, {"INST", 1, 1, 1}, {"MEDI", 1, 1, 1}, {"TRAN", 1, 1, 1}, {"LITE", 1, 1, 1},
    {"CAMR", 1, 1, 1}, {"GEOM", 1, 0, 0}, {"PIXL", 1, 0, 0}, {"ENVM", 1, 0, 1}, {"INLI", 1, 0, 1},
    {"FOGS", 1, 0, 1}, {"BAKD", 1, 0, 1}, {"PROV", 1, 0, 1},
    {"NODE", 1, 0, 1}, {"CHAN", 1, 0, 1}, {"BIND", 1, 0, 1}, {"JONT", 1, 0, 1}, {"DEFM", 1, 0, 1},
    {"KEYS", 1, 0, 1}, {"SHAP", 1, 0, 0},
};

/* --- the arrays of a mesh, each at a multiple of 64 in its GEOM chunk --- */

enum { POSITIONS, NORMALS, UV0, UV1, INDICES, ARRAY_COUNT };

typedef struct geometry_layout {
    uint64_t begin[ARRAY_COUNT], end[ARRAY_COUNT]; /* equal for an array that is not there */
    uint64_t size;
} geometry_layout;

/* Below 2^32 elements of at most 12 bytes in each array: far below 2^64. */
static geometry_layout layout_of(const mesh_head *head)
{
    const al_mesh *m = &head->mesh;
    uint64_t sizes[ARRAY_COUNT] = {12ull * m->vertex_count, 12ull * m->vertex_count,
                                   head->has_uv0 ? 8ull * m->vertex_count : 0,
                                   head->has_uv1 ? 8ull * m->vertex_count : 0, 4ull * m->index_count};
    geometry_layout l = {.size = 0};
    for (int i = 0; i < ARRAY_COUNT; i++) {
        l.begin[i] = al_padded(l.size);
        l.end[i] = l.size = l.begin[i] + sizes[i];
    }
    return l;
}

/* --- reading --- */

typedef struct reader {
    const al_file *file;
    al_scene *scene;
    al_report *report;
    const char *text;
    size_t text_size;
} reader;

static bool chunk_data(reader *r, const char *type, const uint8_t **bytes, size_t *size)
{
    const void *data = NULL;
    ptrdiff_t index = al_file_find(r->file, type, 0);
    assert(index >= 0); /* the kind asks for it */
    bool good = al_report_data(r->report, r->file, (size_t)index, &data, size);
    *bytes = data;
    return good;
}

static bool read_text(reader *r)
{
    const uint8_t *bytes;
    if (!chunk_data(r, "TEXT", &bytes, &r->text_size)) return false;
    r->text = (const char *)bytes;
    if (r->text_size && !r->text[r->text_size - 1]) return true;
    al_report_finding(r->report, AL_RULE_TEXT, "TEXT: does not end with a zero byte");
    return false;
}

/* Decodes exactly `count` records into memory of the scene; NULL when there are not as many or no memory. */
static void *read_records(reader *r, const al_record *record, uint32_t count)
{
    const uint8_t *bytes;
    size_t size, wanted = al_record_size(record) * (size_t)count;
    if (!chunk_data(r, record->type, &bytes, &size)) return NULL;
    if (size != wanted) {
        al_report_finding(r->report, AL_RULE_RECORD_SIZE, "%s: has %zu bytes, %" PRIu32 " records need %zu",
                          record->type, size, count, wanted);
        return NULL;
    }
    void *values = al_scene_allocate(r->scene, record->stride * (size_t)count);
    if (values)
        al_record_decode(record, bytes, count, r->text, r->text_size, values, r->report);
    else
        al_report_out_of_memory(r->report);
    return values;
}

/* The same for a chunk that may be absent and says by its size how many records it has. */
static void *read_optional_records(reader *r, const al_record *record, uint32_t *count)
{
    const uint8_t *bytes;
    size_t size, stride = al_record_size(record);
    *count = 0;
    if (al_file_find(r->file, record->type, 0) < 0) return NULL;
    if (!chunk_data(r, record->type, &bytes, &size)) return NULL;
    if (size % stride || size / stride > COUNT_LIMIT) {
        al_report_finding(r->report, AL_RULE_RECORD_SIZE, "%s: has %zu bytes, no multiple of %zu",
                          record->type, size, stride);
        return NULL;
    }
    void *values = read_records(r, record, (uint32_t)(size / stride));
    if (values) *count = (uint32_t)(size / stride);
    return values;
}

static void read_lighting(reader *r)
{
    uint32_t count;
    al_instance *read = read_optional_records(r, &lighting_record, &count);
    if (read && count != r->scene->instance_count)
        al_report_finding(r->report, AL_RULE_RECORD_SIZE,
                          "INLI: has %" PRIu32 " records, there are %" PRIu32 " instances", count,
                          r->scene->instance_count);
    else
        for (uint32_t i = 0; i < count; i++) r->scene->instances[i].lighting = read[i].lighting;
}

static void read_baked(reader *r)
{
    uint32_t count;
    const al_baked_light *read = read_optional_records(r, &baked_record, &count);
    r->scene->baked = (al_baked_light){"", ""};
    if (read && count != 1)
        al_report_finding(r->report, AL_RULE_RECORD_SIZE, "BAKD: has %" PRIu32 " records, one is right",
                          count);
    else if (read)
        r->scene->baked = *read;
}

static bool read_head(reader *r)
{
    const uint8_t *bytes;
    size_t size, wanted = al_record_size(&scene_record);
    if (!chunk_data(r, "SCEN", &bytes, &size)) return false;
    if (size != wanted) {
        al_report_finding(r->report, AL_RULE_RECORD_SIZE, "SCEN: has %zu bytes, should have %zu", size,
                          wanted);
        return false;
    }
    uint64_t before = r->report->count;
    al_record_decode(&scene_record, bytes, 1, r->text, r->text_size, r->scene, r->report);
    return r->report->count == before;
}

/* Index of the chunk behind `from` that has `type`, or -1. */
static ptrdiff_t next_chunk(const al_file *file, const char *type, ptrdiff_t from)
{
    for (size_t i = (size_t)(from + 1); i < al_file_chunk_count(file); i++)
        if (al_chunk_is(file, i, type)) return (ptrdiff_t)i;
    return -1;
}

static void check_chunk_count(reader *r, const char *type, uint32_t count, enum al_rule rule)
{
    size_t found = 0;
    for (ptrdiff_t i = next_chunk(r->file, type, -1); i >= 0; i = next_chunk(r->file, type, i)) found++;
    if (found != count)
        al_report_finding(r->report, rule, "%zu chunks %s, there should be %" PRIu32, found, type, count);
}

static void check_finite(reader *r, const float *numbers, uint64_t count, const char *owner, uint32_t index,
                         const char *what)
{
    for (uint64_t i = 0; i < count; i++)
        if (!isfinite(numbers[i])) {
            al_report_finding(r->report, AL_RULE_FINITE,
                              "%s %" PRIu32 ": number %" PRIu64 " of the %s is not finite", owner, index, i,
                              what);
            return;
        }
}

static bool is_unit(const float v[3])
{
    double square = (double)v[0] * v[0] + (double)v[1] * v[1] + (double)v[2] * v[2];
    return square >= 0.99 * 0.99 && square <= 1.01 * 1.01;
}

static void check_mesh(reader *r, const al_mesh *m, uint32_t index)
{
    check_finite(r, m->positions, 3ull * m->vertex_count, "mesh", index, "positions");
    if (m->uv0) check_finite(r, m->uv0, 2ull * m->vertex_count, "mesh", index, "uv0");
    if (m->uv1) check_finite(r, m->uv1, 2ull * m->vertex_count, "mesh", index, "uv1");
    for (uint32_t v = 0; v < m->vertex_count; v++)
        if (!is_unit(m->normals + 3 * (size_t)v)) {
            const float *n = m->normals + 3 * (size_t)v;
            al_report_finding(r->report, AL_RULE_SCENE_UNIT,
                              "mesh %" PRIu32 " (%s): normal %" PRIu32 " is (%g, %g, %g)", index, m->name, v,
                              (double)n[0], (double)n[1], (double)n[2]);
            break;
        }
    if (m->index_count % 3)
        al_report_finding(r->report, AL_RULE_SCENE_TRIANGLES, "mesh %" PRIu32 " (%s): %" PRIu32 " indices",
                          index, m->name, m->index_count);
    for (uint32_t i = 0; i < m->index_count; i++)
        if (m->indices[i] >= m->vertex_count) {
            al_report_finding(r->report, AL_RULE_SCENE_INDEX,
                              "mesh %" PRIu32 " (%s): index %" PRIu32 " names vertex %" PRIu32 " of %" PRIu32,
                              index, m->name, i, m->indices[i], m->vertex_count);
            break;
        }
}

/* The file is mapped for reading only; al_scene's arrays are writable for those who fill one. */
static void *in_place(const uint8_t *bytes, uint64_t offset)
{
    return (void *)(uintptr_t)(bytes + offset);
}

static void read_geometry(reader *r, const mesh_head *head, uint32_t index, ptrdiff_t chunk)
{
    al_mesh *m = &r->scene->meshes[index];
    geometry_layout l = layout_of(head);
    const void *data;
    size_t size;
    if (!al_report_data(r->report, r->file, (size_t)chunk, &data, &size)) return;
    if (size != l.size) {
        al_report_finding(r->report, AL_RULE_SCENE_GEOMETRY_SIZE,
                          "mesh %" PRIu32 " (%s): its chunk GEOM has %zu bytes, it needs %" PRIu64, index,
                          m->name, size, l.size);
        return;
    }
    const uint8_t *bytes = data;
    for (int i = 1; i < ARRAY_COUNT; i++)
        if (!al_all_zero(bytes + l.end[i - 1], l.begin[i] - l.end[i - 1])) {
            al_report_finding(r->report, AL_RULE_SCENE_GEOMETRY_PADDING,
                              "mesh %" PRIu32 " (%s): bytes between its arrays are not zero", index, m->name);
            break;
        }
    m->positions = in_place(bytes, l.begin[POSITIONS]);
    m->normals = in_place(bytes, l.begin[NORMALS]);
    m->uv0 = head->has_uv0 ? in_place(bytes, l.begin[UV0]) : NULL;
    m->uv1 = head->has_uv1 ? in_place(bytes, l.begin[UV1]) : NULL;
    m->indices = in_place(bytes, l.begin[INDICES]);
    check_mesh(r, m, index);
}

static void check_submeshes(reader *r, const al_mesh *m, uint32_t index)
{
    for (uint32_t s = 0; s < m->submesh_count; s++) {
        const al_submesh *part = &m->submeshes[s];
        if (part->first_index % 3 || part->index_count % 3 ||
            (uint64_t)part->first_index + part->index_count > m->index_count)
            al_report_finding(r->report, AL_RULE_SCENE_SUBMESHES,
                              "mesh %" PRIu32 " (%s), submesh %" PRIu32 ": %" PRIu32 " indices from %" PRIu32
                              " on, of %" PRIu32,
                              index, m->name, s, part->index_count, part->first_index, m->index_count);
        if (part->material >= r->scene->material_count)
            al_report_finding(r->report, AL_RULE_SCENE_INDEX,
                              "mesh %" PRIu32 " (%s), submesh %" PRIu32 ": names material %" PRIu32
                              " of %" PRIu32,
                              index, m->name, s, part->material, r->scene->material_count);
    }
}

static bool deal_submeshes(reader *r, const mesh_head *heads)
{
    uint64_t total = 0, next = 0;
    for (uint32_t i = 0; i < r->scene->mesh_count; i++) total += heads[i].mesh.submesh_count;
    if (total > COUNT_LIMIT) {
        al_report_finding(r->report, AL_RULE_SCENE_SUBMESHES, "the meshes have %" PRIu64 " submeshes", total);
        return false;
    }
    al_submesh *all = read_records(r, &submesh_record, (uint32_t)total);
    if (!all) return false;
    for (uint32_t i = 0; i < r->scene->mesh_count; i++) {
        r->scene->meshes[i].submeshes = all + next;
        next += heads[i].mesh.submesh_count;
        check_submeshes(r, &r->scene->meshes[i], i);
    }
    return true;
}

static bool read_meshes(reader *r)
{
    al_scene *scene = r->scene;
    mesh_head *heads = read_records(r, &mesh_record, scene->mesh_count);
    scene->meshes = heads ? al_scene_allocate(scene, scene->mesh_count * sizeof *scene->meshes) : NULL;
    if (heads && !scene->meshes) al_report_out_of_memory(r->report);
    if (!scene->meshes) return false;
    for (uint32_t i = 0; i < scene->mesh_count; i++) scene->meshes[i] = heads[i].mesh;
    if (!deal_submeshes(r, heads)) return false;
    check_chunk_count(r, "GEOM", scene->mesh_count, AL_RULE_SCENE_GEOMETRY_COUNT);
    ptrdiff_t chunk = -1;
    for (uint32_t i = 0; i < scene->mesh_count && (chunk = next_chunk(r->file, "GEOM", chunk)) >= 0; i++)
        read_geometry(r, &heads[i], i, chunk);
    return true;
}

static bool read_textures(reader *r)
{
    al_scene *scene = r->scene;
    const void *data;
    size_t size;
    ptrdiff_t chunk = -1;
    uint64_t before = r->report->count;
    scene->textures = read_records(r, &texture_record, scene->texture_count);
    if (!scene->textures || r->report->count != before) return false;
    check_chunk_count(r, "PIXL", scene->texture_count, AL_RULE_SCENE_PIXEL_COUNT);
    for (uint32_t i = 0; i < scene->texture_count && (chunk = next_chunk(r->file, "PIXL", chunk)) >= 0; i++) {
        al_texture *t = &scene->textures[i];
        uint64_t wanted = 4ull * t->width * t->height;
        if (!al_report_data(r->report, r->file, (size_t)chunk, &data, &size)) continue;
        if (size == wanted)
            t->pixels = in_place(data, 0);
        else
            al_report_finding(r->report, AL_RULE_SCENE_PIXEL_SIZE,
                              "texture %" PRIu32 " (%s): its chunk PIXL has %zu bytes, it needs %" PRIu64, i,
                              t->name, size, wanted);
    }
    return true;
}

static void read_environment(reader *r)
{
    al_environment *e = &r->scene->environment;
    ptrdiff_t chunk = al_file_find(r->file, "ENVM", 0);
    const void *data = NULL;
    size_t size = 0;
    uint64_t wanted = 12ull * e->width * e->height;
    if (chunk >= 0 && !al_report_data(r->report, r->file, (size_t)chunk, &data, &size)) return;
    if ((e->width == 0) != (e->height == 0) || (chunk >= 0) != (wanted > 0) || size != wanted) {
        al_report_finding(r->report, AL_RULE_SCENE_ENVIRONMENT,
                          "%" PRIu32 " x %" PRIu32 " pixels need %" PRIu64 " bytes, chunk ENVM %s %zu",
                          e->width, e->height, wanted, chunk >= 0 ? "has" : "is missing:", size);
        return;
    }
    e->pixels = data ? in_place(data, 0) : NULL;
    for (uint64_t i = 0; i < wanted / 4; i++)
        if (!(e->pixels[i] >= 0 && e->pixels[i] <= FLT_MAX)) {
            al_report_finding(r->report, isfinite(e->pixels[i]) ? AL_RULE_RANGE : AL_RULE_FINITE,
                              "environment: number %" PRIu64 " is %g", i, (double)e->pixels[i]);
            return;
        }
}

static void check_index(reader *r, uint32_t index, uint32_t count, const char *owner, uint32_t number,
                        const char *what)
{
    if (index >= count)
        al_report_finding(r->report, AL_RULE_SCENE_INDEX, "%s %" PRIu32 ": names %s %" PRIu32 " of %" PRIu32,
                          owner, number, what, index, count);
}

static void check_materials(reader *r)
{
    for (uint32_t i = 0; i < r->scene->material_count; i++) {
        const al_material *m = &r->scene->materials[i];
        uint32_t textures[] = {m->base_color_texture, m->emission_texture, m->metallic_roughness_texture,
                               m->normal_texture};
        for (size_t t = 0; t < COUNT_OF(textures); t++)
            if (textures[t] != AL_NO_INDEX)
                check_index(r, textures[t], r->scene->texture_count, "material", i, "texture");
    }
}

static void check_instances(reader *r)
{
    const al_scene *s = r->scene;
    for (uint32_t i = 0; i < s->instance_count; i++) {
        const al_instance *in = &s->instances[i];
        check_index(r, in->mesh, s->mesh_count, "instance", i, "mesh");
        if ((in->role == AL_ROLE_OPAQUE) != (in->translucent == AL_NO_INDEX))
            al_report_finding(r->report, AL_RULE_SCENE_ROLE,
                              "instance %" PRIu32 " (%s): role %" PRIu32 " with translucent object %" PRIu32,
                              i, in->name, in->role, in->translucent);
        else if (in->role != AL_ROLE_OPAQUE)
            check_index(r, in->translucent, s->translucent_count, "instance", i, "translucent object");
        if (in->lighting != AL_LIGHTING_DYNAMIC && in->role != AL_ROLE_OPAQUE)
            al_report_finding(r->report, AL_RULE_SCENE_LIGHTING,
                              "instance %" PRIu32 " (%s): role %" PRIu32 " with lighting %" PRIu32, i,
                              in->name, in->role, in->lighting);
        const float *w = in->world;
        if (w[3] != 0 || w[7] != 0 || w[11] != 0 || w[15] != 1)
            al_report_finding(r->report, AL_RULE_SCENE_AFFINE,
                              "instance %" PRIu32 " (%s): the last row is %g %g %g %g", i, in->name,
                              (double)w[3], (double)w[7], (double)w[11], (double)w[15]);
    }
}

static bool is_plain_name(const char *name)
{
    if (!strcmp(name, ".") || !strcmp(name, "..")) return false;
    for (const char *c = name; *c; c++)
        if (*c == '/' || *c == '\\' || (unsigned char)*c < 0x20) return false;
    return true;
}

static void check_asset(reader *r, const char *asset, const char *owner, uint32_t index)
{
    if (!is_plain_name(asset))
        al_report_finding(r->report, AL_RULE_SCENE_ASSET,
                          "%s %" PRIu32 ": the asset's name holds a folder or a control character", owner,
                          index);
}

static void check_translucents(reader *r)
{
    const al_scene *s = r->scene;
    for (uint32_t i = 0; i < s->translucent_count; i++) {
        const al_translucent_object *t = &s->translucents[i];
        check_index(r, t->instance, s->instance_count, "translucent object", i, "instance");
        check_index(r, t->medium, s->medium_count, "translucent object", i, "medium");
        if (t->instance < s->instance_count && (s->instances[t->instance].role != AL_ROLE_TRANSLUCENT ||
                                                s->instances[t->instance].translucent != i))
            al_report_finding(r->report, AL_RULE_SCENE_BOUNDARY,
                              "translucent object %" PRIu32 " (%s): instance %" PRIu32 " is not its boundary",
                              i, t->name, t->instance);
        check_asset(r, t->asset, "translucent object", i);
    }
}

static void check_fogs(reader *r)
{
    for (uint32_t i = 0; i < r->scene->fog_count; i++) {
        const al_fog *f = &r->scene->fogs[i];
        bool good = true;
        for (int k = 0; k < 3; k++)
            good = good && (f->bounded ? f->bounds_min_m[k] < f->bounds_max_m[k]
                                       : f->bounds_min_m[k] == 0 && f->bounds_max_m[k] == 0);
        if (!good)
            al_report_finding(r->report, AL_RULE_SCENE_FOG, "fog %" PRIu32 ": its bounds are no box", i);
        check_index(r, f->medium, r->scene->medium_count, "fog", i, "medium");
        check_asset(r, f->asset, "fog", i);
    }
}

static void check_lights_and_cameras(reader *r)
{
    const al_scene *s = r->scene;
    for (uint32_t i = 0; i < s->light_count; i++)
        if (s->lights[i].type == AL_LIGHT_DIRECTIONAL && !is_unit(s->lights[i].vector))
            al_report_finding(r->report, AL_RULE_SCENE_UNIT,
                              "light %" PRIu32 " (%s): its direction is not of unit length", i,
                              s->lights[i].name);
    for (uint32_t i = 0; i < s->camera_count; i++) {
        const al_camera *c = &s->cameras[i];
        bool on_target = c->position[0] == c->target[0] && c->position[1] == c->target[1] &&
                         c->position[2] == c->target[2];
        if (on_target || (c->up[0] == 0 && c->up[1] == 0 && c->up[2] == 0))
            al_report_finding(r->report, AL_RULE_SCENE_CAMERA, "camera %" PRIu32 " (%s): %s", i, c->name,
                              on_target ? "stands on its target" : "has no up direction");
    }
    if (!s->camera_count) al_report_finding(r->report, AL_RULE_SCENE_CAMERAS, "there is no camera");
}

/* Not checked where a record is wrong: what follows relies on them. */
static void read_motion(reader *r)
{
    al_motion *m = &r->scene->motion;
    uint64_t before = r->report->count;
    m->nodes = read_optional_records(r, &node_record, &m->node_count);
    m->channels = read_optional_records(r, &channel_record, &m->channel_count);
    m->bindings = read_optional_records(r, &binding_record, &m->binding_count);
    m->joints = read_optional_records(r, &joint_record, &m->joint_count);
    m->deforms = read_optional_records(r, &deform_record, &m->deform_count);
    if (r->report->count == before) al_motion_check(r->file, r->scene, r->report);
}

/* Reads everything and checks it; what goes on after a finding only does so where it is safe. */
static void read_scene(const al_file *file, al_scene *scene, al_report *report)
{
    reader r = {.file = file, .scene = scene, .report = report};
    if (!read_text(&r) || !read_head(&r)) return;
    bool good = read_textures(&r);
    scene->materials = read_records(&r, &material_record, scene->material_count);
    good = scene->materials && good;
    good = read_meshes(&r) && good;
    scene->instances = read_records(&r, &instance_record, scene->instance_count);
    scene->media = read_records(&r, &medium_record, scene->medium_count);
    scene->translucents = read_records(&r, &translucent_record, scene->translucent_count);
    scene->lights = read_records(&r, &light_record, scene->light_count);
    scene->cameras = read_records(&r, &camera_record, scene->camera_count);
    scene->fogs = read_optional_records(&r, &fog_record, &scene->fog_count);
    for (uint32_t i = 0; i < scene->fog_count; i++)
        for (int k = 0; k < 16; k++) scene->fogs[i].moved[k] = k % 5 == 0;
    read_baked(&r);
    read_environment(&r);
    if (!good || !scene->instances || !scene->media || !scene->translucents || !scene->lights ||
        !scene->cameras)
        return;
    read_lighting(&r);
    check_materials(&r);
    check_instances(&r);
    check_translucents(&r);
    check_fogs(&r);
    check_asset(&r, scene->baked.lightmap, "lightmap", 0);
    check_asset(&r, scene->baked.probes, "probes", 0);
    check_lights_and_cameras(&r);
    read_motion(&r);
}

al_status al_scene_read(const al_file *file, al_scene *scene, al_error *error)
{
    *scene = (al_scene){0};
    if (al_file_kind(file) != AL_KIND_SCENE)
        return al_fail(error, AL_BAD_INPUT, "%s: is an asset of kind %s, wanted is scene", al_file_name(file),
                       al_kind_name(al_file_kind(file)));
    al_report report = {.name = al_file_name(file), .error = error};
    read_scene(file, scene, &report);
    if (report.status != AL_OK) al_scene_free(scene);
    return report.status;
}

static void check_scene(const al_file *file, al_report *report)
{
    al_scene scene = {0};
    read_scene(file, &scene, report);
    al_scene_free(&scene);
}

const al_kind_rules al_scene_rules = {AL_KIND_SCENE, "scene", chunks, COUNT_OF(chunks), check_scene};

/* --- writing --- */

typedef struct encoded {
    const al_record *record;
    const void *values;
    size_t count;
    uint8_t *bytes;
} encoded;

/* What is stored of the meshes besides their arrays; free() both. */
static bool gather_meshes(const al_scene *scene, mesh_head **heads, al_submesh **submeshes,
                          size_t *submesh_count)
{
    size_t next = 0;
    *submesh_count = 0;
    for (uint32_t i = 0; i < scene->mesh_count; i++) *submesh_count += scene->meshes[i].submesh_count;
    *heads = calloc(scene->mesh_count + (size_t)1, sizeof **heads);
    *submeshes = calloc(*submesh_count + 1, sizeof **submeshes);
    if (!*heads || !*submeshes) return false;
    for (uint32_t i = 0; i < scene->mesh_count; i++) {
        const al_mesh *m = &scene->meshes[i];
        (*heads)[i] = (mesh_head){*m, m->uv0 != NULL, m->uv1 != NULL};
        if (m->submesh_count) memcpy(*submeshes + next, m->submeshes, m->submesh_count * sizeof **submeshes);
        next += m->submesh_count;
    }
    return true;
}

static al_status add_geometry(al_writer *writer, const char *path, const mesh_head *head, al_error *error)
{
    const al_mesh *m = &head->mesh;
    const void *arrays[ARRAY_COUNT] = {m->positions, m->normals, m->uv0, m->uv1, m->indices};
    geometry_layout l = layout_of(head);
    uint8_t *bytes = calloc(1, l.size + 1);
    if (!bytes) return al_fail(error, AL_IO, "%s: out of memory for mesh %s", path, m->name);
    for (int i = 0; i < ARRAY_COUNT; i++)
        if (l.end[i] > l.begin[i]) memcpy(bytes + l.begin[i], arrays[i], l.end[i] - l.begin[i]);
    al_status status = al_writer_add(writer, "GEOM", 1, 0, bytes, l.size, error);
    free(bytes);
    return status;
}

static al_status add_arrays(al_writer *writer, const char *path, const al_scene *scene,
                            const mesh_head *heads, al_error *error)
{
    al_status status = AL_OK;
    const al_environment *e = &scene->environment;
    for (uint32_t i = 0; i < scene->mesh_count && status == AL_OK; i++)
        status = add_geometry(writer, path, &heads[i], error);
    for (uint32_t i = 0; i < scene->texture_count && status == AL_OK; i++) {
        const al_texture *t = &scene->textures[i];
        status = al_writer_add(writer, "PIXL", 1, 0, t->pixels, (size_t)t->width * t->height * 4, error);
    }
    if (status == AL_OK && e->width && e->height)
        status = al_writer_add(writer, "ENVM", 1, 0, e->pixels, (size_t)e->width * e->height * 12, error);
    return status;
}

static bool is_lit_by_bakes(const al_scene *scene)
{
    for (uint32_t i = 0; i < scene->instance_count; i++)
        if (scene->instances[i].lighting != AL_LIGHTING_DYNAMIC) return true;
    return false;
}

static al_status encode(const char *path, encoded *chunk, al_text_table *texts, al_error *error)
{
    chunk->bytes = malloc(al_record_size(chunk->record) * chunk->count + 1);
    if (chunk->bytes && al_record_encode(chunk->record, chunk->values, chunk->count, texts, chunk->bytes))
        return AL_OK;
    return al_fail(error, AL_IO, "%s: out of memory for chunk %s", path, chunk->record->type);
}

/* Chunks that the kind may lack: left out where they would say nothing. */
static bool is_optional(const char *type)
{
    return al_chunk_find(&al_scene_rules, type)->minimum == 0;
}

/* Texts are complete once all records are encoded, so TEXT follows them. */
static al_status add_records(al_writer *writer, const char *path, encoded *all, size_t count, al_error *error)
{
    al_text_table texts = {0};
    al_status status = AL_OK;
    for (size_t i = 0; i < count && status == AL_OK; i++) {
        bool optional = is_optional(all[i].record->type);
        if (optional && !all[i].count) continue;
        status = encode(path, &all[i], &texts, error);
        if (status == AL_OK)
            status = al_writer_add(writer, all[i].record->type, 1, optional ? AL_CHUNK_OPTIONAL : 0,
                                   all[i].bytes, al_record_size(all[i].record) * all[i].count, error);
        free(all[i].bytes);
    }
    if (status == AL_OK)
        status = al_writer_add(writer, "TEXT", 1, 0, texts.size ? texts.bytes : "",
                               texts.size ? texts.size : 1, error);
    free(texts.bytes);
    return status;
}

al_status al_scene_write(const char *path, const al_scene *scene, const char *provenance_json,
                         uint64_t *bytes, al_error *error)
{
    al_writer *writer = NULL;
    mesh_head *heads = NULL;
    al_submesh *submeshes = NULL;
    size_t submesh_count = 0;
    al_status status;
    al_baked_light baked = {scene->baked.lightmap ? scene->baked.lightmap : "",
                            scene->baked.probes ? scene->baked.probes : ""};
    if (bytes) *bytes = 0;
    if (!gather_meshes(scene, &heads, &submeshes, &submesh_count)) {
        status = al_fail(error, AL_IO, "%s: out of memory", path);
        goto cleanup;
    }
    encoded all[] = {
        {&scene_record, scene, 1, NULL},
        {&texture_record, scene->textures, scene->texture_count, NULL},
        {&material_record, scene->materials, scene->material_count, NULL},
        {&mesh_record, heads, scene->mesh_count, NULL},
        {&submesh_record, submeshes, submesh_count, NULL},
        {&instance_record, scene->instances, scene->instance_count, NULL},
        {&medium_record, scene->media, scene->medium_count, NULL},
        {&translucent_record, scene->translucents, scene->translucent_count, NULL},
        {&light_record, scene->lights, scene->light_count, NULL},
        {&camera_record, scene->cameras, scene->camera_count, NULL},
        {&lighting_record, scene->instances, is_lit_by_bakes(scene) ? scene->instance_count : 0, NULL},
        {&fog_record, scene->fogs, scene->fog_count, NULL},
        {&baked_record, &baked, *baked.lightmap || *baked.probes, NULL},
        {&node_record, scene->motion.nodes, scene->motion.node_count, NULL},
        {&channel_record, scene->motion.channels, scene->motion.channel_count, NULL},
        {&binding_record, scene->motion.bindings, scene->motion.binding_count, NULL},
        {&joint_record, scene->motion.joints, scene->motion.joint_count, NULL},
        {&deform_record, scene->motion.deforms, scene->motion.deform_count, NULL},
    };
    status = al_writer_open(path, AL_KIND_SCENE, &writer, error);
    if (status == AL_OK) status = add_records(writer, path, all, COUNT_OF(all), error);
    if (status == AL_OK) status = add_arrays(writer, path, scene, heads, error);
    if (status == AL_OK) status = al_motion_add(writer, path, scene, error);
    if (status == AL_OK && provenance_json)
        status = al_writer_add(writer, "PROV", 1, AL_CHUNK_OPTIONAL, provenance_json, strlen(provenance_json),
                               error);
    if (status == AL_OK) {
        status = al_writer_commit(writer, bytes, error);
        writer = NULL;
    }
cleanup:
    al_writer_discard(writer);
    free(heads);
    free(submeshes);
    return status;
}
