#version 450 core
// What one surfel adds to the samples of one pixel's ray that lie in the shell: radiance at the eye.
//
// A disc of area A, seen at distance d under the angle theta from its normal, fills about A cos theta/d^2 far away;
// near it al_disc_angle keeps the mean over discs laid at random. AL_CLAMPED: the paper's A cos theta / max(d^2, A/pi),
// which is too dark there.
// AL_LEG: what the fogs leave of light between the surfel and the sample; the paper takes all of it.
#extension GL_GOOGLE_include_directive : enable
#include "formulas.glsl"
#include "frame.glsl"
#include "legs.glsl"
#include "interval_map.glsl"

flat in vec4 place;
flat in vec3 facing, front, back;
flat in vec4 shell;
layout(location = 0) out vec4 light;

float solid_angle(float cosine, float squared)
{
#ifdef AL_CLAMPED
    return place.w * cosine / max(squared, place.w / AL_PI);
#else
    return al_disc_angle(place.w, cosine * sqrt(squared), squared);
#endif
}

void main()
{
    light = vec4(0.0);
    ivec2 pixel = pixel_of_texel(ivec2(gl_FragCoord.xy), int(shell.w));
    if (any(greaterThanEqual(pixel, shell_size.zw))) discard;
    vec4 ends = texelFetch(interval_ends, pixel, 0);
    if (ends.z <= 0.0) discard;
    vec3 origin, direction, sum = vec3(0.0);
    view_ray(view_pixel(vec2(pixel) + 0.5), origin, direction);
    vec3 base = origin - place.xyz;
    float foot = dot(base, direction);
    if (dot(base, base) - foot * foot >= shell.y * 1.001) discard;

    uvec4 words;
#ifdef AL_COEFFICIENTS
    uvec4 values;
    uvec2 at = uvec2(pixel + tile.xy);
    float before = ends.x, xi = shell_blur.w != 0 ? 0.0 : unit_float(hash(at.x, at.y, uint(shell_counts.z)));
#endif
    float t = ends.x, g = shell_medium.w;
    for (int k = 0; k < shell_counts.y; k++) {
        if ((k & 15) == 0) {
            words = texelFetch(interval_steps, ivec3(pixel, k >> 4), 0);
#ifdef AL_COEFFICIENTS
            values = texelFetch(interval_coefficients, ivec3(pixel, k >> 4), 0);
#endif
        }
        t += interval_step(words, k) * ends.y;
#ifdef AL_COEFFICIENTS
        float length_m = t - before;
        before = t;
#endif
        vec3 path = base + t * direction;
        float squared = dot(path, path);
        if (squared < shell.x || squared >= shell.y) continue;
        float inverse = inversesqrt(max(squared, 1e-30)), cosine = dot(path, facing) * inverse;
        path *= inverse;
        vec3 part = (cosine > 0.0 ? front : back) * solid_angle(abs(cosine), max(squared, 1e-30));
#ifdef AL_LEG
        part *= leg_transmittance(place.xyz, path, squared * inverse);
#endif
#if defined(AL_WEIGHTS)
        vec4 weight = texelFetch(interval_weights, ivec3(pixel, k), 0);
        g = fogs[int(weight.a * 255.0 + 0.5)].sigma_t.w;
        part *= 3.0 * weight.rgb;
#elif defined(AL_COEFFICIENTS)
        part *= interval_byte(values, k) / 255.0 * (1.0 - (float(k + 1) - xi) * ends.z / float(shell_counts.y)) * length_m;
#endif
        sum += part * al_phase(g, -dot(path, direction));
    }
#if defined(AL_COEFFICIENTS)
    sum *= shell_medium.rgb * ends.w;
#elif defined(AL_WEIGHTS)
    sum *= ends.z / float(shell_counts.y);
#else
    sum *= shell_medium.rgb * ends.z / float(shell_counts.y);
#endif
    light = vec4(min(sum * shell.z, vec3(1e30)), 0.0);
}
