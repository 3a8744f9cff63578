/* The default tables against laws that hold whatever the numbers: conservation of energy, event by event; the
 * mean over an area's orientations; scaling to other media; extremes. Bounds: 0.2 % of band 0, the promise for
 * each number that goes in, unless said otherwise. */
#include "tables.h"

enum { EVENTS = 10 };

static const double promised = 2e-3;

static double ask(const al_impulse_tables *tables, al_impulse_emitter emitter, double d, uint32_t event, int l)
{
    al_impulse_answer a;
    al_impulse_query q = canonical(emitter, d, event, event);
    al_impulse_response(tables, &q, &a);
    return l == 0 ? fluence(&a) : flux_z(&a);
}

/* Without absorption the flux through a sphere grows by what the medium scatters towards event k and loses what it
 * scatters on: d^2 F_k(d) = int_0^d (phi_(k-1) - phi_k) r^2 dr, and for all events together
 * d^2 (F_0 + ... + F_10) = 1 - int_0^d phi_10 r^2 dr, which the exact orders obey; F_0 = phi_0 = exp(-d)/d^2, so the
 * scattered events alone tend to (1 - exp(-d))/d^2. */
static void test_point_energy(const al_impulse_tables *tables)
{
    enum { STEPS = 3000 };
    static const double distances[] = {0.03, 0.3, 1, 3, 8};
    double worst = 0;
    for (int i = 0; i < 5; i++) {
        double d = distances[i], integrals[EVENTS + 1] = {0}, sum = exp(-d), area = d * d;
        for (int s = 0; s < STEPS; s++) { /* midpoints in u, r = d u^2 */
            double u = (s + 0.5) / STEPS, r = d * u * u, weight = 2 * d * u / STEPS;
            for (uint32_t k = 0; k <= EVENTS; k++)
                integrals[k] += weight * r * r * ask(tables, AL_IMPULSE_POINT, r, k, 0);
        }
        for (uint32_t k = 1; k <= EVENTS; k++) {
            double flux = area * ask(tables, AL_IMPULSE_POINT, d, k, 1),
                   scale = area * ask(tables, AL_IMPULSE_POINT, d, k, 0);
            worst = fmax(worst, fabs(flux - (integrals[k - 1] - integrals[k])) / scale);
            sum += flux;
        }
        CHECK_NEAR(sum, 1 - integrals[EVENTS], promised);
        CHECK_NEAR(sum - exp(-d), 1 - exp(-d) - integrals[EVENTS], promised);
        if (d < 0.5) CHECK_NEAR(sum, 1, 0.01); /* what ten events leave out there */
    }
    printf("point, energy event by event: %.1e of the fluence\n", worst);
    CHECK(worst < promised);
}

/* A half-space: towards the light the flux of event k at depth d is what comes up from below,
 * F_k(d) = int_d^inf (phi_k - phi_(k-1)) dx, F counted downwards (positive zh 1: light from above). */
static void test_directional_energy(const al_impulse_tables *tables)
{
    enum { STEPS = 6000 };
    static const double depths[] = {1e-5, 0.02, 0.4, 2, 6};
    double worst = 0;
    for (int i = 0; i < 5; i++)
        for (uint32_t k = 1; k <= EVENTS; k++) {
            double d = depths[i], end = 60, integral = 0;
            for (int s = 0; s < STEPS; s++) {
                double u = (s + 0.5) / STEPS, x = d + (end - d) * u * u, weight = 2 * (end - d) * u / STEPS;
                integral += weight * (ask(tables, AL_IMPULSE_DIRECTIONAL, x, k, 0) -
                                      ask(tables, AL_IMPULSE_DIRECTIONAL, x, k - 1, 0));
            }
            worst = fmax(worst, fabs(ask(tables, AL_IMPULSE_DIRECTIONAL, d, k, 1) - integral) /
                                    ask(tables, AL_IMPULSE_DIRECTIONAL, d, k, 0));
        }
    printf("directional, energy event by event: %.1e of the fluence\n", worst);
    CHECK(worst < promised);
}

/* Averaged over all orientations of its normal an area is a point of 1/4 W/sr: max(0, n.v) averages to 1/4. */
static void test_mean_area(const al_impulse_tables *tables)
{
    enum { STEPS = 400 };
    static const double distances[] = {1e-4, 0.05, 0.7, 3, 12};
    double worst = 0;
    for (int i = 0; i < 5; i++)
        for (uint32_t k = 1; k <= EVENTS; k++) {
            al_impulse_answer point, area;
            double mean[16] = {0}, error = 0;
            al_impulse_query q = canonical(AL_IMPULSE_POINT, distances[i], k, k);
            al_impulse_response(tables, &q, &point);
            q.emitter = AL_IMPULSE_AREA;
            for (int s = 0; s < STEPS; s++) {
                q.cos_normal = -1 + 2 * (s + 0.5) / STEPS;
                al_impulse_response(tables, &q, &area);
                for (int l = 0; l < 11; l++) mean[l] += area.sh[0][l] / STEPS;
            }
            for (int l = 0; l < 11; l++) error = fmax(error, fabs(4 * mean[l] - point.sh[0][l]));
            worst = fmax(worst, error / point.sh[0][0]);
        }
    printf("area, mean over orientations against the point, all events and bands: %.1e of band 0\n", worst);
    CHECK(worst < promised);
}

