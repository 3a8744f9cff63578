/* Single scattering against closed forms and quadrature. "Within noise" is 4.5 standard errors of 16 batches
 * (t distribution of 15 degrees: one in 2000) plus the stated error of the set-up; seeds are fixed. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdarg.h>
#include <string.h>

#include "../test.h"
#include "airlight/formulas.h"
#include "environment_sampler.h"
#include "scene_for_test.h"
#include "sphere_rows.inc"
#include "vdb_writer.h"

static const double sigmas = 4.5;

AL_PRINTF(1, 2)
static test_scene open_scene_of(const char *format, ...)
{
    char json[4096];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(json, sizeof json, format, arguments);
    va_end(arguments);
    return open_scene(json);
}

/* --- a homogeneous sphere --- */

#define SPHERE(radius, medium, rest) \
    "{'meshes':[{'name':'ball','shape':{'type':'sphere','radius_m':" radius ",'subdivisions':6}}]," \
    "'media':[{'name':'m'," medium "}]," \
    "'translucents':[{'name':'o','mesh':'ball','medium':'m'}]," rest "}"

/* 20 * 4^6 triangles inscribed in the unit sphere: edges of 1.107/64 rad, so faces lie up to (edge/sqrt 3)^2
 * / 2 = 5e-5 below the sphere. A ray at radius 0.95 meets them at cosine 0.3: 1.7e-4 along it at each end of
 * both legs; the radiance changes by that times 1/chord (0.6) and by that times sigma_t. */
static double sphere_error(double sigma_t)
{
    return 1.7e-4 * (2 / 0.6 + sigma_t);
}

static void check_rows(const double (*rows)[3], size_t count, double sigma_t, double albedo,
                       const double light[3], double g)
{
    test_scene scene =
        open_scene_of(SPHERE("1", "'sigma_s_per_m':%.17g,'sigma_a_per_m':%.17g,'g':%g",
                             "'lights':[{'type':'directional','direction':[%g,%g,%g],'irradiance_w_m2':1}]"),
                      sigma_t * albedo, sigma_t * (1 - albedo), g, light[0], light[1], light[2]);
    /* One direction of light, one of sight: the phase function is a factor. Light travels along `light`, then
     * +z. */
    double phase = 4 * AL_PI * al_phase(g, light[2]);
    for (size_t i = 0; i < count; i++) {
        al_ray ray = ray_along(rows[i][0], rows[i][1], 10, 0, 0, -1);
        double error, value = estimate(&scene, &ray, 64, 1, &error), expected = rows[i][2] * phase;
        CHECK_NEAR(value, expected, sigmas * error + sphere_error(sigma_t) * expected);
        CHECK(error <= 0.01 * expected); /* so that the check above means something */
    }
    close_scene(&scene);
}

static void test_sphere(void)
{
    check_rows(sphere_rows_0, sizeof sphere_rows_0 / sizeof *sphere_rows_0, 2, 0.9, (double[]){0, 0, -1}, 0);
    check_rows(sphere_rows_1, sizeof sphere_rows_1 / sizeof *sphere_rows_1, 2, 0.9, (double[]){-0.6, 0, -0.8},
               0);
    check_rows(sphere_rows_2, sizeof sphere_rows_2 / sizeof *sphere_rows_2, 6, 0.8, (double[]){0, -0.6, 0.8},
               0);
    check_rows(sphere_rows_1, 3, 2, 0.9, (double[]){-0.6, 0, -0.8}, 0.7);
    check_rows(sphere_rows_1, 3, 2, 0.9, (double[]){-0.6, 0, -0.8}, -0.95);
}

/* Distance from a point to a sphere of radius 1, or to `limit` if that is nearer. */
static double exit_distance(const double p[3], const double d[3], double limit)
{
    double along = p[0] * d[0] + p[1] * d[1] + p[2] * d[2], square = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
    return fmin(-along + sqrt(along * along - square + 1), limit);
}

/* Midpoint quadrature of L = integral sigma_s/(4 pi) exp(-sigma_t (t + d)) I / r^2 along (0.3, 0.2, 1) - z.
 */
static double point_light_quadrature(double sigma_s, double sigma_t, const double light[3])
{
    enum { STEPS = 200000 };
    double half = sqrt(1 - 0.3 * 0.3 - 0.2 * 0.2), sum = 0;
    for (int i = 0; i < STEPS; i++) {
        double t = 2 * half * (i + 0.5) / STEPS, p[3] = {0.3, 0.2, half - t}, d[3], r = 0;
        for (int k = 0; k < 3; k++) d[k] = light[k] - p[k], r += d[k] * d[k];
        r = sqrt(r);
        for (int k = 0; k < 3; k++) d[k] /= r;
        sum += sigma_s / (4 * AL_PI) * exp(-sigma_t * (t + exit_distance(p, d, r))) / (r * r);
    }
    return sum * 2 * half / STEPS;
}

