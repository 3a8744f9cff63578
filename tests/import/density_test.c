/* Densities: grids against an evaluation of our own, their boxes, transforms and refusals; layers; constants.
 */
#include <math.h>

#include "density.h"
#include "files.h"
#include "vdb_writer.h"

static al_status open_density(const char *density, al_scene_description **scene, al_density **out,
                              al_error *error)
{
    char json[2048];
    *out = NULL;
    snprintf(json, sizeof json, "{\"media\": [{\"name\": \"m\", \"sigma_s_per_m\": 1,\n \"density\": {%s}}]}",
             density);
    write_text("density_test.json", json);
    al_status status = al_scene_description_read("density_test.json", AL_QUALITY_PREVIEW, scene, error);
    return status ? status : al_density_open(*scene, &(*scene)->media[0], out, error);
}

/* Evaluates at a point; -1 when refused. */
static double density_at(const char *density, double x, double y, double z)
{
    al_scene_description *scene = NULL;
    al_density *made;
    al_error error;
    double value = -1;
    if (open_density(density, &scene, &made, &error))
        fprintf(stderr, "%s\n", error.message);
    else
        value = al_density_at(made, (double[3]){x, y, z});
    al_density_free(made);
    al_scene_description_free(scene);
    return value;
}

static void refuse(const char *density, const char *parts)
{
    al_scene_description *scene = NULL;
    al_density *made;
    al_error error = {0};
    al_status status = open_density(density, &scene, &made, &error);
    check_mentions(density, status, &error, AL_BAD_INPUT, parts);
    CHECK(!status || !made);
    al_density_free(made);
    al_scene_description_free(scene);
}

enum { NX = 5, NY = 4, NZ = 3 };
static float values[NX * NY * NZ];

static double clamp(double x, double low, double high)
{
    return x < low ? low : x > high ? high : x;
}

/* The definition, written as the sum over eight corners. Voxel (0,0,0) is at (-2, 7, 1) in the file's index.
 */
static double expected_at(const double index[3])
{
    const int size[3] = {NX, NY, NZ}, first[3] = {-2, 7, 1};
    double sum = 0, local[3];
    for (int i = 0; i < 3; i++) {
        local[i] = index[i] - first[i];
        if (local[i] < -0.5 || local[i] > size[i] - 0.5) return 0;
        local[i] = clamp(local[i], 0, size[i] - 1);
    }
    for (int corner = 0; corner < 8; corner++) {
        double weight = 1;
        int at[3];
        for (int i = 0; i < 3; i++) {
            int below = (int)floor(local[i]), side = corner >> i & 1;
            at[i] = below + side;
            weight *= side ? local[i] - below : 1 - (local[i] - below);
            if (at[i] > size[i] - 1) at[i] = size[i] - 1;
        }
        sum += weight * values[(at[2] * NY + at[1]) * NX + at[0]];
    }
    return sum;
}

/* index to world of the grid "slanted": turned, scaled unevenly, sheared and moved; column-major */
static const double slanted[16] = {0.1, 0.02, 0, 0, -0.03, 0.2, 0.01, 0, 0, 0.05, 0.15, 0, 3, -1, 2, 1};

static void write_grids(void)
{
    for (int i = 0; i < NX * NY * NZ; i++) values[i] = (float)((i * 37 + 11) % 64) / 8; /* exact as half */
    vdb_grid grids[2] = {{"straight", VDB_FLOAT, {-2, 7, 1}, {NX, NY, NZ}, values, 100, {0}},
                         {"slanted", VDB_FLOAT, {-2, 7, 1}, {NX, NY, NZ}, values, 0, {0}}};
    memcpy(grids[1].index_to_world, slanted, sizeof slanted);
    vdb_write("grids.vdb", grids, 2);
    grids[0].kind = VDB_HALF;
    vdb_write("half.vdb", grids, 1);
    vdb_grid same[3] = {{"density", VDB_FLOAT, {0, 0, 0}, {2, 2, 2}, NULL, 0, {0}},
                        {"density", VDB_FLOAT, {0, 0, 0}, {3, 3, 3}, NULL, 0, {0}},
                        {"other", VDB_VECTOR, {0, 0, 0}, {2, 2, 2}, NULL, 0, {0}}};
    vdb_write("same.vdb", same, 3);
    vdb_write("one.vdb", same + 1, 2);
    const float bad[3][2] = {{1, -0.5f}, {1, NAN}, {INFINITY, 1}}, zero[2] = {0, 0};
    const char *const names[3] = {"negative.vdb", "nan.vdb", "infinite.vdb"};
    for (int i = 0; i < 3; i++) {
        vdb_grid grid = {"density", VDB_FLOAT, {4, 5, 6}, {2, 1, 1}, bad[i], 0, {0}};
        vdb_write(names[i], &grid, 1);
    }
    vdb_grid odd[5] = {{"density", VDB_FLOAT, {0, 0, 0}, {2, 1, 1}, zero, 0, {0}},
                       {"shape", VDB_LEVEL_SET, {0, 0, 0}, {2, 2, 2}, NULL, 3, {0}},
                       {"frustum", VDB_FRUSTUM, {0, 0, 0}, {8, 8, 8}, NULL, 0, {0}},
                       {"nothing", VDB_FLOAT, {0, 0, 0}, {0, 0, 0}, NULL, 0, {0}},
                       {"huge", VDB_FLOAT, {0, 0, 0}, {1, 1, 1}, NULL, 0, {0}}};
    vdb_write("zero.vdb", odd, 1);
    vdb_write("level_set.vdb", odd + 1, 1);
    vdb_write("frustum.vdb", odd + 2, 1);
    vdb_write("nothing.vdb", odd + 3, 1);
    vdb_write("voxel.vdb", odd + 4, 1);
    vdb_write("two.vdb", (vdb_grid[2]){same[0], odd[4]}, 2);
    vdb_write("vector.vdb", same + 2, 1);
}

