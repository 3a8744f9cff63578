/* Which texels a triangle covers. Coordinates are in texels: texel (x, y) is the square from (x, y) to
 * (x + 1, y + 1). */
#ifndef AIRLIGHT_RASTER_H
#define AIRLIGHT_RASTER_H

#include <stdbool.h>

/* Called for a texel; false stops. */
typedef bool al_raster_fn(void *user, int x, int y);

/* Every texel whose centre the triangle covers. Corners are snapped to 1/256 texel and a centre on an edge
 * belongs to one side, so that triangles beside each other, corners shared, never share a centre. The winding
 * does not matter. Coordinates within +-2^20. Answers false when the function did. */
bool al_raster_centres(const double corners[3][2], al_raster_fn *visit, void *user);

/* The part of a triangle in a texel. */
typedef struct al_raster_part {
    int x, y;
    double area;      /* texels, above 0 */
    double middle[2]; /* its centroid */
} al_raster_part;

typedef bool al_raster_part_fn(void *user, const al_raster_part *part);

/* Every texel that shares an area with the triangle. */
bool al_raster_parts(const double corners[3][2], al_raster_part_fn *visit, void *user);

#endif
