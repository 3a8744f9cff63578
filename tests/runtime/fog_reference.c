/* The player's single scattering in fog against a picture of the reference folder:
 * fog_reference BAKED REFERENCE.exr ERROR.exr LIMIT [CELLS [FRAMES]]. Pixels whose ray passes within 0.15 m
 * of the first light are left out: its glow has no bound there. The relative RMSE with the reference's noise
 * taken out must not be above LIMIT. */
#include <stdlib.h>

#include "../test.h"
#include "airlight/image.h"
#include "stage.h"

enum { DEFAULT_FRAMES = 8 };

/* Whether pixel x, y (first row on top) of the reference camera sees past the light. */
static bool counts(const al_light *light, const float eye[3], double tangent, uint32_t edge, uint32_t x,
                   uint32_t y)
{
    double direction[3] = {(2 * (x + 0.5) / edge - 1) * tangent, (1 - 2 * (y + 0.5) / edge) * tangent, -1};
    double path[3], along = 0, squared = 0, length = 0;
    for (int k = 0; k < 3; k++) {
        path[k] = (double)light->vector[k] - eye[k];
        along += path[k] * direction[k];
        length += direction[k] * direction[k];
        squared += path[k] * path[k];
    }
    return squared - along * along / length > 0.15 * 0.15;
}

/* Sub-pixel offsets of a 4 x 2 grid, as the reference's box filter averages over pixels. */
static void jitter(al_view *view, int frame)
{
    view->projection[8] = (float)((frame % 4 + 0.5) / 4 - 0.5) * 2 / (float)view->width;
    view->projection[9] = (float)((frame / 4 % 2 + 0.5) / 2 - 0.5) * 2 / (float)view->height;
}

int main(int argc, char **argv)
{
    al_runtime *runtime = NULL;
    al_error failure = {0};
    al_image wanted = {0}, error = {0};
    if (argc < 5) return 2;
    const al_settings settings = {.pass = AL_PASS_DIRECT_SCATTERING,
                                  .fog_steps = argc > 5 ? (uint32_t)atoi(argv[5]) : 0};
    const int frames = argc > 6 ? atoi(argv[6]) : DEFAULT_FRAMES;
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    if (al_image_read_exr(argv[2], &wanted, &failure) || al_image_read_exr(argv[3], &error, &failure) ||
        al_runtime_create(NULL, &runtime, &failure) || !stage_load(runtime, argv[1])) {
        fprintf(stderr, "%s\n", failure.message);
        return 1;
    }
    uint32_t edge = (uint32_t)wanted.width;
    const float eye[3] = {0, 0, 3.9f}, fov = 39.3f / 57.29577951f;
    float *sum = calloc((size_t)edge * edge * 3, sizeof *sum);
    al_view view = stage_look(edge, edge, eye, (float[3]){0, 0, 0}, fov);
    for (int frame = 0; frame < frames; frame++) {
        jitter(&view, frame);
        float *pixels = stage_draw(runtime, &view, &settings, 0);
        CHECK(pixels && stage_bad(pixels, (uint64_t)edge * edge * 3) == 0);
        for (size_t i = 0; pixels && i < (size_t)edge * edge * 3; i++) sum[i] += pixels[i] / (float)frames;
        free(pixels);
    }
    double squared = 0, noise = 0, scale = 0, seen = 0, all = 0;
    for (uint32_t y = 0; y < edge; y++)
        for (uint32_t x = 0; x < edge; x++) {
            if (!counts(&al_runtime_scene(runtime)->lights[0], eye, tan(fov / 2), edge, x, y)) continue;
            for (int c = 0; c < 3; c++) {
                double a = sum[3 * ((edge - 1 - y) * edge + x) + c];
                double b = wanted.pixels[wanted.channels * (y * edge + x) + c];
                double e = error.pixels[error.channels * (y * edge + x)];
                squared += (a - b) * (a - b);
                noise += e * e;
                scale += b * b;
                seen += a;
                all += b;
            }
        }
    double without = sqrt(fmax(squared - noise, 0) / scale);
    printf("relative RMSE %.4f, without noise %.4f, mean ratio %.4f\n", sqrt(squared / scale), without,
           seen / all);
    CHECK(without <= atof(argv[4]));
    al_image_free(&wanted);
    al_image_free(&error);
    free(sum);
    al_runtime_destroy(runtime);
    return test_end();
}
