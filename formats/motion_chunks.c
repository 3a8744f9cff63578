#include "motion_chunks.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kinds.h"
#include "layout.h"

/* --- sizes; below 2^31 of everything that is multiplied, so that 64 bits hold twofold products --- */

static uint64_t channel_floats(const al_motion_channel *c)
{
    return (uint64_t)c->key_count * (1 + (uint64_t)c->width * (c->interpolation == AL_MOTION_CUBIC ? 3 : 1));
}

enum { BIND_POSITIONS, BIND_NORMALS, JOINTS, WEIGHTS, POSITION_DELTAS, NORMAL_DELTAS, ARRAY_COUNT };

typedef struct shape_layout { /* arrays at multiples of 64 in SHAP */
    uint64_t begin[ARRAY_COUNT], end[ARRAY_COUNT];
    uint64_t size;
} shape_layout;

static shape_layout layout_of(const al_motion_deform *d, uint32_t vertex_count)
{
    uint64_t v = vertex_count, deltas = 12 * v * d->target_count;
    uint64_t sizes[ARRAY_COUNT] = {12 * v, 12 * v, d->joint_count ? 8 * v : 0, d->joint_count ? 16 * v : 0, deltas,
                                   d->has_normals ? deltas : 0};
    shape_layout l = {.size = 0};
    for (int i = 0; i < ARRAY_COUNT; i++) {
        l.begin[i] = al_padded(l.size);
        l.end[i] = l.size = l.begin[i] + sizes[i];
    }
    return l;
}

/* --- checking --- */

static void *in_place(const void *bytes, uint64_t offset)
{
    return (void *)(uintptr_t)((const uint8_t *)bytes + offset);
}

static bool all_finite(const float *numbers, uint64_t count)
{
    for (uint64_t i = 0; i < count; i++)
        if (!isfinite(numbers[i])) return false;
    return true;
}

static bool is_affine(const float m[16])
{
    return m[3] == 0 && m[7] == 0 && m[11] == 0 && m[15] == 1;
}

static void check_matrix(const float m[16], const char *owner, uint32_t index, al_report *report)
{
    if (!is_affine(m))
        al_report_finding(report, AL_RULE_SCENE_AFFINE, "%s %" PRIu32 ": the last row is %g %g %g %g", owner, index,
                          (double)m[3], (double)m[7], (double)m[11], (double)m[15]);
}

static void check_index(uint32_t index, uint32_t count, const char *owner, uint32_t number, const char *what,
                        al_report *report)
{
    if (index >= count)
        al_report_finding(report, AL_RULE_SCENE_INDEX, "%s %" PRIu32 ": names %s %" PRIu32 " of %" PRIu32, owner,
                          number, what, index, count);
}

static void check_nodes(const al_motion *m, al_report *report)
{
    for (uint32_t i = 0; i < m->node_count; i++) {
        const al_motion_node *n = &m->nodes[i];
        check_matrix(n->matrix, "node", i, report);
        if (n->parent != AL_NO_INDEX && n->parent >= i)
            al_report_finding(report, AL_RULE_SCENE_NODE_ORDER, "node %" PRIu32 " (%s): its parent is %" PRIu32, i,
                              n->name, n->parent);
    }
    for (uint32_t i = 0; i < m->joint_count; i++) {
        check_matrix(m->joints[i].inverse_bind, "joint", i, report);
        check_index(m->joints[i].node, m->node_count, "joint", i, "node", report);
    }
}

