/* The bake of the impulse tables: for each emitter the beam, then one event after the other, each in the
 * light of the one before; event 1 split by its angle of scattering; the published area emitter; the check.
 */
#include "impulse_steps.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "airlight/formulas.h"
#include "measure.h"

enum {
    TABLE_LIMIT = 3 * (2 * (AL_IMPULSE_EVENT_LIMIT + 5) + 1),
    SHARE_DISTANCES = 64, /* of tables that are split by angle: they carry differences only */
    SHARE_COSINES = 9,
    METHOD = 3,       /* of the key: raised with every change of what is computed */
    CHECK_STRIDE = 16 /* every sixteenth distance is recomputed in double */
};

/* Steps of the quadrature, from the convergence in docs/accuracy.md. */
static const double fine_step = 0.25, area_angle_step = 0.28, area_step = 0.42, share_step = 0.3;

typedef struct work {
    const al_impulse_settings *settings;
    al_device *device;
    const al_bake_options *options;
    al_impulse_axis_steps axis;
    double *distances; /* [settings->distances] */
    al_impulse_table tables[TABLE_LIMIT];
    float *owned[2 * TABLE_LIMIT]; /* values and angles, to be freed */
    uint32_t count, owned_count;
    double rounding_error, interpolation_error;
    al_measure measures[3]; /* of each emitter: deviation of an entry over its length */
    al_progress progress;
    unsigned done, total; /* scatterings */
} work;

static al_status out_of_memory(al_error *error)
{
    return al_fail(error, AL_IO, "out of memory for the impulse tables");
}

static al_status advance(work *w, al_error *error)
{
    return al_progress_update(&w->progress, ++w->done, w->total) ? al_fail(error, AL_CANCELLED, "cancelled")
                                                                 : AL_OK;
}

static float *own(work *w, size_t count)
{
    float *made = w->owned_count < 2 * TABLE_LIMIT ? calloc(count, sizeof *made) : NULL;
    if (made) w->owned[w->owned_count++] = made;
    return made;
}

/* A new table of the work's axes with room for its values; NULL when memory runs out. */
static float *add_table(work *w, al_impulse_emitter emitter, al_impulse_axis axis, uint32_t first,
                        uint32_t last, double g)
{
    const al_impulse_settings *s = w->settings;
    if (w->count == TABLE_LIMIT) return NULL;
    al_impulse_table *t = &w->tables[w->count];
    *t = (al_impulse_table){.emitter = emitter,
                            .axis = axis,
                            .first_event = first,
                            .last_event = last,
                            .distance_count = s->distances,
                            .g = (float)g};
    t->cosine_count = emitter == AL_IMPULSE_AREA ? s->cosines : 1;
    t->number_count = al_impulse_number_count(emitter, axis, s->bands);
    float *values = own(w, (size_t)t->cosine_count * t->distance_count * t->number_count);
    t->values = values;
    w->count += values != NULL;
    return values;
}

static const al_impulse_table *find(const work *w, al_impulse_emitter emitter, al_impulse_axis axis,
                                    uint32_t first, uint32_t last, double g)
{
    for (uint32_t i = 0; i < w->count; i++) {
        const al_impulse_table *t = &w->tables[i];
        if (t->emitter == emitter && t->axis == axis && t->first_event == first && t->last_event == last &&
            t->g == (float)g && !t->angle_count)
            return t;
    }
    return NULL;
}

/* --- one emitter, event after event --- */

/* The sum over angles of shares times 4 pi p of Henyey-Greenstein g. values [angle][entry]. */
static void sum_angles(const al_impulse_rule *rule, const double *values, size_t entry_count, double g,
                       float *sums)
{
    for (size_t i = 0; i < entry_count; i++) {
        double sum = 0;
        for (uint32_t a = 0; a < rule->angle_count; a++) {
            double square = (1 - g) * (1 - g) + 4 * g / (1 + exp(-2 * rule->angles[a]));
            sum += values[a * entry_count + i] * (1 - g * g) / (square * sqrt(square));
        }
        sums[i] = (float)sum;
    }
}

