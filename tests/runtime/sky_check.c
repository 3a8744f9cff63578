/* The player's fog under a sky:
 *   sky_check BAKED uniform SIGMA_S SIGMA_A G LAYERED LIMIT   against quadrature in double precision
 *   sky_check BAKED reference PICTURE.exr ERROR.exr LIMIT     against a picture by airlight-reference
 *   sky_check BAKED dark LIMIT                                no pixel above LIMIT, W/(m2 sr)
 * LIMIT is a relative RMSE, of pictures with the reference's noise taken out. */
#include <stdlib.h>
#include <string.h>

#include "../test.h"
#include "airlight/formulas.h"
#include "airlight/image.h"
#include "stage.h"

enum { EDGE = 8, FRAMES = 16, PLACES = 256, COSINES = 64, AZIMUTHS = 32 };
static const al_settings settings = {.pass = AL_PASS_DIRECT_SCATTERING};

/* --- a box from -1 to 1 m of constant density, or with layers, under a sky of 1 W/(m2 sr) --- */

typedef struct box_fog {
    double sigma_s, sigma_t, g;
    bool layered; /* sky.sh: 1 in the lower half of every 0.5 m, 0.2 in the upper one */
} box_fog;

/* The density's integral over y from 0. */
static double layers_to(double y)
{
    double whole = floor(y / 0.5);
    return 0.2 * y + 0.8 * (0.25 * whole + fmin(y - 0.5 * whole, 0.25));
}

static double depth_of(const box_fog *fog, const double from[3], const double direction[3], double length)
{
    double step = length * direction[1];
    if (!fog->layered) return fog->sigma_t * length;
    if (fabs(step) < 1e-6)
        return fog->sigma_t * length * (layers_to(from[1] + 1e-6) - layers_to(from[1])) / 1e-6;
    return fog->sigma_t * length * (layers_to(from[1] + step) - layers_to(from[1])) / step;
}

/* From inside to the box's face. */
static double exit_of(const double from[3], const double direction[3])
{
    double nearest = INFINITY;
    for (int k = 0; k < 3; k++)
        if (direction[k] != 0)
            nearest = fmin(nearest, ((direction[k] > 0 ? 1 : -1) - from[k]) / direction[k]);
    return fmax(nearest, 0);
}

/* The mean of T over directions about the axis that share the phase function evenly. */
static double scattered_at(const box_fog *fog, const double x[3], const double axis[3])
{
    double u[3] = {axis[2], 0, -axis[0]}, length = sqrt(u[0] * u[0] + u[2] * u[2]), v[3], sum = 0, g = fog->g;
    for (int k = 0; k < 3; k++) u[k] /= length;
    for (int k = 0; k < 3; k++)
        v[k] = axis[(k + 1) % 3] * u[(k + 2) % 3] - axis[(k + 2) % 3] * u[(k + 1) % 3];
    for (int i = 0; i < COSINES * AZIMUTHS; i++) {
        double share = (i / AZIMUTHS + 0.5) / COSINES, phi = 2 * AL_PI * (i % AZIMUTHS + 0.5) / AZIMUTHS,
               w[3];
        double root = (1 - g * g) / (1 - g + 2 * g * share); /* Henyey-Greenstein's distribution, inverted */
        double cosine = g == 0 ? 2 * share - 1 : (1 + g * g - root * root) / (2 * g),
               sine = sqrt(1 - cosine * cosine);
        for (int k = 0; k < 3; k++) w[k] = cosine * axis[k] + sine * (cos(phi) * u[k] + sin(phi) * v[k]);
        sum += exp(-depth_of(fog, x, w, exit_of(x, w)));
    }
    return sum / (COSINES * AZIMUTHS);
}

/* The radiance that the box scatters once along a ray that enters at `from`: places share what T loses where
 * the density is constant, else the way. */
static double along(const box_fog *fog, const double from[3], const double direction[3])
{
    double length = exit_of(from, direction), whole = 1 - exp(-fog->sigma_t * length), sum = 0;
    for (int i = 0; i < PLACES; i++) {
        double share = (i + 0.5) / PLACES, x[3];
        double t = fog->layered ? share * length : -log(1 - share * whole) / fog->sigma_t;
        for (int k = 0; k < 3; k++) x[k] = from[k] + t * direction[k];
        double density = layers_to(x[1] + 1e-9) - layers_to(x[1] - 1e-9);
        double weight = fog->layered
                            ? fog->sigma_s * density / 2e-9 * exp(-depth_of(fog, from, direction, t)) * length
                            : fog->sigma_s / fog->sigma_t * whole;
        sum += weight * scattered_at(fog, x, direction) / PLACES;
    }
    return sum;
}

