/* Step 5: sample. Weighted Poisson-disk sampling of the interior by dart throwing.
 *
 * A sample at x keeps free the distance delta(x) = clamp((r/2) rho_q / rho(x), r/2, 2 r): smallest where the
 * divergence rho is largest, rho_q the 98th percentile of rho inside. A dart is kept when
 * |xi - xj| >= min(delta_i, delta_j) for every sample before it. Cook 1986; the mapping's direction is the
 * one the paper's text asks for, not the one its formula prints. */
#include "sample.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "point_grid.h"

/* Throwing ends when this many darts were thrown for each that stuck; by then about one in 200 sticks. */
enum { DARTS_PER_SAMPLE = 32 };
static const double count_tolerance = 0.01;
enum { SOLVE_LIMIT = 12 };
static const uint32_t sample_limit = 16u << 20;

typedef struct thrower {
    const al_grid *grid;
    const float *rho;
    const al_candidates *candidates;
    double low[3], high[3], rho_quantile;
    al_progress *progress;
    uint32_t expected;
} thrower;

static int compare_floats(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static al_status find_quantile(const al_grid *grid, const float *rho, double *quantile, al_error *error)
{
    size_t count = 0, total = al_grid_count(grid);
    float *inside = malloc((total + 1) * sizeof *inside);
    if (!inside) return al_fail(error, AL_IO, "out of memory for the divergence");
    for (size_t i = 0; i < total; i++)
        if (grid->inside[i]) inside[count++] = rho[i];
    qsort(inside, count, sizeof *inside, compare_floats);
    *quantile = inside[(size_t)(0.98 * (double)(count - 1))];
    free(inside);
    return AL_OK;
}

/* rho at a point: trilinear among the interior voxels around it; 0 where there are none. */
static double rho_at(const al_grid *grid, const float *rho, const double point[3])
{
    int64_t base[3];
    double f[3], sum = 0, weights = 0;
    for (int i = 0; i < 3; i++) {
        double at = (point[i] - grid->origin_m[i]) / grid->voxel_m - 0.5;
        at = fmin(fmax(at, 0), grid->size[i] - 1.001);
        base[i] = (int64_t)at;
        f[i] = at - (double)base[i];
    }
    for (int corner = 0; corner < 8; corner++) {
        size_t at = 0;
        double weight = 1;
        for (int i = 2; i >= 0; i--) {
            int step = corner >> i & 1;
            at = at * grid->size[i] + (size_t)(base[i] + step);
            weight *= step ? f[i] : 1 - f[i];
        }
        if (!grid->inside[at]) continue;
        sum += weight * rho[at];
        weights += weight;
    }
    return weights > 0 ? sum / weights : 0;
}

static double distance_at(const thrower *t, double radius, const double point[3])
{
    double rho = rho_at(t->grid, t->rho, point);
    double distance = rho > 0 ? 0.5 * radius * t->rho_quantile / rho : 2 * radius;
    return fmin(fmax(distance, 0.5 * radius), 2 * radius);
}

/* Whether a point with its free distance may join; scale widens all distances. */
static bool fits(const al_point_grid *placed, const float *distances, const double point[3], double distance,
                 double scale)
{
    al_point_walk walk = al_point_walk_begin(placed, point, scale * distance);
    for (uint32_t other = al_point_walk_next(&walk); other != UINT32_MAX; other = al_point_walk_next(&walk)) {
        const float *p = placed->positions + 3 * (size_t)other;
        double dx = p[0] - point[0], dy = p[1] - point[1], dz = p[2] - point[2];
        double least = scale * fmin(distance, distances[other]);
        if (dx * dx + dy * dy + dz * dz < least * least) return false;
    }
    return true;
}

static al_status grow(al_samples *samples, uint32_t *capacity, al_point_grid *placed, al_error *error)
{
    uint32_t larger = *capacity * 2;
    float *positions = realloc(samples->positions, 3 * (size_t)larger * sizeof *positions);
    if (positions) samples->positions = positions;
    float *distances = positions ? realloc(samples->distances, larger * sizeof *distances) : NULL;
    if (distances) samples->distances = distances;
    uint32_t *next = distances ? realloc(placed->next, ((size_t)larger + 1) * sizeof *next) : NULL;
    if (!next) return al_fail(error, AL_IO, "out of memory for %u samples", larger);
    placed->next = next;
    placed->positions = positions;
    *capacity = larger;
    return AL_OK;
}

/* Throws darts until hardly any sticks. */
static al_status throw_darts(const thrower *t, double radius, al_samples *samples, al_error *error)
{
    uint32_t capacity = 1024;
    uint64_t dart = 0;
    al_point_grid placed = {0};
    al_status status = AL_OK;
    samples->count = 0;
    samples->radius_m = radius;
    free(samples->positions);
    free(samples->distances);
    samples->positions = malloc(3 * (size_t)capacity * sizeof *samples->positions);
    samples->distances = malloc(capacity * sizeof *samples->distances);
    if (!samples->positions || !samples->distances) return al_fail(error, AL_IO, "out of memory for samples");
    status = al_point_grid_create(samples->positions, capacity, t->low, t->high, radius, &placed, error);
    for (; status == AL_OK && dart < 256 + DARTS_PER_SAMPLE * (uint64_t)samples->count; dart++) {
        double point[3];
        if (dart % 65536 == 65535 && al_progress_update(t->progress, samples->count, t->expected))
            status = al_fail(error, AL_CANCELLED, "cancelled");
        if (!al_candidate(t->candidates, dart, point)) continue;
        for (int i = 0; i < 3; i++) point[i] = (float)point[i]; /* what is stored is what is tested */
        double distance = (float)distance_at(t, radius, point);
        if (!fits(&placed, samples->distances, point, distance, 1)) continue;
        if (samples->count == sample_limit)
            status = al_fail(error, AL_BAD_INPUT, "radius_m %g asks for more than %u samples; enlarge it",
                             radius, sample_limit);
        else if (samples->count == capacity)
            status = grow(samples, &capacity, &placed, error);
        if (status != AL_OK) break;
        for (int i = 0; i < 3; i++) samples->positions[3 * (size_t)samples->count + i] = (float)point[i];
        samples->distances[samples->count] = (float)distance;
        al_point_grid_insert(&placed, samples->count++);
    }
    al_point_grid_free(&placed);
    return status;
}

/* A first guess of r: dart throwing ends with about 0.6 samples per delta^3 (measured), and delta is r times
 * what it is for r = 1. */
static double guess_radius(const thrower *t, uint32_t asked)
{
    const al_grid *grid = t->grid;
    double samples = 0;
    for (size_t i = 0; i < al_grid_count(grid); i++) {
        if (!grid->inside[i]) continue;
        double distance = t->rho[i] > 0 ? 0.5 * t->rho_quantile / t->rho[i] : 2;
        samples += 0.6 / pow(fmin(fmax(distance, 0.5), 2), 3);
    }
    return grid->voxel_m * cbrt(samples / asked);
}

/* The count falls with the cube of r where the object is large beside r; the secant in log-log follows what
 * it really does. */
static al_status solve_radius(const thrower *t, const char *name, uint32_t asked, al_samples *samples,
                              al_error *error)
{
    double radius = guess_radius(t, asked);
    double previous_radius = 0, previous_count = 0;
    for (int attempt = 0; attempt < SOLVE_LIMIT; attempt++) {
        al_status status = throw_darts(t, radius, samples, error);
        if (status != AL_OK) return status;
        double miss = (double)samples->count / asked;
        if (fabs(miss - 1) <= count_tolerance) return AL_OK;
        double slope = -3;
        if (previous_count > 0 && samples->count != previous_count)
            slope = log(samples->count / previous_count) / log(radius / previous_radius);
        if (!(slope < -0.5 && slope > -6)) slope = -3;
        previous_radius = radius;
        previous_count = samples->count;
        radius *= pow(1 / miss, 1 / slope);
    }
    if (fabs((double)samples->count / asked - 1) <= 0.02 || asked < 50) return AL_OK;
    return al_fail(
        error, AL_BAD_INPUT,
        "%s: %u samples were asked for, %u are as near as the radius comes; ask for more, or give radius_m",
        name, asked, samples->count);
}

/* Reorders the samples so that every prefix is well spread: with distances widened by a factor that shrinks
 * from the object's size to 1 (each step doubles the count), take what fits of the rest, in order. */
static al_status order_progressively(const thrower *t, al_samples *samples, al_error *error)
{
    uint32_t count = samples->count, placed_count = 0;
    float *positions = malloc(3 * (size_t)count * sizeof *positions + 1),
          *distances = malloc(count * sizeof *distances + 1);
    uint32_t *rest = malloc(count * sizeof *rest + 1), rest_count = count;
    double extent = 0;
    al_status status = positions && distances && rest
                           ? AL_OK
                           : al_fail(error, AL_IO, "out of memory to order %u samples", count);
    for (uint32_t i = 0; rest && i < count; i++) rest[i] = i;
    for (int i = 0; i < 3; i++) extent = fmax(extent, t->high[i] - t->low[i]);
    for (double scale = fmax(extent / samples->radius_m, 1); status == AL_OK && rest_count > 0;
         scale *= 0.7937) {
        if (scale < 1) scale = 1;
        al_point_grid placed;
        status = al_point_grid_create(positions, count, t->low, t->high, scale * samples->radius_m, &placed,
                                      error);
        if (status != AL_OK) break;
        for (uint32_t i = 0; i < placed_count; i++) al_point_grid_insert(&placed, i);
        uint32_t kept = 0;
        for (uint32_t n = 0; n < rest_count; n++) {
            const float *p = samples->positions + 3 * (size_t)rest[n];
            double point[3] = {p[0], p[1], p[2]};
            if (scale > 1 && !fits(&placed, distances, point, samples->distances[rest[n]], scale)) {
                rest[kept++] = rest[n];
                continue;
            }
            memcpy(positions + 3 * (size_t)placed_count, p, 3 * sizeof *p);
            distances[placed_count] = samples->distances[rest[n]];
            al_point_grid_insert(&placed, placed_count++);
        }
        rest_count = kept;
        al_point_grid_free(&placed);
    }
    free(rest);
    if (status != AL_OK) {
        free(positions);
        free(distances);
        return status;
    }
    free(samples->positions);
    free(samples->distances);
    samples->positions = positions;
    samples->distances = distances;
    return AL_OK;
}

/* The interior's volume without the blockers. */
static double medium_volume(const al_grid *grid, double interior_volume)
{
    double opaque = 0;
    if (grid->blockers)
        for (size_t i = 0; i < al_grid_count(grid); i++) opaque += grid->blockers[i];
    return interior_volume - opaque * pow(grid->voxel_m, 3);
}

al_status al_sample_interior(const char *name, const al_grid *grid, const float *rho,
                             const al_interior *interior, const al_sample_options *options,
                             al_progress *progress, al_samples *samples, al_error *error)
{
    al_candidates candidates;
    *samples = (al_samples){0};
    thrower t = {.grid = grid,
                 .rho = rho,
                 .candidates = &candidates,
                 .progress = progress,
                 .expected = options->count};
    al_status status = al_candidates_create(interior, options->seed, &candidates, error);
    if (status != AL_OK) return status;
    for (int i = 0; i < 3; i++) {
        t.low[i] = grid->origin_m[i];
        t.high[i] = grid->origin_m[i] + grid->size[i] * grid->voxel_m;
    }
    status = find_quantile(grid, rho, &t.rho_quantile, error);
    samples->volume_m3 = medium_volume(grid, candidates.running_volume[interior->count - 1]);
    if (status == AL_OK && options->count > 0)
        status = solve_radius(&t, name, options->count, samples, error);
    else if (status == AL_OK) {
        t.expected = (uint32_t)fmin(samples->volume_m3 / (2 * pow(options->radius_m, 3)) + 1, sample_limit);
        status = throw_darts(&t, options->radius_m, samples, error);
    }
    samples->rho_quantile = (float)t.rho_quantile;
    if (status == AL_OK) status = order_progressively(&t, samples, error);
    al_candidates_free(&candidates);
    if (status != AL_OK) al_samples_free(samples);
    return status;
}

void al_samples_free(al_samples *samples)
{
    free(samples->positions);
    free(samples->distances);
    free(samples->gaussians);
    *samples = (al_samples){0};
}
