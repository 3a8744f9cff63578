/* Light through fog, with walls bounded and traced, against closed forms. */
#include <string.h>

#include "gather_for_test.h"

static const double pi = 3.14159265358979323846;

/* Mean over four seeds of one channel. */
static double mean_total(const test_gather *test, const double position[3], const double normal[3], int c)
{
    double sum = 0;
    for (uint64_t i = 0; i < 4; i++) {
        al_gathered gathered = gather_at(test, position, normal, i);
        sum += gathered.attenuated[c] + gathered.scattered[c];
    }
    return sum / 4;
}

/* Walls that emit Le and reflect 1/2, around fog that does not absorb: radiance is Le / (1 - 1/2) everywhere,
 * whatever the fog. Here 2 m of sigma_t 0.05 to 5 per metre, isotropic and not. */
static void test_furnace(al_walls walls)
{
    static const double sigma[] = {0.05, 0.5, 5}, g[] = {0, 0.6, 0};
    const double position[3] = {0.3, -1, 0.2}, normal[3] = {0, 1, 0};
    for (int i = 0; i < 3; i++) {
        char text[1024];
        al_gather_options options = {.samples = 512,
                                     .bounces = 12,
                                     .fog = true,
                                     .walls = walls,
                                     .threads = 1,
                                     .fog_points = 8,
                                     .fog_samples = 32};
        snprintf(text, sizeof text,
                 "{'materials':[{'name':'wall','base_color':0.5,'emission_w_m2_sr':1,'double_sided':true}],"
                 "'meshes':[{'name':'box','shape':{'type':'box','size_m':2},'material':'wall',"
                 "'lighting':'lightmap'}],"
                 "'media':[{'name':'fog','sigma_s_per_m':[%g,%g,0],'g':%g}],'fogs':['fog']}",
                 sigma[i], sigma[i] / 2, g[i]);
        test_gather test = open_gather(text, NULL, &options);
        for (int c = 0; c < 3; c++) {
            double ratio = mean_total(&test, position, normal, c) / (2 * pi);
            printf("furnace, walls %d, sigma_t %g: %.4f\n", (int)walls, c < 2 ? sigma[i] / (1 + c) : 0,
                   ratio);
            /* Bounded: energy is kept but for the draws and the last reflections, 2^-12. Traced: light
             * scattered once is exact and the rest interpolated, so that errors of 8 points an edge no longer
             * cancel. */
            CHECK_NEAR(ratio, 1, walls == AL_WALLS_BOUNDED ? 0.02 : 0.1);
        }
        close_gather(&test);
    }
}

/* The same bytes for any number of threads. */
static void test_threads(void)
{
    const char *scene = "{'meshes':[{'name':'ball','shape':{'type':'sphere','subdivisions':2}}],"
                        "'lights':[{'type':'point','position_m':[0,2,0],'intensity_w_sr':1}],"
                        "'environment':{'radiance_w_m2_sr':1},"
                        "'media':[{'name':'fog','sigma_s_per_m':[1,2,3],'g':0.4,'density':{'type':'constant',"
                        "'bounds_min_m':[-1,-1,-1],'bounds_max_m':[1,1,1]}}],'fogs':['fog']}";
    const double position[3] = {0, 0.5, 0}, up[3] = {0, 1, 0};
    al_gather_options options = {.samples = 8,
                                 .bounces = 2,
                                 .fog = true,
                                 .walls = AL_WALLS_BOUNDED,
                                 .threads = 1,
                                 .fog_points = 6,
                                 .fog_samples = 8,
                                 .sh_order = 2};
    test_gather one = open_gather(scene, NULL, &options);
    options.threads = 3;
    test_gather three = open_gather(scene, NULL, &options);
    al_gathered a = gather_at(&one, position, up, 9), b = gather_at(&three, position, up, 9);
    CHECK(!memcmp(&a, &b, sizeof a));
    CHECK(a.scattered[0] > 0);
    close_gather(&one);
    close_gather(&three);
}

/* Fog in which light gets from no point to the next is refused. */
static void test_too_dense(void)
{
    al_gather_options options = {.samples = 1, .fog = true, .walls = AL_WALLS_BOUNDED, .threads = 1};
    al_import *import = import_text("{'meshes':[{'name':'box','shape':{'type':'box'}}],"
                                    "'media':[{'name':'fog','sigma_s_per_m':1e4}],'fogs':['fog']}");
    al_gather *gather;
    al_error error;
    CHECK(al_gather_open(import, NULL, &options, &gather, &error) == AL_BAD_INPUT);
    CHECK(!gather && strstr(error.message, "too dense"));
    al_import_free(import);
}

