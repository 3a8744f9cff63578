/* The atlas: no two surfaces share a texel, every surface has texels, and what is refused. */
#include "atlas.h"

#include <unistd.h>

#include "../import/files.h"
#include "geometry.h"
#include "raster.h"
#include "second_uv.h"
#include "texels.h"

static al_import *import_text(const char *json)
{
    al_import *import = NULL;
    al_error error = {0};
    write_text("atlas_test.json", json);
    if (al_import_scene("atlas_test.json", AL_QUALITY_PREVIEW, &import, &error) != AL_OK) {
        fprintf(stderr, "%s\n", error.message);
        CHECK(!"the scene is imported");
    }
    return import;
}

/* --- texels' centres of a page, each of one triangle at most --- */

typedef struct page_map {
    uint32_t width, height, shared, outside;
    uint8_t *taken;
} page_map;

static bool mark(void *user, int x, int y)
{
    page_map *map = user;
    if (x < 0 || y < 0 || x >= (int)map->width || y >= (int)map->height) {
        map->outside++;
        return true;
    }
    uint8_t *cell = &map->taken[(size_t)y * map->width + (size_t)x];
    map->shared += *cell;
    *cell = 1;
    return true;
}

static void mark_instance(const al_scene *scene, const al_atlas_instance *placed, page_map *map)
{
    const al_mesh *mesh = &scene->meshes[scene->instances[placed->instance].mesh];
    for (uint32_t i = 0; i < mesh->index_count; i += 3) {
        double uv[3][2];
        for (uint32_t k = 0; k < 3; k++) al_texels_corner(mesh, placed, mesh->indices[i + k], uv[k]);
        al_raster_centres((const double(*)[2])uv, mark, map);
    }
}

static double area_of(const al_scene *scene, const al_instance *instance)
{
    const al_mesh *mesh = &scene->meshes[instance->mesh];
    double world[16], sum = 0;
    for (int i = 0; i < 16; i++) world[i] = instance->world[i];
    for (uint32_t i = 0; i < mesh->index_count; i += 3) {
        double p[3][3], square = 0;
        for (uint32_t k = 0; k < 3; k++) {
            const float *from = mesh->positions + 3 * (size_t)mesh->indices[i + k];
            al_matrix_point(world, (double[3]){from[0], from[1], from[2]}, p[k]);
        }
        for (int k = 0; k < 3; k++) {
            int a = (k + 1) % 3, b = (k + 2) % 3;
            double n = (p[1][a] - p[0][a]) * (p[2][b] - p[0][b]) - (p[1][b] - p[0][b]) * (p[2][a] - p[0][a]);
            square += n * n;
        }
        sum += sqrt(square) / 2;
    }
    return sum;
}

/* Vertices, normals and uv0 of the corners are what they were. */
static void check_same_surface(const al_scene *before, const al_scene *after)
{
    CHECK(before->mesh_count == after->mesh_count);
    for (uint32_t m = 0; m < before->mesh_count; m++) {
        const al_mesh *a = &before->meshes[m], *b = &after->meshes[m];
        uint32_t wrong = a->index_count != b->index_count;
        for (uint32_t i = 0; !wrong && i < a->index_count; i++) {
            size_t v = a->indices[i], w = b->indices[i];
            wrong += memcmp(a->positions + 3 * v, b->positions + 3 * w, 12) != 0 ||
                     memcmp(a->normals + 3 * v, b->normals + 3 * w, 12) != 0 ||
                     (a->uv0 && memcmp(a->uv0 + 2 * v, b->uv0 + 2 * w, 8));
        }
        CHECK(wrong == 0);
    }
}

/* Whether the smaller neighbours of the page's rectangles keep their distance: instances' texels differ. */
static void check_rectangles(const al_atlas *atlas, uint32_t padding)
{
    for (uint32_t i = 0; i < atlas->instance_count; i++) {
        const al_atlas_instance *a = &atlas->instances[i];
        CHECK(a->x + a->width <= atlas->pages[a->page][0] && a->y + a->height <= atlas->pages[a->page][1]);
        for (uint32_t k = 0; k < i; k++) {
            const al_atlas_instance *b = &atlas->instances[k];
            bool apart = a->page != b->page || a->x + a->width + padding <= b->x ||
                         b->x + b->width + padding <= a->x || a->y + a->height + padding <= b->y ||
                         b->y + b->height + padding <= a->y;
            CHECK(apart);
        }
    }
}

