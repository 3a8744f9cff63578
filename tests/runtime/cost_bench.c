/* What lights and samples cost: CSV of frame times over both, one sphere that fills the view.
 *   runtime_cost_bench [WIDTH [FRAMES]]: medians, in ms, of frames that were waited for. */
#include <epoxy/gl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "sphere.h"
#include "stage.h"

enum { RUNS = 64 };

static double now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static al_runtime *open_sphere(const char *folder, uint32_t samples)
{
    al_runtime *runtime = NULL;
    al_error error = {0};
    sphere_scene s;
    sphere_scene_begin(&s);
    sphere_scene_add(&s, "sphere.air", 1, (float[3]){0, 0, 0});
    for (int i = 0; i < 8; i++) {
        float angle = (float)i * 0.8f, reach = i % 2 ? 3 : 1;
        sphere_scene_add_light(&s, i % 2 ? AL_LIGHT_POINT : AL_LIGHT_DIRECTIONAL,
                               (float[3]){reach * cosf(angle), 0, reach * sinf(angle)}, 1);
    }
    bool good = sphere_write_asset(folder, "sphere.air", &(sphere_options){.samples = samples, .order = 5}) &&
                sphere_scene_write(folder, &s) && al_runtime_create(NULL, &runtime, &error) == AL_OK &&
                stage_load(runtime, folder);
    sphere_scene_end(&s);
    return good ? runtime : NULL;
}

/* Lights change between frames, so that what drifts in the machine falls on all alike. */
static void measure(const char *folder, uint32_t samples, uint32_t width, int frames)
{
    static const uint32_t lights[] = {2, 4, 7, 8};
    double ms[4][RUNS];
    al_runtime *runtime = open_sphere(folder, samples);
    al_view view = stage_look(width, width, (float[3]){0, 0, 2.6f}, (float[3]){0, 0, 0}, 0.8f);
    for (int frame = -1; runtime && frame < frames; frame++)
        for (int i = 0; i < 4; i++) {
            al_runtime_scene(runtime)->light_count = lights[i];
            glFinish();
            double begin = now_ms();
            free(stage_draw(runtime, &view, &(al_settings){.surface_off = true}, 0));
            if (frame >= 0) ms[i][frame] = now_ms() - begin;
        }
    for (int i = 0; runtime && i < 4; i++) {
        al_pass_time times[8];
        qsort(ms[i], (size_t)frames, sizeof ms[i][0], ascending);
        printf("%u,%u,%u,%.2f", width, samples, lights[i], ms[i][frames / 2]);
        uint32_t count = i == 3 ? al_runtime_times(runtime, times, 8) : 0;
        for (uint32_t k = 0; k < count; k++) printf(",%s %.2f", times[k].name, times[k].ms);
        printf("\n");
    }
    al_runtime_destroy(runtime);
}

int main(int argc, char **argv)
{
    int width = argc > 1 ? atoi(argv[1]) : 800, frames = argc > 2 ? atoi(argv[2]) : 5;
    if (!stage_open()) return 5;
    if (width < 1 || frames < 1 || frames > RUNS) return 2;
    const char *folder = stage_folder();
    printf("# %s\nwidth,samples,lights,frame_ms,passes\n", (const char *)glGetString(GL_RENDERER));
    static const uint32_t samples[] = {25000, 50001, 58297, 107833};
    for (size_t i = 0; i < sizeof samples / sizeof samples[0]; i++)
        measure(folder, samples[i], (uint32_t)width, frames);
    return 0;
}
