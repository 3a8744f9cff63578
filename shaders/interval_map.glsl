// The view's transmittance interval map, as its readers see it. Per pixel and sample one byte: its square is the distance
// from the sample before (the first one: from where the medium starts) in units of the pixel.
#ifndef AL_INTERVAL_MAP_GLSL
#define AL_INTERVAL_MAP_GLSL

#include "shells.glsl"

layout(binding = 2) uniform usampler2DArray interval_steps; // 16 samples a layer
layout(binding = 3) uniform sampler2D interval_ends;        // start of the medium and unit in m, depletion of the
                                                            // ray (0: no medium), largest coefficient in 1/m
#if defined(AL_WEIGHTS)
layout(binding = 4) uniform sampler2DArray interval_weights; // rgb: weight / 3; a: number of the medium / 255
#elif defined(AL_COEFFICIENTS)
layout(binding = 4) uniform usampler2DArray interval_coefficients; // 16 samples a layer, over the largest
#endif

float interval_byte(uvec4 words, int k)
{
    return float(words[(k >> 2) & 3] >> uint(8 * (k & 3)) & 255u);
}

float interval_step(uvec4 words, int k)
{
    float root = interval_byte(words, k);
    return root * root;
}

#endif
