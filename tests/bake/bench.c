/* Bench of the bake's steps: ratios inside one run, for docs/performance.md. Usage: airlight-bench-bake. */
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include "sphere.h"
#include "sweep.h"

enum { COPY_BYTES = 256 << 20, REPEATS = 5 };

static const al_program quiet = {.name = "airlight-bench-bake", .quiet = true};

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values)
{
    qsort(values, REPEATS, sizeof *values, compare_doubles);
    return values[REPEATS / 2];
}

/* Seconds to copy 8 bytes by memcpy, on one thread, far out of the caches. */
static double copy_seconds(void)
{
    char *from = malloc(COPY_BYTES), *to = malloc(COPY_BYTES);
    memset(from, 1, COPY_BYTES);
    memset(to, 2, COPY_BYTES);
    __asm__ volatile("" : : "r"(from), "r"(to) : "memory");
    double started = al_program_seconds();
    memcpy(to, from, COPY_BYTES);
    __asm__ volatile("" : : "r"(to) : "memory"); /* the copy is not to be left out or put off */
    double seconds = (al_program_seconds() - started) * 8 / COPY_BYTES;
    if (to[COPY_BYTES / 2] != 1) abort();
    free(from);
    free(to);
    return seconds;
}

typedef struct times {
    double sweep, moment; /* s */
} times;

static times first_sweep(al_device *device, const al_grid *grid, uint32_t directions)
{
    al_error error = {0};
    al_sweep sweep;
    al_moment_state moment;
    al_progress progress;
    al_progress_begin(&progress, &quiet, "bench");
    if (al_sweep_create(device, grid, directions, 4, 512u << 20, &sweep, &error) != AL_OK ||
        al_moment_begin(&sweep, &moment, &error) != AL_OK) {
        fprintf(stderr, "%s\n", error.message);
        exit(error.status);
    }
    double started = al_program_seconds();
    al_moment_run(&sweep, 4, &moment, &progress, &error);
    times t = {.sweep = sweep.seconds, .moment = al_program_seconds() - started - sweep.seconds};
    al_moment_free(&moment);
    al_sweep_free(&sweep);
    return t;
}

int main(void)
{
    al_error error;
    al_device *device;
    al_density *density;
    al_grid grid;
    al_medium_description medium = {.density = {.type = AL_DENSITY_CONSTANT, .scale = 1}};
    al_scene_description scene = {.path = "bench", .folder = "."};
    al_triangles mesh = test_sphere(1, 96);
    if (al_device_open(0, 0, ".", true, &device, &error) != AL_OK ||
        al_density_open(&scene, &medium, &density, &error) != AL_OK) {
        fprintf(stderr, "%s\n", error.message);
        return error.status;
    }
    al_density_field field = {.density = density,
                              .to_world = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
    if (al_grid_voxelise("sphere", &mesh, NULL, &field, 126, 0, &grid, &error) != AL_OK) return error.status;
    printf("device: %s; grid %u x %u x %u\n", device->name, grid.size[0], grid.size[1], grid.size[2]);

    double copies[REPEATS], ratios[REPEATS], sweeps[REPEATS], moments[REPEATS], linear[REPEATS];
    first_sweep(device, &grid, 32); /* kernels are built and memory is touched */
    for (int i = 0; i < REPEATS; i++) {
        double voxel_directions = (double)al_grid_count(&grid) * 512;
        copies[i] = copy_seconds();
        times few = first_sweep(device, &grid, 32), many = first_sweep(device, &grid, 512);
        sweeps[i] = many.sweep / voxel_directions;
        moments[i] = many.moment / voxel_directions;
        ratios[i] = (sweeps[i] + moments[i]) / copies[i];
        linear[i] = (many.sweep + many.moment) / (few.sweep + few.moment);
    }
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    printf("| copy of 8 bytes (memcpy, one thread) | %.2f ns |\n", 1e9 * median(copies));
    printf("| optical depth, per voxel and direction | %.2f ns |\n", 1e9 * median(sweeps));
    printf("| moment, per voxel and direction | %.2f ns |\n", 1e9 * median(moments));
    printf("| both over the copy | %.1f |\n", median(ratios));
    printf("| 512 directions over 32 | %.1f |\n", median(linear));
    printf("| peak memory | %.0f MiB |\n", usage.ru_maxrss / 1024.0);
    al_grid_free(&grid);
    al_density_free(density);
    al_device_close(device);
    free(mesh.positions);
    free(mesh.indices);
    return 0;
}
