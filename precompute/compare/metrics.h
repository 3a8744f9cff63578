/* How far picture A is from picture B, the one held to be right.
 *
 * Values that are not finite: in A they count as 0 (a display shows black there), where B or an error is not
 * finite the value is left out; both are counted. Undefined ratios are NaN; 0 / 0 of two equal black pictures
 * is 0 for errors and 1 for the mean ratio. */
#ifndef AIRLIGHT_METRICS_H
#define AIRLIGHT_METRICS_H

#include "airlight/image.h"

typedef enum al_metric {
    AL_METRIC_RMSE = 0,
    AL_METRIC_RELATIVE_RMSE, /* sqrt(sum (A-B)^2 / sum B^2) */
    AL_METRIC_PSNR_DB,       /* 10 log10(peak^2 / mean (A-B)^2), peak the largest |B| */
    AL_METRIC_FLIP_LDR,
    AL_METRIC_FLIP_HDR,
    AL_METRIC_MEAN_RATIO, /* sum A / sum B */
    AL_METRIC_MAX_ABS,
    AL_METRIC_NAN_COUNT, /* of the values of A and B */
    AL_METRIC_INF_COUNT,
    /* With B's standard error E: sqrt(max(0, sum (A-B)^2 - sum E^2) / sum B^2) */
    AL_METRIC_RELATIVE_RMSE_WITHOUT_NOISE,
    /* With A's standard error too: mean of (A-B)^2 / (EA^2 + EB^2) over the values where either error is not
     * 0 or A is not B; */
    AL_METRIC_CHI2_MEAN,
    /* and over blocks of 16x16 pixels: the largest difference of the block's means in its standard errors, of
     * the blocks whose means differ by more than 0.5 %; 0 when there is none. */
    AL_METRIC_BLOCK_WORST_SIGMA,
    AL_METRIC_COUNT
} al_metric;

const char *al_metric_name(al_metric metric); /* as in reports */

typedef struct al_comparison {
    const al_image *a, *b;             /* the same size; a single channel stands for all */
    const al_image *error_a, *error_b; /* standard errors, the same size, or NULL; error_a needs error_b */
} al_comparison;

typedef struct al_metrics {
    double values[AL_METRIC_COUNT]; /* NaN when undefined or not asked for */
    uint32_t count;                 /* metrics that were asked for: all before this one */
} al_metrics;

/* `map` is NULL or room for width * height values: the HDR-FLIP difference of each pixel, 0 to 1. */
al_status al_compare(const al_comparison *comparison, al_metrics *metrics, float *map, al_error *error);

#endif
