#version 450 core
// What the medium scatters to the eye of the surfel that the pixel's ray hits, the nearest of all levels: the mean over
// rays drawn by the phase function needs no weight but the depletion and the albedo. AL_LEG: less what the fogs take
// between the surfel and the place on the view ray.
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"
#include "fogs.glsl"
#include "interval_map.glsl"
#include "bounce_hits.glsl"
#include "surfels.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, rgba32f) uniform image2DArray light;
layout(binding = 1, rgba32f) readonly uniform image2D rays;

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, shell_size.xy))) return;
    ivec3 place = ivec3(pixel, 0);
    vec4 before = bounce_sample.x > 0 ? imageLoad(light, place) : vec4(0.0);
    if (any(greaterThanEqual(pixel, shell_size.zw))) {
        imageStore(light, place, vec4(0.0));
        return;
    }
    vec4 ends = texelFetch(interval_ends, pixel, 0), ray = imageLoad(rays, pixel);
    before.a = shell_blur.y != 0 ? ends.z : 1.0;
    float distance_m;
    uint hit = ray.w == 0.0 ? 0u : nearest_hit(pixel, distance_m);
    if (hit != 0u) {
        Surfel s = surfels[hit - 1u];
        vec3 origin, direction, part = dot(s.facing.xyz, ray.xyz) < 0.0 ? s.front.rgb : s.back.rgb;
        view_ray(view_pixel(vec2(pixel) + 0.5), origin, direction);
#ifdef AL_WEIGHTS
        vec2 turn;
        part *= 3.0 * texelFetch(interval_weights, ivec3(pixel, bounce_drawn(pixel + tile.xy, turn)), 0).rgb;
#else
        part *= shell_medium.rgb;
#endif
#ifdef AL_LEG
        if (dot(part, vec3(1.0)) > 0.0)
            part *= fog_transmittance(origin + ray.w * direction, ray.xyz, distance_m, 256.0);
#endif
        before.rgb += min(part * ends.z / float(bounce_sample.y), vec3(1e30));
    }
    imageStore(light, place, before);
}
