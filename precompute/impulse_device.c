/* Step 2 of the impulse tables on the device, in single precision. */
#include <stdlib.h>

#include "impulse_steps.h"

static al_status float_buffer(al_device *device, const double *numbers, size_t count, cl_mem *buffer,
                              al_error *error)
{
    float *rounded = malloc((count ? count : 1) * sizeof *rounded);
    if (!rounded) return al_fail(error, AL_IO, "out of memory for the impulse tables");
    for (size_t i = 0; i < count; i++) rounded[i] = (float)numbers[i];
    al_status status = al_device_buffer(device, count * sizeof *rounded, rounded, buffer, error);
    free(rounded);
    return status;
}

static al_status read_values(al_device *device, cl_mem buffer, size_t count, double *values, al_error *error)
{
    float *shares = malloc(count * sizeof *shares);
    if (!shares) return al_fail(error, AL_IO, "out of memory for the impulse tables");
    al_status status = al_device_read(device, buffer, shares, count * sizeof *shares, error);
    for (size_t i = 0; status == AL_OK && i < count; i++) values[i] = shares[i];
    free(shares);
    return status;
}

enum { RAYS, COLUMNS, TURNS, SPANS, SOURCE, DISTANCES, SHARES, BUFFERS };

static al_status run(al_device *device, const al_impulse_rule *rule, const al_impulse_source *source,
                     uint32_t distance_count, cl_mem *b, al_error *error)
{
    bool sun = rule->emitter == AL_IMPULSE_DIRECTIONAL;
    cl_kernel kernel = NULL;
    size_t size[3] = {distance_count, rule->cosine_count, rule->angle_count};
    cl_int steps = (cl_int)rule->step_count, bands = (cl_int)rule->bands, m_count = (cl_int)rule->m_count,
           source_count = (cl_int)source->axis.count, event = (cl_int)source->event;
    cl_float first = (cl_float)source->axis.first, scale = (cl_float)(1 / source->axis.step);
    const al_argument scatter[] = {
        AL_ARGUMENT(b[RAYS]),   AL_ARGUMENT(b[COLUMNS]),   AL_ARGUMENT(b[TURNS]), AL_ARGUMENT(b[SPANS]),
        AL_ARGUMENT(b[SOURCE]), AL_ARGUMENT(b[DISTANCES]), AL_ARGUMENT(steps),    AL_ARGUMENT(bands),
        AL_ARGUMENT(m_count),   AL_ARGUMENT(source_count), AL_ARGUMENT(event),    AL_ARGUMENT(first),
        AL_ARGUMENT(scale),     AL_ARGUMENT(b[SHARES])};
    const al_argument halfspace[] = {
        AL_ARGUMENT(b[RAYS]),      AL_ARGUMENT(b[TURNS]), AL_ARGUMENT(b[COLUMNS]), AL_ARGUMENT(b[SOURCE]),
        AL_ARGUMENT(b[DISTANCES]), AL_ARGUMENT(steps),    AL_ARGUMENT(bands),      AL_ARGUMENT(source_count),
        AL_ARGUMENT(event),        AL_ARGUMENT(first),    AL_ARGUMENT(scale),      AL_ARGUMENT(b[SHARES])};
    al_status status =
        al_device_kernel(device, sun ? "impulse_halfspace" : "impulse_scatter", &kernel, error);
    if (status == AL_OK)
        status = al_device_run(device, kernel, size, sun ? halfspace : scatter,
                               sun ? sizeof halfspace / sizeof *halfspace : sizeof scatter / sizeof *scatter,
                               error);
    if (status == AL_OK) status = al_device_finish(device, error);
    if (kernel) clReleaseKernel(kernel);
    return status;
}

al_status al_impulse_scatter_device(al_device *device, const al_impulse_rule *rule,
                                    const al_impulse_source *source, const double *distances,
                                    uint32_t distance_count, double *values, al_error *error)
{
    cl_mem b[BUFFERS] = {NULL};
    size_t source_size = (size_t)source->axis.count * rule->cosine_count;
    size_t count = (size_t)rule->angle_count * rule->cosine_count * distance_count * rule->number_count;
    al_status status = float_buffer(device, rule->rays, rule->ray_count, &b[RAYS], error);
    if (status == AL_OK) status = float_buffer(device, rule->columns, rule->column_count, &b[COLUMNS], error);
    if (status == AL_OK) status = float_buffer(device, rule->turns, rule->turn_count, &b[TURNS], error);
    if (status == AL_OK)
        status =
            al_device_buffer(device, rule->span_count * sizeof *rule->spans, rule->spans, &b[SPANS], error);
    if (status == AL_OK) status = float_buffer(device, source->values, source_size, &b[SOURCE], error);
    if (status == AL_OK) status = float_buffer(device, distances, distance_count, &b[DISTANCES], error);
    if (status == AL_OK) status = al_device_buffer(device, count * sizeof(float), NULL, &b[SHARES], error);
    if (status == AL_OK) status = run(device, rule, source, distance_count, b, error);
    if (status == AL_OK) status = read_values(device, b[SHARES], count, values, error);
    if (status == AL_OK) al_impulse_divide(rule, source->event + 1, distances, distance_count, values);
    for (int i = 0; i < BUFFERS; i++) al_device_release(&b[i]);
    return status;
}
