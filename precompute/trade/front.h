/* The Pareto front: points that no other point beats in error and time together. */
#ifndef AIRLIGHT_FRONT_H
#define AIRLIGHT_FRONT_H

#include <stdbool.h>
#include <stddef.h>

/* on_front[count]: no other point is at most as wrong and at most as slow, and better in one of both. Points that are equal
 * in both stand or fall together. Values that are not finite are on no front. */
void al_front(const double *error, const double *time, size_t count, bool *on_front);

/* Of the points on the front the one farthest below the line from the fastest to the most exact, in logarithms of
 * both: where more time begins to buy little. SIZE_MAX when the front is empty. */
size_t al_front_knee(const double *error, const double *time, const bool *on_front, size_t count);

#endif
