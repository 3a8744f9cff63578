/* How many surfels a scene becomes.
 *
 * A triangle of area |T| becomes n fine surfels of area A = |T|/n, each somewhere on it, evenly, and kept
 * with probability min(1, A/A*(x)). The expected number is n / |T| integral over T of min(1, A/A*(x)) dx =
 * integral over T of dx / max(A, A*(x)), which is the integral of dx / A*(x), as A is chosen no larger than
 * A* at the triangle's nearest point. (Where not even a split triangle can be cut as finely as that, there
 * are fewer.) Were they kept or not independently, the variance would be the sum of p (1 - p), at most the
 * expected number; random numbers that are even over each triangle leave less.
 *
 * The integral, of 1 / (A1 max(d, d0)^2), is summed over parts of triangles that are small beside their
 * distance, each by the midpoints of its edges, exact for quadratics. */
#include <math.h>
#include <string.h>

#include "state.h"

enum { DEPTH_LIMIT = 24 };

static double distance(const double a[3], const double b[3])
{
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                (a[2] - b[2]) * (a[2] - b[2]));
}

static double area_of(double t[3][3])
{
    double u[3], v[3], sum = 0;
    for (int k = 0; k < 3; k++) u[k] = t[1][k] - t[0][k], v[k] = t[2][k] - t[0][k];
    for (int k = 0; k < 3; k++)
        sum += pow(u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3], 2);
    return 0.5 * sqrt(sum);
}

/* Halves the longest edge until the part is half as long as it is away, or lies within d0. */
static double integrate(const al_surfel_rule *rule, double t[3][3], double area, int depth)
{
    double middles[3][3], longest = 0, farthest = 0, sum = 0;
    int split = 0;
    for (int i = 0; i < 3; i++) { /* middles[i] is across from corner i */
        const double *a = t[(i + 1) % 3], *b = t[(i + 2) % 3];
        for (int k = 0; k < 3; k++) middles[i][k] = (a[k] + b[k]) / 2;
        double away = distance(middles[i], rule->eye), edge = distance(a, b);
        if (edge > longest) longest = edge, split = i;
        farthest = fmax(farthest, away);
        away = fmax(away, rule->nearest_m);
        sum += area / 3 / (rule->area * away * away);
    }
    if (depth == DEPTH_LIMIT || longest <= 0.5 * fmax(farthest - longest, 0) ||
        farthest + longest <= rule->nearest_m)
        return sum;
    sum = 0;
    for (int half = 1; half <= 2; half++) {
        double part[3][3];
        memcpy(part, t, sizeof part);
        memcpy(part[(split + half) % 3], middles[split], sizeof part[0]);
        sum += integrate(rule, part, area / 2, depth + 1);
    }
    return sum;
}

static double expected_of(const al_mesh *mesh, const float world[16], const al_surfel_rule *rule)
{
    double sum = 0;
    for (uint32_t i = 0; i + 2 < mesh->index_count; i += 3) {
        double t[3][3];
        for (int corner = 0; corner < 3; corner++) {
            const float *p = mesh->positions + 3 * (size_t)mesh->indices[i + (uint32_t)corner];
            for (int k = 0; k < 3; k++)
                t[corner][k] = (double)world[k] * p[0] + (double)world[4 + k] * p[1] +
                               (double)world[8 + k] * p[2] + world[12 + k];
        }
        double area = area_of(t);
        if (!(area > 0) || !isfinite(area)) continue;
        sum += rule->eye[3] > 0 ? integrate(rule, t, area, 0) : area / rule->area;
    }
    return sum;
}

double al_surfels_expected(const al_scene *scene, const al_surfel_rule *rule)
{
    double sum = 0;
    for (uint32_t i = 0; i < scene->instance_count; i++) {
        const al_instance *instance = &scene->instances[i];
        if (instance->role == AL_ROLE_OPAQUE)
            sum += expected_of(&scene->meshes[instance->mesh], instance->world, rule);
    }
    return sum;
}
