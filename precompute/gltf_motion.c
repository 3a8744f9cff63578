#include "gltf_motion.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "motion_import.h"

enum { DEPTH_LIMIT = 512, WHAT_ROOM = 96, INFLUENCES = 4, TARGET_LIMIT = 65536 };

typedef struct source_channel { /* which of the file moves a property; animation AL_NO_INDEX: none */
    uint32_t animation, channel;
} source_channel;

typedef struct vertices { /* of the deformed mesh being gathered, one after the other as in the file */
    uint32_t count, target_count;
    bool has_normals;
    float *joints, *weights;                /* [count][4] */
    float *position_deltas, *normal_deltas; /* [count][target_count][3] */
} vertices;

struct al_gltf_motion {
    al_import *import;
    al_gltf *file;
    const char *name;
    double placement[16];
    uint32_t parent, node_count;
    uint32_t *parents;              /* [node_count] AL_NO_INDEX: a root */
    uint32_t *nodes;                /* [node_count] of the scene, AL_NO_INDEX: not made */
    uint32_t *targets;              /* [node_count] morph targets of the deform on it */
    source_channel (*channels)[4];  /* [node_count] by al_motion_path */
    vertices gathered;
};

static al_status out_of_memory(const al_gltf_motion *m, al_error *error)
{
    return al_fail(error, AL_IO, "%s: out of memory for what moves", m->name);
}

static const json_t *node_at(const al_gltf_motion *m, uint32_t node)
{
    return al_gltf_element(m->file, "nodes", node);
}

/* --- which properties move --- */

static int path_of(const char *path)
{
    static const char *const paths[] = {"translation", "rotation", "scale", "weights"};
    for (int i = 0; path && i < 4; i++)
        if (!strcmp(path, paths[i])) return i;
    return -1;
}

static void choose_channels(al_gltf_motion *m, uint32_t animation, const json_t *list)
{
    for (uint32_t i = 0; i < json_array_size(list); i++) {
        const json_t *target = json_object_get(json_array_get(list, i), "target");
        uint32_t node = al_gltf_index(target, "node");
        int path = path_of(json_string_value(json_object_get(target, "path")));
        if (node < m->node_count && path >= 0 && m->channels[node][path].animation == AL_NO_INDEX)
            m->channels[node][path] = (source_channel){animation, i};
    }
}

static al_status choose_animations(al_gltf_motion *m, const char *only, al_error *error)
{
    const json_t *all = json_object_get(al_gltf_root(m->file), "animations");
    bool found = !*only;
    for (uint32_t i = 0; i < json_array_size(all); i++) {
        const json_t *animation = json_array_get(all, i);
        const char *name = json_string_value(json_object_get(animation, "name"));
        if (*only && (!name || strcmp(name, only))) continue;
        found = true;
        choose_channels(m, i, json_object_get(animation, "channels"));
    }
    return found ? AL_OK
                 : al_fail(error, AL_BAD_INPUT, "%s: no animation is named \"%s\"; there are %zu", m->name, only,
                           json_array_size(all));
}

static al_status find_parents(al_gltf_motion *m, al_error *error)
{
    for (uint32_t i = 0; i < m->node_count; i++) {
        const json_t *children = json_object_get(node_at(m, i), "children");
        for (size_t k = 0; k < json_array_size(children); k++) {
            json_int_t child = json_integer_value(json_array_get(children, k));
            if (child < 0 || child >= (json_int_t)m->node_count || m->parents[child] != AL_NO_INDEX)
                return al_fail(error, AL_BAD_INPUT, "%s: node %u has the child %lld, which is none or another's",
                               m->name, i, (long long)child);
            m->parents[child] = i;
        }
    }
    for (uint32_t i = 0; i < m->node_count; i++) {
        uint32_t depth = 0;
        for (uint32_t at = i; at != AL_NO_INDEX && depth <= DEPTH_LIMIT; at = m->parents[at]) depth++;
        if (depth > DEPTH_LIMIT)
            return al_fail(error, AL_BAD_INPUT, "%s: nodes are nested more than %d deep", m->name, DEPTH_LIMIT);
    }
    return AL_OK;
}

