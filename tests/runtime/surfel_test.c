/* The surfel cloud: areas, counts, light, and what it does at the extremes. */
#include <epoxy/gl.h>
#include <stdlib.h>
#include <string.h>

#include "../../runtime/matrix.h"
#include "../../runtime/state.h"
#include "../test.h"
#include "airlight/formulas.h"
#include "airlight/medium.h"
#include "sphere.h"
#include "stage.h"

enum { WIDTH = 80, HEIGHT = 60 };

typedef struct surfel { /* shaders/surfels.glsl */
    float place[3], area, facing[3], roughness, front[3], f0, back[3], albedo; /* f0 and albedo packed */
    uint32_t edges[4];
} surfel;
_Static_assert(sizeof(surfel) == AL_SURFEL_SIZE, "std430");

static const char *folder;

/* --- scenes: triangles in one mesh, shown by one instance --- */

typedef struct triangles {
    float (*corners)[3][3];
    uint32_t count;
} triangles;

/* The square's mesh becomes these triangles, with their geometric normals and uv = x, y. */
static void use_triangles(sphere_scene *s, const triangles *t)
{
    al_mesh *mesh = &s->meshes[1];
    uint32_t count = 3 * t->count;
    free(mesh->positions);
    free(mesh->normals);
    free(mesh->indices);
    mesh->positions = malloc(count * 12 + 1);
    mesh->normals = malloc(count * 12 + 1);
    mesh->indices = malloc(count * 4 + 1);
    mesh->vertex_count = mesh->index_count = s->submeshes[1].index_count = count;
    for (uint32_t i = 0; i < count; i++) {
        const float(*c)[3] = t->corners[i / 3];
        float normal[3], length = 0;
        for (int k = 0; k < 3; k++) {
            int a = (k + 1) % 3, b = (k + 2) % 3;
            normal[k] = (c[1][a] - c[0][a]) * (c[2][b] - c[0][b]) - (c[1][b] - c[0][b]) * (c[2][a] - c[0][a]);
            length += normal[k] * normal[k];
        }
        for (int k = 0; k < 3; k++) {
            mesh->positions[3 * i + (uint32_t)k] = c[i % 3][k];
            mesh->normals[3 * i + (uint32_t)k] = length > 0 ? normal[k] / sqrtf(length) : (float)(k == 1);
        }
        mesh->indices[i] = i;
    }
}

static void add_triangle(triangles *t, const float a[3], const float b[3], const float c[3])
{
    if (!(t->count & (t->count + 1)))
        t->corners = realloc(t->corners, 2 * (t->count + 1) * sizeof *t->corners);
    memcpy(t->corners[t->count][0], a, 12);
    memcpy(t->corners[t->count][1], b, 12);
    memcpy(t->corners[t->count++][2], c, 12);
}

/* p, p + u, p + u + v, p + v, cut into n x n squares of two triangles */
static void add_square(triangles *t, const float p[3], const float u[3], const float v[3], int n)
{
    for (int i = 0; i < n * n; i++) {
        float corners[4][3];
        for (int c = 0; c < 4; c++)
            for (int k = 0; k < 3; k++)
                corners[c][k] = p[k] + ((float)(i % n) + (float)(c & 1)) * u[k] / (float)n +
                                ((float)(i / n) + (float)(c >> 1)) * v[k] / (float)n;
        add_triangle(t, corners[0], corners[1], corners[3]);
        add_triangle(t, corners[0], corners[3], corners[2]);
    }
}

/* A box of the half edges h about `m`, its fronts outwards, each face in n x n squares */
static void add_box(triangles *t, const float m[3], const float h[3], int n)
{
    for (int face = 0; face < 6; face++) {
        int a = face / 2, side = face % 2 ? 1 : -1, b = (a + 1) % 3, c = (a + 2) % 3;
        float p[3], u[3] = {0}, v[3] = {0};
        for (int k = 0; k < 3; k++) p[k] = m[k] - h[k];
        p[a] = m[a] + (float)side * h[a];
        (side > 0 ? u : v)[b] = 2 * h[b];
        (side > 0 ? v : u)[c] = 2 * h[c];
        add_square(t, p, u, v, n);
    }
}

static double total_area(const triangles *t)
{
    double sum = 0;
    for (uint32_t i = 0; i < t->count; i++) {
        double n[3], length = 0;
        for (int k = 0; k < 3; k++) {
            const float(*c)[3] = t->corners[i];
            int a = (k + 1) % 3, b = (k + 2) % 3;
            n[k] = ((double)c[1][a] - c[0][a]) * ((double)c[2][b] - c[0][b]) -
                   ((double)c[1][b] - c[0][b]) * ((double)c[2][a] - c[0][a]);
            length += n[k] * n[k];
        }
        sum += sqrt(length) / 2;
    }
    return sum;
}

typedef struct lamp {
    al_light_type type;
    float vector[3], intensity;
} lamp;

static al_runtime *open_scene(const triangles *t, const lamp *lamps, int lamp_count, float sigma_t)
{
    al_runtime *runtime = NULL;
    al_error error = {0};
    sphere_scene s;
    al_fog fog = {.density = 1, .asset = ""};
    sphere_scene_begin(&s);
    s.scene.baked = (al_baked_light){"", ""};
    if (sigma_t > 0) {
        for (int k = 0; k < 3; k++) {
            s.medium.sigma_s_per_m[k] = 0;
            s.medium.sigma_a_per_m[k] = sigma_t * (float)(k + 1);
        }
        s.scene.fogs = &fog;
        s.scene.fog_count = 1;
    }
    if (t->count) {
        use_triangles(&s, t);
        sphere_scene_add_floor(&s, 1, (float[3]){0, 0, 0});
    }
    for (int i = 0; i < lamp_count; i++)
        sphere_scene_add_light(&s, lamps[i].type, lamps[i].vector, lamps[i].intensity);
    CHECK(sphere_scene_write(folder, &s));
    sphere_scene_end(&s);
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK);
    CHECK(stage_load(runtime, folder));
    return runtime;
}