static void check_bindings(const al_scene *scene, al_report *report)
{
    const al_motion *m = &scene->motion;
    const uint32_t counts[] = {scene->instance_count, scene->light_count, scene->camera_count, scene->fog_count};
    static const char *const names[] = {"instance", "light", "camera", "fog"};
    for (uint32_t i = 0; i < m->binding_count; i++) {
        const al_motion_binding *b = &m->bindings[i], *before = i ? b - 1 : NULL;
        check_index(b->index, counts[b->kind], "binding", i, names[b->kind], report);
        check_index(b->node, m->node_count, "binding", i, "node", report);
        check_matrix(b->local, "binding", i, report);
        if (before && (b->kind < before->kind || (b->kind == before->kind && b->index <= before->index)))
            al_report_finding(report, AL_RULE_SCENE_BINDING_ORDER,
                              "binding %" PRIu32 ": %s %" PRIu32 " does not follow the one before", i, names[b->kind],
                              b->index);
    }
}

static void check_channel(const al_motion_channel *c, uint32_t i, const al_motion *m, al_report *report)
{
    const al_motion_channel *before = i ? c - 1 : NULL;
    static const uint32_t widths[] = {3, 4, 3};
    check_index(c->node, m->node_count, "channel", i, "node", report);
    if ((before && (c->node < before->node || (c->node == before->node && c->path <= before->path))) ||
        (c->path < AL_MOTION_WEIGHTS && c->width != widths[c->path]))
        al_report_finding(report, AL_RULE_SCENE_CHANNEL,
                          "channel %" PRIu32 ": property %" PRIu32 " of node %" PRIu32 " with %" PRIu32 " numbers", i,
                          c->path, c->node, c->width);
    for (uint32_t k = 0; k < c->key_count && c->times_s; k++)
        if (!(c->times_s[k] >= 0) || (k && !(c->times_s[k] > c->times_s[k - 1]))) {
            al_report_finding(report, AL_RULE_SCENE_KEY_TIMES, "channel %" PRIu32 ": key %" PRIu32 " is at %g s", i, k,
                              (double)c->times_s[k]);
            return;
        }
}

/* The channels' floats, one channel after the other. */
static void find_keys(const al_file *file, al_motion *m, al_report *report)
{
    uint64_t floats = 0;
    const void *data = NULL;
    size_t size = 0;
    ptrdiff_t chunk = al_file_find(file, "KEYS", 0);
    for (uint32_t i = 0; i < m->channel_count; i++) {
        uint64_t more = channel_floats(&m->channels[i]);
        floats = more > UINT64_MAX / 8 - floats ? UINT64_MAX / 8 : floats + more;
    }
    if (chunk >= 0 && !al_report_data(report, file, (size_t)chunk, &data, &size)) return;
    if (size != 4 * floats) {
        al_report_finding(report, AL_RULE_SCENE_KEYS, "KEYS: has %zu bytes, the channels need %" PRIu64, size,
                          4 * floats);
        return;
    }
    float *at = in_place(data, 0);
    if (!all_finite(at, floats)) al_report_finding(report, AL_RULE_FINITE, "KEYS: a number is not finite");
    for (uint32_t i = 0; i < m->channel_count; i++) {
        m->channels[i].times_s = at;
        m->channels[i].values = at + m->channels[i].key_count;
        at += channel_floats(&m->channels[i]);
    }
}

static void check_joints(const al_motion_deform *d, uint32_t vertex_count, uint32_t index, al_report *report)
{
    for (size_t v = 0; v < vertex_count && d->joint_count; v++) {
        const uint16_t *j = d->joints + 4 * v;
        const float *w = d->weights + 4 * v;
        float sum = w[0] + w[1] + w[2] + w[3];
        bool good = sum >= 0.99f && sum <= 1.01f;
        for (int k = 0; k < 4; k++) good = good && j[k] < d->joint_count && w[k] >= 0;
        if (good) continue;
        al_report_finding(report, AL_RULE_SCENE_JOINTS,
                          "deform %" PRIu32 ": vertex %zu has the joints %u %u %u %u of %" PRIu32
                          " with weights %g %g %g %g",
                          index, v, j[0], j[1], j[2], j[3], d->joint_count, (double)w[0], (double)w[1], (double)w[2],
                          (double)w[3]);
        return;
    }
}

