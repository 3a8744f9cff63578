/* Volume paths against closed forms. "Within noise" is 4.5 standard errors of 16 batches (t distribution of
 * 15 degrees: one in 2000); seeds are fixed. Every check also asks that its noise is small enough to mean
 * something. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdarg.h>
#include <string.h>

#include "../test.h"
#include "airlight/formulas.h"
#include "airlight/image.h"
#include "scene_for_test.h"

static const double sigmas = 4.5;

AL_PRINTF(2, 3)
static test_scene open_paths(al_mode_options limits, const char *format, ...)
{
    static char json[16384];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(json, sizeof json, format, arguments);
    va_end(arguments);
    return open_scene_for(&al_mode_volume_path, &limits, json);
}

static al_mode_options up_to(uint32_t events, uint32_t bounces)
{
    return (al_mode_options){.max_events = events, .max_bounces = bounces};
}

static al_mode_options exactly(uint32_t events)
{
    return (al_mode_options){.min_events = events, .max_events = events, .max_bounces = UINT32_MAX};
}

/* Radiance within noise of what is expected, and noise within `noise` of it. */
static void check_ray(const test_scene *scene, al_ray ray, uint32_t count, int channel, double expected,
                      double noise)
{
    double error, value = estimate(scene, &ray, count, channel, &error);
    CHECK_NEAR(value, expected, sigmas * error + 1e-6 * expected);
    CHECK(error <= noise * expected);
}

/* Value `index` that a receiver gets, in channel 0, as in `estimate`. */
static double receive(const test_scene *scene, const al_receiver *receiver, uint32_t count, int index,
                      double *error)
{
    enum { BATCHES = 16 };
    uint32_t dimensions = scene->mode->dimensions(scene->state);
    double *points = malloc(sizeof(double) * count * (dimensions + 1)), means[BATCHES], mean = 0, square = 0;
    for (uint32_t b = 0; b < BATCHES; b++) {
        al_random random = al_random_for(99, b);
        al_sample_hypercube(&random, count, dimensions, points);
        means[b] = 0;
        for (uint32_t i = 0; i < count; i++) {
            double out[AL_PROBE_COUNT][3];
            if (!scene->mode->receive(scene->state, scene->scratch, receiver, points + (size_t)i * dimensions,
                                      out))
                exit(1);
            means[b] += out[index][0] / count;
        }
        mean += means[b] / BATCHES;
    }
    for (uint32_t b = 0; b < BATCHES; b++) square += (means[b] - mean) * (means[b] - mean);
    *error = sqrt(square / (BATCHES * (BATCHES - 1)));
    free(points);
    return mean;
}

static void check_received(const test_scene *scene, al_receiver receiver, uint32_t count, int index,
                           double expected, double noise)
{
    double error, value = receive(scene, &receiver, count, index, &error);
    CHECK_NEAR(value, expected, sigmas * error + 1e-6 * fabs(expected));
    CHECK(error <= noise);
}

/* --- furnaces: radiance that is the same everywhere, whatever scatters --- */

#define FOG(name, rest, density) "{'name':'" name "'," rest ",'density':{" density "}}"

