#include "edges.h"

#include <stdlib.h>

#include "weld.h"

typedef struct side {
    uint32_t low, high, side; /* the edge's points, ascending */
} side;

static int by_edge(const void *a, const void *b)
{
    const side *l = a, *r = b;
    if (l->low != r->low) return l->low < r->low ? -1 : 1;
    if (l->high != r->high) return l->high < r->high ? -1 : 1;
    return (l->side > r->side) - (l->side < r->side);
}

static void group_sides(const side *sorted, uint32_t count, al_edges *edges)
{
    for (uint32_t i = 0; i < count; i++) {
        bool first = i == 0 || sorted[i].low != sorted[i - 1].low || sorted[i].high != sorted[i - 1].high;
        if (first) edges->starts[edges->group_count++] = i;
        edges->sides[i] = sorted[i].side;
        edges->group[sorted[i].side] = edges->group_count - 1;
    }
    edges->starts[edges->group_count] = count;
}

al_status al_edges_make(const al_mesh *mesh, al_edges *edges, al_error *error)
{
    uint32_t count = mesh->index_count, point_count;
    *edges = (al_edges){.starts = malloc((count + (size_t)1) * sizeof(uint32_t)),
                        .sides = malloc((count + (size_t)1) * sizeof(uint32_t)),
                        .group = malloc((count + (size_t)1) * sizeof(uint32_t)),
                        .points = malloc((mesh->vertex_count + (size_t)1) * sizeof(uint32_t))};
    side *sorted = malloc((count + (size_t)1) * sizeof *sorted);
    al_status status = AL_OK;
    if (!edges->starts || !edges->sides || !edges->group || !edges->points || !sorted)
        status = al_fail(error, AL_IO, "mesh \"%s\": out of memory for %u edges", mesh->name, count);
    if (status == AL_OK)
        status = al_weld(mesh->positions, 3 * sizeof(float), mesh->vertex_count, edges->points, &point_count,
                         error);
    for (uint32_t i = 0; status == AL_OK && i < count; i++) {
        uint32_t a = edges->points[mesh->indices[i]],
                 b = edges->points[mesh->indices[i - i % 3 + (i + 1) % 3]];
        sorted[i] = (side){a < b ? a : b, a < b ? b : a, i};
    }
    if (status == AL_OK) {
        qsort(sorted, count, sizeof *sorted, by_edge);
        group_sides(sorted, count, edges);
    }
    free(sorted);
    if (status != AL_OK) al_edges_free(edges);
    return status;
}

void al_edges_free(al_edges *edges)
{
    free(edges->starts);
    free(edges->sides);
    free(edges->group);
    free(edges->points);
    *edges = (al_edges){0};
}
