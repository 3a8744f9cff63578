/* Scattering is sampled, absorption is weighed.
 *
 * Each medium scatters as a Poisson process of its own along the ray; together they are the superposition of
 * those, so the first event of all is the first of the firsts, and nothing need be cut where media overlap. A
 * medium's candidate events come at the even rate m = max over channels and positions of sigma_s. At a
 * candidate it scatters with probability P = sum(w sigma_s) / (m sum(w)), w the throughput of the channels,
 * else it flies on; then scattered: w *= sigma_s / (m P),    not: w *= (m - sigma_s) / (m (1 - P)) keeps each
 * channel's expectation (Woodcock et al. 1965; Kutz, Habel, Li and Novak 2017, "Spectral and decomposition
 * tracking", with this history-aware choice). Grey media of constant density always scatter.
 *
 * Absorption multiplies w by exp(-integral of sigma_a) over what was flown: in closed form for constant
 * densities and layers. In a grid the product of 1 - sigma / m over the events of an independent process of
 * rate m >= sigma has that expectation (ratio tracking: Novak, Selle and Jarosz 2014). Transmittance is the
 * same with sigma_t. */
#include "media.h"

#include <math.h>
#include <stdlib.h>

#include "airlight/formulas.h"

typedef struct al_tracked_medium {
    al_march_medium from;
    double sigma_a_per_m[3];
    double rate_per_m;      /* of candidate events */
    double mean_rate_per_m; /* a guess at the rate of scattering, for al_media_flight_density */
    bool bounded;
    double low[3], high[3];
} medium;

static medium medium_of(const al_import *import, uint32_t index)
{
    medium made = {.from = al_march_medium_of(import, index)};
    double most = al_density_max(made.from.density), largest = 0, mean = 0;
    for (int c = 0; c < 3; c++) {
        made.sigma_a_per_m[c] = made.from.sigma_t_per_m[c] - made.from.sigma_s_per_m[c];
        largest = fmax(largest, made.from.sigma_s_per_m[c]);
        mean += made.from.sigma_s_per_m[c] / 3;
    }
    made.rate_per_m = most * largest;
    made.mean_rate_per_m = most * mean * (made.from.description->type == AL_DENSITY_CONSTANT ? 1 : 0.5);
    made.bounded = al_density_bounds(made.from.density, made.low, made.high);
    return made;
}

al_status al_media_create(const al_import *import, al_media *media, al_error *error)
{
    const al_scene *scene = &import->scene;
    *media = (al_media){.fog_count = scene->fog_count, .object_count = scene->translucent_count};
    size_t count = (size_t)scene->fog_count + scene->translucent_count;
    media->media = malloc(sizeof(medium) * (count + 1));
    if (!media->media) return al_fail(error, AL_IO, "out of memory for %zu media", count);
    for (uint32_t i = 0; i < scene->fog_count; i++)
        media->media[i] = medium_of(import, scene->fogs[i].medium);
    for (uint32_t i = 0; i < scene->translucent_count; i++)
        media->media[scene->fog_count + i] = medium_of(import, scene->translucents[i].medium);
    return AL_OK;
}

void al_media_free(al_media *media)
{
    free(media->media);
    *media = (al_media){0};
}

/* --- lines --- */

void al_media_line_free(al_media_line *line)
{
    al_line_free(&line->segments);
    free(line->parts);
    free(line->marched);
    *line = (al_media_line){0};
}

static void push_part(const al_media *media, uint32_t index, double begin_m, double end_m,
                      al_media_line *line)
{
    const medium *m = &media->media[index];
    const al_ray *ray = line->ray;
    for (int k = 0; m->bounded && k < 3; k++) {
        double low = m->low[k] - ray->origin[k], high = m->high[k] - ray->origin[k];
        if (ray->direction[k] == 0) {
            if (low > 0 || high < 0) return;
            continue;
        }
        double a = low / ray->direction[k], b = high / ray->direction[k];
        begin_m = fmax(begin_m, fmin(a, b));
        end_m = fmin(end_m, fmax(a, b));
    }
    if (begin_m < end_m)
        line->parts[line->part_count++] =
            (al_media_part){.medium = index, .begin_m = begin_m, .end_m = end_m};
}