static void test_point_light(void)
{
    /* Outside, inside, and 1 cm beside the ray. */
    static const double lights[][3] = {{-1.4, 0.8, 0.6}, {-0.2, 0.5, 0.3}, {0.31, 0.2, 0.1}};
    for (int i = 0; i < 3; i++) {
        const double *l = lights[i];
        test_scene scene = open_scene_of(
            SPHERE("1", "'sigma_s_per_m':3,'sigma_a_per_m':[0.5,1,1]",
                   "'lights':[{'type':'point','position_m':[%g,%g,%g],'intensity_w_sr':[0,1,2]}]"),
            l[0], l[1], l[2]);
        al_ray ray = ray_along(0.3, 0.2, 7, 0, 0, -1);
        double error, expected = point_light_quadrature(3, 4, l),
                      value = estimate(&scene, &ray, 64, 1, &error);
        CHECK_NEAR(value, expected, sigmas * error + sphere_error(4) * expected);
        CHECK(error <= 0.01 * expected);
        CHECK_NEAR(estimate(&scene, &ray, 64, 2, &error), 2 * value, 1e-12 * value);
        CHECK(estimate(&scene, &ray, 4, 0, &error) == 0);
        close_scene(&scene);
    }
}

/* A thin medium under an even sky scatters sigma_s times the chord times the sky, whatever the phase
 * function. */
static void test_even_sky(void)
{
    static const double asymmetries[] = {0, 0.5, -0.9, 0.99};
    for (int i = 0; i < 4; i++) {
        test_scene scene = open_scene_of(
            SPHERE("1", "'sigma_s_per_m':1e-6,'g':%g", "'environment':{'radiance_w_m2_sr':[1,2,3]}"),
            asymmetries[i]);
        al_ray ray = ray_along(0.3, 0.2, 7, 0, 0, -1);
        double error, expected = 2e-6 * 2 * sqrt(1 - 0.13), value = estimate(&scene, &ray, 64, 1, &error);
        CHECK_NEAR(value, expected, sigmas * error + 1e-4 * expected);
        CHECK(error <= 0.01 * expected);
        close_scene(&scene);
    }
}

/* --- boxes: light from +x, seen from +z, everything in closed form --- */

#define SUN "'lights':[{'type':'directional','direction':[-1,0,0],'irradiance_w_m2':[1,2,3]}]"

/* Depth 0 to `length` at extinction s, light coming `across` through the same: s_s/(4 pi) E exp(-s across) (1
 * - exp(-s length)) / s. */
static double box_radiance(double sigma_s, double sigma_t, double across, double length)
{
    return sigma_s / (4 * AL_PI) * exp(-sigma_t * across) * -expm1(-sigma_t * length) / sigma_t;
}

/* Checks one ray's three channels; E is 1, 2, 3. */
static void check_ray(const test_scene *scene, al_ray ray, double expected, double relative)
{
    for (int channel = 0; channel < 3; channel++) {
        double error, value = estimate(scene, &ray, 32, channel, &error);
        CHECK_NEAR(value, (channel + 1) * expected, sigmas * error + relative * expected);
    }
}

static void test_absorber_in_front(void)
{
    test_scene scene = open_scene(
        "{'meshes':[{'name':'back','shape':{'type':'box','size_m':1}},"
        "{'name':'front','shape':{'type':'box','size_m':1},'transform':{'translate_m':[0,0,1.5]}}],"
        "'media':[{'name':'milk','sigma_s_per_m':2},{'name':'ink','sigma_a_per_m':1.5}],"
        "'translucents':[{'name':'b','mesh':'back','medium':'milk'},"
        "{'name':'f','mesh':'front','medium':'ink'}]," SUN "}");
    double inside = box_radiance(2, 2, 0.4, 1);
    check_ray(&scene, ray_along(0.1, 0.2, 5, 0, 0, -1), inside * exp(-1.5), 1e-6);
    check_ray(&scene, ray_along(0.1, 0.2, 0.8, 0, 0, -1), inside, 1e-6);              /* between them */
    check_ray(&scene, ray_along(0.1, 0.2, 1.5, 0, 0, -1), inside * exp(-0.75), 1e-6); /* in the absorber */
    check_ray(&scene, ray_along(0.1, 0.2, 0, 0, 0, -1), box_radiance(2, 2, 0.4, 0.5), 1e-6); /* in the milk */
    check_ray(&scene, ray_along(0.1, 0.2, 0, 0, 0, 1), box_radiance(2, 2, 0.4, 0.5), 1e-6);
    check_ray(&scene, ray_along(0.7, 0.2, 5, 0, 0, -1), 0, 0);
    close_scene(&scene);
}

