#version 450 core
// Triangles on their way to surfels, in world space. The only place that knows how their vertices are stored.
#extension GL_GOOGLE_include_directive : enable

layout(location = 0) in vec3 position;
layout(location = 2) in vec2 uv;
layout(location = 4) in uint key; // of the part
layout(location = 0) uniform mat4 world;
layout(location = 5) uniform ivec3 choice; // y: 1 the vertices are those of parts of huge triangles

precise out vec3 vertex_position;
out vec2 vertex_uv;
out uint vertex_key; // a triangle is known by those of its corners

void main()
{
    vertex_position = (world * vec4(position, 1.0)).xyz;
    vertex_uv = uv;
    vertex_key = choice.y != 0 ? key : uint(gl_VertexID);
}
