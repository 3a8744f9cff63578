/* A chart grows from its largest triangle over shared edges, over triangles whose normals lie within 45
 * degrees of that first one, which is the axis it is projected along. That keeps lengths within 1/cos 45
 * degrees, and the projection can only overlap where the surface winds over itself: there the texels'
 * centres, which the chart keeps, would be covered twice, and the triangle begins another chart. In the end a
 * chart is scaled to the area of its triangles in space.
 *
 * Small charts waste their padding. Their triangles move to a chart beside them when they lie within 75
 * degrees of its axis. */
#include "chart.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/formulas.h"
#include "geometry.h"
#include "raster.h"

#define COS_GROWN 0.70710678118654752
#define COS_MERGED 0.25881904510252076

enum { SMALL_CHART_TEXELS = 8, MERGE_PASSES = 8 };

/* --- texels' centres that are taken, of all charts --- */

typedef struct cell_set {
    uint64_t *cells; /* 0: free */
    size_t slots, used;
    uint64_t chart;
    bool taken, full; /* what the last triangle met */
} cell_set;

/* 24 bits of chart, 20 each of x and y. */
static uint64_t cell_of(uint64_t chart, int x, int y)
{
    return (chart + 1) << 40 | (uint64_t)(x & 0xfffff) << 20 | (uint64_t)(y & 0xfffff);
}

static size_t slot_of(const cell_set *set, uint64_t cell)
{
    uint64_t mixed = cell * 0x9e3779b97f4a7c15u;
    size_t slot = (size_t)(mixed ^ mixed >> 32) & (set->slots - 1);
    while (set->cells[slot] && set->cells[slot] != cell) slot = (slot + 1) & (set->slots - 1);
    return slot;
}

static bool grow_set(cell_set *set)
{
    cell_set grown = *set;
    grown.slots = set->slots ? 2 * set->slots : 1024;
    grown.cells = calloc(grown.slots, sizeof *grown.cells);
    if (!grown.cells) return false;
    for (size_t i = 0; i < set->slots; i++)
        if (set->cells[i]) grown.cells[slot_of(&grown, set->cells[i])] = set->cells[i];
    free(set->cells);
    *set = grown;
    return true;
}

static bool is_free(void *user, int x, int y)
{
    cell_set *set = user;
    set->taken = set->slots && set->cells[slot_of(set, cell_of(set->chart, x, y))] != 0;
    return !set->taken;
}

static bool take(void *user, int x, int y)
{
    cell_set *set = user;
    if (2 * (set->used + 1) > set->slots && !grow_set(set)) return set->full = true, false;
    uint64_t cell = cell_of(set->chart, x, y);
    size_t slot = slot_of(set, cell);
    set->used += set->cells[slot] == 0;
    set->cells[slot] = cell;
    return true;
}

/* --- growing --- */

typedef struct frame { /* of a chart: axes per texel, and the point it is projected about */
    double axis[3], u[3], v[3], origin[3];
} frame;

typedef struct cutter {
    const al_mesh *mesh;
    const al_edges *edges;
    al_charts *charts;
    uint32_t triangle_count;
    double texel_m;
    double *points;      /* [vertex_count][3] in world space */
    double *normals;     /* [triangle_count][3] unit; 0 for one without area */
    double *areas;       /* [triangle_count] m2 */
    frame *frames;       /* [triangle_count] of charts */
    double *chart_areas; /* [triangle_count] of charts, m2 */
    uint32_t *queue;     /* [triangle_count] */
    cell_set cells;
} cutter;

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static const double *corner(const cutter *c, uint32_t triangle, uint32_t k)
{
    return c->points + 3 * (size_t)c->mesh->indices[3 * (size_t)triangle + k % 3];
}

