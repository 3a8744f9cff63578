/* Light of one bounce against closed forms.
 *
 * Furnace: inside a box that sends 1 everywhere each surface sends the albedo it has for its view: Lambert's base colour, or
 * the lobe's, the integral of BRDF times cosine, here by microfacets drawn as Heitz (2018) does, not as the shader draws
 * them. A share exp(-3) of the rays at most passes between discs of three times the walls' area, and none between triangles.
 * Mapped normals: of that light, what comes from before the wall; mirrors show what the mapped normal turns them to.
 * Two plates: the floor sends 1, a small plate over its middle gets its form factor (Howell, configuration B-4: a
 * differential area parallel to a rectangle's corner).
 * Glossy senders in fog: a lamp, a metal wall, a metal floor, the eye, by quadrature over the wall.
 * What is left alone: a floor without others, and convex surfaces, get nothing from themselves. */
#include <epoxy/gl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../../runtime/state.h"
#include "../test.h"
#include "airlight/formulas.h"
#include "sphere.h"
#include "stage.h"

enum { EDGE = 40, SAMPLES = 8, NODES = 48 };

/* --- scenes --- */

/* The square with its front towards `axis` (0 to 2, `side` 1 or -1), its middle at `place`. */
static void add_square(sphere_scene *s, float size, const float place[3], int axis, float side)
{
    sphere_scene_add_floor(s, size, place);
    float *world = s->instances[s->scene.instance_count - 1].world;
    memset(world, 0, 12 * sizeof *world);
    world[(axis + 2) % 3] = size * side;
    world[4 + axis] = size * side;
    world[8 + (axis + 1) % 3] = size;
}

/* A box of 2 m that sends 1 inwards. */
static void add_box(sphere_scene *s)
{
    for (int i = 0; i < 6; i++) {
        float place[3] = {0, 0, 0}, side = i % 2 ? 1 : -1;
        place[i / 2] = -side;
        add_square(s, 2, place, i / 2, side);
    }
    for (int c = 0; c < 3; c++) s->materials[1].emission_w_m2_sr[c] = 1;
}

static al_runtime *open_scene(const char *folder, sphere_scene *s)
{
    al_runtime *runtime = NULL;
    al_error error = {0};
    s->scene.baked = (al_baked_light){"", ""};
    CHECK(sphere_scene_write(folder, s));
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK);
    CHECK(stage_load(runtime, folder));
    sphere_scene_end(s);
    return runtime;
}

/* Of each pixel: normal and unit direction to the eye. */
typedef struct seen {
    float geometry[EDGE * EDGE][4];
    double view[EDGE * EDGE][3];
} seen;

static void read_seen(const al_runtime *runtime, seen *s)
{
    al_frame_block frame;
    glGetNamedBufferSubData(runtime->frame_block.id, 0, sizeof frame, &frame);
    glGetTextureImage(runtime->targets.geometry.id, 0, GL_RGBA, GL_FLOAT, sizeof s->geometry, s->geometry);
    for (uint32_t i = 0; i < EDGE * EDGE; i++) {
        double length = 0;
        for (int k = 0; k < 3; k++) {
            s->view[i][k] = -(frame.ray[3][k] + (i % EDGE + 0.5) * frame.ray[4][k] + (i / EDGE + 0.5) * frame.ray[5][k]);
            length += s->view[i][k] * s->view[i][k];
        }
        for (int k = 0; k < 3; k++) s->view[i][k] /= sqrt(length);
    }
}

static float *draw(al_runtime *runtime, const al_view *view, const al_settings *settings)
{
    float *pixels = stage_draw(runtime, view, settings, 0);
    CHECK(pixels && !stage_bad(pixels, EDGE * EDGE * 3));
    return pixels;
}

/* --- furnace --- */

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double fresnel(double f0, double cosine)
{
    double grazing = fmin(50 * f0, 1);
    return f0 + (grazing - f0) * pow(fmax(1 - cosine, 0), 5);
}