al_status al_gltf_motion_open(al_import *import, al_gltf *file, const char *name, const char *animation,
                              const double placement[16], uint32_t parent, al_gltf_motion **motion,
                              al_error *error)
{
    *motion = NULL;
    al_gltf_motion *m = calloc(1, sizeof *m);
    if (!m) return al_fail(error, AL_IO, "%s: out of memory for what moves", name);
    m->import = import;
    m->file = file;
    m->name = name;
    m->parent = parent;
    memcpy(m->placement, placement, sizeof m->placement);
    m->node_count = (uint32_t)json_array_size(json_object_get(al_gltf_root(file), "nodes"));
    size_t room = m->node_count + (size_t)1;
    m->parents = malloc(room * sizeof *m->parents);
    m->nodes = malloc(room * sizeof *m->nodes);
    m->targets = calloc(room, sizeof *m->targets);
    m->channels = malloc(room * sizeof *m->channels);
    al_status status = m->parents && m->nodes && m->targets && m->channels ? AL_OK : out_of_memory(m, error);
    for (uint32_t i = 0; i < m->node_count && !status; i++) {
        m->parents[i] = m->nodes[i] = AL_NO_INDEX;
        for (int path = 0; path < 4; path++) m->channels[i][path] = (source_channel){AL_NO_INDEX, 0};
    }
    if (!status) status = find_parents(m, error);
    if (!status) status = choose_animations(m, animation, error);
    if (status)
        al_gltf_motion_close(m);
    else
        *motion = m;
    return status;
}

static void forget_vertices(vertices *v)
{
    free(v->joints);
    free(v->weights);
    free(v->position_deltas);
    free(v->normal_deltas);
    *v = (vertices){0};
}

void al_gltf_motion_close(al_gltf_motion *m)
{
    if (!m) return;
    forget_vertices(&m->gathered);
    free(m->parents);
    free(m->nodes);
    free(m->targets);
    free(m->channels);
    free(m);
}

bool al_gltf_motion_moves(const al_gltf_motion *m, uint32_t node)
{
    for (; node < m->node_count; node = m->parents[node])
        for (int path = AL_MOTION_TRANSLATION; path <= AL_MOTION_SCALE; path++)
            if (m->channels[node][path].animation != AL_NO_INDEX) return true;
    return false;
}

/* --- nodes --- */

static void read_vector(const json_t *node, const char *key, size_t count, float *out)
{
    const json_t *list = json_object_get(node, key);
    if (json_array_size(list) != count) return;
    for (size_t i = 0; i < count; i++) out[i] = (float)json_number_value(json_array_get(list, i));
}

static bool has_finite_placement(const al_motion_node *n)
{
    const float *parts[] = {n->matrix, n->translation, n->rotation, n->scale};
    const int counts[] = {16, 3, 4, 3};
    for (int p = 0; p < 4; p++)
        for (int i = 0; i < counts[p]; i++)
            if (!isfinite(parts[p][i])) return false;
    return n->matrix[3] == 0 && n->matrix[7] == 0 && n->matrix[11] == 0 && n->matrix[15] == 1;
}