bool al_media_line_fill(const al_media *media, const al_ray_scene *scene, const al_ray *ray, double end_m,
                        al_media_line *line)
{
    line->media = media;
    line->ray = ray;
    line->part_count = line->segments.segment_count = 0;
    if (media->object_count && !al_ray_scene_segments(scene, ray, end_m, &line->segments)) return false;
    size_t wanted = (size_t)media->fog_count + line->segments.segment_count;
    if (wanted > line->part_room) {
        if (wanted > UINT32_MAX / 2) return false;
        al_media_part *grown = realloc(line->parts, sizeof *grown * 2 * wanted);
        if (!grown) return false;
        line->parts = grown;
        al_march_part *marched = realloc(line->marched, sizeof *marched * 2 * wanted);
        if (!marched) return false;
        line->marched = marched;
        line->part_room = (uint32_t)(2 * wanted);
    }
    for (uint32_t i = 0; i < media->fog_count; i++) push_part(media, i, 0, end_m, line);
    for (uint32_t i = 0; i < line->segments.segment_count; i++) {
        const al_segment *segment = &line->segments.segments[i];
        push_part(media, media->fog_count + segment->object, segment->begin_m, segment->end_m, line);
    }
    return true;
}

static double density_at(const medium *m, const al_ray *ray, double distance_m)
{
    double position[3];
    if (m->from.description->type == AL_DENSITY_CONSTANT) return m->from.description->scale;
    for (int k = 0; k < 3; k++) position[k] = ray->origin[k] + distance_m * ray->direction[k];
    return al_density_at(m->from.density, position);
}

/* --- attenuation --- */

static double largest(const double v[3])
{
    return fmax(fmax(v[0], v[1]), v[2]);
}

/* To the next event of a Poisson process. */
static double step_m(double rate_per_m, al_random *random)
{
    return -log1p(-al_random_real(random)) / rate_per_m;
}

/* Multiplies by the product of 1 - sigma / m. What has become small dies by Russian roulette. */
static void track_ratio(const medium *m, const al_ray *ray, const double sigma_per_m[3], double begin_m,
                        double end_m, al_random *random, double throughput[3])
{
    double rate = largest(sigma_per_m) * al_density_max(m->from.density), ratio[3] = {1, 1, 1};
    if (!(rate > 0)) return;
    for (double at = begin_m + step_m(rate, random); at < end_m; at += step_m(rate, random)) {
        double density = density_at(m, ray, at);
        for (int c = 0; c < 3; c++) ratio[c] *= fmax(0, 1 - sigma_per_m[c] * density / rate);
        if (largest(ratio) >= 0.05) continue;
        bool lives = al_random_real(random) < 0.5;
        for (int c = 0; c < 3; c++) ratio[c] *= lives ? 2 : 0;
        if (!lives) break;
    }
    for (int c = 0; c < 3; c++) throughput[c] *= ratio[c];
}

static void attenuate_part(const medium *m, const al_ray *ray, const double sigma_per_m[3], double begin_m,
                           double end_m, al_random *random, double throughput[3])
{
    if (!(begin_m < end_m) || !(largest(sigma_per_m) > 0)) return;
    if (m->from.description->type == AL_DENSITY_GRID) {
        track_ratio(m, ray, sigma_per_m, begin_m, end_m, random, throughput);
        return;
    }
    double length = m->from.description->type == AL_DENSITY_CONSTANT
                        ? (end_m - begin_m) * m->from.description->scale
                        : al_march_length(&m->from, ray, begin_m, end_m);
    for (int c = 0; c < 3; c++)
        if (sigma_per_m[c] > 0) throughput[c] *= exp(-sigma_per_m[c] * length);
}

static void absorb(const al_media_line *line, double end_m, al_random *random, double throughput[3])
{
    for (uint32_t i = 0; i < line->part_count; i++) {
        const al_media_part *part = &line->parts[i];
        const medium *m = &line->media->media[part->medium];
        attenuate_part(m, line->ray, m->sigma_a_per_m, part->begin_m, fmin(part->end_m, end_m), random,
                       throughput);
    }
}

void al_media_attenuate(const al_media_line *line, double end_m, al_random *random, double throughput[3])
{
    for (uint32_t i = 0; i < line->part_count; i++) {
        const al_media_part *part = &line->parts[i];
        const medium *m = &line->media->media[part->medium];
        attenuate_part(m, line->ray, m->from.sigma_t_per_m, part->begin_m, fmin(part->end_m, end_m), random,
                       throughput);
    }
}

/* --- marching --- */

/* Beyond 50 optical depths exp(-tau) is 2e-22. */
static const double nothing_left = 50;

/* The least that a medium takes from a channel per metre, where it takes anything; INFINITY for nothing. */
static double least_per_m(const al_march_medium *from)
{
    const al_density_description *density = from->description;
    double least = INFINITY, densities[2] = {density->scale, density->scale};
    if (density->type == AL_DENSITY_LAYERS) densities[0] *= density->low, densities[1] *= density->high;
    for (int i = 0; i < 2; i++)
        for (int c = 0; c < 3; c++) {
            double sigma_per_m = densities[i] * from->sigma_t_per_m[c];
            if (sigma_per_m > 0) least = fmin(least, sigma_per_m);
        }
    return least;
}