/* A lamp in fog, high above the only surface: its glow is gathered as it is where something of no size hangs
 * above the lamp, so that the box of all surfaces holds it. Lattices of different places differ by 6 % here,
 * each within 4 % of the path tracer; one that ends below the lamp loses a quarter of the light. */
static void test_lamp_above(void)
{
    const char *speck = ",{'name':'speck','shape':{'type':'sphere','radius_m':1e-3,'subdivisions':0},"
                        "'material':'black','transform':{'translate_m':[-1.9,2.5,-1.9]}}";
    const double up[3] = {0, 1, 0};
    const al_gather_options options = {.samples = 1024, .fog = true, .walls = AL_WALLS_BOUNDED, .threads = 1};
    double sums[2] = {0};
    for (int i = 0; i < 2; i++) {
        char text[2048];
        snprintf(text, sizeof text,
                 "{'materials':[{'name':'black','base_color':0}],'meshes':["
                 "{'name':'floor','shape':{'type':'plane','width_m':4,'depth_m':4},'material':'black'}%s],"
                 "'lights':[{'type':'point','position_m':[0.4,0.8,0.2],'intensity_w_sr':5}],"
                 "'media':[{'name':'fog','sigma_s_per_m':0.95,'sigma_a_per_m':0.05,'density':"
                 "{'type':'constant','bounds_min_m':[-2,0,-2],'bounds_max_m':[2,3,2]}}],'fogs':['fog']}",
                 i ? speck : "");
        test_gather test = open_gather(text, NULL, &options);
        for (int k = 0; k < 9; k++) {
            double position[3] = {k % 3 - 1, 0, k / 3 - 1};
            for (uint64_t seed = 0; seed < 4; seed++)
                sums[i] += gather_at(&test, position, up, seed).scattered[1];
        }
        close_gather(&test);
    }
    printf("lamp above all surfaces: %.4f of the light\n", sums[0] / sums[1]);
    CHECK_NEAR(sums[0] / sums[1], 1, 0.12);
}

/* A lamp between two black solids nearer to each other than the fog's points, all of which are inside them:
 * nothing is known there, so that light scattered once is traced, as with traced walls. Light scattered twice
 * is a thousandth of it. What is left is noise: 1.5 % over seven sets of seeds; the bound is four of that. */
static void test_gap(void)
{
    double sums[2] = {0};
    const al_walls walls[2] = {AL_WALLS_BOUNDED, AL_WALLS_TRACED};
    for (int i = 0; i < 2; i++) {
        al_gather_options options = {
            .samples = i ? 1024 : 4096, .fog = true, .walls = walls[i], .threads = 1, .fog_samples = 32};
        test_gather test =
            open_gather("{'materials':[{'name':'black','base_color':0}],'meshes':["
                        "{'name':'left','shape':{'type':'box','size_m':2},'material':'black',"
                        "'transform':{'translate_m':[-1.1,0,0]}},"
                        "{'name':'right','shape':{'type':'box','size_m':2},'material':'black',"
                        "'transform':{'translate_m':[1.1,0,0]}}],"
                        "'lights':[{'type':'point','position_m':[0,0,0],'intensity_w_sr':1}],"
                        "'media':[{'name':'fog','sigma_s_per_m':1e-3,'density':{'type':'constant',"
                        "'bounds_min_m':[-2.5,-2.5,-2.5],'bounds_max_m':[2.5,2.5,2.5]}}],'fogs':['fog']}",
                        NULL, &options);
        for (int k = 0; k < 4; k++) {
            const double position[3] = {-0.1, 0.2 * k, 0.1 * k + 0.1}, normal[3] = {1, 0, 0};
            for (uint64_t seed = 0; seed < 4; seed++)
                sums[i] += gather_at(&test, position, normal, 10 * seed).scattered[1];
        }
        close_gather(&test);
    }
    printf("lamp in a gap: %.4f of the light\n", sums[0] / sums[1]);
    CHECK_NEAR(sums[0] / sums[1], 1, 0.06);
}

int main(void)
{
    test_lamp_above();
    test_gap();
    test_furnace(AL_WALLS_BOUNDED);
    test_furnace(AL_WALLS_TRACED);
    test_threads();
    test_too_dense();
    return test_end();
}
