/* All light: off surfaces and out of media, any number of times, by tracing paths back from the receiver.
 *
 * A path starts at the eye, on a receiving surface or at a probe, and goes from vertex to vertex, which are
 * reflections off surfaces or scattering events in media (media.c says where). Surfaces are what their
 * triangles are: Lambert on both sides, with geometric normals, albedo the base colour times 1 - metallic;
 * mirrored light is left out, so metals are dark. Emitters shine from their fronts unless double-sided.
 * Boundaries of translucent objects are index-matched: light passes them straight on. Where a path meets
 * nothing, it sees the environment.
 *
 * At every vertex each kind of light is asked at one point of it (next-event estimation): a point light and a
 * directional light drawn evenly, a point of an emitter drawn by power, a direction of the environment.
 * Emitters and the environment are also met by the path itself; the two ways share by the balance heuristic
 * (Veach and Guibas 1995), in which the probability of getting there through the media is common to both.
 *
 * Lights in media: what a point of a light sends into a stretch of ray to be scattered there grows like one
 * over its distance from the ray, so each stretch also draws a scattering point by equal angles seen from a
 * point light, and one seen from a point of an emitter (Kulla and Fajardo 2012). These share with the
 * scattering events of the path. With k = (density of the angles) / (density of the events along the ray), a
 * the probability of drawing the light per steradian and p the phase function, the three ways to the light
 * weigh by angles: a k / (a (1 + k) + p),   by asking: a / (a (1 + k) + p),   by meeting it: p / (a (1 + k) +
 * p). The density of the events is a guess where media are not constant: weights that sum to one for every
 * path leave no bias, whatever they are.
 *
 * Russian roulette, with the throughput's largest channel as the chance to live, ends paths; at least one in
 * a hundred dies at every vertex, so that even a path in endless fog that absorbs nothing ends. */
#include <math.h>
#include <stdlib.h>

#include "airlight/formulas.h"
#include "directions.h"
#include "emitters.h"
#include "environment_sampler.h"
#include "media.h"
#include "mode.h"

typedef struct volume_path {
    al_mode_options options;
    al_ray_scene *scene;
    al_emitters *emitters;
    al_environment_sampler environment;
    al_media media;
    const al_light **lamps, **suns; /* the point lights; the directional ones */
    uint32_t lamp_count, sun_count;
} volume_path;

typedef struct scratch {
    al_media_line path, light;
} scratch;

/* What one call draws from: stratified numbers first, then an endless stream. */
enum { SEED, ACROSS, ROUND, EMITTER, DIMENSIONS = EMITTER + 3 };

static void close_state(void *user)
{
    volume_path *state = user;
    if (!state) return;
    al_emitters_free(state->emitters);
    al_ray_scene_free(state->scene);
    al_environment_sampler_free(&state->environment);
    al_media_free(&state->media);
    free(state->lamps);
    free(state->suns);
    free(state);
}

static bool sort_lights(const al_scene *scene, volume_path *state)
{
    state->lamps = malloc(sizeof *state->lamps * (scene->light_count + (size_t)1));
    state->suns = malloc(sizeof *state->suns * (scene->light_count + (size_t)1));
    if (!state->lamps || !state->suns) return false;
    for (uint32_t i = 0; i < scene->light_count; i++) {
        const al_light *light = &scene->lights[i];
        if (light->type == AL_LIGHT_POINT)
            state->lamps[state->lamp_count++] = light;
        else
            state->suns[state->sun_count++] = light;
    }
    return true;
}

static al_status open_state(const al_import *import, const al_mode_options *options, void **out,
                            al_error *error)
{
    *out = NULL;
    volume_path *state = calloc(1, sizeof *state);
    if (!state || !sort_lights(&import->scene, state)) {
        close_state(state);
        return al_fail(error, AL_IO, "out of memory for %u lights", import->scene.light_count);
    }
    state->options = *options;
    al_status status = al_environment_sampler_create(&import->scene.environment, &state->environment, error);
    if (!status) status = al_media_create(import, &state->media, error);
    if (!status) status = al_ray_scene_create(import, AL_RAY_SCENE_ALL, &state->scene, error);
    if (!status) status = al_emitters_create(import, state->scene, &state->emitters, error);
    if (status)
        close_state(state);
    else
        *out = state;
    return status;
}

