/* The area emitter on its own ground: the light rectangle of the reference room alone in endless fog, irradiance
 * at the lightmap points by number of scattering events. The rectangle (radiance 10, downwards) is a sum of
 * differential areas.
 *
 * Truth is an independent renderer (shared/reference/open_area_*.csv). There the rectangle is a black surface that
 * also swallows what is scattered onto it, which no table of an empty medium can know: a random walk of this test,
 * with and without the rectangle in the way of the same paths, gives the share that is left. Bounds: 1 % in the
 * root mean square with the reference's error taken out; the sums over all points within 0.5 % and four of their
 * standard errors. */
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "tables.h"

enum { ORDERS = 6, POINT_LIMIT = 128, GRID = 24 };

typedef struct reference {
    double position[3], normal[3], value[ORDERS + 1], error[ORDERS + 1]; /* by events, 0: direct */
} reference;

static int read_reference(const char *path, reference *points)
{
    char line[2048];
    int count = 0;
    FILE *file = fopen(path, "r");
    while (file && count < POINT_LIMIT && fgets(line, sizeof line, file)) {
        double numbers[6 + 2 * (ORDERS + 2)];
        char *at = line;
        int read = 0;
        while (read < 6 + 2 * (ORDERS + 2)) {
            char *end;
            numbers[read] = strtod(at, &end);
            if (end == at) break;
            read++;
            at = *end == ',' ? end + 1 : end;
        }
        if (read < 6 + 2 * (ORDERS + 2)) continue; /* comments and heads */
        reference *r = &points[count++];
        memcpy(r->position, numbers, sizeof r->position);
        memcpy(r->normal, numbers + 3, sizeof r->normal);
        memcpy(r->value, numbers + 6, sizeof r->value);
        memcpy(r->error, numbers + 6 + ORDERS + 2, sizeof r->error);
    }
    if (file) fclose(file);
    return count;
}

