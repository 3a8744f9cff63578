#include "scatter_point.h"

#include <math.h>

static double mean_of(const double v[3])
{
    return (v[0] + v[1] + v[2]) / 3;
}

bool al_scatter_mixture_create(const al_ray *eye, const al_cells *cells, const double *light,
                               al_scatter_mixture *mixture)
{
    bool alike = cells->depth[0] == cells->depth[1] && cells->depth[0] == cells->depth[2];
    *mixture = (al_scatter_mixture){
        .eye = eye, .cells = cells, .channels = alike ? 1 : 3, .mean_depth = mean_of(cells->depth)};
    if (!(mixture->mean_depth > 0)) return false;
    double begin_m = cells->cells[0].begin_m, end_m = cells->cells[cells->count - 1].end_m;
    mixture->by_angle = light && al_angles_aim(eye, begin_m, end_m, light, &mixture->angles);
    mixture->share = mixture->by_angle ? 1.0 / 3 : 0.5;
    return true;
}

/* Probability per metre of a distance within a cell, and in `cumulative` the probability of drawing less:
 *   transmittance:  F = (1 - exp(-tau(t))) / (1 - exp(-tau)), mean over the channels (0 where tau is 0)
 *   optical depth:  F = tau(t) / tau, of the mean over the channels
 *   equal angles:   F = (angle(t) - first) / (last - first) */
static double mixture_density(const al_scatter_mixture *m, const al_cell *cell, double distance_m,
                              double *cumulative)
{
    double into = distance_m - cell->begin_m, density = 0;
    *cumulative = 0;
    for (int c = 0; c < m->channels; c++) {
        double depth = cell->depth[c] + into * cell->sigma_t_per_m[c], all = -expm1(-m->cells->depth[c]);
        if (!(all > 0)) continue;
        *cumulative += -expm1(-depth) / all / m->channels;
        density += cell->sigma_t_per_m[c] * exp(-depth) / all / m->channels;
    }
    *cumulative += (mean_of(cell->depth) + into * mean_of(cell->sigma_t_per_m)) / m->mean_depth;
    density += mean_of(cell->sigma_t_per_m) / m->mean_depth;
    if (m->by_angle) {
        *cumulative += al_angles_cumulative(&m->angles, distance_m);
        density += al_angles_density(&m->angles, distance_m);
    }
    *cumulative *= m->share;
    return density * m->share;
}

/* The distance in a cell where the cumulative probability is u: Newton's method, kept within the bracket. */
static double invert_in_cell(const al_scatter_mixture *m, const al_cell *cell, double u)
{
    enum { STEPS = 60 };
    double low = cell->begin_m, high = cell->end_m, at = 0.5 * (low + high);
    for (int i = 0; i < STEPS && high - low > 1e-12 * cell->end_m; i++) {
        double cumulative, density = mixture_density(m, cell, at, &cumulative);
        if (fabs(cumulative - u) < 1e-13) break;
        if (cumulative < u)
            low = at;
        else
            high = at;
        at -= (cumulative - u) / density;
        if (!(at > low && at < high)) at = 0.5 * (low + high);
    }
    return at;
}

static void fill_point(const al_scatter_mixture *m, const al_cell *cell, double distance_m,
                       al_scatter_point *out)
{
    double cumulative;
    out->cell = cell;
    out->distance_m = distance_m;
    out->density_per_m = mixture_density(m, cell, distance_m, &cumulative);
    for (int c = 0; c < 3; c++) {
        double into = distance_m - cell->begin_m;
        out->transmittance[c] = exp(-(cell->depth[c] + into * cell->sigma_t_per_m[c]));
        out->position[c] = m->eye->origin[c] + distance_m * m->eye->direction[c];
    }
}

bool al_scatter_point_draw(const al_scatter_mixture *m, double u, al_scatter_point *point)
{
    double cumulative;
    uint32_t low = 0, high = m->cells->count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        const al_cell *cell = &m->cells->cells[middle];
        mixture_density(m, cell, cell->begin_m, &cumulative);
        if (cumulative <= u)
            low = middle;
        else
            high = middle;
    }
    const al_cell *cell = &m->cells->cells[low];
    mixture_density(m, cell, cell->end_m, &cumulative);
    if (u > cumulative && low + 1 < m->cells->count) return false;
    fill_point(m, cell, invert_in_cell(m, cell, u), point);
    return point->density_per_m > 0;
}

bool al_scatter_point_at(const al_scatter_mixture *m, double distance_m, al_scatter_point *point)
{
    uint32_t low = 0, high = m->cells->count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (m->cells->cells[middle].begin_m <= distance_m)
            low = middle;
        else
            high = middle;
    }
    const al_cell *cell = &m->cells->cells[low];
    if (!(distance_m >= cell->begin_m && distance_m <= cell->end_m)) return false;
    fill_point(m, cell, distance_m, point);
    return true;
}

/* Light travels along -towards, then along -eye. */
static double cosine_of(const al_scatter_mixture *m, const double towards[3])
{
    return al_dot(towards, m->eye->direction);
}

static const al_cell_part *part_of(const al_scatter_mixture *m, const al_scatter_point *point, uint32_t i)
{
    return &m->cells->parts[point->cell->first_part + i];
}

void al_scatter_towards(const al_scatter_mixture *m, const al_scatter_point *point, const double towards[3],
                        double out[3])
{
    double cosine = cosine_of(m, towards);
    out[0] = out[1] = out[2] = 0;
    for (uint32_t i = 0; i < point->cell->part_count; i++) {
        const al_cell_part *part = part_of(m, point, i);
        double phase = al_phase(part->medium->g, cosine);
        for (int c = 0; c < 3; c++) out[c] += part->medium->sigma_s_per_m[c] * part->density * phase;
    }
}

static double scattering(const al_cell_part *part)
{
    return part->density * mean_of(part->medium->sigma_s_per_m);
}

double al_scatter_direction_density(const al_scatter_mixture *m, const al_scatter_point *point,
                                    const double towards[3])
{
    double cosine = cosine_of(m, towards), all = 0, sum = 0;
    for (uint32_t i = 0; i < point->cell->part_count; i++) {
        const al_cell_part *part = part_of(m, point, i);
        all += scattering(part);
        sum += scattering(part) * al_phase(part->medium->g, cosine);
    }
    return all > 0 ? sum / all : 0;
}

double al_scatter_draw_direction(const al_scatter_mixture *m, const al_scatter_point *point,
                                 const double u[2], double towards[3])
{
    double all = 0, left, g = 0, share = 1;
    for (uint32_t i = 0; i < point->cell->part_count; i++) all += scattering(part_of(m, point, i));
    if (!(all > 0)) return 0;
    left = u[0] * all;
    for (uint32_t i = 0; i < point->cell->part_count; i++) {
        const al_cell_part *part = part_of(m, point, i);
        if (!(scattering(part) > 0)) continue;
        g = part->medium->g;
        share = scattering(part);
        if (left < share) break;
        left -= share;
    }
    al_direction_about(m->eye->direction, al_phase_cosine(g, fmin(left / share, 1)), 2 * AL_PI * u[1],
                       towards);
    return al_scatter_direction_density(m, point, towards);
}
