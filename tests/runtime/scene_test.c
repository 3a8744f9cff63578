/* What stands together in a scene: shadows both ways, objects behind objects, the host's depth, rigid motion,
 * environment light. Expected values are closed forms; bounds name what they allow for. */
#include <epoxy/gl.h>
#include <stdlib.h>
#include <string.h>

#include "../test.h"
#include "airlight/formulas.h"
#include "sphere.h"
#include "stage.h"

enum { EDGE = 65 };

typedef struct fixture {
    const char *folder;
    sphere_scene s;
    al_runtime *runtime;
} fixture;

static const al_settings plain = {.surface_off = true};

static void begin(fixture *f, const sphere_options *options)
{
    CHECK(sphere_write_asset(f->folder, "sphere.air", options));
    sphere_scene_begin(&f->s);
}

static void load(fixture *f)
{
    al_error error = {0};
    CHECK(sphere_scene_write(f->folder, &f->s));
    CHECK(al_runtime_create(NULL, &f->runtime, &error) == AL_OK);
    CHECK(stage_load(f->runtime, f->folder));
}

static void end(fixture *f)
{
    al_runtime_destroy(f->runtime);
    sphere_scene_end(&f->s);
}

/* Mean over frames of what `view` shows; first row at the bottom. */
static void average(fixture *f, const al_view *view, const al_settings *settings, uint32_t depth, int frames,
                    double *image)
{
    size_t count = (size_t)view->width * view->height * 3;
    memset(image, 0, count * sizeof *image);
    for (int frame = 0; frame < frames; frame++) {
        float *pixels = stage_draw(f->runtime, view, settings, depth);
        CHECK(pixels && stage_bad(pixels, count) == 0);
        for (size_t i = 0; pixels && i < count; i++) image[i] += pixels[i] / frames;
        free(pixels);
    }
}

static double at(const double *image, int x, int y)
{
    return image[3 * (y * EDGE + x)];
}

/* Light falls straight down through a coloured sphere of radius 0.5 onto a white floor seen from the side:
 * its radiance is E/pi times exp(-sigma_c * chord), E/pi beside the sphere. */
static void test_tinted_shadow(fixture *f)
{
    static double image[EDGE * EDGE * 3];
    const float sigma[3] = {1, 2, 4};
    begin(f, &(sphere_options){.radius = 0.5f, .sigma_t = {1, 2, 4}, .samples = 500});
    sphere_scene_add(&f->s, "sphere.air", 0.5f, (float[3]){0, 0.6f, 0});
    sphere_scene_add_floor(&f->s, 4, (float[3]){0, 0, 0});
    sphere_scene_add_light(&f->s, AL_LIGHT_DIRECTIONAL, (float[3]){0, -1, 0}, (float)AL_PI);
    load(f);
    /* From below the sphere's side towards the floor's middle. */
    al_view view = stage_look(EDGE, EDGE, (float[3]){3, 0.3f, 0}, (float[3]){0, 0, 0}, 0.05f);
    average(f, &view, &(al_settings){.surface_off = true, .pass = AL_PASS_SURFACE}, 0, 1, image);
    /* Trilinear voxels of 1/61 m lose at most a voxel's optical depth at both ends; the lobe of the
     * index-matched white floor is nothing. */
    for (int c = 0; c < 3; c++) CHECK_NEAR(image[3 * (EDGE / 2 * EDGE + EDGE / 2) + c], exp(-sigma[c]), 0.02);
    view = stage_look(EDGE, EDGE, (float[3]){3, 0.3f, 1.2f}, (float[3]){0, 0, 1.2f}, 0.05f);
    average(f, &view, &(al_settings){.surface_off = true, .pass = AL_PASS_SURFACE}, 0, 1, image);
    CHECK_NEAR(at(image, EDGE / 2, EDGE / 2), 1, 1e-4);
    end(f);
}