/* Corners of the rectangle: the bounds of object `light`. */
static bool read_light(const char *path, double low[3], double high[3])
{
    char line[256];
    bool inside = false, any = false;
    FILE *file = fopen(path, "r");
    while (file && fgets(line, sizeof line, file)) {
        double v[3];
        if (line[0] == 'o') inside = !strncmp(line, "o light", 7);
        if (!inside || sscanf(line, "v %lf %lf %lf", &v[0], &v[1], &v[2]) != 3) continue;
        for (int i = 0; i < 3; i++) {
            low[i] = any ? fmin(low[i], v[i]) : v[i];
            high[i] = any ? fmax(high[i], v[i]) : v[i];
        }
        any = true;
    }
    if (file) fclose(file);
    return any;
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Irradiance at a point from one differential area with normal -y, W/m2 per W/(m2 sr) m2. */
static double from_area(const al_impulse_tables *tables, const reference *r, const double light[3],
                        al_impulse_query *q)
{
    al_impulse_answer a;
    double to[3], z, down, side[3], length = 0;
    for (int i = 0; i < 3; i++) to[i] = light[i] - r->position[i];
    q->distance_m = sqrt(dot(to, to));
    for (int i = 0; i < 3; i++) to[i] /= q->distance_m;
    q->cos_normal = to[1]; /* normal (0, -1, 0) dot -to */
    z = dot(r->normal, to);
    if (q->first_event == 0) /* the beam as it is, not its bands */
        return fmax(0, q->cos_normal) * fmax(0, z) / (q->distance_m * q->distance_m) *
               exp(-(q->sigma_s_per_m + q->sigma_a_per_m) * q->distance_m);
    down = -to[1]; /* the normal without its part along `to` */
    for (int i = 0; i < 3; i++) side[i] = (i == 1 ? -1 : 0) - down * to[i];
    length = sqrt(dot(side, side));
    al_impulse_response(tables, q, &a);
    return al_impulse_irradiance(&a, z, length > 0 ? dot(r->normal, side) / length : 0);
}

static double from_light(const al_impulse_tables *tables, const reference *r, const double low[3],
                         const double high[3], al_impulse_query *q)
{
    double sum = 0, area = (high[0] - low[0]) * (high[2] - low[2]);
    for (int i = 0; i < GRID * GRID; i++) {
        double light[3] = {low[0] + (high[0] - low[0]) * (i % GRID + 0.5) / GRID, low[1],
                           low[2] + (high[2] - low[2]) * (i / GRID + 0.5) / GRID};
        sum += from_area(tables, r, light, q);
    }
    return 10 * area * sum / (GRID * GRID);
}

/* --- a random walk from the rectangle, with and without it in the way of scattered light --- */

typedef struct walk {
    double free[POINT_LIMIT][ORDERS + 1], shaded[POINT_LIMIT][ORDERS + 1]; /* irradiance by events */
} walk;

static double random_unit(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    uint64_t x = *state ^ *state >> 31;
    x *= 0x9e3779b97f4a7c15u;
    return ((double)(x >> 11) + 0.5) / 9007199254740992.0;
}

/* Does the segment cross the rectangle? */
static bool crosses(const double a[3], const double b[3], const double low[3], const double high[3])
{
    double below = a[1] - low[1], above = b[1] - low[1];
    if (below * above >= 0) return false;
    double share = below / (below - above), x = a[0] + share * (b[0] - a[0]), z = a[2] + share * (b[2] - a[2]);
    return x > low[0] && x < high[0] && z > low[2] && z < high[2];
}

/* What a scattering at p sends to all points. */
static void connect(const reference *points, int count, const double p[3], double weight, double sigma_t,
                      bool alive, const double low[3], const double high[3], int event, walk *w)
{
    for (int i = 0; i < count; i++) {
        double to[3], square = 0, cosine = 0;
        for (int k = 0; k < 3; k++) {
            to[k] = p[k] - points[i].position[k];
            square += to[k] * to[k];
            cosine += to[k] * points[i].normal[k];
        }
        if (cosine <= 0) continue;
        double r = sqrt(square), value = weight / (4 * AL_PI) * exp(-sigma_t * r) * cosine / (r * square);
        w->free[i][event] += value;
        if (alive && !crosses(p, points[i].position, low, high)) w->shaded[i][event] += value;
    }
}

static void random_walk(const reference *points, int count, double sigma_t, double albedo, const double low[3],
                        const double high[3], long paths, walk *w)
{
    uint64_t state = 5;
    double power = 10 * AL_PI * (high[0] - low[0]) * (high[2] - low[2]) / (double)paths;
    memset(w, 0, sizeof *w);
    for (long n = 0; n < paths; n++) {
        double u = random_unit(&state), phi = 2 * AL_PI * random_unit(&state), weight = power;
        double p[3] = {low[0] + (high[0] - low[0]) * random_unit(&state), low[1],
                       low[2] + (high[2] - low[2]) * random_unit(&state)};
        double v[3] = {sqrt(u) * cos(phi), -sqrt(1 - u), sqrt(u) * sin(phi)};
        bool alive = true;
        for (int event = 1; event <= ORDERS; event++) {
            double t = -log(random_unit(&state)) / sigma_t, next[3];
            for (int k = 0; k < 3; k++) next[k] = p[k] + t * v[k];
            if (event > 1 && crosses(p, next, low, high)) alive = false;
            memcpy(p, next, sizeof p);
            weight *= albedo;
            connect(points, count, p, weight, sigma_t, alive, low, high, event, w);
            double z = 2 * random_unit(&state) - 1, angle = 2 * AL_PI * random_unit(&state);
            v[0] = sqrt(1 - z * z) * cos(angle);
            v[1] = sqrt(1 - z * z) * sin(angle);
            v[2] = z;
        }
    }
}

/* --- comparison --- */

typedef struct outcome {
    double relative_rmse, ratio; /* of the sums over all points */
} outcome;

/* Tables, times what the rectangle leaves of them, against the reference; its error is taken out of the root mean
 * square. */
static outcome compare(const al_impulse_tables *tables, const reference *points, int count, const double low[3],
                       const double high[3], al_impulse_query q, const walk *w)
{
    double square = 0, noise = 0, total = 0, ours = 0, theirs = 0;
    uint32_t k = q.first_event;
    for (int i = 0; i < count; i++) {
        double e = from_light(tables, &points[i], low, high, &q), b = points[i].value[k];
        if (w && k > 0) e *= w->shaded[i][k] / w->free[i][k];
        square += (e - b) * (e - b);
        noise += points[i].error[k] * points[i].error[k];
        total += b * b;
        ours += e;
        theirs += b;
    }
    return (outcome){sqrt(fmax(0, square - noise) / total), ours / theirs};
}

static void test_fog(const al_impulse_tables *tables, const char *shared, const char *name, double sigma_t,
                     const double low[3], const double high[3])
{
    enum { PATHS = 200000 };
    static reference points[POINT_LIMIT];
    static walk w;
    char path[1024];
    snprintf(path, sizeof path, "%s/reference/open_area_%s.csv", shared, name);
    int count = read_reference(path, points);
    CHECK(count > 40);
    random_walk(points, count, sigma_t, 0.9, low, high, PATHS, &w);
    for (uint32_t k = 0; k <= ORDERS; k++) {
        al_impulse_query q = {.emitter = AL_IMPULSE_AREA, .first_event = k, .last_event = k,
                              .sigma_s_per_m = 0.9 * sigma_t, .sigma_a_per_m = 0.1 * sigma_t};
        double all = 0, noise = 0;
        for (int i = 0; i < count; i++) {
            double value = points[i].value[k];
            all += value;
            noise += points[i].error[k] * points[i].error[k];
        }
        outcome best = compare(tables, points, count, low, high, q, &w),
                raw = compare(tables, points, count, low, high, q, NULL), fitted;
        q.variant = AL_IMPULSE_PUBLISHED;
        fitted = compare(tables, points, count, low, high, q, &w);
        printf("%-5s %u events: m <= 2 %.2f %%, sums %+.2f %%; unshaded %.2f %%, %+.2f %%; fitted axis %.2f %%\n", name,
               k, 100 * best.relative_rmse, 100 * (best.ratio - 1), 100 * raw.relative_rmse, 100 * (raw.ratio - 1),
               100 * fitted.relative_rmse);
        CHECK(best.relative_rmse < 0.01);
        CHECK_NEAR(best.ratio, 1, 0.005 + 4 * sqrt(noise) / all);
    }
}

int main(int argc, char **argv)
{
    char path[1024];
    double low[3], high[3];
    if (argc != 3) return 2;
    al_impulse_tables *tables = tables_open(argv[1]);
    snprintf(path, sizeof path, "%s/reference/room.obj", argv[2]);
    if (!read_light(path, low, high)) return test_skip("shared/reference is not there");
    test_fog(tables, argv[2], "thin", 0.1, low, high);
    test_fog(tables, argv[2], "mid", 0.5, low, high);
    test_fog(tables, argv[2], "thick", 2, low, high);
    al_impulse_tables_free(tables);
    return test_end();
}
