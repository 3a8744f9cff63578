#include "flip.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846
#define PIXELS_PER_DEGREE (0.7 * (3840 / 0.7) * (PI / 180))

enum {
    BAND_ROWS = 64,   /* rows of the map computed at once */
    RADIUS_LIMIT = 16 /* taps to each side of the widest filter; also the rows a band reads beyond itself */
};

/* --- colour --- */

/* Linear Rec. 709 to XYZ: from the primaries (0.64, 0.33), (0.30, 0.60), (0.15, 0.06) and the white point
 * (0.3127, 0.3290), as fractions. */
static const double rgb_to_xyz[3][3] = {
    {10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794},
    {2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897},
    {1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382},
};
static const double xyz_to_rgb[3][3] = {
    /* its inverse */
    {3.241003232976358, -1.537398969488785, -0.498615881996363},
    {-0.969224252202516, 1.875929983695176, 0.041554226340085},
    {0.055639419851975, -0.204011206123910, 1.057148977187533},
};
static const double white[3] = {0.950428545, 1.0, 1.088900371};

static void multiply(const double m[3][3], const double in[3], double out[3])
{
    for (int i = 0; i < 3; i++) out[i] = m[i][0] * in[0] + m[i][1] * in[1] + m[i][2] * in[2];
}

/* The opponent space YyCxCz: linear in the light, so that it may be filtered. */
static void to_opponent(const double rgb[3], double opponent[3])
{
    double xyz[3];
    multiply(rgb_to_xyz, rgb, xyz);
    for (int i = 0; i < 3; i++) xyz[i] /= white[i];
    opponent[0] = 116 * xyz[1] - 16;
    opponent[1] = 500 * (xyz[0] - xyz[1]);
    opponent[2] = 200 * (xyz[1] - xyz[2]);
}

static void from_opponent(const double opponent[3], double rgb[3])
{
    double y = (opponent[0] + 16) / 116;
    double xyz[3] = {(y + opponent[1] / 500) * white[0], y * white[1], (y - opponent[2] / 200) * white[2]};
    multiply(xyz_to_rgb, xyz, rgb);
}

/* CIE 1976 L*a*b* with chroma scaled by 0.01 L*: the Hunt effect, colours look paler in the dark. */
static void to_hunt_lab(const double rgb[3], double lab[3])
{
    const double delta = 6.0 / 29;
    double xyz[3], f[3];
    multiply(rgb_to_xyz, rgb, xyz);
    for (int i = 0; i < 3; i++) {
        double t = xyz[i] / white[i];
        f[i] = t > delta * delta * delta ? cbrt(t) : t / (3 * delta * delta) + 4.0 / 29;
    }
    lab[0] = 116 * f[1] - 16;
    lab[1] = 500 * (f[0] - f[1]) * 0.01 * lab[0];
    lab[2] = 200 * (f[1] - f[2]) * 0.01 * lab[0];
}

/* City-block in lightness, Euclidean in chroma (Abasi, Tehran and Fairchild 2020). */
static double hyab(const double a[3], const double b[3])
{
    return fabs(a[0] - b[0]) + hypot(a[1] - b[1], a[2] - b[2]);
}

/* --- filters: every two-dimensional one is a sum of products of these --- */

typedef struct kernel {
    int radius;
    float weights[2 * RADIUS_LIMIT + 1];
} kernel;

enum {
    ACHROMATIC,
    RED_GREEN,
    BLUE_YELLOW_WIDE,
    BLUE_YELLOW_NARROW,
    FEATURE_BLUR,
    FEATURE_EDGE,
    FEATURE_POINT,
    KERNEL_COUNT
};

typedef struct filter_bank {
    kernel kernels[KERNEL_COUNT];
    float wide_share; /* of the two Gaussians that make up blue-yellow */
    double error_max; /* colour error of the two most different colours, after the power */
} filter_bank;

