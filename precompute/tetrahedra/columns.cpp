#include "columns.h"

#include <algorithm>
#include <cmath>

namespace
{

struct crossing {
    uint64_t column;
    double z;
    int step; /* +1 where a line upwards enters, -1 where it leaves */
};

struct field {
    double origin[2], edge;
    int64_t count[2];
};

field lay_out(const surface &from, uint32_t resolution)
{
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    for (size_t i = 0; i < from.points.size(); i++)
        if (i % 3 < 2) {
            low[i % 3] = std::min(low[i % 3], from.points[i]);
            high[i % 3] = std::max(high[i % 3], from.points[i]);
        }
    field out;
    out.edge = std::max(high[0] - low[0], high[1] - low[1]) / resolution;
    for (int i = 0; i < 2; i++) {
        out.origin[i] = low[i];
        out.count[i] = std::max<int64_t>(1, std::llround(std::ceil((high[i] - low[i]) / out.edge)));
    }
    return out;
}

/* On which side of the edge a-b a point lies, seen from above. Both triangles of an edge ask in the same
 * order and so get the same answer, ties included: no line slips between them or meets both. */
bool is_left(const double *points, uint32_t a, uint32_t b, double x, double y)
{
    const bool swapped = a > b;
    const double *p = points + size_t{3} * (swapped ? b : a), *q = points + size_t{3} * (swapped ? a : b);
    const double side = (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]);
    return swapped ? side < 0 : side >= 0;
}

void cross_triangle(const surface &from, const uint32_t *corners, const field &columns,
                    std::vector<crossing> &out)
{
    const double *p[3];
    int64_t first[2], last[2];
    for (int k = 0; k < 3; k++) p[k] = from.points.data() + size_t{3} * corners[k];
    for (int i = 0; i < 2; i++) {
        const double low = std::min({p[0][i], p[1][i], p[2][i]}),
                     high = std::max({p[0][i], p[1][i], p[2][i]});
        first[i] =
            std::max<int64_t>(0, std::llround(std::floor((low - columns.origin[i]) / columns.edge)) - 1);
        last[i] = std::min(columns.count[i] - 1, static_cast<int64_t>(std::llround(
                                                     std::ceil((high - columns.origin[i]) / columns.edge))));
    }
    const double area = (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
    for (int64_t row = first[1]; row <= last[1]; row++)
        for (int64_t column = first[0]; column <= last[0]; column++) {
            const double x = columns.origin[0] + (column + 0.5) * columns.edge;
            const double y = columns.origin[1] + (row + 0.5) * columns.edge;
            const bool left = is_left(from.points.data(), corners[0], corners[1], x, y);
            if (is_left(from.points.data(), corners[1], corners[2], x, y) != left ||
                is_left(from.points.data(), corners[2], corners[0], x, y) != left)
                continue;
            /* barycentric in the plane; a triangle seen edge-on is met in at most a tie: take its middle */
            const double b =
                area ? ((x - p[0][0]) * (p[2][1] - p[0][1]) - (y - p[0][1]) * (p[2][0] - p[0][0])) / area
                     : 1.0 / 3;
            const double c =
                area ? ((p[1][0] - p[0][0]) * (y - p[0][1]) - (p[1][1] - p[0][1]) * (x - p[0][0])) / area
                     : 1.0 / 3;
            const double z = p[0][2] + b * (p[1][2] - p[0][2]) + c * (p[2][2] - p[0][2]);
            out.push_back({static_cast<uint64_t>(row * columns.count[0] + column), z, left ? -1 : 1});
        }
}

void add_box(const field &columns, uint64_t column, double bottom, double top, surface &out)
{
    static const uint8_t corners[5][4] = {
        {1, 2, 4, 7}, {0, 1, 2, 4}, {3, 2, 1, 7}, {5, 4, 7, 1}, {6, 7, 4, 2}};
    const uint32_t first = static_cast<uint32_t>(out.points.size() / 3);
    const double x = columns.origin[0] + static_cast<double>(column % columns.count[0]) * columns.edge;
    const double y = columns.origin[1] + static_cast<double>(column / columns.count[0]) * columns.edge;
    for (int i = 0; i < 8; i++) {
        out.points.push_back(x + (i & 1 ? columns.edge : 0));
        out.points.push_back(y + (i & 2 ? columns.edge : 0));
        out.points.push_back(i & 4 ? top : bottom);
    }
    for (const auto &tetrahedron : corners)
        for (const uint8_t corner : tetrahedron) out.corners.push_back(first + corner);
}

} // namespace

surface fill_with_columns(const surface &from, uint32_t resolution)
{
    const field columns = lay_out(from, resolution);
    std::vector<crossing> crossings;
    surface out;
    for (size_t t = 0; t < from.corners.size(); t += 3)
        cross_triangle(from, &from.corners[t], columns, crossings);
    std::sort(crossings.begin(), crossings.end(), [](const crossing &a, const crossing &b) {
        if (a.column != b.column) return a.column < b.column;
        return a.z != b.z ? a.z < b.z : a.step > b.step;
    });
    int depth = 0;
    for (size_t i = 0; i < crossings.size(); i++) {
        const bool entered = i > 0 && crossings[i - 1].column == crossings[i].column;
        if (!entered) depth = 0;
        if (entered && depth > 0 && crossings[i].z > crossings[i - 1].z)
            add_box(columns, crossings[i].column, crossings[i - 1].z, crossings[i].z, out);
        depth += crossings[i].step;
    }
    return out;
}
