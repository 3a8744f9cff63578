#version 450 core
// A tile's radiance into the host's framebuffer.
layout(binding = 2) uniform sampler2D radiance;
layout(location = 0) uniform ivec2 corner; // of the tile in the view
layout(location = 1) uniform float limit;  // largest number the framebuffer holds

layout(location = 0) out vec4 value;

void main()
{
    value = vec4(min(texelFetch(radiance, ivec2(gl_FragCoord.xy) - corner, 0).rgb, vec3(limit)), 1.0);
}
