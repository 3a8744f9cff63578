/* Extremes of gathered light: each right against a closed form or an exact law of scaling, or refused with a
 * line. Usage: gather_extremes_test [TABLES.air]: without tables, published walls are left out. */
#include <stdarg.h>
#include <string.h>

#include "airlight/formulas.h"
#include "gather_for_test.h"
#include "vdb_writer.h"

static const double float_rounding = 0x1p-24;
static const al_impulse_tables *tables;
static const char *const wall_names[] = {"published", "bounded", "traced"};

/* --- scenes --- */

/* A box, lit from inside by an emissive sheet and a lamp; absorbing fog everywhere. */
typedef struct room {
    double size_m, albedo, emission, lamp, lamp_y, sigma_s, sigma_a, g; /* lengths and sigma over the size */
    uint32_t bounces;
} room;

static const room plain = {1, 0.5, 1, 0.5, 0.125, 0.5, 0.25, 0.25, 8};

static al_import *import_room(const room *r)
{
    char text[2048];
    double s = r->size_m;
    snprintf(text, sizeof text,
             "{'materials':[{'name':'wall','base_color':%.9g,'double_sided':true},"
             "{'name':'sheet','base_color':0,'emission_w_m2_sr':%.9g,'double_sided':true}],"
             "'meshes':[{'name':'box','shape':{'type':'box'},'material':'wall','transform':{'scale':%.17g}},"
             "{'name':'sheet','shape':{'type':'plane','width_m':0.25,'depth_m':0.25},'material':'sheet',"
             "'transform':{'matrix':[%.17g,0,0,0,0,%.17g,0,0,0,0,%.17g,0,0,%.17g,0,1]}}],"
             "'lights':[{'type':'point','position_m':[0,%.17g,0],'intensity_w_sr':%.9g}],"
             "'media':[{'name':'fog','sigma_s_per_m':%.17g,'sigma_a_per_m':%.17g,'g':%.9g}],'fogs':['fog']}",
             r->albedo, r->emission, s, s, s, s, 0.375 * s, r->lamp_y * s, r->lamp, r->sigma_s / s,
             r->sigma_a / s, r->g);
    return import_text(text);
}

static al_gather_options options_for(al_walls walls)
{
    return (al_gather_options){.samples = 64,
                               .bounces = 8,
                               .fog = true,
                               .walls = walls,
                               .sh_order = 3,
                               .threads = 1,
                               .fog_points = 4,
                               .fog_samples = 32};
}

/* Published walls only where there are tables. */
static bool can_ask(al_walls walls)
{
    return walls != AL_WALLS_PUBLISHED || tables;
}

static bool is_good(const al_gathered *g)
{
    for (int c = 0; c < 3; c++) {
        if (!(g->surface[c] >= 0 && isfinite(g->surface[c]))) return false;
        if (!(g->attenuated[c] >= 0 && g->attenuated[c] <= g->surface[c] * (1 + 1e-9) + 1e-300)) return false;
        if (!(g->scattered[c] >= -1e-12 * g->surface[c] && isfinite(g->scattered[c]))) return false;
        for (int k = 0; k < 9; k++)
            if (!isfinite(g->sh[AL_GATHER_SCATTERED][c][k])) return false;
    }
    return true;
}

enum { PLACES = 4 };

/* On the floor, at a wall, in the air, in the lamp. False when refused; the error says why. */
static bool gather_room(const room *r, al_walls walls, al_gathered out[PLACES], al_error *error)
{
    double s = r->size_m;
    const double places[PLACES][3] = {{0.125 * s, -0.5 * s, 0.0625 * s},
                                      {0.5 * s, 0.25 * s, 0.125 * s},
                                      {0.25 * s, 0.125 * s, -0.25 * s},
                                      {0, r->lamp_y * s, 0}};
    const double normals[2][3] = {{0, 1, 0}, {-1, 0, 0}};
    al_gather_options options = options_for(walls);
    options.bounces = r->bounces;
    test_gather test = {.import = import_room(r)};
    al_status status = al_gather_open(test.import, tables, &options, &test.gather, error);
    CHECK(status == AL_OK || status == AL_BAD_INPUT);
    if (status == AL_OK) {
        test.scratch = al_gather_scratch_new(test.gather);
        for (int i = 0; i < PLACES; i++) {
            out[i] = gather_at(&test, places[i], i < 2 ? normals[i] : NULL, 3);
            CHECK(is_good(&out[i]));
        }
    }
    close_gather(&test);
    return status == AL_OK;
}