/* One Gaussian a sqrt(pi/b) exp(-pi^2 x^2 / b) of a contrast sensitivity function, x in degrees. Normalised
 * to sum 1; answers the sum its square, the two-dimensional filter, had with the factor. */
static double make_sensitivity(double a, double b, int radius, kernel *out)
{
    double weights[2 * RADIUS_LIMIT + 1], sum = 0;
    for (int i = -radius; i <= radius; i++) {
        double x = i / PIXELS_PER_DEGREE;
        sum += weights[i + radius] = exp(-PI * PI * x * x / b);
    }
    out->radius = radius;
    for (int i = 0; i <= 2 * radius; i++) out->weights[i] = (float)(weights[i] / sum);
    return a * sqrt(PI / b) * sum * sum;
}

/* Gaussian of the width of a feature, and its first and second derivative; positive and negative weights are
 * brought to the sums 1 and -1 apart. */
static void make_features(filter_bank *bank)
{
    const double width_degrees = 0.082, deviation = 0.5 * width_degrees * PIXELS_PER_DEGREE;
    int radius = (int)ceil(3 * deviation);
    double blur_sum = 0, edge_sum = 0, positive_sum = 0, negative_sum = 0;
    double weights[3][2 * RADIUS_LIMIT + 1];
    for (int i = -radius; i <= radius; i++) {
        double gaussian = exp(-i * i / (2 * deviation * deviation));
        double point = (i * i / (deviation * deviation) - 1) * gaussian;
        weights[0][i + radius] = gaussian;
        weights[1][i + radius] = -i * gaussian;
        weights[2][i + radius] = point;
        blur_sum += gaussian;
        if (i < 0) edge_sum += -i * gaussian;
        if (point > 0)
            positive_sum += point;
        else
            negative_sum -= point;
    }
    for (int k = FEATURE_BLUR; k <= FEATURE_POINT; k++) bank->kernels[k].radius = radius;
    for (int i = 0; i <= 2 * radius; i++) {
        bank->kernels[FEATURE_BLUR].weights[i] = (float)(weights[0][i] / blur_sum);
        bank->kernels[FEATURE_EDGE].weights[i] = (float)(weights[1][i] / edge_sum);
        bank->kernels[FEATURE_POINT].weights[i] =
            (float)(weights[2][i] / (weights[2][i] > 0 ? positive_sum : negative_sum));
    }
}

static const double color_power = 0.7, feature_power = 0.5;

static void make_bank(filter_bank *bank)
{
    /* Three deviations of the widest Gaussian, exp(-pi^2 x^2 / b): deviation sqrt(b / 2) / pi. */
    const double widest = 0.04;
    int radius = (int)ceil(3 * sqrt(widest / (2 * PI * PI)) * PIXELS_PER_DEGREE);
    make_sensitivity(1.0, 0.0047, radius, &bank->kernels[ACHROMATIC]);
    make_sensitivity(1.0, 0.0053, radius, &bank->kernels[RED_GREEN]);
    double wide = make_sensitivity(34.1, 0.04, radius, &bank->kernels[BLUE_YELLOW_WIDE]);
    double narrow = make_sensitivity(13.5, 0.025, radius, &bank->kernels[BLUE_YELLOW_NARROW]);
    bank->wide_share = (float)(wide / (wide + narrow));
    make_features(bank);
    const double green[3] = {0, 1, 0}, blue[3] = {0, 0, 1};
    double a[3], b[3];
    to_hunt_lab(green, a);
    to_hunt_lab(blue, b);
    bank->error_max = pow(hyab(a, b), color_power);
}

/* Along the row; the picture's border pixels go on outside. */
static void filter_row(const kernel *k, const float *in, int width, float *out)
{
    for (int x = 0; x < width; x++) {
        float sum = 0;
        for (int i = -k->radius; i <= k->radius; i++) {
            int from = x + i < 0 ? 0 : x + i >= width ? width - 1 : x + i;
            sum += k->weights[i + k->radius] * in[from];
        }
        out[x] = sum;
    }
}

