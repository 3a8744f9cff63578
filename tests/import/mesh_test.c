/* Meshes of every format, shapes, transforms, materials, lights, cameras, and the check for closed surfaces.
 */
#include <math.h>

#include "files.h"
#include "import.h"

static al_import *import_text(const char *json)
{
    al_import *import = NULL;
    al_error error = {0};
    write_text("mesh_test.json", json);
    al_status status = al_import_scene("mesh_test.json", AL_QUALITY_PREVIEW, &import, &error);
    test_checks++;
    if (status) {
        test_failures++;
        fprintf(stderr, "%s\n  refused: %s\n", json, error.message);
    }
    return import;
}

static void refuse(const char *json, al_status expected, const char *parts)
{
    al_import *import = NULL;
    al_error error = {0};
    write_text("mesh_test.json", json);
    al_status status = al_import_scene("mesh_test.json", AL_QUALITY_PREVIEW, &import, &error);
    check_mentions(json, status, &error, expected, parts);
    CHECK(!status || !import);
    al_import_free(import);
}

/* --- a unit cube, [0,1]^3, in every format: 8 points, 12 triangles --- */

static const int cube_quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                     {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};

static void cube_triangle(int index, int corners[3])
{
    const int *quad = cube_quads[index / 2];
    for (int k = 0; k < 3; k++) corners[k] = quad[index % 2 ? (k + 2) % 4 : k];
}

static void write_cube_obj(const char *path, int faces)
{
    FILE *file = fopen(path, "w");
    for (int i = 0; i < 8; i++) fprintf(file, "v %d %d %d\n", i & 1, i >> 1 & 1, i >> 2);
    for (int i = 0; i < faces; i++)
        fprintf(file, "f %d %d %d %d\n", cube_quads[i][0] + 1, cube_quads[i][1] + 1, cube_quads[i][2] + 1,
                cube_quads[i][3] + 1);
    fclose(file);
}

static void write_cube_off(const char *path)
{
    FILE *file = fopen(path, "w");
    fprintf(file, "# a cube\nOFF # with comments\n\n8 6 0\n\n");
    for (int i = 0; i < 8; i++)
        fprintf(file, "%d %d %d 255 0 0 # red\n%s", i & 1, i >> 1 & 1, i >> 2, i % 3 ? "" : "\n \n");
    for (int i = 0; i < 6; i++)
        fprintf(file, "4 %d %d %d %d  0.5 0.5 0.5\n\n", cube_quads[i][0], cube_quads[i][1], cube_quads[i][2],
                cube_quads[i][3]);
    fprintf(file, "\n# the end");
    fclose(file);
}

static void write_cube_ply(const char *path)
{
    FILE *file = fopen(path, "w");
    fprintf(file,
            "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
            "element face 12\nproperty list uchar int vertex_indices\nend_header\n");
    for (int i = 0; i < 8; i++) fprintf(file, "%d %d %d\n", i & 1, i >> 1 & 1, i >> 2);
    for (int i = 0; i < 12; i++) {
        int c[3];
        cube_triangle(i, c);
        fprintf(file, "3 %d %d %d\n", c[0], c[1], c[2]);
    }
    fclose(file);
}

/* Binary STL: nothing shared, normals of 0. */
static void write_cube_stl(const char *path)
{
    unsigned char bytes[84 + 12 * 50] = "binary";
    bytes[80] = 12;
    for (int i = 0; i < 12; i++) {
        int c[3];
        float corners[9];
        cube_triangle(i, c);
        for (int k = 0; k < 3; k++)
            for (int axis = 0; axis < 3; axis++) corners[k * 3 + axis] = (float)(c[k] >> axis & 1);
        memcpy(bytes + 84 + i * 50 + 12, corners, sizeof corners);
    }
    write_bytes(path, bytes, sizeof bytes);
}

/* A glTF with corners of its own for every triangle, a node that moves and one that turns, scales and
 * mirrors. */
