/* Density sequences, baked: frames with boxes of their own on one lattice come back at their places and times, and what is
 * no sequence is refused. */
#define _POSIX_C_SOURCE 200809L
#include "grid_sequence.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "../import/vdb_writer.h"
#include "../test.h"

static char folder[256];

/* Frame f: its active box, and voxels of f + 1 + (x + 2 y + 4 z) / 8 on the lattice of 1/4 m. */
static const int first[3][3] = {{0, 0, 0}, {-2, 1, 0}, {3, -1, 2}}, sizes[3][3] = {{4, 3, 2}, {3, 2, 5}, {9, 2, 2}};

static float value_of(int frame, int x, int y, int z)
{
    return (float)(frame + 1) + (float)(x + 2 * y + 4 * z + 8) / 8;
}

static void write_frames(double edge_of_last)
{
    for (int f = 0; f < 3; f++) {
        float values[64];
        char path[512];
        double edge = f == 2 ? edge_of_last : 0.25;
        int at = 0;
        for (int z = 0; z < sizes[f][2]; z++)
            for (int y = 0; y < sizes[f][1]; y++)
                for (int x = 0; x < sizes[f][0]; x++)
                    values[at++] = value_of(f, first[f][0] + x, first[f][1] + y, first[f][2] + z);
        vdb_grid grid = {.name = "density", .values = values,
                         .index_to_world = {edge, 0, 0, 0, 0, edge, 0, 0, 0, 0, edge, 0, 0, 0, 0, 1}};
        memcpy(grid.first, first[f], sizeof grid.first);
        memcpy(grid.size, sizes[f], sizeof grid.size);
        snprintf(path, sizeof path, "%s/smoke_%03d.vdb", folder, f + 8);
        vdb_write(path, &grid, 1);
    }
}

static al_status import_scene(const char *density, al_import **import, al_error *error)
{
    char path[512];
    snprintf(path, sizeof path, "%s/scene.json", folder);
    FILE *scene = fopen(path, "w");
    if (!scene) return al_fail(error, AL_IO, "%s: cannot be written", path);
    fprintf(scene, "{\"media\": [{\"name\": \"fog\", \"sigma_s_per_m\": 1, \"density\": %s}], \"fogs\": [\"fog\"]}", density);
    fclose(scene);
    return al_import_scene(path, AL_QUALITY_PREVIEW, import, error);
}

#define DENSITY \
    "{\"type\": \"grid\", \"file\": \"smoke_%03d.vdb\", \"first_frame\": 8, \"frame_count\": 3, \"frames_per_second\": 8, " \
    "\"scale\": 2, \"transform\": {\"translate_m\": [0, 0, 1]}}"

static al_status write_asset(const al_import *import, const char *path, al_error *error)
{
    const al_fog *fog = &import->scene.fogs[0];
    al_grid_sequence *sequence;
    al_medium_data data = {.info = {.frame_count = 1, .sigma_s_per_m = {1, 1, 1}}};
    al_density_voxels voxels;
    al_density_grid(import->densities[0], &voxels);
    memcpy(data.info.bounds_min_m, fog->bounds_min_m, sizeof fog->bounds_min_m);
    memcpy(data.info.bounds_max_m, fog->bounds_max_m, sizeof fog->bounds_max_m);
    for (int i = 0; i < 16; i++) data.info.grid_to_world[i] = (float)voxels.index_to_world[i];
    al_status status = al_grid_sequence_open(import, &import->description->media[0], &data, &sequence, error);
    if (!status) status = al_medium_write(path, &data, NULL, error);
    al_grid_sequence_close(sequence);
    return status;
}

