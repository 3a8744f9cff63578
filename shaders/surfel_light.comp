#version 450 core
// What surfels send out on both sides: Lambert's light, L = albedo / pi E, of every lamp that reaches the side, less what
// casters and fog take on its way, and emission (from the front only unless double-sided). Albedo and emission
// stand where their light goes.
#extension GL_GOOGLE_include_directive : enable
#define AL_SURFELS_WRITE
#include "formulas.glsl"
#include "shadows.glsl"
#ifdef AL_FOG
#include "fogs.glsl"
#endif
#include "surfels.glsl"

layout(local_size_x = 128) in;
layout(location = 0) uniform int shadows;

// W/m2 of light `index` on the surfel's plane, from the side it is on: that of `normal` or, `behind`, the other.
vec3 irradiance(int index, vec3 position, vec3 normal, out bool behind)
{
    vec3 direction;
    float reach;
    vec3 arriving = light_arrival(index, position, 0.0, direction, reach);
    float cosine = dot(normal, direction);
    behind = cosine < 0.0;
    arriving *= abs(cosine);
#ifdef AL_FOG
    // First: behind the two below, llvmpipe of Mesa 22.3 samples for one invocation of eight alone.
    arriving *= fog_transmittance(position, direction, reach, 64.0);
#endif
    if (shadows != 0 && arriving != vec3(0.0)) {
        arriving *= opaque_visibility(index, position, behind ? -normal : normal);
        arriving *= translucent_visibility(position, direction, reach, -1);
    }
    return arriving;
}

void main()
{
    uint i = gl_GlobalInvocationID.x;
    if (i >= surfel_count) return;
    vec3 position = surfels[i].place.xyz, normal = surfels[i].facing.xyz, albedo = surfels[i].front.rgb;
    vec4 glow = surfels[i].back;
    vec3 front = vec3(0.0), back = vec3(0.0);
    for (int k = 0; k < counts.x; k++) {
        bool behind;
        vec3 arrived = irradiance(k, position, normal, behind);
        if (behind)
            back += arrived;
        else
            front += arrived;
    }
    surfels[i].front.rgb = front * albedo / AL_PI + glow.rgb;
    surfels[i].back = vec4(back * albedo / AL_PI + glow.rgb * glow.w, pack_color(albedo));
}
