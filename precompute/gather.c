#include "gather.h"

#include <math.h>
#include <stdlib.h>

#include "airlight/formulas.h"
#include "fog_points.h"
#include "gather_path.h"
#include "gather_response.h"

/* --- what all points share --- */

/* Published walls: the tables, and whether light stays finite with them. */
static al_status open_responses(al_gather *gather, al_error *error)
{
    double gain;
    if (!gather->tables)
        return al_fail(error, AL_USAGE, "%s: published walls need impulse tables", gather->path);
    al_status status = al_gather_responses_create(gather, error);
    if (status) return status;
    gather->responds = true;
    al_gather_scratch *scratch = al_gather_scratch_new(gather);
    bool done = scratch && al_gather_gain(gather, scratch, &gain);
    al_gather_scratch_free(scratch);
    if (!done) return al_fail(error, AL_IO, "out of memory for the light gathering");
    if (gain < 1) return AL_OK;
    return al_fail(
        error, AL_BAD_INPUT,
        "lightmap.walls: with \"published\" light would grow without limit, %.3g times from "
        "surface to surface, as it passes through walls: darker surfaces, fog that absorbs more or "
        "\"bounded\" walls are right",
        gain);
}

static al_status open_parts(al_gather *gather, const al_import *import, al_error *error)
{
    al_status status = al_ray_scene_create(import, AL_RAY_SCENE_STILL, &gather->rays, error);
    if (!status) status = al_gather_lights_create(import, gather->rays, &gather->lights, error);
    if (!status && gather->options.fog) status = al_fog_media_create(import, &gather->fog, error);
    if (status || !gather->fog.scatters) return status;
    return gather->options.walls == AL_WALLS_PUBLISHED ? open_responses(gather, error)
                                                       : al_fog_points_create(gather, error);
}

al_status al_gather_open(const al_import *import, const al_impulse_tables *tables,
                         const al_gather_options *options, al_gather **gather, al_error *error)
{
    *gather = NULL;
    al_gather *made = calloc(1, sizeof *made);
    if (!made) return al_fail(error, AL_IO, "out of memory for the light gathering");
    made->options = *options;
    made->tables = tables;
    made->path = import->description->path;
    al_status status = open_parts(made, import, error);
    if (status)
        al_gather_close(made);
    else
        *gather = made;
    return status;
}

void al_gather_close(al_gather *gather)
{
    if (!gather) return;
    al_fog_points_free(gather->points);
    al_gather_responses_free(gather);
    al_fog_media_free(&gather->fog);
    al_gather_lights_free(&gather->lights);
    al_ray_scene_free(gather->rays);
    free(gather);
}

al_gather_scratch *al_gather_scratch_new(const al_gather *gather)
{
    (void)gather;
    return calloc(1, sizeof(al_gather_scratch));
}

void al_gather_scratch_free(al_gather_scratch *scratch)
{
    if (!scratch) return;
    al_fog_path_free(&scratch->fog);
    free(scratch);
}

/* --- a point --- */

static const double back_shift_texels = 0.125;
enum { WAYS_LEAST = 64, WAYS_ENOUGH = 128, PATHS_PER_WAY = 4 };
typedef struct summing {
    const al_gather *gather;
    al_gather_scratch *scratch;
    al_gather_vertex vertex;
    al_gathered *out;
} summing;

static double cosine_of(const summing *s, const double direction[3])
{
    const double *normal = s->vertex.normal;
    return normal[0] * direction[0] + normal[1] * direction[1] + normal[2] * direction[2];
}

/* Adds radiance from one direction, times solid angle, to a layer. */
static void add(summing *s, al_gather_layer layer, const double direction[3], const double basis[],
                const double power[3])
{
    double cosine = cosine_of(s, direction);
    double *irradiance[] = {s->out->surface, s->out->attenuated, s->out->scattered};
    uint32_t order = s->gather->options.sh_order, count = order * order;
    for (int c = 0; c < 3; c++) {
        irradiance[layer][c] += fmax(0, cosine) * power[c];
        for (uint32_t k = 0; k < count; k++) s->out->sh[layer][c][k] += basis[k] * power[c];
    }
}

static void fill_basis(const summing *s, const double direction[3], double basis[AL_SH_MAX_COUNT])
{
    if (s->gather->options.sh_order)
        al_sh_basis((int)s->gather->options.sh_order, direction[0], direction[1], direction[2], basis);
}

/* Adds what the fog of published walls scatters to the point from a source. */
static void add_response(summing *s, const al_gather_source *source, const double power[3])
{
    double response[3];
    if (!s->vertex.in_air) {
        al_gather_response(s->gather, source, s->vertex.normal, response);
        for (int c = 0; c < 3; c++) s->out->scattered[c] += power[c] * response[c];
    }
    if (s->gather->options.sh_order)
        al_gather_response_sh(s->gather, source, power, s->gather->options.sh_order,
                              s->out->sh[AL_GATHER_SCATTERED]);
}

static void add_lights(summing *s, al_sequence *sequence, double weight)
{
    for (int kind = 0; kind < AL_LIGHT_KIND_COUNT; kind++) {
        al_gather_straight straight;
        double basis[AL_SH_MAX_COUNT], plain[3], through[3], power[3];
        if (!al_gather_look(s->gather, s->scratch, &s->vertex, (al_light_kind)kind, sequence, &straight))
            continue;
        const al_light_sample *light = &straight.light;
        for (int c = 0; c < 3; c++) {
            power[c] = weight * straight.share * light->power[c];
            plain[c] = power[c] * light->facing;
            through[c] = plain[c] * straight.transmittance[c];
        }
        fill_basis(s, light->direction, basis);
        if (kind != AL_LIGHT_KIND_LAMP || !s->gather->options.lamps_apart) {
            add(s, AL_GATHER_SURFACE, light->direction, basis, plain);
            add(s, AL_GATHER_ATTENUATED, light->direction, basis, through);
        }
        if (!s->gather->responds) continue;
        al_gather_source source = al_gather_source_of_light(&straight);
        add_response(s, &source, power);
    }
}

