/* The time that is shown: nodes on the CPU, vertices of skinned and morphed instances by compute shader. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "state.h"

enum { GROUP = 64, ROW_FLOATS = 12 };

static al_mesh *mesh_of(al_runtime *runtime, const al_motion_deform *d)
{
    return &runtime->scene.meshes[runtime->scene.instances[d->instance].mesh];
}

/* --- boxes that hold whatever the pose: a skinned vertex is a mean of its joints' transforms of the bound one,
 * so it lies in the box around each joint's transform of the box of the vertices that hang on it. Morph targets
 * widen those boxes by weight x the box of their deltas. --- */

static void clear_box(al_box *box)
{
    for (int k = 0; k < 3; k++) box->low[k] = INFINITY, box->high[k] = -INFINITY;
}

static void grow_box(al_box *box, const float *point)
{
    for (int k = 0; k < 3; k++) {
        box->low[k] = fminf(box->low[k], point[k]);
        box->high[k] = fmaxf(box->high[k], point[k]);
    }
}

static void fill_boxes(const al_motion_deform *d, uint32_t vertex_count, al_deformed *out)
{
    uint32_t parts = d->joint_count ? d->joint_count : 1;
    for (uint32_t i = 0; i < parts; i++) clear_box(&out->boxes[i]);
    for (uint32_t i = 0; i < d->target_count; i++) clear_box(&out->deltas[i]);
    for (size_t v = 0; v < vertex_count; v++) {
        if (!d->joint_count) grow_box(&out->boxes[0], d->bind_positions + 3 * v);
        for (size_t k = 4 * v; k < 4 * v + 4 && d->joint_count; k++)
            if (d->weights[k] > 0) grow_box(&out->boxes[d->joints[k]], d->bind_positions + 3 * v);
        for (size_t t = 0; t < d->target_count; t++)
            grow_box(&out->deltas[t], d->position_deltas + 3 * (t * vertex_count + v));
    }
}

/* The box of what `from` may become, widened by (low, high), under the affine rows m; added to `to`. Rounding
 * aside: a float's, here and in the shader, is covered by a millionth of the largest coordinate. */
static void add_moved_box(const al_box *from, const float low[3], const float high[3], const float *m, al_box *to)
{
    if (!(from->low[0] <= from->high[0])) return; /* nothing hangs on the joint */
    for (int row = 0; row < 3; row++) {
        float least = m[4 * row + 3], most = least, size = fabsf(least);
        for (int k = 0; k < 3; k++) {
            float a = m[4 * row + k] * (from->low[k] + low[k]), b = m[4 * row + k] * (from->high[k] + high[k]);
            least += fminf(a, b);
            most += fmaxf(a, b);
            size += fmaxf(fabsf(a), fabsf(b));
        }
        to->low[row] = fminf(to->low[row], least - 2e-6f * size);
        to->high[row] = fmaxf(to->high[row], most + 2e-6f * size);
    }
}

static void update_box(const al_motion_deform *d, const al_deformed *state, al_model_mesh *mesh)
{
    static const float still[ROW_FLOATS] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    float low[3] = {0}, high[3] = {0};
    const float *weights = state->pose + ROW_FLOATS * (size_t)d->joint_count;
    al_box box;
    clear_box(&box);
    for (uint32_t t = 0; t < d->target_count; t++)
        for (int k = 0; k < 3; k++) {
            float a = weights[t] * state->deltas[t].low[k], b = weights[t] * state->deltas[t].high[k];
            low[k] += fminf(a, b);
            high[k] += fmaxf(a, b);
        }
    for (uint32_t i = 0; i < (d->joint_count ? d->joint_count : 1); i++)
        add_moved_box(&state->boxes[i], low, high, d->joint_count ? state->pose + ROW_FLOATS * (size_t)i : still, &box);
    memcpy(mesh->low, box.low, sizeof box.low);
    memcpy(mesh->high, box.high, sizeof box.high);
    float x = box.high[0] - box.low[0], y = box.high[1] - box.low[1], z = box.high[2] - box.low[2];
    mesh->longest_edge = sqrtf(x * x + y * y + z * z);
}

