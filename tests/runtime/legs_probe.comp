#version 450 core
// What shaders/legs.glsl says of each leg: its transmittance, and the integral of the first fog's density.
#extension GL_GOOGLE_include_directive : enable
#include "formulas.glsl"
#include "frame.glsl"
#include "legs.glsl"

layout(local_size_x = 64) in;
struct Leg { vec4 from, to; }; // m
layout(std430, binding = 6) buffer Legs_asked { Leg asked[]; };

void main()
{
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(asked.length())) return;
    vec3 way = asked[i].to.xyz - asked[i].from.xyz;
    float reach = length(way);
    vec3 left = leg_transmittance(asked[i].from.xyz, way / reach, reach);
#ifdef AL_DEPTH_ORDER
    asked[i].to = vec4(left, leg_depth(0, asked[i].from.xyz, way / reach, reach));
#else
    asked[i].to = vec4(left, 0.0);
#endif
}
