/* Makes the meshes of the default scene: airlight-make-default-scene DIR writes
 *   bear.ply      a jelly bear, watertight: the translucent object's boundary
 *   knot.ply      a trefoil knot that fits into its belly, watertight: the blocker
 *   face.ply      eyes and nose, half sunk into it
 *   backdrop.ply  floor, cove and wall in one sheet
 * The bytes do not depend on the machine: +, -, *, / and sqrt alone are used, which IEEE 754 rounds exactly. */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

typedef struct vector {
    double x, y, z;
} vector;

static vector add(vector a, vector b) { return (vector){a.x + b.x, a.y + b.y, a.z + b.z}; }
static vector subtract(vector a, vector b) { return (vector){a.x - b.x, a.y - b.y, a.z - b.z}; }
static vector scale(vector a, double s) { return (vector){a.x * s, a.y * s, a.z * s}; }
static double dot(vector a, vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static double length(vector a) { return sqrt(dot(a, a)); }
static vector unit(vector a) { return scale(a, 1 / length(a)); }
static vector mix(vector a, vector b, double t) { return add(scale(a, 1 - t), scale(b, t)); }
static vector cross(vector a, vector b)
{
    return (vector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/* --- meshes --- */

typedef struct mesh {
    vector *positions, *normals;
    uint32_t (*triangles)[3]; /* counter-clockwise seen from outside */
    uint32_t vertex_count, triangle_count, vertex_room, triangle_room;
} mesh;

static void *grown(void *array, size_t count, size_t size)
{
    void *made = realloc(array, count * size);
    if (made) return made;
    fprintf(stderr, "airlight-make-default-scene: out of memory\n");
    exit(4);
}

static uint32_t add_vertex(mesh *m, vector position, vector normal)
{
    if (m->vertex_count == m->vertex_room) {
        m->vertex_room = m->vertex_room ? 2 * m->vertex_room : 1024;
        m->positions = grown(m->positions, m->vertex_room, sizeof *m->positions);
        m->normals = grown(m->normals, m->vertex_room, sizeof *m->normals);
    }
    m->positions[m->vertex_count] = position;
    m->normals[m->vertex_count] = normal;
    return m->vertex_count++;
}

static void add_triangle(mesh *m, uint32_t a, uint32_t b, uint32_t c)
{
    if (m->triangle_count == m->triangle_room) {
        m->triangle_room = m->triangle_room ? 2 * m->triangle_room : 1024;
        m->triangles = grown(m->triangles, m->triangle_room, sizeof *m->triangles);
    }
    uint32_t *corners = m->triangles[m->triangle_count++];
    corners[0] = a, corners[1] = b, corners[2] = c;
}

static void free_mesh(mesh *m)
{
    free(m->positions);
    free(m->normals);
    free(m->triangles);
}

static void put_u32(FILE *file, uint32_t value)
{
    for (int shift = 0; shift < 32; shift += 8) fputc((int)(value >> shift & 255), file);
}

static void put_vector(FILE *file, vector v)
{
    const float parts[3] = {(float)v.x, (float)v.y, (float)v.z};
    for (int i = 0; i < 3; i++) {
        uint32_t bits;
        memcpy(&bits, parts + i, sizeof bits);
        put_u32(file, bits);
    }
}

static bool write_ply(const char *folder, const char *name, const mesh *m)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    if (!file) return perror(path), false;
    fprintf(file,
            "ply\nformat binary_little_endian 1.0\nelement vertex %u\n"
            "property float x\nproperty float y\nproperty float z\n"
            "property float nx\nproperty float ny\nproperty float nz\n"
            "element face %u\nproperty list uchar uint vertex_indices\nend_header\n",
            m->vertex_count, m->triangle_count);
    for (uint32_t i = 0; i < m->vertex_count; i++) {
        put_vector(file, m->positions[i]);
        put_vector(file, m->normals[i]);
    }
    for (uint32_t i = 0; i < m->triangle_count; i++) {
        fputc(3, file);
        for (int corner = 0; corner < 3; corner++) put_u32(file, m->triangles[i][corner]);
    }
    bool failed = ferror(file) != 0;
    failed |= fclose(file) != 0;
    if (failed) perror(path);
    return !failed;
}

/* --- the bear as a signed distance (negative inside), metres, feet on y = 0, facing +z --- */

/* First-order distance to an ellipsoid: f / |grad f| of f = |p/r| - 1. */
static double ellipsoid(vector p, vector centre, vector radii)
{
    vector q = subtract(p, centre);
    vector once = {q.x / radii.x, q.y / radii.y, q.z / radii.z};
    vector twice = {once.x / radii.x, once.y / radii.y, once.z / radii.z};
    double steepness = length(twice);
    if (steepness < 1e-12) return -radii.x;
    return length(once) * (length(once) - 1) / steepness;
}

/* The smaller of two distances, the edge between them rounded over `width` by a quadratic. */
static double smooth_min(double a, double b, double width)
{
    double overlap = 1 - fabs(a - b) / width;
    double smaller = a < b ? a : b;
    return overlap > 0 ? smaller - 0.25 * width * overlap * overlap : smaller;
}

static double bear(vector p)
{
    p.x = fabs(p.x);
    double d = ellipsoid(p, (vector){0, 0.200, 0}, (vector){0.138, 0.160, 0.118});
    d = smooth_min(d, ellipsoid(p, (vector){0, 0.397, 0.012}, (vector){0.108, 0.098, 0.098}), 0.035);
    d = smooth_min(d, ellipsoid(p, (vector){0.082, 0.482, 0}, (vector){0.040, 0.042, 0.030}), 0.020);
    d = smooth_min(d, ellipsoid(p, (vector){0, 0.375, 0.098}, (vector){0.050, 0.038, 0.040}), 0.025);
    double arm = smooth_min(ellipsoid(p, (vector){0.116, 0.268, 0.045}, (vector){0.046, 0.046, 0.046}),
                            ellipsoid(p, (vector){0.092, 0.218, 0.118}, (vector){0.042, 0.042, 0.044}), 0.060);
    double leg = smooth_min(ellipsoid(p, (vector){0.080, 0.062, 0.030}, (vector){0.060, 0.060, 0.060}),
                            ellipsoid(p, (vector){0.102, 0.056, 0.130}, (vector){0.056, 0.060, 0.050}), 0.070);
    d = smooth_min(d, arm, 0.025);
    d = smooth_min(d, leg, 0.030);
    d = smooth_min(d, ellipsoid(p, (vector){0, 0.100, -0.112}, (vector){0.036, 0.036, 0.036}), 0.025);
    return -smooth_min(-d, p.y, 0.020);
}

static vector bear_normal(vector p)
{
    const double step = 1e-5;
    return unit((vector){bear(add(p, (vector){step, 0, 0})) - bear(subtract(p, (vector){step, 0, 0})),
                         bear(add(p, (vector){0, step, 0})) - bear(subtract(p, (vector){0, step, 0})),
                         bear(add(p, (vector){0, 0, step})) - bear(subtract(p, (vector){0, 0, step}))});
}

/* --- marching tetrahedra: six per cube around its main diagonal (Kuhn), so that faces match --- */

enum { NX = 23, NY = 36, NZ = 27, EDGES = 8 };
#define CELL_M 0.0165

typedef struct field {
    double *values;     /* [NZ][NY][NX] */
    uint32_t *vertices; /* [NZ][NY][NX][EDGES]: 1 + vertex on the edge to the corner with these offset bits */
} field;

static vector corner_position(uint32_t corner)
{
    return (vector){CELL_M * ((double)(corner % NX) - 0.5 * (NX - 1)),
                    CELL_M * ((double)(corner / NX % NY) - 1.37),
                    CELL_M * ((double)(corner / NX / NY) - 0.5 * (NZ - 1) + 1.37)};
}

static uint32_t corner_index(uint32_t base, uint32_t bits)
{
    return base + (bits & 1) + NX * (bits >> 1 & 1) + NX * NY * (bits >> 2 & 1);
}

static uint32_t edge_vertex(field *f, mesh *m, uint32_t base, uint32_t bits_a, uint32_t bits_b)
{
    uint32_t low = bits_a & bits_b, high = bits_a | bits_b; /* along a Kuhn edge one contains the other */
    uint32_t a = corner_index(base, low), b = corner_index(base, high);
    uint32_t *slot = &f->vertices[(size_t)a * EDGES + (high ^ low)];
    if (!*slot) {
        double t = f->values[a] / (f->values[a] - f->values[b]);
        t = t < 0.1 ? 0.1 : t > 0.9 ? 0.9 : t; /* relaxation brings it to the surface */
        *slot = 1 + add_vertex(m, mix(corner_position(a), corner_position(b), t), (vector){0, 1, 0});
    }
    return *slot - 1;
}

/* Where an edge is cut does not change which way a face looks: tested with the cuts in the middle. */
static void add_facing(mesh *m, const uint32_t corners[3], const vector middles[3], vector outwards)
{
    vector normal = cross(subtract(middles[1], middles[0]), subtract(middles[2], middles[0]));
    if (dot(normal, outwards) > 0) add_triangle(m, corners[0], corners[1], corners[2]);
    else add_triangle(m, corners[0], corners[2], corners[1]);
}

static void march_tetrahedron(field *f, mesh *m, uint32_t base, const uint32_t bits[4])
{
    uint32_t inside[4], outside[4], cuts[4];
    int in = 0, out = 0;
    vector middles[4], outwards = {0, 0, 0};
    for (int i = 0; i < 4; i++) {
        uint32_t corner = corner_index(base, bits[i]);
        bool is_inside = f->values[corner] < 0;
        if (is_inside) inside[in++] = bits[i];
        else outside[out++] = bits[i];
    }
    if (!in || !out) return;
    for (int i = 0; i < in; i++)
        outwards = subtract(outwards, scale(corner_position(corner_index(base, inside[i])), 1.0 / in));
    for (int i = 0; i < out; i++)
        outwards = add(outwards, scale(corner_position(corner_index(base, outside[i])), 1.0 / out));
    int count = in * out; /* cut edges: 3, or 4 in an order that goes round */
    for (int i = 0; i < count; i++) {
        uint32_t a = in == 2 ? inside[i / 2] : inside[in == 1 ? 0 : i];
        uint32_t b = in == 2 ? outside[(i + i / 2) % 2] : outside[out == 1 ? 0 : i];
        cuts[i] = edge_vertex(f, m, base, a, b);
        middles[i] = mix(corner_position(corner_index(base, a)), corner_position(corner_index(base, b)), 0.5);
    }
    add_facing(m, cuts, middles, outwards);
    if (count == 4)
        add_facing(m, (const uint32_t[3]){cuts[0], cuts[2], cuts[3]},
                   (const vector[3]){middles[0], middles[2], middles[3]}, outwards);
}

/* Moves every vertex towards the mean of its neighbours, then back onto the surface: evens the triangles. */
static void relax(mesh *m, int rounds)
{
    vector *sums = grown(NULL, m->vertex_count, sizeof *sums);
    uint32_t *counts = grown(NULL, m->vertex_count, sizeof *counts);
    for (int round = 0; round < rounds; round++) {
        memset(sums, 0, m->vertex_count * sizeof *sums);
        memset(counts, 0, m->vertex_count * sizeof *counts);
        for (uint32_t t = 0; t < m->triangle_count; t++)
            for (int i = 0; i < 3; i++) {
                uint32_t from = m->triangles[t][i], to = m->triangles[t][(i + 1) % 3];
                sums[from] = add(sums[from], m->positions[to]);
                counts[from]++;
            }
        for (uint32_t i = 0; i < m->vertex_count; i++) {
            vector p = mix(m->positions[i], scale(sums[i], 1.0 / counts[i]), 0.6);
            for (int step = 0; step < 3; step++) p = subtract(p, scale(bear_normal(p), bear(p)));
            m->positions[i] = p;
        }
    }
    for (uint32_t i = 0; i < m->vertex_count; i++) m->normals[i] = bear_normal(m->positions[i]);
    free(sums);
    free(counts);
}

static mesh make_bear(void)
{
    static const uint32_t tetrahedra[6][4] = {{0, 1, 3, 7}, {0, 1, 5, 7}, {0, 2, 3, 7},
                                              {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 4, 6, 7}};
    enum { COUNT = NX * NY * NZ };
    mesh m = {0};
    field f = {grown(NULL, COUNT, sizeof *f.values), grown(NULL, (size_t)COUNT * EDGES, sizeof *f.vertices)};
    memset(f.vertices, 0, (size_t)COUNT * EDGES * sizeof *f.vertices);
    for (uint32_t i = 0; i < COUNT; i++) f.values[i] = bear(corner_position(i));
    for (uint32_t z = 0; z + 1 < NZ; z++)
        for (uint32_t y = 0; y + 1 < NY; y++)
            for (uint32_t x = 0; x + 1 < NX; x++)
                for (int t = 0; t < 6; t++)
                    march_tetrahedron(&f, &m, (z * NY + y) * NX + x, tetrahedra[t]);
    relax(&m, 12);
    free(f.values);
    free(f.vertices);
    return m;
}

/* --- the knot --- */

/* Taylor series around 0 after reduction to [-pi, pi]: below 1e-12 off, and the same everywhere. */
static double sine(double angle)
{
    while (angle > PI) angle -= 2 * PI;
    while (angle < -PI) angle += 2 * PI;
    double term = angle, sum = angle;
    for (int i = 1; i < 14; i++) {
        term *= -angle * angle / ((2.0 * i) * (2.0 * i + 1));
        sum += term;
    }
    return sum;
}

static double cosine(double angle)
{
    return sine(angle + PI / 2);
}

/* A tube around the (2, 3) torus knot about z; the torus's normal makes a frame that closes. */
static mesh make_knot(void)
{
    enum { ALONG = 160, AROUND = 16 };
    const double major_m = 0.052, minor_m = 0.026, tube_m = 0.0125;
    const vector centre = {0, 0.205, 0.002};
    mesh m = {0};
    for (int i = 0; i < ALONG; i++) {
        double t = 2 * PI * i / ALONG, radius = major_m + minor_m * cosine(3 * t);
        double cos_around = cosine(2 * t), sin_around = sine(2 * t);
        vector at = {radius * cos_around, radius * sin_around, minor_m * sine(3 * t)};
        double widening = -3 * minor_m * sine(3 * t);
        vector tangent = unit((vector){widening * cos_around - 2 * radius * sin_around,
                                       widening * sin_around + 2 * radius * cos_around,
                                       3 * minor_m * cosine(3 * t)});
        vector normal = {cosine(3 * t) * cos_around, cosine(3 * t) * sin_around, sine(3 * t)};
        vector side = unit(cross(tangent, normal));
        normal = cross(side, tangent);
        for (int j = 0; j < AROUND; j++) {
            double angle = 2 * PI * j / AROUND;
            vector out = add(scale(normal, cosine(angle)), scale(side, sine(angle)));
            add_vertex(&m, add(centre, add(at, scale(out, tube_m))), out);
        }
    }
    for (uint32_t i = 0; i < ALONG; i++)
        for (uint32_t j = 0; j < AROUND; j++) {
            uint32_t next = (i + 1) % ALONG, beside = (j + 1) % AROUND;
            uint32_t a = i * AROUND + j, b = next * AROUND + j;
            uint32_t c = next * AROUND + beside, d = i * AROUND + beside;
            add_triangle(&m, a, d, c);
            add_triangle(&m, a, c, b);
        }
    return m;
}

/* --- the face --- */

static void add_ball(mesh *m, vector centre, double radius)
{
    enum { RINGS = 12, AROUND = 24 };
    uint32_t first = m->vertex_count;
    for (int ring = 0; ring <= RINGS; ring++)
        for (int i = 0; i < AROUND; i++) {
            double polar = PI * ring / RINGS, around = 2 * PI * i / AROUND;
            vector out = {sine(polar) * sine(around), cosine(polar), sine(polar) * cosine(around)};
            add_vertex(m, add(centre, scale(out, radius)), out);
        }
    for (uint32_t ring = 0; ring < RINGS; ring++)
        for (uint32_t i = 0; i < AROUND; i++) {
            uint32_t beside = (i + 1) % AROUND;
            uint32_t a = first + ring * AROUND + i, b = first + ring * AROUND + beside;
            if (ring > 0) add_triangle(m, a, b + AROUND, b);
            if (ring + 1 < RINGS) add_triangle(m, a, a + AROUND, b + AROUND);
        }
}

static mesh make_face(void)
{
    mesh m = {0};
    add_ball(&m, (vector){0, 0.391, 0.133}, 0.0135);
    add_ball(&m, (vector){0.040, 0.424, 0.099}, 0.0125);
    add_ball(&m, (vector){-0.040, 0.424, 0.099}, 0.0125);
    return m;
}

/* --- the backdrop: a floor that bends up into a wall --- */

static mesh make_backdrop(void)
{
    enum { ARC = 24, ROWS = ARC + 3 };
    const double half_width_m = 3, front_m = 2.5, back_m = -0.55, bend_m = 0.6, top_m = 2.5;
    mesh m = {0};
    for (int i = 0; i < ROWS; i++) {
        double angle = i <= 1 ? 0 : i >= ROWS - 2 ? PI / 2 : PI / 2 * (i - 1) / ARC;
        vector normal = {0, cosine(angle), sine(angle)};
        vector at = {0, bend_m - bend_m * normal.y, back_m - bend_m * normal.z};
        if (i == 0) at.z = front_m;
        if (i == ROWS - 1) at.y = top_m;
        at.x = -half_width_m;
        add_vertex(&m, at, normal);
        at.x = half_width_m;
        add_vertex(&m, at, normal);
    }
    for (uint32_t i = 0; i + 1 < ROWS; i++) {
        add_triangle(&m, 2 * i, 2 * i + 1, 2 * i + 3);
        add_triangle(&m, 2 * i, 2 * i + 3, 2 * i + 2);
    }
    return m;
}

int main(int argc, char **argv)
{
    if (argc != 2 || argv[1][0] == '-') {
        fprintf(stderr, "usage: airlight-make-default-scene DIR\n");
        return 2;
    }
    mesh meshes[] = {make_bear(), make_knot(), make_face(), make_backdrop()};
    static const char *const names[] = {"bear.ply", "knot.ply", "face.ply", "backdrop.ply"};
    bool good = true;
    for (int i = 0; i < 4; i++) {
        good &= write_ply(argv[1], names[i], meshes + i);
        free_mesh(meshes + i);
    }
    return good ? 0 : 4;
}
