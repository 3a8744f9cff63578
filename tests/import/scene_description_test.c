/* The JSON scene file: what is read, what is refused and how that is said, and that the schema agrees. */
#include <jansson.h>
#include <sys/stat.h>

#include "airlight/scene_description.h"
#include "files.h"

static const char *const path = "description_test.json";

static al_status read_scene(const char *text, al_scene_description **scene, al_error *error)
{
    write_text(path, text);
    return al_scene_description_read(path, AL_QUALITY_MEDIUM, scene, error);
}

/* `message` follows "description_test.json:". */
static void refuse(const char *text, const char *message)
{
    al_scene_description *scene;
    al_error error = {0};
    char whole[AL_ERROR_SIZE];
    al_status status = read_scene(text, &scene, &error);
    snprintf(whole, sizeof whole, "%s:%s", path, message);
    check_refusal(text, status, &error, AL_BAD_INPUT, whole);
    CHECK(status ? scene == NULL : 1);
    if (!status) al_scene_description_free(scene);
}

static void test_lighting_refusals(void)
{
    refuse("{\"fogs\": [\"haze\"]}", "1: fogs: no medium is named \"haze\"; name one of \"media\"");
    refuse("{\"media\": [{\"name\": \"haze\", \"sigma_s_per_m\": 1}],\n \"fogs\": [\"haze\", \"haze\"]}",
           "2: fogs: \"haze\" stands there twice; once is right");
    refuse("{\"media\": [{\"name\": \"haze\", \"sigma_s_per_m\": 1, \"density\": {\"type\": \"layers\", "
           "\"period_m\": 1, "
           "\"thickness_m\": 0.5}}], \"fogs\": [\"haze\"]}",
           "1: fogs: the layers of \"haze\" have no end; give its density bounds");
    refuse("{\"meshes\": [{\"name\": \"a\", \"file\": \"a.obj\", \"lighting\": \"probes\"}]}",
           "1: meshes[0]: is lit by probes; the scene needs \"probes\" for that");
    refuse("{\"meshes\": [{\"name\": \"a\", \"file\": \"a.obj\", \"lighting\": \"lightmap\"}],\n"
           "\"media\": [{\"name\": \"wax\", \"sigma_s_per_m\": 1}], \"translucents\": [{\"name\": \"t\", "
           "\"mesh\": \"a\", "
           "\"medium\": \"wax\"}]}",
           "1: meshes[0]: is part of translucent \"t\", which no lightmap or probe lights");
    refuse("{\"lightmap\": {\"walls\": \"thick\"}}",
           "1: lightmap.walls: is \"thick\"; one of published|bounded|traced is right");
    refuse("{\"lightmap\": {\"back_scatter_shift_m\": 1}}",
           "1: lightmap: back_scatter_shift_m needs \"back_scatter\": true");
    refuse("{\"probes\": {\"spacing_m\": 1, \"points\": [{\"position_m\": [0, 0, 0]}]}}",
           "1: probes: spacing_m and points exclude each other: points are the probes' places");
}

