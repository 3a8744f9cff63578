#version 450 core
// The sum of the levels, each from its own mip: light that surfaces send into the medium and the medium to the eye.
// AL_FRONT: the share of it that comes from before the boundary of a translucent object, taken to be that of the
// samples there.
#extension GL_GOOGLE_include_directive : enable
#include "interval_map.glsl"

layout(binding = 5) uniform sampler2DArray levels;
layout(location = 0) out vec4 light;
#ifdef AL_FRONT
layout(binding = 6) uniform sampler2D boundary; // w distance, negative: the eye is inside, 0 none
layout(location = 1) out vec4 kept;             // stays as it is

float share_before(ivec2 pixel, float distance_m)
{
    vec4 ends = texelFetch(interval_ends, pixel, 0);
    uvec4 words;
    float t = ends.x;
    for (int k = 0; k < shell_counts.y; k++) {
        if ((k & 15) == 0) words = texelFetch(interval_steps, ivec3(pixel, k >> 4), 0);
        float step = interval_step(words, k) * ends.y;
        if (t + step > distance_m)
            return (float(k) + clamp((distance_m - t) / max(step, 1e-30), 0.0, 1.0)) / float(shell_counts.y);
        t += step;
    }
    return 1.0;
}
#endif

// A mip as a quadratic B-spline through its texels: nine weighted as the pixel lies among them, no seams in the slope.
vec4 smooth_texel(int level, int mip, vec2 pixel)
{
    vec2 place = pixel / float(1 << mip);
    ivec2 middle = ivec2(floor(place)), last = textureSize(levels, mip).xy - 1;
    vec2 f = place - vec2(middle); // in [0, 1) across the middle texel
    vec2 w[3] = vec2[](0.5 * (1.0 - f) * (1.0 - f), 0.5 + f * (1.0 - f), 0.5 * f * f);
    vec4 sum = vec4(0.0);
    for (int y = 0; y < 3; y++)
        for (int x = 0; x < 3; x++) {
            ivec2 at = clamp(middle + ivec2(x, y) - 1, ivec2(0), last);
            sum += w[x].x * w[y].y * texelFetch(levels, ivec3(at, level), mip);
        }
    return sum;
}

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depletion = texelFetch(interval_ends, pixel, 0).z;
    light = vec4(0.0);
#ifdef AL_FRONT
    kept = vec4(0.0);
#endif
    if (depletion <= 0.0) return;
    for (int level = 0; level < textureSize(levels, 0).z; level++) {
        int mip = shell_blur.x < 0 ? 0 : level + shell_blur.x;
        vec4 texel = mip == 0 ? texelFetch(levels, ivec3(pixel, level), 0) : smooth_texel(level, mip, gl_FragCoord.xy);
        light.rgb += texel.rgb / max(texel.a, 1e-30);
    }
    if (shell_blur.y != 0) light.rgb *= depletion;
#ifdef AL_FRONT
    light.rgb *= share_before(pixel, max(texelFetch(boundary, pixel, 0).w, 0.0));
#endif
}
