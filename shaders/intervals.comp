#version 450 core
// The transmittance interval map of one translucent object (Nalbach et al. 2014, section 4.1): per pixel n
// distances t_k between which the transmittance to the eye falls in n - 1 equal steps.
//
// The first march finds where the medium starts and ends and its optical depth, the second places the knots
// inside the steps. Density is trilinear and zero outside the grid. The medium begins at the object's front
// surface, which the voxels blur over 1.5 of their edges to both sides: the first cell reaches 1.5 voxels
// behind the front and takes what lies before it too, so that no optical depth is lost (in a homogeneous
// medium its density comes out exact). Both marches stop at opaque surfaces, at blockers and where nothing is
// left to see.
//
// Layer j of the knots holds t of the knots 4j+1 to 4j+4 but for the last; unused places repeat the last but
// one. AL_CHROMATIC: as many layers again hold the optical depth of the largest channel there (in grey media
// it follows from the equal steps). Ends: t_0, t_last (equal: no medium), optical depth, 1 behind a blocker.
#extension GL_GOOGLE_include_directive : enable
#include "formulas.glsl"
#include "frame.glsl"
#include "box.glsl"
#include "object.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(location = 0) uniform ivec4 rectangle; // of the tile: x, y, width, height
layout(binding = 2) uniform sampler3D density;
layout(binding = 3) uniform sampler2D geometry; // of the opaque surfaces: w distance, 0 none
layout(binding = 4) uniform sampler2D boundary; // w distance, negative: back face, 0 none
layout(binding = 0, rgba32f) writeonly uniform image2DArray knots;
layout(binding = 1, rgba32f) writeonly uniform image2D ends;

// Where exp(-tau) is below 1e-17 of every channel, nothing is left.
const float nothing_left = 40.0;

// Uniform in [0, 1) from pixel and frame: the 32-bit mixer of Wellons's "lowbias32" search.
float jitter(ivec2 pixel)
{
    uint h = uint(pixel.x) * 0x9e3779b9u ^ uint(pixel.y) * 0x85ebca6bu ^ uint(sizes.w) * 0xc2b2ae35u;
    h = (h ^ (h >> 16)) * 0x7feb352du;
    h = (h ^ (h >> 15)) * 0x846ca68bu;
    h ^= h >> 16;
    return float(h >> 8) / 16777216.0;
}

struct March {
    vec3 origin, step; // grid coordinates in [0, 1]
    float first, size; // t of the first cell's start, its length in m
};

vec2 texel_at(March m, float t)
{
    return textureLod(density, m.origin + m.step * t, 0.0).rg;
}

void store(ivec2 place, int layer, vec4 group, vec4 depths)
{
    imageStore(knots, ivec3(place, layer), group);
#ifdef AL_CHROMATIC
    imageStore(knots, ivec3(place, layer + (sizes.y + 1) / 4), depths);
#endif
}

// The optical depth at which the depletion is `wanted`, from `tau` below it: Newton's method approaches the
// root of a concave increasing function from the left without leaving it.
float depth_of(float wanted, float tau)
{
    for (int i = 0; i < 8; i++) {
        vec3 slope = ratio.rgb * exp(-ratio.rgb * tau);
        float missing = wanted - reference_depletion(tau);
        if (!(missing > 1e-7 * wanted)) break;
        tau += missing * ratio.w / max(slope.r + slope.g + slope.b, 1e-30);
    }
    return tau;
}