/* A microfacet as seen from `v`, z along the normal. */
static void draw_microfacet(const double v[3], double alpha, double u0, double u1, double m[3])
{
    double h[3] = {alpha * v[0], alpha * v[1], v[2]}, size = sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
    for (int k = 0; k < 3; k++) h[k] /= size;
    double flat = hypot(h[0], h[1]), a[3] = {1, 0, 0};
    if (flat > 0) a[0] = -h[1] / flat, a[1] = h[0] / flat;
    double b[3] = {-h[2] * a[1], h[2] * a[0], h[0] * a[1] - h[1] * a[0]};
    double r = sqrt(u0), x = r * cos(2 * AL_PI * u1), y = r * sin(2 * AL_PI * u1), s = 0.5 * (1 + h[2]);
    y = (1 - s) * sqrt(1 - x * x) + s * y;
    double z = sqrt(fmax(1 - x * x - y * y, 0)), length = 0;
    for (int k = 0; k < 3; k++) m[k] = (x * a[k] + y * b[k] + z * h[k]) * (k < 2 ? alpha : 1);
    for (int k = 0; k < 3; k++) length += m[k] * m[k];
    for (int k = 0; k < 3; k++) m[k] /= sqrt(length);
}

/* Albedo for a view at `cosine`: the lobe's F G1 over drawn microfacets, Lambert's (1 - F) over the cosine. */
static double albedo(double cosine, double color, double metallic, double roughness, double reflectance)
{
    double alpha = fmax(roughness * roughness, 1e-3), f0 = reflectance + (color - reflectance) * metallic, sum = 0;
    const double v[3] = {sqrt(1 - cosine * cosine), 0, cosine};
    for (int i = 0; i < NODES * NODES; i++) {
        double u = (i / NODES + 0.5) / NODES, w = (i % NODES + 0.5) / NODES, m[3], half = 0;
        draw_microfacet(v, alpha, u, w, m);
        double dot = v[0] * m[0] + v[2] * m[2], toward = 2 * dot * m[2] - v[2];
        if (toward > 0)
            sum += fresnel(f0, dot) * 2 * toward / (toward + sqrt(alpha * alpha + (1 - alpha * alpha) * toward * toward));
        double z = sqrt(1 - u), x = sqrt(u) * cos(2 * AL_PI * w), y = sqrt(u) * sin(2 * AL_PI * w);
        half = hypot(hypot(x + v[0], y), z + v[2]);
        sum += (1 - fresnel(f0, half / 2)) * color * (1 - metallic);
    }
    return sum / (NODES * NODES);
}

static void check_furnace(al_runtime *runtime, al_carrier carrier, double roughness, double metallic, bool filter)
{
    static seen s;
    const double color = 0.8, ior = 1.5, reflectance = pow((ior - 1) / (ior + 1), 2);
    al_material *m = &al_runtime_scene(runtime)->materials[1];
    for (int c = 0; c < 3; c++) m->base_color[c] = (float)color;
    m->roughness = (float)roughness;
    m->metallic = (float)metallic;
    m->ior = (float)ior;
    al_view view = stage_look(EDGE, EDGE, (float[3]){0.3f, 0.2f, 0.9f}, (float[3]){-0.2f, -0.5f, -1}, 1.2f);
    al_settings settings = {.pass = AL_PASS_INDIRECT, .bounce_samples = SAMPLES, .bounce_filter_off = !filter,
                            .indirect_lambert = true, .shell_levels = 1, .surfel_pixels = 2, .indirect_carrier = carrier};
    float *pixels = draw(runtime, &view, &settings);
    if (!pixels) return;
    read_seen(runtime, &s);
    double found = 0, expected = 0;
    for (uint32_t i = 0; i < EDGE * EDGE; i++) {
        double cosine = 0;
        for (int k = 0; k < 3; k++) cosine += s.geometry[i][k] * s.view[i][k];
        found += (double)pixels[3 * i];
        if (i % 7 == 0) expected += 7 * albedo(fmin(cosine, 1), color, metallic, roughness, reflectance);
    }
    double noise = 3 / sqrt((double)EDGE * EDGE * SAMPLES); /* no ray counts more than 1, but for what F G1 varies */
    printf("furnace, carrier %d, roughness %g, metallic %g: %.4f of the albedo, noise %.4f\n", (int)carrier, roughness, metallic,
           found / expected, noise);
    CHECK(found / expected > 1 - (carrier == AL_CARRIER_SURFELS ? exp(-3) : 0) - noise);
    CHECK(found / expected < 1 + noise);
    free(pixels);
}

