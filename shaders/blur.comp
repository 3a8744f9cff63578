#version 450 core
// One mip of the levels from the one below, by the binomial kernel (1 3 3 1)/8 along both axes: a Gaussian pyramid.
// Only levels that the sum reads at this mip or above.
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 5) uniform sampler2DArray levels;
layout(binding = 0, rgba32f) writeonly uniform image2DArray above;
layout(location = 0) uniform int mip;   // the one below
layout(location = 1) uniform int first; // level

void main()
{
    ivec3 place = ivec3(gl_GlobalInvocationID) + ivec3(0, 0, first);
    if (any(greaterThanEqual(place, imageSize(above)))) return;
    const float weights[4] = float[](0.125, 0.375, 0.375, 0.125);
    ivec2 last = textureSize(levels, mip).xy - 1;
    vec4 sum = vec4(0.0);
    for (int y = 0; y < 4; y++)
        for (int x = 0; x < 4; x++) {
            ivec2 from = 2 * place.xy + ivec2(x, y) - 1;
            if (any(lessThan(from, ivec2(0))) || any(greaterThan(from, last))) continue;
            sum += weights[x] * weights[y] * texelFetch(levels, ivec3(from, place.z), mip);
        }
    imageStore(above, place, sum);
}