/* A part that does not end, of a medium without bounds, is cut off where nothing comes through it. */
static al_march_part march_part(const al_media_line *line, uint32_t index, double end_m)
{
    const al_media_part *at = &line->parts[index];
    al_march_part part = {&line->media->media[at->medium].from, at->begin_m, fmin(at->end_m, end_m)};
    if (!isfinite(part.end_m)) part.end_m = part.begin_m + nothing_left / least_per_m(part.medium);
    return part;
}

void al_media_transmittance(const al_media_line *line, double end_m, double transmittance[3])
{
    double depth[3] = {0};
    for (uint32_t i = 0; i < line->part_count; i++) {
        al_march_part part = march_part(line, i, end_m);
        if (!(part.begin_m < part.end_m)) continue;
        double length = al_march_length(part.medium, line->ray, part.begin_m, part.end_m);
        for (int c = 0; c < 3; c++) depth[c] += part.medium->sigma_t_per_m[c] * length;
    }
    for (int c = 0; c < 3; c++) transmittance[c] = exp(-depth[c]);
}

bool al_media_cells(al_media_line *line, al_cells *cells)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < line->part_count; i++) {
        al_march_part part = march_part(line, i, INFINITY);
        if (part.begin_m < part.end_m) line->marched[count++] = part;
    }
    return al_march_cells(line->ray, line->marched, count, cells);
}

/* --- flight --- */

/* Whether the medium scatters at a candidate event; weighs the throughput for either. */
static bool scatters(const medium *m, double density, al_random *random, double throughput[3])
{
    double rate = m->rate_per_m, wanted = 0, sum = 0, share[3];
    for (int c = 0; c < 3; c++) {
        share[c] = fmin(m->from.sigma_s_per_m[c] * density / rate, 1);
        wanted += throughput[c] * share[c];
        sum += throughput[c];
    }
    double chance = sum > 0 ? wanted / sum : 0;
    bool yes = al_random_real(random) < chance;
    for (int c = 0; c < 3; c++) throughput[c] *= yes ? share[c] / chance : (1 - share[c]) / (1 - chance);
    return yes;
}

al_flight al_media_fly(al_media_line *line, double end_m, al_random *random, double throughput[3])
{
    al_flight flight = {.distance_m = end_m};
    const al_media *media = line->media;
    for (uint32_t i = 0; i < line->part_count; i++) {
        al_media_part *part = &line->parts[i];
        double rate = media->media[part->medium].rate_per_m;
        part->next_m = rate > 0 ? part->begin_m + step_m(rate, random) : INFINITY;
    }
    while (!flight.scattered && largest(throughput) > 0) {
        al_media_part *first = NULL;
        for (uint32_t i = 0; i < line->part_count; i++) {
            al_media_part *part = &line->parts[i];
            if (part->next_m < part->end_m && (!first || part->next_m < first->next_m)) first = part;
        }
        if (!first) break;
        const medium *m = &media->media[first->medium];
        flight.scattered = scatters(m, density_at(m, line->ray, first->next_m), random, throughput);
        flight.distance_m = flight.scattered ? first->next_m : end_m;
        flight.medium = first->medium;
        first->next_m += step_m(m->rate_per_m, random);
    }
    absorb(line, flight.distance_m, random, throughput);
    return flight;
}

/* --- at a distance --- */

bool al_media_part_scatters(const al_media_line *line, uint32_t part, double distance_m,
                            double sigma_s_per_m[3], double *g)
{
    const al_media_part *at = &line->parts[part];
    const medium *m = &line->media->media[at->medium];
    if (distance_m < at->begin_m || distance_m > at->end_m) return false;
    double density = density_at(m, line->ray, distance_m);
    for (int c = 0; c < 3; c++) sigma_s_per_m[c] = m->from.sigma_s_per_m[c] * density;
    *g = m->from.g;
    return density > 0;
}

double al_media_flight_density(const al_media_line *line, double distance_m)
{
    double rate = 0, depth = 0;
    for (uint32_t i = 0; i < line->part_count; i++) {
        const al_media_part *part = &line->parts[i];
        double here = line->media->media[part->medium].mean_rate_per_m;
        if (distance_m <= part->begin_m) continue;
        depth += here * (fmin(part->end_m, distance_m) - part->begin_m);
        if (distance_m <= part->end_m) rate += here;
    }
    return rate * exp(-depth);
}

double al_media_asymmetry(const al_media *media, uint32_t medium_index)
{
    return media->media[medium_index].from.g;
}
