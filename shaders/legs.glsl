// What the media leave of light between two places, for passes that ask it of very many pairs: constant media in
// closed form, gridded ones all together by a march through 32^3 cells (legs.comp), or, with
// AL_DEPTH_ORDER bands, one by one from baked spherical harmonics of tau(x, w), the optical depth from x to the bounds
// along w (formats/include/airlight/medium.h, al_medium_depth).
#ifndef AL_LEGS_GLSL
#define AL_LEGS_GLSL

#include "fogs.glsl"

struct LegDepth {
    mat4 to_share; // from world to the lattice's share of the bounds, 0 to 1
    vec4 edge;     // xyz: edges of the bounds in m; w: m of fog_density where a coefficient is 1
    ivec4 size;    // points along the axes; w: first slice in `legs`
};
layout(std140, binding = 5) uniform Legs {
    vec4 legs_low;    // xyz: lower corner of the box around all gridded fogs in m; w: steps of the march
    vec4 legs_extent; // xyz: its edges in m; w: 0 when there is none
    ivec4 legs_stride; // x: texels along x of `legs` from one to the next of a point; yzw unused
    LegDepth leg_depths[AL_FOG_LIMIT];
};
layout(binding = 6) uniform sampler3D legs; // rgb: extinction per metre; or four coefficients a texel, odd bands first

#ifdef AL_DEPTH_ORDER

const int odd_texels = AL_DEPTH_ORDER > 3 ? 3 : AL_DEPTH_ORDER > 1 ? 1 : 0,
          even_texels = AL_DEPTH_ORDER > 4 ? 4 : AL_DEPTH_ORDER > 2 ? 2 : 1;
vec4 leg_basis[7];

// al_sh_basis by bands, odd ones first, each parity from a texel of its own on. Written out: every leg asks for all of it.
void leg_begin(vec3 w)
{
    float x = w.x, y = w.y, z = w.z, xx = x * x, yy = y * y, zz = z * z, xy = x * y, yz = y * z, xz = x * z;
    float cos2 = xx - yy, cos3 = x * (xx - 3.0 * yy), sin3 = y * (3.0 * xx - yy);
    leg_basis[0] = vec4(0.4886025 * y, 0.4886025 * z, 0.4886025 * x, 0.5900436 * sin3);
    if (odd_texels > 1) {
        leg_basis[1] = vec4(2.8906114 * xy * z, 0.4570458 * y * (5.0 * zz - 1.0), 0.3731763 * z * (5.0 * zz - 3.0),
                            0.4570458 * x * (5.0 * zz - 1.0));
        leg_basis[2] = vec4(1.4453057 * z * cos2, 0.5900436 * cos3, 0.0, 0.0);
    }
    leg_basis[odd_texels] = vec4(0.2820948, 1.0925484 * xy, 1.0925484 * yz, 0.3153916 * (3.0 * zz - 1.0));
    if (even_texels > 1)
        leg_basis[odd_texels + 1] = vec4(1.0925484 * xz, 0.5462742 * cos2, 2.5033429 * xy * cos2, 1.7701308 * z * sin3);
    if (even_texels > 2) {
        leg_basis[odd_texels + 2] = vec4(0.9461747 * xy * (7.0 * zz - 1.0), 0.6690465 * yz * (7.0 * zz - 3.0),
                                         0.1057855 * (zz * (35.0 * zz - 30.0) + 3.0), 0.6690465 * xz * (7.0 * zz - 3.0));
        leg_basis[odd_texels + 3] = vec4(0.4730873 * cos2 * (7.0 * zz - 1.0), 1.7701308 * z * cos3,
                                         0.6258357 * (x * cos3 - y * sin3), 0.0);
    }
}

// The part of odd bands, or of even ones, of tau at a place of the lattice along leg_begin's direction.
float leg_part(int i, vec3 share, int first, int count)
{
    vec3 texel = 1.0 / vec3(textureSize(legs, 0));
    vec3 at = share * vec3(leg_depths[i].size.xyz - 1) + 0.5;
    at += vec3(first * legs_stride.x, 0, leg_depths[i].size.w);
    float sum = 0.0;
    for (int k = 0; k < count; k++, at.x += float(legs_stride.x))
        sum += dot(textureLod(legs, at * texel, 0.0), leg_basis[first + k]);
    return sum;
}

// The integral of the density of gridded fog i over the leg, in m. Where the leg begins or ends at the bounds it is tau of
// its other end. In between it is a difference of two, the same along the leg and against it:
//   tau(a, w) - tau(b, w) = tau(b, -w) - tau(a, -w).
// The mean of both is made of odd bands alone. Even ones are half of the whole chord's depth, which all points of a line
// share: what is left of their difference is error.
float leg_depth(int i, vec3 origin, vec3 direction, float reach)
{
    vec3 begin = (leg_depths[i].to_share * vec4(origin, 1.0)).xyz, along = mat3(leg_depths[i].to_share) * direction;
    float entry, leave;
    box_span(begin, along, vec3(0.0), vec3(1.0), 0.0, entry, leave);
    if (max(entry, 0.0) >= min(leave, reach)) return 0.0;
    vec3 baked = along * leg_depths[i].edge.xyz;
    float stretch = length(baked), margin = 1e-3 * (leave - entry), tau;
    vec3 end = begin + along * min(leave, reach);
    leg_begin(baked / stretch);
    bool enters = entry > -margin;
    float odd = leg_part(i, enters ? end : begin, 0, odd_texels);
    if (enters || leave < reach + margin)
        tau = leg_part(i, enters ? end : begin, odd_texels, even_texels) + (enters ? -odd : odd);
    else
        tau = odd - leg_part(i, end, 0, odd_texels);
    return max(tau, 0.0) * leg_depths[i].edge.w / stretch;
}

#endif

vec3 leg_transmittance(vec3 origin, vec3 direction, float reach)
{
    vec3 tau = vec3(0.0);
    for (int i = 0; i < fog_counts.x; i++)
        if (fogs[i].cells.x == 0) tau += fogs[i].sigma_t.rgb * fog_depth(i, origin, direction, 0.0, reach, 1.0);
#ifdef AL_DEPTH_ORDER
    for (int i = 0; i < fog_counts.x; i++)
        if (fogs[i].cells.x != 0) tau += fogs[i].sigma_t.rgb * leg_depth(i, origin, direction, reach);
#else
    if (legs_extent.w > 0.0) {
        float entry, leave;
        box_span(origin, direction, legs_low.xyz, legs_extent.xyz, 0.0, entry, leave);
        entry = max(entry, 0.0);
        float size = (min(leave, reach) - entry) / legs_low.w;
        if (size > 0.0) {
            vec3 at = (origin + direction * (entry + 0.5 * size) - legs_low.xyz) / legs_extent.xyz;
            vec3 step = direction * size / legs_extent.xyz, sum = vec3(0.0);
            for (int k = 0; k < int(legs_low.w); k++) sum += textureLod(legs, at + step * float(k), 0.0).rgb;
            tau += sum * size;
        }
    }
#endif
    return exp(-min(tau, vec3(1e4)));
}

#endif