/* The beam as a source: band 0 of a direction is 1/sqrt(4 pi), an area's times its cosine. */
static void fill_beam(const al_impulse_rule *rule, uint32_t distance_count, double *source)
{
    for (uint32_t i = 0; i < distance_count; i++)
        for (uint32_t c = 0; c < rule->cosine_count; c++)
            source[(size_t)i * rule->cosine_count + c] =
                fmax(0, al_impulse_cosine(rule->cosine_count, c)) / sqrt(4 * AL_PI);
}

/* Band 0 of [cosine][distance][number] as a source [distance][cosine]. */
static void fill_source(const al_impulse_rule *rule, uint32_t distance_count, const float *sums,
                        double *source)
{
    for (uint32_t c = 0; c < rule->cosine_count; c++)
        for (uint32_t i = 0; i < distance_count; i++)
            source[(size_t)i * rule->cosine_count + c] =
                sums[((size_t)c * distance_count + i) * rule->number_count];
}

/* Largest deviation of the device's sums from double precision, over the entry's band 0. */
static al_status check_rounding(work *w, const al_impulse_rule *rule, const al_impulse_source *source,
                                const float *sums, al_error *error)
{
    uint32_t n = w->settings->distances, count = 0;
    size_t entries =
        (size_t)rule->cosine_count * ((n + CHECK_STRIDE - 1) / CHECK_STRIDE) * rule->number_count;
    double *distances = malloc(n * sizeof *distances),
           *values = malloc(entries * rule->angle_count * sizeof *values);
    float *exact = malloc(entries * sizeof *exact);
    al_status status = distances && values && exact ? AL_OK : out_of_memory(error);
    for (uint32_t i = 0; i < n && status == AL_OK; i += CHECK_STRIDE) distances[count++] = w->distances[i];
    if (status == AL_OK)
        status =
            al_impulse_scatter_double(rule, source, distances, count, w->options->threads, values, error);
    if (status == AL_OK) sum_angles(rule, values, entries, 0, exact);
    for (uint32_t c = 0; c < rule->cosine_count && status == AL_OK; c++)
        for (uint32_t i = 0; i < count; i++) {
            const float *e = exact + ((size_t)c * count + i) * rule->number_count;
            const float *s = sums + ((size_t)c * n + (size_t)i * CHECK_STRIDE) * rule->number_count;
            for (uint32_t k = 0; k < rule->number_count; k++)
                w->rounding_error = fmax(w->rounding_error, fabs(s[k] - e[k]) / e[0]);
        }
    free(distances);
    free(values);
    free(exact);
    return status;
}

static al_status scatter_events(work *w, const al_impulse_rule *rule, double *source_values, double *values,
                                al_error *error)
{
    const al_impulse_settings *s = w->settings;
    size_t entries = (size_t)rule->cosine_count * s->distances * rule->number_count;
    al_status status = AL_OK;
    fill_beam(rule, s->distances, source_values);
    for (uint32_t event = 1; event <= s->events && status == AL_OK; event++) {
        al_impulse_source source = {event - 1, w->axis, source_values};
        status =
            al_impulse_scatter_device(w->device, rule, &source, w->distances, s->distances, values, error);
        for (int side = event == 1 ? -1 : 0; side <= (event == 1) && status == AL_OK; side++) {
            float *sums =
                add_table(w, rule->emitter, AL_IMPULSE_AXIS_EMITTER, event, event, side * s->g_range);
            if (!sums)
                status = out_of_memory(error);
            else
                sum_angles(rule, values, entries, side * s->g_range, sums);
        }
        if (status != AL_OK) break;
        const float *sums = find(w, rule->emitter, AL_IMPULSE_AXIS_EMITTER, event, event, 0)->values;
        status = check_rounding(w, rule, &source, sums, error);
        fill_source(rule, s->distances, sums, source_values);
        if (status == AL_OK) status = advance(w, error);
    }
    return status;
}

