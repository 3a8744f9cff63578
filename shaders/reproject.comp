#version 450 core
// Light of the frame before at the places that the pixels see now, by the four pixels around where that frame saw them. Each
// counts only if it saw that place: its own lies within a pixel's width of the surface's tangent plane, and its normal within
// 25 degrees of the surface's. So what comes into view has no history, nor has what moves along its normal; what slides along
// its plane keeps the plane's.
//
// Light off a lobe belongs to its direction of view. When that turns by t a frame, what is mirrored turns by 2 t, and n frames
// spread it over 2 n t. Raised by x each frame, 1/n settles at sqrt(x): (4 t / alpha)^2, for the lobe's share of the light, holds
// the spread to half of alpha, the lobe's own width.
#extension GL_GOOGLE_include_directive : enable
#include "history.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 2) uniform sampler2D before_light;                // of the view; a: frames in it, 0: none
layout(binding = 5) uniform usampler2D before_places;              // of the view: normal, distance; 0: none
layout(binding = 1, rgba32f) writeonly uniform image2D carried;    // of the tile: what of before_light is here now
layout(binding = 2, rgba32f) uniform image2D light;                // of the tile; a: samples, then 1; 0: none
layout(binding = 3, rg32ui) writeonly uniform uimage2D places;     // of the view

void before_ray(vec2 pixel, out vec3 origin, out vec3 direction)
{
    origin = before_origin.xyz + pixel.x * before_origin_x.xyz + pixel.y * before_origin_y.xyz;
    direction = normalize(before_direction.xyz + pixel.x * before_direction_x.xyz + pixel.y * before_direction_y.xyz);
}

bool saw(ivec2 at, vec3 place, vec3 normal, float width)
{
    if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, tile.zw))) return false;
    uvec2 there = texelFetch(before_places, at, 0).xy;
    if (there.y == 0u || dot(unpack_normal(there.x), normal) < 0.9) return false;
    vec3 origin, direction;
    before_ray(vec2(at) + 0.5, origin, direction);
    return abs(dot(normal, origin + uintBitsToFloat(there.y) * direction - place)) <= width;
}

// Frames that count after the eye has seen the place from another side.
float turned_frames(Receiver r, vec2 at, float frames)
{
#ifdef AL_INDIRECT
    vec3 origin, direction;
    before_ray(at, origin, direction);
    float share = 1.0 - lambert_share(r.surface), turn = 4.0 * length(direction + r.surface.view) / lobe_alpha(r.surface);
    return 1.0 / (1.0 / frames + share * turn * turn);
#else
    return frames;
#endif
}

vec4 carried_to(Receiver r, float width)
{
    vec4 clip = before_view_projection * vec4(r.surface.position, 1.0);
    vec2 at = (0.5 * clip.xy / clip.w + 0.5) * vec2(tile.zw);
    bool in_view = clip.w > 0.0 && all(greaterThan(at, vec2(-1.0))) && all(lessThan(at, vec2(tile.zw) + 1.0));
    if (!in_view) return vec4(0.0);
    vec2 corner = floor(at - 0.5), part = at - 0.5 - corner;
    vec4 sum = vec4(0.0);
    float whole = 0.0;
    for (int i = 0; i < 4; i++) {
        ivec2 step = ivec2(i & 1, i >> 1), pixel = ivec2(corner) + step;
        float weight = (step.x == 1 ? part.x : 1.0 - part.x) * (step.y == 1 ? part.y : 1.0 - part.y);
        if (weight <= 0.0 || !saw(pixel, r.surface.position, r.surface.normal, width)) continue;
        sum += weight * texelFetch(before_light, pixel, 0);
        whole += weight;
    }
    if (whole < 0.01 || !(sum.a > 0.0)) return vec4(0.0);
    sum /= whole;
    return vec4(sum.rgb, turned_frames(r, at, sum.a));
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(light)))) return;
    vec4 sum = imageLoad(light, pixel), here = vec4(0.0), there = vec4(0.0);
    uvec2 place = uvec2(0u);
    Receiver r;
    if (receiver_at(pixel, r) && sum.a > 0.0) {
        float distance_m = texelFetch(geometry, pixel, 0).w;
        vec3 beside, direction;
        view_ray(view_pixel(vec2(pixel) + vec2(1.5, 0.5)), beside, direction);
        float width = length(beside + distance_m * direction - r.surface.position);
        here = vec4(sum.rgb / (sum.a * albedo(r)), 1.0);
        if (history_rule.x == 1) there = carried_to(r, width);
        place = uvec2(pack_normal(r.surface.normal), floatBitsToUint(distance_m));
    }
    imageStore(light, pixel, here);
    imageStore(carried, pixel, there);
    if (is_kept(pixel)) imageStore(places, pixel + tile.xy, uvec4(place, 0u, 0u));
}