static void test_furnace(const char *folder)
{
    sphere_scene s;
    sphere_scene_begin(&s);
    add_box(&s);
    al_runtime *runtime = open_scene(folder, &s);
    static const double roughnesses[] = {0, 0.2, 0.5, 1};
    for (int i = 0; i < 4; i++)
        for (int metal = 0; metal < 2; metal++) {
            check_furnace(runtime, AL_CARRIER_SURFELS, roughnesses[i], metal, i % 2);
            check_furnace(runtime, AL_CARRIER_VOLUMES, roughnesses[i], metal, i % 2);
        }
    check_furnace(runtime, AL_CARRIER_SURFELS, 0.5, 0.5, true);
    al_runtime_destroy(runtime);
}

/* --- mapped normals --- */

/* Of a square whose normal is turned by `degrees` towards its first axis. */
typedef struct bent_map {
    uint8_t texel[4];
    float uv[8];
    al_texture texture;
} bent_map;

static void set_map(sphere_scene *s, bent_map *map, double degrees)
{
    static const float uv[8] = {0, 0, 0, 1, 1, 1, 1, 0};
    const double turn = degrees * AL_PI / 180, normal[4] = {sin(turn), 0, cos(turn), 1};
    for (int k = 0; k < 4; k++) map->texel[k] = (uint8_t)lround(127.5 + 127.5 * normal[k]);
    memcpy(map->uv, uv, sizeof uv);
    map->texture = (al_texture){"bent", 1, 1, false, map->texel};
    s->meshes[1].uv0 = map->uv;
    s->scene.textures = &map->texture;
    s->scene.texture_count = 1;
    s->materials[1].normal_texture = 0;
}

/* The axis a wall faces, as its mapped normal is turned from it by 30 degrees. */
static void face_of(const float normal[4], double face[3])
{
    int axis = 0;
    for (int k = 1; k < 3; k++)
        if (fabsf(normal[k]) > fabsf(normal[axis])) axis = k;
    for (int k = 0; k < 3; k++) face[k] = k == axis ? copysign(1, (double)normal[k]) : 0;
}

/* Of light from the side of `face` alone, as albedo() of `normal` for light from everywhere; of metal or Lambert's. */
static double albedo_above(const double normal[3], const double face[3], const double view[3], double color, bool metal,
                           double roughness)
{
    enum { FEWER = 24 };
    double alpha = fmax(roughness * roughness, 1e-3), x[3] = {0}, y[3], sum = 0, v[3];
    x[fabs(normal[0]) < 0.6 ? 0 : 1] = 1;
    double along = dot(x, normal), size = sqrt(1 - along * along);
    for (int k = 0; k < 3; k++) x[k] = (x[k] - along * normal[k]) / size;
    for (int k = 0; k < 3; k++) y[k] = normal[(k + 1) % 3] * x[(k + 2) % 3] - normal[(k + 2) % 3] * x[(k + 1) % 3];
    v[0] = dot(x, view), v[1] = dot(y, view), v[2] = dot(normal, view);
    for (int i = 0; i < FEWER * FEWER; i++) {
        double u = (i / FEWER + 0.5) / FEWER, w = (i % FEWER + 0.5) / FEWER, m[3], l[3], a2 = alpha * alpha;
        if (metal) {
            draw_microfacet(v, alpha, u, w, m);
            double half = dot(v, m);
            for (int k = 0; k < 3; k++) l[k] = 2 * half * m[k] - v[k];
            if (l[2] <= 0) continue;
            u = fresnel(color, half) * 2 * l[2] / (l[2] + sqrt(a2 + (1 - a2) * l[2] * l[2]));
        } else {
            l[0] = sqrt(u) * cos(2 * AL_PI * w), l[1] = sqrt(u) * sin(2 * AL_PI * w), l[2] = sqrt(1 - u);
            u = color;
        }
        double up = 0;
        for (int k = 0; k < 3; k++) up += face[k] * (l[0] * x[k] + l[1] * y[k] + l[2] * normal[k]);
        if (up > 0) sum += u;
    }
    return sum / (FEWER * FEWER);
}