/* --- at load --- */

static al_status upload(al_runtime *runtime, const al_motion_deform *d, uint32_t vertex_count, al_deformed *out,
                        al_error *error)
{
    uint64_t v = vertex_count, deltas = 12 * v * d->target_count;
    const struct {
        const void *data;
        uint64_t size;
    } sources[AL_DEFORM_BUFFERS] = {{d->bind_positions, 12 * v}, {d->bind_normals, 12 * v}, {d->joints, 8 * v},
                                    {d->weights, 16 * v},        {d->position_deltas, deltas}, {d->normal_deltas, deltas},
                                    {NULL, 4 * out->pose_count}};
    GLint64 limit = 0;
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &limit);
    al_status status = AL_OK;
    for (int i = 0; i < AL_DEFORM_BUFFERS && !status; i++) {
        bool is_pose = i == AL_DEFORM_BUFFERS - 1;
        if (!sources[i].data && !is_pose) continue;
        if (sources[i].size > (uint64_t)limit)
            return al_fail(error, AL_BAD_INPUT, "scene.air: mesh \"%s\": %llu bytes of its morph targets are more than "
                           "this OpenGL's buffers hold, %lld", mesh_of(runtime, d)->name,
                           (unsigned long long)sources[i].size, (long long)limit);
        status = al_gl_buffer_create(&runtime->memory, sources[i].size, sources[i].data, &out->buffers[i], error);
    }
    return status;
}

al_status al_motion_create(al_runtime *runtime, al_error *error)
{
    const al_motion *m = &runtime->scene.motion;
    al_moving *moving = &runtime->moving;
    moving->length_s = al_motion_length_s(m);
    moving->world = calloc(m->node_count + (size_t)1, sizeof *moving->world);
    moving->scratch = calloc(al_motion_width(m), sizeof *moving->scratch);
    moving->deforms = calloc(m->deform_count + (size_t)1, sizeof *moving->deforms);
    if (!moving->world || !moving->scratch || !moving->deforms)
        return al_fail(error, AL_IO, "scene.air: no memory for what moves");
    for (uint32_t i = 0; i < m->deform_count; i++) {
        const al_motion_deform *d = &m->deforms[i];
        al_deformed *out = &moving->deforms[moving->deform_count++];
        uint32_t vertex_count = mesh_of(runtime, d)->vertex_count;
        out->pose_count = ROW_FLOATS * (size_t)d->joint_count + d->target_count;
        out->pose = calloc(out->pose_count + 1, sizeof *out->pose);
        out->palette = calloc(d->joint_count + (size_t)1, sizeof *out->palette);
        out->weights = calloc(d->target_count + (size_t)1, sizeof *out->weights);
        out->boxes = calloc(d->joint_count + (size_t)1, sizeof *out->boxes);
        out->deltas = calloc(d->target_count + (size_t)1, sizeof *out->deltas);
        if (!out->pose || !out->palette || !out->weights || !out->boxes || !out->deltas)
            return al_fail(error, AL_IO, "scene.air: no memory for what moves");
        fill_boxes(d, vertex_count, out);
        al_status status = upload(runtime, d, vertex_count, out, error);
        if (status) return status;
    }
    al_runtime_set_time(runtime, 0);
    return AL_OK;
}

void al_motion_free(al_runtime *runtime)
{
    al_moving *moving = &runtime->moving;
    for (uint32_t i = 0; i < moving->deform_count; i++) {
        al_deformed *d = &moving->deforms[i];
        for (int k = 0; k < AL_DEFORM_BUFFERS; k++) al_gl_buffer_free(&runtime->memory, &d->buffers[k]);
        free(d->pose);
        free(d->palette);
        free(d->weights);
        free(d->boxes);
        free(d->deltas);
    }
    free(moving->deforms);
    free(moving->world);
    free(moving->scratch);
    memset(moving, 0, sizeof *moving);
}

