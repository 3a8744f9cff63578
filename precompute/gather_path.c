/* The radiance that a surface point y sends is emission plus albedo/pi times its irradiance,
 *
 *   E(y) = integral of L(y, w) cos dw = integral of (T(y, w) Lo(y', -w) + S(y, w)) cos dw,
 *
 * Lo what the next surface y' sends, T the fog's transmittance in between, S the light scattered in between.
 * It is estimated by one direction, drawn in proportion to the cosine, for what reflects, and one point of
 * each kind of light. Lights that a direction may meet (emissive surfaces, the sky) are found both ways,
 * weighted by the balance heuristic (Veach and Guibas 1995). `surface` leaves out T and S, `attenuated` S. */
#include "gather_path.h"

#include <math.h>

#include "airlight/formulas.h"
#include "fog_points.h"
#include "gather_response.h"
#include "gather_scatter.h"

/* After so many reflections a path may end by chance, the more likely the less it carries. */
static const double roulette_importance = 0.25;

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

void al_gather_origin(const al_gather_vertex *vertex, const double direction[3], double origin[3])
{
    double step = vertex->in_air ? 0 : vertex->offset_m;
    if (dot(vertex->normal, direction) < 0) step = -step;
    for (int k = 0; k < 3; k++) origin[k] = vertex->position[k] + step * vertex->normal[k];
}

/* --- directions --- */

/* Two axes across a unit vector: Duff et al. 2017, "Building an Orthonormal Basis, Revisited". */
static void make_axes(const double n[3], double a[3], double b[3])
{
    double sign = n[2] < 0 ? -1 : 1, q = -1 / (sign + n[2]), r = n[0] * n[1] * q;
    a[0] = 1 + sign * n[0] * n[0] * q, a[1] = sign * r, a[2] = -sign * n[0];
    b[0] = r, b[1] = sign + n[1] * n[1] * q, b[2] = -n[1];
}

static const double even_share = 0.1, back_share = 0.25, glow_share = 0.25;
static const double glow_least = 1e-4; /* radians: no ray is drawn through the lamp itself */
static const double back_least = 1e-3; /* cosines behind reach from here to 1 */

static double density_without_glow(const al_gather_vertex *vertex, const double direction[3])
{
    if (vertex->in_air) return 1 / (4 * AL_PI);
    double cosine = dot(vertex->normal, direction), even = vertex->asks ? even_share : 0;
    double front = vertex->looks_back ? 1 - back_share : 1;
    if (cosine > 0) return front * ((1 - even) * cosine / AL_PI + even / (2 * AL_PI));
    return vertex->looks_back && cosine <= -back_least ? back_share / (2 * AL_PI * -cosine * -log(back_least))
                                                       : 0;
}

/* The glow of a lamp in fog goes like one over the ray's distance from it, so like 1/sin of the angle theta
 * to the lamp: theta is drawn evenly between glow_least and pi, per steradian 1/(2 pi (pi - glow_least) sin
 * theta). */
static double glow_density(const al_gather_vertex *vertex, const double direction[3])
{
    double cosine = dot(vertex->lamp, direction), square = 0;
    for (int k = 0; k < 3; k++) square += pow(direction[k] - cosine * vertex->lamp[k], 2);
    double sine = sqrt(square); /* exact near the lamp, where 1 - cosine^2 is not */
    if (cosine > 0 && sine < glow_least) return 0;
    return 1 / (2 * AL_PI * (AL_PI - glow_least) * fmax(sine, 1e-9));
}

double al_gather_density(const al_gather_vertex *vertex, const double direction[3])
{
    double density = density_without_glow(vertex, direction);
    if (!vertex->glows) return density;
    return (1 - glow_share) * density + glow_share * glow_density(vertex, direction);
}

/* The cosine to the normal: for all ways one number is enough, its range is dealt out and stretched. In
 * proportion to the cosine: cos^2 = 1 - u. In proportion to 1/cosine: cos = least^u. */
static double draw_cosine(const al_gather_vertex *vertex, double u)
{
    if (vertex->looks_back) {
        if (u < back_share) return -pow(back_least, u / back_share);
        u = (u - back_share) / (1 - back_share);
    }
    if (vertex->asks) {
        if (u < even_share) return u / even_share;
        u = (u - even_share) / (1 - even_share);
    }
    return sqrt(1 - u);
}

