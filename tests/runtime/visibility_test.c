/* Light of an emitter in fog behind a wall, by the bounced z-buffer: the mean over frames against a quadrature in double
 * precision over all discs, which knows nothing of drawn rays and the depth test; and that quadrature against the true
 * squares, with surfels ever smaller. */
#include <stdlib.h>
#include <string.h>

#include "../test.h"
#include "airlight/formulas.h"
#include "readback.h"
#include "sphere.h"
#include "stage.h"

enum { EDGE = 32, HALF = EDGE / 2, FRAMES = 32, CHANNELS = 3, SUMS = 4 * CHANNELS, OVERLAP = 3 }; /* of four blocks of pixels */

static const double emitter_y = -0.6, emitter_half = 0.8, wall_y = -0.4, wall_half = 0.35, wall_at[2] = {0.2, -0.1};
static const float emission[3] = {2, 1, 0.5f};

static const char *folder;

typedef struct fog_kind {
    const char *name;
    uint32_t count; /* fogs, one place */
    float sigma_s[2][3], sigma_a[2][3], g[2];
} fog_kind;

static const fog_kind kinds[] = {
    {"grey, g 0.3", 1, {{0.6f, 0.6f, 0.6f}}, {{0.2f, 0.2f, 0.2f}}, {0.3f}},
    {"coloured, g -0.2", 1, {{1.5f, 0.6f, 0.1f}}, {{0.1f, 0.1f, 0.4f}}, {-0.2f}},
    {"two coloured, g 0.6 and -0.5", 2, {{0.8f, 0.2f, 0}, {0, 0.3f, 0.9f}}, {{0, 0.1f, 0.1f}, {0.2f, 0, 0}}, {0.6f, -0.5f}},
};

/* The ball's mesh becomes a black square; the other one glows. */
static al_runtime *open_room(const fog_kind *kind)
{
    al_runtime *runtime = NULL;
    al_error error = {0};
    sphere_scene s;
    al_fog fogs[2];
    al_medium media[2];
    sphere_scene_begin(&s);
    memcpy(s.meshes[0].positions, s.meshes[1].positions, 12 * sizeof(float));
    memcpy(s.meshes[0].normals, s.meshes[1].normals, 12 * sizeof(float));
    memcpy(s.meshes[0].indices, s.meshes[1].indices, 6 * sizeof(uint32_t));
    s.meshes[0].vertex_count = 4;
    s.meshes[0].index_count = s.submeshes[0].index_count = 6;
    for (int k = 0; k < 3; k++) {
        s.materials[0].base_color[k] = s.materials[1].base_color[k] = 0;
        s.materials[1].emission_w_m2_sr[k] = emission[k];
    }
    for (uint32_t i = 0; i < kind->count; i++) {
        fogs[i] = (al_fog){.medium = i,
                           .bounded = true,
                           .density = 1,
                           .asset = "",
                           .bounds_min_m = {-0.6f, -0.3f, -0.6f},
                           .bounds_max_m = {0.6f, 0.5f, 0.6f}};
        media[i] = (al_medium){.name = "", .g = kind->g[i]};
        memcpy(media[i].sigma_s_per_m, kind->sigma_s[i], 12);
        memcpy(media[i].sigma_a_per_m, kind->sigma_a[i], 12);
    }
    s.scene.fogs = fogs;
    s.scene.media = media;
    s.scene.fog_count = s.scene.medium_count = kind->count;
    s.scene.baked = (al_baked_light){"", ""};
    sphere_scene_add_floor(&s, (float)(2 * emitter_half), (float[3]){0, (float)emitter_y, 0});
    sphere_scene_add_floor(&s, (float)(2 * wall_half), (float[3]){(float)wall_at[0], (float)wall_y, (float)wall_at[1]});
    s.instances[1].mesh = 0;
    CHECK(sphere_scene_write(folder, &s));
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK);
    CHECK(stage_load(runtime, folder));
    sphere_scene_end(&s);
    return runtime;
}

