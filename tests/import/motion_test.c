/* Motion from glTF files and from keys of the scene file: what comes into the scene, where it is at a time, and what
 * is refused. The files are made here: a bar of two bones, a triangle with morph targets, a node that turns. */
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>

#include "files.h"
#include "import.h"

/* What is stored as floats, at 1 to 4. */
static const double rounded = 1e-6;

/* --- a glTF file being written: one buffer of floats, an accessor for each array --- */

enum { FLOAT_LIMIT = 512, TEXT_LIMIT = 8192 };

static float numbers[FLOAT_LIMIT];
static size_t number_count;
static char views[TEXT_LIMIT], accessors[TEXT_LIMIT];
static int accessor_count;

static void begin_file(void)
{
    number_count = 0;
    accessor_count = 0;
    views[0] = accessors[0] = 0;
}

static void append(char *text, const char *format, ...) AL_PRINTF(2, 3);
static void append(char *text, const char *format, ...)
{
    va_list arguments;
    size_t used = strlen(text);
    va_start(arguments, format);
    vsnprintf(text + used, TEXT_LIMIT - used, format, arguments);
    va_end(arguments);
}

/* Answers the accessor's number. */
static int add(const char *type, int width, int count, const float *values)
{
    append(views, "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%d}", accessor_count ? "," : "", 4 * number_count,
           4 * width * count);
    append(accessors, "%s{\"bufferView\":%d,\"componentType\":5126,\"type\":\"%s\",\"count\":%d%s}",
           accessor_count ? "," : "", accessor_count, type, count,
           strcmp(type, "VEC3") ? "" : ",\"min\":[0,0,0],\"max\":[2,2,2]");
    memcpy(numbers + number_count, values, sizeof(float) * (size_t)(width * count));
    number_count += (size_t)(width * count);
    return accessor_count++;
}

/* Joints are bytes: two floats' worth for each pair of vertices. */
static int add_joints(int vertices, const unsigned char *joints)
{
    append(views, "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%d}", accessor_count ? "," : "", 4 * number_count,
           4 * vertices);
    append(accessors, "%s{\"bufferView\":%d,\"componentType\":5121,\"type\":\"VEC4\",\"count\":%d}",
           accessor_count ? "," : "", accessor_count, vertices);
    memcpy(numbers + number_count, joints, (size_t)(4 * vertices));
    number_count += (size_t)vertices;
    return accessor_count++;
}

static void end_file(const char *rest)
{
    static char text[4 * TEXT_LIMIT];
    write_bytes("motion.bin", numbers, 4 * number_count);
    snprintf(text, sizeof text,
             "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"buffers\":[{\"uri\":\"motion.bin\",\"byteLength\":%zu}],"
             "\"bufferViews\":[%s],\"accessors\":[%s],%s}",
             4 * number_count, views, accessors, rest);
    write_text("motion.gltf", text);
}

static al_import *read_scene(const char *json)
{
    al_import *import = NULL;
    al_error error = {0};
    write_text("motion_test.json", json);
    al_status status = al_import_scene("motion_test.json", AL_QUALITY_PREVIEW, &import, &error);
    test_checks++;
    if (status) {
        test_failures++;
        fprintf(stderr, "%s\n  refused: %s\n", json, error.message);
        exit(1);
    }
    return import;
}

static void refuse(const char *json, const char *parts)
{
    al_import *import = NULL;
    al_error error = {0};
    write_text("motion_test.json", json);
    al_status status = al_import_scene("motion_test.json", AL_QUALITY_PREVIEW, &import, &error);
    check_mentions(json, status, &error, AL_BAD_INPUT, parts);
    al_import_free(import);
}

#define SCENE "{\"meshes\": [{\"name\": \"m\", \"file\": \"motion.gltf\"}]}"

/* --- the scene at a time --- */

static double world[64][16];

static void show(al_import *import, double time_s)
{
    double scratch[16];
    const al_motion *m = &import->scene.motion;
    CHECK(m->node_count <= 64 && al_motion_width(m) <= 16);
    al_motion_nodes_at(m, time_s, scratch, world);
    al_motion_place(&import->scene, (const double(*)[16])world);
}

