#version 450 core
// Where the medium starts at least and ends at most among the texels of the mip below, nine of them, so that the last row
// and column of an odd number are not lost; of the first mip, on the pixel's own ray (AL_FIRST). AL_SURFACE: instead of
// the medium, the surface that is seen.
#extension GL_GOOGLE_include_directive : enable
#include "interval_map.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, rg32f) writeonly uniform image2D above;
layout(binding = 5) uniform sampler2D interval_span;
#ifdef AL_SURFACE
layout(binding = 4) uniform sampler2D geometry; // normal, distance; 0: no surface
#endif
layout(location = 0) uniform int mip; // of the nine

vec2 span_of(ivec2 place)
{
    vec4 ends = texelFetch(interval_ends, place, 0);
    if (any(greaterThanEqual(place, shell_size.zw)) || ends.z <= 0.0) return vec2(1e30, 0.0);
    float t = ends.x;
    for (int k = 0; k < shell_counts.y;) {
        uvec4 words = texelFetch(interval_steps, ivec3(place, k >> 4), 0);
        for (int j = 0; j < 16 && k < shell_counts.y; j++, k++) t += interval_step(words, j) * ends.y;
    }
    return vec2(ends.x, t);
}

void main()
{
    ivec2 place = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(place, imageSize(above)))) return;
#if defined(AL_FIRST) && defined(AL_SURFACE)
    float away = all(lessThan(place, shell_size.zw)) ? texelFetch(geometry, place, 0).w : 0.0;
    vec2 span = away > 0.0 ? vec2(away) : vec2(1e30, 0.0);
#elif defined(AL_FIRST)
    vec2 span = span_of(place);
#else
    ivec2 last = textureSize(interval_span, mip) - 1;
    vec2 span = vec2(1e30, 0.0);
    for (int i = 0; i < 9; i++) {
        vec2 one = texelFetch(interval_span, min(2 * place + ivec2(i % 3, i / 3), last), mip).xy;
        span = vec2(min(span.x, one.x), max(span.y, one.y));
    }
#endif
    imageStore(above, place, vec4(span, 0.0, 0.0));
}