static void write_cube_gltf(const char *path)
{
    float corners[36 * 3];
    for (int i = 0; i < 12; i++) {
        int c[3];
        cube_triangle(i, c);
        for (int k = 0; k < 3; k++)
            for (int axis = 0; axis < 3; axis++) corners[(i * 3 + k) * 3 + axis] = (float)(c[k] >> axis & 1);
    }
    write_bytes("cube.bin", corners, sizeof corners);
    write_text(
        path,
        "{\"asset\": {\"version\": \"2.0\"}, \"scene\": 0, \"scenes\": [{\"nodes\": [0, 2, 3, 4]}],\n"
        "\"extensionsUsed\": [\"KHR_lights_punctual\", \"KHR_materials_volume\", \"KHR_materials_ior\", "
        "\"KHR_materials_emissive_strength\"],\n"
        "\"nodes\": [{\"name\": \"moved\", \"translation\": [10, 0, 0], \"children\": [1]},\n"
        " {\"name\": \"box\", \"mesh\": 0, \"scale\": [2, 3, -4]},\n"
        " {\"name\": \"lamp\", \"translation\": [1, 2, 3], \"extensions\": {\"KHR_lights_punctual\": "
        "{\"light\": 0}}},\n"
        " {\"name\": \"eye\", \"camera\": 0, \"translation\": [0, 0, 5]},\n"
        " {\"name\": \"sun\", \"rotation\": [-0.70710678, 0, 0, 0.70710678], \"extensions\": "
        "{\"KHR_lights_punctual\": {\"light\": 1}}}],\n"
        "\"extensions\": {\"KHR_lights_punctual\": {\"lights\": [{\"type\": \"point\", \"intensity\": 7, "
        "\"color\": [1, 0.5, 0.25]}, {\"type\": \"directional\", \"intensity\": 3}]}},\n"
        "\"cameras\": [{\"type\": \"perspective\", \"perspective\": {\"yfov\": 0.7, \"aspectRatio\": 1.5, "
        "\"znear\": 0.1}}],\n"
        "\"materials\": [{\"name\": \"glass\", \"doubleSided\": true, \"emissiveFactor\": [1, 0.5, 0], "
        "\"pbrMetallicRoughness\": {\"baseColorFactor\": [0.1, 0.2, 0.3, 1], \"metallicFactor\": 0.25, "
        "\"roughnessFactor\": 0.75},\n"
        " \"extensions\": {\"KHR_materials_volume\": {\"attenuationColor\": [0.5, 0.25, 1], "
        "\"attenuationDistance\": 2, \"thicknessFactor\": 1}, \"KHR_materials_ior\": {\"ior\": 1.3}, "
        "\"KHR_materials_emissive_strength\": {\"emissiveStrength\": 8}}}],\n"
        "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0}, \"material\": 0}]}],\n"
        "\"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 36, \"type\": \"VEC3\", "
        "\"min\": [0, 0, 0], \"max\": [1, 1, 1]}],\n"
        "\"bufferViews\": [{\"buffer\": 0, \"byteLength\": 432}],\n"
        "\"buffers\": [{\"byteLength\": 432, \"uri\": \"cube.bin\"}]}\n");
}

static void check_cube(const char *mesh, double volume, double tolerance)
{
    char json[1024];
    al_triangles boundary;
    al_error error;
    snprintf(json, sizeof json,
             "{\"meshes\": [{\"name\": \"a\", %s}], \"media\": [{\"name\": \"m\", \"sigma_s_per_m\": 1}], "
             "\"translucents\": [{\"mesh\": \"a\", \"medium\": \"m\"}]}",
             mesh);
    al_import *import = import_text(json);
    if (!import) return;
    CHECK(al_import_boundary(import, 0, &boundary, &error) == AL_OK);
    CHECK(boundary.vertex_count == 8 && boundary.triangle_count == 12);
    CHECK_NEAR(al_triangles_volume(&boundary), volume, tolerance * volume);
    CHECK(al_triangles_check("cube", &boundary, &error) == AL_OK);
    al_triangles_free(&boundary);
    CHECK(al_import_blockers(import, 0, &boundary, &error) == AL_OK);
    CHECK(boundary.triangle_count == 0);
    al_triangles_free(&boundary);
    const al_mesh *made = &import->scene.meshes[0];
    CHECK(made->vertex_count == 24); /* 90 degrees are above the crease: three normals at each point */
    for (uint32_t i = 0; i < made->index_count; i++) { /* every normal stands on its triangle's edges */
        const uint32_t here = made->indices[i] * 3, next = made->indices[i % 3 == 2 ? i - 2 : i + 1] * 3;
        double along = 0, edge = 0, unit = 0;
        for (int k = 0; k < 3; k++) {
            double step = (double)made->positions[next + k] - made->positions[here + k];
            along += step * made->normals[here + k];
            edge += step * step;
            unit += made->normals[here + k] * made->normals[here + k];
        }
        CHECK_NEAR(along, 0, 1e-6 * sqrt(edge));
        CHECK_NEAR(unit, 1, 1e-6);
    }
    al_import_free(import);
}

