/* What moves in a scene: a tree of nodes, channels of keys that move them, and what hangs on the nodes.
 *
 *     local(node) = matrix T R S        (T, R, S from the node, or from its channels at the time)
 *     world(node) = world(parent) local(node)
 *
 * An instance that hangs on a node has the world matrix world(node) local, a light or camera its place and
 * axes: it shines or looks along -z, +y is up. Vertices of a deformed instance are, in its object space,
 *
 *     sum_j weight_j world(joint_j) inverse_bind_j (position + sum_t weight_t delta_t),
 *
 * or without joints position + sum_t weight_t delta_t (glTF 2.0, section 3.7). Joints know the world already:
 * an instance that has some hangs on no node and has the world matrix 1, unless a host moves it as a whole.
 * Keys are those of glTF 2.0, appendix C. All of it is computed in double. */
#ifndef AIRLIGHT_MOTION_H
#define AIRLIGHT_MOTION_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

struct al_scene;

typedef struct al_motion_node {
    char *name;
    uint32_t parent; /* below the node's own number, or AL_NO_INDEX */
    float matrix[16]; /* column-major, affine; before T R S, which move inside of it */
    float translation[3], rotation[4] /* quaternion x, y, z, w */, scale[3]; /* where no channel says otherwise */
} al_motion_node;

typedef enum al_motion_path {
    AL_MOTION_TRANSLATION = 0,
    AL_MOTION_ROTATION = 1,
    AL_MOTION_SCALE = 2,
    AL_MOTION_WEIGHTS = 3 /* of the morph targets of the deformed instance that names the node */
} al_motion_path;

typedef enum al_motion_interpolation {
    AL_MOTION_STEP = 0,
    AL_MOTION_LINEAR = 1, /* rotations: slerp along the shorter arc */
    AL_MOTION_CUBIC = 2   /* Hermite: each key is in-tangent, value, out-tangent, tangents per second */
} al_motion_interpolation;

typedef struct al_motion_channel { /* ordered by node, then path; no two of the same */
    uint32_t node, path, interpolation;
    uint32_t key_count, width; /* width: numbers of a value, 3, 4, 3 or as many as there are targets */
    float *times_s;            /* [key_count] from 0, rising */
    float *values;             /* [key_count][cubic: 3][width] */
} al_motion_channel;

typedef enum al_motion_kind {
    AL_MOTION_INSTANCE = 0,
    AL_MOTION_LIGHT = 1,
    AL_MOTION_CAMERA = 2,
    AL_MOTION_FOG = 3 /* al_fog.moved is world(node) local */
} al_motion_kind;

typedef struct al_motion_binding { /* ordered by kind, then index; no two of the same */
    uint32_t kind, index; /* of the scene's instances, lights, cameras or fogs */
    uint32_t node;
    float local[16]; /* its own space to the node's; column-major, affine */
} al_motion_binding;

typedef struct al_motion_joint {
    uint32_t node;
    float inverse_bind[16]; /* column-major, affine */
} al_motion_joint;

typedef struct al_motion_deform { /* ordered by instance; the instance's mesh is nobody else's */
    uint32_t instance;
    uint32_t node; /* whose channel has the targets' weights; AL_NO_INDEX or without such a channel: 0 */
    uint32_t first_joint, joint_count; /* in al_motion.joints; 0: morph targets alone */
    uint32_t target_count;
    bool has_normals;        /* the targets move normals, too */
    float *bind_positions;   /* [vertex_count][3] before anything moves them; the mesh has those of time 0 */
    float *bind_normals;     /* [vertex_count][3] unit */
    uint16_t *joints;        /* [vertex_count][4] below joint_count; NULL without joints */
    float *weights;          /* [vertex_count][4] from 0, sum 1 */
    float *position_deltas;  /* [target_count][vertex_count][3]; NULL without targets */
    float *normal_deltas;    /* the same; NULL without */
} al_motion_deform;

typedef struct al_motion {
    uint32_t node_count, channel_count, binding_count, joint_count, deform_count;
    al_motion_node *nodes;
    al_motion_channel *channels;
    al_motion_binding *bindings;
    al_motion_joint *joints;
    al_motion_deform *deforms;
} al_motion;

/* The time of the last key, where the animation begins anew; 0: nothing moves. */
double al_motion_length_s(const al_motion *motion);
/* The time within [0, length) that `time_s`, any finite number, stands for; 0 when the length is 0. */
double al_motion_loop_s(double time_s, double length_s);

/* The channel's value at a time, [width]: before the first key the first one's, after the last the last one's.
 * Rotations come out with length 1. */
void al_motion_channel_at(const al_motion_channel *channel, double time_s, double *value);
/* Numbers of the widest value; al_motion_nodes_at wants room for them. */
uint32_t al_motion_width(const al_motion *motion);
/* World matrices of all nodes, column-major: world[node_count]; scratch[al_motion_width]. */
void al_motion_nodes_at(const al_motion *motion, double time_s, double *scratch, double (*world)[16]);
/* Puts the instances, lights, cameras and fogs that hang on nodes where the nodes are; cameras keep the distance to
 * what they look at. What would not be finite stays as it was. */
void al_motion_place(struct al_scene *scene, const double (*world)[16]);
/* Weights of the morph targets, [target_count]. */
void al_motion_weights_at(const al_motion *motion, const al_motion_deform *deform, double time_s, double *weights);
/* world(joint) inverse_bind of each joint, [joint_count], column-major. */
void al_motion_palette(const al_motion *motion, const al_motion_deform *deform, const double (*world)[16],
                       double (*palette)[16]);

/* Whether the instance hangs on a node or is deformed. */
bool al_motion_moves(const al_motion *motion, uint32_t instance);

/* The instance's vertices: positions and unit normals, [vertex_count][3] each. palette as above, NULL without
 * joints; weights[target_count]. A normal turns with the cofactors of the blended matrix. */
void al_motion_deform_at(const al_motion_deform *deform, uint32_t vertex_count, const double (*palette)[16],
                         const double *weights, float *positions, float *normals);

#ifdef __cplusplus
}
#endif
#endif