static void measure(cutter *c, uint32_t triangle)
{
    const double *p0 = corner(c, triangle, 0), *p1 = corner(c, triangle, 1), *p2 = corner(c, triangle, 2);
    double a[3], b[3], *n = c->normals + 3 * (size_t)triangle;
    for (int k = 0; k < 3; k++) {
        a[k] = p1[k] - p0[k];
        b[k] = p2[k] - p0[k];
    }
    for (int k = 0; k < 3; k++) n[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
    double length = sqrt(dot(n, n)), longest = fmax(dot(a, a), dot(b, b));
    /* What rounding leaves of a needle says nothing of its direction. */
    if (!(length > 1e-7 * longest)) length = 0;
    for (int k = 0; k < 3; k++) n[k] = length > 0 ? n[k] / length : 0;
    c->areas[triangle] = length / 2;
}

static bool has_area(const cutter *c, uint32_t triangle)
{
    return c->areas[triangle] > 0;
}

/* The shortest edge of the first triangle lies along u: of walls, which are right-angled, it is a side. */
static void make_frame(const cutter *c, uint32_t triangle, frame *f)
{
    double shortest = INFINITY, side[3] = {0};
    memcpy(f->axis, c->normals + 3 * (size_t)triangle, sizeof f->axis);
    memcpy(f->origin, corner(c, triangle, 0), sizeof f->origin);
    for (uint32_t k = 0; k < 3; k++) {
        const double *a = corner(c, triangle, k), *b = corner(c, triangle, k + 1);
        double d[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, square = dot(d, d);
        if (square >= shortest) continue;
        shortest = square;
        memcpy(side, d, sizeof side);
    }
    double length = sqrt(shortest);
    for (int k = 0; k < 3; k++) f->u[k] = side[k] / length / c->texel_m;
    for (int k = 0; k < 3; k++)
        f->v[k] = f->axis[(k + 1) % 3] * f->u[(k + 2) % 3] - f->axis[(k + 2) % 3] * f->u[(k + 1) % 3];
}

static void project(const cutter *c, const frame *f, uint32_t triangle, double uv[3][2])
{
    for (uint32_t k = 0; k < 3; k++) {
        const double *p = corner(c, triangle, k);
        double d[3] = {p[0] - f->origin[0], p[1] - f->origin[1], p[2] - f->origin[2]};
        uv[k][0] = dot(d, f->u);
        uv[k][1] = dot(d, f->v);
    }
}

/* Takes the triangle into the chart when it faces the axis and covers no centre twice. */
static bool accept(cutter *c, uint32_t triangle, uint32_t chart, double least_cosine)
{
    double uv[3][2];
    const frame *f = &c->frames[chart];
    if (has_area(c, triangle)) {
        if (dot(c->normals + 3 * (size_t)triangle, f->axis) < least_cosine) return false;
        project(c, f, triangle, uv);
        c->cells.chart = chart;
        if (!al_raster_centres((const double(*)[2])uv, is_free, &c->cells)) return false;
        al_raster_centres((const double(*)[2])uv, take, &c->cells);
    }
    c->charts->chart[triangle] = chart;
    c->chart_areas[chart] += c->areas[triangle];
    return true;
}

static void grow(cutter *c, uint32_t first)
{
    uint32_t chart = c->charts->count++, head = 0, tail = 0;
    make_frame(c, first, &c->frames[chart]);
    accept(c, first, chart, -1);
    c->queue[tail++] = first;
    while (head < tail) {
        uint32_t triangle = c->queue[head++];
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t group = c->edges->group[3 * (size_t)triangle + k];
            for (uint32_t i = c->edges->starts[group]; i < c->edges->starts[group + 1]; i++) {
                uint32_t other = c->edges->sides[i] / 3;
                if (c->charts->chart[other] == AL_NO_CHART && accept(c, other, chart, COS_GROWN))
                    c->queue[tail++] = other;
            }
        }
    }
}

typedef struct seed {
    double area;
    uint32_t triangle;
} seed;

static int larger_first(const void *a, const void *b)
{
    const seed *l = a, *r = b;
    if (l->area != r->area) return l->area > r->area ? -1 : 1;
    return (l->triangle > r->triangle) - (l->triangle < r->triangle);
}

static bool grow_all(cutter *c)
{
    seed *seeds = malloc((c->triangle_count + (size_t)1) * sizeof *seeds);
    if (!seeds) return false;
    for (uint32_t t = 0; t < c->triangle_count; t++) seeds[t] = (seed){c->areas[t], t};
    qsort(seeds, c->triangle_count, sizeof *seeds, larger_first);
    for (uint32_t i = 0; i < c->triangle_count && seeds[i].area > 0; i++)
        if (c->charts->chart[seeds[i].triangle] == AL_NO_CHART) grow(c, seeds[i].triangle);
    free(seeds);
    return !c->cells.full;
}

/* --- merging --- */

static bool is_small(const cutter *c, uint32_t chart)
{
    return c->chart_areas[chart] < SMALL_CHART_TEXELS * c->texel_m * c->texel_m;
}

/* Moves one triangle to a chart beside it that is not small, if there is one. */
static bool move_beside(cutter *c, uint32_t triangle)
{
    uint32_t own = c->charts->chart[triangle];
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t group = c->edges->group[3 * (size_t)triangle + k];
        for (uint32_t i = c->edges->starts[group]; i < c->edges->starts[group + 1]; i++) {
            uint32_t other = c->charts->chart[c->edges->sides[i] / 3];
            if (other == own || other == AL_NO_CHART || is_small(c, other)) continue;
            if (accept(c, triangle, other, COS_MERGED)) return true;
        }
    }
    return false;
}