/* Two objects in the same place: coefficients add, faces coincide. */
static void test_overlap(void)
{
    test_scene scene = open_scene("{'meshes':[{'name':'a','shape':{'type':'box','size_m':1}},"
                                  "{'name':'b','shape':{'type':'box','size_m':1}}],"
                                  "'media':[{'name':'one','sigma_s_per_m':1,'g':0.5},"
                                  "{'name':'two','sigma_s_per_m':0.5,'sigma_a_per_m':1}],"
                                  "'translucents':[{'name':'a','mesh':'a','medium':'one'},"
                                  "{'name':'b','mesh':'b','medium':'two'}]," SUN "}");
    /* sigma_s p: 1 at g = 0.5 and a right angle, 0.5 isotropic. */
    double effective = 1 * 4 * AL_PI * al_phase(0.5, 0) + 0.5;
    check_ray(&scene, ray_along(0.1, 0.2, 5, 0, 0, -1), box_radiance(effective, 2.5, 0.4, 1), 1e-6);
    close_scene(&scene);
}

/* A plate in the box at z = 0.2 ends the eye ray; a wall at x = 0.3 keeps the light from all but 5 cm at each
 * end of a ray behind it. */
static void test_blockers(void)
{
    test_scene scene = open_scene(
        "{'meshes':[{'name':'box','shape':{'type':'box','size_m':1}},"
        "{'name':'plate','shape':{'type':'box','size_m':[0.4,0.9,0.02]},"
        "'transform':{'translate_m':[0.28,0,0.19]}},"
        "{'name':'wall','shape':{'type':'box','size_m':[0.02,0.2,0.9]},"
        "'transform':{'translate_m':[0.3,-0.3,0]}}],"
        "'media':[{'name':'m','sigma_s_per_m':2}],"
        "'translucents':[{'name':'o','mesh':'box','medium':'m','blockers':['plate','wall']}]," SUN "}");
    check_ray(&scene, ray_along(0.4, 0.2, 5, 0, 0, -1), box_radiance(2, 2, 0.1, 0.3), 1e-5);
    check_ray(&scene, ray_along(0, -0.3, 5, 0, 0, -1), box_radiance(2, 2, 0.5, 0.05) * (1 + exp(-2 * 0.95)),
              1e-5);
    close_scene(&scene);
}

/* An outside plate between the box and the light, and one in front of the camera. */
static void test_opaque(void)
{
    test_scene scene = open_scene(
        "{'meshes':[{'name':'box','shape':{'type':'box','size_m':1}},"
        "{'name':'shade','shape':{'type':'box','size_m':[0.1,0.5,2]},"
        "'transform':{'translate_m':[2,-0.25,0]}},"
        "{'name':'lid','shape':{'type':'box','size_m':[0.2,1,0.1]},'transform':{'translate_m':[-0.4,0,2]}}],"
        "'media':[{'name':'m','sigma_s_per_m':2}],"
        "'translucents':[{'name':'o','mesh':'box','medium':'m'}]," SUN "}");
    check_ray(&scene, ray_along(0.1, 0.2, 5, 0, 0, -1), box_radiance(2, 2, 0.4, 1), 1e-6);
    check_ray(&scene, ray_along(0.1, -0.2, 5, 0, 0, -1), 0, 0);
    check_ray(&scene, ray_along(-0.4, 0.2, 5, 0, 0, -1), 0, 0);
    close_scene(&scene);
}

/* Layers of density 3 on 0.5, stacked along z: exp(-tau) integrated piece by piece; the bounds end the
 * medium. */
