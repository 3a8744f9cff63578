#include "motion_import.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "geometry.h"

enum { TURN_DEGREES = 90 }; /* between two stored keys: far enough below half a turn */

static al_status out_of_memory(const al_import *import, al_error *error)
{
    return al_fail(error, AL_IO, "%s: out of memory for what moves", import->description->path);
}

al_status al_motion_add_node(al_import *import, const al_motion_node *node, uint32_t *index, al_error *error)
{
    al_motion *m = &import->scene.motion;
    al_motion_node *place = al_scene_append(&import->scene, &m->nodes, &m->node_count, sizeof *place);
    if (!place) return out_of_memory(import, error);
    *place = *node;
    *index = m->node_count - 1;
    place->name = al_scene_text(&import->scene, node->name);
    return place->name ? AL_OK : out_of_memory(import, error);
}

al_status al_motion_add_channel(al_import *import, const al_motion_channel *channel, al_error *error)
{
    al_motion *m = &import->scene.motion;
    al_motion_channel *place = al_scene_append(&import->scene, &m->channels, &m->channel_count, sizeof *place);
    size_t parts = channel->interpolation == AL_MOTION_CUBIC ? 3 : 1,
           numbers = (size_t)channel->key_count * channel->width * parts;
    if (!place) return out_of_memory(import, error);
    *place = *channel;
    place->times_s = al_scene_array(&import->scene, channel->key_count, sizeof *place->times_s);
    place->values = al_scene_array(&import->scene, numbers, sizeof *place->values);
    if (!place->times_s || !place->values) return out_of_memory(import, error);
    memcpy(place->times_s, channel->times_s, channel->key_count * sizeof *place->times_s);
    memcpy(place->values, channel->values, numbers * sizeof *place->values);
    return AL_OK;
}

al_status al_motion_bind(al_import *import, al_motion_kind kind, uint32_t index, uint32_t node,
                         const double local[16], al_error *error)
{
    al_motion *m = &import->scene.motion;
    al_motion_binding *b = al_scene_append(&import->scene, &m->bindings, &m->binding_count, sizeof *b);
    if (!b) return out_of_memory(import, error);
    *b = (al_motion_binding){.kind = kind, .index = index, .node = node};
    for (int i = 0; i < 16; i++) {
        b->local[i] = (float)local[i];
        if (!isfinite(b->local[i]))
            return al_fail(error, AL_BAD_INPUT, "%s: node \"%s\" moves by a transform that is not finite",
                           import->description->path, m->nodes[node].name);
    }
    return AL_OK;
}

/* --- keys of the scene file --- */

/* Quaternion of turns about x, then y, then z: q = qz qy qx. */
static void quaternion(const double degrees[3], float out[4])
{
    double c[3], s[3];
    for (int i = 0; i < 3; i++) {
        c[i] = cos(degrees[i] * (3.14159265358979323846 / 360));
        s[i] = sin(degrees[i] * (3.14159265358979323846 / 360));
    }
    out[0] = (float)(s[0] * c[1] * c[2] - c[0] * s[1] * s[2]);
    out[1] = (float)(c[0] * s[1] * c[2] + s[0] * c[1] * s[2]);
    out[2] = (float)(c[0] * c[1] * s[2] - s[0] * s[1] * c[2]);
    out[3] = (float)(c[0] * c[1] * c[2] + s[0] * s[1] * s[2]);
}

/* Keys stored for the way from one key of the scene file to the next: its angles change evenly, which slerps
 * follow exactly about one axis and closely about several. */
static uint32_t pieces(const al_motion_key_description *from, const al_motion_key_description *to)
{
    double largest = 0;
    for (int i = 0; i < 3; i++) largest = fmax(largest, fabs(to->rotate_degrees[i] - from->rotate_degrees[i]));
    return (uint32_t)fmax(1, ceil(largest / TURN_DEGREES));
}

static void store_key(const al_motion_key_description *from, const al_motion_key_description *to, double t,
                      uint32_t key, al_motion_channel channels[3])
{
    double degrees[3];
    for (int i = 0; i < 3; i++) {
        degrees[i] = (1 - t) * from->rotate_degrees[i] + t * to->rotate_degrees[i];
        channels[0].values[3 * key + (uint32_t)i] = (float)((1 - t) * from->translate_m[i] + t * to->translate_m[i]);
        channels[2].values[3 * key + (uint32_t)i] = (float)((1 - t) * from->scale[i] + t * to->scale[i]);
        channels[i].times_s[key] = (float)((1 - t) * from->time_s + t * to->time_s);
    }
    quaternion(degrees, channels[1].values + 4 * (size_t)key);
}

