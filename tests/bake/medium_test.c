/* Media of fogs, baked, against the density they were baked from: grids at random places (turned and moved,
 * with and without bounds), layers by their mean, a grid that is too large refused. */
#define _POSIX_C_SOURCE 200809L
#include "bake_medium.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "../test.h"
#include "airlight/medium.h"

static char folder[256];
static const al_program program = {.name = "medium_test", .quiet = true};

/* Bakes the only fog of a scene file with this density; the import is the caller's. */
static al_status bake(const char *density, size_t memory_limit, al_import **import, al_error *error)
{
    char path[512], file[160];
    al_steps steps = {0};
    uint64_t key;
    snprintf(path, sizeof path, "%s/scene.json", folder);
    FILE *scene = fopen(path, "w");
    if (!scene) return al_fail(error, AL_IO, "%s: cannot be written", path);
    fprintf(scene,
            "{\"media\": [{\"name\": \"fog\", \"sigma_s_per_m\": 1, \"density\": %s}], \"fogs\": [\"fog\"]}",
            density);
    fclose(scene);
    al_status status = al_import_scene(path, AL_QUALITY_PREVIEW, import, error);
    unlink(path);
    if (status) return status;
    al_bake_options options = {.program = &program, .folder = folder, .memory_limit = memory_limit};
    status = al_bake_medium_key(*import, 0, &key, error);
    if (!status) status = al_bake_medium(*import, 0, key, &options, &steps, error);
    al_bake_medium_file(*import, 0, file, sizeof file);
    CHECK(strcmp(file, "fog.medium.air") == 0);
    return status;
}

static al_file *open_asset(al_medium_info *info, al_medium_field **field)
{
    char path[512];
    al_file *file = NULL;
    al_error error = {0};
    snprintf(path, sizeof path, "%s/fog.medium.air", folder);
    al_status status = al_file_open(path, NULL, &file, &error);
    if (!status) status = al_medium_read(file, info, &error);
    if (!status) status = al_medium_field_open(file, info, field, &error);
    CHECK(!status);
    if (status) fprintf(stderr, "%s\n", error.message), exit(1);
    unlink(path);
    return file;
}

static double uniform(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) / 9007199254740992.0;
}

/* Stored halves are within 2^-11 of each voxel; the float matrix moves places by 2^-23 of the grid, which
 * costs no more where a voxel differs from the next by less than a tenth of the maximum: 1e-6 of it is
 * allowed for. */
static void test_grid(const char *density)
{
    al_import *import = NULL;
    al_error error = {0};
    al_medium_info info;
    al_medium_field *field;
    double worst = 0;
    uint64_t state = 3;
    al_status status = bake(density, 64u << 20, &import, &error);
    if (status) fprintf(stderr, "%s\n", error.message);
    CHECK(!status);
    if (status) return;
    al_file *file = open_asset(&info, &field);
    const al_density *wanted = import->densities[0];
    double maximum = al_density_max(wanted);
    for (int i = 0; i < 20000; i++) {
        double place[3];
        for (int k = 0; k < 3; k++) {
            double edge = (double)info.bounds_max_m[k] - info.bounds_min_m[k];
            place[k] = info.bounds_min_m[k] + edge * (1.2 * uniform(&state) - 0.1);
        }
        double is = al_density_at(wanted, place), seen = al_medium_evaluate(field, place, 0);
        if ((is == 0) != (seen == 0) && fmax(is, seen) > 1e-3 * maximum) {
            for (int k = 0; k < 3; k++)
                place[k] *= 1 + 1e-5; /* on the very face: a little farther they agree */
            is = al_density_at(wanted, place), seen = al_medium_evaluate(field, place, 0);
        }
        worst = fmax(worst, (fabs(seen - is) - is / 2048) / maximum);
    }
    printf("%.60s: beyond 2^-11 of the value %.1e of the maximum\n", density, worst);
    CHECK(worst < 1e-5);
    al_medium_field_close(field);
    al_file_close(file);
    al_import_free(import);
}

