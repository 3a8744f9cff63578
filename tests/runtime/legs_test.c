/* Extinction between surfaces and places in a gridded fog, as shaders/legs.glsl has it from baked optical depths: against its
 * formula in double precision, against closed form in a box of constant density, against a fine march in a smooth grid and in
 * a hard one, thin and very thick, moved and turned; and what is said where a medium keeps no depths. */
#include <epoxy/gl.h>
#include <stdlib.h>
#include <string.h>

#include "../../runtime/state.h"
#include "../test.h"
#include "airlight/formulas.h"
#include "sphere.h"
#include "stage.h"

enum { VOXELS = 12, POINTS = 9, RINGS = 24, MARCH = 160, LEGS = 1024 };
static const double low[3] = {-0.6, -0.4, -0.5}, edge[3] = {1.2, 0.8, 1};

typedef enum density_kind { EVEN, SMOOTH, HARD } density_kind;

static float voxels[VOXELS * VOXELS * VOXELS];

/* Even: 1. Smooth: a blob. Hard: blocks of 3^3 voxels, full or empty. Largest value about 1. */
static void fill_voxels(density_kind kind)
{
    for (int i = 0; i < VOXELS * VOXELS * VOXELS; i++) {
        double x = i % VOXELS - 5.5, y = i / VOXELS % VOXELS - 5.5, z = i / (VOXELS * VOXELS) - 5.5;
        int block = i % VOXELS / 3 + i / VOXELS % VOXELS / 3 + i / (VOXELS * VOXELS) / 3;
        voxels[i] = kind == EVEN ? 1 : kind == SMOOTH ? (float)exp(-(x * x + y * y + z * z) / 18) : (float)(block % 2);
    }
}

static al_status slice(void *user, uint32_t frame, uint32_t z, float *density, al_error *error)
{
    (void)user, (void)error;
    for (size_t i = 0; i < VOXELS * VOXELS; i++) density[i] = (frame ? 3 : 1) * voxels[z * VOXELS * VOXELS + i];
    return AL_OK;
}

/* Trilinear between voxel centres, held beyond the outermost; at a share of the bounds. */
static double density_at(const double share[3])
{
    double sum = 0, rest[3];
    int first[3];
    for (int k = 0; k < 3; k++) {
        double at = fmin(fmax(share[k] * VOXELS - 0.5, 0), VOXELS - 1);
        first[k] = (int)fmin(at, VOXELS - 2);
        rest[k] = at - first[k];
    }
    for (int i = 0; i < 8; i++) {
        double weight = 1;
        int at = 0;
        for (int k = 2; k >= 0; k--) {
            weight *= i >> k & 1 ? rest[k] : 1 - rest[k];
            at = at * VOXELS + first[k] + (i >> k & 1);
        }
        sum += weight * voxels[at];
    }
    return sum;
}

/* The part of from + t (to - from), t in [0, limit], inside the bounds. */
static bool span(const double from[3], const double to[3], double limit, double *begin, double *end)
{
    *begin = 0;
    *end = limit;
    for (int k = 0; k < 3; k++) {
        double a = (low[k] - from[k]) / (to[k] - from[k]), b = (low[k] + edge[k] - from[k]) / (to[k] - from[k]);
        *begin = fmax(*begin, fmin(a, b));
        *end = fmin(*end, fmax(a, b));
    }
    return *begin < *end;
}

static double length_of(const double from[3], const double to[3])
{
    return sqrt(pow(to[0] - from[0], 2) + pow(to[1] - from[1], 2) + pow(to[2] - from[2], 2));
}

/* The density's integral over the leg, or, with an infinite limit, to the bounds, m. */
static double march(const double from[3], const double to[3], double limit, int steps)
{
    double begin, end, sum = 0, share[3];
    if (!span(from, to, limit, &begin, &end)) return 0;
    for (int i = 0; i < steps; i++) {
        for (int k = 0; k < 3; k++)
            share[k] = (from[k] + (begin + (i + 0.5) / steps * (end - begin)) * (to[k] - from[k]) - low[k]) / edge[k];
        sum += density_at(share);
    }
    return sum / steps * (end - begin) * length_of(from, to);
}

/* --- the asset --- */

