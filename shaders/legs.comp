#version 450 core
// The gridded media's extinction in one coarse grid: the mean of 3^3 places in each cell.
#extension GL_GOOGLE_include_directive : enable
#include "formulas.glsl"
#include "frame.glsl"
#include "legs.glsl"

layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(binding = 0, rgba32f) writeonly uniform image3D coarse;

void main()
{
    ivec3 cell = ivec3(gl_GlobalInvocationID);
    vec3 sum = vec3(0.0), size = legs_extent.xyz / vec3(imageSize(coarse));
    for (int i = 0; i < fog_counts.x; i++) {
        if (fogs[i].cells.x == 0) continue;
        for (int k = 0; k < 27; k++) {
            vec3 place = legs_low.xyz + (vec3(cell) + (vec3(k % 3, k / 3 % 3, k / 9) + 0.5) / 3.0) * size;
            vec3 inside = (place - fogs[i].low.xyz) / fogs[i].extent.xyz;
            if (all(greaterThanEqual(inside, vec3(0.0))) && all(lessThanEqual(inside, vec3(1.0))))
                sum += fogs[i].sigma_t.rgb * fog_density(i, place);
        }
    }
    imageStore(coarse, cell, vec4(sum / 27.0, 0.0));
}