al_status al_motion_add_keys(al_import *import, const char *name, const al_motion_description *motion,
                             const double pivot[3], uint32_t *node, al_error *error)
{
    al_motion_node made = {.name = (char *)(uintptr_t)name, .parent = AL_NO_INDEX, .rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}};
    for (int i = 0; i < 16; i++) made.matrix[i] = i % 5 == 0;
    for (int i = 0; i < 3; i++) made.matrix[12 + i] = (float)pivot[i];
    al_status status = al_motion_add_node(import, &made, node, error);
    if (status) return status;
    uint32_t count = 1, key = 0;
    for (uint32_t i = 1; i < motion->count; i++) count += pieces(&motion->keys[i - 1], &motion->keys[i]);
    float *numbers = calloc(count, sizeof(float[11])), *times = numbers;
    if (!numbers) return out_of_memory(import, error);
    al_motion_channel channels[3] = {
        {*node, AL_MOTION_TRANSLATION, AL_MOTION_LINEAR, count, 3, times, times + count},
        {*node, AL_MOTION_ROTATION, AL_MOTION_LINEAR, count, 4, times, times + 4 * (size_t)count},
        {*node, AL_MOTION_SCALE, AL_MOTION_LINEAR, count, 3, times, times + 8 * (size_t)count}};
    store_key(&motion->keys[0], &motion->keys[0], 0, key++, channels);
    for (uint32_t i = 1; i < motion->count; i++)
        for (uint32_t k = 1, n = pieces(&motion->keys[i - 1], &motion->keys[i]); k <= n; k++)
            store_key(&motion->keys[i - 1], &motion->keys[i], (double)k / n, key++, channels);
    for (int i = 0; i < 3 && !status; i++) status = al_motion_add_channel(import, &channels[i], error);
    free(numbers);
    return status;
}

/* A frame at `place` whose -z is `forward`, and +y as near to `up` as can be. */
static void frame_of(const double place[3], const double forward[3], const double up[3], double m[16])
{
    double z[3], x[3], length = 0, wide = 0;
    for (int i = 0; i < 3; i++) length += forward[i] * forward[i];
    for (int i = 0; i < 3; i++) z[i] = -forward[i] / sqrt(length);
    for (int i = 0; i < 3; i++) x[i] = up[(i + 1) % 3] * z[(i + 2) % 3] - up[(i + 2) % 3] * z[(i + 1) % 3];
    for (int i = 0; i < 3; i++) wide += x[i] * x[i];
    for (int i = 0; i < 16; i++) m[i] = i == 15;
    for (int i = 0; i < 3; i++) {
        x[i] /= sqrt(wide);
        m[i] = x[i];
        m[8 + i] = z[i];
        m[12 + i] = place[i];
    }
    for (int i = 0; i < 3; i++) m[4 + i] = z[(i + 1) % 3] * x[(i + 2) % 3] - z[(i + 2) % 3] * x[(i + 1) % 3];
}

static al_status bind_described(al_import *import, al_motion_kind kind, uint32_t index, const char *name,
                                const al_motion_description *motion, double frame[16], al_error *error)
{
    double pivot[3] = {frame[12], frame[13], frame[14]};
    uint32_t node;
    for (int i = 0; i < 3; i++) frame[12 + i] = 0; /* move(-pivot) frame */
    al_status status = al_motion_add_keys(import, name, motion, pivot, &node, error);
    return status ? status : al_motion_bind(import, kind, index, node, frame, error);
}

al_status al_motion_bind_described(al_import *import, al_error *error)
{
    const al_scene_description *d = import->description;
    al_status status = AL_OK;
    double frame[16];
    for (uint32_t i = 0; i < d->light_count && !status; i++) {
        const al_light *l = &d->lights[i];
        bool point = l->type == AL_LIGHT_POINT;
        double place[3] = {0}, forward[3] = {0, 0, -1}, up[3];
        for (int k = 0; k < 3; k++) (point ? place : forward)[k] = l->vector[k];
        for (int k = 0; k < 3; k++) up[k] = fabs(forward[1]) < 0.7 ? k == 1 : k == 0;
        frame_of(place, forward, up, frame);
        if (d->light_motions[i].count)
            status = bind_described(import, AL_MOTION_LIGHT, i, l->name, &d->light_motions[i], frame, error);
    }
    for (uint32_t i = 0; i < d->camera_count && !status; i++) {
        const al_camera *c = &d->cameras[i];
        double place[3], forward[3], up[3];
        for (int k = 0; k < 3; k++) {
            place[k] = c->position[k];
            forward[k] = (double)c->target[k] - c->position[k];
            up[k] = c->up[k];
        }
        frame_of(place, forward, up, frame);
        if (d->camera_motions[i].count)
            status = bind_described(import, AL_MOTION_CAMERA, i, c->name, &d->camera_motions[i], frame, error);
    }
    for (uint32_t i = 0; i < import->scene.fog_count && !status; i++) {
        const al_fog *f = &import->scene.fogs[i];
        const al_motion_description *motion = &d->media[f->medium].density.motion;
        double pivot[3];
        uint32_t node;
        if (!motion->count) continue;
        for (int k = 0; k < 16; k++) frame[k] = k % 5 == 0;
        for (int k = 0; k < 3; k++) {
            pivot[k] = 0.5 * ((double)f->bounds_min_m[k] + f->bounds_max_m[k]);
            frame[12 + k] = -pivot[k];
        }
        status = al_motion_add_keys(import, d->media[f->medium].name, motion, pivot, &node, error);
        if (!status) status = al_motion_bind(import, AL_MOTION_FOG, i, node, frame, error);
    }
    return status;
}