/* At voxel centres only the halfs' rounding counts: 2^-11 of the value. */
static void test_frames(void)
{
    char path[512];
    al_import *import = NULL;
    al_file *file = NULL;
    al_medium_info info;
    al_medium_field *field = NULL;
    al_error error = {0};
    write_frames(0.25);
    snprintf(path, sizeof path, "%s/fog.medium.air", folder);
    al_status status = import_scene(DENSITY, &import, &error);
    if (!status) status = write_asset(import, path, &error);
    if (!status) status = al_file_open(path, NULL, &file, &error);
    if (!status) status = al_medium_read(file, &info, &error);
    if (!status) status = al_medium_field_open(file, &info, &field, &error);
    CHECK(!status);
    if (status) fprintf(stderr, "%s\n", error.message), exit(1);
    CHECK(info.frame_count == 3 && info.size[0] == 14 && info.size[1] == 4 && info.size[2] == 5);
    CHECK_NEAR(info.bounds_min_m[0], -2.5 * 0.25, 1e-6);
    CHECK_NEAR(info.bounds_max_m[2], 1 + 4.5 * 0.25, 1e-6);
    for (int f = 0; f < 3; f++)
        for (int z = 0; z < 5; z++)
            for (int y = -1; y < 3; y++)
                for (int x = -2; x < 12; x++) {
                    double place[3] = {0.25 * x, 0.25 * y, 1 + 0.25 * z}, wanted = 2 * value_of(f, x, y, z);
                    const int point[3] = {x, y, z};
                    for (int k = 0; k < 3; k++)
                        if (point[k] < first[f][k] || point[k] >= first[f][k] + sizes[f][k]) wanted = 0;
                    CHECK_NEAR(al_medium_evaluate(field, place, f / 8.0), wanted, wanted / 2048 + 1e-5);
                }
    al_medium_field_close(field);
    al_file_close(file);
    CHECK(import->input_count == 4); /* the scene and three files */
    al_import_free(import);
    unlink(path);
}

static void refuse(const char *density, const char *words)
{
    char path[512];
    al_import *import = NULL;
    al_error error = {0};
    snprintf(path, sizeof path, "%s/refused.air", folder);
    al_status status = import_scene(density, &import, &error);
    if (!status) status = write_asset(import, path, &error);
    if (!strstr(error.message, words)) fprintf(stderr, "%s\n", error.message);
    CHECK(status && strstr(error.message, words) && !strchr(error.message, '\n'));
    CHECK(access(path, F_OK) != 0);
    al_import_free(import);
}

static void test_refused(void)
{
    write_frames(0.26);
    refuse(DENSITY, "smoke_010.vdb are not those of the first frame");
    write_frames(0.25);
    refuse("{\"type\": \"grid\", \"file\": \"smoke_%03d.vdb\", \"first_frame\": 8}", "frame_count");
    refuse("{\"type\": \"grid\", \"file\": \"smoke_008.vdb\", \"frame_count\": 3}", "frame_count goes with a file name that has %04d");
    refuse("{\"type\": \"grid\", \"file\": \"smoke_%03d.vdb\", \"first_frame\": 8, \"frame_count\": 4}", "smoke_011.vdb");
    refuse("{\"type\": \"grid\", \"file\": \"smoke_%d.vdb\", \"frame_count\": 0}", "frame_count: is 0");
    refuse("{\"type\": \"layers\", \"period_m\": 1, \"thickness_m\": 0.5, \"frame_count\": 2}", "\"frame_count\" does not go with");
}

int main(void)
{
    const char *temporary = getenv("TMPDIR");
    char path[512];
    snprintf(folder, sizeof folder, "%s/airlight-sequence-XXXXXX", temporary && *temporary ? temporary : "/tmp");
    if (!mkdtemp(folder)) return test_skip("no temporary folder");
    test_frames();
    test_refused();
    for (int f = 8; f < 11; f++) {
        snprintf(path, sizeof path, "%s/smoke_%03d.vdb", folder, f);
        unlink(path);
    }
    snprintf(path, sizeof path, "%s/scene.json", folder);
    unlink(path);
    CHECK(rmdir(folder) == 0);
    return test_end();
}
