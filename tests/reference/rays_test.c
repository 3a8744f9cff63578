/* Rays against surfaces: points, sides, colours, offsets, emitters. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdarg.h>
#include <string.h>

#include "../test.h"
#include "airlight/formulas.h"
#include "airlight/image.h"
#include "emitters.h"
#include "scene_for_test.h"

typedef struct rays {
    al_import *import;
    al_ray_scene *scene;
} rays;

AL_PRINTF(2, 3)
static rays open_rays(al_ray_scene_content content, const char *format, ...)
{
    char json[2048];
    rays made;
    al_error error = {0};
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(json, sizeof json, format, arguments);
    va_end(arguments);
    made.import = import_scene(json);
    CHECK(al_ray_scene_create(made.import, content, &made.scene, &error) == AL_OK);
    return made;
}

static void close_rays(rays *r)
{
    al_ray_scene_free(r->scene);
    al_import_free(r->import);
}

/* Evenly over the sphere. */
static void random_direction(al_random *random, double direction[3])
{
    double z = 2 * al_random_real(random) - 1, phi = 2 * AL_PI * al_random_real(random), s = sqrt(1 - z * z);
    direction[0] = s * cos(phi), direction[1] = s * sin(phi), direction[2] = z;
}

/* Reflected off the walls of a closed box 20 000 times, a ray must neither leave it nor meet the wall it
 * comes from: sizes, places and shapes (1 to 100). */
static void test_offset(void)
{
    static const double scales[] = {1e-4, 1, 1e4}, places[] = {0, 3, 1000};
    for (int i = 0; i < 9; i++) {
        double scale = scales[i / 3], place = places[i % 3] * scale, half[3] = {0.5, 0.5, 50};
        rays r = open_rays(AL_RAY_SCENE_ALL,
                           "{'meshes':[{'name':'b','shape':{'type':'box','size_m':[%.9g,%.9g,%.9g]},'"
                           "transform':{'translate_m':[%.9g,0,0]}}]}",
                           scale, scale, 100 * scale, place);
        al_random random = al_random_for(5, (uint64_t)i);
        al_ray ray = {.origin = {place, 0, 0}};
        random_direction(&random, ray.direction);
        int misses = 0, again = 0, off = 0, backs = 0;
        uint32_t last = AL_NO_INDEX;
        for (int n = 0; n < 20000; n++) {
            al_surface_hit hit;
            if (!al_ray_scene_hit(r.scene, &ray, INFINITY, &hit)) {
                misses++;
                break;
            }
            int axis = fabs(hit.normal[0]) > 0.5 ? 0 : fabs(hit.normal[1]) > 0.5 ? 1 : 2;
            double wall = (axis == 0 ? place : 0) + copysign(half[axis] * scale, hit.normal[axis]);
            /* vertices and matrices are floats */
            off += fabs(hit.position[axis] - wall) > 0x1p-23 * (fabs(wall) + scale);
            backs += !hit.front;
            again += hit.triangle == last;
            last = hit.triangle;
            random_direction(&random, ray.direction);
            double inwards = 0;
            for (int k = 0; k < 3; k++) inwards -= hit.normal[k] * ray.direction[k];
            if (inwards < 0)
                for (int k = 0; k < 3; k++) ray.direction[k] = -ray.direction[k];
            al_surface_offset(&hit, ray.direction, ray.origin);
        }
        CHECK(misses == 0);
        CHECK(again == 0);
        CHECK(off == 0);
        CHECK(backs == 20000); /* a box faces outwards */
        close_rays(&r);
    }
}

static void write_text(const char *path, const char *text)
{
    FILE *file = fopen(path, "w");
    CHECK(file && fputs(text, file) >= 0 && fclose(file) == 0);
}

/* A square of texels 0 and 255: base colour half and half, emission in two texels of four. */
static void test_colors(void)
{
    static const uint8_t pixels[2][2][3] = {{{255, 0, 188}, {0, 0, 188}}, {{0, 255, 188}, {0, 255, 188}}};
    al_error error = {0};
    CHECK(al_image_write_png("rays_texture.png", 2, 2, 3, &pixels[0][0][0], &error) == AL_OK);
    write_text("rays.mtl",
               "newmtl m\nKd 1 0.5 1\nKe 2 4 1\nmap_Kd rays_texture.png\nmap_Ke rays_texture.png\n");
    write_text("rays.obj",
               "mtllib rays.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\n"
               "vt 0 1\nf 1/1 2/2 3/3 4/4\n");
    rays r = open_rays(AL_RAY_SCENE_ALL, "{'meshes':[{'name':'s','file':'rays.obj'}]}");
    al_ray ray = ray_along(0.25, 0.75, 1, 0, 0, -1); /* the upper left texel's centre */
    al_surface_hit hit;
    double blue = pow((188 / 255.0 + 0.055) / 1.055, 2.4);
    CHECK(al_ray_scene_hit(r.scene, &ray, 2, &hit));
    CHECK(!al_ray_scene_hit(r.scene, &ray, 0.99, &hit) && al_ray_scene_hit(r.scene, &ray, 1.01, &hit));
    CHECK(hit.front && hit.normal[2] == 1 && hit.shading_normal[2] == 1 && hit.distance_m == 1);
    CHECK_NEAR(hit.albedo[0], 1, 1e-6);
    CHECK_NEAR(hit.albedo[1], 0, 1e-6);
    CHECK_NEAR(hit.albedo[2], blue, 1e-6);
    CHECK_NEAR(hit.emission_w_m2_sr[0], 2, 1e-5);
    CHECK_NEAR(hit.emission_w_m2_sr[2], blue, 1e-6);
    ray = ray_along(0.375, 0.75, -1, 0, 0,
                    1); /* a quarter of the way to the next, from behind: no light there */
    CHECK(al_ray_scene_hit(r.scene, &ray, 2, &hit));
    CHECK(!hit.front && hit.normal[2] == 1);
    CHECK_NEAR(hit.albedo[0], 0.75, 1e-6);
    CHECK(hit.emission_w_m2_sr[0] == 0);
    ray = ray_along(0.5, 0.999999, 1, 0, 0, -1); /* textures repeat: half of the lowest row */
    CHECK(al_ray_scene_hit(r.scene, &ray, 2, &hit));
    CHECK_NEAR(hit.albedo[0], 0.25, 1e-5);
    CHECK_NEAR(hit.albedo[1], 0.25, 1e-5);
    close_rays(&r);
}

