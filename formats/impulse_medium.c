/* Tables collapsed for one albedo and phase function.
 *
 * With sigma_s = albedo sigma_t all events of a medium depend on sigma_t d alone: those from 2 on are looked
 * up at sigma_t' d = (1 - g albedo) sigma_t d by the similarity rule. So their sum is one function of
 * distance (and cosine), resampled here on the tables' own axes over the asymptote exp(-rate d) falloff(d),
 * where rate is that of the events which reach farthest. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/formulas.h"
#include "impulse.h"

typedef struct collapsed {
    uint32_t cosine_count, number_count;
    float *values; /* [cosine][distance][number] */
} collapsed;

struct al_impulse_medium {
    al_impulse_info info;
    uint32_t first_event, last_event, distance_count;
    double rate;
    collapsed emitters[3];
    /* Recurrence of the normalised Legendre functions (al_sh_column) and bands of the clamped cosine. */
    double start[AL_IMPULSE_M_COUNT], factors[AL_IMPULSE_M_COUNT][AL_IMPULSE_BAND_LIMIT],
        bands[AL_IMPULSE_BAND_LIMIT];
};

/* exp(-rate d) falloff(d) in a medium, sigma_t^2 in it for point and area; d in metres. */
static double medium_asymptote(const al_impulse_medium *medium, al_impulse_emitter emitter, double distance_m,
                               double sigma_t)
{
    double d = sigma_t * distance_m, decay = exp(-medium->rate * d);
    if (emitter != AL_IMPULSE_DIRECTIONAL && medium->first_event == 1) /* no overflow where d is tiny */
        return decay * exp(medium->last_event / 3.0 * log1p(d)) * sigma_t / (distance_m * (1 + d));
    double scale = emitter == AL_IMPULSE_DIRECTIONAL ? 1 : sigma_t * sigma_t;
    return scale * decay * al_impulse_falloff(emitter, medium->first_event, medium->last_event, d);
}

static al_status collapse(const al_impulse_tables *tables, const al_impulse_medium_settings *s,
                          al_impulse_emitter emitter, al_impulse_medium *medium, al_error *error)
{
    const al_impulse_table *t = tables->events[emitter][AL_IMPULSE_AXIS_EMITTER][1];
    collapsed *c = &medium->emitters[emitter];
    *c = (collapsed){t->cosine_count, t->number_count, NULL};
    c->values = calloc((size_t)t->cosine_count * medium->distance_count * t->number_count, sizeof *c->values);
    if (!c->values) return al_fail(error, AL_IO, "out of memory for a medium's impulse responses");
    double step = log(medium->info.distance_max / medium->info.distance_min) / (medium->distance_count - 1);
    float *entry = c->values;
    for (uint32_t k = 0; k < t->cosine_count; k++)
        for (uint32_t i = 0; i < medium->distance_count; i++, entry += t->number_count) {
            double u = t->cosine_count > 1 ? -1 + 2.0 * k / (t->cosine_count - 1) : 1;
            double sum[AL_IMPULSE_NUMBER_LIMIT] = {0}, numbers[AL_IMPULSE_NUMBER_LIMIT];
            al_impulse_query q = {.emitter = emitter,
                                  .distance_m = medium->info.distance_min * exp(i * step),
                                  .cos_normal = u * fabs(u),
                                  .sigma_s_per_m = s->albedo,
                                  .sigma_a_per_m = 1 - s->albedo,
                                  .g = s->g,
                                  .moments = s->moments,
                                  .moment_count = s->moment_count};
            double scale = medium_asymptote(medium, emitter, q.distance_m, 1);
            for (uint32_t event = s->first_event; event <= s->last_event; event++) {
                if (!al_impulse_event_numbers(tables, &q, AL_IMPULSE_AXIS_EMITTER, event, numbers)) continue;
                for (uint32_t n = 0; n < t->number_count; n++) sum[n] += numbers[n];
            }
            for (uint32_t n = 0; n < t->number_count && scale > 0; n++) entry[n] = (float)(sum[n] / scale);
        }
    return AL_OK;
}

