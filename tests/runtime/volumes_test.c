/* Ambient occlusion volumes. With the bounced z-buffer: on every pixel's ray the same triangle as a loop over all of them in
 * double precision, at the same distance; of scenes of 1e-4, 1 and 1e4 m, with a mirrored, a deformed and a turned
 * instance, a huge one, one that continues another evenly, two that coincide and one without area; from outside, from
 * within the volumes, orthographic. Blended: of one triangle the form factor, by quadrature. */
#include <epoxy/gl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../../runtime/matrix.h"
#include "../../runtime/state.h"
#include "../test.h"
#include "airlight/formulas.h"
#include "sphere.h"
#include "stage.h"

enum { EDGE = 32, PIXELS = EDGE * EDGE };

typedef struct triangle {
    double corner[3][3];
} triangle;

typedef struct place {
    double at[3], ray[3], normal[3], scale;
} place;

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double *a, const double *b, double *out)
{
    for (int k = 0; k < 3; k++) out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* Fraction of the unit normal along n, and the height of `at` over the triangle; false: it has no area. */
static bool plane(const triangle *t, const double at[3], double normal[3], double *height)
{
    double a[3], b[3], off[3];
    for (int k = 0; k < 3; k++) {
        a[k] = t->corner[1][k] - t->corner[0][k];
        b[k] = t->corner[2][k] - t->corner[0][k];
        off[k] = at[k] - t->corner[0][k];
    }
    cross(a, b, normal);
    double size = sqrt(dot(normal, normal));
    for (int k = 0; k < 3; k++) normal[k] /= size;
    *height = dot(normal, off);
    return size > 0;
}

/* --- against a loop over all triangles --- */

/* Distance at which the place's ray meets the triangle, INFINITY where it does not or where the place lies on it (triangle.glsl).
 * *doubt: how near either decision is, relative to the triangle and to the rounding of the place. */
static double meet(const place *p, const triangle *t, double *doubt)
{
    double normal[3], height, weight[3], sum = 0, least = INFINITY;
    *doubt = INFINITY;
    if (!plane(t, p->at, normal, &height)) return INFINITY;
    double slope = dot(normal, p->ray), distance = -height / slope, rounding = 4e-6 * p->scale;
    for (int i = 0; i < 3; i++) {
        const double *a = t->corner[i], *b = t->corner[(i + 1) % 3];
        double side[3], from[3], across[3];
        for (int k = 0; k < 3; k++) {
            side[k] = b[k] - a[k];
            from[k] = p->at[k] + distance * p->ray[k] - a[k];
        }
        cross(side, from, across);
        weight[i] = dot(across, normal) / sqrt(dot(side, side)); /* distance of the ray from the side, m */
        sum += weight[i];
        least = fmin(least, weight[i]);
    }
    /* The place's rounding, seen along the plane, moves what is met. */
    double moves = 1e-6 * p->scale / fmax(fabs(slope), 1e-9);
    *doubt = fmin(fabs(least) / moves, fabs(fabs(height) - rounding) / (1e-6 * p->scale));
    if (fabs(height) <= rounding && fabs(dot(normal, p->normal)) >= 0.5) return INFINITY;
    if (fabs(height) <= 2 * rounding) *doubt = 0; /* moved off */
    return distance > 0 && least >= 0 ? distance : INFINITY;
}

static uint32_t list_triangles(const al_runtime *runtime, triangle *list)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < runtime->scene.instance_count; i++) {
        const al_instance *instance = &runtime->scene.instances[i];
        const al_mesh *mesh = &runtime->scene.meshes[instance->mesh];
        float *vertices = malloc(mesh->vertex_count * 8 * sizeof *vertices); /* as they are posed on the GPU */
        double world[16];
        al_matrix_from_float(instance->world, world);
        glGetNamedBufferSubData(runtime->model.meshes[instance->mesh].vertices.id, 0,
                                (GLsizeiptr)(mesh->vertex_count * 8 * sizeof *vertices), vertices);
        for (uint32_t k = 0; k < mesh->index_count; k++) {
            const float *v = vertices + 8 * mesh->indices[k];
            double at[4] = {(double)v[0], (double)v[1], (double)v[2], 1};
            al_matrix_transform(world, at, at);
            if (list) memcpy(list[count + k / 3].corner[k % 3], at, 3 * sizeof *at);
        }
        count += mesh->index_count / 3;
        free(vertices);
    }
    return count;
}

