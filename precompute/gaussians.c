/* Step 5, continued: the samples' Gaussians gamma_i(x) = w_i exp(-a_i |x - b_i|^2), |x - b_i| <= R_i.
 *
 * The width follows the mean distance s_i of the nearest samples: standard deviation WIDTH s_i, cut off at
 * REACH standard deviations. The weights make the sum S(x) = sum of w_i g_i(x) as near to 1 as it gets over
 * the interior: they minimise sum over points p of (S(p) - 1)^2 with w >= 0 by the multiplicative iteration
 * w_i <- w_i (sum_p g_i(p)) / (sum_p g_i(p) S(p)) (Daube-Witherspoon and Muehllehner 1986), on points drawn
 * uniformly inside; what is reached is measured on other points. */
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "parallel.h"
#include "point_grid.h"
#include "sample.h"

static const double width = 0.55, reach = 2.5;
enum { NEIGHBOURS = 6, POINTS_PER_SAMPLE = 12, POINTS_AT_LEAST = 4096, ITERATIONS = 12, BLOCK = 256 };

typedef struct blend {
    al_samples *samples;
    const al_grid *grid;
    const al_density_field *field;
    al_point_grid by_sample, by_point;
    float *points;                /* [point_count][3] */
    _Atomic uint64_t *fixed_sums; /* [point_count] S in units of 2^-40 */
    float *sums;                  /* [point_count] S */
    float *weights;               /* [count] next weights */
    uint32_t point_count;
} blend;

static unsigned blocks(uint32_t count)
{
    return (count + BLOCK - 1) / BLOCK;
}

static float gaussian(const float centre[3], const float g[4], const float point[3])
{
    float dx = point[0] - centre[0], dy = point[1] - centre[1], dz = point[2] - centre[2];
    float square = dx * dx + dy * dy + dz * dz;
    return square <= g[2] * g[2] ? expf(-g[0] * square) : 0;
}

/* Mean distance to the nearest samples. A sample has neighbours within about twice its free distance, so the
 * ball is doubled until enough are in it. */
static double spacing(const blend *b, uint32_t sample)
{
    const float *p = b->samples->positions + 3 * (size_t)sample;
    double centre[3] = {p[0], p[1], p[2]},
           extent = b->grid->voxel_m * (b->grid->size[0] + b->grid->size[1] + b->grid->size[2]);
    for (double radius = 2 * b->samples->distances[sample];; radius *= 2) {
        double nearest[NEIGHBOURS];
        int found = 0;
        al_point_walk walk = al_point_walk_begin(&b->by_sample, centre, radius);
        for (uint32_t other = al_point_walk_next(&walk); other != UINT32_MAX;
             other = al_point_walk_next(&walk)) {
            const float *q = b->samples->positions + 3 * (size_t)other;
            double distance =
                sqrt(pow(q[0] - centre[0], 2) + pow(q[1] - centre[1], 2) + pow(q[2] - centre[2], 2));
            if (other == sample || distance > radius) continue;
            int at = found < NEIGHBOURS                   ? found++
                     : distance < nearest[NEIGHBOURS - 1] ? NEIGHBOURS - 1
                                                          : NEIGHBOURS;
            if (at == NEIGHBOURS) continue;
            for (; at > 0 && nearest[at - 1] > distance; at--) nearest[at] = nearest[at - 1];
            nearest[at] = distance;
        }
        if (found < NEIGHBOURS && radius < extent) continue;
        double sum = 0;
        for (int i = 0; i < found; i++) sum += nearest[i];
        return found > 0 ? sum / found : 2 * b->samples->distances[sample];
    }
}

static bool shape_block(void *user, unsigned piece, unsigned thread)
{
    blend *b = user;
    (void)thread;
    for (uint32_t i = piece * BLOCK; i < b->samples->count && i < (piece + 1) * BLOCK; i++) {
        const float *p = b->samples->positions + 3 * (size_t)i;
        const double *m = b->field->to_world;
        double deviation = width * spacing(b, i), world[3];
        for (int n = 0; n < 3; n++) world[n] = m[n] * p[0] + m[4 + n] * p[1] + m[8 + n] * p[2] + m[12 + n];
        float *g = b->samples->gaussians + 4 * (size_t)i;
        g[0] = (float)(0.5 / (deviation * deviation));
        g[1] = 1;
        g[2] = (float)(reach * deviation);
        g[3] = (float)al_density_at(b->field->density, world);
    }
    return true;
}

