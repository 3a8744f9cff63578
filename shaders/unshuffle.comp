#version 450 core
// Every pixel's light of every level, back at the pixel's place; with it what the blur divides by: the depletion of the
// ray, so that the medium's outline stays sharp, or 1.
#extension GL_GOOGLE_include_directive : enable
#include "interval_map.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 5) uniform sampler2DArray levels;
layout(binding = 0, rgba32f) writeonly uniform image2DArray unshuffled;

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, shell_size.xy))) return;
    bool inside = all(lessThan(pixel, shell_size.zw));
    float share = !inside ? 0.0 : shell_blur.y != 0 ? texelFetch(interval_ends, pixel, 0).z : 1.0;
    for (int level = 0; level < shell_counts.x; level++) {
        vec3 light = vec3(0.0);
        if (inside) light = texelFetch(levels, ivec3(texel_of_pixel(pixel, level), level), 0).rgb;
        imageStore(unshuffled, ivec3(pixel, level), vec4(light, share));
    }
}
