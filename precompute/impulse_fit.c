/* Step 3 of the impulse tables: the published area emitter, a zonal function about one axis.
 *
 * The best zonal function about a given axis a is the projection: band l is
 *   z(l; a) = sqrt(4 pi/(2l + 1)) sum over m of sh(l, m) Y(l, m; a),
 * and what it misses in the square norm is smallest where sum of z(l; a)^2 is largest. By symmetry a lies in
 * the plane of the normal and the direction to the emitter; a search over its angle, then a parabola through
 * the best three until they close in (the paper: Brent's method). Only m <= 2 is known here: bands 0 to 2 are
 * exact, those above lack what m > 2 would add off the direction to the emitter. */
#include <math.h>
#include <string.h>

#include "airlight/formulas.h"
#include "airlight/sh.h"
#include "impulse_steps.h"

/* sum of z^2; z [bands]. sh: numbers with their sines. */
static double project(uint32_t bands, const double *sh, double angle, double *z)
{
    double cosine = cos(angle), sine = sin(angle), column[AL_IMPULSE_BAND_LIMIT], norm = 0, factor = 1;
    memset(z, 0, bands * sizeof *z);
    for (uint32_t m = 0; m < AL_IMPULSE_M_COUNT; m++, factor = m == 1 ? sqrt(2.0) * sine : factor * sine) {
        al_sh_column((int)m, (int)bands, cosine, column);
        for (uint32_t l = m; l < bands; l++) z[l] += *sh++ * factor * column[l];
    }
    for (uint32_t l = 0; l < bands; l++) {
        z[l] *= sqrt(4 * AL_PI / (2 * l + 1));
        norm += z[l] * z[l];
    }
    return norm;
}

void al_impulse_fit(uint32_t bands, double cos_normal, const double *numbers, double *fitted)
{
    enum { ANGLES = 48, STEPS = 24 };
    double sh[AL_IMPULSE_NUMBER_LIMIT], z[AL_IMPULSE_BAND_LIMIT], best = -1, angle = 0;
    double sine = sqrt(fmax(0, 1 - cos_normal * cos_normal)), width = AL_PI / ANGLES, factor = 1;
    for (uint32_t m = 0, n = 0; m < AL_IMPULSE_M_COUNT; m++, factor *= sine)
        for (uint32_t l = m; l < bands; l++, n++) sh[n] = numbers[n] * factor;
    for (int i = -ANGLES / 4; i <= ANGLES; i++) {
        double norm = project(bands, sh, i * width, z);
        if (norm > best) {
            best = norm;
            angle = i * width;
        }
    }
    for (int step = 0; step < STEPS; step++) {
        double low = project(bands, sh, angle - width, z), here = project(bands, sh, angle, z),
               high = project(bands, sh, angle + width, z), bend = low - 2 * here + high;
        if (bend < 0) angle += fmin(fmax(0.5 * width * (low - high) / bend, -width), width);
        width *= 0.6;
    }
    fitted[0] = sine > 0 ? angle : 0;
    project(bands, sh, fitted[0], fitted + 1);
}
