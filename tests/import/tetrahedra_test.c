/* airlight-tetrahedra through al_tetrahedralise: closed shapes, cavities, surfaces that cut themselves. */
#include <math.h>

#include "files.h"
#include "import.h"
#include "tetrahedra.h"

static al_import *import_text(const char *json)
{
    al_import *import = NULL;
    al_error error = {0};
    write_text("tetrahedra_test.json", json);
    CHECK(al_import_scene("tetrahedra_test.json", AL_QUALITY_PREVIEW, &import, &error) == AL_OK);
    if (!import) fprintf(stderr, "%s\n", error.message);
    return import;
}

/* Sum of the volumes; every single one must be above 0 or, where points lie in one plane, not below. */
static double total_volume(const al_tetrahedra *mesh)
{
    double sum = 0;
    for (uint32_t t = 0; t < mesh->count; t++) {
        double e[3][3];
        const double *origin = mesh->points + mesh->corners[t * (size_t)4] * (size_t)3;
        for (int k = 0; k < 3; k++)
            for (int i = 0; i < 3; i++)
                e[k][i] = mesh->points[mesh->corners[t * (size_t)4 + k + 1] * (size_t)3 + i] - origin[i];
        double volume = (e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) +
                         e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
                         e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0])) /
                        6;
        CHECK(volume >= 0);
        sum += volume;
    }
    return sum;
}

static void check_shape(const char *shape)
{
    char json[512];
    al_triangles surface;
    al_tetrahedra mesh;
    al_error error = {0};
    snprintf(json, sizeof json, "{\"meshes\": [{\"name\": \"a\", \"shape\": {%s}}]}", shape);
    al_import *import = import_text(json);
    if (!import) return;
    CHECK(al_triangles_from_mesh(&import->scene.meshes[0], &surface, &error) == AL_OK);
    CHECK(al_tetrahedralise("a shape", &surface, &mesh, &error) == AL_OK);
    if (mesh.count == 0) fprintf(stderr, "%s\n", error.message);
    /* rounding: up to 2e4 terms of relative error 1e-15, the sum grows with their number at worst */
    CHECK_NEAR(total_volume(&mesh), al_triangles_volume(&surface), 1e-9 * al_triangles_volume(&surface));
    CHECK(mesh.exact);
    CHECK(mesh.point_count >= surface.vertex_count &&
          memcmp(mesh.points, surface.positions, surface.vertex_count * sizeof(double[3])) == 0);
    al_tetrahedra_free(&mesh);
    al_triangles_free(&surface);
    al_import_free(import);
}

/* Joins the meshes of a scene into one surface; `inward` turns the second over. */
static al_triangles join(const al_import *import, bool inward)
{
    al_triangles parts[2], whole;
    al_error error;
    for (int k = 0; k < 2; k++)
        CHECK(al_triangles_from_mesh(&import->scene.meshes[k], &parts[k], &error) == AL_OK);
    whole = (al_triangles){parts[0].vertex_count + parts[1].vertex_count,
                           parts[0].triangle_count + parts[1].triangle_count,
                           malloc((parts[0].vertex_count + parts[1].vertex_count) * sizeof(double[3])),
                           malloc((parts[0].triangle_count + parts[1].triangle_count) * sizeof(uint32_t[3]))};
    memcpy(whole.positions, parts[0].positions, parts[0].vertex_count * sizeof(double[3]));
    memcpy(whole.positions + parts[0].vertex_count * 3, parts[1].positions,
           parts[1].vertex_count * sizeof(double[3]));
    memcpy(whole.indices, parts[0].indices, parts[0].triangle_count * sizeof(uint32_t[3]));
    for (uint32_t i = 0; i < parts[1].triangle_count * 3; i++)
        whole.indices[parts[0].triangle_count * 3 + (inward ? i - i % 3 + 2 - i % 3 : i)] =
            parts[0].vertex_count + parts[1].indices[i];
    for (int k = 0; k < 2; k++) al_triangles_free(&parts[k]);
    return whole;
}