static void test_formats(void)
{
    write_cube_obj("cube.obj", 6);
    write_cube_off("cube.off");
    write_cube_ply("cube.ply");
    write_cube_stl("cube.stl");
    write_cube_gltf("cube.gltf");
    check_cube("\"file\": \"cube.obj\"", 1, 0);
    check_cube("\"file\": \"cube.off\"", 1, 0);
    check_cube("\"file\": \"cube.ply\"", 1, 0);
    check_cube("\"file\": \"cube.stl\"", 1, 0);
    check_cube("\"file\": \"cube.gltf\"", 24, 1e-6); /* mirrored by its node: still outwards */
    check_cube("\"file\": \"cube.gltf\", \"node\": \"box\"", 24, 1e-6);
    check_cube("\"shape\": {\"type\": \"box\", \"size_m\": [1, 2, 3]}", 6, 1e-6);
    /* rounding of float positions: three factors, half a unit in the last place each, and cancellation of the
     * offset of 10 units: 1e-5 covers it */
    check_cube("\"file\": \"cube.obj\", \"unit_m\": 0.01, \"transform\": {\"scale\": [1, -2, 3], "
               "\"rotate_degrees\": [10, 20, 30], \"translate_m\": [1, 2, 3]}",
               6e-6, 1e-5);
}

/* Translucent objects are rigid, blockers share their space, others keep even transforms. */
static void test_spaces(void)
{
    al_import *import = import_text(
        "{\"meshes\": [{\"name\": \"outer\", \"file\": \"cube.obj\", \"transform\": {\"scale\": 4, "
        "\"rotate_degrees\": [0, 90, 0], \"translate_m\": [10, 0, 0]}},\n"
        " {\"name\": \"inner\", \"file\": \"cube.ply\", \"transform\": {\"translate_m\": [11, 1, -2]}},\n"
        " {\"name\": \"even\", \"file\": \"cube.stl\", \"transform\": {\"scale\": 2, \"translate_m\": [0, 5, "
        "0]}},\n"
        " {\"name\": \"squeezed\", \"file\": \"cube.stl\", \"transform\": {\"scale\": [1, 2, 1]}},\n"
        " {\"name\": \"unseen\", \"file\": \"cube.stl\", \"hidden\": true}],\n"
        "\"media\": [{\"name\": \"m\", \"sigma_s_per_m\": 1}],\n"
        "\"translucents\": [{\"name\": \"t\", \"mesh\": \"outer\", \"medium\": \"m\", \"blockers\": "
        "[\"inner\"]}]}");
    if (!import) return;
    const al_scene *scene = &import->scene;
    al_triangles boundary, blockers;
    al_error error;
    CHECK(scene->instance_count == 4);
    CHECK(scene->translucents[0].instance == 0 && scene->instances[0].role == AL_ROLE_TRANSLUCENT);
    CHECK(scene->instances[1].role == AL_ROLE_BLOCKER && scene->instances[1].translucent == 0);
    CHECK(memcmp(scene->instances[0].world, scene->instances[1].world, sizeof scene->instances[0].world) ==
          0);
    CHECK_NEAR(scene->instances[0].world[2], -1, 1e-7); /* x turns to -z */
    CHECK_NEAR(scene->instances[0].world[12], 10, 0);
    CHECK(al_import_boundary(import, 0, &boundary, &error) == AL_OK);
    CHECK(al_import_blockers(import, 0, &blockers, &error) == AL_OK);
    CHECK_NEAR(al_triangles_volume(&boundary), 64, 1e-4);
    CHECK_NEAR(al_triangles_volume(&blockers), 1, 1e-5);
    /* world (11, 1, -2) is 1, 1, -2 from the boundary's origin; turned back: x = -z, z = x */
    double low[3] = {1e9, 1e9, 1e9};
    for (uint32_t i = 0; i < blockers.vertex_count * 3; i++)
        low[i % 3] = fmin(low[i % 3], blockers.positions[i]);
    CHECK_NEAR(low[0], 1, 1e-6);
    CHECK_NEAR(low[1], 1, 1e-6);
    CHECK_NEAR(low[2], 1, 1e-6);
    al_triangles_free(&boundary);
    al_triangles_free(&blockers);
    CHECK_NEAR(scene->instances[2].world[0], 2, 1e-6);
    CHECK_NEAR(scene->instances[2].world[13], 5, 0);
    CHECK_NEAR(scene->instances[3].world[5], 1, 0);
    al_import_free(import);
}

