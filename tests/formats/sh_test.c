/* Spherical harmonics: conventions, orthonormality, addition theorem, rotation, phase, direction sets. */
#include "airlight/sh.h"

#include <stdlib.h>
#include <string.h>

#include "../test.h"
#include "airlight/formulas.h"

/* Deterministic numbers in [-1, 1): the low bits of a 64-bit linear congruence are poor, so take high ones.
 */
static double random_signed(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) / 0x1p52 - 1;
}

static void random_direction(uint64_t *state, double w[3])
{
    double square;
    do {
        for (int i = 0; i < 3; i++) w[i] = random_signed(state);
        square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
    } while (square > 1 || square < 0.01);
    for (int i = 0; i < 3; i++) w[i] /= sqrt(square);
}

static void test_conventions(void)
{
    double s[AL_SH_MAX_COUNT];
    const double c1 = sqrt(3 / (4 * AL_PI)), x = 0.48, y = 0.6, z = 0.64;
    al_sh_basis(3, x, y, z, s);
    /* Closed forms of the real harmonics without the Condon-Shortley phase; rounding only. */
    CHECK_NEAR(s[0], sqrt(1 / (4 * AL_PI)), 1e-15);
    CHECK_NEAR(s[1], c1 * y, 1e-15);
    CHECK_NEAR(s[2], c1 * z, 1e-15);
    CHECK_NEAR(s[3], c1 * x, 1e-15);
    CHECK_NEAR(s[4], sqrt(15 / (4 * AL_PI)) * x * y, 1e-15);
    CHECK_NEAR(s[5], sqrt(15 / (4 * AL_PI)) * y * z, 1e-15);
    CHECK_NEAR(s[6], sqrt(5 / (16 * AL_PI)) * (3 * z * z - 1), 1e-15);
    CHECK_NEAR(s[7], sqrt(15 / (4 * AL_PI)) * x * z, 1e-15);
    CHECK_NEAR(s[8], sqrt(15 / (16 * AL_PI)) * (x * x - y * y), 1e-15);
}

/* Composite midpoint in azimuth is exact for these frequencies; in z Simpson's rule with n steps errs by
 * (2/180) h^4 max|f''''|. The integrands are polynomials of degree 14 in z (times sqrt(1-z^2) factors that
 * cancel in products), bounded so that n = 4000 leaves below 1e-7. */
static void test_orthonormality(void)
{
    enum { STEPS = 4000, AZIMUTHS = 32 };
    static double gram[AL_SH_MAX_COUNT][AL_SH_MAX_COUNT];
    double s[AL_SH_MAX_COUNT], worst = 0;
    for (int i = 0; i <= STEPS; i++) {
        double z = -1 + 2.0 * i / STEPS, r = sqrt(fmax(0, 1 - z * z));
        double weight = (i == 0 || i == STEPS ? 1
                         : i % 2              ? 4
                                              : 2) *
                        (2.0 / STEPS) / 3 * (2 * AL_PI / AZIMUTHS);
        for (int j = 0; j < AZIMUTHS; j++) {
            double angle = 2 * AL_PI * (j + 0.5) / AZIMUTHS;
            al_sh_basis(AL_SH_MAX_ORDER, r * cos(angle), r * sin(angle), z, s);
            for (int a = 0; a < AL_SH_MAX_COUNT; a++)
                for (int b = 0; b <= a; b++) gram[a][b] += weight * s[a] * s[b];
        }
    }
    for (int a = 0; a < AL_SH_MAX_COUNT; a++)
        for (int b = 0; b <= a; b++) worst = fmax(worst, fabs(gram[a][b] - (a == b)));
    CHECK_NEAR(worst, 0, 1e-7);
}

/* sum over m of Y(l,m;a) Y(l,m;b) = (2l+1)/(4 pi) P_l(a.b); the Legendre polynomial by its own recurrence.
 * Sums of at most 15 products below 1.4^2: rounding stays below 1e-13. */
