/* For each stretch of a path the published method adds what an endless medium would scatter from the emitter
 * at its far end (Dubouchet et al. 2019): a lamp, or a piece of surface that sends radiance Lo. A direction
 * drawn with density p per steradian stands for the piece dA = d^2 / cos_y / p, an area emitter of intensity
 * Lo dA along its normal. So the irradiance of x gets
 *
 *   Lo / p (T cos_x + d^2 / cos_y R(d, cos_y)),
 *
 * R the table's irradiance. R does not vanish with cos_x: a tenth of the directions is drawn evenly over the
 * hemisphere (al_gather_draw), else R cos_x^-1 would make noise without bound. Light reaches the table's
 * emitters along a sight line only: what x does not see does not count.
 *
 * A stretch takes the mean coefficients along it. The sky and directional lights enter where the ray leaves
 * the fog.
 *
 * An endless medium lets light through walls both ways, so that it is counted more than once: in a closed
 * room without absorption T + R grows with density as long as events are added, and surfaces that reflect
 * well enough multiply light from stretch to stretch. How much is measured by random walks: the mean product
 * over steps 4 to 8 of albedo (T cos_x + d^2 / cos_y R) / (pi p). */
#include "gather_response.h"

#include <math.h>

#include "airlight/formulas.h"
#include "airlight/sh.h"
#include "gather_kernel.h"

enum { WALKS = 4096, WALK_FIRST = 4, WALK_LAST = 8 };

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* --- media --- */

static double albedo_of(const al_fog_medium *medium, int c)
{
    return medium->sigma_t_per_m[c] > 0 ? medium->sigma_s_per_m[c] / medium->sigma_t_per_m[c] : 0;
}

/* Whether all media have the same g and albedo, so that one collapsed table a channel serves. */
static bool is_alike(const al_fog_media *fog)
{
    for (uint32_t i = 1; i < fog->count; i++)
        for (int c = 0; c < 3; c++)
            if (fog->media[i].g != fog->media[0].g ||
                albedo_of(&fog->media[i], c) != albedo_of(&fog->media[0], c))
                return false;
    return true;
}

al_status al_gather_responses_create(al_gather *gather, al_error *error)
{
    if (!is_alike(&gather->fog)) return AL_OK;
    for (int c = 0; c < 3; c++) {
        double albedo = albedo_of(&gather->fog.media[0], c), g = gather->fog.media[0].g;
        for (int other = 0; other < c && !gather->kernels[c]; other++)
            if (albedo_of(&gather->fog.media[0], other) == albedo)
                gather->kernels[c] = gather->kernels[other];
        if (!gather->kernels[c]) gather->kernels[c] = al_gather_kernel_create(gather->tables, albedo, g);
        if (!gather->kernels[c]) return al_fail(error, AL_IO, "out of memory for the fog's responses");
    }
    return AL_OK;
}

void al_gather_responses_free(al_gather *gather)
{
    for (int c = 0; c < 3; c++) {
        bool shared = false;
        for (int other = 0; other < c; other++)
            shared = shared || gather->kernels[other] == gather->kernels[c];
        if (!shared) al_gather_kernel_free(gather->kernels[c]);
    }
}

/* --- sources --- */

al_gather_source al_gather_source_of_light(const al_gather_straight *straight)
{
    const al_light_sample *light = &straight->light;
    al_gather_source source = {.emitter = AL_IMPULSE_POINT,
                               .direction = light->direction,
                               .cos_normal = light->cos_normal,
                               .fog = &straight->fog,
                               .transmittance = straight->transmittance};
    if (isinf(light->distance_m)) source.emitter = AL_IMPULSE_DIRECTIONAL;
    if (light->kind != AL_LIGHT_KIND_EMITTER) return source;
    bool back = light->double_sided && dot(light->normal, light->direction) > 0;
    source.emitter = AL_IMPULSE_AREA;
    for (int k = 0; k < 3; k++) source.normal[k] = back ? -light->normal[k] : light->normal[k];
    return source;
}

/* A back side of something solid counts as met at distance 0: a piece of no area. */
bool al_gather_source_of_way(const al_gather_way *way, al_gather_source *source, double *scale)
{
    const al_surface_hit *hit = &way->hit;
    *scale = 1;
    if (al_gather_is_dark(way)) return false;
    *source = (al_gather_source){.emitter = way->met ? AL_IMPULSE_AREA : AL_IMPULSE_DIRECTIONAL,
                                 .direction = way->ray.direction,
                                 .cos_normal = 1,
                                 .fog = &way->fog,
                                 .transmittance = way->transmittance};
    if (!way->met) return true;
    for (int k = 0; k < 3; k++) source->normal[k] = hit->front ? hit->normal[k] : -hit->normal[k];
    source->cos_normal = -dot(source->normal, way->ray.direction);
    *scale = hit->distance_m * hit->distance_m / source->cos_normal;
    return source->cos_normal > 0 && isfinite(*scale) && (hit->front || hit->material->double_sided);
}

