// The bounced z-buffer (Nalbach et al. 2015) as its passes share it: one ray per pixel, from a place on the pixel's own
// ray into a direction; per level of the shells the nearest surfel that it hits.
#ifndef AL_BOUNCE_GLSL
#define AL_BOUNCE_GLSL

#include "shells.glsl"

layout(std140, binding = 4) uniform Bounce {
    vec4 bounce_reach; // x: radius of the innermost shell in m; y: distance whose square has depth 1, in m; z: what a
                       // disc's area is multiplied by; w: radius beyond which nothing is looked for in m
    ivec4 bounce_sample; // x: number of the sample; y: samples a pixel; z: 1 throws near fragments away; w unused
};

// Which sample of the view ray the pixel's ray begins at, and random bits for its direction. `pixel`: of the view.
int bounce_drawn(ivec2 pixel, out uint bits)
{
    bits = hash(uint(pixel.x), uint(pixel.y), uint(shell_counts.z * bounce_sample.y + bounce_sample.x));
    return min(int(unit_float(bits) * float(shell_counts.y)), shell_counts.y - 1);
}

#endif