static bool merge_small(cutter *c)
{
    bool moved = true;
    for (int pass = 0; pass < MERGE_PASSES && moved; pass++) {
        moved = false;
        for (uint32_t t = 0; t < c->triangle_count; t++) {
            uint32_t own = c->charts->chart[t];
            if (own == AL_NO_CHART || !is_small(c, own) || !move_beside(c, t)) continue;
            c->chart_areas[own] -= c->areas[t];
            moved = true;
        }
    }
    return !c->cells.full;
}

/* Numbers charts anew, each what hangs together over edges: those that lost triangles may have come apart, or
 * be empty. */
static bool renumber(cutter *c)
{
    uint32_t *old = malloc((c->triangle_count + (size_t)1) * sizeof *old), next = 0;
    frame *frames = malloc((c->triangle_count + (size_t)1) * sizeof *frames);
    if (!old || !frames) {
        free(old);
        free(frames);
        return false;
    }
    memcpy(old, c->charts->chart, c->triangle_count * sizeof *old);
    memset(c->charts->chart, 0xff, c->triangle_count * sizeof *old);
    for (uint32_t first = 0; first < c->triangle_count; first++) {
        uint32_t head = 0, tail = 0;
        if (old[first] == AL_NO_CHART || c->charts->chart[first] != AL_NO_CHART) continue;
        frames[next] = c->frames[old[first]];
        c->charts->chart[first] = next;
        c->queue[tail++] = first;
        while (head < tail) {
            uint32_t triangle = c->queue[head++];
            for (uint32_t k = 0; k < 3; k++) {
                uint32_t group = c->edges->group[3 * (size_t)triangle + k];
                for (uint32_t i = c->edges->starts[group]; i < c->edges->starts[group + 1]; i++) {
                    uint32_t other = c->edges->sides[i] / 3;
                    if (old[other] != old[first] || c->charts->chart[other] != AL_NO_CHART) continue;
                    c->charts->chart[other] = next;
                    c->queue[tail++] = other;
                }
            }
        }
        next++;
    }
    c->charts->count = next;
    memcpy(c->frames, frames, next * sizeof *frames);
    free(old);
    free(frames);
    return true;
}

/* --- placing --- */

/* A chart's box in texels, turned by i * 90 / TURNS degrees; turn 0 is how it was grown. */
enum { TURNS = 16 };

typedef struct extent {
    double low[TURNS][2], high[TURNS][2], area, projected;
    double scale, direction[2]; /* cosine and sine of the turn that is used */
    int turn;
    bool overlaps;
} extent;

static void direction_of(int turn, double direction[2])
{
    direction[0] = cos(turn * (AL_PI / 2) / TURNS);
    direction[1] = sin(turn * (AL_PI / 2) / TURNS);
}

static void rotate(const double direction[2], const double from[2], double to[2])
{
    to[0] = direction[0] * from[0] - direction[1] * from[1];
    to[1] = direction[1] * from[0] + direction[0] * from[1];
}

static void clear_extents(const cutter *c, extent *extents)
{
    for (uint32_t i = 0; i < c->charts->count; i++) {
        extents[i] = (extent){.scale = 1, .direction = {1, 0}};
        for (int turn = 0; turn < TURNS; turn++)
            for (int k = 0; k < 2; k++) {
                extents[i].low[turn][k] = INFINITY;
                extents[i].high[turn][k] = -INFINITY;
            }
    }
}

static void measure_extents(const cutter *c, extent *extents)
{
    double directions[TURNS][2];
    clear_extents(c, extents);
    for (int turn = 0; turn < TURNS; turn++) direction_of(turn, directions[turn]);
    for (uint32_t t = 0; t < c->triangle_count; t++) {
        uint32_t chart = c->charts->chart[t];
        if (chart == AL_NO_CHART) continue;
        double(*uv)[2] = c->charts->uv + 3 * (size_t)t;
        extent *e = &extents[chart];
        project(c, &c->frames[chart], t, uv);
        for (int i = 0; i < 3 * TURNS; i++) {
            double turned[2];
            rotate(directions[i / 3], uv[i % 3], turned);
            for (int k = 0; k < 2; k++) {
                e->low[i / 3][k] = fmin(e->low[i / 3][k], turned[k]);
                e->high[i / 3][k] = fmax(e->high[i / 3][k], turned[k]);
            }
        }
        e->area += c->areas[t] / (c->texel_m * c->texel_m);
        e->projected += fabs((uv[1][0] - uv[0][0]) * (uv[2][1] - uv[0][1]) -
                             (uv[1][1] - uv[0][1]) * (uv[2][0] - uv[0][0])) /
                        2;
    }
}

/* The turn with the smallest box; as grown unless another saves 2 %. */
static void choose_turn(extent *e)
{
    double best = INFINITY;
    for (int turn = 0; turn < TURNS; turn++) {
        double area = (e->high[turn][0] - e->low[turn][0]) * (e->high[turn][1] - e->low[turn][1]);
        if (!(area < (turn ? 0.98 * best : best))) continue;
        best = area;
        e->turn = turn;
    }
    direction_of(e->turn, e->direction);
}

