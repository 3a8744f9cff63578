// A colour in [0, 1] as a whole number that a float holds exactly: roots of the channels in 8 bits each, so that dark
// ones are kept to a few percent of themselves.
#ifndef AL_PACKED_COLOR_GLSL
#define AL_PACKED_COLOR_GLSL

float pack_color(vec3 color)
{
    uvec3 root = uvec3(sqrt(clamp(color, 0.0, 1.0)) * 255.0 + 0.5);
    return float(root.r | root.g << 8 | root.b << 16);
}

vec3 unpack_color(float value)
{
    uint bits = uint(value);
    vec3 root = vec3(bits & 255u, bits >> 8 & 255u, bits >> 16 & 255u) / 255.0;
    return root * root;
}

#endif
