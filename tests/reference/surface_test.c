/* Light from surfaces into media against quadrature and against volume paths. "Within noise" is 4.5 standard
 * errors of 16 batches (t distribution of 15 degrees: one in 2000); seeds are fixed. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdarg.h>

#include "../test.h"
#include "airlight/formulas.h"
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

/* --- a rectangle in fog, under a black plate that hides part of it from the lamp and from the eye's ray ---
 */

static const double half_width = 0.5, half_depth = 0.4, plate_y = 0.12, plate_x[2] = {0.05, 0.25},
                    albedo[3] = {0.2, 0.5, 0.8}, sigma_s[3] = {0.5, 1, 2}, sigma_a = 0.3;
static const double lamp_position[3] = {0.2, 0.4, 0.1}, sun_direction[3] = {0.3, -1, 0.2};

typedef struct rectangle_case {
    bool has_sun, has_plate; /* else a lamp of 2 W/sr; the sun's irradiance is 3 */
    double half_box_m;       /* of the fog; INFINITY: endless */
    double g;
    bool no_visibility, no_attenuation;
} rectangle_case;

static const al_ray rectangle_eye = {{-1, 0.25, 0.3},
                                     {0.9759000729485332, 0.09759000729485333, -0.19518001458970666}};

/* All lengths times `scale`, coefficients divided by it, the lamp's power times scale^2 and `power`. */
static test_scene open_scaled_rectangle(const rectangle_case *from, double scale, double power)
{
    char bounds[192] = "", lamp[192], plate[256] = "";
    double b = from->half_box_m * scale;
    if (b < INFINITY)
        snprintf(bounds, sizeof bounds, ",'bounds_min_m':[%g,%g,%g],'bounds_max_m':[%g,%g,%g]", -b, -b, -b, b,
                 b, b);
    if (from->has_sun)
        snprintf(lamp, sizeof lamp, "{'type':'directional','direction':[0.3,-1,0.2],'irradiance_w_m2':%g}",
                 3 * power);
    else
        snprintf(lamp, sizeof lamp, "{'type':'point','position_m':[%g,%g,%g],'intensity_w_sr':%g}",
                 0.2 * scale, 0.4 * scale, 0.1 * scale, 2 * scale * scale * power);
    if (from->has_plate)
        snprintf(plate, sizeof plate,
                 ",{'name':'plate','shape':{'type':'plane','width_m':%g,'depth_m':%g},'material':'black',"
                 "'transform':{'translate_m':[%g,%g,0]}}",
                 0.2 * scale, 2 * scale, 0.15 * scale, 0.12 * scale);
    al_mode_options options = al_mode_defaults;
    options.no_visibility = from->no_visibility;
    options.no_attenuation = from->no_attenuation;
    return open_mode(&al_mode_surface_to_volume, options,
                     "{'materials':[{'name':'black','base_color':0},{'name':'m','base_color':[0.2,0.5,0.8]}],"
                     "'meshes':[{'name':'r','shape':{'type':'plane','width_m':%g,'depth_m':%g},'material':"
                     "'m'}%s],'lights':[%s],'media':[{'name':'a','sigma_s_per_m':[%g,%g,%g],'sigma_a_per_m':"
                     "%g,'g':%g,'density':{'type':'constant'%s}}],'fogs':['a']}",
                     scale, 0.8 * scale, plate, lamp, 0.5 / scale, 1 / scale, 2 / scale, 0.3 / scale, from->g,
                     bounds);
}

static test_scene open_rectangle(const rectangle_case *from)
{
    return open_scaled_rectangle(from, 1, 1);
}

/* Whether the plate lies between a point of the rectangle and a place above it. */
static bool plate_hides(const double y[3], const double above[3])
{
    double share = (plate_y - y[1]) / (above[1] - y[1]), x = y[0] + share * (above[0] - y[0]);
    return share < 1 && x > plate_x[0] && x < plate_x[1];
}

