// What the pixel's ray hits first, of all levels.
#ifndef AL_BOUNCE_HITS_GLSL
#define AL_BOUNCE_HITS_GLSL

#include "bounce.glsl"

layout(binding = 5) uniform usampler2DArray hits;
layout(binding = 6) uniform sampler2DArray depths;

// Number of the surfel, from 1; 0: none.
uint nearest_hit(ivec2 pixel, out float distance_m)
{
    uint nearest = 0u;
    float least = 2.0;
    for (int level = 0; level < shell_counts.x; level++) {
        ivec3 texel = ivec3(texel_of_pixel(pixel, level), level);
        float depth = texelFetch(depths, texel, 0).r;
        uint hit = texelFetch(hits, texel, 0).r;
        if (hit == 0u || depth >= least) continue;
        least = depth;
        nearest = hit;
    }
    distance_m = sqrt(least) * bounce_reach.y;
    return nearest;
}

#endif
