// How the seen surface takes what arrives along a ray, and how densely its rays are drawn.
//
// Ambient occlusion (by default): the cosine over pi, drawn by the cosine, or evenly as published (AL_UNIFORM).
// AL_INDIRECT: the reflectance of brdf.glsl, drawn as it says.
#ifndef AL_BOUNCE_RECEIVER_GLSL
#define AL_BOUNCE_RECEIVER_GLSL

#include "frame.glsl"
#include "bounce.glsl"
#include "material.glsl"

layout(binding = 3) uniform sampler2D geometry; // normal, distance; 0: no surface
#ifdef AL_INDIRECT
layout(binding = 4) uniform usampler2D material;
#endif

struct Receiver {
    Surface surface;
    vec3 face; // normal of the triangle
};

// The seen surface of a pixel of the tile; false: none that takes light. A host's surface has no normal.
bool receiver_at(ivec2 pixel, out Receiver r)
{
    vec4 place = texelFetch(geometry, pixel, 0);
    vec3 origin, direction;
    view_ray(view_pixel(vec2(pixel) + 0.5), origin, direction);
    bool seen = place.w > 0.0 && dot(place.xyz, place.xyz) > 0.25;
#ifdef AL_INDIRECT
    uvec4 packed_material = texelFetch(material, pixel, 0);
    r = Receiver(unpack_surface(packed_material, place.xyz, -direction), unpack_face(packed_material));
    seen = seen && packed_material != uvec4(0u);
#else
    r = Receiver(Surface(vec3(0.0), place.xyz, -direction, vec3(1.0), vec3(0.0), 1.0, -1), place.xyz);
#endif
    r.surface.position = origin + place.w * direction;
    return seen;
}

// What of radiance from a direction counts, per steradian.
vec3 received(Receiver r, vec3 direction)
{
#ifdef AL_INDIRECT
    return dot(r.face, direction) > 0.0 ? reflectance(r.surface, direction) : vec3(0.0);
#else
    return vec3(max(dot(r.surface.normal, direction), 0.0) / AL_PI);
#endif
}

// Of the rays drawn, per steradian.
float ray_density(Receiver r, vec3 direction)
{
#if defined(AL_INDIRECT)
    return reflectance_density(r.surface, direction);
#elif defined(AL_UNIFORM)
    return dot(r.surface.normal, direction) > 0.0 ? 0.5 / AL_PI : 0.0;
#else
    return max(dot(r.surface.normal, direction), 0.0) / AL_PI;
#endif
}

vec3 ray_direction_of(Receiver r, vec2 u)
{
#if defined(AL_INDIRECT)
    return reflectance_direction(r.surface, u);
#elif defined(AL_UNIFORM)
    return turned(r.surface.normal, 1.0 - u.x, u.y);
#else
    return turned(r.surface.normal, sqrt(1.0 - u.x), u.y);
#endif
}

#endif
