#version 450 core
// Corners of the triangles whose occlusion volumes are drawn, world space. AL_SENDERS: and what their light depends on.
layout(location = 0) in vec3 position;
layout(location = 0) uniform mat4 world;
#ifdef AL_SENDERS
#extension GL_GOOGLE_include_directive : enable
#include "cofactor.glsl"
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;
out vec3 world_normal;
out vec2 surface_uv;
#endif

out vec3 world_position;

void main()
{
    world_position = (world * vec4(position, 1.0)).xyz;
#ifdef AL_SENDERS
    world_normal = turned_normal(mat3(world), normal);
    surface_uv = uv;
#endif
}