static void test_layers(void)
{
    test_scene scene =
        open_scene("{'meshes':[{'name':'box','shape':{'type':'box','size_m':1}}],"
                   "'media':[{'name':'m','sigma_s_per_m':1.2,'sigma_a_per_m':0.3,"
                   "'density':{'type':'layers','axis':[0,0,1],'period_m':0.2,'thickness_m':0.07,"
                   "'low':0.5,'high':3,'bounds_min_m':[-1,-1,-0.33],'bounds_max_m':[0.3,1,0.4]}}],"
                   "'translucents':[{'name':'o','mesh':'box','medium':'m'}]," SUN "}");
    enum { STEPS = 7300 }; /* of 0.1 mm from z = 0.4 down to -0.33: every face lies on a step */
    double expected = 0, depth = 0, step = 1e-4;
    for (int i = 0; i < STEPS; i++) {
        double z = 0.4 - (i + 0.5) * step, within = z / 0.2 - floor(z / 0.2);
        double density = within * 0.2 < 0.07 ? 3 : 0.5, sigma_t = 1.5 * density;
        expected +=
            1.2 * density / (4 * AL_PI) * exp(-depth - sigma_t * 0.2) * -expm1(-sigma_t * step) / sigma_t;
        depth += sigma_t * step;
    }
    check_ray(&scene, ray_along(0.1, 0.2, 5, 0, 0, -1), expected, 1e-6);
    check_ray(&scene, ray_along(0.4, 0.2, 5, 0, 0, -1), 0, 0); /* in the box, beyond the bounds */
    close_scene(&scene);
}

/* Red sees another depth than blue. */
static void test_chromatic(void)
{
    test_scene scene =
        open_scene("{'meshes':[{'name':'box','shape':{'type':'box','size_m':1}}],"
                   "'media':[{'name':'m','sigma_s_per_m':[0.1,1,20],'sigma_a_per_m':[0,0.1,0]}],"
                   "'translucents':[{'name':'o','mesh':'box','medium':'m'}]," SUN "}");
    const double sigma_s[3] = {0.1, 1, 20}, sigma_t[3] = {0.1, 1.1, 20};
    al_ray ray = ray_along(0.1, 0.2, 5, 0, 0, -1);
    for (int c = 0; c < 3; c++) {
        double error, value = estimate(&scene, &ray, 256, c, &error);
        double expected = (c + 1) * box_radiance(sigma_s[c], sigma_t[c], 0.4, 1);
        CHECK_NEAR(value, expected, sigmas * error + 1e-6 * expected);
        CHECK(error <= 0.01 * expected);
    }
    close_scene(&scene);
}

/* sigma_t times size from 1e-6 to 1e4, in boxes from 1e-4 m to 1e4 m, lit from where they are seen:
 * albedo / (8 pi) (1 - exp(-2 sigma_t length)). */
static void test_extremes(void)
{
    for (double thickness = 1e-6; thickness < 2e4; thickness *= 1e5)
        for (double size = 1e-4; size < 2e4; size *= 1e4) {
            test_scene scene =
                open_scene_of("{'meshes':[{'name':'box','shape':{'type':'box','size_m':%g}}],"
                              "'media':[{'name':'m','sigma_s_per_m':%.17g}],"
                              "'translucents':[{'name':'o','mesh':'box','medium':'m'}],"
                              "'lights':[{'type':'directional','direction':[0,0,-1],'irradiance_w_m2':1}]}",
                              size, thickness / size);
            al_ray ray = ray_along(0.1 * size, 0.2 * size, 100 * size, 0, 0, -1);
            double error, value = estimate(&scene, &ray, 64, 0, &error);
            double expected = -expm1(-2 * thickness) / (8 * AL_PI), bound = sigmas * error + 1e-5 * expected;
            if (size == 1)
                test_extreme(thickness < 1e-5 ? "sigma_t times size 1e-6" : thickness > 1e3 ? "sigma_t times size 1e4" : "sigma_t times size 1 to 100",
                             value, expected, bound, "reference: radiance of a box of sigma_t times size %g", thickness);
            else if (thickness < 1e3 && thickness > 1e-5)
                test_extreme(size < 1 ? "scene of 1e-4 m" : "scene of 1e4 m", value, expected, bound,
                             "reference: radiance of a box of sigma_t times size %g", thickness);
            else
                CHECK_NEAR(value, expected, bound);
            CHECK(error <= 0.01 * expected);
            close_scene(&scene);
        }
}

/* --- one voxel of a grid --- */

/* A box of 2 m, its grid 0.1 but for one voxel of `speck` in the middle: density rest + (speck - rest) w(x)
 * w(y) w(z), w(x) = max(1 - |x| / h, 0). Eye rays run along -z at x = 0.3 h, y = -0.2 h, where w is 0.7 and
 * 0.8. */
typedef struct speck {
    double rest, peak, voxel_m; /* peak: speck - rest */
} speck;

enum { SPECK_VOXELS = 21 };

static double tent(double x)
{
    return fmax(1 - fabs(x), 0);
}

