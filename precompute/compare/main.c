/* airlight-compare: how far one picture is from another, and whether that is too far. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/image.h"
#include "airlight/program.h"
#include "metrics.h"

typedef struct limit {
    al_metric metric;
    double value;
} limit;

typedef struct arguments {
    const char *a, *b, *error_b, *error_a, *diff;
    bool json;
    limit limits[AL_OPTION_LIST_LIMIT];
    int limit_count;
} arguments;

/* METRIC=VALUE */
static al_status parse_limit(const arguments *given, const char *text, limit *out, al_error *error)
{
    const char *equals = strchr(text, '=');
    if (!equals) return al_fail(error, AL_USAGE, "--fail-above takes METRIC=VALUE, not '%s'", text);
    size_t length = (size_t)(equals - text), metric = 0;
    while (metric < AL_METRIC_COUNT && (strlen(al_metric_name((al_metric)metric)) != length ||
                                        memcmp(al_metric_name((al_metric)metric), text, length)))
        metric++;
    if (metric == AL_METRIC_COUNT) {
        char names[512] = "";
        for (int i = 0; i < AL_METRIC_COUNT; i++) {
            size_t used = strlen(names);
            snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", al_metric_name((al_metric)i));
        }
        return al_fail(error, AL_USAGE, "--fail-above knows no metric '%.*s'; it is one of %s", (int)length,
                       text, names);
    }
    char *end;
    out->metric = (al_metric)metric;
    out->value = strtod(equals + 1, &end);
    if (end == equals + 1 || *end || !isfinite(out->value))
        return al_fail(error, AL_USAGE, "--fail-above %.*s takes a number, not '%s'", (int)length, text,
                       equals + 1);
    if (metric >= AL_METRIC_CHI2_MEAN && !given->error_a)
        return al_fail(error, AL_USAGE, "--fail-above %.*s needs --error and --noise-a", (int)length, text);
    if (metric >= AL_METRIC_RELATIVE_RMSE_WITHOUT_NOISE && !given->error_b)
        return al_fail(error, AL_USAGE, "--fail-above %.*s needs --error", (int)length, text);
    return AL_OK;
}

/* Reads a picture of the size of `like` (NULL: any). */
static al_status read_like(const char *path, const al_image *like, const char *like_path, al_image *image,
                           al_error *error)
{
    al_status status = al_image_read_exr(path, image, error);
    if (status) return status;
    if (!like || (image->width == like->width && image->height == like->height)) return AL_OK;
    status = al_fail(error, AL_BAD_INPUT, "%s: %u x %u pixels, but %s has %u x %u; the sizes must be equal",
                     path, image->width, image->height, like_path, like->width, like->height);
    al_image_free(image);
    return status;
}

/* From black over blue, red and yellow to white, each step brighter than the one before. */
static void heat_color(float value, uint8_t rgb[3])
{
    static const float stops[5][3] = {
        {0, 0, 0.02f}, {0.05f, 0.02f, 0.4f}, {0.75f, 0.03f, 0.1f}, {1, 0.6f, 0.02f}, {1, 1, 0.9f}};
    float place = fminf(fmaxf(value, 0), 1) * 4;
    int i = place >= 4 ? 3 : (int)place;
    for (int c = 0; c < 3; c++)
        rgb[c] = al_srgb_byte(stops[i][c] + (place - (float)i) * (stops[i + 1][c] - stops[i][c]));
}

static al_status write_heat_map(const char *path, const al_image *like, const float *map, al_error *error)
{
    size_t count = (size_t)like->width * like->height;
    uint8_t *pixels = malloc(3 * count);
    if (!pixels)
        return al_fail(error, AL_IO, "%s: out of memory for %u x %u pixels", path, like->width, like->height);
    for (size_t i = 0; i < count; i++) heat_color(map[i], pixels + 3 * i);
    al_status status = al_image_write_png(path, like->width, like->height, 3, pixels, error);
    free(pixels);
    return status;
}

static void print_value(double value, bool json)
{
    if (isfinite(value))
        printf("%.9g", value);
    else if (json)
        printf("null");
    else
        printf("%s", isnan(value) ? "undefined" : value > 0 ? "infinite" : "-infinite");
}

static void print_metrics(const al_metrics *metrics, bool json)
{
    if (json) printf("{");
    for (uint32_t i = 0; i < metrics->count; i++) {
        const char *name = al_metric_name((al_metric)i);
        if (json)
            printf("%s\n  \"%s\": ", i ? "," : "", name);
        else
            printf("%s ", name);
        print_value(metrics->values[i], json);
        if (!json) printf("\n");
    }
    if (json) printf("\n}\n");
}

