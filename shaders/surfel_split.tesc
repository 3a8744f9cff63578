#version 450 core
// Only huge triangles go on, with the level that cuts them into smaller ones.
#extension GL_GOOGLE_include_directive : enable
#include "surfel_hash.glsl"
#include "surfel_size.glsl"

layout(vertices = 3) out;

in vec3 vertex_position[];
in vec2 vertex_uv[];
in uint vertex_key[];
out vec3 corner_position[];
out vec2 corner_uv[];
patch out uint whole_key;

void main()
{
    corner_position[gl_InvocationID] = vertex_position[gl_InvocationID];
    corner_uv[gl_InvocationID] = vertex_uv[gl_InvocationID];
    float level = split_level(vertex_position[0], vertex_position[1], vertex_position[2]);
    gl_TessLevelOuter[0] = gl_TessLevelOuter[1] = gl_TessLevelOuter[2] = level;
    gl_TessLevelInner[0] = level;
    whole_key = hash(uvec3(vertex_key[0], vertex_key[1], vertex_key[2])).x;
}