/* What must not be refused. */
static void gather_open_room(const room *r, al_walls walls, al_gathered out[PLACES])
{
    al_error error = {0};
    bool opened = gather_room(r, walls, out, &error);
    if (!opened) fprintf(stderr, "%s\n", error.message);
    CHECK(opened);
    if (!opened) memset(out, 0, PLACES * sizeof *out);
}

/* --- comparing --- */

static const double *layer_of(const al_gathered *g, al_gather_layer layer)
{
    return layer == AL_GATHER_SURFACE      ? g->surface
           : layer == AL_GATHER_ATTENUATED ? g->attenuated
                                           : g->scattered;
}

/* Largest difference of one layer's irradiance and SH, over its irradiance or SH of band 0. */
static double difference(const al_gathered *a, const al_gathered *b, double factor, al_gather_layer layer)
{
    double worst = 0;
    for (int c = 0; c < 3; c++) {
        double expected = factor * layer_of(b, layer)[c];
        if (expected > 0) worst = fmax(worst, fabs(layer_of(a, layer)[c] / expected - 1));
        if (expected == 0) worst = fmax(worst, layer_of(a, layer)[c] != 0);
        for (int k = 0; k < 9; k++) {
            double scale = factor * b->sh[layer][c][0];
            if (scale > 0)
                worst = fmax(worst, fabs(a->sh[layer][c][k] - factor * b->sh[layer][c][k]) / scale);
        }
    }
    return worst;
}

static double all_difference(const al_gathered a[], const al_gathered b[], int places, double factor)
{
    double worst = 0;
    for (int i = 0; i < places; i++)
        for (int layer = 0; layer < AL_GATHER_LAYER_COUNT; layer++)
            worst = fmax(worst, difference(&a[i], &b[i], factor, (al_gather_layer)layer));
    return worst;
}

/* --- strength of lights --- */

/* Light is linear in its sources. By a power of two nothing rounds differently: the same bits, shifted. By
 * 1e6 the lights are rounded to floats once (2^-24), and fog points add up floats: at most 32 paths of 8
 * vertices, light and record each, 512 roundings a number, in each of some 16 iterations. */
static void test_strength(al_walls walls)
{
    static const double factors[] = {0x1p-20, 0x1p20, 1e-6, 1e6};
    al_gathered unit[PLACES], other[PLACES];
    gather_open_room(&plain, walls, unit);
    CHECK(unit[0].scattered[0] > 0 && unit[0].attenuated[0] < unit[0].surface[0]);
    for (int i = 0; i < 4; i++) {
        room r = plain;
        r.emission *= factors[i];
        r.lamp *= factors[i];
        gather_open_room(&r, walls, other);
        double worst = all_difference(other, unit, PLACES, factors[i]);
        if (i < 2) CHECK(worst == 0);
        if (i >= 2)
            test_extreme(i == 2 ? "radiosity 1e-6" : "radiosity 1e6", worst, 0, 512 * 16 * float_rounding,
                         "gathered, %s walls: lamp and emission times that, largest relative difference (times 2^-20, 2^20: the same bits)",
                         wall_names[walls]);
    }
}

