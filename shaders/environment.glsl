// The environment by direction: from its lat-long picture, from its first nine SH coefficients, or none.
#ifndef AL_ENVIRONMENT_GLSL
#define AL_ENVIRONMENT_GLSL

#include "formulas.glsl"
#include "frame.glsl"

layout(binding = 1) uniform sampler2D environment_map;

// Sum of coefficients, each band scaled: (1, 1, 1) is the radiance itself, (pi, 2 pi/3, pi/4) the irradiance
// (Ramamoorthi and Hanrahan 2001).
vec3 environment_bands(vec3 direction, vec3 scale)
{
    float basis[AL_SH_MAX_COUNT];
    al_sh_basis(3, direction.x, direction.y, direction.z, basis);
    vec3 sum = environment[0].rgb * basis[0] * scale.x;
    for (int i = 1; i < 4; i++) sum += environment[i].rgb * basis[i] * scale.y;
    for (int i = 4; i < 9; i++) sum += environment[i].rgb * basis[i] * scale.z;
    return max(sum, vec3(0.0));
}

// Radiance from `direction`; level 0 is the sharpest picture.
vec3 environment_radiance(vec3 direction, float level)
{
    if (counts.z == 0) return background.rgb;
    if (counts.z == 1) return environment_bands(direction, vec3(1.0));
    // First row +y; the middle column looks along -z, the first one along +z, the right quarter along +x.
    vec2 place = vec2(atan(direction.x, -direction.z) / (2.0 * AL_PI) + 0.5,
                      acos(clamp(direction.y, -1.0, 1.0)) / AL_PI);
    return background.w * textureLod(environment_map, place, level).rgb;
}

#endif