al_status al_impulse_medium_make(const al_impulse_tables *tables, const al_impulse_medium_settings *s,
                                 al_impulse_medium **medium, al_error *error)
{
    assert(s->first_event >= 1 && s->first_event <= s->last_event);
    assert(s->last_event <= tables->info.event_count && s->albedo >= 0 && s->albedo <= 1);
    al_impulse_medium *made = calloc(1, sizeof *made);
    *medium = NULL;
    if (!made) return al_fail(error, AL_IO, "out of memory for a medium's impulse responses");
    double g = !s->moments ? s->g : s->moment_count > 1 ? s->moments[1] : 0, slower = 1 - g * s->albedo;
    made->info = tables->info;
    made->first_event = s->first_event;
    made->last_event = s->last_event;
    made->distance_count = tables->events[AL_IMPULSE_POINT][AL_IMPULSE_AXIS_EMITTER][1]->distance_count;
    made->rate = s->first_event > 1 ? slower : s->last_event > 1 ? fmin(1, slower) : 1;
    al_impulse_cosine_bands(made->info.band_count, made->bands);
    made->start[0] = sqrt(1 / (4 * AL_PI));
    for (uint32_t m = 0; m < AL_IMPULSE_M_COUNT; m++) {
        if (m > 0) made->start[m] = made->start[m - 1] * sqrt((2 * m + 1) / (2.0 * m));
        for (uint32_t l = m + 1; l < made->info.band_count; l++)
            made->factors[m][l] = sqrt((4.0 * l * l - 1) / (1.0 * (l * l - m * m)));
    }
    al_status status = AL_OK;
    for (int e = 0; e < 3 && status == AL_OK; e++)
        status = collapse(tables, s, (al_impulse_emitter)e, made, error);
    if (status == AL_OK)
        *medium = made;
    else
        al_impulse_medium_free(made);
    return status;
}

void al_impulse_medium_free(al_impulse_medium *medium)
{
    if (!medium) return;
    for (int e = 0; e < 3; e++) free(medium->emitters[e].values);
    free(medium);
}

/* The interpolated numbers, without their scale, which is answered; 0: nothing is left. */
static double interpolate(const al_impulse_medium *medium, al_impulse_emitter emitter, double distance_m,
                          double cos_normal, double sigma_t, float numbers[AL_IMPULSE_NUMBER_LIMIT])
{
    const collapsed *c = &medium->emitters[emitter];
    double scale = medium_asymptote(medium, emitter, distance_m, sigma_t);
    if (!(scale > 0)) return 0;
    al_impulse_stencil cosines = al_impulse_cosines(c->cosine_count, cos_normal),
                       distances =
                           al_impulse_distances(&medium->info, medium->distance_count, sigma_t * distance_m);
    for (uint32_t n = 0; n < c->number_count; n++) numbers[n] = 0;
    for (uint32_t k = 0; k < cosines.count; k++) {
        const float *entry =
            c->values +
            ((size_t)(cosines.first + k) * medium->distance_count + distances.first) * c->number_count;
        for (uint32_t d = 0; d < 4; d++, entry += c->number_count) {
            float w = (float)(cosines.weights[k] * distances.weights[d]);
            for (uint32_t n = 0; n < c->number_count; n++) numbers[n] += w * entry[n];
        }
    }
    return scale;
}

void al_impulse_medium_response(const al_impulse_medium *medium, al_impulse_emitter emitter,
                                double distance_m, double cos_normal, double sigma_t_per_m,
                                al_impulse_answer *answer)
{
    float numbers[AL_IMPULSE_NUMBER_LIMIT], *number = numbers;
    double scale = interpolate(medium, emitter, distance_m, cos_normal, sigma_t_per_m, numbers);
    double sine = sqrt(fmax(0, 1 - cos_normal * cos_normal));
    memset(answer, 0, sizeof *answer);
    answer->band_count = medium->info.band_count;
    answer->m_count = emitter == AL_IMPULSE_AREA ? AL_IMPULSE_M_COUNT : 1;
    for (uint32_t m = 0; m < answer->m_count && scale > 0; m++, scale *= sine)
        for (uint32_t l = m; l < answer->band_count; l++) answer->sh[m][l] = scale * *number++;
}

double al_impulse_medium_irradiance(const al_impulse_medium *medium, al_impulse_emitter emitter,
                                    double distance_m, double cos_normal, double sigma_t_per_m,
                                    double normal_z, double normal_x)
{
    float numbers[AL_IMPULSE_NUMBER_LIMIT];
    const float *number = numbers;
    double scale = interpolate(medium, emitter, distance_m, cos_normal, sigma_t_per_m, numbers), sum = 0;
    if (!(scale > 0)) return 0;
    double sine = sqrt(fmax(0, 1 - cos_normal * cos_normal));
    const double azimuths[] = {1, sqrt(2.0) * normal_x * sine,
                               sqrt(2.0) * (2 * normal_x * normal_x + normal_z * normal_z - 1) * sine * sine};
    uint32_t bands = medium->info.band_count, m_count = emitter == AL_IMPULSE_AREA ? AL_IMPULSE_M_COUNT : 1;
    for (uint32_t m = 0; m < m_count; m++) {
        double here = medium->start[m], below = 0, part = 0;
        for (uint32_t l = m; l < bands; l++) {
            if (l > m) { /* the factors of below and here are those of l - 1 and l: al_sh_column */
                double factor = medium->factors[m][l], next = normal_z * here;
                if (l > m + 1) next -= below / medium->factors[m][l - 1];
                below = here;
                here = factor * next;
            }
            part += medium->bands[l] * here * *number++;
        }
        sum += azimuths[m] * part;
    }
    return scale * sum;
}
