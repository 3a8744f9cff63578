/* Looking up impulse responses.
 *
 * Scaling. Lengths in mean free paths: with x = sigma_t y the canonical medium (sigma_s = sigma_t = 1)
 * differs from any other by one factor sigma_s/sigma_t for each event, and the inverse square of a point's
 * (and an area's) irradiance by sigma_t^2. So L(d) = sigma_t^2 (sigma_s/sigma_t)^k L_canonical(sigma_t d),
 * without the square for a directional light. (The paper's sigma ratio, section 4.3.)
 *
 * Phase functions. Event 1 is linear in the phase function p. A resolved table splits the isotropic response
 * into the shares of the angles of scattering, so that the response to p is the sum of shares times 4 pi p.
 */
#include <assert.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "airlight/formulas.h"
#include "airlight/sh.h"
#include "impulse.h"

/* Near, the first event's fluence is pi^2/(4 d), the second's grows like -ln d, later ones are finite; a
 * directional light's are finite near the plane. Far, event k falls like exp(-d) (ln 2d)^k, over d^2 for a
 * point: over the distances that matter the power of the logarithm is close to (1 + d)^(k/3). */
double al_impulse_falloff(uint32_t emitter, uint32_t first_event, uint32_t last_event, double d)
{
    double near = fmax(d, 1e-300), far = 1 + d, events = exp(last_event / 3.0 * log(far));
    if (emitter == AL_IMPULSE_DIRECTIONAL) return events;
    if (first_event == 0) return events / (near * near);
    if (first_event == 1) return events / (near * far);
    return (first_event == 2 ? 1 + log1p(1 / near) : 1) * events / (far * far);
}

/* The asymptote in a medium, sigma_t^2 exp(-sigma_t d) falloff(sigma_t d), without overflow where sigma_t d
 * is tiny. */
static double asymptote(const al_impulse_query *q, uint32_t first_event, uint32_t last_event, double sigma_t)
{
    double d = q->distance_m, dq = sigma_t * d;
    if (q->emitter == AL_IMPULSE_DIRECTIONAL || first_event > 1)
        return exp(-dq) * al_impulse_falloff(q->emitter, first_event, last_event, dq) *
               (q->emitter == AL_IMPULSE_DIRECTIONAL ? 1 : sigma_t * sigma_t);
    double events = exp(last_event / 3.0 * log1p(dq) - dq);
    return first_event == 0 ? events / (d * d) : events * sigma_t / (d * (1 + dq));
}

/* --- interpolation: cubic through the four nearest values of an axis with equal steps --- */

/* At `place` in steps, from the nodes low to high. */
static al_impulse_stencil stencil_at(double place, uint32_t low, uint32_t high)
{
    double base = fmin(fmax(floor(place) - 1, low), high - 3.0), f = place - base;
    double a = f, b = f - 1, c = f - 2, d = f - 3;
    return (al_impulse_stencil){
        (uint32_t)base, 4, {-b * c * d / 6, a * c * d / 2, -a * b * d / 2, a * b * c / 6}};
}

al_impulse_stencil al_impulse_distances(const al_impulse_info *info, uint32_t count, double distance)
{
    double low = log(info->distance_min), high = log(info->distance_max);
    double share = (log(fmax(distance, 1e-300)) - low) / (high - low);
    return stencil_at(fmin(fmax(share, 0), 1) * (count - 1), 0, count - 1);
}

/* A kink of the response may lie at cos_normal 0: the two sides are interpolated apart. */
al_impulse_stencil al_impulse_cosines(uint32_t count, double cosine)
{
    uint32_t half = (count - 1) / 2;
    if (count == 1) return (al_impulse_stencil){0, 1, {1}};
    double root = sqrt(fmin(fabs(cosine), 1)), place = (1 + (cosine < 0 ? -root : root)) * half;
    return cosine < 0 ? stencil_at(place, 0, half) : stencil_at(place, half, 2 * half);
}

/* Adds weight times the interpolated numbers of one angle's share. */
static void gather(const al_impulse_table *t, uint32_t angle, const al_impulse_stencil *cosines,
                   const al_impulse_stencil *distances, double weight, double *numbers)
{
    size_t row = (size_t)t->distance_count * t->number_count;
    const float *share = t->values + (size_t)angle * t->cosine_count * row;
    for (uint32_t c = 0; c < cosines->count; c++)
        for (uint32_t d = 0; d < 4; d++) {
            const float *entry =
                share + (cosines->first + c) * row + (size_t)(distances->first + d) * t->number_count;
            double w = weight * cosines->weights[c] * distances->weights[d];
            for (uint32_t n = 0; n < t->number_count; n++) numbers[n] += w * entry[n];
        }
}

