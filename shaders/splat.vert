#version 450 core
// One quad per sample: the exact screen bounds of its ball under any projection.
#extension GL_GOOGLE_include_directive : enable
#include "formulas.glsl"
#include "frame.glsl"
#include "object.glsl"

layout(std430, binding = 0) readonly buffer Positions { float positions[]; };
layout(std430, binding = 1) readonly buffer Gaussians { vec4 gaussians[]; };
layout(std430, binding = 4) readonly buffer Lit { vec4 lit[]; };

flat out vec3 center; // object space, m
flat out vec4 shape;  // a in 1/m^2, radius squared, sqrt(a), weight
flat out vec4 light; // rgb; what alpha adds up
flat out vec3 slope; // of the light, relative, 1/m

// Bounds along one screen axis. The planes x = s w that touch the ball of radius R about c fulfil (r0.c - s
// r3.c)^2 = R^2 |n0 - s n3|^2 with r0, r3 the matrix's rows and n0, n3 their normals: a quadratic in s. Only
// called for balls in front of the eye plane (r3.c > R |n3|), where the coefficient of s^2 is positive. A
// quarter of its discriminant is R^2 (|r3.c n0 - r0.c n3|^2 - R^2 |n0 x n3|^2), which does not cancel.
vec2 axis_bounds(vec4 row, vec4 depth_row, vec4 middle, float radius2)
{
    float along = dot(row, middle), depth = dot(depth_row, middle);
    float a = depth * depth - radius2 * dot(depth_row.xyz, depth_row.xyz);
    float b = along * depth - radius2 * dot(row.xyz, depth_row.xyz);
    vec3 tilt = depth * row.xyz - along * depth_row.xyz, normal = cross(row.xyz, depth_row.xyz);
    float root = sqrt(radius2 * max(dot(tilt, tilt) - radius2 * dot(normal, normal), 0.0));
    return vec2(b - root, b + root) / a;
}

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

    mat4 rows = transpose(view_projection * object_to_world);
    vec4 middle = vec4(center, 1.0);
    float depth = dot(rows[3], middle), reach = radius * length(rows[3].xyz);
    vec2 x = vec2(-1.0, 1.0), y = vec2(-1.0, 1.0);
    if (depth > 1.0001 * reach) {
        // A sixteenth of a pixel more than the ball: GL may round corners by half of that.
        x = axis_bounds(rows[0], rows[3], middle, radius * radius) + vec2(-0.125, 0.125) / float(tile.z);
        y = axis_bounds(rows[1], rows[3], middle, radius * radius) + vec2(-0.125, 0.125) / float(tile.w);
    } else if (depth < -reach || a <= 0.0) {
        x = vec2(2.0);
    }
    x = clamp(x, -1.0, 1.0);
    y = clamp(y, -1.0, 1.0);
    gl_Position = vec4((corner & 1) == 0 ? x.x : x.y, (corner & 2) == 0 ? y.x : y.y, 0.0, 1.0);
}
