#version 450 core
// Whether the pixel's ray hits the surfel's disc; the depth test keeps the nearest.
//
// A surfel whose middle lies in the shell stands for 4^l surfels, so its disc has 2^l times the radius. Nearer ones,
// which a finer level takes, are tested too, as large as they are there: the same fragment, fewer gaps.
//
// AL_SURFACE: discs end where their triangle ends, at each of its edges over which it is at least a radius high; in a finer
// mesh they stand for the triangles around too. A disc that ends at all three edges pokes out nowhere: it gets four times the overlap
// of area, so that next to no ray passes between such discs. Others get no overlap: where discs poke out, being larger darkens more
// than gaps brighten. But those of parts of huge triangles poke out over what is flat, and in coarser levels, which are dealt few of
// a triangle's surfels, gaps let more pass: these get the overlap, and coarser ones end where the triangle is two radii high. Half a disc at an edge covers half as much, so its radius squared grows by
// 1 / (1/2 + d/2r) for each edge at a distance d < r.
//
// The rays begin on surfaces, which surfels stand for too: discs of the own one float a little above the
// origin where it is curved, and pass through it by rounding where it is flat. A disc that the origin lies on does not
// count: at most 0.3 of its radius above or below, 0.014 where it ends at all edges, inside its rim, and turned as the surface
// by 60 degrees at most. A disc that touches a sphere of radius R is R/2 (r/R)^2 off at its rim: 0.3 r up to r = 0.6 R.
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"
#include "bounce.glsl"

layout(binding = 2) uniform sampler2D rays; // direction, distance of the origin; 0: none
#ifdef AL_SURFACE
layout(binding = 3) uniform sampler2D geometry; // normal, distance
#endif

flat in vec4 disc;
flat in vec3 facing;
flat in vec4 shell;
flat in int number;
#ifdef AL_SURFACE
flat in vec4 edges[3]; // of the triangle: normal, distance in m
flat in vec4 heights;  // over them, m; w: 1 a part of a huge triangle
#endif
layout(location = 0) out uint hit; // number of the surfel, from 1

#ifdef AL_SURFACE
bool lies_on(ivec2 pixel, vec3 path, float radius2, bool whole)
{
    float height = dot(facing, path), across2 = dot(path, path) - height * height;
    vec3 normal = texelFetch(geometry, pixel, 0).xyz;
    return across2 <= radius2 && height * height <= (whole ? 0.0002 : 0.09) * radius2 && abs(dot(normal, facing)) > 0.5;
}

// Whether `off`, from the disc's middle, is behind an edge; otherwise its radius squared, and whether all edges end it.
bool passes_edge(vec3 off, float scale, inout float radius2, out bool whole)
{
    bool coarse = scale > 1.0, overlaps = coarse || heights.w > 0.0;
    if (!overlaps) radius2 /= bounce_reach.z;
    float radius = sqrt(radius2);
    bvec3 ends = greaterThanEqual(heights.xyz, vec3(coarse ? 2.0 * radius : radius));
    whole = all(ends);
    if (whole) {
        radius2 *= overlaps ? 4.0 : 4.0 * bounce_reach.z;
        radius = sqrt(radius2);
    }
    for (int i = 0; i < 3; i++) {
        if (!ends[i]) continue;
        if (dot(off, edges[i].xyz) > edges[i].w) return true;
        radius2 /= 0.5 + 0.5 * min(edges[i].w / radius, 1.0);
    }
    return false;
}
#endif

void main()
{
    ivec2 pixel = pixel_of_texel(ivec2(gl_FragCoord.xy), int(shell.w));
    if (any(greaterThanEqual(pixel, shell_size.zw))) discard;
    vec4 ray = texelFetch(rays, pixel, 0);
    if (ray.w == 0.0) discard;
    vec3 origin, direction;
    view_ray(view_pixel(vec2(pixel) + 0.5), origin, direction);
    vec3 path = disc.xyz - origin - ray.w * direction;
    float squared = dot(path, path), scale = shell.z;
    if (squared >= shell.y) discard;
    if (squared < shell.x) {
        if (bounce_sample.z != 0) discard;
        float shells = log2(squared) - 2.0 * log2(bounce_reach.x); // twice the number of the shell, less one
        scale = exp2(2.0 * ceil(max(0.5 * shells, 0.0)));
    }
    float away = dot(facing, path), slope = dot(facing, ray.xyz);
    float t = away / (slope != 0.0 ? slope : 1e-30);
    vec3 off = t * ray.xyz - path;
    float radius2 = disc.w * scale;
#ifdef AL_SURFACE
    bool whole;
    if (passes_edge(off, scale, radius2, whole) || lies_on(pixel, path, radius2, whole)) discard;
#endif
    if (!(t > 0.0) || !(dot(off, off) <= radius2)) discard;
    hit = uint(number);
    gl_FragDepth = min(t * t / (bounce_reach.y * bounce_reach.y), 1.0);
}