static void check_point(const al_instance *instance, double x, double y, double z, double wx, double wy, double wz)
{
    const float *m = instance->world;
    double p[3] = {x, y, z}, wanted[3] = {wx, wy, wz};
    for (int i = 0; i < 3; i++)
        CHECK_NEAR(m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2] + m[12 + i], wanted[i], 2 * rounded);
}

/* --- nodes, lights and cameras of a file --- */

static const float triangle[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};

/* A parent that moves from x = 0 to 2 in 2 s below a node that is scaled by 2; on it a triangle, a lamp and a camera
 * that look along -z. */
static void write_slider(const char *more)
{
    static const float times[] = {0, 2}, places[] = {0, 0, 0, 2, 0, 0};
    char rest[2048];
    begin_file();
    add("VEC3", 3, 3, triangle);
    add("SCALAR", 1, 2, times);
    add("VEC3", 3, 2, places);
    snprintf(rest, sizeof rest,
             "\"scenes\":[{\"nodes\":[0,4]}],\"nodes\":[{\"name\":\"top\",\"scale\":[2,2,2],\"children\":[1]},"
             "{\"name\":\"slider\",\"mesh\":0,\"children\":[2,3]},"
             "{\"name\":\"lamp\",\"translation\":[0,1,0],\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}},"
             "{\"name\":\"eye\",\"camera\":0},{\"name\":\"still\",\"mesh\":0,\"translation\":[0,0,5]}],"
             "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
             "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.7,\"znear\":0.1}}],"
             "\"extensionsUsed\":[\"KHR_lights_punctual\"],"
             "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"point\",\"intensity\":3}]}},"
             "\"animations\":[{\"name\":\"slide\",\"channels\":[{\"sampler\":0,\"target\":{\"node\":1,\"path\":"
             "\"translation\"}}],\"samplers\":[{\"input\":1,\"output\":2%s}]}]",
             more);
    end_file(rest);
}

static void test_slider(void)
{
    write_slider("");
    al_import *import = read_scene(SCENE);
    al_scene *scene = &import->scene;
    CHECK(scene->instance_count == 2 && scene->light_count == 1 && scene->camera_count == 1);
    CHECK(scene->motion.binding_count == 3 && scene->motion.channel_count == 1 && !scene->motion.deform_count);
    CHECK(al_motion_length_s(&scene->motion) == 2);
    CHECK(al_motion_moves(&scene->motion, 0) && !al_motion_moves(&scene->motion, 1));
    for (int i = 0; i <= 4; i++) {
        double x = 2 * 0.5 * i;
        show(import, 0.5 * i);
        check_point(&scene->instances[0], 1, 0, 0, x + 2, 0, 0);
        check_point(&scene->instances[1], 1, 0, 0, 1, 0, 5);
        CHECK_NEAR(scene->lights[0].vector[0], x, rounded);
        CHECK_NEAR(scene->lights[0].vector[1], 2, rounded);
        CHECK_NEAR(scene->cameras[0].position[0], x, rounded);
        CHECK_NEAR(scene->cameras[0].target[0], x, rounded);
        CHECK(scene->cameras[0].target[2] < 0);
    }
    al_import_free(import);
    write_slider(",\"interpolation\":\"STEP\"");
    import = read_scene("{\"meshes\": [{\"name\": \"m\", \"file\": \"motion.gltf\", \"unit_m\": 0.5, \"animation\": "
                        "\"slide\", \"transform\": {\"translate_m\": [0, 0, 3]}}]}");
    show(import, 1.9);
    check_point(&import->scene.instances[0], 1, 0, 0, 1, 0, 3);
    show(import, 2);
    check_point(&import->scene.instances[0], 1, 0, 0, 3, 0, 3);
    al_import_free(import);
}

/* What stands still in the lightmap stays there; what moves takes the probes, or nothing where there are none. */
static void test_lighting(void)
{
    write_slider("");
    al_import *import = read_scene("{\"meshes\": [{\"name\": \"m\", \"file\": \"motion.gltf\", \"lighting\": "
                                   "\"lightmap\"}], \"probes\": {}}");
    CHECK(import->scene.instances[0].lighting == AL_LIGHTING_PROBES);
    CHECK(import->scene.instances[1].lighting == AL_LIGHTING_LIGHTMAP);
    al_import_free(import);
    import = read_scene("{\"meshes\": [{\"name\": \"m\", \"file\": \"motion.gltf\", \"lighting\": \"lightmap\"}]}");
    CHECK(import->scene.instances[0].lighting == AL_LIGHTING_DYNAMIC);
    al_import_free(import);
}