/* Within the box; from a point inside, along a unit direction. */
static double length_in_fog(const double from[3], const double direction[3], double half_box_m)
{
    double end = INFINITY;
    for (int k = 0; k < 3; k++)
        if (direction[k] != 0 && half_box_m < INFINITY)
            end = fmin(end, (copysign(half_box_m, direction[k]) - from[k]) / direction[k]);
    return end;
}

/* Irradiance of a point of the rectangle, of the lamp or the sun, and how much fog is on the way. */
static double irradiance_at(const rectangle_case *from, const double y[3], double *way_m)
{
    double towards[3], above[3], length = 0;
    for (int k = 0; k < 3; k++) {
        towards[k] = from->has_sun ? -sun_direction[k] : lamp_position[k] - y[k];
        above[k] = y[k] + towards[k];
        length += towards[k] * towards[k];
    }
    length = sqrt(length);
    for (int k = 0; k < 3; k++) towards[k] /= length;
    if (from->has_plate && plate_hides(y, above)) return 0;
    *way_m = from->has_sun ? length_in_fog(y, towards, from->half_box_m) : length;
    return from->has_sun ? 3 * towards[1] : 2 * towards[1] / (length * length);
}

/* What the rectangle sends to a place, scattered into the eye's ray, of one channel; without the eye's leg.
 * Steps in x are many, for the edges of shadows, in z few. */
static double scattered_at(const rectangle_case *from, const double x[3], int channel, int steps)
{
    int nx = 4 * steps, nz = steps / 16;
    double sum = 0, sigma_t = sigma_s[channel] + sigma_a;
    for (int i = 0; i < nx * nz; i++) {
        double y[3] = {half_width * (2 * (i % nx + 0.5) / nx - 1), 0,
                       half_depth * (2 * (i / nx + 0.5) / nz - 1)};
        double way_m = 0, arrives = irradiance_at(from, y, &way_m), to[3], square = 0, turn = 0;
        if (!(arrives > 0) || (from->has_plate && !from->no_visibility && plate_hides(y, x))) continue;
        for (int k = 0; k < 3; k++) {
            to[k] = x[k] - y[k];
            square += to[k] * to[k];
            turn -= to[k] * rectangle_eye.direction[k];
        }
        double length = sqrt(square), legs_m = way_m + (from->no_attenuation ? 0 : length);
        sum += arrives * albedo[channel] / AL_PI * to[1] / (length * square) * exp(-sigma_t * legs_m) *
               sigma_s[channel] * al_phase(from->g, turn / length);
    }
    return sum * 4 * half_width * half_depth / (nx * nz);
}

/* Midpoints in area and in angle seen from the rectangle's middle. */
static double rectangle_quadrature(const rectangle_case *from, int channel, int steps)
{
    const al_ray *eye = &rectangle_eye;
    double foot = 0, height = 0, sum = 0;
    for (int k = 0; k < 3; k++) {
        foot -= eye->origin[k] * eye->direction[k];
        height += eye->origin[k] * eye->origin[k];
    }
    height = sqrt(height - foot * foot);
    double end_m = length_in_fog(eye->origin, eye->direction, from->half_box_m), first = atan2(-foot, height),
           last = end_m < INFINITY ? atan2(end_m - foot, height) : AL_PI / 2;
    for (int i = 0; i < steps; i++) {
        double angle = first + (last - first) * (i + 0.5) / steps, t = foot + height * tan(angle), x[3];
        for (int k = 0; k < 3; k++) x[k] = eye->origin[k] + t * eye->direction[k];
        sum += scattered_at(from, x, channel, steps) * exp(-(sigma_s[channel] + sigma_a) * t) * height /
               (cos(angle) * cos(angle));
    }
    return sum * (last - first) / steps;
}

/* Lamp and sun, with plate and without, with each of the second leg's parts left out. The quadrature with
 * half as many steps differs from it by less than its part of the bound. */
