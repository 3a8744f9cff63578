/* Step 3: first moment. T(x) = integral of psi(x, w) w dw, as the sum over direction pairs of
 * (psi(w) - psi(-w)) w = (A(-w) - A(w)) w, A = 1 - psi; the weight 4 pi / n is applied once by the host. */
#include "sweep.cl"

/* A field's difference at eight voxels from the four rays around each: voxel u lies between the rays stored
 * at columns u - 1 and u, at distances 1 - fraction and fraction. */
static inline float8 al_difference(global const float *forward, global const float *backward, size_t row,
                                   float2 fraction)
{
    float8 here = vload8(0, backward) - vload8(0, forward);
    float8 left = vload8(0, backward - 1) - vload8(0, forward - 1);
    float8 below = vload8(0, backward - row) - vload8(0, forward - row);
    float8 corner = vload8(0, backward - row - 1) - vload8(0, forward - row - 1);
    return mix(mix(here, left, fraction.x), mix(below, corner, fraction.x), fraction.y);
}

#define BLOCKS 4

/* Global size: (groups of 8 * BLOCKS voxels along u, slices, rows). moment: three planes
 * [3][nv + 2][na][width], the components along world x, y, z; the terms of the batch are added in order, so
 * that the sum does not depend on the size of the batch. directions: [pair] world w. */
kernel void moment(global const float *forward, global const float *backward, int4 shape,
                   global const float2 *fractions, global const float4 *directions, int pair_count,
                   ulong field_stride, global float *moment)
{
    int u = (int)get_global_id(0) * 8 * BLOCKS, a = get_global_id(1), v = get_global_id(2);
    size_t at = al_at(shape, u, v, a), row = al_row(shape);
    float8 x[BLOCKS], y[BLOCKS], z[BLOCKS];
    int blocks = min(BLOCKS, (shape.x - u + 7) / 8);
    for (int b = 0; b < blocks; b++) {
        x[b] = vload8(b, moment + at);
        y[b] = vload8(b, moment + field_stride + at);
        z[b] = vload8(b, moment + 2 * field_stride + at);
    }
    for (int pair = 0; pair < pair_count; pair++) {
        size_t here = pair * field_stride + at;
        float2 fraction = fractions[pair * shape.z + a];
        float4 w = directions[pair];
        for (int b = 0; b < blocks; b++) {
            float8 difference = al_difference(forward + here + 8 * b, backward + here + 8 * b, row, fraction);
            x[b] += difference * w.x;
            y[b] += difference * w.y;
            z[b] += difference * w.z;
        }
    }
    for (int b = 0; b < blocks; b++) {
        vstore8(x[b], b, moment + at);
        vstore8(y[b], b, moment + field_stride + at);
        vstore8(z[b], b, moment + 2 * field_stride + at);
    }
}
