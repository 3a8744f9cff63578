/* The transmittance interval map of a slab against its closed form, over ten decades of optical depth. */
#include <epoxy/gl.h>
#include <stdlib.h>

#include "../../runtime/state.h"
#include "../test.h"
#include "sphere.h"
#include "stage.h"

enum { KNOTS = 16, EDGE = 9 };

/* Homogeneous medium of length L that starts at d1: transmittance falls in n - 1 equal steps. n = 16, no
 * offset. */
static const struct {
    double start, sigma_t, length, depths[KNOTS];
} oracle[] = {
    {2,
     0.5,
     4,
     {2, 2.11874498033, 2.24498764304, 2.37973900606, 2.5242294615, 2.67997722598, 2.8488857647,
      3.03338627855, 3.23665284011, 3.46293972717, 3.71813504489, 4.01072186609, 4.35357001888, 4.76760364305,
      5.29034161426, 6}},
    {0,
     3,
     2,
     {0, 0.0229386111441, 0.0475731899487, 0.0741746850658, 0.10308465466, 0.134742166471, 0.169724828731,
      0.208814033318, 0.253103732467, 0.304193166254, 0.364555677426, 0.438320799753, 0.533190578306,
      0.666306516778, 0.891312075289, 2}},
};

/* A slab of `length` metres along z, its middle in the origin, in GRID voxels; 1 m wide. */
static bool write_slab(const char *folder, double sigma_t, double length, bool colored)
{
    enum { LONG = 128, WIDE = 16 };
    static uint16_t grid[LONG * WIDE * WIDE];
    al_error error = {0};
    char path[512];
    al_translucent_data data = {.density = grid, .provenance_json = "{}"};
    al_translucent_info *info = &data.info;
    for (size_t i = 0; i < sizeof grid / sizeof grid[0]; i++) grid[i] = 65535;
    info->page_size = 64;
    info->order = info->ior = info->density_max = 1;
    info->channel_count = colored ? 3 : 1;
    info->direction_count = 32;
    info->voxel_m = (float)(length / LONG);
    for (int k = 0; k < 3; k++) {
        info->grid_size[k] = k == 2 ? LONG : WIDE;
        info->grid_origin_m[k] = -0.5f * info->voxel_m * (float)info->grid_size[k];
        info->sigma_s_per_m[k] = (float)(sigma_t * (colored && k ? 0.5 / k : 1));
        info->bounds_min_m[k] = info->grid_origin_m[k];
        info->bounds_max_m[k] = -info->grid_origin_m[k];
    }
    info->volume_m3 = (double)LONG * WIDE * WIDE * info->voxel_m * info->voxel_m * info->voxel_m;
    info->radius_m = 1;
    snprintf(path, sizeof path, "%s/slab.air", folder);
    if (al_translucent_write(path, &data, NULL, &error) == AL_OK) return true;
    fprintf(stderr, "slab: %s\n", error.message);
    return false;
}

/* A box from -half to half in place of the sphere. */
static void make_box(al_mesh *mesh, const float half[3])
{
    static const uint32_t faces[36] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                       2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    mesh->vertex_count = 8;
    mesh->index_count = 36;
    mesh->submeshes[0].index_count = 36;
    for (uint32_t i = 0; i < 8; i++)
        for (int k = 0; k < 3; k++) {
            mesh->positions[3 * i + k] = i >> k & 1 ? half[k] : -half[k];
            mesh->normals[3 * i + k] = (i >> k & 1 ? 1 : -1) * 0.57735f;
        }
    for (int i = 0; i < 36; i++) mesh->indices[i] = faces[i];
}

/* Draws the slab, its front `start` metres from the eye's plane, and reads the middle pixel's knots; answers
 * the march step in metres. */
