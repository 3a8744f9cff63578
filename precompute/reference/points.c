#define _POSIX_C_SOURCE 200809L
#include "points.h"

#include <errno.h>
#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "parallel.h"
#include "sampling.h"

enum { COLUMNS = 6 };

/* --- reading --- */

/* The first six numbers of a line; false with the column (1 to 6) that is none. */
static bool read_numbers(const char *text, double numbers[COLUMNS], int *column)
{
    for (*column = 1; *column <= COLUMNS; ++*column) {
        char *end;
        numbers[*column - 1] = strtod(text, &end);
        if (end == text || !isfinite(numbers[*column - 1])) return false;
        end += strspn(end, " \t");
        if (*column == COLUMNS) return !*end || *end == ',';
        if (*end != ',') {
            ++*column;
            return false;
        }
        text = end + 1;
    }
    return true;
}

static bool is_heading(const char *text)
{
    return !strncmp(text, "x,y,z", 5);
}

static al_status take_line(const char *path, size_t line, const char *text, al_points *points, uint32_t *room,
                           al_error *error)
{
    static const char *const names[] = {"x", "y", "z", "nx", "ny", "nz"};
    double n[COLUMNS], length = 0;
    int column;
    if (!read_numbers(text, n, &column))
        return al_fail(error, AL_BAD_INPUT,
                       "%s:%zu: column %d (%s) is not a number; x,y,z,nx,ny,nz with commas between is right",
                       path, line, column, names[column - 1]);
    for (int k = 3; k < 6; k++) length += n[k] * n[k];
    length = sqrt(length);
    bool is_probe = length == 0;
    if (!is_probe && !(fabs(length - 1) < 1e-3))
        return al_fail(error, AL_BAD_INPUT,
                       "%s:%zu: the normal has length %g; 1 is right, or 0,0,0 for a probe", path, line,
                       length);
    if (points->count && is_probe != points->are_probes)
        return al_fail(error, AL_BAD_INPUT,
                       "%s:%zu: is a %s, the lines before it are %s; a file of either kind is right", path,
                       line, is_probe ? "probe" : "surface point", is_probe ? "surface points" : "probes");
    if (points->count == *room) {
        uint32_t wanted = *room ? 2 * *room : 64;
        al_receiver *grown = wanted > *room ? realloc(points->receivers, sizeof *grown * wanted) : NULL;
        if (!grown) return al_fail(error, AL_IO, "%s: out of memory for its points", path);
        points->receivers = grown;
        *room = wanted;
    }
    al_receiver *made = &points->receivers[points->count++];
    points->are_probes = is_probe;
    for (int k = 0; k < 3; k++) {
        made->position[k] = n[k];
        made->normal[k] = is_probe ? 0 : n[k + 3] / length;
    }
    return AL_OK;
}

al_status al_points_read(const char *path, al_points *points, al_error *error)
{
    *points = (al_points){0};
    FILE *file = fopen(path, "r");
    if (!file) return al_fail_errno(error, path, "open");
    char *line = NULL;
    size_t size = 0, number = 0, content = 0;
    uint32_t room = 0;
    al_status status = AL_OK;
    errno = 0;
    for (ssize_t length; !status && (length = getline(&line, &size, file)) >= 0;) {
        number++;
        while (length > 0 && strchr(" \t\r\n", line[length - 1])) line[--length] = 0;
        const char *text = line + strspn(line, " \t");
        if (!*text || *text == '#') continue;
        if (content++ == 0 && is_heading(text)) continue;
        status = take_line(path, number, text, points, &room, error);
    }
    if (!status && ferror(file)) status = al_fail_errno(error, path, "read");
    if (!status && !points->count)
        status = al_fail(error, AL_BAD_INPUT, "%s: holds no points; x,y,z,nx,ny,nz lines are right", path);
    free(line);
    fclose(file);
    if (status) al_points_free(points);
    return status;
}

void al_points_free(al_points *points)
{
    free(points->receivers);
    *points = (al_points){0};
}

uint32_t al_points_width(const al_points *points)
{
    return points->are_probes ? AL_PROBE_COUNT : 1;
}

/* --- estimating: as in render.c, stratified within batches, independent between them --- */

enum { BATCH_LIMIT = 64, BATCH_SAMPLES = 8 };

typedef struct worker {
    void *scratch;
    double *numbers; /* of one batch */
} worker;

typedef struct estimation {
    const al_mode *mode;
    const void *state;
    const al_points *points;
    const al_points_options *options;
    double (*values)[3], (*errors)[3];
    worker *workers;
    uint32_t batches, dimensions, width;
    atomic_ullong batches_done;
    atomic_bool out_of_memory, stopped;
} estimation;

static bool is_stopped(estimation *e, unsigned thread)
{
    const al_points_options *options = e->options;
    if (thread == 0 && options->on_progress &&
        options->on_progress(options->user, (double)e->batches_done, (double)e->points->count * e->batches))
        e->stopped = true;
    return e->stopped;
}