/* A box that sends 1. Seen from below the mapped normal there is no closed form. */
static void test_mapped_furnace(const char *folder)
{
    static seen s;
    sphere_scene scene;
    bent_map map;
    sphere_scene_begin(&scene);
    add_box(&scene);
    set_map(&scene, &map, 30);
    al_runtime *runtime = open_scene(folder, &scene);
    al_view view = stage_look(EDGE, EDGE, (float[3]){0.3f, 0.2f, 0.9f}, (float[3]){-0.2f, -0.5f, -1}, 1.2f);
    for (int i = 0; i < 8; i++) {
        const double roughnesses[] = {0, 0.2, 0.5, 1}, roughness = roughnesses[i / 2], color = 0.8;
        al_material *m = &al_runtime_scene(runtime)->materials[1];
        for (int c = 0; c < 3; c++) m->base_color[c] = (float)color;
        m->roughness = (float)roughness;
        m->metallic = i % 2;
        m->ior = 1;
        al_settings settings = {.pass = AL_PASS_INDIRECT, .bounce_samples = SAMPLES, .bounce_filter_off = i / 2 % 2,
                                .indirect_lambert = true, .shell_levels = 1, .surfel_pixels = 2};
        float *pixels = draw(runtime, &view, &settings);
        if (!pixels) continue;
        read_seen(runtime, &s);
        double found = 0, expected = 0;
        for (uint32_t k = 0; k < EDGE * EDGE; k++) {
            double face[3], normal[3];
            face_of(s.geometry[k], face);
            for (int c = 0; c < 3; c++) normal[c] = (double)s.geometry[k][c];
            if (dot(normal, s.view[k]) < 0.02) continue;
            found += (double)pixels[3 * k];
            if (k % 7 == 0) expected += 7 * albedo_above(normal, face, s.view[k], color, i % 2, roughness);
        }
        double noise = 3 / sqrt((double)EDGE * EDGE * SAMPLES);
        printf("mapped normals, roughness %g, metallic %d: %.4f of the albedo above the wall, noise %.4f\n", roughness, i % 2,
               found / expected, noise);
        CHECK(found / expected > 1 - exp(-3) - noise);
        CHECK(found / expected < 1 + noise);
        free(pixels);
    }
    al_runtime_destroy(runtime);
}

/* A floor of 2 m with a map that turns its normal by `degrees` towards +x, and a ball that sends 1. */
static al_runtime *open_ball(const char *folder, double degrees, float radius, const float place[3])
{
    sphere_scene s;
    bent_map map;
    sphere_scene_begin(&s);
    set_map(&s, &map, degrees);
    add_square(&s, 2, (float[3]){0, 0, 0}, 1, 1);
    sphere_scene_add_floor(&s, radius, place);
    s.instances[1].mesh = 0;
    for (int c = 0; c < 3; c++) s.materials[0].emission_w_m2_sr[c] = 1;
    return open_scene(folder, &s);
}

/* A mirror of the mapped normal: the ball where its ray, mirrored, meets the ball, nothing where it passes by; neither within
 * 0.06 m of its rim, which discs of two pixels cross. */
