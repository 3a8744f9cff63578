#version 450 core
// The chord of the pixel's ray in one ball, its light added up.
//
// Marched view leg: between two knots of the interval map the transmittance T falls linearly by D_c in
// channel c; behind the last but one it falls exponentially, for there little is left and where it is left
// matters. The part of the chord in an interval adds J times
//   (what T loses over the part) times (the mean of w exp(-a |x(t) - b|^2) over the part),
// alpha the same with the reference transmittance and J = 1: summed over all samples, what the Gaussians
// should have added up to and did not. J is taken at the middle of each part: it falls as fast as T, and J at
// the chord's mean depth would be 1/e where the mean of J is 1/2.
//
// AL_VIEW_SH: J times the plain integral of the Gaussian over the chord inside the object, from the front
// surface on to the last back one or an opaque one; alpha is the transmittance that the sample's spherical
// harmonics lose over it. AL_UNITY: alpha is the integral itself, in m, inside the medium.
#extension GL_GOOGLE_include_directive : enable
#include "formulas.glsl"
#include "frame.glsl"
#include "object.glsl"

layout(binding = 2) uniform sampler2D ends;          // of the interval map
layout(binding = 3) uniform sampler2DArray knots; // four a texel
layout(binding = 4) uniform sampler2D boundary;
layout(binding = 5) uniform sampler2D geometry;
layout(binding = 6) uniform sampler2D back; // AL_VIEW_SH: distance of the last face

flat in vec3 center;
flat in vec4 shape; // a in 1/m^2, radius squared, sqrt(a), weight
flat in vec4 light; // rgb; what alpha adds up
flat in vec3 slope;

layout(location = 0) out vec4 sum;

#ifdef AL_CHROMATIC
#define Share vec4 // rgb and the reference
Share transmittance(float tau)
{
    vec3 t = exp(-ratio.rgb * tau);
    return vec4(t, 1.0 - (3.0 - t.r - t.g - t.b) / ratio.w);
}
#else
#define Share float
#endif

// The mean of exp(-x^2) between x0 <= x1, given the error function at both. Short spans by their middle,
// where the difference would cancel: relative error below d^2 |4 m^2 - 2| / 24 = 1e-3 and only far out.
float mean_gauss(float x0, float x1, float erf0, float erf1)
{
    float d = x1 - x0, middle = 0.5 * (x0 + x1);
    return d > 0.03 ? 0.886226925452758 * max(erf1 - erf0, 0.0) / d : exp(-middle * middle);
}

// Share of the interval [low, high] that lies in [from, to]; a jump (low = high) counts whole when it is
// inside.
float overlap(float low, float high, float from, float to)
{
    return high > low ? (to - from) / (high - low) : low >= from && low <= to ? 1.0 : 0.0;
}

// What J is over what it is at the sample, where its logarithm has grown by x; beyond e^2 it would be a guess.
float growth(float x)
{
    return exp(clamp(x, -2.0, 2.0));
}