static bool estimate_batch(const estimation *e, worker *w, uint32_t point, uint32_t batch,
                           double mean[AL_PROBE_COUNT][3])
{
    uint32_t count = e->options->samples / e->batches + (batch < e->options->samples % e->batches);
    al_random random = al_random_for(point, batch);
    double received[AL_PROBE_COUNT][3];
    al_sample_hypercube(&random, count, e->dimensions, w->numbers);
    memset(mean, 0, sizeof(double) * 3 * AL_PROBE_COUNT);
    for (uint32_t i = 0; i < count; i++) {
        if (!e->mode->receive(e->state, w->scratch, &e->points->receivers[point],
                              w->numbers + (size_t)i * e->dimensions, received))
            return false;
        for (uint32_t k = 0; k < e->width; k++)
            for (int c = 0; c < 3; c++) mean[k][c] += received[k][c] / count;
    }
    return true;
}

static bool estimate_point(void *user, unsigned point, unsigned thread)
{
    estimation *e = user;
    double means[BATCH_LIMIT][AL_PROBE_COUNT][3];
    for (uint32_t b = 0; b < e->batches; b++) {
        if (is_stopped(e, thread)) return false;
        if (!estimate_batch(e, &e->workers[thread], point, b, means[b])) {
            e->out_of_memory = true;
            return false;
        }
        e->batches_done++;
    }
    for (uint32_t k = 0; k < e->width; k++)
        for (int c = 0; c < 3; c++) {
            double mean = 0, square = 0;
            for (uint32_t b = 0; b < e->batches; b++) mean += means[b][k][c] / e->batches;
            for (uint32_t b = 0; b < e->batches; b++)
                square += (means[b][k][c] - mean) * (means[b][k][c] - mean);
            e->values[(size_t)point * e->width + k][c] = mean;
            e->errors[(size_t)point * e->width + k][c] =
                sqrt(square / ((double)e->batches * (e->batches - 1)));
        }
    return true;
}

static uint32_t batch_count(uint32_t samples)
{
    uint32_t wanted = samples / BATCH_SAMPLES;
    if (wanted < BATCH_SAMPLES) wanted = BATCH_SAMPLES;
    if (wanted > BATCH_LIMIT) wanted = BATCH_LIMIT;
    return samples < wanted ? samples : wanted;
}

static bool allocate(estimation *e, unsigned threads)
{
    size_t numbers = ((size_t)e->options->samples / e->batches + 1) * e->dimensions;
    e->workers = calloc(threads, sizeof *e->workers);
    for (unsigned i = 0; e->workers && i < threads; i++) {
        e->workers[i].scratch = e->mode->scratch_new();
        e->workers[i].numbers = malloc(sizeof(double) * numbers);
        if (!e->workers[i].scratch || !e->workers[i].numbers) return false;
    }
    return e->workers;
}

static void free_workers(estimation *e, unsigned threads)
{
    for (unsigned i = 0; e->workers && i < threads; i++) {
        e->mode->scratch_free(e->workers[i].scratch);
        free(e->workers[i].numbers);
    }
    free(e->workers);
}

al_status al_points_estimate(const al_mode *mode, const void *state, const al_points *points,
                             const al_points_options *options, double (*values)[3], double (*errors)[3],
                             al_error *error)
{
    estimation e = {.mode = mode,
                    .state = state,
                    .points = points,
                    .options = options,
                    .values = values,
                    .errors = errors,
                    .batches = batch_count(options->samples),
                    .dimensions = mode->dimensions(state),
                    .width = al_points_width(points)};
    unsigned threads = al_parallel_threads(options->threads);
    al_status status = AL_OK;
    if (!allocate(&e, threads) ||
        (!al_parallel(threads, points->count, estimate_point, &e) && e.out_of_memory))
        status = al_fail(error, AL_IO, "out of memory for %u points", points->count);
    else if (e.stopped)
        status = al_fail(error, AL_CANCELLED, "cancelled: nothing was written");
    free_workers(&e, threads);
    return status;
}

/* --- writing --- */

static void print_row(FILE *file, const al_points *points, size_t row, double (*values)[3],
                      double (*errors)[3])
{
    uint32_t width = al_points_width(points);
    const al_receiver *r = &points->receivers[row / width];
    fprintf(file, "%.9g,%.9g,%.9g,", r->position[0], r->position[1], r->position[2]);
    if (points->are_probes)
        fprintf(file, "%zu", row % width);
    else
        fprintf(file, "%.9g,%.9g,%.9g", r->normal[0], r->normal[1], r->normal[2]);
    for (int c = 0; c < 3; c++) fprintf(file, ",%.7g", values[row][c]);
    for (int c = 0; c < 3; c++) fprintf(file, ",%.7g", errors[row][c]);
    fputc('\n', file);
}

al_status al_points_write(const char *path, const al_points *points, double (*values)[3], double (*errors)[3],
                          al_error *error)
{
    char *text = NULL;
    size_t size = 0, rows = (size_t)points->count * al_points_width(points);
    FILE *file = open_memstream(&text, &size);
    if (!file) return al_fail(error, AL_IO, "%s: out of memory", path);
    fputs(points->are_probes ? "x,y,z,index,sh_r,sh_g,sh_b,se_r,se_g,se_b\n"
                             : "x,y,z,nx,ny,nz,r,g,b,se_r,se_g,se_b\n",
          file);
    for (size_t row = 0; row < rows; row++) print_row(file, points, row, values, errors);
    al_status status = fclose(file) ? al_fail(error, AL_IO, "%s: out of memory", path)
                                    : al_write_file(path, text, size, error);
    free(text);
    return status;
}