/* --- a bar of two bones: vertices at x = 0, 1, 2, the middle one half on each; the second bone turns about z --- */

static const float bar[] = {0, 0, 0, 1, 0, 0, 2, 0, 0, 1, 1, 0};

static void write_bar(const unsigned char *joints, const float *weights, const char *inverse, const float *times)
{
    static const float turn[] = {0, 0, 0, 1, 0, 0, 0.70710678f, 0.70710678f};
    static const float binds[] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0,  0, 0, 1,
                                  1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1};
    static const float corners[] = {0, 1, 3, 1, 2, 3};
    char rest[2048];
    begin_file();
    add("VEC3", 3, 4, bar);
    add_joints(4, joints);
    add("VEC4", 4, 4, weights);
    add("MAT4", 16, 2, binds);
    add("SCALAR", 1, 2, times);
    add("VEC4", 4, 2, turn);
    unsigned short indices[6];
    for (int i = 0; i < 6; i++) indices[i] = (unsigned short)corners[i];
    append(views, ",{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":12}", 4 * number_count);
    append(accessors, ",{\"bufferView\":6,\"componentType\":5123,\"type\":\"SCALAR\",\"count\":6}");
    memcpy(numbers + number_count, indices, sizeof indices);
    number_count += 3;
    snprintf(rest, sizeof rest,
             "\"scenes\":[{\"nodes\":[0,1]}],\"nodes\":[{\"name\":\"bar\",\"mesh\":0,\"skin\":0,\"translation\":[7,7,7]},"
             "{\"name\":\"shoulder\",\"children\":[2]},{\"name\":\"elbow\",\"translation\":[1,0,0]}],"
             "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"JOINTS_0\":1,\"WEIGHTS_0\":2},"
             "\"indices\":6}]}],\"skins\":[{%s\"joints\":[1,2]}],"
             "\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"node\":2,\"path\":\"rotation\"}}],"
             "\"samplers\":[{\"input\":4,\"output\":5}]}]",
             inverse);
    end_file(rest);
}

static const unsigned char bar_joints[] = {0, 9, 9, 9, 0, 1, 9, 9, 1, 0, 0, 0, 0, 1, 0, 0};
static const float bar_weights[] = {1, 0, 0, 0, 0.5f, 0.5f, 0, 0, 1, 0, 0, 0, 0.5f, 0.5f, 0, 0};
static const float bar_times[] = {0, 1};
#define BINDS "\"inverseBindMatrices\":3,"

/* The vertex of the mesh that is bound at (x, y). */
static void check_vertex(al_import *import, double x, double y, double time_s, double wx, double wy)
{
    const al_motion *m = &import->scene.motion;
    const al_motion_deform *d = &m->deforms[0];
    const al_mesh *mesh = &import->scene.meshes[import->scene.instances[d->instance].mesh];
    double palette[2][16];
    float positions[3 * 6], normals[3 * 6];
    int found = 0;
    CHECK(mesh->vertex_count == 4);
    show(import, time_s);
    al_motion_palette(m, d, (const double(*)[16])world, palette);
    al_motion_deform_at(d, mesh->vertex_count, (const double(*)[16])palette, NULL, positions, normals);
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        const float *bind = d->bind_positions + 3 * i, *w = d->weights + 4 * i;
        if (fabs(bind[0] - x) > rounded || fabs(bind[1] - y) > rounded) continue;
        found++;
        CHECK_NEAR(positions[3 * i], wx, 2 * rounded);
        CHECK_NEAR(positions[3 * i + 1], wy, 2 * rounded);
        CHECK_NEAR(w[0] + w[1] + w[2] + w[3], 1, rounded);
    }
    CHECK(found == 1);
}

