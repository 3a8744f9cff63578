#version 450 core
// What one surfel sends to the place that a pixel shows, however much stands between (Nalbach et al. 2014, onto surfaces): the
// share of the cosine-weighted hemisphere that it hides or, AL_INDIRECT, its Lambert light that is reflected to the eye.
// Shares are added up, so that what several surfels hide counts as often.
#extension GL_GOOGLE_include_directive : enable
#include "bounce_receiver.glsl"
#include "surfels.glsl"

flat in int number;
layout(location = 0) out vec4 sum; // a: 0

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    Receiver r;
    if (!receiver_at(pixel, r)) discard;
    Surfel s = surfels[number - 1];
    vec3 path = s.place.xyz - r.surface.position;
    float squared = max(dot(path, path), 1e-30), away = dot(path, s.facing.xyz);
    if (squared > bounce_reach.w * bounce_reach.w) discard;
    vec3 part = received(r, path * inversesqrt(squared)) * al_disc_angle(s.place.w, abs(away), squared);
#ifdef AL_INDIRECT
    part *= away < 0.0 ? s.front.rgb : s.back.rgb;
#endif
    sum = vec4(min(part, vec3(1e30)), 0.0);
}