void al_gather_draw(const al_gather_vertex *vertex, const double u[2], double direction[3],
                    double *density_per_sr)
{
    double a[3] = {1, 0, 0}, b[3] = {0, 1, 0}, up[3] = {0, 0, 1};
    double along = vertex->glows ? (u[0] - glow_share) / (1 - glow_share) : u[0], cosine = 1 - 2 * along;
    const double *axis = along < 0 ? vertex->lamp : vertex->in_air ? NULL : vertex->normal;
    if (axis) {
        make_axes(axis, a, b);
        for (int k = 0; k < 3; k++) up[k] = axis[k];
        cosine = along < 0 ? cos(glow_least + (AL_PI - glow_least) * u[0] / glow_share)
                           : draw_cosine(vertex, along);
    }
    double sine = sqrt(fmax(0, 1 - cosine * cosine)), x = sine * cos(2 * AL_PI * u[1]),
           y = sine * sin(2 * AL_PI * u[1]);
    for (int k = 0; k < 3; k++) direction[k] = x * a[k] + y * b[k] + cosine * up[k];
    *density_per_sr = al_gather_density(vertex, direction);
}

al_gather_vertex al_gather_vertex_of(const al_surface_hit *hit)
{
    al_gather_vertex vertex = {.offset_m = hit->offset_m};
    for (int k = 0; k < 3; k++) {
        vertex.position[k] = hit->position[k];
        vertex.normal[k] = hit->front ? hit->normal[k] : -hit->normal[k];
    }
    return vertex;
}

void al_gather_find_glow(const al_gather *gather, al_gather_vertex *vertex)
{
    const al_scene *scene = gather->lights.scene;
    double brightest = 0;
    for (uint32_t i = 0; vertex->scatters && i < scene->light_count; i++) {
        const al_light *light = &scene->lights[i];
        double to[3], square = 0;
        if (light->type != AL_LIGHT_POINT) continue;
        for (int k = 0; k < 3; k++) {
            to[k] = light->vector[k] - vertex->position[k];
            square += to[k] * to[k];
        }
        double glow =
            ((double)light->intensity[0] + light->intensity[1] + light->intensity[2]) / sqrt(square);
        if (!(glow > brightest) || isinf(glow)) continue;
        brightest = glow;
        vertex->glows = true;
        for (int k = 0; k < 3; k++) vertex->lamp[k] = to[k] / sqrt(square);
    }
}

/* --- lights --- */

/* Transmittance and, where responses are asked, the mean of the fog along a ray. */
static bool pass_evenly(const al_gather *gather, al_gather_scratch *scratch, const al_ray *ray,
                        double length_m, bool asks, double transmittance[3], al_fog_mean *mean)
{
    if (!asks) {
        al_fog_transmittance(&gather->fog, ray, length_m, transmittance);
        return true;
    }
    return al_fog_mean_along(&gather->fog, ray, length_m, &scratch->fog, transmittance, mean);
}

bool al_gather_look(const al_gather *gather, al_gather_scratch *scratch, const al_gather_vertex *vertex,
                    al_light_kind kind, al_sequence *sequence, al_gather_straight *straight)
{
    al_light_sample *light = &straight->light;
    al_ray ray;
    if (!al_gather_light_sample(&gather->lights, kind, vertex->position,
                                vertex->in_air ? NULL : vertex->normal, sequence, light))
        return false;
    if (!(light->facing > 0) && !(vertex->asks)) return false;
    al_gather_origin(vertex, light->direction, ray.origin);
    if (!al_gather_light_is_seen(&gather->lights, ray.origin, light)) return false;
    for (int k = 0; k < 3; k++) ray.direction[k] = light->direction[k];
    if (!pass_evenly(gather, scratch, &ray, light->distance_m, vertex->asks, straight->transmittance,
                     &straight->fog))
        return false;
    double other = kind == AL_LIGHT_KIND_LAMP ? 0 : al_gather_density(vertex, light->direction);
    straight->share = kind == AL_LIGHT_KIND_LAMP ? 1 : 1 / (1 + other / light->density_per_sr);
    return true;
}

