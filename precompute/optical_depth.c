/* Step 2: optical depth. Prepares the rays of a batch of direction pairs and runs opencl/optical_depth.cl. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/sh.h"
#include "sweep.h"

enum {
    PAD_COLUMNS = 8,
    LANES = 8,
    GROUP = 4 * LANES /* opencl/optical_depth.cl: BLOCKS */,
    BATCH_LIMIT = 16
};

/* A voxel that is opaque throughout lets exp(-6) = 0.25 % through per voxel crossed; one that is opaque by
 * a share s lets 1 - s through. More would widen blockers, since density is interpolated between voxels. */
static const double blocker_nats = 6;

static cl_int4 shape_for(const al_grid *grid, const uint32_t axis[3])
{
    cl_int width = (cl_int)((grid->size[axis[0]] + 2 * PAD_COLUMNS + 1 + LANES - 1) / LANES * LANES);
    return (cl_int4){
        {(cl_int)grid->size[axis[0]], (cl_int)grid->size[axis[1]], (cl_int)grid->size[axis[2]], width}};
}

static size_t padded_count(cl_int4 shape)
{
    return (size_t)shape.s[2] * (size_t)(shape.s[1] + 2) * (size_t)shape.s[3];
}

static void axes_for(uint32_t a, uint32_t axis[3])
{
    static const uint32_t axes[3][3] = {{1, 2, 0}, {0, 2, 1}, {0, 1, 2}};
    memcpy(axis, axes[a], sizeof axes[a]);
}

al_status al_sweep_create(al_device *device, const al_grid *grid, uint32_t direction_count,
                          double sigma_smallest, size_t memory_limit, al_sweep *sweep, al_error *error)
{
    *sweep = (al_sweep){.device = device, .grid = grid, .direction_count = direction_count};
    sweep->blocker_density = 1 / (sigma_smallest * grid->voxel_m);
    size_t longest = 0;
    for (uint32_t a = 0; a < 3; a++) {
        uint32_t axis[3];
        axes_for(a, axis);
        size_t count = padded_count(shape_for(grid, axis));
        if (count > sweep->buffer_size) sweep->buffer_size = count;
        if (grid->size[a] > longest) longest = grid->size[a];
    }
    size_t pair_bytes = 2 * sweep->buffer_size * sizeof(float), batch = memory_limit / pair_bytes;
    sweep->batch = (uint32_t)(batch < 1 ? 1 : batch > BATCH_LIMIT ? BATCH_LIMIT : batch);
    sweep->staging = calloc(sweep->buffer_size, sizeof *sweep->staging);
    sweep->pairs = malloc((direction_count / 2 + 1) * sizeof *sweep->pairs);
    if (!sweep->staging || !sweep->pairs) {
        al_sweep_free(sweep);
        return al_fail(error, AL_IO, "out of memory for the sweep's staging");
    }
    al_status status = al_device_kernel(device, "optical_depth", &sweep->kernel, error);
    size_t field_bytes = sweep->buffer_size * sizeof(float), slices = sweep->batch * longest;
    struct {
        cl_mem *buffer;
        size_t size;
    } buffers[] = {
        {&sweep->density, field_bytes},
        {&sweep->forward, sweep->batch * field_bytes},
        {&sweep->backward, sweep->batch * field_bytes},
        {&sweep->shifts, slices * sizeof(cl_int2)},
        {&sweep->fractions, slices * sizeof(cl_float2)},
        {&sweep->rays, sweep->batch * sizeof(cl_int4)},
        {&sweep->lengths, sweep->batch * sizeof(cl_float)},
    };
    for (size_t i = 0; i < sizeof buffers / sizeof *buffers && status == AL_OK; i++)
        status = al_device_buffer(device, buffers[i].size, NULL, buffers[i].buffer, error);
    if (status != AL_OK) al_sweep_free(sweep);
    return status;
}

void al_sweep_free(al_sweep *sweep)
{
    cl_mem *buffers[] = {&sweep->density,   &sweep->forward, &sweep->backward, &sweep->shifts,
                         &sweep->fractions, &sweep->rays,    &sweep->lengths};
    for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++) al_device_release(buffers[i]);
    if (sweep->kernel) clReleaseKernel(sweep->kernel);
    free(sweep->staging);
    free(sweep->pairs);
    *sweep = (al_sweep){0};
}