/* Down the columns at one row of a plane that has RADIUS_LIMIT more rows above and below. */
static void filter_column(const kernel *k, const float *row, int width, float *out)
{
    memset(out, 0, sizeof(float) * (size_t)width);
    for (int i = -k->radius; i <= k->radius; i++) {
        float weight = k->weights[i + k->radius];
        const float *from = row + (ptrdiff_t)i * width;
        for (int x = 0; x < width; x++) out[x] += weight * from[x];
    }
}

/* --- a band of rows --- */

enum { FILTERED_L, FILTERED_CX, FILTERED_CZ, EDGE, POINT, RESULT_COUNT };

typedef struct band {
    int width, rows;                /* rows: BAND_ROWS or fewer */
    float *source[3];               /* [rows + 2 RADIUS_LIMIT][width] opponent colours */
    float *across[KERNEL_COUNT];    /* the same size, filtered along rows */
    float *result[2][RESULT_COUNT]; /* [rows][width] of test and reference */
    float *line;                    /* [width] */
    float *memory;
} band;

static bool band_allocate(int width, band *out)
{
    size_t tall = (size_t)width * (BAND_ROWS + 2 * RADIUS_LIMIT), low = (size_t)width * BAND_ROWS;
    *out = (band){.width = width};
    out->memory =
        malloc(sizeof(float) * (tall * (3 + KERNEL_COUNT) + low * 2 * RESULT_COUNT + (size_t)width));
    if (!out->memory) return false;
    float *next = out->memory;
    for (int i = 0; i < 3; i++, next += tall) out->source[i] = next;
    for (int i = 0; i < KERNEL_COUNT; i++, next += tall) out->across[i] = next;
    for (int i = 0; i < 2 * RESULT_COUNT; i++, next += low)
        out->result[i / RESULT_COUNT][i % RESULT_COUNT] = next;
    out->line = next;
    return true;
}

/* How a linear value becomes what is shown: identity or tone-mapped at an exposure; then clamped to [0, 1].
 */
typedef struct display {
    bool tone_mapped;
    double exposure_factor;
} display;

/* ACES fit of Narkowicz 2015, (x (2.51 x + 0.03)) / (x (2.43 x + 0.59) + 0.14), its input scaled by 0.6. */
static const double aces[6] = {0.6 * 0.6 * 2.51, 0.6 * 0.03, 0, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14};

static double show(const display *d, double value)
{
    if (d->tone_mapped) {
        double x = fmax(value, 0) * d->exposure_factor;
        if (x > 1e6) return 1; /* the curve is above 1 from 10 on; no overflow of the squares */
        value = (aces[0] * x * x + aces[1] * x + aces[2]) / (aces[3] * x * x + aces[4] * x + aces[5]);
    }
    return value < 0 ? 0 : value > 1 ? 1 : value;
}

static void fill_source(const al_image *image, const display *d, int first_row, band *b)
{
    for (int r = -RADIUS_LIMIT; r < b->rows + RADIUS_LIMIT; r++) {
        int y = first_row + r, last = (int)image->height - 1;
        y = y < 0 ? 0 : y > last ? last : y;
        const float *pixels = image->pixels + (size_t)y * image->width * 3;
        size_t offset = (size_t)(r + RADIUS_LIMIT) * image->width;
        for (uint32_t x = 0; x < image->width; x++) {
            double rgb[3], opponent[3];
            for (int c = 0; c < 3; c++) rgb[c] = show(d, pixels[x * 3 + c]);
            to_opponent(rgb, opponent);
            for (int c = 0; c < 3; c++) b->source[c][offset + x] = (float)opponent[c];
        }
    }
}

/* sqrt(across(first) down(second)^2 + across(second) down(first)^2): the size of a gradient of features. */
static void feature_size(const filter_bank *bank, band *b, int derivative, size_t offset, float *out)
{
    filter_column(&bank->kernels[FEATURE_BLUR], b->across[derivative] + offset, b->width, out);
    filter_column(&bank->kernels[derivative], b->across[FEATURE_BLUR] + offset, b->width, b->line);
    for (int x = 0; x < b->width; x++) out[x] = hypotf(out[x], b->line[x]);
}