al_status al_gltf_motion_node(al_gltf_motion *m, uint32_t node, uint32_t *index, al_error *error)
{
    *index = m->nodes[node];
    if (*index != AL_NO_INDEX) return AL_OK;
    const json_t *from = node_at(m, node);
    const char *name = json_string_value(json_object_get(from, "name"));
    bool is_root = m->parents[node] == AL_NO_INDEX;
    al_motion_node made = {.name = (char *)(uintptr_t)(name ? name : ""), .parent = m->parent, .rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}};
    double matrix[16];
    for (int i = 0; i < 16; i++) made.matrix[i] = i % 5 == 0;
    read_vector(from, "matrix", 16, made.matrix);
    for (int i = 0; i < 16; i++) matrix[i] = made.matrix[i];
    if (is_root) al_matrix_multiply(m->placement, matrix, matrix);
    for (int i = 0; i < 16; i++) made.matrix[i] = (float)matrix[i];
    read_vector(from, "translation", 3, made.translation);
    read_vector(from, "rotation", 4, made.rotation);
    read_vector(from, "scale", 3, made.scale);
    if (!has_finite_placement(&made))
        return al_fail(error, AL_BAD_INPUT, "%s: node %u has a transform that is not finite or not affine", m->name,
                       node);
    al_status status = is_root ? AL_OK : al_gltf_motion_node(m, m->parents[node], &made.parent, error);
    if (!status) status = al_motion_add_node(m->import, &made, index, error);
    if (!status) m->nodes[node] = *index;
    return status;
}

/* --- channels --- */

static al_status check_times(const al_gltf_motion *m, const char *what, const float *times, uint32_t count,
                             al_error *error)
{
    if (!count) return al_fail(error, AL_BAD_INPUT, "%s: %s: has no keys", m->name, what);
    for (uint32_t k = 0; k < count; k++)
        if (!(times[k] >= 0) || (k && !(times[k] > times[k - 1])))
            return al_fail(error, AL_BAD_INPUT, "%s: %s: key %u is at %g s; times that rise from 0 on are right",
                           m->name, what, k, (double)times[k]);
    return AL_OK;
}

static al_status interpolation_of(const al_gltf_motion *m, const char *what, const json_t *sampler, uint32_t *out,
                                  al_error *error)
{
    const char *word = json_string_value(json_object_get(sampler, "interpolation"));
    if (!word || !strcmp(word, "LINEAR"))
        *out = AL_MOTION_LINEAR;
    else if (!strcmp(word, "STEP"))
        *out = AL_MOTION_STEP;
    else if (!strcmp(word, "CUBICSPLINE"))
        *out = AL_MOTION_CUBIC;
    else
        return al_fail(error, AL_BAD_INPUT, "%s: %s: interpolation %s; LINEAR, STEP or CUBICSPLINE is right", m->name,
                       what, word);
    return AL_OK;
}

static al_status add_channel(al_gltf_motion *m, uint32_t node, int path, al_error *error)
{
    const source_channel *from = &m->channels[node][path];
    const json_t *animation = al_gltf_element(m->file, "animations", from->animation);
    const json_t *channel = json_array_get(json_object_get(animation, "channels"), from->channel);
    const json_t *sampler = json_array_get(json_object_get(animation, "samplers"), al_gltf_index(channel, "sampler"));
    uint32_t width = path == AL_MOTION_WEIGHTS ? m->targets[node] : path == AL_MOTION_ROTATION ? 4 : 3, numbers;
    al_motion_channel made = {.node = m->nodes[node], .path = (uint32_t)path, .width = width};
    float *times = NULL, *values = NULL;
    char what[WHAT_ROOM];
    snprintf(what, sizeof what, "animation %u, channel %u", from->animation, from->channel);
    al_status status = interpolation_of(m, what, sampler, &made.interpolation, error);
    if (!status)
        status = al_gltf_numbers(m->file, al_gltf_index(sampler, "input"), 1, what, &times, &made.key_count, error);
    if (!status) status = check_times(m, what, times, made.key_count, error);
    if (!status)
        status = al_gltf_numbers(m->file, al_gltf_index(sampler, "output"), path == AL_MOTION_WEIGHTS ? 1 : width, what,
                                 &values, &numbers, error);
    uint64_t each = (made.interpolation == AL_MOTION_CUBIC ? 3 : 1) * (path == AL_MOTION_WEIGHTS ? (uint64_t)width : 1);
    if (!status && numbers != each * made.key_count)
        status = al_fail(error, AL_BAD_INPUT, "%s: %s: %u values for %u keys; %llu are right", m->name, what, numbers,
                         made.key_count, (unsigned long long)(each * made.key_count));
    made.times_s = times;
    made.values = values;
    if (!status) status = al_motion_add_channel(m->import, &made, error);
    free(times);
    free(values);
    return status;
}

