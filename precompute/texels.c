#include "texels.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "geometry.h"
#include "raster.h"
#include "second_uv.h"

#define SLIVER 1e-3 /* texels: what rounding leaves of a texel beside a straight border */

void al_texels_corner(const al_mesh *mesh, const al_atlas_instance *instance, uint32_t vertex, double at[2])
{
    at[0] = instance->x + (double)mesh->uv1[2 * (size_t)vertex] * instance->width;
    at[1] = instance->y + (double)mesh->uv1[2 * (size_t)vertex + 1] * instance->height;
}

/* --- one page --- */

typedef struct triangle {
    double uv[3][2];
    double points[3][3], normals[3][3];
    double face[3];    /* unit */
    double twice_area; /* in uv, with its sign */
    double edge_m;
    uint32_t chart;
} triangle;

typedef struct page_work {
    uint32_t width, height;
    al_texel *cells; /* [height][width]; edge_m 0: none */
    float *shares;   /* [height][width] area of the owner in the texel; 2: it covers the centre */
    const triangle *current;
} page_work;

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void weights_at(const triangle *t, const double at[2], double weight[3])
{
    for (int k = 0; k < 3; k++) {
        const double *a = t->uv[(k + 1) % 3], *b = t->uv[(k + 2) % 3];
        weight[k] = ((b[0] - a[0]) * (at[1] - a[1]) - (b[1] - a[1]) * (at[0] - a[0])) / t->twice_area;
    }
}

/* On a mesh whose normals are smoother than its triangles, points of the flat triangle lie inside the surface
 * that the normals mean, and rays along its tangents meet the triangle's neighbours: the dark steps of the
 * shadow terminator. The point moves out to where the tangent planes of the corners, interpolated, would have
 * it; on a flat triangle it stays (Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems II, 2021). */
static void lift(const triangle *t, const double weight[3], double position[3])
{
    double moved[3];
    memcpy(moved, position, sizeof moved);
    for (int k = 0; k < 3; k++) {
        double d[3] = {position[0] - t->points[k][0], position[1] - t->points[k][1],
                       position[2] - t->points[k][2]};
        double below = fmin(dot(d, t->normals[k]), 0);
        for (int i = 0; i < 3; i++) moved[i] -= weight[k] * below * t->normals[k][i];
    }
    memcpy(position, moved, sizeof moved);
}

static void fill_cell(page_work *w, int x, int y, const double at[2], float share)
{
    const triangle *t = w->current;
    size_t cell = (size_t)y * w->width + (size_t)x;
    al_texel *texel = &w->cells[cell];
    double weight[3], normal[3] = {0};
    weights_at(t, at, weight);
    *texel = (al_texel){.cell = (uint32_t)cell, .chart = t->chart, .edge_m = (float)t->edge_m};
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++) {
            texel->position[i] += weight[k] * t->points[k][i];
            normal[i] += weight[k] * t->normals[k][i];
        }
    double length = sqrt(dot(normal, normal));
    bool smooth = dot(normal, t->face) > 0.1 * length; /* else they say nothing of this side */
    for (int i = 0; i < 3; i++) texel->normal[i] = (float)(smooth ? normal[i] / length : t->face[i]);
    if (smooth) lift(t, weight, texel->position);
    w->shares[cell] = share;
}

static bool inside(const page_work *w, int x, int y)
{
    return x >= 0 && y >= 0 && x < (int)w->width && y < (int)w->height;
}

static bool take_centre(void *user, int x, int y)
{
    page_work *w = user;
    const double at[2] = {x + 0.5, y + 0.5};
    if (inside(w, x, y) && w->shares[(size_t)y * w->width + (size_t)x] < 2) fill_cell(w, x, y, at, 2);
    return true;
}

static bool take_part(void *user, const al_raster_part *part)
{
    page_work *w = user;
    if (!inside(w, part->x, part->y)) return true;
    bool sliver = part->area < SLIVER && part->area < fabs(w->current->twice_area) / 4;
    if (!sliver && part->area > w->shares[(size_t)part->y * w->width + (size_t)part->x])
        fill_cell(w, part->x, part->y, part->middle, (float)part->area);
    return true;
}

