/* Rendered homogeneous spheres against single scattering by quadrature (oracle copied below). */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "../test.h"
#include "airlight/runtime.h"
#include "sphere.h"
#include "stage.h"

int main(int argc, char **argv)
{
    uint32_t samples = argc > 1 ? (uint32_t)atoi(argv[1]) : 4000, order = argc > 2 ? (uint32_t)atoi(argv[2]) : 5;
    al_error error = {0};
    al_runtime *runtime;
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    const char *folder = stage_folder();
    printf("%s\n", folder);
    sphere_scene s;
    sphere_scene_begin(&s);
    sphere_write_asset(folder, "a.air", &(sphere_options){.samples = samples, .order = order});
    sphere_scene_add(&s, "a.air", 1, (float[3]){0, 0, 0});
    sphere_scene_add_light(&s, AL_LIGHT_DIRECTIONAL, (float[3]){0, 0, -1}, 1);
    sphere_scene_write(folder, &s);
    al_status st = al_runtime_create(&(al_runtime_options){getenv("AL_SHADERS")}, &runtime, &error);
    if (st) { printf("%s\n", error.message); return 1; }
    if (!stage_load(runtime, folder)) return 1;
    uint32_t w = argc > 3 ? (uint32_t)atoi(argv[3]) : 200;
    al_view view = stage_ortho(w, w, 1);
    al_settings settings = {.surface_off = true, .background_off = true};
    if (argc > 4) settings.view_leg = (al_view_leg)atoi(argv[4]);
    if (argc > 5) settings.pass = (al_pass)atoi(argv[5]);
    for (int i = 0; i < 5; i++) {
        clock_t c0 = clock(); float *p = stage_draw(runtime, &view, &settings, 0);
        if (!p) return 1; printf("cpu %.1f ms ", 1e3*(clock()-c0)/CLOCKS_PER_SEC);
        al_pass_time times[8];
        uint32_t n = al_runtime_times(runtime, times, 8);
        for (uint32_t k = 0; k < n; k++) printf("%s %.2f  ", times[k].name, times[k].ms);
        printf("mem %.1f MB bad %lu\n", al_runtime_memory(runtime) / 1e6, (unsigned long)stage_bad(p, w * w * 3));
        if (i == 4)
            for (uint32_t y = 0; y < w; y += w / 16) printf("y %d: %g %g\n", y, p[3 * (y * w + w / 2)], p[3 * (y * w + w * 3 / 4)]);
        free(p);
    }
    return test_end();
}
