#version 450 core
// The gridded media's extinction in one coarse grid: per cell what takes as much light over the cell's width w as 3^3
// places do in the mean,
//   sigma = -log(mean of exp(-sigma_i w)) / w,
// which is the mean of sigma_i where they take little. A dense voxel that fills a part of a cell hides that part: the mean
// would make the whole cell, and half of those beside it, opaque.
#extension GL_GOOGLE_include_directive : enable
#include "formulas.glsl"
#include "frame.glsl"
#include "legs.glsl"

layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(binding = 0, rgba32f) writeonly uniform image3D coarse;

vec3 extinction_at(vec3 place)
{
    vec3 sum = vec3(0.0);
    for (int i = 0; i < fog_counts.x; i++) {
        if (fogs[i].cells.x == 0) continue;
        vec3 inside = (place - fogs[i].low.xyz) / fogs[i].extent.xyz;
        if (all(greaterThanEqual(inside, vec3(0.0))) && all(lessThanEqual(inside, vec3(1.0))))
            sum += fogs[i].sigma_t.rgb * fog_density(i, place);
    }
    return sum;
}

// -log(1 - taken), without cancellation.
float depth_that_takes(float taken)
{
    return taken < 1e-2 ? taken * (1.0 + taken * (0.5 + taken / 3.0)) : -log(1.0 - taken);
}

void main()
{
    ivec3 cell = ivec3(gl_GlobalInvocationID);
    vec3 size = legs_extent.xyz / vec3(imageSize(coarse)), at[27], least = vec3(1e30), taken = vec3(0.0);
    float width = (size.x + size.y + size.z) / 3.0;
    for (int k = 0; k < 27; k++) {
        at[k] = extinction_at(legs_low.xyz + (vec3(cell) + (vec3(k % 3, k / 3 % 3, k / 9) + 0.5) / 3.0) * size);
        least = min(least, at[k]);
    }
    for (int k = 0; k < 27; k++) // beyond the least one, so that thick cells do not round to nothing
        for (int c = 0; c < 3; c++) taken[c] += al_one_minus_exp((at[k][c] - least[c]) * width) / 27.0;
    for (int c = 0; c < 3; c++) least[c] += depth_that_takes(min(taken[c], 26.5 / 27.0)) / width;
    imageStore(coarse, cell, vec4(least, 0.0));
}
