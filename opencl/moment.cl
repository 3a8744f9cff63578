/* Step 3: first moment. T(x) = integral of psi(x, w) w dw, as the sum over direction pairs of
 * (psi(w) - psi(-w)) w = (A(-w) - A(w)) w, A = 1 - psi; the weight 4 pi / n is applied once by the host. */
#include "sweep.cl"

/* A field's difference at eight voxels from the four rays around each: voxel u lies between the rays stored
 * at columns u - 1 and u, at distances 1 - fraction and fraction. */
static inline float8 al_difference(global const float *forward, global const float *backward, int4 shape,
                                   float2 fraction)
{
    float8 here = vload8(0, backward) - vload8(0, forward);
    float8 left = vload8(0, backward - 1) - vload8(0, forward - 1);
    float8 below = vload8(0, backward - shape.w) - vload8(0, forward - shape.w);
    float8 corner = vload8(0, backward - shape.w - 1) - vload8(0, forward - shape.w - 1);
    return mix(mix(here, left, fraction.x), mix(below, corner, fraction.x), fraction.y);
}

/* Global size: (blocks of 8 voxels along u, rows, slices). moment: three planes [3][na][nv + 2][width], the
 * components along world x, y, z; the terms of the batch are added in order, so that the sum does not depend
 * on the size of the batch. directions: [pair] world w. */
kernel void moment(global const float *forward, global const float *backward, int4 shape,
                   global const float2 *fractions, global const float4 *directions, int pair_count,
                   ulong field_stride, global float *moment)
{
    int u = (int)get_global_id(0) * 8, v = get_global_id(1), a = get_global_id(2);
    size_t at = al_at(shape, u, v, a);
    float8 x = vload8(0, moment + at);
    float8 y = vload8(0, moment + field_stride + at);
    float8 z = vload8(0, moment + 2 * field_stride + at);
    for (int pair = 0; pair < pair_count; pair++) {
        size_t here = pair * field_stride + at;
        float8 difference = al_difference(forward + here, backward + here, shape, fractions[pair * shape.z + a]);
        x += difference * directions[pair].x;
        y += difference * directions[pair].y;
        z += difference * directions[pair].z;
    }
    vstore8(x, 0, moment + at);
    vstore8(y, 0, moment + field_stride + at);
    vstore8(z, 0, moment + 2 * field_stride + at);
}
