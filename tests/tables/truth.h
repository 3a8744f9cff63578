/* Event 1 by another quadrature than the tables': Gauss-Legendre panels over the angles at receiver and emitter
 * (geometry: opencl/impulse_scatter.cl). Good to 1e-7 for distances of 0.01 to 30 mean free paths and phase
 * functions no narrower than g = 0.9. */
#ifndef AIRLIGHT_TRUTH_H
#define AIRLIGHT_TRUTH_H

#include <math.h>
#include <string.h>

#include "airlight/formulas.h"
#include "airlight/sh.h"

enum { TRUTH_PANELS = 96, TRUTH_BANDS = 11 };

static const double truth_nodes[5] = {0.046910077030668, 0.230765344947158, 0.5, 0.769234655052842,
                                      0.953089922969332};
static const double truth_weights[5] = {0.118463442528095, 0.239314335249683, 0.284444444444444,
                                        0.239314335249683, 0.118463442528095};

/* Point i of the panels on (0, length), denser towards both ends; *weight its weight. */
static inline double truth_point(int i, double length, double *weight)
{
    double u = (i / 5 + truth_nodes[i % 5]) / TRUTH_PANELS; /* x = u^2 (3 - 2u): dx = 6 u (1 - u) du */
    *weight = length * 6 * u * (1 - u) * truth_weights[i % 5] / TRUTH_PANELS;
    return length * u * u * (3 - 2 * u);
}

typedef double truth_phase(double g, double cosine);

/* ZH of event 1 in the light of a point, sigma_s = sigma_t = 1. */
static inline void truth_point_single(double d, double g, truth_phase *phase, double zh[TRUTH_BANDS])
{
    memset(zh, 0, TRUTH_BANDS * sizeof *zh);
    for (int i = 0; i < 5 * TRUTH_PANELS; i++) {
        double weight, theta = truth_point(i, AL_PI, &weight), sum = 0, column[TRUTH_BANDS];
        for (int k = 0; k < 5 * TRUTH_PANELS; k++) {
            double w, alpha = truth_point(k, AL_PI - theta, &w);
            double excess = 2 * sin(theta / 2) * sin(alpha / 2) / cos((theta + alpha) / 2);
            sum += w * phase(g, cos(theta + alpha)) * exp(-d * (1 + excess));
        }
        al_sh_column(0, TRUTH_BANDS, cos(theta), column);
        for (int l = 0; l < TRUTH_BANDS; l++) zh[l] += 2 * AL_PI / d * weight * sum * column[l];
    }
}

/* Fluence and flux (z to the emitter, x to the normal's side) of event 1 in the light of an area, isotropic. */
static inline void truth_area_single(double d, double c, double answer[3])
{
    double s = sqrt(1 - c * c);
    memset(answer, 0, 3 * sizeof *answer);
    for (int i = 0; i < 5 * TRUTH_PANELS; i++) {
        double weight, theta = truth_point(i, AL_PI, &weight), mean = 0, side = 0;
        for (int k = 0; k < 5 * TRUTH_PANELS; k++) {
            double w, alpha = truth_point(k, AL_PI - theta, &w);
            double light = w * exp(-d * (1 + 2 * sin(theta / 2) * sin(alpha / 2) / cos((theta + alpha) / 2)));
            /* means over the azimuth of max(0, a + b cos phi) and of cos phi times it */
            double a = c * cos(alpha), b = s * sin(alpha), end = fabs(a) < b ? acos(-a / b) : a > 0 ? AL_PI : 0;
            mean += light * (a * end + b * sin(end)) / AL_PI;
            side += light * (a * sin(end) + b * (end / 2 + sin(2 * end) / 4)) / AL_PI;
        }
        answer[0] += weight / (2 * d) * mean;
        answer[1] += weight / (2 * d) * side * sin(theta);
        answer[2] += weight / (2 * d) * mean * cos(theta);
    }
}

#endif