/* The frame of a response: z towards the emitter, x towards the side of its normal. */
static void frame_of(const al_gather_source *source, double x[3], double z[3])
{
    double along = dot(source->normal, source->direction), square = 0;
    for (int k = 0; k < 3; k++) {
        z[k] = source->direction[k];
        x[k] = source->normal[k] - along * z[k];
        square += x[k] * x[k];
    }
    if (square < 1e-12) { /* any axis across will do */
        double helper[3] = {fabs(z[0]) < 0.6, fabs(z[0]) >= 0.6, 0};
        along = dot(helper, z);
        square = 0;
        for (int k = 0; k < 3; k++) {
            x[k] = helper[k] - along * z[k];
            square += x[k] * x[k];
        }
    }
    for (int k = 0; k < 3; k++) x[k] /= sqrt(square);
}

/* --- responses --- */

static bool scatters(const al_gather_source *source, int c)
{
    return source->fog->sigma_s_per_m[c] > 0 && source->fog->length_m > 0 && isfinite(source->fog->length_m);
}

static void ask(const al_gather *gather, const al_gather_source *source, int c, al_impulse_answer *answer)
{
    al_impulse_query query = {.emitter = source->emitter,
                              .first_event = 1,
                              .last_event = al_impulse_tables_info(gather->tables)->event_count,
                              .distance_m = source->fog->length_m,
                              .cos_normal = source->cos_normal,
                              .sigma_s_per_m = source->fog->sigma_s_per_m[c],
                              .sigma_a_per_m =
                                  fmax(0, source->fog->sigma_t_per_m[c] - source->fog->sigma_s_per_m[c]),
                              .g = source->fog->g};
    al_impulse_response(gather->tables, &query, answer);
}

/* Whether the channel answers as the one before. */
static bool is_same(const al_gather *gather, const al_gather_source *source, int c)
{
    return c > 0 && gather->kernels[c] == gather->kernels[c - 1] &&
           source->fog->sigma_s_per_m[c] == source->fog->sigma_s_per_m[c - 1] &&
           source->fog->sigma_t_per_m[c] == source->fog->sigma_t_per_m[c - 1];
}

static double ask_kernel(const al_gather_kernel *kernel, const al_gather_source *source, int c,
                         double normal_z, double normal_across)
{
    double sigma_t = source->fog->sigma_t_per_m[c];
    al_gather_kernel_query query = {.emitter = source->emitter,
                                    .depth = sigma_t * source->fog->length_m,
                                    .transmittance = source->transmittance[c],
                                    .cos_normal = source->cos_normal,
                                    .normal_z = normal_z,
                                    .normal_across = normal_across};
    double irradiance = al_gather_kernel_irradiance(kernel, &query);
    return source->emitter == AL_IMPULSE_DIRECTIONAL ? irradiance : sigma_t * sigma_t * irradiance;
}

static double ask_tables(const al_gather *gather, const al_gather_source *source, int c, double normal_z,
                         double normal_across)
{
    double sine = sqrt(fmax(0, 1 - source->cos_normal * source->cos_normal));
    al_impulse_answer answer;
    ask(gather, source, c, &answer);
    return al_impulse_irradiance(&answer, normal_z, sine > 0 ? normal_across / sine : 0);
}

void al_gather_response(const al_gather *gather, const al_gather_source *source, const double normal[3],
                        double irradiance[3])
{
    double z = dot(normal, source->direction), across = 0;
    if (source->emitter == AL_IMPULSE_AREA) across = dot(normal, source->normal) + source->cos_normal * z;
    for (int c = 0; c < 3; c++) {
        irradiance[c] = 0;
        if (is_same(gather, source, c))
            irradiance[c] = irradiance[c - 1];
        else if (scatters(source, c) && gather->kernels[c])
            irradiance[c] = ask_kernel(gather->kernels[c], source, c, z, across);
        else if (scatters(source, c))
            irradiance[c] = ask_tables(gather, source, c, z, across);
        if (!(irradiance[c] > 0)) irradiance[c] = 0; /* a few bands may swing below 0 */
    }
}