/* Adds a block of samples to the sums in fixed point, so that the order in which threads add is no matter. */
static bool sum_block(void *user, unsigned piece, unsigned thread)
{
    blend *b = user;
    (void)thread;
    for (uint32_t i = piece * BLOCK; i < b->samples->count && i < (piece + 1) * BLOCK; i++) {
        const float *p = b->samples->positions + 3 * (size_t)i, *g = b->samples->gaussians + 4 * (size_t)i;
        double centre[3] = {p[0], p[1], p[2]};
        al_point_walk walk = al_point_walk_begin(&b->by_point, centre, g[2]);
        for (uint32_t n = al_point_walk_next(&walk); n != UINT32_MAX; n = al_point_walk_next(&walk)) {
            float value = g[1] * gaussian(p, g, b->points + 3 * (size_t)n);
            if (value > 0)
                atomic_fetch_add_explicit(&b->fixed_sums[n], (uint64_t)((double)value * 0x1p40),
                                          memory_order_relaxed);
        }
    }
    return true;
}

static void sum_gaussians(blend *b, unsigned threads)
{
    for (uint32_t i = 0; i < b->point_count; i++) atomic_init(&b->fixed_sums[i], 0);
    al_parallel(threads, blocks(b->samples->count), sum_block, b);
    for (uint32_t i = 0; i < b->point_count; i++) b->sums[i] = (float)((double)b->fixed_sums[i] * 0x1p-40);
}

static bool weigh_block(void *user, unsigned piece, unsigned thread)
{
    blend *b = user;
    (void)thread;
    for (uint32_t i = piece * BLOCK; i < b->samples->count && i < (piece + 1) * BLOCK; i++) {
        const float *p = b->samples->positions + 3 * (size_t)i, *g = b->samples->gaussians + 4 * (size_t)i;
        double centre[3] = {p[0], p[1], p[2]}, wanted = 0, reached = 0;
        al_point_walk walk = al_point_walk_begin(&b->by_point, centre, g[2]);
        for (uint32_t n = al_point_walk_next(&walk); n != UINT32_MAX; n = al_point_walk_next(&walk)) {
            float value = gaussian(p, g, b->points + 3 * (size_t)n);
            wanted += value;
            reached += (double)value * b->sums[n];
        }
        b->weights[i] = reached > 0 ? (float)(g[1] * wanted / reached) : g[1];
    }
    return true;
}

/* Lists the points in by_point; those of a cell are made neighbours in memory, where most of the time goes.
 */
static al_status list_points(blend *b, const double low[3], const double high[3], al_error *error)
{
    al_point_grid unsorted = {0};
    float *sorted = malloc(3 * (size_t)b->point_count * sizeof *sorted);
    al_status status = sorted ? AL_OK : al_fail(error, AL_IO, "out of memory for %u points", b->point_count);
    if (status == AL_OK)
        status = al_point_grid_create(b->points, b->point_count, low, high, b->samples->radius_m, &unsorted,
                                      error);
    if (status == AL_OK) {
        uint32_t count = 0;
        for (uint32_t i = 0; i < b->point_count; i++) al_point_grid_insert(&unsorted, i);
        al_point_walk walk =
            al_point_walk_begin(&unsorted, low, high[0] - low[0] + high[1] - low[1] + high[2] - low[2]);
        for (uint32_t n = al_point_walk_next(&walk); n != UINT32_MAX; n = al_point_walk_next(&walk))
            memcpy(sorted + 3 * (size_t)count++, b->points + 3 * (size_t)n, 3 * sizeof *sorted);
        memcpy(b->points, sorted, 3 * (size_t)count * sizeof *sorted);
        al_point_grid_free(&unsorted);
        al_point_grid_free(&b->by_point);
        status = al_point_grid_create(b->points, b->point_count, low, high, b->samples->radius_m,
                                      &b->by_point, error);
    }
    for (uint32_t i = 0; status == AL_OK && i < b->point_count; i++) al_point_grid_insert(&b->by_point, i);
    free(sorted);
    return status;
}

