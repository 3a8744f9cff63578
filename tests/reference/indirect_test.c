/* Ambient occlusion and one bounce between surfaces against closed forms, quadrature and volume paths.
 * "Within noise" is 4.5 standard errors of 16 batches (t distribution of 15 degrees: one in 2000); seeds are
 * fixed. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdarg.h>

#include "../test.h"
#include "airlight/formulas.h"
#include "directions.h"
#include "reflection.h"
#include "scene_for_test.h"

static const double sigmas = 4.5;

AL_PRINTF(3, 4)
static test_scene open_mode(const al_mode *mode, al_mode_options options, const char *format, ...)
{
    static char json[16384];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(json, sizeof json, format, arguments);
    va_end(arguments);
    return open_scene_for(mode, &options, json);
}

static void check_ray(const test_scene *scene, al_ray ray, uint32_t count, double expected, double relative)
{
    double error, value = estimate(scene, &ray, count, 1, &error);
    CHECK_NEAR(value, expected, sigmas * error + relative * expected);
    CHECK(error <= 0.005 * expected);
}

/* --- ambient occlusion --- */

/* Straight down onto the floor at x, z. */
static al_ray down(double x, double z)
{
    return ray_along(x, 0.1, z, 0, -1, 0);
}

/* Share of the hemisphere that a wall at distance c covers, of height a and length b from the point's foot to
 * one side (form factor to a perpendicular rectangle; Howell, configuration B-3). */
static double wall_share(double c, double a, double b)
{
    double x = a / b, y = c / b, root = sqrt(x * x + y * y);
    return (atan(1 / y) - y / root * atan(1 / root)) / (2 * AL_PI);
}

/* A wall at x = 0 on a floor; a ceiling within a radius R covers the directions of cosine above h / R, a
 * share of 1 - (h / R)^2; a ball of radius r whose middle is d away under an angle from the normal covers cos
 * (r / d)^2: its triangles enclose 0.05 % less. */
static void test_occlusion(void)
{
    static const char floor[] =
        "{'meshes':[{'name':'f','shape':{'type':'plane','width_m':9,'depth_m':9}},%s]}",
                      wall[] = "{'name':'w','shape':{'type':'plane','width_m':2,'depth_m':3},'transform':{"
                               "'rotate_degrees':[0,0,-90],'translate_m':[0,1,0]}}",
                      ceiling[] = "{'name':'c','shape':{'type':'plane','width_m':9,'depth_m':9},'transform':{"
                                  "'translate_m':[0,0.5,0]}}",
                      ball[] = "{'name':'b','shape':{'type':'sphere','subdivisions':5,'radius_m':0.3},"
                               "'transform':{'translate_m':[0,0.8,0]}}";
    al_mode_options near_only = al_mode_defaults;
    near_only.radius_m = 0.8;
    test_scene scene = open_mode(&al_mode_ambient_occlusion, al_mode_defaults, floor, wall);
    check_ray(&scene, down(0.4, 0.5), 400, 1 - wall_share(0.4, 2, 1) - wall_share(0.4, 2, 2), 0);
    close_scene(&scene);
    scene = open_mode(&al_mode_ambient_occlusion, near_only, floor, ceiling);
    check_ray(&scene, down(0.1, 0.1), 400, (0.5 / 0.8) * (0.5 / 0.8), 1e-5);
    close_scene(&scene);
    scene = open_mode(&al_mode_ambient_occlusion, al_mode_defaults, floor, ball);
    double square = 0.8 * 0.8 + 0.3 * 0.3;
    check_ray(&scene, down(0.3, 0), 400, 1 - 0.8 / sqrt(square) * 0.3 * 0.3 / square, 0.0005);
    al_ray away = ray_along(0, 5, 0, 0, 1, 0);
    double error;
    CHECK(estimate(&scene, &away, 2, 0, &error) == 0);
    close_scene(&scene);
}

/* --- reflection --- */