/* Walls that give off 1 and reflect 0.5 around lossless fog: 2 everywhere. */
static void test_furnace(void)
{
    static const char *const media[] = {
        "",
        "'media':[" FOG("a", "'sigma_s_per_m':0.5", "'type':'constant'") "],'fogs':['a'],",
        "'media':[" FOG(
            "a", "'sigma_s_per_m':5,'g':0.7",
            "'type':'constant','bounds_min_m':[-3,-0.4,-3],'bounds_max_m':[3,0.3,0.6]") "],'fogs':['a'],",
        "'media':[" FOG("a", "'sigma_s_per_m':[0.2,1,4],'g':-0.5", "'type':'constant'") "," FOG(
            "b", "'sigma_s_per_m':[2,1,0]",
            "'type':'layers','period_m':0.3,'thickness_m':0.1,'low':0.3,'high':2,"
            "'bounds_min_m':[-2,-2,-2],'bounds_max_m':[0.4,2,2]") "],'fogs':['a','b'],",
        "'media':[" FOG("a", "'sigma_s_per_m':1",
                        "'type':'constant'") "],'fogs':[],"
                                             "'translucents':[{'name':'o','mesh':'ball','medium':'a'}],",
    };
    for (size_t i = 0; i < sizeof media / sizeof *media; i++) {
        test_scene scene = open_paths(
            al_mode_defaults,
            "{%s'materials':[{'name':'glow','base_color':0.5,'emission_w_m2_sr':1,'double_sided':true}],"
            "'meshes':[{'name':'box','shape':{'type':'box','size_m':2},'material':'glow'}%s]}",
            media[i], i == 4 ? ",{'name':'ball','shape':{'type':'sphere','subdivisions':3}}" : "");
        for (int c = 0; c < 3; c++)
            check_ray(&scene, ray_along(0.3, 0.1, 0.9, -0.2, 0.1, -1), 1000, c, 2, 0.02);
        check_received(&scene, (al_receiver){{0.2, -1, 0.1}, {0, 1, 0}}, 1000, 0, 2 * AL_PI,
                       0.02 * 2 * AL_PI);
        check_received(&scene, (al_receiver){{0.2, 0.1, -0.3}, {0, 0, 0}}, 1000, 0, 2 * sqrt(4 * AL_PI),
                       0.14);
        check_received(&scene, (al_receiver){{0.2, 0.1, -0.3}, {0, 0, 0}}, 1000, 7, 0, 0.2);
        close_scene(&scene);
    }
}

/* Lossless fog and white surfaces under an even sky are as bright as the sky. */
static void test_even_sky(void)
{
    static const double asymmetries[] = {0, 0.9, -0.6, 1e-5};
    for (int i = 0; i < 4; i++) {
        test_scene scene = open_paths(
            al_mode_defaults,
            "{'environment':{'radiance_w_m2_sr':[1,2,3]},'materials':[{'name':'white','base_color':1}],"
            "'meshes':[{'name':'b','shape':{'type':'sphere','subdivisions':2},'material':'white'}],"
            "'media':[" FOG(
                "a", "'sigma_s_per_m':2,'g':%g",
                "'type':'constant','bounds_min_m':[-1,-1,-1],'bounds_max_m':[1,1,1]") "],'fogs':['a']}",
            asymmetries[i]);
        for (int c = 0; c < 3; c++) check_ray(&scene, ray_along(0.3, 0.1, 4, 0, 0, -1), 1000, c, c + 1, 0.04);
        close_scene(&scene);
    }
}

/* --- attenuation: what is closed form must have no noise at all --- */

static void test_attenuation(void)
{
    test_scene scene = open_paths(
        al_mode_defaults,
        "{'materials':[{'name':'glow','base_color':0,'emission_w_m2_sr':[1,2,3]}],"
        "'meshes':[{'name':'p','shape':{'type':'plane','width_m':10,'depth_m':10},'"
        "material':'glow'}],"
        "'media':[" FOG(
            "a", "'sigma_s_per_m':0,'sigma_a_per_m':[0.5,1,0]",
            "'type':'constant','scale':2,'bounds_min_m':[-1,0.5,-1],'bounds_max_m':[1,1.5,"
            "1]") "," FOG("b", "'sigma_s_per_m':0,'sigma_a_per_m':1",
                          "'type':'layers','period_m':1,'thickness_m':0.25,'low':0,'high':"
                          "3,"
                          "'bounds_min_m':[-2,-2,-2],'bounds_max_m':[2,2,2]") "],'fogs':['a','b']}");
    /* Through 1 m of a; of b the layers at [0, 0.25] and [1, 1.25]. */
    double expected[] = {exp(-1 - 1.5), 2 * exp(-2 - 1.5), 3 * exp(-1.5)}, error;
    al_ray down = ray_along(0.2, 9, 0.3, 0, -1, 0), up = ray_along(0.2, -9, 0.3, 0, 1, 0);
    for (int c = 0; c < 3; c++) {
        CHECK_NEAR(estimate(&scene, &down, 4, c, &error), expected[c], 1e-6 * expected[c]);
        CHECK(error < 1e-12);
        CHECK(estimate(&scene, &up, 4, c, &error) == 0); /* the back does not shine */
    }
    close_scene(&scene);
    /* The same extinction by scattering: path without events. */
    scene = open_paths(
        up_to(0, UINT32_MAX),
        "{'materials':[{'name':'glow','base_color':0,'emission_w_m2_sr':[1,2,3]}],"
        "'meshes':[{'name':'p','shape':{'type':'plane','width_m':10,'depth_m':10},'material':'glow'}],"
        "'media':[" FOG(
            "a", "'sigma_s_per_m':[0.5,1,0]",
            "'type':'constant','scale':2,'bounds_min_m':[-1,0.5,-1],'bounds_max_m':[1,1.5,1]") "],'fogs':['a'"
                                                                                               "]}");
    CHECK_NEAR(estimate(&scene, &down, 4, 1, &error), 2 * exp(-2), 1e-6);
    CHECK(error < 1e-12);
    close_scene(&scene);
}

