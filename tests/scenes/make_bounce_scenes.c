/* Makes the meshes of two scenes for scripts/bounce_figures.sh: make_bounce_scenes DIR writes
 *   dominoes.obj  140 dominoes in a spiral on a floor, some fallen; materials red to violet and floor
 *   yard.obj      uneven ground, a brick wall with gaps, headstones and a meadow of grass blades; materials earth, brick, stone
 *                 and grass */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#define PI 3.14159265358979323846

typedef struct writer {
    FILE *file;
    unsigned vertices;
    uint32_t state;
} writer;

static double drawn(writer *w, double low, double high)
{
    w->state = w->state * 1664525u + 1013904223u;
    return low + (high - low) * (w->state >> 8) / 16777216.0;
}

static void corner(writer *w, double x, double y, double z)
{
    fprintf(w->file, "v %.5f %.5f %.5f\n", x, y, z);
    w->vertices++;
}

/* A box of half sizes `half` about `middle`, tilted by `tilt` about its own z, then turned by `turn` about +y. */
static void box(writer *w, const double middle[3], const double half[3], double turn, double tilt)
{
    static const int faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    unsigned first = w->vertices + 1;
    for (int i = 0; i < 8; i++) {
        double x = i & 1 ? half[0] : -half[0], y = i & 2 ? half[1] : -half[1], z = i & 4 ? half[2] : -half[2];
        double along = x * cos(tilt) - y * sin(tilt), up = x * sin(tilt) + y * cos(tilt);
        corner(w, middle[0] + along * cos(turn) + z * sin(turn), middle[1] + up,
               middle[2] - along * sin(turn) + z * cos(turn));
    }
    for (int i = 0; i < 6; i++) {
        const int *f = faces[i];
        fprintf(w->file, "f %u %u %u %u\n", first + (unsigned)f[0], first + (unsigned)f[1], first + (unsigned)f[2],
                first + (unsigned)f[3]);
    }
}

static void make_dominoes(writer *w)
{
    static const char *const colors[] = {"red", "orange", "yellow", "green", "blue", "violet"};
    fprintf(w->file, "usemtl floor\n");
    box(w, (double[]){0, -0.05, 0}, (double[]){2, 0.05, 2}, 0, 0);
    double angle = 2;
    for (int i = 0; i < 140; i++) {
        double radius = 0.08 * angle, fallen = i % 9 == 4 ? 0.5 * PI - 0.02 : 0;
        angle += 0.11 / radius;
        fprintf(w->file, "usemtl %s\n", colors[(int)drawn(w, 0, 6)]);
        box(w, (double[]){radius * cos(angle), fallen > 0 ? 0.026 : 0.121, radius * sin(angle)}, (double[]){0.025, 0.12, 0.06},
            0.5 * PI - angle + drawn(w, -0.3, 0.3), fallen);
    }
}

static double ground(double x, double z)
{
    return 0.06 * sin(1.7 * x + 0.4) * cos(1.3 * z) + 0.03 * sin(4.1 * x - 2.3 * z) + 0.012 * sin(11 * x + 7 * z);
}

static void make_ground(writer *w)
{
    enum { N = 48 };
    fprintf(w->file, "usemtl earth\n");
    unsigned first = w->vertices + 1;
    for (int j = 0; j <= N; j++)
        for (int i = 0; i <= N; i++) {
            double x = 8.0 * i / N - 4, z = 8.0 * j / N - 4;
            corner(w, x, ground(x, z), z);
        }
    for (unsigned j = 0; j < N; j++)
        for (unsigned i = 0; i < N; i++) {
            unsigned a = first + j * (N + 1) + i, b = a + N + 1;
            fprintf(w->file, "f %u %u %u %u\n", a, b, b + 1, a + 1);
        }
}

static void make_wall(writer *w)
{
    fprintf(w->file, "usemtl brick\n");
    for (int row = 0; row < 12; row++)
        for (int i = 0; i < 26; i++) {
            double x = -3.1 + 0.25 * i + (row % 2) * 0.125;
            if (row > 7 && drawn(w, 0, 1) < 0.25 * (row - 7)) continue;
            box(w, (double[]){x, 0.1 * row, -1.9 + drawn(w, -0.02, 0.02)}, (double[]){0.118, 0.044, 0.07},
                drawn(w, -0.04, 0.04), 0);
        }
}

static void make_stones(writer *w)
{
    fprintf(w->file, "usemtl stone\n");
    for (int row = 0; row < 4; row++)
        for (int i = 0; i < 7; i++) {
            double x = -2.4 + 0.8 * i + drawn(w, -0.1, 0.1), z = -1.2 + 0.85 * row + drawn(w, -0.1, 0.1);
            double height = drawn(w, 0.16, 0.3), turn = 0.5 * PI + drawn(w, -0.2, 0.2), lean = drawn(w, -0.15, 0.15);
            box(w, (double[]){x, ground(x, z) + height, z}, (double[]){0.045, height, 0.17}, turn, lean);
            box(w, (double[]){x, ground(x, z), z}, (double[]){0.09, 0.05, 0.23}, turn, 0);
        }
}

static void make_grass(writer *w)
{
    fprintf(w->file, "usemtl grass\n");
    for (int i = 0; i < 7000; i++) {
        double x = drawn(w, -3.6, 3.6), z = drawn(w, -1.6, 3), turn = drawn(w, 0, 2 * PI), height = drawn(w, 0.05, 0.16);
        double y = ground(x, z), ax = 0.008 * cos(turn), az = 0.008 * sin(turn);
        double lean = drawn(w, 0, 0.6) * height, towards = drawn(w, 0, 2 * PI);
        unsigned first = w->vertices + 1;
        corner(w, x - ax, y - 0.01, z - az);
        corner(w, x + ax, y - 0.01, z + az);
        corner(w, x + 0.4 * lean * cos(towards), y + 0.6 * height, z + 0.4 * lean * sin(towards));
        corner(w, x + lean * cos(towards), y + height, z + lean * sin(towards));
        fprintf(w->file, "f %u %u %u\nf %u %u %u\n", first, first + 1, first + 2, first + 1, first + 3, first + 2);
    }
}

static int make(const char *folder, const char *name, void (*const steps[])(writer *), int count)
{
    char path[1024];
    writer w = {.state = 1};
    snprintf(path, sizeof path, "%s/%s", folder, name);
    w.file = fopen(path, "wb");
    if (w.file)
        for (int i = 0; i < count; i++) steps[i](&w);
    if (w.file && !ferror(w.file) && fclose(w.file) == 0) return 0;
    fprintf(stderr, "make_bounce_scenes: %s cannot be written\n", path);
    return 4;
}

int main(int argc, char **argv)
{
    static void (*const dominoes[])(writer *) = {make_dominoes};
    static void (*const yard[])(writer *) = {make_ground, make_wall, make_stones, make_grass};
    if (argc != 2) {
        fprintf(stderr, "usage: make_bounce_scenes DIR\n");
        return 2;
    }
    int code = make(argv[1], "dominoes.obj", dominoes, 1);
    return code ? code : make(argv[1], "yard.obj", yard, 4);
}
