#version 450 core
// The shell of one surfel in a level of the bounced z-buffer: as shell.geom's, but of one radius for all surfels, as dark
// ones block too.
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"
#include "splat_quad.glsl"
#include "bounce.glsl"
#include "surfels.glsl"
#ifdef AL_SURFACE
#include "surfel_edges.glsl"
#endif

layout(points) in;
layout(triangle_strip, max_vertices = 4) out;

layout(location = 0) uniform int level;

flat in int surfel[];
flat out vec4 disc;   // xyz: middle; w: radius squared at level 0, enlarged
flat out vec3 facing; // unit normal
flat out vec4 shell;  // inner and outer radius squared; 4^l; l
flat out int number;
#ifdef AL_SURFACE
flat out vec4 edges[3]; // of the triangle: normal, distance in m
flat out vec4 heights; // over them, m; w: 1 a part of a huge triangle
#endif

void main()
{
    Surfel s = surfels[surfel[0]];
    vec2 radii = shell_radii(bounce_reach.x, level);
    float widest = sqrt(s.place.w / 3.14159265 * bounce_reach.z) * float(1 << level);
#ifdef AL_SURFACE
    widest *= 6.0; // of those that end at all edges, beside them
    Edges e = unpack_edges(s.edges, s.facing.xyz, s.place.w);
#endif
    radii.y = min(radii.y, bounce_reach.w + widest); // a disc farther away is hit farther away
    vec4 bounds;
    if (!(radii.x < radii.y) || !splat_bounds(s.place.xyz, radii.y, level, surfel[0], bounds)) return;
    for (int i = 0; i < 4; i++) {
        disc = vec4(s.place.xyz, s.place.w / 3.14159265 * bounce_reach.z);
        facing = s.facing.xyz;
        shell = vec4(radii * radii, float(1 << 2 * level), float(level));
        number = surfel[0] + 1;
#ifdef AL_SURFACE
        for (int k = 0; k < 3; k++) edges[k] = vec4(e.normals[k], e.distances[k]);
        heights = vec4(e.heights, e.part ? 1.0 : 0.0);
#endif
        gl_Position = vec4((i & 1) == 0 ? bounds.x : bounds.z, (i & 2) == 0 ? bounds.y : bounds.w, 0.0, 1.0);
        EmitVertex();
    }
    EndPrimitive();
}