static void check_uniform(al_runtime *runtime, char **arguments)
{
    const box_fog fog = {.sigma_s = atof(arguments[0]),
                         .sigma_t = atof(arguments[0]) + atof(arguments[1]),
                         .g = atof(arguments[2]),
                         .layered = atoi(arguments[3])};
    const double tangent = 0.24, eye_y = 0.07; /* rays that stay off the layers' edges */
    al_view view = stage_look(EDGE, EDGE, (float[3]){0, (float)eye_y, 5}, (float[3]){0, (float)eye_y, 0},
                              2 * (float)atan(tangent));
    float *pixels = stage_draw(runtime, &view, &settings, 0);
    double squared = 0, scale = 0, largest = 0, sum = 0, wanted_sum = 0;
    CHECK(pixels && stage_bad(pixels, EDGE * EDGE * 3) == 0);
    for (int i = 0; pixels && i < EDGE * EDGE; i++) {
        double d[3] = {(2 * (i % EDGE + 0.5) / EDGE - 1) * tangent,
                       (2 * (i / EDGE + 0.5) / EDGE - 1) * tangent, -1};
        double length = sqrt(d[0] * d[0] + d[1] * d[1] + 1), from[3] = {4 * d[0], eye_y + 4 * d[1], 1};
        for (int k = 0; k < 3; k++) d[k] /= length;
        double wanted = along(&fog, from, d);
        squared += (pixels[3 * i] - wanted) * (pixels[3 * i] - wanted);
        scale += wanted * wanted;
        sum += pixels[3 * i];
        wanted_sum += wanted;
        largest = fmax(largest, pixels[3 * i]);
    }
    printf("relative RMSE %.4f, mean ratio %.4f, largest %.4f\n", sqrt(squared / scale), sum / wanted_sum,
           largest);
    CHECK(sqrt(squared / scale) <= atof(arguments[4]));
    CHECK(largest <= 1); /* nothing is brighter than the sky by scattering it */
    free(pixels);
}

/* --- pictures --- */

/* The mean over sub-pixel offsets of a 4 x 4 grid, as the reference's box filter averages over pixels. */
static float *draw_mean(al_runtime *runtime, uint32_t width, uint32_t height)
{
    const al_camera *camera = al_runtime_scene(runtime)->cameras;
    al_view view = stage_look(width, height, camera->position, camera->target, camera->fov_y_radians);
    size_t count = (size_t)width * height * 3;
    float *sum = calloc(count, sizeof *sum);
    for (int frame = 0; sum && frame < FRAMES; frame++) {
        view.projection[8] = (float)((frame % 4 + 0.5) / 4 - 0.5) * 2 / (float)width;
        view.projection[9] = (float)((frame / 4 + 0.5) / 4 - 0.5) * 2 / (float)height;
        float *pixels = stage_draw(runtime, &view, &settings, 0);
        CHECK(pixels && stage_bad(pixels, count) == 0);
        for (size_t i = 0; pixels && i < count; i++) sum[i] += pixels[i] / FRAMES;
        free(pixels);
    }
    return sum;
}

static void check_reference(al_runtime *runtime, char **arguments)
{
    al_image wanted = {0}, error = {0};
    al_error failure = {0};
    CHECK(!al_image_read_exr(arguments[0], &wanted, &failure) &&
          !al_image_read_exr(arguments[1], &error, &failure));
    uint32_t width = (uint32_t)wanted.width, height = (uint32_t)wanted.height;
    float *mean = draw_mean(runtime, width, height);
    double squared = 0, noise = 0, scale = 0, sum = 0, wanted_sum = 0;
    for (uint32_t y = 0; mean && y < height; y++)
        for (uint32_t x = 0; x < width; x++)
            for (uint32_t c = 0; c < 3; c++) {
                double a = mean[3 * ((height - 1 - y) * width + x) + c];
                double b = wanted.pixels[wanted.channels * (y * width + x) + c];
                double e = error.pixels[error.channels * (y * width + x)];
                squared += (a - b) * (a - b);
                noise += e * e;
                scale += b * b;
                sum += a;
                wanted_sum += b;
            }
    double without = sqrt(fmax(squared - noise, 0) / scale);
    printf("relative RMSE %.4f, without noise %.4f, mean ratio %.4f\n", sqrt(squared / scale), without,
           sum / wanted_sum);
    CHECK(without <= atof(arguments[2]));
    al_image_free(&wanted);
    al_image_free(&error);
    free(mean);
}

static void check_dark(al_runtime *runtime, char **arguments)
{
    enum { WIDTH = 64 };
    float *mean = draw_mean(runtime, WIDTH, WIDTH), largest = 0;
    for (int i = 0; mean && i < WIDTH * WIDTH * 3; i++) largest = fmaxf(largest, mean[i]);
    printf("largest %g\n", (double)largest);
    CHECK(mean && largest <= atof(arguments[0]));
    free(mean);
}

int main(int argc, char **argv)
{
    al_runtime *runtime = NULL;
    al_error failure = {0};
    if (argc < 4) return 2;
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    if (al_runtime_create(NULL, &runtime, &failure) || !stage_load(runtime, argv[1])) {
        fprintf(stderr, "%s\n", failure.message);
        return 1;
    }
    if (!strcmp(argv[2], "uniform") && argc == 8)
        check_uniform(runtime, argv + 3);
    else if (!strcmp(argv[2], "reference") && argc == 6)
        check_reference(runtime, argv + 3);
    else if (!strcmp(argv[2], "dark"))
        check_dark(runtime, argv + 3);
    else
        return 2;
    al_runtime_destroy(runtime);
    return test_end();
}