static uint32_t dimensions(const void *user)
{
    (void)user;
    return DIMENSIONS;
}

static void *scratch_new(void)
{
    return calloc(1, sizeof(scratch));
}

static void scratch_free(void *user)
{
    scratch *s = user;
    if (!s) return;
    al_media_line_free(&s->path);
    al_media_line_free(&s->light);
    free(s);
}

static double largest(const double v[3])
{
    return fmax(fmax(v[0], v[1]), v[2]);
}

/* --- vertices: what leaves along -way is scale times the mean of what arrives, weighted by the lobe --- */

typedef enum lobe { LOBE_COSINE, LOBE_PHASE, LOBE_SPHERE } lobe;

/* Where media may be along a ray: nowhere unless begin_m < end_m. */
typedef struct stretch {
    al_ray ray;
    double begin_m, end_m;
} stretch;

/* A scattering event of a path, to weigh it against equal angles. */
typedef struct event {
    stretch along;
    double at_m, density; /* 0: no event */
} event;

typedef struct vertex {
    lobe lobe;
    double position[3]; /* off the surface: rays begin and end there */
    double axis[3];     /* cosine: the normal towards the path; phase: the path's direction */
    double g;
    double scale[3]; /* of what arrives: albedo; for receivers the measure of their sphere */
    event event;
} vertex;

/* The lobe's value and probability in a direction, per steradian: its integral is 1. */
static double lobe_density(const vertex *v, const double towards[3])
{
    switch (v->lobe) {
    case LOBE_COSINE:
        return fmax(0, al_dot(v->axis, towards)) / AL_PI;
    case LOBE_PHASE:
        return al_phase(v->g, al_dot(v->axis, towards));
    case LOBE_SPHERE:
        break;
    }
    return 1 / (4 * AL_PI);
}

static void draw_direction(const vertex *v, double u0, double u1, double direction[3])
{
    double phi = 2 * AL_PI * u1;
    switch (v->lobe) {
    case LOBE_COSINE:
        al_direction_about(v->axis, sqrt(1 - u0), phi, direction);
        break;
    case LOBE_PHASE:
        al_direction_about(v->axis, al_phase_cosine(v->g, u0), phi, direction);
        break;
    case LOBE_SPHERE:
        al_direction_about((double[]){0, 0, 1}, 2 * u0 - 1, phi, direction);
        break;
    }
}

static al_ray leave(const vertex *v, const double direction[3])
{
    al_ray ray;
    for (int k = 0; k < 3; k++) {
        ray.origin[k] = v->position[k];
        ray.direction[k] = direction[k];
    }
    return ray;
}

static vertex surface_vertex(const al_surface_hit *hit)
{
    double side = hit->front ? 1 : -1;
    vertex v = {.lobe = LOBE_COSINE};
    for (int k = 0; k < 3; k++) {
        v.axis[k] = side * hit->normal[k];
        v.position[k] = hit->position[k] + hit->offset_m * v.axis[k];
        v.scale[k] = hit->albedo[k];
    }
    return v;
}

static vertex scatter_vertex(const al_media_line *line, const stretch *along, const al_flight *flight)
{
    double at_m = flight->distance_m;
    vertex v = {.lobe = LOBE_PHASE,
                .scale = {1, 1, 1},
                .g = al_media_asymmetry(line->media, flight->medium),
                .event = {*along, at_m, al_media_flight_density(line, at_m)}};
    for (int k = 0; k < 3; k++) {
        v.position[k] = along->ray.origin[k] + at_m * along->ray.direction[k];
        v.axis[k] = along->ray.direction[k];
    }
    return v;
}

/* --- equal angles --- */

static bool aim(const stretch *along, const double light[3], al_angles *out)
{
    return al_angles_aim(&along->ray, along->begin_m, along->end_m, light, out);
}

/* Keeps products with 0 from being NaN. */
static const double ratio_limit = 1e30;

/* k of the comment on top, for light from a point that is scattered at the event. */
static double angle_ratio(const event *at, const double light[3])
{
    al_angles a;
    if (!(at->density > 0) || !aim(&at->along, light, &a)) return 0;
    return fmin(al_angles_density(&a, at->at_m) / at->density, ratio_limit);
}

/* --- lights --- */

