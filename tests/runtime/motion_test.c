/* The time in the runtime: what moves is drawn just as if a host had put it there, shadows included; the same time is
 * the same picture, whatever was shown before; nothing is allocated; skinned and morphed vertices agree with those
 * computed in double, and lie in the box that shadows are fitted to. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../runtime/state.h"
#include "../test.h"
#include "sphere.h"
#include "stage.h"

enum { EDGE = 48, PIXELS = EDGE * EDGE * 3 };
#define UNIT_MATRIX {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}

static const char *folder;

static al_runtime *open_scene(const sphere_scene *s)
{
    al_runtime *runtime = NULL;
    al_error error = {0};
    CHECK(sphere_scene_write(folder, s));
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK);
    CHECK(stage_load(runtime, folder));
    return runtime;
}

static void check_same(const float *a, const float *b, bool same)
{
    CHECK(a && b);
    if (a && b) CHECK((memcmp(a, b, PIXELS * sizeof *a) == 0) == same);
}

/* Marches through translucent objects begin elsewhere in each frame: here always where they do in the first one. */
static float *draw(al_runtime *runtime, const al_view *view)
{
    const al_settings settings = {0};
    runtime->frame_number = 0;
    return stage_draw(runtime, view, &settings, 0);
}

/* --- a small floor, a translucent sphere and a lamp over a large floor, moved along x, y and z by a node each --- */

static float times[] = {0, 2}, right[] = {0, 0, 0, 1, 0, 0}, up[] = {0, 0, 0, 0, 0.5f, 0}, ahead[] = {0, 0, 0, 0, 0, -1};
static al_motion_node nodes[3];
static al_motion_channel channels[3];
static al_motion_binding bindings[3];

static void add_moving(sphere_scene *s)
{
    float *places[] = {right, up, ahead};
    for (uint32_t i = 0; i < 3; i++) {
        nodes[i] = (al_motion_node){"", AL_NO_INDEX, UNIT_MATRIX, {0}, {0, 0, 0, 1}, {1, 1, 1}};
        channels[i] = (al_motion_channel){i, AL_MOTION_TRANSLATION, AL_MOTION_LINEAR, 2, 3, times, places[i]};
        bindings[i] = (al_motion_binding){i < 2 ? AL_MOTION_INSTANCE : AL_MOTION_LIGHT, i < 2 ? i + 1 : 0, i, UNIT_MATRIX};
        if (i < 2) memcpy(bindings[i].local, s->instances[i + 1].world, sizeof bindings[i].local);
        if (i == 2) memcpy(bindings[i].local + 12, s->lights[0].vector, sizeof s->lights[0].vector);
    }
    s->scene.motion = (al_motion){3, 3, 3, 0, 0, nodes, channels, bindings, NULL, NULL};
}

static void begin_scene(sphere_scene *s)
{
    sphere_scene_begin(s);
    sphere_scene_add_floor(s, 6, (float[3]){0, -1, 0});
    sphere_scene_add_floor(s, 0.75f, (float[3]){-0.5f, 0.5f, 0.25f});
    sphere_scene_add(s, "ball.translucent.air", 0.4f, (float[3]){0.5f, -0.25f, 0});
    sphere_scene_add_light(s, AL_LIGHT_POINT, (float[3]){0.25f, 3, 0.5f}, 20);
}

static void test_moved(const al_view *view)
{
    sphere_scene s;
    begin_scene(&s);
    al_runtime *still = open_scene(&s);
    add_moving(&s);
    al_runtime *moving = open_scene(&s);
    CHECK(al_runtime_duration_s(still) == 0 && al_runtime_duration_s(moving) == 2);
    al_scene *by_host = al_runtime_scene(still);
    float *first = draw(moving, view), *before = NULL;
    uint64_t memory = al_runtime_memory(moving);
    for (int i = 0; i <= 4; i++) {
        /* 0.5 s is a quarter of the way; 4: the end, which is the beginning again */
        double t = 0.5 * i, share = i == 4 ? 0 : 0.25 * i;
        by_host->instances[1].world[12] = (float)(-0.5 + share);
        by_host->instances[2].world[13] = (float)(-0.25 + 0.5 * share);
        by_host->lights[0].vector[2] = (float)(0.5 - share);
        al_runtime_set_time(moving, t);
        float *wanted = draw(still, view), *made = draw(moving, view);
        check_same(made, wanted, true);
        if (before) check_same(made, before, false);
        free(before);
        free(wanted);
        before = made;
    }
    check_same(before, first, true);
    free(before);
    al_runtime_set_time(moving, -0.5);
    float *early = draw(moving, view);
    al_runtime_set_time(moving, 1.5 + 2e6);
    al_runtime_set_time(moving, NAN);
    al_runtime_set_time(moving, INFINITY);
    float *late = draw(moving, view);
    check_same(early, late, true);
    check_same(early, first, false);
    CHECK(al_runtime_memory(moving) == memory);
    float low[3], high[3];
    CHECK(al_runtime_bounds(moving, low, high) && low[0] == -3 && high[0] == 3 && low[1] == -1);
    CHECK_NEAR(high[1], 0.525, 1e-6); /* the sphere at three quarters of its way: -0.25 + 0.375 + 0.4 */
    free(first);
    free(early);
    free(late);
    al_runtime_destroy(still);
    al_runtime_destroy(moving);
    sphere_scene_end(&s);
}