/* A square between light and sphere takes all light from it; moved away, it takes none. */
static void test_opaque_shadow(fixture *f, al_light_type type)
{
    static double image[EDGE * EDGE * 3];
    begin(f, &(sphere_options){.radius = 0.5f, .samples = 500});
    sphere_scene_add(&f->s, "sphere.air", 0.5f, (float[3]){0, 0, 0});
    sphere_scene_add_floor(&f->s, 3, (float[3]){0, 1.5f, 0});
    sphere_scene_add_light(&f->s, type,
                           type == AL_LIGHT_POINT ? (float[3]){0.1f, 3, 0} : (float[3]){0.05f, -1, 0}, 9);
    load(f);
    al_view view = stage_ortho(EDGE, EDGE, 0.6f);
    average(f, &view, &(al_settings){.pass = AL_PASS_TRANSLUCENT}, 0, 1, image);
    CHECK(at(image, EDGE / 2, EDGE / 2) == 0);
    average(f, &view, &(al_settings){.pass = AL_PASS_TRANSLUCENT, .shadows_off = true}, 0, 1, image);
    double lit = at(image, EDGE / 2, EDGE / 2);
    CHECK(lit > 0);
    al_runtime_scene(f->runtime)->instances[1].world[12] = 20;
    average(f, &view, &(al_settings){.pass = AL_PASS_TRANSLUCENT}, 0, 1, image);
    CHECK_NEAR(at(image, EDGE / 2, EDGE / 2), lit, 1e-3 * lit); /* but for the jitter of the march */
    end(f);
}

/* An unlit sphere of optical depth 2 in front of a lit one, of depth 2 too, dims it by exp(-2), and dims the
 * background; the lit one in front hides nothing of itself. The order in the file does not matter. */
static void test_order(fixture *f, bool swapped)
{
    static double image[EDGE * EDGE * 3], alone[EDGE * EDGE * 3];
    const float front[3] = {0, 0, 2}, back[3] = {0, 0, -2};
    begin(f, &(sphere_options){.radius = 0.5f, .samples = 2000, .grid = 64});
    sphere_scene_add(&f->s, "sphere.air", 0.5f, swapped ? front : back);
    sphere_scene_add(&f->s, "sphere.air", 0.5f, swapped ? back : front);
    /* So near behind the hind sphere that the front one gets next to nothing of it. */
    sphere_scene_add_light(&f->s, AL_LIGHT_POINT, (float[3]){0, 0, -2.7f}, 1);
    load(f);
    al_view view = stage_ortho(EDGE, EDGE, 0.6f);
    al_scene *scene = al_runtime_scene(f->runtime);
    average(f, &view, &(al_settings){.pass = AL_PASS_TRANSLUCENT, .shadows_off = true}, 0, 8, image);
    scene->instances[swapped ? 0 : 1].world[12] = 30; /* away with the front one */
    average(f, &view, &(al_settings){.pass = AL_PASS_TRANSLUCENT, .shadows_off = true}, 0, 8, alone);
    double behind = at(alone, EDGE / 2, EDGE / 2);
    scene->instances[swapped ? 0 : 1].world[12] = 0;
    scene->instances[swapped ? 1 : 0].world[12] = 30;
    average(f, &view, &(al_settings){.pass = AL_PASS_TRANSLUCENT, .shadows_off = true}, 0, 8, alone);
    double before = at(alone, EDGE / 2, EDGE / 2);
    /* exp(-2) within a voxel's optical depth at each end, 2 * 2 / 61. */
    CHECK_NEAR((at(image, EDGE / 2, EDGE / 2) - before) / behind, exp(-2), exp(-2) * 0.06);
    end(f);
}

