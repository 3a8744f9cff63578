/* Step 1 of the impulse tables: the quadrature. Trapezoidal sums over the whole line; why they converge
 * exponentially stands above the kernels. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/formulas.h"
#include "airlight/sh.h"
#include "impulse_steps.h"

/* Where the sums end. Angles: s = 2 atan(exp(y)) down to 3e-5, of which a phase function of g = 0.99 (width
 * 0.01) keeps the square, 1e-5; up to pi - s = 1e-2 of 1e-5 for g = -0.99, and, for sources that reach a mean
 * free path from a receiver at distance_min, to s where r = 50. Steps: layers of relative width 1e-3 where
 * d = 1000, to 1e-5 of them. */
static const double angle_low = -11, angle_high = 16.5, reach_mfp = 50, step_end = 18;

double al_impulse_axis_distance(const al_impulse_axis_steps *axis, double place)
{
    return exp(axis->first + place * axis->step);
}

double al_impulse_cosine(uint32_t count, uint32_t i)
{
    if (count == 1) return 1;
    double u = -1 + 2.0 * i / (count - 1);
    return u * fabs(u);
}

/* --- azimuth integrals --- */

/* An emission angle alpha from the axis to the receiver, at azimuth phi, makes the cosine
 * c cos(alpha) + sqrt(1 - c^2) sin(alpha) cos(phi) with the normal. turn [m][cosine]: the mean over phi of
 * {1, sqrt 2 cos(m phi)} times the interpolation's weights, over (1 - c^2)^(m/2). At c = +-1, where that is
 * 0/0, the limit is taken from sin = 0.01, 1e-4 off in m > 0. */
static void fill_turn(uint32_t count, double receiver, double cos_alpha, double sin_alpha, double *turn)
{
    enum { AZIMUTHS = 96 };
    double sine = sqrt(fmax(0, 1 - receiver * receiver)), away = fmax(sine, 0.01),
           beside = copysign(sqrt(1 - away * away), receiver);
    for (int p = 0; p < AZIMUTHS; p++) {
        double phi = AL_PI * (p + 0.5) / AZIMUTHS, x = cos(phi), weight = 1.0 / AZIMUTHS;
        const double factors[] = {weight, weight * sqrt(2.0) * x / away,
                                  weight * sqrt(2.0) * (2 * x * x - 1) / (away * away)};
        for (int m = 0; m < AL_IMPULSE_M_COUNT; m++) {
            double cosine =
                m ? beside * cos_alpha + away * sin_alpha * x : receiver * cos_alpha + sine * sin_alpha * x;
            al_impulse_stencil at = al_impulse_cosines(count, cosine);
            for (int k = 0; k < 4; k++) turn[(size_t)m * count + at.first + k] += factors[m] * at.weights[k];
        }
    }
}

/* The turns of all emission angles in equal steps: [angle][cosine][m][source cosine]. Even: pi/2 is one. */
enum { TURN_ANGLES = 1024 };

static double *make_turns(uint32_t count)
{
    size_t size = (size_t)AL_IMPULSE_M_COUNT * count;
    double *turns = calloc((TURN_ANGLES + 1) * count * size, sizeof *turns);
    for (uint32_t i = 0; turns && i <= TURN_ANGLES; i++)
        for (uint32_t c = 0; c < count; c++) {
            double alpha = AL_PI * i / TURN_ANGLES;
            fill_turn(count, al_impulse_cosine(count, c), cos(alpha), sin(alpha),
                      turns + (i * (size_t)count + c) * size);
        }
    return turns;
}

static void add_turn(const double *turns, size_t size, double alpha, double weight, double *turn)
{
    double place = alpha / AL_PI * TURN_ANGLES, below = fmin(floor(place), TURN_ANGLES - 1.0),
           f = place - below;
    const double *at = turns + (size_t)below * size;
    for (size_t k = 0; k < size; k++) turn[k] += weight * ((1 - f) * at[k] + f * at[size + k]);
}

/* Cardinal function of the interpolation through six neighbours (Lagrange): 1 at 0, 0 at other whole x. */
static double cardinal(double x)
{
    double value = 1, base = floor(x = fabs(x));
    if (x >= 3) return 0;
    for (int k = -2; k <= 3; k++) { /* nodes base - 2 to base + 3 beside x, the one at 0 left out */
        double node = k + base;
        if (node != 0) value *= (x - node) / -node;
    }
    return value;
}