typedef struct cloud {
    surfel *surfels;
    uint32_t count;
    double area, squares; /* sums of areas and of their squares */
} cloud;

/* Draws a frame and reads the cloud it left. */
static cloud draw_cloud(al_runtime *runtime, const al_view *view, const al_settings *settings)
{
    cloud c = {0};
    float *pixels = stage_draw(runtime, view, settings, 0);
    CHECK(pixels && stage_bad(pixels, (uint64_t)view->width * view->height * 3) == 0);
    free(pixels);
    glGetNamedBufferSubData(runtime->surfels.count.id, 0, sizeof c.count, &c.count);
    CHECK(c.count == al_runtime_surfels(runtime));
    c.surfels = malloc(c.count * sizeof *c.surfels + 1);
    glGetNamedBufferSubData(runtime->surfels.cloud.id, 0, c.count * (GLsizeiptr)sizeof *c.surfels, c.surfels);
    uint32_t bad = 0;
    for (uint32_t i = 0; i < c.count; i++) {
        const float *numbers = c.surfels[i].place;
        for (int k = 0; k < 16; k++) bad += !isfinite(numbers[k]);
        c.area += c.surfels[i].area;
        c.squares += (double)c.surfels[i].area * c.surfels[i].area;
    }
    CHECK(bad == 0);
    return c;
}

/* --- areas and counts --- */

/* A kept surfel's area is max(A, A*), kept with probability p = min(1, A/A*): mean A, variance A max(A, A*) -
 * A^2. They are independent, so the variance of the sum is below the mean of the sum of kept areas' squares,
 * which the cloud itself estimates; the count's is at most the expected count. Four standard deviations of
 * each; and they must be small enough that 1 % would be seen. */
static void test_areas(const char *name, const triangles *t, const al_view *view, float pixels)
{
    al_runtime *runtime = open_scene(t, NULL, 0, 0);
    al_settings settings = {.pass = AL_PASS_SURFELS, .surfel_pixels = pixels};
    cloud c = draw_cloud(runtime, view, &settings);
    double wanted = total_area(t), deviation = sqrt(c.squares),
           expected = al_surfels_expected(al_runtime_scene(runtime), &runtime->surfels.rule);
    printf("%s: %u triangles, %u surfels of %.0f expected, area %.5f of %.5f (%+.2f %%, deviation %.2f %%)\n",
           name, t->count, c.count, expected, c.area, wanted, 100 * (c.area / wanted - 1),
           100 * deviation / wanted);
    CHECK(4 * deviation < 0.01 * wanted);
    CHECK_NEAR(c.area, wanted, 0.01 * wanted);
    CHECK_NEAR(c.area, wanted, 4 * deviation);
    CHECK_NEAR(c.count, expected, 4 * sqrt(expected));
    free(c.surfels);
    al_runtime_destroy(runtime);
}

/* As published in 2014 each triangle keeps all points of its level, of equal areas: 48 of one so large that it wants more,
 * at least 3 of a tiny one. */
static void test_plain(const triangles *t, const al_view *view)
{
    al_runtime *runtime = open_scene(t, NULL, 0, 0);
    al_settings settings = {.pass = AL_PASS_SURFELS, .surfel_pixels = 3, .surfels_plain = true};
    cloud c = draw_cloud(runtime, view, &settings);
    CHECK(t->count < 100 ? c.count == t->count * 48 : c.count >= t->count * 3);
    CHECK_NEAR(c.area, total_area(t), 1e-5 * total_area(t));
    free(c.surfels);
    al_runtime_destroy(runtime);
}

/* From inside a box of two triangles a side, of very small ones, and of needles 2 m long and 1 mm wide; of
 * each side, one half shows its back. */
static void test_shapes(void)
{
    triangles huge = {0}, tiny = {0}, thin = {0};
    const float middle[3] = {0, 0, 0}, half[3] = {1, 1, 1}, flat[3] = {1, 1, -1};
    al_view inside = stage_look(800, 600, (float[3]){0.1f, 0.2f, 0.9f}, (float[3]){0, 0, -1}, 0.7f);
    add_box(&huge, middle, half, 1);
    test_areas("huge", &huge, &inside, 3);
    test_plain(&huge, &inside);
    add_box(&tiny, middle, half, 100);
    test_areas("tiny", &tiny, &inside, 3);
    test_plain(&tiny, &inside);
    add_box(&tiny, middle, flat, 20); /* fronts inwards: about as many surfels in each triangle as can be */
    test_areas("mixed", &tiny, &inside, 3);
    for (int i = 0; i < 1000; i++) {
        float x = 2e-3f * (float)i - 1, z = (float)(i % 20) / 10 - 1;
        add_triangle(&thin, (float[3]){x, -1, z}, (float[3]){x + 1e-3f, -1, z}, (float[3]){x, 1, z + 0.01f});
        add_triangle(&thin, (float[3]){-1, x, z}, (float[3]){-1, x + 1e-3f, z}, (float[3]){1, x, z + 0.01f});
    }
    test_areas("thin", &thin, &inside, 1);
    free(huge.corners);
    free(tiny.corners);
    free(thin.corners);
}

static al_view front_view(void)
{
    return stage_look(WIDTH, HEIGHT, (float[3]){0, 1, 4}, (float[3]){0, 0, 0}, 0.7f);
}

static const al_settings shown = {.pass = AL_PASS_SURFELS, .surfel_pixels = 1};

/* Seen orthographically one triangle wants the same area everywhere: of c surfels' worth, the integers next
 * to c are kept, whatever the level. That is so only if each point of the tessellator's pattern gets a number
 * of its own. */