static void look_up(const al_impulse_info *info, const al_impulse_table *t, double distance, double cosine,
                    double weight, double *numbers)
{
    al_impulse_stencil cosines = al_impulse_cosines(t->cosine_count, cosine),
                       distances = al_impulse_distances(info, t->distance_count, distance);
    gather(t, 0, &cosines, &distances, weight, numbers);
}

/* --- phase functions --- */

/* 4 pi p at the angle s of scattering with ln tan(s/2) = y: cos s = -tanh y. */
static double relative_phase(const al_impulse_query *q, double y)
{
    if (!q->moments) {
        /* 1 + g^2 - 2 g cos s = (1 - g)^2 + 2 g (1 - cos s), 1 - cos s = 2/(1 + exp(-2 y)): nothing cancels
         */
        double square = (1 - q->g) * (1 - q->g) + 4 * q->g / (1 + exp(-2 * y));
        return (1 - q->g * q->g) / (square * sqrt(square));
    }
    double cosine = -tanh(y), below = 0, here = 1, sum = 0;
    for (uint32_t n = 0; n < q->moment_count; n++) {
        sum += (2 * n + 1) * q->moments[n] * here;
        double next = ((2 * n + 1) * cosine * here - n * below) / (n + 1);
        below = here;
        here = next;
    }
    return sum;
}

/* Event 1 by the shares of its angles; what isotropic scattering gives comes from the finer table of its own,
 * so that the shares carry only the difference. */
static void look_up_resolved(const al_impulse_tables *tables, const al_impulse_query *q, double distance,
                             double *numbers)
{
    const al_impulse_table *t = tables->resolved[q->emitter];
    al_impulse_stencil cosines = al_impulse_cosines(t->cosine_count, q->cos_normal),
                       distances = al_impulse_distances(&tables->info, t->distance_count, distance);
    look_up(&tables->info, tables->events[q->emitter][AL_IMPULSE_AXIS_EMITTER][1], distance, q->cos_normal, 1,
            numbers);
    for (uint32_t a = 0; a < t->angle_count; a++)
        gather(t, a, &cosines, &distances, relative_phase(q, t->angles[a]) - 1, numbers);
}

/* Event 1 as published: linear between the two nearest g that are tabulated, constant beyond them. */
static void look_up_phases(const al_impulse_tables *tables, const al_impulse_query *q, uint32_t axis,
                           double distance, double *numbers)
{
    const al_impulse_table *const *list = tables->phases[q->emitter][axis];
    uint32_t count = tables->phase_counts[q->emitter][axis], above = 0;
    while (above < count && list[above]->g < q->g) above++;
    if (above == 0 || above == count) {
        look_up(&tables->info, list[above ? count - 1 : 0], distance, q->cos_normal, 1, numbers);
        return;
    }
    double low = list[above - 1]->g, share = (q->g - low) / (list[above]->g - low);
    look_up(&tables->info, list[above - 1], distance, q->cos_normal, 1 - share, numbers);
    look_up(&tables->info, list[above], distance, q->cos_normal, share, numbers);
}

static double mean_cosine(const al_impulse_query *q)
{
    if (!q->moments) return q->g;
    return q->moment_count > 1 ? q->moments[1] : 0;
}

static bool is_isotropic(const al_impulse_query *q)
{
    bool isotropic = q->moments || q->g == 0;
    for (uint32_t n = 1; q->moments && n < q->moment_count; n++) isotropic = isotropic && q->moments[n] == 0;
    return isotropic;
}

/* --- one answer --- */

/* A fitted axis' angle is no radiance. */
static void scale_numbers(uint32_t axis, double scale, double *numbers)
{
    for (uint32_t n = axis == AL_IMPULSE_AXIS_FITTED; n < AL_IMPULSE_NUMBER_LIMIT; n++) numbers[n] *= scale;
}