/* The background shows through with exp(-sigma * chord); composite is translucent plus surface. */
static void test_background(fixture *f)
{
    static double image[EDGE * EDGE * 3], translucent[EDGE * EDGE * 3];
    begin(f, &(sphere_options){.radius = 0.5f, .sigma_t = {3}, .samples = 500});
    sphere_scene_add(&f->s, "sphere.air", 0.5f, (float[3]){0, 0, 0});
    for (int k = 0; k < 3; k++) f->s.scene.play.background[k] = 2;
    load(f);
    al_view view = stage_ortho(EDGE, EDGE, 0.6f);
    average(f, &view, &plain, 0, 1, image);
    average(f, &view, &(al_settings){.pass = AL_PASS_TRANSLUCENT}, 0, 1, translucent);
    CHECK_NEAR(at(image, EDGE / 2, EDGE / 2), 2 * exp(-3),
               2 * exp(-3) * 0.1); /* a voxel at each end: 2 * 3 / 61 */
    CHECK_NEAR(at(image, 1, 1), 2, 1e-6);
    CHECK(at(translucent, EDGE / 2, EDGE / 2) == 0); /* no light */
    average(f, &view, &(al_settings){.surface_off = true, .background_off = true}, 0, 1, image);
    CHECK(at(image, 1, 1) == 0 && at(image, EDGE / 2, EDGE / 2) == 0);
    end(f);
}

/* A sphere whose far half is opaque: nothing shines through, the medium ends in its middle, the near half
 * still scatters, and the shadow below is black. */
static void test_blockers(fixture *f)
{
    static double image[EDGE * EDGE * 3];
    begin(f, &(sphere_options){.radius = 0.5f, .samples = 500, .blocked = true});
    sphere_scene_add(&f->s, "sphere.air", 0.5f, (float[3]){0, 0, 0});
    sphere_scene_add_floor(&f->s, 4, (float[3]){0, -0.6f, 0});
    sphere_scene_add_light(&f->s, AL_LIGHT_DIRECTIONAL, (float[3]){0, -1, 0}, 1);
    for (int k = 0; k < 3; k++) f->s.scene.play.background[k] = 2;
    load(f);
    al_view view = stage_ortho(EDGE, EDGE, 0.6f);
    average(f, &view, &plain, 0, 1, image);
    double all = at(image, EDGE / 2, EDGE / 2);
    average(f, &view, &(al_settings){.pass = AL_PASS_TRANSLUCENT}, 0, 1, image);
    CHECK(at(image, EDGE / 2, EDGE / 2) > 0);
    CHECK_NEAR(all, at(image, EDGE / 2, EDGE / 2), 1e-3 * all);
    average(f, &view, &(al_settings){.pass = AL_PASS_INTERVALS, .interval_count = 4}, 0, 1, image);
    /* Of depth 1 the transmittance has fallen by 2/3 of its whole fall at 0.55 of the way from 4.5 m to 5 m.
     */
    double third = -log(1 - (1 - exp(-1)) * 2 / 3) / 2;
    CHECK_NEAR(image[3 * (EDGE / 2 * EDGE + EDGE / 2) + 2], 4.5 + third, 1.0 / 61);
    view = stage_look(EDGE, EDGE, (float[3]){3, -0.1f, -0.25f}, (float[3]){0, -0.6f, -0.25f}, 0.05f);
    average(f, &view, &(al_settings){.surface_off = true, .pass = AL_PASS_SURFACE}, 0, 1, image);
    CHECK(at(image, EDGE / 2, EDGE / 2) == 0);
    end(f);
}

/* Even light L from all around, no absorption, optically thin: single scattering sends sigma_s * chord * L,
 * less what is lost on the way, below the optical depth 0.02. The same from the product with a forward lobe.
 */
static void test_environment(fixture *f, float g)
{
    static double image[EDGE * EDGE * 3];
    begin(f, &(sphere_options){
                 .radius = 0.5f, .sigma_t = {0.02f}, .albedo = 1, .g = g, .samples = 2000, .order = 8});
    sphere_scene_add(&f->s, "sphere.air", 0.5f, (float[3]){0, 0, 0});
    for (int c = 0; c < 3; c++) f->s.scene.environment.sh[c][0] = (float)(3 * sqrt(4 * AL_PI));
    load(f);
    al_view view = stage_ortho(EDGE, EDGE, 0.6f);
    average(f, &view, &(al_settings){.surface_off = true, .pass = AL_PASS_TRANSLUCENT}, 0, 4, image);
    CHECK_NEAR(at(image, EDGE / 2, EDGE / 2) / (3 * 0.02), 1,
               0.03); /* losses, and a voxel of 2/61 of the chord */
    /* The background shines through, and all together stay at 3: nothing is absorbed. */
    average(f, &view, &plain, 0, 4, image);
    CHECK_NEAR(at(image, EDGE / 2, EDGE / 2), 3, 3 * 0.02 * 0.05);
    end(f);
}