uint64_t al_motion_bytes(const al_runtime *runtime)
{
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < runtime->moving.deform_count; i++)
        for (int k = 0; k < AL_DEFORM_BUFFERS; k++) bytes += runtime->moving.deforms[i].buffers[k].size;
    return bytes;
}

/* --- the time --- */

static void fill_pose(al_runtime *runtime, const al_motion_deform *d, al_deformed *state)
{
    const al_motion *m = &runtime->scene.motion;
    al_motion_weights_at(m, d, runtime->moving.time_s, state->weights);
    al_motion_palette(m, d, (const double(*)[16])runtime->moving.world, state->palette);
    for (uint32_t i = 0; i < d->joint_count; i++)
        for (int k = 0; k < ROW_FLOATS; k++) {
            float number = (float)state->palette[i][k % 4 * 4 + k / 4];
            state->pose[ROW_FLOATS * (size_t)i + (size_t)k] = isfinite(number) ? number : 0;
        }
    for (uint32_t i = 0; i < d->target_count; i++)
        state->pose[ROW_FLOATS * (size_t)d->joint_count + i] = (float)state->weights[i];
}

void al_runtime_set_time(al_runtime *runtime, double seconds)
{
    const al_motion *m = &runtime->scene.motion;
    al_moving *moving = &runtime->moving;
    if (!moving->world || !isfinite(seconds)) return;
    double time_s = al_motion_loop_s(seconds, moving->length_s);
    if (moving->placed && time_s == moving->time_s) return;
    moving->time_s = time_s;
    if (runtime->ended) al_fog_follow(runtime);
    moving->placed = true;
    al_motion_nodes_at(m, time_s, moving->scratch, moving->world);
    al_motion_place(&runtime->scene, (const double(*)[16])moving->world);
    for (uint32_t i = 0; i < m->deform_count; i++) {
        const al_motion_deform *d = &m->deforms[i];
        fill_pose(runtime, d, &moving->deforms[i]);
        update_box(d, &moving->deforms[i], &runtime->model.meshes[runtime->scene.instances[d->instance].mesh]);
    }
    moving->poses += m->deform_count > 0;
}

double al_runtime_duration_s(const al_runtime *runtime)
{
    return runtime->moving.length_s;
}

/* --- vertices --- */

static void pose_vertices(al_runtime *runtime, const al_motion_deform *d, al_deformed *state)
{
    uint32_t count = mesh_of(runtime, d)->vertex_count;
    const al_model_mesh *mesh = &runtime->model.meshes[runtime->scene.instances[d->instance].mesh];
    if (!mesh->vertices.id) return;
    glNamedBufferSubData(state->buffers[AL_DEFORM_BUFFERS - 1].id, 0, (GLsizeiptr)(4 * state->pose_count), state->pose);
    for (GLuint i = 0; i < AL_DEFORM_BUFFERS; i++)
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, i, state->buffers[i].id);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, AL_DEFORM_BUFFERS, mesh->vertices.id);
    glUniform4ui(0, count, d->joint_count, d->target_count, d->has_normals);
    glDispatchCompute((count + GROUP - 1) / GROUP, 1, 1);
}

al_status al_motion_draw(al_draw *draw)
{
    al_runtime *runtime = draw->runtime;
    al_moving *moving = &runtime->moving;
    GLuint program;
    if (moving->posed == moving->poses) return AL_OK;
    al_status status = al_shaders_get(runtime->shaders, "skin.comp", "", &program, draw->error);
    if (status) return status;
    al_timing_begin(&runtime->timing, AL_STAGE_SKIN);
    glUseProgram(program);
    for (uint32_t i = 0; i < moving->deform_count; i++)
        pose_vertices(runtime, &runtime->scene.motion.deforms[i], &moving->deforms[i]);
    glMemoryBarrier(GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
    al_timing_end(&runtime->timing);
    moving->posed = moving->poses;
    return AL_OK;
}
