/* What fog costs: processor time of gathering with each setting over that of surfaces alone, in one process.
 * Usage: airlight-bench-gather SCENE.json TABLES.air [POINTS]. Points are the middles of triangles, evenly
 * taken from all there are; with --list in place of the tables they are printed as airlight-reference
 * --points reads them. Rounds of the settings take turns, each point's least time counts. Not a test.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "gather.h"

enum { ROUNDS = 5, POINT_LIMIT = 4096 };

typedef struct point {
    double position[3], normal[3];
} point;

typedef struct setting {
    const char *name;
    bool fog;
    al_walls walls;
    bool back_scatter;
} setting;

static const setting settings[] = {{"surfaces", false, AL_WALLS_PUBLISHED, false},
                                   {"published", true, AL_WALLS_PUBLISHED, false},
                                   {"back-scatter", true, AL_WALLS_PUBLISHED, true},
                                   {"bounded", true, AL_WALLS_BOUNDED, false},
                                   {"traced", true, AL_WALLS_TRACED, false}};
enum { SETTINGS = sizeof settings / sizeof *settings };

static uint32_t triangle_count(const al_scene *scene)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < scene->instance_count; i++)
        count += scene->meshes[scene->instances[i].mesh].index_count / 3;
    return count;
}

static void place(const float world[16], const float *in, double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = (double)world[k] * in[0] + (double)world[4 + k] * in[1] + (double)world[8 + k] * in[2] +
                 world[12 + k];
}

/* The middle of triangle `index` of all. False where it has no area. */
static bool middle_of(const al_scene *scene, uint32_t index, point *out)
{
    for (uint32_t i = 0; i < scene->instance_count; i++) {
        const al_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        if (index >= mesh->index_count / 3) {
            index -= mesh->index_count / 3;
            continue;
        }
        double v[3][3], a[3], b[3], *n = out->normal;
        for (int k = 0; k < 3; k++)
            place(scene->instances[i].world,
                  mesh->positions + 3 * (size_t)mesh->indices[3 * index + (uint32_t)k], v[k]);
        for (int k = 0; k < 3; k++) {
            a[k] = v[1][k] - v[0][k];
            b[k] = v[2][k] - v[0][k];
            out->position[k] = (v[0][k] + v[1][k] + v[2][k]) / 3;
        }
        n[0] = a[1] * b[2] - a[2] * b[1], n[1] = a[2] * b[0] - a[0] * b[2], n[2] = a[0] * b[1] - a[1] * b[0];
        double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (int k = 0; k < 3; k++) n[k] /= length;
        return length > 0;
    }
    return false;
}

static uint32_t choose_points(const al_scene *scene, uint32_t wanted, point *points)
{
    uint32_t total = triangle_count(scene), count = 0;
    for (uint32_t i = 0; i < wanted; i++)
        count += middle_of(scene, (uint32_t)((uint64_t)i * total / wanted), &points[count]);
    return count;
}

static double processor_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Lowers the least seconds of each point; the sum keeps the work from being left out. */
static void time_points(const al_gather *gather, const point *points, uint32_t count, double *least_s,
                        double *sum)
{
    al_gather_scratch *scratch = al_gather_scratch_new(gather);
    for (uint32_t i = 0; scratch && i < count; i++) {
        al_gathered gathered;
        double begin_s = processor_seconds();
        if (al_gather_point(gather, scratch, points[i].position, points[i].normal, 0.05, i, &gathered))
            *sum += gathered.attenuated[1] + gathered.scattered[1];
        least_s[i] = fmin(least_s[i], processor_seconds() - begin_s);
    }
    al_gather_scratch_free(scratch);
}

static double total(const double *values, uint32_t count)
{
    double sum = 0;
    for (uint32_t i = 0; i < count; i++) sum += values[i];
    return sum;
}

static al_status compare(const al_import *import, const al_impulse_tables *tables,
                         const al_lightmap_settings *quality, const point *points, uint32_t count,
                         al_error *error)
{
    static double least_s[SETTINGS][POINT_LIMIT];
    al_gather *gathers[SETTINGS] = {0};
    double opening[SETTINGS], sums[SETTINGS] = {0};
    al_status status = AL_OK;
    for (int i = 0; i < SETTINGS && !status; i++) {
        al_gather_options options = {.samples = quality->samples,
                                     .bounces = quality->bounces,
                                     .fog = settings[i].fog,
                                     .walls = settings[i].walls,
                                     .back_scatter = settings[i].back_scatter,
                                     .threads = 1};
        double begin_s = processor_seconds();
        status = al_gather_open(import, tables, &options, &gathers[i], error);
        opening[i] = processor_seconds() - begin_s;
        for (uint32_t k = 0; k < count; k++) least_s[i][k] = INFINITY;
    }
    for (int round = 0; round < ROUNDS && !status; round++)
        for (int i = 0; i < SETTINGS; i++) time_points(gathers[i], points, count, least_s[i], &sums[i]);
    for (int i = 0; i < SETTINGS && !status; i++)
        printf("%4u paths, %u bounces, %-12s %8.1f us a path, %+7.1f %% over surfaces, opened in %.2f s, "
               "mean %.4g\n",
               quality->samples, quality->bounces, settings[i].name,
               1e6 * total(least_s[i], count) / count / quality->samples,
               100 * (total(least_s[i], count) / total(least_s[0], count) - 1), opening[i],
               sums[i] / ROUNDS / count);
    for (int i = 0; i < SETTINGS; i++) al_gather_close(gathers[i]);
    return status;
}

static void list(const point *points, uint32_t count)
{
    printf("x,y,z,nx,ny,nz\n");
    for (uint32_t i = 0; i < count; i++) {
        const double *p = points[i].position, *n = points[i].normal;
        printf("%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n", p[0], p[1], p[2], n[0], n[1], n[2]);
    }
}

int main(int argc, char **argv)
{
    static point points[POINT_LIMIT];
    al_import *import = NULL;
    al_file *file = NULL;
    al_impulse_tables *tables = NULL;
    al_error error = {0};
    if (argc < 3) {
        fprintf(stderr, "usage: airlight-bench-gather SCENE.json TABLES.air|--list [POINTS]\n");
        return AL_USAGE;
    }
    uint32_t wanted = argc > 3 ? (uint32_t)atoi(argv[3]) : 400;
    al_status status = al_import_scene(argv[1], AL_QUALITY_FINAL, &import, &error);
    if (!status && !strcmp(argv[2], "--list")) {
        list(points, choose_points(&import->scene, wanted, points));
        al_import_free(import);
        return AL_OK;
    }
    if (!status) status = al_file_open(argv[2], NULL, &file, &error);
    if (!status) status = al_impulse_tables_read(file, &tables, &error);
    for (int quality = AL_QUALITY_PREVIEW; quality <= AL_QUALITY_FINAL && !status; quality += 2) {
        al_lightmap_settings set = al_lightmap_settings_for((al_quality)quality);
        uint32_t count = choose_points(&import->scene, quality ? wanted / 8 : wanted, points);
        status = compare(import, tables, &set, points, count, &error);
    }
    if (status) fprintf(stderr, "airlight-bench-gather: %s\n", error.message);
    al_impulse_tables_free(tables);
    al_file_close(file);
    al_import_free(import);
    return (int)status;
}
