#version 450 core
// Opaque: shaded radiance, normal and distance along the pixel's ray. AL_BOUNDARY: the boundary of a
// translucent object, whose distance is negative where its back face comes first (the eye is inside) and
// whose light is the reflected part alone, with the share that it reflects beside it. AL_LIGHTMAP: all light comes
// from the lightmap, L = albedo / pi E, and no lobe. AL_PROBES: light besides the lights' comes from probes.
// AL_MATERIAL: what reflects light that comes later goes to a target of its own; baked light holds all light already.
#extension GL_GOOGLE_include_directive : enable
#include "shade.glsl"
#ifdef AL_MATERIAL
#include "material.glsl"
#endif

layout(binding = 2) uniform sampler2D base_color_map;
layout(binding = 3) uniform sampler2D emission_map;
layout(binding = 4) uniform sampler2D metallic_roughness_map;
layout(binding = 5) uniform sampler2D normal_map;

layout(location = 1) uniform vec4 base;      // rgb, metallic
layout(location = 2) uniform vec4 emission;  // rgb in W/(m2 sr), roughness
layout(location = 3) uniform vec4 optics;    // x: dielectric reflectance along the normal; y: 1 double-sided
layout(location = 4) uniform ivec4 maps;     // which of the four textures exist
#ifdef AL_LIGHTMAP
layout(binding = 6) uniform sampler2DArray irradiance_map; // surface, attenuated, scattered; then the SH of each
layout(location = 7) uniform vec3 layers;                  // W/m2 of each where the texture reads 1
layout(location = 17) uniform vec4 sh_layers; // rgb: W/(m2 sr) of each where the texture reads 1; a: their order
in vec2 page_uv;
#endif
#ifdef AL_PROBES
layout(location = 8) uniform vec3 probe_sh[9]; // incident radiance, W/(m2 sr)
#endif
layout(location = 5) uniform ivec4 choice;   // x: shade at all; y: shadows; z: own caster or -1; w: 1 the environment's
                                             // light comes later

in vec3 world_position;
in vec3 world_normal;
in vec2 surface_uv;

layout(location = 0) out vec4 radiance;
layout(location = 1) out vec4 geometry; // normal, distance in m
#ifdef AL_MATERIAL
layout(location = 2) out uvec4 material;
#endif

// Tangents from screen derivatives (Mikkelsen 2010), so that meshes need not carry them.
vec3 mapped_normal(vec3 normal)
{
    if (maps.w == 0) return normal;
    vec3 dx = dFdx(world_position), dy = dFdy(world_position);
    vec2 ux = dFdx(surface_uv), uy = dFdy(surface_uv);
    vec3 across = cross(dy, normal), up = cross(normal, dx);
    vec3 tangent = across * ux.x + up * uy.x, bitangent = across * ux.y + up * uy.y;
    float size = max(dot(tangent, tangent), dot(bitangent, bitangent));
    if (!(size > 0.0)) return normal;
    vec3 bent = texture(normal_map, surface_uv).xyz * 2.0 - 1.0;
    return normalize(mat3(tangent * inversesqrt(size), bitangent * inversesqrt(size), normal) * bent);
}

#ifdef AL_LIGHTMAP
// W/m2 on the front; the back of a surface has no lightmap.
vec3 baked_irradiance(bool front)
{
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 3; i++)
        if (layers[i] > 0.0) sum += layers[i] * textureLod(irradiance_map, vec3(page_uv, float(i)), 0.0).rgb;
    return front ? sum : vec3(0.0);
}