static void test_mapped_mirror(const char *folder)
{
    const double radius = 0.4, place[3] = {0.9, 0.7, 0}, color = 0.8, rim = 0.06;
    static seen s;
    for (int degrees = -30; degrees <= 30; degrees += 30) {
        const float ball[3] = {degrees < 0 ? -(float)place[0] : degrees ? (float)place[0] : 0, degrees ? (float)place[1] : 1, 0};
        al_runtime *runtime = open_ball(folder, degrees, (float)radius, ball);
        al_material *m = &al_runtime_scene(runtime)->materials[1];
        for (int c = 0; c < 3; c++) m->base_color[c] = (float)color;
        m->roughness = 0;
        m->metallic = 1;
        const float eye[3] = {0, 2.4f, 1.2f};
        al_view view = stage_look(EDGE, EDGE, eye, (float[3]){0, 0, 0}, 0.7f);
        al_settings settings = {.pass = AL_PASS_INDIRECT, .bounce_samples = SAMPLES, .shell_levels = 1, .surfel_pixels = 1};
        float *pixels = draw(runtime, &view, &settings);
        if (!pixels) continue;
        read_seen(runtime, &s);
        int hits = 0, misses = 0;
        double sum = 0, expected = 0, beside = 0, farthest = 0;
        for (uint32_t i = 0; i < EDGE * EDGE; i++) {
            double to[3], ray[3], normal[3], away = s.geometry[i][3];
            for (int k = 0; k < 3; k++) normal[k] = (double)s.geometry[i][k];
            double cosine = dot(normal, s.view[i]), at = (double)eye[1] - away * s.view[i][1];
            if (away == 0 || fabs(at) > 1e-3) continue; /* the ball itself */
            for (int k = 0; k < 3; k++) {
                ray[k] = 2 * cosine * normal[k] - s.view[i][k];
                to[k] = (double)ball[k] - ((double)eye[k] - away * s.view[i][k]);
            }
            double along = dot(to, ray), by = sqrt(dot(to, to) - along * along);
            if (along > 0 && by < radius - rim) {
                hits++;
                sum += (double)pixels[3 * i];
                expected += fresnel(color, cosine);
            } else if (along < 0 || by > radius + rim) {
                misses++;
                beside += (double)pixels[3 * i];
                farthest = fmax(farthest, sqrt(dot(to, to)));
            }
        }
        printf("mapped mirror, %d degrees: %.4f of the ball in %d pixels, %.1e in %d\n", degrees, sum / expected, hits, beside / misses,
               misses);
        CHECK(hits > 60 && misses > 200);
        /* Rays that pass by meet the ball where the facet is turned by half of the rim's angle or more, a share of
         * alpha^2 / (alpha^2 + tan^2), alpha being 0.001. */
        CHECK(beside / misses < 1e-6 / (1e-6 + pow(tan(0.5 * rim / farthest), 2)));
        CHECK(sum / expected > 1 - exp(-3) - 3 / sqrt(hits * SAMPLES) && sum / expected < 1 + 1e-2);
        free(pixels);
        al_runtime_destroy(runtime);
    }
}

/* A ball below the floor's plane, towards which mapped normals lean: nothing of it arrives, of one above it does. */
static void test_mapped_below(const char *folder)
{
    for (int above = 0; above < 2; above++) {
        al_runtime *runtime = open_ball(folder, 75, 0.5f, (float[3]){1.7f, above ? 0.8f : -0.8f, 0});
        al_view view = stage_look(EDGE, EDGE, (float[3]){0, 2, 0.2f}, (float[3]){0, 0, 0}, 0.5f);
        for (int i = 0; i < 12; i++) {
            const float roughnesses[] = {0, 0.4f, 1};
            al_material *m = &al_runtime_scene(runtime)->materials[1];
            m->roughness = roughnesses[i / 4];
            m->metallic = i & 1;
            al_settings settings = {.pass = AL_PASS_INDIRECT, .bounce_filter_off = i >> 1 & 1, .surfel_pixels = 4,
                                    .shell_levels = 1, .bounce_samples = 2};
            float *pixels = draw(runtime, &view, &settings);
            double sum = pixels ? stage_sum(pixels, EDGE * EDGE * 3) : -1;
            CHECK(above ? sum > 0 || (m->metallic > 0 && m->roughness < 1) : sum == 0);
            free(pixels);
        }
        al_runtime_destroy(runtime);
    }
}

/* --- plates --- */

static double corner_factor(double a, double b)
{
    double p = sqrt(1 + a * a), q = sqrt(1 + b * b);
    return (a / p * atan(b / p) + b / q * atan(a / q)) / (2 * AL_PI);
}