/* Draws the points of one purpose: numbers from `first` on of the candidates' sequence. */
static void draw_points(blend *b, const al_candidates *candidates, uint64_t first)
{
    for (uint32_t i = 0; i < b->point_count; i++) {
        double point[3];
        while (!al_candidate(candidates, first, point)) first++;
        first++;
        for (int n = 0; n < 3; n++) b->points[3 * (size_t)i + n] = (float)point[n];
    }
}

/* Least squares shrinks a sum that it cannot make flat; one common factor puts its mean back to 1. */
static void centre_sum(blend *b, unsigned threads)
{
    double sum = 0;
    sum_gaussians(b, threads);
    for (uint32_t i = 0; i < b->point_count; i++) sum += b->sums[i];
    for (uint32_t i = 0; sum > 0 && i < b->samples->count; i++)
        b->samples->gaussians[4 * (size_t)i + 1] *= (float)(b->point_count / sum);
}

static void measure_unity(blend *b)
{
    double sum = 0, squares = 0, worst = 0;
    for (uint32_t i = 0; i < b->point_count; i++) {
        sum += b->sums[i];
        squares += (double)b->sums[i] * b->sums[i];
        worst = fmax(worst, fabs(b->sums[i] - 1));
    }
    double mean = sum / b->point_count;
    b->samples->unity_mean = (float)mean;
    b->samples->unity_deviation = (float)sqrt(fmax(squares / b->point_count - mean * mean, 0));
    b->samples->unity_worst = (float)worst;
}

al_status al_sample_gaussians(const char *name, const al_grid *grid, const al_interior *interior,
                              const al_density_field *field, const al_sample_options *options,
                              al_progress *progress, al_samples *samples, al_error *error)
{
    uint32_t count = samples->count;
    blend b = {.samples = samples, .grid = grid, .field = field};
    al_candidates candidates = {0};
    double low[3], high[3];
    al_status status = AL_OK;
    for (int i = 0; i < 3; i++) {
        low[i] = grid->origin_m[i];
        high[i] = grid->origin_m[i] + grid->size[i] * grid->voxel_m;
    }
    b.point_count = POINTS_PER_SAMPLE * count > POINTS_AT_LEAST ? POINTS_PER_SAMPLE * count : POINTS_AT_LEAST;
    samples->gaussians = malloc(4 * (size_t)count * sizeof(float));
    b.points = malloc(3 * (size_t)b.point_count * sizeof(float));
    b.sums = malloc(b.point_count * sizeof(float));
    b.fixed_sums = malloc(b.point_count * sizeof *b.fixed_sums);
    b.weights = malloc(count * sizeof(float));
    if (!samples->gaussians || !b.points || !b.sums || !b.fixed_sums || !b.weights) {
        status = al_fail(error, AL_IO, "%s: out of memory for the Gaussians of %u samples", name, count);
        goto cleanup;
    }
    status = al_candidates_create(interior, options->seed ^ 0x5bd1e995u, &candidates, error);
    if (status == AL_OK)
        status = al_point_grid_create(samples->positions, count, low, high, samples->radius_m, &b.by_sample,
                                      error);
    if (status != AL_OK) goto cleanup;
    for (uint32_t i = 0; i < count; i++) al_point_grid_insert(&b.by_sample, i);
    al_parallel(options->threads, blocks(count), shape_block, &b);
    draw_points(&b, &candidates, 0);
    status = list_points(&b, low, high, error);
    for (int n = 0; n < ITERATIONS && status == AL_OK; n++) {
        sum_gaussians(&b, options->threads);
        al_parallel(options->threads, blocks(count), weigh_block, &b);
        for (uint32_t i = 0; i < count; i++) samples->gaussians[4 * (size_t)i + 1] = b.weights[i];
        if (al_progress_update(progress, n, ITERATIONS)) status = al_fail(error, AL_CANCELLED, "cancelled");
    }
    if (status != AL_OK) goto cleanup;
    centre_sum(&b, options->threads);
    draw_points(&b, &candidates, 1u << 30);
    status = list_points(&b, low, high, error);
    if (status != AL_OK) goto cleanup;
    sum_gaussians(&b, options->threads);
    measure_unity(&b);
cleanup:
    al_point_grid_free(&b.by_sample);
    al_point_grid_free(&b.by_point);
    al_candidates_free(&candidates);
    free(b.points);
    free(b.sums);
    free(b.fixed_sums);
    free(b.weights);
    return status;
}
