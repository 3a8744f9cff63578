#version 450 core
// The view's transmittance interval map (Nalbach et al. 2014, section 4.1): on every pixel's ray up to the nearest
// surface, m distances in equal steps of depletion, one minus the transmittance T to the eye.
//
// With D the depletion of the whole ray, sample k of m lies where D(t) = (k - xi)/m D, xi in [0, 1) drawn per
// pixel: a stratified draw of t with density T sigma_t / D. So the integral of sigma_s T f dt is the mean over
// the samples of D sigma_s/sigma_t f: where the albedo is the same everywhere, a constant, and neither coefficients
// nor lengths need be stored. (The paper stores coefficients and multiplies by lengths: AL_COEFFICIENTS.)
// Chromatic media: depletion is the mean of the channels', and sample k weighs
//   D sigma_s T / mean(sigma_t T) per channel (AL_WEIGHTS), at most 3 D.
//
// The first march sums the optical depth, the second places the samples; inside a cell the density is constant.
// A byte holds the root of each sample's distance from the one before, over that of the largest, L: nothing can
// overflow, and as the rounded sum is carried on, no sample is off by more than half of what its byte's neighbours are
// apart, root(s L)/255 at a distance of s. A channel that is gone soon in a fog that is clear to another has its samples
// close together before wide gaps: bytes in proportion to distance would round them by many of its mean free paths.
#extension GL_GOOGLE_include_directive : enable
#include "formulas.glsl"
#include "frame.glsl"
#include "fogs.glsl"
#include "shells.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(location = 0) uniform float cell_m; // wanted length of a cell, 0: one cell holds all
layout(binding = 2) uniform sampler2D geometry; // of the opaque surfaces: w distance, 0 none
layout(binding = 0, rgba32ui) writeonly uniform uimage2DArray steps;
layout(binding = 1, rgba32f) writeonly uniform image2D ends;
#if defined(AL_WEIGHTS)
layout(binding = 2, rgba8) writeonly uniform image2DArray weights;
#elif defined(AL_COEFFICIENTS)
layout(binding = 2, rgba32ui) writeonly uniform uimage2DArray coefficients;
#endif

const int most_samples = 32;

struct Cell {
    float start, size;
    vec3 depth, source; // optical, of extinction and of scattering
};

Cell cell_at(vec3 origin, vec3 direction, float a, float b)
{
    Cell c = Cell(a, b - a, vec3(0.0), vec3(0.0));
    for (int i = 0; i < fog_counts.x; i++) {
        float share = fog_depth(i, origin, direction, a, b, 8.0);
        c.depth += fogs[i].sigma_t.rgb * share;
        c.source += fogs[i].sigma_s.rgb * share;
    }
    return c;
}

float depletion(vec3 tau)
{
    return (al_one_minus_exp(tau.r) + al_one_minus_exp(tau.g) + al_one_minus_exp(tau.b)) / 3.0;
}

// The share of the cell after which the depletion is `wanted`. Newton's method approaches the root of a concave
// increasing function from the left without leaving it; it starts where the first channel alone has got there.
float share_of(float wanted, vec3 tau, vec3 depth, float from)
{
    float alone = wanted < 1e-3 ? wanted * (1.0 + 0.5 * wanted) : -log(max(1.0 - wanted, 1e-9));
    vec3 left = (vec3(alone) - tau) / max(depth, vec3(1e-30));
    float f = clamp(min(min(left.r, left.g), left.b) * 0.999, from, 1.0);
    for (int i = 0; i < 64; i++) { // about one for each optical depth of a channel that is gone before the others begin
        vec3 slope = depth * exp(-(tau + f * depth));
        float missing = wanted - depletion(tau + f * depth);
        if (!(missing > 1e-7 * wanted)) break;
        f += 3.0 * missing / max(slope.r + slope.g + slope.b, 1e-30);
    }
    return clamp(f, from, 1.0);
}

#if defined(AL_WEIGHTS)
// One of several media is drawn by its share of what the cell scatters, and stands for all of them: each has a phase
// function of its own. What it stands for is at most what the cell takes, so that a weight is at most 3.
void store_weight(ivec2 place, int k, vec3 origin, vec3 direction, Cell c, vec3 tau, uint bits)
{
    vec3 left = exp(-(tau - min(min(tau.r, tau.g), tau.b))), source = c.source;
    float all = dot(source, left), share = all * unit_float(mix_bits(bits));
    int drawn = 0;
    for (int i = 0; i < fog_counts.x && fog_counts.x > 1 && share >= 0.0; i++) {
        vec3 own = fogs[i].sigma_s.rgb * fog_depth(i, origin, direction, c.start, c.start + c.size, 8.0);
        float part = dot(own, left);
        if (!(part > 0.0)) continue;
        drawn = i;
        source = own * (all / part);
        share -= part;
    }
    vec3 weight = source * left / max(dot(c.depth * left, vec3(1.0)), 1e-30);
    vec3 dither = (vec3(bits & 255u, bits >> 8 & 255u, bits >> 16 & 255u) - 127.5) / 256.0 / 255.0;
    imageStore(weights, ivec3(place, k), vec4(weight + dither, float(drawn) / 255.0));
}
#endif

