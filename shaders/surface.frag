#version 450 core
// Opaque: shaded radiance, normal and distance along the pixel's ray. AL_BOUNDARY: the boundary of a
// translucent object, whose distance is negative where its back face comes first (the eye is inside) and
// whose light is the reflected part alone, with the share that it reflects beside it.
#extension GL_GOOGLE_include_directive : enable
#include "shade.glsl"

layout(binding = 2) uniform sampler2D base_color_map;
layout(binding = 3) uniform sampler2D emission_map;
layout(binding = 4) uniform sampler2D metallic_roughness_map;
layout(binding = 5) uniform sampler2D normal_map;

layout(location = 1) uniform vec4 base;      // rgb, metallic
layout(location = 2) uniform vec4 emission;  // rgb in W/(m2 sr), roughness
layout(location = 3) uniform vec4 optics;    // x: dielectric reflectance along the normal; y: 1 double-sided
layout(location = 4) uniform ivec4 maps;     // which of the four textures exist
layout(location = 5) uniform ivec4 choice;   // x: shade at all; y: shadows; z: own caster or -1

in vec3 world_position;
in vec3 world_normal;
in vec2 surface_uv;

layout(location = 0) out vec4 radiance;
layout(location = 1) out vec4 geometry; // normal, distance in m

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

void main()
{
    vec3 origin, direction;
    view_ray(view_pixel(gl_FragCoord.xy), origin, direction);
    float away = dot(world_position - origin, direction);
    float size = length(world_normal);
    vec3 normal = size > 0.0 ? world_normal / size : -direction;
    bool front = gl_FrontFacing;
    if (!front) normal = -normal;
    normal = mapped_normal(normal);
#ifdef AL_BOUNDARY
    geometry = vec4(normal, front ? max(away, 1e-30) : -max(away, 1e-30));
    radiance = vec4(0.0);
    if (!front || choice.x == 0) return;
#else
    geometry = vec4(normal, away);
    radiance = vec4(0.0, 0.0, 0.0, 1.0);
    if (choice.x == 0) return;
#endif
    vec3 color = base.rgb;
    float metallic = base.a, roughness = emission.a;
    if (maps.x != 0) color *= texture(base_color_map, surface_uv).rgb;
    if (maps.z != 0) {
        vec4 texel = texture(metallic_roughness_map, surface_uv);
        metallic *= texel.b;
        roughness *= texel.g;
    }
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
    radiance = vec4(shade_lights(s, choice.y != 0) + shade_environment(s),
                    lobe_albedo(s).x);
#else
    s.diffuse = color * (1.0 - metallic);
    s.f0 = mix(vec3(optics.x), color, metallic);
    vec3 glow = emission.rgb;
    if (maps.y != 0) glow *= texture(emission_map, surface_uv).rgb;
    if (!front && optics.y == 0.0) glow = vec3(0.0);
    radiance = vec4(shade_lights(s, choice.y != 0) + shade_environment(s) + glow, 1.0);
#endif
}
