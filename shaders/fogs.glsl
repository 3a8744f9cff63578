// Media that fill the air: density at a place, optical depth along a ray. Mirrored by al_fog_block in
// runtime/state.h (std140). A constant medium is a box (or endless) whose optical depth is a length; a gridded
// one is marched through its bricks of 9^3 densities, one atlas for all fogs.
#ifndef AL_FOGS_GLSL
#define AL_FOGS_GLSL

#include "formulas.glsl"
#include "box.glsl"

#define AL_FOG_LIMIT 8

struct Fog {
    mat4 to_index; // from world to the grid's index space, voxel centres at whole numbers
    vec4 low;      // xyz: lower bounds in m; w: 1 bounded
    vec4 extent;   // xyz: edges of the bounds in m; w: 1 when the outermost densities hold up to the bounds
    vec4 sigma_t;  // rgb: per metre where fog_density is 1; w: Henyey-Greenstein g
    vec4 sigma_s;  // rgb: likewise; w: the largest fog_density
    ivec4 size;    // voxels along the axes; w: first cell in fog_cells
    ivec4 cells;   // bricks along the axes, 0 for a constant density
    vec4 march;    // x: step in m; yzw unused
    ivec4 sky_size;  // xyz: points along the axes; w: bands of SH, 0 without light of the sky
    ivec4 sky_place; // x: first slice in sky_light, y: in sky_planes, negative: no walls; zw unused
    vec4 sky_grade;  // xyz: of the planes of points; w: W/(m2 sr) where a number reads 1
};

layout(std140, binding = 2) uniform Fogs {
    ivec4 fog_counts; // fogs; cells along a ray and light; frame number; 1 when lights cast shadows
    ivec4 fog_atlas;  // xy: bricks along x and y of the atlas; z: 1 with light of the sky; w: of sky_light, texels
                      // along x from number to number
    vec4 fog_texel;   // xyz: edge of an atlas texel in texture coordinates
    Fog fogs[AL_FOG_LIMIT];
};
layout(std430, binding = 5) readonly buffer FogCells { uint fog_cells[]; }; // numbers of bricks in the atlas
layout(binding = 7) uniform sampler3D fog_bricks;

// Density of gridded fog i, relative to its unit (sigma_t holds the rest).
float fog_density(int i, vec3 position)
{
    vec3 last = vec3(fogs[i].size.xyz - 1);
    vec3 index = (fogs[i].to_index * vec4(position, 1.0)).xyz;
    if (fogs[i].extent.w == 0.0 &&
        (any(lessThan(index, vec3(-0.5))) || any(greaterThan(index, last + 0.5))))
        return 0.0;
    index = clamp(index, vec3(0.0), last);
    ivec3 cells = fogs[i].cells.xyz, cell = min(ivec3(index) / 8, cells - 1);
    uint brick = fog_cells[fogs[i].size.w + (cell.z * cells.y + cell.y) * cells.x + cell.x];
    if (brick == 0xffffffffu) return 0.0;
    uvec2 edge = uvec2(fog_atlas.xy);
    uvec3 at = uvec3(brick % edge.x, brick / edge.x % edge.y, brick / (edge.x * edge.y));
    return textureLod(fog_bricks, (vec3(at * 9u) + index - vec3(8 * cell) + 0.5) * fog_texel.xyz, 0.0).r;
}

// The part of [from, to] that lies in the bounds of fog i; entry >= leave when there is none.
void fog_span(int i, vec3 origin, vec3 direction, float from, float to, out float entry, out float leave)
{
    entry = from;
    leave = to;
    if (fogs[i].low.w == 0.0) return;
    box_span(origin, direction, fogs[i].low.xyz, fogs[i].extent.xyz, 0.0, entry, leave);
    entry = max(entry, from);
    leave = min(leave, to);
}

// The integral of the density of fog i over [from, to], in m, by the midpoint rule in steps of fogs[i].march.x,
// at most `most` of them; a constant density's is exact.
float fog_depth(int i, vec3 origin, vec3 direction, float from, float to, float most)
{
    float entry, leave, sum = 0.0;
    fog_span(i, origin, direction, from, to, entry, leave);
    if (!(entry < leave)) return 0.0;
    if (fogs[i].cells.x == 0) return leave - entry;
    int count = int(clamp((leave - entry) / fogs[i].march.x + 0.5, 1.0, most));
    float step = (leave - entry) / float(count);
    for (int k = 0; k < count; k++)
        sum += fog_density(i, origin + direction * (entry + (float(k) + 0.5) * step));
    return sum * step;
}

// What the fogs leave of light on the way from `origin` over `reach`.
vec3 fog_transmittance(vec3 origin, vec3 direction, float reach, float most)
{
    vec3 tau = vec3(0.0);
    for (int i = 0; i < fog_counts.x; i++)
        tau += fogs[i].sigma_t.rgb * fog_depth(i, origin, direction, 0.0, reach, most);
    return exp(-min(tau, vec3(1e4)));
}

const float nothing_left = 20.0; // exp(-20) = 2e-9

// Where on [entry, leave] nothing is left in the clearest channel of fog i alone: closed for a constant density,
// marched for a grid that is dense enough to matter.
float fog_end(int i, vec3 origin, vec3 direction, float entry, float leave)
{
    vec3 sigma = fogs[i].sigma_t.rgb;
    float least = max(min(min(sigma.r, sigma.g), sigma.b), 1e-30);
    if (fogs[i].cells.x == 0) return min(leave, entry + nothing_left / least);
    if (least * fogs[i].sigma_s.w * (leave - entry) < nothing_left) return leave;
    int count = int(clamp((leave - entry) / fogs[i].march.x + 0.5, 1.0, 512.0));
    float step = (leave - entry) / float(count), depth = 0.0;
    for (int k = 0; k < count; k++) {
        float here = fog_density(i, origin + direction * (entry + (float(k) + 0.5) * step)) * least;
        if (depth + here * step >= nothing_left)
            return entry + float(k) * step + (nothing_left - depth) / max(here, 1e-30);
        depth += here * step;
    }
    return leave;
}

// The cells' range: from the first fog on to where all end or nothing is left. False: no fog.
bool fog_range(vec3 origin, vec3 direction, float to, out float from, out float end)
{
    float last = 0.0;
    from = to;
    end = to;
    for (int i = 0; i < fog_counts.x; i++) {
        float entry, leave;
        fog_span(i, origin, direction, 0.0, to, entry, leave);
        if (!(entry < leave)) continue;
        from = min(from, entry);
        float stop = fog_end(i, origin, direction, entry, leave);
        if (stop < leave) end = min(end, stop);
        last = max(last, leave);
    }
    end = min(end, last);
    return from < end;
}

#endif
