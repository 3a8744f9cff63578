#version 450 core
// Vertices of a skinned or morphed instance at the time that is shown, written over those of its vertex array:
//   p' = sum_j w_j M_j (p + sum_t m_t dp_t),   n' = cof(sum_j w_j M_j) (n + sum_t m_t dn_t), made unit,
// M_j = world(joint) inverse bind matrix, w the vertex's weights, m those of the morph targets (glTF 2.0,
// section 3.7). cof is the cofactor matrix: what normals turn with under any invertible transform. Without
// joints the matrix is 1. formats/motion.c has the same in double.
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer BindPositions { float bind_positions[]; }; // [vertex][3] metres
layout(std430, binding = 1) readonly buffer BindNormals { float bind_normals[]; };
layout(std430, binding = 2) readonly buffer Joints { uvec2 joints[]; }; // four numbers of 16 bits
layout(std430, binding = 3) readonly buffer Weights { vec4 weights[]; };
layout(std430, binding = 4) readonly buffer PositionDeltas { float position_deltas[]; }; // [target][vertex][3]
layout(std430, binding = 5) readonly buffer NormalDeltas { float normal_deltas[]; };
layout(std430, binding = 6) readonly buffer Pose { float pose[]; }; // M row by row [joint][3][4], then m [target]
layout(std430, binding = 7) buffer Vertices { float vertices[]; };  // [vertex][8] position, normal, uv
// vertices, joints, targets, 1 where the targets move normals
layout(location = 0) uniform uvec4 counts;

vec3 triple(uint vertex, bool normal, uint target)
{
    uint at = 3u * (target * counts.x + vertex);
    return normal ? vec3(normal_deltas[at], normal_deltas[at + 1u], normal_deltas[at + 2u])
                  : vec3(position_deltas[at], position_deltas[at + 1u], position_deltas[at + 2u]);
}

vec4 row(uint joint, uint index)
{
    uint at = 12u * joint + 4u * index;
    return vec4(pose[at], pose[at + 1u], pose[at + 2u], pose[at + 3u]);
}

void main()
{
    uint v = gl_GlobalInvocationID.x;
    if (v >= counts.x) return;
    vec3 bound = vec3(bind_normals[3u * v], bind_normals[3u * v + 1u], bind_normals[3u * v + 2u]), normal = bound;
    vec3 position = vec3(bind_positions[3u * v], bind_positions[3u * v + 1u], bind_positions[3u * v + 2u]);
    for (uint t = 0u; t < counts.z; t++) {
        float share = pose[12u * counts.y + t];
        position += share * triple(v, false, t);
        if (counts.w == 1u) normal += share * triple(v, true, t);
    }
    if (counts.y > 0u) {
        vec4 x = vec4(0.0), y = vec4(0.0), z = vec4(0.0); // rows of the blended matrix
        for (uint k = 0u; k < 4u; k++) {
            uint joint = bitfieldExtract(joints[v][k >> 1], int(k & 1u) * 16, 16);
            x += weights[v][k] * row(joint, 0u);
            y += weights[v][k] * row(joint, 1u);
            z += weights[v][k] * row(joint, 2u);
        }
        vec4 p = vec4(position, 1.0);
        position = vec3(dot(x, p), dot(y, p), dot(z, p));
        // Rows of the cofactor matrix are cross products of the matrix's rows.
        normal = vec3(dot(cross(y.xyz, z.xyz), normal), dot(cross(z.xyz, x.xyz), normal),
                      dot(cross(x.xyz, y.xyz), normal));
    }
    float size = length(normal);
    normal = size > 0.0 && !isinf(size) ? normal / size : bound;
    vertices[8u * v] = position.x;
    vertices[8u * v + 1u] = position.y;
    vertices[8u * v + 2u] = position.z;
    vertices[8u * v + 3u] = normal.x;
    vertices[8u * v + 4u] = normal.y;
    vertices[8u * v + 5u] = normal.z;
}
