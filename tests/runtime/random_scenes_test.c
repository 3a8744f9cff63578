/* usage: runtime_random_scenes_test [--seed S] [--from N] [--count N]
 *
 * Draws random scenes with random settings, over all that is allowed, and checks of each:
 * - no picture holds a number that is negative or not finite, and OpenGL reports no error;
 * - loaded and drawn anew, it is the same to the last byte; a refusal is the same words;
 * - light is linear: all light of 2^k times the strength, with the exposure that epsilon follows, is 2^k times the picture,
 *   and lengths have no unit: a scene 2^k times as large, of 2^-k the extinction and 4^k the lamps, is the same picture.
 *   Floats round alike at every power of two, so both hold bit by bit;
 * - shares are shares: ambient occlusion and depletion are 1 at most;
 * - energy is not made: see check_furnace and check_absorbed.
 * A refusal in one line is a right answer; they are counted. A scene that fails is named by its number: --from N --count 1. */
#include <epoxy/gl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "../../runtime/state.h"
#include "../refusals.h"
#include "../test.h"
#include "random_scene.h"
#include "stage.h"

enum { PIXEL_LIMIT = 16 * 16 };

static const char *folder;
static al_runtime *runtime; /* one, as its shaders are what takes time */
static GLuint texture, framebuffer;

typedef struct picture { /* all frames of a scene */
    al_status status;
    al_error error;
    uint32_t count; /* numbers */
    float values[RANDOM_FRAMES * PIXEL_LIMIT * 3];
} picture;

/* Scenes that have failed, beyond the 200 that are drawn anyway. */
static const struct {
    uint32_t index; /* of seed 1 */
    const char *what;
} known[] = {{218, "a ray nearer than 0.1 mm to a lamp was lit as from there, in a scene of 1 mm"}};

static struct {
    int surfaces, fogs, objects, lights, sky, probes, furnace, black, composite, history;
} drawn;

static void count_drawn(const random_scene *scene)
{
    drawn.surfaces += scene->surfaces > 0;
    drawn.fogs += scene->fogs > 0;
    drawn.objects += scene->objects > 0;
    drawn.lights += scene->lights > 0;
    drawn.sky += scene->sky;
    drawn.probes += scene->probes;
    drawn.furnace += scene->kind == RANDOM_FURNACE;
    drawn.black += scene->kind == RANDOM_BLACK;
    drawn.composite += scene->settings.pass == AL_PASS_COMPOSITE;
    drawn.history += scene->settings.temporal > 0;
}

/* --- drawing --- */

static al_status load(al_error *error)
{
    al_load_state state = {0};
    al_status status = al_runtime_load(runtime, folder, error);
    while (!status && !state.complete) {
        const struct timespec pause = {0, 100000};
        status = al_runtime_update(runtime, 0, &state, error);
        if (!status && !state.complete) nanosleep(&pause, NULL);
    }
    return status;
}

static void draw(const random_scene *scene, picture *p)
{
    p->count = 0;
    p->status = load(&p->error);
    runtime->frame_number = 0;
    for (uint32_t i = 0; i < scene->frames && !p->status; i++) {
        const al_view *view = &scene->views[i];
        const uint32_t size = view->width * view->height * 3;
        p->status = al_runtime_draw(runtime, view, &scene->settings, framebuffer, 0, &p->error);
        if (p->status) break;
        glGetTextureSubImage(texture, 0, 0, 0, 0, (GLsizei)view->width, (GLsizei)view->height, 1, GL_RGB, GL_FLOAT,
                             (GLsizei)(size * sizeof(float)), p->values + p->count);
        p->count += size;
    }
    for (GLenum code; (code = glGetError());) {
        fprintf(stderr, "OpenGL error 0x%04x\n", code);
        CHECK(!"an OpenGL error");
    }
}

/* --- checks: each answers whether it holds --- */

static bool check_finite(const picture *p)
{
    for (uint32_t i = 0; i < p->count; i++)
        if (!(p->values[i] >= 0) || isinf(p->values[i])) {
            fprintf(stderr, "number %u of %u is %g\n", i, p->count, (double)p->values[i]);
            return false;
        }
    return true;
}

/* An unbiased mean of even directions weighs each by twice its cosine and is 2 at most; by the cosine each counts 1. */
static bool check_share(const random_scene *scene, const picture *p)
{
    const al_pass pass = scene->settings.pass;
    for (uint32_t i = 0; i < p->count && (pass == AL_PASS_AMBIENT_OCCLUSION || pass == AL_PASS_DEPLETION); i++)
        if (p->values[i] > (scene->settings.occlusion_uniform ? 2 : 1)) {
            fprintf(stderr, "a share of %.9g\n", (double)p->values[i]);
            return false;
        }
    return true;
}

static bool check_same(const picture *p, const picture *other, double factor)
{
    if (p->status || other->status) return p->status == other->status;
    for (uint32_t i = 0; i < p->count; i++)
        if ((double)p->values[i] * factor != (double)other->values[i]) {
            fprintf(stderr, "number %u of %u is %.9g, not %.9g times %.9g\n", i, p->count, (double)other->values[i], factor,
                    (double)p->values[i]);
            return false;
        }
    return true;
}

/* Where all light is an environment of 1 from everywhere, nothing shines brighter: what scatters or reflects sends on at most what
 * comes in. Indirect light without ambient occlusion counts the environment twice, surfaces into fog without visibility let it
 * through walls, and objects' bands ring: scenes with these are left out. Skies are kept as halfs: 2^-11; twice that is asked. */
