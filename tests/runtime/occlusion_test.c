/* Ambient occlusion against closed forms: a sphere over a plane, and a wall on a plane. A receiver's share of its
 * cosine-weighted hemisphere that is hidden is
 *   R^2 H / d^3 by a sphere of radius R whose middle is H over the plane and d away, where all of it is above the plane;
 *   1/2 (1 - x / sqrt(x^2 + h^2)) by a wall without ends, h high and x away;
 *   (acos c - c sqrt(1 - c^2)) / pi, c = x / R, by what is nearer than R <= h of it: directions w with w_x > c, whose
 *   projection to the plane is a segment of the unit circle.
 * Summed over the plane's pixels. With surfels, a share exp(-3) of the rays passes between discs of three times the area at most, and
 * none reaches farther than its radius r from the surface it touches: a sphere's to sqrt(R^2 + r^2), a wall's to h + r. So
 * the sum lies between these two, and three standard deviations of the number of rays that hit. Volumes find the triangles
 * themselves: the sphere's lie between it and a sphere of radius R cos a, a half the diagonal of a facet's angles. Blended, the
 * wall's two triangles have no noise either, and each pixel is right but for what is missing beyond the wall's ends, which are
 * L = 8 m away at least: twice the integral from L of x h^2 / (2 pi y^4) dy at most, x h^2 / (3 pi L^3). */
#include <epoxy/gl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../../runtime/state.h"
#include "../test.h"
#include "airlight/formulas.h"
#include "sphere.h"
#include "stage.h"

enum { EDGE = 32, SAMPLES = 8 };
static const double radius = 0.5, height = 0.8, wall = 1, near_m = 0.75;
/* Of a disc of 1 pixel at 5.2 m, the view's farthest part of a blocker, times sqrt(3). */
static const double reach = 1.732 * 5.2 * 2 * 0.3093 / EDGE;

static double hidden_by_sphere(const double at[3], double reach_m)
{
    double d = sqrt(at[0] * at[0] + height * height + at[2] * at[2]);
    return (radius * radius + reach_m * reach_m) * height / (d * d * d);
}

static double hidden_by_polyhedron(const double at[3], double reach_m)
{
    double shrunk = cos(0.5 * sqrt(pow(2 * AL_PI / 96, 2) + pow(AL_PI / 48, 2))); /* sphere.c */
    return shrunk * shrunk * hidden_by_sphere(at, reach_m);
}

static double hidden_by_near_wall(const double at[3], double reach_m)
{
    double c = fabs(at[2]) / near_m;
    (void)reach_m;
    return c < 1 ? (acos(c) - c * sqrt(1 - c * c)) / AL_PI : 0;
}

static double hidden_by_wall(const double at[3], double reach_m)
{
    double h = wall + reach_m; /* on either side */
    return 0.5 * (1 - fabs(at[2]) / sqrt(at[2] * at[2] + h * h));
}

static bool open_scene(al_runtime *runtime, const char *folder, bool sphere)
{
    sphere_scene s;
    sphere_scene_begin(&s);
    s.scene.baked = (al_baked_light){"", ""};
    sphere_scene_add_floor(&s, 6, (float[3]){0, 0, 0});
    sphere_scene_add_floor(&s, (float)radius, (float[3]){0, (float)height, 0});
    al_instance *blocker = &s.instances[1];
    if (sphere)
        blocker->mesh = 0;
    else
        memcpy(blocker->world, (float[16]){20, 0, 0, 0, 0, 0, 1, 0, 0, -(float)wall, 0, 0, 0, (float)wall / 2, 0, 1},
               sizeof blocker->world);
    bool good = sphere_scene_write(folder, &s) && stage_load(runtime, folder);
    sphere_scene_end(&s);
    return good;
}

/* Where the pixel's ray meets the plane y = 0. */
static void place_of(const al_frame_block *frame, uint32_t pixel, double at[3])
{
    double x = pixel % EDGE + 0.5, y = pixel / EDGE + 0.5, origin[3], view[3];
    for (int k = 0; k < 3; k++) {
        origin[k] = frame->ray[0][k] + x * frame->ray[1][k] + y * frame->ray[2][k];
        view[k] = frame->ray[3][k] + x * frame->ray[4][k] + y * frame->ray[5][k];
    }
    for (int k = 0; k < 3; k++) at[k] = origin[k] - origin[1] / view[1] * view[k];
}

typedef double hidden(const double at[3], double reach_m);