static void add_lights(const al_gather *gather, al_gather_scratch *scratch, const al_gather_vertex *vertex,
                       al_sequence *sequence, al_gather_layers irradiance)
{
    for (int kind = 0; kind < AL_LIGHT_KIND_COUNT; kind++) {
        al_gather_straight straight;
        double response[3] = {0};
        if (!al_gather_look(gather, scratch, vertex, (al_light_kind)kind, sequence, &straight)) continue;
        const al_light_sample *light = &straight.light;
        double cosine = dot(vertex->normal, light->direction);
        if (vertex->asks) {
            al_gather_source source = al_gather_source_of_light(&straight);
            al_gather_response(gather, &source, vertex->normal, response);
        }
        for (int c = 0; c < 3; c++) {
            double power = straight.share * light->power[c], arrives = power * light->facing * cosine;
            double attenuated = arrives * straight.transmittance[c];
            irradiance[AL_GATHER_SURFACE][c] += arrives;
            irradiance[AL_GATHER_ATTENUATED][c] += attenuated;
            irradiance[AL_GATHER_TOTAL][c] += attenuated + power * response[c];
        }
    }
}

/* --- paths --- */

/* Estimates the irradiance of a vertex by one path. `carried`: of irradiance. */
static bool estimate(const al_gather *gather, al_gather_scratch *scratch, const al_gather_vertex *vertex,
                     uint32_t bounces, const double carried[3], double importance, al_sequence *sequence,
                     al_gather_layers irradiance)
{
    double u[2], ahead[3], response[3] = {0}, scale;
    al_gather_way way;
    al_gather_source source;
    add_lights(gather, scratch, vertex, sequence, irradiance);
    al_sequence_pair(sequence, u);
    al_gather_draw(vertex, u, way.ray.direction, &way.density_per_sr);
    if (!(way.density_per_sr > 0)) return true;
    al_gather_origin(vertex, way.ray.direction, way.ray.origin);
    double cosine = dot(vertex->normal, way.ray.direction);
    if (cosine <= 0) return true;
    double arrives = cosine / way.density_per_sr;
    for (int c = 0; c < 3; c++) ahead[c] = arrives * carried[c];
    way.asks = vertex->asks;
    way.scatters = vertex->scatters;
    way.places = AL_GATHER_LATER_PLACES;
    way.surfaces = true;
    if (!al_gather_follow(gather, scratch, bounces, ahead, importance, sequence, &way)) return false;
    if (way.asks && al_gather_source_of_way(&way, &source, &scale)) {
        al_gather_response(gather, &source, vertex->normal, response);
        scale /= way.density_per_sr;
        for (int c = 0; c < 3; c++) response[c] *= scale * way.sent[AL_GATHER_TOTAL][c];
    }
    for (int c = 0; c < 3; c++) {
        double through = arrives * way.transmittance[c];
        double scattered = arrives * way.scattered[c] + response[c];
        irradiance[AL_GATHER_SURFACE][c] += arrives * way.sent[AL_GATHER_SURFACE][c];
        irradiance[AL_GATHER_ATTENUATED][c] += through * way.sent[AL_GATHER_ATTENUATED][c];
        irradiance[AL_GATHER_TOTAL][c] += through * way.sent[AL_GATHER_TOTAL][c] + scattered;
    }
    return true;
}

/* Emission of the far end, weighted against finding it as a light. */
static void add_emission(const al_gather *gather, al_gather_way *way)
{
    double other;
    if (way->met) {
        for (int c = 0; c < 3; c++) way->emitted[c] = way->hit.emission_w_m2_sr[c];
        if (!(way->emitted[0] + way->emitted[1] + way->emitted[2] > 0)) return;
        other = al_gather_emitter_density(&gather->lights, &way->ray, &way->hit);
    } else {
        other = al_gather_sky_density(&gather->lights, way->ray.direction, way->emitted);
    }
    for (int c = 0; c < 3; c++) {
        way->emitted[c] *= way->density_per_sr / (way->density_per_sr + other);
        for (int layer = 0; layer < AL_GATHER_LAYER_COUNT; layer++) way->sent[layer][c] += way->emitted[c];
    }
}

/* Scattered light that falls on the far end and is reflected, as the fog points know it: not what differs
 * from place to place within a cell, so that a way must be longer than one. */