static bool is_unit(const float *v)
{
    double square = (double)v[0] * v[0] + (double)v[1] * v[1] + (double)v[2] * v[2];
    return square >= 0.99 * 0.99 && square <= 1.01 * 1.01;
}

static void find_shape(const al_file *file, const al_scene *scene, uint32_t index, al_report *report)
{
    al_motion_deform *d = &scene->motion.deforms[index];
    uint32_t vertex_count = scene->meshes[scene->instances[d->instance].mesh].vertex_count;
    shape_layout l = layout_of(d, vertex_count);
    const void *data;
    size_t size;
    ptrdiff_t chunk = al_file_find(file, "SHAP", index);
    if (chunk < 0 || !al_report_data(report, file, (size_t)chunk, &data, &size)) return;
    if (size != l.size) {
        al_report_finding(report, AL_RULE_SCENE_SHAPE,
                          "deform %" PRIu32 ": its chunk SHAP has %zu bytes, it needs %" PRIu64, index, size, l.size);
        return;
    }
    for (int i = 1; i < ARRAY_COUNT; i++)
        if (!al_all_zero((const uint8_t *)data + l.end[i - 1], l.begin[i] - l.end[i - 1])) {
            al_report_finding(report, AL_RULE_SCENE_SHAPE, "deform %" PRIu32 ": bytes between its arrays are not zero",
                              index);
            break;
        }
    d->bind_positions = in_place(data, l.begin[BIND_POSITIONS]);
    d->bind_normals = in_place(data, l.begin[BIND_NORMALS]);
    d->joints = d->joint_count ? in_place(data, l.begin[JOINTS]) : NULL;
    d->weights = d->joint_count ? in_place(data, l.begin[WEIGHTS]) : NULL;
    d->position_deltas = d->target_count ? in_place(data, l.begin[POSITION_DELTAS]) : NULL;
    d->normal_deltas = d->has_normals ? in_place(data, l.begin[NORMAL_DELTAS]) : NULL;
    uint64_t deltas = 3ull * vertex_count * d->target_count;
    if (!all_finite(d->bind_positions, 3ull * vertex_count) ||
        (d->position_deltas && !all_finite(d->position_deltas, deltas)) ||
        (d->normal_deltas && !all_finite(d->normal_deltas, deltas)))
        al_report_finding(report, AL_RULE_FINITE, "deform %" PRIu32 ": a number is not finite", index);
    for (size_t v = 0; v < vertex_count; v++)
        if (!is_unit(d->bind_normals + 3 * v)) {
            al_report_finding(report, AL_RULE_SCENE_UNIT, "deform %" PRIu32 ": normal %zu is not of unit length", index,
                              v);
            break;
        }
    check_joints(d, vertex_count, index, report);
}

static uint32_t mesh_users(const al_scene *scene, uint32_t mesh)
{
    uint32_t users = 0;
    for (uint32_t i = 0; i < scene->instance_count; i++) users += scene->instances[i].mesh == mesh;
    return users;
}

static bool check_deform(const al_scene *scene, uint32_t index, al_report *report)
{
    const al_motion *m = &scene->motion;
    const al_motion_deform *d = &m->deforms[index];
    check_index(d->instance, scene->instance_count, "deform", index, "instance", report);
    if (d->node != AL_NO_INDEX) check_index(d->node, m->node_count, "deform", index, "node", report);
    if ((uint64_t)d->first_joint + d->joint_count > m->joint_count || d->joint_count > UINT16_MAX + 1)
        al_report_finding(report, AL_RULE_SCENE_INDEX,
                          "deform %" PRIu32 ": %" PRIu32 " joints from %" PRIu32 " on, of %" PRIu32, index,
                          d->joint_count, d->first_joint, m->joint_count);
    if (d->instance >= scene->instance_count) return false;
    const al_instance *instance = &scene->instances[d->instance];
    if (instance->role != AL_ROLE_OPAQUE || instance->lighting == AL_LIGHTING_LIGHTMAP ||
        instance->mesh >= scene->mesh_count || mesh_users(scene, instance->mesh) != 1 ||
        (index && d->instance <= m->deforms[index - 1].instance))
        al_report_finding(report, AL_RULE_SCENE_DEFORM,
                          "deform %" PRIu32 ": instance %" PRIu32 " (%s) has another role, a lightmap, a shared mesh or "
                          "does not follow the one before",
                          index, d->instance, instance->name);
    return instance->mesh < scene->mesh_count;
}

