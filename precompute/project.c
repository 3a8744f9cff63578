/* Step 6: project. Spherical harmonics of the transmittance at the samples, by a second sweep that is read
 * at the samples only: psi = 1 - A, so that c(l, m) = sqrt(4 pi) [l = 0] - (4 pi / n) sum of A(w) Y(l, m; w).
 * The sum over the n directions of Y(l, m) alone is not quite 0 for l > 0; the mean of A times that sum is
 * taken out, so that constants are exact in thick media (A near 1) as in thin ones (A near 0). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/formulas.h"
#include "airlight/sh.h"
#include "sweep.h"

static uint32_t blocks_for(uint32_t order)
{
    return (order * order + 7) / 8;
}

al_status al_project_begin(uint32_t point_count, uint32_t order, al_project_state *state, al_error *error)
{
    *state = (al_project_state){.sum_count = (size_t)point_count * blocks_for(order) * 8};
    state->sums = calloc(state->sum_count + 1, sizeof *state->sums);
    return state->sums
               ? AL_OK
               : al_fail(error, AL_IO, "out of memory for the coefficients of %u samples", point_count);
}

void al_project_free(al_project_state *state)
{
    free(state->sums);
    *state = (al_project_state){0};
}

/* Y(l, m) of a direction, split by the parity of l: two runs of 8 * blocks numbers. */
static void split_basis(uint32_t order, const double w[3], float *even, float *odd)
{
    double basis[AL_SH_MAX_COUNT];
    al_sh_basis((int)order, w[0], w[1], w[2], basis);
    memset(even, 0, blocks_for(order) * 8 * sizeof *even);
    memset(odd, 0, blocks_for(order) * 8 * sizeof *odd);
    for (uint32_t l = 0; l < order; l++)
        for (uint32_t i = l * l; i < (l + 1) * (l + 1); i++) (l % 2 ? odd : even)[i] = (float)basis[i];
}

/* The points in voxel coordinates (centres at whole numbers) of the sweep's axes, kept a little inside. */
static void place_points(const al_sweep *sweep, const float *points, uint32_t count, cl_float4 *placed)
{
    for (uint32_t i = 0; i < count; i++)
        for (int n = 0; n < 3; n++) {
            uint32_t world = sweep->axis[n];
            double at = (points[3 * i + world] - sweep->grid->origin_m[world]) / sweep->grid->voxel_m - 0.5;
            placed[i].s[n] = (cl_float)fmin(fmax(at, 0.5), sweep->grid->size[world] - 1.5);
        }
}

typedef struct projector {
    cl_kernel kernel;
    cl_mem points, even, odd, sums;
    cl_float4 *placed;
    float *basis; /* [2][batch][blocks * 8] */
} projector;

static al_status add_batch(al_sweep *sweep, projector *p, uint32_t order, uint32_t first, uint32_t count,
                           double sigma, uint32_t point_count, al_error *error)
{
    size_t run = blocks_for(order) * 8, bytes = count * run * sizeof *p->basis;
    for (uint32_t pair = 0; pair < count; pair++) {
        double w[3];
        al_sweep_direction(sweep, first + pair, w);
        split_basis(order, w, p->basis + pair * run, p->basis + (sweep->batch + pair) * run);
    }
    al_status status = al_sweep_run(sweep, first, count, sigma, error);
    if (status == AL_OK) status = al_device_write(sweep->device, p->even, p->basis, bytes, error);
    if (status == AL_OK)
        status = al_device_write(sweep->device, p->odd, p->basis + sweep->batch * run, bytes, error);
    cl_int pair_count = (cl_int)count, blocks = (cl_int)blocks_for(order);
    size_t size[3] = {point_count, 1, 1};
    al_argument arguments[] = {
        AL_ARGUMENT(sweep->forward),   AL_ARGUMENT(sweep->backward), AL_ARGUMENT(sweep->shape),
        AL_ARGUMENT(sweep->fractions), AL_ARGUMENT(p->points),       AL_ARGUMENT(p->even),
        AL_ARGUMENT(p->odd),           AL_ARGUMENT(pair_count),      AL_ARGUMENT(blocks),
        AL_ARGUMENT(sweep->stride),    AL_ARGUMENT(p->sums)};
    if (status == AL_OK)
        status = al_device_run(sweep->device, p->kernel, size, arguments,
                               sizeof arguments / sizeof *arguments, error);
    if (status == AL_OK) status = al_device_finish(sweep->device, error);
    return status;
}