static al_view look(void)
{
    return stage_look(EDGE, EDGE, (float[3]){0, 0.1f, 3}, (float[3]){0, 0.1f, 0}, 0.3f);
}

/* --- the quadrature --- */

typedef enum world { DISCS, DISCS_WITHOUT_WALL, SQUARES } world;

typedef struct scene {
    readback state;
    world world;
    int levels;
    double overlap, reach; /* of the innermost shell, m */
} scene;

/* What share of rays a plane lets through, seen from one place, over the square of x and z in [-EXTENT, EXTENT]. */
enum { CELLS = 120 };
static const double extent = 1.2;
typedef double plane[CELLS * CELLS]; /* [z][x] */

static int cell_of(double x)
{
    int cell = (int)floor((x + extent) * (CELLS / (2 * extent)));
    return cell < 0 ? 0 : cell >= CELLS ? CELLS - 1 : cell;
}

static double middle_of(int cell)
{
    return (cell + 0.5) * (2 * extent / CELLS) - extent;
}

/* A surfel at distance d lies in shell m, d <= reach 2^m, and has a disc 4^m times as large there. It is drawn in level m
 * and, as such near fragments count, in those above, into one of 4^l sub-buffers of each: what share of pixels see it. */
static double drawn_share(const scene *s, double distance, double *scale)
{
    double missing = 1;
    int m = (int)fmin(ceil(fmax(log2(distance / s->reach), 0)), s->levels - 1);
    for (int level = m; level < s->levels; level++) missing *= 1 - exp2(-2 * level);
    *scale = exp2(2 * m);
    return 1 - missing;
}

static void fill_discs(const scene *s, const double from[3], double y, plane open)
{
    for (uint32_t i = 0; i < s->state.surfel_count; i++) {
        const surfel *f = &s->state.surfels[i];
        double squared = 0, scale;
        if (fabs(f->place[1] - y) > 0.05) continue;
        for (int k = 0; k < 3; k++) squared += (f->place[k] - from[k]) * (f->place[k] - from[k]);
        double through = 1 - drawn_share(s, sqrt(squared), &scale), radius2 = f->place[3] / AL_PI * s->overlap * scale;
        double radius = sqrt(radius2);
        for (int z = cell_of(f->place[2] - radius); z <= cell_of(f->place[2] + radius); z++)
            for (int x = cell_of(f->place[0] - radius); x <= cell_of(f->place[0] + radius); x++) {
                double dx = middle_of(x) - f->place[0], dz = middle_of(z) - f->place[2];
                if (dx * dx + dz * dz <= radius2) open[z * CELLS + x] *= through;
            }
    }
}

static void fill_square(double half, const double at[2], plane open)
{
    for (int z = 0; z < CELLS; z++)
        for (int x = 0; x < CELLS; x++)
            if (fabs(middle_of(x) - at[0]) < half && fabs(middle_of(z) - at[1]) < half) open[z * CELLS + x] = 0;
}

