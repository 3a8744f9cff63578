/* Inside tests against closed forms: a sphere, a hollow one, two that overlap, none. */
#include <stdlib.h>
#include <string.h>

#include "../test.h"
#include "solid.h"
#include "sphere.h"

/* Points of the additive recurrence of the plastic number's generalisation: evenly spread in [-1.5, 1.5]^3.
 */
static void spread(int index, double point[3])
{
    static const double step[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    for (int i = 0; i < 3; i++) point[i] = 3 * fmod(0.5 + index * step[i], 1) - 1.5;
}

static double length(const double p[3], double x)
{
    return sqrt((p[0] - x) * (p[0] - x) + p[1] * p[1] + p[2] * p[2]);
}

static al_triangles join(al_triangles a, al_triangles b)
{
    al_triangles both = {a.vertex_count + b.vertex_count, a.triangle_count + b.triangle_count, NULL, NULL};
    both.positions = malloc(3 * both.vertex_count * sizeof(double));
    both.indices = malloc(3 * both.triangle_count * sizeof(uint32_t));
    memcpy(both.positions, a.positions, 3 * a.vertex_count * sizeof(double));
    memcpy(both.positions + 3 * a.vertex_count, b.positions, 3 * b.vertex_count * sizeof(double));
    memcpy(both.indices, a.indices, 3 * a.triangle_count * sizeof(uint32_t));
    for (uint32_t i = 0; i < 3 * b.triangle_count; i++)
        both.indices[3 * a.triangle_count + i] = b.indices[i] + a.vertex_count;
    return both;
}

static void turn_inside_out(al_triangles *mesh)
{
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        uint32_t swapped = mesh->indices[3 * t];
        mesh->indices[3 * t] = mesh->indices[3 * t + 1];
        mesh->indices[3 * t + 1] = swapped;
    }
}

typedef bool expected_fn(const double point[3], bool *near);

/* The middle of a face of 1/48 of pi lies R (1 - cos(pi/96)^2) < 0.0011 R below the sphere through its
 * corners, which is scaled out by less than that. */
static const double sag = 0.003;

static bool in_two(const double p[3], bool *near)
{
    double a = length(p, -0.3), b = length(p, 0.3);
    *near = fabs(a - 0.7) < sag || fabs(b - 0.7) < sag;
    return a < 0.7 || b < 0.7;
}

static bool in_shell(const double p[3], bool *near)
{
    double r = length(p, 0);
    *near = fabs(r - 1) < sag || fabs(r - 0.5) < sag;
    return r < 1 && r > 0.5;
}

static void check(const char *name, al_triangles *mesh, expected_fn *expected)
{
    al_solid *solid;
    al_error error = {0};
    int wrong = 0, asked = 0;
    CHECK(al_solid_create(mesh, &solid, &error) == AL_OK);
    if (!solid) return;
    for (int i = 0; i < 20000; i++) {
        double point[3];
        bool near;
        spread(i, point);
        bool inside = expected(point, &near);
        if (near) continue;
        asked++;
        wrong += al_solid_contains(solid, point) != inside;
    }
    if (wrong) fprintf(stderr, "%s: %d of %d points wrong\n", name, wrong, asked);
    CHECK(wrong == 0 && asked > 19000);
    al_solid_free(solid);
    al_triangles_free(mesh);
}

int main(void)
{
    al_triangles outer = test_sphere(1, 48), inner = test_sphere(0.5, 48);
    turn_inside_out(&inner);
    al_triangles shell = join(outer, inner);
    check("shell", &shell, in_shell);
    al_triangles_free(&outer);
    al_triangles_free(&inner);

    al_triangles left = test_sphere(0.7, 48), right = test_sphere(0.7, 48);
    for (uint32_t v = 0; v < left.vertex_count; v++) {
        left.positions[3 * v] -= 0.3;
        right.positions[3 * v] += 0.3;
    }
    al_triangles two = join(left, right);
    check("two that overlap", &two, in_two);
    al_triangles_free(&left);
    al_triangles_free(&right);

    al_triangles none = {0};
    al_solid *solid;
    al_error error = {0};
    const double origin[3] = {0, 0, 0};
    CHECK(al_solid_create(&none, &solid, &error) == AL_OK && !al_solid_contains(solid, origin));
    al_solid_free(solid);
    return test_end();
}