/* --- surfaces --- */

/* A Lambert plane in the sun: albedo E cos / pi, from both sides; metals are dark. */
static void test_lambert(void)
{
    test_scene scene =
        open_paths(al_mode_defaults,
                   "{'lights':[{'type':'directional','direction':[0,-0.8,0.6],'irradiance_w_m2':[1,2,3]}],"
                   "'materials':[{'name':'m','base_color':[0.2,0.4,0.6],'metallic':0.25}],"
                   "'meshes':[{'name':'p','shape':{'type':'plane'},'material':'m'}]}");
    al_ray above = ray_along(0.1, 1, 0.1, 0.1, -1, 0), below = ray_along(0.1, -1, 0.1, 0.1, 1, 0);
    double error;
    for (int c = 0; c < 3; c++)
        CHECK_NEAR(estimate(&scene, &above, 2, c, &error), 0.75 * 0.2 * (c + 1) * (c + 1) * 0.8 / AL_PI,
                   1e-7);
    CHECK(estimate(&scene, &below, 2, 0, &error) == 0);
    close_scene(&scene);
}

/* Irradiance of a parallel rectangle's corner (form factor to a point; Howell, configuration B-4), straight
 * and through a gap-free black sheet; and of one bounce less. */
static void test_rectangle(void)
{
    static const char lamp[] =
        "{'materials':[{'name':'glow','base_color':0,'emission_w_m2_sr':5}],"
        "'meshes':[{'name':'p','shape':{'type':'plane','width_m':1,'depth_m':1},'material':'glow',"
        "'transform':{'rotate_degrees':[180,0,0],'translate_m':[0.5,1,0.5]}}%s]}";
    double x = 1 / sqrt(2), factor = 2 * x * atan(x) / (2 * AL_PI);
    test_scene scene = open_paths(al_mode_defaults, lamp, "");
    check_received(&scene, (al_receiver){{0, 0, 0}, {0, 1, 0}}, 2000, 0, 5 * AL_PI * factor, 0.01);
    check_received(&scene, (al_receiver){{0, 0, 0}, {0, -1, 0}}, 16, 0, 0, 0);
    close_scene(&scene);
    scene = open_paths(al_mode_defaults, lamp,
                       ",{'name':'s','shape':{'type':'plane','width_m':3,'depth_m':3},'transform':{'"
                       "translate_m':[0,0.5,0]}}");
    check_received(&scene, (al_receiver){{0, 0, 0}, {0, 1, 0}}, 200, 0, 0, 0);
    close_scene(&scene);
}

/* --- a point light in fog --- */

/* Midpoint quadrature, over angles seen from the light, of sigma_s p exp(-sigma_t (t + r)) I / r^2 along -z.
 */
static double airlight(double sigma_s, double sigma_t, double g, const double light[3], double length)
{
    enum { STEPS = 20000 };
    double height = hypot(light[0], light[1]), foot = -light[2], first = atan2(-foot, height),
           last = atan2(length - foot, height), sum = 0;
    for (int i = 0; i < STEPS; i++) {
        double angle = first + (last - first) * (i + 0.5) / STEPS, t = foot + height * tan(angle);
        double r = height / cos(angle), cosine = (foot - t) / r;
        sum += sigma_s * al_phase(g, cosine) * exp(-sigma_t * (t + r)) / height * (last - first) / STEPS;
    }
    return sum;
}

