#include "metrics.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "flip.h"

const char *al_metric_name(al_metric metric)
{
    static const char *const names[AL_METRIC_COUNT] = {
        [AL_METRIC_RMSE] = "rmse",
        [AL_METRIC_RELATIVE_RMSE] = "relative_rmse",
        [AL_METRIC_PSNR_DB] = "psnr_db",
        [AL_METRIC_FLIP_LDR] = "flip_ldr",
        [AL_METRIC_FLIP_HDR] = "flip_hdr",
        [AL_METRIC_MEAN_RATIO] = "mean_ratio",
        [AL_METRIC_MAX_ABS] = "max_abs",
        [AL_METRIC_NAN_COUNT] = "nan_count",
        [AL_METRIC_INF_COUNT] = "inf_count",
        [AL_METRIC_RELATIVE_RMSE_WITHOUT_NOISE] = "relative_rmse_without_noise",
        [AL_METRIC_CHI2_MEAN] = "chi2_mean",
        [AL_METRIC_BLOCK_WORST_SIGMA] = "block_worst_sigma",
    };
    return names[metric];
}

/* Value `channel` of pixel `i`; a single channel stands for all. */
static double value_of(const al_image *image, size_t i, uint32_t channel)
{
    return image->pixels[i * image->channels + (image->channels == 1 ? 0 : channel)];
}

/* One pair of values, cleaned; false when it is left out. Errors are 0 without pictures of them. */
typedef struct pair {
    double a, b, error_a, error_b;
} pair;

static bool read_pair(const al_comparison *c, size_t i, uint32_t channel, pair *out)
{
    *out = (pair){value_of(c->a, i, channel), value_of(c->b, i, channel), 0, 0};
    if (c->error_a) out->error_a = value_of(c->error_a, i, channel);
    if (c->error_b) out->error_b = value_of(c->error_b, i, channel);
    if (!isfinite(out->a)) out->a = 0;
    return isfinite(out->b) && isfinite(out->error_a) && isfinite(out->error_b);
}

static uint32_t channel_count(const al_comparison *c)
{
    return c->a->channels > c->b->channels ? c->a->channels : c->b->channels;
}

static double ratio(double numerator, double denominator, double of_zeros)
{
    if (denominator != 0) return numerator / denominator;
    return numerator == 0 ? of_zeros : NAN;
}

static void count_special(const al_image *image, double *values)
{
    for (size_t i = 0; i < (size_t)image->width * image->height * image->channels; i++) {
        values[AL_METRIC_NAN_COUNT] += isnan(image->pixels[i]) != 0;
        values[AL_METRIC_INF_COUNT] += isinf(image->pixels[i]) != 0;
    }
}

static void compare_values(const al_comparison *c, double *values)
{
    double square = 0, square_b = 0, square_error = 0, sum_a = 0, sum_b = 0, peak = 0, largest = 0;
    double count = 0, chi2 = 0, chi2_count = 0;
    uint32_t channels = channel_count(c);
    for (size_t i = 0; i < (size_t)c->a->width * c->a->height; i++)
        for (uint32_t channel = 0; channel < channels; channel++) {
            pair p;
            if (!read_pair(c, i, channel, &p)) continue;
            double difference = p.a - p.b, variance = p.error_a * p.error_a + p.error_b * p.error_b;
            count++;
            square += difference * difference;
            square_b += p.b * p.b;
            square_error += p.error_b * p.error_b;
            sum_a += p.a;
            sum_b += p.b;
            peak = fmax(peak, fabs(p.b));
            largest = fmax(largest, fabs(difference));
            if (variance == 0 && difference == 0) continue;
            chi2 += difference * difference / variance;
            chi2_count++;
        }
    values[AL_METRIC_RMSE] = sqrt(ratio(square, count, NAN));
    values[AL_METRIC_RELATIVE_RMSE] = sqrt(ratio(square, square_b, 0));
    values[AL_METRIC_PSNR_DB] = 10 * log10(peak * peak * count / square);
    values[AL_METRIC_MEAN_RATIO] = ratio(sum_a, sum_b, 1);
    values[AL_METRIC_MAX_ABS] = largest;
    values[AL_METRIC_RELATIVE_RMSE_WITHOUT_NOISE] = sqrt(ratio(fmax(square - square_error, 0), square_b, 0));
    values[AL_METRIC_CHI2_MEAN] = ratio(chi2, chi2_count, 0);
}

