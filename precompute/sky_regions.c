/* Median cut (Debevec 2005): the region that weighs most is halved by weight across its longer side, again
 * and again. Weight is the mean of a region's shares of the map's light and of the sphere: bright places are
 * resolved, and dark ones still tell where they are hidden. What is asked along the region's one direction,
 * its centroid, is transmittance and visibility alone: its light counts as it is in the map, so that all
 * regions together are the map without any error, and nothing where all are hidden.
 *
 * Small maps are cut on a finer grid than their own. Convention of the map: docs/scene.md. */
#include "sky_regions.h"

#include <math.h>
#include <stdlib.h>

#include "airlight/formulas.h"

enum { WIDTH_LEAST = 128, HEIGHT_LEAST = 64 };

typedef struct rectangle {
    uint32_t x, y, width, height; /* on the grid */
    double weight;                /* 0: cannot be cut */
} rectangle;

typedef struct grid {
    const al_environment *map;
    uint32_t across, down; /* of the grid's cells in a pixel */
    uint32_t width, height;
    double light; /* of the whole map, sum of the channels */
} grid;

static const float *radiance_at(const grid *g, uint32_t x, uint32_t y)
{
    return g->map->pixels + ((size_t)(y / g->down) * g->map->width + x / g->across) * 3;
}

static double solid_angle(const grid *g, uint32_t y)
{
    return (cos(AL_PI * y / g->height) - cos(AL_PI * (y + 1) / g->height)) * 2 * AL_PI / g->width;
}

static double light_at(const grid *g, uint32_t x, uint32_t y)
{
    const float *p = radiance_at(g, x, y);
    return (double)p[0] + p[1] + p[2];
}

/* Of the part of a row of cells. */
static double row_weight(const grid *g, uint32_t x, uint32_t y, uint32_t width)
{
    double light = 0;
    for (uint32_t i = x; i < x + width; i++) light += light_at(g, i, y);
    return 0.5 * solid_angle(g, y) * (light / g->light + width / (4 * AL_PI));
}

static double column_weight(const grid *g, uint32_t x, uint32_t y, uint32_t height)
{
    double sum = 0;
    for (uint32_t i = y; i < y + height; i++) sum += row_weight(g, x, i, 1);
    return sum;
}

static bool is_wide(const grid *g, const rectangle *r)
{
    double middle = AL_PI * (r->y + 0.5 * r->height) / g->height;
    return 2.0 * r->width / g->width * sin(middle) > (double)r->height / g->height;
}

/* Keeps the first half, answers the other. */
static rectangle halve(const grid *g, rectangle *r)
{
    bool columns = r->height < 2 || (r->width > 1 && is_wide(g, r));
    uint32_t length = columns ? r->width : r->height, at = 0;
    double first = 0, whole = r->weight;
    while (at + 1 < length) {
        double next =
            columns ? column_weight(g, r->x + at, r->y, r->height) : row_weight(g, r->x, r->y + at, r->width);
        if (at && first + 0.5 * next > 0.5 * whole) break;
        first += next;
        at++;
    }
    rectangle other = *r;
    if (columns) {
        other.x += at;
        other.width -= at;
        r->width = at;
    } else {
        other.y += at;
        other.height -= at;
        r->height = at;
    }
    r->weight = first;
    other.weight = whole - first;
    return other;
}

static uint32_t cut(const grid *g, uint32_t limit, rectangle *list)
{
    uint32_t count = 1;
    list[0] = (rectangle){0, 0, g->width, g->height, 1};
    while (count < limit) {
        uint32_t heaviest = 0;
        for (uint32_t i = 1; i < count; i++)
            if (list[i].weight > list[heaviest].weight) heaviest = i;
        if (list[heaviest].weight <= 0) break;
        if (list[heaviest].width * (uint64_t)list[heaviest].height < 2)
            list[heaviest].weight = 0;
        else
            list[count++] = halve(g, &list[heaviest]);
    }
    return count;
}

static void add_cell(const grid *g, uint32_t x, uint32_t y, uint32_t order, al_sky_region *region)
{
    double theta = AL_PI * (y + 0.5) / g->height, phi = 2 * AL_PI * ((x + 0.5) / g->width - 0.5);
    double direction[3] = {sin(theta) * sin(phi), cos(theta), -sin(theta) * cos(phi)},
           angle = solid_angle(g, y);
    double weight = angle * (light_at(g, x, y) / g->light + 1 / (4 * AL_PI)), basis[AL_SH_MAX_COUNT];
    const float *radiance = radiance_at(g, x, y);
    al_sh_basis((int)order, direction[0], direction[1], direction[2], basis);
    for (int c = 0; c < 3; c++) {
        region->direction[c] += weight * direction[c];
        region->power[c] += angle * radiance[c];
        for (uint32_t k = 0; k < order * order; k++) region->sh[c][k] += angle * radiance[c] * basis[k];
    }
}

static void fill(const grid *g, const rectangle *r, uint32_t order, al_sky_region *region)
{
    double square = 0;
    *region = (al_sky_region){0};
    for (uint32_t y = r->y; y < r->y + r->height; y++)
        for (uint32_t x = r->x; x < r->x + r->width; x++) add_cell(g, x, y, order, region);
    for (int k = 0; k < 3; k++) square += region->direction[k] * region->direction[k];
    for (int k = 0; k < 3; k++) region->direction[k] /= sqrt(square);
}

al_status al_sky_regions_create(const al_environment *map, uint32_t order, uint32_t limit,
                                al_sky_region **regions, uint32_t *count, al_error *error)
{
    grid g = {.map = map,
              .across = (WIDTH_LEAST + map->width - 1) / map->width,
              .down = (HEIGHT_LEAST + map->height - 1) / map->height};
    rectangle *list = malloc(limit * sizeof *list);
    *regions = malloc(limit * sizeof **regions);
    *count = 0;
    if (!list || !*regions) {
        free(list);
        free(*regions);
        *regions = NULL;
        return al_fail(error, AL_IO, "out of memory for %u regions of the sky", limit);
    }
    g.width = g.across * map->width;
    g.height = g.down * map->height;
    for (uint32_t y = 0; y < g.height; y++)
        for (uint32_t x = 0; x < g.width; x++) g.light += light_at(&g, x, y) * solid_angle(&g, y);
    if (!(g.light > 0)) g.light = 1; /* black */
    *count = cut(&g, limit, list);
    for (uint32_t i = 0; i < *count; i++) fill(&g, &list[i], order, &(*regions)[i]);
    free(list);
    return AL_OK;
}
