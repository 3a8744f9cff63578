/* In one medium all events together depend on dq = sigma_t d alone, times sigma_t^2 for points and areas
 * (docs/methods.md). Of a response r(l, m) about the direction to the emitter the irradiance about a normal n
 * is
 *
 *   E = sum of A(l) r(l, m) Y(l, m; n),   A = pi, 2 pi/3, pi/4, 0, -pi/24 for l = 0 to 4,
 *
 * A the clamped cosine's coefficients (Ramamoorthi and Hanrahan 2001). Bands above 4 bring at most 1.5 % of
 * the unscattered beam's irradiance and are left out. What is left is a polynomial in z = n . direction and,
 * for an area whose normal has cosine c and sine s to the direction, in y = s n_x, which needs no axis x:
 *
 *   E = a0 + a1 z + a2 z^2 + a3 z^4 + y (a4 + a5 z + a6 z^3) + (2 y^2 - s^2 (1 - z^2)) (a7 + a8 z^2),
 *
 * as Y(l, m) has the factor n_x^m (m = 2: 2 n_x^2 + z^2 - 1) and r(l, m) the factor s^m.
 *
 * A look-up is to cost little beside a ray, so float arithmetic finds the numbers, without a logarithm and in
 * few cache lines: linear between dq in equal parts of every octave, which are the exponent and first digits
 * of a float; cubic in sqrt|c|, which both sides of the area have apart, as the response may bend in its
 * plane. They are divided by falloff() below, so that this errs by 0.7 % of the fluence (|g| up to 0.5). */
#include "gather_kernel.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/formulas.h"

enum {
    DIGITS = 4, /* an octave has 2^DIGITS parts */
    FIRST_OCTAVE = -17,
    END_OCTAVE = 6, /* 7.6e-6 to 64 mean free paths; beyond, the falloff goes on */
    DISTANCES = ((END_OCTAVE - FIRST_OCTAVE) << DIGITS) + 1,
    COSINES = 7,       /* of a side */
    POINT_NUMBERS = 4, /* a0 to a3: m = 0 */
    AREA_NUMBERS = 9   /* a4 to a6: m = 1; a7, a8: m = 2 */
};

struct al_gather_kernel {
    float point[DISTANCES][POINT_NUMBERS], sun[DISTANCES][POINT_NUMBERS];
    float area[2][DISTANCES][COSINES][AREA_NUMBERS]; /* before the area, behind it */
};

/* Follows the first event: 1/d of a point near it, exp(-d)/d^2 far away. Only a directional light does not
 * thin out by distance. */
static double falloff(al_impulse_emitter emitter, double depth, double transmittance)
{
    return emitter == AL_IMPULSE_DIRECTIONAL ? transmittance : transmittance / (depth * (1 + depth));
}

/* A(l) r(l, m) N(l, m), N the constant of Y(l, m). */
static double term(const al_impulse_answer *answer, uint32_t m, uint32_t l)
{
    static const double bands[] = {AL_PI, 2 * AL_PI / 3, AL_PI / 4, 0, -AL_PI / 24};
    static const double constants[3][5] = {
        {0.28209479177387814, 0.4886025119029199, 0.31539156525252005, 0, 0.10578554691520431},
        {0, 0.4886025119029199, 1.0925484305920792, 0, 0.6690465435572892},
        {0, 0, 0.5462742152960396, 0, 0.47308734787878004}};
    return m < answer->m_count && l < answer->band_count ? bands[l] * constants[m][l] * answer->sh[m][l] : 0;
}

static void fill_entry(const al_impulse_tables *tables, const al_impulse_query *query, int count, float out[])
{
    al_impulse_answer answer;
    al_impulse_response(tables, query, &answer);
    double four[] = {term(&answer, 0, 4), term(&answer, 1, 4), term(&answer, 2, 4)};
    double two = term(&answer, 0, 2);
    double numbers[AREA_NUMBERS] = {term(&answer, 0, 0) - two + 3 * four[0],
                                    term(&answer, 0, 1),
                                    3 * two - 30 * four[0],
                                    35 * four[0],
                                    term(&answer, 1, 1),
                                    term(&answer, 1, 2) - 3 * four[1],
                                    7 * four[1],
                                    term(&answer, 2, 2) - four[2],
                                    7 * four[2]};
    double d = query->distance_m, sine = sqrt(1 - query->cos_normal * query->cos_normal);
    double scale = 1 / falloff(query->emitter, d, exp(-d));
    for (int n = 0; n < count; n++)
        out[n] = (float)(scale * numbers[n] / (n < 4 ? 1 : n < 7 ? sine : sine * sine)); /* over s^m */
}

