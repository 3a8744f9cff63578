/* Light over surfaces alone, against closed forms. */
#include <string.h>

#include "gather_for_test.h"

static const double pi = 3.14159265358979323846;

/* Mean irradiance of 16 independent gathers and its standard error, one channel. */
static double mean_surface(const test_gather *test, const double position[3], const double normal[3], int c,
                           double *error)
{
    enum { COUNT = 16 };
    double values[COUNT], mean = 0, square = 0;
    for (int i = 0; i < COUNT; i++) {
        al_gathered gathered = gather_at(test, position, normal, (uint64_t)i);
        values[i] = gathered.surface[c];
        mean += values[i] / COUNT;
    }
    for (int i = 0; i < COUNT; i++) square += (values[i] - mean) * (values[i] - mean);
    *error = sqrt(square / (COUNT * (COUNT - 1)));
    return mean;
}

/* Walls that emit Le and reflect one half send Le / (1 - 1/2) everywhere: pi times that is received. Paths
 * end after 24 reflections, which leaves 2^-25. */
static void test_furnace(void)
{
    al_gather_options options = {.samples = 8192, .bounces = 24};
    test_gather test = open_gather(
        "{'materials':[{'name':'wall','base_color':0.5,'emission_w_m2_sr':[1,2,3],'double_sided':true}],"
        "'meshes':[{'name':'box','shape':{'type':'box','size_m':2},'material':'wall','lighting':'lightmap'}]"
        "}",
        NULL, &options);
    const double position[3] = {0.3, -1, 0.2}, normal[3] = {0, 1, 0};
    for (int c = 0; c < 3; c++) {
        double error, mean = mean_surface(&test, position, normal, c, &error);
        CHECK_NEAR(mean, 2 * pi * (c + 1), 0.001 * 2 * pi * (c + 1));
        CHECK(error < 0.001 * mean);
    }
    close_gather(&test);
}

/* A plane of albedo 0.25 under a sun of 3 W/m2 at 60 degrees, a lamp of 2 W/sr 2 m above and a white sky. */
static void test_lamps(void)
{
    al_gather_options options = {.samples = 256, .bounces = 2, .sh_order = 2};
    test_gather test =
        open_gather("{'meshes':[{'name':'floor','shape':{'type':'plane'},'lighting':'lightmap'}],"
                    "'environment':{'radiance_w_m2_sr':[0,0,1]},"
                    "'lights':[{'type':'directional','direction':[0.8660254037844386,-0.5,0],"
                    "'irradiance_w_m2':[3,0,0]},"
                    "{'type':'point','position_m':[0,2,0],'intensity_w_sr':[0,2,0]}]}",
                    NULL, &options);
    const double position[3] = {0, 0, 0}, up[3] = {0, 1, 0}, down[3] = {0, -1, 0}, air[3] = {0, 1, 0};
    double error;
    /* One lamp is drawn per path, in proportion to what it does: the mean is exact to the draws' evenness. */
    CHECK_NEAR(mean_surface(&test, position, up, 0, &error), 3 * 0.5, 0.003);
    CHECK_NEAR(mean_surface(&test, position, up, 1, &error), 0.5, 0.002);
    CHECK_NEAR(mean_surface(&test, position, up, 2, &error), pi, 0.002 * pi);
    CHECK_NEAR(mean_surface(&test, position, down, 0, &error), 0, 0);
    CHECK_NEAR(mean_surface(&test, position, down, 2, &error), pi, 0.002 * pi);

    /* In the air: a white sky above, and below the floor's solid angle as seen from 1 m, which reflects. Band
     * 0 of the lamp, at 1 m distance: intensity Y(0,0). */
    al_gathered probe = gather_at(&test, air, NULL, 7);
    double band0 = sqrt(1 / (4 * pi)), seen = 4 * asin(0.25 / (0.25 + 1));
    double floor_sends = 0.8 * 2 / pi * 0.25; /* at its middle; 1/(1 + r2)^(3/2) less away from it */
    CHECK(probe.sh[AL_GATHER_SURFACE][1][0] > 2 * band0 + 0.6 * seen * floor_sends * band0);
    CHECK(probe.sh[AL_GATHER_SURFACE][1][0] < 2 * band0 + 1.4 * seen * floor_sends * band0);
    CHECK_NEAR(probe.sh[AL_GATHER_SURFACE][1][1], 2 * sqrt(3 / (4 * pi)), 0.1);
    CHECK(!memcmp(probe.sh[AL_GATHER_SURFACE], probe.sh[AL_GATHER_ATTENUATED], sizeof probe.sh[0]));
    CHECK(probe.surface[0] == 0);
    close_gather(&test);
}

/* The same arguments give the same bytes. */
static void test_again(void)
{
    al_gather_options options = {.samples = 8, .bounces = 3, .sh_order = 3};
    const char *scene = "{'meshes':[{'name':'floor','shape':{'type':'sphere','subdivisions':2}}],"
                        "'environment':{'radiance_w_m2_sr':1}}";
    const double position[3] = {0, 0.5, 0}, up[3] = {0, 1, 0};
    test_gather a = open_gather(scene, NULL, &options), b = open_gather(scene, NULL, &options);
    al_gathered first = gather_at(&a, position, up, 5), second = gather_at(&b, position, up, 5);
    al_gathered other = gather_at(&a, position, up, 6);
    CHECK(!memcmp(&first, &second, sizeof first));
    CHECK(memcmp(&first, &other, sizeof first) != 0);
    close_gather(&a);
    close_gather(&b);
}

int main(void)
{
    test_furnace();
    test_lamps();
    test_again();
    return test_end();
}
