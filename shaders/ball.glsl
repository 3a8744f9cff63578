// The exact screen bounds of a ball under any projection.
#ifndef AL_BALL_GLSL
#define AL_BALL_GLSL

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

// Both axes' bounds in normalised device coordinates: the whole view for balls that cross the eye plane, a point
// beside it for those behind. `rows`: the transposed matrix to clip space.
void ball_bounds(mat4 rows, vec3 center, float radius, out vec2 x, out vec2 y)
{
    vec4 middle = vec4(center, 1.0);
    float depth = dot(rows[3], middle), reach = radius * length(rows[3].xyz);
    x = y = vec2(-1.0, 1.0);
    if (depth > 1.0001 * reach) {
        x = axis_bounds(rows[0], rows[3], middle, radius * radius);
        y = axis_bounds(rows[1], rows[3], middle, radius * radius);
    } else if (depth < -reach) {
        x = vec2(2.0);
    }
}

#endif
