#version 450 core
// Opaque instances and boundaries of translucent objects.
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"
#include "cofactor.glsl"

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
    world_normal = turned_normal(mat3(world), normal);
    surface_uv = uv;
#ifdef AL_LIGHTMAP
    page_uv = uv1 * page_place.xy + page_place.zw;
#endif
    gl_Position = view_projection * here;
}
