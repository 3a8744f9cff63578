#version 450 core
// The ambient occlusion volume of a triangle (McGuire 2010): a prism around all places that are at most `reach` away from
// it. Its outline is the triangle's with every side moved outwards by the reach; since corners of acute angles would
// move far away, a further side cuts each of them off, a reach away from it and perpendicular to its bisector. Its ends
// lie a reach before and behind the triangle's plane, as both of its sides occlude.
//
// The side with outward normal p, the cut with b and the next side with q: the point where p and b are both a reach
// away from the corner is (p + b)/(1 + p.b) reaches from it, as its products with p and with b are 1. b lies half-way
// between p and q, so that p.b >= 0.
//
// Only the back faces are drawn, which the view ray to any place inside passes exactly one of, also where the eye is
// inside. Depth does not clip them: whatever is seen lies behind the near plane, so what is nearer than half as far is
// cut off and nothing else is.
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"
#include "splat_quad.glsl"

layout(triangles) in;
layout(triangle_strip, max_vertices = 26) out;

in vec3 world_position[];
layout(location = 6) uniform float reach; // m
layout(location = 7) uniform int first;   // number of the draw's first triangle
#ifdef AL_SENDERS
in vec3 world_normal[];
in vec2 surface_uv[];
flat out vec3 corner_normal[3];
flat out vec2 corner_uv[3];
#endif

flat out vec3 corner[3]; // m
flat out int number;

void emit(vec3 place)
{
    vec4 near = view_projection_inverse * vec4(0.0, 0.0, -1.0, 1.0);
    corner = vec3[3](world_position[0], world_position[1], world_position[2]);
    number = first + gl_PrimitiveIDIn;
#ifdef AL_SENDERS
    corner_normal = vec3[3](world_normal[0], world_normal[1], world_normal[2]);
    corner_uv = vec2[3](surface_uv[0], surface_uv[1], surface_uv[2]);
#endif
    gl_Position = view_projection * vec4(place, 1.0);
    gl_Position.z = gl_Position.w - 1.0 / near.w;
    EmitVertex();
}

void main()
{
    vec3 along[3], normal, outline[6], middle = vec3(0.0);
    for (int i = 0; i < 3; i++) {
        along[i] = world_position[(i + 1) % 3] - world_position[i];
        middle += world_position[i] / 3.0;
        float size = length(along[i]);
        if (!(size > 0.0)) return; // no area: nothing is occluded
        along[i] /= size;
    }
    normal = cross(along[0], along[1]);
    if (!(dot(normal, normal) > 0.0)) return;
    normal = normalize(normal);
    float far = 0.0;
    for (int i = 0; i < 3; i++) far = max(far, distance(middle, world_position[i]));
    vec4 bounds;
    if (!splat_bounds(middle, far + reach, 0, 0, bounds)) return;
    for (int i = 0; i < 3; i++) {
        vec3 before = along[(i + 2) % 3], after = along[i], p = cross(before, normal), q = cross(after, normal);
        vec3 b = normalize(p + q + before - after);
        outline[2 * i] = world_position[i] + reach * (p + b) / (1.0 + dot(p, b));
        outline[2 * i + 1] = world_position[i] + reach * (b + q) / (1.0 + dot(b, q));
    }
    const int zigzag[6] = int[6](0, 1, 5, 2, 4, 3);
    vec3 up = reach * normal;
    for (int i = 0; i < 6; i++) emit(outline[zigzag[i]] + up);
    EndPrimitive();
    for (int i = 0; i < 6; i++) emit(outline[(6 - zigzag[i]) % 6] - up);
    EndPrimitive();
    for (int i = 0; i <= 6; i++) {
        emit(outline[i % 6] + up);
        emit(outline[i % 6] - up);
    }
    EndPrimitive();
}
