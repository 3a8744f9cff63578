/* Surfaces into fog, splatted and by brute force: scattering_bench BAKED SHADERS [WIDTH HEIGHT FRAMES STEPS].
 * Prints a table for docs/performance.md. Brute force, over all surfels at all march steps, is timed on every eighth
 * pixel of every eighth row and scaled. */
#include <epoxy/gl.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "../../runtime/state.h"
#include "../test.h"
#include "stage.h"

enum { STRIDE = 8, TIMES = 64, MOST_ITERATIONS = 5000 }; /* llvmpipe ends a shader's loops after 65535 */

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static al_view reference_view(uint32_t width, uint32_t height)
{
    return stage_look(width, height, (float[3]){0, 0, 3.9f}, (float[3]){0, 0, 0}, 39.3f / 57.29577951f);
}

/* The last frame's surfels, map and fogs are still bound. Answers the time for the whole picture. */
static double brute_force(al_runtime *runtime, uint32_t width, uint32_t height, int steps, uint32_t surfels,
                          float *light)
{
    GLuint program, texture;
    al_error error = {0};
    int columns = (int)width / STRIDE, rows = (int)height / STRIDE;
    if (al_shaders_get(runtime->shaders, "brute.comp", "", &program, &error)) {
        fprintf(stderr, "%s\n", error.message);
        exit(1);
    }
    glCreateTextures(GL_TEXTURE_2D, 1, &texture);
    glTextureStorage2D(texture, 1, GL_RGBA32F, columns, rows);
    glUseProgram(program);
    al_gl_bind_texture(AL_UNIT_PASS, runtime->targets.geometry.id);
    al_gl_bind_texture(AL_UNIT_PASS + 4, runtime->legs.extinction.id);
    glBindImageTexture(0, texture, 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
    glFinish();
    double start = seconds();
    for (int first = 0, part = MOST_ITERATIONS / steps; first < (int)surfels; first += part) {
        glUniform4i(0, STRIDE, steps, first, (int)surfels - first < part ? (int)surfels - first : part);
        glDispatchCompute((GLuint)(columns + 3) / 4, (GLuint)(rows + 3) / 4, 1);
        glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    }
    glFinish();
    double spent = (seconds() - start) * width * height / ((double)columns * rows);
    glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
    glGetTextureImage(texture, 0, GL_RGB, GL_FLOAT, columns * rows * 12, light);
    glDeleteTextures(1, &texture);
    return spent;
}

static double draw_seconds(al_runtime *runtime, const al_view *view, const al_settings *settings, int frames)
{
    double fastest = INFINITY;
    for (int frame = 0; frame <= frames; frame++) {
        double start = seconds();
        float *pixels = stage_draw(runtime, view, settings, 0);
        if (!pixels) exit(1);
        free(pixels);
        if (frame) fastest = fmin(fastest, seconds() - start);
    }
    return fastest;
}

/* Time over the number of surfels, the shells' radius held: a straight line and what it explains. */
static void print_line(al_runtime *runtime, const al_view *view, int frames)
{
    double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
    for (float size = 9.2f; size > 2; size /= 1.41421356f) {
        const al_settings settings = {.pass = AL_PASS_SURFACE_SCATTERING, .surfel_pixels = size, .shell_radius_m = 0.05f};
        double spent = draw_seconds(runtime, view, &settings, frames), count = (double)al_runtime_surfels(runtime);
        printf("%8.0f surfels %8.3f s\n", count, spent);
        n++, x += count, y += spent, xx += count * count, xy += count * spent, yy += spent * spent;
    }
    double slope = (n * xy - x * y) / (n * xx - x * x), start = (y - slope * x) / n;
    double explained = (n * xy - x * y) * (n * xy - x * y) / ((n * xx - x * x) * (n * yy - y * y));
    printf("frame = %.3f s + %.1f us a surfel, r^2 %.3f\n", start, 1e6 * slope, explained);
}

int main(int argc, char **argv)
{
    al_runtime *runtime = NULL;
    al_error error = {0};
    if (argc < 3) return 2;
    uint32_t width = argc > 3 ? (uint32_t)atoi(argv[3]) : 800, height = argc > 4 ? (uint32_t)atoi(argv[4]) : 600;
    int frames = argc > 5 ? atoi(argv[5]) : 3, steps = argc > 6 ? atoi(argv[6]) : 200;
    const al_runtime_options options = {argv[2]};
    al_settings settings = {.pass = AL_PASS_SURFACE_SCATTERING};
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    if (al_runtime_create(&options, &runtime, &error) || !stage_load(runtime, argv[1])) {
        fprintf(stderr, "%s\n", error.message);
        return 1;
    }
    runtime->timing.waits = true;
    al_view view = reference_view(width, height);
    double fastest = INFINITY, splatted = 0, brute = 0;
    float *pixels = NULL;
    for (int frame = 0; frame <= frames; frame++) {
        free(pixels);
        double start = seconds();
        pixels = stage_draw(runtime, &view, &settings, 0);
        if (!pixels) return 1;
        if (frame) fastest = fmin(fastest, seconds() - start);
    }
    al_pass_time times[TIMES];
    uint32_t count = al_runtime_times(runtime, times, TIMES), surfels = (uint32_t)al_runtime_surfels(runtime);
    float *light = calloc((size_t)(width / STRIDE) * (height / STRIDE) * 3, sizeof *light);
    double spent = brute_force(runtime, width, height, steps, surfels, light);
    for (uint32_t y = 0; y < height / STRIDE; y++)
        for (uint32_t x = 0; x < width / STRIDE; x++) {
            splatted += pixels[3 * ((y * STRIDE + STRIDE / 2) * width + x * STRIDE + STRIDE / 2)];
            brute += light[3 * (y * (width / STRIDE) + x)];
        }
    printf("%u x %u, %u surfels, %d march steps; on %s\n", width, height, surfels, steps, glGetString(GL_RENDERER));
    double sum = 0;
    for (uint32_t i = 0; i < count; i++) sum += times[i].ms;
    for (uint32_t i = 0; i < count; i++)
        printf("%-16s %10.2f ms %5.1f %%\n", times[i].name, times[i].ms, 100 * times[i].ms / sum);
    const al_shells *shells = &runtime->shells;
    const struct {
        const char *name;
        uint64_t bytes;
    } buffers[] = {{"surfels", al_surfels_bytes(runtime)},
                   {"interval map", shells->steps.bytes + shells->ends.bytes + shells->weights.bytes},
                   {"span", shells->span.bytes},
                   {"levels", shells->levels.bytes},
                   {"light and its mips", shells->light.bytes},
                   {"legs", runtime->legs.extinction.bytes},
                   {"tables of the deal", 0},
                   {"all of the runtime", al_runtime_memory(runtime)}};
    for (size_t i = 0; i < sizeof buffers / sizeof buffers[0]; i++)
        printf("%-20s %8.2f MiB\n", buffers[i].name, (double)buffers[i].bytes / 1048576);
    printf("frame %.3f s, brute force %.1f s: %.0f times; light of both %.4f\n", fastest, spent, spent / fastest,
           splatted / brute);
    free(pixels);
    free(light);
    print_line(runtime, &view, frames);
    al_runtime_destroy(runtime);
    return 0;
}
