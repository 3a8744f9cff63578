#version 450 core
// What the pixel's ray meets of the surfaces that the view shows: a march through their distances, for comparison with
// carriers that know what the view does not show.
//
// Steps are even in the picture: the share s of the way in it is s w_0 / ((1 - s) w_1 + s w_0) of the way in space, w the
// clip coordinate of origin and end, which is held in the view. The ray has met a surface where it is behind the plane of one by at most
// the thickness, which all surfaces are taken to have. Steps begin at random, within one, in each pixel and sample.
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"
#include "bounce.glsl"

layout(binding = 2) uniform sampler2D rays;     // direction, distance of the origin; 0: none
layout(binding = 3) uniform sampler2D geometry; // normal, distance; 0: no surface
layout(location = 0) uniform vec2 march;        // steps; thickness in m

layout(location = 0) out uint hit; // number of the pixel that shows the surface, from 1

// Shares of the way to `path` beyond clip coordinates `from` at which it crosses the sides of the view and a plane before the eye.
float way_in_view(vec4 from, vec4 path)
{
    float share = 1.0;
    for (int k = 0; k < 3; k++)
        for (float side = -1.0; side <= 1.0; side += 2.0) {
            float inside = k < 2 ? from.w - side * from[k] : 0.99 * from.w, grows = k < 2 ? path.w - side * path[k] : path.w;
            if (grows < 0.0) share = min(share, max(inside, 0.0) / -grows);
        }
    return share;
}

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 ray = texelFetch(rays, pixel, 0);
    if (ray.w == 0.0) discard;
    vec3 origin, view, unused;
    view_ray(view_pixel(vec2(pixel) + 0.5), origin, view);
    origin += ray.w * view;
    float whole = min(bounce_reach.w, 1e-4 * bounce_reach.y);
    vec4 from = view_projection * vec4(origin, 1.0), path = view_projection * vec4(whole * ray.xyz, 0.0);
    float share = way_in_view(from, path);
    whole *= share;
    float end = from.w + share * path.w;
    float begin = unit_float(hash(uint(pixel.x + tile.x), uint(pixel.y + tile.y), uint(shell_counts.z) << 6 ^ uint(bounce_sample.x)));
    for (float k = 0.0; k < march.x; k++) {
        float s = (k + begin) / march.x, t = whole * s * from.w / mix(end, from.w, s);
        vec3 place = origin + t * ray.xyz;
        vec4 clip = view_projection * vec4(place, 1.0);
        ivec2 at = ivec2(floor((clip.xy / clip.w * 0.5 + 0.5) * vec2(tile.zw))) - tile.xy;
        if (at == pixel || any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, shell_size.zw))) continue;
        vec4 shown = texelFetch(geometry, at, 0);
        view_ray(view_pixel(vec2(at) + 0.5), unused, view);
        vec3 path = place - unused - shown.w * view, facing = dot(shown.xyz, shown.xyz) > 0.25 ? shown.xyz : -view; // a host's has no normal
        float below = -dot(path, facing);
        if (shown.w == 0.0 || below <= 1e-5 * shown.w || max(below, dot(path, view)) > march.y) continue;
        hit = uint(at.y * shell_size.z + at.x) + 1u;
        gl_FragDepth = min(t * t / (bounce_reach.y * bounce_reach.y), 1.0);
        return;
    }
    discard;
}
