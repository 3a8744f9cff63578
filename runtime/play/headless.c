#define _POSIX_C_SOURCE 200809L
#include "headless.h"

#include <epoxy/gl.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "debug_output.h"
#include "eye.h"
#include "offscreen.h"
#include "picture.h"
#include "stats.h"
#include "watch.h"

enum { TIMES_LIMIT = 64, STREAM_BUDGET = 8 << 20 }; /* bytes uploaded per frame while drawing */

typedef struct session {
    const al_program *program;
    const al_play_options *options;
    al_offscreen offscreen;
    al_runtime *runtime;
    al_target target;
    al_image sum; /* of the frames, when they are averaged */
    al_stats stats;
    al_progress progress;
    unsigned frame;
    al_eye eye;
    al_bounds bounds;
} session;

static void pause_ms(double ms)
{
    struct timespec wait = {0, (long)(ms * 1e6)};
    nanosleep(&wait, NULL);
}

static al_status cancelled(al_error *error)
{
    return al_fail(error, AL_CANCELLED, "stopped");
}

/* Found out before anything is rendered: the folder of every output must take new files. */
static al_status check_writable(const char *path, al_error *error)
{
    char folder[4096];
    struct stat about;
    const char *slash = strrchr(path, '/');
    if (stat(path, &about) == 0 && !S_ISREG(about.st_mode))
        return al_fail(error, AL_IO, "%s: is no regular file and stays; give another name", path);
    snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash - path) : 1, slash ? path : ".");
    if (access(*folder ? folder : "/", W_OK | X_OK) == 0) return AL_OK;
    return al_fail(error, AL_IO, "%s: cannot write: %s: %s", path, *folder ? folder : "/", strerror(errno));
}

static al_status check_outputs(const al_play_options *options, al_error *error)
{
    al_status status = options->stats ? check_writable(options->stats, error) : AL_OK;
    for (int i = 0; i < options->out.count && !status; i++)
        status = check_writable(options->out.values[i], error);
    return status;
}

static bool on_tile(void *user, double done, double total)
{
    session *s = user;
    return al_progress_update(&s->progress, s->frame + done / total, s->options->frames);
}

static al_status draw(session *s, al_error *error)
{
    float offset[2] = {0, 0};
    al_settings settings = s->options->settings;
    settings.progress = on_tile;
    settings.progress_user = s;
    if (s->options->accumulate) {
        al_jitter(s->frame, s->options->frames, offset);
        settings.surfel_seed = s->frame;
    }
    al_view view = al_eye_view(&s->eye, &s->bounds, offset, s->target.width, s->target.height);
    al_status status = al_runtime_draw(s->runtime, &view, &settings, s->target.framebuffer, 0, error);
    glFinish();
    return status;
}

static al_status look_at_scene(session *s, al_error *error)
{
    const al_scene *scene = al_runtime_scene(s->runtime);
    const al_camera *camera;
    al_status status = al_play_camera(s->options, scene, &camera, error);
    if (status) return status;
    s->eye = al_eye_from_camera(camera);
    s->bounds = al_bounds_of_scene(scene);
    return AL_OK;
}

/* Frame i shows time i / fps. The camera may move, and so may what its planes enclose. */
static al_status show_frame_time(session *s, al_error *error)
{
    al_runtime_set_time(s->runtime, s->frame / s->options->fps);
    if (!(al_runtime_duration_s(s->runtime) > 0)) return AL_OK;
    al_status status = look_at_scene(s, error);
    al_load_state state = {0};
    while (!status && !state.complete) { /* frames of density sequences, so that every run shows the same */
        if (al_program_cancelled()) return cancelled(error);
        status = al_runtime_update(s->runtime, 0, &state, error);
        if (!status && !state.complete) pause_ms(0.2);
    }
    al_runtime_bounds(s->runtime, s->bounds.low, s->bounds.high);
    return status;
}

/* Loads the folder to its end. With --first-picture frames are drawn meanwhile, as the window does. */
static al_status load(session *s, al_error *error)
{
    s->frame = 0;
    al_progress_begin(&s->progress, s->program, "render");
    bool stream = s->options->first_picture;
    al_load_state state = {0};
    double start_s = al_program_seconds();
    s->stats.first_picture_ms = s->stats.last_sample_ms = NAN;
    al_status status = al_runtime_load(s->runtime, s->options->folder, error);
    if (!status) status = look_at_scene(s, error);
    while (!status && !state.complete) {
        if (al_program_cancelled()) return cancelled(error);
        status = al_runtime_update(s->runtime, stream ? STREAM_BUDGET : 0, &state, error);
        if (status || !stream || !state.ready) {
            pause_ms(0.2);
            continue;
        }
        status = draw(s, error);
        if (isnan(s->stats.first_picture_ms))
            s->stats.first_picture_ms = 1e3 * (al_program_seconds() - start_s);
    }
    s->stats.last_sample_ms = 1e3 * (al_program_seconds() - start_s);
    return status;
}

/* `pattern` with the frame's number for %04d. */
static void frame_path(const char *pattern, unsigned frame, char *path, size_t size)
{
    const char *number = strstr(pattern, "%04d");
    if (number)
        snprintf(path, size, "%.*s%04u%s", (int)(number - pattern), pattern, frame, number + 4);
    else
        snprintf(path, size, "%s", pattern);
}

static al_status write_pictures(session *s, const al_image *image, bool last, al_error *error)
{
    const al_scene *scene = al_runtime_scene(s->runtime);
    al_status status = AL_OK;
    for (int i = 0; i < s->options->out.count && !status; i++) {
        char path[4096];
        const char *pattern = s->options->out.values[i];
        if (!last && !strstr(pattern, "%04d")) continue;
        frame_path(pattern, s->frame, path, sizeof path);
        status = al_picture_write(path, image, al_pass_is_light(s->options->settings.pass),
                                  al_play_exposure(s->options, scene), error);
    }
    return status;
}

