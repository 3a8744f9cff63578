#version 450 core
// Shadow maps of opaque instances: one layer for a directional light, six faces for a point light.
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"

layout(location = 0) in vec3 position;
layout(location = 0) uniform mat4 world;
layout(location = 1) uniform ivec2 place; // light, face

out float light_depth; // directional
out vec3 light_path;   // point: from the light

void main()
{
    Light light = lights[place.x];
    vec3 here = (world * vec4(position, 1.0)).xyz;
    light_path = here - light.vector.xyz;
    light_depth = (light.to_shadow * vec4(here, 1.0)).z;
    if (light.vector.w == 0.0) {
        gl_Position = vec4((light.to_shadow * vec4(here, 1.0)).xyz * 2.0 - 1.0, 1.0);
        return;
    }
    int axis = place.y / 2;
    float along = (place.y & 1) == 1 ? -light_path[axis] : light_path[axis];
    // Depth 0 everywhere: the fragment's depth is the distance, and only along > 0 is kept.
    gl_Position = vec4(light_path[(axis + 1) % 3], light_path[(axis + 2) % 3], 0.0, along);
}