typedef struct arrival { /* light that comes to a vertex from one direction */
    double towards[3], end_m;
    double power[3];  /* irradiance facing it, or radiance over its probability per steradian */
    double density;   /* that probability; 0: the path itself cannot meet this light */
    double source[3]; /* the light's point, where it has one */
    bool has_source;
} arrival;

/* Irradiance of a point light facing it; false on the light itself. */
static bool ask_lamp(const al_light *lamp, const double position[3], arrival *a)
{
    double square = 0;
    *a = (arrival){.has_source = true};
    for (int k = 0; k < 3; k++) {
        a->source[k] = lamp->vector[k];
        a->towards[k] = a->source[k] - position[k];
        square += a->towards[k] * a->towards[k];
    }
    if (!(square > 0)) return false;
    a->end_m = sqrt(square);
    for (int k = 0; k < 3; k++) {
        a->towards[k] /= a->end_m;
        a->power[k] = lamp->intensity[k] / square;
    }
    return true;
}

static const al_light *pick(const al_light *const *lights, uint32_t count, al_random *random)
{
    if (count < 2) return count ? lights[0] : NULL;
    return lights[(uint32_t)(al_random_real(random) * count)];
}

static bool draw_lamp(const volume_path *state, const double position[3], al_random *random, arrival *a)
{
    const al_light *lamp = pick(state->lamps, state->lamp_count, random);
    if (!lamp || !ask_lamp(lamp, position, a)) return false;
    for (int c = 0; c < 3; c++) a->power[c] *= state->lamp_count;
    return true;
}

static bool draw_sun(const volume_path *state, al_random *random, arrival *a)
{
    const al_light *sun = pick(state->suns, state->sun_count, random);
    if (!sun) return false;
    double length = hypot(hypot(sun->vector[0], sun->vector[1]), sun->vector[2]);
    *a = (arrival){.end_m = INFINITY};
    for (int k = 0; k < 3; k++) {
        a->towards[k] = -sun->vector[k] / length;
        a->power[k] = sun->intensity[k] * (double)state->sun_count;
    }
    return true;
}

/* What a point of an emitter, drawn with per_m2, sends to a position. Per area to per steradian: distance
 * squared over the cosine at the emitter. */
static bool ask_emitter(const al_surface_hit *point, double per_m2, const double position[3], arrival *a)
{
    double back[3], square = 0;
    *a = (arrival){.has_source = true};
    for (int k = 0; k < 3; k++) back[k] = position[k] - point->position[k];
    al_surface_offset(point, back, a->source);
    for (int k = 0; k < 3; k++) {
        a->towards[k] = a->source[k] - position[k];
        square += a->towards[k] * a->towards[k];
    }
    if (!(square > 0)) return false;
    a->end_m = sqrt(square);
    for (int k = 0; k < 3; k++) a->towards[k] /= a->end_m;
    double cosine = -al_dot(point->normal, a->towards);
    if (point->material->double_sided) cosine = fabs(cosine);
    if (!(cosine > 0)) return false;
    a->density = per_m2 * square / cosine;
    if (!isfinite(a->density)) return false;
    for (int c = 0; c < 3; c++) a->power[c] = point->emission_w_m2_sr[c] / a->density;
    return true;
}

static bool draw_emitter(const volume_path *state, const double position[3], const double u[3], arrival *a)
{
    al_surface_hit point;
    if (!al_emitters_count(state->emitters)) return false;
    double per_m2 = al_emitters_sample(state->emitters, u, &point);
    return ask_emitter(&point, per_m2, position, a);
}

static bool draw_sky(const volume_path *state, al_random *random, arrival *a)
{
    if (!state->environment.map) return false;
    double u[2] = {al_random_real(random), al_random_real(random)}, radiance[3];
    *a = (arrival){0};
    al_environment_sample(&state->environment, u, a->towards);
    a->density = al_environment_density(&state->environment, a->towards, radiance);
    a->end_m = INFINITY;
    for (int c = 0; c < 3; c++) a->power[c] = a->density > 0 ? radiance[c] / a->density : 0;
    return a->density > 0;
}