/* --- a strip of 2 x 16 vertices with four joints and two targets --- */

enum { RUNGS = 16, VERTICES = 2 * RUNGS, JOINTS = 4, TARGETS = 2 };

static float draw_number(uint32_t *state) /* in [-1, 1) */
{
    *state = *state * 1664525u + 1013904223u;
    return (float)(*state >> 8) / 8388608 - 1;
}

typedef struct strip {
    float positions[3 * VERTICES], normals[3 * VERTICES], weights[4 * VERTICES], deltas[2][TARGETS * 3 * VERTICES];
    uint16_t joints[4 * VERTICES];
    uint32_t indices[6 * (RUNGS - 1)];
    al_submesh submesh;
    al_motion_node nodes[JOINTS];
    float times[3], turns[JOINTS][12], shares[3 * TARGETS];
    al_motion_channel channels[JOINTS + 1];
    al_motion_joint joint[JOINTS];
    al_motion_deform deform;
    al_mesh mesh;
} strip;

static void fill_vertices(strip *t, uint32_t *state)
{
    for (uint32_t i = 0; i < VERTICES; i++) {
        float sum = 0, *n = t->normals + 3 * i;
        t->positions[3 * i] = (float)(i % 2) - 0.5f;
        t->positions[3 * i + 1] = (float)(i / 2) / RUNGS;
        n[0] = 0.6f * draw_number(state);
        n[1] = 0.6f * draw_number(state);
        n[2] = sqrtf(1 - n[0] * n[0] - n[1] * n[1]);
        for (int k = 0; k < 4; k++) {
            t->joints[4 * i + (uint32_t)k] = (uint16_t)((i / 8 + (uint32_t)k) % JOINTS);
            sum += t->weights[4 * i + (uint32_t)k] = 1 + draw_number(state) + 1e-3f;
        }
        for (int k = 0; k < 4; k++) t->weights[4 * i + (uint32_t)k] /= sum;
    }
    for (int d = 0; d < 2; d++)
        for (int i = 0; i < TARGETS * 3 * VERTICES; i++) t->deltas[d][i] = 0.5f * draw_number(state);
    for (uint32_t r = 0; r + 1 < RUNGS; r++)
        memcpy(t->indices + 6 * r,
               (uint32_t[]){2 * r, 2 * r + 1, 2 * r + 2, 2 * r + 2, 2 * r + 1, 2 * r + 3}, 6 * sizeof(uint32_t));
}

static void fill_strip(strip *t, uint32_t joint_count, uint32_t target_count)
{
    uint32_t state = 7;
    memset(t, 0, sizeof *t);
    fill_vertices(t, &state);
    for (int k = 0; k < 3; k++) t->times[k] = (float)k;
    for (uint32_t i = 0; i < JOINTS; i++) {
        t->nodes[i] = (al_motion_node){"", i ? i - 1 : AL_NO_INDEX, UNIT_MATRIX, {0, 0.25f, 0}, {0, 0, 0, 1}, {1, 1, 1.25f}};
        t->joint[i] = (al_motion_joint){i, UNIT_MATRIX};
        t->joint[i].inverse_bind[13] = -0.25f * (float)(i + 1);
        for (int k = 0; k < 12; k++) t->turns[i][k] = draw_number(&state);
        t->channels[i] = (al_motion_channel){i, AL_MOTION_ROTATION, AL_MOTION_LINEAR, 3, 4, t->times, t->turns[i]};
    }
    for (int i = 0; i < 3 * TARGETS; i++) t->shares[i] = draw_number(&state);
    t->channels[JOINTS] = (al_motion_channel){JOINTS - 1, AL_MOTION_WEIGHTS, AL_MOTION_LINEAR, 3, TARGETS, t->times, t->shares};
    t->submesh = (al_submesh){0, 6 * (RUNGS - 1), 0};
    t->mesh = (al_mesh){"strip", VERTICES, 6 * (RUNGS - 1), 1, t->positions, t->normals, NULL, NULL, t->indices, &t->submesh};
    t->deform = (al_motion_deform){1, JOINTS - 1, 0, joint_count, target_count, target_count > 0, t->positions, t->normals,
                                   joint_count ? t->joints : NULL, joint_count ? t->weights : NULL,
                                   target_count ? t->deltas[0] : NULL, target_count ? t->deltas[1] : NULL};
}