/* The same under a sky and a sun. */
static void test_sky_strength(al_walls walls)
{
    static const double factors[] = {1, 0x1p-20, 0x1p20, 1e-6, 1e6};
    const double origin[3] = {0.25, 0, 0.125}, up[3] = {0, 1, 0};
    al_gathered unit = {0};
    for (int i = 0; i < 5; i++) {
        char text[1024];
        al_gather_options options = options_for(walls);
        snprintf(
            text, sizeof text,
            "{'meshes':[{'name':'floor','shape':{'type':'plane'}},{'name':'block','shape':{'type':'box',"
            "'size_m':0.25}}],'environment':{'radiance_w_m2_sr':%.9g},"
            "'lights':[{'type':'directional','direction':[0.6,-0.8,0],'irradiance_w_m2':%.9g}],"
            "'media':[{'name':'fog','sigma_s_per_m':0.5,'sigma_a_per_m':0.25,'density':{'type':'constant',"
            "'bounds_min_m':[-1,-1,-1],'bounds_max_m':[1,1,1]}}],'fogs':['fog']}",
            factors[i], factors[i]);
        test_gather test = open_gather(text, tables, &options);
        al_gathered lit = gather_at(&test, origin, up, 3);
        if (i == 0) unit = lit;
        CHECK(is_good(&lit) && lit.scattered[0] > 0);
        double worst = all_difference(&lit, &unit, 1, factors[i]);
        CHECK(worst <= (i < 3 ? 0 : 512 * 16 * float_rounding));
        close_gather(&test);
    }
}

/* --- size of the scene --- */

/* The same scene in other metres, its fog as dense for its size. Light from surfaces is the same, from a lamp
 * it falls with the square of the size. By a power of two nothing rounds differently. By 1e4 Embree's
 * positions, 2^-24 of the room's size each, are others: over the shortest ways, 0.03 of the size, 1/d^2 and
 * cosines change by some 4 times as much relative to it, on up to 9 stretches; who stands in the lamp is as
 * far from it as that rounds it. */
static void test_size(al_walls walls)
{
    static const double sizes[] = {0x1p-13, 0x1p13, 1e-4, 1e4};
    for (int kind = 0; kind < 2; kind++) { /* the sheet, the lamp */
        room r = plain;
        al_gathered unit[PLACES], other[PLACES];
        if (kind == 0) r.lamp = 0;
        if (kind == 1) r.emission = 0;
        gather_open_room(&r, walls, unit);
        for (int i = 0; i < 4; i++) {
            r.size_m = sizes[i];
            gather_open_room(&r, walls, other);
            double worst = all_difference(other, unit, i < 2 ? PLACES : PLACES - 1,
                                          kind ? 1 / (sizes[i] * sizes[i]) : 1);
            if (i < 2) CHECK(worst == 0);
            if (i >= 2)
                test_extreme(i == 2 ? "scene of 1e-4 m" : "scene of 1e4 m", worst, 0, 9 * 4 / 0.03 * float_rounding,
                             "gathered, %s walls: light of a %s against that in 1 m, largest relative difference (2^-13, 2^13 m: the same bits)",
                             wall_names[walls], kind ? "lamp" : "sheet");
        }
    }
}

/* --- thin and dense fog --- */

/* Ways of at most sqrt(3) through the room, 9 of them, lose that times sigma_t; light scattered twice is 1e-6
 * of that scattered once, so that scattered light is in proportion to sigma_s: for the fog points within the
 * roundings above, for the tables within their promise (0.2 %) on both sides. */
static void test_thin(al_walls walls)
{
    al_gathered thin[PLACES], thinner[PLACES];
    room r = plain;
    r.sigma_s = r.sigma_a = 5e-7;
    gather_open_room(&r, walls, thin);
    r.sigma_s = r.sigma_a = 2.5e-7;
    gather_open_room(&r, walls, thinner);
    for (int i = 0; i < 2; i++) {
        double loss = 1 - thin[i].attenuated[0] / thin[i].surface[0];
        CHECK(loss > 0 && loss <= 9 * sqrt(3) * 1e-6);
        CHECK_NEAR(1 - thinner[i].attenuated[0] / thinner[i].surface[0], loss / 2, 1e-3 * loss);
        CHECK(thin[i].scattered[0] > 0 && thin[i].scattered[0] < 1e-5 * thin[i].surface[0]);
        const double ratio = thin[i].scattered[0] / thinner[i].scattered[0],
                     bound = walls == AL_WALLS_PUBLISHED ? 2 * 2 * 2e-3 : 2 * 512 * 16 * float_rounding;
        if (i)
            CHECK_NEAR(ratio, 2, bound);
        else
            test_extreme("sigma_t times size 1e-6", ratio, 2, bound, "gathered, %s walls: scattered light over that of half the fog",
                         wall_names[walls]);
    }
}

