// The view-dependent surfel cloud, as std430 blocks. AL_SURFELS_WRITE: for the pass that lights it.
#ifndef AL_SURFELS_GLSL
#define AL_SURFELS_GLSL

#ifdef AL_SURFELS_WRITE
#define AL_SURFELS_ACCESS
#else
#define AL_SURFELS_ACCESS readonly
#endif

struct Surfel {
    vec4 place;  // xyz: m, world; w: area in m2
    vec4 facing; // xyz: unit normal of the front; w: roughness
    vec4 front;  // rgb: exitant radiance in W/(m2 sr), Lambert's; w: reflectance along the normal, packed
    vec4 back;   // rgb: likewise of the back; w: Lambert's albedo, packed
    uvec4 edges; // of its triangle: surfel_edges.glsl
};

#include "packed_color.glsl"

layout(std430, binding = 6) AL_SURFELS_ACCESS buffer Surfels { Surfel surfels[]; };
layout(std430, binding = 7) readonly buffer SurfelCount { uint surfel_count; }; // the head of an indirect draw

#endif
