/* Files that others made, where they are at hand: scans, grids, scenes, maps. The facts are their makers'. */
#include <math.h>
#include <sys/stat.h>

#include "files.h"
#include "import.h"
#include "tetrahedra.h"

static al_status import_text(const char *json, al_import **import, al_error *error)
{
    write_text("shared_test.json", json);
    return al_import_scene("shared_test.json", AL_QUALITY_PREVIEW, import, error);
}

typedef struct closed_mesh {
    const char *file;
    uint32_t triangles;
    bool exact; /* does not cut itself */
} closed_mesh;

static void test_closed(const closed_mesh *fact)
{
    char json[1024];
    al_import *import = NULL;
    al_triangles boundary;
    al_tetrahedra mesh;
    al_error error = {0};
    snprintf(json, sizeof json,
             "{\"meshes\": [{\"name\": \"a\", \"file\": \"%s/data/meshes/%s\", \"unit_m\": 0.1}], \"media\": "
             "[{\"name\": "
             "\"m\", \"sigma_s_per_m\": 1}], \"translucents\": [{\"mesh\": \"a\", \"medium\": \"m\"}]}",
             shared_folder(), fact->file);
    if (import_text(json, &import, &error)) {
        CHECK(!"a closed mesh is accepted");
        fprintf(stderr, "%s\n", error.message);
        return;
    }
    CHECK(al_import_boundary(import, 0, &boundary, &error) == AL_OK);
    CHECK(boundary.triangle_count == fact->triangles);
    CHECK(al_tetrahedralise(fact->file, &boundary, &mesh, &error) == AL_OK);
    CHECK(mesh.exact == fact->exact && mesh.count > 0);
    double sum = 0, expected = al_triangles_volume(&boundary);
    for (uint32_t t = 0; t < mesh.count; t++) {
        double e[3][3];
        for (int k = 0; k < 3; k++)
            for (int i = 0; i < 3; i++)
                e[k][i] = mesh.points[mesh.corners[t * 4 + k + 1] * 3 + i] -
                          mesh.points[mesh.corners[t * 4] * 3 + i];
        sum += (e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) +
                e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
                e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0])) /
               6;
    }
    /* what cuts itself counts overlaps twice in its signed volume: only "about" the same, 1 % here */
    CHECK_NEAR(sum, expected, expected * (fact->exact ? 1e-9 : 0.01));
    al_tetrahedra_free(&mesh);
    al_triangles_free(&boundary);
    al_import_free(import);
}

/* `folder` is meshes or volumes. */
static void refuse(const char *folder, const char *file, const char *parts)
{
    char json[1024];
    al_import *import = NULL;
    al_error error = {0};
    if (strcmp(folder, "meshes") == 0)
        snprintf(json, sizeof json,
                 "{\"meshes\": [{\"name\": \"a\", \"file\": \"%s/data/meshes/%s\"}], \"media\": [{\"name\": "
                 "\"m\", "
                 "\"sigma_s_per_m\": 1}], \"translucents\": [{\"mesh\": \"a\", \"medium\": \"m\"}]}",
                 shared_folder(), file);
    else
        snprintf(json, sizeof json,
                 "{\"media\": [{\"name\": \"m\", \"sigma_s_per_m\": 1, \"density\": {\"type\": \"grid\", "
                 "\"file\": "
                 "\"%s/data/volumes/%s\"}}]}",
                 shared_folder(), file);
    al_status status = import_text(json, &import, &error);
    check_mentions(file, status, &error, AL_BAD_INPUT, parts);
    al_import_free(import);
}

typedef struct grid_fact {
    const char *file, *grid;
    double largest, voxel;
} grid_fact;

static void test_grid(const grid_fact *fact)
{
    char json[1024];
    al_import *import = NULL;
    al_error error = {0};
    snprintf(json, sizeof json,
             "{\"media\": [{\"name\": \"m\", \"sigma_s_per_m\": 1, \"density\": {\"type\": \"grid\", "
             "\"file\": \"%s/%s\"%s}}]}",
             shared_folder(), fact->file, fact->grid);
    CHECK(import_text(json, &import, &error) == AL_OK);
    if (!import) {
        fprintf(stderr, "%s\n", error.message);
        return;
    }
    CHECK_NEAR(al_density_max(import->densities[0]), fact->largest,
               5e-4 * fact->largest); /* facts of 4 digits */
    CHECK_NEAR(al_density_detail_m(import->densities[0]), fact->voxel, 1e-4 * fact->voxel);
    CHECK(import->input_count == 2);
    al_import_free(import);
}