/* Fog that lets nothing through: black, or refused where light gets from no fog point to the next. */
static void test_dense(al_walls walls)
{
    al_gathered out[PLACES];
    al_error error = {0};
    room r = plain;
    r.sigma_s = r.sigma_a = 5e3;
    if (walls != AL_WALLS_PUBLISHED) {
        CHECK(!gather_room(&r, walls, out, &error));
        CHECK(strstr(error.message, "lightmap.walls: the fog is too dense for 4 points along the scene"));
        printf("extreme: | sigma_t times size 1e4 | gathered, %s walls: the room | exit code 3: %s | a refusal | |\n", wall_names[walls], error.message);
        return;
    }
    gather_open_room(&r, walls, out);
    for (int i = 0; i < 2; i++) {
        CHECK(out[i].surface[0] > 0 && out[i].attenuated[0] == 0 && out[i].scattered[0] == 0);
    }
    test_extreme("sigma_t times size 1e4", out[0].attenuated[0] + out[0].scattered[0], exp(-1e4), 0,
                 "gathered, published walls: light that comes through");
}

/* --- albedo --- */

/* Irradiance is a sum over powers 0 to 8 of the walls' albedo, in which draws take no part above 1/4. Around
 * the fog points light may be reflected 8 times again after each event: 16 times 9 in all. */
static void test_wall_albedo(al_walls walls)
{
    al_gathered black[PLACES], direct[PLACES], white[PLACES], nearly[PLACES];
    al_error error = {0};
    room r = plain;
    r.albedo = 0;
    gather_open_room(&r, walls, black);
    r.bounces = 0;
    gather_open_room(&r, walls, direct);
    CHECK(all_difference(black, direct, PLACES, 1) == 0);
    r = plain;
    r.albedo = 1;
    if (walls == AL_WALLS_PUBLISHED && !gather_room(&r, walls, white, &error)) {
        CHECK(strstr(error.message, "grow without limit"));
        printf("extreme: | albedo 1 | gathered, published walls: surfaces in thin fog | exit code 3: %s | a refusal | |\n", error.message);
        r.sigma_a = 4; /* which is not refused */
    }
    gather_open_room(&r, walls, white);
    r.albedo = 1 - 1e-6;
    gather_open_room(&r, walls, nearly);
    double powers = 1.1e-6, sums = 512 * 16 * float_rounding; /* 1.1: a float's 1 - 1e-6 */
    for (int i = 0; i < 2; i++) {
        CHECK(white[i].surface[0] > 1.5 * black[i].surface[0]);
        const double share = nearly[i].surface[0] / white[i].surface[0];
        if (i)
            CHECK_NEAR(share, 1 - 4 * powers, 4 * powers);
        else
            test_extreme("albedo 1 - 1e-6", share, 1 - 4 * powers, 4 * powers, "gathered, %s walls: light off surfaces over that of albedo 1",
                         wall_names[walls]);
        CHECK_NEAR(nearly[i].attenuated[0] / white[i].attenuated[0], 1 - 4 * powers, 4 * powers);
        CHECK_NEAR(nearly[i].scattered[0] / white[i].scattered[0], 1, 16 * 9 * powers + sums);
    }
}

/* Fog that only absorbs scatters nothing, and light straight from a lamp loses exp(-sigma_t d) (the lamp's
 * place is a float). Fog of albedo 1 - 1e-6 is that of 1 but for 1e-6 an event, 16 of them, and sums of
 * floats; in tables the albedo's power is a factor of each event. */
