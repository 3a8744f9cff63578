#version 450 core
// Distance along the pixel's ray of the faces of a translucent object, blended by maximum: where the ray leaves
// it for the last time.
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"

in vec3 world_position;

layout(location = 0) out float away;

void main()
{
    vec3 origin, direction;
    view_ray(view_pixel(gl_FragCoord.xy), origin, direction);
    away = max(dot(world_position - origin, direction), 0.0);
}
