// What the pixel's ray hits first, of all levels. They are drawn one after the other into the same textures, and what they
// found is kept beside, so that not every level needs room of its own.
#ifndef AL_BOUNCE_HITS_GLSL
#define AL_BOUNCE_HITS_GLSL

#include "bounce.glsl"

layout(binding = 5) uniform usampler2DArray hits;  // of the level drawn last
layout(binding = 6) uniform sampler2DArray depths; // likewise
layout(binding = 3, rg32ui) uniform uimage2D nearest; // of the levels before: number of the surfel, from 1, 0: none; depth's bits

// Of levels up to the one drawn last; as `nearest`. Depths are not negative, so that their bits are ordered as they are.
uvec2 nearest_until(ivec2 pixel, int level)
{
    ivec3 texel = ivec3(texel_of_pixel(pixel, level), 0);
    uvec2 found = uvec2(texelFetch(hits, texel, 0).r, floatBitsToUint(texelFetch(depths, texel, 0).r));
    if (level == 0) return found;
    uvec2 before = imageLoad(nearest, pixel).xy;
    return found.x == 0u || (before.x != 0u && before.y <= found.y) ? before : found;
}

// Number of the surfel, from 1; 0: none.
uint nearest_hit(ivec2 pixel, out float distance_m)
{
    uvec2 found = nearest_until(pixel, shell_counts.x - 1);
    distance_m = sqrt(uintBitsToFloat(found.y)) * bounce_reach.y;
    return found.x;
}

#endif
