/* Pictures: the camera's axes, the standard error, threads, cancelling. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <string.h>

#include "../test.h"
#include "render.h"
#include "scene_for_test.h"

/* A box right of and above the middle, in an even sky: every pixel that sees it is lit. */
static const char *const scene_json =
    "{'meshes':[{'name':'box','shape':{'type':'box','size_m':1},'transform':{'translate_m':[1,0.6,0]}}],"
    "'media':[{'name':'m','sigma_s_per_m':2}],"
    "'translucents':[{'name':'o','mesh':'box','medium':'m'}],"
    "'environment':{'radiance_w_m2_sr':1},"
    "'lights':[{'type':'point','position_m':[0,2,1],'intensity_w_sr':[1,2,0]}],"
    "'cameras':[{'name':'c','position_m':[0,0,5],'target_m':[0,0,0],'fov_y_degrees':40}]}";

typedef struct pictures {
    al_image image, error;
} pictures;

static al_status draw(const test_scene *scene, al_render_options options, pictures *out)
{
    al_error error;
    options.camera = &scene->import->scene.cameras[0];
    return al_render(&al_mode_single_scatter, scene->state, &options, &out->image, &out->error, &error);
}

static void free_pictures(pictures *p)
{
    al_image_free(&p->image);
    al_image_free(&p->error);
}

static double channel_sum(const al_image *image, uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1)
{
    double sum = 0;
    for (uint32_t y = y0; y < y1; y++)
        for (uint32_t x = x0; x < x1; x++)
            sum += image->pixels[((size_t)y * image->width + x) * image->channels];
    return sum;
}

static void test_axes(const test_scene *scene)
{
    pictures p;
    CHECK(draw(scene, (al_render_options){.width = 30, .height = 20, .samples = 4}, &p) == AL_OK);
    CHECK(p.image.channels == 3 && p.error.channels == 1 && p.error.width == 30 && p.error.height == 20);
    /* The picture's height is 2 * 5 tan 20 degrees = 3.64 m at z = 0: the box's middle is 5.5 pixels right of
     * and 3.3 above the middle. */
    CHECK(channel_sum(&p.image, 15, 0, 30, 11) > 0.95 * channel_sum(&p.image, 0, 0, 30, 20));
    CHECK(p.image.pixels[(6 * 30 + 20) * 3] > 0 && p.image.pixels[(13 * 30 + 20) * 3] == 0);
    CHECK(p.image.pixels[(6 * 30 + 9) * 3] == 0 && p.error.pixels[6 * 30 + 9] == 0);
    free_pictures(&p);
}

/* Sixteen times the samples: the pictures differ by what their errors say. The mean of z^2 with errors from B
 * batches is (B-1)/(B-3) for one side, so below 1.4 here; the pixels' spread is about sqrt(2 * 2 / 200). */
static void test_standard_error(const test_scene *scene, uint32_t samples)
{
    pictures few, many;
    CHECK(draw(scene, (al_render_options){.width = 24, .height = 24, .samples = samples}, &few) == AL_OK);
    CHECK(draw(scene, (al_render_options){.width = 24, .height = 24, .samples = 16 * samples}, &many) ==
          AL_OK);
    double sum = 0, count = 0, errors[2] = {0};
    for (size_t i = 0; i < 24 * 24; i++) {
        double difference = few.image.pixels[3 * i] - many.image.pixels[3 * i];
        double error = few.error.pixels[i], finer = many.error.pixels[i];
        if (error == 0) continue;
        sum += difference * difference / (error * error + finer * finer);
        count++;
        errors[0] += error;
        errors[1] += finer;
    }
    CHECK(count > 50);
    CHECK(sum / count > 0.5 && sum / count < 2);
    CHECK(errors[1] < 0.3 * errors[0]); /* 1/sqrt(16) or better */
    free_pictures(&few);
    free_pictures(&many);
}

