/* Step 2: optical depth. Marches the rays of a batch of direction pairs {w, -w} through the density grid and
 * keeps the absorbance 1 - psi(x, +-w), psi = exp(-tau), tau = sigma * integral of density from x to the
 * boundary. Along a ray tau is the trapezoidal rule between slices ds = voxel/|w_a| apart, exact for density
 * linear between slices; the sums for w and -w run separately, so that a blocker (a huge density) on one
 * side cannot cancel against the other. */
#include "sweep.cl"

/* 1 - exp(-x) for x >= 0 with relative error below 3e-6: the series below x = 0.03 (its next term is
 * x^4/120 < 7e-9 of it), where the difference would cancel; above, exp2 by Taylor's series of 2^f on
 * f in [-0.5, 0.5] to degree 6 (next term (0.5 ln 2)^7/5040 < 1.2e-7) with the exponent set in the bits. */
static inline float8 al_absorbance(float8 x)
{
    x = select(x, (float8)80.0f, x > 80.0f); /* exp(-80) is nothing beside 1 */
    float8 series = x * (1.0f - x * (0.5f - x * (1.0f / 6.0f - x * (1.0f / 24.0f))));
    float8 power = x * -1.44269504f;
    float8 shifted = power + 12582912.0f; /* 1.5 * 2^23: the nearest whole number in the low bits */
    float8 f = (power - (shifted - 12582912.0f)) * 0.693147181f;
    float8 p = 1.0f + f * (1.0f + f * (0.5f + f * (1.0f / 6.0f + f * (1.0f / 24.0f +
               f * (1.0f / 120.0f + f * (1.0f / 720.0f))))));
    float8 e = p * as_float8((as_int8(shifted) << 23) + (127 << 23));
    return select(1.0f - e, series, x < 0.03f);
}

/* Density on the eight rays whose storage begins at `place`; the next row is `row` further. */
static inline float8 al_on_rays(global const float *place, size_t row, float2 fraction)
{
    float8 low = mix(vload8(0, place), vload8(0, place + 1), fraction.x);
    float8 high = mix(vload8(0, place + row), vload8(0, place + row + 1), fraction.x);
    return mix(low, high, fraction.y);
}

/* Blocks of eight rays that one work-item takes side by side: whole cache lines, slice after slice. */
#define BLOCKS 4

/* Global size: (groups of 8 * BLOCKS rays along u, rays along v, direction pairs of the batch).
 * shifts, fractions: [pair][na]; rays: per pair first column and row of rays, their counts;
 * lengths: per pair sigma * ds; forward, backward: [pair][nv + 2][na][width]. */
kernel void optical_depth(global const float *density, int4 shape, global const int2 *shifts,
                          global const float2 *fractions, global const int4 *rays, global const float *lengths,
                          ulong field_stride, global float *forward, global float *backward)
{
    int pair = get_global_id(2);
    int4 range = rays[pair];
    int first_u = (int)get_global_id(0) * 8 * BLOCKS, first_v = get_global_id(1);
    if (first_u >= range.z || first_v >= range.w) return;
    first_u += range.x;
    first_v += range.y;
    shifts += pair * shape.z;
    fractions += pair * shape.z;
    size_t row = al_row(shape);
    float half_length = 0.5f * lengths[pair];

    for (int side = 0; side < 2; side++) { /* 0: tau towards +w, slices from last to first; 1: towards -w */
        global float *field = (side == 0 ? forward : backward) + pair * field_stride;
        float8 tau[BLOCKS], before[BLOCKS];
        for (int b = 0; b < BLOCKS; b++) tau[b] = before[b] = 0.0f;
        for (int n = 0; n < shape.z; n++) {
            int a = side == 0 ? shape.z - 1 - n : n;
            int u = first_u + shifts[a].x, v = first_v + shifts[a].y;
            if (u <= -8 * BLOCKS || u >= shape.x || v < -1 || v >= shape.y) continue;
            float2 fraction = fractions[a];
            size_t at = al_at(shape, u, v, a);
            for (int b = 0; b < BLOCKS; b++) {
                if (u + 8 * b < -8 || u + 8 * b >= shape.x) continue;
                float8 here = al_on_rays(density + at + 8 * b, row, fraction);
                tau[b] += half_length * (before[b] + here);
                before[b] = here;
                vstore8(al_absorbance(tau[b]), 0, field + at + 8 * b);
            }
        }
    }
}
