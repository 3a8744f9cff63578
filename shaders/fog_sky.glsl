// Light of the environment in the fogs, as baked (formats/include/airlight/medium.h, al_medium_sky):
//   L_lm = c_lm exp(-t),
// t and c_lm trilinear between the points of a lattice over each fog's bounds. What goes on along -d towards
// the eye is J = sum of g^l L_lm Y_lm(d), Henyey-Greenstein's Legendre moments being g^l. Few bands of a narrow
// lobe swing below 0: cut off there. In sky_light the numbers of a fog (t, then c_lm) stand side by side along
// x, its slices and those of the other fogs one after the other along z.
#ifndef AL_FOG_SKY_GLSL
#define AL_FOG_SKY_GLSL

#include "fogs.glsl"

layout(binding = 4) uniform sampler3D sky_light;
layout(binding = 5) uniform usampler3D sky_planes; // x: lower eighths, y: upper ones, eight bits each

float sky_basis[AL_SH_MAX_COUNT]; // of the ray's direction

void sky_begin(vec3 direction)
{
    int order = 1;
    for (int i = 0; i < fog_counts.x; i++) order = max(order, fogs[i].sky_size.w);
    al_sh_basis(order, direction.x, direction.y, direction.z, sky_basis);
}

// The sum of the numbers of fog i, from texture coordinates `at` of the first of them.
vec3 sky_sum(int i, vec3 at, float next)
{
    vec3 sum = vec3(0.0);
    float band = 1.0;
    for (int l = 0, k = 0; l < fogs[i].sky_size.w; l++, band *= fogs[i].sigma_t.w)
        for (; k < (l + 1) * (l + 1); k++) {
            at.x += next;
            sum += band * sky_basis[k] * textureLod(sky_light, at, 0.0).rgb;
        }
    return sum;
}

// J at a place, in W/(m2 sr).
vec3 sky_towards(int i, vec3 position)
{
    ivec3 size = fogs[i].sky_size.xyz;
    vec3 place = clamp((position - fogs[i].low.xyz) / fogs[i].extent.xyz, vec3(0.0), vec3(1.0)), at;
    for (int k = 0; k < 3; k++) at[k] = al_graded_share(fogs[i].sky_grade[k], place[k]) * float(size[k] - 1);
    vec3 first = vec3(0.5, 0.5, 0.5 + float(fogs[i].sky_place.x)), texel = 1.0 / vec3(textureSize(sky_light, 0));
    vec3 thinned = fogs[i].sky_grade.w * exp(-textureLod(sky_light, (at + first) * texel, 0.0).rgb);
    if (fogs[i].sky_place.y >= 0) {
        ivec3 cell = clamp(ivec3(at), ivec3(0), size - 2);
        uvec2 eighths = texelFetch(sky_planes, cell + ivec3(0, 0, fogs[i].sky_place.y), 0).xy;
        ivec3 upper = ivec3(greaterThanEqual(at - vec3(cell), vec3(0.5)));
        uint planes = eighths[upper.z] >> (8 * (upper.x + 2 * upper.y));
        for (int k = 0; k < 3; k++) {
            if ((planes >> k & 1u) == 0u) at[k] = float(cell[k] + 1);
            if ((planes >> (3 + k) & 1u) == 0u) at[k] = float(cell[k]);
        }
    }
    vec3 sum = sky_sum(i, (at + first) * texel, float(fog_atlas.w) * texel.x);
    return max(sum, vec3(0.0)) * thinned;
}

#endif