static void test_bar(void)
{
    write_bar(bar_joints, bar_weights, BINDS, bar_times);
    al_import *import = read_scene(SCENE);
    CHECK(import->scene.motion.deform_count == 1 && import->scene.motion.joint_count == 2);
    /* Half a second is 45 degrees: the end at (1 + cos, sin), the middle one still, its neighbour above between
     * (1, 1) and (1 - sin, cos). */
    double c = sqrt(0.5);
    check_vertex(import, 0, 0, 0.5, 0, 0);
    check_vertex(import, 1, 0, 0.5, 1, 0);
    check_vertex(import, 2, 0, 0.5, 1 + c, c);
    check_vertex(import, 1, 1, 0.5, 1 - c / 2, (1 + c) / 2);
    check_vertex(import, 2, 0, 1, 1, 1);
    check_vertex(import, 2, 0, 0, 2, 0);
    al_import_free(import);
    /* The same through a scene that is half as large and elsewhere: joints take it along. */
    import = read_scene("{\"meshes\": [{\"name\": \"m\", \"file\": \"motion.gltf\", \"unit_m\": 0.5, \"transform\": "
                        "{\"translate_m\": [1, 0, 0]}}]}");
    check_vertex(import, 2, 0, 1, 1.5, 0.5);
    al_import_free(import);
    /* Weights of twice the sum are halved; without inverse bind matrices they are 1, so the end goes to (1, 2). */
    float twice[16];
    for (int i = 0; i < 16; i++) twice[i] = 2 * bar_weights[i];
    write_bar(bar_joints, twice, "", bar_times);
    import = read_scene(SCENE);
    check_vertex(import, 2, 0, 1, 1, 2);
    al_import_free(import);
}

/* Nothing moves the joints: the mesh stands where they put it, and is like any other. */
static void test_still_skin(void)
{
    write_bar(bar_joints, bar_weights, "", bar_times);
    refuse("{\"meshes\": [{\"name\": \"m\", \"file\": \"motion.gltf\", \"animation\": \"walk\"}]}",
           "no animation is named \"walk\"");
    char text[8192];
    FILE *file = fopen("motion.gltf", "r");
    size_t size = file ? fread(text, 1, sizeof text - 1, file) : 0;
    if (file) fclose(file);
    text[size] = 0;
    char *animations = strstr(text, ",\"animations\"");
    if (!animations) exit(1);
    strcpy(animations, "}");
    write_text("motion.gltf", text);
    al_import *import = read_scene(SCENE);
    const al_mesh *mesh = &import->scene.meshes[0];
    float largest = 0;
    for (uint32_t i = 0; i < mesh->vertex_count; i++) largest = fmaxf(largest, mesh->positions[3 * i]);
    CHECK(!import->scene.motion.deform_count && largest == 3);
    al_import_free(import);
}

static void test_bad_skins(void)
{
    unsigned char outside[16];
    float negative[16];
    memcpy(outside, bar_joints, sizeof outside);
    memcpy(negative, bar_weights, sizeof negative);
    outside[8] = 2;
    negative[1] = -0.5f;
    write_bar(outside, bar_weights, BINDS, bar_times);
    refuse(SCENE, "motion_test.json:1: mesh \"m\" (motion.gltf)|vertex 2 hangs on joint 2 of 2");
    write_bar(bar_joints, negative, BINDS, bar_times);
    refuse(SCENE, "vertex 0 has the weight -0.5; 0 or more is right");
    write_bar(bar_joints, bar_weights, "\"inverseBindMatrices\":2,", bar_times);
    refuse(SCENE, "inverseBindMatrices: accessor 2 is not there or has not 16 numbers each");
    write_bar(bar_joints, bar_weights, BINDS, (float[]){-1, 1});
    refuse(SCENE, "animation 0, channel 0: key 0 is at -1 s; times that rise from 0 on are right");
    write_bar(bar_joints, bar_weights, BINDS, (float[]){1, 0.5f});
    refuse(SCENE, "animation 0, channel 0: key 1 is at 0.5 s");
    write_bar(bar_joints, bar_weights, BINDS, (float[]){0, NAN});
    refuse(SCENE, "animation 0, channel 0: number 1 is nan");
    write_slider(",\"interpolation\":\"BEZIER\"");
    refuse(SCENE, "interpolation BEZIER; LINEAR, STEP or CUBICSPLINE is right");
    write_slider(",\"interpolation\":\"CUBICSPLINE\"");
    refuse(SCENE, "2 values for 2 keys; 6 are right");
}

/* --- morph targets --- */

