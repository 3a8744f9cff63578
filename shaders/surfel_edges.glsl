// Where a surfel's triangle ends, so that its disc need not poke out over it: of each edge the angle of its outward normal
// in the triangle's plane, in the axes across the surfel's normal, its distance to the surfel and the triangle's height over
// it, both beside the root of the surfel's area A. Four words: angle (16 bits) and distance (half) of each edge; the
// heights' binary logarithms in eighths, 8 bits each, and whether it is a part of a huge triangle, whose surfels go on beyond.
#ifndef AL_SURFEL_EDGES_GLSL
#define AL_SURFEL_EDGES_GLSL

#include "turned.glsl"

struct Edges {
    vec3 normals[3];
    vec3 distances, heights; // m
    bool part;
};

uvec4 pack_edges(vec3 corners[3], bool part, vec3 place, vec3 facing, float area)
{
    vec3 x, y;
    uvec4 packed_edges = uvec4(0u, 0u, 0u, part ? 1u << 24 : 0u);
    axes_across(facing, x, y);
    for (int e = 0; e < 3; e++) {
        vec3 a = corners[e], along = corners[(e + 1) % 3] - a, n = cross(along, facing);
        n /= max(length(n), 1e-37);
        float height = dot(a - corners[(e + 2) % 3], n);
        if (height < 0.0) n = -n;
        uint angle = uint(fract(atan(dot(n, y), dot(n, x)) / (2.0 * AL_PI)) * 65536.0) & 0xffffu;
        float apart = clamp(dot(a - place, n) * inversesqrt(area), 0.0, 6e4);
        packed_edges[e] = angle << 16 | packHalf2x16(vec2(apart, 0.0));
        float logarithm = log2(max(abs(height) * inversesqrt(area), 1e-30));
        packed_edges.w |= uint(clamp(8.0 * logarithm + 64.0, 0.0, 255.0)) << uint(8 * e);
    }
    return packed_edges;
}

Edges unpack_edges(uvec4 packed_edges, vec3 facing, float area)
{
    vec3 x, y;
    Edges edges;
    edges.part = packed_edges.w >> 24 != 0u;
    axes_across(facing, x, y);
    for (int e = 0; e < 3; e++) {
        float angle = (float(packed_edges[e] >> 16) + 0.5) * (2.0 * AL_PI / 65536.0);
        edges.normals[e] = cos(angle) * x + sin(angle) * y;
        edges.distances[e] = unpackHalf2x16(packed_edges[e]).x * sqrt(area);
        edges.heights[e] = exp2((float(packed_edges.w >> uint(8 * e) & 255u) - 64.0) / 8.0) * sqrt(area);
    }
    return edges;
}

#endif