/* Difference of the block's means in standard errors; 0 where they differ by at most 0.5 %. The errors of the
 * channels of one pixel are taken as fully correlated, those of pixels as independent. */
static double block_sigma(const al_comparison *c, uint32_t x0, uint32_t y0, uint32_t edge)
{
    double sum_a = 0, sum_b = 0, variance = 0;
    uint32_t channels = channel_count(c);
    for (uint32_t y = y0; y < y0 + edge && y < c->a->height; y++)
        for (uint32_t x = x0; x < x0 + edge && x < c->a->width; x++) {
            double error_a = 0, error_b = 0;
            for (uint32_t channel = 0; channel < channels; channel++) {
                pair p;
                if (!read_pair(c, (size_t)y * c->a->width + x, channel, &p)) continue;
                sum_a += p.a;
                sum_b += p.b;
                error_a += p.error_a;
                error_b += p.error_b;
            }
            variance += error_a * error_a + error_b * error_b;
        }
    double difference = fabs(sum_a - sum_b);
    return difference <= 0.005 * fabs(sum_b) ? 0 : difference / sqrt(variance);
}

static double worst_block(const al_comparison *c)
{
    enum { EDGE = 16 };
    double worst = 0;
    for (uint32_t y = 0; y < c->a->height; y += EDGE)
        for (uint32_t x = 0; x < c->a->width; x += EDGE) worst = fmax(worst, block_sigma(c, x, y, EDGE));
    return worst;
}

/* Three finite channels for FLIP; where B is not finite both are black, so that they do not differ. */
static bool displayed(const al_comparison *c, bool of_a, al_image *out)
{
    size_t count = (size_t)c->a->width * c->a->height;
    *out = (al_image){c->a->width, c->a->height, 3, malloc(sizeof(float) * 3 * count)};
    if (!out->pixels) return false;
    for (size_t i = 0; i < count; i++)
        for (uint32_t channel = 0; channel < 3; channel++) {
            double a = value_of(c->a, i, channel), b = value_of(c->b, i, channel);
            double shown = of_a ? a : b;
            out->pixels[3 * i + channel] = isfinite(b) && isfinite(shown) ? (float)shown : 0;
        }
    return true;
}

static al_status compare_flip(const al_comparison *c, double *values, float *map, al_error *error)
{
    al_image test = {0}, reference = {0};
    float *scratch = map ? NULL : malloc(sizeof(float) * c->a->width * c->a->height);
    al_status status = AL_OK;
    if ((!map && !scratch) || !displayed(c, true, &test) || !displayed(c, false, &reference)) {
        status = al_fail(error, AL_IO, "out of memory for %u x %u pixels", c->a->width, c->a->height);
        goto cleanup;
    }
    float *out = map ? map : scratch;
    status = al_flip_ldr(&test, &reference, out, &values[AL_METRIC_FLIP_LDR], error);
    if (!status) status = al_flip_hdr(&test, &reference, out, &values[AL_METRIC_FLIP_HDR], error);

cleanup:
    free(scratch);
    al_image_free(&test);
    al_image_free(&reference);
    return status;
}

al_status al_compare(const al_comparison *c, al_metrics *metrics, float *map, al_error *error)
{
    *metrics = (al_metrics){0};
    metrics->count = c->error_a   ? AL_METRIC_COUNT
                     : c->error_b ? AL_METRIC_RELATIVE_RMSE_WITHOUT_NOISE + 1
                                  : AL_METRIC_RELATIVE_RMSE_WITHOUT_NOISE;
    count_special(c->a, metrics->values);
    count_special(c->b, metrics->values);
    compare_values(c, metrics->values);
    if (c->error_a) metrics->values[AL_METRIC_BLOCK_WORST_SIGMA] = worst_block(c);
    for (uint32_t i = metrics->count; i < AL_METRIC_COUNT; i++) metrics->values[i] = NAN;
    al_status status = compare_flip(c, metrics->values, map, error);
    if (status) *metrics = (al_metrics){0};
    return status;
}