static void test_refusals(void)
{
    refuse("", "1: not valid JSON: '[' or '{' expected near end of file");
    refuse("{\n  \"meshes\": [,]\n}", "2: not valid JSON: unexpected token near ','");
    refuse("{\"unit_m\": 1e999}", "1: not valid JSON: real number overflow near '1e999'");
    refuse("{\"unit_m\": NaN}", "1: not valid JSON: invalid token near 'NaN'");
    refuse("{\"unit_m\": 1,\n \"unit_m\": 2}", "2: not valid JSON: duplicate object key near '\"unit_m\"'");
    refuse("[]", "1: the scene: is not an object; {...} is right");
    refuse("{\n\n  \"colour\": 1}",
           "3: colour: unknown key; known here: $schema, comment, unit_m, meshes, materials, "
           "lights, environment, cameras, media, translucents, fogs, lightmap, probes, bake, play");
    refuse("{\"a\\nb\": 1}",
           "1: a b: unknown key; known here: $schema, comment, unit_m, meshes, materials, "
           "lights, environment, cameras, media, translucents, fogs, lightmap, probes, bake, play");
    refuse("{\"unit_m\": 0}", "1: unit_m: is 0; a number from 1e-09 to 1000000000 is right");
    refuse("{\"unit_m\": -1}", "1: unit_m: is -1; a number from 1e-09 to 1000000000 is right");
    refuse("{\"unit_m\": \"1\"}", "1: unit_m: is \"1\"; a number from 1e-09 to 1000000000 is right");
    refuse("{\"meshes\": {}}", "1: meshes: is {}; a list [...] of objects is right");
    refuse("{\"meshes\": [7]}", "1: meshes[0]: is not an object; {...} is right");
    refuse("{\"meshes\": [\n {\"name\": \"a\", \"file\": \"a.obj\"},\n {\"file\": \"b.obj\"}]}",
           "3: meshes[1]: \"name\" is missing");
    refuse(
        "{\"meshes\": [\n {\"name\": \"a\", \"file\": \"a.obj\"},\n {\"name\": \"a\", \"file\": \"b.obj\"}]}",
        "3: meshes[1]: the name \"a\" is taken by element 0; names must differ");
    refuse("{\"meshes\": [{\"name\": \"a\"}]}",
           "1: meshes[0]: has neither \"file\" nor \"shape\"; give either \"file\" or \"shape\"");
    refuse("{\"meshes\": [{\"name\": \"\", \"file\": \"a\"}]}",
           "1: meshes[0].name: is \"\"; a text is right");
    refuse("{\"meshes\": [{\"name\": \"a\\nb\", \"file\": \"a\"}]}",
           "1: meshes[0].name: is \"a\\nb\"; a text is right");
    refuse("{\"meshes\": [{\"name\": \"a\", \"file\": \"a.obj\", \"hidden\": 1}]}",
           "1: meshes[0].hidden: is 1; true or false is right");
    refuse("{\"meshes\": [{\"name\": \"a\", \"file\": \"a.obj\", \"material\": \"m\"}]}",
           "1: meshes[0]: no material is named \"m\"; name one of \"materials\"");
    refuse(
        "{\"meshes\": [{\"name\": \"a\", \"file\": \"a.obj\",\n \"transform\": {\"scale\":\n [1, 0, 1]}}]}",
        "2: meshes[0].transform: squeezes space flat (determinant 0); every scale must differ from 0");
    refuse("{\"meshes\": [{\"name\": \"a\", \"file\": \"a.obj\", \"transform\": {\"matrix\": [1, 2]}}]}",
           "1: meshes[0].transform.matrix: is [1, 2]; a list of 16 numbers from -1000000000 to 1000000000 is "
           "right");
    refuse("{\"meshes\": [{\"name\": \"a\", \"file\": \"a.obj\", \"transform\": "
           "{\"matrix\": [1,0,0,5, 0,1,0,0, 0,0,1,0, 0,0,0,1]}}]}",
           "1: meshes[0].transform: matrix is projective or not column-major; elements 4, 8, 12 must be 0 "
           "and element "
           "16 must be 1");
    refuse("{\"meshes\": [{\"name\": \"a\", \"shape\": {\"type\": \"cone\"}}]}",
           "1: meshes[0].shape.type: is \"cone\"; one of sphere|box|plane|torus is right");
    refuse("{\"meshes\": [{\"name\": \"a\", \"shape\": {\"type\": \"box\", \"radius_m\": 1}}]}",
           "1: meshes[0].shape: \"radius_m\" does not go with \"box\"; these do: type|size_m");
    refuse("{\"meshes\": [{\"name\": \"a\", \"unit_m\": 2, \"shape\": {\"type\": \"box\"}}]}",
           "1: meshes[0]: \"unit_m\" does not go with \"shape\"; these do: "
           "name|shape|transform|material|lighting|hidden|motion");
    refuse("{\"meshes\": [{\"name\": \"a\", \"shape\": {\"type\": \"torus\", \"minor_radius_m\": 0.5}}]}",
           "1: meshes[0].shape: minor_radius_m 0.5 is not below major_radius_m 0.35; the torus would run "
           "into itself");
    refuse("{\"materials\": [{\"name\": \"m\",\n \"base_color\": [0.5, 0.5, 1.5]}]}",
           "2: materials[0].base_color: is [0.5, 0.5, 1.5]; a number or a list of 3 numbers from 0 to 1 is "
           "right");
    refuse("{\"lights\": [{\"type\": \"spot\"}]}",
           "1: lights[0].type: is \"spot\"; one of directional|point is right");
    refuse("{\"lights\": [{\"type\": \"point\", \"position_m\": [0, 0, 0]}]}",
           "1: lights[0]: \"intensity_w_sr\" is missing; \"point\" needs it");
    refuse("{\"lights\": [{\"type\": \"directional\", \"direction\": [0, 0, 0], \"irradiance_w_m2\": 1}]}",
           "1: lights[0]: direction has no length; the way the light travels is right");
    refuse("{\"lights\": [{\"type\": \"point\", \"position_m\": [0, 0], \"intensity_w_sr\": 1}]}",
           "1: lights[0].position_m: is [0, 0]; a list of 3 numbers from -1000000000 to 1000000000 is right");
    refuse("{\"lights\": [{\"type\": \"point\", \"position_m\": [0, 0, 0],\n\n\n \"intensity_w_sr\": -1}]}",
           "4: lights[0].intensity_w_sr: is -1; a number or a list of 3 numbers from 0 to 1e+12 is right");
    refuse("{\"cameras\": [{\"position_m\": [1, 1, 1], \"target_m\": [1, 1, 1]}]}",
           "1: cameras[0]: position_m and target_m are the same point");
    refuse("{\"cameras\": [{\"position_m\": [0, 1, 0], \"target_m\": [0, 0, 0]}]}",
           "1: cameras[0]: looks along its own up; choose another \"up\", such as [0, 0, -1]");
    refuse("{\"environment\": {}}", "1: environment: give either \"file\" or \"radiance_w_m2_sr\"");
    refuse("{\"media\": [{\"name\": \"m\"}]}",
           "1: media[0]: has no coefficients; give either sigma_s_per_m and "
           "sigma_a_per_m, or albedo and mean_free_path_m");
    refuse("{\"media\": [{\"name\": \"m\", \"sigma_s_per_m\": 1, \"albedo\": 1}]}",
           "1: media[0]: is described twice; give either sigma_s_per_m and sigma_a_per_m, or albedo and "
           "mean_free_path_m");
    refuse("{\"media\": [{\"name\": \"m\", \"albedo\": 0.5}]}",
           "1: media[0]: albedo and mean_free_path_m go together");
    refuse("{\"media\": [{\"name\": \"m\", \"sigma_s_per_m\": 0}]}",
           "1: media[0]: sigma_s_per_m and sigma_a_per_m are 0 everywhere: there is no medium");
    refuse("{\"media\": [{\"name\": \"m\", \"sigma_s_per_m\": 1, \"g\": 1}]}",
           "1: media[0].g: is 1; a number from -0.99 to 0.99 is right");
    refuse("{\"media\": [{\"name\": \"m\", \"sigma_s_per_m\": 1, \"density\": {\"type\": \"constant\", "
           "\"scale\": 0}}]}",
           "1: media[0].density.scale: is 0; a number from 1e-09 to 1000000000 is right");
    refuse("{\"media\": [{\"name\": \"m\", \"sigma_s_per_m\": 1, \"density\": {\"type\": \"constant\", "
           "\"scale\": -2}}]}",
           "1: media[0].density.scale: is -2; a number from 1e-09 to 1000000000 is right");
    refuse("{\"media\": [{\"name\": \"m\", \"sigma_s_per_m\": 1, \"density\": {\"type\": \"grid\"}}]}",
           "1: media[0].density: \"file\" is missing; \"grid\" needs it");
    refuse("{\"media\": [{\"name\": \"m\", \"sigma_s_per_m\": 1, \"density\": {\"type\": \"layers\", "
           "\"period_m\": 1, "
           "\"thickness_m\": 2}}]}",
           "1: media[0].density: thickness_m 2 exceeds period_m 1");
    refuse("{\"media\": [{\"name\": \"m\", \"sigma_s_per_m\": 1, \"density\": {\"type\": \"constant\", "
           "\"bounds_min_m\": [0,0,0], \"bounds_max_m\": [1,0,1]}}]}",
           "1: media[0].density: bounds_min_m is not below bounds_max_m on axis y");
    refuse("{\"media\": [{\"name\": \"m\", \"sigma_s_per_m\": 1, \"absorption_from\": {\"mesh\": \"x\", "
           "\"material\": "
           "\"y\"}}]}",
           "1: media[0]: absorption_from: no mesh with a file is named \"x\"");
    refuse("{\"translucents\": [{\"mesh\": \"a\", \"medium\": \"m\"}]}",
           "1: translucents[0]: no mesh is named \"a\"; name one of \"meshes\"");
    refuse("{\"meshes\": [{\"name\": \"a\", \"file\": \"a.obj\"}],\n \"translucents\": [{\"mesh\": \"a\", "
           "\"medium\": "
           "\"m\"}]}",
           "2: translucents[0]: no medium is named \"m\"; name one of \"media\"");
    refuse("{\"meshes\": [{\"name\": \"a\", \"file\": \"a.obj\"}], \"media\": [{\"name\": \"m\", "
           "\"sigma_s_per_m\": 1}],"
           "\n \"translucents\": [{\"mesh\": \"a\", \"medium\": \"m\", \"blockers\": [\"a\"]}]}",
           "2: translucents[0]: mesh \"a\" is already a boundary or blocker; give a second mesh with the "
           "same file");
    refuse("{\"translucents\": [{\"mesh\": \"a\", \"medium\": \"m\", \"blockers\": [1]}]}",
           "1: translucents[0].blockers: is [1]; a list of texts is right");
    refuse("{\"bake\": {\"directions\": 33}}", "1: bake: directions is 33; an even number is right");
    refuse("{\"bake\": {\"directions\": 2.5}}",
           "1: bake.directions: is 2.5; a whole number from 2 to 4096 is right");
    refuse("{\"bake\": {\"samples\": 0}}",
           "1: bake.samples: is 0; a whole number from 1 to 10000000 is right");
    refuse("{\"bake\": {\"sh_order\": 9}}", "1: bake.sh_order: is 9; a whole number from 1 to 8 is right");
    refuse("{\"bake\": {\"samples\": 10, \"radius_m\": 1}}",
           "1: bake: samples and radius_m exclude each other: the count follows from the radius");
    refuse("{\"bake\": {\"seed\": 4294967296}}",
           "1: bake.seed: is 4294967296; a whole number from 0 to 4294967295 is right");
    /* strings, escapes and comments of other lines must not confuse the search for the line */
    refuse("{\"comment\": \"a \\\" { [ \\\\\",\n \"play\": {\"background\": [1, 2, 3],\n  \"exposure_ev\": "
           "null}}",
           "3: play.exposure_ev: is null; a number from -30 to 30 is right");
}