static void check_material(const al_material *m)
{
    const float base[3] = {0.1f, 0.2f, 0.3f}, emission[3] = {8, 4, 0};
    for (int i = 0; i < 3; i++) {
        CHECK_NEAR(m->base_color[i], base[i], 1e-7);
        CHECK_NEAR(m->emission_w_m2_sr[i], emission[i], 1e-6);
    }
    CHECK(strcmp(m->name, "glass") == 0 && m->double_sided);
    CHECK_NEAR(m->metallic, 0.25, 0);
    CHECK_NEAR(m->roughness, 0.75, 0);
    CHECK_NEAR(m->ior, 1.3, 1e-7);
    CHECK(m->base_color_texture == AL_NO_INDEX && m->normal_texture == AL_NO_INDEX);
}

static void test_gltf(void)
{
    al_import *import = import_text(
        "{\"meshes\": [{\"name\": \"a\", \"file\": \"cube.gltf\", \"unit_m\": 0.5, \"transform\": "
        "{\"translate_m\": [0, 0, 1]}}], \"media\": [{\"name\": \"m\", \"sigma_s_per_m\": 2, "
        "\"absorption_from\": "
        "{\"mesh\": \"a\", \"material\": \"glass\"}}]}");
    if (!import) return;
    const al_scene *s = &import->scene;
    CHECK(s->light_count == 2 && s->camera_count == 1 && s->instance_count == 1 && s->material_count == 1);
    check_material(&s->materials[0]);
    CHECK(s->lights[0].type == AL_LIGHT_POINT && s->lights[1].type == AL_LIGHT_DIRECTIONAL);
    const float at[3] = {0.5f, 1, 2.5f}, intensity[3] = {7, 3.5f, 1.75f}, down[3] = {0, -1, 0};
    for (int i = 0; i < 3; i++) {
        CHECK_NEAR(s->lights[0].vector[i], at[i], 1e-6);
        CHECK_NEAR(s->lights[0].intensity[i], intensity[i], 1e-6);
        CHECK_NEAR(s->lights[1].vector[i], down[i], 1e-6); /* -z turned by -90 degrees about x */
        CHECK_NEAR(s->lights[1].intensity[i], 3, 1e-6);
    }
    CHECK_NEAR(s->cameras[0].fov_y_radians, 0.7, 1e-7);
    CHECK_NEAR(s->cameras[0].position[2], 3.5, 1e-6);
    CHECK(s->cameras[0].target[2] < 3.5f && fabsf(s->cameras[0].target[0]) < 1e-6f);
    /* -ln(colour) / distance; 2 units are 1 m */
    CHECK_NEAR(s->media[0].sigma_a_per_m[0], log(2), 1e-6);
    CHECK_NEAR(s->media[0].sigma_a_per_m[1], log(4), 1e-6);
    CHECK_NEAR(s->media[0].sigma_a_per_m[2], 0, 0);
    /* the node's box in metres: [5, 6] x [0, 1.5] x [1 - 2, 1], its shear-free uneven scale in the vertices
     */
    double low[3] = {1e9, 1e9, 1e9}, high[3] = {-1e9, -1e9, -1e9};
    for (uint32_t i = 0; i < s->meshes[0].vertex_count * 3; i++) {
        double x = s->meshes[0].positions[i] + s->instances[0].world[12 + i % 3];
        low[i % 3] = fmin(low[i % 3], x);
        high[i % 3] = fmax(high[i % 3], x);
    }
    const double expected[6] = {5, 0, -1, 6, 1.5, 1};
    for (int i = 0; i < 3; i++) {
        CHECK_NEAR(low[i], expected[i], 1e-6);
        CHECK_NEAR(high[i], expected[i + 3], 1e-6);
    }
    CHECK(import->input_count == 3); /* scene, .gltf, .bin */
    al_import_free(import);

    import =
        import_text("{\"meshes\": [{\"name\": \"a\", \"file\": \"cube.gltf\", \"import_lights\": false, "
                    "\"import_cameras\": false}], \"materials\": [{\"name\": \"glass\", \"metallic\": 1}]}");
    if (!import) return;
    CHECK(import->scene.light_count == 0 && import->scene.material_count == 1);
    CHECK(import->scene.materials[0].metallic == 1 && import->scene.meshes[0].submeshes[0].material == 0);
    CHECK(import->scene.camera_count == 1 && strcmp(import->scene.cameras[0].name, "default") == 0);
    al_import_free(import);
}