static void test_rectangle(void)
{
    static const double step_error = 0.008;
    static const rectangle_case cases[] = {
        {false, false, INFINITY, 0.4, false, false}, {true, false, 2, 0, false, false},
        {false, false, INFINITY, 0.4, false, true},  {false, true, INFINITY, -0.5, false, false},
        {true, true, 2, 0.3, false, false},          {true, true, 2, 0.3, true, false},
        {true, true, 2, 0.3, false, true},           {true, true, 2, 0.3, true, true},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        test_scene scene = open_rectangle(&cases[i]);
        for (int c = 0; c < 3; c += 2) {
            double error, value = estimate(&scene, &rectangle_eye, 400, c, &error);
            double expected = rectangle_quadrature(&cases[i], c, 192);
            CHECK_NEAR(rectangle_quadrature(&cases[i], c, 96), expected, step_error * expected);
            CHECK_NEAR(value, expected, sigmas * error + step_error * expected);
            CHECK(error <= 0.01 * expected);
        }
        close_scene(&scene);
    }
}

/* From the same random numbers, in fog of closed form, a path without attenuation or without visibility
 * never carries less: sample by sample, no noise. */
static void test_monotone(void)
{
    enum { SAMPLES = 1000 };
    rectangle_case from = {true, true, 2, 0.3, false, false};
    test_scene scenes[4];
    double sums[4] = {0};
    int wrong = 0;
    for (int i = 0; i < 4; i++) {
        from.no_visibility = i & 1;
        from.no_attenuation = i & 2;
        scenes[i] = open_rectangle(&from);
    }
    al_random random = al_random_for(7, 0);
    for (int n = 0; n < SAMPLES; n++) {
        double numbers[64], value[4][3];
        for (uint32_t d = 0; d < scenes[0].mode->dimensions(scenes[0].state); d++)
            numbers[d] = al_random_real(&random);
        for (int i = 0; i < 4; i++) {
            CHECK(scenes[i].mode->radiance(scenes[i].state, scenes[i].scratch, &rectangle_eye, numbers,
                                           value[i]));
            sums[i] += value[i][1];
        }
        for (int c = 0; c < 3; c++)
            wrong += value[1][c] < value[0][c] || value[2][c] < value[0][c] || value[3][c] < value[1][c] ||
                     value[3][c] < value[2][c];
    }
    CHECK(wrong == 0);
    CHECK(sums[0] > 0 && sums[1] > sums[0] && sums[2] > sums[0] && sums[3] > sums[1] && sums[3] > sums[2]);
    for (int i = 0; i < 4; i++) close_scene(&scenes[i]);
}

/* A scene of 1e-4 m and one of 1e4 m, lamps and suns of 1e-6 and 1e6: from the same random numbers the same
 * radiance, but for what the rounding of vertices to single precision moves across a shadow's edge. */
static void test_scaling(void)
{
    for (int i = 0; i < 2; i++) {
        rectangle_case from = {i, true, i ? 2 : INFINITY, 0.3, false, false};
        test_scene base = open_rectangle(&from);
        double error, expected = estimate(&base, &rectangle_eye, 50, 1, &error);
        CHECK(expected > 0);
        close_scene(&base);
        for (int k = 0; k < 2; k++) {
            double scale = k ? 1e4 : 1e-4, power = k ? 1e-6 : 1e6;
            test_scene scene = open_scaled_rectangle(&from, scale, power);
            al_ray eye = rectangle_eye;
            for (int c = 0; c < 3; c++) eye.origin[c] *= scale;
            CHECK_NEAR(estimate(&scene, &eye, 50, 1, &error), power * expected, 2e-3 * power * expected);
            close_scene(&scene);
        }
    }
}

/* Optical depths of 1e-6 and 1e4, lobes of |g| = 0.99, an eye inside a ball and a lamp on the floor, a mirror
 * and a matt metal, a sun of 1e6: finite and never negative, in every mode of one bounce or less. */