/* Many points inside and around the grid, against the definition. The bound: float values up to 8, double
 * arithmetic over about 60 operations, and the inverse transform of condition below 10. */
static void compare_grid(const char *density, const double to_world[16], double scale)
{
    al_scene_description *scene = NULL;
    al_density *made;
    al_error error;
    CHECK(open_density(density, &scene, &made, &error) == AL_OK);
    uint32_t state = 1;
    double largest = 0;
    for (int n = 0; n < 20000 && made; n++) {
        double index[3], world[3];
        for (int i = 0; i < 3; i++) {
            state = state * 1664525u + 1013904223u;
            index[i] = (double)(state >> 8) / (1 << 24) * 8 + (i == 0 ? -4 : i == 1 ? 5 : -1);
        }
        for (int i = 0; i < 3; i++)
            world[i] = to_world[i] * index[0] + to_world[4 + i] * index[1] + to_world[8 + i] * index[2] +
                       to_world[12 + i];
        double value = al_density_at(made, world);
        CHECK_NEAR(value, scale * expected_at(index), scale * 1e-12);
        largest = fmax(largest, value);
    }
    if (made) CHECK(largest <= al_density_max(made) && al_density_max(made) == scale * 63 / 8.0);
    al_density_free(made);
    al_scene_description_free(scene);
}

static void test_grids(void)
{
    const double identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    double moved[16];
    compare_grid("\"type\": \"grid\", \"file\": \"grids.vdb\", \"grid\": \"straight\"", identity, 1);
    compare_grid("\"type\": \"grid\", \"file\": \"half.vdb\"", identity, 1);
    compare_grid("\"type\": \"grid\", \"file\": \"grids.vdb\", \"grid\": \"slanted\", \"scale\": 2.5",
                 slanted, 2.5);
    for (int i = 0; i < 16; i++) moved[i] = i % 4 == 3 ? slanted[i] : slanted[i] * 0.1; /* then x -> x + 1 */
    moved[12] += 1;
    compare_grid("\"type\": \"grid\", \"file\": \"grids.vdb\", \"grid\": \"slanted\", \"unit_m\": 0.1, "
                 "\"transform\": {\"translate_m\": [1, 0, 0]}",
                 moved, 1);
}

static void test_bounds(void)
{
    const char *const plain = "\"type\": \"grid\", \"file\": \"one.vdb\"";
    /* three voxels of 1 m from 0: the box is [-0.5, 2.5]^3, its faces included */
    CHECK(density_at(plain, 2.5, 1, 1) == 1);
    CHECK(density_at(plain, -0.5, -0.5, -0.5) == 1);
    CHECK(density_at(plain, 2.501, 1, 1) == 0);
    CHECK(density_at(plain, 1, -0.501, 1) == 0);
    CHECK(density_at(plain, NAN, 1, 1) == 0);
    CHECK(density_at(plain, 1, INFINITY, 1) == 0);
    const char *const wide = "\"type\": \"grid\", \"file\": \"one.vdb\", \"bounds_min_m\": [-9, 1, 1], "
                             "\"bounds_max_m\": [9, 2, 2]";
    CHECK(density_at(wide, -8.9, 1.5, 1.5) == 1); /* held constant beyond the outermost centres */
    CHECK(density_at(wide, 1, 0.9, 1.5) == 0);
    CHECK(density_at(wide, 9.1, 1.5, 1.5) == 0);
    CHECK(density_at("\"type\": \"grid\", \"file\": \"voxel.vdb\"", 0.4, -0.4, 0) == 1); /* one voxel */
}

