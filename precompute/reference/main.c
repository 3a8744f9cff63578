/* airlight-reference: ground truth by ray tracing, with the standard error of every pixel. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "airlight/program.h"
#include "points.h"
#include "render.h"

static const al_mode *const modes[] = {&al_mode_single_scatter, &al_mode_surface_to_volume,
                                       &al_mode_volume_path, &al_mode_ambient_occlusion, &al_mode_indirect};
enum { MODE_COUNT = sizeof modes / sizeof *modes };

typedef struct arguments {
    const char *scene, *mode, *out, *camera, *points, *stats;
    char *out_error; /* "ref.exr": "ref.error.exr" */
    int size[2], samples, threads;
    int min_events, max_events, max_bounces; /* -1: not given */
    bool no_visibility, no_attenuation;
    double radius_m;
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

static al_status check_usage(const arguments *given, const al_mode *mode, al_error *error)
{
    bool limited = given->min_events >= 0 || given->max_events >= 0 || given->max_bounces >= 0;
    if (limited && mode != &al_mode_volume_path)
        return al_fail(error, AL_USAGE,
                       "--min-events, --max-events and --max-bounces go with --mode volume-path, not %s",
                       mode->name);
    if ((given->no_visibility || given->no_attenuation) && mode != &al_mode_surface_to_volume &&
        mode != &al_mode_indirect)
        return al_fail(error, AL_USAGE,
                       "--no-visibility and --no-attenuation go with --mode surface-to-volume and indirect, "
                       "not %s",
                       mode->name);
    if (given->radius_m < INFINITY && mode != &al_mode_ambient_occlusion)
        return al_fail(error, AL_USAGE, "--radius goes with --mode ambient-occlusion, not %s", mode->name);
    if (given->points && !mode->receive)
        return al_fail(error, AL_USAGE, "--points goes with --mode volume-path, not %s", mode->name);
    if (given->stats && !given->points) return al_fail(error, AL_USAGE, "--stats goes with --points");
    return AL_OK;
}

/* Checks the name of the output and that its folder can be written before hours are spent. */
static al_status name_outputs(arguments *given, al_error *error)
{
    static const char added[] = ".error.exr";
    const char *ending = given->points ? ".csv" : ".exr";
    if (!given->out) return al_fail(error, AL_USAGE, "-o is missing: the %s file to write", ending);
    size_t length = strlen(given->out), stem = length - strlen(ending);
    if (length <= strlen(ending) || strcmp(given->out + stem, ending))
        return al_fail(error, AL_USAGE, "-o takes a name that ends in %s, not '%s'", ending, given->out);
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
                        const void *state, const al_camera *camera, al_error *error)
{
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
    al_progress_begin(&progress, program, mode->name);
    al_status status = al_render(mode, state, &options, &image, &standard_error, error);
    if (!status) al_progress_end(&progress);
    if (!status) status = al_image_write_exr(given->out_error, &standard_error, error);
    if (!status) status = al_image_write_exr(given->out, &image, error);
    al_image_free(&image);
    al_image_free(&standard_error);
    return status;
}

/* Of all threads together: what other programs take does not count. */
static double cpu_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Relative standard error sqrt(sum e^2 / sum v^2) and what it took; for another error E the time is seconds *
 * (error / E)^2. */
static al_status write_stats(const arguments *given, const al_points *points, double (*values)[3],
                             double (*errors)[3], double seconds, al_error *error)
{
    char text[512];
    double square = 0, noise = 0;
    for (size_t i = 0; i < (size_t)points->count * al_points_width(points); i++)
        for (int c = 0; c < 3; c++) {
            square += values[i][c] * values[i][c];
            noise += errors[i][c] * errors[i][c];
        }
    snprintf(text, sizeof text,
             "{\n  \"points\": %u,\n  \"samples\": %d,\n  \"cpu_seconds\": %.6g,\n"
             "  \"cpu_seconds_per_point\": %.6g,\n  \"relative_standard_error\": %.6g\n}\n",
             points->count, given->samples, seconds, seconds / points->count,
             square > 0 ? sqrt(noise / square) : 0);
    return al_write_file(given->stats, text, strlen(text), error);
}

static al_status receive(const al_program *program, const arguments *given, const al_mode *mode,
                         const void *state, const al_points *points, al_error *error)
{
    al_progress progress;
    al_points_options options = {.samples = (uint32_t)given->samples,
                                 .threads = (unsigned)given->threads,
                                 .on_progress = on_progress,
                                 .user = &progress};
    size_t rows = (size_t)points->count * al_points_width(points);
    double(*values)[3] = malloc(sizeof *values * rows), (*errors)[3] = malloc(sizeof *errors * rows);
    al_status status = AL_OK;
    if (!values || !errors) status = al_fail(error, AL_IO, "out of memory for %u points", points->count);
    double started = cpu_seconds();
    al_progress_begin(&progress, program, mode->name);
    if (!status) status = al_points_estimate(mode, state, points, &options, values, errors, error);
    if (!status) al_progress_end(&progress);
    double seconds = cpu_seconds() - started;
    if (!status && given->stats) status = write_stats(given, points, values, errors, seconds, error);
    if (!status) status = al_points_write(given->out, points, values, errors, error);
    free(values);
    free(errors);
    return status;
}

static al_mode_options options_of(const arguments *given)
{
    al_mode_options options = al_mode_defaults;
    if (given->min_events >= 0) options.min_events = (uint32_t)given->min_events;
    if (given->max_events >= 0) options.max_events = (uint32_t)given->max_events;
    if (given->max_bounces >= 0) options.max_bounces = (uint32_t)given->max_bounces;
    options.no_visibility = given->no_visibility;
    options.no_attenuation = given->no_attenuation;
    options.radius_m = given->radius_m;
    return options;
}