/* One event, near the light and far, thin fog and thick, against the quadrature. */
static void test_airlight(void)
{
    static const struct {
        double light[3], sigma_s, sigma_a, g;
    } cases[] = {{{0.3, 0.2, -1}, 0.5, 0.1, 0},
                 {{0.003, 0, -1}, 0.5, 0, 0.6},
                 {{0.5, 0, -0.2}, 20, 5, -0.4},
                 {{2, 0, 1}, 1e-3, 0, 0}};
    for (int i = 0; i < 4; i++) {
        const double *l = cases[i].light, sigma_t = cases[i].sigma_s + cases[i].sigma_a;
        test_scene scene =
            open_paths(exactly(1),
                       "{'lights':[{'type':'point','position_m':[%g,%g,%g],'intensity_w_sr':[1,0,2]}],"
                       "'materials':[{'name':'black','base_color':0}],'meshes':[{'name':'far','shape':{'type'"
                       ":'plane','width_m':90,'depth_m':90},"
                       "'material':'black','transform':{'rotate_degrees':[90,0,0],'translate_m':[0,0,-4]}}],"
                       "'media':[" FOG("a", "'sigma_s_per_m':%g,'sigma_a_per_m':%g,'g':%g",
                                       "'type':'constant'") "],'fogs':['a']}",
                       l[0], l[1], l[2], cases[i].sigma_s, cases[i].sigma_a, cases[i].g);
        check_ray(&scene, ray_along(0, 0, 0, 0, 0, -1), 2000, 0,
                  airlight(cases[i].sigma_s, sigma_t, cases[i].g, l, 4), 0.01);
        close_scene(&scene);
    }
}

/* Fluence by number of events about a point light of 1 W/sr in endless fog, sigma_s = sigma_t = 1: values of
 * an independent Fourier inversion, good to 1e-6. */
static void test_orders(void)
{
    static const struct {
        double distance;
        uint32_t events;
        double fluence;
    } rows[] = {
#include "fluence_rows.inc"
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        test_scene scene =
            open_paths(exactly(rows[i].events),
                       "{'lights':[{'type':'point','position_m':[0,0,0],'intensity_w_sr':1}],"
                       "'media':[" FOG("a", "'sigma_s_per_m':1", "'type':'constant'") "],'fogs':['a']}");
        double d = rows[i].distance;
        check_received(&scene, (al_receiver){{0.48 * d, 0.6 * d, 0.64 * d}, {0, 0, 0}}, 4000, 0,
                       rows[i].fluence / sqrt(4 * AL_PI), 0.03 * rows[i].fluence);
        close_scene(&scene);
    }
}

/* One event is what single-scatter makes of it: in a translucent ball with fog around it, of a sun, a lamp, a
 * sky, a lit panel and a sheet that gives off light to both sides. */
