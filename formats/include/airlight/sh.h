/* Spherical harmonics and direction sets on the host. Conventions: formulas.h.
 * Thread safety: every function is pure. */
#ifndef AIRLIGHT_SH_H
#define AIRLIGHT_SH_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Float version of al_sh_basis (formulas.h), computed in double. `basis` holds order * order numbers. */
void al_sh_basis_f(int order, const float direction[3], float *basis);

/* Y(l, m) for l = m to band_count - 1 without its azimuth, in column[l]: Y(l, 0) = column[l], and for m > 0
 * Y(l, +-m) = sqrt 2 column[l] Re or Im of (x + i y)^m, at a unit direction (x, y, z). Any band. */
void al_sh_column(int m, int band_count, double z, double *column);

/* Rotates coefficients: the function f(w) becomes f(R^-1 w). `rotation` is row-major, orthonormal, det +1.
 * order 1 to 8; `in` and `out` hold order * order numbers and may be the same array. */
void al_sh_rotate(int order, const float rotation[9], const float *in, float *out);

/* Coefficients of al_phase(g, cos) about the axis: band l is g^l Y(l, .; axis). */
void al_sh_phase(int order, float g, const float axis[3], float *out);

/* Direction `index` of a set of `count` (even, >= 2): the first half is a spherical Fibonacci set of
 * count/2 points (Swinbank and Purser 2006), the second half its mirror image:
 * direction(i + count/2) = -direction(i). */
void al_direction_set(uint32_t count, uint32_t index, double direction[3]);

#ifdef __cplusplus
}
#endif
#endif