static void test_choice(void)
{
    CHECK(density_at("\"type\": \"grid\", \"file\": \"same.vdb\", \"grid\": \"density[0]\"", 2, 0, 0) == 0);
    CHECK(density_at("\"type\": \"grid\", \"file\": \"same.vdb\", \"grid\": \"density[1]\"", 2, 0, 0) == 1);
    CHECK(density_at("\"type\": \"grid\", \"file\": \"one.vdb\", \"grid\": \"density[0]\"", 2, 0, 0) == 1);
    CHECK(density_at("\"type\": \"grid\", \"file\": \"one.vdb\"", 2, 0, 0) == 1); /* the only float grid */
#define GRID(file, more) "\"type\": \"grid\", \"file\": \"" file "\"" more
    refuse(GRID("same.vdb", ", \"grid\": \"density\""),
           "same.vdb: several grids are named \"density\"|name[i]|"
           "\"density[0]\" (float, fog volume), \"density[1]\" (float, fog volume), \"other\" (vec3s");
    refuse(GRID("same.vdb", ", \"grid\": \"density[2]\""),
           "same.vdb: no grid is named \"density[2]\"|\"density[1]\"");
    refuse(GRID("same.vdb", ", \"grid\": \"smoke\""), "same.vdb: no grid is named \"smoke\"; the file has");
    refuse(GRID("two.vdb", ""),
           "two.vdb: several grids are float densities; choose one|\"density\"|\"huge\"");
    refuse(GRID("same.vdb", ", \"grid\": \"other\""),
           "same.vdb: grid \"other\" is of type vec3s; a float fog volume");
    refuse(GRID("vector.vdb", ""),
           "vector.vdb: grid \"other\" is of type vec3s; a float fog volume is right");
    refuse(GRID("level_set.vdb", ""),
           "level_set.vdb: grid \"shape\" is a level set; a float fog volume is right");
    refuse(GRID("frustum.vdb", ""),
           "frustum.vdb: grid \"frustum\" has a perspective transform; an affine one");
    refuse(GRID("nothing.vdb", ""), "nothing.vdb: grid \"nothing\" has no active voxels");
    refuse(GRID("zero.vdb", ""), "density_test.json:1: medium \"m\": the grid in zero.vdb is 0 everywhere");
    refuse(GRID("negative.vdb", ""),
           "negative.vdb: grid \"density\" is -0.5 in voxel (5, 5, 6), at (5, 5, 6)");
    refuse(GRID("nan.vdb", ""), "nan.vdb: grid \"density\" is nan in voxel (5, 5, 6)");
    refuse(GRID("infinite.vdb", ""), "infinite.vdb: grid \"density\" is inf in voxel (4, 5, 6)");
    refuse(GRID("none.vdb", ""), "none.vdb: cannot be read as OpenVDB:");
    refuse(GRID("density_test.json", ""), "density_test.json: cannot be read as OpenVDB:");
}

/* Two far voxels: a box larger than the limit is refused without its memory. */
static void test_size_limit(void)
{
    const vdb_grid far = {"far", VDB_CORNERS, {0, 0, 0}, {2000, 700, 200}, NULL, 0, {0}};
    vdb_write("far.vdb", &far, 1);
    refuse(GRID("far.vdb", ""),
           "far.vdb: grid \"far\" spans 2000 x 700 x 200 voxels, 1068 MiB as floats; at most 1024 MiB");
}

static void test_layers(void)
{
    const char *const layers =
        "\"type\": \"layers\", \"axis\": [0, 0, 3], \"period_m\": 0.5, \"thickness_m\": 0.2, "
        "\"offset_m\": 0.1, \"low\": 0.25, \"high\": 2, \"scale\": 3";
    const double z[7] = {0.1001, 0.2999, 0.3001, 0.5999, 0.6001, -0.3, -0.1};
    const double value[7] = {6, 6, 0.75, 0.75, 6, 6, 0.75}; /* layers at [0.1, 0.3) + 0.5 n */
    al_scene_description *scene = NULL;
    al_density *made;
    al_error error;
    for (int i = 0; i < 7; i++) CHECK_NEAR(density_at(layers, 7, -3, z[i]), value[i], 1e-15);
    CHECK(open_density(layers, &scene, &made, &error) == AL_OK);
    if (made) {
        CHECK_NEAR(al_density_max(made), 6, 1e-15);
        CHECK_NEAR(al_density_detail_m(made), 0.2, 1e-15);
        CHECK(!al_density_is_constant(made));
    }
    al_density_free(made);
    al_scene_description_free(scene);
    refuse("\"type\": \"layers\", \"period_m\": 1, \"thickness_m\": 0",
           "medium \"m\" has density 0 everywhere");
}

static void test_constant(void)
{
    al_scene_description *scene = NULL;
    al_density *made;
    al_error error;
    CHECK(open_density("\"type\": \"constant\", \"scale\": 4", &scene, &made, &error) == AL_OK);
    if (made) {
        CHECK(al_density_at(made, (double[3]){1e9, -1e9, 0}) == 4 && al_density_max(made) == 4);
        CHECK(al_density_is_constant(made) && al_density_detail_m(made) == 0);
    }
    al_density_free(made);
    al_scene_description_free(scene);
    const char *const box =
        "\"type\": \"constant\", \"bounds_min_m\": [0, 0, 0], \"bounds_max_m\": [1, 1, 1]";
    CHECK(density_at(box, 0.5, 0.5, 1) == 1);
    CHECK(density_at(box, 0.5, 0.5, 1.001) == 0);
}

int main(void)
{
    write_grids();
    test_grids();
    test_bounds();
    test_choice();
    test_size_limit();
    test_layers();
    test_constant();
    return test_end();
}
