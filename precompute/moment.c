/* Step 3: first moment of the transmittance, T(x) = integral of psi(x, w) w dw = (4 pi / n) sum of psi w. */
#include <stdlib.h>
#include <string.h>

#include "airlight/formulas.h"
#include "sweep.h"

enum { GROUP = 32 /* voxels per work-item: opencl/moment.cl */ };

al_status al_moment_begin(const al_sweep *sweep, al_moment_state *state, al_error *error)
{
    *state = (al_moment_state){.plane_size = sweep->buffer_size};
    state->total = calloc(3 * al_grid_count(sweep->grid), sizeof *state->total);
    state->planes = calloc(3 * sweep->buffer_size, sizeof *state->planes);
    if (state->total && state->planes) return AL_OK;
    al_moment_free(state);
    return al_fail(error, AL_IO, "out of memory for the first moment");
}

void al_moment_free(al_moment_state *state)
{
    free(state->total);
    free(state->planes);
    *state = (al_moment_state){0};
}

void al_moment_finish(const al_sweep *sweep, al_moment_state *state)
{
    float weight = (float)(4 * AL_PI / sweep->direction_count);
    for (size_t i = 0; i < 3 * al_grid_count(sweep->grid); i++) state->total[i] *= weight;
}

static al_status add_batch(al_sweep *sweep, cl_kernel kernel, cl_mem directions, cl_mem planes,
                           uint32_t first, uint32_t count, double sigma, al_error *error)
{
    cl_float4 w[64] = {0};
    for (uint32_t pair = 0; pair < count; pair++) {
        double direction[3];
        al_sweep_direction(sweep, first + pair, direction);
        for (int i = 0; i < 3; i++) w[pair].s[i] = (cl_float)direction[i];
    }
    al_status status = al_sweep_run(sweep, first, count, sigma, error);
    if (status == AL_OK) status = al_device_write(sweep->device, directions, w, count * sizeof *w, error);
    cl_int pair_count = (cl_int)count;
    size_t size[3] = {(size_t)(sweep->shape.s[0] + GROUP - 1) / GROUP, (size_t)sweep->shape.s[2],
                      (size_t)sweep->shape.s[1]};
    al_argument arguments[] = {AL_ARGUMENT(sweep->forward), AL_ARGUMENT(sweep->backward),
                               AL_ARGUMENT(sweep->shape),   AL_ARGUMENT(sweep->fractions),
                               AL_ARGUMENT(directions),     AL_ARGUMENT(pair_count),
                               AL_ARGUMENT(sweep->stride),  AL_ARGUMENT(planes)};
    if (status == AL_OK)
        status = al_device_run(sweep->device, kernel, size, arguments, sizeof arguments / sizeof *arguments,
                               error);
    if (status == AL_OK) status = al_device_finish(sweep->device, error);
    return status;
}

al_status al_moment_run(al_sweep *sweep, double sigma, al_moment_state *state, al_progress *progress,
                        al_error *error)
{
    cl_kernel kernel = NULL;
    cl_mem directions = NULL, planes = NULL;
    size_t bytes = 3 * state->plane_size * sizeof *state->planes;
    uint32_t done = 0, total = sweep->direction_count / 2;
    al_status status = al_device_kernel(sweep->device, "moment", &kernel, error);
    if (status == AL_OK)
        status = al_device_buffer(sweep->device, 64 * sizeof(cl_float4), NULL, &directions, error);
    if (status == AL_OK) status = al_device_buffer(sweep->device, bytes, state->planes, &planes, error);
    for (uint32_t a = 0; a < 3 && status == AL_OK; a++) {
        if (a < state->axis) continue;
        status = al_sweep_set_axis(sweep, a, error);
        while (status == AL_OK && state->next < sweep->pair_count) {
            uint32_t left = sweep->pair_count - state->next,
                     count = left < sweep->batch ? left : sweep->batch;
            status = add_batch(sweep, kernel, directions, planes, state->next, count, sigma, error);
            if (status != AL_OK) break;
            state->next += count;
            done += count;
            if (al_progress_update(progress, done, total)) status = al_fail(error, AL_CANCELLED, "cancelled");
        }
        if (status != AL_OK && status != AL_CANCELLED) break;
        al_error ignored;
        al_status read =
            al_device_read(sweep->device, planes, state->planes, bytes, status == AL_OK ? error : &ignored);
        if (read != AL_OK) status = read;
        if (status != AL_OK) break;
        for (int i = 0; i < 3; i++)
            al_sweep_unpad_add(sweep, state->planes + i * sweep->stride,
                               state->total + i * al_grid_count(sweep->grid));
        memset(state->planes, 0, bytes);
        status = al_device_write(sweep->device, planes, state->planes, bytes, error);
        state->axis = a + 1;
        state->next = 0;
    }
    al_device_release(&directions);
    al_device_release(&planes);
    if (kernel) clReleaseKernel(kernel);
    return status;
}
