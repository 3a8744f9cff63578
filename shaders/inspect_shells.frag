#version 450 core
// The intermediate pictures of shell splatting: a level as it was splatted, unshuffled or blurred, or where the view's
// samples lie; and a layer of the shadow maps.
#extension GL_GOOGLE_include_directive : enable
#include "interval_map.glsl"

layout(binding = 5) uniform sampler2DArray levels;
// x: 0 distances of the first, middle and last sample, 1 depletion, 2 level, 3 unshuffled, 4 blurred, 5 shadow map; y:
// which level or layer
layout(location = 0) uniform ivec2 choice;
layout(location = 1) uniform vec2 tile_size;
layout(location = 0) out vec4 value;

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    value = vec4(0.0, 0.0, 0.0, 1.0);
    if (choice.x == 5) value.rgb = textureLod(levels, vec3(gl_FragCoord.xy / tile_size, float(choice.y)), 0.0).rrr;
    if (choice.x == 2 || choice.x == 3) value.rgb = texelFetch(levels, ivec3(pixel, choice.y), 0).rgb;
    if (choice.x == 4) {
        int mip = choice.y + max(shell_blur.x, -choice.y);
        vec4 texel = texelFetch(levels, ivec3(pixel >> mip, choice.y), mip);
        value.rgb = texel.rgb / max(texel.a, 1e-30);
        if (shell_blur.y != 0) value.rgb *= texelFetch(interval_ends, pixel, 0).z;
    }
    if (choice.x >= 2) return;
    vec4 ends = texelFetch(interval_ends, pixel, 0);
    if (ends.z <= 0.0) return;
    value.rgb = ends.zzz;
    if (choice.x == 1) return;
    uvec4 words;
    float t = ends.x;
    for (int k = 0; k < shell_counts.y; k++) {
        if ((k & 15) == 0) words = texelFetch(interval_steps, ivec3(pixel, k >> 4), 0);
        t += interval_step(words, k) * ends.y;
        if (k == 0) value.r = t;
        if (2 * k <= shell_counts.y) value.g = t;
        value.b = t;
    }
}