/* A PNG of 2 x 1 pixels, red and green: https://www.w3.org/TR/png/ */
static const unsigned char png[] = {
    0x89, 'P',  'N', 'G', 0x0d, 0x0a, 0x1a, 0x0a, 0,    0,    0,    13,   'I',  'H',  'D',  'R',  0,    0,
    0,    2,    0,   0,   0,    1,    8,    2,    0,    0,    0,    0x7b, 0x40, 0xe8, 0xdd, 0,    0,    0,
    15,   'I',  'D', 'A', 'T',  0x78, 0x9c, 0x63, 0xf8, 0xcf, 0xc0, 0xc0, 0xf0, 0x9f, 0x01, 0x00, 0x07, 0xff,
    0x01, 0xff, 0,   0,   0,    0,    0,    0,    0,    0,    'I',  'E',  'N',  'D',  0xae, 0x42, 0x60, 0x82};

static void test_obj_materials(void)
{
    write_bytes("two.png", png, sizeof png);
    write_text("quad.mtl", "newmtl dull\nKd 0.5 0.25 0.125\nKe 3 2 1\nmap_Kd two.png\n"
                           "newmtl shiny\nKd 1 1 1\nKs 0.5 0.5 0.5\nNs 30\nNi 1.4\n"
                           "newmtl measured\nKd 0 0 0\nKs 1 1 1\nPr 0.3\nPm 0.6\n");
    write_text("quad.obj",
               "mtllib quad.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
               "usemtl dull\nf 1/1 2/2 3/3\nusemtl shiny\nf 1 3 4\nusemtl measured\nf 1 4 3\n");
    al_import *import = import_text("{\"meshes\": [{\"name\": \"a\", \"file\": \"quad.obj\"}]}");
    if (!import) return;
    const al_scene *s = &import->scene;
    const al_material *dull = NULL, *shiny = NULL, *measured = NULL;
    for (uint32_t i = 0; i < s->material_count; i++) {
        if (strcmp(s->materials[i].name, "dull") == 0) dull = &s->materials[i];
        if (strcmp(s->materials[i].name, "shiny") == 0) shiny = &s->materials[i];
        if (strcmp(s->materials[i].name, "measured") == 0) measured = &s->materials[i];
    }
    CHECK(dull && shiny && measured && s->material_count == 3);
    if (dull && shiny && measured) {
        CHECK(dull->base_color[1] == 0.25f && dull->emission_w_m2_sr[0] == 3 && dull->ior == 1);
        CHECK(dull->base_color_texture == 0 && s->texture_count == 1);
        CHECK_NEAR(shiny->roughness, 0.5, 1e-6); /* (2/32)^(1/4) */
        CHECK_NEAR(shiny->ior, 1.4, 1e-6);
        CHECK_NEAR(measured->roughness, 0.3, 1e-6);
        CHECK_NEAR(measured->metallic, 0.6, 1e-6);
        CHECK_NEAR(measured->ior, 1.5, 0);
    }
    if (s->texture_count) {
        const al_texture *t = &s->textures[0];
        const unsigned char expected[8] = {255, 0, 0, 255, 0, 255, 0, 255};
        CHECK(t->width == 2 && t->height == 1 && t->srgb && memcmp(t->pixels, expected, 8) == 0);
    }
    const al_mesh *mesh = &s->meshes[0];
    CHECK(s->mesh_count == 1 && mesh->submesh_count == 3 && mesh->uv0);
    for (uint32_t i = 0; i < 3; i++) { /* obj counts v upwards, textures here downwards */
        uint32_t v = mesh->indices[mesh->submeshes[0].first_index + i];
        CHECK(s->materials[mesh->submeshes[0].material].base_color_texture == 0);
        CHECK_NEAR(mesh->uv0[v * 2 + 1], 1 - mesh->positions[v * 3 + 1], 0);
    }
    CHECK(import->input_count == 4); /* scene, obj, mtl, png */
    al_import_free(import);
}

