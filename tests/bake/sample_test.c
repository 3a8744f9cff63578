/* Step 5: Poisson-disk distance for every pair, asked counts, prefixes, the sum of the Gaussians, and the
 * same bytes from any number of threads, on a homogeneous sphere. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../test.h"
#include "sample.h"
#include "sphere.h"
#include "sweep.h"

static const al_program quiet = {.name = "sample_test", .quiet = true};

typedef struct scene {
    al_density *density;
    al_density_field field;
    al_grid grid;
    float *rho;
    double *points;
    uint32_t *corners;
    al_interior interior;
    double volume;
} scene;

/* A sphere is star-shaped: its centre and each face make tetrahedra that fill it. */
static void fill_sphere(scene *s, const al_triangles *mesh)
{
    s->points = calloc(3 * (mesh->vertex_count + 1), sizeof *s->points);
    s->corners = malloc(4 * mesh->triangle_count * sizeof *s->corners);
    memcpy(s->points + 3, mesh->positions, 3 * mesh->vertex_count * sizeof *s->points);
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        s->corners[4 * t] = 0;
        for (int i = 0; i < 3; i++) s->corners[4 * t + 1 + i] = 1 + mesh->indices[3 * t + i];
    }
    s->interior = (al_interior){s->points, s->corners, mesh->triangle_count, NULL};
    s->volume = 4 * acos(-1) / 3;
}

static bool open_scene(scene *s, al_device *device, uint32_t directions)
{
    al_error error = {0};
    al_medium_description medium = {.density = {.type = AL_DENSITY_CONSTANT, .scale = 1}};
    al_scene_description description = {.path = "test", .folder = "."};
    al_triangles mesh = test_sphere(1, 48);
    al_sweep sweep;
    al_moment_state moment;
    al_progress progress;
    memset(s, 0, sizeof *s);
    al_progress_begin(&progress, &quiet, "test");
    CHECK(al_density_open(&description, &medium, &s->density, &error) == AL_OK);
    s->field = (al_density_field){.density = s->density,
                                  .to_world = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
    CHECK(al_grid_voxelise("sphere", &mesh, NULL, &s->field, 48, 0, &s->grid, &error) == AL_OK);
    CHECK(al_sweep_create(device, &s->grid, directions, 4, 256u << 20, &sweep, &error) == AL_OK);
    CHECK(al_moment_begin(&sweep, &moment, &error) == AL_OK);
    CHECK(al_moment_run(&sweep, 4, &moment, &progress, &error) == AL_OK);
    al_moment_finish(&sweep, &moment);
    s->rho = malloc(al_grid_count(&s->grid) * sizeof *s->rho);
    CHECK(al_divergence(device, &s->grid, moment.total, s->rho, &error) == AL_OK);
    al_moment_free(&moment);
    al_sweep_free(&sweep);
    fill_sphere(s, &mesh);
    free(mesh.positions);
    free(mesh.indices);
    return test_failures == 0;
}

static void close_scene(scene *s)
{
    al_density_free(s->density);
    al_grid_free(&s->grid);
    free(s->rho);
    free(s->points);
    free(s->corners);
}

static al_samples place(const scene *s, al_sample_options options)
{
    al_error error = {0};
    al_progress progress;
    al_samples samples;
    al_progress_begin(&progress, &quiet, "test");
    al_status status =
        al_sample_interior("sphere", &s->grid, s->rho, &s->interior, &options, &progress, &samples, &error);
    if (status == AL_OK)
        status = al_sample_gaussians("sphere", &s->grid, &s->interior, &s->field, &options, &progress,
                                     &samples, &error);
    if (status != AL_OK) printf("%s\n", error.message);
    CHECK(status == AL_OK);
    return samples;
}

/* Least distance of any pair among the first `count`, relative to min(delta_i, delta_j). */
static double least_relative_distance(const al_samples *samples, uint32_t count)
{
    double least = INFINITY;
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t j = i + 1; j < count; j++) {
            double square = 0;
            for (int n = 0; n < 3; n++)
                square += pow(samples->positions[3 * i + n] - samples->positions[3 * j + n], 2);
            least = fmin(least, sqrt(square) / fmin(samples->distances[i], samples->distances[j]));
        }
    return least;
}

static void check_samples(const scene *s, uint32_t asked)
{
    al_samples samples = place(s, (al_sample_options){.count = asked, .seed = 1, .threads = 1});
    printf("asked %u, placed %u, r %.5f; sum of Gaussians: mean %.4f, deviation %.4f, worst %.4f\n", asked,
           samples.count, samples.radius_m, samples.unity_mean, samples.unity_deviation, samples.unity_worst);
    CHECK(fabs((double)samples.count / asked - 1) <= 0.02);
    CHECK(least_relative_distance(&samples, samples.count) >= 1);
    CHECK_NEAR(samples.volume_m3, s->volume, 1e-6 * s->volume);
    for (uint32_t i = 0; i < samples.count; i++) {
        const float *p = samples.positions + 3 * i;
        CHECK(p[0] * p[0] + p[1] * p[1] + p[2] * p[2] <= 1.001);
        CHECK(samples.distances[i] >= 0.5f * (float)samples.radius_m &&
              samples.distances[i] <= 2.0001f * (float)samples.radius_m);
    }
    /* A prefix of n of N samples could at best be spread (N/n)^(1/3) times wider; its levels shrink by 0.7937
     * and a level is cut off anywhere, so one level's worth is given away. */
    for (uint32_t n = samples.count / 64; n < samples.count; n *= 4)
        CHECK(least_relative_distance(&samples, n) >= 0.6 * cbrt((double)samples.count / n));
    CHECK_NEAR(samples.unity_mean, 1, 0.01);

    al_samples again = place(s, (al_sample_options){.count = asked, .seed = 1, .threads = 3});
    CHECK(again.count == samples.count);
    CHECK(!memcmp(again.positions, samples.positions, 3 * samples.count * sizeof(float)));
    CHECK(!memcmp(again.gaussians, samples.gaussians, 4 * samples.count * sizeof(float)));
    al_samples_free(&again);
    al_samples_free(&samples);
}

int main(void)
{
    al_device *device;
    al_error error;
    scene s;
    if (al_device_open(0, 0, ".", true, &device, &error) != AL_OK) return test_skip(error.message);
    static const uint32_t directions[] = {32, 128, 512};
    for (int i = 0; i < 3 && open_scene(&s, device, directions[i]); i++) {
        al_samples published =
            place(&s, (al_sample_options){.radius_m = cbrt(s.volume / (2 * 5000)), .seed = 1});
        printf("%u directions, r as published for 5000 samples: %u\n", directions[i], published.count);
        CHECK(published.count > 0);
        al_samples_free(&published);
        if (i == 0) {
            check_samples(&s, 500);
            check_samples(&s, 5000);
            al_samples one = place(&s, (al_sample_options){.radius_m = 4, .seed = 1});
            CHECK(one.count == 1); /* delta is at least r/2, the sphere's diameter */
            al_samples_free(&one);
        }
        close_scene(&s);
    }
    al_device_close(device);
    return test_end();
}