static void check_deforms(const al_file *file, al_scene *scene, al_report *report)
{
    size_t chunks = 0;
    for (size_t i = 0; i < al_file_chunk_count(file); i++) chunks += al_chunk_is(file, i, "SHAP");
    if (chunks != scene->motion.deform_count)
        al_report_finding(report, AL_RULE_SCENE_SHAPE, "%zu chunks SHAP, there should be %" PRIu32, chunks,
                          scene->motion.deform_count);
    for (uint32_t i = 0; i < scene->motion.deform_count; i++)
        if (check_deform(scene, i, report)) find_shape(file, scene, i, report);
}

void al_motion_check(const al_file *file, al_scene *scene, al_report *report)
{
    al_motion *m = &scene->motion;
    check_nodes(m, report);
    check_bindings(scene, report);
    find_keys(file, m, report);
    for (uint32_t i = 0; i < m->channel_count; i++) check_channel(&m->channels[i], i, m, report);
    check_deforms(file, scene, report);
}

/* --- writing --- */

static al_status add_keys(al_writer *writer, const char *path, const al_motion *m, al_error *error)
{
    uint64_t floats = 0;
    for (uint32_t i = 0; i < m->channel_count; i++) floats += channel_floats(&m->channels[i]);
    if (!floats) return AL_OK;
    float *all = malloc(floats * sizeof *all), *at = all;
    if (!all) return al_fail(error, AL_IO, "%s: out of memory for %" PRIu64 " numbers of its keys", path, floats);
    for (uint32_t i = 0; i < m->channel_count; i++) {
        const al_motion_channel *c = &m->channels[i];
        size_t values = (size_t)channel_floats(c) - c->key_count;
        memcpy(at, c->times_s, c->key_count * sizeof *at);
        memcpy(at + c->key_count, c->values, values * sizeof *at);
        at += c->key_count + values;
    }
    al_status status = al_writer_add(writer, "KEYS", 1, AL_CHUNK_OPTIONAL, all, floats * sizeof *all, error);
    free(all);
    return status;
}

static al_status add_shape(al_writer *writer, const char *path, const al_motion_deform *d, uint32_t vertex_count,
                           al_error *error)
{
    const void *arrays[ARRAY_COUNT] = {d->bind_positions, d->bind_normals,    d->joints,
                                       d->weights,        d->position_deltas, d->normal_deltas};
    shape_layout l = layout_of(d, vertex_count);
    uint8_t *bytes = calloc(1, l.size + 1);
    if (!bytes) return al_fail(error, AL_IO, "%s: out of memory for a deformed mesh", path);
    for (int i = 0; i < ARRAY_COUNT; i++)
        if (l.end[i] > l.begin[i]) memcpy(bytes + l.begin[i], arrays[i], l.end[i] - l.begin[i]);
    al_status status = al_writer_add(writer, "SHAP", 1, AL_CHUNK_OPTIONAL, bytes, l.size, error);
    free(bytes);
    return status;
}

al_status al_motion_add(al_writer *writer, const char *path, const al_scene *scene, al_error *error)
{
    al_status status = add_keys(writer, path, &scene->motion, error);
    for (uint32_t i = 0; i < scene->motion.deform_count && status == AL_OK; i++) {
        const al_motion_deform *d = &scene->motion.deforms[i];
        status = add_shape(writer, path, d, scene->meshes[scene->instances[d->instance].mesh].vertex_count, error);
    }
    return status;
}
