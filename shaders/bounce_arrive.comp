#version 450 core
// What arrives along the pixel's ray. Ambient occlusion: 1 where it meets no surface within the radius.
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"
#include "bounce_hits.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 1, rgba32f) uniform image2D arriving; // a: density, 0: no ray

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, shell_size.zw))) return;
    float density = imageLoad(arriving, pixel).a, distance_m;
    if (density == 0.0) return;
    bool open = nearest_hit(pixel, distance_m) == 0u || distance_m > bounce_reach.w;
    imageStore(arriving, pixel, vec4(vec3(open ? 1.0 : 0.0), density));
}
