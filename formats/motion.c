#include "airlight/motion.h"

#include <math.h>
#include <string.h>

#include "airlight/scene.h"

enum { STORED = 3, VALUE = 1, OUT = 2 }; /* of a cubic key: in-tangent, value, out-tangent */

/* --- time --- */

double al_motion_length_s(const al_motion *motion)
{
    double last = 0;
    for (uint32_t i = 0; i < motion->channel_count; i++) {
        const al_motion_channel *c = &motion->channels[i];
        if (c->key_count) last = fmax(last, c->times_s[c->key_count - 1]);
    }
    return last;
}

double al_motion_loop_s(double time_s, double length_s)
{
    if (!(length_s > 0) || !isfinite(time_s)) return 0;
    double rest = fmod(time_s, length_s);
    if (rest < 0) rest += length_s;
    return rest < length_s ? rest : 0; /* a tiny negative rest rounds up to the length */
}

/* --- keys --- */

/* The last key that is not after the time; the first one before all keys. */
static uint32_t key_before(const al_motion_channel *c, double time_s)
{
    uint32_t low = 0, high = c->key_count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (c->times_s[middle] <= time_s)
            low = middle;
        else
            high = middle;
    }
    return low;
}

static const float *key(const al_motion_channel *c, uint32_t index, int part)
{
    size_t width = c->width;
    return c->interpolation == AL_MOTION_CUBIC ? c->values + (STORED * (size_t)index + (size_t)part) * width
                                               : c->values + index * width;
}

/* Length 1; a quaternion without a length turns nothing. */
static void unit_quaternion(double q[4])
{
    double largest = 0, square = 0;
    for (int i = 0; i < 4; i++) largest = fmax(largest, fabs(q[i]));
    for (int i = 0; i < 4 && largest > 0; i++) square += q[i] / largest * (q[i] / largest);
    for (int i = 0; i < 4; i++) q[i] = largest > 0 ? q[i] / largest / sqrt(square) : i == 3;
}

/* Shoemake 1985: sin((1-t) a)/sin a p + sin(t a)/sin a q, a the angle between them; q and -q turn the same, the
 * nearer one is meant. Where sin a has no digits left the straight line is as good. */
static void slerp(const float *from, const float *to, double t, double out[4])
{
    double p[4], q[4], cosine = 0;
    for (int i = 0; i < 4; i++) p[i] = from[i], q[i] = to[i];
    unit_quaternion(p);
    unit_quaternion(q);
    for (int i = 0; i < 4; i++) cosine += p[i] * q[i];
    double sign = cosine < 0 ? -1 : 1, angle = acos(fmin(1, fabs(cosine))), sine = sin(angle);
    double a = sine > 1e-9 ? sin((1 - t) * angle) / sine : 1 - t, b = sine > 1e-9 ? sin(t * angle) / sine : t;
    for (int i = 0; i < 4; i++) out[i] = a * p[i] + sign * b * q[i];
}

/* glTF 2.0, C.5: v(t) = (2t^3-3t^2+1) v0 + d(t^3-2t^2+t) b0 + (-2t^3+3t^2) v1 + d(t^3-t^2) a1, d the time
 * between the keys, b the out-tangent of the first and a the in-tangent of the second. */
static void hermite(const al_motion_channel *c, uint32_t k, double t, double step_s, double *out)
{
    const float *v0 = key(c, k, VALUE), *b0 = key(c, k, OUT), *a1 = key(c, k + 1, 0), *v1 = key(c, k + 1, VALUE);
    double t2 = t * t, t3 = t2 * t;
    for (uint32_t i = 0; i < c->width; i++)
        out[i] = (2 * t3 - 3 * t2 + 1) * v0[i] + step_s * (t3 - 2 * t2 + t) * b0[i] + (3 * t2 - 2 * t3) * v1[i] +
                 step_s * (t3 - t2) * a1[i];
}

void al_motion_channel_at(const al_motion_channel *c, double time_s, double *value)
{
    uint32_t k = key_before(c, time_s);
    const float *here = key(c, k, VALUE);
    bool between = k + 1 < c->key_count && time_s > c->times_s[k];
    for (uint32_t i = 0; i < c->width; i++) value[i] = here[i];
    if (between && c->interpolation != AL_MOTION_STEP) {
        double step_s = (double)c->times_s[k + 1] - c->times_s[k], t = (time_s - c->times_s[k]) / step_s;
        const float *next = key(c, k + 1, VALUE);
        if (c->interpolation == AL_MOTION_CUBIC)
            hermite(c, k, t, step_s, value);
        else if (c->path == AL_MOTION_ROTATION)
            slerp(here, next, t, value);
        else
            for (uint32_t i = 0; i < c->width; i++) value[i] = (1 - t) * here[i] + t * next[i];
    }
    if (c->path == AL_MOTION_ROTATION) unit_quaternion(value);
}