static place place_of(const al_frame_block *frame, uint32_t pixel, const float stored[4], const float surface[4])
{
    place p;
    double view[3];
    for (int k = 0; k < 3; k++)
        view[k] = frame->ray[3][k] + (pixel % EDGE + 0.5) * frame->ray[4][k] + (pixel / EDGE + 0.5) * frame->ray[5][k];
    for (int k = 0; k < 3; k++) {
        p.at[k] = frame->ray[0][k] + (pixel % EDGE + 0.5) * frame->ray[1][k] +
                  (pixel / EDGE + 0.5) * frame->ray[2][k] + stored[3] * view[k] / sqrt(dot(view, view));
        p.ray[k] = stored[k];
        p.normal[k] = surface[k];
    }
    p.scale = stored[3] + sqrt(dot(p.at, p.at));
    return p;
}

static void check_hits(const al_runtime *runtime, const al_settings *settings)
{
    static float rays[PIXELS][4], surfaces[PIXELS][4], depths[PIXELS];
    static uint32_t numbers[PIXELS];
    const al_bounce *bounce = &runtime->bounce;
    al_frame_block frame;
    al_bounce_block block;
    uint32_t count = list_triangles(runtime, NULL), places = 0, hits = 0, doubts = 0;
    triangle *list = malloc(count * sizeof *list);
    double radius = settings->occlusion_radius_m > 0 ? (double)settings->occlusion_radius_m : INFINITY;
    list_triangles(runtime, list);
    glGetNamedBufferSubData(runtime->frame_block.id, 0, sizeof frame, &frame);
    glGetNamedBufferSubData(bounce->constants.id, 0, sizeof block, &block);
    glGetTextureImage(bounce->rays.id, 0, GL_RGBA, GL_FLOAT, sizeof rays, rays);
    glGetTextureImage(runtime->targets.geometry.id, 0, GL_RGBA, GL_FLOAT, sizeof surfaces, surfaces);
    glGetTextureImage(bounce->hits.id, 0, GL_RED_INTEGER, GL_UNSIGNED_INT, sizeof numbers, numbers);
    glGetTextureImage(bounce->depths.id, 0, GL_DEPTH_COMPONENT, GL_FLOAT, sizeof depths, depths);
    for (uint32_t i = 0; i < PIXELS; i++) {
        if (rays[i][3] == 0) continue;
        place p = place_of(&frame, i, rays[i], surfaces[i]);
        double nearest = INFINITY, doubt, least = INFINITY, depth = sqrt((double)depths[i]) * block.reach[1];
        uint32_t found = 0;
        for (uint32_t t = 0; t < count; t++) {
            double distance = meet(&p, &list[t], &doubt);
            if (doubt < 1) least = doubt;
            if (fabs(distance / radius - 1) < 1e-5) least = 0;
            if (distance >= nearest || distance > radius) continue;
            nearest = distance;
            found = t + 1;
        }
        places++;
        hits += found > 0;
        /* Triangles that share a side, or coincide, are met at one distance: either number is right. */
        double bound = 1e-6 * (nearest + p.scale / 1e-2);
        bool same = found == numbers[i] || (found && numbers[i] && fabs(depth - nearest) < bound);
        if (!same && least < 1) {
            doubts++;
            continue;
        }
        CHECK(same);
        if (found && numbers[i] && least >= 1) CHECK_NEAR(depth, nearest, bound);
    }
    printf("%u of %u rays hit one of %u triangles, rounding decides about %u\n", hits, places, count, doubts);
    CHECK(hits > PIXELS / 40 && hits < places);
    CHECK(doubts < PIXELS / 100);
    free(list);
}

typedef struct test_scene {
    sphere_scene s;
    float times[2], shares[2], *deltas;
    al_motion_node node;
    al_motion_channel channel;
    al_motion_deform deform;
} test_scene;

/* The sphere grows an egg's tip in the first second. */
static void deform_sphere(test_scene *t, uint32_t instance)
{
    const al_mesh *mesh = &t->s.meshes[0];
    t->deltas = calloc(mesh->vertex_count, 12);
    for (uint32_t i = 0; i < mesh->vertex_count; i++) t->deltas[3 * i + 1] = fmaxf(mesh->positions[3 * i + 1], 0);
    t->times[1] = t->shares[1] = 1;
    t->node = (al_motion_node){"", AL_NO_INDEX, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, {0}, {0, 0, 0, 1}, {1, 1, 1}};
    t->channel = (al_motion_channel){0, AL_MOTION_WEIGHTS, AL_MOTION_LINEAR, 2, 1, t->times, t->shares};
    t->deform = (al_motion_deform){instance, 0, 0, 0, 1, false, mesh->positions, mesh->normals, NULL, NULL, t->deltas, NULL};
    t->s.scene.motion = (al_motion){1, 1, 0, 0, 1, &t->node, &t->channel, NULL, NULL, &t->deform};
}

