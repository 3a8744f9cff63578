#version 450 core
// Whether the pixel's ray meets the triangle whose occlusion volume its place may be in; the depth test keeps the nearest.
// AL_SENDERS: and what the triangle is made of there, as the material target holds it, and its emission.
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"
#include "bounce.glsl"
#include "triangle.glsl"
#ifdef AL_SENDERS
#include "material.glsl"

layout(binding = 2) uniform sampler2D base_color_map;
layout(binding = 3) uniform sampler2D emission_map;
layout(binding = 4) uniform sampler2D metallic_roughness_map;
layout(location = 1) uniform vec4 base;     // rgb, metallic
layout(location = 2) uniform vec4 emission; // rgb in W/(m2 sr), roughness
layout(location = 3) uniform vec4 optics;   // x: dielectric reflectance along the normal; y: 1 double-sided
layout(location = 4) uniform ivec4 maps;    // which of the textures exist
layout(location = 8) uniform float winding; // 1, or -1 where the instance mirrors

flat in vec3 corner_normal[3];
flat in vec2 corner_uv[3];
layout(location = 1) out uvec4 sender; // its normal is that of the side that is met
layout(location = 2) out vec4 glow;    // W/(m2 sr)
#endif

layout(binding = 0, rgba32f) readonly uniform image2D rays; // direction, distance of the origin; 0: none
layout(binding = 6) uniform sampler2D geometry;             // normal, distance

flat in vec3 corner[3];
flat in int number;
layout(location = 0) out uint hit; // number of the triangle, from 1

#ifdef AL_SENDERS
// Where the place lies between the corners.
vec3 shares_at(vec3 place)
{
    vec3 a = corner[0] - place, b = corner[1] - place, c = corner[2] - place, m = cross(b - a, c - a);
    vec3 shares = vec3(dot(cross(b, c), m), dot(cross(c, a), m), dot(cross(a, b), m));
    return shares / (shares.x + shares.y + shares.z);
}

void send(vec3 place, vec3 direction)
{
    vec3 shares = shares_at(place), color = base.rgb, light = emission.rgb;
    vec2 uv = shares.x * corner_uv[0] + shares.y * corner_uv[1] + shares.z * corner_uv[2];
    vec3 face = winding * normalize(cross(corner[1] - corner[0], corner[2] - corner[0]));
    vec3 normal = shares.x * corner_normal[0] + shares.y * corner_normal[1] + shares.z * corner_normal[2];
    float metallic = base.a, roughness = emission.a;
    if (maps.x != 0) color *= textureLod(base_color_map, uv, 0.0).rgb;
    if (maps.y != 0) light *= textureLod(emission_map, uv, 0.0).rgb;
    if (maps.z != 0) {
        vec4 texel = textureLod(metallic_roughness_map, uv, 0.0);
        metallic *= texel.b;
        roughness *= texel.g;
    }
    bool front = dot(face, direction) < 0.0;
    normal = dot(normal, normal) > 0.0 && dot(normal, face) > 0.0 ? normalize(normal) : face;
    sender = pack_material(color, metallic, roughness, optics.x, front ? normal : -normal);
    glow = vec4(front || optics.y != 0.0 ? light : vec3(0.0), 0.0);
}
#endif

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 ray = imageLoad(rays, pixel);
    if (ray.w == 0.0) discard;
    vec3 origin, view, m, normal = texelFetch(geometry, pixel, 0).xyz;
    float height;
    view_ray(view_pixel(vec2(pixel) + 0.5), origin, view);
    origin += ray.w * view;
    vec3 from[3] = vec3[3](corner[0] - origin, corner[1] - origin, corner[2] - origin);
    if (!may_hide(from, normal, ray.w + length(origin), m, height)) discard;
    float t = meet_triangle(from[0], from[1], from[2], ray.xyz);
    if (!(t > 0.0) || t > bounce_reach.w) discard;
    hit = uint(number) + 1u;
    gl_FragDepth = min(t * t / (bounce_reach.y * bounce_reach.y), 1.0);
#ifdef AL_SENDERS
    send(origin + t * ray.xyz, ray.xyz);
#endif
}
