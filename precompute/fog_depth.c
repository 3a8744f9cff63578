/* Spherical harmonics over the direction w of
 *   tau(x, w) = integral of the density from x along w to the bounds,
 * at a lattice of points x. By orthonormality the coefficient of Y(l, m) is the integral of tau Y(l, m) over the sphere.
 * Along a direction the density is summed by the midpoint rule, in steps of at most one voxel; between voxel centres it is
 * trilinear, as the player reads it.
 *
 * Directions are those of a product rule: equal steps in azimuth, and Fejer's first rule in the angle theta from +z, with
 * nodes at the middles of n equal steps of theta and the weights
 *   (2/n) (1 - 2 sum over j from 1 to n/2 of cos(2 j theta) / (4 j^2 - 1)),
 * exact for polynomials in cos theta of degree below n (Fejer 1933). It lies alike on both sides of every plane along the
 * axes, so that the jump of tau at the faces that a point stands on is summed without error (in a box of constant density a
 * set of as many directions that are spread evenly was off four times as much). What is left is measured in
 * tests/bake/depth_test.c: below 1 % of the largest band 0. */
#include "fog_depth.h"

#include <math.h>
#include <stdlib.h>

#include "airlight/formulas.h"
#include "bake_medium.h"
#include "geometry.h"
#include "parallel.h"

enum { CELLS = 16, CELLS_LEAST = 4, RINGS = 16, AZIMUTHS = 2 * RINGS, DIRECTIONS = RINGS * AZIMUTHS };
static const double inset = 1e-3; /* of the edge, of the outermost points: which side of a face they see must be sure */

static uint32_t order_of(const al_import *import, uint32_t fog)
{
    return import->description->media[import->scene.fogs[fog].medium].optical_depth_order;
}

const char *al_fog_depth_missing(const al_import *import, uint32_t fog)
{
    if (!order_of(import, fog)) return "no fog asks for optical_depth_order";
    return al_fog_varies(import, fog) ? NULL : "the density of the fogs that ask for it is constant: its depth is a length";
}

void al_fog_depths_place(const al_import *import, uint32_t fog, const al_bake_options *options, al_medium_data *data,
                         al_fog_depths *depths)
{
    double longest = 0;
    const al_medium_info *info = &data->info;
    *depths = (al_fog_depths){.depth.order = order_of(import, fog), .data = data, .options = options};
    for (int k = 0; k < 3; k++) longest = fmax(longest, (double)info->bounds_max_m[k] - info->bounds_min_m[k]);
    for (int k = 0; k < 3; k++) {
        double cells = ceil(CELLS * ((double)info->bounds_max_m[k] - info->bounds_min_m[k]) / longest - 1e-6);
        depths->depth.size[k] = 1 + (uint32_t)fmax(cells, CELLS_LEAST);
    }
    data->depth = &depths->depth;
    data->depths = al_fog_depths_make;
    data->depths_user = depths;
}

typedef struct projection {
    const al_medium_info *info;
    const float *density;
    const al_medium_depth *depth;
    uint32_t points, terms;
    double to_index[16], voxel_m;
    double (*directions)[3], *basis; /* [DIRECTIONS], [DIRECTIONS][terms] times the weight */
    float *coefficients;
    al_progress progress;
} projection;

/* As al_medium_evaluate, where there is a density. */
static double density_at(const projection *p, const double index[3])
{
    const uint32_t *size = p->info->size;
    size_t first[3];
    double share[3];
    for (int k = 0; k < 3; k++) {
        double last = size[k] - 1.0;
        double at = fmin(fmax(index[k], 0), last);
        first[k] = (size_t)fmin(at, size[k] > 1 ? last - 1 : 0);
        share[k] = at - (double)first[k];
    }
    size_t right = size[0] > 1, up = size[1] > 1 ? size[0] : 0, back = size[2] > 1 ? (size_t)size[0] * size[1] : 0;
    const float *v = p->density + (first[2] * size[1] + first[1]) * size[0] + first[0];
    double low = v[0] + share[0] * (v[right] - v[0]), high = v[up] + share[0] * (v[up + right] - v[up]),
           near = low + share[1] * (high - low);
    v += back;
    low = v[0] + share[0] * (v[right] - v[0]);
    high = v[up] + share[0] * (v[up + right] - v[up]);
    return near + share[2] * (low + share[1] * (high - low) - near);
}

/* Cuts [*from, *to] to where origin + t step lies between low and high along one axis. */
static void cut(double origin, double step, double low, double high, double *from, double *to)
{
    double a = (low - origin) / step, b = (high - origin) / step;
    if (step == 0) {
        if (origin < low || origin > high) *to = *from;
        return;
    }
    *from = fmax(*from, fmin(a, b));
    *to = fmin(*to, fmax(a, b));
}

