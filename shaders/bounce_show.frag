#version 450 core
// The mean of all samples of the bounced z-buffer from surfaces, 0 where there is none. AL_FOG: less what the fog takes on
// its way to the eye. AL_AMBIENT: the light of the environment that the open share of the hemisphere lets through. AL_HIDDEN:
// the sum is of what is hidden.
#extension GL_GOOGLE_include_directive : enable
#define AL_INDIRECT
#include "shade.glsl"
#include "bounce_receiver.glsl"

layout(binding = 2) uniform sampler2D light;
layout(location = 0) out vec4 value;

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 sum = texelFetch(light, pixel, 0);
#ifdef AL_HIDDEN
    vec4 place = texelFetch(geometry, pixel, 0);
    bool seen = place.w > 0.0 && dot(place.xyz, place.xyz) > 0.25; // a host's surface has no normal
    sum = seen ? vec4(max(1.0 - sum.rgb, 0.0), 1.0) : vec4(0.0);
#endif
    value = vec4(sum.rgb / max(sum.a, 1e-30), 0.0);
#if defined(AL_AMBIENT)
    Receiver r;
    value.rgb = receiver_at(pixel, r) ? shade_environment(r.surface, value.r) : vec3(0.0);
#elif defined(AL_FOG)
    vec3 origin, direction;
    view_ray(view_pixel(vec2(pixel) + 0.5), origin, direction);
    value.rgb *= fog_transmittance(origin, direction, texelFetch(geometry, pixel, 0).w, 256.0);
#endif
}