static uint32_t dominant_axis(const double w[3])
{
    uint32_t a = fabs(w[1]) > fabs(w[0]) ? 1 : 0;
    return fabs(w[2]) > fabs(w[a]) ? 2 : a;
}

/* A voxel's place in the padded field, and in the grid. */
static size_t padded_at(const al_sweep *sweep, uint32_t u, uint32_t v, uint32_t a)
{
    return ((size_t)(v + 1) * (size_t)sweep->shape.s[2] + a) * (size_t)sweep->shape.s[3] + u + PAD_COLUMNS;
}

static size_t grid_at(const al_sweep *sweep, uint32_t u, uint32_t v, uint32_t a)
{
    uint32_t at[3];
    at[sweep->axis[0]] = u;
    at[sweep->axis[1]] = v;
    at[sweep->axis[2]] = a;
    return ((size_t)at[2] * sweep->grid->size[1] + at[1]) * sweep->grid->size[0] + at[0];
}

static float swept_density(const al_sweep *sweep, size_t at)
{
    const al_grid *grid = sweep->grid;
    if (!grid->blockers || grid->blockers[at] <= 0) return grid->density[at];
    double nats = grid->blockers[at] < 1 ? fmin(-log1p(-grid->blockers[at]), blocker_nats) : blocker_nats;
    return (float)(grid->density[at] + nats * sweep->blocker_density);
}

al_status al_sweep_set_axis(al_sweep *sweep, uint32_t a, al_error *error)
{
    axes_for(a, sweep->axis);
    sweep->shape = shape_for(sweep->grid, sweep->axis);
    sweep->stride = padded_count(sweep->shape);
    sweep->pair_count = 0;
    for (uint32_t i = 0; i < sweep->direction_count / 2; i++) {
        double w[3];
        al_direction_set(sweep->direction_count, i, w);
        if (dominant_axis(w) == a) sweep->pairs[sweep->pair_count++] = i;
    }
    memset(sweep->staging, 0, sweep->buffer_size * sizeof *sweep->staging);
    for (uint32_t k = 0; k < (uint32_t)sweep->shape.s[2]; k++)
        for (uint32_t v = 0; v < (uint32_t)sweep->shape.s[1]; v++)
            for (uint32_t u = 0; u < (uint32_t)sweep->shape.s[0]; u++)
                sweep->staging[padded_at(sweep, u, v, k)] = swept_density(sweep, grid_at(sweep, u, v, k));
    return al_device_write(sweep->device, sweep->density, sweep->staging, sweep->buffer_size * sizeof(float),
                           error);
}

void al_sweep_direction(const al_sweep *sweep, uint32_t index, double w[3])
{
    al_direction_set(sweep->direction_count, sweep->pairs[index], w);
    double sign = w[sweep->axis[2]] < 0 ? -1 : 1;
    for (int i = 0; i < 3; i++) w[i] *= sign;
}

/* First ray and number of rays along one axis, so that columns -1 .. count - 1 exist in every slice. */
static void ray_range(int32_t lowest_shift, int32_t highest_shift, cl_int count, cl_int *first, cl_int *rays)
{
    *first = -1 - highest_shift;
    *rays = count + 1 + highest_shift - lowest_shift;
}

typedef struct ray_set { /* of a batch; arrays as opencl/optical_depth.cl takes them */
    cl_int2 *shifts;
    cl_float2 *fractions;
    cl_int4 rays[BATCH_LIMIT];
    cl_float lengths[BATCH_LIMIT];
    size_t groups, rows; /* the most of any pair */
} ray_set;