/* Drawn directions have the density that is stated: over the sphere it sums to one (midpoints in cosine about
 * the mirrored direction, denser towards it, and angle), and the mean over draws of value / density is the
 * sum of the value. */
static void test_reflection(void)
{
    static const struct {
        double alpha, view[3], diffuse, f0;
    } cases[] = {{1, {0.6, 0, 0.8}, 0, 1},
                 {0.04, {0.6, 0, 0.8}, 0, 1},
                 {0.25, {0.9797958971132712, 0, 0.2}, 0.5, 0.04},
                 {0.3, {0, 0, 1}, 0.2, 0.6}};
    enum { RINGS = 4000, SPOKES = 200, DRAWS = 20000 };
    for (int i = 0; i < 4; i++) {
        double f0 = cases[i].f0, d = cases[i].diffuse;
        const double *v = cases[i].view;
        al_reflection r = {.normal = {0, 0, 1},
                           .face = {0, 0, 1},
                           .view = {v[0], v[1], v[2]},
                           .diffuse = {d, d, d},
                           .f0 = {f0, f0, f0},
                           .alpha = cases[i].alpha,
                           .lambert_share = d > 0 ? 0.4 : 0};
        double mirrored[3] = {-v[0], -v[1], v[2]}, density = 0, value = 0, towards[3], out[3];
        for (int k = 0; k < RINGS; k++) {
            /* 1 - cosine = 2 s^4, so d cosine = 8 s^3 ds */
            double s = (k + 0.5) / RINGS, ring = 8 * s * s * s / RINGS * 2 * AL_PI / SPOKES;
            for (int n = 0; n < SPOKES; n++) {
                al_direction_about(mirrored, 1 - 2 * s * s * s * s, 2 * AL_PI * (n + 0.5) / SPOKES, towards);
                density += ring * al_reflection_density(&r, towards);
                al_reflection_value(&r, towards, out);
                value += ring * out[1];
            }
        }
        CHECK_NEAR(density, 1, 2e-3);
        double mean = 0, square = 0, u[3], start[3] = {0.2, 0.5, 0.8};
        for (uint32_t n = 0; n < DRAWS; n++) {
            al_sample_turned(start, 3, n, u);
            al_reflection_draw(&r, u, towards);
            double p = al_reflection_density(&r, towards);
            al_reflection_value(&r, towards, out);
            CHECK(p > 0 && fabs(al_dot(towards, towards) - 1) < 1e-9);
            mean += out[1] / p / DRAWS;
            square += out[1] / p * out[1] / p / DRAWS;
        }
        /* the sequence does better than independent draws, whose error this is */
        CHECK_NEAR(mean, value, 3 * sqrt((square - mean * mean) / DRAWS) + 2e-3 * value);
        CHECK(value < 1);
    }
}

/* --- one bounce --- */

/* A wall (x = 0, 0 < y < 1, |z| < 0.5) that the sun lights, and a floor of gold that mirrors it: midpoints
 * over the wall of f cos_x cos_y / r^2 albedo / pi E, with GGX written out once more. */
static double gold(double alpha, int channel, double cos_view, double cos_light, double cos_normal,
                   double cos_half)
{
    static const double f0[3] = {1, 0.7, 0.3};
    double a2 = alpha * alpha, d = a2 / (AL_PI * pow(cos_normal * cos_normal * (a2 - 1) + 1, 2)), g = 1;
    double cosines[2] = {cos_view, cos_light};
    for (int i = 0; i < 2; i++) g *= 2 / (1 + sqrt(1 + a2 * (1 / (cosines[i] * cosines[i]) - 1)));
    double f = f0[channel] + (1 - f0[channel]) * pow(1 - cos_half, 5);
    return d * g * f / (4 * cos_view * cos_light);
}