static void test_plates(const char *folder)
{
    const float height = 0.8f, half = 1;
    sphere_scene s;
    sphere_scene_begin(&s);
    add_square(&s, 2 * half, (float[3]){0, 0, 0}, 1, 1);
    add_square(&s, 0.05f, (float[3]){0, height, 0}, 1, -1);
    for (int c = 0; c < 3; c++) s.materials[1].emission_w_m2_sr[c] = 1;
    al_runtime *runtime = open_scene(folder, &s);
    al_view view = stage_look(EDGE, EDGE, (float[3]){0.5f, 0.2f, 0}, (float[3]){0, height, 0}, 0.06f);
    static const struct {
        al_carrier carrier;
        uint32_t levels;
    } cases[] = {{AL_CARRIER_SURFELS, 1}, {AL_CARRIER_SURFELS, 6}, {AL_CARRIER_VOLUMES, 1}, {AL_CARRIER_SURFELS_BLENDED, 1}};
    for (int k = 0; k < 4; k++) {
        bool rays = cases[k].carrier != AL_CARRIER_SURFELS_BLENDED, surfels = cases[k].carrier != AL_CARRIER_VOLUMES;
        al_settings settings = {.pass = AL_PASS_INDIRECT, .bounce_samples = SAMPLES, .surfel_pixels = 1,
                                .shell_levels = cases[k].levels, .bounce_radius_m = 1, .surfel_limit = 4000,
                                .indirect_carrier = cases[k].carrier};
        static seen seen_now;
        float *pixels = draw(runtime, &view, &settings);
        if (!pixels) continue;
        read_seen(runtime, &seen_now);
        double sum = 0, count = 0, factor = 4 * corner_factor(half / height, half / height);
        for (uint32_t i = 0; i < EDGE * EDGE; i++) {
            if (seen_now.geometry[i][1] > -0.9f) continue;
            sum += (double)pixels[3 * i];
            count++;
        }
        printf("plates, carrier %d, %u levels: %.4f on %g pixels, form factor %.4f\n", (int)cases[k].carrier, cases[k].levels,
               sum / count, count, factor);
        CHECK(count > 200);
        /* Rays that meet or not; or surfels laid at random, whose shares of the light vary as cos^4, by
         * 0.68 of their mean: three standard errors. */
        double noise = rays ? 3 * sqrt(factor * (1 - factor) / (count * SAMPLES)) : 3 * 0.68 * factor / sqrt((double)al_surfels_count(runtime));
        CHECK(sum / count > factor * (1 - (rays && surfels ? exp(-3) : 0)) - noise);
        CHECK(sum / count < factor * (rays && surfels ? 1.05 : 1) + noise); /* discs poke out by 1/20 of the edge at most */
        free(pixels);
    }
    al_runtime_destroy(runtime);
}

/* --- glossy senders --- */

static const double shine_alpha = 0.49, shine_color = 0.9, fog_per_m = 0.3;

/* BRDF of the metal: GGX's D with Smith's G1 of both sides and Schlick's F. */
static double shine(const double normal[3], const double light[3], const double view[3])
{
    double m[3], a2 = shine_alpha * shine_alpha, in = dot(normal, light), out = dot(normal, view);
    if (in <= 0 || out <= 0) return 0;
    for (int k = 0; k < 3; k++) m[k] = light[k] + view[k];
    double size = sqrt(dot(m, m)), facing = dot(normal, m) / size, spread = 1 - facing * facing * (1 - a2);
    double g = 1 / ((in + sqrt(a2 + (1 - a2) * in * in)) * (out + sqrt(a2 + (1 - a2) * out * out)));
    return fresnel(shine_color, dot(view, m) / size) * a2 / (AL_PI * spread * spread) * g;
}

static double towards(const double from[3], const double to[3], double direction[3])
{
    for (int k = 0; k < 3; k++) direction[k] = to[k] - from[k];
    double size = sqrt(dot(direction, direction));
    for (int k = 0; k < 3; k++) direction[k] /= size;
    return size;
}

/* What the eye sees at `place` on the floor: the wall at z = -0.5 is 1 m wide and high, the lamp sends 1 W/sr. */
static double shone_on(const double place[3], const double view[3], const double lamp[3])
{
    const double up[3] = {0, 1, 0}, front[3] = {0, 0, 1};
    double sum = 0;
    for (int i = 0; i < NODES * NODES; i++) {
        double at[3] = {(i % NODES + 0.5) / NODES - 0.5, (i / NODES + 0.5) / NODES, -0.5}, in[3], out[3];
        double reach = towards(at, lamp, in), leg = towards(at, place, out), back[3] = {-out[0], -out[1], -out[2]};
        sum += shine(front, in, out) * dot(front, in) / (reach * reach) * dot(front, out) / (leg * leg) *
               shine(up, back, view) * back[1] * exp(-fog_per_m * (reach + leg));
    }
    return sum / (NODES * NODES);
}

