#include "airlight/sh.h"

#include <math.h>

#include "airlight/formulas.h"

void al_sh_basis_f(int order, const float direction[3], float *basis)
{
    double values[AL_SH_MAX_COUNT];
    al_sh_basis(order, direction[0], direction[1], direction[2], values);
    for (int i = 0; i < order * order; i++) basis[i] = (float)values[i];
}

/* The recurrence above al_sh_basis (formulas.h). */
void al_sh_column(int m, int band_count, double z, double *column)
{
    double here = 0.28209479177387814, below = 0, factor = 1;
    for (int i = 1; i <= m; i++) here *= sqrt((2 * i + 1) / (2.0 * i));
    for (int l = m; l < band_count; l++) {
        if (l > m) {
            double previous_factor = factor;
            factor = sqrt((4.0 * l * l - 1) / (1.0 * (l * l - m * m)));
            double next = factor * (z * here - below / previous_factor);
            below = here;
            here = next;
        }
        column[l] = here;
    }
}

/* Nodes and weights of Gauss-Legendre quadrature with `count` points: the roots of the Legendre polynomial P,
 * by Newton's method from cos(pi (i + 3/4) / (count + 1/2)), with P and its derivative from the recurrence
 * n P(n) = (2n-1) z P(n-1) - (n-1) P(n-2),  (z^2 - 1) P'(n) = n (z P(n) - P(n-1)); weight 2 / ((1 - z^2)
 * P'^2). */
static void gauss_legendre(int count, double nodes[], double weights[])
{
    enum { STEPS = 8 }; /* quadratic convergence from a start that is good to 1 % */
    for (int i = 0; i < count; i++) {
        double z = cos(AL_PI * (i + 0.75) / (count + 0.5)), slope = 1;
        for (int step = 0; step < STEPS; step++) {
            double below = 1, here = z;
            for (int n = 2; n <= count; n++) {
                double next = ((2 * n - 1) * z * here - (n - 1) * below) / n;
                below = here;
                here = next;
            }
            slope = count * (z * here - below) / (z * z - 1);
            z -= here / slope;
        }
        nodes[i] = z;
        weights[i] = 2 / ((1 - z * z) * slope * slope);
    }
}

/* The rotated function h(w) = f(R^-1 w) has the same bands as f, so its coefficients are the integrals
 *   h(l, m) = integral of f(R^-1 w) Y(l, m; w) dw
 * of a polynomial of degree 2 (order - 1) on the sphere. A product rule is exact for it: Gauss-Legendre with
 * `order` points in z (exact to degree 2 order - 1), 2 order - 1 equal steps in azimuth (exact for the
 * frequencies up to 2 order - 2). R^-1 is the transpose of R. */
void al_sh_rotate(int order, const float rotation[9], const float *in, float *out)
{
    double nodes[AL_SH_MAX_ORDER], weights[AL_SH_MAX_ORDER], sums[AL_SH_MAX_COUNT] = {0};
    double there[AL_SH_MAX_COUNT], here[AL_SH_MAX_COUNT];
    int count = order * order, steps = 2 * order - 1;
    gauss_legendre(order, nodes, weights);
    for (int i = 0; i < order * steps; i++) {
        double z = nodes[i / steps], radius = sqrt(1 - z * z), angle = 2 * AL_PI * (i % steps) / steps;
        double w[3] = {radius * cos(angle), radius * sin(angle), z}, back[3], value = 0;
        for (int k = 0; k < 3; k++)
            back[k] = rotation[k] * w[0] + rotation[3 + k] * w[1] + rotation[6 + k] * w[2];
        al_sh_basis(order, back[0], back[1], back[2], there);
        al_sh_basis(order, w[0], w[1], w[2], here);
        for (int k = 0; k < count; k++) value += in[k] * there[k];
        value *= weights[i / steps] * 2 * AL_PI / steps;
        for (int k = 0; k < count; k++) sums[k] += value * here[k];
    }
    for (int k = 0; k < count; k++) out[k] = (float)sums[k];
}

void al_sh_phase(int order, float g, const float axis[3], float *out)
{
    double values[AL_SH_MAX_COUNT], moment = 1;
    al_sh_basis(order, axis[0], axis[1], axis[2], values);
    for (int l = 0; l < order; l++, moment *= g)
        for (int i = l * l; i < (l + 1) * (l + 1); i++) out[i] = (float)(moment * values[i]);
}

void al_direction_set(uint32_t count, uint32_t index, double direction[3])
{
    uint32_t half = count / 2, i = index % half;
    double sign = index < half ? 1 : -1;
    double golden_angle = AL_PI * (3 - sqrt(5.0));
    double z = 1 - (2.0 * i + 1) / half, radius = sqrt(fmax(0, 1 - z * z)), angle = golden_angle * i;
    direction[0] = sign * radius * cos(angle);
    direction[1] = sign * radius * sin(angle);
    direction[2] = sign * z;
}