/* Everything an atlas promises. `area_error` bounds how far the texels' own areas may be from the surface's:
 * texels at borders count whole in neither sum, so what is compared is the triangles' area on the page. */
static void check_atlas(const char *name, const char *json, double area_error)
{
    al_import *before = import_text(json), *import = import_text(json), *again = import_text(json);
    al_atlas atlas, second;
    al_texels texels;
    al_error error = {0};
    if (!before || !import || !again) goto cleanup;
    bool made = al_atlas_make(import, &atlas, &error) == AL_OK;
    CHECK(made);
    if (!made) {
        fprintf(stderr, "%s: %s\n", name, error.message);
        goto cleanup;
    }
    check_same_surface(&before->scene, &import->scene);
    check_rectangles(&atlas, import->description->lightmap.padding_texels);

    uint32_t covered = 0;
    double on_page = 0, in_space = 0;
    for (uint32_t p = 0; p < atlas.page_count; p++) {
        page_map map = {.width = atlas.pages[p][0], .height = atlas.pages[p][1]};
        map.taken = calloc((size_t)map.width * map.height, 1);
        for (uint32_t i = 0; i < atlas.instance_count; i++)
            if (atlas.instances[i].page == p) mark_instance(&import->scene, &atlas.instances[i], &map);
        CHECK(map.shared == 0 && map.outside == 0);
        if (map.shared || map.outside)
            fprintf(stderr, "%s: %u texels shared, %u outside\n", name, map.shared, map.outside);
        for (size_t i = 0; i < (size_t)map.width * map.height; i++) covered += map.taken[i];
        free(map.taken);
    }
    for (uint32_t i = 0; i < atlas.instance_count; i++) {
        const al_atlas_instance *placed = &atlas.instances[i];
        const al_mesh *mesh = &import->scene.meshes[import->scene.instances[placed->instance].mesh];
        bool good = al_uv_check(mesh, placed->width, placed->height, &error) == AL_OK;
        CHECK(good);
        if (!good) fprintf(stderr, "%s: %s\n", name, error.message);
        in_space += area_of(&import->scene, &import->scene.instances[placed->instance]);
        for (uint32_t k = 0; k < mesh->index_count; k += 3) {
            double uv[3][2];
            for (uint32_t c = 0; c < 3; c++) al_texels_corner(mesh, placed, mesh->indices[k + c], uv[c]);
            on_page += fabs((uv[1][0] - uv[0][0]) * (uv[2][1] - uv[0][1]) -
                            (uv[1][1] - uv[0][1]) * (uv[2][0] - uv[0][0])) /
                       2;
        }
    }
    if (atlas.coarse_count == 0)
        CHECK_NEAR(on_page * atlas.texel_m * atlas.texel_m / in_space, 1, area_error);

    CHECK(al_texels_make(&import->scene, &atlas, &texels, &error) == AL_OK);
    CHECK(texels.count >= covered);
    uint32_t wrong = 0;
    for (uint32_t i = 0; i < texels.count; i++) {
        const al_texel *t = &texels.texels[i];
        double length = 0;
        for (int k = 0; k < 3; k++) length += (double)t->normal[k] * t->normal[k];
        wrong += !(t->edge_m > 0) || !(fabs(length - 1) < 1e-5) ||
                 !isfinite(t->position[0] + t->position[1] + t->position[2]);
        wrong += i > 0 && (t->page < t[-1].page || (t->page == t[-1].page && t->cell <= t[-1].cell));
    }
    CHECK(wrong == 0);
    printf("%s: %u pages, first %u x %u, %u texels, %.0f %% of the pages\n", name, atlas.page_count,
           atlas.pages[0][0], atlas.pages[0][1], texels.count,
           100.0 * texels.count / ((double)atlas.pages[0][0] * atlas.pages[0][1] * atlas.page_count));

    CHECK(al_atlas_make(again, &second, &error) == AL_OK);
    CHECK(second.instance_count == atlas.instance_count &&
          !memcmp(second.instances, atlas.instances, atlas.instance_count * sizeof *atlas.instances));
    for (uint32_t m = 0; m < import->scene.mesh_count; m++) {
        const al_mesh *a = &import->scene.meshes[m], *b = &again->scene.meshes[m];
        CHECK(a->vertex_count == b->vertex_count && (!a->uv1) == (!b->uv1) &&
              (!a->uv1 || !memcmp(a->uv1, b->uv1, a->vertex_count * sizeof(float[2]))));
    }
    al_texels_free(&texels);
    al_atlas_free(&second);
    al_atlas_free(&atlas);
cleanup:
    al_import_free(before);
    al_import_free(import);
    al_import_free(again);
}