static void test_object(void)
{
    static const char scene[] =
        "{'materials':[{'name':'glow','base_color':0,'emission_w_m2_sr':[2,1,3]},"
        "{'name':'lit','base_color':0,'emission_w_m2_sr':1,'double_sided':true}],"
        "'meshes':[{'name':'ball','shape':{'type':'sphere','subdivisions':4}},"
        "{'name':'rod','shape':{'type':'box','size_m':[0.1,2,0.1]},'transform':{'translate_m':[0.4,0,0.6]}},"
        "{'name':'panel','shape':{'type':'plane','width_m':0.6,'depth_m':0.4},'material':'glow',"
        "'transform':{'translate_m':[0.1,-0.7,0.3]}},"
        "{'name':'sheet','shape':{'type':'plane','width_m':0.4,'depth_m':0.5},'material':'lit',"
        "'transform':{'rotate_degrees':[0,0,80],'translate_m':[-0.7,0.1,0.2]}}],"
        "'media':[" FOG(
            "m", "'sigma_s_per_m':[1,3,5],'sigma_a_per_m':0.5,'g':0.3",
            "'type':'layers','period_m':0.2,'thickness_m':0.1,'high':2,'low':0.5") "," FOG("a",
                                                                                           "'sigma_s_per_m':["
                                                                                           "0.3,0.2,0.4],'g':"
                                                                                           "-0.4",
                                                                                           "'type':'constant'"
                                                                                           ",'bounds_min_m':["
                                                                                           "-2,-2,-1.5],'"
                                                                                           "bounds_max_m':[2,"
                                                                                           "2,1.5]") "],"
                                                                                                     "'transl"
                                                                                                     "ucents'"
                                                                                                     ":[{'"
                                                                                                     "name':'"
                                                                                                     "o','"
                                                                                                     "mesh':'"
                                                                                                     "ball','"
                                                                                                     "medium'"
                                                                                                     ":'m'}],"
                                                                                                     "'fogs':"
                                                                                                     "['a'],"
                                                                                                     "'enviro"
                                                                                                     "nment':"
                                                                                                     "{'"
                                                                                                     "radianc"
                                                                                                     "e_w_m2_"
                                                                                                     "sr':[0."
                                                                                                     "2,0.3,"
                                                                                                     "0.1]},"
                                                                                                     "'lights"
                                                                                                     "':[{'"
                                                                                                     "type':'"
                                                                                                     "directi"
                                                                                                     "onal','"
                                                                                                     "directi"
                                                                                                     "on':[-"
                                                                                                     "0.6,0,-"
                                                                                                     "0.8],'"
                                                                                                     "irradia"
                                                                                                     "nce_w_"
                                                                                                     "m2':2},"
                                                                                                     "{'type'"
                                                                                                     ":'"
                                                                                                     "point',"
                                                                                                     "'positi"
                                                                                                     "on_m':["
                                                                                                     "0.2,0."
                                                                                                     "9,0.1],"
                                                                                                     "'intens"
                                                                                                     "ity_w_"
                                                                                                     "sr':1}]"
                                                                                                     "}";
    test_scene paths = open_paths((al_mode_options){.min_events = 1, .max_events = 1}, scene),
               single = open_scene(scene);
    al_ray rays[] = {ray_along(0.1, 0.1, 3, 0, 0, -1), ray_along(-0.3, 0.2, 3, 0, 0, -1)};
    for (int i = 0; i < 2; i++)
        for (int c = 0; c < 3; c++) {
            double noise[2], value = estimate(&paths, &rays[i], 4000, c, &noise[0]);
            double expected = estimate(&single, &rays[i], 400, c, &noise[1]);
            CHECK_NEAR(value, expected, sigmas * hypot(noise[0], noise[1]));
            CHECK(noise[0] <= 0.03 * expected && noise[1] <= 0.02 * expected);
        }
    close_scene(&paths);
    close_scene(&single);
}

/* --- structured surroundings, many lamps --- */

/* Direction of a place on a map, docs/scene.md. */
static void map_direction(double u, double v, double direction[3])
{
    double theta = AL_PI * v, phi = 2 * AL_PI * (u - 0.5);
    direction[0] = sin(theta) * sin(phi);
    direction[1] = cos(theta);
    direction[2] = -sin(theta) * cos(phi);
}

/* A map that brightens from the ground up and around, with one pixel of 300: on a tilted receiver in the
 * middle of a cube of absorbing fog of 2 m, against the sum over 48 x 48 places a pixel (edges of the
 * hemisphere and of the cube's faces cross a few of them: 1e-3). A ray through it is exact. */