/* A float's rounding is 2^-24. A coordinate here is a sum over 2 targets, of 4 weights, of 4 products with matrices
 * that were rounded once, in any order: fewer than 16 roundings, each of at most the sum of the magnitudes, which is below
 * 3 x 4 (positions to 2, matrices to 2): 16 x 12 / 2^24 = 1.2e-5. Normals are as many roundings of cofactors (sums of
 * products below 4 in all), relative to their length before they are made unit, which is above 0.07 here: 6e-5. */
static void check_vertices(al_runtime *runtime, double time_s)
{
    const al_motion *m = &runtime->scene.motion;
    const al_motion_deform *d = &m->deforms[0];
    const al_model_mesh *mesh = &runtime->model.meshes[runtime->scene.instances[d->instance].mesh];
    double world[JOINTS][16], palette[JOINTS][16], scratch[4], weights[TARGETS] = {0};
    float positions[3 * VERTICES], normals[3 * VERTICES], made[8 * VERTICES];
    al_motion_nodes_at(m, time_s, scratch, world);
    al_motion_palette(m, d, (const double(*)[16])world, palette);
    al_motion_weights_at(m, d, time_s, weights);
    al_motion_deform_at(d, VERTICES, (const double(*)[16])palette, weights, positions, normals);
    glGetNamedBufferSubData(mesh->vertices.id, 0, sizeof made, made);
    for (int i = 0; i < VERTICES; i++)
        for (int k = 0; k < 3; k++) {
            CHECK_NEAR(made[8 * i + k], positions[3 * i + k], 1.2e-5);
            CHECK_NEAR(made[8 * i + 3 + k], normals[3 * i + k], 6e-5);
            CHECK(made[8 * i + k] >= mesh->low[k] && made[8 * i + k] <= mesh->high[k]);
        }
}

static void test_deformed(const al_view *view, uint32_t joint_count, uint32_t target_count)
{
    static strip t;
    sphere_scene s;
    al_mesh meshes[3];
    fill_strip(&t, joint_count, target_count);
    sphere_scene_begin(&s);
    sphere_scene_add_floor(&s, 6, (float[3]){0, -1, 0});
    sphere_scene_add_floor(&s, 1, (float[3]){0, 0, 0});
    sphere_scene_add_light(&s, AL_LIGHT_DIRECTIONAL, (float[3]){0, -0.8f, -0.6f}, 5);
    memcpy(meshes, s.meshes, sizeof s.meshes);
    meshes[2] = t.mesh;
    meshes[2].submeshes[0].material = 1;
    s.scene.meshes = meshes;
    s.scene.mesh_count = 3;
    s.instances[1].mesh = 2;
    s.scene.motion = (al_motion){JOINTS, target_count ? JOINTS + 1 : JOINTS, 0, joint_count, 1, t.nodes, t.channels, NULL, t.joint, &t.deform};
    al_runtime *runtime = open_scene(&s);
    float *pictures[5];
    for (int i = 0; i < 5; i++) {
        al_runtime_set_time(runtime, 0.4375 * i);
        pictures[i] = draw(runtime, view);
        check_vertices(runtime, 0.4375 * i);
        if (i) check_same(pictures[i], pictures[i - 1], false);
        CHECK(pictures[i] && stage_bad(pictures[i], PIXELS) == 0);
    }
    uint64_t memory = al_runtime_memory(runtime);
    uint32_t posed = runtime->moving.posed;
    for (int i = 4; i >= 0; i--) { /* the other way round, and once more without a change */
        al_runtime_set_time(runtime, 0.4375 * i + 2 * i);
        float *again = draw(runtime, view);
        check_same(again, pictures[i], true);
        free(again);
        again = draw(runtime, view);
        check_same(again, pictures[i], true);
        free(again);
    }
    CHECK(runtime->moving.posed == posed + 4 && al_runtime_memory(runtime) == memory);
    for (int i = 0; i < 5; i++) free(pictures[i]);
    al_runtime_destroy(runtime);
    sphere_scene_end(&s);
}

int main(void)
{
    if (!stage_open()) return test_skip("no OpenGL 4.5");
    folder = stage_folder();
    if (!folder) return test_skip("no temporary folder");
    const sphere_options ball = {.radius = 0.4f, .samples = 300, .grid = 16, .order = 3};
    CHECK(sphere_write_asset(folder, "ball.translucent.air", &ball));
    al_view view = stage_look(EDGE, EDGE, (float[3]){1, 2, 4}, (float[3]){0, -0.25f, 0}, 0.9f);
    test_moved(&view);
    test_deformed(&view, JOINTS, TARGETS);
    test_deformed(&view, JOINTS, 0);
    test_deformed(&view, 0, TARGETS);
    return test_end();
}
