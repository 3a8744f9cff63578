#version 450 core
// Vertices of the parts of a huge triangle.
layout(triangles, equal_spacing, ccw) in;

in vec3 corner_position[];
in vec2 corner_uv[];
patch in uint whole_key;
out vec3 vertex_position;
out vec2 vertex_uv;
out vec2 vertex_share; // of the first two corners
flat out uint vertex_key; // of the whole

void main()
{
    vec3 share = gl_TessCoord;
    vertex_position = share.x * corner_position[0] + share.y * corner_position[1] + share.z * corner_position[2];
    vertex_uv = share.x * corner_uv[0] + share.y * corner_uv[1] + share.z * corner_uv[2];
    vertex_share = share.xy;
    vertex_key = whole_key;
}