static void place_corners(const cutter *c, const extent *extents, uint32_t t, double uv[3][2])
{
    const extent *e = &extents[c->charts->chart[t]];
    for (int k = 0; k < 3; k++) {
        rotate(e->direction, c->charts->uv[3 * (size_t)t + (size_t)k], uv[k]);
        for (int i = 0; i < 2; i++) uv[k][i] = (uv[k][i] - e->low[e->turn][i]) * e->scale;
    }
}

/* Charts turned to their smallest box and scaled to their area; those that overlap so stay as they were
 * grown, on the grid that has been checked. */
static bool place_all(cutter *c, extent *extents)
{
    double uv[3][2];
    cell_set fresh = {0};
    for (uint32_t i = 0; i < c->charts->count; i++) {
        choose_turn(&extents[i]);
        extents[i].scale = extents[i].projected > 0 ? sqrt(extents[i].area / extents[i].projected) : 1;
    }
    for (uint32_t t = 0; t < c->triangle_count; t++) {
        if (c->charts->chart[t] == AL_NO_CHART || !has_area(c, t)) continue;
        extent *e = &extents[c->charts->chart[t]];
        place_corners(c, extents, t, uv);
        fresh.chart = c->charts->chart[t];
        e->overlaps = e->overlaps || !al_raster_centres((const double(*)[2])uv, is_free, &fresh);
        al_raster_centres((const double(*)[2])uv, take, &fresh);
    }
    free(fresh.cells);
    for (uint32_t i = 0; i < c->charts->count; i++) {
        extent *e = &extents[i];
        if (e->overlaps) {
            e->scale = 1;
            e->turn = 0;
            direction_of(0, e->direction);
            for (int k = 0; k < 2; k++) e->low[0][k] = floor(e->low[0][k]);
        }
        for (int k = 0; k < 2; k++)
            c->charts->size[i][k] = (e->high[e->turn][k] - e->low[e->turn][k]) * e->scale;
    }
    for (uint32_t t = 0; t < c->triangle_count; t++) {
        if (c->charts->chart[t] == AL_NO_CHART) continue;
        place_corners(c, extents, t, uv);
        memcpy(c->charts->uv + 3 * (size_t)t, uv, sizeof uv);
    }
    return !fresh.full;
}

static bool cut(cutter *c)
{
    for (uint32_t t = 0; t < c->triangle_count; t++) measure(c, t);
    if (!grow_all(c) || !merge_small(c) || !renumber(c)) return false;
    c->charts->size = calloc(c->charts->count + (size_t)1, sizeof *c->charts->size);
    extent *extents = malloc((c->charts->count + (size_t)1) * sizeof *extents);
    bool good = c->charts->size && extents;
    if (good) {
        measure_extents(c, extents);
        good = place_all(c, extents);
    }
    free(extents);
    return good;
}

al_status al_charts_make(const al_mesh *mesh, const al_edges *edges, const double to_world[16],
                         double texel_m, al_charts *charts, al_error *error)
{
    uint32_t count = mesh->index_count / 3;
    size_t room = count + (size_t)1;
    *charts = (al_charts){.chart = malloc(room * sizeof(uint32_t)), .uv = calloc(room, sizeof(double[3][2]))};
    cutter c = {.mesh = mesh,
                .edges = edges,
                .charts = charts,
                .triangle_count = count,
                .texel_m = texel_m,
                .points = malloc((mesh->vertex_count + (size_t)1) * sizeof(double[3])),
                .normals = malloc(room * sizeof(double[3])),
                .areas = malloc(room * sizeof(double)),
                .frames = malloc(room * sizeof(frame)),
                .chart_areas = calloc(room, sizeof(double)),
                .queue = malloc(room * sizeof(uint32_t))};
    bool good = charts->chart && charts->uv && c.points && c.normals && c.areas && c.frames &&
                c.chart_areas && c.queue;
    if (good) {
        memset(charts->chart, 0xff, room * sizeof(uint32_t));
        for (size_t v = 0; v < mesh->vertex_count; v++) {
            const float *p = mesh->positions + 3 * v;
            al_matrix_point(to_world, (double[3]){p[0], p[1], p[2]}, c.points + 3 * v);
        }
        good = cut(&c);
    }
    free(c.points);
    free(c.normals);
    free(c.areas);
    free(c.frames);
    free(c.chart_areas);
    free(c.queue);
    free(c.cells.cells);
    if (good) return AL_OK;
    al_charts_free(charts);
    return al_fail(error, AL_IO, "mesh \"%s\": out of memory for the charts of %u triangles", mesh->name,
                   count);
}

void al_charts_free(al_charts *charts)
{
    free(charts->chart);
    free(charts->uv);
    free(charts->size);
    *charts = (al_charts){0};
}
