/* airlight-reference: ground truth by ray tracing, with the standard error of every pixel. */
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "airlight/program.h"
#include "render.h"

static const al_mode *const modes[] = {&al_mode_single_scatter};
enum { MODE_COUNT = sizeof modes / sizeof *modes };

typedef struct arguments {
    const char *scene, *mode, *out, *camera;
    char *out_error; /* "ref.exr": "ref.error.exr" */
    int size[2], samples, threads;
} arguments;

static al_status find_mode(const char *name, const al_mode **mode, al_error *error)
{
    char names[256] = "";
    for (int i = 0; i < MODE_COUNT; i++) {
        if (name && !strcmp(modes[i]->name, name)) {
            *mode = modes[i];
            return AL_OK;
        }
        size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", modes[i]->name);
    }
    if (!name) return al_fail(error, AL_USAGE, "--mode is missing: one of %s", names);
    return al_fail(error, AL_USAGE, "'%s' is not a mode: one of %s", name, names);
}

/* Checks the name of the output and that its folder can be written before hours are spent. */
static al_status name_outputs(arguments *given, al_error *error)
{
    static const char ending[] = ".exr", added[] = ".error.exr";
    if (!given->out) return al_fail(error, AL_USAGE, "-o is missing: the OpenEXR file to write");
    size_t length = strlen(given->out), stem = length - (sizeof ending - 1);
    if (length < sizeof ending || strcmp(given->out + stem, ending))
        return al_fail(error, AL_USAGE, "-o takes a name that ends in .exr, not '%s'", given->out);
    given->out_error = malloc(stem + sizeof added);
    char *folder = strdup(given->out);
    if (!given->out_error || !folder) {
        free(folder);
        return al_fail(error, AL_IO, "%s: out of memory", given->out);
    }
    memcpy(given->out_error, given->out, stem);
    memcpy(given->out_error + stem, added, sizeof added);
    char *slash = strrchr(folder, '/');
    if (slash) slash[slash == folder ? 1 : 0] = 0;
    al_status status = AL_OK;
    if (access(slash ? folder : ".", W_OK)) {
        al_fail_errno(error, given->out, "write");
        status = error->status = AL_IO;
    }
    free(folder);
    return status;
}

static al_status find_camera(const al_import *import, const char *name, const al_camera **camera,
                             al_error *error)
{
    const al_scene *scene = &import->scene;
    char names[512] = "";
    for (uint32_t i = 0; i < scene->camera_count; i++) {
        if (!name || !strcmp(scene->cameras[i].name, name)) {
            *camera = &scene->cameras[i];
            return AL_OK;
        }
        size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s\"%s\"", i ? ", " : "", scene->cameras[i].name);
    }
    return al_fail(error, AL_USAGE, "--camera: %s has no camera \"%s\"; it has %s", import->description->path,
                   name, names);
}

static bool on_progress(void *user, double done, double total)
{
    return al_progress_update(user, done, total);
}

static al_status render(const al_program *program, const arguments *given, const al_mode *mode,
                        const al_import *import, const al_camera *camera, al_error *error)
{
    void *state = NULL;
    al_image image = {0}, standard_error = {0};
    al_progress progress;
    al_render_options options = {
        .width = (uint32_t)given->size[0],
        .height = (uint32_t)given->size[1],
        .samples = (uint32_t)given->samples,
        .threads = (unsigned)given->threads,
        .camera = camera,
        .on_progress = on_progress,
        .user = &progress,
    };
    al_status status = mode->open(import, &state, error);
    if (status) return status;
    al_progress_begin(&progress, program, mode->name);
    status = al_render(mode, state, &options, &image, &standard_error, error);
    if (!status) al_progress_end(&progress);
    if (!status) status = al_image_write_exr(given->out_error, &standard_error, error);
    if (!status) status = al_image_write_exr(given->out, &image, error);
    mode->close(state);
    al_image_free(&image);
    al_image_free(&standard_error);
    return status;
}

static al_status run(const al_program *program, arguments *given, al_error *error)
{
    const al_mode *mode = NULL;
    const al_camera *camera = NULL;
    al_import *import = NULL;
    al_status status = find_mode(given->mode, &mode, error);
    if (!status) status = name_outputs(given, error);
    if (!status) status = al_import_scene(given->scene, AL_QUALITY_FINAL, &import, error);
    if (!status) status = find_camera(import, given->camera, &camera, error);
    if (!status) status = render(program, given, mode, import, camera, error);
    al_import_free(import);
    free(given->out_error);
    return status;
}

int main(int argc, char **argv)
{
    arguments given = {.size = {192, 192}, .samples = 64};
    const al_option options[] = {
        {"--mode", "MODE", AL_OPTION_STRING, &given.mode, "what to compute: single-scatter", 0, 0},
        {"--spp", "N", AL_OPTION_INT, &given.samples, "samples per pixel (64)", 2, 100000000},
        {"-o", "REF.exr", AL_OPTION_STRING, &given.out,
         "the picture; its standard error goes to REF.error.exr", 0, 0},
        {"--size", "WxH", AL_OPTION_SIZE, given.size, "of the picture in pixels (192x192)", 1, 16384},
        {"--camera", "NAME", AL_OPTION_STRING, &given.camera, "of the scene (its first)", 0, 0},
        {"--threads", "N", AL_OPTION_INT, &given.threads, "0: one per core (0); changes no bit of the result",
         0, 256},
    };
    al_program program = {
        .name = "airlight-reference",
        .usage = "SCENE.json --mode MODE --spp N -o REF.exr [options]",
        .summary =
            "Renders ground truth by ray tracing: linear radiance, the box-filtered mean over each pixel, "
            "and\n"
            "in REF.error.exr the standard error of each pixel (one channel, mean over the colours).\n"
            "Modes:\n"
            "  single-scatter  light scattered once inside translucent objects; attenuated on both legs,\n"
            "                  stopped by opaque surfaces; neither surfaces nor background are shown",
        .options = options,
        .option_count = sizeof options / sizeof *options,
    };
    size_t count;
    int code = al_program_parse(&program, argc, argv, &given.scene, 1, 1, &count);
    if (code >= 0) return code;
    al_program_catch_signals();
    al_error error = {0};
    return run(&program, &given, &error) ? al_program_fail(&program, &error) : AL_OK;
}
