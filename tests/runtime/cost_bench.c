/* What lights and samples cost, one sphere that fills the view: CSV of times, in ms, of frames that were
 * waited for. First both at WIDTH x WIDTH pixels (medians); then samples alone at 64 x 64 (the fastest of
 * FRAMES), where pixels cost little, with the line of least squares through the times.
 *   runtime_cost_bench [WIDTH [FRAMES]] */
#include <epoxy/gl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
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

static al_runtime *open_sphere(const char *folder, uint32_t samples, float cut)
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
    bool good = sphere_write_asset(folder, "sphere.air",
                                   &(sphere_options){.samples = samples, .order = 5, .reach = cut}) &&
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
    al_runtime *runtime = open_sphere(folder, samples, 3.5f);
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

typedef struct sample_cost {
    double samples, frame_ms, light_ms, splat_ms;
} sample_cost;

/* Gaussians end where the bake ends them. The fastest of the frames, for what others do on the machine only
 * adds. The splats' share is that of the wall clock: on a software rasteriser vertices are not in the timer
 * queries. */
static sample_cost measure_samples(const char *folder, uint32_t samples, int frames)
{
    double all[RUNS], one[RUNS], light[RUNS];
    al_runtime *runtime = open_sphere(folder, samples, 2.5f);
    al_view view = stage_look(64, 64, (float[3]){0, 0, 2.6f}, (float[3]){0, 0, 0}, 0.8f);
    al_settings settings = {.surface_off = true, .detail_off = true};
    for (int frame = -1; runtime && frame < frames; frame++)
        for (settings.sample_limit = 0; settings.sample_limit < 2; settings.sample_limit++) {
            al_pass_time times[8];
            double begin = now_ms();
            free(stage_draw(runtime, &view, &settings, 0));
            if (frame >= 0) (settings.sample_limit ? one : all)[frame] = now_ms() - begin;
            uint32_t count = al_runtime_times(runtime, times, 8);
            for (uint32_t k = 0; k < count && frame >= 0 && !settings.sample_limit; k++)
                if (!strcmp(times[k].name, "light")) light[frame] = times[k].ms;
        }
    al_runtime_destroy(runtime);
    qsort(all, (size_t)frames, sizeof *all, ascending);
    qsort(one, (size_t)frames, sizeof *one, ascending);
    qsort(light, (size_t)frames, sizeof *light, ascending);
    return (sample_cost){samples, all[0], light[0], all[0] - one[0] - light[0]};
}

/* a + b x by least squares of relative errors (the points span two decades), and r^2 of log y against the
 * line's: how much of the growth the line explains. */
static void print_fit(const char *name, const double *x, const double *y, int count)
{
    double s = 0, sx = 0, sxx = 0, sy = 0, sxy = 0, mean = 0, left = 0, all = 0;
    for (int i = 0; i < count; i++) {
        double w = 1 / (y[i] * y[i]);
        s += w, sx += w * x[i], sxx += w * x[i] * x[i], sy += w * y[i], sxy += w * x[i] * y[i];
        mean += log(y[i]) / count;
    }
    double b = (s * sxy - sx * sy) / (s * sxx - sx * sx), a = (sy - b * sx) / s;
    for (int i = 0; i < count; i++) {
        left += pow(log(y[i]) - log(fmax(a + b * x[i], 1e-9)), 2);
        all += pow(log(y[i]) - mean, 2);
    }
    printf("# %s: %.3f ms + %.3f us a sample, r^2 %.4f\n", name, a, 1e3 * b, 1 - left / all);
}

static void measure_line(const char *folder, int frames)
{
    enum { COUNT = 8 };
    static const uint32_t samples[COUNT] = {6250, 12500, 25000, 50000, 100000, 200000, 400000, 1000000};
    double x[COUNT], frame[COUNT], light[COUNT], splat[COUNT];
    printf("samples,frame_ms,light_ms,splat_ms\n");
    for (int i = 0; i < COUNT; i++) {
        sample_cost cost = measure_samples(folder, samples[i], frames);
        x[i] = cost.samples;
        frame[i] = cost.frame_ms;
        light[i] = cost.light_ms;
        splat[i] = cost.splat_ms;
        printf("%.0f,%.2f,%.2f,%.2f\n", x[i], frame[i], light[i], splat[i]);
        fflush(stdout);
    }
    print_fit("frame", x, frame, COUNT);
    print_fit("light", x, light, COUNT);
    print_fit("splat", x, splat, COUNT);
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
    measure_line(folder, frames);
    return 0;
}
