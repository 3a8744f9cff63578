/* Procedural meshes, made in double precision and rounded once. Points that belong together are computed
 * from the same numbers in the same order, so that they are bit-identical and the mesh is closed. */
#include <math.h>
#include <string.h>

#include "airlight/formulas.h"
#include "geometry.h"

typedef struct corner {
    double position[3], normal[3], uv[2];
} corner;

static void put(al_corners *out, const corner *from)
{
    size_t i = out->count++;
    for (int k = 0; k < 3; k++) {
        out->positions[i * 3 + k] = (float)from->position[k];
        out->normals[i * 3 + k] = (float)from->normal[k];
    }
    for (int k = 0; k < 2; k++) {
        out->uv0[i * 2 + k] = (float)from->uv[k];
        out->uv1[i * 2 + k] = 0;
    }
}

static void put_quad(al_corners *out, const corner *a, const corner *b, const corner *c, const corner *d)
{
    const corner *order[6] = {a, b, c, a, c, d};
    for (int i = 0; i < 6; i++) put(out, order[i]);
}

/* The middle of the arc from a to b; a + b == b + a, so both neighbours find the same point. */
static void middle(const double a[3], const double b[3], double out[3])
{
    double length = 0;
    for (int i = 0; i < 3; i++) {
        out[i] = a[i] + b[i];
        length += out[i] * out[i];
    }
    length = sqrt(length);
    for (int i = 0; i < 3; i++) out[i] /= length;
}

static void sphere_corner(al_corners *out, double radius, const double n[3])
{
    corner made = {{n[0] * radius, n[1] * radius, n[2] * radius}, {n[0], n[1], n[2]}, {0}};
    put(out, &made);
}

static void split_triangle(al_corners *out, double radius, uint32_t depth, const double a[3],
                           const double b[3], const double c[3])
{
    if (depth == 0) {
        sphere_corner(out, radius, a);
        sphere_corner(out, radius, b);
        sphere_corner(out, radius, c);
        return;
    }
    double ab[3], bc[3], ca[3];
    middle(a, b, ab);
    middle(b, c, bc);
    middle(c, a, ca);
    split_triangle(out, radius, depth - 1, a, ab, ca);
    split_triangle(out, radius, depth - 1, b, bc, ab);
    split_triangle(out, radius, depth - 1, c, ca, bc);
    split_triangle(out, radius, depth - 1, ab, bc, ca);
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double triple(const double a[3], const double b[3], const double c[3])
{
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
           a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/* The icosahedron's points are the cyclic permutations of (0, +-1, +-golden), its faces all triples of
 * neighbours; neighbours on the unit sphere have the cosine 1/sqrt(5). Each split halves the edges. */
static al_status make_sphere(const al_shape_description *shape, al_corners *out, al_error *error)
{
    const double golden = (1 + sqrt(5)) / 2, length = sqrt(1 + golden * golden), near = 0.4;
    double points[12][3];
    for (int i = 0; i < 12; i++) {
        int axis = i / 4;
        points[i][axis] = 0;
        points[i][(axis + 1) % 3] = (i & 1 ? -1 : 1) / length;
        points[i][(axis + 2) % 3] = (i & 2 ? -golden : golden) / length;
    }
    al_status status = al_corners_reserve(out, 60u << (2 * shape->subdivisions), error);
    if (status) return status;
    for (int a = 0; a < 12; a++)
        for (int b = a + 1; b < 12; b++)
            for (int c = b + 1; c < 12; c++) {
                if (dot(points[a], points[b]) < near || dot(points[b], points[c]) < near ||
                    dot(points[c], points[a]) < near)
                    continue;
                bool outward = triple(points[a], points[b], points[c]) > 0;
                split_triangle(out, shape->radius_m, shape->subdivisions, points[a], points[outward ? b : c],
                               points[outward ? c : b]);
            }
    return AL_OK;
}

static al_status make_box(const al_shape_description *shape, al_corners *out, al_error *error)
{
    al_status status = al_corners_reserve(out, 36, error);
    for (int face = 0; face < 6 && !status; face++) {
        int axis = face / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
        double side = face % 2 ? -1 : 1;
        corner corners[4] = {0};
        for (int k = 0; k < 4; k++) {
            bool far_u = k == 1 || k == 2, far_v = k >= 2;
            corners[k].position[axis] = side * shape->size_m[axis] / 2;
            corners[k].position[u] = (far_u ? side : -side) * shape->size_m[u] / 2;
            corners[k].position[v] = (far_v ? 1 : -1) * shape->size_m[v] / 2;
            corners[k].normal[axis] = side;
            corners[k].uv[0] = far_u;
            corners[k].uv[1] = far_v;
        }
        put_quad(out, &corners[0], &corners[1], &corners[2], &corners[3]);
    }
    out->has_uv0 = true;
    return status;
}

static al_status make_plane(const al_shape_description *shape, al_corners *out, al_error *error)
{
    al_status status = al_corners_reserve(out, 6, error);
    if (status) return status;
    double x = shape->width_m / 2, z = shape->depth_m / 2;
    const corner corners[4] = {{{-x, 0, z}, {0, 1, 0}, {0, 1}},
                               {{x, 0, z}, {0, 1, 0}, {1, 1}},
                               {{x, 0, -z}, {0, 1, 0}, {1, 0}},
                               {{-x, 0, -z}, {0, 1, 0}, {0, 0}}};
    put_quad(out, &corners[0], &corners[1], &corners[2], &corners[3]);
    out->has_uv0 = true;
    return AL_OK;
}

/* Around the y axis; the last segment ends on the first one's own numbers. */
static corner torus_corner(const al_shape_description *shape, uint32_t i, uint32_t j)
{
    double around = 2 * AL_PI * (i % shape->major_segments) / shape->major_segments;
    double tube = 2 * AL_PI * (j % shape->minor_segments) / shape->minor_segments;
    double n[3] = {cos(around) * cos(tube), sin(tube), -sin(around) * cos(tube)};
    double ring = shape->major_radius_m + shape->minor_radius_m * cos(tube);
    return (corner){{cos(around) * ring, shape->minor_radius_m * n[1], -sin(around) * ring},
                    {n[0], n[1], n[2]},
                    {(double)i / shape->major_segments, (double)j / shape->minor_segments}};
}

static al_status make_torus(const al_shape_description *shape, al_corners *out, al_error *error)
{
    al_status status = al_corners_reserve(out, 6 * shape->major_segments * shape->minor_segments, error);
    if (status) return status;
    for (uint32_t i = 0; i < shape->major_segments; i++)
        for (uint32_t j = 0; j < shape->minor_segments; j++) {
            corner a = torus_corner(shape, i, j), b = torus_corner(shape, i + 1, j);
            corner c = torus_corner(shape, i + 1, j + 1), d = torus_corner(shape, i, j + 1);
            put_quad(out, &a, &b, &c, &d);
        }
    out->has_uv0 = true;
    return AL_OK;
}

al_status al_shape_corners(const al_shape_description *shape, al_corners *corners, al_error *error)
{
    switch (shape->type) {
    case AL_SHAPE_SPHERE:
        return make_sphere(shape, corners, error);
    case AL_SHAPE_BOX:
        return make_box(shape, corners, error);
    case AL_SHAPE_PLANE:
        return make_plane(shape, corners, error);
    case AL_SHAPE_TORUS:
        return make_torus(shape, corners, error);
    case AL_SHAPE_NONE:
        break;
    }
    return al_fail(error, AL_USAGE, "shape type %d does not exist", (int)shape->type);
}
