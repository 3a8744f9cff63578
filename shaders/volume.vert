#version 450 core
// Corners of the triangles whose occlusion volumes are drawn, world space.
layout(location = 0) in vec3 position;
layout(location = 0) uniform mat4 world;

out vec3 world_position;

void main()
{
    world_position = (world * vec4(position, 1.0)).xyz;
}
