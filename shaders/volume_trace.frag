#version 450 core
// Whether the pixel's ray meets the triangle whose occlusion volume its place may be in; the depth test keeps the nearest.
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"
#include "bounce.glsl"
#include "triangle.glsl"

layout(binding = 2) uniform sampler2D rays; // direction, distance of the origin; 0: none
layout(binding = 3) uniform sampler2D geometry; // normal, distance

flat in vec3 corner[3];
flat in int number;
layout(location = 0) out uint hit; // number of the triangle, from 1

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 ray = texelFetch(rays, pixel, 0);
    if (ray.w == 0.0) discard;
    vec3 origin, view, m, normal = texelFetch(geometry, pixel, 0).xyz;
    float height;
    view_ray(view_pixel(vec2(pixel) + 0.5), origin, view);
    origin += ray.w * view;
    vec3 from[3] = vec3[3](corner[0] - origin, corner[1] - origin, corner[2] - origin);
    if (!may_hide(from, normal, ray.w + length(origin), m, height)) discard;
    float t = meet_triangle(from[0], from[1], from[2], ray.xyz);
    if (!(t > 0.0) || t > bounce_reach.w) discard;
    hit = uint(number) + 1u;
    gl_FragDepth = min(t * t / (bounce_reach.y * bounce_reach.y), 1.0);
}