/* What is undefined is over every limit. */
static al_status check_limits(const arguments *given, const al_metrics *metrics, al_error *error)
{
    for (int i = 0; i < given->limit_count; i++) {
        const limit *l = &given->limits[i];
        double value = metrics->values[l->metric];
        if (!(value <= l->value))
            return al_fail(error, AL_CHECK_FAILED, "%s: %s is %.6g against %s, above the allowed %g",
                           given->a, al_metric_name(l->metric), value, given->b, l->value);
    }
    return AL_OK;
}

static al_status compare(const arguments *given, al_error *error)
{
    al_image a = {0}, b = {0}, error_a = {0}, error_b = {0};
    float *map = NULL;
    al_status status = al_image_read_exr(given->b, &b, error);
    if (!status) status = read_like(given->a, &b, given->b, &a, error);
    if (!status && given->error_b) status = read_like(given->error_b, &b, given->b, &error_b, error);
    if (!status && given->error_a) status = read_like(given->error_a, &b, given->b, &error_a, error);
    if (status) goto cleanup;
    if (given->diff && !(map = malloc(sizeof(float) * b.width * b.height))) {
        status =
            al_fail(error, AL_IO, "%s: out of memory for %u x %u pixels", given->diff, b.width, b.height);
        goto cleanup;
    }
    al_comparison comparison = {&a, &b, given->error_a ? &error_a : NULL, given->error_b ? &error_b : NULL};
    al_metrics metrics;
    status = al_compare(&comparison, &metrics, map, error);
    if (!status && given->diff) status = write_heat_map(given->diff, &b, map, error);
    if (status) goto cleanup;
    print_metrics(&metrics, given->json);
    status = fflush(stdout) ? al_fail_errno(error, "standard output", "write")
                            : check_limits(given, &metrics, error);

cleanup:
    free(map);
    al_image_free(&a);
    al_image_free(&b);
    al_image_free(&error_a);
    al_image_free(&error_b);
    return status;
}

int main(int argc, char **argv)
{
    arguments given = {0};
    al_option_list limits = {0};
    const al_option options[] = {
        {"--error", "E.exr", AL_OPTION_STRING, &given.error_b,
         "B's standard error: adds relative_rmse_without_noise", 0, 0},
        {"--noise-a", "EA.exr", AL_OPTION_STRING, &given.error_a,
         "A's standard error: adds chi2_mean and block_worst_sigma", 0, 0},
        {"--fail-above", "METRIC=VALUE", AL_OPTION_LIST, &limits,
         "exit 1 when the metric is larger or undefined; repeatable", 0, 0},
        {"--json", NULL, AL_OPTION_FLAG, &given.json, "print one JSON object", 0, 0},
        {"--diff", "OUT.png", AL_OPTION_STRING, &given.diff,
         "write HDR-FLIP per pixel: black 0, blue, red, yellow, white 1", 0, 0},
    };
    al_program program = {
        .name = "airlight-compare",
        .usage = "A.exr B.exr [options]",
        .summary =
            "Measures how far picture A is from B, the one held to be right: rmse, relative_rmse =\n"
            "sqrt(sum (A-B)^2 / sum B^2), psnr_db (peak: B's largest value), FLIP of the sRGB picture "
            "clamped\n"
            "to [0, 1] (flip_ldr) and over exposures (flip_hdr) at 67.02 pixels per degree, mean_ratio =\n"
            "sum A / sum B, max_abs, nan_count and inf_count of both.\n"
            "A single channel stands for all. NaN and infinite values: in A they count as 0, where B or an\n"
            "error has one the value is left out.\n"
            "chi2_mean is the mean of (A-B)^2 / (EA^2 + EB^2), about 1 when A and B differ by noise alone;\n"
            "block_worst_sigma the largest difference of 16x16 block means in standard errors, among the\n"
            "blocks that differ by more than 0.5 %.",
        .options = options,
        .option_count = sizeof options / sizeof *options,
    };
    const char *paths[2];
    size_t path_count;
    int code = al_program_parse(&program, argc, argv, paths, 2, 2, &path_count);
    if (code >= 0) return code;
    given.a = paths[0];
    given.b = paths[1];
    al_error error = {0};
    al_status status = AL_OK;
    if (given.diff) status = al_program_check_ending("--diff", given.diff, ".png", &error);
    if (!status && given.error_a && !given.error_b)
        status = al_fail(&error, AL_USAGE, "--noise-a needs --error");
    for (int i = 0; !status && i < limits.count; i++)
        status = parse_limit(&given, limits.values[i], &given.limits[given.limit_count++], &error);
    if (!status) status = compare(&given, &error);
    return status ? al_program_fail(&program, &error) : AL_OK;
}