/* By the midpoint rule in z and azimuth, as one who only knows docs/formats.md would. */
static al_status project(void *user, uint32_t frame, float *coefficients, al_error *error)
{
    const al_medium_depth *depth = user;
    uint32_t terms = depth->order * depth->order, points = POINTS * POINTS * POINTS;
    double basis[AL_SH_MAX_COUNT];
    (void)error;
    memset(coefficients, 0, sizeof *coefficients * terms * points);
    for (uint32_t i = 0; i < points; i++) {
        uint32_t at[3] = {i % POINTS, i / POINTS % POINTS, i / (POINTS * POINTS)};
        double place[3], to[3];
        for (int k = 0; k < 3; k++) place[k] = low[k] + edge[k] * fmin(fmax(at[k] / (POINTS - 1.0), 1e-3), 1 - 1e-3);
        for (int d = 0; d < 2 * RINGS * RINGS; d++) {
            double z = 1 - (d / (2 * RINGS) + 0.5) * 2 / RINGS, r = sqrt(1 - z * z), angle = (d % (2 * RINGS) + 0.5) * AL_PI / RINGS;
            double w[3] = {r * cos(angle), r * sin(angle), z};
            for (int k = 0; k < 3; k++) to[k] = place[k] + w[k];
            double tau = (frame ? 3 : 1) * march(place, to, INFINITY, 24) * 2 * AL_PI / (RINGS * RINGS);
            al_sh_basis((int)depth->order, w[0], w[1], w[2], basis);
            for (uint32_t n = 0; n < terms; n++) coefficients[n * points + i] += (float)(tau * basis[n]);
        }
    }
    return AL_OK;
}

/* The medium with sigma_t grey at density 1; order 0: it keeps no depths. A second frame, at 1 s, is three times as dense. */
static bool write_medium(const char *folder, double sigma_t, uint32_t order, uint32_t frames)
{
    static const float times_s[] = {0, 1};
    char path[512];
    al_error error = {0};
    al_medium_depth depth = {{POINTS, POINTS, POINTS}, order};
    al_medium_data data = {.info = {.size = {VOXELS, VOXELS, VOXELS}, .frame_count = frames, .extended = true},
                           .times_s = times_s, .slice = slice};
    for (int k = 0; k < 3; k++) {
        data.info.bounds_min_m[k] = (float)low[k];
        data.info.bounds_max_m[k] = (float)(low[k] + edge[k]);
        data.info.grid_to_world[5 * k] = (float)(edge[k] / VOXELS);
        data.info.grid_to_world[12 + k] = (float)(low[k] + 0.5 * edge[k] / VOXELS);
        data.info.sigma_s_per_m[k] = (float)sigma_t;
    }
    data.info.grid_to_world[15] = 1;
    if (order) {
        data.depth = &depth;
        data.depths = project;
        data.depths_user = &depth;
    }
    snprintf(path, sizeof path, "%s/fog.medium.air", folder);
    if (al_medium_write(path, &data, NULL, &error) == AL_OK) return true;
    fprintf(stderr, "%s\n", error.message);
    return false;
}

/* A scene with that fog over a lit square. */
static al_runtime *open_fog(const char *folder)
{
    al_runtime *runtime = NULL;
    al_error error = {0};
    sphere_scene s;
    al_fog fog = {.bounded = true, .density = 1, .asset = "fog.medium.air"};
    al_medium medium = {.name = "smoke"};
    sphere_scene_begin(&s);
    for (int k = 0; k < 3; k++) {
        fog.bounds_min_m[k] = (float)low[k];
        fog.bounds_max_m[k] = (float)(low[k] + edge[k]);
        medium.sigma_s_per_m[k] = 1;
    }
    s.scene.fogs = &fog;
    s.scene.media = &medium;
    s.scene.fog_count = s.scene.medium_count = 1;
    s.scene.baked = (al_baked_light){"", ""};
    sphere_scene_add_floor(&s, 2, (float[3]){0, -0.6f, 0});
    sphere_scene_add_light(&s, AL_LIGHT_POINT, (float[3]){0, 0.9f, 0}, 1);
    al_runtime_options options = {.shader_folder = AIRLIGHT_TEST_SHADERS};
    CHECK(sphere_scene_write(folder, &s));
    CHECK(al_runtime_create(&options, &runtime, &error) == AL_OK);
    CHECK(stage_load(runtime, folder));
    sphere_scene_end(&s);
    return runtime;
}

/* --- legs --- */

typedef struct leg {
    float from[4], to[4]; /* then: transmittance, integral of the density relative to the stored unit */
} leg;

static double uniform(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) / 9007199254740992.0;
}

/* From a surfel, anywhere in the bounds grown by half, or on one of their faces, to a place inside, as the passes ask; now
 * and then to one outside. */
