#version 450 core
// The share of the pixel's hemisphere that the triangle hides; shares are added up, so that what several triangles hide
// from one place counts as often (McGuire 2010).
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"
#include "bounce.glsl"
#include "triangle.glsl"

layout(binding = 6) uniform sampler2D geometry; // normal, distance; 0: no surface

flat in vec3 corner[3];
flat in int number;
layout(location = 0) out vec4 hidden;

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 place = texelFetch(geometry, pixel, 0);
    if (place.w == 0.0 || dot(place.xyz, place.xyz) < 0.25) discard; // a host's surface has no normal
    vec3 origin, view, m;
    view_ray(view_pixel(vec2(pixel) + 0.5), origin, view);
    origin += place.w * view;
    vec3 from[3] = vec3[3](corner[0] - origin, corner[1] - origin, corner[2] - origin);
    float height;
    if (!may_hide(from, place.xyz, place.w + length(origin), m, height)) discard;
    hidden = vec4(vec3(form_factor(from, place.xyz, m, height, bounce_reach.w)), 0.0);
}
