#version 450 core
// One ray per pixel from the seen surface, and the density in 1/sr with which its direction was drawn. A direction from
// which the surface takes nothing, below it, is kept with its density, but no ray goes there.
//
// Blocks of 4 x 4 pixels share one sequence of pairs, as in bounce_drawn: multiples of the powers of 1/1.3247..., the smallest
// Pisot number, which fill the square evenly at every length (Roberts 2018), begun at random in each block. A sample takes
// sixteen of them, one a pixel, and the sequence goes on through samples and frames.
#extension GL_GOOGLE_include_directive : enable
#include "bounce_receiver.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, rgba32f) writeonly uniform image2D rays; // direction, distance of the origin; 0: none
layout(binding = 1, rgba32f) writeonly uniform image2D arriving; // a: density

vec2 drawn_pair(ivec2 pixel)
{
    uint number = uint(shell_counts.z * bounce_sample.y + bounce_sample.x) << 4 | uint((pixel.y & 3) << 2 | (pixel.x & 3));
    uint bits = hash(uint(pixel.x >> 2), uint(pixel.y >> 2), 0x5bd1e995u);
    return vec2(unit_float(bits + number * 3242174889u), unit_float(mix_bits(bits) + number * 2447445414u));
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, shell_size.zw))) return;
    Receiver r;
    vec4 ray = vec4(0.0);
    float density = 0.0;
    if (receiver_at(pixel, r)) {
        ray.xyz = ray_direction_of(r, drawn_pair(pixel + tile.xy));
        density = ray_density(r, ray.xyz);
        if (received(r, ray.xyz) != vec3(0.0)) ray.w = texelFetch(geometry, pixel, 0).w;
    }
    imageStore(rays, pixel, ray);
    imageStore(arriving, pixel, vec4(0.0, 0.0, 0.0, density));
}