static void place_instance(sphere_scene *s, float unit, const float world[12])
{
    sphere_scene_add_floor(s, 1, (float[3]){0, 0, 0});
    float *to = s->instances[s->scene.instance_count - 1].world;
    for (int i = 0; i < 12; i++) to[i / 3 * 4 + i % 3] = unit * world[i];
}

static al_runtime *open_scene(const char *folder, test_scene *t, float unit)
{
    al_runtime *runtime = NULL;
    al_error error = {0};
    memset(t, 0, sizeof *t);
    sphere_scene *s = &t->s;
    sphere_scene_begin(s);
    s->scene.baked = (al_baked_light){"", ""};
    place_instance(s, unit, (float[]){4, 0, 0, 0, 1, 0, 0, 0, 4, 0, 0, 0});                 /* floor */
    place_instance(s, unit, (float[]){0.3f, 0, 0, 0, 0.3f, 0, 0, 0, 0.3f, 0.5f, 0.5f, 0});  /* sphere */
    s->instances[1].mesh = 0;
    place_instance(s, unit, (float[]){30, 0, 0, 0, 0, 1, 0, 20, 0, 0, 9, -1.5f});            /* huge wall */
    place_instance(s, unit, (float[]){1, 0, 0, 0, 1, 0, 0, 0, 1, 2.5f, 0, 0});               /* goes on from the floor */
    place_instance(s, unit, (float[]){-1, 0.4f, 0, 0.4f, 1, 0, 0, 0, 1, -0.6f, 0.6f, 0.1f}); /* mirrored, tilted */
    place_instance(s, unit, (float[]){-1, 0.4f, 0, 0.4f, 1, 0, 0, 0, 1, -0.6f, 0.6f, 0.1f}); /* and the same again */
    place_instance(s, unit, (float[]){1, 0, 0, 0, 1, 0, 1, 0, 0, 0.4f, 0.4f, 0.4f});         /* no area */
    deform_sphere(t, 1);
    CHECK(sphere_scene_write(folder, s));
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK);
    CHECK(stage_load(runtime, folder));
    return runtime;
}

/* `step`: of the six views and radii, every how many. */
static void test_hits(const char *folder, float unit, int step)
{
    test_scene t;
    al_runtime *runtime = open_scene(folder, &t, unit);
    al_view views[3] = {stage_look(EDGE, EDGE, (float[3]){1, 1.5f, 4}, (float[3]){0, 0.4f, 0}, 0.7f),
                        stage_look(EDGE, EDGE, (float[3]){0.1f, 0.9f, 0.9f}, (float[3]){0, 0.3f, 0}, 1.2f),
                        stage_ortho(EDGE, EDGE, 1.5f)};
    al_runtime_set_time(runtime, 0.5);
    for (int i = 0; i < 6; i += step) {
        al_view view = views[i % 3];
        al_settings settings = {.pass = AL_PASS_AMBIENT_OCCLUSION,
                                .occlusion_carrier = AL_CARRIER_VOLUMES,
                                .occlusion_radius_m = i < 3 ? 0 : 0.7f * unit,
                                .bounce_samples = 1,
                                .bounce_filter_off = true};
        for (int k = 12; k < 15; k++) view.view[k] *= unit;
        if (i % 3 == 2) {
            for (int k = 0; k < 11; k += 5) view.projection[k] /= unit;
        } else {
            view.projection[14] *= unit;
        }
        free(stage_draw(runtime, &view, &settings, 0));
        check_hits(runtime, &settings);
        for (settings.occlusion_carrier = 0; i == 4 && settings.occlusion_carrier < AL_CARRIER_COUNT; settings.occlusion_carrier++) {
            float *pixels = stage_draw(runtime, &view, &settings, 0);
            CHECK(pixels && !stage_bad(pixels, PIXELS * 3));
            for (uint32_t k = 0; pixels && k < PIXELS * 3; k++) CHECK(pixels[k] <= 1.0001f);
            free(pixels);
        }
    }
    al_runtime_destroy(runtime);
    free(t.deltas);
    sphere_scene_end(&t.s);
}

/* --- form factors --- */

static const float corners[3][3] = {{-0.5f, 0.1f, -0.4f}, {0.7f, 0.3f, 0}, {0, 0.9f, 0.3f}};

/* Share of the cosine-weighted hemisphere over (at, normal): midpoints of N^2 equal triangles, inside the ball and over the
 * horizon. cos cos'/(pi r^2) varies by at most the fourth of a cell's part of the distance squared over a cell's middle, so
 * smooth ones are 1e-4 off; of the ball's rim a line of at most 2 N cells counts by whole cells, at random. */