static void check_hidden(al_runtime *runtime, const al_settings *settings, hidden *least, hidden *greatest)
{
    static float geometry[EDGE * EDGE][4];
    al_view view = stage_look(EDGE, EDGE, (float[3]){0, 3, 4}, (float[3]){0, 0.3f, 0.8f}, 0.6f);
    al_frame_block frame;
    bool surfels = settings->occlusion_carrier == AL_CARRIER_SURFELS, sums = settings->occlusion_carrier == AL_CARRIER_VOLUMES_BLENDED,
         discs = settings->occlusion_carrier == AL_CARRIER_SURFELS_BLENDED;
    float *pixels = stage_draw(runtime, &view, settings, 0);
    double hides = 0, expected = 0, most = 0;
    CHECK(pixels != NULL);
    if (!pixels) return;
    CHECK(!stage_bad(pixels, EDGE * EDGE * 3));
    glGetNamedBufferSubData(runtime->frame_block.id, 0, sizeof frame, &frame);
    glGetTextureImage(runtime->targets.geometry.id, 0, GL_RGBA, GL_FLOAT, sizeof geometry, geometry);
    for (uint32_t i = 0; i < EDGE * EDGE; i++) {
        double at[3];
        if (geometry[i][1] < 0.999f) continue;
        place_of(&frame, i, at);
        hides += 1 - (double)pixels[3 * i];
        expected += least(at, 0);
        most += greatest(at, surfels ? reach : 0);
        if (sums) CHECK_NEAR(1 - (double)pixels[3 * i], greatest(at, 0), 2e-5 + fabs(at[2]) / (3 * AL_PI * 512));
    }
    free(pixels);
    /* Rays that meet or not; or surfels laid at random, each of which hides much the same. */
    double noise = sums ? 0 : discs ? 3 / sqrt((double)al_surfels_count(runtime)) * expected : 3 / sqrt(SAMPLES * expected) * expected;
    printf("hidden %.4f of the closed form, %.4f of the bound above; noise %.4f\n", hides / expected,
           hides / most, noise / expected);
    if (sums) return;
    CHECK(hides > expected * (surfels ? 1 - exp(-3) : 1) - noise);
    CHECK(hides < most + noise);
}

/* Everything that may hide, and what is near. */
static void check_carriers(al_runtime *runtime, al_settings settings, bool sphere)
{
    hidden *greatest = sphere ? hidden_by_sphere : hidden_by_wall;
    for (int i = 0; i < 3; i++) {
        settings.occlusion_uniform = i == 1;
        settings.bounce_filter_off = i < 2;
        settings.shell_levels = i == 2 ? 6 : 1;
        settings.occlusion_carrier = AL_CARRIER_SURFELS;
        check_hidden(runtime, &settings, greatest, greatest);
        settings.occlusion_carrier = AL_CARRIER_VOLUMES;
        check_hidden(runtime, &settings, sphere ? hidden_by_polyhedron : greatest, greatest);
    }
    if (sphere) return;
    settings.occlusion_carrier = AL_CARRIER_VOLUMES_BLENDED;
    check_hidden(runtime, &settings, hidden_by_wall, hidden_by_wall);
    settings.occlusion_radius_m = (float)near_m;
    settings.bounce_filter_off = true;
    for (settings.occlusion_carrier = 0; settings.occlusion_carrier < AL_CARRIER_SCREEN; settings.occlusion_carrier++)
        check_hidden(runtime, &settings, hidden_by_near_wall, hidden_by_near_wall);
}

/* The last rays as the passes show them: of length one, away from the plane, and to the sphere where they hit; a disc
 * touches it and reaches `reach` from there. */
static void check_rays(al_runtime *runtime, al_settings settings)
{
    al_view view = stage_look(EDGE, EDGE, (float[3]){0, 3, 4}, (float[3]){0, 0.3f, 0.8f}, 0.6f);
    static float geometry[EDGE * EDGE][4];
    al_frame_block frame;
    settings.shell_levels = 1; /* further ones enlarge discs */
    settings.pass = AL_PASS_BOUNCE_RAYS;
    float *rays = stage_draw(runtime, &view, &settings, 0);
    runtime->frame_number--; /* the same rays once more */
    settings.pass = AL_PASS_BOUNCE_HITS;
    float *hits = stage_draw(runtime, &view, &settings, 0);
    uint32_t count = 0;
    CHECK(rays && hits);
    glGetNamedBufferSubData(runtime->frame_block.id, 0, sizeof frame, &frame);
    glGetTextureImage(runtime->targets.geometry.id, 0, GL_RGBA, GL_FLOAT, sizeof geometry, geometry);
    for (uint32_t i = 0; rays && hits && i < EDGE * EDGE; i++) {
        double at[3], length = 0, away = 0;
        if (geometry[i][1] < 0.999f) continue;
        CHECK(rays[3 * i + 1] > 0.5f);
        place_of(&frame, i, at);
        at[1] -= height;
        for (int k = 0; k < 3; k++) {
            double d = 2 * (double)rays[3 * i + (uint32_t)k] - 1, p = at[k] + d * (double)hits[3 * i];
            length += d * d;
            away += p * p;
        }
        CHECK(fabs(length - 1) < 1e-5);
        if (hits[3 * i] <= 0) continue;
        count++;
        CHECK(sqrt(away) > radius - reach && sqrt(away) < sqrt(radius * radius + reach * reach) + 1e-4);
    }
    CHECK(count > 10);
    free(rays);
    free(hits);
}

int main(void)
{
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    const char *folder = stage_folder();
    al_runtime *runtime = NULL;
    al_error error = {0};
    CHECK(folder != NULL);
    if (!folder) return test_end();
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK);
    const al_settings settings = {.pass = AL_PASS_AMBIENT_OCCLUSION, .surfel_pixels = 1, .bounce_samples = SAMPLES};
    for (int sphere = 0; sphere < 2; sphere++) {
        CHECK(open_scene(runtime, folder, sphere));
        check_carriers(runtime, settings, sphere);
        if (sphere) check_rays(runtime, settings);
    }
    al_runtime_destroy(runtime);
    return test_end();
}
