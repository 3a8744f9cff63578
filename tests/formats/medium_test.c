/* The medium asset: what is written comes back within the stated error, seams are none, outside is nothing.
 */
#include "airlight/medium.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "../test.h"
#include "folder.h"
#include "golden_data.h"

static char path[512];

typedef struct opened {
    al_file *file;
    al_medium_info info;
    al_medium_field *field;
} opened;

static opened open_medium(const char *name)
{
    opened o = {0};
    al_error error = {0};
    CHECK(al_file_open(name, &(al_open_options){.kind = AL_KIND_MEDIUM}, &o.file, &error) == AL_OK);
    CHECK(o.file && al_medium_read(o.file, &o.info, &error) == AL_OK);
    CHECK(o.file && al_medium_field_open(o.file, &o.info, &o.field, &error) == AL_OK);
    if (!o.field) fprintf(stderr, "%s\n", error.message), exit(1);
    return o;
}

static void close_medium(opened *o)
{
    al_medium_field_close(o->field);
    al_file_close(o->file);
}

static double at(const opened *o, double x, double y, double z, double time_s)
{
    return al_medium_evaluate(o->field, (double[3]){x, y, z}, time_s);
}

/* The golden medium: every voxel of both frames, half-way in place and in time, and beyond everything. */
static void test_golden(void)
{
    opened o = open_medium(AIRLIGHT_GOLDEN "/medium_1_0.air");
    for (uint32_t z = 0; z < 9; z++)
        for (uint32_t y = 0; y < 2; y++)
            for (uint32_t x = 0; x < 10; x++) {
                double px = 0.5 * x - 2, py = 0.25 * y - 1, pz = 0.125 * z + 3;
                double early = golden_density(0, x, y, z), late = golden_density(1, x, y, z);
                CHECK(at(&o, px, py, pz, 0.5) == early && at(&o, px, py, pz, 1) == late);
                CHECK(at(&o, px, py, pz, -7) == early && at(&o, px, py, pz, 7) == late);
                CHECK(at(&o, px, py, pz, 0.75) == (early + late) / 2);
                if (x == 9) continue;
                double next = golden_density(1, x + 1, y, z);
                CHECK(at(&o, px + 0.25, py, pz, 1) == (late + next) / 2);
            }
    CHECK(at(&o, 2.7, -0.75, 3.5, 0.5) == 2); /* the outermost voxel, up to the bounds */
    CHECK(at(&o, 2.76, -0.75, 3.5, 0.5) == 0 && at(&o, 0, 0.51, 3, 1) == 0 && at(&o, NAN, 0, 3, 1) == 0);
    close_medium(&o);
}

/* A turned and squeezed grid whose density is trilinear by itself, a + b x + c y + d z + e x y z over voxel
 * numbers: interpolation is exact, so that what is left is the rounding of the halves, 2^-11. */
static double formula(double x, double y, double z)
{
    return 1 + x / 3 + y / 7 + z / 11 + x * y * z / 500;
}

static al_status formula_slice(void *user, uint32_t frame, uint32_t z, float *density, al_error *error)
{
    const uint32_t *size = user;
    (void)frame, (void)error;
    for (uint32_t i = 0; i < size[0] * size[1]; i++)
        density[i] = (float)formula(i % size[0], (double)(i / size[0]), z);
    return AL_OK;
}

