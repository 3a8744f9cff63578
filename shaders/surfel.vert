#version 450 core
// Triangles on their way to surfels, in world space. The only place that knows how their vertices are stored.
#extension GL_GOOGLE_include_directive : enable

layout(location = 0) in vec3 position;
layout(location = 2) in vec2 uv;
layout(location = 4) in uint key; // of the part, where vertices are of parts of huge triangles
layout(location = 0) uniform mat4 world;

precise out vec3 vertex_position;
out vec2 vertex_uv;
out uint vertex_key;

void main()
{
    vertex_position = (world * vec4(position, 1.0)).xyz;
    vertex_uv = uv;
    vertex_key = key;
}
