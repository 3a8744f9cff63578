// Directions about an axis.
#ifndef AL_TURNED_GLSL
#define AL_TURNED_GLSL

#include "formulas.glsl"

// Two unit vectors across `axis` and each other (Duff et al. 2017).
void axes_across(vec3 axis, out vec3 x, out vec3 y)
{
    float s = axis.z < 0.0 ? -1.0 : 1.0, a = -1.0 / (s + axis.z), b = axis.x * axis.y * a;
    x = vec3(1.0 + s * axis.x * axis.x * a, s * b, -s * axis.x);
    y = vec3(b, s + axis.y * axis.y * a, -axis.y);
}

// A unit vector at the cosine from `axis`, turned about it by the share of a full turn.
vec3 turned(vec3 axis, float cosine, float turn)
{
    vec3 x, y;
    axes_across(axis, x, y);
    float sine = sqrt(max(1.0 - cosine * cosine, 0.0)), angle = 2.0 * AL_PI * turn;
    return axis * cosine + sine * (x * cos(angle) + y * sin(angle));
}

#endif
