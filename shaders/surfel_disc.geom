#version 450 core
// The square around a surfel's disc.
#extension GL_GOOGLE_include_directive : enable
#include "formulas.glsl"
#include "frame.glsl"
#include "surfels.glsl"

layout(points) in;
layout(triangle_strip, max_vertices = 4) out;

in int number[];
out vec2 place; // on the disc, its rim at 1
flat out vec3 radiance;

void main()
{
    Surfel s = surfels[number[0]];
    vec3 normal = s.facing.xyz;
    vec3 other = abs(normal.x) < 0.5 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0);
    vec3 across = normalize(cross(normal, other)), up = cross(normal, across);
    float radius = sqrt(s.place.w / AL_PI);
    vec3 light = dot(to_eye(s.place.xyz), normal) >= 0.0 ? s.front.rgb : s.back.rgb;
    for (int i = 0; i < 4; i++) {
        place = vec2(i & 1, i >> 1) * 2.0 - 1.0;
        radiance = light;
        gl_Position =
            view_projection * vec4(s.place.xyz + radius * (place.x * across + place.y * up), 1.0);
        EmitVertex();
    }
}
