#include "measure.h"

#include <math.h>
#include <stdlib.h>

#include "airlight/formulas.h"
#include "geometry.h"
#include "parallel.h"
#include "reference/march.h"
#include "solid.h"

void al_measure_add(al_measure *measure, double deviation, double truth)
{
    measure->count++;
    measure->square += deviation * deviation;
    measure->truth_square += truth * truth;
    measure->largest = fmax(measure->largest, fabs(deviation));
}

al_measured al_measure_result(const al_measure *measure, const char *compared, const char *settings,
                              const char *unit)
{
    return (al_measured){.compared = compared,
                         .settings = settings,
                         .unit = unit,
                         .count = measure->count,
                         .rmse = sqrt(measure->square / measure->count),
                         .truth_rms = sqrt(measure->truth_square / measure->count),
                         .largest = measure->largest};
}

al_measured al_measure_twice(const al_measure *measure, const char *compared, const char *settings, const char *unit)
{
    al_measured measured = al_measure_result(measure, compared, settings, unit);
    measured.standard_error = measured.rmse / sqrt(2);
    return measured;
}

/* --- translucent objects --- */

/* Points, fewer where there are many triangles: a ray is tested against each of them. */
enum { POINTS_MOST = 1024, POINTS_LEAST = 64, TRIES = 4096 };
static const double tests_limit = 2e8;

typedef struct crossing {
    double distance_m;
    int turns; /* change of the winding number along the ray: 1 in, -1 out */
} crossing;

typedef struct ray_crossings { /* of a ray with a surface, in the order of the surface */
    crossing *list;
    size_t count, room;
    bool failed;
} ray_crossings;

typedef struct work {
    const al_measured_object *object;
    al_march_medium medium;
    double to_world[16];
    al_solid *boundary, *blockers; /* no blockers: NULL */
    double low[3], high[3];
    uint32_t count;
    float *positions, *directions; /* [count][3] */
    double (*truths)[3];           /* [count]; below 0: no point was found */
} work;