/* Integral of the tent from x to infinity, |x| <= 1. */
static double tent_integral(double x)
{
    return x > 0 ? 0.5 * (1 - x) * (1 - x) : 1 - 0.5 * (1 + x) * (1 + x);
}

/* Light per metre of the eye ray at height z, the sun of irradiance 1 at +x. */
static double speck_source(const speck *s, double z)
{
    double h = s->voxel_m, density = s->rest + s->peak * 0.56 * tent(z / h);
    double to_eye = s->rest * (1 - z) + s->peak * 0.56 * h * tent_integral(fmin(fmax(z / h, -1), 1));
    double to_sun = s->rest * (1 - 0.3 * h) + s->peak * 0.8 * tent(z / h) * h * tent_integral(0.3);
    return density / (4 * AL_PI) * exp(-to_eye - to_sun);
}

/* Midpoints from `from` to `to`, drawn towards `from` by the fourth power: light dies out within h / (peak h)
 * of the tent's ends. */
static double speck_quadrature(const speck *s, double from, double to)
{
    enum { STEPS = 20000 };
    double sum = 0;
    for (int i = 0; i < STEPS; i++) {
        double v = (i + 0.5) / STEPS;
        sum += speck_source(s, from + (to - from) * v * v * v * v) * 4 * v * v * v * fabs(to - from) / STEPS;
    }
    return sum;
}

/* Along x at z = -0.5 m, y = 0.1 h, the sun at +z: rays that pass the speck are in its shadow. */
static double shadow_quadrature(const speck *s)
{
    enum { STEPS = 200000 };
    double sum = 0;
    for (int i = 0; i < STEPS; i++) {
        double x = 1 - 2 * (i + 0.5) / STEPS, through = s->peak * tent(x / s->voxel_m) * 0.9 * s->voxel_m;
        sum += exp(-s->rest * (1 - x + 1.5) - through);
    }
    return s->rest / (4 * AL_PI) * sum * 2 / STEPS;
}

/* A voxel of a million, and one of twenty, in a medium and in nothing. Cells of 0.05 of optical depth, taken
 * as constant, err by up to 1.6e-3 of the light; cells of 0.01 by 2e-4. */
static void test_speck(void)
{
    static const double rests[] = {0.1, 0}, specks[] = {20, 1e6};
    const double relative = 2e-3, h = 2.0 / SPECK_VOXELS;
    for (int i = 0; i < 4; i++) {
        speck s = {rests[i / 2], specks[i % 2] - rests[i / 2], h};
        char path[64];
        snprintf(path, sizeof path, "speck_of_test_%ld.vdb", (long)getpid());
        vdb_write_speck(path, SPECK_VOXELS, 2, (float)specks[i % 2], (float)s.rest);
        for (int side = 0; side < 3; side++) {
            static const char *const suns[] = {"0,0,-1", "-1,0,0", "0,0,-1"};
            test_scene scene = open_scene_of(
                "{'meshes':[{'name':'box','shape':{'type':'box','size_m':2}}],"
                "'media':[{'name':'m','sigma_s_per_m':1,'density':{'type':'grid','file':'%s'}}],"
                "'translucents':[{'name':'o','mesh':'box','medium':'m'}],"
                "'lights':[{'type':'directional','direction':[%s],'irradiance_w_m2':1}]}",
                path, suns[side]);
            al_ray ray =
                side == 2 ? ray_along(5, 0.1 * h, -0.5, -1, 0, 0) : ray_along(0.3 * h, -0.2 * h, 5, 0, 0, -1);
            double depth = 2 * s.rest + 0.56 * s.peak * h, expected;
            if (side == 0) /* light and eye lose the same */
                expected = -expm1(-2 * depth) / (8 * AL_PI);
            else if (side == 1)
                expected = speck_quadrature(&s, 1, h) + speck_quadrature(&s, h, 0) +
                           speck_quadrature(&s, -h, 0) + speck_quadrature(&s, -h, -1);
            else
                expected = shadow_quadrature(&s);
            double error, value = estimate(&scene, &ray, 256, 0, &error);
            if (specks[i % 2] > 20)
                test_extreme("one voxel of 1e6", value, expected, sigmas * error + relative * expected,
                             "reference: radiance %s, %g in all other voxels",
                             side == 0 ? "of the speck, lit from the eye" : side == 1 ? "of the speck, lit from the side" : "in its shadow", s.rest);
            else
                CHECK_NEAR(value, expected, sigmas * error + relative * expected);
            CHECK(error <= 0.01 / (8 * AL_PI)); /* of what an opaque thing sends back to its light */
            close_scene(&scene);
        }
        remove(path);
    }
}

