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

/* Solid angle in sr that stands for a disc of `area` in m2, seen from `height` h >= 0 m over its plane at a squared
 * distance d^2 > 0 from its middle: that of a small piece of its area seen from a height h' instead,
 *   A h' / (d^2 - h^2 + h'^2)^(3/2),  h'^2 = s (s + h) / 2,  s^2 = h^2 + A/pi.
 * On the axis it is the disc's, 2 pi (1 - h/s); far away A h/d^3; at most 2 pi. Whatever h' is, the integral over all
 * middles in the plane is 2 pi A: a wall of discs laid at random is as bright on average as the wall, however near. */
AL_FORMULA AL_REAL al_disc_angle(AL_REAL area, AL_REAL height, AL_REAL squared)
{
    AL_REAL s = sqrt(height * height + area / AL_PI), lifted = 0.5 * s * (s + height);
    AL_REAL away = squared - height * height + lifted;
    return area / away * sqrt(lifted / away);
}

/* 1 - exp(-x) for x >= 0 without cancellation. Below 1/4 by the first seven terms of the Taylor series, whose
 * remainder is below x^7/8! < 2e-9 of the value. */
AL_FORMULA AL_REAL al_one_minus_exp(AL_REAL x)
{
    if (x > 0.25) return 1.0 - exp(-x);
    return x * (1.0 - x / 2.0 * (1.0 - x / 3.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0 * (1.0 - x / 6.0 * (1.0 - x / 7.0))))));
}

/* Planes that stand closer towards both ends of an edge, like the light in a thick medium asks for: the share
 * of the edge where the share u of the planes lies, (1 + tanh(k (2u - 1)) / tanh k) / 2, and its inverse. For
 * large k distances to an end grow by exp(4k/n) from plane to plane of n. k from 0 (even) to 6, where float
 * keeps 1 - tanh k to 0.5 %. */
AL_FORMULA AL_REAL al_graded_place(AL_REAL k, AL_REAL u)
{
    return k > 0.0 ? 0.5 + 0.5 * tanh(k * (2.0 * u - 1.0)) / tanh(k) : u;
}
AL_FORMULA AL_REAL al_graded_share(AL_REAL k, AL_REAL place)
{
    return k > 0.0 ? 0.5 + atanh((2.0 * place - 1.0) * tanh(k)) / (2.0 * k) : place;
}

/* The error function, |error| < 3e-7 everywhere: Abramowitz and Stegun 7.1.28. */
AL_FORMULA AL_REAL al_erf(AL_REAL x)
{
    AL_REAL a = x < 0.0 ? -x : x;
    AL_REAL p = 1.0 + a * (0.0705230784 + a * (0.0422820123 + a * (0.0092705272 + a * (0.0001520143 +
                a * (0.0002765672 + a * 0.0000430638)))));
    p *= p;
    p *= p;
    p *= p;
    p *= p;
    return x < 0.0 ? 1.0 / p - 1.0 : 1.0 - 1.0 / p;
}

/* The integral of exp(-x^2) from `from` to `to` (from <= to): al_erf apart, but for short spans d = to - from,
 * where its difference would cancel, by the Taylor series about the middle m,
 *   d exp(-m^2) (1 + d^2 (4 m^2 - 2)/24 + d^4 (16 m^4 - 48 m^2 + 12)/1920),
 * the derivatives being Hermite polynomials. Together |error| < 6e-7, and relative to d below 4e-6. */
AL_FORMULA AL_REAL al_gauss_span(AL_REAL from, AL_REAL to)
{
    AL_REAL d = to - from;
    if (d > 0.25) {
        AL_REAL span = 0.886226925452758 * (al_erf(to) - al_erf(from));
        return span > 0.0 ? span : 0.0;
    }
    AL_REAL m = from + 0.5 * d, q = m * m, s = d * d;
    return d * exp(-q) * (1.0 + s * ((4.0 * q - 2.0) / 24.0 + s * (16.0 * q * q - 48.0 * q + 12.0) / 1920.0));
}

#endif