static void test_fog_albedo(al_walls walls)
{
    al_gathered dark[PLACES], whole[PLACES], nearly[PLACES];
    room r = plain;
    r.albedo = r.emission = r.sigma_s = 0;
    r.sigma_a = 2;
    gather_open_room(&r, walls, dark);
    const double squares[] = {0.125 * 0.125 + 0.625 * 0.625 + 0.0625 * 0.0625, 0.25 + 2 * 0.125 * 0.125},
                 heights[] = {0.625, 0.5};
    for (int i = 0; i < 2; i++) {
        double d = sqrt(squares[i]), expected = 0.5 * heights[i] / (d * squares[i]);
        CHECK(dark[i].scattered[0] == 0);
        CHECK_NEAR(dark[i].surface[0], expected, 1e-6 * expected);
        if (i)
            CHECK_NEAR(dark[i].attenuated[0], expected * exp(-2 * d), 1e-6 * expected);
        else
            test_extreme("albedo 0", dark[i].attenuated[0], expected * exp(-2 * d), 1e-6 * expected,
                         "gathered, %s walls: irradiance through fog that only absorbs (nothing scattered)", wall_names[walls]);
    }
    for (int k = 0; k < 9; k++) CHECK(dark[2].sh[AL_GATHER_SCATTERED][1][k] == 0);
    r = plain;
    r.sigma_a = 0;
    gather_open_room(&r, walls, whole);
    r.sigma_s *= 1 - 1e-6;
    r.sigma_a = 1e-6 * plain.sigma_s;
    gather_open_room(&r, walls, nearly);
    for (int i = 0; i < 2; i++) {
        CHECK_NEAR(nearly[i].attenuated[0] / whole[i].attenuated[0], 1, 1e-6);
        CHECK_NEAR(nearly[i].scattered[0] / whole[i].scattered[0], 1,
                   16 * 1.1e-6 + 512 * 16 * float_rounding);
    }
}

/* --- narrow phase functions --- */

/* Irradiance of a floor 1 m below a lamp of 1 W/sr, scattered once. Over the angle s of scattering and the
 * angle a to the lamp, as in tests/tables/oracle_test.c: 2 pi sigma_s integral of p(s) integral over a of
 * cos(a) exp(-sigma_t (1 + excess)). Midpoints, s = pi u^3. */
static double floor_below_lamp(double sigma_s, double sigma_t, double g)
{
    enum { OUTER = 4000, INNER = 400 };
    double sum = 0;
    for (int i = 0; i < OUTER; i++) {
        double u = (i + 0.5) / OUTER, s = AL_PI * u * u * u, weight = 3 * AL_PI * u * u / OUTER;
        double end = fmin(s, AL_PI / 2), inner = 0;
        for (int k = 0; k < INNER; k++) {
            double a = end * (k + 0.5) / INNER;
            inner += cos(a) * exp(-sigma_t * (1 + 2 * sin(a / 2) * sin((s - a) / 2) / cos(s / 2)));
        }
        sum += weight * al_phase(g, cos(s)) * inner * end / INNER;
    }
    return 2 * AL_PI * sigma_s * sum;
}

/* Mean of scattered light over 16 seeds, and its standard error. */
static double mean_scattered(const test_gather *test, const double position[3], const double normal[3],
                             double *error)
{
    enum { SEEDS = 16 };
    double values[SEEDS], mean = 0, square = 0;
    for (uint64_t i = 0; i < SEEDS; i++) {
        values[i] = gather_at(test, position, normal, i).scattered[0];
        mean += values[i] / SEEDS;
    }
    for (int i = 0; i < SEEDS; i++) square += (values[i] - mean) * (values[i] - mean);
    *error = sqrt(square / (SEEDS * (SEEDS - 1)));
    return mean;
}

