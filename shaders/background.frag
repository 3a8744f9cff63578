#version 450 core
// First of a tile: the host's own depth as ours, and the background where the host drew nothing.
#extension GL_GOOGLE_include_directive : enable
#include "environment.glsl"

layout(binding = 2) uniform sampler2D host_depth;
layout(binding = 3) uniform sampler2D host_color;
// There is a host depth; draw the background; keep the host's colour.
layout(location = 0) uniform ivec3 choice;

layout(location = 0) out vec4 radiance;
layout(location = 1) out vec4 geometry;

void main()
{
    vec2 pixel = view_pixel(gl_FragCoord.xy);
    vec3 origin, direction;
    view_ray(pixel, origin, direction);
    geometry = vec4(0.0);
    radiance = vec4(choice.y != 0 ? environment_radiance(direction, 0.0) : vec3(0.0), 1.0);
    gl_FragDepth = 1.0;
    if (choice.x == 0) return;
    float depth = texelFetch(host_depth, ivec2(pixel), 0).r;
    if (depth >= 1.0) return;
    vec4 clip = vec4(pixel / vec2(tile.zw) * 2.0 - 1.0, depth * 2.0 - 1.0, 1.0);
    vec4 place = view_projection_inverse * clip;
    geometry.w = max(dot(place.xyz / place.w - origin, direction), 1e-30);
    radiance = vec4(choice.z != 0 ? texelFetch(host_color, ivec2(gl_FragCoord.xy), 0).rgb : vec3(0.0), 1.0);
    gl_FragDepth = depth;
}