static void test_addition_theorem(void)
{
    uint64_t state = 1;
    double a[3], b[3], sa[AL_SH_MAX_COUNT], sb[AL_SH_MAX_COUNT];
    for (int trial = 0; trial < 100; trial++) {
        random_direction(&state, a);
        random_direction(&state, b);
        al_sh_basis(AL_SH_MAX_ORDER, a[0], a[1], a[2], sa);
        al_sh_basis(AL_SH_MAX_ORDER, b[0], b[1], b[2], sb);
        double cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2], below = 1, here = cosine;
        for (int l = 0; l < AL_SH_MAX_ORDER; l++) {
            double sum = 0, legendre = l == 0 ? 1 : here;
            for (int i = l * l; i < (l + 1) * (l + 1); i++) sum += sa[i] * sb[i];
            CHECK_NEAR(sum, (2 * l + 1) / (4 * AL_PI) * legendre, 1e-13);
            if (l >= 1) {
                double next = ((2 * l + 1) * cosine * here - l * below) / (l + 1);
                below = here;
                here = next;
            }
        }
    }
}

/* A rotation from a random unit quaternion, row-major. */
static void random_rotation(uint64_t *state, float r[9])
{
    double q[4], square;
    do {
        square = 0;
        for (int i = 0; i < 4; i++) {
            q[i] = random_signed(state);
            square += q[i] * q[i];
        }
    } while (square > 1 || square < 0.01);
    for (int i = 0; i < 4; i++) q[i] /= sqrt(square);
    double w = q[0], x = q[1], y = q[2], z = q[3];
    double m[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
                   2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                   2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
    for (int i = 0; i < 9; i++) r[i] = (float)m[i];
}

static double evaluate(int order, const float *coefficients, const double w[3])
{
    double s[AL_SH_MAX_COUNT], sum = 0;
    al_sh_basis(order, w[0], w[1], w[2], s);
    for (int i = 0; i < order * order; i++) sum += coefficients[i] * s[i];
    return sum;
}

static void rotate_direction(const float r[9], const double w[3], double out[3])
{
    for (int i = 0; i < 3; i++) out[i] = r[3 * i] * w[0] + r[3 * i + 1] * w[1] + r[3 * i + 2] * w[2];
}

/* h(R w) = f(w) at random directions. Coefficients are in [-1, 1], so |f| is at most 64 x 1.2; floats hold
 * rotation and coefficients to 6e-8, which order 8 amplifies by the gradient, at most l per radian: 2e-5. */
static void test_rotation(void)
{
    uint64_t state = 2;
    float in[AL_SH_MAX_COUNT], out[AL_SH_MAX_COUNT], r[9];
    for (int order = 1; order <= AL_SH_MAX_ORDER; order++)
        for (int trial = 0; trial < 20; trial++) {
            double w[3], turned[3];
            random_rotation(&state, r);
            for (int i = 0; i < order * order; i++) in[i] = (float)random_signed(&state);
            al_sh_rotate(order, r, in, out);
            for (int k = 0; k < 10; k++) {
                random_direction(&state, w);
                rotate_direction(r, w, turned);
                CHECK_NEAR(evaluate(order, out, turned), evaluate(order, in, w), 2e-5);
            }
        }
}

/* Quarter turns have exact float matrices, so each coefficient must come out to 1e-6: about z by 90 degrees
 * x goes to y and y to -x; every other coefficient is checked by four turns giving the first function back.
 */
static void test_quarter_turns(void)
{
    const float about_z[9] = {0, -1, 0, 1, 0, 0, 0, 0, 1}, about_x[9] = {1, 0, 0, 0, 0, -1, 0, 1, 0};
    const float *turns[] = {about_z, about_x};
    uint64_t state = 3;
    float in[AL_SH_MAX_COUNT], out[AL_SH_MAX_COUNT];
    for (int i = 0; i < AL_SH_MAX_COUNT; i++) in[i] = (float)random_signed(&state);
    al_sh_rotate(2, about_z, in, out);
    CHECK_NEAR(out[0], in[0], 1e-6);
    CHECK_NEAR(out[1], in[3], 1e-6);
    CHECK_NEAR(out[2], in[2], 1e-6);
    CHECK_NEAR(out[3], -in[1], 1e-6);
    for (int t = 0; t < 2; t++) {
        memcpy(out, in, sizeof out);
        for (int k = 0; k < 4; k++) al_sh_rotate(AL_SH_MAX_ORDER, turns[t], out, out); /* in place */
        for (int i = 0; i < AL_SH_MAX_COUNT; i++) CHECK_NEAR(out[i], in[i], 1e-6);
    }
}

/* sum over l < order of the coefficients is the phase function cut off: the rest is a geometric series,
 * sum over l >= order of (2l+1)/(4 pi) |g|^l; at g = 0.5 and order 8 below 0.011. */
static void test_phase(void)
{
    uint64_t state = 4;
    double axis[3], w[3];
    float c[AL_SH_MAX_COUNT];
    for (int trial = 0; trial < 50; trial++) {
        double g = 0.5 * random_signed(&state), rest = 0;
        random_direction(&state, axis);
        random_direction(&state, w);
        const float axis_f[3] = {(float)axis[0], (float)axis[1], (float)axis[2]};
        al_sh_phase(AL_SH_MAX_ORDER, (float)g, axis_f, c);
        for (int l = AL_SH_MAX_ORDER; l < 200; l++) rest += (2 * l + 1) / (4 * AL_PI) * pow(fabs(g), l);
        double cosine = axis[0] * w[0] + axis[1] * w[1] + axis[2] * w[2];
        CHECK_NEAR(evaluate(AL_SH_MAX_ORDER, c, w), al_phase(g, cosine), rest + 1e-6);
        CHECK_NEAR(c[0], 0.28209479177387814, 1e-7);
    }
}

/* The whole set: pairs are exact mirrors, so the sum is zero up to the rounding of the summation; lengths 1.
 */
static void test_direction_set(uint32_t count)
{
    double sum[3] = {0}, w[3], mirror[3];
    for (uint32_t i = 0; i < count; i++) {
        al_direction_set(count, i, w);
        for (int k = 0; k < 3; k++) sum[k] += w[k];
        CHECK_NEAR(w[0] * w[0] + w[1] * w[1] + w[2] * w[2], 1, 1e-14);
    }
    for (uint32_t i = 0; i < count / 2; i++) {
        al_direction_set(count, i, w);
        al_direction_set(count, i + count / 2, mirror);
        for (int k = 0; k < 3; k++) CHECK(mirror[k] == -w[k]);
    }
    for (int k = 0; k < 3; k++) CHECK_NEAR(sum[k], 0, 1e-12 * count);
}

/* The largest |mean of Y(l,m) over the set| for 1 <= l < order: what equal weights make of functions whose
 * mean is zero. */
static double quadrature_error(uint32_t count, int order)
{
    double s[AL_SH_MAX_COUNT], mean[AL_SH_MAX_COUNT] = {0}, w[3], worst = 0;
    for (uint32_t i = 0; i < count; i++) {
        al_direction_set(count, i, w);
        al_sh_basis(order, w[0], w[1], w[2], s);
        for (int k = 0; k < order * order; k++) mean[k] += s[k] / count;
    }
    for (int k = 1; k < order * order; k++) worst = fmax(worst, fabs(mean[k]));
    return worst;
}

/* A spherical Fibonacci set is a lattice whose error for smooth functions falls at least like 1/n: four times
 * the directions gain at least 4 times (measured: 7 and 6). Random directions would gain 2. */
static void test_quadrature(void)
{
    double at_128 = quadrature_error(128, 5), at_512 = quadrature_error(512, 5),
           at_2048 = quadrature_error(2048, 5);
    printf("mean of harmonics of bands 1 to 4: %.2e at 128 directions, %.2e at 512, %.2e at 2048\n", at_128,
           at_512, at_2048);
    CHECK(at_512 * 4 <= at_128);
    CHECK(at_2048 * 4 <= at_512);
}

int main(void)
{
    test_conventions();
    test_orthonormality();
    test_addition_theorem();
    test_rotation();
    test_quarter_turns();
    test_phase();
    test_direction_set(2);
    test_direction_set(32);
    test_direction_set(512);
    test_quadrature();
    return test_end();
}