static al_status make_events(work *w, al_impulse_emitter emitter, al_error *error)
{
    const al_impulse_settings *s = w->settings;
    al_impulse_rule rule;
    double angle_step = emitter == AL_IMPULSE_AREA ? area_angle_step : fine_step,
           step = emitter == AL_IMPULSE_AREA ? area_step : fine_step;
    al_status status =
        al_impulse_rule_make(emitter, s->bands, s->cosines, angle_step, step, s->distance_min, &rule, error);
    if (status != AL_OK) return status;
    double *source = malloc((size_t)s->distances * rule.cosine_count * sizeof *source);
    double *values = malloc((size_t)rule.angle_count * rule.cosine_count * s->distances * rule.number_count *
                            sizeof *values);
    status = source && values ? scatter_events(w, &rule, source, values, error) : out_of_memory(error);
    free(source);
    free(values);
    al_impulse_rule_free(&rule);
    return status;
}

/* --- the check: double precision halfway between the distances --- */

/* Band by band at half a step behind distance i, as look-ups interpolate. row: [distance][number]. */
static double halfway(const float *row, uint32_t distance_count, uint32_t number_count, uint32_t i,
                      uint32_t n)
{
    static const double middle[] = {-1 / 16.0, 9 / 16.0, 9 / 16.0, -1 / 16.0},
                        end[] = {5 / 16.0, 15 / 16.0, -5 / 16.0, 1 / 16.0};
    double sum = 0;
    bool first = i == 0, last = i + 2 >= distance_count;
    uint32_t from = first ? 0 : last ? distance_count - 4 : i - 1;
    for (uint32_t k = 0; k < 4; k++)
        sum += (first ? end[k] : last ? end[3 - k] : middle[k]) * row[(size_t)(from + k) * number_count + n];
    return sum;
}

static void compare_halfway(work *w, const al_impulse_rule *rule, const al_impulse_table *t,
                            const float *exact, uint32_t count)
{
    for (uint32_t c = 0; c < rule->cosine_count; c++)
        for (uint32_t i = 0; i < count; i++) {
            const float *e = exact + ((size_t)c * count + i) * t->number_count,
                        *row = t->values + (size_t)c * t->distance_count * t->number_count;
            double square = 0, exact_square = 0;
            for (uint32_t n = 0; n < t->number_count; n++) {
                double deviation = halfway(row, t->distance_count, t->number_count, 2 * i, n) - e[n];
                w->interpolation_error = fmax(w->interpolation_error, fabs(deviation) / e[0]);
                square += deviation * deviation;
                exact_square += (double)e[n] * e[n];
            }
            al_measure_add(&w->measures[rule->emitter], sqrt(square / exact_square), 1);
        }
}

/* Every event again, in double precision, on distances of its own: halfway between every second pair of the
 * tables'. Its sources are its own, so that what the device's rounding adds up to over the events is seen
 * too. */