/* Lets `a->power` pass from the light to the ray's origin: 0 behind surfaces. */
static bool pass(const volume_path *state, scratch *s, const al_ray *ray, al_random *random, arrival *a)
{
    /* A lamp on a surface is in front of it. */
    if (al_ray_scene_is_blocked(state->scene, ray, a->end_m - al_ray_scene_offset_m(state->scene))) {
        for (int c = 0; c < 3; c++) a->power[c] = 0;
        return true;
    }
    if (!al_media_line_fill(&state->media, state->scene, ray, a->end_m, &s->light)) return false;
    al_media_attenuate(&s->light, a->end_m, random, a->power);
    return true;
}

enum { ARRIVALS = 4 };

/* Asks the lights from a vertex: `arrivals` become what they add to what leaves it. `u` draws the emitter. */
static bool ask_lights(const volume_path *state, scratch *s, const vertex *v, const double u[3],
                       al_random *random, arrival arrivals[ARRIVALS], int *count)
{
    int found = *count = 0;
    found += draw_lamp(state, v->position, random, &arrivals[found]);
    found += draw_sun(state, random, &arrivals[found]);
    found += draw_emitter(state, v->position, u, &arrivals[found]);
    found += draw_sky(state, random, &arrivals[found]);
    for (int i = 0; i < found; i++) {
        arrival a = arrivals[i];
        double value = lobe_density(v, a.towards), k = a.has_source ? angle_ratio(&v->event, a.source) : 0;
        double share = a.density > 0 ? a.density / (a.density * (1 + k) + value) : 1 / (1 + k);
        for (int c = 0; c < 3; c++) a.power[c] *= value * share * v->scale[c];
        if (!(largest(a.power) > 0)) continue;
        al_ray ray = leave(v, a.towards);
        if (!pass(state, s, &ray, random, &a)) return false;
        arrivals[(*count)++] = a;
    }
    return true;
}

/* --- lights along a stretch of ray --- */

static stretch stretch_of(const al_media_line *line)
{
    stretch along = {.ray = *line->ray, .begin_m = INFINITY};
    for (uint32_t i = 0; i < line->part_count; i++) {
        along.begin_m = fmin(along.begin_m, line->parts[i].begin_m);
        along.end_m = fmax(along.end_m, line->parts[i].end_m);
    }
    return along;
}

/* A point of the stretch by equal angles from `light`: its distance, and the density it was drawn with, 0 for
 * none. */
static double draw_angle(const stretch *along, const double light[3], al_random *random, double *at_m,
                         double position[3])
{
    al_angles a;
    if (!aim(along, light, &a)) return 0;
    *at_m = al_angles_draw(&a, al_random_real(random));
    if (!(*at_m >= along->begin_m && *at_m <= along->end_m) || !isfinite(*at_m)) return 0;
    for (int k = 0; k < 3; k++) position[k] = along->ray.origin[k] + *at_m * along->ray.direction[k];
    return al_angles_density(&a, *at_m);
}

/* Adds what `from` sends to a point of the path's line, drawn with `density`, to be scattered there. */
static bool add_scattered(const volume_path *state, scratch *s, double at_m, double density, arrival *from,
                          const double position[3], const double throughput[3], al_random *random,
                          double out[3])
{
    double cosine = al_dot(from->towards, s->path.ray->direction), sum[3] = {0}, sigma_s[3], g;
    double events = al_media_flight_density(&s->path, at_m), k = fmin(density / events, ratio_limit);
    if (!(events > 0)) return true;
    for (uint32_t i = 0; i < s->path.part_count; i++) {
        if (!al_media_part_scatters(&s->path, i, at_m, sigma_s, &g)) continue;
        double phase = al_phase(g, cosine), met = from->density > 0 ? phase / from->density : 0;
        for (int c = 0; c < 3; c++) sum[c] += sigma_s[c] * phase * k / (1 + k + met);
    }
    al_ray ray;
    for (int c = 0; c < 3; c++) {
        ray.origin[c] = position[c];
        ray.direction[c] = from->towards[c];
        from->power[c] *= throughput[c] * sum[c] / density;
    }
    if (!(largest(from->power) > 0)) return true;
    if (!pass(state, s, &ray, random, from)) return false;
    al_media_attenuate(&s->path, at_m, random, from->power);
    for (int c = 0; c < 3; c++) out[c] += from->power[c];
    return true;
}