// How much more light a bent normal gathers than the surface's own: of both the fold of the texel's SH with the
// cosine, whose bands weigh pi, 2 pi/3, pi/4 and, of the fourth, nothing.
vec3 bent_share(vec3 own, vec3 bent)
{
    int order = int(sh_layers.a), count = min(order * order, 9);
    if (order < 2 || bent == own) return vec3(1.0);
    float at_own[AL_SH_MAX_COUNT], at_bent[AL_SH_MAX_COUNT];
    al_sh_basis(3, own.x, own.y, own.z, at_own);
    al_sh_basis(3, bent.x, bent.y, bent.z, at_bent);
    vec3 before = vec3(0.0), after = vec3(0.0);
    for (int i = 0; i < 3; i++) {
        if (sh_layers[i] == 0.0) continue;
        for (int k = 0; k < count; k++) {
            vec3 value = sh_layers[i] * textureLod(irradiance_map, vec3(page_uv, float(3 + i * order * order + k)), 0.0).rgb;
            value *= k == 0 ? 1.0 : k < 4 ? 2.0 / 3.0 : 0.25;
            before += value * at_own[k];
            after += value * at_bent[k];
        }
    }
    vec3 share = clamp(after / max(before, vec3(1e-30)), 0.0, 4.0);
    return mix(share, vec3(1.0), lessThanEqual(before, vec3(0.0)));
}
#endif

#ifdef AL_PROBES
vec3 probe_irradiance(vec3 normal)
{
    float basis[AL_SH_MAX_COUNT];
    al_sh_basis(3, normal.x, normal.y, normal.z, basis);
    vec3 sum = probe_sh[0] * basis[0] * AL_PI;
    for (int i = 1; i < 4; i++) sum += probe_sh[i] * basis[i] * 2.0 * AL_PI / 3.0;
    for (int i = 4; i < 9; i++) sum += probe_sh[i] * basis[i] * AL_PI / 4.0;
    return max(sum, vec3(0.0));
}
#endif

void main()
{
    vec3 origin, direction;
    view_ray(view_pixel(gl_FragCoord.xy), origin, direction);
    float away = dot(world_position - origin, direction);
    float size = length(world_normal);
    vec3 normal = size > 0.0 ? world_normal / size : -direction;
    bool front = gl_FrontFacing;
    if (!front) normal = -normal;
    vec3 own = normal;
    normal = mapped_normal(normal);
#ifdef AL_BOUNDARY
    geometry = vec4(normal, front ? max(away, 1e-30) : -max(away, 1e-30));
    radiance = vec4(0.0);
    if (!front || choice.x == 0) return;
#else
    geometry = vec4(normal, away);
    radiance = vec4(0.0, 0.0, 0.0, 1.0);
#ifndef AL_MATERIAL
    if (choice.x == 0) return;
#endif
#endif
    vec3 color = base.rgb;
    float metallic = base.a, roughness = emission.a;
    if (maps.x != 0) color *= texture(base_color_map, surface_uv).rgb;
    if (maps.z != 0) {
        vec4 texel = texture(metallic_roughness_map, surface_uv);
        metallic *= texel.b;
        roughness *= texel.g;
    }
#ifdef AL_MATERIAL
#if defined(AL_LIGHTMAP) || defined(AL_PROBES)
    material = uvec4(0u);
#else
    material = pack_material(color, metallic, roughness, optics.x, own);
#endif
    if (choice.x == 0) return;
#endif
    Surface s;
    s.position = world_position;
    s.normal = normal;
    s.view = -direction;
    s.roughness = roughness;
    s.own_caster = choice.z;
#ifdef AL_BOUNDARY
    s.diffuse = vec3(0.0);
    s.f0 = vec3(optics.x);
    if (optics.x == 0.0) return; // index-matched
    radiance = vec4(shade_lights(s, choice.y != 0) + shade_environment(s, 1.0),
                    lobe_albedo(s).x);
#else
    s.diffuse = color * (1.0 - metallic);
    s.f0 = mix(vec3(optics.x), color, metallic);
    vec3 glow = emission.rgb;
    if (maps.y != 0) glow *= texture(emission_map, surface_uv).rgb;
    if (!front && optics.y == 0.0) glow = vec3(0.0);
#if defined(AL_LIGHTMAP)
    radiance = vec4(s.diffuse / AL_PI * baked_irradiance(front) * bent_share(own, normal) + glow, 1.0);
#elif defined(AL_PROBES)
    radiance = vec4(shade_lights(s, choice.y != 0) + s.diffuse / AL_PI * probe_irradiance(s.normal) + glow, 1.0);
#else
    radiance = vec4(shade_lights(s, choice.y != 0) + (choice.w != 0 ? vec3(0.0) : shade_environment(s, 1.0)) + glow, 1.0);
#endif
#endif
}