/* SplitMix64 (Steele, Lea and Flood 2014) of a counter. */
static double uniform(uint32_t seed, uint64_t counter)
{
    uint64_t x = ((uint64_t)seed << 40) + (counter + 1) * 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return (double)((x ^ (x >> 31)) >> 11) * 0x1p-53;
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double product[3])
{
    for (int i = 0; i < 3; i++) product[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

/* Where the ray crosses the triangle ahead of its origin (Moeller and Trumbore 1997). */
static bool cross_triangle(const al_triangles *triangles, uint32_t t, const al_ray *ray, crossing *found)
{
    const double *a = triangles->positions + 3 * (size_t)triangles->indices[3 * (size_t)t],
                 *b = triangles->positions + 3 * (size_t)triangles->indices[3 * (size_t)t + 1],
                 *c = triangles->positions + 3 * (size_t)triangles->indices[3 * (size_t)t + 2];
    double ab[3], ac[3], from[3], p[3], q[3];
    for (int i = 0; i < 3; i++) {
        ab[i] = b[i] - a[i];
        ac[i] = c[i] - a[i];
        from[i] = ray->origin[i] - a[i];
    }
    cross(ray->direction, ac, p);
    double determinant = dot(ab, p), u = dot(from, p) / determinant;
    if (determinant == 0 || !(u >= 0 && u <= 1)) return false;
    cross(from, ab, q);
    double v = dot(ray->direction, q) / determinant, distance_m = dot(ac, q) / determinant;
    if (!(v >= 0 && u + v <= 1 && distance_m > 0)) return false;
    *found = (crossing){distance_m, determinant > 0 ? 1 : -1};
    return true;
}

static void cross_surface(const al_triangles *triangles, const al_ray *ray, ray_crossings *crossings)
{
    crossings->count = 0;
    for (uint32_t t = 0; t < triangles->triangle_count; t++) {
        crossing found;
        if (!cross_triangle(triangles, t, ray, &found)) continue;
        if (crossings->count == crossings->room) {
            size_t room = 2 * crossings->room + 16;
            crossing *grown = realloc(crossings->list, room * sizeof *grown);
            crossings->failed = !grown;
            if (!grown) return;
            crossings->list = grown;
            crossings->room = room;
        }
        crossings->list[crossings->count++] = found;
    }
}

static int compare_crossings(const void *a, const void *b)
{
    double x = ((const crossing *)a)->distance_m, y = ((const crossing *)b)->distance_m;
    return (x > y) - (x < y);
}

static void to_world(const double matrix[16], const al_ray *ray, al_ray *world)
{
    al_matrix_point(matrix, ray->origin, world->origin);
    for (int i = 0; i < 3; i++)
        world->direction[i] =
            matrix[i] * ray->direction[0] + matrix[4 + i] * ray->direction[1] + matrix[8 + i] * ray->direction[2];
}

/* The integral of the density along the ray inside the boundary, in metres; INFINITY behind a blocker. */
static double optical_length(const work *w, const al_ray *ray, ray_crossings *crossings)
{
    al_ray world;
    double sum = 0, from = 0;
    int winding = 0;
    to_world(w->to_world, ray, &world);
    cross_surface(w->object->boundary, ray, crossings);
    if (crossings->count) qsort(crossings->list, crossings->count, sizeof *crossings->list, compare_crossings);
    for (size_t i = 0; i < crossings->count; i++) winding -= crossings->list[i].turns;
    for (size_t i = 0; i < crossings->count; i++) {
        double to = crossings->list[i].distance_m;
        if (winding > 0) sum += al_march_length(&w->medium, &world, from, to);
        winding += crossings->list[i].turns;
        from = to;
    }
    cross_surface(w->object->blockers, ray, crossings);
    for (size_t i = 0; i < crossings->count; i++)
        if (crossings->list[i].distance_m < from) return INFINITY;
    return sum;
}

/* Draws the position, in the medium, and the direction of point `index`. */
static bool draw(const work *w, uint32_t index, al_ray *ray)
{
    uint64_t first = (uint64_t)index * (3 * TRIES + 2);
    float *position = w->positions + 3 * (size_t)index, *direction = w->directions + 3 * (size_t)index;
    double z = 2 * uniform(w->object->seed, first) - 1, angle = 2 * AL_PI * uniform(w->object->seed, first + 1);
    direction[0] = (float)(sqrt(1 - z * z) * cos(angle));
    direction[1] = (float)(sqrt(1 - z * z) * sin(angle));
    direction[2] = (float)z;
    for (int i = 0; i < 3; i++) ray->direction[i] = direction[i];
    double length = sqrt(dot(ray->direction, ray->direction));
    for (int i = 0; i < 3; i++) ray->direction[i] /= length;
    for (uint64_t at = first + 2; at < first + 2 + 3 * TRIES; at += 3) {
        for (int i = 0; i < 3; i++) {
            position[i] = (float)(w->low[i] + (w->high[i] - w->low[i]) * uniform(w->object->seed, at + (uint64_t)i));
            ray->origin[i] = position[i];
        }
        if (al_solid_contains(w->boundary, ray->origin) &&
            !(w->blockers && al_solid_contains(w->blockers, ray->origin)))
            return true;
    }
    return false;
}

/* A point and its truth. */
static bool find_truth(void *user, unsigned index, unsigned thread)
{
    work *w = user;
    al_ray ray;
    ray_crossings crossings = {0};
    (void)thread;
    bool found = draw(w, index, &ray);
    double length_m = found ? optical_length(w, &ray, &crossings) : 0;
    for (int c = 0; c < 3; c++) w->truths[index][c] = found ? exp(-w->medium.sigma_t_per_m[c] * length_m) : -1;
    free(crossings.list);
    return !crossings.failed;
}

static void add_deviations(const work *w, uint32_t channels, const float *values, al_measure *measure)
{
    for (uint32_t i = 0; i < w->count; i++)
        for (uint32_t c = 0; c < channels && w->truths[i][0] >= 0; c++)
            al_measure_add(measure, values[3 * (size_t)i + c] - w->truths[i][c], w->truths[i][c]);
}

static al_status out_of_memory(const char *name, al_error *error)
{
    return al_fail(error, AL_IO, "%s: out of memory to measure its error", name);
}

static void choose_points(work *w)
{
    const al_triangles *boundary = w->object->boundary;
    double triangles = (double)boundary->triangle_count + w->object->blockers->triangle_count;
    w->count = (uint32_t)fmin(POINTS_MOST, fmax(POINTS_LEAST, tests_limit / fmax(triangles, 1)));
    for (int i = 0; i < 3; i++) {
        w->low[i] = INFINITY;
        w->high[i] = -INFINITY;
        for (uint32_t v = 0; v < boundary->vertex_count; v++) {
            w->low[i] = fmin(w->low[i], boundary->positions[3 * (size_t)v + (size_t)i]);
            w->high[i] = fmax(w->high[i], boundary->positions[3 * (size_t)v + (size_t)i]);
        }
    }
}

al_status al_measure_object(const al_measured_object *object, const al_translucent_data *data, al_measure *measure,
                            al_error *error)
{
    const al_translucent_object *from = &object->import->scene.translucents[object->index];
    work w = {.object = object, .medium = al_march_medium_of(object->import, from->medium)};
    for (int i = 0; i < 16; i++) w.to_world[i] = object->import->scene.instances[from->instance].world[i];
    choose_points(&w);
    w.positions = calloc(3 * (size_t)w.count, sizeof *w.positions);
    w.directions = calloc(3 * (size_t)w.count, sizeof *w.directions);
    w.truths = calloc(w.count, sizeof *w.truths);
    float *values = calloc(3 * (size_t)w.count, sizeof *values);
    al_status status = w.positions && w.directions && w.truths && values ? AL_OK : out_of_memory(from->name, error);
    if (status == AL_OK) status = al_solid_create(object->boundary, &w.boundary, error);
    if (status == AL_OK && object->blockers->triangle_count)
        status = al_solid_create(object->blockers, &w.blockers, error);
    if (status == AL_OK && !al_parallel(object->threads, w.count, find_truth, &w))
        status = out_of_memory(from->name, error);
    if (status == AL_OK)
        status = al_translucent_foretell(data, w.count, w.positions, w.directions, values, error);
    if (status == AL_OK) add_deviations(&w, data->info.channel_count, values, measure);
    al_solid_free(w.boundary);
    al_solid_free(w.blockers);
    free(w.positions);
    free(w.directions);
    free(w.truths);
    free(values);
    return status;
}