/* A box with a cubic hole: the volume inside is the difference. */
static void test_cavity(void)
{
    al_error error = {0};
    al_tetrahedra mesh;
    al_import *import =
        import_text("{\"meshes\": [{\"name\": \"a\", \"shape\": {\"type\": \"box\", \"size_m\": 3}}, "
                    "{\"name\": \"b\", \"shape\": {\"type\": \"box\", \"size_m\": [1, 2, 1]}}]}");
    if (!import) return;
    al_triangles surface = join(import, true);
    CHECK(al_triangles_check("cavity", &surface, &error) == AL_OK);
    CHECK(al_tetrahedralise("cavity", &surface, &mesh, &error) == AL_OK);
    CHECK(mesh.exact);
    CHECK_NEAR(total_volume(&mesh), 25, 1e-9 * 25);
    al_tetrahedra_free(&mesh);
    al_triangles_free(&surface);
    al_import_free(import);
}

/* Two boxes of 2 x 2 x 2 that overlap in 1 x 2 x 2: they wind around 12. The boxes' sides lie in whole
 * columns or not; at worst one column of 3/256 is missing or too much at each side in x (3 m long) and y: 2 *
 * 3/256 / 2. */
static void test_overlap(void)
{
    al_error error = {0};
    al_tetrahedra mesh;
    al_import *import =
        import_text("{\"meshes\": [{\"name\": \"a\", \"shape\": {\"type\": \"box\", \"size_m\": 2}}, "
                    "{\"name\": \"b\", \"shape\": {\"type\": \"box\", \"size_m\": 2}, \"transform\": "
                    "{\"scale\": [1, 1.001, 1], "
                    "\"translate_m\": [1, 0, 0.01]}}]}");
    if (!import) return;
    for (uint32_t i = 0; i < import->scene.meshes[1].vertex_count; i++) { /* instances move, meshes do not */
        import->scene.meshes[1].positions[i * 3] += 1;
        import->scene.meshes[1].positions[i * 3 + 2] += 0.01f;
    }
    al_triangles surface = join(import, false);
    CHECK(al_tetrahedralise("overlap", &surface, &mesh, &error) == AL_OK);
    CHECK(!mesh.exact);
    CHECK_NEAR(total_volume(&mesh), 12, 12 * 0.012);
    al_tetrahedra_free(&mesh);
    al_triangles_free(&surface);
    al_import_free(import);
}

/* What has no inside is refused with one line and nothing else happens. */
static void test_refusals(void)
{
    double flat[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    uint32_t sides[] = {0, 1, 2, 0, 2, 1};
    al_triangles surface = {3, 2, flat, sides};
    al_tetrahedra mesh;
    al_error error = {0};
    al_status status = al_tetrahedralise("flat", &surface, &mesh, &error);
    check_mentions("flat", status, &error, AL_BAD_INPUT, "flat: ");
    CHECK(mesh.count == 0 && !mesh.points);
    flat[4] = NAN;
    status = al_tetrahedralise("nan", &surface, &mesh, &error);
    check_refusal("nan", status, &error, AL_BAD_INPUT, "nan: point 1 is not finite");
}

/* Without triangles: the Delaunay mesh of points, here of a cube's corners and its middle. */
static void test_delaunay(void)
{
    double points[27];
    for (int i = 0; i < 24; i++) points[i] = i / 3 >> i % 3 & 1;
    points[24] = points[25] = points[26] = 0.5;
    al_triangles cloud = {9, 0, points, NULL};
    al_tetrahedra mesh;
    al_error error = {0};
    CHECK(al_tetrahedralise("points", &cloud, &mesh, &error) == AL_OK);
    CHECK_NEAR(total_volume(&mesh), 1, 1e-12);
    CHECK(mesh.point_count == 9 && mesh.count == 12);
    al_tetrahedra_free(&mesh);
}

int main(void)
{
    check_shape("\"type\": \"box\"");
    check_shape("\"type\": \"sphere\", \"subdivisions\": 3, \"radius_m\": 1e-4");
    check_shape("\"type\": \"sphere\", \"subdivisions\": 4, \"radius_m\": 1e4");
    check_shape("\"type\": \"torus\"");
    test_cavity();
    test_overlap();
    test_refusals();
    test_delaunay();
    return test_end();
}