static void test_numbers(void)
{
    triangles t = {0};
    add_triangle(&t, (float[3]){-1, -1, 0}, (float[3]){1, -1, 0}, (float[3]){0.3f, 0.8f, 0.4f});
    al_runtime *runtime = open_scene(&t, NULL, 0, 0);
    al_view view = stage_ortho(WIDTH, HEIGHT, 1);
    double area = total_area(&t), pixel = 4.0 / (WIDTH * HEIGHT);
    for (int wanted = 1; wanted < 48; wanted++) {
        al_settings settings = {.pass = AL_PASS_SURFELS,
                                .surfel_pixels = (float)sqrt(area / (wanted + 0.5) / AL_PI / pixel)};
        cloud c = draw_cloud(runtime, &view, &settings);
        CHECK(c.count == (uint32_t)wanted || c.count == (uint32_t)wanted + 1);
        for (uint32_t i = 0; i < c.count; i++) CHECK_NEAR(c.surfels[i].area * (wanted + 0.5) / area, 1, 1e-5);
        free(c.surfels);
    }
    al_runtime_destroy(runtime);
    free(t.corners);
}

/* Places are even over a triangle: the mean of n is its middle, within four standard errors of a coordinate
 * whose variance over the triangle is (sum of squares of the corners' offsets from the middle) / 12; and as
 * many lie in each of its four halves-by-halves. */
static void test_places(void)
{
    const float corners[3][3] = {{-1, -1, 0}, {1, -1, 0}, {0.3f, 0.8f, 0.4f}};
    triangles t = {0};
    add_triangle(&t, corners[0], corners[1], corners[2]);
    al_runtime *runtime = open_scene(&t, NULL, 0, 0);
    al_view view = stage_ortho(800, 600, 1);
    cloud c = draw_cloud(runtime, &view, &(al_settings){.pass = AL_PASS_SURFELS, .surfel_pixels = 2});
    CHECK(c.count > 10000);
    for (int k = 0; k < 2; k++) {
        double middle = 0, variance = 0, mean = 0;
        for (int i = 0; i < 3; i++) middle += corners[i][k] / 3.0;
        for (int i = 0; i < 3; i++) variance += pow(corners[i][k] - middle, 2) / 12;
        for (uint32_t i = 0; i < c.count; i++) mean += c.surfels[i].place[k] / c.count;
        CHECK_NEAR(mean, middle, 4 * sqrt(variance / c.count));
    }
    double quarter = 0; /* above half of the height: a triangle of half the size */
    for (uint32_t i = 0; i < c.count; i++) quarter += c.surfels[i].place[1] > -0.1f;
    CHECK_NEAR(quarter / c.count, 0.25, 4 * sqrt(0.25 * 0.75 / c.count));
    free(c.surfels);
    al_runtime_destroy(runtime);
    free(t.corners);
}

/* The same view leaves the same bytes: again, and in another runtime. */
static void test_same(void)
{
    triangles t = {0};
    add_box(&t, (float[3]){0, 0, 0}, (float[3]){1, 0.7f, 0.4f}, 3);
    const lamp lamps[] = {{AL_LIGHT_POINT, {0, 2, 3}, 5}};
    al_view view = front_view();
    al_runtime *runtime = open_scene(&t, lamps, 1, 0.3f);
    cloud first = draw_cloud(runtime, &view, &shown);
    al_view other = stage_look(WIDTH, HEIGHT, (float[3]){3, 1, 1}, (float[3]){0, 0, 0}, 0.5f);
    free(draw_cloud(runtime, &other, &shown).surfels);
    cloud second = draw_cloud(runtime, &view, &shown);
    al_runtime_destroy(runtime);
    runtime = open_scene(&t, lamps, 1, 0.3f);
    cloud third = draw_cloud(runtime, &view, &shown);
    CHECK(first.count > 100 && first.count == second.count && first.count == third.count);
    CHECK(!memcmp(first.surfels, second.surfels, first.count * sizeof(surfel)) &&
          !memcmp(first.surfels, third.surfels, first.count * sizeof(surfel)));
    free(first.surfels);
    free(second.surfels);
    free(third.surfels);
    al_runtime_destroy(runtime);
    free(t.corners);
}

/* --- light --- */

/* shaders/packed_color.glsl */
static float packed(double r, double g, double b)
{
    return (float)(floor(sqrt(r) * 255 + 0.5) + 256 * floor(sqrt(g) * 255 + 0.5) + 65536 * floor(sqrt(b) * 255 + 0.5));
}

/* A floor at y = 0, and above its half x > 0 a square that hides it from a lamp at y = 1. */
static triangles make_floor(void)
{
    triangles t = {0};
    add_square(&t, (float[3]){-1, 0, -1}, (float[3]){0, 0, 2}, (float[3]){2, 0, 0}, 1);
    add_square(&t, (float[3]){0, 0.5f, -1}, (float[3]){0, 0, 2}, (float[3]){1, 0, 0}, 1);
    return t;
}

/* How far from the closed form, relative to it, the light is: a lamp at (0, 1, 0), fog of c + 1 tenths per
 * metre in channel c, albedo 1: L = I cos / (pi d^2) exp(-sigma d) above, nothing below and in the shadow,
 * whose rim is as wide as a few texels of the shadow map. */
static void test_point(void)
{
    const double intensity = 7;
    const lamp lamps[] = {{AL_LIGHT_POINT, {0, 1, 0}, 7}};
    triangles t = make_floor();
    al_runtime *runtime = open_scene(&t, lamps, 1, 0.1f);
    al_view view = front_view();
    cloud c = draw_cloud(runtime, &view, &shown);
    int lit = 0, dark = 0;
    double worst = 0;
    for (uint32_t i = 0; i < c.count; i++) {
        const surfel *s = &c.surfels[i];
        bool floor = s->place[1] < 0.25f, hidden = floor && s->place[0] > 0;
        double h = 1 - s->place[1], d = sqrt(s->place[0] * s->place[0] + h * h + s->place[2] * s->place[2]);
        CHECK_NEAR(s->facing[1], 1, 1e-6);
        CHECK(s->roughness == 1 && s->f0 == 0 && s->albedo == packed(1, 1, 1) && s->back[0] == 0 && s->back[1] == 0 && s->back[2] == 0);
        if (floor && fabsf(s->place[0]) < 0.03f) continue;
        (hidden ? dark++ : lit++);
        for (int k = 0; k < 3; k++) {
            double wanted = intensity * h / (AL_PI * d * d * d) * exp(-0.1 * (k + 1) * d);
            if (hidden)
                CHECK(s->front[k] == 0);
            else
                worst = fmax(worst, fabs(s->front[k] / wanted - 1));
        }
    }
    printf("point lamp: %d lit surfels, %d in the shadow, %.1e from the closed form\n", lit, dark, worst);
    CHECK(lit > 100 && dark > 100 && worst < 1e-5); /* some 20 roundings of floats */
    free(c.surfels);
    al_runtime_destroy(runtime);
    free(t.corners);
}