/* Scaling: sigma_t^2 (sigma_s/sigma_t)^k at sigma_t d; from event 2 on with (1 - g) sigma_s. */
static void test_scaling(const al_impulse_tables *tables)
{
    for (int emitter = 0; emitter < 3; emitter++)
        for (uint32_t k = 1; k <= 4; k++) {
            al_impulse_answer a, b;
            double s = 0.6, absorption = 0.15, g = k > 1 ? 0.4 : 0, t = absorption + (1 - g) * s;
            al_impulse_query q = canonical((al_impulse_emitter)emitter, 2.5, k, k), unit;
            q.cos_normal = -0.35;
            unit = q;
            q.sigma_s_per_m = s;
            q.sigma_a_per_m = absorption;
            q.g = g;
            unit.distance_m *= t;
            double factor = pow((1 - g) * s / t, k) * (emitter == AL_IMPULSE_DIRECTIONAL ? 1 : t * t);
            al_impulse_response(tables, &q, &a);
            al_impulse_response(tables, &unit, &b);
            for (int l = 0; l < 11; l++)
                CHECK_NEAR(a.sh[0][l], factor * b.sh[0][l], 1e-12 * factor * b.sh[0][0]);
        }
    /* The beam: exp(-sigma_t d)/d^2 along the axis, times the cosine of an area. */
    al_impulse_answer a;
    al_impulse_query q = canonical(AL_IMPULSE_AREA, 2, 0, 0);
    q.cos_normal = 0.25;
    q.sigma_a_per_m = 0.5;
    al_impulse_response(tables, &q, &a);
    for (int l = 0; l < 11; l++)
        CHECK_NEAR(a.sh[0][l], 0.25 * exp(-3.0) / 4 * sqrt((2 * l + 1) / (4 * AL_PI)), 1e-15);
}

/* The summed table against the events one by one, in both variants: two interpolations, each to the promise. */
static void test_sum(const al_impulse_tables *tables)
{
    double worst = 0;
    for (int emitter = 0; emitter < 3; emitter++)
        for (int variant = 0; variant < 2; variant++)
            for (double d = 1e-5; d < 100; d *= 1.7) {
                al_impulse_answer all, one, sum = {0};
                al_impulse_query q = canonical((al_impulse_emitter)emitter, d, 1, EVENTS);
                q.cos_normal = 0.3;
                q.variant = (al_impulse_variant)variant;
                al_impulse_response(tables, &q, &all);
                for (q.first_event = 1; q.first_event <= EVENTS; q.first_event++) {
                    q.last_event = q.first_event;
                    al_impulse_response(tables, &q, &one);
                    sum.sh[0][0] += one.sh[0][0];
                }
                worst = fmax(worst, fabs(all.sh[0][0] / sum.sh[0][0] - 1));
            }
    printf("summed table against its events: %.1e\n", worst);
    CHECK(worst < 2 * promised);
}

/* A medium's collapsed table against the look-up of its events; irradiance of normals all around. */
static void test_medium(const al_impulse_tables *tables)
{
    static const double albedos[] = {1, 0.9, 0.3}, gs[] = {0, 0.6, -0.4};
    static const uint32_t firsts[] = {1, 2};
    double worst = 0;
    for (int i = 0; i < 18; i++) {
        const al_impulse_medium_settings s = {.first_event = firsts[i / 9], .last_event = EVENTS,
                                              .albedo = albedos[i % 3], .g = gs[i / 3 % 3]};
        al_impulse_medium *medium;
        al_error error;
        CHECK(al_impulse_medium_make(tables, &s, &medium, &error) == AL_OK);
        for (int k = 0; k < 3 * 40; k++) {
            al_impulse_answer a, b;
            al_impulse_query q = canonical((al_impulse_emitter)(k % 3), 1e-4 * pow(1.4, k / 3.0), s.first_event,
                                           s.last_event);
            double sigma_t = 1.7, angle = 0.37 * k, z = cos(angle), x = sin(angle) * cos(1.1 * k);
            q.cos_normal = sin(0.7 * k);
            q.sigma_s_per_m = sigma_t * s.albedo;
            q.sigma_a_per_m = sigma_t - q.sigma_s_per_m;
            q.g = s.g;
            al_impulse_response(tables, &q, &a);
            al_impulse_medium_response(medium, q.emitter, q.distance_m, q.cos_normal, sigma_t, &b);
            double quick = al_impulse_medium_irradiance(medium, q.emitter, q.distance_m, q.cos_normal, sigma_t, z, x);
            CHECK_NEAR(quick, al_impulse_irradiance(&b, z, x), 1e-5 * fluence(&b));
            for (uint32_t m = 0; m < a.m_count; m++)
                for (int l = 0; l < 11; l++)
                    worst = fmax(worst, fabs(a.sh[m][l] - b.sh[m][l]) / a.sh[0][0]);
        }
        al_impulse_medium_free(medium);
    }
    printf("media against their events: %.1e of band 0\n", worst);
    CHECK(worst < promised);
}

