#version 450 core
// One ray per pixel from one sample of its ray through the medium, drawn among them, into a direction drawn from the
// phase function there: where its light may come from.
//
// Henyey-Greenstein's cosine between the directions of travel is drawn by inverting its distribution (Witt 1977);
// near g = 0 that cancels, and the series 1 - 2 u + ... is not needed below 1e-3: an even draw is within g of it.
#extension GL_GOOGLE_include_directive : enable
#include "formulas.glsl"
#include "frame.glsl"
#include "fogs.glsl"
#include "interval_map.glsl"
#include "bounce.glsl"
#include "turned.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, rgba32f) writeonly uniform image2D rays; // direction, distance of the origin; 0: none

float scattering_cosine(float g, float u)
{
    if (abs(g) < 1e-3) return 1.0 - 2.0 * u;
    float root = (1.0 - g * g) / (1.0 + g - 2.0 * g * u);
    return clamp((1.0 + g * g - root * root) / (2.0 * g), -1.0, 1.0);
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, shell_size.zw))) return;
    vec4 ends = texelFetch(interval_ends, pixel, 0);
    imageStore(rays, pixel, vec4(0.0));
    if (ends.z <= 0.0) return;
    vec2 turn;
    int drawn = bounce_drawn(pixel + tile.xy, turn);
    uvec4 words;
    float t = ends.x;
    for (int k = 0; k <= drawn; k++) {
        if ((k & 15) == 0) words = texelFetch(interval_steps, ivec3(pixel, k >> 4), 0);
        t += interval_step(words, k) * ends.y;
    }
    float g = shell_medium.w;
#ifdef AL_WEIGHTS
    g = fogs[int(texelFetch(interval_weights, ivec3(pixel, drawn), 0).a * 255.0 + 0.5)].sigma_t.w;
#endif
    vec3 origin, direction;
    view_ray(view_pixel(vec2(pixel) + 0.5), origin, direction);
    // Light travels to the eye along -direction, and came along minus the ray's: the cosine is that of the two rays.
    imageStore(rays, pixel, vec4(turned(direction, scattering_cosine(g, turn.x), turn.y), max(t, 1e-30)));
}