static void test_extremes(void)
{
    enum { SAMPLES = 40 };
    static const al_mode *const modes[] = {&al_mode_surface_to_volume, &al_mode_indirect,
                                           &al_mode_single_scatter, &al_mode_ambient_occlusion};
    static const double sigmas_per_m[] = {1e-6, 1e4}, lobes[] = {0.99, -0.99};
    const al_ray rays[] = {ray_along(1, 0.5, 1, -1, -0.3, -1), ray_along(0, 0.4, 1e-4, 0.1, -0.2, -1)};
    for (int i = 0; i < 16; i++) {
        test_scene scene = open_mode(
            modes[i / 4], al_mode_defaults,
            "{'materials':[{'name':'m','base_color':0.7,'roughness':0},{'name':'k','base_color':1,'metallic':"
            "1}],"
            "'meshes':[{'name':'f','shape':{'type':'plane','width_m':2,'depth_m':2},'material':'m'},"
            "{'name':'s','shape':{'type':'sphere','subdivisions':2,'radius_m':0.3},'material':'k',"
            "'transform':{'translate_m':[0,0.4,0]}}],'media':[{'name':'a','sigma_s_per_m':%g,'g':%g}],"
            "'fogs':['a'],'lights':[{'type':'point','position_m':[0.2,0,0.3],'intensity_w_sr':2},"
            "{'type':'directional','direction':[1,-1,0],'irradiance_w_m2':1e6}]}",
            sigmas_per_m[i % 2], lobes[i / 2 % 2]);
        al_random random = al_random_for(11, (uint64_t)i);
        int wrong = 0;
        for (int n = 0; n < SAMPLES; n++) {
            double numbers[64], value[3];
            for (uint32_t d = 0; d < scene.mode->dimensions(scene.state); d++)
                numbers[d] = al_random_real(&random);
            CHECK(scene.mode->radiance(scene.state, scene.scratch, &rays[n % 2], numbers, value));
            for (int c = 0; c < 3; c++) wrong += !(value[c] >= 0) || !isfinite(value[c]);
        }
        CHECK(wrong == 0);
        close_scene(&scene);
    }
}

/* --- every kind of lamp and medium --- */

/* Along a ray that meets no surface the first vertex of a path of one event is that event: with at most one
 * bounce, less what has none, is light off one surface. Two emitters, one of them shining on both sides and
 * reflecting, a lamp, a sun, a sky; a floor, a wall; two fogs that overlap, layers in one of them, and a
 * translucent ball; one lamp more, which lies on the wall. */
