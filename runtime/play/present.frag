/* Shows the linear picture in the window. tone_map.h stands in front of this text. */
layout(binding = 0) uniform sampler2D picture;
layout(location = 0) uniform float exposure_scale;
layout(location = 1) uniform bool is_light; /* a picture of light, not of normals, depths and the like */
layout(location = 0) out vec4 color;

/* IEC 61966-2-1 */
float srgb_from_linear(float value)
{
    value = clamp(value, 0.0, 1.0);
    return value <= 0.0031308 ? 12.92 * value : 1.055 * pow(value, 1.0 / 2.4) - 0.055;
}

void main()
{
    vec3 value = exposure_scale * texelFetch(picture, ivec2(gl_FragCoord.xy), 0).rgb;
    for (int i = 0; i < 3; i++) color[i] = srgb_from_linear(is_light ? al_tone_map(value[i]) : value[i]);
    color.a = 1.0;
}
