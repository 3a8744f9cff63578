#version 450 core
// Each triangle's level: as many points as make its surfels no larger than wanted at its nearest point.
#extension GL_GOOGLE_include_directive : enable
#include "surfel_hash.glsl"
#include "surfel_size.glsl"

layout(vertices = 3) out;
layout(location = 5) uniform ivec3 choice; // x: instance
layout(location = 7) uniform bool leave_huge; // they are split
layout(location = 8) uniform uint cloud_seed; // another one places all surfels anew

in vec3 vertex_position[];
in vec2 vertex_uv[];
in uint vertex_key[];
out vec3 corner_position[];
out vec2 corner_uv[];
patch out float fine_area; // m2
patch out uint seed;
patch out float offset; // [0, 1)

void main()
{
    corner_position[gl_InvocationID] = vertex_position[gl_InvocationID];
    corner_uv[gl_InvocationID] = vertex_uv[gl_InvocationID];
    vec3 a = vertex_position[0], b = vertex_position[1], c = vertex_position[2];
    float area = 0.5 * length(cross(b - a, c - a));
    float level = fine_level(area / wanted_area(nearest_distance(a, b, c)));
    bool left_out = !(area > 0.0) || isinf(area) || (leave_huge && split_level(a, b, c) > 0.0);
    gl_TessLevelOuter[0] = gl_TessLevelOuter[1] = gl_TessLevelOuter[2] = left_out ? 0.0 : level;
    gl_TessLevelInner[0] = level;
    fine_area = area / fine_count(level);
    uint which = hash(uvec3(vertex_key[0], vertex_key[1], vertex_key[2])).x;
    uvec3 random = hash(uvec3(choice.x, which, cloud_seed));
    seed = random.x;
    offset = float(random.y >> 8) / 16777216.0;
}