static al_status check_emitter(work *w, al_impulse_emitter emitter, al_error *error)
{
    const al_impulse_settings *s = w->settings;
    al_impulse_rule rule;
    double angle_step = emitter == AL_IMPULSE_AREA ? area_angle_step : fine_step,
           step = emitter == AL_IMPULSE_AREA ? area_step : fine_step, *distances, *source, *values;
    float *sums;
    al_impulse_axis_steps axis = {s->distances / 2, w->axis.first + 0.5 * w->axis.step, 2 * w->axis.step};
    al_status status =
        al_impulse_rule_make(emitter, s->bands, s->cosines, angle_step, step, s->distance_min, &rule, error);
    if (status != AL_OK) return status;
    size_t entries = (size_t)rule.cosine_count * axis.count * rule.number_count;
    distances = malloc(axis.count * sizeof *distances);
    source = malloc((size_t)axis.count * rule.cosine_count * sizeof *source);
    values = malloc(entries * rule.angle_count * sizeof *values);
    sums = malloc(entries * sizeof *sums);
    status = distances && source && values && sums ? AL_OK : out_of_memory(error);
    for (uint32_t i = 0; i < axis.count && status == AL_OK; i++)
        distances[i] = al_impulse_axis_distance(&axis, i);
    if (status == AL_OK) fill_beam(&rule, axis.count, source);
    for (uint32_t event = 1; event <= s->events && status == AL_OK; event++) {
        const al_impulse_source light = {event - 1, axis, source};
        status = al_impulse_scatter_double(&rule, &light, distances, axis.count, w->options->threads, values,
                                           error);
        if (status != AL_OK) break;
        sum_angles(&rule, values, entries, 0, sums);
        compare_halfway(w, &rule, find(w, emitter, AL_IMPULSE_AXIS_EMITTER, event, event, 0), sums,
                        axis.count);
        fill_source(&rule, axis.count, sums, source);
        status = advance(w, error);
    }
    free(distances);
    free(source);
    free(values);
    free(sums);
    al_impulse_rule_free(&rule);
    return status;
}

/* --- event 1 by its angle --- */

static al_status make_shares(work *w, al_impulse_emitter emitter, al_error *error)
{
    const al_impulse_settings *s = w->settings;
    al_impulse_rule rule;
    al_impulse_axis_steps axis = {SHARE_DISTANCES, log(s->distance_min),
                                  log(s->distance_max / s->distance_min) / (SHARE_DISTANCES - 1)};
    double distances[SHARE_DISTANCES], *source = NULL, *values = NULL;
    al_status status = al_impulse_rule_make(emitter, s->bands, SHARE_COSINES, share_step, fine_step,
                                            s->distance_min, &rule, error);
    if (status != AL_OK) return status;
    size_t count = (size_t)rule.angle_count * rule.cosine_count * SHARE_DISTANCES * rule.number_count;
    float *shares = own(w, count), *angles = own(w, rule.angle_count);
    source = malloc((size_t)SHARE_DISTANCES * rule.cosine_count * sizeof *source);
    values = malloc(count * sizeof *values);
    status = shares && angles && source && values && w->count < TABLE_LIMIT ? AL_OK : out_of_memory(error);
    if (status != AL_OK) goto cleanup;
    for (uint32_t i = 0; i < SHARE_DISTANCES; i++) distances[i] = al_impulse_axis_distance(&axis, i);
    fill_beam(&rule, SHARE_DISTANCES, source);
    status = al_impulse_scatter_device(w->device, &rule, &(al_impulse_source){0, axis, source}, distances,
                                       SHARE_DISTANCES, values, error);
    if (status != AL_OK) goto cleanup;
    for (size_t i = 0; i < count; i++) shares[i] = (float)values[i];
    for (uint32_t a = 0; a < rule.angle_count; a++) angles[a] = (float)rule.angles[a];
    w->tables[w->count++] = (al_impulse_table){
        emitter,          AL_IMPULSE_AXIS_EMITTER, 1, 1,      SHARE_DISTANCES, rule.cosine_count,
        rule.angle_count, rule.number_count,       0, angles, shares};
    status = advance(w, error);
cleanup:
    free(source);
    free(values);
    al_impulse_rule_free(&rule);
    return status;
}

/* --- sums and fits --- */

/* Adds an event to an entry; the beam is event 0. */
static void add_event(const work *w, al_impulse_emitter emitter, uint32_t event, size_t entry, double ratio,
                      double *sum)
{
    uint32_t bands = w->settings->bands;
    const al_impulse_table *t =
        find(w, emitter, AL_IMPULSE_AXIS_EMITTER, event ? event : 1, event ? event : 1, 0);
    if (event > 0) {
        for (uint32_t n = 0; n < t->number_count; n++)
            sum[n] += ratio * t->values[entry * t->number_count + n];
        return;
    }
    double light = fmax(0, al_impulse_cosine(t->cosine_count, (uint32_t)(entry / t->distance_count)));
    for (uint32_t l = 0; l < bands; l++) sum[l] += ratio * light * sqrt((2 * l + 1) / (4 * AL_PI));
}

