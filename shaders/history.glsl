// What the light of the frame before is found by, for reproject.comp and history.comp.
//
// Light is kept as the surface would send it whose albedo is 1, so that textures stay sharp wherever it is taken from.
#ifndef AL_HISTORY_GLSL
#define AL_HISTORY_GLSL

#include "bounce_receiver.glsl"

layout(std140, binding = 6) uniform History {
    mat4 before_view_projection; // of that frame, as are the rays of its view's pixels: frame.glsl
    vec4 before_origin, before_origin_x, before_origin_y, before_direction, before_direction_x, before_direction_y;
    ivec4 kept;         // x, y, width, height: the part of the tile that no other tile makes too, from the tile's corner
    ivec4 history_rule; // x: 1 there is such a frame; y: frames that history may weigh; z: 1 it is never doubted
};

vec3 albedo(Receiver r)
{
#ifdef AL_INDIRECT
    return max(r.surface.diffuse + r.surface.f0, vec3(1e-4));
#else
    return vec3(1.0);
#endif
}

bool is_kept(ivec2 pixel)
{
    return all(greaterThanEqual(pixel, kept.xy)) && all(lessThan(pixel, kept.xy + kept.zw));
}

#endif