static void test_morph(void)
{
    static const float times[] = {0, 1}, weights[] = {0, 0.25f, 1, 0.25f}, deltas[] = {0, 0, 0, 0, 0, 2, 0, 0, 0},
                       others[] = {0, 4, 0, 0, 0, 0, 0, 0, 0};
    double at[2];
    begin_file();
    add("VEC3", 3, 3, triangle);
    add("VEC3", 3, 3, deltas);
    add("VEC3", 3, 3, others);
    add("SCALAR", 1, 2, times);
    add("SCALAR", 1, 4, weights);
    end_file("\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{"
             "\"POSITION\":0},\"targets\":[{\"POSITION\":1},{\"POSITION\":2}]}]}],"
             "\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"weights\"}}],"
             "\"samplers\":[{\"input\":3,\"output\":4}]}]");
    al_import *import = read_scene(SCENE);
    const al_motion *m = &import->scene.motion;
    CHECK(m->deform_count == 1 && m->deforms[0].target_count == 2 && !m->deforms[0].has_normals && !m->joint_count);
    const al_mesh *mesh = &import->scene.meshes[0];
    CHECK(mesh->positions[1] == 1 && m->deforms[0].bind_positions[1] == 0); /* as at time 0 */
    CHECK(!m->deforms[0].normal_deltas && !m->deforms[0].joints && !m->deforms[0].weights);
    for (int i = 0; i <= 2; i++) {
        float positions[9], normals[9];
        al_motion_weights_at(m, &m->deforms[0], 0.5 * i, at);
        CHECK_NEAR(at[0], 0.5 * i, 1e-12);
        CHECK_NEAR(at[1], 0.25, 1e-12);
        al_motion_deform_at(&m->deforms[0], 3, NULL, at, positions, normals);
        CHECK_NEAR(positions[5], i, rounded);
        CHECK_NEAR(positions[1], 1, rounded);
    }
    al_import_free(import);
}

/* --- keys of the scene file --- */

static void test_keys(void)
{
    al_import *import = read_scene(
        "{\"meshes\": [{\"name\": \"box\", \"shape\": {\"type\": \"box\"}, \"transform\": {\"translate_m\": [0, 0, 4]},"
        "\"motion\": [{\"time_s\": 1}, {\"time_s\": 3, \"rotate_degrees\": [0, 360, 0], \"translate_m\": [2, 0, 0]},"
        "{\"time_s\": 4, \"translate_m\": [2, 0, 0], \"scale\": 3}]}],"
        "\"lights\": [{\"type\": \"directional\", \"direction\": [0, -1, 0], \"irradiance_w_m2\": 1, \"motion\": "
        "[{\"time_s\": 0}, {\"time_s\": 4, \"rotate_degrees\": [90, 0, 0]}]}],"
        "\"cameras\": [{\"position_m\": [0, 0, 9], \"target_m\": [0, 0, 4], \"motion\": [{\"time_s\": 0}, {\"time_s\": 4, "
        "\"translate_m\": [0, 4, 0]}]}]}");
    al_scene *scene = &import->scene;
    CHECK(al_motion_length_s(&scene->motion) == 4);
    show(import, 0);
    check_point(&scene->instances[0], 1, 0, 0, 1, 0, 4);
    show(import, 1.5); /* a quarter of the turn: +x to -z */
    check_point(&scene->instances[0], 1, 0, 0, 0.5, 0, 3);
    show(import, 2.25);
    check_point(&scene->instances[0], 0, 0, 1, 1.25 - sqrt(0.5), 0, 4 - sqrt(0.5));
    show(import, 3);
    check_point(&scene->instances[0], 1, 0, 0, 3, 0, 4);
    show(import, 3.5); /* and back the whole turn in a second: half of it, twice as large */
    check_point(&scene->instances[0], 1, 0, 0, 0, 0, 4);
    show(import, 4);
    check_point(&scene->instances[0], 1, 0, 0, 5, 0, 4);
    CHECK_NEAR(scene->lights[0].vector[1], 0, rounded);
    CHECK_NEAR(scene->lights[0].vector[2], -1, rounded);
    CHECK_NEAR(scene->cameras[0].position[1], 4, rounded);
    CHECK_NEAR(scene->cameras[0].target[1], 4, rounded);
    CHECK_NEAR(scene->cameras[0].target[2], 4, 4 * rounded);
    al_import_free(import);
    refuse("{\"meshes\": [{\"name\": \"a\", \"shape\": {\"type\": \"box\"}, \"motion\": [{\"time_s\": 1}, {\"time_s\": 1}]}]}",
           "motion[1]: time_s 1 does not follow 1; times that rise are right");
    refuse("{\"meshes\": [{\"name\": \"a\", \"shape\": {\"type\": \"box\"}, \"motion\": [{\"time_s\": -1}]}]}",
           "motion[0].time_s: is -1");
    refuse("{\"meshes\": [{\"name\": \"a\", \"shape\": {\"type\": \"box\"}, \"lighting\": \"lightmap\", \"motion\": "
           "[{\"time_s\": 0}]}]}",
           "moves and cannot keep a lightmap");
    refuse("{\"meshes\": [{\"name\": \"a\", \"shape\": {\"type\": \"box\"}, \"motion\": [{\"time_s\": 0, \"scale\": 2}]}], "
           "\"media\": [{\"name\": \"w\", \"sigma_s_per_m\": 1}], \"translucents\": [{\"mesh\": \"a\", \"medium\": \"w\"}]}",
           "its boundary \"a\" changes its scale");
}

