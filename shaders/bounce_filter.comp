#version 450 core
// The rays of the pixels around, as the pixel itself receives them. Samples are added up here, so that none is stored.
//
// With F what the pixel's surface takes of radiance L from a direction (BRDF times cosine), p the density of its own ray w,
// p_j that of neighbour j's ray w_j, k_j how like the two places are, and K the sum of all k_j, the mean over neighbours of
//   k_j/K F(w) L / (p(w) + K p_j(w)) + k_j F(w_j) L_j / (p(w_j) + K p_j(w_j))
// expects what F L/p does, where both places receive the same light: the two weights of a direction sum to k_j/K, by the
// balance heuristic (Veach and Guibas 1995) of one own ray and K of the neighbour's, pair by pair (Bitterli 2022). Where
// all densities are alike every ray counts by its k, the own one by 1. No term is larger than F/p, which is an albedo: a
// mirror's neighbour adds nothing that glares, and no likeness of materials is asked for.
//
// Likeness: exp(-(h/s)^2 - 8 (1 - n.n') - 2 (d/R)^2), h the other place's height above the pixel's tangent plane, s as far
// as R pixels reach there, d the pixels between.
#extension GL_GOOGLE_include_directive : enable
#include "bounce_receiver.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 2) uniform sampler2D rays;
layout(binding = 1, rgba32f) readonly uniform image2D arriving; // a: density, 0: no ray
layout(binding = 2, rgba32f) uniform image2D light;             // rgb: sum; a: samples

// 0: the pixel itself, or it has no ray.
float likeness(Receiver own, ivec2 pixel, ivec2 at, float reach)
{
    ivec2 off = at - pixel;
    if (off == ivec2(0) || imageLoad(arriving, at).a == 0.0) return 0.0;
    vec4 other = texelFetch(geometry, at, 0);
    vec3 origin, direction;
    view_ray(view_pixel(vec2(at) + 0.5), origin, direction);
    float height = dot(own.surface.normal, origin + other.w * direction - own.surface.position) / reach;
    float across = float(off.x * off.x + off.y * off.y) / float(bounce_sample.w * bounce_sample.w);
    return exp(-height * height - 8.0 * max(1.0 - dot(own.surface.normal, other.xyz), 0.0) - 2.0 * across);
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, shell_size.zw))) return;
    vec4 sum = bounce_sample.x > 0 ? imageLoad(light, pixel) : vec4(0.0), arrived = imageLoad(arriving, pixel);
    Receiver own, other;
    if (!receiver_at(pixel, own) || arrived.a == 0.0) {
        imageStore(light, pixel, sum);
        return;
    }
    int radius = bounce_sample.w;
    vec3 beside, direction, towards = texelFetch(rays, pixel, 0).xyz;
    view_ray(view_pixel(vec2(pixel) + vec2(1.5, 0.5)), beside, direction);
    beside += texelFetch(geometry, pixel, 0).w * direction;
    float reach = float(max(radius, 1)) * length(beside - own.surface.position), alike = 0.0;
    ivec2 low = max(pixel - radius, ivec2(0)), high = min(pixel + radius, shell_size.zw - 1);
    for (int y = low.y; y <= high.y; y++)
        for (int x = low.x; x <= high.x; x++) alike += likeness(own, pixel, ivec2(x, y), reach);
    vec3 here = received(own, towards) * arrived.rgb, light_here = alike > 0.0 ? vec3(0.0) : here / arrived.a;
    for (int y = low.y; y <= high.y && alike > 0.0; y++)
        for (int x = low.x; x <= high.x; x++) {
            ivec2 at = ivec2(x, y);
            float like = likeness(own, pixel, at, reach);
            if (like <= 0.0 || !receiver_at(at, other)) continue;
            vec4 there = imageLoad(arriving, at);
            vec3 its = texelFetch(rays, at, 0).xyz;
            light_here += like / alike * here / (arrived.a + alike * ray_density(other, towards));
            light_here += like * received(own, its) * there.rgb / (ray_density(own, its) + alike * there.a);
        }
    imageStore(light, pixel, sum + vec4(light_here, 1.0));
}