static double gold_quadrature(double alpha, int channel, const double x[3], const double view[3], int steps)
{
    double sum = 0;
    for (int i = 0; i < steps * steps; i++) {
        double to[3] = {-x[0], (i % steps + 0.5) / steps, (i / steps + 0.5) / steps - 0.5 - x[2]}, half[3],
               r = sqrt(al_dot(to, to));
        for (int k = 0; k < 3; k++) half[k] = to[k] / r + view[k];
        double h = sqrt(al_dot(half, half)), cos_light = to[1] / r;
        sum += gold(alpha, channel, view[1], cos_light, half[1] / h, al_dot(half, view) / h) * cos_light *
               x[0] / (r * r * r);
    }
    return sum / (steps * steps) * 0.5 / AL_PI * 3 * 0.8; /* albedo 0.5; E = 3, cosine 0.8 */
}

static const char gold_scene[] =
    "{'materials':[{'name':'black','base_color':0,'ior':1},{'name':'wall','base_color':0.5,'ior':1},{'name':'"
    "gold','base_color':[1,0.7,0.3],'"
    "metallic':"
    "1,'roughness':%g}],'meshes':[{'name':'f','shape':{'type':'plane','width_m':4,'depth_m':4},'material':"
    "'gold'},{'name':'w','shape':{'type':'plane','width_m':1,'depth_m':1},'material':'wall','transform':{"
    "'rotate_degrees':[0,0,-90],'translate_m':[0,0.5,0]}}%s],"
    "'lights':[{'type':'directional','direction':[-0.8,-0.6,0],'irradiance_w_m2':3}]}";

static void test_gold(void)
{
    static const double roughness[3] = {1, 0.5, 0.3};
    double x[3] = {0.5, 0, 0.1}, view[3] = {0.6, 0.8, 0};
    al_ray eye = ray_along(x[0] + view[0], view[1], x[2], -view[0], -view[1], 0);
    for (int i = 0; i < 3; i++) {
        double alpha = roughness[i] * roughness[i], error;
        test_scene scene = open_mode(&al_mode_indirect, al_mode_defaults, gold_scene, roughness[i], "");
        for (int c = 0; c < 3; c++) {
            double expected = gold_quadrature(alpha, c, x, view, 400);
            CHECK_NEAR(gold_quadrature(alpha, c, x, view, 200), expected, 1e-3 * expected);
            double value = estimate(&scene, &eye, 300, c, &error);
            CHECK_NEAR(value, expected, sigmas * error + 1e-3 * expected);
            CHECK(error <= 0.005 * expected);
        }
        close_scene(&scene);
    }
}

/* A black screen that hides the lower half of the wall: without visibility it does nothing, but for its
 * shadow, which falls on the floor here. */
static void test_screen(void)
{
    static const char screen[] =
        ",{'name':'s','shape':{'type':'plane','width_m':0.2,'depth_m':3},'material':"
        "'black','transform':{'rotate_degrees':[0,0,-90],'translate_m':[0.25,0.1,0]}}";
    double x[3] = {0.5, 0, 0.1}, view[3] = {0.6, 0.8, 0}, error[3];
    al_ray eye = ray_along(x[0] + view[0], view[1], x[2], -view[0], -view[1], 0);
    al_mode_options through = al_mode_defaults;
    through.no_visibility = true;
    test_scene hidden = open_mode(&al_mode_indirect, al_mode_defaults, gold_scene, 1.0, screen),
               open = open_mode(&al_mode_indirect, through, gold_scene, 1.0, screen);
    double expected = 0, whole = gold_quadrature(1, 0, x, view, 400);
    for (int i = 0; i < 400 * 400;
         i++) { /* the screen's upper edge at x = 0.25, y = 0.2 is seen at y = 0.4 */
        double y = (i % 400 + 0.5) / 400, z = (i / 400 + 0.5) / 400 - 0.5 - x[2], to[3] = {-x[0], y, z},
               half[3];
        double r = sqrt(al_dot(to, to));
        if (y < 0.4) continue;
        for (int k = 0; k < 3; k++) half[k] = to[k] / r + view[k];
        double h = sqrt(al_dot(half, half));
        expected += gold(1, 0, view[1], y / r, half[1] / h, al_dot(half, view) / h) * y / r * x[0] /
                    (r * r * r) / (400 * 400) * 0.5 / AL_PI * 3 * 0.8;
    }
    /* The sun comes over the screen to the wall above y = 0.2 + 0.25 * 0.6 / 0.8. */
    double value = estimate(&hidden, &eye, 300, 0, &error[0]);
    CHECK(expected < 0.95 * whole);
    CHECK_NEAR(value, expected, sigmas * error[0] + 2e-3 * expected);
    CHECK(error[0] <= 0.01 * expected);
    CHECK(estimate(&open, &eye, 300, 0, &error[1]) >= value);
    close_scene(&hidden);
    close_scene(&open);
}