/* A lamp and a point of an emitter, each seen by equal angles. */
static bool add_angles(const volume_path *state, scratch *s, const stretch *along, const double throughput[3],
                       al_random *random, double out[3])
{
    double at_m, density, position[3];
    arrival from;
    const al_light *lamp = pick(state->lamps, state->lamp_count, random);
    if (lamp) {
        double place[3] = {lamp->vector[0], lamp->vector[1], lamp->vector[2]};
        density = draw_angle(along, place, random, &at_m, position);
        if (density > 0 && ask_lamp(lamp, position, &from)) {
            for (int c = 0; c < 3; c++) from.power[c] *= state->lamp_count;
            if (!add_scattered(state, s, at_m, density, &from, position, throughput, random, out))
                return false;
        }
    }
    if (!al_emitters_count(state->emitters)) return true;
    al_surface_hit point;
    double u[3] = {al_random_real(random), al_random_real(random), al_random_real(random)};
    double per_m2 = al_emitters_sample(state->emitters, u, &point);
    density = draw_angle(along, point.position, random, &at_m, position);
    if (!(density > 0) || !ask_emitter(&point, per_m2, position, &from)) return true;
    return add_scattered(state, s, at_m, density, &from, position, throughput, random, out);
}

/* --- paths --- */

/* Radiance that arrives along a ray whose direction was drawn with `density` per steradian; 0: it was given,
 * and no vertex before it asked the lights. */
typedef struct walk {
    al_ray ray;
    double density;
    double throughput[3];
    event event; /* where it was drawn, if in a medium */
    uint32_t events, bounces;
} walk;

static bool counts(const volume_path *state, uint32_t events)
{
    return events >= state->options.min_events && events <= state->options.max_events;
}

/* Light that the path itself meets: its share beside asking for it. */
static void add_met(const walk *w, const double radiance[3], double asked, double out[3])
{
    double share = w->density > 0 ? w->density / (w->density + asked) : 1;
    for (int c = 0; c < 3; c++) out[c] += w->throughput[c] * radiance[c] * share;
}

static void add_emission(const volume_path *state, const walk *w, const al_surface_hit *hit, double out[3])
{
    if (!(largest(hit->emission_w_m2_sr) > 0)) return;
    double cosine = fabs(al_dot(hit->normal, w->ray.direction));
    double asked = al_emitters_density(state->emitters, hit->material) * hit->distance_m * hit->distance_m *
                   (1 + angle_ratio(&w->event, hit->position));
    add_met(w, hit->emission_w_m2_sr, cosine > 0 ? asked / cosine : INFINITY, out);
}

static void add_sky(const volume_path *state, const walk *w, double out[3])
{
    if (!state->environment.map) return;
    double radiance[3], asked = al_environment_density(&state->environment, w->ray.direction, radiance);
    add_met(w, radiance, asked, out);
}

/* Goes along the ray to the next vertex, collecting light; *goes_on is false where the path ends. */
static bool walk_on(const volume_path *state, scratch *s, walk *w, al_random *random, vertex *v,
                    bool *goes_on, double out[3])
{
    al_surface_hit hit;
    bool met = al_ray_scene_hit(state->scene, &w->ray, INFINITY, &hit);
    double end_m = met ? hit.distance_m : INFINITY;
    al_flight flight = {.distance_m = end_m};
    *goes_on = false;
    if (!al_media_line_fill(&state->media, state->scene, &w->ray, end_m, &s->path)) return false;
    stretch along = stretch_of(&s->path);
    bool may_scatter = w->events < state->options.max_events;
    if (may_scatter && counts(state, w->events + 1) &&
        !add_angles(state, s, &along, w->throughput, random, out))
        return false;
    if (may_scatter)
        flight = al_media_fly(&s->path, end_m, random, w->throughput);
    else
        al_media_attenuate(&s->path, end_m, random, w->throughput);
    if (flight.scattered) {
        *v = scatter_vertex(&s->path, &along, &flight);
        w->events++;
    } else {
        if (counts(state, w->events) && met) add_emission(state, w, &hit, out);
        if (counts(state, w->events) && !met) add_sky(state, w, out);
        if (!met || w->bounces >= state->options.max_bounces) return true;
        *v = surface_vertex(&hit);
        w->bounces++;
    }
    *goes_on = true;
    return true;
}

static bool survives(walk *w, al_random *random)
{
    double chance = fmin(largest(w->throughput), 0.99);
    if (!(al_random_real(random) < chance)) return false;
    for (int c = 0; c < 3; c++) w->throughput[c] /= chance;
    return true;
}

