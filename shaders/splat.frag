#version 450 core
// The chord of the pixel's ray in one ball, its light added up.
//
// Marched view leg: in the interval between two knots the density counts as constant, so that the optical
// depth is linear in t. The part [ta, tb] of the chord in it carries the extinguished share T(ta) - T(tb),
// spread evenly, and adds J times
//   (T(ta) - T(tb)) / (tb - ta) * integral over [ta, tb] of w exp(-a |x(t) - b|^2) dt,
// per channel; alpha is the same with the reference transmittance and J = 1: summed over all samples, what the
// Gaussians should have added up to and did not.
//
// AL_VIEW_SH and AL_UNITY: the plain integral of the Gaussian over the chord, from the front surface on to the
// opaque surface (unity: inside the medium); alpha is the integral itself, in m.
#extension GL_GOOGLE_include_directive : enable
#include "formulas.glsl"
#include "frame.glsl"
#include "object.glsl"

layout(binding = 2) uniform sampler2D ends;          // of the interval map
layout(binding = 3) uniform sampler2DArray knots;
layout(binding = 4) uniform sampler2D boundary;
layout(binding = 5) uniform sampler2D geometry;

flat in vec3 center;
flat in vec4 shape;
flat in vec3 light;

layout(location = 0) out vec4 sum;

// Optical depth at knot k: of the largest channel, stored; in grey media from the equal steps.
float knot_depth(float k, float depletion)
{
    return -log(max(1.0 - depletion * k, 1e-30));
}

void main()
{
    ivec2 place = ivec2(gl_FragCoord.xy);
    vec3 origin, direction;
    object_ray(view_pixel(gl_FragCoord.xy), origin, direction);
    vec3 path = center - origin;
    float middle = dot(path, direction);
    vec3 across = path - middle * direction;
    float rho2 = dot(across, across), half2 = shape.y - rho2;
    if (!(half2 > 0.0)) discard;
    float extent = sqrt(half2), ta = middle - extent, tb = middle + extent;
    float profile = shape.w * exp(-shape.x * rho2);

#if defined(AL_VIEW_SH) || defined(AL_UNITY)
#ifdef AL_UNITY
    vec2 span = texelFetch(ends, place, 0).xy;
#else
    float front = texelFetch(boundary, place, 0).w, opaque = texelFetch(geometry, place, 0).w;
    if (toggles.x != 0 && front == 0.0) discard;
    vec2 span = vec2(toggles.x != 0 ? max(front, 0.0) : 0.0, opaque > 0.0 ? opaque : 1e30);
#endif
    ta = max(ta, span.x);
    tb = min(tb, span.y);
    if (!(ta < tb)) discard;
    float part = profile * al_gauss_span(shape.z * (ta - middle), shape.z * (tb - middle));
    sum = vec4(light * part, part);
#else
    vec4 end = texelFetch(ends, place, 0);
    ta = max(ta, end.x);
    tb = min(tb, end.y);
    if (!(ta < tb)) discard;
    int last = sizes.y - 1, k = 0;
    for (int above = last; above - k > 1;) {
        int between = (k + above) >> 1;
        if (texelFetch(knots, ivec3(place, between), 0).r <= ta) k = between; else above = between;
    }
#ifdef AL_CHROMATIC
    vec2 low = texelFetch(knots, ivec3(place, k), 0).rg;
    vec4 part = vec4(0.0);
#else
    float depletion = al_one_minus_exp(end.z) / float(last);
    vec2 low = vec2(texelFetch(knots, ivec3(place, k), 0).r, knot_depth(float(k), depletion));
    float part = 0.0;
#endif
    for (; k < last && low.x < tb; k++) {
#ifdef AL_CHROMATIC
        vec2 high = texelFetch(knots, ivec3(place, k + 1), 0).rg;
#else
        vec2 high = vec2(texelFetch(knots, ivec3(place, k + 1), 0).r,
                         k + 1 == last ? end.z : knot_depth(float(k + 1), depletion));
#endif
        float from = max(ta, low.x), to = min(tb, high.x), extinction = (high.y - low.y) / (high.x - low.x);
        if (to > from) {
            float tau = low.y + extinction * (from - low.x), more = extinction * (to - from);
            float gamma = al_gauss_span(shape.z * (from - middle), shape.z * (to - middle)) / (to - from);
#ifdef AL_CHROMATIC
            vec3 lost = exp(-ratio.rgb * tau) * vec3(al_one_minus_exp(ratio.r * more),
                                                     al_one_minus_exp(ratio.g * more),
                                                     al_one_minus_exp(ratio.b * more));
            part += gamma * vec4(lost, (lost.r + lost.g + lost.b) / ratio.w);
#else
            part += gamma * exp(-tau) * al_one_minus_exp(more);
#endif
        }
        low = high;
    }
    part *= profile;
#ifdef AL_CHROMATIC
    sum = vec4(light * part.rgb, part.a);
#else
    sum = vec4(light, 1.0) * part;
#endif
#endif
}