void main()
{
    if (any(greaterThanEqual(ivec2(gl_GlobalInvocationID.xy), rectangle.zw))) return;
    ivec2 place = rectangle.xy + ivec2(gl_GlobalInvocationID.xy);
    imageStore(ends, place, vec4(0.0));
    float entry, leave, front = texelFetch(boundary, place, 0).w, opaque = texelFetch(geometry, place, 0).w;
    if (ratio.w == 0.0 || (toggles.x != 0 && front == 0.0)) return;

    vec3 origin, direction;
    object_ray(view_pixel(vec2(place) + 0.5), origin, direction);
    box_span(origin, direction, box_min.xyz, box_size.xyz, 0.5 * box_min.w, entry, leave);
    entry = max(entry, 0.0);
    if (opaque > 0.0) leave = min(leave, opaque);
    float start = toggles.x != 0 ? max(front, 0.0) : 0.0;
    if (!(entry < leave) || start >= leave) return;

    March m;
    m.origin = (origin - box_min.xyz) / box_size.xyz;
    m.step = direction / box_size.xyz;
    m.size = march.y;
    m.first = entry - jitter(place + tile.xy) * m.size;
    vec3 present = mix(vec3(1.0), ratio.rgb, greaterThan(ratio.rgb, vec3(0.0)));
    float limit = nothing_left / min(min(present.r, present.g), present.b);

    int count = int(ceil((leave - m.first) / m.size)), from = -1, to = 0;
    float tau = 0.0, blocked = 0.0, share = 0.0;
    for (int i = 0; i < count && tau < limit; i++) {
        float a = max(m.first + float(i) * m.size, entry), b = min(m.first + float(i + 1) * m.size, leave);
        vec2 texel = texel_at(m, 0.5 * (a + b));
        if (box_size.w > 0.0 && texel.g > 0.5) {
            // Half-way between the last two samples' shares lies the blocker's surface.
            float middle = 0.5 * (a + b);
            float past = clamp((texel.g - 0.5) / max(texel.g - share, 1e-6), 0.0, 1.0);
            leave = max(middle - m.size * past, entry);
            blocked = 1.0;
            if (leave > a) tau += texel.r * march.x * (leave - a);
            to = i + 1;
            break;
        }
        share = texel.g;
        if (texel.r > 0.0) {
            from = from < 0 ? i : from;
            to = i + 1;
            tau += texel.r * march.x * (b - a);
        }
    }
    if (from < 0 || !(tau > 0.0)) {
        if (blocked > 0.0) imageStore(ends, place, vec4(0.0, 0.0, 0.0, 1.0));
        return;
    }
    float t_end = min(m.first + float(to) * m.size, leave);
    float t_start = max(max(m.first + float(from) * m.size, entry), start);
    if (!(t_start < t_end)) { // all of it lies in the blur before the front
        t_start = start;
        t_end = start + 1e-3 * m.size;
    }

    int last = sizes.y - 1, k = 1;
    float total = reference_depletion(tau), before = 0.0, after = 0.0, knot_tau = 0.0, cell = t_start;
    vec4 group = vec4(t_start), depths = vec4(0.0);
    float joined = start > entry ? start + 1.5 * box_min.w : 0.0;
    for (int i = from; i < to && k < last; i++) {
        float a = max(m.first + float(i) * m.size, entry), b = min(m.first + float(i + 1) * m.size, leave);
        after += texel_at(m, 0.5 * (a + b)).r * march.x * max(b - a, 0.0);
        if (b < joined && i + 1 < to) continue;
        float gone = reference_depletion(after);
        for (; k < last && gone >= total * float(k) / float(last); k++) {
            knot_tau = depth_of(total * float(k) / float(last), max(before, knot_tau));
            float inside = clamp((knot_tau - before) / max(after - before, 1e-30), 0.0, 1.0);
            group[(k - 1) & 3] = clamp(mix(cell, b, inside), t_start, t_end);
            depths[(k - 1) & 3] = knot_tau;
            if ((k & 3) == 0) store(place, k / 4 - 1, group, depths);
        }
        before = after;
        cell = max(b, t_start);
    }
    for (; k <= (last + 2) / 4 * 4; k++) { // rounding left some unplaced, or the last layer is not full
        group[(k - 1) & 3] = k < last ? t_end : group[(k - 2) & 3];
        depths[(k - 1) & 3] = k < last ? tau : depths[(k - 2) & 3];
        if ((k & 3) == 0) store(place, k / 4 - 1, group, depths);
    }
    imageStore(ends, place, vec4(t_start, t_end, tau, blocked));
}