/* Directional light from below on backs, a metal, emission from one side and from both, a mirrored instance.
 */
static void test_sides(void)
{
    const float down[3] = {0, -0.6f, 0.8f}, up[3] = {0, 1, 0};
    lamp lamps[] = {{AL_LIGHT_DIRECTIONAL, {0}, 3}, {AL_LIGHT_DIRECTIONAL, {0}, 2}};
    memcpy(lamps[0].vector, down, sizeof down);
    memcpy(lamps[1].vector, up, sizeof up);
    triangles t = {0};
    add_square(&t, (float[3]){-1, 0, -1}, (float[3]){0, 0, 2}, (float[3]){2, 0, 0}, 1);
    al_runtime *runtime = open_scene(&t, lamps, 2, 0);
    al_scene *scene = al_runtime_scene(runtime);
    al_material *m = &scene->materials[1];
    al_view view = front_view();
    m->base_color[0] = 0.5f;
    m->base_color[1] = 0.25f;
    m->metallic = 0.5f;
    m->emission_w_m2_sr[1] = 10;
    for (int form = 0; form < 3; form++) {
        m->double_sided = form != 1;
        if (form == 2) scene->instances[0].world[0] = -1;
        cloud c = draw_cloud(runtime, &view, &shown);
        CHECK(c.count > 10);
        for (uint32_t i = 0; i < c.count; i++) {
            const surfel *s = &c.surfels[i];
            CHECK_NEAR(s->facing[1], 1, 1e-6);
            CHECK_NEAR(s->front[0], 0.25 / AL_PI * 3 * 0.6, 1e-6);
            CHECK_NEAR(s->back[0], 0.25 / AL_PI * 2, 1e-6);
            CHECK_NEAR(s->front[1], 0.125 / AL_PI * 3 * 0.6 + 10, 1e-5);
            CHECK_NEAR(s->back[1], 0.125 / AL_PI * 2 + (form == 1 ? 0 : 10), 1e-5);
            CHECK(s->albedo == packed(0.25, 0.125, 0.5));
            CHECK(s->f0 == packed(0.25, 0.125, 0.5));
        }
        free(c.surfels);
    }
    al_runtime_destroy(runtime);
    free(t.corners);
}

static al_status even_slice(void *user, uint32_t frame, uint32_t z, float *density, al_error *error)
{
    (void)user, (void)frame, (void)z, (void)error;
    for (int i = 0; i < 12 * 12; i++) density[i] = 1;
    return AL_OK;
}

/* A box of 1.2 m, its middle at y = 1, holds a grid of density 1; the sun shines down through it. */
static al_runtime *open_under_box(const triangles *t, const al_motion *motion)
{
    char path[512];
    al_error error = {0};
    sphere_scene s;
    al_runtime *runtime = NULL;
    al_fog fog = {.bounded = true, .density = 1, .asset = "fog.medium.air"};
    al_medium_data data = {.info = {.size = {12, 12, 12}, .page_size = 3, .frame_count = 1},
                           .slice = even_slice};
    for (int k = 0; k < 3; k++) {
        fog.bounds_min_m[k] = data.info.bounds_min_m[k] = -0.6f + (float)(k == 1);
        fog.bounds_max_m[k] = data.info.bounds_max_m[k] = 0.6f + (float)(k == 1);
        data.info.sigma_a_per_m[k] = 0.5f * (float)(k + 1);
        data.info.grid_to_world[5 * k] = 0.1f;
        data.info.grid_to_world[12 + k] = fog.bounds_min_m[k] + 0.05f;
    }
    data.info.grid_to_world[15] = 1;
    snprintf(path, sizeof path, "%s/fog.medium.air", folder);
    CHECK(al_medium_write(path, &data, NULL, &error) == AL_OK);
    sphere_scene_begin(&s);
    s.scene.baked = (al_baked_light){"", ""};
    s.scene.fogs = &fog;
    s.scene.fog_count = 1;
    if (motion) s.scene.motion = *motion;
    use_triangles(&s, t);
    sphere_scene_add_floor(&s, 1, (float[3]){0, 0, 0});
    sphere_scene_add_light(&s, AL_LIGHT_DIRECTIONAL, (float[3]){0, -1, 0}, (float)AL_PI);
    CHECK(sphere_scene_write(folder, &s));
    sphere_scene_end(&s);
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK && stage_load(runtime, folder));
    return runtime;
}

/* All surfels of `c` lie at `height` and get what the box leaves of the sun: the march finds it within the
 * half floats of its bricks, 2^-11 of an optical depth of 1.8, and the rounding of 24 steps. */
static void check_under_box(const cloud *c, double height)
{
    int under = 0;
    for (uint32_t i = 0; i < c->count; i++) {
        const surfel *f = &c->surfels[i];
        bool below = fabsf(f->place[0]) < 0.6f && fabsf(f->place[2]) < 0.6f;
        under += below;
        CHECK_NEAR(f->place[1], height, 1e-6);
        for (int k = 0; k < 3; k++)
            CHECK_NEAR(f->front[k] / (below ? exp(-0.6 * (k + 1)) : 1), 1, below ? 1e-3 : 1e-6);
    }
    CHECK(under > 50 && under < (int)c->count);
}

