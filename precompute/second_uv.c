#include "second_uv.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "raster.h"
#include "weld.h"

/* --- parts --- */

static uint32_t find_root(uint32_t *parents, uint32_t i)
{
    while (parents[i] != i) i = parents[i] = parents[parents[i]];
    return i;
}

/* Vertices are the same when place and uv1 are. */
static al_status weld_vertices(const al_mesh *mesh, uint32_t *map, uint32_t *count, al_error *error)
{
    float(*records)[5] = malloc((mesh->vertex_count + (size_t)1) * sizeof *records);
    if (!records) return al_fail(error, AL_IO, "mesh \"%s\": out of memory", mesh->name);
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        for (int k = 0; k < 3; k++) records[i][k] = mesh->positions[3 * i + k] + 0.0f;
        for (int k = 0; k < 2; k++) records[i][3 + k] = mesh->uv1[2 * i + k] + 0.0f;
    }
    al_status status = al_weld(records, sizeof *records, mesh->vertex_count, map, count, error);
    free(records);
    return status;
}

al_status al_uv_parts(const al_mesh *mesh, uint32_t *parts, uint32_t *count, al_error *error)
{
    uint32_t *map = malloc((mesh->vertex_count + (size_t)1) * sizeof *map);
    uint32_t *parents = malloc((mesh->vertex_count + (size_t)1) * sizeof *parents), distinct;
    al_status status = map && parents ? weld_vertices(mesh, map, &distinct, error)
                                      : al_fail(error, AL_IO, "mesh \"%s\": out of memory", mesh->name);
    *count = 0;
    if (status != AL_OK) goto cleanup;
    for (uint32_t i = 0; i < distinct; i++) parents[i] = i;
    for (uint32_t i = 0; i < mesh->index_count; i++)
        parents[find_root(parents, map[mesh->indices[i]])] =
            find_root(parents, map[mesh->indices[i - i % 3]]);
    /* Roots become numbers in order of their first triangle. */
    uint32_t *numbers = malloc((distinct + (size_t)1) * sizeof *numbers);
    if (!numbers) {
        status = al_fail(error, AL_IO, "mesh \"%s\": out of memory", mesh->name);
        goto cleanup;
    }
    memset(numbers, 0xff, distinct * sizeof *numbers);
    for (uint32_t t = 0; t < mesh->index_count / 3; t++) {
        uint32_t root = find_root(parents, map[mesh->indices[3 * (size_t)t]]);
        if (numbers[root] == UINT32_MAX) numbers[root] = (*count)++;
        parts[t] = numbers[root];
    }
    free(numbers);
cleanup:
    free(map);
    free(parents);
    return status;
}

/* --- check --- */

/* Texels: what rounding leaves of a texel beside a straight border, or a triangle too small to be missed. */
#define SLIVER 1e-3

typedef struct checker {
    const al_mesh *mesh;
    uint32_t width, height;
    uint32_t *owners; /* [height][width] 1 + triangle that covers the centre, then 1 + part that touches */
    uint32_t current;
    int x, y;       /* where something was wrong, */
    uint32_t other; /* and with whom */
} checker;

static uint32_t *owner(checker *c, int x, int y)
{
    int column = x < 0 ? 0 : x >= (int)c->width ? (int)c->width - 1 : x;
    int row = y < 0 ? 0 : y >= (int)c->height ? (int)c->height - 1 : y;
    return &c->owners[(size_t)row * c->width + (size_t)column];
}

static bool cover(void *user, int x, int y)
{
    checker *c = user;
    uint32_t *cell = owner(c, x, y);
    if (*cell) {
        c->other = *cell - 1;
        return false;
    }
    *cell = c->current + 1;
    return true;
}

static bool touch(void *user, const al_raster_part *part)
{
    checker *c = user;
    if (part->area < SLIVER) return true;
    for (int y = part->y - 1; y <= part->y + 1; y++)
        for (int x = part->x - 1; x <= part->x + 1; x++) {
            uint32_t there =
                x < 0 || y < 0 || x >= (int)c->width || y >= (int)c->height ? 0 : *owner(c, x, y);
            if (!there || there == c->current + 1) continue;
            c->x = part->x;
            c->y = part->y;
            return false;
        }
    *owner(c, part->x, part->y) = c->current + 1;
    return true;
}

static void corners_of(const checker *c, uint32_t triangle, double uv[3][2])
{
    for (size_t k = 0; k < 3; k++) {
        const float *from = c->mesh->uv1 + 2 * (size_t)c->mesh->indices[3 * (size_t)triangle + k];
        uv[k][0] = (double)from[0] * c->width;
        uv[k][1] = (double)from[1] * c->height;
    }
}