/* Fog of albedo 1e-3, so that less than a few 1e-3 is scattered twice. Bounded walls take the lamp's
 * transmittance from fog points 0.4 m apart: there thin fog, in which that is right within 1e-3, and light
 * that turns back comes from up to 100 m beyond them. Their light at 0.99 is drawn as that of traced walls
 * is, and left out for its noise. The tables' kernel takes five bands: 3.1 % at 0.99 (measured). */
static void test_narrow(al_walls walls)
{
    static const double gs[] = {0, -0.99, 0.99};
    const double origin[3] = {0, 0, 0}, up[3] = {0, 1, 0};
    double sigma_a = walls == AL_WALLS_BOUNDED ? 1e-3 : 1, sigma_s = 1e-3 * sigma_a;
    for (int i = 0; i < (walls == AL_WALLS_BOUNDED ? 2 : 3); i++) {
        char text[1024];
        al_gather_options options = options_for(walls);
        options.samples = walls == AL_WALLS_PUBLISHED ? 1 : gs[i] == 0 ? 1 << 14 : 1 << 16;
        snprintf(text, sizeof text,
                 "{'materials':[{'name':'black','base_color':0}],"
                 "'meshes':[{'name':'floor','shape':{'type':'plane'},'material':'black'}],"
                 "'lights':[{'type':'point','position_m':[0,1,0],'intensity_w_sr':1}],"
                 "'media':[{'name':'fog','sigma_s_per_m':%g,'sigma_a_per_m':%g,'g':%g}],'fogs':['fog']}",
                 sigma_s, sigma_a, gs[i]);
        test_gather test = open_gather(text, tables, &options);
        double error, mean = mean_scattered(&test, origin, up, &error),
                      expected = floor_below_lamp(sigma_s, sigma_s + sigma_a, gs[i]);
        const double bound = 4.5 * error + (walls == AL_WALLS_PUBLISHED ? 0.04 : 0.01) * expected;
        if (gs[i] == 0)
            CHECK_NEAR(mean, expected, bound);
        else
            test_extreme(gs[i] > 0 ? "g 0.99" : "g -0.99", mean, expected, bound,
                         "gathered, %s walls: scattered onto a floor below a lamp", wall_names[walls]);
        CHECK(error < (gs[i] == 0 ? 0.01 : 0.1) * expected);
        close_gather(&test);
    }
}

/* --- density of a grid --- */

/* A cube of fog of 2 m, 0.1 per metre but for one voxel of 1e6 in its middle; a lamp 3 m behind it. A
 * receiver in its shadow gets nothing; of one 2 m aside the light passes 1 m off the middle: a sixth of its
 * way in fog, whose density is taken at the middles of pieces of two voxels. */
static void test_speck(al_walls walls)
{
    const char *path = "speck_of_gather_extremes.vdb";
    const double behind[3] = {0, 0, 3}, aside[3] = {2, 0, 3}, forth[3] = {0, 0, -1};
    char text[1024];
    al_gather_options options = options_for(walls);
    vdb_write_speck(path, 21, 2, 1e6f, 0.1f);
    snprintf(text, sizeof text,
             "{'materials':[{'name':'black','base_color':0}],"
             "'meshes':[{'name':'floor','shape':{'type':'plane','width_m':6,'depth_m':6},'material':'black',"
             "'transform':{'translate_m':[0,-2,0]}}],"
             "'lights':[{'type':'point','position_m':[0,0,-3],'intensity_w_sr':1}],"
             "'media':[{'name':'fog','sigma_s_per_m':0.5,'sigma_a_per_m':0.5,"
             "'density':{'type':'grid','file':'%s'}}],'fogs':['fog']}",
             path);
    test_gather test = open_gather(text, tables, &options);
    al_gathered shadow = gather_at(&test, behind, forth, 3), light = gather_at(&test, aside, forth, 3);
    double d = sqrt(40), inside = d / 6, expected = 6 / (d * d * d);
    CHECK(is_good(&shadow) && is_good(&light));
    CHECK_NEAR(shadow.surface[0], 1.0 / 36, 1e-6);
    CHECK(shadow.attenuated[0] == 0);
    test_extreme("one voxel of 1e6", light.attenuated[0], expected * exp(-0.1 * inside), 1e-3 * expected,
                 "gathered, %s walls: irradiance beside its shadow (in it: 0)", wall_names[walls]);
    close_gather(&test);
    remove(path);
}