static double quadrature(const double at[3], const double normal[3], double radius)
{
    enum { N = 160 };
    triangle t;
    double m[3], height, sum = 0, sides[2][3], across[3];
    for (int i = 0; i < 9; i++) t.corner[i / 3][i % 3] = (double)corners[i / 3][i % 3];
    plane(&t, at, m, &height);
    for (int k = 0; k < 3; k++) {
        sides[0][k] = t.corner[1][k] - t.corner[0][k];
        sides[1][k] = t.corner[2][k] - t.corner[0][k];
    }
    cross(sides[0], sides[1], across);
    double area = sqrt(dot(across, across)) / 2 / (N * N);
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N - i; j++)
            for (int up = 0; up < 2 && i + j + up < N; up++) {
                double u = (i + (1 + up) / 3.0) / N, v = (j + (1 + up) / 3.0) / N, path[3];
                for (int k = 0; k < 3; k++) path[k] = t.corner[0][k] + u * sides[0][k] + v * sides[1][k] - at[k];
                double square = dot(path, path), cosine = dot(path, normal) / sqrt(square);
                if (cosine > 0 && square < radius * radius)
                    sum += cosine * fabs(dot(path, m)) / sqrt(square) / (AL_PI * square) * area;
            }
    return sum;
}

static void test_blended(const char *folder)
{
    sphere_scene s;
    al_runtime *runtime = NULL;
    al_error error = {0};
    static float surfaces[PIXELS][4];
    al_frame_block frame;
    sphere_scene_begin(&s);
    s.scene.baked = (al_baked_light){"", ""};
    memcpy(s.meshes[0].positions, corners, sizeof corners);
    memcpy(s.meshes[0].indices, (uint32_t[]){0, 1, 2}, 12);
    s.meshes[0].vertex_count = s.submeshes[0].index_count = s.meshes[0].index_count = 3;
    sphere_scene_add_floor(&s, 3, (float[3]){0, 0, 0});
    memcpy(s.instances[0].world, (float[16]){3, 0, 0, 0, 0, 3, 0, 0, 0, 0, 3, 0, 0, 0, 0, 1}, 64);
    sphere_scene_add_floor(&s, 1, (float[3]){0, 0, 0});
    s.instances[1].mesh = 0;
    CHECK(sphere_scene_write(folder, &s));
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK);
    CHECK(stage_load(runtime, folder));
    sphere_scene_end(&s);
    al_view view = stage_look(EDGE, EDGE, (float[3]){0.5f, 2, 2}, (float[3]){0, 0, 0.1f}, 0.8f);
    for (int i = 0; i < 3; i++) {
        al_settings settings = {.pass = AL_PASS_AMBIENT_OCCLUSION,
                                .occlusion_carrier = AL_CARRIER_VOLUMES_BLENDED,
                                .occlusion_radius_m = i ? 0.2f + 0.3f * (float)i : 0};
        float *pixels = stage_draw(runtime, &view, &settings, 0);
        uint32_t hidden = 0;
        double worst = 0;
        CHECK(pixels != NULL);
        if (!pixels) return;
        CHECK(!runtime->bounce.rays.id && !runtime->bounce.hits.id && !runtime->surfels.cloud.id);
        glGetNamedBufferSubData(runtime->frame_block.id, 0, sizeof frame, &frame);
        glGetTextureImage(runtime->targets.geometry.id, 0, GL_RGBA, GL_FLOAT, sizeof surfaces, surfaces);
        for (uint32_t k = 0; k < PIXELS; k++) {
            const double up[3] = {0, 1, 0};
            if (surfaces[k][1] < 0.999f) continue;
            place p = place_of(&frame, k, surfaces[k], surfaces[k]);
            if (fabs(p.at[1]) > 1e-5) continue; /* the triangle itself */
            double truth = quadrature(p.at, up, i ? (double)settings.occlusion_radius_m : INFINITY);
            hidden += truth > 1e-3;
            worst = fmax(worst, fabs(1 - (double)pixels[3 * k] - truth));
            CHECK_NEAR(1 - (double)pixels[3 * k], truth, 2e-4 + (i ? 4e-3 * truth : 0));
        }
        printf("one triangle hides something from %u pixels, %.2g off at most\n", hidden, worst);
        CHECK(hidden > PIXELS / 10);
        free(pixels);
    }
    al_runtime_destroy(runtime);
}

int main(void)
{
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    const char *folder = stage_folder();
    CHECK(folder != NULL);
    if (!folder) return test_end();
    const float units[] = {1, 1e-4f, 1e4f};
    for (int i = 0; i < 3; i++) test_hits(folder, units[i], i ? 2 : 1);
    test_blended(folder);
    return test_end();
}
