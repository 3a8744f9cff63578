/* Boundaries and blockers as closed surfaces: welded by exact position, then checked. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "geometry.h"
#include "weld.h"

void al_triangles_free(al_triangles *triangles)
{
    free(triangles->positions);
    free(triangles->indices);
    *triangles = (al_triangles){0};
}

/* --- the check --- */

typedef struct half_edge {
    uint32_t low, high; /* vertex numbers */
    uint32_t forward;   /* 1: runs from low to high */
} half_edge;

static int compare_edges(const void *a, const void *b)
{
    const half_edge *x = a, *y = b;
    if (x->low != y->low) return x->low < y->low ? -1 : 1;
    if (x->high != y->high) return x->high < y->high ? -1 : 1;
    return (int)x->forward - (int)y->forward;
}

typedef struct edge_census {
    uint32_t open, many, twisted; /* edges with one triangle, more than two, two of the same direction */
    half_edge first_open, first_many, first_twisted;
} edge_census;

static void count_edge(edge_census *census, const half_edge *edges, uint32_t count)
{
    if (count == 1 && !census->open++) census->first_open = edges[0];
    if (count > 2 && !census->many++) census->first_many = edges[0];
    if (count == 2 && edges[0].forward == edges[1].forward && !census->twisted++)
        census->first_twisted = edges[0];
}

static al_status census_edges(const al_triangles *triangles, edge_census *census, al_error *error)
{
    uint32_t count = triangles->triangle_count * 3;
    half_edge *edges = malloc(count * sizeof *edges);
    if (!edges) return al_fail(error, AL_IO, "out of memory for %u edges", count);
    for (uint32_t i = 0; i < count; i++) {
        uint32_t from = triangles->indices[i], to = triangles->indices[i % 3 == 2 ? i - 2 : i + 1];
        edges[i] = from < to ? (half_edge){from, to, 1} : (half_edge){to, from, 0};
    }
    qsort(edges, count, sizeof *edges, compare_edges);
    for (uint32_t first = 0, end; first < count; first = end) {
        for (end = first + 1;
             end < count && edges[end].low == edges[first].low && edges[end].high == edges[first].high;)
            end++;
        count_edge(census, edges + first, end - first);
    }
    free(edges);
    return AL_OK;
}

/* Sum of the tetrahedra between a reference point and every triangle (divergence theorem); the reference
 * is a vertex, so that a mesh far from the origin keeps its digits. */
static double signed_volume(const al_triangles *triangles)
{
    const double *origin = triangles->positions;
    double sum = 0;
    for (uint32_t t = 0; t < triangles->triangle_count; t++) {
        double e[3][3];
        for (int k = 0; k < 3; k++)
            for (int i = 0; i < 3; i++)
                e[k][i] =
                    triangles->positions[triangles->indices[t * (size_t)3 + k] * (size_t)3 + i] - origin[i];
        sum += e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) +
               e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
               e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
    }
    return sum / 6;
}

double al_triangles_volume(const al_triangles *triangles)
{
    return triangles->triangle_count ? signed_volume(triangles) : 0;
}

static al_status refuse_edge(const char *name, const al_triangles *triangles, const half_edge *edge,
                             uint32_t count, const char *what, const char *right, al_error *error)
{
    const double *a = triangles->positions + edge->low * (size_t)3,
                 *b = triangles->positions + edge->high * (size_t)3;
    return al_fail(error, AL_BAD_INPUT,
                   "%s: %u %s, the first between (%.7g, %.7g, %.7g) and (%.7g, %.7g, %.7g); %s", name, count,
                   what, a[0], a[1], a[2], b[0], b[1], b[2], right);
}

al_status al_triangles_check(const char *name, const al_triangles *triangles, al_error *error)
{
    if (!triangles->triangle_count)
        return al_fail(error, AL_BAD_INPUT, "%s: has no triangles; a closed surface is right", name);
    for (uint32_t i = 0; i < triangles->vertex_count * 3; i++)
        if (!isfinite(triangles->positions[i]))
            return al_fail(error, AL_BAD_INPUT,
                           "%s: vertex %u has the coordinate %f; finite numbers are right", name, i / 3,
                           triangles->positions[i]);
    edge_census census = {0};
    al_status status = census_edges(triangles, &census, error);
    if (status) return status;
    if (census.open)
        return refuse_edge(name, triangles, &census.first_open, census.open,
                           census.open == 1 ? "open edge" : "open edges",
                           "a closed (watertight) surface is right", error);
    if (census.many)
        return refuse_edge(name, triangles, &census.first_many, census.many,
                           census.many == 1 ? "edge with more than two triangles"
                                            : "edges with more than two triangles",
                           "two triangles at every edge are right", error);
    if (census.twisted)
        return refuse_edge(name, triangles, &census.first_twisted, census.twisted,
                           census.twisted == 1 ? "edge whose two triangles face opposite sides"
                                               : "edges whose two triangles face opposite sides",
                           "triangles counter-clockwise seen from outside are right", error);
    double volume = signed_volume(triangles);
    if (!(volume > 0))
        return al_fail(error, AL_BAD_INPUT,
                       "%s: encloses %.4g m3: it is inside out or flat; triangles "
                       "counter-clockwise seen from outside are right",
                       name, volume);
    return AL_OK;
}