al_gather_kernel *al_gather_kernel_create(const al_impulse_tables *tables, double albedo, double g)
{
    al_gather_kernel *kernel = malloc(sizeof *kernel);
    if (!kernel) return NULL;
    al_impulse_query query = {.first_event = 1,
                              .last_event = al_impulse_tables_info(tables)->event_count,
                              .sigma_s_per_m = albedo,
                              .sigma_a_per_m = 1 - albedo,
                              .g = g};
    for (int i = 0; i < DISTANCES; i++) {
        int octave = i >> DIGITS, part = i - (octave << DIGITS);
        query.distance_m = ldexp(1 + ldexp(part, -DIGITS), FIRST_OCTAVE + octave);
        query.cos_normal = 0;
        query.emitter = AL_IMPULSE_POINT;
        fill_entry(tables, &query, POINT_NUMBERS, kernel->point[i]);
        query.emitter = AL_IMPULSE_DIRECTIONAL;
        fill_entry(tables, &query, POINT_NUMBERS, kernel->sun[i]);
        query.emitter = AL_IMPULSE_AREA;
        for (int k = 0; k < COSINES; k++) {
            double root = k / (COSINES - 1.0), cosine = fmin(root * root, 1 - 1e-9); /* so that s > 0 */
            query.cos_normal = cosine;
            fill_entry(tables, &query, AREA_NUMBERS, kernel->area[0][i][k]);
            query.cos_normal = -cosine;
            fill_entry(tables, &query, AREA_NUMBERS, kernel->area[1][i][k]);
        }
    }
    return kernel;
}

void al_gather_kernel_free(al_gather_kernel *kernel)
{
    free(kernel);
}

/* The last entry not beyond the depth, and the share of the way to the next. */
static int find_distance(float depth, float *share)
{
    const float least = 0x1p-17f, most = 0x1.fffffep5f; /* FIRST_OCTAVE, just below END_OCTAVE */
    const int shift = 23 - DIGITS;
    uint32_t bits;
    depth = depth > least ? depth : least;
    depth = depth < most ? depth : most;
    memcpy(&bits, &depth, sizeof bits);
    bits -= (uint32_t)(127 + FIRST_OCTAVE) << 23;
    *share = (float)(bits & ((1u << shift) - 1)) / (float)(1u << shift);
    return (int)(bits >> shift);
}

/* The first of four cosines, and their weights. */
static int find_cosine(float cosine, float weights[4])
{
    float place = (COSINES - 1) * sqrtf(fabsf(cosine));
    int first = (int)place - 1;
    first = first < 0 ? 0 : first > COSINES - 4 ? COSINES - 4 : first;
    float a = place - (float)first, b = a - 1, c = a - 2, d = a - 3;
    weights[0] = -b * c * d / 6, weights[1] = a * c * d / 2, weights[2] = -a * b * d / 2;
    weights[3] = a * b * c / 6;
    return first;
}

static float zonal(const float a[POINT_NUMBERS], float z)
{
    return a[0] + z * (a[1] + z * (a[2] + z * z * a[3]));
}

static float zonal_irradiance(const float (*entries)[POINT_NUMBERS], float share, float z)
{
    float a[POINT_NUMBERS];
    for (int n = 0; n < POINT_NUMBERS; n++) a[n] = entries[0][n] + share * (entries[1][n] - entries[0][n]);
    return zonal(a, z);
}

static float area_irradiance(const float (*entries)[COSINES][AREA_NUMBERS], float share, float c, float z,
                             float y)
{
    float weights[4], a[AREA_NUMBERS];
    int first = find_cosine(c, weights);
    for (int n = 0; n < AREA_NUMBERS; n++) {
        float nearer = 0, farther = 0;
        for (int k = 0; k < 4; k++) {
            nearer += weights[k] * entries[0][first + k][n];
            farther += weights[k] * entries[1][first + k][n];
        }
        a[n] = nearer + share * (farther - nearer);
    }
    float once = y * (a[4] + z * (a[5] + z * z * a[6]));
    float twice = (2 * y * y - (1 - c * c) * (1 - z * z)) * (a[7] + a[8] * z * z);
    return zonal(a, z) + once + twice;
}

double al_gather_kernel_irradiance(const al_gather_kernel *kernel, const al_gather_kernel_query *query)
{
    float share, irradiance, z = (float)query->normal_z;
    int i = find_distance((float)query->depth, &share);
    if (query->emitter == AL_IMPULSE_AREA)
        irradiance = area_irradiance(kernel->area[query->cos_normal < 0] + i, share, (float)query->cos_normal,
                                     z, (float)query->normal_across);
    else if (query->emitter == AL_IMPULSE_POINT)
        irradiance = zonal_irradiance(kernel->point + i, share, z);
    else
        irradiance = zonal_irradiance(kernel->sun + i, share, z);
    return falloff(query->emitter, query->depth, query->transmittance) * irradiance;
}