/* False for a triangle without area in space or on the page. */
static bool load_triangle(const al_scene *scene, const al_atlas_instance *placed, uint32_t index, triangle *t)
{
    const al_instance *instance = &scene->instances[placed->instance];
    const al_mesh *mesh = &scene->meshes[instance->mesh];
    double world[16], inverse[16], a[3], b[3];
    for (int i = 0; i < 16; i++) world[i] = instance->world[i];
    bool flat = al_matrix_determinant(world) == 0;
    if (!flat) al_matrix_invert(world, inverse);
    for (size_t k = 0; k < 3; k++) {
        uint32_t v = mesh->indices[3 * (size_t)index + k];
        const float *p = mesh->positions + 3 * (size_t)v, *n = mesh->normals + 3 * (size_t)v;
        al_matrix_point(world, (double[3]){p[0], p[1], p[2]}, t->points[k]);
        al_texels_corner(mesh, placed, v, t->uv[k]);
        for (int i = 0; i < 3; i++) /* the inverse transposed */
            t->normals[k][i] =
                flat ? 0 : inverse[4 * i] * n[0] + inverse[4 * i + 1] * n[1] + inverse[4 * i + 2] * n[2];
        double length = sqrt(dot(t->normals[k], t->normals[k]));
        for (int i = 0; i < 3; i++) t->normals[k][i] = length > 0 ? t->normals[k][i] / length : 0;
    }
    for (int k = 0; k < 3; k++) {
        a[k] = t->points[1][k] - t->points[0][k];
        b[k] = t->points[2][k] - t->points[0][k];
    }
    for (int k = 0; k < 3; k++)
        t->face[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
    double length = sqrt(dot(t->face, t->face)), sign = al_matrix_determinant(world) < 0 ? -1 : 1;
    t->twice_area = (t->uv[1][0] - t->uv[0][0]) * (t->uv[2][1] - t->uv[0][1]) -
                    (t->uv[1][1] - t->uv[0][1]) * (t->uv[2][0] - t->uv[0][0]);
    if (!(length > 0) || !(fabs(t->twice_area) > 1e-12)) return false;
    for (int k = 0; k < 3; k++) t->face[k] *= sign / length;
    t->edge_m = sqrt(length / fabs(t->twice_area));
    return true;
}

/* Centres first: who has one keeps it. */
static al_status cover_instance(const al_scene *scene, const al_atlas_instance *placed, page_work *w,
                                uint32_t *next_chart, al_error *error)
{
    const al_mesh *mesh = &scene->meshes[scene->instances[placed->instance].mesh];
    uint32_t *parts = malloc((mesh->index_count / 3 + (size_t)1) * sizeof *parts), count;
    triangle t;
    al_status status = parts ? al_uv_parts(mesh, parts, &count, error)
                             : al_fail(error, AL_IO, "mesh \"%s\": out of memory", mesh->name);
    for (int round = 0; status == AL_OK && round < 2; round++)
        for (uint32_t i = 0; i < mesh->index_count / 3; i++) {
            if (!load_triangle(scene, placed, i, &t)) continue;
            t.chart = *next_chart + parts[i];
            w->current = &t;
            if (round == 0)
                al_raster_centres((const double(*)[2])t.uv, take_centre, w);
            else
                al_raster_parts((const double(*)[2])t.uv, take_part, w);
        }
    if (status == AL_OK) *next_chart += count;
    free(parts);
    return status;
}

static al_status append_page(const page_work *w, uint32_t page, al_texels *texels, al_error *error)
{
    size_t cells = (size_t)w->width * w->height, used = 0;
    for (size_t i = 0; i < cells; i++) used += w->cells[i].edge_m > 0;
    al_texel *grown = realloc(texels->texels, (texels->count + used + 1) * sizeof *grown);
    if (!grown) return al_fail(error, AL_IO, "out of memory for %zu texels", texels->count + used);
    texels->texels = grown;
    for (size_t i = 0; i < cells; i++) {
        if (!(w->cells[i].edge_m > 0)) continue;
        texels->texels[texels->count] = w->cells[i];
        texels->texels[texels->count++].page = page;
    }
    return AL_OK;
}

static al_status cover_page(const al_scene *scene, const al_atlas *atlas, uint32_t page, uint32_t *next_chart,
                            al_texels *texels, al_error *error)
{
    page_work w = {.width = atlas->pages[page][0], .height = atlas->pages[page][1]};
    size_t cells = (size_t)w.width * w.height;
    al_status status = AL_OK;
    w.cells = calloc(cells + 1, sizeof *w.cells);
    w.shares = calloc(cells + 1, sizeof *w.shares);
    if (!w.cells || !w.shares)
        status = al_fail(error, AL_IO, "out of memory for a page of %u x %u texels", w.width, w.height);
    for (uint32_t i = 0; status == AL_OK && i < atlas->instance_count; i++)
        if (atlas->instances[i].page == page)
            status = cover_instance(scene, &atlas->instances[i], &w, next_chart, error);
    if (status == AL_OK) status = append_page(&w, page, texels, error);
    free(w.cells);
    free(w.shares);
    return status;
}

al_status al_texels_make(const al_scene *scene, const al_atlas *atlas, al_texels *texels, al_error *error)
{
    uint32_t next_chart = 0;
    al_status status = AL_OK;
    *texels = (al_texels){0};
    for (uint32_t page = 0; status == AL_OK && page < atlas->page_count; page++)
        status = cover_page(scene, atlas, page, &next_chart, texels, error);
    if (status != AL_OK) al_texels_free(texels);
    return status;
}

void al_texels_free(al_texels *texels)
{
    free(texels->texels);
    *texels = (al_texels){0};
}