static void test_missing_file(void)
{
    al_scene_description *scene;
    al_error error;
    al_status status = al_scene_description_read("no such scene.json", AL_QUALITY_FINAL, &scene, &error);
    check_refusal("missing", status, &error, AL_BAD_INPUT,
                  "no such scene.json: cannot open the scene: No such file or directory");
}

static char *lights(size_t count)
{
    char *text = calloc(count + 1, 128), *at = text;
    if (!text) exit(1);
    at += sprintf(at, "{\"lights\": [");
    for (size_t i = 0; i < count; i++)
        at += sprintf(at, "%s{\"type\": \"point\", \"position_m\": [0, 0, 0], \"intensity_w_sr\": 1}",
                      i ? ", " : "");
    strcpy(at, "]}");
    return text;
}

static void test_light_count(void)
{
    al_scene_description *scene;
    al_error error = {0};
    char *text = lights(64);
    CHECK(read_scene(text, &scene, &error) == AL_OK);
    if (scene) {
        CHECK(scene->light_count == 64);
        CHECK(strcmp(scene->lights[63].name, "light 63") == 0);
    }
    al_scene_description_free(scene);
    free(text);
    text = lights(65);
    al_status status = read_scene(text, &scene, &error);
    check_refusal("65 lights", status, &error, AL_BAD_INPUT,
                  "description_test.json:1: lights: there are 65 lights; at most 64 are right");
    free(text);
    CHECK(read_scene("{}", &scene, &error) == AL_OK);
    if (scene) CHECK(scene->light_count == 0 && scene->camera_count == 0 && !*scene->environment.file);
    al_scene_description_free(scene);
}