/* First source cosine of a receiver's turns [m][source cosine] that is not 0, and the one behind the last. */
static void find_span(uint32_t count, const double *turn, int32_t span[2])
{
    span[0] = (int32_t)count;
    span[1] = 0;
    for (uint32_t k = 0; k < AL_IMPULSE_M_COUNT * count; k++) {
        int32_t j = (int32_t)(k % count);
        if (turn[k] == 0) continue;
        if (j < span[0]) span[0] = j;
        if (j >= span[1]) span[1] = j + 1;
    }
    if (span[0] > span[1]) span[0] = span[1];
}

/* An area's light has kinks where the emitter's plane is crossed (at c = +-1 a sharp one at alpha = pi/2),
 * which a trapezoidal sum sees to the square of its step only. So the sum over z is a product rule:
 * everything else is interpolated through six nodes, and a node's turn is the integral of the turns against
 * its cardinal function. */
static void fill_turns(const double *turns, size_t size, double s, double z, double step, double *turn)
{
    enum { PIECES = 8, REACH = 3 * PIECES };
    for (int i = -REACH; i < REACH; i++) {
        double x = (i + 0.5) / PIECES, alpha = s / (1 + exp(z + x * step));
        add_turn(turns, size, alpha, cardinal(x) / PIECES, turn);
    }
}

/* --- point and area --- */

static void fill_node(al_impulse_rule *rule, size_t node, double y, double z, double area)
{
    double v = exp(y), s = 2 * atan(v), rest = 2 * atan(1 / v); /* s and pi - s */
    double share = 1 / (1 + exp(-z)), other = 1 / (1 + exp(z)), theta = s * share, alpha = s * other;
    /* the sine of an angle near pi by what it lacks */
    double sin_s = 2 * v / (1 + v * v);
    double sin_theta = theta > AL_PI / 2 ? sin(rest + alpha) : sin(theta);
    double *ray = rule->rays + 3 * node, *column = rule->columns + node * rule->number_count;
    double bands[AL_IMPULSE_BAND_LIMIT], power = 1;
    ray[0] = log(sin_theta / sin_s);
    ray[1] = 2 * sin(theta / 2) * sin(alpha / 2) * sqrt(1 + v * v);
    ray[2] = area / cosh(y) * s * share * other;
    if (ray[2] < 1e-12) ray[2] = 0;
    for (uint32_t m = 0; m < rule->m_count; m++, power *= sin_theta) {
        al_sh_column((int)m, (int)rule->bands, cos(theta), bands);
        for (uint32_t l = m; l < rule->bands; l++) *column++ = power * bands[l];
    }
}

static void fill_scatter(al_impulse_rule *rule, const double *turns, double angle_step, double step)
{
    size_t size = rule->turn_count / rule->angle_count / rule->step_count;
    for (uint32_t a = 0; a < rule->angle_count; a++) {
        rule->angles[a] = (ceil(angle_low / angle_step) + a) * angle_step;
        for (uint32_t i = 0; i < rule->step_count; i++) {
            size_t node = (size_t)a * rule->step_count + i;
            double z = (i - 0.5 * (rule->step_count - 1)) * step;
            fill_node(rule, node, rule->angles[a], z, angle_step * step);
            double *turn = rule->turns + node * size;
            int32_t *span = rule->spans + 2 * node * rule->cosine_count;
            if (!turns) {
                turn[0] = 1;
                span[1] = 1;
            } else if (rule->rays[3 * node + 2] > 0) {
                fill_turns(turns, size, 2 * atan(exp(rule->angles[a])), z, step, turn);
                for (uint32_t c = 0; c < rule->cosine_count; c++)
                    find_span(rule->cosine_count, turn + c * size / rule->cosine_count, span + 2 * c);
            }
        }
    }
}

/* --- half-space --- */

/* Rows: |mu| = 1/(1 + exp(-w)), w from -16 to 22, towards the plane, then the same away from it. */
static const double row_low = -16, row_high = 22, away_low = -20, away_high = 4;