void main()
{
    ivec2 place = ivec2(gl_FragCoord.xy);
    vec3 origin, direction;
    object_ray(view_pixel(gl_FragCoord.xy), origin, direction);
    vec3 path = center - origin;
    float middle = dot(path, direction);
    vec3 across = path - middle * direction;
    float rho2 = dot(across, across), chord2 = shape.y - rho2;
    if (!(chord2 > 0.0)) discard;
    float extent = sqrt(chord2), ta = middle - extent, tb = middle + extent;
    float profile = shape.w * exp(-shape.x * rho2);

#if defined(AL_VIEW_SH) || defined(AL_UNITY)
#ifdef AL_UNITY
    vec2 span = texelFetch(ends, place, 0).xy;
#else
    float front = texelFetch(boundary, place, 0).w, opaque = texelFetch(geometry, place, 0).w;
    if (toggles.x != 0 && front == 0.0) discard;
    vec2 span = vec2(0.0, opaque > 0.0 ? opaque : 1e30);
    if (toggles.x != 0) span = vec2(max(front, 0.0), min(span.y, texelFetch(back, place, 0).x));
#endif
    ta = max(ta, span.x);
    tb = min(tb, span.y);
    if (!(ta < tb)) discard;
    float part = profile / shape.z * al_gauss_span(shape.z * (ta - middle), shape.z * (tb - middle));
#ifdef AL_UNITY
    sum = vec4(light.rgb, 1.0) * part;
#else
    sum = light * part;
#endif
#else
    vec4 end = texelFetch(ends, place, 0);
    ta = max(ta, end.x);
    tb = min(tb, end.y);
    if (!(ta < tb)) discard;
    // Group j holds the knots 4j+1 to 4j+4 but for the last one, which the ends hold; unused places repeat
    // the last but one.
    int count = sizes.y - 2, groups = (count + 3) / 4, j = 0;
    float low = end.x;
    vec4 group = vec4(low);
    for (; j < groups; j++) {
        group = texelFetch(knots, ivec3(place, j), 0);
        if (group.w > ta) break;
        low = group.w;
    }
    // The first of the group's knots behind the start of the chord.
    int c = int(dot(vec4(lessThanEqual(group, vec4(ta))), vec4(1.0)));
    low = c > 0 ? group[c - 1] : low;
    float here = clamp(low, ta, tb), x = shape.z * (here - middle), erf_x = al_erf(x);
    Share part = Share(0.0);
    Share lit = Share(0.0); // sum of shares times the growth of J
    float along = dot(slope, direction), aside = dot(slope, across);
#ifdef AL_CHROMATIC
    Share above = vec4(1.0);
    if (c > 0) above = transmittance(texelFetch(knots, ivec3(place, groups + j), 0)[c - 1]);
    else if (j > 0) above = transmittance(texelFetch(knots, ivec3(place, groups + j - 1), 0).w);
#else
    float step = al_one_minus_exp(end.z) / float(sizes.y - 1);
#endif
    for (; j < groups && low < tb; j++) {
#ifdef AL_CHROMATIC
        vec4 depths = texelFetch(knots, ivec3(place, groups + j), 0);
#endif
        for (; c < min(4, count - 4 * j) && low < tb; c++) {
            float high = group[c], next = clamp(high, ta, tb), next_x = shape.z * (next - middle);
            float next_erf = al_erf(next_x);
            float mean = overlap(low, high, here, next) * mean_gauss(x, next_x, erf_x, next_erf);
#ifdef AL_CHROMATIC
            Share below = transmittance(depths[c]), share = (above - below) * mean;
            above = below;
#else
            float share = mean * step;
#endif
            part += share;
            lit += share * growth(along * (0.5 * (here + next) - middle) - aside);
            low = high;
            here = next;
            x = next_x;
            erf_x = next_erf;
        }
        group = texelFetch(knots, ivec3(place, min(j + 1, groups - 1)), 0);
        c = 0;
    }
    for (; low < tb;) { // a loop, because software rasterisers execute both sides of an if
        float high = end.y, to = tb, next_x = shape.z * (to - middle);
#ifdef AL_CHROMATIC
        float tau = texelFetch(knots, ivec3(place, 2 * groups - 1), 0).w;
#else
        float gone = step * float(count); // -log(1 - gone), without cancellation
        float tau = gone < 0.02 ? gone * (1.0 + gone * (0.5 + gone / 3.0)) : -log(max(1.0 - gone, 1e-30));
#endif
        float extinction = max(end.z - tau, 0.0) / max(high - low, 1e-30);
        float tau_from = tau + extinction * (here - low), tau_to = tau + extinction * (to - low);
#ifdef AL_CHROMATIC
        vec3 lost = exp(-ratio.rgb * tau_from) * vec3(al_one_minus_exp(ratio.r * (tau_to - tau_from)),
                                                      al_one_minus_exp(ratio.g * (tau_to - tau_from)),
                                                      al_one_minus_exp(ratio.b * (tau_to - tau_from)));
        Share share = vec4(lost, (lost.r + lost.g + lost.b) / ratio.w);
#else
        float share = exp(-tau_from) * al_one_minus_exp(tau_to - tau_from);
#endif
        share *= mean_gauss(x, next_x, erf_x, al_erf(next_x));
        part += share;
        lit += share * growth(along * (0.5 * (here + to) - middle) - aside);
        break;
    }
#ifdef AL_CHROMATIC
    sum = profile * vec4(light.rgb * lit.rgb, part.a);
#else
    sum = profile * vec4(light.rgb * lit, part);
#endif
#endif
}