static void draw_legs(leg *legs)
{
    uint64_t state = 5;
    for (int i = 0; i < LEGS; i++)
        for (int k = 0; k < 3; k++) {
            double a = -0.25 + 1.5 * uniform(&state), b = uniform(&state);
            if (i % 4 == 0) a = fmin(fmax(a, 0), 1);
            if (i % 8 == 1) b = -0.25 + 1.5 * b;
            legs[i].from[k] = (float)(low[k] + edge[k] * a);
            legs[i].to[k] = (float)(low[k] + edge[k] * b);
        }
}

/* Draws a frame with the leg, then asks the shader for all of them. */
static bool ask(al_runtime *runtime, al_second_leg kind, leg *legs)
{
    al_view view = stage_look(16, 16, (float[3]){0, 0.2f, 3}, (float[3]){0, 0, 0}, 0.6f);
    const al_settings settings = {.pass = AL_PASS_SURFACE_SCATTERING, .second_leg = kind, .second_leg_steps = 64};
    GLuint buffer, program;
    al_error error = {0};
    char defines[64];
    float *pixels = stage_draw(runtime, &view, &settings, 0);
    CHECK(pixels && stage_bad(pixels, 16 * 16 * 3) == 0);
    free(pixels);
    al_draw draw = {.runtime = runtime, .settings = settings};
    al_legs_define(&draw, defines);
    al_status status = al_shaders_get(runtime->shaders, "legs_probe.comp", defines, &program, &error);
    CHECK(status == AL_OK);
    if (status) return fprintf(stderr, "%s\n", error.message), false;
    glCreateBuffers(1, &buffer);
    glNamedBufferStorage(buffer, sizeof *legs * LEGS, legs, 0);
    glUseProgram(program);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 6, buffer);
    al_gl_bind_texture(6, al_legs_texture(runtime));
    glDispatchCompute(LEGS / 64, 1, 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(buffer, 0, sizeof *legs * LEGS, legs);
    glDeleteBuffers(1, &buffer);
    return true;
}

/* --- what they should be --- */

/* tau of the lattice's numbers at a place along a unit direction, by parity. */
static void tau_of(const al_fog_medium *medium, const double place[3], const double w[3], double parts[2])
{
    double sh[AL_DEPTH_TERMS_LIMIT], basis[AL_SH_MAX_COUNT];
    int order = (int)medium->depth.order;
    al_medium_depth_at(&medium->info, &medium->depth, medium->depths, medium->frame.density_max, place, sh);
    al_sh_basis(order, w[0], w[1], w[2], basis);
    parts[0] = parts[1] = 0;
    for (int l = 0; l < order; l++)
        for (int n = l * l; n < (l + 1) * (l + 1); n++) parts[l & 1] += sh[n] * basis[n];
}

/* The leg's depth in m as legs.glsl derives it; *missing: what it lacks of the true one, from what the bands leave out of
 * tau at the ends; *plain: the difference of tau with all bands, where legs.glsl takes the odd ones. */
static double formula(const al_fog_medium *medium, const leg *asked, double *missing, double *plain)
{
    double from[3], to[3], w[3], begin, end, at_begin[2], at_end[2], before, after, from_place[3], to_place[3];
    for (int k = 0; k < 3; k++) from[k] = asked->from[k], to[k] = asked->to[k];
    double reach = length_of(from, to);
    for (int k = 0; k < 3; k++) w[k] = (to[k] - from[k]) / reach;
    if (!span(from, to, 1, &begin, &end)) return 0;
    for (int k = 0; k < 3; k++) {
        from_place[k] = from[k];
        to_place[k] = from[k] + end * (to[k] - from[k]);
    }
    tau_of(medium, from_place, w, at_begin);
    tau_of(medium, to_place, w, at_end);
    before = -INFINITY, after = INFINITY; /* the whole line's span */
    for (int k = 0; k < 3; k++) {
        double a = (low[k] - from[k]) / w[k], b = (low[k] + edge[k] - from[k]) / w[k];
        before = fmax(before, fmin(a, b));
        after = fmin(after, fmax(a, b));
    }
    double margin = 1e-3 * (after - before), tau = at_begin[1] - at_end[1], ahead[2], behind[2];
    const double *ends[2] = {from_place, to_place};
    for (int e = 0; e < 2; e++) { /* true depths to the bounds */
        double on[3], back[3];
        for (int k = 0; k < 3; k++) on[k] = ends[e][k] + w[k], back[k] = ends[e][k] - w[k];
        ahead[e] = march(ends[e], on, INFINITY, MARCH);
        behind[e] = march(ends[e], back, INFINITY, MARCH);
    }
    *missing = 0.5 * (ahead[0] - behind[0] - ahead[1] + behind[1]) - tau;
    *plain = fmax(tau + at_begin[0] - at_end[0], 0);
    if (before > -margin) {
        *plain = tau = at_end[0] - at_end[1];
        *missing = behind[1] - tau;
    } else if (after < reach + margin) {
        *plain = tau = at_begin[0] + at_begin[1];
        *missing = ahead[0] - tau;
    }
    *plain = fmax(*plain, 0);
    return fmax(tau, 0);
}

