/* Gathers light at the points of a reference table and says how far off it is: the source of the accuracy
 * tables in docs/accuracy.md, and of the room tests. The last line is one of numbers:
 *   relative_rmse mean_ratio noise seconds opening_seconds
 * relative_rmse = sqrt((sum (A - B)^2 - sum of the reference's squared errors) / sum B^2) over points and
 * channels, not below 0, A the mean of the repetitions; noise: that mean's own, in the same units. Seconds
 * are processor time: of gathering once at all points, each point's least of its repetitions, and of all
 * threads for what all points share. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "airlight/impulse_tables.h"
#include "airlight/program.h"
#include "gather.h"
#include "parallel.h"

enum { ROW_LIMIT = 4096, REPEAT_LIMIT = 64 };

typedef struct row {
    double position[3], normal[3], value[3], error[3];
    int index; /* of the SH coefficient; -1: irradiance */
} row;

typedef struct table {
    row rows[ROW_LIMIT];
    uint32_t count;
} table;

typedef struct arguments {
    const char *scene, *points, *layer, *walls, *tables;
    int samples, bounces, repeats, threads, fog_points, fog_samples, seed;
    bool without_fog, back_scatter, list;
    double shift_m;
} arguments;

/* Rows of x,y,z, then nx,ny,nz or a coefficient's index, then three values and three errors. */
static bool read_table(const char *path, table *out)
{
    char line[1024];
    FILE *file = fopen(path, "r");
    if (!file) return false;
    out->count = 0;
    while (fgets(line, sizeof line, file) && out->count < ROW_LIMIT) {
        row *r = &out->rows[out->count];
        double *p = r->position, *n = r->normal, *v = r->value, *e = r->error;
        r->index = -1;
        if (sscanf(line, "%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf", p, p + 1, p + 2, n, n + 1, n + 2,
                   v, v + 1, v + 2, e, e + 1, e + 2) == 12)
            out->count++;
        else if (sscanf(line, "%lf,%lf,%lf,%d,%lf,%lf,%lf,%lf,%lf,%lf", p, p + 1, p + 2, &r->index, v, v + 1,
                        v + 2, e, e + 1, e + 2) == 10)
            out->count++;
    }
    fclose(file);
    return out->count > 0;
}

typedef struct work {
    const al_gather *gather;
    const arguments *given;
    const table *table;
    al_gather_scratch **scratches;
    double (*values)[REPEAT_LIMIT][3]; /* [row] */
    double *least_s;                   /* [row] */
} work;