/* Weights of a node or its mesh that no animation moves, as a channel of one key. */
static al_status add_still_weights(al_gltf_motion *m, uint32_t node, al_error *error)
{
    const json_t *n = node_at(m, node), *list = json_object_get(n, "weights");
    if (!list) list = json_object_get(al_gltf_element(m->file, "meshes", al_gltf_index(n, "mesh")), "weights");
    uint32_t count = m->targets[node];
    if (json_array_size(list) != count) return AL_OK;
    float zero = 0, *weights = calloc(count + (size_t)1, sizeof *weights);
    if (!weights) return out_of_memory(m, error);
    for (uint32_t i = 0; i < count; i++) {
        double w = json_number_value(json_array_get(list, i));
        weights[i] = isfinite((float)w) ? (float)w : 0;
    }
    const al_motion_channel made = {m->nodes[node], AL_MOTION_WEIGHTS, AL_MOTION_STEP, 1, count, &zero, weights};
    al_status status = al_motion_add_channel(m->import, &made, error);
    free(weights);
    return status;
}

al_status al_gltf_motion_finish(al_gltf_motion *m, al_error *error)
{
    al_status status = AL_OK;
    for (uint32_t i = 0; i < m->node_count && !status; i++) {
        if (m->nodes[i] == AL_NO_INDEX) continue;
        for (int path = 0; path < 4 && !status; path++) {
            if (path == AL_MOTION_WEIGHTS && !m->targets[i]) continue;
            if (m->channels[i][path].animation != AL_NO_INDEX)
                status = add_channel(m, i, path, error);
            else if (path == AL_MOTION_WEIGHTS)
                status = add_still_weights(m, i, error);
        }
    }
    return status;
}

/* --- deformed meshes --- */

static const json_t *primitives_of(const al_gltf_motion *m, uint32_t node)
{
    return json_object_get(al_gltf_element(m->file, "meshes", al_gltf_index(node_at(m, node), "mesh")), "primitives");
}

bool al_gltf_motion_skinned(const al_gltf_motion *m, uint32_t node)
{
    const json_t *attributes = json_object_get(json_array_get(primitives_of(m, node), 0), "attributes");
    return al_gltf_element(m->file, "skins", al_gltf_index(node_at(m, node), "skin")) &&
           json_object_get(attributes, "JOINTS_0") && json_object_get(attributes, "WEIGHTS_0");
}

static uint32_t target_count(const al_gltf_motion *m, uint32_t node)
{
    return (uint32_t)json_array_size(json_object_get(json_array_get(primitives_of(m, node), 0), "targets"));
}

/* A mesh whose targets have no weight, ever, is like any other. */
static bool has_weights(const al_gltf_motion *m, uint32_t node)
{
    const json_t *n = node_at(m, node), *mesh = al_gltf_element(m->file, "meshes", al_gltf_index(n, "mesh"));
    return m->channels[node][AL_MOTION_WEIGHTS].animation != AL_NO_INDEX || json_object_get(n, "weights") ||
           json_object_get(mesh, "weights");
}

bool al_gltf_motion_deforms(const al_gltf_motion *m, uint32_t node)
{
    return node < m->node_count && (al_gltf_motion_skinned(m, node) || (target_count(m, node) && has_weights(m, node)));
}

