// The bounced z-buffer (Nalbach et al. 2015) as its passes share it: one ray per pixel, from a place on the pixel's own
// ray into a direction, in the medium or on the surface seen; per level of the shells the nearest surfel that it hits.
#ifndef AL_BOUNCE_GLSL
#define AL_BOUNCE_GLSL

#include "shells.glsl"

layout(std140, binding = 4) uniform Bounce {
    vec4 bounce_reach; // x: radius of the innermost shell in m; y: distance whose square has depth 1, in m; z: what a
                       // disc's area is multiplied by; w: distance beyond which nothing is hit in m
    ivec4 bounce_sample; // x: number of the sample; y: samples a pixel; z: 1 throws near fragments away; w: pixels that the
                         // light on surfaces is filtered over to each side
};

// Which sample of the view ray the pixel's ray begins at, and two numbers in [0, 1) for its direction. `pixel`: of the view.
//
// Blocks of 4 x 4 pixels share one additive sequence, number n of it is (shift + n a) mod 1, with a the powers of 1/x,
// x^4 = x + 1, which fill the cube evenly (Roberts 2018), and a shift drawn per block. A frame's sample takes sixteen numbers,
// one a pixel: a pixel's samples over the frames are as even as those of its block, over which the blur takes the mean.
int bounce_drawn(ivec2 pixel, out vec2 turn)
{
    uint block = hash(uint(pixel.x >> 2), uint(pixel.y >> 2), 0u);
    uint n = uint(shell_counts.z * bounce_sample.y + bounce_sample.x) << 4 | uint((pixel.y & 3) << 2 | (pixel.x & 3));
    turn = vec2(unit_float(mix_bits(block ^ 0x68bc21ebu) + n * 0xabc98389u),
                unit_float(mix_bits(block ^ 0x02e5be93u) + n * 0x8cb92ba7u));
    return min(int(unit_float(block + n * 0xd1b54a33u) * float(shell_counts.y)), shell_counts.y - 1);
}

#endif