/* Optical depth through layers along their axis and across: voxels cut the layers' edges, the sum is kept. */
static void test_layers(void)
{
    al_import *import = NULL;
    al_error error = {0};
    al_medium_info info;
    al_medium_field *field;
    CHECK(bake("{\"type\": \"layers\", \"axis\": [0, 1, 0], \"period_m\": 0.5, \"thickness_m\": 0.2, "
               "\"high\": 3,"
               "\"low\": 1, \"bounds_min_m\": [-1, 0, -1], \"bounds_max_m\": [1, 2, 1]}",
               64u << 20, &import, &error) == AL_OK);
    if (!import) return;
    al_file *file = open_asset(&info, &field);
    double sum = 0;
    enum { STEPS = 4000 };
    for (int i = 0; i < STEPS; i++)
        sum += al_medium_evaluate(field, (double[3]){0.3, 2 * (i + 0.5) / STEPS, -0.2}, 0) * 2 / STEPS;
    CHECK_NEAR(sum, 4 * (0.2 * 3 + 0.3), 0.01); /* a voxel is 2 / 80 m, of which half points are 1/160 m */
    CHECK_NEAR(al_medium_evaluate(field, (double[3]){0.3, 0.6, 0}, 0), 3, 3.0 / 2048);
    CHECK_NEAR(al_medium_evaluate(field, (double[3]){0.3, 0.85, 0}, 0), 1, 1.0 / 2048);
    CHECK(al_medium_evaluate(field, (double[3]){0.3, 2.01, 0}, 0) == 0);
    al_medium_field_close(field);
    al_file_close(file);
    al_import_free(import);
}

#define CHECK_MESSAGE(error, words) \
    do { \
        if (!strstr((error).message, words)) fprintf(stderr, "%s\n", (error).message); \
        CHECK(strstr((error).message, words)); \
    } while (0)

static void test_refused(void)
{
    al_import *import = NULL;
    al_error error = {0};
    CHECK(bake("{\"type\": \"layers\", \"period_m\": 0.5, \"thickness_m\": 0.2}", 1u << 20, &import,
               &error) == AL_BAD_INPUT);
    CHECK_MESSAGE(error, "give its density bounds");
    al_import_free(import);
    CHECK(bake("{\"type\": \"layers\", \"period_m\": 0.1, \"thickness_m\": 0.05, \"bounds_min_m\": [0, 0, 0],"
               "\"bounds_max_m\": [2, 2, 2]}",
               16u << 20, &import, &error) == AL_BAD_INPUT);
    CHECK_MESSAGE(error, "256 x 256 x 256 voxels take 64 MiB as floats, --memory-limit allows 16 MiB");
    al_import_free(import);
}

int main(void)
{
    const char *temporary = getenv("TMPDIR"), *shared = getenv("AIRLIGHT_SHARED");
    char grid[512], density[1024];
    snprintf(folder, sizeof folder, "%s/airlight-medium-XXXXXX",
             temporary && *temporary ? temporary : "/tmp");
    if (!mkdtemp(folder)) return test_skip("no temporary folder");
    test_layers();
    test_refused();
    snprintf(grid, sizeof grid, "%s/reference/fog.vdb", shared ? shared : AIRLIGHT_SHARED_DEFAULT);
    if (access(grid, R_OK) == 0) {
        snprintf(density, sizeof density, "{\"type\": \"grid\", \"file\": \"%s\"}", grid);
        test_grid(density);
        snprintf(density, sizeof density,
                 "{\"type\": \"grid\", \"scale\": 2.5, \"file\": \"%s\", \"transform\": {\"rotate_degrees\": "
                 "[10, 20, 30], \"translate_m\": [1, 2, 3], \"scale\": [1, 2, 0.5]}}",
                 grid);
        test_grid(density);
        snprintf(density, sizeof density,
                 "{\"type\": \"grid\", \"file\": \"%s\", \"transform\": {\"rotate_degrees\": [10, 20, 30]}, "
                 "\"bounds_min_m\": [-1.5, -1, -1], \"bounds_max_m\": [1.5, 1, 0.5]}",
                 grid);
        test_grid(density);
    }
    CHECK(rmdir(folder) == 0);
    int code = test_end();
    return code || access(grid, R_OK) == 0 ? code
                                           : test_skip("grids: the shared reference folder is not here");
}
