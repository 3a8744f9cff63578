#version 450 core
// A fine surfel: somewhere on its triangle, evenly at random, which covers needles as evenly as others (the
// tessellator's own points would stand in rows). The numbers come from instance, primitive and the point's place
// in the pattern, so that a moving camera or object does not deal anew.
#extension GL_GOOGLE_include_directive : enable
#include "surfel_hash.glsl"

layout(triangles, equal_spacing, point_mode) in;
layout(location = 5) uniform ivec4 choice; // w: 1, or -1 where the instance mirrors

in vec3 corner_position[];
in vec2 corner_uv[];
patch in float fine_area;
patch in uint seed;

out vec3 fine_position;
out vec3 fine_normal;
out vec2 fine_uv;
out float fine_size;    // m2
out float fine_density; // area in uv per m2
out float fine_random;  // [0, 1)

float cross2(vec2 a, vec2 b)
{
    return a.x * b.y - a.y * b.x;
}

void main()
{
    vec3 random = vec3(hash(uvec3(seed, floatBitsToUint(gl_TessCoord.xy))) >> 8) / 16777216.0;
    float root = sqrt(random.x); // even over the triangle (Turk 1990)
    vec3 share = vec3(1.0 - root, root * (1.0 - random.y), root * random.y);
    vec3 across = cross(corner_position[1] - corner_position[0], corner_position[2] - corner_position[0]);
    fine_position = share.x * corner_position[0] + share.y * corner_position[1] + share.z * corner_position[2];
    fine_uv = share.x * corner_uv[0] + share.y * corner_uv[1] + share.z * corner_uv[2];
    fine_normal = across * (float(choice.w) / length(across));
    fine_density = abs(cross2(corner_uv[1] - corner_uv[0], corner_uv[2] - corner_uv[0])) / length(across);
    fine_size = fine_area;
    fine_random = random.z;
}