uint32_t al_motion_width(const al_motion *motion)
{
    uint32_t width = 4;
    for (uint32_t i = 0; i < motion->channel_count; i++)
        if (motion->channels[i].width > width) width = motion->channels[i].width;
    return width;
}

/* --- nodes --- */

static void multiply(const double a[16], const double b[16], double out[16])
{
    double product[16];
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 4; row++) {
            product[4 * column + row] = 0;
            for (int k = 0; k < 4; k++) product[4 * column + row] += a[4 * k + row] * b[4 * column + k];
        }
    memcpy(out, product, sizeof product);
}

static void multiply_float(const double a[16], const float b[16], double out[16])
{
    double wide[16];
    for (int i = 0; i < 16; i++) wide[i] = b[i];
    multiply(a, wide, out);
}

typedef struct placement {
    double translation[3], rotation[4], scale[3];
} placement;

/* Column-major T R S. */
static void compose(const placement *p, double m[16])
{
    const double *q = p->rotation, x = q[0], y = q[1], z = q[2], w = q[3];
    const double columns[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)},
                                  {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)},
                                  {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)}};
    for (int column = 0; column < 3; column++) {
        for (int row = 0; row < 3; row++) m[4 * column + row] = columns[column][row] * p->scale[column];
        m[4 * column + 3] = 0;
        m[12 + column] = p->translation[column];
    }
    m[15] = 1;
}

/* Channels of one node follow each other. */
static void place_node(const al_motion *motion, uint32_t index, double time_s, uint32_t *next, double *scratch,
                       placement *p)
{
    const al_motion_node *node = &motion->nodes[index];
    for (int i = 0; i < 3; i++) p->translation[i] = node->translation[i], p->scale[i] = node->scale[i];
    for (int i = 0; i < 4; i++) p->rotation[i] = node->rotation[i];
    unit_quaternion(p->rotation);
    for (; *next < motion->channel_count && motion->channels[*next].node == index; ++*next) {
        const al_motion_channel *c = &motion->channels[*next];
        if (c->path == AL_MOTION_WEIGHTS) continue;
        al_motion_channel_at(c, time_s, scratch);
        double *to = c->path == AL_MOTION_TRANSLATION ? p->translation
                     : c->path == AL_MOTION_ROTATION  ? p->rotation
                                                      : p->scale;
        memcpy(to, scratch, c->width * sizeof *to);
    }
}

void al_motion_nodes_at(const al_motion *motion, double time_s, double *scratch, double (*world)[16])
{
    uint32_t next = 0;
    for (uint32_t i = 0; i < motion->node_count; i++) {
        const al_motion_node *node = &motion->nodes[i];
        placement p;
        double own[16];
        place_node(motion, i, time_s, &next, scratch, &p);
        compose(&p, own);
        for (int k = 0; k < 16; k++) world[i][k] = node->matrix[k];
        multiply(world[i], own, world[i]);
        if (node->parent != AL_NO_INDEX) multiply(world[node->parent], world[i], world[i]);
    }
}

/* --- what hangs on them --- */

static bool is_finite(const float *numbers, int count)
{
    for (int i = 0; i < count; i++)
        if (!isfinite(numbers[i])) return false;
    return true;
}

/* The unit vector along column `axis` of a matrix, times `sign`; false where it has no length. */
static bool axis_of(const double m[16], int axis, double sign, float out[3])
{
    const double *v = m + 4 * axis;
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int i = 0; i < 3; i++) out[i] = (float)(sign * v[i] / length);
    return length > 0 && isfinite(length);
}

static void place_light(al_light *light, const double m[16])
{
    float vector[3] = {(float)m[12], (float)m[13], (float)m[14]};
    bool good = light->type == AL_LIGHT_POINT || axis_of(m, 2, -1, vector);
    if (good && is_finite(vector, 3)) memcpy(light->vector, vector, sizeof vector);
}

static void place_camera(al_camera *camera, const double m[16])
{
    float forward[3], up[3], position[3], target[3];
    double square = 0;
    bool good = axis_of(m, 2, -1, forward) && axis_of(m, 1, 1, up);
    for (int i = 0; i < 3; i++) {
        double along = (double)camera->target[i] - camera->position[i];
        square += along * along;
    }
    for (int i = 0; i < 3; i++) {
        position[i] = (float)m[12 + i];
        target[i] = (float)(m[12 + i] + sqrt(square) * forward[i]);
    }
    if (!good || !is_finite(position, 3) || !is_finite(target, 3) || !memcmp(position, target, sizeof target)) return;
    memcpy(camera->position, position, sizeof position);
    memcpy(camera->target, target, sizeof target);
    memcpy(camera->up, up, sizeof up);
}