void store_bytes(ivec2 place, int count, float distances[most_samples], float start, inout vec4 end)
{
    float largest = 0.0, before = start;
    for (int k = 0; k < count; k++) {
        largest = max(largest, distances[k] - before);
        before = distances[k];
    }
    end.y = max(largest / 65025.0, 1e-30);
    float sum = 0.0; // whole, below 2^21
    for (int layer = 0; 16 * layer < count; layer++) {
        uvec4 words = uvec4(0u);
        for (int j = 0; j < 16 && 16 * layer + j < count; j++) {
            float wanted = (distances[16 * layer + j] - start) / end.y - sum;
            float root = min(floor(sqrt(max(wanted - 0.25, 0.0)) + 0.5), 255.0); // (b + 1/2)^2 is 1/4 above the middle
            words[j >> 2] |= uint(root) << uint(8 * (j & 3));
            sum += root * root;
        }
        imageStore(steps, ivec3(place, layer), words);
    }
}

#if defined(AL_COEFFICIENTS)
void store_coefficients(ivec2 place, int count, float values[most_samples], inout vec4 end)
{
    for (int k = 0; k < count; k++) end.w = max(end.w, values[k]);
    for (int layer = 0; 16 * layer < count; layer++) {
        uvec4 words = uvec4(0u);
        for (int j = 0; j < 16 && 16 * layer + j < count; j++)
            words[j >> 2] |= uint(values[16 * layer + j] / max(end.w, 1e-30) * 255.0 + 0.5) << uint(8 * (j & 3));
        imageStore(coefficients, ivec3(place, layer), words);
    }
}
#endif

void main()
{
    ivec2 place = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(place, shell_size.zw))) return;
    imageStore(ends, place, vec4(0.0));
    vec3 origin, direction, tau = vec3(0.0);
    view_ray(view_pixel(vec2(place) + 0.5), origin, direction);
    float to = texelFetch(geometry, place, 0).w, from, end;
    if (!fog_range(origin, direction, to == 0.0 ? 1e30 : to, from, end)) return;

    uvec2 pixel = uvec2(place + tile.xy);
    float xi = shell_blur.w != 0 ? 0.0 : unit_float(hash(pixel.x, pixel.y, uint(shell_counts.z)));
    float jitter = shell_blur.w != 0 ? 0.0 : unit_float(hash(pixel.x, pixel.y, ~uint(shell_counts.z)));
    int cells = cell_m == 0.0 ? 1 : int(clamp(ceil((end - from) / cell_m), 1.0, 512.0));
    float size = (end - from) / float(cells), first = cells == 1 ? from : from - jitter * size;
    if (first < from) cells++;

    int begin = -1;
    for (int i = 0; i < cells; i++) {
        Cell c = cell_at(origin, direction, max(first + float(i) * size, from), min(first + float(i + 1) * size, end));
        if (begin < 0 && c.depth != vec3(0.0)) begin = i;
        tau += c.depth;
    }
    float total = depletion(tau);
    if (begin < 0 || !(total > 0.0)) return;

    int count = shell_counts.y, k = 0;
    float start = max(first + float(begin) * size, from), distances[most_samples];
#if defined(AL_COEFFICIENTS)
    float values[most_samples];
#endif
    tau = vec3(0.0);
    for (int i = begin; i < cells && k < count; i++) {
        float a = max(first + float(i) * size, from), b = min(first + float(i + 1) * size, end), share = 0.0;
        Cell c = cell_at(origin, direction, a, b);
        bool last = i + 1 == cells;
        for (; k < count; k++) {
            float wanted = (float(k + 1) - xi) * total / float(count);
            if (!last && depletion(tau + c.depth) < wanted) break;
            share = share_of(wanted, tau, c.depth, share);
            distances[k] = a + share * c.size;
#if defined(AL_WEIGHTS)
            store_weight(place, k, origin, direction, c, tau + share * c.depth, hash(pixel.x, pixel.y, uint(k) << 16 ^ uint(shell_counts.z)));
#elif defined(AL_COEFFICIENTS)
            values[k] = dot(c.source, vec3(1.0 / 3.0)) / max(c.size, 1e-30);
#endif
        }
        tau += c.depth;
    }
    vec4 ends_here = vec4(start, 0.0, total, 0.0);
    store_bytes(place, count, distances, start, ends_here);
#if defined(AL_COEFFICIENTS)
    store_coefficients(place, count, values, ends_here);
#endif
    imageStore(ends, place, ends_here);
}