static void test_scene(const char *file, uint32_t triangles, uint32_t lights, uint32_t cameras)
{
    char json[1024];
    al_import *import = NULL;
    al_error error = {0};
    uint32_t found = 0;
    snprintf(json, sizeof json, "{\"meshes\": [{\"name\": \"a\", \"file\": \"%s/data/scenes/%s\"}]}",
             shared_folder(), file);
    CHECK(import_text(json, &import, &error) == AL_OK);
    if (!import) {
        fprintf(stderr, "%s\n", error.message);
        return;
    }
    for (uint32_t i = 0; i < import->scene.instance_count; i++)
        found += import->scene.meshes[import->scene.instances[i].mesh].index_count / 3;
    CHECK(found == triangles);
    CHECK(import->scene.light_count == lights && import->scene.camera_count == cameras);
    al_import_free(import);
}

static void test_map(const char *file, uint32_t width, uint32_t height)
{
    char json[1024];
    al_import *import = NULL;
    al_error error = {0};
    double mean = 0;
    snprintf(json, sizeof json, "{\"environment\": {\"file\": \"%s/data/images/%s\"}}", shared_folder(),
             file);
    CHECK(import_text(json, &import, &error) == AL_OK);
    if (!import) {
        fprintf(stderr, "%s\n", error.message);
        return;
    }
    const al_environment *e = &import->scene.environment;
    CHECK(e->width == width && e->height == height);
    /* band 0 is sqrt(4 pi) times the mean over the sphere: a sum over rows with their solid angles */
    for (uint32_t y = 0; y < height; y++) {
        double share =
            (cos(3.14159265358979 * y / height) - cos(3.14159265358979 * (y + 1) / height)) / 2 / width;
        for (uint32_t x = 0; x < width; x++) mean += share * e->pixels[(y * (size_t)width + x) * 3];
    }
    CHECK_NEAR(e->sh[0][0], sqrt(4 * 3.14159265358979) * mean, 1e-6 * e->sh[0][0]);
    al_import_free(import);
}

int main(void)
{
    static const closed_mesh meshes[] = {
        {"c3d_spot.obj", 5856, true},       {"cgal_armadillo.off", 52000, true},
        {"cgal_bones.off", 4204, false},    {"cgal_cheese.off", 17786, true},
        {"cgal_elephant.off", 5558, true},  {"cgal_sphere966.off", 1848, true},
        {"glmark2_bunny.obj", 69666, false}};
    static const grid_fact grids[] = {
        {"data/volumes/smoke.vdb", "", 5.715, 0.47619},
        {"data/volumes/oiio_sphere.vdb", "", 1, 0.1},
        {"data/volumes/vpt_box.vdb", "", 1, 0.05},
        {"data/volumes/wdas_cloud_sixteenth.vdb", "", 1, 3.33333},
        {"data/volumes/arnold_grids.vdb", ", \"grid\": \"density[2]\"", 10, 0.1},
        {"reference/layers.vdb", "", 7.99983, 0.015625},
        {"reference/scan_smoke.vdb", "", 13.1883, 0.01875}};
    char path[512];
    struct stat facts;
    snprintf(path, sizeof path, "%s/data/meshes/c3d_spot.obj", shared_folder());
    if (stat(path, &facts)) return test_skip("the shared data folder is not here (AIRLIGHT_SHARED)");
    for (size_t i = 0; i < sizeof meshes / sizeof meshes[0]; i++) test_closed(&meshes[i]);
    refuse("meshes", "neg_c3d_beast.obj", "neg_c3d_beast.obj): 2 edges with more than two triangles");
    refuse("meshes", "neg_c3d_suzanne.obj", "neg_c3d_suzanne.obj): 42 open edges");
    refuse("meshes", "neg_c3d_teapot.obj", "neg_c3d_teapot.obj): 160 open edges");
    for (size_t i = 0; i < sizeof grids / sizeof grids[0]; i++) test_grid(&grids[i]);
    refuse("volumes", "arnold_grids.vdb", "density[0]|density[1]|density[2]|name[i]");
    refuse("volumes", "neg_arnold_pointgrid.vdb", "is of type ptdataidx32; a float fog volume is right");
    refuse("volumes", "neg_zeno_res_levelset.vdb", "is a level set; a float fog volume is right");
    refuse("volumes", "oiio_sphereCd.vdb", "grid \"Cd\" is of type vec3s; a float fog volume is right");
    test_scene("nvpro_cornellBox/cornellBox.gltf", 16732, 0, 1);
    test_scene("sponza/atrium.obj", 33662, 0, 1);
    test_scene("tim_cornell/cornell.obj", 32, 0, 1);
    test_map("arnold_rooftop_small.hdr", 300, 150);
    test_map("blender_interior.exr", 1024, 512);
    test_map("blender_sunset.exr", 1024, 512);
    return test_end();
}