static void test_grid(void)
{
    triangles t = {0};
    add_square(&t, (float[3]){-1, 0, -1}, (float[3]){0, 0, 2}, (float[3]){2, 0, 0}, 1);
    al_runtime *runtime = open_under_box(&t, NULL);
    al_view view = front_view();
    cloud c = draw_cloud(runtime, &view, &shown);
    check_under_box(&c, 0);
    free(c.surfels);
    al_runtime_destroy(runtime);
    free(t.corners);
}

/* A morph target makes the floor twice as large and lowers it by 1 m: surfels follow, in place and number. */
static void test_morphed(void)
{
    static float times[] = {0, 1, 2}, weights[] = {0, 1, 0}, positions[6][3], normals[6][3], deltas[6][3],
                 turns[6][3];
    al_motion_node node = {"",  AL_NO_INDEX,  {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1},
                           {0}, {0, 0, 0, 1}, {1, 1, 1}};
    al_motion_channel channel = {0, AL_MOTION_WEIGHTS, AL_MOTION_LINEAR, 3, 1, times, weights};
    al_motion_deform deform = {.target_count = 1,
                               .bind_positions = positions[0],
                               .bind_normals = normals[0],
                               .has_normals = true,
                               .position_deltas = deltas[0],
                               .normal_deltas = turns[0]};
    al_motion motion = {.node_count = 1,
                        .channel_count = 1,
                        .deform_count = 1,
                        .nodes = &node,
                        .channels = &channel,
                        .deforms = &deform};
    triangles t = {0};
    add_square(&t, (float[3]){-0.5f, 0, -0.5f}, (float[3]){0, 0, 1}, (float[3]){1, 0, 0}, 1);
    for (int i = 0; i < 6; i++) {
        memcpy(positions[i], t.corners[i / 3][i % 3], sizeof positions[i]);
        memcpy(deltas[i], positions[i], sizeof deltas[i]);
        normals[i][1] = 1;
        deltas[i][1] = -1;
        for (int k = 0; k < 3; k++) turns[i][k] = 0.1f;
    }
    al_runtime *runtime = open_under_box(&t, &motion);
    al_view view = front_view();
    for (int i = 1; i < 3; i++) {
        al_runtime_set_time(runtime, i / 2.0);
        free(draw_cloud(runtime, &view, &shown).surfels); /* finds out how many there are */
        al_runtime_set_time(runtime, i / 2.0 + 2);
        cloud c = draw_cloud(runtime, &view, &shown);
        double edge = 1 + i / 2.0;
        CHECK_NEAR(c.area, edge * edge, 4 * sqrt(c.squares));
        check_under_box(&c, -i / 2.0);
        free(c.surfels);
    }
    al_runtime_set_time(runtime, 0.75); /* a new pose and its light in the same frame */
    cloud c = draw_cloud(runtime, &view, &shown);
    check_under_box(&c, -0.75);
    free(c.surfels);
    al_runtime_destroy(runtime);
    free(t.corners);
}

/* The picture of a floor's discs: each pixel shows the floor's light or nothing, from above and from below.
 */
static void test_picture(void)
{
    const lamp lamps[] = {{AL_LIGHT_DIRECTIONAL, {0, -1, 0}, 3}, {AL_LIGHT_DIRECTIONAL, {0, 1, 0}, 2}};
    triangles t = {0};
    add_square(&t, (float[3]){-1, 0, -1}, (float[3]){0, 0, 2}, (float[3]){2, 0, 0}, 1);
    al_runtime *runtime = open_scene(&t, lamps, 2, 0);
    for (int below = 0; below < 2; below++) {
        al_view view =
            stage_look(WIDTH, HEIGHT, (float[3]){0, below ? -2 : 2, 0.1f}, (float[3]){0, 0, 0}, 0.7f);
        float *pixels = stage_draw(runtime, &view, &shown, 0);
        int covered = 0;
        for (int i = 0; i < WIDTH * HEIGHT * 3 && pixels; i++) {
            if (pixels[i] == 0) continue;
            covered++;
            CHECK_NEAR(pixels[i] * AL_PI, below ? 2 : 3, 1e-6);
        }
        CHECK(covered > WIDTH * HEIGHT * 3 / 2 && covered < WIDTH * HEIGHT * 3);
        free(pixels);
    }
    al_runtime_destroy(runtime);
    free(t.corners);
}

/* Under the middle of a translucent sphere of radius 0.5 m and 2 per metre, a floor gets exp(-2) of the sun;
 * beside it all. Within what casters' marches through 64 voxels give: a step of 1/64 m at each end, and the
 * chord falls by 0.3 % towards 4 cm from the middle. */
static void test_caster(void)
{
    triangles t = {0};
    sphere_scene s;
    al_runtime *runtime = NULL;
    al_error error = {0};
    add_square(&t, (float[3]){-1, 0, -1}, (float[3]){0, 0, 2}, (float[3]){2, 0, 0}, 1);
    sphere_scene_begin(&s);
    s.scene.baked = (al_baked_light){"", ""};
    CHECK(sphere_write_asset(folder, "sphere.air", &(sphere_options){.radius = 0.5f, .samples = 500}));
    sphere_scene_add(&s, "sphere.air", 0.5f, (float[3]){0, 1, 0});
    use_triangles(&s, &t);
    sphere_scene_add_floor(&s, 1, (float[3]){0, 0, 0});
    sphere_scene_add_light(&s, AL_LIGHT_DIRECTIONAL, (float[3]){0, -1, 0}, (float)AL_PI);
    CHECK(sphere_scene_write(folder, &s));
    sphere_scene_end(&s);
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK && stage_load(runtime, folder));
    al_view view = stage_look(800, 600, (float[3]){0, 1, 4}, (float[3]){0, 0, 0}, 0.7f);
    cloud c = draw_cloud(runtime, &view, &shown);
    int under = 0;
    for (uint32_t i = 0; i < c.count; i++) {
        double away = hypot(c.surfels[i].place[0], c.surfels[i].place[2]);
        if (away > 0.04 && away < 0.55) continue;
        CHECK_NEAR(c.surfels[i].front[0] / (away < 0.04 ? exp(-2) : 1), 1,
                   away < 0.04 ? 4.0 / 64 + 0.01 : 1e-6);
        under += away < 0.04;
    }
    CHECK(under > 10);
    free(c.surfels);
    al_runtime_destroy(runtime);
    free(t.corners);
}

