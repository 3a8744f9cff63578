// Surface shading by the lights and the environment.
#ifndef AL_SHADE_GLSL
#define AL_SHADE_GLSL

#include "brdf.glsl"
#include "shadows.glsl"
#include "environment.glsl"
#ifdef AL_FOG
#include "fogs.glsl"
#endif

// What hides light `index` from the surface, opaque, translucent or fog, leaves of it.
vec3 light_share(int index, Surface s, vec3 direction, float reach, bool shadows)
{
    vec3 share = vec3(1.0);
#ifdef AL_FOG
    share *= fog_transmittance(s.position, direction, reach, 64.0); // first: surfel_light.comp says why
#endif
    if (shadows) {
        share *= opaque_visibility(index, s.position, s.normal);
        share *= translucent_visibility(s.position, direction, reach, s.own_caster);
    }
    return share;
}

vec3 shade_lights(Surface s, bool shadows)
{
    vec3 sum = vec3(0.0);
    for (int i = 0; i < counts.x; i++) {
        vec3 direction;
        float reach;
        vec3 arriving = light_arrival(i, s.position, 0.0, direction, reach);
        vec3 part = reflectance(s, direction) * arriving;
        if (dot(part, vec3(1.0)) <= 0.0) continue;
        sum += part * light_share(i, s, direction, reach, shadows);
    }
    return sum;
}

// What the lobe reflects of even light from all sides: Karis's fit (2014, "Physically based shading on
// mobile").
vec3 lobe_albedo(Surface s)
{
    float seen = clamp(dot(s.normal, s.view), 0.0, 1.0);
    vec4 r = s.roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
    float a = min(r.x * r.x, exp2(-9.28 * seen)) * r.x + r.y;
    vec2 fit = vec2(-1.04, 1.04) * a + r.zw;
    return clamp(s.f0 * fit.x + fit.y * grazing(s.f0), vec3(0.0), vec3(1.0));
}

// Diffuse light from the irradiance of nine coefficients; the lobe's from the picture's mip of its width. `open`: the share
// of the hemisphere that nothing hides from it. Of the lobe's light it leaves (seen + open)^e - 1 + open, clamped, with e =
// 2^(-16 roughness - 1): a fit by Lagarde and de Rousiers (2014, "Moving Frostbite to PBR"), 1 where all is open.
vec3 shade_environment(Surface s, float open)
{
    if (counts.z == 0) return vec3(0.0);
    vec3 lobe = lobe_albedo(s);
    vec3 irradiance = environment_bands(s.normal, vec3(AL_PI, 2.0 * AL_PI / 3.0, AL_PI / 4.0));
    float level = s.roughness * float(max(counts.w - 3, 0)), seen = max(dot(s.normal, s.view), 0.0);
    float mirrored_open = clamp(pow(seen + open, exp2(-16.0 * s.roughness - 1.0)) - 1.0 + open, 0.0, 1.0);
    vec3 mirrored = environment_radiance(reflect(-s.view, s.normal), level);
    return open * (1.0 - lobe) * s.diffuse * irradiance / AL_PI + mirrored_open * lobe * mirrored;
}

#endif