/* --- lamps and samples --- */

/* A black floor in absorbing fog under `count` lamps of 1/count W/sr, 1 m up, side by side over `width_m`. */
static test_gather open_lamps(al_walls walls, uint32_t count, double width_m, uint32_t samples)
{
    static char text[16384];
    al_gather_options options = options_for(walls);
    options.samples = samples;
    int used = snprintf(text, sizeof text,
                        "{'materials':[{'name':'black','base_color':0}],"
                        "'meshes':[{'name':'floor','shape':{'type':'plane'},'material':'black'}],"
                        "'media':[{'name':'fog','sigma_s_per_m':0.25,'sigma_a_per_m':0.25}],'fogs':['fog'],"
                        "'lights':[");
    for (uint32_t i = 0; i < count; i++)
        used += snprintf(text + used, sizeof text - (size_t)used,
                         "%s{'type':'point','position_m':[%.9g,1,0],'intensity_w_sr':%.9g}", i ? "," : "",
                         width_m * i / count, 1.0 / count);
    snprintf(text + used, sizeof text - (size_t)used, "]}");
    return open_gather(text, tables, &options);
}

/* No lamp: no light. 64 in one place: one of their sum, to the bit where no path is drawn. 64 side by side:
 * one is drawn a sample, in proportion to its irradiance before fog; over that, exp(-sigma_t d) is bounded by
 * its ends, so that the mean of 4096 samples is within 4.5/64 of half their difference, with draws spread
 * evenly by far less. */
static void test_lamps(al_walls walls)
{
    const double origin[3] = {0, 0, 0}, up[3] = {0, 1, 0};
    test_gather none = open_lamps(walls, 0, 0, 16), one = open_lamps(walls, 1, 0, 16),
                same = open_lamps(walls, 64, 0, 16), row = open_lamps(walls, 64, 1, 4096);
    al_gathered dark = gather_at(&none, origin, up, 1), single = gather_at(&one, origin, up, 1),
                stacked = gather_at(&same, origin, up, 1), many = gather_at(&row, origin, up, 1);
    test_extreme("0 lights", dark.surface[0] + dark.attenuated[0] + dark.scattered[0], 0, 0, "gathered, %s walls: irradiance",
                 wall_names[walls]);
    CHECK_NEAR(single.attenuated[0], exp(-0.5), 1e-9);
    CHECK_NEAR(stacked.surface[0], single.surface[0], 1e-12);
    CHECK_NEAR(stacked.attenuated[0], single.attenuated[0], 1e-12);
    double surface = 0, attenuated = 0, error[2];
    for (int i = 0; i < 64; i++) {
        double square = 1 + i / 64.0 * i / 64.0, d = sqrt(square), e = 1 / (64 * d * square);
        surface += e;
        attenuated += e * exp(-0.5 * d);
    }
    double spread = 0.5 * (exp(-0.5) - exp(-0.5 * sqrt(2)));
    CHECK_NEAR(many.surface[0], surface, 1e-9);
    test_extreme("64 lights", many.attenuated[0], attenuated, 4.5 / 64 * spread * surface, "gathered, %s walls: irradiance of a row of lamps",
                 wall_names[walls]);
    CHECK(many.attenuated[0] != many.surface[0] * exp(-0.5));
    double expected = mean_scattered(&one, origin, up, &error[0]),
           sum = mean_scattered(&same, origin, up, &error[1]);
    CHECK_NEAR(sum, expected, 4.5 * hypot(error[0], error[1]) + 1e-9 * expected);
    CHECK(expected > 0 && error[0] < 0.1 * expected);
    close_gather(&none);
    close_gather(&one);
    close_gather(&same);
    close_gather(&row);
}

