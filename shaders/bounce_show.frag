#version 450 core
// The mean of all samples of the bounced z-buffer from surfaces; 0 where there is none.
layout(binding = 2) uniform sampler2D light;
layout(location = 0) out vec4 value;

void main()
{
    vec4 sum = texelFetch(light, ivec2(gl_FragCoord.xy), 0);
    value = vec4(sum.rgb / max(sum.a, 1e-30), 1.0);
}