static const char everything[] =
    "{\"unit_m\": 0.01,\n"
    " \"meshes\": [{\"name\": \"a\", \"file\": \"sub/a.obj\", \"node\": \"n\", \"material\": \"m\", "
    "\"hidden\": true,\n"
    "   \"import_lights\": false, \"transform\": {\"translate_m\": [1, 2, 3], \"rotate_degrees\": [90, 0, "
    "90], "
    "\"scale\": [2, 3, 4]}},\n"
    "  {\"name\": \"b\", \"file\": \"/abs/b.ply\", \"unit_m\": 1, \"transform\": {\"matrix\": "
    "[1,0,0,0, 0,1,0,0, 0,0,1,0, 5,6,7,1]}},\n"
    "  {\"name\": \"s\", \"shape\": {\"type\": \"sphere\", \"radius_m\": 2, \"subdivisions\": 3}}],\n"
    " \"materials\": [{\"name\": \"m\", \"base_color\": 0.25, \"emission_w_m2_sr\": [1, 2, 3], "
    "\"double_sided\": true}],\n"
    " \"lights\": [{\"type\": \"directional\", \"direction\": [0, -2, 0], \"irradiance_w_m2\": [1, 2, 3]}],\n"
    " \"cameras\": [{\"name\": \"c\", \"position_m\": [0, 0, 5], \"target_m\": [0, 0, 0], \"fov_y_degrees\": "
    "90}],\n"
    " \"environment\": {\"radiance_w_m2_sr\": [0.5, 1, 2], \"scale\": 3, \"rotation_degrees\": 180},\n"
    " \"media\": [{\"name\": \"w\", \"albedo\": [1, 0.5, 0], \"mean_free_path_m\": [0.1, 0.2, 0.5], \"g\": "
    "-0.5,\n"
    "   \"density\": {\"type\": \"grid\", \"file\": \"f.vdb\", \"grid\": \"d[1]\", \"scale\": 2, \"unit_m\": "
    "0.1,\n"
    "     \"transform\": {\"translate_m\": [1, 0, 0]}, \"bounds_min_m\": [0, 0, 0], \"bounds_max_m\": [1, 1, "
    "1]}},\n"
    "  {\"name\": \"l\", \"sigma_s_per_m\": 3, \"sigma_a_per_m\": [0, 1, 2],\n"
    "   \"density\": {\"type\": \"layers\", \"axis\": [0, 0, 2], \"period_m\": 0.5, \"thickness_m\": "
    "0.2}}],\n"
    " \"translucents\": [{\"mesh\": \"s\", \"medium\": \"w\", \"blockers\": [\"b\"]}],\n"
    " \"fogs\": [\"w\"],\n"
    " \"lightmap\": {\"walls\": \"traced\", \"uv\": \"atlas\", \"samples\": 7, \"fog_points\": 24, "
    "\"back_scatter\": true},\n"
    " \"probes\": {\"order\": 4, \"points\": [{\"position_m\": [1, 2, 3]}]},\n"
    " \"bake\": {\"directions\": 64, \"radius_m\": 0.25, \"coefficient_format\": \"byte\", \"too_dense\": "
    "\"bake\"},\n"
    " \"play\": {\"exposure_ev\": -2, \"background\": 0.5}}";