/* A texture: squares of albedo 0 and 0.8, one texel each, seen from where a surfel covers many: the mean, and
 * each between the extremes. */
static void test_texture(void)
{
    enum { TEXELS = 256 };
    static uint8_t pixels[TEXELS * TEXELS * 4];
    static float uvs[12];
    for (int i = 0; i < TEXELS * TEXELS * 4; i++) pixels[i] = (i / 4 + i / 4 / TEXELS) % 2 ? 204 : 0;
    al_texture texture = {.name = "squares", .width = TEXELS, .height = TEXELS, .pixels = pixels};
    triangles t = {0};
    add_square(&t, (float[3]){-1, 0, -1}, (float[3]){0, 0, 2}, (float[3]){2, 0, 0}, 1);
    for (int i = 0; i < 6; i++) {
        uvs[2 * i] = (t.corners[i / 3][i % 3][0] + 1) / 2;
        uvs[2 * i + 1] = (t.corners[i / 3][i % 3][2] + 1) / 2;
    }
    sphere_scene s;
    al_runtime *runtime = NULL;
    al_error error = {0};
    sphere_scene_begin(&s);
    s.scene.baked = (al_baked_light){"", ""};
    s.scene.textures = &texture;
    s.scene.texture_count = 1;
    use_triangles(&s, &t);
    s.meshes[1].uv0 = uvs;
    s.materials[1].base_color_texture = 0;
    sphere_scene_add_floor(&s, 1, (float[3]){0, 0, 0});
    sphere_scene_add_light(&s, AL_LIGHT_DIRECTIONAL, (float[3]){0, -1, 0}, (float)AL_PI);
    CHECK(sphere_scene_write(folder, &s));
    sphere_scene_end(&s);
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK && stage_load(runtime, folder));
    al_view view = front_view();
    cloud c = draw_cloud(runtime, &view, &shown); /* of 9 mm and more: a texel is 8 mm */
    double sum = 0;
    for (uint32_t i = 0; i < c.count; i++) {
        sum += c.surfels[i].front[0] / c.count;
        CHECK(c.surfels[i].front[0] > 0.3 && c.surfels[i].front[0] < 0.5);
    }
    CHECK_NEAR(sum, 0.4, 0.01);
    free(c.surfels);
    al_runtime_destroy(runtime);
    free(t.corners);
}

/* --- room and extremes --- */

/* The camera comes closer, in steps too small for a cut: a frame shows no more than the buffer holds, and a
 * few frames later all. After a cut that is so at once. Then more than the limit: surfels get larger, and
 * small again without it. Areas stay right. */
static void test_room(void)
{
    triangles t = {0};
    add_box(&t, (float[3]){0, 0, 0}, (float[3]){1, 1, 1}, 4);
    al_runtime *runtime = open_scene(&t, NULL, 0, 0);
    al_view far = stage_look(800, 600, (float[3]){0, 0, 90}, (float[3]){0, 0, 0}, 0.7f),
            near = stage_look(800, 600, (float[3]){0, 0, 3}, (float[3]){0, 0, 0}, 0.7f);
    free(draw_cloud(runtime, &far, &(al_settings){.pass = AL_PASS_SURFELS}).surfels);
    uint64_t room = runtime->surfels.cloud.size / AL_SURFEL_SIZE, full = 0;
    cloud c = {0};
    for (float away = 90; away > 3; away = 1 + (away - 1) * 0.6f) {
        al_view view = stage_look(800, 600, (float[3]){0, 0, away}, (float[3]){0, 0, 0}, 0.7f);
        c = draw_cloud(runtime, &view, &(al_settings){.pass = AL_PASS_SURFELS});
        full += c.count == runtime->surfels.cloud.size / AL_SURFEL_SIZE;
        free(c.surfels);
    }
    CHECK(full > 2);
    c.surfels = NULL;
    for (int frame = 0; frame < AL_SURFEL_RING + 1; frame++) {
        free(c.surfels);
        glFinish();
        c = draw_cloud(runtime, &near, &(al_settings){.pass = AL_PASS_SURFELS});
    }
    double expected = al_surfels_expected(al_runtime_scene(runtime), &runtime->surfels.rule);
    CHECK(c.count > 10 * room);
    CHECK_NEAR(c.count, expected, 4 * sqrt(expected));
    CHECK_NEAR(c.area, 24, 4 * sqrt(c.squares));
    free(c.surfels);
    for (int limited = 1; limited >= 0; limited--) {
        al_settings settings = {.pass = AL_PASS_SURFELS, .surfel_limit = limited ? 2000 : 0};
        for (int frame = 0; frame < AL_SURFEL_RING + 2; frame++) {
            glFinish();
            c = draw_cloud(runtime, &near, &settings);
            free(c.surfels);
        }
        CHECK(limited ? c.count <= 2000 && c.count > 1500 : c.count > 10 * room);
        CHECK((runtime->surfels.coarseness > 1) == limited);
        CHECK_NEAR(c.area, 24, 4 * sqrt(c.squares));
    }
    al_runtime_destroy(runtime);
    runtime = open_scene(&t, NULL, 0, 0);
    free(draw_cloud(runtime, &far, &(al_settings){.pass = AL_PASS_SURFELS}).surfels);
    c = draw_cloud(runtime, &near, &(al_settings){.pass = AL_PASS_SURFELS}); /* a cut */
    CHECK_NEAR(c.count, expected, 4 * sqrt(expected));
    free(c.surfels);
    al_runtime_destroy(runtime);
    runtime = open_scene(&t, NULL, 0, 0); /* the limit from the first frame on */
    c = draw_cloud(runtime, &near, &(al_settings){.pass = AL_PASS_SURFELS, .surfel_limit = 2000});
    CHECK(c.count <= 2000 && c.count > 1500);
    CHECK_NEAR(c.area, 24, 4 * sqrt(c.squares));
    free(c.surfels);
    al_runtime_destroy(runtime);
    free(t.corners);
}

