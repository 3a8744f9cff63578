/* Pixels are constant over their solid angles, (cos top - cos bottom) 2 pi / width. Convention
 * (docs/scene.md): polar angle pi v from +y, direction (sin theta sin phi, cos theta, -sin theta cos phi),
 * phi = 2 pi (u - 1/2). */
#include "environment_sampler.h"

#include <math.h>
#include <stdlib.h>

#include "airlight/formulas.h"

/* cos theta at the top of a row, and the solid angle of one of its pixels. */
static double row_top(const al_environment *map, uint32_t row)
{
    return cos(AL_PI * row / map->height);
}

static double pixel_angle(const al_environment *map, uint32_t row)
{
    return (row_top(map, row) - row_top(map, row + 1)) * 2 * AL_PI / map->width;
}

/* What a pixel is drawn in proportion to: the sum of its channels times its solid angle. */
static double weight(const al_environment *map, uint32_t row, uint32_t column)
{
    const float *p = map->pixels + ((size_t)row * map->width + column) * 3;
    return ((double)p[0] + p[1] + p[2]) * pixel_angle(map, row);
}

al_status al_environment_sampler_create(const al_environment *map, al_environment_sampler *sampler,
                                        al_error *error)
{
    *sampler = (al_environment_sampler){0};
    if (!map->width || !map->height) return AL_OK;
    sampler->rows = malloc(sizeof(double) * (map->height + (size_t)1));
    sampler->columns = malloc(sizeof(double) * map->height * (map->width + (size_t)1));
    if (!sampler->rows || !sampler->columns) {
        al_environment_sampler_free(sampler);
        return al_fail(error, AL_IO, "out of memory for an environment of %u x %u pixels", map->width,
                       map->height);
    }
    sampler->rows[0] = 0;
    for (uint32_t row = 0; row < map->height; row++) {
        double *columns = sampler->columns + row * (map->width + (size_t)1);
        columns[0] = 0;
        for (uint32_t i = 0; i < map->width; i++) columns[i + 1] = columns[i] + weight(map, row, i);
        sampler->rows[row + 1] = sampler->rows[row] + columns[map->width];
    }
    if (sampler->rows[map->height] > 0) sampler->map = map;
    return AL_OK;
}

void al_environment_sampler_free(al_environment_sampler *sampler)
{
    free(sampler->rows);
    free(sampler->columns);
    *sampler = (al_environment_sampler){0};
}

/* The interval of a cumulative table that holds u times its end, and the place in it. */
static uint32_t invert(const double *cumulative, uint32_t count, double u, double *place)
{
    double target = u * cumulative[count];
    uint32_t low = 0, high = count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (cumulative[middle] <= target)
            low = middle;
        else
            high = middle;
    }
    double width = cumulative[low + 1] - cumulative[low];
    *place = width > 0 ? fmin((target - cumulative[low]) / width, 1) : 0.5;
    return low;
}

void al_environment_sample(const al_environment_sampler *sampler, const double u[2], double direction[3])
{
    const al_environment *map = sampler->map;
    double down, across;
    uint32_t row = invert(sampler->rows, map->height, u[0], &down);
    uint32_t column = invert(sampler->columns + row * (map->width + (size_t)1), map->width, u[1], &across);
    double cosine = row_top(map, row) + down * (row_top(map, row + 1) - row_top(map, row));
    double sine = sqrt(fmax(0, 1 - cosine * cosine));
    double phi = 2 * AL_PI * ((column + across) / map->width - 0.5);
    direction[0] = sine * sin(phi);
    direction[1] = cosine;
    direction[2] = -sine * cos(phi);
}

double al_environment_density(const al_environment_sampler *sampler, const double direction[3],
                              double radiance[3])
{
    const al_environment *map = sampler->map;
    double theta = acos(fmin(fmax(direction[1], -1), 1));
    double around = atan2(direction[0], -direction[2]) / (2 * AL_PI) + 0.5;
    uint32_t row = (uint32_t)fmin(theta / AL_PI * map->height, map->height - 1.0);
    uint32_t column = (uint32_t)fmin(around * map->width, map->width - 1.0);
    const float *p = map->pixels + ((size_t)row * map->width + column) * 3;
    for (int c = 0; c < 3; c++) radiance[c] = p[c];
    return weight(map, row, column) / (sampler->rows[map->height] * pixel_angle(map, row));
}
