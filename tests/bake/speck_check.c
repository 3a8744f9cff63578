/* A baked box of 2 m whose grid is REST but for one voxel of a million in the middle (vdb_speck), against its
 * transmittance: every sample's coefficients, and the stored densities.
 * usage: speck_check ASSET.air VOXELS REST */
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "../test.h"
#include "airlight/formulas.h"
#include "airlight/sh.h"
#include "airlight/translucent.h"

static const double speck = 1e6;

/* Distances at which a ray enters and leaves the cube [-half, half]^3; false: it misses it. */
static bool cross(const float from[3], const double w[3], double half, double span[2])
{
    span[0] = 0;
    span[1] = INFINITY;
    for (int k = 0; k < 3; k++) {
        double a = (-half - from[k]) / w[k], b = (half - from[k]) / w[k];
        span[0] = fmax(span[0], fmin(a, b));
        span[1] = fmin(span[1], fmax(a, b));
    }
    return span[0] < span[1];
}

/* Optical depth of the speck alone: trilinear, so peak times w(x) w(y) w(z), w(x) = max(1 - |x| / h, 0).
 * Midpoint rule: with a peak of a million it matters only whether the ray grazes the cube's very edge. */
static double speck_depth(const float from[3], const double w[3], double h, double peak)
{
    enum { STEPS = 64 };
    double span[2], sum = 0;
    if (!cross(from, w, h, span)) return 0;
    for (int i = 0; i < STEPS; i++) {
        double t = span[0] + (span[1] - span[0]) * (i + 0.5) / STEPS, density = peak;
        for (int k = 0; k < 3; k++) density *= fmax(1 - fabs(from[k] + t * w[k]) / h, 0);
        sum += density * (span[1] - span[0]) / STEPS;
    }
    return sum;
}

typedef struct sums {
    double error, bound, shadow, worst;
} sums;

/* The square of the difference between stored and true coefficients, the true ones projected on the same
 * directions, is at most (4 pi / n) times the sum over the directions of (psi' - psi)^2, for an orthonormal
 * basis; the Gram matrix of 512 directions is that to 5 %. The speck may come out larger or smaller by three
 * edges of the baked grid's voxels: they cover it by up to one, density is interpolated between them, and so
 * is psi about a sample. Rays between may be dark or clear. All others are off by what voxels do to the rest,
 * a voxel's depth at most. */
static void add_sample(const al_translucent_info *info, const float place[3], const float *stored, double h,
                       double rest, sums *total)
{
    double wanted[AL_SH_MAX_COUNT] = {0}, without[AL_SH_MAX_COUNT] = {0}, basis[AL_SH_MAX_COUNT];
    double error = 0, shadow = 0, bound = 0, voxel = info->voxel_m;
    int count = (int)(info->order * info->order);
    for (uint32_t i = 0; i < info->direction_count; i++) {
        double w[3], box[2], span[2], weight = 4 * AL_PI / info->direction_count;
        al_direction_set(info->direction_count, i, w);
        cross(place, w, 1, box);
        double clear = exp(-rest * box[1]);
        double psi = clear * exp(-speck_depth(place, w, h, speck - rest));
        bool maybe = cross(place, w, h + 3 * voxel, span), surely = cross(place, w, h - 3 * voxel, span);
        bound += weight * (maybe && !surely ? clear * clear : pow(rest * voxel * clear, 2) + 1e-8);
        al_sh_basis((int)info->order, w[0], w[1], w[2], basis);
        for (int k = 0; k < count; k++) {
            wanted[k] += weight * psi * basis[k];
            without[k] += weight * clear * basis[k];
        }
    }
    for (int k = 0; k < count; k++) {
        error += (stored[k] - wanted[k]) * (stored[k] - wanted[k]);
        shadow += (without[k] - wanted[k]) * (without[k] - wanted[k]);
    }
    CHECK(error <= 1.05 * bound);
    total->error += error;
    total->bound += bound;
    total->shadow += shadow;
    total->worst = fmax(total->worst, error / bound);
}

static void check_samples(const al_file *file, const al_translucent_info *info, double h, double rest)
{
    sums total = {0};
    al_error error = {0};
    for (uint32_t p = 0; p < al_translucent_page_count(info); p++) {
        al_translucent_page page;
        CHECK(al_translucent_read_page(file, info, p, &page, &error) == AL_OK);
        for (uint32_t i = 0; i < page.count; i++) {
            float stored[AL_SH_MAX_COUNT];
            al_translucent_decode(info, &page, i, 0, stored);
            add_sample(info, page.positions + 3 * i, stored, h, rest, &total);
        }
    }
    printf("%u samples: error %.3f, bound %.3f, shadow %.3f (root mean squares), largest error^2 / bound^2 "
           "%.2f\n",
           info->sample_count, sqrt(total.error / info->sample_count), sqrt(total.bound / info->sample_count),
           sqrt(total.shadow / info->sample_count), total.worst);
    /* Far below the bound, as most rays between are right: 2.6 % of the shadow's square when this was
     * written. */
    CHECK(total.error < 0.05 * total.shadow);
}

/* The middle is opaque, and what surrounds the speck is there still: to half of a 65535th of 16 optical
 * depths. */
static void check_densities(const al_file *file, const al_translucent_info *info, double h, double rest)
{
    const uint16_t *density;
    const uint8_t *blockers;
    al_error error = {0};
    const uint32_t *n = info->grid_size;
    double unit = info->density_max, voxel = info->voxel_m, extinction = info->sigma_s_per_m[0];
    CHECK(al_translucent_read_grid(file, info, &density, &blockers, &error) == AL_OK);
    CHECK_NEAR(unit * extinction * voxel, 16, 1e-5);
    CHECK(density[((size_t)n[2] / 2 * n[1] + n[1] / 2) * n[0] + n[0] / 2] == 65535);
    uint32_t seen = 0;
    for (uint32_t z = 0; z < n[2]; z++)
        for (uint32_t y = 0; y < n[1]; y++)
            for (uint32_t x = 0; x < n[0]; x++) {
                const uint32_t at[3] = {x, y, z};
                double far = 0, out = 0;
                for (int k = 0; k < 3; k++) {
                    double middle = info->grid_origin_m[k] + (at[k] + 0.5) * voxel;
                    far = fmax(far, fabs(middle));
                    out = fmax(out, fabs(middle) + voxel);
                }
                if (far < h + voxel || out > 1) continue;
                seen++;
                CHECK_NEAR(density[((size_t)z * n[1] + y) * n[0] + x] * unit / 65535, rest,
                           0.5 * unit / 65535 + 1e-5 * rest);
            }
    CHECK(seen > 1000);
}

int main(int argc, char **argv)
{
    al_file *file = NULL;
    al_translucent_info info;
    al_error error = {0};
    if (argc != 4) return 2;
    double h = 2 / atof(argv[2]), rest = atof(argv[3]);
    if (al_file_open(argv[1], NULL, &file, &error) || al_translucent_read(file, &info, &error)) {
        fprintf(stderr, "%s\n", error.message);
        return 1;
    }
    check_samples(file, &info, h, rest);
    check_densities(file, &info, h, rest);
    al_file_close(file);
    return test_end();
}