static void test_shapes(void)
{
    al_import *import = import_text(
        "{\"meshes\": [{\"name\": \"ball\", \"shape\": {\"type\": \"sphere\", \"radius_m\": 2, "
        "\"subdivisions\": 4}},\n"
        "{\"name\": \"ring\", \"shape\": {\"type\": \"torus\", \"major_radius_m\": 1, \"minor_radius_m\": "
        "0.25, "
        "\"major_segments\": 64, \"minor_segments\": 32}},\n"
        "{\"name\": \"ground\", \"shape\": {\"type\": \"plane\", \"width_m\": 4, \"depth_m\": 2}}]}");
    if (!import) return;
    const al_scene *s = &import->scene;
    al_triangles t;
    al_error error;
    CHECK(s->mesh_count == 3 && s->meshes[0].index_count == 3 * 20 * 256);
    CHECK(al_triangles_from_mesh(&s->meshes[0], &t, &error) == AL_OK);
    CHECK(al_triangles_check("ball", &t, &error) == AL_OK);
    /* A triangle of circumradius rho lies rho^2/(4 R) below the sphere on average, to first order, so the
     * volume lacks 3 rho^2/(4 R^2). Neighbours of the icosahedron are 1.107 apart, halved four times, so a
     * mean edge is about 0.0692 R and rho = edge/sqrt 3 = 0.04 R: 0.12 %; projecting stretches edges by up
     * to 1.2: 0.2 %. */
    double ball = 4.0 / 3 * 3.14159265358979 * 8;
    CHECK(al_triangles_volume(&t) < ball && al_triangles_volume(&t) > ball * (1 - 0.0025));
    for (uint32_t i = 0; i < t.vertex_count * 3; i += 3)
        CHECK_NEAR(sqrt(t.positions[i] * t.positions[i] + t.positions[i + 1] * t.positions[i + 1] +
                        t.positions[i + 2] * t.positions[i + 2]),
                   2, 3e-7);
    al_triangles_free(&t);
    CHECK(al_triangles_from_mesh(&s->meshes[1], &t, &error) == AL_OK);
    CHECK(al_triangles_check("ring", &t, &error) == AL_OK);
    /* 2 pi^2 R r^2; polygons of n corners enclose sin(2 pi/n)/(2 pi/n) of their circle: 0.64 % and 0.16 %
     * less, and the ring's chords shorten it again by about half of that */
    CHECK_NEAR(al_triangles_volume(&t), 2 * 9.8696044 * 0.0625, 0.012 * 2 * 9.8696044 * 0.0625);
    al_triangles_free(&t);
    CHECK(al_triangles_from_mesh(&s->meshes[2], &t, &error) == AL_OK);
    CHECK(al_triangles_check("ground", &t, &error) == AL_BAD_INPUT);
    al_triangles_free(&t);
    CHECK(s->meshes[2].normals[1] == 1 && s->meshes[2].vertex_count == 4);
    al_import_free(import);
}

/* The default camera sees all eight corners of the scene's box. */
static void test_default_camera(void)
{
    al_import *import =
        import_text("{\"meshes\": [{\"name\": \"a\", \"file\": \"cube.obj\", \"unit_m\": 100}]}");
    if (!import) return;
    const al_camera *c = &import->scene.cameras[0];
    float forward[3], length = 0;
    for (int i = 0; i < 3; i++) {
        forward[i] = c->target[i] - c->position[i];
        length += forward[i] * forward[i];
    }
    for (int corner = 0; corner < 8; corner++) {
        float along = 0, square = 0;
        for (int i = 0; i < 3; i++) {
            float d = 100.0f * (float)(corner >> i & 1) - c->position[i];
            along += d * forward[i] / sqrtf(length);
            square += d * d;
        }
        CHECK(along > 0 && acosf(along / sqrtf(square)) <= c->fov_y_radians / 2);
    }
    al_import_free(import);
}