/* Planes of a box are projected as they are: areas agree to rounding. A sphere's charts are scaled to theirs.
 */
static void test_shapes(void)
{
    check_atlas("box",
                "{\"meshes\": [{\"name\": \"m1\", \"shape\": {\"type\": \"box\", \"size_m\": [1, 2, 3]}, "
                "\"lighting\": \"lightmap\"}]}",
                1e-5);
    check_atlas("sphere and torus",
                "{\"meshes\": [{\"name\": \"m2\", \"shape\": {\"type\": \"sphere\", \"radius_m\": 1, "
                "\"subdivisions\": 5}, "
                "\"lighting\": "
                "\"lightmap\"}, {\"name\": \"m3\", \"shape\": {\"type\": \"torus\", \"major_radius_m\": 2, "
                "\"minor_radius_m\": 0.5}, "
                "\"lighting\": \"lightmap\", \"transform\": {\"translate_m\": [0, 2, 0]}}]}",
                1e-4);
    check_atlas("many pages",
                "{\"meshes\": [{\"name\": \"m4\", \"shape\": {\"type\": \"box\", \"size_m\": [1, 1, 1]}, "
                "\"lighting\": \"lightmap\"}, "
                "{\"name\": \"m5\", \"shape\": {\"type\": \"box\", \"size_m\": [2, 1, 1]}, \"lighting\": "
                "\"lightmap\"}, "
                "{\"name\": \"m6\", \"shape\": {\"type\": \"plane\", \"width_m\": 9, \"depth_m\": 9}, "
                "\"lighting\": \"lightmap\"}], "
                "\"lightmap\": {\"texel_m\": 0.1, \"page_size\": 100, \"padding_texels\": 3}}",
                1e-5);
}

/* One page of 64 texels for a surface that needs many more: the texels grow. */
static void test_coarse(void)
{
    al_import *import =
        import_text("{\"meshes\": [{\"name\": \"m7\", \"shape\": {\"type\": \"box\", \"size_m\": [1, 1, 1]}, "
                    "\"lighting\": \"lightmap\"}], \"lightmap\": {\"texel_m\": 0.001, \"page_size\": 64}}");
    al_atlas atlas;
    al_error error = {0};
    CHECK(al_atlas_make(import, &atlas, &error) == AL_OK);
    CHECK(atlas.coarse_count == 1 && atlas.page_count == 1 && atlas.pages[0][0] <= 64 &&
          atlas.pages[0][1] <= 64 && atlas.pages[0][0] > 48);
    al_atlas_free(&atlas);
    al_import_free(import);
}

/* --- what a second UV set must keep --- */

typedef struct uv_case {
    const char *name;
    float uv1[8];     /* of two triangles, a square from (0, 0) to (1, 1): corners 0 1 2 and 0 2 3 */
    const char *says; /* "": it serves */
} uv_case;

static const uv_case uv_cases[] = {
    {"whole", {0, 0, 0, 1, 1, 1, 1, 0}, ""},
    {"mirrored", {1, 0, 1, 1, 0, 1, 0, 0}, ""},
    {"outside", {0, 0, 0, 1, 1, 1.25f, 1, 0}, "triangle 0 has a corner at (1, 1.25), outside of [0, 1]"},
    {"folded", {0, 0, 0, 1, 1, 1, 0.1f, 0.9f}, "triangles 0 and 1 overlap in the second UV set"},
    {"flat", {0, 0, 0.5f, 0.5f, 1, 1, 1, 0}, "triangle 0 has no area in the second UV set"},
    {"a point", {0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f}, "has no area in the second UV set"},
};

static const char *const square_json =
    "{\"meshes\": [{\"name\": \"floor\", \"shape\": {\"type\": \"plane\", \"width_m\": 1, \"depth_m\": 1}, "
    "\"lighting\": \"lightmap\"}], \"lightmap\": {\"texel_m\": 0.02, \"uv\": \"%s\"}}";

