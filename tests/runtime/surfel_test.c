/* The surfel cloud: areas, counts, light, and what it does at the extremes. */
#include <epoxy/gl.h>
#include <stdlib.h>
#include <string.h>

#include "../../runtime/state.h"
#include "../test.h"
#include "sphere.h"
#include "stage.h"

enum { WIDTH = 80, HEIGHT = 60 };

typedef struct surfel { /* shaders/surfels.glsl */
    float place[3], area, facing[3], roughness, front[3], metallic, back[3], unused;
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
    if (!(t->count & (t->count + 1))) t->corners = realloc(t->corners, 2 * (t->count + 1) * sizeof *t->corners);
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

/* A kept surfel's area is max(A, A*), kept with probability p = min(1, A/A*): mean A, variance A max(A, A*) - A^2. They
 * are independent, so the variance of the sum is below the mean of the sum of kept areas' squares, which the cloud
 * itself estimates; the count's is at most the expected count. Four standard deviations of each; and they must
 * be small enough that 1 % would be seen. */
static void test_areas(const char *name, const triangles *t, const al_view *view, float pixels)
{
    al_runtime *runtime = open_scene(t, NULL, 0, 0);
    al_settings settings = {.pass = AL_PASS_SURFELS, .surfel_pixels = pixels};
    cloud c = draw_cloud(runtime, view, &settings);
    double wanted = total_area(t), deviation = sqrt(c.squares),
           expected = al_surfels_expected(al_runtime_scene(runtime), &runtime->surfels.rule);
    printf("%s: %u triangles, %u surfels of %.0f expected, area %.5f of %.5f (%+.2f %%, deviation %.2f %%)\n", name,
           t->count, c.count, expected, c.area, wanted, 100 * (c.area / wanted - 1), 100 * deviation / wanted);
    CHECK(4 * deviation < 0.01 * wanted);
    CHECK_NEAR(c.area, wanted, 0.01 * wanted);
    CHECK_NEAR(c.area, wanted, 4 * deviation);
    CHECK_NEAR(c.count, expected, 4 * sqrt(expected));
    free(c.surfels);
    al_runtime_destroy(runtime);
}

/* From inside a box of two triangles a side, of very small ones, and of needles 2 m long and 1 mm wide; of each
 * side, one half shows its back. */
static void test_shapes(void)
{
    triangles huge = {0}, tiny = {0}, thin = {0};
    const float middle[3] = {0, 0, 0}, half[3] = {1, 1, 1}, flat[3] = {1, 1, -1};
    al_view inside = stage_look(800, 600, (float[3]){0.1f, 0.2f, 0.9f}, (float[3]){0, 0, -1}, 0.7f);
    add_box(&huge, middle, half, 1);
    test_areas("huge", &huge, &inside, 3);
    add_box(&tiny, middle, half, 100);
    test_areas("tiny", &tiny, &inside, 3);
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

int main(void)
{
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    folder = stage_folder();
    if (!folder) return test_skip("no temporary folder");
    test_shapes();
    return test_end();
}
