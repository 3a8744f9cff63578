#version 450 core
// Keeps what the level drawn last and those before it have found, before the next one is drawn in its place.
#extension GL_GOOGLE_include_directive : enable
#include "bounce_hits.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(location = 0) uniform int level;

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, shell_size.zw))) return;
    imageStore(nearest, pixel, uvec4(nearest_until(pixel, level), 0u, 0u));
}