static bool check_furnace(const random_scene *scene, const picture *p)
{
    const al_settings *s = &scene->settings;
    if (scene->kind != RANDOM_FURNACE || s->pass != AL_PASS_COMPOSITE || s->indirect || !s->surface_scattering_off || scene->objects)
        return true;
    for (uint32_t i = 0; i < p->count; i++)
        if ((double)p->values[i] > 1 + 0x1p-10) {
            fprintf(stderr, "%.9g in a furnace of 1\n", (double)p->values[i]);
            return false;
        }
    return true;
}

/* Fog that only absorbs never brightens: the same scene in clear air is at least as bright, within the rounding of the few dozen
 * operations of a pixel's sum, 2^-17. History is left out, as it doubts what has changed. */
static bool check_absorbed(const random_scene *scene, const picture *fog, const picture *clear)
{
    if (scene->settings.pass != AL_PASS_COMPOSITE || scene->settings.temporal || fog->status || clear->status) return true;
    for (uint32_t i = 0; i < fog->count; i++)
        if ((double)fog->values[i] > (double)clear->values[i] * (1 + 0x1p-17)) {
            fprintf(stderr, "number %u of %u is %.9g in fog that absorbs, %.9g without\n", i, fog->count, (double)fog->values[i],
                    (double)clear->values[i]);
            return false;
        }
    return true;
}

static bool shows_radiance(al_pass pass)
{
    return pass == AL_PASS_COMPOSITE || pass == AL_PASS_TRANSLUCENT || pass == AL_PASS_SURFACE ||
           pass == AL_PASS_DIRECT_SCATTERING || pass == AL_PASS_SURFACE_SCATTERING || pass == AL_PASS_SURFELS ||
           pass == AL_PASS_INDIRECT || pass == AL_PASS_BLURRED;
}

static double expected_factor(al_pass pass, const random_change *change)
{
    const bool distance = pass == AL_PASS_INTERVAL_MAP || pass == AL_PASS_BOUNCE_HITS;
    return ldexp(1, distance ? change->size : shows_radiance(pass) ? change->strength : 0);
}

static bool check_scene(uint32_t index, uint64_t seed)
{
    static const random_change none = {0};
    static picture first, second;
    static random_scene scene, other;
    random_change change = {0};
    if (!random_scene_write(folder, seed, index, &none, &scene)) return false;
    count_drawn(&scene);
    draw(&scene, &first);
    draw(&scene, &second);
    if (first.status) count_refusal(first.error.message);
    if (first.status && (!*first.error.message || strchr(first.error.message, '\n') || first.status > AL_BAD_INPUT ||
                         strcmp(first.error.message, second.error.message) != 0)) {
        fprintf(stderr, "refused with status %d: %s\n", (int)first.status, first.error.message);
        return false;
    }
    if (!check_same(&first, &second, 1) || !check_finite(&first) || !check_share(&scene, &first) ||
        !check_furnace(&scene, &first))
        return false;
    if (scene.kind == RANDOM_BLACK) {
        change.fog_left_out = true;
    } else if (index % 2 && scene.kind == RANDOM_ANY) {
        change.strength = 10;
    } else {
        change.size = scene.unit > 1 ? -10 : 10;
    }
    if (!random_scene_write(folder, seed, index, &change, &other)) return false;
    draw(&other, &second);
    if (scene.kind == RANDOM_BLACK) return check_absorbed(&scene, &first, &second);
    return check_same(&first, &second, expected_factor(scene.settings.pass, &change));
}

static void test_scene(uint32_t index, uint64_t seed)
{
    test_checks++;
    if (check_scene(index, seed)) return;
    test_failures++;
    fprintf(stderr, "failed: scene %u of seed %llu\n", index, (unsigned long long)seed);
}

int main(int argc, char **argv)
{
    uint64_t seed = 1;
    uint32_t from = 0, count = 200;
    for (int i = 1; i + 1 < argc; i += 2) {
        if (!strcmp(argv[i], "--seed")) seed = strtoull(argv[i + 1], NULL, 10);
        if (!strcmp(argv[i], "--from")) from = (uint32_t)strtoul(argv[i + 1], NULL, 10);
        if (!strcmp(argv[i], "--count")) count = (uint32_t)strtoul(argv[i + 1], NULL, 10);
    }
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    folder = stage_folder();
    al_error error = {0};
    CHECK(folder && al_runtime_create(NULL, &runtime, &error) == AL_OK);
    if (!runtime) return test_end();
    glCreateTextures(GL_TEXTURE_2D, 1, &texture);
    glTextureStorage2D(texture, 1, GL_RGBA32F, 16, 16);
    glCreateFramebuffers(1, &framebuffer);
    glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, texture, 0);
    for (uint32_t i = from; i < from + count; i++) {
        test_scene(i, seed);
        if ((i + 1 - from) % 500 == 0) {
            printf("%u scenes, %d refused, %d failed\n", i + 1 - from, refused, test_failures);
            fflush(stdout);
        }
    }
    print_refusals();
    printf("%d with surfaces, %d fogs, %d translucent objects, %d lamps or suns, %d a sky, %d probes, %d history; %d all passes\n",
           drawn.surfaces, drawn.fogs, drawn.objects, drawn.lights, drawn.sky, drawn.probes, drawn.history, drawn.composite);
    printf("%d furnaces, %d with fogs that absorb\n", drawn.furnace, drawn.black);
    for (size_t i = 0; i < sizeof known / sizeof *known && argc == 1; i++) {
        const int before = test_failures;
        test_scene(known[i].index, 1);
        if (test_failures > before) fprintf(stderr, "again: %s\n", known[i].what);
    }
    printf("seed %llu, scenes %u to %u: %d refused\n", (unsigned long long)seed, from, from + count - 1, refused);
    al_runtime_destroy(runtime);
    return test_end();
}