/* The square's uv1 as a case says: `file` refuses what does not serve, `auto` makes its own instead. */
static void test_uv_case(const uv_case *c, const char *uv)
{
    char json[1024];
    al_atlas atlas = {0};
    al_error error = {0};
    snprintf(json, sizeof json, square_json, uv);
    al_import *import = import_text(json);
    if (!import) return;
    al_mesh *mesh = &import->scene.meshes[0];
    CHECK(mesh->vertex_count == 4 && mesh->index_count == 6);
    mesh->uv1 = al_scene_array(&import->scene, 8, sizeof(float));
    const uint32_t corners[4] = {mesh->indices[0], mesh->indices[1], mesh->indices[2], mesh->indices[5]};
    for (size_t k = 0; k < 4; k++)
        memcpy(mesh->uv1 + 2 * (size_t)corners[k], c->uv1 + 2 * k, sizeof(float[2]));
    al_status status = al_atlas_make(import, &atlas, &error);
    bool file = !strcmp(uv, "file");
    if (!*c->says || !file)
        CHECK(status == AL_OK && atlas.own_count == (*c->says != 0));
    else
        check_mentions(c->name, status, &error, AL_BAD_INPUT, c->says);
    al_atlas_free(&atlas);
    al_import_free(import);
}

/* Two parts that touch but share no corner there: light would leak over. */
static void test_uv_gap(void)
{
    float positions[] = {0, 0, 0, 0, 0, 1, 1, 0, 1, 0, 1, 0, 0, 1, 1, 1, 1, 1};
    float uv1[] = {0, 0, 0, 1, 1, 1, 0.01f, 0, 1, 0.99f, 1, 0};
    uint32_t indices[] = {0, 1, 2, 3, 4, 5};
    const al_mesh mesh = {.name = "two",
                          .vertex_count = 6,
                          .index_count = 6,
                          .positions = positions,
                          .uv1 = uv1,
                          .indices = indices};
    al_error error = {0};
    check_mentions("gap", al_uv_check(&mesh, 50, 50, &error), &error, AL_BAD_INPUT,
                   "two parts of the second UV set are less than a texel of 50 x 50 apart");
    uv1[6] = 0.1f; /* five texels along each axis */
    uv1[9] = 0.9f;
    CHECK(al_uv_check(&mesh, 50, 50, &error) == AL_OK);
}

static void test_second_uv(void)
{
    char json[1024];
    al_atlas atlas;
    al_error error = {0};
    for (size_t i = 0; i < sizeof uv_cases / sizeof *uv_cases; i++) {
        test_uv_case(&uv_cases[i], "file");
        test_uv_case(&uv_cases[i], "auto");
    }
    test_uv_gap();
    snprintf(json, sizeof json, square_json, "file");
    al_import *import = import_text(json);
    check_mentions(
        "no second set", al_atlas_make(import, &atlas, &error), &error, AL_BAD_INPUT,
        "mesh \"floor\" has no second UV set, which \"uv\": \"file\" asks for; \"auto\" makes one");
    al_import_free(import);
}

/* Everything that lies at hand as triangles. */
static void test_data(void)
{
    static const char *const files[] = {"meshes/c3d_spot.obj",
                                        "meshes/cgal_cheese.off",
                                        "meshes/glmark2_bunny.obj",
                                        "meshes/cgal_armadillo.off",
                                        "meshes/cgal_elephant.off",
                                        "scenes/tim_cornell/cornell.obj",
                                        "scenes/nvpro_cornellBox/cornellBox.gltf",
                                        "scenes/sponza/atrium.obj"};
    char json[1024];
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        snprintf(json, sizeof json,
                 "{\"meshes\": [{\"name\": \"m8\", \"file\": \"%s/data/%s\", \"lighting\": \"lightmap\"}]}",
                 shared_folder(), files[i]);
        check_atlas(files[i], json,
                    0.02); /* charts that would overlap when scaled to their area are not scaled */
    }
}

int main(void)
{
    char path[1024];
    test_shapes();
    test_coarse();
    test_second_uv();
    snprintf(path, sizeof path, "%s/data", shared_folder());
    if (access(path, R_OK) == 0)
        test_data();
    else
        printf("SKIP: meshes of %s: not there\n", path);
    return test_end();
}