/* Adds the radiance that arrives along the ray of a walk. */
static bool trace(const volume_path *state, scratch *s, walk *w, al_random *random, double out[3])
{
    vertex v;
    arrival arrivals[ARRIVALS];
    int count;
    bool goes_on;
    for (;;) {
        if (!walk_on(state, s, w, random, &v, &goes_on, out)) return false;
        if (!goes_on) return true;
        if (counts(state, w->events)) {
            double u[3] = {al_random_real(random), al_random_real(random), al_random_real(random)};
            if (!ask_lights(state, s, &v, u, random, arrivals, &count)) return false;
            for (int i = 0; i < count; i++)
                for (int c = 0; c < 3; c++) out[c] += w->throughput[c] * arrivals[i].power[c];
        }
        for (int c = 0; c < 3; c++) w->throughput[c] *= v.scale[c];
        if (!survives(w, random)) return true;
        double direction[3], u0 = al_random_real(random), u1 = al_random_real(random);
        draw_direction(&v, u0, u1, direction);
        w->ray = leave(&v, direction);
        w->event = v.event;
        w->density = lobe_density(&v, direction);
    }
}

static al_random stream(const double *random)
{
    return al_random_for((uint64_t)(random[SEED] * 0x1p53), 0);
}

static bool radiance(const void *user, void *memory, const al_ray *eye, const double *random, double out[3])
{
    al_random numbers = stream(random);
    walk w = {.ray = *eye, .throughput = {1, 1, 1}};
    out[0] = out[1] = out[2] = 0;
    return trace(user, memory, &w, &numbers, out);
}

static vertex receiver_vertex(const volume_path *state, const al_receiver *receiver)
{
    const double *n = receiver->normal;
    bool is_probe = n[0] == 0 && n[1] == 0 && n[2] == 0;
    double measure = is_probe ? 4 * AL_PI : AL_PI;
    vertex v = {.lobe = is_probe ? LOBE_SPHERE : LOBE_COSINE, .scale = {measure, measure, measure}};
    for (int k = 0; k < 3; k++) {
        v.axis[k] = receiver->normal[k];
        v.position[k] = receiver->position[k] + al_ray_scene_offset_m(state->scene) * v.axis[k];
    }
    return v;
}

/* What comes from one direction, as irradiance or as coefficients. */
static void add_received(const vertex *v, const double towards[3], const double power[3], double (*out)[3])
{
    double basis[AL_SH_MAX_COUNT] = {1};
    int count = v->lobe == LOBE_SPHERE ? AL_PROBE_COUNT : 1;
    if (count > 1) al_sh_basis(AL_PROBE_ORDER, towards[0], towards[1], towards[2], basis);
    for (int i = 0; i < count; i++)
        for (int c = 0; c < 3; c++) out[i][c] += power[c] * basis[i];
}

static bool receive(const void *user, void *memory, const al_receiver *receiver, const double *random,
                    double (*out)[3])
{
    const volume_path *state = user;
    al_random numbers = stream(random);
    vertex v = receiver_vertex(state, receiver);
    arrival arrivals[ARRIVALS];
    int count = 0;
    for (int i = 0; i < (v.lobe == LOBE_SPHERE ? AL_PROBE_COUNT : 1); i++)
        out[i][0] = out[i][1] = out[i][2] = 0;
    if (counts(state, 0) && !ask_lights(state, memory, &v, random + EMITTER, &numbers, arrivals, &count))
        return false;
    for (int i = 0; i < count; i++) add_received(&v, arrivals[i].towards, arrivals[i].power, out);
    double direction[3], power[3] = {0};
    draw_direction(&v, random[ACROSS], random[ROUND], direction);
    walk w = {.ray = leave(&v, direction), .density = lobe_density(&v, direction), .throughput = {1, 1, 1}};
    if (!trace(state, memory, &w, &numbers, power)) return false;
    for (int c = 0; c < 3; c++) power[c] *= v.scale[c];
    add_received(&v, direction, power, out);
    return true;
}

const al_mode al_mode_volume_path = {
    .name = "volume-path",
    .summary = "all light, off surfaces and out of media",
    .open = open_state,
    .close = close_state,
    .dimensions = dimensions,
    .scratch_new = scratch_new,
    .scratch_free = scratch_free,
    .radiance = radiance,
    .receive = receive,
};
