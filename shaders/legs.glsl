// What the media leave of light between two places, for passes that ask it of very many pairs: constant media in
// closed form, gridded ones all together by a march through their mean extinction in 32^3 cells (legs.comp).
#ifndef AL_LEGS_GLSL
#define AL_LEGS_GLSL

#include "fogs.glsl"

layout(std140, binding = 5) uniform Legs {
    vec4 legs_low;    // xyz: lower corner of the box around all gridded fogs in m; w: steps of the march
    vec4 legs_extent; // xyz: its edges in m; w: 0 when there is none
};
layout(binding = 6) uniform sampler3D legs; // rgb: extinction per metre

vec3 leg_transmittance(vec3 origin, vec3 direction, float reach)
{
    vec3 tau = vec3(0.0);
    for (int i = 0; i < fog_counts.x; i++)
        if (fogs[i].cells.x == 0) tau += fogs[i].sigma_t.rgb * fog_depth(i, origin, direction, 0.0, reach, 1.0);
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
    return exp(-min(tau, vec3(1e4)));
}

#endif
