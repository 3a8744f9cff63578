#version 450 core
// The intermediate pictures of shell splatting: a level as it was splatted, or where the view's samples lie.
#extension GL_GOOGLE_include_directive : enable
#include "interval_map.glsl"

layout(binding = 5) uniform sampler2DArray levels;
layout(location = 0) uniform ivec2 choice; // 0 distances of the first, middle and last sample, 1 depletion, 2 level; which
layout(location = 0) out vec4 value;

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    value = vec4(0.0, 0.0, 0.0, 1.0);
    if (choice.x == 2) {
        value.rgb = texelFetch(levels, ivec3(pixel, choice.y), 0).rgb;
        return;
    }
    vec4 ends = texelFetch(interval_ends, pixel, 0);
    if (ends.z <= 0.0) return;
    value.rgb = ends.zzz;
    if (choice.x == 1) return;
    uvec4 words;
    float t = ends.x;
    for (int k = 0; k < shell_counts.y; k++) {
        if ((k & 15) == 0) words = texelFetch(interval_steps, ivec3(pixel, k >> 4), 0);
        t += interval_byte(words, k) * ends.y;
        if (k == 0) value.r = t;
        if (2 * k <= shell_counts.y) value.g = t;
        value.b = t;
    }
}