static void check_meshes(const al_scene_description *s)
{
    const al_mesh_description *a = &s->meshes[0];
    CHECK(s->mesh_count == 3);
    CHECK(strcmp(a->file, "described/sub/a.obj") == 0 && strcmp(a->node, "n") == 0 &&
          strcmp(a->material, "m") == 0);
    CHECK(a->hidden && !a->import_lights && a->import_cameras && a->line == 2);
    CHECK_NEAR(a->unit_m, 0.01, 0);
    /* x: scaled by 2, unmoved by the turn about x, then to y; y: by 3, to z; z: by 4, to -y, then to x */
    const double expected[16] = {0, 2, 0, 0, 0, 0, 3, 0, 4, 0, 0, 0, 1, 2, 3, 1};
    for (int i = 0; i < 16; i++) CHECK_NEAR(a->transform[i], expected[i], 1e-15);
    CHECK(strcmp(s->meshes[1].file, "/abs/b.ply") == 0 && s->meshes[1].line == 4);
    CHECK_NEAR(s->meshes[1].transform[13], 6, 0);
    CHECK(s->meshes[2].shape.type == AL_SHAPE_SPHERE && s->meshes[2].shape.subdivisions == 3);
    CHECK_NEAR(s->meshes[2].unit_m, 1, 0); /* shapes are in metres */
}