al_status al_project_run(al_sweep *sweep, double sigma, uint32_t order, const float *points,
                         uint32_t point_count, al_project_state *state, al_progress *progress,
                         al_error *error)
{
    projector p = {0};
    size_t basis_bytes = sweep->batch * blocks_for(order) * 8 * sizeof *p.basis,
           point_bytes = point_count * sizeof *p.placed;
    size_t sum_bytes = state->sum_count * sizeof *state->sums;
    uint32_t done = 0, total = sweep->direction_count / 2;
    al_status status = al_device_kernel(sweep->device, "project", &p.kernel, error);
    p.placed = malloc(point_bytes + 1);
    p.basis = malloc(2 * basis_bytes);
    if (status == AL_OK && (!p.placed || !p.basis))
        status = al_fail(error, AL_IO, "out of memory for %u samples", point_count);
    if (status == AL_OK) status = al_device_buffer(sweep->device, point_bytes, NULL, &p.points, error);
    if (status == AL_OK) status = al_device_buffer(sweep->device, basis_bytes, NULL, &p.even, error);
    if (status == AL_OK) status = al_device_buffer(sweep->device, basis_bytes, NULL, &p.odd, error);
    if (status == AL_OK) status = al_device_buffer(sweep->device, sum_bytes, state->sums, &p.sums, error);
    for (uint32_t a = state->axis; a < 3 && status == AL_OK; a++) {
        status = al_sweep_set_axis(sweep, a, error);
        place_points(sweep, points, point_count, p.placed);
        if (status == AL_OK) status = al_device_write(sweep->device, p.points, p.placed, point_bytes, error);
        while (status == AL_OK && state->next < sweep->pair_count) {
            uint32_t left = sweep->pair_count - state->next,
                     count = left < sweep->batch ? left : sweep->batch;
            status = add_batch(sweep, &p, order, state->next, count, sigma, point_count, error);
            if (status != AL_OK) break;
            state->next += count;
            done += count;
            if (al_progress_update(progress, done, total)) status = al_fail(error, AL_CANCELLED, "cancelled");
        }
        if (status == AL_OK) {
            state->axis = a + 1;
            state->next = 0;
        }
    }
    if (status == AL_OK || status == AL_CANCELLED) {
        al_error ignored;
        al_status read =
            al_device_read(sweep->device, p.sums, state->sums, sum_bytes, status == AL_OK ? error : &ignored);
        if (read != AL_OK) status = read;
    }
    cl_mem *buffers[] = {&p.points, &p.even, &p.odd, &p.sums};
    for (int i = 0; i < 4; i++) al_device_release(buffers[i]);
    if (p.kernel) clReleaseKernel(p.kernel);
    free(p.placed);
    free(p.basis);
    return status;
}

void al_project_finish(const al_project_state *state, uint32_t direction_count, uint32_t order,
                       uint32_t point_count, float *coefficients, size_t stride)
{
    size_t run = blocks_for(order) * 8;
    double weight = 4 * AL_PI / direction_count, constant[AL_SH_MAX_COUNT] = {0};
    for (uint32_t i = 0; i < direction_count; i++) {
        double w[3], basis[AL_SH_MAX_COUNT];
        al_direction_set(direction_count, i, w);
        al_sh_basis((int)order, w[0], w[1], w[2], basis);
        for (uint32_t c = 1; c < order * order; c++) constant[c] += weight * basis[c];
    }
    for (uint32_t i = 0; i < point_count; i++) {
        const float *sums = state->sums + i * run;
        double mean = weight * sums[0] / sqrt(4 * AL_PI);
        coefficients[i * stride] = (float)(sqrt(4 * AL_PI) - weight * sums[0]);
        for (uint32_t c = 1; c < order * order; c++)
            coefficients[i * stride + c] = (float)(mean * constant[c] - weight * sums[c]);
    }
}
