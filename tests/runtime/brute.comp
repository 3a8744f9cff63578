#version 450 core
// Light of all surfels that the fog scatters to the eye, by brute force: on every stride-th pixel's ray a march in equal
// steps, at each of them the sum over all surfels.
#extension GL_GOOGLE_include_directive : enable
#include "formulas.glsl"
#include "frame.glsl"
#include "legs.glsl"
#include "surfels.glsl"

layout(local_size_x = 4, local_size_y = 4) in;
layout(location = 0) uniform ivec4 choice; // stride, steps, first surfel, surfels
layout(binding = 2) uniform sampler2D geometry;
layout(binding = 0, rgba32f) uniform image2D light;

vec3 arriving(vec3 place, vec3 direction)
{
    vec3 sum = vec3(0.0), phase = vec3(0.0);
    for (int s = 0; s < choice.w; s++) {
        Surfel surfel = surfels[choice.z + s];
        vec3 path = place - surfel.place.xyz;
        float squared = max(dot(path, path), 1e-30), inverse = inversesqrt(squared);
        path *= inverse;
        float cosine = dot(path, surfel.facing.xyz);
        vec3 radiance = cosine > 0.0 ? surfel.front.rgb : surfel.back.rgb;
        if (dot(radiance, vec3(1.0)) <= 0.0) continue;
        radiance *= al_disc_angle(surfel.place.w, abs(cosine) * squared * inverse, squared);
        radiance *= leg_transmittance(surfel.place.xyz, path, squared * inverse);
        sum += radiance * al_phase(fogs[0].sigma_t.w, -dot(path, direction));
    }
    return sum;
}

void main()
{
    ivec2 place = ivec2(gl_GlobalInvocationID.xy), pixel = place * choice.x + choice.x / 2;
    if (any(greaterThanEqual(place, imageSize(light)))) return;
    vec3 origin, direction, sum = vec3(0.0), tau = vec3(0.0);
    view_ray(view_pixel(vec2(pixel) + 0.5), origin, direction);
    float to = texelFetch(geometry, pixel, 0).w, from, end;
    if (fog_range(origin, direction, to == 0.0 ? 1e30 : to, from, end)) {
        float size = (end - from) / float(choice.y);
        for (int k = 0; k < choice.y; k++) {
            float a = from + float(k) * size;
            vec3 depth = vec3(0.0), source = vec3(0.0);
            for (int i = 0; i < fog_counts.x; i++) {
                float share = fog_depth(i, origin, direction, a, a + size, 1.0);
                depth += fogs[i].sigma_t.rgb * share;
                source += fogs[i].sigma_s.rgb * share;
            }
            if (source != vec3(0.0))
                sum += exp(-(tau + 0.5 * depth)) * source * arriving(origin + direction * (a + 0.5 * size), direction);
            tau += depth;
        }
    }
    if (choice.z > 0) sum += imageLoad(light, place).rgb;
    imageStore(light, place, vec4(sum, 1.0));
}
