#version 450 core
// What arrives along the pixel's ray. Ambient occlusion: 1 where it meets no surface within the radius. AL_INDIRECT: the
// radiance of the surfel it meets, less what the fog in between takes (AL_FOG), in W/(m2 sr).
//
// AL_GLOSSY: a surfel sends more than Lambert's light, which it carries: F (G1 G1 D/(4 cos cos) - albedo/pi) cos E of each
// light (brdf.glsl), lit at the place that is met. A lobe narrower than what the ray stands for would be met seldom and
// glare: it is widened to the solid angle 1/(n p) of one of n rays of density p, of which a microfacet turns through half
// the angle: alpha^2 + 1/(4 pi n p).
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"
#include "bounce_hits.glsl"
#ifdef AL_INDIRECT
#include "shade.glsl"
#include "surfels.glsl"
#endif

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 2) uniform sampler2D rays;
layout(binding = 1, rgba32f) uniform image2D arriving; // a: density, 0: no ray

#ifdef AL_GLOSSY
#ifdef AL_SHADOWS
const bool shadows = true;
#else
const bool shadows = false;
#endif

vec3 gloss(Surface s)
{
    vec3 sum = vec3(0.0);
    for (int i = 0; i < counts.x; i++) {
        vec3 direction;
        float reach;
        vec3 arrived = light_arrival(i, s.position, 1e8, direction, reach);
        vec3 part = (reflectance(s, direction) - s.diffuse / AL_PI * max(dot(s.normal, direction), 0.0)) * arrived;
        if (part != vec3(0.0)) sum += part * light_share(i, s, direction, reach, shadows);
    }
    return sum;
}
#endif

#ifdef AL_INDIRECT
vec3 arriving_from(Surfel s, vec3 place, vec3 direction, float distance_m, float density)
{
    bool front = dot(s.facing.xyz, direction) < 0.0;
    vec3 light = front ? s.front.rgb : s.back.rgb;
#ifdef AL_GLOSSY
    float alpha2 = max(pow(s.facing.w, 4.0), 1e-6) + 0.25 / (AL_PI * density * float(bounce_sample.y));
    Surface sender = Surface(place + distance_m * direction, front ? s.facing.xyz : -s.facing.xyz, -direction,
                             unpack_color(s.back.w), unpack_color(s.front.w), min(pow(alpha2, 0.25), 1.0), -1);
    if (sender.f0 != vec3(0.0)) light = max(light + gloss(sender), vec3(0.0));
#endif
#ifdef AL_FOG
    if (light != vec3(0.0)) light *= fog_transmittance(place, direction, distance_m, 256.0);
#endif
    return min(light, vec3(1e30));
}
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
        light = arriving_from(surfels[hit - 1u], origin + ray.w * direction, ray.xyz, distance_m, density);
    }
#else
    if (hit == 0u || distance_m > bounce_reach.w) light = vec3(1.0);
#endif
    imageStore(arriving, pixel, vec4(light, density));
}
