/* Points drawn uniformly from an object's interior: a tetrahedron by its volume, then a point in it. */
#include <math.h>
#include <stdlib.h>

#include "sample.h"

/* SplitMix64 (Steele, Lea and Flood 2014): every counter its own number, so that draws can be made in any
 * order and on any thread. */
static double uniform(uint32_t seed, uint64_t counter)
{
    uint64_t x = ((uint64_t)seed << 32) ^ (counter * 0x9e3779b97f4a7c15u + 0x9e3779b97f4a7c15u);
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return (double)((x ^ (x >> 31)) >> 11) * 0x1p-53;
}

static double tetrahedron_volume(const al_interior *interior, uint32_t t)
{
    const double *p[4];
    double e[3][3];
    for (int i = 0; i < 4; i++) p[i] = interior->points + 3 * (size_t)interior->corners[4 * (size_t)t + i];
    for (int n = 0; n < 3; n++)
        for (int i = 0; i < 3; i++) e[n][i] = p[n + 1][i] - p[0][i];
    double determinant = e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
                         e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
                         e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
    return fabs(determinant) / 6;
}

al_status al_candidates_create(const al_interior *interior, uint32_t seed, al_candidates *candidates,
                               al_error *error)
{
    double volume = 0;
    *candidates = (al_candidates){.interior = interior, .seed = seed};
    candidates->running_volume = malloc((interior->count + 1) * sizeof(double));
    if (!candidates->running_volume)
        return al_fail(error, AL_IO, "out of memory for %u tetrahedra", interior->count);
    for (uint32_t t = 0; t < interior->count; t++)
        candidates->running_volume[t] = volume += tetrahedron_volume(interior, t);
    return AL_OK;
}

void al_candidates_free(al_candidates *candidates)
{
    free(candidates->running_volume);
    *candidates = (al_candidates){0};
}

bool al_candidate(const al_candidates *candidates, uint64_t index, double point[3])
{
    const al_interior *interior = candidates->interior;
    double u[4];
    for (int i = 0; i < 4; i++) u[i] = uniform(candidates->seed, 4 * index + (uint64_t)i);
    double target = u[3] * candidates->running_volume[interior->count - 1];
    uint32_t low = 0, high = interior->count - 1;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (candidates->running_volume[middle] > target)
            high = middle;
        else
            low = middle + 1;
    }
    /* The gaps between three sorted uniform numbers are uniform barycentric coordinates. */
    double a = fmin(u[0], u[1]), b = fmax(u[0], u[1]);
    double first = fmin(a, u[2]), last = fmax(b, u[2]), middle = u[0] + u[1] + u[2] - first - last;
    double weight[4] = {first, middle - first, last - middle, 1 - last};
    for (int i = 0; i < 3; i++) {
        point[i] = 0;
        for (int n = 0; n < 4; n++)
            point[i] += weight[n] * interior->points[3 * (size_t)interior->corners[4 * (size_t)low + n] + i];
    }
    return !interior->blockers || !al_solid_contains(interior->blockers, point);
}
