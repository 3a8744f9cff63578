#version 450 core
// Normal or distance of the opaque surfaces, for the intermediate pictures.
layout(binding = 2) uniform sampler2D geometry;
layout(location = 0) uniform int choice; // 0 normal, 1 distance

layout(location = 0) out vec4 value;

void main()
{
    vec4 here = texelFetch(geometry, ivec2(gl_FragCoord.xy), 0);
    if (here.w == 0.0) discard;
    value = vec4(choice == 0 ? here.xyz * 0.5 + 0.5 : here.www, 1.0);
}