static void test_senders(const char *folder)
{
    const double lamp[3] = {0.3, 0.9, 0.6};
    const float eye[3] = {0.2f, 1.2f, 2.5f};
    static seen s;
    sphere_scene scene;
    al_fog fog = {.density = 1, .asset = ""};
    sphere_scene_begin(&scene);
    for (int c = 0; c < 3; c++) {
        scene.medium.sigma_s_per_m[c] = 0;
        scene.medium.sigma_a_per_m[c] = (float)fog_per_m;
        scene.materials[1].base_color[c] = (float)shine_color;
    }
    scene.materials[1].metallic = 1;
    scene.materials[1].roughness = (float)sqrt(shine_alpha);
    scene.scene.fogs = &fog;
    scene.scene.fog_count = 1;
    add_square(&scene, 4, (float[3]){0, 0, 0}, 1, 1);
    add_square(&scene, 1, (float[3]){0, 0.5f, -0.5f}, 2, 1);
    sphere_scene_add_light(&scene, AL_LIGHT_POINT, (float[3]){0.3f, 0.9f, 0.6f}, 1);
    al_runtime *runtime = open_scene(folder, &scene);
    al_view view = stage_look(EDGE, EDGE, eye, (float[3]){0, 0, 0.3f}, 0.35f);
    al_settings settings = {.pass = AL_PASS_INDIRECT, .bounce_samples = 32, .surfel_pixels = 1, .shell_levels = 1,
                            .bounce_filter_off = true};
    for (int volumes = 0; volumes < 2; volumes++) {
        settings.indirect_carrier = volumes ? AL_CARRIER_VOLUMES : AL_CARRIER_SURFELS;
        settings.indirect_lambert = false;
        float *pixels = draw(runtime, &view, &settings);
        double found = 0, expected = 0;
        read_seen(runtime, &s);
        for (uint32_t i = 0; i < EDGE * EDGE && pixels; i++) {
            double place[3], away = s.geometry[i][3];
            if (s.geometry[i][1] < 0.9f) continue;
            for (int k = 0; k < 3; k++) place[k] = (double)eye[k] - away * s.view[i][k];
            found += (double)pixels[3 * i];
            expected += shone_on(place, s.view[i], lamp) * exp(-fog_per_m * away);
        }
        printf("glossy senders in fog, %s: %.4f of the quadrature\n", volumes ? "volumes" : "surfels", found / expected);
        CHECK(expected > 0);
        CHECK(found / expected > 1 - (volumes ? 0 : exp(-3)) - 0.03); /* gaps; the noise of some 20 000 rays, a third of which meet the wall */
        CHECK(found / expected < 1.03);
        settings.indirect_lambert = true;
        float *matt = draw(runtime, &view, &settings);
        if (matt) CHECK(stage_sum(matt, EDGE * EDGE * 3) == 0); /* a metal has no Lambert's part */
        free(pixels);
        free(matt);
    }
    al_runtime_destroy(runtime);
}

/* --- what is left alone, and sums --- */

static void test_alone(const char *folder)
{
    sphere_scene s;
    sphere_scene_begin(&s);
    add_square(&s, 4, (float[3]){0, 0, 0}, 1, 1);
    add_square(&s, 4, (float[3]){0, 0, 0}, 1, 1); /* coplanar */
    sphere_scene_add_light(&s, AL_LIGHT_POINT, (float[3]){0, 1, 0}, 1);
    al_runtime *runtime = open_scene(folder, &s);
    al_view view = stage_look(EDGE, EDGE, (float[3]){0, 2, 2}, (float[3]){0, 0, 0}, 0.6f);
    al_view grazing = stage_look(EDGE, EDGE, (float[3]){0, 1e-3f, 2}, (float[3]){0, 0, 0}, 0.6f);
    for (int i = 0; i < 32; i++) {
        static const al_carrier carriers[] = {AL_CARRIER_SURFELS, AL_CARRIER_SURFELS_BLENDED, AL_CARRIER_VOLUMES, AL_CARRIER_SCREEN};
        al_material *m = &al_runtime_scene(runtime)->materials[1];
        m->roughness = i & 1;
        m->metallic = i >> 1 & 1;
        al_settings settings = {.pass = AL_PASS_INDIRECT, .indirect_carrier = carriers[i / 8]};
        float *pixels = draw(runtime, i & 4 ? &grazing : &view, &settings);
        if (pixels) CHECK(stage_sum(pixels, EDGE * EDGE * 3) == 0);
        free(pixels);
    }
    al_runtime_destroy(runtime);
}