/* An attribute of every vertex, zeros where the primitive has none; *found says whether it has. */
static al_status read_attribute(al_gltf_motion *m, const json_t *attributes, const char *key, uint32_t width,
                                uint32_t vertex_count, float **values, bool *found, al_error *error)
{
    uint32_t count = vertex_count;
    *found = json_object_get(attributes, key) != NULL;
    if (*found) {
        al_status status = al_gltf_numbers(m->file, al_gltf_index(attributes, key), width, key, values, &count, error);
        if (status) return status;
    } else {
        *values = calloc((size_t)vertex_count * width + 1, sizeof **values);
        if (!*values) return out_of_memory(m, error);
    }
    if (count == vertex_count) return AL_OK;
    free(*values);
    *values = NULL;
    return al_fail(error, AL_BAD_INPUT, "%s: %s: %u vertices of %u", m->name, key, count, vertex_count);
}

static bool grow(float **array, size_t floats)
{
    float *grown = realloc(*array, (floats + 1) * sizeof *grown);
    if (grown) *array = grown;
    return grown != NULL;
}

/* Weights that sum to 1; a vertex without any follows its first joint. */
static al_status check_weights(const al_gltf_motion *m, uint32_t vertex, float weights[INFLUENCES],
                               const float joints[INFLUENCES], size_t joint_count, al_error *error)
{
    double sum = 0;
    for (int k = 0; k < INFLUENCES; k++) {
        if (!(weights[k] >= 0))
            return al_fail(error, AL_BAD_INPUT, "%s: vertex %u has the weight %g; 0 or more is right", m->name, vertex,
                           (double)weights[k]);
        if (weights[k] > 0 && !(joints[k] >= 0 && (size_t)joints[k] < joint_count))
            return al_fail(error, AL_BAD_INPUT, "%s: vertex %u hangs on joint %g of %zu", m->name, vertex,
                           (double)joints[k], joint_count);
        sum += weights[k];
    }
    for (int k = 0; k < INFLUENCES; k++) weights[k] = sum > 0 ? (float)(weights[k] / sum) : k == 0;
    return AL_OK;
}

static size_t joints_of(const al_gltf_motion *m, uint32_t node)
{
    return json_array_size(
        json_object_get(al_gltf_element(m->file, "skins", al_gltf_index(node_at(m, node), "skin")), "joints"));
}

static al_status gather_joints(al_gltf_motion *m, uint32_t node, const json_t *attributes, uint32_t count,
                               al_error *error)
{
    vertices *v = &m->gathered;
    float *joints = NULL, *weights = NULL;
    bool has_joints, has_any;
    al_status status = read_attribute(m, attributes, "JOINTS_0", 4, count, &joints, &has_joints, error);
    if (!status) status = read_attribute(m, attributes, "WEIGHTS_0", 4, count, &weights, &has_any, error);
    size_t all = INFLUENCES * ((size_t)v->count + count);
    if (!status && !(grow(&v->joints, all) && grow(&v->weights, all))) status = out_of_memory(m, error);
    for (uint32_t i = 0; i < count && !status; i++) {
        status = check_weights(m, i, weights + INFLUENCES * (size_t)i, joints + INFLUENCES * (size_t)i,
                               joints_of(m, node), error);
        for (size_t k = INFLUENCES * (size_t)i; k < INFLUENCES * ((size_t)i + 1); k++)
            if (!(joints[k] >= 0 && (size_t)joints[k] < joints_of(m, node))) joints[k] = 0; /* of no weight */
    }
    if (!status) {
        memcpy(v->joints + INFLUENCES * (size_t)v->count, joints, INFLUENCES * (size_t)count * sizeof *joints);
        memcpy(v->weights + INFLUENCES * (size_t)v->count, weights, INFLUENCES * (size_t)count * sizeof *weights);
    }
    free(joints);
    free(weights);
    return status;
}

static void deal_deltas(const vertices *v, const float *deltas, uint32_t count, uint32_t target, float *all)
{
    for (uint32_t i = 0; i < count; i++)
        memcpy(all + 3 * (((size_t)v->count + i) * v->target_count + target), deltas + 3 * (size_t)i,
               3 * sizeof *deltas);
}