typedef struct errors {
    double rms, bias, worst, plain; /* of the transmittance against a fine march; rms of the plain difference's */
} errors;

/* Asks for all legs. Every one is the formula within rounding of floats, whatever the density; and the formula is what
 * the bands leave out at its ends away from the truth, never brighter than that. */
static errors check_legs(const char *folder, density_kind kind, double sigma_t, uint32_t order)
{
    static leg legs[LEGS], answers[LEGS];
    errors e = {0};
    fill_voxels(kind);
    CHECK(write_medium(folder, sigma_t, order, 1));
    al_runtime *runtime = open_fog(folder);
    draw_legs(legs);
    memcpy(answers, legs, sizeof legs);
    if (!ask(runtime, order ? AL_SECOND_LEG_BAKED : AL_SECOND_LEG_MARCHED, answers)) return e;
    const al_fog_medium *medium = &runtime->fogs.media[0];
    for (int i = 0; i < LEGS; i++) {
        double from[3], to[3];
        for (int k = 0; k < 3; k++) from[k] = legs[i].from[k], to[k] = legs[i].to[k];
        double left = answers[i].to[0], whole = march(from, to, 1, MARCH), truth = exp(-sigma_t * whole);
        CHECK(left >= 0 && left <= 1); /* not for NaN */
        if (order) {
            /* Sums of 25 products of floats and filtered halfs; of the largest depth, the diagonal. */
            double missing, plain, depth = formula(medium, &legs[i], &missing, &plain), allowed = 2e-5 * 1.8;
            CHECK_NEAR(answers[i].to[3] * medium->frame.density_max / AL_MEDIUM_UNIT, depth, allowed);
            CHECK(left <= exp(-sigma_t * (depth - allowed)) + 1e-6 && left >= exp(-sigma_t * (depth + allowed)) - 1e-6);
            /* Midpoints over the voxels' kinks, and the margin beyond the bounds' faces. */
            CHECK(whole - depth <= fmax(missing, 0) + 5e-3 && (depth == 0 || fabs(whole - depth - missing) < 5e-3));
            e.plain += pow(exp(-sigma_t * plain) - truth, 2) / LEGS;
        }
        e.bias += (left - truth) / LEGS;
        e.rms += (left - truth) * (left - truth) / LEGS;
        e.worst = fmax(e.worst, left - truth);
    }
    e.rms = sqrt(e.rms);
    e.plain = sqrt(e.plain);
    al_runtime_destroy(runtime);
    return e;
}

/* Errors of transmittances at sigma_t of 2 per metre, root mean square over the legs; measured, the bound a fifth more. */
static const struct {
    density_kind kind;
    const char *name;
    double rms[4]; /* order 3, 4, 5; marched in 64 steps */
} accuracy[] = {{EVEN, "box", {0.091, 0.076, 0.068, 1e-4}},
                {SMOOTH, "smooth", {0.091, 0.047, 0.033, 0.001}},
                {HARD, "hard", {0.123, 0.113, 0.110, 0.0074}}};

static void check_accuracy(const char *folder)
{
    static const uint32_t orders[4] = {3, 4, 5, 0};
    for (size_t i = 0; i < sizeof accuracy / sizeof *accuracy; i++)
        for (int j = 0; j < 4; j++) {
            errors e = check_legs(folder, accuracy[i].kind, 2, orders[j]);
            printf("%s, order %u: transmittance off by %.4f rms, %+.4f mean, %.3f at most; %.4f rms with even bands\n",
                   accuracy[i].name, orders[j], e.rms, e.bias, e.worst, e.plain);
            CHECK_NEAR(e.rms, 0, 1.2 * accuracy[i].rms[j]);
            CHECK(!orders[j] || e.rms <= e.plain);
        }
}

/* Nothing of that hangs on how thick the fog is; check_legs asks for numbers from 0 to 1. */
static void check_thick(const char *folder)
{
    static const double sigmas[] = {1e-6, 1e4, 1e9};
    for (size_t i = 0; i < sizeof sigmas / sizeof *sigmas; i++)
        for (uint32_t order = 1; order <= 5; order += i ? 2 : 1) check_legs(folder, HARD, sigmas[i], order);
}