/* Object, light and camera turned together show the same picture. */
static void test_motion(fixture *f)
{
    static double image[EDGE * EDGE * 3], turned[EDGE * EDGE * 3];
    begin(f, &(sphere_options){.samples = 1000, .g = 0.4f});
    sphere_scene_add(&f->s, "sphere.air", 1, (float[3]){0, 0, 0});
    sphere_scene_add_light(&f->s, AL_LIGHT_DIRECTIONAL, (float[3]){1, 0, 0}, 1);
    f->s.scene.environment.sh[0][2] = 0.2f; /* band 1 along z, on top of band 0 */
    f->s.scene.environment.sh[0][0] = 1;
    load(f);
    al_view view = stage_look(EDGE, EDGE, (float[3]){0, 0, 4}, (float[3]){0, 0, 0}, 0.6f);
    average(f, &view, &(al_settings){.surface_off = true, .pass = AL_PASS_TRANSLUCENT}, 0, 4, image);
    /* A quarter turn about y, (x, y, z) to (z, y, -x), and a shift. */
    al_scene *scene = al_runtime_scene(f->runtime);
    static const float world[16] = {0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 7, 8, 9, 1};
    memcpy(scene->instances[0].world, world, sizeof world);
    memcpy(scene->lights[0].vector, (float[3]){0, 0, -1}, 12);
    scene->environment.sh[0][2] = 0;
    scene->environment.sh[0][3] = 0.2f;
    view = stage_look(EDGE, EDGE, (float[3]){11, 8, 9}, (float[3]){7, 8, 9}, 0.6f);
    average(f, &view, &(al_settings){.surface_off = true, .pass = AL_PASS_TRANSLUCENT}, 0, 4, turned);
    double worst = 0, most = 0;
    for (int i = 0; i < EDGE * EDGE; i++) {
        double x = i % EDGE - EDGE / 2, y = i / EDGE - EDGE / 2;
        if (x * x + y * y > 20 * 20) continue; /* the rim's pixels may fall to either side */
        worst = fmax(worst, fabs(turned[3 * i] - image[3 * i]));
        most = fmax(most, image[3 * i]);
    }
    /* Rounding at 11 m from the origin, and the march's jitter over 4 frames. */
    CHECK_NEAR(worst, 0, 0.01 * most);
    end(f);
}

/* The host's wall before the object hides it and keeps its colour; a wall through its middle hides the rest.
 */