/* Lambert surfaces: at most two bounces of volume paths, less at most one. Every kind of lamp, and a fog that
 * absorbs. */
static void test_paths(void)
{
    static const char scene[] =
        "{'materials':[{'name':'glow','base_color':0,'emission_w_m2_sr':[3,2,1]},"
        "{'name':'grey','base_color':[0.8,0.5,0.3],'ior':1},{'name':'red','base_color':[0.7,0.2,0.1],'ior':1}"
        "],"
        "'meshes':[{'name':'floor','shape':{'type':'plane','width_m':3,'depth_m':3},'material':'grey'},"
        "{'name':'wall','shape':{'type':'plane','width_m':2,'depth_m':1},'material':'red',"
        "'transform':{'rotate_degrees':[90,0,0],'translate_m':[0,0.5,-0.8]}},"
        "{'name':'box','shape':{'type':'box','size_m':[0.3,0.4,0.3]},'material':'red',"
        "'transform':{'rotate_degrees':[0,30,0],'translate_m':[-0.3,0.2,0.1]}},"
        "{'name':'panel','shape':{'type':'plane','width_m':0.5,'depth_m':0.5},'material':'glow',"
        "'transform':{'rotate_degrees':[180,0,0],'translate_m':[0.3,1,0]}}],"
        "'media':[{'name':'a','sigma_s_per_m':[0.2,0.4,0.1],'sigma_a_per_m':0.3}],'fogs':[%s],"
        "'environment':{'radiance_w_m2_sr':[0.2,0.1,0.3]},"
        "'lights':[{'type':'point','position_m':[0.5,0.3,-0.3],'intensity_w_sr':0.4}%s]}";
    /* Endless fog lets no sun through. */
    for (int i = 0; i < 2; i++) {
        const char *sun = i ? ",{'type':'directional','direction':[-0.6,-0.7,-0.4],'irradiance_w_m2':2}" : "";
        const char *fogs = i ? "" : "'a'";
        test_scene ours = open_mode(&al_mode_indirect, al_mode_defaults, scene, fogs, sun);
        test_scene two =
            open_mode(&al_mode_volume_path, (al_mode_options){.max_bounces = 2}, scene, fogs, sun);
        test_scene one =
            open_mode(&al_mode_volume_path, (al_mode_options){.max_bounces = 1}, scene, fogs, sun);
        al_ray rays[] = {ray_along(1, 1, 1.2, -1, -1, -1.1), ray_along(0.2, 1.5, 2, -0.1, -1, -2.6)};
        for (int k = 0; k < 2; k++)
            for (int c = 0; c < 3; c += 2) {
                double noise[3], value = estimate(&ours, &rays[k], 200, c, &noise[0]);
                double expected = estimate(&two, &rays[k], 15000, c, &noise[1]) -
                                  estimate(&one, &rays[k], 15000, c, &noise[2]);
                CHECK_NEAR(value, expected, sigmas * hypot(noise[0], hypot(noise[1], noise[2])));
                CHECK(noise[0] <= 0.01 * expected && hypot(noise[1], noise[2]) <= 0.03 * expected);
            }
        close_scene(&ours);
        close_scene(&two);
        close_scene(&one);
    }
}

int main(void)
{
    test_occlusion();
    test_reflection();
    test_gold();
    test_screen();
    test_paths();
    return test_end();
}