static bool wants_picture(const session *s, bool last)
{
    bool every = false;
    for (int i = 0; i < s->options->out.count; i++)
        every |= strstr(s->options->out.values[i], "%04d") != NULL;
    return s->options->out.count && (every || last || s->options->accumulate);
}

/* Adds `image` to the sum and replaces it by the mean so far. */
static al_status accumulate(session *s, al_image *image, al_error *error)
{
    size_t count = (size_t)image->width * image->height * 3;
    if (s->frame == 0) {
        al_image_free(&s->sum);
        s->sum = (al_image){image->width, image->height, 3, calloc(count, sizeof(float))};
        if (!s->sum.pixels) return al_fail(error, AL_IO, "out of memory for the mean of the frames");
    }
    for (size_t i = 0; i < count; i++) {
        s->sum.pixels[i] += image->pixels[i];
        image->pixels[i] = s->sum.pixels[i] / (float)(s->frame + 1);
    }
    return AL_OK;
}

static al_status render_frame(session *s, bool last, al_error *error)
{
    al_image image = {0};
    al_load_state state;
    al_pass_time times[TIMES_LIMIT];
    double start_s = al_program_seconds();
    al_status status = al_runtime_update(s->runtime, 0, &state, error);
    if (!status) status = show_frame_time(s, error);
    if (!status) status = draw(s, error);
    if (status) return status;
    double frame_ms = 1e3 * (al_program_seconds() - start_s);
    status =
        al_stats_add(&s->stats, frame_ms, times, al_runtime_times(s->runtime, times, TIMES_LIMIT), error);
    if (status || !wants_picture(s, last)) return status;
    status = al_target_read(&s->target, &image, error);
    if (!status && s->options->accumulate) status = accumulate(s, &image, error);
    if (!status) status = write_pictures(s, &image, last, error);
    al_image_free(&image);
    return status;
}

static al_status render(session *s, al_error *error)
{
    unsigned count = (unsigned)s->options->frames;
    al_status status = AL_OK;
    al_progress_begin(&s->progress, s->program, "render");
    for (s->frame = 0; s->frame < count && !status; s->frame++)
        status = al_program_cancelled() ? cancelled(error) : render_frame(s, s->frame + 1 == count, error);
    if (!status) al_progress_end(&s->progress);
    if (!status && s->options->stats)
        status = al_stats_write(s->options->stats, &s->stats, s->runtime, error);
    return status;
}

/* Renders again after every change of the folder, until the user stops it. A folder that is broken for a
 * while, say in the middle of a bake, is said and waited for. */
static al_status render_and_watch(session *s, al_error *error)
{
    al_watch watch;
    al_watch_begin(&watch, s->options->folder, al_program_seconds());
    al_status status = render(s, error);
    while (!status) {
        if (al_program_cancelled()) return AL_OK;
        pause_ms(100);
        if (!al_watch_changed(&watch, s->options->folder, al_program_seconds())) continue;
        al_program_say(s->program, "%s has changed", s->options->folder);
        status = load(s, error);
        if (!status) status = render(s, error);
        if (status != AL_BAD_INPUT) continue;
        al_program_fail(s->program, error);
        status = AL_OK;
    }
    return status == AL_CANCELLED ? AL_OK : status;
}

/* Of the second of two frames that are drawn and shown to nobody: what passes run follows from the options, the view and
 * the scene; the first one builds the shaders. */
static al_status print_plan(session *s, al_error *error)
{
    uint32_t count = 0;
    s->frame = 0;
    al_progress_begin(&s->progress, s->program, "plan");
    al_status status = show_frame_time(s, error);
    for (int i = 0; i < 2 && !status; i++) status = draw(s, error);
    if (status) return status;
    al_progress_end(&s->progress);
    al_runtime_times(s->runtime, NULL, 0);
    const al_plan_row *rows = al_runtime_plan(s->runtime, &count);
    for (uint32_t i = 0; i < count; i++)
        printf("%-24s %-4s %10.3f ms %12llu bytes  %s\n", rows[i].step, rows[i].needed ? "yes" : "no",
               1e3 * rows[i].seconds, (unsigned long long)rows[i].bytes, rows[i].why);
    return AL_OK;
}

static al_status run(session *s, al_error *error)
{
    const al_play_options *options = s->options;
    al_status status = check_outputs(options, error);
    if (!status) status = al_offscreen_create(s->program->verbose, &s->offscreen, error);
    if (status) return status;
    if (s->program->verbose) al_debug_output_begin();
    s->stats.renderer = (const char *)glGetString(GL_RENDERER);
    s->stats.pick = &options->pick;
    s->stats.width = (uint32_t)options->size[0];
    s->stats.height = (uint32_t)options->size[1];
    status = al_runtime_create(NULL, &s->runtime, error);
    if (!status) status = al_target_create(s->stats.width, s->stats.height, &s->target, error);
    if (!status) status = load(s, error);
    if (status) return status;
    if (options->plan) return print_plan(s, error);
    return options->watch ? render_and_watch(s, error) : render(s, error);
}

int al_headless_run(const al_program *program, const al_play_options *options)
{
    al_error error;
    session s = {.program = program, .options = options};
    al_status status = run(&s, &error);
    if (s.offscreen.context) {
        al_target_destroy(&s.target);
        al_runtime_destroy(s.runtime);
    }
    al_offscreen_destroy(&s.offscreen);
    al_image_free(&s.sum);
    al_stats_free(&s.stats);
    return al_program_end(program, status ? al_program_fail(program, &error) : AL_OK);
}