/* A frame of its own, so that random numbers are the same. */
static float *draw_fresh(const char *folder, const al_settings *settings)
{
    al_runtime *runtime = NULL;
    al_error error = {0};
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK);
    CHECK(stage_load(runtime, folder));
    al_view view = stage_look(EDGE, EDGE, (float[3]){0, 2, 3}, (float[3]){0, 0.3f, 0}, 0.6f);
    float *pixels = draw(runtime, &view, settings);
    al_runtime_destroy(runtime);
    return pixels;
}

/* A floor under a sun and a sky, and a wall on it. */
static void write_wall(const char *folder, float lift)
{
    sphere_scene s;
    sphere_scene_begin(&s);
    add_square(&s, 4, (float[3]){0, 0, 0}, 1, 1);
    add_square(&s, 1, (float[3]){0, 0.5f + lift, -0.4f}, 2, 1);
    sphere_scene_add_light(&s, AL_LIGHT_DIRECTIONAL, (float[3]){0, -0.8f, -0.6f}, 3);
    s.materials[1].roughness = 0.3f;
    s.materials[1].ior = 1.5f;
    for (int c = 0; c < 3; c++) s.scene.environment.sh[c][0] = 0.5f * 3.5449077f; /* 0.5 W/(m2 sr) from everywhere */
    s.scene.baked = (al_baked_light){"", ""};
    CHECK(sphere_scene_write(folder, &s));
    sphere_scene_end(&s);
}

static void check_sums(const char *folder, al_carrier carrier)
{
    const al_settings plain = {0}, alone = {.pass = AL_PASS_INDIRECT, .indirect_carrier = carrier},
                      both = {.indirect = true, .indirect_carrier = carrier},
                      open = {.ambient_occlusion = true, .occlusion_carrier = carrier};
    float *p = draw_fresh(folder, &plain), *a = draw_fresh(folder, &alone), *b = draw_fresh(folder, &both),
          *c = draw_fresh(folder, &both), *o = draw_fresh(folder, &open);
    if (p && a && b && c && o) {
        double darker = 0;
        CHECK(!memcmp(b, c, EDGE * EDGE * 3 * sizeof *b));
        CHECK(stage_sum(a, EDGE * EDGE * 3) > 0);
        for (int i = 0; i < EDGE * EDGE * 3; i++) {
            CHECK_NEAR((double)b[i], (double)p[i] + (double)a[i], 1e-5 * (1 + (double)p[i]));
            CHECK(o[i] <= p[i] + 1e-3f * p[i]); /* materials in halves */
            darker += (double)(p[i] - o[i]);
        }
        printf("carrier %d: ambient occlusion takes %.4f of the light\n", (int)carrier, darker / stage_sum(p, EDGE * EDGE * 3));
        CHECK(darker > 0.01 * stage_sum(p, EDGE * EDGE * 3));
    }
    free(p), free(a), free(b), free(c), free(o);
}

static void test_sums(const char *folder)
{
    write_wall(folder, 0);
    for (al_carrier carrier = 0; carrier < AL_CARRIER_COUNT; carrier++)
        if (carrier != AL_CARRIER_VOLUMES_BLENDED) check_sums(folder, carrier);
}

int main(void)
{
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    const char *folder = stage_folder();
    CHECK(folder != NULL);
    if (!folder) return test_end();
    test_furnace(folder);
    test_mapped_furnace(folder);
    test_mapped_mirror(folder);
    test_mapped_below(folder);
    test_plates(folder);
    test_senders(folder);
    test_alone(folder);
    test_sums(folder);
    return test_end();
}
