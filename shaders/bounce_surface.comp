#version 450 core
// One ray per pixel from the seen surface, and the density in 1/sr with which its direction was drawn. A direction from
// which the surface takes nothing, below it, is kept with its density, but no ray goes there.
//
// The pairs are a lattice over pixels and samples: x (g, g^2) + y (g^3, g^4) + n (h, h^2) mod 1, with g = 1/1.1673... and
// h = 1/1.3247..., the roots of g^5 + g^4 = 1 and h^3 + h^2 = 1 that Roberts (2018) takes to fill four and two dimensions evenly.
// Those of one pixel over samples and frames, and those of any window of pixels, cover the square without clumps.
#extension GL_GOOGLE_include_directive : enable
#include "bounce_receiver.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, rgba32f) writeonly uniform image2D rays; // direction, distance of the origin; 0: none
layout(binding = 1, rgba32f) writeonly uniform image2D arriving; // a: density

vec2 drawn_pair(ivec2 pixel)
{
    uint number = uint(shell_counts.z * bounce_sample.y + bounce_sample.x);
    uvec2 bits = uint(pixel.x) * uvec2(3679390609u, 3152041523u) + uint(pixel.y) * uvec2(2700274806u, 2313257605u) +
                 number * uvec2(3242174889u, 2447445414u);
    return vec2(unit_float(bits.x), unit_float(bits.y));
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