/* --- lights --- */

/* Midpoint quadrature along (0.1, 0.2, 0.5) - z through a box of 1 m and sigma_t 2 per metre, from a lamp of
 * 1 W/sr on its boundary: all ways between them lie inside. */
static double lamp_quadrature(const double lamp[3])
{
    enum { STEPS = 100000 };
    double sum = 0;
    for (int i = 0; i < STEPS; i++) {
        double t = (i + 0.5) / STEPS, d[3] = {0.1 - lamp[0], 0.2 - lamp[1], 0.5 - t - lamp[2]};
        double square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        sum += exp(-2 * (t + sqrt(square))) / square / STEPS;
    }
    return 2 / (4 * AL_PI) * sum;
}

/* In the middle of a face, on an edge of two triangles, on an edge of the box, in a vertex. */
static void test_light_on_boundary(void)
{
    static const double lamps[][3] = {{0.5, 0.13, 0.21}, {0.5, 0, 0}, {-0.5, -0.5, 0.1}, {0.5, 0.5, 0.5}};
    for (int i = 0; i < 4; i++) {
        const double *l = lamps[i];
        test_scene scene =
            open_scene_of("{'meshes':[{'name':'box','shape':{'type':'box','size_m':1}}],"
                          "'media':[{'name':'m','sigma_s_per_m':2}],"
                          "'translucents':[{'name':'o','mesh':'box','medium':'m'}],"
                          "'lights':[{'type':'point','position_m':[%g,%g,%g],'intensity_w_sr':1}]}",
                          l[0], l[1], l[2]);
        al_ray ray = ray_along(0.1, 0.2, 5, 0, 0, -1);
        static const char *const where[] = {"in a face", "on an edge of two triangles", "on an edge of the box", "in a vertex"};
        double error, expected = lamp_quadrature(l), value = estimate(&scene, &ray, 64, 0, &error);
        test_extreme("light on a surface", value, expected, sigmas * error + 1e-5 * expected, "reference: radiance of a box, the lamp %s", where[i]);
        CHECK(error <= 0.01 * expected);
        close_scene(&scene);
    }
}

/* A sun of 1e6 from +x beside one of 1e-6 from +y: behind a wall the first adds nothing. */
static void test_strong_beside_weak(void)
{
    static const char *const wall =
        "{'name':'wall','shape':{'type':'box','size_m':[0.1,3,3]},'transform':{'translate_m':[2,0,0]}},";
    for (int walled = 0; walled < 2; walled++) {
        test_scene scene =
            open_scene_of("{'meshes':[%s{'name':'box','shape':{'type':'box','size_m':1}}],"
                          "'media':[{'name':'m','sigma_s_per_m':2}],"
                          "'translucents':[{'name':'o','mesh':'box','medium':'m'}],"
                          "'lights':[{'type':'directional','direction':[-1,0,0],'irradiance_w_m2':1e6},"
                          "{'type':'directional','direction':[0,-1,0],'irradiance_w_m2':1e-6}]}",
                          walled ? wall : "");
        al_ray ray = ray_along(0.1, 0.2, 5, 0, 0, -1);
        double error, value = estimate(&scene, &ray, 32, 0, &error), weak = 1e-6 * box_radiance(2, 2, 0.3, 1);
        double expected = weak + (walled ? 0 : 1e6 * box_radiance(2, 2, 0.4, 1));
        test_extreme(walled ? "radiosity 1e-6" : "radiosity 1e6", value, expected, sigmas * error + 1e-6 * expected,
                     "reference: radiance of a box under suns of 1e-6 and 1e6%s", walled ? ", the latter behind a wall" : "");
        close_scene(&scene);
    }
}

/* A light in the corner of the box's boundary, and none at all: finite, and black. */
static void test_lights(void)
{
    test_scene scene =
        open_scene("{'meshes':[{'name':'box','shape':{'type':'box','size_m':1}}],"
                   "'media':[{'name':'m','sigma_s_per_m':2}],"
                   "'translucents':[{'name':'o','mesh':'box','medium':'m'}],"
                   "'lights':[{'type':'point','position_m':[0.5,0.5,0.5],'intensity_w_sr':1}]}");
    al_ray rays[] = {ray_along(0.1, 0.2, 5, 0, 0, -1), ray_along(0.5, 0.5, 5, 0, 0, -1),
                     ray_along(3, 3, 3, -1, -1, -1)};
    for (int i = 0; i < 3; i++) {
        double error, value = estimate(&scene, &rays[i], 32, 0, &error);
        CHECK(isfinite(value) && value >= 0 && isfinite(error));
    }
    close_scene(&scene);
    scene = open_scene("{'meshes':[{'name':'box','shape':{'type':'box','size_m':1}}],"
                       "'media':[{'name':'m','sigma_s_per_m':2}],"
                       "'translucents':[{'name':'o','mesh':'box','medium':'m'}]}");
    check_ray(&scene, rays[0], 0, 0);
    close_scene(&scene);
}