static al_status run(const al_program *program, arguments *given, al_error *error)
{
    const al_mode *mode = NULL;
    const al_camera *camera = NULL;
    al_import *import = NULL;
    al_points points = {0};
    void *state = NULL;
    al_mode_options options = options_of(given);
    al_status status = find_mode(given->mode, &mode, error);
    if (!status) status = check_usage(given, mode, error);
    if (!status) status = name_outputs(given, error);
    if (!status && given->points) status = al_points_read(given->points, &points, error);
    if (!status) status = al_import_scene(given->scene, AL_QUALITY_FINAL, &import, error);
    if (!status) status = find_camera(import, given->camera, &camera, error);
    if (!status) status = mode->open(import, &options, &state, error);
    if (!status && given->points) status = receive(program, given, mode, state, &points, error);
    if (!status && !given->points) status = render(program, given, mode, state, camera, error);
    if (mode) mode->close(state);
    al_points_free(&points);
    al_import_free(import);
    free(given->out_error);
    return status;
}

int main(int argc, char **argv)
{
    arguments given = {.size = {192, 192},
                       .samples = 64,
                       .min_events = -1,
                       .max_events = -1,
                       .max_bounces = -1,
                       .radius_m = INFINITY};
    const al_option options[] = {
        {"--mode", "MODE", AL_OPTION_STRING, &given.mode, "what to compute, see below", 0, 0},
        {"--spp", "N", AL_OPTION_INT, &given.samples, "samples per pixel or point (64)", 2, 100000000},
        {"-o", "REF.exr", AL_OPTION_STRING, &given.out,
         "the picture; its standard error goes to REF.error.exr. With --points a .csv file", 0, 0},
        {"--points", "IN.csv", AL_OPTION_STRING, &given.points,
         "instead of a picture, irradiance at points (columns x,y,z,nx,ny,nz), or SH of probes (normal "
         "0,0,0)",
         0, 0},
        {"--stats", "OUT.json", AL_OPTION_STRING, &given.stats,
         "with --points: seconds per point and the relative standard error they bought", 0, 0},
        {"--size", "WxH", AL_OPTION_SIZE, given.size, "of the picture in pixels (192x192)", 1, 16384},
        {"--camera", "NAME", AL_OPTION_STRING, &given.camera, "of the scene (its first)", 0, 0},
        {"--max-events", "N", AL_OPTION_INT, &given.max_events,
         "volume-path: scatter at most N times; 0: media only absorb and scatter out", 0, 1000000000},
        {"--min-events", "N", AL_OPTION_INT, &given.min_events, "volume-path: scatter at least N times", 0,
         1000000000},
        {"--max-bounces", "N", AL_OPTION_INT, &given.max_bounces,
         "volume-path: reflect off surfaces at most N times; 0: they are black", 0, 1000000000},
        {"--no-visibility", NULL, AL_OPTION_FLAG, &given.no_visibility,
         "surface-to-volume, indirect: no surface stands between the surface and what it lights", 0, 0},
        {"--no-attenuation", NULL, AL_OPTION_FLAG, &given.no_attenuation,
         "surface-to-volume, indirect: no medium attenuates between the surface and what it lights", 0, 0},
        {"--radius", "M", AL_OPTION_REAL, &given.radius_m,
         "ambient-occlusion: surfaces farther away than this many metres do not count", 1e-9, 1e9},
        {"--threads", "N", AL_OPTION_INT, &given.threads, "0: one per core (0); changes no bit of the result",
         0, 256},
    };
    al_program program = {
        .name = "airlight-reference",
        .usage = "SCENE.json --mode MODE --spp N -o REF.exr|OUT.csv [options]",
        .summary =
            "Renders ground truth by ray tracing: linear radiance, the box-filtered mean over each pixel, "
            "and\n"
            "in REF.error.exr the standard error of each pixel (one channel, mean over the colours).\n"
            "Modes:\n"
            "  single-scatter  light of any lamp scattered once in fogs and translucent objects; attenuated "
            "on\n"
            "                  both legs, stopped by opaque surfaces; neither surfaces nor background are "
            "shown\n"
            "  surface-to-volume\n"
            "                  light of any lamp off one surface, then scattered once in fogs and "
            "translucent\n"
            "                  objects; attenuated and shadowed on all three legs; neither surfaces nor\n"
            "                  background are shown; an eye ray (--spp) carries 32 paths\n"
            "  volume-path     all light, off surfaces and out of media, any number of times, without bias:\n"
            "                  fogs and translucent objects, homogeneous or not; surfaces are two-sided\n"
            "                  Lambert of base colour times 1 - metallic (what metals mirror is left out);\n"
            "                  point, directional, emissive and environment light\n"
            "  ambient-occlusion\n"
            "                  share of the cosine-weighted hemisphere over the surface that is seen which "
            "meets\n"
            "                  no surface (within --radius); an eye ray sends 32 rays\n"
            "  indirect        light of any lamp off one Lambert surface onto the surface that is seen, "
            "which\n"
            "                  reflects as in glTF (Lambert and GGX); attenuated and shadowed on all legs;\n"
            "                  neither direct light nor emission is shown; an eye ray carries 32 paths\n"
            "--points reads a line for each point: x,y,z,nx,ny,nz in metres, the normal of length 1; a line "
            "of\n"
            "names, lines that begin with # and further columns are left out. It writes irradiance in W/m2 "
            "as\n"
            "x,y,z,nx,ny,nz,r,g,b,se_r,se_g,se_b; where the normals are 0,0,0, coefficients of incident\n"
            "radiance as x,y,z,index,sh_r,sh_g,sh_b,se_r,se_g,se_b. se is the standard error.",
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
