#version 450 core
// The shells of one surfel, one per level: a quad over the part of one sub-buffer that its outer sphere can reach.
//
// A surfel draws into one of the 4^l sub-buffers of level l, so that 4^l times its light is right on average.
//
// With exitant radiance B and area A a surfel's irradiance at distance d is at most A B/d^2, and what it adds to a
// pixel at most A B p_max/d^2, the weights of a ray's samples summing to at most one. It falls below epsilon at
//   d_max = sqrt(A B p_max / epsilon),
// and with 4^l times the area at d_max 2^l, the outer radius of level l. Where the outermost shell is open, so that a
// smaller d_max makes nothing but noise, it is held to eight of the surfel's radii: lights too bright for the
// exposure would have everything drawn over the whole view.
#extension GL_GOOGLE_include_directive : enable
#include "frame.glsl"
#include "splat_quad.glsl"
#include "surfels.glsl"

layout(points, invocations = AL_LEVELS) in;
layout(triangle_strip, max_vertices = 4) out;

flat in int surfel[];
flat out vec4 place;  // xyz: m; w: area in m2
flat out vec3 facing; // unit normal
flat out vec3 front, back; // exitant radiance
flat out vec4 shell;  // inner and outer radius squared; 4^l; l

void main()
{
    Surfel s = surfels[surfel[0]];
    int level = gl_InvocationID;
    vec3 most = max(s.front.rgb, s.back.rgb);
    float brightest = max(max(most.r, most.g), most.b);
    if (!(brightest > 0.0)) return;
    float reach = shell_reach.y > 0.0 ? shell_reach.y
                                      : sqrt(s.place.w * brightest * shell_reach.z / shell_reach.x);
    if (shell_reach.y <= 0.0 && shell_reach.w > 0.0) reach = min(reach, 8.0 * sqrt(s.place.w / 3.14159265));
    vec2 radii = shell_radii(reach, level);
    vec4 bounds;
    if (!splat_bounds(s.place.xyz, radii.y, level, surfel[0], bounds)) return;
    for (int i = 0; i < 4; i++) {
        place = s.place;
        facing = s.facing.xyz;
        front = s.front.rgb;
        back = s.back.rgb;
        shell = vec4(radii * radii, float(1 << 2 * level), float(level));
        gl_Layer = level;
        gl_Position = vec4((i & 1) == 0 ? bounds.x : bounds.z, (i & 2) == 0 ? bounds.y : bounds.w, 0.0, 1.0);
        EmitVertex();
    }
    EndPrimitive();
}