/* Four times the samples: half the error or less (stratified strata do better). */
static void test_convergence(void)
{
    test_scene scene = open_scene(SPHERE("1", "'sigma_s_per_m':3",
                                         "'environment':{'radiance_w_m2_sr':1},'lights':[{'type':'point','"
                                         "position_m':[1.5,1,0],'intensity_w_sr':1}]"));
    al_ray ray = ray_along(0.3, 0.2, 7, 0, 0, -1);
    double error, finest, last = INFINITY, best = estimate(&scene, &ray, 4096, 0, &finest);
    for (uint32_t count = 4; count <= 1024; count *= 4) {
        double value = estimate(&scene, &ray, count, 0, &error);
        CHECK_NEAR(value, best, sigmas * hypot(error, finest));
        /* An error from 16 batches is itself known to 1/sqrt(30): two of them differ by up to 1.8 at 2.3
         * sigma. */
        CHECK(error < 0.5 * 1.8 * last);
        last = error;
    }
    CHECK(last < 0.01 * best);
    close_scene(&scene);
}

/* --- rays against boundaries --- */

static double chord(const al_line *line)
{
    double sum = 0;
    for (uint32_t i = 0; i < line->segment_count; i++)
        sum += line->segments[i].end_m - line->segments[i].begin_m;
    return sum;
}

/* Length of a ray within [-0.5, 0.5]^3, from its origin on. */
static double box_chord(const al_ray *ray)
{
    double first = 0, last = INFINITY;
    for (int k = 0; k < 3; k++) {
        if (ray->direction[k] == 0) {
            if (fabs(ray->origin[k]) > 0.5) return 0;
            continue;
        }
        double a = (-0.5 - ray->origin[k]) / ray->direction[k],
               b = (0.5 - ray->origin[k]) / ray->direction[k];
        first = fmax(first, fmin(a, b));
        last = fmin(last, fmax(a, b));
    }
    return fmax(0, last - first);
}

static void check_chord(const al_ray_scene *scene, al_line *line, al_ray ray, int *wrong)
{
    if (!al_ray_scene_segments(scene, &ray, INFINITY, line)) exit(1);
    /* Where a ray runs within 1e-6 of an edge, rounding to float decides whether it meets the box at all. */
    if (fabs(chord(line) - box_chord(&ray)) <= 3e-6) return;
    al_ray shifted = ray;
    for (int i = 0; i < 8; i++) {
        for (int k = 0; k < 3; k++) shifted.origin[k] = ray.origin[k] + (i >> k & 1 ? 1e-6 : -1e-6);
        if (fabs(chord(line) - box_chord(&shifted)) <= 1e-4) return;
    }
    (*wrong)++;
    fprintf(stderr, "chord %.9g, expected %.9g: from (%g, %g, %g) along (%g, %g, %g)\n", chord(line),
            box_chord(&ray), ray.origin[0], ray.origin[1], ray.origin[2], ray.direction[0], ray.direction[1],
            ray.direction[2]);
}

/* Through corners, edges and diagonals, from afar, from the faces and from within. */
static void test_chords(void)
{
    enum { RANDOM_RAYS = 50000 };
    test_scene scene = open_scene("{'meshes':[{'name':'box','shape':{'type':'box','size_m':1}}],"
                                  "'media':[{'name':'m','sigma_s_per_m':1}],"
                                  "'translucents':[{'name':'o','mesh':'box','medium':'m'}]}");
    al_ray_scene *rays;
    al_error error;
    al_line line = {0};
    int wrong = 0;
    CHECK(al_ray_scene_create(scene.import, AL_RAY_SCENE_ALL, &rays, &error) == AL_OK);
    for (int i = -6; i <= 6; i++)
        for (int k = -6; k <= 6; k++) {
            double x = 0.1 * i, y = 0.1 * k;
            check_chord(rays, &line, ray_along(x, y, 3, 0, 0, -1), &wrong);
            check_chord(rays, &line, ray_along(x, y, 0, 0, 0, -1), &wrong);
            check_chord(rays, &line, ray_along(2 + x, 2 + y, 2, -1, -1, -1), &wrong);
            check_chord(rays, &line, ray_along(x, y, 0.5, x, y, 1), &wrong);
            check_chord(rays, &line, ray_along(1e5 + x, y, 0.05, -1, 0, 0), &wrong);
        }
    al_random random = al_random_for(7, 7);
    for (int i = 0; i < RANDOM_RAYS; i++) {
        double to[3], from[3];
        for (int k = 0; k < 3; k++) {
            to[k] = 1.4 * al_random_real(&random) - 0.7;
            from[k] = (i % 2 ? 1 : 10) * (al_random_real(&random) - 0.5);
        }
        check_chord(rays, &line,
                    ray_along(from[0], from[1], from[2], to[0] - from[0], to[1] - from[1], to[2] - from[2]),
                    &wrong);
    }
    CHECK(wrong == 0);
    al_line_free(&line);
    al_ray_scene_free(rays);
    close_scene(&scene);
}