static bool add_known_reflection(const al_gather *gather, const al_gather_scratch *scratch,
                                 al_gather_way *way)
{
    double irradiance[3];
    if (gather->options.walls == AL_WALLS_TRACED || scratch->record) return false;
    if (way->hit.distance_m < al_fog_points_cell_m(gather->points)) return false;
    al_gather_vertex vertex = al_gather_vertex_of(&way->hit);
    if (!al_fog_points_irradiance(gather->points, vertex.position, vertex.normal, irradiance)) return false;
    for (int c = 0; c < 3; c++) way->sent[AL_GATHER_TOTAL][c] += way->hit.albedo[c] / AL_PI * irradiance[c];
    return true;
}

/* What the far end reflects; `scatters`: fog's light too. `carried` is of the radiance it sends. */
static bool add_reflection(const al_gather *gather, al_gather_scratch *scratch, uint32_t bounces,
                           const double carried[3], double importance, bool scatters, al_sequence *sequence,
                           al_gather_way *way)
{
    const al_surface_hit *hit = &way->hit;
    al_gather_vertex vertex = al_gather_vertex_of(hit);
    al_gather_layers irradiance = {{0}};
    double survival = 1, u[2], reflected[3], ahead[3];
    importance *= fmax(fmax(hit->albedo[0], hit->albedo[1]), hit->albedo[2]);
    if (!(importance > 0)) return true;
    if (importance < roulette_importance) {
        survival = importance / roulette_importance;
        al_sequence_pair(sequence, u);
        if (u[0] >= survival) return true;
    }
    for (int k = 0; k < 3; k++) {
        reflected[k] = hit->albedo[k] / (AL_PI * survival);
        ahead[k] = carried[k] * reflected[k];
    }
    vertex.asks = way->asks;
    vertex.scatters = scatters;
    al_gather_find_glow(gather, &vertex);
    if (!estimate(gather, scratch, &vertex, bounces - 1, ahead, importance / survival, sequence, irradiance))
        return false;
    for (int layer = 0; layer < AL_GATHER_LAYER_COUNT; layer++)
        for (int c = 0; c < 3; c++) way->sent[layer][c] += reflected[c] * irradiance[layer][c];
    return true;
}

/* Transmittance of the way, and light that fog scatters into it, by fog points. */
static bool pass_points(const al_gather *gather, al_gather_scratch *scratch, const double carried[3],
                        al_sequence *sequence, al_gather_way *way)
{
    double length_m = way->met ? way->hit.distance_m : INFINITY;
    if (!al_fog_along(&gather->fog, &way->ray, length_m, &scratch->fog)) return false;
    al_fog_transmit(&gather->fog, scratch->fog.depth, way->transmittance);
    return al_gather_scatter(gather, scratch, carried, sequence, way);
}

bool al_gather_is_dark(const al_gather_way *way)
{
    const double *sent = way->sent[AL_GATHER_TOTAL];
    return !(sent[0] + sent[1] + sent[2] > 0);
}

/* Without fog points what the fog does is asked last: half of the ways bring nothing, as they end in the
 * dark. */
bool al_gather_follow(const al_gather *gather, al_gather_scratch *scratch, uint32_t bounces,
                      const double carried[3], double importance, al_sequence *sequence, al_gather_way *way)
{
    double ahead[3];
    for (int c = 0; c < 3; c++) {
        way->transmittance[c] = 1;
        way->scattered[c] = way->emitted[c] = 0;
        for (int layer = 0; layer < AL_GATHER_LAYER_COUNT; layer++) way->sent[layer][c] = 0;
    }
    way->met = al_ray_scene_hit(gather->rays, &way->ray, INFINITY, &way->hit);
    if (way->scatters && !pass_points(gather, scratch, carried, sequence, way)) return false;
    add_emission(gather, way);
    for (int c = 0; c < 3; c++) ahead[c] = carried[c] * way->transmittance[c];
    if (way->met && bounces) {
        bool scatters = way->scatters && !add_known_reflection(gather, scratch, way);
        if ((scatters || way->surfaces) &&
            !add_reflection(gather, scratch, bounces, ahead, importance, scatters, sequence, way))
            return false;
    }
    if (way->scatters || al_gather_is_dark(way)) return true;
    return pass_evenly(gather, scratch, &way->ray, way->met ? way->hit.distance_m : INFINITY, way->asks,
                       way->transmittance, &way->fog);
}
