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
    float8 series = x * (1.0f - x * (0.5f - x * (1.0f / 6.0f - x * (1.0f / 24.0f))));
    float8 power = fmax(x * -1.44269504f, (float8)(-126.0f));
    float8 whole = rint(power);
    float8 f = (power - whole) * 0.693147181f;
    float8 p = 1.0f + f * (1.0f + f * (0.5f + f * (1.0f / 6.0f + f * (1.0f / 24.0f +
               f * (1.0f / 120.0f + f * (1.0f / 720.0f))))));
    float8 e = p * as_float8((convert_int8(whole) + 127) << 23);
    return select(1.0f - e, series, x < 0.03f);
}

/* Density on eight neighbouring rays of slice a; column u, row v of their storage. */
static inline float8 al_on_rays(global const float *density, int4 shape, int u, int v, int a, float2 fraction)
{
    global const float *row = density + al_at(shape, u, v, a);
    float8 low = mix(vload8(0, row), vload8(0, row + 1), fraction.x);
    float8 high = mix(vload8(0, row + shape.w), vload8(0, row + shape.w + 1), fraction.x);
    return mix(low, high, fraction.y);
}

/* Global size: (blocks of 8 rays along u, rays along v, direction pairs of the batch).
 * shifts, fractions: [pair][na]; rays: per pair first column and row of rays, their counts;
 * lengths: per pair sigma * ds; forward, backward: [pair][na][nv + 2][width]. */
kernel void optical_depth(global const float *density, int4 shape, global const int2 *shifts,
                          global const float2 *fractions, global const int4 *rays, global const float *lengths,
                          ulong field_stride, global float *forward, global float *backward)
{
    int pair = get_global_id(2);
    int4 range = rays[pair];
    int first_u = (int)get_global_id(0) * 8, first_v = get_global_id(1);
    if (first_u >= range.z || first_v >= range.w) return;
    first_u += range.x;
    first_v += range.y;
    shifts += pair * shape.z;
    fractions += pair * shape.z;
    forward += pair * field_stride;
    backward += pair * field_stride;
    float half_length = 0.5f * lengths[pair];

    for (int side = 0; side < 2; side++) { /* 0: tau towards +w, slices from last to first; 1: towards -w */
        global float *field = side == 0 ? forward : backward;
        float8 tau = 0.0f, before = 0.0f;
        for (int n = 0; n < shape.z; n++) {
            int a = side == 0 ? shape.z - 1 - n : n;
            int u = first_u + shifts[a].x, v = first_v + shifts[a].y;
            if (u < -8 || u >= shape.x || v < -1 || v >= shape.y) continue;
            float8 here = al_on_rays(density, shape, u, v, a, fractions[a]);
            tau += half_length * (before + here);
            before = here;
            vstore8(al_absorbance(tau), 0, field + al_at(shape, u, v, a));
        }
    }
}
