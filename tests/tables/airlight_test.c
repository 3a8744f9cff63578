/* The airlight integral along one ray: against a sum over the ray itself, and, over all directions, against the
 * table of event 1. */
#include <stdbool.h>

#include "airlight/sh.h"
#include "tables.h"

/* The integral over t in its own variable, midpoints of t = end u^2 split at the point nearest to the emitter,
 * towards which the points crowd. Relative error below 1e-6 at these counts. */
static double sum_over_ray(const al_impulse_ray *ray)
{
    enum { STEPS = 40000 };
    double sigma_t = ray->sigma_s_per_m + ray->sigma_a_per_m, d = ray->distance_m, z = ray->direction_z;
    double end = fmin(ray->length_m, d + 60 / sigma_t), near = fmin(fmax(d * z, 0), end), sum = 0;
    double side = sqrt(fmax(0, 1 - z * z)), across = d * side;
    for (int part = 0; part < 2; part++) {
        double span = part ? end - near : near, top = asinh(span / across);
        for (int i = 0; i < STEPS && span > 0; i++) { /* |t - d z| = across sinh(u) where near = d z */
            double u = top * (i + 0.5) / STEPS, offset = across * sinh(u);
            double t = part ? near + offset : near - offset, weight = top / STEPS * across * cosh(u);
            double p[3] = {t * ray->direction_x, 0, t * z - d}; /* from the emitter */
            double r = sqrt(t * t + d * d - 2 * t * d * z), cosine = (d * z - t) / r;
            double c = ray->cos_normal, s = sqrt(1 - c * c), light = 1;
            if (ray->emitter == AL_IMPULSE_AREA) light = fmax(0, (s * p[0] - c * p[2]) / r);
            sum += weight * light * al_phase(ray->g, cosine) * exp(-sigma_t * (t + r)) / (r * r);
        }
    }
    return ray->sigma_s_per_m * sum;
}

static void test_rays(void)
{
    static const double distances[] = {0.01, 1, 20}, lengths[] = {0.3, 1.2, 50}, angles[] = {0.01, 0.3, 1.3, 2, 3.1},
                        gs[] = {0, 0.5, -0.7, 0.95, 0.99, -0.99}, sigmas[] = {0.001, 0.5, 4};
    double worst[2] = {0};
    for (int i = 0; i < 3 * 3 * 5 * 6 * 3 * 2; i++) {
        int rest = i;
        double d = distances[rest % 3], angle = angles[(rest /= 3) % 5], g = gs[(rest /= 5) % 6];
        al_impulse_ray ray = {.distance_m = d, .direction_z = cos(angle), .direction_x = 0.8 * sin(angle), .g = g};
        ray.length_m = d * lengths[(rest /= 6) % 3];
        ray.sigma_s_per_m = 0.7 * sigmas[(rest /= 3) % 3];
        ray.sigma_a_per_m = 0.3 * sigmas[rest % 3];
        bool area = (rest / 3) % 2;
        ray.emitter = area ? AL_IMPULSE_AREA : AL_IMPULSE_POINT;
        ray.cos_normal = 0.4;
        double wanted = sum_over_ray(&ray), value = al_impulse_airlight(&ray);
        if (wanted > 1e-200) worst[area] = fmax(worst[area], fabs(value / wanted - 1));
    }
    printf("airlight along rays: point %.1e, area %.1e\n", worst[0], worst[1]);
    CHECK(worst[0] < 1e-4);
    CHECK(worst[1] < 1e-2);
}

/* Light in a half-space, closed form: radiance from straight up at depth d is sigma_s p d exp(-sigma_t d), and the
 * length bounds it. */
static void test_directional(void)
{
    al_impulse_ray ray = {.emitter = AL_IMPULSE_DIRECTIONAL, .distance_m = 3, .direction_z = 1, .length_m = INFINITY,
                          .sigma_s_per_m = 0.5, .sigma_a_per_m = 0.25, .g = 0.3};
    CHECK_NEAR(al_impulse_airlight(&ray), 0.5 * al_phase(0.3, 1) * 3 * exp(-0.75 * 3), 1e-15);
    ray.length_m = 1;
    CHECK_NEAR(al_impulse_airlight(&ray), 0.5 * al_phase(0.3, 1) * exp(-0.75 * 3), 1e-15);
    ray.direction_z = -0.6;
    ray.length_m = INFINITY;
    CHECK_NEAR(al_impulse_airlight(&ray), 0.5 * al_phase(0.3, -0.6) * exp(-2.25) / (0.75 * 1.6), 1e-15);
}

/* Rays of all directions and no end: the ZH of event 1, as the table has them. */
static void test_table(const al_impulse_tables *tables)
{
    enum { STEPS = 4000 };
    for (int emitter = 0; emitter < 2; emitter++) {
        double zh[11] = {0};
        al_impulse_answer a;
        al_impulse_query q = canonical((al_impulse_emitter)emitter, 0.9, 1, 1);
        q.g = 0.6;
        al_impulse_response(tables, &q, &a);
        for (int i = 0; i < STEPS; i++) {
            double theta = AL_PI * (i + 0.5) / STEPS, column[11];
            al_impulse_ray ray = {.emitter = (al_impulse_emitter)emitter, .distance_m = 0.9, .cos_normal = 1,
                                  .direction_z = cos(theta), .direction_x = sin(theta), .length_m = INFINITY,
                                  .sigma_s_per_m = 1, .g = 0.6};
            double weight = 2 * AL_PI * sin(theta) * AL_PI / STEPS * al_impulse_airlight(&ray);
            al_sh_column(0, 11, cos(theta), column);
            for (int l = 0; l < 11; l++) zh[l] += weight * column[l];
        }
        double error = band_error(&a, zh);
        printf("airlight of all directions against the table of emitter %d: %.1e of band 0\n", emitter, error);
        CHECK(error < 2e-3);
    }
}

static void test_extremes(void)
{
    static const double numbers[] = {1e-6, 1e-3, 1, 1e3, 1e4};
    for (int i = 0; i < 5 * 5 * 5 * 5; i++) {
        al_impulse_ray ray = {.emitter = (al_impulse_emitter)(i % 3), .distance_m = numbers[i % 5], .cos_normal = -1,
                              .direction_z = i % 7 == 0 ? 1 : i % 7 == 1 ? -1 : 0.5, .length_m = numbers[i / 5 % 5],
                              .sigma_s_per_m = numbers[i / 25 % 5], .sigma_a_per_m = i / 125 % 2, .g = i / 125 ? -0.99 : 0.99};
        ray.direction_x = sqrt(1 - ray.direction_z * ray.direction_z);
        double value = al_impulse_airlight(&ray);
        CHECK(isfinite(value) && value >= 0);
        ray.sigma_s_per_m = 0;
        CHECK(al_impulse_airlight(&ray) == 0);
    }
}

int main(int argc, char **argv)
{
    if (argc < 2) return 2;
    al_impulse_tables *tables = tables_open(argv[1]);
    test_rays();
    test_directional();
    test_table(tables);
    test_extremes();
    al_impulse_tables_free(tables);
    return test_end();
}