/* Radiance scattered per metre at a place towards -direction: the sum over the cells of the emitter's plane. */
static void source_at(const scene *s, const double place[3], const double direction[3], double light[CHANNELS])
{
    static plane emitter, wall;
    static const double origin[2] = {0, 0};
    const al_fog_block *fogs = &s->state.fogs;
    for (int i = 0; i < CELLS * CELLS; i++) emitter[i] = wall[i] = 1;
    if (s->world == SQUARES) {
        fill_square(emitter_half, origin, emitter);
        fill_square(wall_half, wall_at, wall);
    } else {
        fill_discs(s, place, emitter_y, emitter);
        if (s->world == DISCS) fill_discs(s, place, wall_y, wall);
    }
    double height = place[1] - emitter_y, part = (place[1] - wall_y) / height, cell = 2 * extent / CELLS;
    memset(light, 0, CHANNELS * sizeof *light);
    for (int z = 0; z < CELLS; z++)
        for (int x = 0; x < CELLS; x++) {
            double to[2] = {middle_of(x) - place[0], middle_of(z) - place[2]}, cross[2], tau[3];
            for (int k = 0; k < 2; k++) cross[k] = place[2 * k] + part * to[k];
            double seen = 1 - emitter[z * CELLS + x];
            if (fabs(cross[0]) < extent && fabs(cross[1]) < extent) seen *= wall[cell_of(cross[1]) * CELLS + cell_of(cross[0])];
            if (!(seen > 0)) continue;
            ray leg = {{place[0], place[1], place[2]}, {to[0], -height, to[1]}};
            double distance = sqrt(to[0] * to[0] + to[1] * to[1] + height * height), cosine = 0;
            for (int k = 0; k < 3; k++) {
                leg.direction[k] /= distance;
                cosine += leg.direction[k] * direction[k];
            }
            readback_depth(&s->state, &leg, distance, tau);
            double angle = cell * cell * height / (distance * distance * distance);
            for (int32_t i = 0; i < fogs->counts[0]; i++)
                for (int c = 0; c < CHANNELS; c++)
                    light[c] += fogs->fogs[i].sigma_s[c] * al_phase(fogs->fogs[i].sigma_t[3], cosine) * seen * angle *
                                emission[c] * exp(-tau[c]);
        }
}

/* Means over four blocks of the picture: rays through the middles of every STEP x STEP pixels. Near the fog's faces light
 * falls off like x log x, as the way through the fog ends there: places are drawn towards them. Of one block, twice as
 * many rays move 0.2 %, cells of half the size 0.2 %. */
static void integrate(const scene *s, double blocks[SUMS])
{
    enum { STEP = 2, PANELS = 4, PLACES = 3 };
    static const double place[PLACES] = {0.1127016653792583, 0.5, 0.8872983346207417}, weight[PLACES] = {5 / 18.0, 4 / 9.0, 5 / 18.0};
    memset(blocks, 0, SUMS * sizeof *blocks);
    for (int y = 0; y < EDGE; y += STEP)
        for (int x = 0; x < EDGE; x += STEP) {
            ray r = readback_ray(&s->state.frame, x + 0.5 * STEP, y + 0.5 * STEP);
            double span[2], at[3], tau[3], light[CHANNELS], *block = blocks + (y / HALF * 2 + x / HALF) * CHANNELS;
            if (!readback_clip(&s->state.fogs.fogs[0], &r, 1e30, span)) continue;
            for (int i = 0; i < PANELS * PLACES; i++) {
                double share = (i / PLACES + place[i % PLACES]) / PANELS, length = span[1] - span[0];
                double t = span[0] + share * share * (3 - 2 * share) * length;
                for (int k = 0; k < 3; k++) at[k] = r.origin[k] + t * r.direction[k];
                readback_depth(&s->state, &r, t, tau);
                source_at(s, at, r.direction, light);
                for (int c = 0; c < CHANNELS; c++)
                    block[c] += weight[i % PLACES] / PANELS * 6 * share * (1 - share) * length * exp(-tau[c]) * light[c] *
                                STEP * STEP / (HALF * HALF);
            }
        }
}

/* --- the runtime --- */

static const al_settings drawn = {.pass = AL_PASS_SURFACE_SCATTERING,
                                  .visibility = true,
                                  .surfel_pixels = 1.7f,
                                  .bounce_samples = 16,
                                  .bounce_overlap = OVERLAP,
                                  .blur_off = true};

