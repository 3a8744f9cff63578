/* In one medium all events together depend on dq = sigma_t d alone, times sigma_t^2 for points and areas
 * (docs/methods.md). Of a response r(l, m) about the direction to the emitter the irradiance about a normal n
 * is
 *
 *   E = sum of A(l) r(l, m) Y(l, m; n),   A = pi, 2 pi/3, pi/4, 0, -pi/24 for l = 0 to 4,
 *
 * A the clamped cosine's coefficients (Ramamoorthi and Hanrahan 2001). Bands above 4 bring at most 1.5 % of
 * the unscattered beam's irradiance and are left out. What is left are nine numbers A(l) r(l, m) N(l, m),
 * which are tabulated over ln dq and sign(c) sqrt|c| of the emitter's cosine c, divided by falloff() below so
 * that linear interpolation serves, and multiplied with polynomials in n_z and n_x. */
#include "gather_kernel.h"

#include <math.h>
#include <stdlib.h>

#include "airlight/formulas.h"

enum { DISTANCES = 256, COSINES = 33, NUMBERS = 9 };
static const double least = 1e-5, most = 60; /* mean free paths; beyond, the falloff goes on */

struct al_gather_kernel {
    float point[DISTANCES][NUMBERS], sun[DISTANCES][NUMBERS]; /* m = 0 only: the first four */
    float area[COSINES][DISTANCES][NUMBERS];
    double log_least, per_step;
};

/* Follows the first event: 1/d of a point near it, exp(-d)/d^2 far away. Only a directional light does not
 * thin out by distance. */
static double falloff(al_impulse_emitter emitter, double d)
{
    return emitter == AL_IMPULSE_DIRECTIONAL ? exp(-d) : exp(-d) / (d * (1 + d));
}

static void fill_entry(const al_impulse_tables *tables, const al_impulse_query *query, float out[NUMBERS])
{
    /* A(l) N(l, m) in the order of al_gather_kernel_irradiance. */
    static const struct {
        int m, l;
        double factor;
    } terms[NUMBERS] = {
        {0, 0, AL_PI * 0.28209479177387814},        {0, 1, 2 * AL_PI / 3 * 0.4886025119029199},
        {0, 2, AL_PI / 4 * 0.31539156525252005},    {0, 4, -AL_PI / 24 * 0.10578554691520431},
        {1, 1, 2 * AL_PI / 3 * 0.4886025119029199}, {1, 2, AL_PI / 4 * 1.0925484305920792},
        {1, 4, -AL_PI / 24 * 0.6690465435572892},   {2, 2, AL_PI / 4 * 0.5462742152960396},
        {2, 4, -AL_PI / 24 * 0.47308734787878004}};
    al_impulse_answer answer;
    double scale = falloff(query->emitter, query->distance_m);
    al_impulse_response(tables, query, &answer);
    for (int n = 0; n < NUMBERS; n++) {
        bool given = (uint32_t)terms[n].m < answer.m_count && (uint32_t)terms[n].l < answer.band_count;
        out[n] = given ? (float)(terms[n].factor * answer.sh[terms[n].m][terms[n].l] / scale) : 0;
    }
}

al_gather_kernel *al_gather_kernel_create(const al_impulse_tables *tables, double albedo, double g)
{
    al_gather_kernel *kernel = malloc(sizeof *kernel);
    if (!kernel) return NULL;
    kernel->log_least = log(least);
    kernel->per_step = (DISTANCES - 1) / log(most / least);
    al_impulse_query query = {.first_event = 1,
                              .last_event = al_impulse_tables_info(tables)->event_count,
                              .sigma_s_per_m = albedo,
                              .sigma_a_per_m = 1 - albedo,
                              .g = g,
                              .cos_normal = 1};
    for (int i = 0; i < DISTANCES; i++) {
        query.distance_m = exp(kernel->log_least + i / kernel->per_step);
        query.emitter = AL_IMPULSE_POINT;
        fill_entry(tables, &query, kernel->point[i]);
        query.emitter = AL_IMPULSE_DIRECTIONAL;
        fill_entry(tables, &query, kernel->sun[i]);
        query.emitter = AL_IMPULSE_AREA;
        for (int k = 0; k < COSINES; k++) {
            double u = 2.0 * k / (COSINES - 1) - 1;
            query.cos_normal = u * fabs(u);
            fill_entry(tables, &query, kernel->area[k][i]);
        }
    }
    return kernel;
}

void al_gather_kernel_free(al_gather_kernel *kernel)
{
    free(kernel);
}

/* Adds an entry between two distances. */
static void add_between(const float entries[][NUMBERS], int first, float share, float weight,
                        float numbers[NUMBERS])
{
    const float *a = entries[first], *b = entries[first + 1];
    for (int n = 0; n < NUMBERS; n++) numbers[n] += weight * (a[n] + share * (b[n] - a[n]));
}

double al_gather_kernel_irradiance(const al_gather_kernel *kernel, al_impulse_emitter emitter,
                                   double distance_m, double cos_normal, double sigma_t_per_m,
                                   double normal_z, double normal_x)
{
    double d = sigma_t_per_m * distance_m, z = normal_z, x = normal_x, z2 = z * z;
    double at = fmin(fmax((log(d) - kernel->log_least) * kernel->per_step, 0), DISTANCES - 1.0001);
    int first = (int)at;
    float share = (float)(at - first), numbers[NUMBERS] = {0}, *c = numbers;
    if (!(d > 0)) return 0;
    double scale =
        falloff(emitter, d) * (emitter == AL_IMPULSE_DIRECTIONAL ? 1 : sigma_t_per_m * sigma_t_per_m);
    if (emitter == AL_IMPULSE_AREA) {
        double u = copysign(sqrt(fabs(cos_normal)), cos_normal), row = 0.5 * (u + 1) * (COSINES - 1);
        row = fmin(fmax(row, 0), COSINES - 1.0001);
        int k = (int)row;
        add_between(kernel->area[k], first, share, (float)(1 - (row - k)), numbers);
        add_between(kernel->area[k + 1], first, share, (float)(row - k), numbers);
    } else {
        add_between(emitter == AL_IMPULSE_POINT ? kernel->point : kernel->sun, first, share, 1, numbers);
    }
    double even = c[0] + c[2] * (3 * z2 - 1) + c[3] * (35 * z2 * z2 - 30 * z2 + 3) + c[1] * z;
    double once = x * (c[4] + c[5] * z + c[6] * z * (7 * z2 - 3));
    double twice = (2 * x * x + z2 - 1) * (c[7] + c[8] * (7 * z2 - 1));
    return scale * (even + once + twice);
}
