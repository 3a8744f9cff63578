#include "raster.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

enum { SUBTEXELS = 256 };

/* Twice the signed area of (a, b, p): positive when p lies left of a to b. */
static int64_t edge(const int64_t a[2], const int64_t b[2], const int64_t p[2])
{
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
}

/* Of a centre exactly on an edge, the side where the edge goes up, or left when it is level, has it: for the
 * neighbour the edge runs the other way. */
static int64_t tie(const int64_t a[2], const int64_t b[2])
{
    return b[1] > a[1] || (b[1] == a[1] && b[0] < a[0]) ? 0 : -1;
}

static int low_texel(const int64_t p[3][2], int axis)
{
    int64_t low = p[0][axis];
    for (int i = 1; i < 3; i++) low = p[i][axis] < low ? p[i][axis] : low;
    return (int)floor((double)low / SUBTEXELS);
}

static int high_texel(const int64_t p[3][2], int axis)
{
    int64_t high = p[0][axis];
    for (int i = 1; i < 3; i++) high = p[i][axis] > high ? p[i][axis] : high;
    return (int)floor((double)high / SUBTEXELS);
}

bool al_raster_centres(const double corners[3][2], al_raster_fn *visit, void *user)
{
    int64_t p[3][2];
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 2; k++) p[i][k] = llrint(corners[i][k] * SUBTEXELS);
    int64_t area = edge(p[0], p[1], p[2]);
    if (area == 0) return true;
    if (area < 0) {
        int64_t kept[2];
        memcpy(kept, p[1], sizeof kept);
        memcpy(p[1], p[2], sizeof kept);
        memcpy(p[2], kept, sizeof kept);
    }
    for (int y = low_texel(p, 1); y <= high_texel(p, 1); y++)
        for (int x = low_texel(p, 0); x <= high_texel(p, 0); x++) {
            const int64_t centre[2] = {(int64_t)x * SUBTEXELS + SUBTEXELS / 2,
                                       (int64_t)y * SUBTEXELS + SUBTEXELS / 2};
            bool inside = true;
            for (int i = 0; i < 3 && inside; i++)
                inside = edge(p[i], p[(i + 1) % 3], centre) + tie(p[i], p[(i + 1) % 3]) >= 0;
            if (inside && !visit(user, x, y)) return false;
        }
    return true;
}

/* --- parts --- */

enum { POLYGON_LIMIT = 8 }; /* a triangle cut by four lines has at most seven corners */

typedef struct polygon {
    double points[POLYGON_LIMIT][2];
    int count;
} polygon;

/* Keeps what lies on one side of a line of constant x or y (Sutherland and Hodgman 1974). */
static polygon cut(const polygon *from, int axis, double limit, double sign)
{
    polygon kept = {.count = 0};
    for (int i = 0; i < from->count; i++) {
        const double *a = from->points[i], *b = from->points[(i + 1) % from->count];
        double da = sign * (a[axis] - limit), db = sign * (b[axis] - limit);
        if (da >= 0) memcpy(kept.points[kept.count++], a, sizeof(double[2]));
        if ((da > 0 && db < 0) || (da < 0 && db > 0)) {
            double t = da / (da - db);
            for (int k = 0; k < 2; k++) kept.points[kept.count][k] = a[k] + t * (b[k] - a[k]);
            kept.points[kept.count++][axis] = limit;
        }
    }
    return kept;
}

/* Area and centroid as sums over the fan of triangles about the first corner. */
static bool measure(const polygon *p, al_raster_part *part)
{
    double sum[2] = {0}, area = 0;
    for (int i = 1; i + 1 < p->count; i++) {
        const double *o = p->points[0], *a = p->points[i], *b = p->points[i + 1];
        double twice = fabs((a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]));
        for (int k = 0; k < 2; k++) sum[k] += twice / 2 * (o[k] + a[k] + b[k]) / 3;
        area += twice / 2;
    }
    part->area = area;
    for (int k = 0; k < 2; k++) part->middle[k] = sum[k] / area;
    return area > 1e-12;
}

bool al_raster_parts(const double corners[3][2], al_raster_part_fn *visit, void *user)
{
    polygon whole = {.count = 3};
    double low = INFINITY, high = -INFINITY;
    memcpy(whole.points, corners, sizeof(double[3][2]));
    for (int i = 0; i < 3; i++) {
        low = fmin(low, corners[i][1]);
        high = fmax(high, corners[i][1]);
    }
    for (int y = (int)floor(low); y < high; y++) {
        polygon above = cut(&whole, 1, y, 1), row = cut(&above, 1, y + 1, -1);
        double left = INFINITY, right = -INFINITY;
        for (int i = 0; i < row.count; i++) {
            left = fmin(left, row.points[i][0]);
            right = fmax(right, row.points[i][0]);
        }
        for (int x = row.count ? (int)floor(left) : 0; row.count && x < right; x++) {
            al_raster_part part = {.x = x, .y = y};
            polygon after = cut(&row, 0, x, 1), cell = cut(&after, 0, x + 1, -1);
            if (cell.count > 2 && measure(&cell, &part) && !visit(user, &part)) return false;
        }
    }
    return true;
}
