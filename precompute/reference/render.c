#include "render.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "parallel.h"
#include "sampling.h"

/* Within a batch samples are stratified, across batches they are independent: the spread of the batches'
 * means tells the error. More batches tell it better, fewer stratify better: 8 samples to a batch, within
 * these. */
enum { BATCH_MINIMUM = 8, BATCH_LIMIT = 16, BATCH_SAMPLES = 8, RUN_PIXELS = 16 };

typedef struct worker {
    void *scratch;
    double *points; /* of one batch */
} worker;

typedef struct render {
    const al_mode *mode;
    const void *state;
    const al_render_options *options;
    al_image *image, *standard_error;
    worker *workers;
    uint32_t batches, dimensions;
    double position[3], forward[3], right[3],
        up[3]; /* right and up reach the picture's border at distance 1 */
    atomic_uint pixels_done;
    atomic_bool out_of_memory, stopped;
} render;

static uint32_t runs_per_row(const al_render_options *options)
{
    return (options->width + RUN_PIXELS - 1) / RUN_PIXELS;
}

static double length_of(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static al_status aim(render *r, al_error *error)
{
    const al_camera *camera = r->options->camera;
    double up[3], half = tan(0.5 * camera->fov_y_radians);
    for (int k = 0; k < 3; k++) {
        r->position[k] = camera->position[k];
        r->forward[k] = (double)camera->target[k] - camera->position[k];
        up[k] = camera->up[k];
    }
    double distance = length_of(r->forward);
    cross(r->forward, up, r->right);
    double across = length_of(r->right);
    if (!(across > 1e-9 * distance * length_of(up)))
        return al_fail(error, AL_BAD_INPUT, "camera \"%s\": its up direction must not point at its target",
                       camera->name);
    for (int k = 0; k < 3; k++) {
        r->forward[k] /= distance;
        r->right[k] /= across;
    }
    cross(r->right, r->forward, r->up);
    for (int k = 0; k < 3; k++) {
        r->up[k] *= half;
        r->right[k] *= half * r->options->width / r->options->height;
    }
    return AL_OK;
}

/* Through the point (x, y) of the picture, in pixels from its upper left corner. */
static al_ray eye_ray(const render *r, double x, double y)
{
    al_ray ray;
    double across = 2 * x / r->options->width - 1, upwards = 1 - 2 * y / r->options->height;
    for (int k = 0; k < 3; k++) {
        ray.origin[k] = r->position[k];
        ray.direction[k] = r->forward[k] + across * r->right[k] + upwards * r->up[k];
    }
    double length = length_of(ray.direction);
    for (int k = 0; k < 3; k++) ray.direction[k] /= length;
    return ray;
}

/* Mean of one batch; two of the dimensions are the place in the pixel. */
static bool render_batch(const render *r, worker *w, uint32_t x, uint32_t y, uint32_t batch, double mean[3])
{
    uint64_t pixel = (uint64_t)y * r->options->width + x;
    uint32_t count = r->options->samples / r->batches + (batch < r->options->samples % r->batches);
    al_random random = al_random_for(pixel, batch);
    al_sample_hypercube(&random, count, r->dimensions, w->points);
    mean[0] = mean[1] = mean[2] = 0;
    for (uint32_t i = 0; i < count; i++) {
        const double *point = w->points + (size_t)i * r->dimensions;
        al_ray eye = eye_ray(r, x + point[0], y + point[1]);
        double radiance[3];
        if (!r->mode->radiance(r->state, w->scratch, &eye, point + 2, radiance)) return false;
        for (int c = 0; c < 3; c++) mean[c] += radiance[c] / count;
    }
    return true;
}

/* Asked between batches, so that a long pixel can be stopped too; the calling thread is number 0. */
static bool is_stopped(render *r, unsigned thread)
{
    const al_render_options *options = r->options;
    if (thread == 0 && options->on_progress &&
        options->on_progress(options->user, r->pixels_done, (double)options->width * options->height))
        r->stopped = true;
    return r->stopped;
}

/* Mean m of B independent batch means m_b; its variance is estimated without bias, whatever B and however the
 * batches' own variances differ, by sum (m_b - m)^2 / (B (B - 1)). */
static bool render_pixel(render *r, unsigned thread, uint32_t x, uint32_t y)
{
    double means[BATCH_LIMIT][3], error = 0;
    for (uint32_t b = 0; b < r->batches; b++) {
        if (is_stopped(r, thread)) return false;
        if (render_batch(r, &r->workers[thread], x, y, b, means[b])) continue;
        r->out_of_memory = true;
        return false;
    }
    size_t pixel = (size_t)y * r->options->width + x;
    for (int c = 0; c < 3; c++) {
        double mean = 0, square = 0;
        for (uint32_t b = 0; b < r->batches; b++) mean += means[b][c] / r->batches;
        for (uint32_t b = 0; b < r->batches; b++) square += (means[b][c] - mean) * (means[b][c] - mean);
        r->image->pixels[3 * pixel + c] = (float)mean;
        error += sqrt(square / ((double)r->batches * (r->batches - 1))) / 3;
    }
    r->standard_error->pixels[pixel] = (float)error;
    return true;
}

/* A run of a row's pixels: short, so that threads end together. */
static bool render_run(void *user, unsigned piece, unsigned thread)
{
    render *r = user;
    uint32_t runs = runs_per_row(r->options), first = piece % runs * RUN_PIXELS;
    for (uint32_t x = first; x < first + RUN_PIXELS && x < r->options->width; x++) {
        if (!render_pixel(r, thread, x, piece / runs)) return false;
        r->pixels_done++;
    }
    return true;
}

static bool allocate(render *r, unsigned threads)
{
    size_t pixels = (size_t)r->options->width * r->options->height;
    size_t points = ((size_t)r->options->samples / r->batches + 1) * r->dimensions;
    *r->image = (al_image){r->options->width, r->options->height, 3, malloc(sizeof(float) * 3 * pixels)};
    *r->standard_error = (al_image){r->options->width, r->options->height, 1, malloc(sizeof(float) * pixels)};
    r->workers = calloc(threads, sizeof *r->workers);
    if (!r->image->pixels || !r->standard_error->pixels || !r->workers) return false;
    for (unsigned i = 0; i < threads; i++) {
        r->workers[i].scratch = r->mode->scratch_new();
        r->workers[i].points = malloc(sizeof(double) * points);
        if (!r->workers[i].scratch || !r->workers[i].points) return false;
    }
    return true;
}

static void free_workers(render *r, unsigned threads)
{
    for (unsigned i = 0; r->workers && i < threads; i++) {
        r->mode->scratch_free(r->workers[i].scratch);
        free(r->workers[i].points);
    }
    free(r->workers);
}

static uint32_t batch_count(uint32_t samples)
{
    uint32_t wanted = samples / BATCH_SAMPLES;
    if (wanted < BATCH_MINIMUM) wanted = BATCH_MINIMUM;
    if (wanted > BATCH_LIMIT) wanted = BATCH_LIMIT;
    return samples < wanted ? samples : wanted;
}

al_status al_render(const al_mode *mode, const void *state, const al_render_options *options, al_image *image,
                    al_image *standard_error, al_error *error)
{
    render r = {
        .mode = mode, .state = state, .options = options, .image = image, .standard_error = standard_error};
    unsigned threads = al_parallel_threads(options->threads),
             pieces = options->height * runs_per_row(options);
    r.batches = batch_count(options->samples);
    r.dimensions = 2 + mode->dimensions(state);
    *image = *standard_error = (al_image){0};
    al_status status = aim(&r, error);
    if (status) return status;
    if (!allocate(&r, threads) || (!al_parallel(threads, pieces, render_run, &r) && r.out_of_memory))
        status = al_fail(error, AL_IO, "out of memory for a picture of %u x %u pixels", options->width,
                         options->height);
    else if (r.stopped)
        status = al_fail(error, AL_CANCELLED, "cancelled: nothing was written");
    free_workers(&r, threads);
    if (status) {
        al_image_free(image);
        al_image_free(standard_error);
    }
    return status;
}
