#version 450 core
// A fine surfel: somewhere on its triangle, evenly at random, which covers needles as evenly as others (the
// tessellator's own points would stand in rows). The tessellator says which of the triangle's surfels it is, instance
// and primitive say which triangle: so a surfel stays where it is when its triangle is cut more finely.
// AL_PLAIN: the tessellator's own points (Nalbach et al. 2014).
#extension GL_GOOGLE_include_directive : enable
#include "surfel_hash.glsl"
#include "surfel_size.glsl"

layout(triangles, equal_spacing, point_mode) in;
layout(location = 5) uniform ivec3 choice; // z: 1, or -1 where the instance mirrors

in vec3 corner_position[];
in vec2 corner_uv[];
patch in float fine_area;
patch in uint seed;
patch in float offset;

out vec3 fine_position;
out vec3 first_corner; // of the triangle
out vec3 second_corner;
out vec3 third_corner;
out vec3 fine_normal;
out vec2 fine_uv;
out float fine_size;    // m2
out float fine_density; // area in uv per m2
out float fine_random;  // [0, 1), even over the triangle's surfels

float cross2(vec2 a, vec2 b)
{
    return a.x * b.y - a.y * b.x;
}

// Which point of the pattern this is. Ring by ring from inside, each of 3 s points, s segments a side; its corners are
// (1 - 2q, q, q), with q = 2 (n - s) / (6 n), as a segment of the next ring out stands over that corner's 60 degrees.
int pattern_index()
{
    int level = int(gl_TessLevelInner[0] + 0.5);
    float least = min(min(gl_TessCoord.x, gl_TessCoord.y), gl_TessCoord.z);
    int s = level - 2 * int(least * 1.5 * float(level) + 0.5);
    if (s <= 0) return 0;
    ivec3 along = ivec3((gl_TessCoord - least) / (1.0 - 3.0 * least) * float(s) + 0.5); // one is 0, their sum s
    int inside = int(fine_count(float(s - 2)));
    if (along.z == 0 && along.x > 0) return inside + along.y;
    if (along.x == 0 && along.y > 0) return inside + s + along.z;
    return inside + 2 * s + along.x;
}

void main()
{
    int index = pattern_index();
    vec2 random = vec2(hash(uvec3(seed, index, 1u)).xy >> 8) / 16777216.0;
    float root = sqrt(random.x); // even over the triangle (Turk 1990)
    vec3 share = vec3(1.0 - root, root * (1.0 - random.y), root * random.y);
#ifdef AL_PLAIN
    share = gl_TessCoord;
#endif
    vec3 across = cross(corner_position[1] - corner_position[0], corner_position[2] - corner_position[0]);
    fine_position = share.x * corner_position[0] + share.y * corner_position[1] + share.z * corner_position[2];
    fine_uv = share.x * corner_uv[0] + share.y * corner_uv[1] + share.z * corner_uv[2];
    fine_normal = across * (float(choice.z) / length(across));
    fine_density = abs(cross2(corner_uv[1] - corner_uv[0], corner_uv[2] - corner_uv[0])) / length(across);
    first_corner = corner_position[0];
    second_corner = corner_position[1];
    third_corner = corner_position[2];
    fine_size = fine_area;
    fine_random = (float(index) + offset) / fine_count(gl_TessLevelInner[0]);
}