static void check_media(const al_scene_description *s)
{
    const al_medium_description *w = &s->media[0], *l = &s->media[1];
    const double scatter[3] = {10, 2.5, 0}, absorb[3] = {0, 2.5, 2};
    for (int i = 0; i < 3; i++) {
        CHECK_NEAR(w->sigma_s_per_m[i], scatter[i], 1e-14);
        CHECK_NEAR(w->sigma_a_per_m[i], absorb[i], 1e-14);
        CHECK_NEAR(l->sigma_a_per_m[i], i, 0);
    }
    CHECK(w->density.type == AL_DENSITY_GRID && w->density.has_bounds &&
          strcmp(w->density.grid, "d[1]") == 0);
    CHECK(strcmp(w->density.file, "described/f.vdb") == 0);
    CHECK_NEAR(w->density.grid_to_world[0], 0.1, 0);
    CHECK_NEAR(w->density.grid_to_world[12], 1, 0); /* the transform is in metres, after the unit */
    CHECK(l->density.type == AL_DENSITY_LAYERS && l->density.axis[2] == 1 && l->density.high == 1);
}

static void test_values(void)
{
    al_scene_description *s;
    al_error error;
    mkdir("described", 0777);
    write_text("described/test.json", everything);
    CHECK(al_scene_description_read("described/test.json", AL_QUALITY_FINAL, &s, &error) == AL_OK);
    if (!s) {
        fprintf(stderr, "%s\n", error.message);
        return;
    }
    check_meshes(s);
    check_media(s);
    CHECK(s->materials[0].base_color[2] == 0.25f && s->materials[0].emission_w_m2_sr[2] == 3);
    CHECK(s->materials[0].double_sided && s->materials[0].roughness == 1 && s->materials[0].ior == 1.5f);
    CHECK(s->lights[0].vector[1] == -1 && s->lights[0].intensity[2] == 3 &&
          s->lights[0].type == AL_LIGHT_DIRECTIONAL);
    CHECK_NEAR(s->cameras[0].fov_y_radians, 1.57079632679, 1e-7);
    CHECK_NEAR(s->environment.rotation_y_radians, 3.14159265358979, 1e-14);
    CHECK(s->environment.radiance[0] == 0.5 && s->environment.scale == 3);
    CHECK(s->fog_count == 1 && s->fogs[0] == 0);
    CHECK(s->lightmap.walls == AL_WALLS_TRACED && s->lightmap.uv == AL_UV_ATLAS && s->lightmap.samples == 7 &&
          s->lightmap.back_scatter && s->lightmap.bounces == 8 && s->lightmap.fog_points == 24);
    CHECK(s->has_probes && s->probes.order == 4 && s->probes.samples == 4096 && s->probes.point_count == 1 &&
          s->probes.points[0][2] == 3);
    CHECK(s->translucents[0].blocker_count == 1 && strcmp(s->translucents[0].blockers[0], "b") == 0);
    CHECK(s->bake.directions == 64 && s->bake.samples == 0 && s->bake.radius_m == 0.25);
    CHECK(s->bake.grid_resolution == 128 && s->bake.sh_order == 8 &&
          s->bake.coefficient_format == AL_COEFFICIENT_BYTE && s->bake.too_dense == AL_TOO_DENSE_BAKE);
    CHECK(s->play.exposure_ev == -2 && s->play.background[1] == 0.5f);
    al_scene_description_free(s);
}

/* --- docs/scene.schema.json --- */

static bool has_limits(const json_t *property, const al_scene_key *key)
{
    return json_number_value(json_object_get(property, "minimum")) == key->minimum &&
           json_number_value(json_object_get(property, "maximum")) == key->maximum;
}

