#include "front.h"

#include <math.h>
#include <stdint.h>

static bool beats(const double *error, const double *time, size_t a, size_t b)
{
    return error[a] <= error[b] && time[a] <= time[b] && (error[a] < error[b] || time[a] < time[b]);
}

void al_front(const double *error, const double *time, size_t count, bool *on_front)
{
    for (size_t i = 0; i < count; i++) {
        on_front[i] = isfinite(error[i]) && isfinite(time[i]);
        for (size_t k = 0; k < count && on_front[i]; k++) on_front[i] = !beats(error, time, k, i);
    }
}

size_t al_front_knee(const double *error, const double *time, const bool *on_front, size_t count)
{
    size_t fastest = SIZE_MAX, best = SIZE_MAX, knee = SIZE_MAX;
    for (size_t i = 0; i < count; i++) {
        if (!on_front[i]) continue;
        if (fastest == SIZE_MAX || time[i] < time[fastest]) fastest = i;
        if (best == SIZE_MAX || error[i] < error[best]) best = i;
    }
    if (fastest == SIZE_MAX) return SIZE_MAX;
    const double least = 1e-12;
    double t0 = log(fmax(time[fastest], least)), e0 = log(fmax(error[fastest], least)),
           dt = log(fmax(time[best], least)) - t0, de = log(fmax(error[best], least)) - e0, farthest = -1;
    for (size_t i = 0; i < count; i++) {
        if (!on_front[i]) continue;
        double below = de * (log(fmax(time[i], least)) - t0) - dt * (log(fmax(error[i], least)) - e0);
        if (below > farthest) farthest = below, knee = i;
    }
    return knee;
}
