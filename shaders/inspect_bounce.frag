#version 450 core
// The bounced z-buffer of the last sample: each pixel's ray, d * 0.5 + 0.5, or how far along it the nearest surfel is, m;
// black where there is none.
#extension GL_GOOGLE_include_directive : enable
#include "bounce_hits.glsl"

layout(location = 0) uniform int choice; // 0: rays, 1: distances
layout(binding = 2) uniform sampler2D rays; // direction, distance of the origin; 0: none
layout(location = 0) out vec4 value;

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 ray = texelFetch(rays, pixel, 0);
    value = vec4(0.0, 0.0, 0.0, 1.0);
    if (ray.w == 0.0) return;
    float distance_m;
    if (choice == 0) value.rgb = 0.5 * ray.xyz + 0.5;
    else if (nearest_hit(pixel, distance_m) != 0u) value.rgb = vec3(distance_m);
}