static void average(al_runtime *runtime, const al_settings *settings, double mean[SUMS], double error[SUMS])
{
    al_view view = look();
    memset(mean, 0, SUMS * sizeof *mean);
    memset(error, 0, SUMS * sizeof *error);
    for (int frame = 0; frame < FRAMES; frame++) {
        float *pixels = stage_draw(runtime, &view, settings, 0);
        CHECK(pixels && stage_bad(pixels, EDGE * EDGE * 3) == 0);
        double sums[SUMS] = {0};
        for (int i = 0; pixels && i < EDGE * EDGE; i++)
            for (int c = 0; c < CHANNELS; c++)
                sums[(i / EDGE / HALF * 2 + i % EDGE / HALF) * CHANNELS + c] += pixels[3 * i + c] / (double)(HALF * HALF);
        for (int i = 0; i < SUMS; i++) {
            mean[i] += sums[i] / FRAMES;
            error[i] += sums[i] * sums[i] / FRAMES;
        }
        free(pixels);
    }
    for (int i = 0; i < SUMS; i++)
        error[i] = sqrt(fmax(error[i] - mean[i] * mean[i], 0) / (FRAMES - 1));
}

static double sum(double blocks[SUMS])
{
    double total = 0;
    for (int i = 0; i < SUMS; i++) total += blocks[i];
    return total;
}

/* Blocks within four standard errors or 0.5 %, 0.8 % where samples keep weights of 8 bits. */
static void test_discs(const fog_kind *kind, uint32_t levels)
{
    const float reach = 0.4f;
    al_settings settings = drawn;
    settings.shell_levels = levels;
    settings.bounce_radius_m = reach;
    double mean[SUMS], error[SUMS], expected[SUMS], open[SUMS], worst = 0;
    al_runtime *runtime = open_room(kind);
    average(runtime, &settings, mean, error);
    scene s = {readback_take(runtime), DISCS, (int)levels, OVERLAP, (double)reach};
    integrate(&s, expected);
    for (int i = 0; i < SUMS; i++) {
        worst = fmax(worst, fabs(mean[i] / expected[i] - 1));
        CHECK_NEAR(mean[i] / expected[i], 1, fmax(4 * error[i] / expected[i], kind == kinds ? 0.005 : 0.008));
    }
    printf("| light past a wall, %s, %u level%s | %.2f %%, worst block %.2f %% at a standard error of %.2f %% (%u surfels) |\n",
           kind->name, levels, levels > 1 ? "s" : "", 100 * (sum(mean) / sum(expected) - 1), 100 * worst,
           100 * sum(error) / sum(mean), s.state.surfel_count);
    s.world = DISCS_WITHOUT_WALL;
    if (levels == 1 && kind == kinds) {
        integrate(&s, open);
        printf("| what the wall hides of it | %.0f %% |\n", 100 * (1 - sum(expected) / sum(open)));
        CHECK(sum(expected) < 0.8 * sum(open));
    }
    readback_free(&s.state);
    al_runtime_destroy(runtime);
}

/* Discs of nine times their surfels' area leave no holes; what they hide and send beyond the squares' edges, in the mean,
 * goes with their radius. */
static void test_squares(void)
{
    double off[2];
    al_runtime *runtime = open_room(&kinds[0]);
    al_view view = look();
    for (int i = 0; i < 2; i++) {
        al_settings settings = drawn;
        settings.bounce_samples = 1;
        settings.surfel_pixels = i ? 0.4f : 0.8f;
        free(stage_draw(runtime, &view, &settings, 0));
        scene s = {readback_take(runtime), DISCS, 1, 9, 1};
        double discs[SUMS], squares[SUMS];
        integrate(&s, discs);
        s.world = SQUARES;
        integrate(&s, squares);
        off[i] = sum(discs) / sum(squares) - 1;
        printf("| %u discs against the true squares | %.2f %% |\n", s.state.surfel_count, 100 * off[i]);
        readback_free(&s.state);
    }
    CHECK(fabs(off[1]) < 0.7 * fabs(off[0]));
    al_runtime_destroy(runtime);
}

int main(void)
{
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    folder = stage_folder();
    if (!folder) return test_skip("no temporary folder");
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) test_discs(&kinds[i], 1);
    test_discs(&kinds[0], 4);
    test_squares();
    return test_end();
}