static void filter_band(const filter_bank *bank, band *b, float *result[RESULT_COUNT])
{
    static const int plane_of[KERNEL_COUNT] = {0, 1, 2, 2, 0, 0, 0};
    size_t width = (size_t)b->width;
    for (int k = 0; k < KERNEL_COUNT; k++)
        for (int r = 0; r < b->rows + 2 * RADIUS_LIMIT; r++)
            filter_row(&bank->kernels[k], b->source[plane_of[k]] + (size_t)r * width, b->width,
                       b->across[k] + (size_t)r * width);
    for (int r = 0; r < b->rows; r++) {
        size_t from = (size_t)(r + RADIUS_LIMIT) * width, to = (size_t)r * width;
        filter_column(&bank->kernels[ACHROMATIC], b->across[ACHROMATIC] + from, b->width,
                      result[FILTERED_L] + to);
        filter_column(&bank->kernels[RED_GREEN], b->across[RED_GREEN] + from, b->width,
                      result[FILTERED_CX] + to);
        filter_column(&bank->kernels[BLUE_YELLOW_WIDE], b->across[BLUE_YELLOW_WIDE] + from, b->width,
                      result[FILTERED_CZ] + to);
        filter_column(&bank->kernels[BLUE_YELLOW_NARROW], b->across[BLUE_YELLOW_NARROW] + from, b->width,
                      b->line);
        for (size_t x = 0; x < width; x++) {
            float *cz = &result[FILTERED_CZ][to + x];
            *cz = bank->wide_share * *cz + (1 - bank->wide_share) * b->line[x];
        }
        feature_size(bank, b, FEATURE_EDGE, from, result[EDGE] + to);
        feature_size(bank, b, FEATURE_POINT, from, result[POINT] + to);
    }
}

/* The power of the HyAB distance, redistributed: what lies below 0.4 of the largest fills [0, 0.95]. */
static double color_error(const filter_bank *bank, float *const test[RESULT_COUNT],
                          float *const reference[RESULT_COUNT], size_t i)
{
    const double share = 0.4, value = 0.95;
    double lab[2][3];
    float *const *results[2] = {test, reference};
    for (int side = 0; side < 2; side++) {
        double opponent[3], rgb[3];
        for (int c = 0; c < 3; c++) opponent[c] = results[side][FILTERED_L + c][i];
        from_opponent(opponent, rgb);
        for (int c = 0; c < 3; c++) rgb[c] = fmin(fmax(rgb[c], 0), 1);
        to_hunt_lab(rgb, lab[side]);
    }
    double error = pow(hyab(lab[0], lab[1]), color_power), knee = share * bank->error_max;
    if (error < knee) return value / knee * error;
    return fmin(value + (error - knee) / (bank->error_max - knee) * (1 - value), 1);
}

/* Features were found in Y of YyCxCz; its 116 units are one unit of luminance. */
static double feature_error(float *const test[RESULT_COUNT], float *const reference[RESULT_COUNT], size_t i)
{
    double edge = fabs(reference[EDGE][i] - test[EDGE][i]) / 116;
    double point = fabs(reference[POINT][i] - test[POINT][i]) / 116;
    return fmin(pow(fmax(edge, point) / sqrt(2), feature_power), 1);
}