/* Irradiance by bands against the integral over the sphere of the clamped cosine times the harmonics. */
static void test_irradiance(const al_impulse_tables *tables)
{
    enum { STEPS = 600 };
    al_impulse_answer a;
    al_impulse_query q = canonical(AL_IMPULSE_AREA, 0.8, 1, 3);
    const double normal[3] = {0.48, 0.64, 0.6};
    double sum = 0;
    q.cos_normal = 0.3;
    al_impulse_response(tables, &q, &a);
    a.band_count = 7; /* al_sh_basis below has bands 0 to 7 */
    for (int i = 0; i < STEPS; i++)
        for (int k = 0; k < 2 * STEPS; k++) {
            double z = -1 + 2 * (i + 0.5) / STEPS, phi = AL_PI * (k + 0.5) / STEPS, r = sqrt(1 - z * z);
            double x = r * cos(phi), y = r * sin(phi), basis[AL_SH_MAX_COUNT], radiance = 0;
            double cosine = x * normal[0] + y * normal[1] + z * normal[2];
            if (cosine <= 0) continue;
            al_sh_basis(7, x, y, z, basis);
            for (int m = 0; m < 3; m++)
                for (int l = m; l < 7; l++) radiance += a.sh[m][l] * basis[l * (l + 1) + m];
            sum += radiance * cosine * 2 / STEPS * AL_PI / STEPS;
        }
    CHECK_NEAR(al_impulse_irradiance(&a, normal[2], normal[0]), sum, 5e-5 * sum); /* midpoints: 1/600^2, 15-fold */
}

/* methods: distances 1e-6 to 1e3, albedo 0, 1 - 1e-6, 1, |g| to 0.99, sigma from 0 to 1e4: finite, and the fluence
 * not negative. */
static void test_extremes(const al_impulse_tables *tables)
{
    static const double distances[] = {1e-6, 1e-3, 1, 30, 1e3}, albedos[] = {0, 0.5, 1 - 1e-6, 1},
                        gs[] = {-0.99, -0.5, 0, 0.7, 0.99}, sigmas[] = {0, 1e-300, 1e-6, 1, 1e4},
                        cosines[] = {-1, -1e-9, 0, 0.5, 1};
    long bad = 0, count = 0;
    for (int i = 0; i < 3 * 2 * 5 * 4 * 5 * 5 * 5; i++) {
        al_impulse_answer a;
        int rest = i;
        al_impulse_query q = {.emitter = (al_impulse_emitter)(rest % 3), .last_event = EVENTS};
        q.variant = (al_impulse_variant)((rest /= 3) % 2);
        q.distance_m = distances[(rest /= 2) % 5];
        double albedo = albedos[(rest /= 5) % 4], sigma = sigmas[(rest /= 4) % 5];
        q.g = gs[(rest /= 5) % 5];
        q.cos_normal = cosines[(rest /= 5) % 5];
        q.sigma_s_per_m = albedo * sigma;
        q.sigma_a_per_m = (1 - albedo) * sigma;
        al_impulse_response(tables, &q, &a);
        double sum = a.axis_angle;
        for (int m = 0; m < 3; m++)
            for (int l = 0; l < 11; l++) sum += a.sh[m][l];
        double e = al_impulse_irradiance(&a, 0.6, 0.8);
        bad += !isfinite(sum) || !isfinite(e) || !(a.sh[0][0] >= 0);
        count++;
    }
    printf("%ld extremes, %ld wrong\n", count, bad);
    CHECK(bad == 0);
    /* Vacuum: the beam alone, whole. */
    al_impulse_answer a;
    al_impulse_query q = {.emitter = AL_IMPULSE_POINT, .last_event = EVENTS, .distance_m = 2};
    al_impulse_response(tables, &q, &a);
    CHECK_NEAR(fluence(&a), 0.25, 1e-15);
    q.first_event = 1;
    al_impulse_response(tables, &q, &a);
    CHECK(a.sh[0][0] == 0);
}

int main(int argc, char **argv)
{
    if (argc < 2) return 2;
    al_impulse_tables *tables = tables_open(argv[1]);
    test_point_energy(tables);
    test_directional_energy(tables);
    test_mean_area(tables);
    test_scaling(tables);
    test_sum(tables);
    test_medium(tables);
    test_irradiance(tables);
    test_extremes(tables);
    al_impulse_tables_free(tables);
    return test_end();
}
