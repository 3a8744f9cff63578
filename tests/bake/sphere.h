/* A homogeneous sphere as a closed mesh, for tests of the steps. */
#ifndef AIRLIGHT_TEST_SPHERE_H
#define AIRLIGHT_TEST_SPHERE_H

#include <math.h>
#include <stdlib.h>

#include "import.h"

/* Latitude-longitude sphere with `rows` x 2 `rows` faces, scaled so that its volume is the ball's. */
static inline al_triangles test_sphere(double radius, uint32_t rows)
{
    uint32_t columns = 2 * rows, t = 0;
    al_triangles mesh = {.vertex_count = 2 + (rows - 1) * columns,
                         .triangle_count = 2 * columns * (rows - 1)};
    mesh.positions = malloc(3 * mesh.vertex_count * sizeof(double));
    mesh.indices = malloc(3 * mesh.triangle_count * sizeof(uint32_t));
    double pi = acos(-1), volume = 0;
    for (uint32_t v = 0; v < mesh.vertex_count; v++) {
        uint32_t row = v == 0 ? 0 : v + 1 == mesh.vertex_count ? rows : 1 + (v - 1) / columns;
        double theta = pi * row / rows, phi = 2 * pi * ((v - 1) % columns) / columns;
        double unit[3] = {sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta)};
        for (int i = 0; i < 3; i++) mesh.positions[3 * v + i] = radius * unit[i];
    }
    for (uint32_t row = 0; row < rows; row++)
        for (uint32_t c = 0; c < columns; c++) {
            uint32_t d = (c + 1) % columns, above = 1 + (row - 1) * columns, below = 1 + row * columns;
            uint32_t corners[4] = {row ? above + c : 0, row ? above + d : 0,
                                   row + 1 < rows ? below + c : mesh.vertex_count - 1,
                                   row + 1 < rows ? below + d : mesh.vertex_count - 1};
            if (row + 1 < rows) {
                uint32_t triangle[3] = {corners[0], corners[2], corners[3]};
                for (int i = 0; i < 3; i++) mesh.indices[3 * t + i] = triangle[i];
                t++;
            }
            if (row > 0) {
                uint32_t triangle[3] = {corners[0], corners[3], corners[1]};
                for (int i = 0; i < 3; i++) mesh.indices[3 * t + i] = triangle[i];
                t++;
            }
        }
    for (t = 0; t < mesh.triangle_count; t++) {
        const double *p[3];
        for (int i = 0; i < 3; i++) p[i] = mesh.positions + 3 * mesh.indices[3 * t + i];
        volume += (p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) +
                   p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2]) +
                   p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0])) /
                  6;
    }
    double scale = cbrt(4 * pi / 3 * radius * radius * radius / volume);
    for (uint32_t v = 0; v < 3 * mesh.vertex_count; v++) mesh.positions[v] *= scale;
    return mesh;
}

#endif
