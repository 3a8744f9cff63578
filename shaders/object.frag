#version 450 core
// Joins one translucent object with what lies behind it: radiance = L + T * behind (blended by the second
// output). With surface shading the boundary reflects a share F of what falls on it and lets 1 - F through.
#extension GL_GOOGLE_include_directive : enable
#include "formulas.glsl"
#include "frame.glsl"
#include "object.glsl"

layout(binding = 2) uniform sampler2D ends;
layout(binding = 3) uniform sampler2DArray knots;
layout(binding = 4) uniform sampler2D boundary;
layout(binding = 5) uniform sampler2D geometry;
layout(binding = 6) uniform sampler2D light;      // the splats' sum
layout(binding = 7) uniform sampler2D reflection; // rgb, F
#ifdef AL_FOG // in front of the object: light that the fog sends, what it leaves of the light behind it
layout(binding = 2, rgba32f) readonly uniform image2D fog_light;
layout(binding = 3, rgba16f) readonly uniform image2D fog_kept;
#endif
layout(location = 0) uniform int choice; // al_pass

layout(location = 0, index = 0) out vec4 added;
layout(location = 0, index = 1) out vec4 kept;

// What the samples sent, times what they missed: the extinguished share of the whole chord, which the interval
// map knows, over the share that fell on Gaussians. With the view leg by spherical harmonics that is the integral
// of sigma_t psi gamma, which should be 1 - transmittance as well but for the band limit of psi: divided, the
// weights along the ray add up to what they should, though not each of them is right. At most four times, so
// that the ragged rim of few samples does not glare.
vec3 scattered(ivec2 place, vec4 end)
{
    vec4 total = texelFetch(light, place, 0);
    if (toggles.y == 0) return total.rgb;
    float expected = reference_depletion(end.z);
    return total.a > 0.0 ? total.rgb * min(expected / total.a, 4.0) : vec3(0.0);
}

void main()
{
    ivec2 place = ivec2(gl_FragCoord.xy);
    vec4 front = texelFetch(boundary, place, 0), end = texelFetch(ends, place, 0);
    float opaque = texelFetch(geometry, place, 0).w;
    bool seen = front.w != 0.0 && (opaque == 0.0 || max(front.w, 0.0) < opaque);
    vec3 through = end.w > 0.0 ? vec3(0.0) : exp(-ratio.rgb * end.z);
    vec4 mirrored = seen ? texelFetch(reflection, place, 0) : vec4(0.0);
    added = vec4(0.0, 0.0, 0.0, 1.0);
    kept = vec4(through, 0.0);
    switch (choice) {
    case 0: // composite
        added.rgb = scattered(place, end) * (1.0 - mirrored.a) + mirrored.rgb;
        kept.rgb *= 1.0 - mirrored.a;
#ifdef AL_FOG
        // What lies behind is seen through all of the fog already: of that, the object takes away what comes
        // from behind it, but not the fog before it.
        added.rgb = imageLoad(fog_kept, place).rgb * added.rgb +
                    (1.0 - kept.rgb) * imageLoad(fog_light, place).rgb;
#endif
        break;
    case 1: // translucent
        added.rgb = scattered(place, end);
        break;
    case 2: // surface
        added.rgb = mirrored.rgb;
        kept.rgb *= 1.0 - mirrored.a;
        break;
    case 3: // normal
        kept = vec4(seen ? 0.0 : 1.0);
        if (seen) added.rgb = front.xyz * 0.5 + 0.5;
        break;
    case 4: // depth
        kept = vec4(seen ? 0.0 : 1.0);
        if (seen) added.rgb = vec3(abs(front.w));
        break;
    case 5: // intervals
        kept = vec4(end.x < end.y ? 0.0 : 1.0);
        if (end.x < end.y)
            added.rgb = vec3(end.x, texelFetch(knots, ivec3(place, 0), 0).xy);
        break;
    case 7: // direct scattering
    case 8: // surface scattering
        kept.rgb *= 1.0 - mirrored.a;
#ifdef AL_FOG
        added.rgb = (1.0 - kept.rgb) * imageLoad(fog_light, place).rgb;
#endif
        break;
    default: // unity
        kept = vec4(end.x < end.y ? 0.0 : 1.0);
        if (end.x < end.y) added.rgb = vec3(texelFetch(light, place, 0).a / (end.y - end.x));
    }
}
