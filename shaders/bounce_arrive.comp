#version 450 core
// What arrives along the pixel's ray. Ambient occlusion: 1 where it meets no surface within the radius. AL_INDIRECT: the
// radiance of what it meets, less what the fog in between takes (AL_FOG), in W/(m2 sr): of a surfel, which carries Lambert's
// light; of a triangle (AL_TRACED), lit at the place that is met; or what the picture shows of the surface (AL_SHOWN).
//
// AL_GLOSSY: a sender sends more than Lambert's light: F (G1 G1 D/(4 cos cos) - albedo/pi) cos E of each light (brdf.glsl), lit
// at the place that is met. A lobe narrower than what the ray stands for would be met seldom and glare: it is widened to the solid angle 1/(n p) of one of n rays of density p, of which a microfacet turns through half
// the angle: alpha^2 + 1/(4 pi n p).
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"
#include "bounce_hits.glsl"
#ifdef AL_INDIRECT
#include "shade.glsl"
#if defined(AL_TRACED)
#include "material.glsl"
layout(binding = 3) uniform usampler2DArray senders; // at what is met
layout(binding = 4) uniform sampler2DArray glows;    // emission
#elif defined(AL_SHOWN)
layout(binding = 3) uniform sampler2D shown; // radiance
#else
#include "surfels.glsl"
#endif
#endif

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 2) uniform sampler2D rays;
layout(binding = 1, rgba32f) uniform image2D arriving; // a: density, 0: no ray

#if defined(AL_GLOSSY) || defined(AL_TRACED)
#ifdef AL_SHADOWS
const bool shadows = true;
#else
const bool shadows = false;
#endif

// Of the lights, what the sender does not carry.
vec3 part_sent(Surface s, vec3 direction)
{
    vec3 matt = s.diffuse / AL_PI * max(dot(s.normal, direction), 0.0);
#if defined(AL_TRACED) && defined(AL_GLOSSY)
    return reflectance(s, direction);
#elif defined(AL_TRACED)
    return matt;
#else
    return reflectance(s, direction) - matt;
#endif
}

vec3 sent(Surface s)
{
    vec3 sum = vec3(0.0);
    for (int i = 0; i < counts.x; i++) {
        vec3 direction;
        float reach;
        vec3 arrived = light_arrival(i, s.position, 0.0, direction, reach);
        vec3 part = part_sent(s, direction) * arrived;
        if (part != vec3(0.0)) sum += part * light_share(i, s, direction, reach, shadows);
    }
    return sum;
}
#endif

#ifdef AL_INDIRECT
// Roughness that no lobe of a sender is narrower than.
float widened(float roughness, float density)
{
    float alpha2 = max(pow(roughness, 4.0), 1e-6) + 0.25 / (AL_PI * density * float(bounce_sample.y));
    return min(pow(alpha2, 0.25), 1.0);
}

#if defined(AL_TRACED)
vec3 light_from(uint hit, ivec2 pixel, vec3 place, vec3 direction, float density)
{
    uvec4 packed_material = texelFetch(senders, ivec3(pixel, 0), 0);
    Surface sender = unpack_surface(packed_material, unpack_face(packed_material), -direction);
    sender.position = place;
    sender.roughness = widened(sender.roughness, density);
    return texelFetch(glows, ivec3(pixel, 0), 0).rgb + sent(sender);
}
#elif defined(AL_SHOWN)
vec3 light_from(uint hit, ivec2 pixel, vec3 place, vec3 direction, float density)
{
    int at = int(hit) - 1;
    return texelFetch(shown, ivec2(at % shell_size.z, at / shell_size.z), 0).rgb;
}
#else
vec3 light_from(uint hit, ivec2 pixel, vec3 place, vec3 direction, float density)
{
    Surfel s = surfels[hit - 1u];
    bool front = dot(s.facing.xyz, direction) < 0.0;
    vec3 light = front ? s.front.rgb : s.back.rgb;
#ifdef AL_GLOSSY
    Surface sender = Surface(place, front ? s.facing.xyz : -s.facing.xyz, -direction, unpack_color(s.back.w),
                             unpack_color(s.front.w), widened(s.facing.w, density), -1);
    if (sender.f0 != vec3(0.0)) light = max(light + sent(sender), vec3(0.0));
#endif
    return light;
}
#endif
#endif

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, shell_size.zw))) return;
    float density = imageLoad(arriving, pixel).a, distance_m;
    if (density == 0.0) return;
    uint hit = nearest_hit(pixel, distance_m);
    vec3 light = vec3(0.0);
#ifdef AL_INDIRECT
    if (hit != 0u) {
        vec4 ray = texelFetch(rays, pixel, 0);
        vec3 origin, direction;
        view_ray(view_pixel(vec2(pixel) + 0.5), origin, direction);
        origin += ray.w * direction;
        light = light_from(hit, pixel, origin + distance_m * ray.xyz, ray.xyz, density);
#ifdef AL_FOG
        if (light != vec3(0.0)) light *= fog_transmittance(origin, ray.xyz, distance_m, 256.0);
#endif
        light = min(light, vec3(1e30));
    }
#else
    if (hit == 0u || distance_m > bounce_reach.w) light = vec3(1.0);
#endif
    imageStore(arriving, pixel, vec4(light, density));
}
