#version 450 core
// Depth is the distance from the light over its range, or the place between the directional map's planes.
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"

layout(location = 1) uniform ivec2 place;

in float light_depth;
in vec3 light_path;

void main()
{
    Light light = lights[place.x];
    float depth = light.vector.w == 0.0 ? light_depth : length(light_path) / light.shadow.y;
    gl_FragDepth = clamp(depth, 0.0, 1.0);
}