/* Legs and fog turned and moved alike keep their depths, and in a sequence they are those of the frame that is shown. */
static void check_moved(const char *folder)
{
    static leg legs[LEGS], still[LEGS], answers[LEGS];
    const float c = 0.8f, s = 0.6f, moved[16] = {c, 0, -s, 0, 0, 1, 0, 0, s, 0, c, 0, 0.5f, -0.25f, 2, 1};
    al_load_state state = {0};
    fill_voxels(SMOOTH);
    CHECK(write_medium(folder, 2, 5, 2));
    al_runtime *runtime = open_fog(folder);
    draw_legs(legs);
    memcpy(still, legs, sizeof legs);
    ask(runtime, AL_SECOND_LEG_BAKED, still);
    CHECK(al_runtime_keeps_depths(runtime));
    memcpy(al_runtime_scene(runtime)->fogs[0].moved, moved, sizeof moved);
    for (int i = 0; i < LEGS; i++)
        for (int end = 0; end < 2; end++) {
            const float *p = end ? legs[i].to : legs[i].from;
            float *q = end ? answers[i].to : answers[i].from;
            for (int k = 0; k < 3; k++) q[k] = moved[k] * p[0] + moved[4 + k] * p[1] + moved[8 + k] * p[2] + moved[12 + k];
        }
    memcpy(legs, answers, sizeof legs);
    ask(runtime, AL_SECOND_LEG_BAKED, answers);
    int jumps = 0; /* legs that begin within rounding of the margin at a face take either way */
    for (int i = 0; i < LEGS; i++) jumps += fabsf(answers[i].to[0] - still[i].to[0]) > 1e-4f;
    CHECK(jumps <= 2);
    memcpy(still, answers, sizeof still);
    al_runtime_set_time(runtime, 1);
    for (int i = 0; i < 1000 && (!state.complete || !i); i++) CHECK(al_runtime_update(runtime, 0, &state, NULL) == AL_OK);
    CHECK(state.complete && runtime->fogs.media[0].slots[runtime->fogs.media[0].shown].index == 1);
    memcpy(answers, legs, sizeof legs);
    ask(runtime, AL_SECOND_LEG_BAKED, answers);
    for (int i = 0; i < LEGS; i++) CHECK_NEAR(answers[i].to[0], pow(still[i].to[0], 3), 2e-3); /* halfs of both frames */
    al_runtime_destroy(runtime);
}

/* One line that says which medium, and what to do. */
static void check_refusal(const char *folder)
{
    GLuint texture, framebuffer;
    al_error error = {0};
    al_view view = stage_look(16, 16, (float[3]){0, 0.2f, 3}, (float[3]){0, 0, 0}, 0.6f);
    al_settings settings = {.pass = AL_PASS_SURFACE_SCATTERING, .second_leg = AL_SECOND_LEG_BAKED};
    CHECK(write_medium(folder, 2, 0, 1));
    al_runtime *runtime = open_fog(folder);
    glCreateTextures(GL_TEXTURE_2D, 1, &texture);
    glTextureStorage2D(texture, 1, GL_RGBA32F, 16, 16);
    glCreateFramebuffers(1, &framebuffer);
    glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, texture, 0);
    CHECK(!al_runtime_keeps_depths(runtime));
    CHECK(al_runtime_draw(runtime, &view, &settings, framebuffer, 0, &error) == AL_BAD_INPUT);
    CHECK(strstr(error.message, "\"smoke\"") && strstr(error.message, "\"optical_depth_order\": 5"));
    settings.second_leg_off = true;
    CHECK(al_runtime_draw(runtime, &view, &settings, framebuffer, 0, &error) == AL_OK);
    settings = (al_settings){.pass = AL_PASS_SURFACE_SCATTERING, .second_leg = AL_SECOND_LEG_COUNT};
    CHECK(al_runtime_draw(runtime, &view, &settings, framebuffer, 0, &error) == AL_USAGE);
    glDeleteFramebuffers(1, &framebuffer);
    glDeleteTextures(1, &texture);
    al_runtime_destroy(runtime);
}

int main(void)
{
    const char *folder = stage_folder();
    if (!folder || !stage_open()) return test_skip("no OpenGL 4.5 context");
    check_accuracy(folder);
    check_thick(folder);
    check_moved(folder);
    check_refusal(folder);
    return test_end();
}
