#version 450 core
// One quad per sample: the exact screen bounds of its ball under any projection.
#extension GL_GOOGLE_include_directive : enable
#include "formulas.glsl"
#include "frame.glsl"
#include "ball.glsl"
#include "object.glsl"

layout(std430, binding = 0) readonly buffer Positions { float positions[]; };
layout(std430, binding = 1) readonly buffer Gaussians { vec4 gaussians[]; };
layout(std430, binding = 4) readonly buffer Lit { vec4 lit[]; };

flat out vec3 center; // object space, m
flat out vec4 shape;  // a in 1/m^2, radius squared, sqrt(a), weight
flat out vec4 light; // rgb; what alpha adds up
flat out vec3 slope; // of the light, relative, 1/m

void main()
{
    int index = gl_VertexID / 6, corner = gl_VertexID % 6;
    corner = corner > 2 ? corner - 2 : corner; // 0 1 2, 1 2 3
    vec4 gaussian = gaussians[index];
    center = vec3(positions[3 * index], positions[3 * index + 1], positions[3 * index + 2]);
    float a = gaussian.x * prefix.x, radius = gaussian.z * prefix.y;
    shape = vec4(a, radius * radius, sqrt(a), gaussian.y);
    light = lit[2 * index];
    slope = lit[2 * index + 1].xyz;

    vec2 x, y;
    ball_bounds(transpose(view_projection * object_to_world), center, radius, x, y);
    if (a <= 0.0) x = vec2(2.0);
    // A sixteenth of a pixel more than the ball: GL may round corners by half of that.
    x = clamp(x + vec2(-0.125, 0.125) / float(tile.z), -1.0, 1.0);
    y = clamp(y + vec2(-0.125, 0.125) / float(tile.w), -1.0, 1.0);
    gl_Position = vec4((corner & 1) == 0 ? x.x : x.y, (corner & 2) == 0 ? y.x : y.y, 0.0, 1.0);
}