static void add_response_of_way(summing *s, const al_gather_way *way, double share)
{
    al_gather_source source;
    double scale, power[3];
    if (!al_gather_source_of_way(way, &source, &scale)) return;
    for (int c = 0; c < 3; c++) power[c] = share * scale * way->sent[AL_GATHER_TOTAL][c];
    add_response(s, &source, power);
}

/* A way that light arrives along. The power per radiance over all directions, 0 where nothing is drawn, in
 * `share`. False without memory. */
static bool follow(summing *s, al_sequence *sequence, bool surfaces, al_gather_way *way, double *share)
{
    double u[2];
    *share = 0;
    way->asks = s->vertex.asks;
    way->scatters = s->vertex.scatters;
    way->surfaces = surfaces;
    way->places = AL_GATHER_FIRST_PLACES;
    al_sequence_pair(sequence, u);
    al_gather_draw(&s->vertex, u, way->ray.direction, &way->density_per_sr);
    if (!(way->density_per_sr > 0)) return true;
    al_gather_origin(&s->vertex, way->ray.direction, way->ray.origin);
    bool behind = !s->vertex.in_air && cosine_of(s, way->ray.direction) <= 0;
    if (behind && !s->vertex.looks_back) return true;
    *share = 1 / way->density_per_sr;
    double carried[3] = {*share, *share, *share};
    return al_gather_follow(s->gather, s->scratch, s->gather->options.bounces, carried, 1, sequence, way);
}

/* One of the ways: its shares of paths over surfaces and of scattered light, 0 where it is none of them. */
static bool add_way(summing *s, al_sequence *sequence, double weight, double scattered_weight)
{
    double basis[AL_SH_MAX_COUNT], plain[3], through[3], scattered[3], share;
    al_gather_way way;
    if (!follow(s, sequence, weight > 0, &way, &share)) return false;
    if (!(share > 0)) return true;
    if (s->gather->responds) add_response_of_way(s, &way, weight * share);
    if (!s->vertex.in_air && cosine_of(s, way.ray.direction) <= 0) return true;
    fill_basis(s, way.ray.direction, basis);
    for (int c = 0; c < 3; c++) {
        double sent = way.sent[AL_GATHER_TOTAL][c] - way.sent[AL_GATHER_ATTENUATED][c];
        scattered[c] = scattered_weight * share * (way.transmittance[c] * sent + way.scattered[c]);
        plain[c] = weight * share * way.sent[AL_GATHER_SURFACE][c];
        through[c] = weight * share * way.transmittance[c] * way.sent[AL_GATHER_ATTENUATED][c];
    }
    add(s, AL_GATHER_SCATTERED, way.ray.direction, basis, scattered);
    if (!(weight > 0)) return true;
    add(s, AL_GATHER_SURFACE, way.ray.direction, basis, plain);
    add(s, AL_GATHER_ATTENUATED, way.ray.direction, basis, through);
    if (way.met && !way.hit.front && !way.hit.material->double_sided) s->out->back_share += weight;
    return true;
}

/* On how many of the ways scattered light counts. Of bounded walls it is smooth, and the light of the fog's
 * points is not known better than within a percent, so that it takes fewer than surfaces do. Its noise falls
 * faster than their number grows, while the points cost the same for any: where paths are few there are ways
 * beyond them, which end where the points know. */
static uint32_t ways_of(const al_gather *gather, uint32_t samples)
{
    if (!gather->points || gather->options.walls != AL_WALLS_BOUNDED) return samples;
    if (samples < WAYS_ENOUGH) return samples > WAYS_LEAST ? samples : WAYS_LEAST;
    return samples / PATHS_PER_WAY > WAYS_ENOUGH ? samples / PATHS_PER_WAY : WAYS_ENOUGH;
}

bool al_gather_point(const al_gather *gather, al_gather_scratch *scratch, const double position[3],
                     const double *normal, double texel_m, uint64_t seed, al_gathered *out)
{
    summing s = {.gather = gather, .scratch = scratch, .out = out};
    *out = (al_gathered){0};
    s.vertex.in_air = !normal;
    s.vertex.asks = gather->responds;
    s.vertex.looks_back = normal && gather->options.back_scatter && gather->responds;
    double shift_m = gather->options.back_scatter_shift_m > 0 ? gather->options.back_scatter_shift_m
                                                              : back_shift_texels * texel_m;
    s.vertex.offset_m = al_ray_scene_offset_m(gather->rays);
    for (int k = 0; k < 3; k++) {
        s.vertex.normal[k] = normal ? normal[k] : 0;
        s.vertex.position[k] = position[k] + (s.vertex.looks_back ? shift_m * normal[k] : 0);
    }
    al_gather_vertex plain = s.vertex, foggy = s.vertex;
    foggy.scatters = gather->points;
    al_gather_find_glow(gather, &foggy);
    uint32_t samples = gather->options.samples ? gather->options.samples : 1, ways = ways_of(gather, samples);
    for (uint32_t i = 0; i < samples || i < ways; i++) {
        al_sequence sequence = {.index = i, .seed = al_mix_bits(seed + 1)};
        double weight = i < samples ? 1.0 / samples : 0;
        s.vertex = i < ways ? foggy : plain;
        if (!add_way(&s, &sequence, weight, i < ways ? 1.0 / ways : 0)) return false;
        if (weight > 0) add_lights(&s, &sequence, weight);
    }
    return true;
}
