/* Filling a closed surface that cuts itself, where no tetrahedra can keep its triangles. */
#ifndef AIRLIGHT_COLUMNS_H
#define AIRLIGHT_COLUMNS_H

#include <cstdint>
#include <vector>

struct surface {
    std::vector<double> points;    /* [..][3] */
    std::vector<uint32_t> corners; /* [..][3] */
};

/* Columns along z, `resolution` of them along the longer side of the surface's box: each is filled between the
 * heights where its middle line enters and leaves the surface (winding number of 1 or more), five tetrahedra
 * for each stretch. What sticks out or is missing at the sides is within half a column. */
surface fill_with_columns(const surface &from, uint32_t resolution);

#endif