/* With a margin the cloud is the part of the whole one that lies within it, in the same order: planes in double
 * precision; float32 may decide either way within 1e-5 m of one. */
static void test_margin(void)
{
    triangles t = {0};
    add_square(&t, (float[3]){-4, 0, -4}, (float[3]){0, 0, 8}, (float[3]){8, 0, 0}, 1);
    al_runtime *runtime = open_scene(&t, NULL, 0, 0);
    al_view view = stage_look(160, 120, (float[3]){0, 1, 2}, (float[3]){0, 0, 0}, 0.7f);
    cloud all = draw_cloud(runtime, &view, &(al_settings){.pass = AL_PASS_SURFELS});
    const float margin = 0.5f;
    cloud some = draw_cloud(runtime, &view, &(al_settings){.pass = AL_PASS_SURFELS, .surfel_margin_m = margin});
    double clip[16], v[16], p[16];
    al_matrix_from_float(view.view, v);
    al_matrix_from_float(view.projection, p);
    al_matrix_multiply(p, v, clip);
    uint32_t next = 0, left_out = 0;
    for (uint32_t i = 0; i < all.count; i++) {
        double nearest = INFINITY;
        for (int plane = 0; plane < 5; plane++) {
            double c[4], length = 0, away = 0;
            for (int k = 0; k < 4; k++)
                c[k] = clip[4 * k + 3] + (plane & 1 ? -1 : 1) * clip[4 * k + plane / 2];
            for (int k = 0; k < 3; k++) {
                length += c[k] * c[k];
                away += c[k] * (double)all.surfels[i].place[k];
            }
            nearest = fmin(nearest, (away + c[3]) / sqrt(length) + (double)margin);
        }
        bool kept = next < some.count && !memcmp(&all.surfels[i], &some.surfels[next], sizeof *all.surfels);
        next += kept;
        left_out += !kept;
        if (fabs(nearest) > 1e-5) CHECK(kept == (nearest > 0));
    }
    CHECK(next == some.count);
    CHECK(some.count > 100 && left_out > 100);
    free(all.surfels);
    free(some.surfels);
    al_runtime_destroy(runtime);
    free(t.corners);
}

/* An eye on a wall of two triangles, and 1 mm above it, its near plane at 1 cm: not many more surfels than
 * from 1 m, none larger than a hundredth of the wall within 10 cm, and all of the area. */
static void test_wall(void)
{
    triangles t = {0};
    add_square(&t, (float[3]){-1, 0, -1}, (float[3]){0, 0, 2}, (float[3]){2, 0, 0}, 1);
    al_runtime *runtime = open_scene(&t, NULL, 0, 0);
    static const float heights[] = {1, 1e-3f, 0};
    uint32_t before = 0;
    for (int i = 0; i < 3; i++) {
        const float eye[3] = {0.3f, heights[i], 0.2f};
        al_view view = stage_look(800, 600, eye, (float[3]){0, heights[i] / 2, 0}, 0.7f);
        cloud c = draw_cloud(runtime, &view, &(al_settings){.pass = AL_PASS_SURFELS});
        double expected = al_surfels_expected(al_runtime_scene(runtime), &runtime->surfels.rule);
        printf("eye at %g m: %u surfels of %.0f expected\n", (double)heights[i], c.count, expected);
        CHECK_NEAR(c.area, 4, 4 * sqrt(c.squares));
        CHECK(c.count > before && c.count < expected + 4 * sqrt(expected));
        if (i) CHECK(c.count < 20 * before);
        if (!i) before = c.count;
        for (uint32_t k = 0; k < c.count && i; k++) {
            double x = c.surfels[k].place[0] - eye[0], z = c.surfels[k].place[2] - eye[2];
            if (sqrt(x * x + z * z) < 0.1) CHECK(c.surfels[k].area < 1e-4);
        }
        free(c.surfels);
    }
    al_runtime_destroy(runtime);
    free(t.corners);
}

/* Triangles without area are no surfels, and the others are what they are without them. */
static void test_flat(void)
{
    triangles t = {0};
    const float a[3] = {0, 0, 0}, b[3] = {1, 0, 0}, c[3] = {2, 0, 0}, d[3] = {0, 1e-25f, 0};
    add_triangle(&t, a, a, a);
    add_triangle(&t, a, b, b);
    add_triangle(&t, a, b, c);
    add_triangle(&t, a, b, d);
    add_square(&t, (float[3]){-1, 0, -1}, (float[3]){0, 0, 2}, (float[3]){2, 0, 0}, 1);
    al_runtime *runtime = open_scene(&t, NULL, 0, 0);
    al_view view = front_view();
    cloud kept = draw_cloud(runtime, &view, &shown);
    CHECK(kept.count > 100);
    CHECK_NEAR(kept.area, 4, 4 * sqrt(kept.squares));
    free(kept.surfels);
    al_runtime_destroy(runtime);
    t.count = 4;
    runtime = open_scene(&t, NULL, 0, 0);
    kept = draw_cloud(runtime, &view, &shown);
    CHECK(kept.count == 0);
    free(kept.surfels);
    al_runtime_destroy(runtime);
    free(t.corners);
}

/* A scene of 1e-4 m and one of 1e4 m, each as seen from as many times its size: the same cloud but for
 * rounding. */
