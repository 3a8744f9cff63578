/* Step 6: project. Adds a batch of direction pairs to the spherical harmonics of the absorbance
 * A = 1 - psi at the samples: c(l, m) += (A(w) + (-1)^l A(-w)) Y(l, m; w), since Y(l, m; -w) = (-1)^l Y(l, m; w).
 * The host applies 4 pi / n and turns it into psi: the constant 1 is exact, only A is summed by quadrature. */
#include "sweep.cl"

/* A swept field at a point: bilinear among the rays of a slice. point in voxels, centres at whole numbers. */
static inline float al_in_slice(global const float *field, int4 shape, float2 point, int a, float2 fraction)
{
    float u = point.x - fraction.x, v = point.y - fraction.y;
    float whole_u = floor(u), whole_v = floor(v);
    global const float *at = field + al_at(shape, (int)whole_u, (int)whole_v, a);
    size_t row = al_row(shape);
    float fu = u - whole_u, fv = v - whole_v;
    return mix(mix(at[0], at[1], fu), mix(at[row], at[row + 1], fu), fv);
}

static inline float al_at_point(global const float *field, int4 shape, float4 point,
                                global const float2 *fractions)
{
    float whole = floor(point.z), f = point.z - whole;
    int a = (int)whole;
    return mix(al_in_slice(field, shape, point.xy, a, fractions[a]),
               al_in_slice(field, shape, point.xy, a + 1, fractions[a + 1]), f);
}

/* Global size: samples. points: (u, v, a) voxel coordinates, at least half a voxel inside the grid.
 * even, odd: [pair][blocks] Y(l, m; w) of even and odd l, zero for the others, blocks of 8 numbers;
 * coefficients: [sample][blocks]. */
kernel void project(global const float *forward, global const float *backward, int4 shape,
                    global const float2 *fractions, global const float4 *points, global const float8 *even,
                    global const float8 *odd, int pair_count, int blocks, ulong field_stride,
                    global float8 *coefficients)
{
    size_t sample = get_global_id(0);
    float4 point = points[sample];
    float8 sum[8];
    for (int b = 0; b < blocks; b++) sum[b] = coefficients[sample * blocks + b];
    for (int pair = 0; pair < pair_count; pair++) {
        global const float2 *fraction = fractions + pair * shape.z;
        float ahead = al_at_point(forward + pair * field_stride, shape, point, fraction);
        float behind = al_at_point(backward + pair * field_stride, shape, point, fraction);
        for (int b = 0; b < blocks; b++)
            sum[b] += (ahead + behind) * even[pair * blocks + b] + (ahead - behind) * odd[pair * blocks + b];
    }
    for (int b = 0; b < blocks; b++) coefficients[sample * blocks + b] = sum[b];
}