/* Events `first` (0 or 1) to the last of a medium that absorbs nothing. */
static al_status make_sum(work *w, al_impulse_emitter emitter, uint32_t first, al_error *error)
{
    uint32_t events = w->settings->events;
    if (first == events) return AL_OK;
    float *sums = add_table(w, emitter, AL_IMPULSE_AXIS_EMITTER, first, events, 0);
    if (!sums) return out_of_memory(error);
    const al_impulse_table *made = &w->tables[w->count - 1];
    for (size_t i = 0; i < (size_t)made->cosine_count * made->distance_count; i++) {
        double d = w->distances[i % made->distance_count], sum[AL_IMPULSE_NUMBER_LIMIT] = {0};
        for (uint32_t event = first; event <= events; event++)
            add_event(w, emitter, event, i,
                      al_impulse_falloff(emitter, event, event, d) /
                          al_impulse_falloff(emitter, first, events, d),
                      sum);
        for (uint32_t n = 0; n < made->number_count; n++) sums[i * made->number_count + n] = (float)sum[n];
    }
    return AL_OK;
}

/* The published form of every table of the area emitter that is not split by angle. */
static al_status make_fits(work *w, al_error *error)
{
    uint32_t count = w->count, bands = w->settings->bands;
    for (uint32_t i = 0; i < count; i++) {
        const al_impulse_table t = w->tables[i];
        if (t.emitter != AL_IMPULSE_AREA || t.angle_count) continue;
        float *fits = add_table(w, AL_IMPULSE_AREA, AL_IMPULSE_AXIS_FITTED, t.first_event, t.last_event, t.g);
        if (!fits) return out_of_memory(error);
        for (size_t e = 0; e < (size_t)t.cosine_count * t.distance_count; e++) {
            double numbers[AL_IMPULSE_NUMBER_LIMIT], fitted[1 + AL_IMPULSE_BAND_LIMIT];
            for (uint32_t n = 0; n < t.number_count; n++) numbers[n] = t.values[e * t.number_count + n];
            al_impulse_fit(bands, al_impulse_cosine(t.cosine_count, (uint32_t)(e / t.distance_count)),
                           numbers, fitted);
            for (uint32_t n = 0; n <= bands; n++) fits[e * (bands + 1) + n] = (float)fitted[n];
        }
    }
    return AL_OK;
}

/* --- everything --- */

uint64_t al_impulse_tables_key(const al_impulse_settings *s)
{
    char text[256];
    int size =
        snprintf(text, sizeof text,
                 "%s impulse-tables %d %" PRIu32 " %" PRIu32 " %" PRIu32 " %" PRIu32 " %.17g %.17g %.17g%s",
                 AIRLIGHT_VERSION, METHOD, s->bands, s->events, s->distances, s->cosines, s->distance_min,
                 s->distance_max, s->g_range, s->all_in_one ? " all in one" : "");
    return XXH64(text, (size_t)size, 0);
}

#define COMPARED(emitter) \
    "coefficients of " emitter " halfway between tabulated distances, each event, isotropic, over their length, " \
    "with double precision"