static void test_filter(void)
{
    uint32_t size[3] = {19, 17, 26}; /* 18 spans: three bricks; 16: just two; 25: four */
    al_error error = {0};
    al_medium_data data = {.info = {.size = {size[0], size[1], size[2]},
                                    .page_size = 5,
                                    .frame_count = 1,
                                    .grid_to_world = {0, 0, 0.5f, 0, -0.25f, 0, 0, 0, 0, 1, 0, 0, 1, 2, 3, 1},
                                    .bounds_min_m = {-100, -100, -100},
                                    .bounds_max_m = {100, 100, 100},
                                    .sigma_s_per_m = {1, 1, 1}},
                           .slice = formula_slice,
                           .user = size};
    CHECK(al_medium_write(path, &data, NULL, &error) == AL_OK);
    opened o = open_medium(path);
    uint64_t state = 5;
    double worst = 0;
    for (int i = 0; i < 20000; i++) {
        double index[3];
        for (int k = 0; k < 3; k++) {
            state = state * 6364136223846793005u + 1442695040888963407u;
            index[k] = (double)(state >> 33) / 2147483648.0 * (size[k] - 1);
            if (i % 7 == k) index[k] = floor(index[k] / 8) * 8; /* seams */
        }
        double wanted = formula(index[0], index[1], index[2]);
        double seen = at(&o, 1 - 0.25 * index[1], 2 + index[2], 3 + 0.5 * index[0], 0);
        worst = fmax(worst, fabs(seen - wanted) / wanted);
    }
    printf("relative error of a trilinear density: %.2e\n", worst);
    CHECK(worst < 1.0 / 2048 + 1e-6); /* and the rounding of float */
    /* Half a voxel beyond the last centre the density still holds; then there is nothing. */
    double last = formula(18, 0, 0);
    CHECK_NEAR(at(&o, 1, 2, 3 + 0.5 * 18.49, 0), last, last / 2048);
    CHECK(at(&o, 1, 2, 3 + 0.5 * 18.51, 0) == 0 && at(&o, 1, 2, 3 - 0.5 * 0.51, 0) == 0);
    close_medium(&o);
    unlink(path);
}

/* Values nine orders of magnitude apart keep their relative error; what is 0 takes no bricks. */
static al_status peak_slice(void *user, uint32_t frame, uint32_t z, float *density, al_error *error)
{
    (void)user, (void)frame, (void)error;
    memset(density, 0, 65 * 65 * sizeof *density);
    if (z == 3) density[3] = 1e6f, density[10] = 1e-2f;
    return AL_OK;
}

static void test_range(void)
{
    al_error error = {0};
    al_medium_frame frame;
    al_medium_data data = {.info = {.size = {65, 65, 9},
                                    .frame_count = 1,
                                    .extended = true,
                                    .grid_to_world = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1},
                                    .bounds_min_m = {-1, -1, -1},
                                    .bounds_max_m = {65, 65, 9}},
                           .slice = peak_slice};
    CHECK(al_medium_write(path, &data, NULL, &error) == AL_OK);
    opened o = open_medium(path);
    CHECK(al_medium_read_frame(o.file, &o.info, 0, &frame, &error) == AL_OK);
    CHECK(frame.brick_count == 2 && frame.density_max == 1e6f);
    CHECK_NEAR(at(&o, 3, 0, 3, 0), 1e6, 0);
    CHECK_NEAR(at(&o, 10, 0, 3, 0), 1e-2, 1e-2 / 2048);
    close_medium(&o);
    unlink(path);
}

static al_status bad_slice(void *user, uint32_t frame, uint32_t z, float *density, al_error *error)
{
    (void)frame, (void)error;
    memset(density, 0, 4 * sizeof *density);
    if (z == 1) density[2] = *(const float *)user;
    return AL_OK;
}

static void test_refused(void)
{
    float bad[] = {-1, NAN, INFINITY};
    al_medium_data data = {.info = {.size = {2, 2, 2},
                                    .frame_count = 1,
                                    .grid_to_world = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1},
                                    .bounds_max_m = {1, 1, 1}},
                           .slice = bad_slice};
    for (int i = 0; i < 3; i++) {
        al_error error = {0};
        data.user = &bad[i];
        CHECK(al_medium_write(path, &data, NULL, &error) == AL_BAD_INPUT &&
              strstr(error.message, "density 2 of slice 1"));
        CHECK(access(path, F_OK) != 0);
    }
}

int main(void)
{
    char folder[256];
    if (!folder_make(folder, sizeof folder)) return test_skip("no temporary folder");
    snprintf(path, sizeof path, "%s/made.air", folder);
    test_golden();
    test_filter();
    test_range();
    test_refused();
    CHECK(rmdir(folder) == 0);
    return test_end();
}