static al_status gather_targets(al_gltf_motion *m, const json_t *primitive, uint32_t count, al_error *error)
{
    vertices *v = &m->gathered;
    const json_t *targets = json_object_get(primitive, "targets");
    size_t all = 3 * ((size_t)v->count + count) * v->target_count;
    if (json_array_size(targets) != v->target_count || v->target_count > TARGET_LIMIT)
        return al_fail(error, AL_BAD_INPUT, "%s: a primitive has %zu morph targets, the first one of its mesh %u",
                       m->name, json_array_size(targets), v->target_count);
    if (!grow(&v->position_deltas, all) || !grow(&v->normal_deltas, all)) return out_of_memory(m, error);
    al_status status = AL_OK;
    for (uint32_t t = 0; t < v->target_count && !status; t++) {
        const json_t *target = json_array_get(targets, t);
        float *positions = NULL, *normals = NULL;
        bool has_positions, has_normals = false;
        status = read_attribute(m, target, "POSITION", 3, count, &positions, &has_positions, error);
        if (!status) status = read_attribute(m, target, "NORMAL", 3, count, &normals, &has_normals, error);
        if (!status) deal_deltas(v, positions, count, t, v->position_deltas);
        if (!status) deal_deltas(v, normals, count, t, v->normal_deltas);
        v->has_normals = v->has_normals || has_normals;
        free(positions);
        free(normals);
    }
    return status;
}

typedef struct surface { /* of a primitive */
    uint32_t vertex_count, corner_count;
    float *positions, *normals, *uv0, *uv1, *indices; /* indices NULL: in order; exact up to 2^24 */
    bool has_normals, has_uv0, has_uv1;
} surface;

static void free_surface(surface *s)
{
    free(s->positions);
    free(s->normals);
    free(s->uv0);
    free(s->uv1);
    free(s->indices);
}

static al_status read_surface(al_gltf_motion *m, const json_t *primitive, surface *s, al_error *error)
{
    const json_t *attributes = json_object_get(primitive, "attributes");
    uint32_t mode = al_gltf_index(primitive, "mode");
    if (mode != AL_NO_INDEX && mode != 4)
        return al_fail(error, AL_BAD_INPUT, "%s: a mesh with a skin or morph targets has primitives of mode %u; "
                       "triangles (4) are right", m->name, mode);
    if (json_object_get(json_object_get(primitive, "extensions"), "KHR_draco_mesh_compression"))
        return al_fail(error, AL_BAD_INPUT, "%s: a mesh with a skin or morph targets is compressed (Draco); numbers as they "
                       "are would be right", m->name);
    al_status status = al_gltf_numbers(m->file, al_gltf_index(attributes, "POSITION"), 3, "POSITION", &s->positions,
                                       &s->vertex_count, error);
    if (!status)
        status = read_attribute(m, attributes, "NORMAL", 3, s->vertex_count, &s->normals, &s->has_normals, error);
    if (!status)
        status = read_attribute(m, attributes, "TEXCOORD_0", 2, s->vertex_count, &s->uv0, &s->has_uv0, error);
    if (!status)
        status = read_attribute(m, attributes, "TEXCOORD_1", 2, s->vertex_count, &s->uv1, &s->has_uv1, error);
    s->corner_count = s->vertex_count;
    if (!status && json_object_get(primitive, "indices"))
        status = al_gltf_numbers(m->file, al_gltf_index(primitive, "indices"), 1, "indices", &s->indices,
                                 &s->corner_count, error);
    s->corner_count -= s->corner_count % 3;
    if (!status && s->vertex_count > 1u << 24)
        status = al_fail(error, AL_BAD_INPUT, "%s: a mesh with a skin or morph targets has %u vertices; at most %u "
                         "are right", m->name, s->vertex_count, 1u << 24);
    return status;
}