static bool is_type(const json_t *property, const char *type)
{
    const char *text = json_string_value(json_object_get(property, "type"));
    return text && strcmp(text, type) == 0;
}

static bool is_reference(const json_t *property, const char *kind)
{
    char expected[64];
    const char *text = json_string_value(json_object_get(property, "$ref"));
    snprintf(expected, sizeof expected, "#/$defs/%s", kind);
    return text && strcmp(text, expected) == 0;
}

static bool is_numbers(const json_t *property, const al_scene_key *key, json_int_t count)
{
    const json_t *items = json_object_get(property, "items");
    return is_type(property, "array") && is_type(items, "number") && has_limits(items, key) &&
           json_integer_value(json_object_get(property, "minItems")) == count &&
           json_integer_value(json_object_get(property, "maxItems")) == count;
}

static bool same_words(const json_t *list, const char *words)
{
    char joined[256] = "";
    for (size_t i = 0; i < json_array_size(list); i++) {
        if (i) strcat(joined, "|");
        strcat(joined, json_string_value(json_array_get(list, i)));
    }
    return strcmp(joined, words) == 0;
}

static bool agrees(const json_t *property, const al_scene_key *key)
{
    const json_t *either = json_object_get(property, "oneOf");
    switch (key->type) {
    case AL_SCENE_STRING:
        return is_type(property, "string");
    case AL_SCENE_BOOL:
        return is_type(property, "boolean");
    case AL_SCENE_NUMBER:
        return is_type(property, "number") && has_limits(property, key);
    case AL_SCENE_INTEGER:
        return is_type(property, "integer") && has_limits(property, key);
    case AL_SCENE_TRIPLE:
        return json_array_size(either) == 2 && has_limits(json_array_get(either, 0), key) &&
               is_numbers(json_array_get(either, 1), key, 3);
    case AL_SCENE_VECTOR:
        return is_numbers(property, key, 3);
    case AL_SCENE_MATRIX:
        return is_numbers(property, key, 16);
    case AL_SCENE_CHOICE:
        return same_words(json_object_get(property, "enum"), key->words);
    case AL_SCENE_NAMES:
        return is_type(property, "array") && is_type(json_object_get(property, "items"), "string");
    case AL_SCENE_OBJECT:
        return is_reference(property, key->words);
    case AL_SCENE_LIST:
        return is_type(property, "array") && is_reference(json_object_get(property, "items"), key->words);
    }
    return false;
}

static bool is_required(const json_t *object, const char *name)
{
    const json_t *list = json_object_get(object, "required");
    for (size_t i = 0; i < json_array_size(list); i++)
        if (strcmp(json_string_value(json_array_get(list, i)), name) == 0) return true;
    return false;
}

static size_t count_properties(json_t *root)
{
    size_t count = json_object_size(json_object_get(root, "properties"));
    const char *name;
    json_t *object;
    json_object_foreach(json_object_get(root, "$defs"), name, object)
    {
        count += json_object_size(json_object_get(object, "properties"));
        CHECK(json_is_false(json_object_get(object, "additionalProperties")));
    }
    CHECK(json_is_false(json_object_get(root, "additionalProperties")));
    return count;
}

static void test_schema(void)
{
    size_t count;
    const al_scene_key *keys = al_scene_keys(&count);
    json_t *root = json_load_file(AIRLIGHT_SCHEMA, 0, NULL);
    CHECK(root != NULL);
    for (size_t i = 0; i < count; i++) {
        bool top = strcmp(keys[i].object, "scene") == 0;
        const json_t *object = top ? root : json_object_get(json_object_get(root, "$defs"), keys[i].object);
        const json_t *property = json_object_get(json_object_get(object, "properties"), keys[i].key);
        test_checks++;
        if (!agrees(property, &keys[i]) || is_required(object, keys[i].key) != keys[i].required) {
            test_failures++;
            fprintf(stderr, "the schema does not agree about %s.%s\n", keys[i].object, keys[i].key);
        }
    }
    CHECK(count_properties(root) == count);
    json_decref(root);
}

int main(void)
{
    test_refusals();
    test_lighting_refusals();
    test_missing_file();
    test_light_count();
    test_values();
    test_schema();
    return test_end();
}