static void test_threads(const test_scene *scene)
{
    pictures one, other;
    CHECK(draw(scene, (al_render_options){.width = 33, .height = 21, .samples = 5, .threads = 1}, &one) ==
          AL_OK);
    for (unsigned threads = 0; threads <= 5; threads++) {
        CHECK(draw(scene, (al_render_options){.width = 33, .height = 21, .samples = 5, .threads = threads},
                   &other) == AL_OK);
        CHECK(!memcmp(one.image.pixels, other.image.pixels, sizeof(float) * 33 * 21 * 3));
        CHECK(!memcmp(one.error.pixels, other.error.pixels, sizeof(float) * 33 * 21));
        free_pictures(&other);
    }
    free_pictures(&one);
}

/* Pictures are linear in the lights: times a power of two equal to the last bit; times another number but for
 * what the numbers in the scene and the picture's are rounded by, 2^-24 each. */
static void test_strengths(void)
{
    static const double factors[] = {1, 0x1p-20, 0x1p20, 1e-6, 1e6};
    pictures p[5];
    for (int i = 0; i < 5; i++) {
        char json[1024];
        double f = factors[i];
        snprintf(json, sizeof json,
                 "{'meshes':[{'name':'box','shape':{'type':'box','size_m':1}}],"
                 "'media':[{'name':'m','sigma_s_per_m':2}],"
                 "'translucents':[{'name':'o','mesh':'box','medium':'m'}],"
                 "'environment':{'radiance_w_m2_sr':%.17g},"
                 "'lights':[{'type':'point','position_m':[0,2,1],'intensity_w_sr':%.17g},"
                 "{'type':'directional','direction':[-1,0,0],'irradiance_w_m2':%.17g}],"
                 "'cameras':[{'name':'c','position_m':[0,0,5],'target_m':[0,0,0],'fov_y_degrees':20}]}",
                 f, f, f);
        test_scene scene = open_scene(json);
        CHECK(draw(&scene, (al_render_options){.width = 16, .height = 16, .samples = 4}, &p[i]) == AL_OK);
        close_scene(&scene);
        double bound = i < 3 ? 0 : 0x1p-22;
        for (size_t k = 0; k < 16 * 16 * 3; k++) {
            double wanted = f * p[0].image.pixels[k];
            CHECK_NEAR(p[i].image.pixels[k], wanted, bound * wanted);
        }
        for (size_t k = 0; k < 16 * 16; k++)
            CHECK_NEAR(p[i].error.pixels[k], f * p[0].error.pixels[k], bound * f * p[0].image.pixels[3 * k]);
    }
    CHECK(channel_sum(&p[0].image, 0, 0, 16, 16) > 0);
    for (int i = 0; i < 5; i++) free_pictures(&p[i]);
}

static bool stop_at_once(void *user, double done, double total)
{
    (void)user, (void)done, (void)total;
    return true;
}

static void test_refusals(const test_scene *scene)
{
    pictures p;
    al_error error;
    al_camera camera = {.name = (char[]){"c"}, .position = {0, 5, 0}, .up = {0, 1, 0}, .fov_y_radians = 1};
    al_render_options options = {.width = 8, .height = 8, .samples = 4, .camera = &camera};
    CHECK(al_render(&al_mode_single_scatter, scene->state, &options, &p.image, &p.error, &error) ==
          AL_BAD_INPUT);
    CHECK(p.image.pixels == NULL && strstr(error.message, "up direction"));
    options = (al_render_options){
        .width = 8, .height = 64, .samples = 4, .threads = 1, .on_progress = stop_at_once};
    CHECK(draw(scene, options, &p) == AL_CANCELLED);
    CHECK(p.image.pixels == NULL && p.error.pixels == NULL);
}

int main(void)
{
    test_scene scene = open_scene(scene_json);
    test_axes(&scene);
    test_standard_error(&scene, 16);
    test_standard_error(&scene, 64);
    test_threads(&scene);
    test_refusals(&scene);
    test_strengths();
    close_scene(&scene);
    return test_end();
}