/* --- environment maps --- */

static void test_environment(void)
{
    enum { WIDTH = 8, HEIGHT = 5, COUNT = 200000 };
    float pixels[HEIGHT * WIDTH * 3];
    for (int i = 0; i < HEIGHT * WIDTH * 3; i++) pixels[i] = (float)(i * i % 17) / 4;
    for (int i = 0; i < 3; i++) pixels[i + 30] = 0;
    al_environment map = {.width = WIDTH, .height = HEIGHT, .pixels = pixels};
    al_environment_sampler sampler;
    al_error error;
    CHECK(al_environment_sampler_create(&map, &sampler, &error) == AL_OK);
    /* Directions: the middle of the map is -z, its right quarter +x, its first row +y (docs/scene.md). */
    double radiance[3], sum = 0, angle = 0, expected = 0;
    al_environment_density(&sampler, (double[]){0.05, 0.05, -0.9975}, radiance);
    CHECK(radiance[0] == pixels[(2 * WIDTH + 4) * 3]);
    al_environment_density(&sampler, (double[]){0.9975, 0, 0.05}, radiance);
    CHECK(radiance[0] == pixels[(2 * WIDTH + 6) * 3]);
    al_environment_density(&sampler, (double[]){0.001, 0.99995, -0.01}, radiance);
    CHECK(radiance[0] == pixels[(0 * WIDTH + 4) * 3]);
    al_environment_density(&sampler, (double[]){-0.001, -0.99995, 0.01}, radiance);
    CHECK(radiance[0] == pixels[(4 * WIDTH + 0) * 3]);
    /* The mean of radiance over density is the integral of radiance; that of 1 over density at most the
     * sphere, less the black pixels. Both estimates: standard deviation below 2 times the mean, so 1 % is
     * over two of them. */
    al_random random = al_random_for(3, 3);
    for (int i = 0; i < COUNT; i++) {
        double u[2] = {al_random_real(&random), al_random_real(&random)}, direction[3];
        al_environment_sample(&sampler, u, direction);
        double density = al_environment_density(&sampler, direction, radiance);
        sum += radiance[1] / density / COUNT;
        angle += 1 / density / COUNT;
        CHECK(density > 0);
    }
    double black = 0;
    for (int row = 0; row < HEIGHT; row++)
        for (int column = 0; column < WIDTH; column++) {
            const float *p = pixels + (row * WIDTH + column) * 3;
            double solid = (cos(AL_PI * row / HEIGHT) - cos(AL_PI * (row + 1) / HEIGHT)) * 2 * AL_PI / WIDTH;
            expected += p[1] * solid;
            if (p[0] + p[1] + p[2] == 0) black += solid;
        }
    CHECK_NEAR(sum, expected, 0.01 * expected);
    CHECK_NEAR(angle, 4 * AL_PI - black, 0.01 * 4 * AL_PI);
    al_environment_sampler_free(&sampler);

    memset(pixels, 0, sizeof pixels);
    CHECK(al_environment_sampler_create(&map, &sampler, &error) == AL_OK && sampler.map == NULL);
    al_environment_sampler_free(&sampler);
}

int main(void)
{
    test_chords();
    test_environment();
    test_sphere();
    test_point_light();
    test_even_sky();
    test_absorber_in_front();
    test_overlap();
    test_blockers();
    test_opaque();
    test_layers();
    test_chromatic();
    test_extremes();
    test_speck();
    test_light_on_boundary();
    test_strong_beside_weak();
    test_lights();
    test_convergence();
    return test_end();
}