/* A lamp on the floor is as bright as one that hangs a millionth higher; the floor gets nothing of it. What
 * stands in a lamp gets no light straight from it; 1e-6 beside it, 1e12. */
static void test_lamp_on_surface(al_walls walls)
{
    al_gathered on[PLACES], above[PLACES];
    room r = plain;
    r.emission = r.albedo = 0;
    r.lamp_y = -0.5;
    gather_open_room(&r, walls, on);
    r.lamp_y = -0.5 + 0x1p-20;
    gather_open_room(&r, walls, above);
    CHECK(on[0].surface[0] == 0 && on[1].surface[0] > 0);
    CHECK_NEAR(on[1].surface[0] / above[1].surface[0], 1, 1e-5);
    test_extreme("light on a surface", on[1].attenuated[0], above[1].attenuated[0], 1e-5 * above[1].attenuated[0],
                 "gathered, %s walls: irradiance, against that of a lamp 1e-6 m above", wall_names[walls]);
    CHECK_NEAR(on[2].sh[AL_GATHER_SURFACE][0][0] / above[2].sh[AL_GATHER_SURFACE][0][0], 1, 1e-5);
    test_gather test = open_lamps(walls, 1, 0, 16);
    const double in[3] = {0, 1, 0}, near[3] = {0, 1 - 1e-6, 0}, up[3] = {0, 1, 0};
    al_gathered inside = gather_at(&test, in, up, 1), beside = gather_at(&test, near, up, 1);
    CHECK(is_good(&inside) && is_good(&beside) && inside.surface[0] == 0);
    CHECK_NEAR(beside.surface[0], 1e12, 1e3); /* 1 - 1e-6 in doubles: 1e-16 / 1e-6, twice */
    CHECK_NEAR(beside.attenuated[0], 1e12, 1e6);
    close_gather(&test);
}

/* One sample is an answer, and a million of them are the mean that 4096 scatter about. */
static void test_samples(al_walls walls)
{
    const double origin[3] = {0.1, 0, 0.2}, up[3] = {0, 1, 0};
    const int failures = test_failures;
    test_gather one = open_lamps(walls, 3, 1, 1), some = open_lamps(walls, 3, 1, 4096),
                million = open_lamps(walls, 3, 1, 1000000);
    al_gathered least = gather_at(&one, origin, up, 1), most = gather_at(&million, origin, up, 1);
    double error, mean = mean_scattered(&some, origin, up, &error);
    CHECK(is_good(&least) && is_good(&most));
    CHECK(least.surface[0] > 0);
    test_extreme("1 sample", test_failures - failures, 0, 0, "gathered, %s walls: answers that are negative, not finite or dark",
                 wall_names[walls]);
    test_extreme("1e6 samples", most.scattered[0], mean, 4.5 * error, "gathered, %s walls: scattered light, against the mean of 16 times 4096",
                 wall_names[walls]);
    CHECK(error < 0.02 * mean);
    close_gather(&one);
    close_gather(&some);
    close_gather(&million);
}

int main(int argc, char **argv)
{
    al_file *file = NULL;
    al_impulse_tables *read = NULL;
    al_error error = {0};
    if (argc > 1 && !al_file_open(argv[1], NULL, &file, &error))
        CHECK(al_impulse_tables_read(file, &read, &error) == AL_OK);
    tables = read;
    if (!tables) printf("SKIP published walls: there are no impulse tables\n");
    for (al_walls walls = AL_WALLS_PUBLISHED; walls <= AL_WALLS_TRACED; walls++) {
        if (!can_ask(walls)) continue;
        test_strength(walls);
        test_sky_strength(walls);
        test_size(walls);
        test_thin(walls);
        test_dense(walls);
        test_wall_albedo(walls);
        test_fog_albedo(walls);
        test_narrow(walls);
        test_speck(walls);
        test_lamps(walls);
        test_lamp_on_surface(walls);
        test_samples(walls);
    }
    al_impulse_tables_free(read);
    al_file_close(file);
    return test_end();
}