static al_status append_corners(const al_gltf_motion *m, const surface *s, al_corners *out, al_error *error)
{
    al_status status = al_corners_reserve(out, s->corner_count, error);
    for (uint32_t i = 0; i < s->corner_count && !status; i++) {
        size_t from = !s->indices ? i : s->indices[i] >= 0 ? (size_t)s->indices[i] : SIZE_MAX, to = out->count;
        if (from >= s->vertex_count)
            return al_fail(error, AL_BAD_INPUT, "%s: triangle %u names vertex %zu of %u", m->name, i / 3, from,
                           s->vertex_count);
        memcpy(out->positions + 3 * to, s->positions + 3 * from, 3 * sizeof(float));
        memcpy(out->normals + 3 * to, s->normals + 3 * from, 3 * sizeof(float));
        memcpy(out->uv0 + 2 * to, s->uv0 + 2 * from, 2 * sizeof(float));
        memcpy(out->uv1 + 2 * to, s->uv1 + 2 * from, 2 * sizeof(float));
        out->marks[to] = m->gathered.count + (uint32_t)from;
        out->count++;
    }
    out->has_uv0 = out->has_uv0 || s->has_uv0;
    out->has_uv1 = out->has_uv1 || s->has_uv1;
    return status;
}

al_status al_gltf_motion_corners(al_gltf_motion *m, uint32_t node, uint32_t index, al_corners *corners,
                                 al_error *error)
{
    const json_t *primitive = json_array_get(primitives_of(m, node), index);
    surface s = {0};
    if (!index) {
        forget_vertices(&m->gathered);
        m->gathered.target_count = target_count(m, node);
    }
    al_status status = read_surface(m, primitive, &s, error);
    if (!status) status = append_corners(m, &s, corners, error);
    if (!status && al_gltf_motion_skinned(m, node))
        status = gather_joints(m, node, json_object_get(primitive, "attributes"), s.vertex_count, error);
    if (!status) status = gather_targets(m, primitive, s.vertex_count, error);
    if (!status) m->gathered.count += s.vertex_count;
    free_surface(&s);
    return status;
}

/* --- into the scene --- */

static al_status add_joints(al_gltf_motion *m, uint32_t node, al_motion_deform *deform, al_error *error)
{
    const json_t *skin = al_gltf_element(m->file, "skins", al_gltf_index(node_at(m, node), "skin"));
    const json_t *joints = json_object_get(skin, "joints");
    al_motion *motion = &m->import->scene.motion;
    float *inverse = NULL;
    uint32_t count = (uint32_t)json_array_size(joints), given = 0;
    al_status status = AL_OK;
    deform->first_joint = motion->joint_count;
    deform->joint_count = count;
    if (json_object_get(skin, "inverseBindMatrices"))
        status = al_gltf_numbers(m->file, al_gltf_index(skin, "inverseBindMatrices"), 16, "inverseBindMatrices",
                                 &inverse, &given, error);
    if (!status && ((inverse && given < count) || count > UINT16_MAX + 1))
        status = al_fail(error, AL_BAD_INPUT, "%s: a skin has %u joints and %u inverse bind matrices", m->name, count,
                         given);
    for (uint32_t i = 0; i < count && !status; i++) {
        json_int_t joint = json_integer_value(json_array_get(joints, i));
        if (joint < 0 || joint >= (json_int_t)m->node_count) {
            status = al_fail(error, AL_BAD_INPUT, "%s: joint %u of a skin is node %lld of %u", m->name, i,
                             (long long)joint, m->node_count);
            break;
        }
        uint32_t to;
        status = al_gltf_motion_node(m, (uint32_t)joint, &to, error);
        if (status) break;
        al_motion_joint *made =
            al_scene_append(&m->import->scene, &motion->joints, &motion->joint_count, sizeof *made);
        if (!made) {
            status = out_of_memory(m, error);
            break;
        }
        made->node = to;
        for (int k = 0; k < 16; k++)
            made->inverse_bind[k] = k % 4 == 3 ? k == 15 : inverse ? inverse[16 * (size_t)i + (size_t)k] : k % 5 == 0;
    }
    free(inverse);
    return status;
}