/* --- the end --- */

static int compare_channels(const void *a, const void *b)
{
    const al_motion_channel *x = a, *y = b;
    if (x->node != y->node) return x->node < y->node ? -1 : 1;
    return x->path < y->path ? -1 : x->path > y->path;
}

static int compare_bindings(const void *a, const void *b)
{
    const al_motion_binding *x = a, *y = b;
    if (x->kind != y->kind) return x->kind < y->kind ? -1 : 1;
    return x->index < y->index ? -1 : x->index > y->index;
}

static bool node_moves(const al_motion *m, uint32_t node)
{
    for (; node != AL_NO_INDEX; node = m->nodes[node].parent)
        for (uint32_t i = 0; i < m->channel_count; i++)
            if (m->channels[i].node == node && m->channels[i].path != AL_MOTION_WEIGHTS) return true;
    return false;
}

static bool deform_moves(const al_motion *m, const al_motion_deform *d)
{
    for (uint32_t i = 0; i < m->channel_count; i++)
        if (m->channels[i].node == d->node && m->channels[i].path == AL_MOTION_WEIGHTS &&
            m->channels[i].key_count > 1)
            return true;
    for (uint32_t i = 0; i < d->joint_count; i++)
        if (node_moves(m, m->joints[d->first_joint + i].node)) return true;
    return false;
}

/* Vertices where they are at time 0. */
static al_status pose(al_import *import, const al_motion_deform *d, const double (*world)[16], al_error *error)
{
    const al_motion *m = &import->scene.motion;
    al_mesh *mesh = &import->scene.meshes[import->scene.instances[d->instance].mesh];
    double(*palette)[16] = calloc(d->joint_count + (size_t)1, sizeof *palette);
    double *weights = calloc(d->target_count + (size_t)1, sizeof *weights);
    if (palette && weights) {
        al_motion_weights_at(m, d, 0, weights);
        al_motion_palette(m, d, world, palette);
        al_motion_deform_at(d, mesh->vertex_count, (const double(*)[16])palette, weights, mesh->positions,
                            mesh->normals);
    }
    bool good = palette && weights;
    free(palette);
    free(weights);
    for (size_t i = 0; good && i < 3 * (size_t)mesh->vertex_count; i++)
        if (!isfinite(mesh->positions[i]))
            return al_fail(error, AL_BAD_INPUT, "%s: mesh \"%s\" is moved beyond all numbers",
                           import->description->path, mesh->name);
    return good ? AL_OK : out_of_memory(import, error);
}

static void choose_lighting(al_import *import)
{
    for (uint32_t i = 0; i < import->scene.instance_count; i++) {
        al_instance *instance = &import->scene.instances[i];
        if (instance->lighting == AL_LIGHTING_LIGHTMAP && al_motion_moves(&import->scene.motion, i))
            instance->lighting = import->description->has_probes ? AL_LIGHTING_PROBES : AL_LIGHTING_DYNAMIC;
    }
}

al_status al_motion_finish(al_import *import, al_error *error)
{
    al_motion *m = &import->scene.motion;
    if (!m->node_count) return AL_OK;
    if (m->channel_count) qsort(m->channels, m->channel_count, sizeof *m->channels, compare_channels);
    if (m->binding_count) qsort(m->bindings, m->binding_count, sizeof *m->bindings, compare_bindings);
    double(*world)[16] = calloc(m->node_count, sizeof *world), *scratch = calloc(al_motion_width(m), sizeof *scratch);
    al_status status = world && scratch ? AL_OK : out_of_memory(import, error);
    uint32_t kept = 0;
    if (!status) {
        al_motion_nodes_at(m, 0, scratch, world);
        al_motion_place(&import->scene, (const double(*)[16])world);
    }
    for (uint32_t i = 0; i < m->deform_count && !status; i++) {
        status = pose(import, &m->deforms[i], (const double(*)[16])world, error);
        if (deform_moves(m, &m->deforms[i])) m->deforms[kept++] = m->deforms[i];
    }
    free(world);
    free(scratch);
    m->deform_count = kept;
    if (!kept && !m->binding_count) *m = (al_motion){0};
    choose_lighting(import);
    return status;
}
