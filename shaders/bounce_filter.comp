#version 450 core
// The rays of the pixels around, weighed as the pixel itself receives them: by its cosine over the density of each,
// and by how like the two places are (cross-bilateral). Samples are added up here, so that none is stored.
//
// Likeness: exp(-(h/s)^2 - 8 (1 - n.n') - 2 (d/R)^2), h the other place's height above the pixel's tangent plane, s as far
// as R pixels reach there, d the pixels between.
#extension GL_GOOGLE_include_directive : enable
#include "formulas.glsl"
#include "frame.glsl"
#include "bounce.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 2) uniform sampler2D rays;
layout(binding = 3) uniform sampler2D geometry;
layout(binding = 1, rgba32f) readonly uniform image2D arriving; // a: density, 0: no ray
layout(binding = 2, rgba32f) uniform image2D light;             // rgb: sum; a: of the weights

vec3 place_of(ivec2 pixel, float distance_m)
{
    vec3 origin, direction;
    view_ray(view_pixel(vec2(pixel) + 0.5), origin, direction);
    return origin + distance_m * direction;
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, shell_size.zw))) return;
    vec4 own = texelFetch(geometry, pixel, 0);
    vec3 place = place_of(pixel, own.w);
    int radius = bounce_sample.w;
    float far = float(max(radius, 1)), reach = far * length(place_of(pixel + ivec2(1, 0), own.w) - place);
    vec4 sum = bounce_sample.x > 0 ? imageLoad(light, pixel) : vec4(0.0);
    ivec2 low = max(pixel - radius, ivec2(0)), high = min(pixel + radius, shell_size.zw - 1);
    for (int y = low.y; y <= high.y; y++)
        for (int x = low.x; x <= high.x; x++) {
            ivec2 at = ivec2(x, y), off = at - pixel;
            vec4 arrived = imageLoad(arriving, at), other = texelFetch(geometry, at, 0);
            if (arrived.a == 0.0 || texelFetch(rays, pixel, 0).w == 0.0) continue;
            float height = dot(own.xyz, place_of(at, other.w) - place) / reach;
            float like = exp(-height * height - 8.0 * max(1.0 - dot(own.xyz, other.xyz), 0.0) -
                             2.0 * float(off.x * off.x + off.y * off.y) / (far * far));
            float cosine = max(dot(own.xyz, texelFetch(rays, at, 0).xyz), 0.0);
            sum += like * vec4(cosine / (AL_PI * arrived.a) * arrived.rgb, 1.0);
        }
    imageStore(light, pixel, sum);
}