/* The arrays of the mesh's vertices, from those of the file's: `from` says which each is. */
static al_status fill_deform(al_gltf_motion *m, const uint32_t *from, const al_mesh *mesh, al_motion_deform *d,
                             al_error *error)
{
    al_scene *scene = &m->import->scene;
    const vertices *v = &m->gathered;
    size_t count = mesh->vertex_count, deltas = 3 * count * d->target_count;
    d->bind_positions = al_scene_array(scene, 3 * count, sizeof(float));
    d->bind_normals = al_scene_array(scene, 3 * count, sizeof(float));
    if (d->joint_count) {
        d->joints = al_scene_array(scene, INFLUENCES * count, sizeof *d->joints);
        d->weights = al_scene_array(scene, INFLUENCES * count, sizeof(float));
    }
    if (d->target_count) d->position_deltas = al_scene_array(scene, deltas, sizeof(float));
    if (d->has_normals) d->normal_deltas = al_scene_array(scene, deltas, sizeof(float));
    if (!d->bind_positions || !d->bind_normals || (d->joint_count && !(d->joints && d->weights)) ||
        (d->target_count && !d->position_deltas) || (d->has_normals && !d->normal_deltas))
        return out_of_memory(m, error);
    memcpy(d->bind_positions, mesh->positions, 3 * count * sizeof(float));
    memcpy(d->bind_normals, mesh->normals, 3 * count * sizeof(float));
    for (size_t i = 0; i < count; i++) {
        for (size_t k = 0; k < INFLUENCES && d->joint_count; k++) {
            d->joints[INFLUENCES * i + k] = (uint16_t)v->joints[INFLUENCES * (size_t)from[i] + k];
            d->weights[INFLUENCES * i + k] = v->weights[INFLUENCES * (size_t)from[i] + k];
        }
        for (size_t t = 0; t < d->target_count; t++) {
            size_t here = 3 * (t * count + i), there = 3 * (from[i] * (size_t)d->target_count + t);
            memcpy(d->position_deltas + here, v->position_deltas + there, 3 * sizeof(float));
            if (d->has_normals) memcpy(d->normal_deltas + here, v->normal_deltas + there, 3 * sizeof(float));
        }
    }
    return AL_OK;
}

al_status al_gltf_motion_deform(al_gltf_motion *m, uint32_t node, const al_corners *corners, uint32_t instance,
                                al_error *error)
{
    al_scene *scene = &m->import->scene;
    const al_mesh *mesh = &scene->meshes[scene->instances[instance].mesh];
    al_motion_deform made = {.instance = instance, .node = AL_NO_INDEX, .target_count = m->gathered.target_count,
                             .has_normals = m->gathered.has_normals};
    uint32_t *from = calloc(mesh->vertex_count + (size_t)1, sizeof *from);
    if (!from) return out_of_memory(m, error);
    for (uint32_t i = 0; i < mesh->index_count; i++) from[mesh->indices[i]] = corners->marks[i];
    al_status status = al_gltf_motion_skinned(m, node) ? add_joints(m, node, &made, error) : AL_OK;
    if (!status && made.target_count) {
        m->targets[node] = made.target_count;
        status = al_gltf_motion_node(m, node, &made.node, error);
    }
    if (!status) status = fill_deform(m, from, mesh, &made, error);
    free(from);
    if (status) return status;
    al_motion_deform *place = al_scene_append(scene, &scene->motion.deforms, &scene->motion.deform_count, sizeof *place);
    if (!place) return out_of_memory(m, error);
    *place = made;
    return AL_OK;
}
