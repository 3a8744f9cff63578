// What a seen surface reflects, as the material target holds it: base colour, metallic, roughness and the dielectric's
// reflectance along the normal as halves, the triangle's own normal (octahedral, Meyer et al. 2010) as two 16-bit numbers.
// All 0: nothing, or a surface that takes no more light.
#ifndef AL_MATERIAL_GLSL
#define AL_MATERIAL_GLSL

#include "brdf.glsl"

vec2 signs(vec2 v)
{
    return vec2(v.x < 0.0 ? -1.0 : 1.0, v.y < 0.0 ? -1.0 : 1.0);
}

uint pack_normal(vec3 normal)
{
    vec3 n = normal / (abs(normal.x) + abs(normal.y) + abs(normal.z));
    return packSnorm2x16(n.z < 0.0 ? (1.0 - abs(n.yx)) * signs(n.xy) : n.xy);
}

vec3 unpack_normal(uint packed_normal)
{
    vec2 v = unpackSnorm2x16(packed_normal);
    vec3 n = vec3(v, 1.0 - abs(v.x) - abs(v.y));
    if (n.z < 0.0) n.xy = (1.0 - abs(v.yx)) * signs(v);
    return normalize(n);
}

uvec4 pack_material(vec3 color, float metallic, float roughness, float reflectance, vec3 face)
{
    return uvec4(packHalf2x16(color.rg), packHalf2x16(vec2(color.b, metallic)),
                 packHalf2x16(vec2(roughness, reflectance)), pack_normal(face));
}

vec3 unpack_face(uvec4 material)
{
    return unpack_normal(material.w);
}

// With the normal and the direction to the eye that are not in it; its place is left 0.
Surface unpack_surface(uvec4 material, vec3 normal, vec3 view)
{
    vec2 x = unpackHalf2x16(material.x), y = unpackHalf2x16(material.y), z = unpackHalf2x16(material.z);
    vec3 color = vec3(x, y.x);
    return Surface(vec3(0.0), normal, view, color * (1.0 - y.y), mix(vec3(z.y), color, y.y), z.x, -1);
}

#endif