/* Raises `map` to the LDR difference of the two pictures as the display shows them. */
static void raise_map(const filter_bank *bank, const al_image *test, const al_image *reference,
                      const display *d, band *b, float *map)
{
    const al_image *images[2] = {test, reference};
    int height = (int)test->height;
    for (int first = 0; first < height; first += BAND_ROWS) {
        b->rows = height - first < BAND_ROWS ? height - first : BAND_ROWS;
        for (int side = 0; side < 2; side++) {
            fill_source(images[side], d, first, b);
            filter_band(bank, b, b->result[side]);
        }
        float *out = map + (size_t)first * test->width;
        for (size_t i = 0; i < (size_t)b->rows * test->width; i++) {
            double color = color_error(bank, b->result[0], b->result[1], i);
            double feature = feature_error(b->result[0], b->result[1], i);
            float difference = (float)pow(color, 1 - feature);
            if (difference > out[i]) out[i] = difference;
        }
    }
}

static al_status out_of_memory(al_error *error)
{
    return al_fail(error, AL_IO, "out of memory while comparing with FLIP");
}

static al_status evaluate(const al_image *test, const al_image *reference, const display *displays, int count,
                          float *map, double *mean, al_error *error)
{
    filter_bank bank;
    band b;
    size_t pixels = (size_t)test->width * test->height;
    *mean = 0;
    make_bank(&bank);
    if (!band_allocate((int)test->width, &b)) return out_of_memory(error);
    memset(map, 0, sizeof(float) * pixels);
    for (int i = 0; i < count; i++) raise_map(&bank, test, reference, &displays[i], &b, map);
    double sum = 0;
    for (size_t i = 0; i < pixels; i++) sum += map[i];
    *mean = sum / (double)pixels;
    free(b.memory);
    return AL_OK;
}

al_status al_flip_ldr(const al_image *test, const al_image *reference, float *map, double *mean,
                      al_error *error)
{
    const display plain = {false, 1};
    return evaluate(test, reference, &plain, 1, map, mean, error);
}

static int compare_floats(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* Largest and median luminance of the reference; 0 and less count as the smallest number that is told from 0.
 */
static al_status luminance_range(const al_image *reference, double *largest, double *median, al_error *error)
{
    size_t count = (size_t)reference->width * reference->height;
    float *luminances = malloc(sizeof(float) * count);
    if (!luminances) return out_of_memory(error);
    for (size_t i = 0; i < count; i++) {
        const float *rgb = reference->pixels + 3 * i;
        luminances[i] = (float)(rgb_to_xyz[1][0] * fmax(rgb[0], 0) + rgb_to_xyz[1][1] * fmax(rgb[1], 0) +
                                rgb_to_xyz[1][2] * fmax(rgb[2], 0));
    }
    qsort(luminances, count, sizeof *luminances, compare_floats);
    *largest = fmax(luminances[count - 1], FLT_EPSILON);
    *median = count % 2 ? luminances[count / 2] : 0.5 * (luminances[count / 2 - 1] + luminances[count / 2]);
    *median = fmax(*median, FLT_EPSILON);
    free(luminances);
    return AL_OK;
}

/* The input that the tone curve maps to t = 0.85: the larger root of
 * (k0 - t k3) x^2 + (k1 - t k4) x + (k2 - t k5) = 0. */
static double brightest_input(void)
{
    const double t = 0.85;
    double a = aces[0] - t * aces[3], b = aces[1] - t * aces[4], c = aces[2] - t * aces[5];
    return (-b + sqrt(b * b - 4 * a * c)) / (2 * a);
}

al_status al_flip_hdr(const al_image *test, const al_image *reference, float *map, double *mean,
                      al_error *error)
{
    enum { EXPOSURE_LIMIT = 512 }; /* float32 spans less than 300 stops */
    display displays[EXPOSURE_LIMIT];
    double largest = 0, median = 0;
    *mean = 0;
    al_status status = luminance_range(reference, &largest, &median, error);
    if (status) return status;
    double start = log2(brightest_input() / largest), stop = log2(brightest_input() / median);
    int count = (int)fmin(fmax(2, ceil(stop - start)), EXPOSURE_LIMIT);
    for (int i = 0; i < count; i++)
        displays[i] = (display){true, exp2(start + i * (stop - start) / (count - 1))};
    return evaluate(test, reference, displays, count, map, mean, error);
}