void al_motion_place(struct al_scene *scene, const double (*world)[16])
{
    for (uint32_t i = 0; i < scene->motion.binding_count; i++) {
        const al_motion_binding *b = &scene->motion.bindings[i];
        double m[16];
        float matrix[16];
        multiply_float(world[b->node], b->local, m);
        for (int k = 0; k < 16; k++) matrix[k] = (float)m[k];
        if (b->kind == AL_MOTION_LIGHT)
            place_light(&scene->lights[b->index], m);
        else if (b->kind == AL_MOTION_CAMERA)
            place_camera(&scene->cameras[b->index], m);
        else if (is_finite(matrix, 16))
            memcpy(b->kind == AL_MOTION_FOG ? scene->fogs[b->index].moved : scene->instances[b->index].world, matrix,
                   sizeof matrix);
    }
}

void al_motion_weights_at(const al_motion *motion, const al_motion_deform *deform, double time_s, double *weights)
{
    memset(weights, 0, deform->target_count * sizeof *weights);
    for (uint32_t i = 0; i < motion->channel_count && deform->node != AL_NO_INDEX; i++) {
        const al_motion_channel *c = &motion->channels[i];
        if (c->node == deform->node && c->path == AL_MOTION_WEIGHTS && c->width == deform->target_count)
            al_motion_channel_at(c, time_s, weights);
    }
}

void al_motion_palette(const al_motion *motion, const al_motion_deform *deform, const double (*world)[16],
                       double (*palette)[16])
{
    for (uint32_t i = 0; i < deform->joint_count; i++) {
        const al_motion_joint *joint = &motion->joints[deform->first_joint + i];
        multiply_float(world[joint->node], joint->inverse_bind, palette[i]);
    }
}

bool al_motion_moves(const al_motion *motion, uint32_t instance)
{
    for (uint32_t i = 0; i < motion->binding_count; i++)
        if (motion->bindings[i].kind == AL_MOTION_INSTANCE && motion->bindings[i].index == instance) return true;
    for (uint32_t i = 0; i < motion->deform_count; i++)
        if (motion->deforms[i].instance == instance) return true;
    return false;
}

/* --- vertices --- */

static void morph(const float *bind, const float *deltas, uint32_t targets, uint32_t vertices, uint32_t vertex,
                  const double *weights, double out[3])
{
    for (int i = 0; i < 3; i++) out[i] = bind[3 * (size_t)vertex + (size_t)i];
    for (uint32_t t = 0; t < targets && deltas; t++)
        for (int i = 0; i < 3; i++) out[i] += weights[t] * deltas[3 * ((size_t)t * vertices + vertex) + (size_t)i];
}

static void blend(const al_motion_deform *deform, uint32_t vertex, const double (*palette)[16], double m[16])
{
    memset(m, 0, sizeof(double[16]));
    for (int k = 0; k < 4; k++)
        for (int i = 0; i < 16; i++)
            m[i] += deform->weights[4 * (size_t)vertex + (size_t)k] *
                    palette[deform->joints[4 * (size_t)vertex + (size_t)k]][i];
}

/* Columns i+1 x i+2 of the upper 3x3 part: what normals turn with. */
static void turn_normal(const double m[16], double n[3])
{
    double turned[3] = {0};
    for (int column = 0; column < 3; column++) {
        const double *a = m + 4 * ((column + 1) % 3), *b = m + 4 * ((column + 2) % 3);
        for (int row = 0; row < 3; row++)
            turned[row] += n[column] * (a[(row + 1) % 3] * b[(row + 2) % 3] - a[(row + 2) % 3] * b[(row + 1) % 3]);
    }
    memcpy(n, turned, sizeof turned);
}

static void store_unit(const double n[3], const float *otherwise, float *out)
{
    double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    bool good = length > 0 && isfinite(length);
    for (int i = 0; i < 3; i++) out[i] = good ? (float)(n[i] / length) : otherwise[i];
}

void al_motion_deform_at(const al_motion_deform *deform, uint32_t vertex_count, const double (*palette)[16],
                         const double *weights, float *positions, float *normals)
{
    for (uint32_t v = 0; v < vertex_count; v++) {
        double p[3], n[3], m[16], moved[3];
        morph(deform->bind_positions, deform->position_deltas, deform->target_count, vertex_count, v, weights, p);
        morph(deform->bind_normals, deform->normal_deltas, deform->target_count, vertex_count, v, weights, n);
        if (deform->joint_count) {
            blend(deform, v, palette, m);
            for (int i = 0; i < 3; i++) moved[i] = m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2] + m[12 + i];
            memcpy(p, moved, sizeof p);
            turn_normal(m, n);
        }
        for (int i = 0; i < 3; i++) positions[3 * (size_t)v + (size_t)i] = (float)p[i];
        store_unit(n, deform->bind_normals + 3 * (size_t)v, normals + 3 * (size_t)v);
    }
}