static void lay_rays(const al_sweep *sweep, uint32_t first, uint32_t count, double sigma, ray_set *set)
{
    uint32_t slices = (uint32_t)sweep->shape.s[2];
    for (uint32_t pair = 0; pair < count; pair++) {
        double w[3];
        al_sweep_direction(sweep, first + pair, w);
        double along = w[sweep->axis[2]], slope[2] = {w[sweep->axis[0]] / along, w[sweep->axis[1]] / along};
        for (uint32_t k = 0; k < slices; k++)
            for (int side = 0; side < 2; side++) {
                double at = k * slope[side], whole = floor(at);
                set->shifts[pair * slices + k].s[side] = (cl_int)whole;
                set->fractions[pair * slices + k].s[side] = (cl_float)(at - whole);
            }
        cl_int4 *rays = &set->rays[pair];
        for (int side = 0; side < 2; side++) {
            cl_int end = set->shifts[pair * slices + slices - 1].s[side];
            ray_range(end < 0 ? end : 0, end > 0 ? end : 0, sweep->shape.s[side], &rays->s[side],
                      &rays->s[2 + side]);
        }
        set->lengths[pair] = (cl_float)(sigma * sweep->grid->voxel_m / along);
        size_t groups = (size_t)(rays->s[2] + GROUP - 1) / GROUP, rows = (size_t)rays->s[3];
        if (groups > set->groups) set->groups = groups;
        if (rows > set->rows) set->rows = rows;
    }
}

static al_status upload_rays(al_sweep *sweep, uint32_t count, const ray_set *set, al_error *error)
{
    size_t slices = count * (size_t)sweep->shape.s[2];
    struct {
        cl_mem buffer;
        const void *data;
        size_t size;
    } uploads[] = {
        {sweep->shifts, set->shifts, slices * sizeof *set->shifts},
        {sweep->fractions, set->fractions, slices * sizeof *set->fractions},
        {sweep->rays, set->rays, count * sizeof *set->rays},
        {sweep->lengths, set->lengths, count * sizeof *set->lengths},
    };
    al_status status = AL_OK;
    for (size_t i = 0; i < sizeof uploads / sizeof *uploads && status == AL_OK; i++)
        status = al_device_write(sweep->device, uploads[i].buffer, uploads[i].data, uploads[i].size, error);
    return status;
}

al_status al_sweep_run(al_sweep *sweep, uint32_t first, uint32_t count, double sigma, al_error *error)
{
    double started_s = al_program_seconds();
    size_t slices = count * (size_t)sweep->shape.s[2];
    ray_set set = {.shifts = malloc(slices * sizeof *set.shifts),
                   .fractions = malloc(slices * sizeof *set.fractions)};
    al_status status = AL_OK;
    if (!set.shifts || !set.fractions) {
        status = al_fail(error, AL_IO, "out of memory for a sweep's rays");
        goto cleanup;
    }
    lay_rays(sweep, first, count, sigma, &set);
    status = upload_rays(sweep, count, &set, error);
    if (status != AL_OK) goto cleanup;
    size_t size[3] = {set.groups, set.rows, count};
    al_argument arguments[] = {
        AL_ARGUMENT(sweep->density),   AL_ARGUMENT(sweep->shape),   AL_ARGUMENT(sweep->shifts),
        AL_ARGUMENT(sweep->fractions), AL_ARGUMENT(sweep->rays),    AL_ARGUMENT(sweep->lengths),
        AL_ARGUMENT(sweep->stride),    AL_ARGUMENT(sweep->forward), AL_ARGUMENT(sweep->backward)};
    status = al_device_run(sweep->device, sweep->kernel, size, arguments,
                           sizeof arguments / sizeof *arguments, error);
    if (status == AL_OK) status = al_device_finish(sweep->device, error);
    sweep->seconds += al_program_seconds() - started_s;
cleanup:
    free(set.shifts);
    free(set.fractions);
    return status;
}

void al_sweep_unpad_add(const al_sweep *sweep, const float *padded, float *grid_values)
{
    for (uint32_t k = 0; k < (uint32_t)sweep->shape.s[2]; k++)
        for (uint32_t v = 0; v < (uint32_t)sweep->shape.s[1]; v++)
            for (uint32_t u = 0; u < (uint32_t)sweep->shape.s[0]; u++)
                grid_values[grid_at(sweep, u, v, k)] += padded[padded_at(sweep, u, v, k)];
}
