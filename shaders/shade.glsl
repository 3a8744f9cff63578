// Surface shading: Lambert and a GGX lobe (Walter et al. 2007) with Schlick's Fresnel term and the separable
// Smith masking, in glTF's metallic-roughness terms.
#ifndef AL_SHADE_GLSL
#define AL_SHADE_GLSL

#include "shadows.glsl"
#include "environment.glsl"
#ifdef AL_FOG
#include "fogs.glsl"
#endif

struct Surface {
    vec3 position, normal, view; // world; view: unit direction to the eye
    vec3 diffuse;                // albedo of the Lambert part
    vec3 f0;                     // reflectance along the normal
    float roughness;
    int own_caster; // whose medium does not shadow this surface, -1
};

// Schlick's reflectance at grazing angles is 1, but an index-matched surface reflects nothing (Lagarde and de
// Rousiers 2014).
vec3 grazing(vec3 f0)
{
    return clamp(50.0 * f0, vec3(0.0), vec3(1.0));
}

vec3 fresnel(vec3 f0, float cosine)
{
    return f0 + (grazing(f0) - f0) * pow(clamp(1.0 - cosine, 0.0, 1.0), 5.0);
}

// GGX lobe times the cosine towards the light; diffuse light is what the Fresnel term leaves.
vec3 reflectance(Surface s, vec3 light)
{
    float toward = dot(s.normal, light), seen = max(dot(s.normal, s.view), 1e-4);
    if (toward <= 0.0) return vec3(0.0);
    vec3 middle = normalize(light + s.view + vec3(1e-20));
    float alpha = max(s.roughness * s.roughness, 1e-3), alpha2 = alpha * alpha;
    float facing = clamp(dot(s.normal, middle), 0.0, 1.0);
    // 1 - facing^2 (1 - alpha^2), as a sum of what does not cancel near the peak.
    vec3 across = cross(s.normal, middle);
    float spread = dot(across, across) + facing * facing * alpha2;
    float distribution = alpha2 / (AL_PI * spread * spread);
    float masking = 1.0 / ((toward + sqrt(alpha2 + (1.0 - alpha2) * toward * toward)) *
                           (seen + sqrt(alpha2 + (1.0 - alpha2) * seen * seen)));
    vec3 f = fresnel(s.f0, max(dot(s.view, middle), 0.0));
    return ((1.0 - f) * s.diffuse / AL_PI + f * distribution * masking) * toward;
}

vec3 shade_lights(Surface s, bool shadows)
{
    vec3 sum = vec3(0.0);
    for (int i = 0; i < counts.x; i++) {
        vec3 direction;
        float reach;
        vec3 arriving = light_arrival(i, s.position, 1e8, direction, reach); // no closer than 0.1 mm
        vec3 part = reflectance(s, direction) * arriving;
        if (dot(part, vec3(1.0)) <= 0.0) continue;
        if (shadows) {
            part *= opaque_visibility(i, s.position, s.normal);
            part *= translucent_visibility(s.position, direction, reach, s.own_caster);
        }
#ifdef AL_FOG
        part *= fog_transmittance(s.position, direction, reach, 64.0);
#endif
        sum += part;
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

// Diffuse light from the irradiance of nine coefficients; the lobe's from the picture's mip of its width.
vec3 shade_environment(Surface s)
{
    if (counts.z == 0) return vec3(0.0);
    vec3 lobe = lobe_albedo(s);
    vec3 irradiance = environment_bands(s.normal, vec3(AL_PI, 2.0 * AL_PI / 3.0, AL_PI / 4.0));
    float level = s.roughness * float(max(counts.w - 3, 0));
    vec3 mirrored = environment_radiance(reflect(-s.view, s.normal), level);
    return (1.0 - lobe) * s.diffuse * irradiance / AL_PI + lobe * mirrored;
}

#endif
