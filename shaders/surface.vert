#version 450 core
// Opaque instances and boundaries of translucent objects.
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;
layout(location = 3) in vec2 uv1;
layout(location = 0) uniform mat4 world;
#ifdef AL_LIGHTMAP
layout(location = 6) uniform vec4 page_place; // page uv = uv1 * xy + zw
out vec2 page_uv;
#endif

out vec3 world_position;
out vec3 world_normal;
out vec2 surface_uv;

void main()
{
    vec4 here = world * vec4(position, 1.0);
    world_position = here.xyz;
    // The cofactor matrix, the inverse's transpose times the determinant, whose sign alone matters: right for every
    // invertible transform.
    mat3 m = mat3(world), cofactor = mat3(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1]));
    world_normal = (dot(m[0], cofactor[0]) < 0.0 ? -1.0 : 1.0) * (cofactor * normal);
    surface_uv = uv;
#ifdef AL_LIGHTMAP
    page_uv = uv1 * page_place.xy + page_place.zw;
#endif
    gl_Position = view_projection * here;
}
