#version 450 core
in vec2 place;
flat in vec3 radiance;
layout(location = 0) out vec4 color;
layout(location = 1) out vec4 geometry;

void main()
{
    if (dot(place, place) > 1.0) discard;
    color = vec4(radiance, 1.0);
    geometry = vec4(0.0);
}