static double read_knots(const char *folder, double start, double sigma_t, double length, bool colored,
                         double depths[KNOTS], double *tau)
{
    sphere_scene s;
    al_runtime *runtime = NULL;
    al_error error = {0};
    sphere_scene_begin(&s);
    double voxel = length / 128;
    sphere_scene_add(&s, "slab.air", 0, (float[3]){0, 0, 0});
    make_box(&s.meshes[0], (float[3]){(float)(8 * voxel), (float)(8 * voxel), (float)(length / 2)});
    CHECK(write_slab(folder, sigma_t, length, colored) && sphere_scene_write(folder, &s));
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK);
    CHECK(stage_load(runtime, folder));
    al_view view = stage_ortho(EDGE, EDGE, (float)(4 * voxel));
    view.view[14] = (float)(-start - length / 2); /* the near plane lies at the eye's plane */
    view.projection[10] = -2.0f / 20;
    float *pixels = stage_draw(runtime, &view, &(al_settings){.surface_off = true}, 0);
    CHECK(pixels && stage_bad(pixels, EDGE * EDGE * 3) == 0);
    float ends[EDGE * EDGE * 4], groups[EDGE * EDGE * 4 * 8];
    glGetTextureImage(runtime->targets.ends.id, 0, GL_RGBA, GL_FLOAT, sizeof ends, ends);
    glGetTextureImage(runtime->targets.knots.id, 0, GL_RGBA, GL_FLOAT, sizeof groups, groups);
    const float *end = ends + 4 * (EDGE * (EDGE / 2) + EDGE / 2);
    depths[0] = end[0];
    depths[KNOTS - 1] = end[1];
    *tau = end[2];
    for (int k = 1; k < KNOTS - 1; k++)
        depths[k] = groups[4 * (((k - 1) / 4 * EDGE + EDGE / 2) * EDGE + EDGE / 2) + (k - 1) % 4];
    free(pixels);
    al_runtime_destroy(runtime);
    sphere_scene_end(&s);
    return 0.5 * voxel;
}

static void test_oracle(const char *folder)
{
    for (size_t i = 0; i < sizeof oracle / sizeof oracle[0]; i++) {
        double depths[KNOTS], tau, start = oracle[i].start > 0 ? oracle[i].start : 1;
        double step = read_knots(folder, start, oracle[i].sigma_t, oracle[i].length, false, depths, &tau);
        /* A march step; the grid fades over half a voxel, a step, at its end, and as far over the last knot.
         */
        for (int k = 0; k < KNOTS - 1; k++)
            CHECK_NEAR(depths[k] - start, oracle[i].depths[k] - oracle[i].start, step);
        CHECK_NEAR(depths[KNOTS - 1] - start, oracle[i].length, 2 * step);
        CHECK_NEAR(tau, oracle[i].sigma_t * oracle[i].length, 0.01 * tau);
    }
}

/* t_k = -log(1 - k (1 - exp(-tau)) / (n - 1)) / sigma in one slab of 2 m, tau from 1e-6 to 1e4. */
static void test_decades(const char *folder)
{
    for (int exponent = -6; exponent <= 4; exponent++) {
        double wanted = pow(10, exponent), sigma = wanted / 2, depths[KNOTS], tau;
        double step = read_knots(folder, 1, sigma, 2, false, depths, &tau);
        /* Where nothing is left, below exp(-40), the march ends; voxels are 16 bits and floats 24. */
        CHECK(wanted > 40 ? tau >= 40 : fabs(tau / wanted - 1) < 0.01);
        for (int k = 1; k < KNOTS - 1; k++) {
            CHECK(depths[k] >= depths[k - 1]);
            CHECK_NEAR(depths[k] - 1, -log1p(k * expm1(-wanted) / (KNOTS - 1)) / sigma, step);
        }
    }
}

/* Coloured: the mean of the channels' transmittances falls in equal steps (solved by bisection here). */
static void test_colored(const char *folder)
{
    const double sigma[3] = {3, 1.5, 0.75}, length = 2;
    double depths[KNOTS], tau, total = 0;
    double step = read_knots(folder, 1, sigma[0], length, true, depths, &tau);
    for (int c = 0; c < 3; c++) total -= expm1(-sigma[c] * length) / 3;
    for (int k = 1; k < KNOTS - 1; k++) {
        double low = 0, high = length;
        for (int i = 0; i < 60; i++) {
            double middle = 0.5 * (low + high), lost = 0;
            for (int c = 0; c < 3; c++) lost -= expm1(-sigma[c] * middle) / 3;
            if (lost < total * k / (KNOTS - 1))
                low = middle;
            else
                high = middle;
        }
        CHECK_NEAR(depths[k] - 1, low, step);
    }
}

int main(void)
{
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    const char *folder = stage_folder();
    test_oracle(folder);
    test_decades(folder);
    test_colored(folder);
    return test_end();
}