/* --- out of the scene --- */

static uint32_t drop_collapsed(uint32_t *indices, uint32_t triangle_count)
{
    uint32_t kept = 0;
    for (uint32_t t = 0; t < triangle_count; t++) {
        uint32_t *from = indices + t * (size_t)3;
        if (from[0] == from[1] || from[1] == from[2] || from[2] == from[0]) continue;
        memmove(indices + kept++ * (size_t)3, from, 3 * sizeof *from);
    }
    return kept;
}

static bool is_wanted(const al_instance *instance, uint32_t role, uint32_t translucent)
{
    return instance->role == role && instance->translucent == translucent;
}

/* Points that are the same become one; triangles that two such points collapse to a line go. */
static al_status weld_triangles(al_triangles *triangles, al_error *error)
{
    uint32_t count = triangles->vertex_count, distinct;
    uint32_t *map = malloc((count + (size_t)1) * sizeof *map);
    if (!map) return al_fail(error, AL_IO, "out of memory for %u vertices", count);
    for (size_t i = 0; i < count * (size_t)3; i++) triangles->positions[i] += 0.0;
    al_status status = al_weld(triangles->positions, 3 * sizeof(double), count, map, &distinct, error);
    for (uint32_t i = 0; i < count && !status; i++)
        memmove(triangles->positions + map[i] * (size_t)3, triangles->positions + i * (size_t)3,
                3 * sizeof(double));
    for (uint32_t i = 0; i < triangles->triangle_count * 3 && !status; i++)
        triangles->indices[i] = map[triangles->indices[i]];
    triangles->vertex_count = status ? 0 : distinct;
    triangles->triangle_count = status ? 0 : drop_collapsed(triangles->indices, triangles->triangle_count);
    free(map);
    return status;
}

static void append_mesh(const al_mesh *mesh, al_triangles *out)
{
    for (size_t i = 0; i < mesh->vertex_count * (size_t)3; i++)
        out->positions[out->vertex_count * (size_t)3 + i] = mesh->positions[i];
    for (uint32_t i = 0; i < mesh->index_count; i++)
        out->indices[out->triangle_count * (size_t)3 + i] = out->vertex_count + mesh->indices[i];
    out->vertex_count += mesh->vertex_count;
    out->triangle_count += mesh->index_count / 3;
}

/* A blocker's vertices are in its boundary's object space already: import.c. */
static al_status collect(const al_scene *scene, uint32_t role, uint32_t translucent, al_triangles *out,
                         al_error *error)
{
    size_t vertex_count = 0, index_count = 0;
    *out = (al_triangles){0};
    for (uint32_t i = 0; i < scene->instance_count; i++) {
        if (!is_wanted(&scene->instances[i], role, translucent)) continue;
        vertex_count += scene->meshes[scene->instances[i].mesh].vertex_count;
        index_count += scene->meshes[scene->instances[i].mesh].index_count;
    }
    if (vertex_count > UINT32_MAX / 4 || index_count > UINT32_MAX / 4)
        return al_fail(error, AL_BAD_INPUT, "%s: has more than %u vertices or corners",
                       scene->translucents[translucent].name, UINT32_MAX / 4);
    out->positions = malloc((vertex_count + 1) * 3 * sizeof *out->positions);
    out->indices = malloc((index_count + 1) * sizeof *out->indices);
    if (!out->positions || !out->indices) {
        al_triangles_free(out);
        return al_fail(error, AL_IO, "out of memory for %zu triangles", index_count / 3);
    }
    for (uint32_t i = 0; i < scene->instance_count; i++)
        if (is_wanted(&scene->instances[i], role, translucent))
            append_mesh(&scene->meshes[scene->instances[i].mesh], out);
    al_status status = weld_triangles(out, error);
    if (status) al_triangles_free(out);
    return status;
}

al_status al_import_boundary(const al_import *import, uint32_t translucent, al_triangles *boundary,
                             al_error *error)
{
    return collect(&import->scene, AL_ROLE_TRANSLUCENT, translucent, boundary, error);
}

al_status al_import_blockers(const al_import *import, uint32_t translucent, al_triangles *blockers,
                             al_error *error)
{
    return collect(&import->scene, AL_ROLE_BLOCKER, translucent, blockers, error);
}

al_status al_triangles_from_mesh(const al_mesh *mesh, al_triangles *triangles, al_error *error)
{
    *triangles = (al_triangles){.positions = malloc((mesh->vertex_count + (size_t)1) * 3 * sizeof(double)),
                                .indices = malloc((mesh->index_count + (size_t)1) * sizeof(uint32_t))};
    if (!triangles->positions || !triangles->indices) {
        al_triangles_free(triangles);
        return al_fail(error, AL_IO, "out of memory for %u triangles", mesh->index_count / 3);
    }
    append_mesh(mesh, triangles);
    al_status status = weld_triangles(triangles, error);
    if (status) al_triangles_free(triangles);
    return status;
}