/* Adds an entry's numbers, which are about the emitter's direction or a fitted axis. */
static void add_numbers(const al_impulse_query *q, uint32_t axis, const double *numbers,
                        al_impulse_answer *answer)
{
    if (axis == AL_IMPULSE_AXIS_FITTED) { /* the mean of the axes, weighted by band 0 */
        double before = answer->sh[0][0], all = before + numbers[1];
        if (all > 0) answer->axis_angle = (before * answer->axis_angle + numbers[1] * numbers[0]) / all;
        numbers++;
    }
    double sine = sqrt(fmax(0, 1 - q->cos_normal * q->cos_normal)), factor = 1;
    for (uint32_t m = 0; m < answer->m_count; m++, factor *= sine)
        for (uint32_t l = m; l < answer->band_count; l++) answer->sh[m][l] += factor * *numbers++;
}

static void add_beam(const al_impulse_query *q, al_impulse_answer *answer)
{
    double irradiance = asymptote(q, 0, 0, q->sigma_s_per_m + q->sigma_a_per_m);
    if (q->emitter == AL_IMPULSE_AREA) irradiance *= fmax(0, q->cos_normal);
    for (uint32_t l = 0; l < answer->band_count; l++)
        answer->sh[0][l] += irradiance * sqrt((2 * l + 1) / (4 * AL_PI));
}

bool al_impulse_event_numbers(const al_impulse_tables *tables, const al_impulse_query *q, uint32_t axis,
                              uint32_t event, double *numbers)
{
    double sigma_s = q->sigma_s_per_m;
    if (event > 1) sigma_s *= 1 - mean_cosine(q);
    double sigma_t = sigma_s + q->sigma_a_per_m, distance = sigma_t * q->distance_m;
    double scale = asymptote(q, event, event, sigma_t) * pow(sigma_s / sigma_t, event);
    memset(numbers, 0, AL_IMPULSE_NUMBER_LIMIT * sizeof *numbers);
    if (!(scale > 0) || !tables->events[q->emitter][axis][event]) return false;
    if (event > 1 || is_isotropic(q))
        look_up(&tables->info, tables->events[q->emitter][axis][event], distance, q->cos_normal, 1, numbers);
    else if (q->variant == AL_IMPULSE_PUBLISHED || !tables->resolved[q->emitter])
        look_up_phases(tables, q, axis, distance, numbers);
    else
        look_up_resolved(tables, q, distance, numbers);
    scale_numbers(axis, scale, numbers);
    return true;
}

/* The table that holds all that is asked of a medium that absorbs nothing and is isotropic; the one with the
 * beam in it as published only. NULL: none. */
static const al_impulse_table *summed_table(const al_impulse_tables *tables, const al_impulse_query *q,
                                            uint32_t axis)
{
    if (q->sigma_a_per_m > 0 || !is_isotropic(q) || q->last_event != tables->info.event_count) return NULL;
    if (q->first_event == 0 && q->variant == AL_IMPULSE_PUBLISHED && tables->all_in_one[q->emitter][axis])
        return tables->all_in_one[q->emitter][axis];
    return q->first_event <= 1 ? tables->summed[q->emitter][axis] : NULL;
}

static void add_sum(const al_impulse_tables *tables, const al_impulse_query *q, const al_impulse_table *t,
                    al_impulse_answer *answer)
{
    double numbers[AL_IMPULSE_NUMBER_LIMIT] = {0};
    double scale = asymptote(q, t->first_event, t->last_event, q->sigma_s_per_m);
    if (!(scale > 0)) return;
    look_up(&tables->info, t, q->sigma_s_per_m * q->distance_m, q->cos_normal, 1, numbers);
    scale_numbers(t->axis, scale, numbers);
    add_numbers(q, t->axis, numbers, answer);
}