/* A fog moves from where it lies; what cannot is refused. */
static void test_fog(void)
{
#define FOG(density) "{\"media\": [{\"name\": \"f\", \"sigma_a_per_m\": 1, \"density\": {" density "}}], \"fogs\": [\"f\"]}"
#define BOX "\"type\": \"constant\", \"bounds_min_m\": [1, 0, 0], \"bounds_max_m\": [3, 1, 1]"
    al_import *import = read_scene(FOG(BOX ", \"motion\": [{\"time_s\": 0}, {\"time_s\": 2, \"translate_m\": [0, 4, 0]}]"));
    al_scene *scene = &import->scene;
    CHECK(scene->motion.binding_count == 1 && scene->motion.bindings[0].kind == AL_MOTION_FOG);
    CHECK(scene->fogs[0].bounds_min_m[1] == 0);
    show(import, 0);
    for (int i = 0; i < 16; i++) CHECK_NEAR(scene->fogs[0].moved[i], i % 5 == 0, rounded);
    show(import, 0.5);
    CHECK_NEAR(scene->fogs[0].moved[13], 1, rounded);
    CHECK_NEAR(scene->fogs[0].moved[12], 0, rounded);
    al_import_free(import);
    refuse(FOG("\"type\": \"constant\", \"motion\": [{\"time_s\": 0}]"), "has no end and cannot move");
    refuse(FOG(BOX ", \"motion\": [{\"time_s\": 0, \"rotate_degrees\": [0, 9, 0]}]"), "only a grid without bounds of its own turns");
    refuse(FOG(BOX ", \"motion\": [{\"time_s\": 0, \"scale\": 2}]"), "a density only turns and moves");
    refuse("{\"meshes\": [{\"name\": \"b\", \"shape\": {\"type\": \"box\"}}], \"media\": [{\"name\": \"f\", \"sigma_s_per_m\": 1, "
           "\"density\": {" BOX ", \"motion\": [{\"time_s\": 0}]}}], \"translucents\": [{\"mesh\": \"b\", \"medium\": \"f\"}]}",
           "moves with its boundary, by the motion of mesh \"b\"");
}

/* A keyed mesh from a file whose nodes move as well: one inside the other. */
static void test_both(void)
{
    write_slider("");
    al_import *import = read_scene("{\"meshes\": [{\"name\": \"m\", \"file\": \"motion.gltf\", \"motion\": [{\"time_s\": 0},"
                                   "{\"time_s\": 2, \"rotate_degrees\": [0, 90, 0], \"translate_m\": [0, 1, 0]}]}]}");
    show(import, 2);
    check_point(&import->scene.instances[0], 1, 0, 0, 0, 1, -6);
    check_point(&import->scene.instances[1], 1, 0, 0, 5, 1, -1);
    CHECK_NEAR(import->scene.lights[0].vector[2], -4, 2 * rounded);
    al_import_free(import);
}

int main(void)
{
    test_slider();
    test_lighting();
    test_bar();
    test_still_skin();
    test_bad_skins();
    test_morph();
    test_keys();
    test_both();
    test_fog();
    return test_end();
}
