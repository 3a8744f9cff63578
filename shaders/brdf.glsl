// How a surface reflects: Lambert and a GGX lobe (Walter et al. 2007) with Schlick's Fresnel term and the separable Smith
// masking, in glTF's metallic-roughness terms. As precompute/reference/reflection.c, in double precision there.
#ifndef AL_BRDF_GLSL
#define AL_BRDF_GLSL

#include "formulas.glsl"
#include "turned.glsl"

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

float lobe_alpha(Surface s)
{
    return max(s.roughness * s.roughness, 1e-3);
}

float cosine_to_eye(Surface s) // below an interpolated normal too
{
    return max(dot(s.normal, s.view), 1e-4);
}

// GGX's D at a microfacet. 1 - facing^2 (1 - alpha^2), as a sum of what does not cancel near the peak.
float distribution(Surface s, vec3 middle)
{
    float alpha = lobe_alpha(s), alpha2 = alpha * alpha, facing = clamp(dot(s.normal, middle), 0.0, 1.0);
    vec3 across = cross(s.normal, middle);
    float spread = dot(across, across) + facing * facing * alpha2;
    return alpha2 / (AL_PI * spread * spread);
}

// Smith's G1 / (2 cosine).
float masking(Surface s, float cosine)
{
    float alpha = lobe_alpha(s), alpha2 = alpha * alpha;
    return 1.0 / (cosine + sqrt(alpha2 + (1.0 - alpha2) * cosine * cosine));
}

vec3 half_way(Surface s, vec3 light)
{
    return normalize(light + s.view + vec3(1e-20));
}

// GGX lobe times the cosine towards the light; diffuse light is what the Fresnel term leaves. Per steradian.
vec3 reflectance(Surface s, vec3 light)
{
    float toward = dot(s.normal, light);
    if (toward <= 0.0) return vec3(0.0);
    vec3 middle = half_way(s, light);
    vec3 f = fresnel(s.f0, max(dot(s.view, middle), 0.0));
    float lobe = distribution(s, middle) * masking(s, toward) * masking(s, cosine_to_eye(s));
    return ((1.0 - f) * s.diffuse / AL_PI + f * lobe) * toward;
}

// Directions towards the light are drawn as the reflectance: of Lambert's part by the cosine, of the lobe by its visible
// microfacets; this share of them Lambert's, by the albedos seen from the eye.
float lambert_share(Surface s)
{
    float seen = dot(s.normal, s.view), mirrored = min(dot(fresnel(s.f0, max(seen, 0.0)), vec3(1.0 / 3.0)), 1.0);
    float diffuse = dot(s.diffuse, vec3(1.0 / 3.0)) * (1.0 - mirrored);
    return mirrored > 0.0 && seen > 1e-4 ? diffuse / (diffuse + mirrored) : 1.0;
}

// Per steradian. Microfacets are drawn with density G1(view) D max(0, view . m) / cos_view, light off them with that over
// 4 view . m. What they reflect below the surface is drawn too.
float reflectance_density(Surface s, vec3 light)
{
    float share = lambert_share(s);
    return share * max(dot(s.normal, light), 0.0) / AL_PI +
           (1.0 - share) * 0.5 * masking(s, cosine_to_eye(s)) * distribution(s, half_way(s, light));
}

// A direction for u in [0, 1)^2. GGX microfacets are those of an ellipsoid (Heitz 2018): stretched by 1/alpha across, it is
// a hemisphere, and a mirrored sphere turns parallel light evenly into all directions. The upper hemisphere turns light
// from v into all those with z > -v.z; so a microfacet as v sees it is half way between v and a direction drawn evenly from
// that cap (Dupuy and Benyoub 2023).
vec3 reflectance_direction(Surface s, vec2 u)
{
    float share = lambert_share(s), alpha = lobe_alpha(s);
    if (u.x < share) return turned(s.normal, sqrt(1.0 - u.x / share), u.y);
    u.x = (u.x - share) / (1.0 - share);
    vec3 x, y;
    axes_across(s.normal, x, y);
    vec3 v = normalize(vec3(alpha * dot(x, s.view), alpha * dot(y, s.view), cosine_to_eye(s)));
    float z = 1.0 - u.x * (1.0 + v.z), sine = sqrt(max(1.0 - z * z, 0.0)), angle = 2.0 * AL_PI * u.y;
    vec3 m = v + vec3(sine * cos(angle), sine * sin(angle), z);
    m = normalize(vec3(alpha * m.xy, max(m.z, 1e-12)));
    return normalize(reflect(-s.view, m.x * x + m.y * y + m.z * s.normal));
}

#endif