/* A moving mesh is there or not; probabilities of emitters over their areas sum to 1, and samples lie on them
 * in proportion. */
static void test_emitters(void)
{
#define LAMPS \
    "{'materials':[{'name':'one','emission_w_m2_sr':[1,2,3]},{'name':'two','emission_w_m2_sr':1,'double_" \
    "sided':true}]," \
    "'probes':{},'meshes':[{'name':'a','shape':{'type':'plane','width_m':2,'depth_m':1},'material':'one'}," \
    "{'name':'b','shape':{'type':'plane','width_m':1,'depth_m':1},'transform':{'translate_m':[0,1,0]}," \
    "'material':'two','lighting':'%s'},{'name':'c','shape':{'type':'box'}}]}"
    al_error error = {0};
    for (int still = 0; still < 2; still++) {
        rays r = open_rays(still ? AL_RAY_SCENE_STILL : AL_RAY_SCENE_ALL, LAMPS, "probes");
        al_emitters *emitters = NULL;
        al_ray ray = ray_along(0.7, 2, 0.1, 0, -1, 0), other = ray_along(0.3, 2, 0.1, 0, -1, 0);
        al_surface_hit hit;
        CHECK(al_emitters_create(r.import, r.scene, &emitters, &error) == AL_OK);
        CHECK(al_emitters_count(emitters) == (still ? 2 : 4));
        CHECK(al_ray_scene_hit(r.scene, &ray, INFINITY, &hit));
        double one = al_emitters_density(emitters, hit.material), two = 0;
        CHECK(al_ray_scene_hit(r.scene, &other, INFINITY, &hit));
        CHECK_NEAR(hit.position[1], still ? 0.5 : 1, 1e-6);
        if (!still) two = al_emitters_density(emitters, hit.material);
        CHECK_NEAR(one * 2 + two * 1, 1, 1e-12);
        if (!still) CHECK_NEAR(one, two, 1e-12); /* 6 on one side, 3 on both */
        al_random random = al_random_for(1, 2);
        int upper = 0, count = 10000;
        double middle = 0;
        for (int i = 0; i < count; i++) {
            double u[3] = {al_random_real(&random), al_random_real(&random), al_random_real(&random)};
            double density = al_emitters_sample(emitters, u, &hit);
            CHECK(density == al_emitters_density(emitters, hit.material) && density > 0);
            upper += hit.position[1] > 0.5;
            middle += hit.position[0] / count;
        }
        /* 4.5 standard deviations of a binomial share, and of a mean over widths of 1 and 2 (variance w^2/12)
         */
        CHECK_NEAR((double)upper / count, still ? 0 : 1.0 / 3, still ? 0 : 4.5 * sqrt(2.0 / 9 / count));
        CHECK_NEAR(middle, 0, 4.5 * sqrt(4.0 / 12 / count));
        al_emitters_free(emitters);
        close_rays(&r);
    }
    rays dark = open_rays(AL_RAY_SCENE_ALL, "{'meshes':[{'name':'c','shape':{'type':'box'}}]}");
    al_emitters *none = NULL;
    CHECK(al_emitters_create(dark.import, dark.scene, &none, &error) == AL_OK);
    CHECK(al_emitters_count(none) == 0);
    CHECK(al_emitters_density(none, &dark.import->scene.materials[0]) == 0);
    al_emitters_free(none);
    close_rays(&dark);
}

/* A sphere that its motion stretches threefold along y at time 0: normals are those of x^2 + y^2 / 9 + z^2 = 1/4, within
 * the icosphere's own error (20 * 4^5 triangles of 0.02 m, smooth normals: a thousandth). It moves: scenes that stand
 * still lack it. */
static void test_moving(void)
{
    for (int still = 0; still < 2; still++) {
        rays r = open_rays(still ? AL_RAY_SCENE_STILL : AL_RAY_SCENE_ALL,
                           "{'meshes':[{'name':'s','shape':{'type':'sphere'},'motion':[{'time_s':0,'scale':[1,3,1]}]},"
                           "{'name':'wall','shape':{'type':'box'},'transform':{'translate_m':[-3,0,0]}}]}");
        al_ray ray = {.origin = {2, 0.9, 0}, .direction = {-1, 0, 0}};
        al_surface_hit hit;
        CHECK(al_ray_scene_hit(r.scene, &ray, 4, &hit) == !still);
        if (!still) {
            CHECK_NEAR(hit.position[0], 0.4, 1e-3);
            CHECK_NEAR(hit.shading_normal[0], 1.6 / sqrt(1.6 * 1.6 + 0.4 * 0.4), 2e-3);
            CHECK_NEAR(hit.shading_normal[1], 0.4 / sqrt(1.6 * 1.6 + 0.4 * 0.4), 2e-3);
        }
        close_rays(&r);
    }
}

int main(void)
{
    test_offset();
    test_moving();
    test_colors();
    test_emitters();
    return test_end();
}
