/* Directions to draw, and equal angles along a ray. All directions are unit vectors. */
#ifndef AIRLIGHT_DIRECTIONS_H
#define AIRLIGHT_DIRECTIONS_H

#include <math.h>

#include "airlight/formulas.h"
#include "ray_scene.h"

static inline double al_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Two axes across a third: Duff et al. 2017, "Building an Orthonormal Basis, Revisited". */
static inline void al_axes_across(const double axis[3], double a[3], double b[3])
{
    double sign = axis[2] < 0 ? -1 : 1, q = -1 / (sign + axis[2]), r = axis[0] * axis[1] * q;
    a[0] = 1 + sign * axis[0] * axis[0] * q, a[1] = sign * r, a[2] = -sign * axis[0];
    b[0] = r, b[1] = sign + axis[1] * axis[1] * q, b[2] = -axis[1];
}

static inline void al_direction_about(const double axis[3], double cosine, double phi, double direction[3])
{
    double sine = sqrt(fmax(0, 1 - cosine * cosine)), a[3], b[3];
    al_axes_across(axis, a, b);
    for (int k = 0; k < 3; k++) direction[k] = sine * (cos(phi) * a[k] + sin(phi) * b[k]) + cosine * axis[k];
}

/* Cosine of Henyey-Greenstein: (1 + g^2 - ((1 - g^2) / (1 - g + 2 g u))^2) / (2 g), which loses its digits
 * where g is near 0. */
static inline double al_phase_cosine(double g, double u)
{
    if (fabs(g) < 1e-4) return 2 * u - 1 + 3.0 / 2 * g * (1 - (2 * u - 1) * (2 * u - 1));
    double square = (1 - g * g) / (1 - g + 2 * g * u);
    return fmin(fmax((1 + g * g - square * square) / (2 * g), -1), 1);
}

/* Distances at equal angles seen from a light (Kulla and Fajardo 2012): distance = foot + height tan(angle),
 * the angle even between first and last. */
typedef struct al_angles {
    double foot_m, height_m, first, last;
} al_angles;

/* Between begin_m and end_m of the ray. False where there is nothing between them. */
static inline bool al_angles_aim(const al_ray *ray, double begin_m, double end_m, const double light[3],
                                 al_angles *out)
{
    double to[3], square = 0;
    if (!(begin_m < end_m)) return false;
    for (int k = 0; k < 3; k++) to[k] = light[k] - ray->origin[k];
    out->foot_m = al_dot(to, ray->direction);
    for (int k = 0; k < 3; k++) {
        double off = to[k] - out->foot_m * ray->direction[k];
        square += off * off;
    }
    /* A light on the ray itself would make every angle the same. */
    out->height_m = fmax(sqrt(square), 1e-9 * (1 + fabs(out->foot_m)));
    out->first = atan2(begin_m - out->foot_m, out->height_m);
    out->last = atan2(end_m - out->foot_m, out->height_m);
    return out->last > out->first;
}

static inline double al_angles_draw(const al_angles *a, double u)
{
    return a->foot_m + a->height_m * tan(a->first + u * (a->last - a->first));
}

/* Probability of drawing less, and per metre. */
static inline double al_angles_cumulative(const al_angles *a, double distance_m)
{
    return (atan2(distance_m - a->foot_m, a->height_m) - a->first) / (a->last - a->first);
}

static inline double al_angles_density(const al_angles *a, double distance_m)
{
    double off = distance_m - a->foot_m;
    return a->height_m / ((a->last - a->first) * (a->height_m * a->height_m + off * off));
}

#endif