static void test_map(void)
{
    enum { WIDTH = 16, HEIGHT = 8, FINE = 48 };
    static const double sigmas_a[] = {0, 0.75};
    static const char path[] = "sky_of_volume_test.exr";
    static float pixels[WIDTH * HEIGHT * 3];
    const double normal[3] = {0.48, 0.8, -0.36};
    al_error error = {0};
    for (int i = 0; i < WIDTH * HEIGHT * 3; i++)
        pixels[i] = 0.25f * (float)(HEIGHT - i / 3 / WIDTH) + 0.125f * (float)(i / 3 % WIDTH);
    for (int c = 0; c < 3; c++) pixels[(2 * WIDTH + 11) * 3 + c] = 300;
    CHECK(al_image_write_exr(path,
                             &(al_image){.width = WIDTH, .height = HEIGHT, .channels = 3, .pixels = pixels},
                             &error) == AL_OK);
    for (int i = 0; i < 2; i++) {
        double sum = 0, exact, direction[3];
        for (int v = 0; v < HEIGHT * FINE; v++)
            for (int u = 0; u < WIDTH * FINE; u++) {
                double solid = sin(AL_PI * (v + 0.5) / (HEIGHT * FINE)) * 2 * AL_PI * AL_PI /
                               (WIDTH * FINE * (double)HEIGHT * FINE);
                map_direction((u + 0.5) / (WIDTH * FINE), (v + 0.5) / (HEIGHT * FINE), direction);
                double cosine = 0, largest = 0;
                for (int k = 0; k < 3; k++) {
                    cosine += normal[k] * direction[k];
                    largest = fmax(largest, fabs(direction[k]));
                }
                sum += solid * fmax(0, cosine) * exp(-sigmas_a[i] / largest) *
                       (double)pixels[(v / FINE * WIDTH + u / FINE) * 3];
            }
        test_scene scene = open_paths(
            al_mode_defaults,
            "{'environment':{'file':'%s'},'media':[" FOG(
                "a", "'sigma_s_per_m':0,'sigma_a_per_m':0.75",
                "'type':'constant','bounds_min_m':[-1,-1,-1],'bounds_max_m':[1,1,1]") "],'fogs':[%s]}",
            path, i ? "'a'" : "");
        double noise,
            value = receive(&scene, &(al_receiver){{0, 0, 0}, {0.48, 0.8, -0.36}}, 16384, 0, &noise);
        CHECK_NEAR(value, sum, sigmas * noise + 1e-3 * sum);
        CHECK(noise < 0.01 * sum);
        map_direction(11.5 / WIDTH, 2.5 / HEIGHT, direction);
        al_ray ray = ray_along(0, 0, 0, direction[0], direction[1], direction[2]);
        double largest = fmax(fmax(fabs(direction[0]), fabs(direction[1])), fabs(direction[2]));
        exact = estimate(&scene, &ray, 2, 0, &noise);
        CHECK_NEAR(exact, 300 * exp(-sigmas_a[i] / largest), 1e-4);
        CHECK(noise < 1e-9);
        close_scene(&scene);
    }
    remove(path);
}

static const char lamps_over_floor[] =
    "{'materials':[{'name':'black','base_color':0}],'meshes':[{'name':'floor','shape':{'type':'plane'},"
    "'material':'black'}],'lights':[%s],'media':[%s],'fogs':[%s]}";

/* 64 lamps over a black floor in absorbing fog: the sum of I cos exp(-sigma d) / d^2. */
static void test_many_lamps(void)
{
    static char lamps[8192];
    double expected = 0;
    int used = 0;
    for (int i = 0; i < 64; i++) {
        double x = i % 8 * 0.25 - 0.7, z = i / 8 * 0.2 - 0.3, square = x * x + z * z + 1, d = sqrt(square);
        used += snprintf(lamps + used, sizeof lamps - (size_t)used,
                         "%s{'type':'point','position_m':[%.9g,1,%.9g],'intensity_w_sr':%.9g}", i ? "," : "",
                         x, z, 1.0 + i % 5);
        expected += (1.0 + i % 5) * exp(-0.5 * d) / (square * d);
    }
    test_scene scene =
        open_paths(al_mode_defaults, lamps_over_floor, lamps,
                   FOG("a", "'sigma_s_per_m':0,'sigma_a_per_m':0.5", "'type':'constant'"), "'a'");
    check_received(&scene, (al_receiver){{0, 0, 0}, {0, 1, 0}}, 16384, 0, expected, 0.01 * expected);
    close_scene(&scene);
}

/* A lamp on a surface is in front of it, seen from either side: I cos / d^2. Receivers begin 2e-6 of the
 * scene off. */
static void test_lamp_on_surface(void)
{
    test_scene scene = open_paths(al_mode_defaults, lamps_over_floor,
                                  "{'type':'point','position_m':[0.25,0,0.125],'intensity_w_sr':2}", "", "");
    double noise;
    for (int side = -1; side <= 1; side += 2) {
        const al_receiver receiver = {{0.25, 0.5 * side, 0.125}, {0, -side, 0}};
        CHECK_NEAR(receive(&scene, &receiver, 16, 0, &noise), 2 / 0.25, 1e-4);
        CHECK(noise < 1e-12);
    }
    close_scene(&scene);
}

int main(void)
{
    test_furnace();
    test_even_sky();
    test_attenuation();
    test_lambert();
    test_rectangle();
    test_airlight();
    test_orders();
    test_object();
    test_map();
    test_many_lamps();
    test_lamp_on_surface();
    return test_end();
}