static al_status write_tables(const char *path, work *w, uint64_t key, uint64_t *bytes, al_error *error)
{
    const al_impulse_settings *s = w->settings;
    static const char *const compared[] = {
        COMPARED("a point"), COMPARED("a directional light"), COMPARED("an area")};
    char provenance[512], settings[160];
    snprintf(provenance, sizeof provenance,
             "{\"key\":\"%016" PRIx64 "\",\"bands\":%" PRIu32 ",\"events\":%" PRIu32 ",\"distances\":%" PRIu32
             ",\"cosines\":%" PRIu32 ",\"g\":%.17g}",
             key, s->bands, s->events, s->distances, s->cosines, s->g_range);
    snprintf(settings, sizeof settings, "%u bands, %u events, %u distances, %u cosines", s->bands, s->events,
             s->distances, s->cosines);
    al_measured measured[3];
    for (int e = 0; e < 3; e++) measured[e] = al_measure_result(&w->measures[e], compared[e], settings, "");
    const al_impulse_data data = {.info = {s->bands, s->events, w->count, s->distance_min, s->distance_max,
                                           w->rounding_error, w->interpolation_error},
                                  .tables = w->tables,
                                  .provenance_json = provenance,
                                  .measured = measured,
                                  .measured_count = 3};
    return al_impulse_tables_write(path, &data, bytes, error);
}

static void finish_step(al_steps *steps, const char *name, double *started, uint64_t bytes, uint64_t items)
{
    al_steps_add(steps, name, *started, bytes, items);
    *started = al_program_seconds();
}

static al_status make_all(work *w, const char *path, uint64_t key, al_steps *steps, al_error *error)
{
    static const char *const names[] = {"point", "directional", "area"};
    double started = al_program_seconds();
    uint64_t bytes = 0;
    al_status status = AL_OK;
    for (int e = 0; e < 3 && status == AL_OK; e++) {
        status = make_events(w, (al_impulse_emitter)e, error);
        if (status == AL_OK) finish_step(steps, names[e], &started, 0, w->settings->events);
    }
    for (int e = 0; e < 3 && status == AL_OK; e++) status = make_shares(w, (al_impulse_emitter)e, error);
    if (status == AL_OK) finish_step(steps, "angles of scattering", &started, 0, 3);
    for (uint32_t first = w->settings->all_in_one ? 0 : 1; first <= 1; first++)
        for (int e = 0; e < 3 && status == AL_OK; e++)
            status = make_sum(w, (al_impulse_emitter)e, first, error);
    if (status == AL_OK) status = make_fits(w, error);
    if (status == AL_OK) finish_step(steps, "sums and axes", &started, 0, w->count);
    for (int e = 0; e < 3 && status == AL_OK; e++) status = check_emitter(w, (al_impulse_emitter)e, error);
    if (status == AL_OK) finish_step(steps, "measure", &started, 0, w->settings->distances / 2);
    if (status == AL_OK) status = write_tables(path, w, key, &bytes, error);
    if (status == AL_OK) finish_step(steps, "write", &started, bytes, w->count);
    return status;
}

al_status al_impulse_tables_bake(const char *path, const al_impulse_settings *settings, uint64_t key,
                                 al_device *device, const al_bake_options *options, al_steps *steps,
                                 al_error *error)
{
    work *w = calloc(1, sizeof *w);
    if (!w) return out_of_memory(error);
    w->settings = settings;
    w->device = device;
    w->options = options;
    w->axis = (al_impulse_axis_steps){settings->distances, log(settings->distance_min),
                                      log(settings->distance_max / settings->distance_min) /
                                          (settings->distances - 1)};
    w->total = 6 * settings->events + 3;
    w->distances = malloc(settings->distances * sizeof *w->distances);
    al_status status = w->distances ? AL_OK : out_of_memory(error);
    for (uint32_t i = 0; i < settings->distances && status == AL_OK; i++)
        w->distances[i] = al_impulse_axis_distance(&w->axis, i);
    al_progress_begin(&w->progress, options->program, "impulse tables");
    if (status == AL_OK) status = make_all(w, path, key, steps, error);
    al_progress_end(&w->progress);
    for (uint32_t i = 0; i < w->owned_count; i++) free(w->owned[i]);
    free(w->distances);
    free(w);
    return status;
}