#define OBJECT(mesh) \
    "{\"meshes\": [{\"name\": \"a\", " mesh "}], \"media\": [{\"name\": \"m\", \"sigma_s_per_m\": 1}], " \
    "\"translucents\": [{\"mesh\": \"a\", \"medium\": \"m\"}]}"

static void test_refusals(void)
{
    write_cube_obj("open.obj", 5);
    write_text("empty.obj", "");
    write_text("points.obj", "v 0 0 0\n");
    write_text("inverted.off", "OFF 4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 3 1\n3 0 2 3\n3 1 3 2\n");
    write_text("twisted.off", "OFF 4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 1 3\n3 0 3 2\n3 1 2 3\n");
    write_text("nan.off", "OFF 4 4 0\n0 0 0\n1 0 0\n0 nan 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n");
    write_text("inf.stl",
               "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1e39 0 0\nvertex 0 1 0\n"
               "endloop\nendfacet\nendsolid a\n");
    write_text("short.off", "OFF\n4 4 0\n0 0 0\n1 0 0\n");
    write_text("index.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n");
    write_text("junk.ply", "this is no ply file\n");
    write_text("junk.gltf", "{\"asset\": ");
    write_text(
        "spot.gltf",
        "{\"asset\": {\"version\": \"2.0\"}, \"scene\": 0, \"scenes\": [{\"nodes\": [0]}], \"nodes\": "
        "[{\"name\": \"s\", \"extensions\": {\"KHR_lights_punctual\": {\"light\": 0}}}], \"extensionsUsed\": "
        "[\"KHR_lights_punctual\"], \"extensions\": {\"KHR_lights_punctual\": {\"lights\": [{\"type\": "
        "\"spot\", "
        "\"intensity\": 1, \"spot\": {}}]}}}");
    write_text("badpng.mtl", "newmtl m\nmap_Kd junk.ply\n");
    write_text("badpng.obj", "mtllib badpng.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    write_text("nopng.mtl", "newmtl m\nmap_Kd none.png\n");
    write_text("nopng.obj", "mtllib nopng.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    refuse(OBJECT("\"file\": \"open.obj\""), AL_BAD_INPUT,
           "mesh_test.json:1: mesh \"a\" (open.obj): 4 open edges, the first between (1, 1, 0) and (1, 0, "
           "0)|closed");
    refuse(OBJECT("\"file\": \"inverted.off\""), AL_BAD_INPUT,
           "(inverted.off): encloses -0.1667 m3: it is inside out");
    refuse(OBJECT("\"file\": \"twisted.off\""), AL_BAD_INPUT,
           "(twisted.off): 3 edges whose two triangles face opposite");
    refuse(OBJECT("\"file\": \"nan.off\""), AL_BAD_INPUT,
           "(nan.off): line 4: vertex 2 has the coordinate nan");
    refuse(OBJECT("\"file\": \"inf.stl\""), AL_BAD_INPUT,
           "(inf.stl): vertex 1 of|inf|finite numbers are right");
    refuse(OBJECT("\"file\": \"short.off\""), AL_BAD_INPUT,
           "(short.off): line 5: the file ends within the vertices");
    refuse(OBJECT("\"file\": \"index.off\""), AL_BAD_INPUT,
           "(index.off): line 6: corners that are numbers of vertices");
    refuse(OBJECT("\"file\": \"empty.obj\""), AL_BAD_INPUT, "mesh \"a\" (empty.obj): the file is empty");
    refuse(OBJECT("\"file\": \"points.obj\""), AL_BAD_INPUT, "mesh \"a\" (points.obj):");
    refuse(OBJECT("\"file\": \"none.obj\""), AL_BAD_INPUT,
           "none.obj: cannot open: No such file or directory");
    refuse(OBJECT("\"file\": \".\""), AL_BAD_INPUT, "mesh \"a\" (.): unknown kind of mesh file");
    refuse(OBJECT("\"file\": \"junk.ply\""), AL_BAD_INPUT, "mesh \"a\" (junk.ply): cannot be read as a mesh");
    refuse(OBJECT("\"file\": \"junk.gltf\""), AL_BAD_INPUT, "mesh \"a\" (junk.gltf): is not valid glTF 2.0");
    refuse(OBJECT("\"file\": \"cube.txt\""), AL_BAD_INPUT,
           "(cube.txt): unknown kind of mesh file; .gltf, .glb");
    refuse(OBJECT("\"file\": \"cube.gltf\", \"node\": \"nobody\""), AL_BAD_INPUT,
           "no node is named \"nobody\"");
    refuse(OBJECT("\"shape\": {\"type\": \"plane\"}"), AL_BAD_INPUT, "mesh \"a\": 4 open edges");
    refuse("{\"meshes\": [{\"name\": \"a\", \"file\": \"spot.gltf\"}]}", AL_BAD_INPUT,
           "light \"s\" is neither point nor directional|\"import_lights\": false");
    refuse("{\"meshes\": [{\"name\": \"a\", \"file\": \"badpng.obj\"}]}", AL_BAD_INPUT,
           "junk.ply: cannot be read as a picture");
    refuse("{\"meshes\": [{\"name\": \"a\", \"file\": \"nopng.obj\"}]}", AL_BAD_INPUT,
           "none.png: cannot open: No such file");
    refuse("{\"meshes\": [{\"name\": \"a\", \"file\": \"cube.gltf\"}], \"media\": [{\"name\": \"m\", "
           "\"absorption_from\": "
           "{\"mesh\": \"a\", \"material\": \"steel\"}}]}",
           AL_BAD_INPUT, "no material is named \"steel\"");
    refuse("{\"meshes\": [{\"name\": \"a\", \"file\": \"cube.off\"}], \"media\": [{\"name\": \"m\", "
           "\"absorption_from\": "
           "{\"mesh\": \"a\", \"material\": \"glass\"}}]}",
           AL_BAD_INPUT, "no material is named \"glass\"");
    write_text(
        "far.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "1e38 0 0\n0 1e38 0\n0 0 1\n3 0 1 2\n");
    refuse(
        "{\"meshes\": [{\"name\": \"a\", \"file\": \"far.ply\", \"transform\": {\"scale\": [100, 1, 1]}}]}",
        AL_BAD_INPUT, "mesh \"a\" (far.ply): its transforms lead beyond all numbers");
}

/* Two tetrahedra that share one edge: four triangles meet there. */
static void test_check(void)
{
    double positions[] = {0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 1, 0, -1, 0, 0, 0, -1, 0};
    uint32_t indices[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3, 0, 4, 1, 0, 1, 5, 0, 5, 4, 1, 4, 5};
    al_triangles mesh = {6, 8, positions, indices};
    al_error error = {0};
    check_refusal("shared edge", al_triangles_check("two", &mesh, &error), &error, AL_BAD_INPUT,
                  "two: 1 edge with more than two triangles, the first between (0, 0, 0) and (0, 0, 1); two "
                  "triangles at "
                  "every edge are right");
    mesh.triangle_count = 4;
    CHECK(al_triangles_check("one", &mesh, &error) == AL_OK);
    CHECK_NEAR(al_triangles_volume(&mesh), 1.0 / 6, 1e-15);
    mesh.triangle_count = 0;
    check_refusal("empty", al_triangles_check("none", &mesh, &error), &error, AL_BAD_INPUT,
                  "none: has no triangles; a closed surface is right");
    mesh.triangle_count = 4;
    positions[7] = NAN;
    check_refusal("nan", al_triangles_check("one", &mesh, &error), &error, AL_BAD_INPUT,
                  "one: vertex 2 has the coordinate nan; finite numbers are right");
    /* a point on an edge, with a triangle without area: still closed */
    double line[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0.5, 0, 0};
    uint32_t sliver[] = {0, 2, 1, 0, 4, 3, 4, 1, 3, 0, 1, 4, 0, 3, 2, 1, 2, 3};
    al_triangles closed = {5, 6, line, sliver};
    CHECK(al_triangles_check("sliver", &closed, &error) == AL_OK);
}

int main(void)
{
    test_formats();
    test_spaces();
    test_gltf();
    test_obj_materials();
    test_shapes();
    test_default_camera();
    test_refusals();
    test_check();
    return test_end();
}
