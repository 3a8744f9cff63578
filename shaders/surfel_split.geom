#version 450 core
// Captures the parts of a huge triangle, three vertices each: world position, uv, and a number that tells the part from
// others, whatever else is split. Vertices are captured as points, as surfels are, because Mesa 22.3 takes a
// paused capture to be of what was captured meanwhile.
#extension GL_GOOGLE_include_directive : enable
#include "surfel_hash.glsl"

layout(triangles) in;
layout(points, max_vertices = 3) out;

in vec3 vertex_position[];
in vec2 vertex_uv[];
in vec2 vertex_share[];
in uint vertex_key[];
layout(xfb_buffer = 0, xfb_stride = 24, xfb_offset = 0) out vec3 part_position;
layout(xfb_buffer = 0, xfb_offset = 12) out vec2 part_uv;
layout(xfb_buffer = 0, xfb_offset = 20) flat out uint part_key;

void main()
{
    vec2 middle = vertex_share[0] + vertex_share[1] + vertex_share[2];
    uint key = hash(uvec3(vertex_key[0], floatBitsToUint(middle))).x;
    for (int i = 0; i < 3; i++) {
        part_position = vertex_position[i];
        part_uv = vertex_uv[i];
        part_key = key;
        EmitVertex();
        EndPrimitive();
    }
}