void al_impulse_response(const al_impulse_tables *tables, const al_impulse_query *q,
                         al_impulse_answer *answer)
{
    assert(q->first_event <= q->last_event && q->last_event <= tables->info.event_count);
    assert(q->distance_m > 0 && q->sigma_s_per_m >= 0 && q->sigma_a_per_m >= 0 && fabs(q->g) < 1);
    bool fitted = q->variant == AL_IMPULSE_PUBLISHED && q->emitter == AL_IMPULSE_AREA &&
                  tables->events[AL_IMPULSE_AREA][AL_IMPULSE_AXIS_FITTED][1];
    uint32_t axis = fitted ? AL_IMPULSE_AXIS_FITTED : AL_IMPULSE_AXIS_EMITTER;
    memset(answer, 0, sizeof *answer);
    answer->band_count = tables->info.band_count;
    answer->m_count = q->emitter == AL_IMPULSE_AREA && !fitted ? AL_IMPULSE_M_COUNT : 1;
    const al_impulse_table *sum = q->last_event > 0 ? summed_table(tables, q, axis) : NULL;
    if (q->first_event == 0 && !(sum && sum->first_event == 0)) add_beam(q, answer);
    if (sum) add_sum(tables, q, sum, answer);
    if (sum || q->last_event == 0) return;
    double numbers[AL_IMPULSE_NUMBER_LIMIT];
    for (uint32_t event = q->first_event ? q->first_event : 1; event <= q->last_event; event++)
        if (al_impulse_event_numbers(tables, q, axis, event, numbers)) add_numbers(q, axis, numbers, answer);
}

/* --- what is made of an answer --- */

/* Band l of the clamped cosine: the integral of max(0, cos) against P(l), times 2 pi (Ramamoorthi and
 * Hanrahan 2001): pi, 2 pi/3, and 0 or 2 pi (-1)^(l/2 - 1) / ((l + 2)(l - 1)) l! / (2^l (l/2)!^2). The last
 * quotient is 1/2 for l = 2 and (l - 1)/l times that of l - 2. */
void al_impulse_cosine_bands(uint32_t count, double bands[AL_IMPULSE_BAND_LIMIT])
{
    double quotient = 1, sign = -1;
    for (uint32_t l = 0; l < count; l++) bands[l] = 0;
    bands[0] = AL_PI;
    bands[1] = 2 * AL_PI / 3;
    for (uint32_t l = 2; l < count; l += 2) {
        quotient *= (l - 1.0) / l;
        sign = -sign;
        bands[l] = sign * 2 * AL_PI / ((l + 2.0) * (l - 1.0)) * quotient;
    }
}

/* Y(l, m) at a direction, without its al_sh_column: {1, sqrt 2 x, sqrt 2 (x^2 - y^2)}, y^2 = 1 - z^2 - x^2.
 */
static double azimuth_factor(uint32_t m, double z, double x)
{
    return m == 0 ? 1 : sqrt(2.0) * (m == 1 ? x : 2 * x * x + z * z - 1);
}

double al_impulse_irradiance(const al_impulse_answer *answer, double normal_z, double normal_x)
{
    double bands[AL_IMPULSE_BAND_LIMIT], column[AL_IMPULSE_BAND_LIMIT], sum = 0;
    double cosine = cos(answer->axis_angle), sine = sin(answer->axis_angle);
    double z = cosine * normal_z + sine * normal_x, x = cosine * normal_x - sine * normal_z;
    al_impulse_cosine_bands(answer->band_count, bands);
    for (uint32_t m = 0; m < answer->m_count; m++) {
        double part = 0;
        al_sh_column((int)m, (int)answer->band_count, z, column);
        for (uint32_t l = m; l < answer->band_count; l++) part += bands[l] * answer->sh[m][l] * column[l];
        sum += part * azimuth_factor(m, z, x);
    }
    return sum;
}

/* The flux is sqrt(4 pi/3) times band 1: Y(1,0) goes with z, Y(1,1) with x. About its direction a the zonal
 * part of band l is sqrt(4 pi/(2l + 1)) sum over m of sh[m][l] Y(l, m; a). */
double al_impulse_zonal(const al_impulse_answer *answer, double *zh)
{
    double angle = answer->m_count > 1 ? atan2(answer->sh[1][1], answer->sh[0][1]) : 0;
    double z = cos(angle), x = sin(angle), column[AL_IMPULSE_BAND_LIMIT];
    memcpy(zh, answer->sh[0], answer->band_count * sizeof *zh);
    if (answer->m_count == 1) return answer->axis_angle;
    memset(zh, 0, answer->band_count * sizeof *zh);
    for (uint32_t m = 0; m < answer->m_count; m++) {
        al_sh_column((int)m, (int)answer->band_count, z, column);
        for (uint32_t l = m; l < answer->band_count; l++)
            zh[l] += sqrt(4 * AL_PI / (2 * l + 1)) * answer->sh[m][l] * column[l] * azimuth_factor(m, z, x);
    }
    return angle;
}
