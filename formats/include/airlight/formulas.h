/* Formulas that host and device share, written once in the common subset of C and GLSL.
 *
 * C sees them in double precision. GLSL includes this text with AL_GLSL, AL_REAL and AL_OUT defined
 * (shaders/formulas.glsl). No casts: both languages convert int to floating point in mixed expressions.
 *
 * Spherical harmonics are real and orthonormal, without the Condon-Shortley phase, index l*(l+1)+m;
 * Y(1,-1) goes with y, Y(1,0) with z, Y(1,1) with x. */
#ifndef AIRLIGHT_FORMULAS_H
#define AIRLIGHT_FORMULAS_H

#ifndef AL_GLSL
#include <math.h>
#define AL_FORMULA static inline
#define AL_REAL double
#define AL_OUT(count, name) AL_REAL name[count]
#endif

#define AL_SH_MAX_ORDER 8
#define AL_SH_MAX_COUNT 64
#define AL_PI 3.14159265358979323846

/* All Y(l, m) with l < order at the unit direction (x, y, z); order 1 to AL_SH_MAX_ORDER.
 *
 * Y(l, +-m) = P(l, m; z) {c(m), s(m)} (times sqrt 2 for m > 0), where c(m) + i s(m) = (x + i y)^m carries
 * sin^m theta, so that nothing is divided by sin theta at the poles. The normalised Legendre functions
 * without their sin^m theta and without the sign (-1)^m obey
 *   P(0, 0) = sqrt(1/(4 pi)),   P(m, m) = sqrt((2m+1)/(2m)) P(m-1, m-1),
 *   P(l, m) = a(l) (z P(l-1, m) - P(l-2, m)/a(l-1)),   a(l) = sqrt((4 l^2 - 1)/(l^2 - m^2)),
 * from the three-term recurrence of the associated Legendre functions (DLMF 14.10.3). */
AL_FORMULA void al_sh_basis(int order, AL_REAL x, AL_REAL y, AL_REAL z, AL_OUT(AL_SH_MAX_COUNT, basis))
{
    AL_REAL cosine = 1.0, sine = 0.0, diagonal = 0.28209479177387814;
    for (int m = 0; m < order; m++) {
        AL_REAL scale = m == 0 ? 1.0 : 1.4142135623730951;
        AL_REAL below = 0.0, here = diagonal, factor = 1.0;
        for (int l = m; l < order; l++) {
            if (l > m) {
                AL_REAL previous_factor = factor;
                factor = sqrt((4.0 * l * l - 1.0) / (1.0 * (l * l - m * m)));
                AL_REAL next = factor * (z * here - below / previous_factor);
                below = here;
                here = next;
            }
            basis[l * (l + 1) + m] = scale * here * cosine;
            if (m > 0) basis[l * (l + 1) - m] = scale * here * sine;
        }
        AL_REAL next_cosine = x * cosine - y * sine;
        sine = x * sine + y * cosine;
        cosine = next_cosine;
        diagonal *= sqrt((2.0 * m + 3.0) / (2.0 * m + 2.0));
    }
}

/* Henyey-Greenstein phase function per steradian; cosine between the two directions of travel,
 * g > 0 scatters forward. Henyey and Greenstein 1941. */
AL_FORMULA AL_REAL al_phase(AL_REAL g, AL_REAL cosine)
{
    AL_REAL denominator = 1.0 + g * g - 2.0 * g * cosine;
    return (1.0 - g * g) / (4.0 * AL_PI * denominator * sqrt(denominator));
}

#endif