void al_gather_response_sh(const al_gather *gather, const al_gather_source *source, const double power[3],
                           uint32_t order, double sh[3][AL_GATHER_SH_COUNT])
{
    double x[3], z[3], y[3];
    float rotation[9], local[AL_SH_MAX_COUNT], world[AL_SH_MAX_COUNT];
    frame_of(source, x, z);
    y[0] = z[1] * x[2] - z[2] * x[1], y[1] = z[2] * x[0] - z[0] * x[2], y[2] = z[0] * x[1] - z[1] * x[0];
    for (int k = 0; k < 3; k++) {
        rotation[3 * k] = (float)x[k];
        rotation[3 * k + 1] = (float)y[k];
        rotation[3 * k + 2] = (float)z[k];
    }
    for (int c = 0; c < 3; c++) {
        al_impulse_answer answer;
        if (!scatters(source, c)) continue;
        if (!is_same(gather, source, c)) {
            ask(gather, source, c, &answer);
            for (uint32_t l = 0; l < order; l++)
                for (uint32_t k = 0; k < 2 * l + 1; k++) {
                    uint32_t m = k - l; /* of k = l + m, m from 0 */
                    bool used = k >= l && m < answer.m_count && l < answer.band_count;
                    local[l * l + k] = used ? (float)answer.sh[m][l] : 0;
                }
            al_sh_rotate((int)order, rotation, local, world);
        }
        for (uint32_t k = 0; k < order * order; k++) sh[c][k] += power[c] * world[k];
    }
}

/* --- growth --- */

/* One step of a walk: multiplies `carried`. False where it ends. */
static bool step(const al_gather *gather, al_gather_scratch *scratch, al_gather_vertex *vertex,
                 al_sequence *sequence, double carried[3], bool *failed)
{
    double u[2], response[3] = {0}, scale;
    al_gather_way way = {.sent[AL_GATHER_TOTAL] = {1, 1, 1}};
    al_gather_source source;
    al_sequence_pair(sequence, u);
    al_gather_draw(vertex, u, way.ray.direction, &way.density_per_sr);
    al_gather_origin(vertex, way.ray.direction, way.ray.origin);
    way.met = al_ray_scene_hit(gather->rays, &way.ray, INFINITY, &way.hit);
    if (!way.met) return false;
    *failed = !al_fog_mean_along(&gather->fog, &way.ray, way.hit.distance_m, &scratch->fog, way.transmittance,
                                 &way.fog);
    if (*failed) return false;
    double cosine = vertex->in_air ? 0.25 : dot(vertex->normal, way.ray.direction);
    if (!vertex->in_air && al_gather_source_of_way(&way, &source, &scale)) {
        al_gather_response(gather, &source, vertex->normal, response);
        for (int c = 0; c < 3; c++) response[c] *= scale;
    }
    for (int c = 0; c < 3; c++) {
        double arrives = cosine * way.transmittance[c] + response[c];
        carried[c] *= way.hit.albedo[c] * arrives / (AL_PI * way.density_per_sr);
    }
    *vertex = al_gather_vertex_of(&way.hit);
    vertex->asks = true;
    return true;
}

bool al_gather_gain(const al_gather *gather, al_gather_scratch *scratch, double *gain)
{
    double low[3], high[3], first[3] = {0}, last[3] = {0};
    bool failed = false;
    *gain = 0;
    al_ray_scene_bounds(gather->rays, low, high);
    for (uint32_t i = 0; i < WALKS; i++) {
        al_sequence sequence = {.index = i, .seed = al_mix_bits(gather->options.seed + 0x77616c6bu)};
        al_gather_vertex vertex = {.in_air = true};
        double carried[3] = {1, 1, 1}, u[4];
        al_sequence_pair(&sequence, u);
        al_sequence_pair(&sequence, u + 2);
        for (int k = 0; k < 3; k++) vertex.position[k] = low[k] + u[k] * (high[k] - low[k]);
        for (int n = 0; n <= WALK_LAST && step(gather, scratch, &vertex, &sequence, carried, &failed); n++)
            for (int c = 0; c < 3; c++) {
                if (n == WALK_FIRST) first[c] += carried[c];
                if (n == WALK_LAST) last[c] += carried[c];
            }
        if (failed) return false;
    }
    for (int c = 0; c < 3; c++)
        if (first[c] > 0) *gain = fmax(*gain, pow(last[c] / first[c], 1.0 / (WALK_LAST - WALK_FIRST)));
    return true;
}