static double area_in_space(const al_mesh *mesh, uint32_t triangle)
{
    const float *p[3];
    double a[3], b[3], square = 0;
    for (size_t k = 0; k < 3; k++)
        p[k] = mesh->positions + 3 * (size_t)mesh->indices[3 * (size_t)triangle + k];
    for (int k = 0; k < 3; k++) {
        a[k] = (double)p[1][k] - p[0][k];
        b[k] = (double)p[2][k] - p[0][k];
    }
    for (int k = 0; k < 3; k++) {
        double n = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
        square += n * n;
    }
    return sqrt(square) / 2;
}

static double area_on_page(double uv[3][2])
{
    return fabs((uv[1][0] - uv[0][0]) * (uv[2][1] - uv[0][1]) -
                (uv[1][1] - uv[0][1]) * (uv[2][0] - uv[0][0])) /
           2;
}

/* Texels for each unit of area in space, of the whole mesh. */
static double texels_per_area(const checker *c)
{
    double page = 0, space = 0, uv[3][2];
    for (uint32_t t = 0; t < c->mesh->index_count / 3; t++) {
        corners_of(c, t, uv);
        page += area_on_page(uv);
        space += area_in_space(c->mesh, t);
    }
    return space > 0 ? page / space : 0;
}

static al_status check_triangles(checker *c, al_error *error)
{
    double density = texels_per_area(c);
    if (!(density > 0))
        return al_fail(error, AL_BAD_INPUT, "mesh \"%s\" has no area in the second UV set", c->mesh->name);
    for (uint32_t t = 0; t < c->mesh->index_count / 3; t++) {
        double uv[3][2], wanted = density * area_in_space(c->mesh, t);
        if (!(wanted > 0)) continue;
        corners_of(c, t, uv);
        for (int k = 0; k < 3; k++)
            for (int i = 0; i < 2; i++)
                if (!(uv[k][i] >= 0 && uv[k][i] <= (i ? c->height : c->width)))
                    return al_fail(
                        error, AL_BAD_INPUT,
                        "mesh \"%s\": the second UV set of triangle %u has a corner at (%g, %g), outside "
                        "of [0, 1]",
                        c->mesh->name, t, uv[k][0] / c->width, uv[k][1] / c->height);
        if (wanted > SLIVER && area_on_page(uv) < 1e-6 * wanted)
            return al_fail(error, AL_BAD_INPUT,
                           "mesh \"%s\": triangle %u has no area in the second UV set, at (%g, %g)",
                           c->mesh->name, t, uv[0][0] / c->width, uv[0][1] / c->height);
        c->current = t;
        if (!al_raster_centres((const double(*)[2])uv, cover, c))
            return al_fail(error, AL_BAD_INPUT,
                           "mesh \"%s\": triangles %u and %u overlap in the second UV set, at (%g, %g)",
                           c->mesh->name, c->other, t, uv[0][0] / c->width, uv[0][1] / c->height);
    }
    return AL_OK;
}

static al_status check_gaps(checker *c, al_error *error)
{
    uint32_t count, *parts = malloc((c->mesh->index_count / 3 + (size_t)1) * sizeof *parts);
    al_status status = parts ? al_uv_parts(c->mesh, parts, &count, error)
                             : al_fail(error, AL_IO, "mesh \"%s\": out of memory", c->mesh->name);
    for (uint32_t t = 0; status == AL_OK && t < c->mesh->index_count / 3; t++) {
        double uv[3][2];
        corners_of(c, t, uv);
        c->current = parts[t];
        if (!al_raster_parts((const double(*)[2])uv, touch, c))
            status = al_fail(
                error, AL_BAD_INPUT,
                "mesh \"%s\": two parts of the second UV set are less than a texel of %u x %u apart, at "
                "(%g, %g); smaller texels or wider gaps are right",
                c->mesh->name, c->width, c->height, (c->x + 0.5) / c->width, (c->y + 0.5) / c->height);
    }
    free(parts);
    return status;
}

al_status al_uv_check(const al_mesh *mesh, uint32_t width, uint32_t height, al_error *error)
{
    size_t size = (size_t)width * height * sizeof(uint32_t);
    checker c = {.mesh = mesh, .width = width, .height = height, .owners = calloc(1, size + 1)};
    if (!c.owners) return al_fail(error, AL_IO, "mesh \"%s\": out of memory", mesh->name);
    al_status status = check_triangles(&c, error);
    memset(c.owners, 0, size);
    if (status == AL_OK) status = check_gaps(&c, error);
    free(c.owners);
    return status;
}