static double depth_along(const projection *p, const double origin[3], const double direction[3])
{
    double from = 0, to = INFINITY, at[3], step[3], sum = 0;
    for (int k = 0; k < 3; k++) {
        const double *m = p->to_index + k;
        step[k] = m[0] * direction[0] + m[4] * direction[1] + m[8] * direction[2];
        at[k] = m[0] * origin[0] + m[4] * origin[1] + m[8] * origin[2] + m[12];
        cut(origin[k], direction[k], p->info->bounds_min_m[k], p->info->bounds_max_m[k], &from, &to);
        if (!p->info->extended) cut(at[k], step[k], -0.5, p->info->size[k] - 0.5, &from, &to);
    }
    if (!(from < to)) return 0;
    double count = ceil((to - from) / p->voxel_m), length = (to - from) / count;
    for (int k = 0; k < 3; k++) {
        step[k] *= length;
        at[k] += from / length * step[k] + 0.5 * step[k];
    }
    for (double i = 0; i < count; i++) {
        sum += density_at(p, at);
        for (int k = 0; k < 3; k++) at[k] += step[k];
    }
    return sum * length;
}

static bool project_point(void *user, unsigned index, unsigned thread)
{
    projection *p = user;
    double place[3], sums[AL_SH_MAX_COUNT] = {0};
    if (al_program_cancelled() || (!thread && al_progress_update(&p->progress, index, p->points))) return false;
    for (uint32_t k = 0, rest = index; k < 3; rest /= p->depth->size[k], k++) {
        double share = (rest % p->depth->size[k]) / (p->depth->size[k] - 1.0), low = p->info->bounds_min_m[k];
        place[k] = low + fmin(fmax(share, inset), 1 - inset) * (p->info->bounds_max_m[k] - low);
    }
    for (uint32_t i = 0; i < DIRECTIONS; i++) {
        double tau = depth_along(p, place, p->directions[i]);
        for (uint32_t n = 0; n < p->terms; n++) sums[n] += tau * p->basis[i * p->terms + n];
    }
    for (uint32_t n = 0; n < p->terms; n++)
        p->coefficients[(size_t)n * p->points + index] = (float)sums[n];
    return true;
}

/* The direction's weight, steradians. */
static double place_direction(int i, double direction[3])
{
    double theta = (i / AZIMUTHS + 0.5) * AL_PI / RINGS, angle = (i % AZIMUTHS + 0.5) * 2 * AL_PI / AZIMUTHS, sum = 0;
    for (int j = 1; j <= RINGS / 2; j++) sum += cos(2 * j * theta) / (4 * j * j - 1);
    direction[0] = sin(theta) * cos(angle);
    direction[1] = sin(theta) * sin(angle);
    direction[2] = cos(theta);
    return 2.0 / RINGS * (1 - 2 * sum) * 2 * AL_PI / AZIMUTHS;
}

static bool project(projection *p, unsigned threads)
{
    double directions[DIRECTIONS][3], world[16], values[AL_SH_MAX_COUNT];
    double *basis = malloc(sizeof *basis * DIRECTIONS * p->terms);
    if (!basis) return false;
    for (int i = 0; i < 16; i++) world[i] = p->info->grid_to_world[i];
    al_matrix_invert(world, p->to_index);
    p->voxel_m = INFINITY;
    for (int k = 0; k < 3; k++) {
        const double *axis = world + 4 * k;
        p->voxel_m = fmin(p->voxel_m, sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]));
    }
    for (int i = 0; i < DIRECTIONS; i++) {
        double weight = place_direction(i, directions[i]);
        al_sh_basis((int)p->depth->order, directions[i][0], directions[i][1], directions[i][2], values);
        for (uint32_t n = 0; n < p->terms; n++) basis[(uint32_t)i * p->terms + n] = weight * values[n];
    }
    p->directions = directions;
    p->basis = basis;
    bool done = al_parallel(threads, p->points, project_point, p);
    free(basis);
    return done;
}

al_status al_fog_depths_make(void *user, uint32_t frame, float *coefficients, al_error *error)
{
    al_fog_depths *depths = user;
    const al_medium_data *data = depths->data;
    const uint32_t *size = depths->depth.size;
    double started = al_program_seconds();
    size_t slice = (size_t)data->info.size[0] * data->info.size[1];
    float *density = malloc(slice * data->info.size[2] * sizeof *density);
    projection p = {.info = &data->info,
                    .density = density,
                    .depth = &depths->depth,
                    .points = size[0] * size[1] * size[2],
                    .terms = depths->depth.order * depths->depth.order,
                    .coefficients = coefficients};
    al_status status = density ? AL_OK : al_fail(error, AL_IO, "out of memory for the densities of a fog");
    for (uint32_t z = 0; z < data->info.size[2] && !status; z++)
        status = data->slice(data->user, frame, z, density + z * slice, error);
    al_progress_begin(&p.progress, depths->options->program, "fog depth");
    if (!status && !project(&p, depths->options->threads))
        status = al_program_cancelled() ? al_fail(error, AL_CANCELLED, "cancelled while optical depths were summed")
                                        : al_fail(error, AL_IO, "out of memory for the directions of optical depths");
    al_progress_end(&p.progress);
    free(density);
    depths->seconds += al_program_seconds() - started;
    return status;
}