static void test_paths(void)
{
    static const char scene[] =
        "{'materials':[{'name':'glow','base_color':0,'emission_w_m2_sr':[3,2,1]},"
        "{'name':'lit','base_color':0.4,'emission_w_m2_sr':[1,2,4],'double_sided':true},"
        "{'name':'grey','base_color':[0.8,0.5,0.3],'metallic':0.2}],"
        "'meshes':[{'name':'floor','shape':{'type':'plane','width_m':3,'depth_m':3},'material':'grey'},"
        "{'name':'wall','shape':{'type':'plane','width_m':2,'depth_m':1},'material':'grey',"
        "'transform':{'rotate_degrees':[90,0,0],'translate_m':[0,0.5,-0.8]}},"
        "{'name':'panel','shape':{'type':'plane','width_m':0.5,'depth_m':0.5},'material':'glow',"
        "'transform':{'rotate_degrees':[180,0,0],'translate_m':[0.3,1,0]}},"
        "{'name':'sheet','shape':{'type':'plane','width_m':0.4,'depth_m':0.6},'material':'lit',"
        "'transform':{'rotate_degrees':[0,0,70],'translate_m':[-0.7,0.4,0]}},"
        "{'name':'ball','shape':{'type':'sphere','subdivisions':3},"
        "'transform':{'scale':0.3,'translate_m':[0.2,0.6,0.3]}}],"
        "'media':[{'name':'a','sigma_s_per_m':[0.4,0.6,0.9],'sigma_a_per_m':0.1,'g':0.6,"
        "'density':{'type':'layers','period_m':0.3,'thickness_m':0.1,'high':2,'low':0.3,"
        "'bounds_min_m':[-1,-0.5,-1],'bounds_max_m':[1,2,1]}},"
        "{'name':'b','sigma_s_per_m':0.3,'g':-0.3,'density':{'type':'constant',"
        "'bounds_min_m':[-3,-3,-3],'bounds_max_m':[3,3,3]}},"
        "{'name':'c','sigma_s_per_m':[3,1,2],'sigma_a_per_m':1}],"
        "'fogs':['a','b'],'translucents':[{'name':'o','mesh':'ball','medium':'c'}],"
        "'environment':{'radiance_w_m2_sr':[0.2,0.1,0.3]},"
        "'lights':[{'type':'directional','direction':[-0.6,-0.7,-0.4],'irradiance_w_m2':2},"
        "{'type':'point','position_m':[0.5,0.3,-0.3],'intensity_w_sr':0.4},"
        "{'type':'point','position_m':[-0.4,0.6,-0.8],'intensity_w_sr':0.3}]}";
    test_scene ours = open_mode(&al_mode_surface_to_volume, al_mode_defaults, "%s", scene);
    test_scene with =
        open_mode(&al_mode_volume_path, (al_mode_options){.min_events = 1, .max_events = 1, .max_bounces = 1},
                  "%s", scene);
    test_scene without =
        open_mode(&al_mode_volume_path, (al_mode_options){.min_events = 1, .max_events = 1}, "%s", scene);
    al_ray rays[] = {ray_along(-2, 0.7, 0.9, 4, 0.1, -0.1), ray_along(1.25, 0.6, 3, 0, 0.05, -3)};
    for (int i = 0; i < 2; i++)
        for (int c = 0; c < 2; c++) {
            double noise[3], value = estimate(&ours, &rays[i], 200, c, &noise[0]);
            double expected = estimate(&with, &rays[i], 15000, c, &noise[1]) -
                              estimate(&without, &rays[i], 15000, c, &noise[2]);
            CHECK_NEAR(value, expected, sigmas * hypot(noise[0], hypot(noise[1], noise[2])));
            CHECK(noise[0] <= 0.02 * expected && hypot(noise[1], noise[2]) <= 0.05 * expected);
        }
    close_scene(&ours);
    close_scene(&with);
    close_scene(&without);
}

/* No lamp, no surface, no medium: black. */
static void test_nothing(void)
{
    static const char *const scenes[] = {
        "{'meshes':[{'name':'p','shape':{'type':'plane'}}],'media':[{'name':'a','sigma_s_per_m':1}],'fogs':['"
        "a']}",
        "{'lights':[{'type':'point','position_m':[0,1,0],'intensity_w_sr':1}],"
        "'media':[{'name':'a','sigma_s_per_m':1}],'fogs':['a']}",
        "{'meshes':[{'name':'p','shape':{'type':'plane'}}],"
        "'lights':[{'type':'point','position_m':[0,1,0],'intensity_w_sr':1}]}"};
    for (int i = 0; i < 3; i++) {
        test_scene scene = open_mode(&al_mode_surface_to_volume, al_mode_defaults, "%s", scenes[i]);
        al_ray ray = ray_along(0, 1, 1, 0, -1, -1);
        double error;
        CHECK(estimate(&scene, &ray, 100, 0, &error) == 0 && error == 0);
        close_scene(&scene);
    }
}

int main(void)
{
    test_rectangle();
    test_monotone();
    test_scaling();
    test_extremes();
    test_paths();
    test_nothing();
    return test_end();
}