static void test_scales(void)
{
    for (int exponent = -4; exponent <= 4; exponent += 8) {
        float size = powf(10, (float)exponent);
        triangles t = {0};
        add_box(&t, (float[3]){0, 0, 0}, (float[3]){size, size, size}, 2);
        al_runtime *runtime = open_scene(&t, NULL, 0, 0);
        al_view view =
            stage_look(WIDTH, HEIGHT, (float[3]){0, 2 * size, 3 * size}, (float[3]){0, 0, 0}, 0.7f);
        view.projection[10] = -1; /* from 1e-3 of the size to infinity */
        view.projection[14] = -2e-3f * size;
        cloud c = draw_cloud(runtime, &view, &shown);
        double area = 24 * (double)size * size,
               expected = al_surfels_expected(al_runtime_scene(runtime), &runtime->surfels.rule);
        CHECK_NEAR(expected, 4154, 4); /* a thousandth: float matrices */
        CHECK_NEAR(c.count, expected, 4 * sqrt(expected));
        CHECK_NEAR(c.area, area, 4 * sqrt(c.squares));
        free(c.surfels);
        al_runtime_destroy(runtime);
        free(t.corners);
    }
}

/* 64 lamps in one place are one of 64 times their strength (without shadows: each of 64 maps has fewer
 * texels); on a surface they are no brighter than from 2^-20 of the scene's size, the root of 8.25 m. */
static void test_lamps(void)
{
    const al_settings settings = {.pass = AL_PASS_SURFELS, .surfel_pixels = 1, .shadows_off = true};
    lamp lamps[64];
    triangles t = make_floor();
    al_view view = front_view();
    for (int on = 0; on < 2; on++) {
        for (int i = 0; i < 64; i++) lamps[i] = (lamp){AL_LIGHT_POINT, {-0.5f, on ? 0 : 1, 0}, 1e6f};
        al_runtime *runtime = open_scene(&t, lamps, 64, 0);
        cloud many = draw_cloud(runtime, &view, &settings);
        al_scene *scene = al_runtime_scene(runtime);
        scene->light_count = 1;
        for (int k = 0; k < 3; k++) scene->lights[0].intensity[k] = 64e6f;
        cloud one = draw_cloud(runtime, &view, &settings);
        CHECK(one.count == many.count && one.count > 100);
        for (uint32_t i = 0; i < one.count; i++) { /* 64 additions of floats */
            CHECK_NEAR(many.surfels[i].front[0], one.surfels[i].front[0],
                       64 * 0x1p-24 * one.surfels[i].front[0]);
            CHECK(one.surfels[i].front[0] <= 64e6f / (float)AL_PI * 0x1p40f / 8.25f);
        }
        free(many.surfels);
        free(one.surfels);
        al_runtime_destroy(runtime);
    }
    free(t.corners);
}

static void test_wrong(void)
{
    static const al_settings wrong[] = {{.surfel_pixels = -1},    {.surfel_pixels = NAN},
                                        {.surfel_pixels = 0.01f}, {.surfel_pixels = 1e4f},
                                        {.surfel_limit = 63},     {.surfel_limit = (1 << 22) + 1},
                                        {.surfel_margin_m = -1}};
    triangles none = {0};
    al_runtime *runtime = open_scene(&none, NULL, 0, 0);
    al_view view = front_view();
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        al_error error = {0};
        CHECK(al_runtime_draw(runtime, &view, &wrong[i], 0, 0, &error) == AL_USAGE);
        CHECK(strstr(error.message, i < 4 ? "use 0.1 to 1000" : i < 6 ? "use 64 to 4194304" : "use 1e-6 to 1e6"));
    }
    al_runtime_destroy(runtime);
}

static bool find_row(al_runtime *runtime, al_plan_row *row)
{
    uint32_t count;
    const al_plan_row *rows = al_runtime_plan(runtime, &count);
    for (uint32_t i = 0; i < count; i++)
        if (!strcmp(rows[i].step, "surfels")) return *row = rows[i], true;
    return false;
}

/* Without opaque meshes, fog or any light there is no pass, no row that asks for one and not a byte; switched
 * off, likewise. */
static void test_plan(void)
{
    const lamp lamps[] = {{AL_LIGHT_POINT, {0, 2, 3}, 5}};
    triangles t = make_floor(), none = {0};
    al_view view = front_view();
    const struct {
        const triangles *t;
        int lamps;
        float sigma_t;
        bool needed;
    } cases[] = {{&t, 1, 0.1f, true},
                 {&t, 0, 0.1f, false},
                 {&t, 1, 0, false},
                 {&none, 1, 0.1f, false},
                 {&none, 0, 0, false}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        al_plan_row row = {0};
        al_runtime *runtime = open_scene(cases[i].t, lamps, cases[i].lamps, cases[i].sigma_t);
        for (int off = 1; off >= 0; off--) {
            al_settings settings = {.surface_scattering_off = off};
            float *pixels = stage_draw(runtime, &view, &settings, 0);
            CHECK(pixels && stage_bad(pixels, WIDTH * HEIGHT * 3) == 0);
            free(pixels);
            CHECK(find_row(runtime, &row) && row.needed == (cases[i].needed && !off));
            CHECK((row.bytes > 0) == (cases[i].needed && !off));
            CHECK((al_runtime_surfels(runtime) > 0) == (cases[i].needed && !off));
        }
        if (cases[i].t == &none) { /* shown all the same: black */
            float *pixels = stage_draw(runtime, &view, &shown, 0);
            CHECK(pixels && stage_sum(pixels, WIDTH * HEIGHT * 3) == 0 && al_runtime_surfels(runtime) == 0);
            free(pixels);
        }
        al_runtime_destroy(runtime);
    }
    free(t.corners);
}

int main(void)
{
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    folder = stage_folder();
    if (!folder) return test_skip("no temporary folder");
    test_numbers();
    test_places();
    test_same();
    test_point();
    test_sides();
    test_grid();
    test_morphed();
    test_picture();
    test_caster();
    test_texture();
    test_room();
    test_margin();
    test_wall();
    test_flat();
    test_scales();
    test_lamps();
    test_wrong();
    test_plan();
    test_shapes();
    return test_end();
}