static double seconds_of(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double value_of(const al_gathered *g, const row *r, const char *layer, int c)
{
    double surface = g->surface[c], attenuated = g->attenuated[c], scattered = g->scattered[c];
    if (r->index >= 0) {
        surface = g->sh[AL_GATHER_SURFACE][c][r->index];
        attenuated = g->sh[AL_GATHER_ATTENUATED][c][r->index];
        scattered = g->sh[AL_GATHER_SCATTERED][c][r->index];
    }
    if (!strcmp(layer, "surface")) return surface;
    if (!strcmp(layer, "attenuated")) return attenuated;
    if (!strcmp(layer, "scattered")) return scattered;
    return attenuated + scattered;
}

/* A texel of 0.02 m stands for the points when back-scatter asks. */
static bool gather_row(void *user, unsigned piece, unsigned thread)
{
    work *w = user;
    const row *r = &w->table->rows[piece];
    w->least_s[piece] = INFINITY;
    for (int i = 0; i < w->given->repeats; i++) {
        al_gathered gathered;
        double begin_s = seconds_of(CLOCK_THREAD_CPUTIME_ID);
        uint64_t seed = ((uint64_t)w->given->seed * ROW_LIMIT + piece) * REPEAT_LIMIT + (uint64_t)i;
        if (!al_gather_point(w->gather, w->scratches[thread], r->position, r->index >= 0 ? NULL : r->normal,
                             0.02, seed, &gathered))
            return false;
        w->least_s[piece] = fmin(w->least_s[piece], seconds_of(CLOCK_THREAD_CPUTIME_ID) - begin_s);
        for (int c = 0; c < 3; c++) w->values[piece][i][c] = value_of(&gathered, r, w->given->layer, c);
    }
    return true;
}

static void say_result(const work *w, double opening)
{
    double square = 0, norm = 0, sum = 0, reference = 0, noise = 0, seconds = 0;
    int repeats = w->given->repeats;
    for (uint32_t i = 0; i < w->table->count; i++) {
        const row *r = &w->table->rows[i];
        double means[3] = {0};
        seconds += w->least_s[i];
        for (int c = 0; c < 3; c++) {
            double spread = 0;
            for (int k = 0; k < repeats; k++) means[c] += w->values[i][k][c] / repeats;
            for (int k = 0; k < repeats; k++) spread += pow(w->values[i][k][c] - means[c], 2);
            if (repeats > 1) noise += spread / (repeats * (repeats - 1.0));
            square += pow(means[c] - r->value[c], 2) - pow(r->error[c], 2);
            norm += pow(r->value[c], 2);
            sum += means[c];
            reference += r->value[c];
        }
        if (w->given->list)
            printf("%9.5f %9.5f %9.5f  %9.5f %9.5f %9.5f  %8.4f +- %.4f\n", means[0], means[1], means[2],
                   r->value[0], r->value[1], r->value[2], means[0] / r->value[0],
                   fabs(r->error[0] / r->value[0]));
    }
    printf("%.6f %.6f %.6f %.4f %.4f\n", sqrt(fmax(0, square) / norm), sum / reference, sqrt(noise / norm),
           seconds, opening);
}

static al_status gather_all(const al_gather *gather, const arguments *given, const table *points,
                            double opening, al_error *error)
{
    unsigned threads = al_parallel_threads((unsigned)given->threads);
    work w = {.gather = gather, .given = given, .table = points};
    w.scratches = calloc(threads, sizeof *w.scratches);
    w.values = calloc(points->count, sizeof *w.values);
    w.least_s = calloc(points->count, sizeof *w.least_s);
    bool done = w.scratches && w.values && w.least_s;
    for (unsigned i = 0; done && i < threads; i++)
        done = (w.scratches[i] = al_gather_scratch_new(gather)) != NULL;
    done = done && al_parallel(threads, points->count, gather_row, &w);
    if (done) say_result(&w, opening);
    for (unsigned i = 0; w.scratches && i < threads; i++) al_gather_scratch_free(w.scratches[i]);
    free(w.scratches);
    free(w.values);
    free(w.least_s);
    return done ? AL_OK : al_fail(error, AL_IO, "out of memory");
}

static al_status find_walls(const char *name, al_walls *walls, al_error *error)
{
    static const char *const names[] = {"published", "bounded", "traced"};
    for (int i = 0; i < 3; i++)
        if (!strcmp(name, names[i])) {
            *walls = (al_walls)i;
            return AL_OK;
        }
    return al_fail(error, AL_USAGE, "'%s' is no setting of walls: published, bounded or traced", name);
}

static al_status run(const arguments *given, const table *points, al_error *error)
{
    al_import *import = NULL;
    al_file *file = NULL;
    al_impulse_tables *tables = NULL;
    al_gather *gather = NULL;
    al_gather_options options = {.samples = (uint32_t)given->samples,
                                 .bounces = (uint32_t)given->bounces,
                                 .fog = !given->without_fog,
                                 .back_scatter = given->back_scatter,
                                 .back_scatter_shift_m = given->shift_m,
                                 .sh_order = points->rows[0].index >= 0 ? 3 : 0,
                                 .threads = (unsigned)given->threads,
                                 .seed = (uint32_t)given->seed,
                                 .fog_points = (uint32_t)given->fog_points,
                                 .fog_samples = (uint32_t)given->fog_samples};
    al_status status = find_walls(given->walls, &options.walls, error);
    if (!status) status = al_import_scene(given->scene, AL_QUALITY_FINAL, &import, error);
    if (!status && given->tables) status = al_file_open(given->tables, NULL, &file, error);
    if (!status && given->tables) status = al_impulse_tables_read(file, &tables, error);
    double begin = seconds_of(CLOCK_PROCESS_CPUTIME_ID);
    if (!status) status = al_gather_open(import, tables, &options, &gather, error);
    double opening = seconds_of(CLOCK_PROCESS_CPUTIME_ID) - begin;
    if (!status) status = gather_all(gather, given, points, opening, error);
    al_gather_close(gather);
    al_impulse_tables_free(tables);
    al_file_close(file);
    al_import_free(import);
    return status;
}

int main(int argc, char **argv)
{
    static table points;
    arguments given = {
        .layer = "total", .walls = "bounded", .samples = 1024, .bounces = 16, .repeats = 4, .threads = 1};
    const al_option options[] = {
        {"--layer", "NAME", AL_OPTION_STRING, &given.layer, "surface, attenuated, scattered or total", 0, 0},
        {"--walls", "NAME", AL_OPTION_STRING, &given.walls, "published, bounded or traced", 0, 0},
        {"--tables", "FILE.air", AL_OPTION_STRING, &given.tables, "impulse tables, for published walls", 0,
         0},
        {"--samples", "N", AL_OPTION_INT, &given.samples, "paths a point and repetition", 1, 1e7},
        {"--bounces", "N", AL_OPTION_INT, &given.bounces, "diffuse reflections", 0, 1000},
        {"--repeats", "N", AL_OPTION_INT, &given.repeats, "repetitions with other seeds", 1, REPEAT_LIMIT},
        {"--threads", "N", AL_OPTION_INT, &given.threads, "threads; 0: one per core", 0, 256},
        {"--fog-points", "N", AL_OPTION_INT, &given.fog_points, "fog points along the longest edge", 0, 256},
        {"--fog-samples", "N", AL_OPTION_INT, &given.fog_samples, "paths a fog point", 0, 1e6},
        {"--seed", "N", AL_OPTION_INT, &given.seed, "of all paths, those of the fog points too", 0, 1e6},
        {"--no-fog", NULL, AL_OPTION_FLAG, &given.without_fog, "without the scene's fog", 0, 0},
        {"--back-scatter", NULL, AL_OPTION_FLAG, &given.back_scatter, "gather over the whole sphere", 0, 0},
        {"--shift", "M", AL_OPTION_REAL, &given.shift_m, "of the receiver, for back-scatter", 0, 1e6},
        {"--list", NULL, AL_OPTION_FLAG, &given.list, "print every point, ours and the reference", 0, 0},
    };
    al_program program = {.name = "gather_points",
                          .usage = "SCENE.json POINTS.csv [options]",
                          .summary = "Gathers light at the points of a reference table and compares.",
                          .options = options,
                          .option_count = sizeof options / sizeof *options};
    const char *positionals[2];
    size_t count;
    al_error error = {0};
    int code = al_program_parse(&program, argc, argv, positionals, 2, 2, &count);
    if (code >= 0) return code;
    given.scene = positionals[0];
    given.points = positionals[1];
    if (!read_table(given.points, &points)) {
        al_fail(&error, AL_BAD_INPUT, "%s: no rows of 10 or 12 numbers", given.points);
        return al_program_fail(&program, &error);
    }
    return run(&given, &points, &error) ? al_program_fail(&program, &error) : 0;
}
