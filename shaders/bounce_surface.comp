#version 450 core
// One ray per pixel from the seen surface, and the density in 1/sr with which its direction was drawn.
//
// Ambient occlusion: over the hemisphere as the cosine, or evenly as published (AL_UNIFORM).
//
// The pixel's sequence of pairs goes on through samples and frames: multiples of the powers of 1/1.3247..., the
// smallest Pisot number, which fill the square evenly at every length (Roberts 2018), begun at random in each pixel.
#extension GL_GOOGLE_include_directive : enable
#include "formulas.glsl"
#include "frame.glsl"
#include "bounce.glsl"
#include "turned.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 3) uniform sampler2D geometry; // normal, distance; 0: no surface
layout(binding = 0, rgba32f) writeonly uniform image2D rays; // direction, distance of the origin; 0: none
layout(binding = 1, rgba32f) writeonly uniform image2D arriving; // a: density

vec2 drawn_pair(ivec2 pixel)
{
    uint number = uint(shell_counts.z) * uint(bounce_sample.y) + uint(bounce_sample.x);
    uint bits = hash(uint(pixel.x), uint(pixel.y), 0x5bd1e995u);
    return vec2(unit_float(bits + number * 3242174889u), unit_float(mix_bits(bits) + number * 2447445414u));
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, shell_size.zw))) return;
    vec4 place = texelFetch(geometry, pixel, 0), ray = vec4(0.0);
    float density = 0.0;
    if (place.w > 0.0 && dot(place.xyz, place.xyz) > 0.25) { // a host's surface has no normal
        vec2 u = drawn_pair(pixel + tile.xy);
#ifdef AL_UNIFORM
        float cosine = 1.0 - u.x;
        density = 0.5 / AL_PI;
#else
        float cosine = sqrt(1.0 - u.x);
        density = cosine / AL_PI;
#endif
        ray = vec4(turned(place.xyz, cosine, u.y), place.w);
    }
    imageStore(rays, pixel, ray);
    imageStore(arriving, pixel, vec4(0.0, 0.0, 0.0, density));
}