static void test_host_depth(fixture *f)
{
    GLuint depth, color, framebuffer;
    al_error error = {0};
    begin(f, &(sphere_options){.radius = 0.5f, .sigma_t = {3}, .samples = 500});
    sphere_scene_add(&f->s, "sphere.air", 0.5f, (float[3]){0, 0, 0});
    load(f);
    al_view view = stage_ortho(EDGE, EDGE, 0.6f);
    glCreateTextures(GL_TEXTURE_2D, 1, &depth);
    glTextureStorage2D(depth, 1, GL_DEPTH_COMPONENT32F, EDGE, EDGE);
    glCreateTextures(GL_TEXTURE_2D, 1, &color);
    glTextureStorage2D(color, 1, GL_RGBA32F, EDGE, EDGE);
    glCreateFramebuffers(1, &framebuffer);
    glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, color, 0);
    glNamedFramebufferTexture(framebuffer, GL_DEPTH_ATTACHMENT, depth, 0);
    const struct {
        float z;
        double wanted;
    } walls[] = {{1, 5}, {0, 5 * exp(-1.5)}, {-1, 5 * exp(-3)}};
    for (size_t i = 0; i < sizeof walls / sizeof walls[0]; i++) {
        float pixels[EDGE * EDGE * 4], clip = (5 - walls[i].z) / 10;
        glClearNamedFramebufferfv(framebuffer, GL_COLOR, 0, (float[4]){5, 5, 5, 1});
        glClearNamedFramebufferfv(framebuffer, GL_DEPTH, 0, &clip);
        CHECK(al_runtime_draw(f->runtime, &view, &plain, framebuffer, depth, &error) == AL_OK);
        glGetTextureImage(color, 0, GL_RGBA, GL_FLOAT, sizeof pixels, pixels);
        CHECK_NEAR(pixels[4 * (EDGE / 2 * EDGE + EDGE / 2)], walls[i].wanted, walls[i].wanted * 0.06);
        CHECK(pixels[0] == 5);
    }
    glDeleteFramebuffers(1, &framebuffer);
    glDeleteTextures(1, &depth);
    glDeleteTextures(1, &color);
    end(f);
}

/* Normal and distance of the nearest surface, and the sum of Gaussians. */
static void test_passes(fixture *f)
{
    static double image[EDGE * EDGE * 3];
    begin(f, &(sphere_options){.radius = 0.5f, .samples = 4000});
    sphere_scene_add(&f->s, "sphere.air", 0.5f, (float[3]){0, 0, 0});
    sphere_scene_add_floor(&f->s, 8, (float[3]){0, -0.52f, 0});
    load(f);
    al_view view = stage_look(EDGE, EDGE, (float[3]){0, 0, 3}, (float[3]){0, 0, 0}, 0.5f);
    average(f, &view, &(al_settings){.pass = AL_PASS_DEPTH}, 0, 1, image);
    CHECK_NEAR(at(image, EDGE / 2, EDGE / 2), 2.5, 2e-3); /* facets of a 96-gon */
    average(f, &view, &(al_settings){.pass = AL_PASS_NORMAL}, 0, 1, image);
    CHECK_NEAR(image[3 * (EDGE / 2 * EDGE + EDGE / 2) + 2], 1, 1e-3);
    CHECK_NEAR(image[3 * (2 * EDGE + 2) + 1], 1, 1e-5); /* the floor's corner */
    al_runtime_scene(f->runtime)->instances[1].world[0] *= -1; /* mirrored, the floor still faces up */
    average(f, &view, &(al_settings){.pass = AL_PASS_NORMAL}, 0, 1, image);
    CHECK_NEAR(image[3 * (2 * EDGE + 2) + 1], 1, 1e-5);
    average(f, &view, &(al_settings){.pass = AL_PASS_INTERVALS}, 0, 1, image);
    const double *knots = image + 3 * (EDGE / 2 * EDGE + EDGE / 2);
    CHECK(knots[0] < knots[1] && knots[1] < knots[2]);
    CHECK_NEAR(knots[0], 2.5, 0.02);
    average(f, &view, &(al_settings){.pass = AL_PASS_UNITY}, 0, 1, image);
    /* Half of the outermost Gaussians lies outside: over a chord of 16 spacings s that takes 2 * 0.4 * 0.55
     * s. */
    CHECK_NEAR(at(image, EDGE / 2, EDGE / 2), 1 - 0.44 / 16, 0.05);
    end(f);
}

int main(void)
{
    fixture f = {0};
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    f.folder = stage_folder();
    test_tinted_shadow(&f);
    test_opaque_shadow(&f, AL_LIGHT_DIRECTIONAL);
    test_opaque_shadow(&f, AL_LIGHT_POINT);
    test_order(&f, false);
    test_order(&f, true);
    test_background(&f);
    test_blockers(&f);
    test_environment(&f, 0);
    test_environment(&f, 0.6f);
    test_motion(&f);
    test_host_depth(&f);
    test_passes(&f);
    return test_end();
}