static void fill_halfspace(al_impulse_rule *rule, double angle_step, double step)
{
    uint32_t half = rule->angle_count / 2;
    for (uint32_t r = 0; r < rule->angle_count; r++) {
        double w = row_low + r % half * angle_step, mu = 1 / (1 + exp(-w)), rest = 1 / (1 + exp(w)),
               side = r < half ? 1 : -1;
        double *row = rule->rays + 3 * (size_t)r;
        row[0] = mu;
        row[1] = r < half ? rest : 1 + mu;
        row[2] = r < half ? 1 : 0;
        rule->angles[r] = side * 0.5 * log(rest / (1 + mu));
        double *column = rule->columns + (size_t)r * rule->bands;
        al_sh_column(0, (int)rule->bands, side * mu, column);
        for (uint32_t l = 0; l < rule->bands; l++) column[l] *= mu * rest * angle_step;
    }
    double away_step = (away_high - away_low) / (rule->step_count - 1);
    for (uint32_t i = 0; i < rule->step_count; i++) {
        double z = (i - 0.5 * (rule->step_count - 1)) * step, t = exp(away_low + i * away_step);
        double *at = rule->turns + 5 * (size_t)i;
        at[0] = 1 / (1 + exp(-z));
        at[1] = 1 / (1 + exp(z));
        at[2] = at[0] * at[1] * step;
        at[3] = t;
        at[4] = t * away_step;
    }
}

al_status al_impulse_rule_make(al_impulse_emitter emitter, uint32_t bands, uint32_t cosine_count,
                               double angle_step, double step, double distance_min, al_impulse_rule *rule,
                               al_error *error)
{
    bool sun = emitter == AL_IMPULSE_DIRECTIONAL, area = emitter == AL_IMPULSE_AREA;
    double high = fmax(angle_high, log(reach_mfp / distance_min));
    *rule = (al_impulse_rule){.emitter = emitter, .bands = bands, .m_count = area ? 3 : 1};
    rule->cosine_count = area ? cosine_count : 1;
    rule->number_count = al_impulse_number_count(emitter, AL_IMPULSE_AXIS_EMITTER, bands);
    rule->step_count = (uint32_t)ceil(2 * step_end / step) + 1;
    rule->angle_count = sun ? 2 * ((uint32_t)ceil((row_high - row_low) / angle_step) + 1)
                            : (uint32_t)ceil((high - angle_low) / angle_step) + 1;
    size_t nodes = (size_t)rule->angle_count * rule->step_count;
    rule->ray_count = 3 * (sun ? rule->angle_count : nodes);
    rule->column_count = sun ? (size_t)rule->angle_count * bands : nodes * rule->number_count;
    rule->span_count = sun ? 0 : 2 * nodes * rule->cosine_count;
    rule->turn_count = sun    ? 5 * (size_t)rule->step_count
                       : area ? nodes * 3 * cosine_count * cosine_count
                              : nodes;
    rule->angles = calloc(rule->angle_count, sizeof *rule->angles);
    rule->rays = calloc(rule->ray_count, sizeof *rule->rays);
    rule->columns = calloc(rule->column_count, sizeof *rule->columns);
    rule->turns = calloc(rule->turn_count, sizeof *rule->turns);
    rule->spans = calloc(rule->span_count + 1, sizeof *rule->spans);
    double *turns = area ? make_turns(cosine_count) : NULL;
    if (!rule->angles || !rule->rays || !rule->columns || !rule->turns || !rule->spans || (area && !turns)) {
        free(turns);
        al_impulse_rule_free(rule);
        return al_fail(error, AL_IO, "out of memory for the quadrature of the impulse tables");
    }
    if (sun)
        fill_halfspace(rule, angle_step, step);
    else
        fill_scatter(rule, turns, angle_step, step);
    free(turns);
    return AL_OK;
}

void al_impulse_rule_free(al_impulse_rule *rule)
{
    free(rule->angles);
    free(rule->rays);
    free(rule->columns);
    free(rule->turns);
    free(rule->spans);
    *rule = (al_impulse_rule){0};
}

/* From the kernels' sums to values: sqrt(4 pi)/2 for the source kept as band 0, 1/d where the kernel has it,
 * and the falloff of the event. values [angle][cosine][distance][number]. */
void al_impulse_divide(const al_impulse_rule *rule, uint32_t event, const double *distances,
                       uint32_t distance_count, double *values)
{
    size_t rows = (size_t)rule->angle_count * rule->cosine_count;
    for (uint32_t i = 0; i < distance_count; i++) {
        double d = distances[i], factor = sqrt(AL_PI) / al_impulse_falloff(rule->emitter, event, event, d);
        if (rule->emitter != AL_IMPULSE_DIRECTIONAL) factor /= d;
        for (size_t r = 0; r < rows; r++)
            for (uint32_t n = 0; n < rule->number_count; n++)
                values[(r * distance_count + i) * rule->number_count + n] *= factor;
    }
}
