#define _POSIX_C_SOURCE 200809L
#include "window.h"

#include <epoxy/gl.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "debug_output.h"
#include "eye.h"
#include "panel.h"
#include "picture.h"
#include "present.h"
#include "watch.h"

enum { TIMES_LIMIT = 64, UPLOAD_BUDGET = 8 << 20 }; /* bytes per frame: a few milliseconds */

typedef struct player {
    const al_program *program;
    const al_play_options *options;
    GLFWwindow *window;
    al_runtime *runtime;
    al_target target;
    al_present present;
    al_eye eye;
    al_bounds bounds;
    al_settings settings;
    al_load_state load;
    al_watch watch;
    float exposure_ev;
    int camera, applied_camera; /* what the panel shows, and what the eye was last set to */
    char folder[4096], message[AL_ERROR_SIZE];
    bool panel_ready, panel_hidden, help;
    bool screenshot; /* of the next frame, which shows all that happened before the key */
    double mouse[2], last_s, frame_ms;
    double time_s; /* shown, within the scene's duration */
    bool paused;
    al_pass_time times[TIMES_LIMIT];
    uint32_t time_count;
} player;

static void show_message(player *p, const al_error *error)
{
    snprintf(p->message, sizeof p->message, "%s", error->message);
    fprintf(stderr, "%s: %s\n", p->program->name, error->message);
}

/* --- the folder --- */

static void use_camera(player *p, int index)
{
    const al_scene *scene = al_runtime_scene(p->runtime);
    if (!scene || index < 0 || index >= (int)scene->camera_count) return;
    p->eye = al_eye_from_camera(&scene->cameras[index]);
    p->camera = p->applied_camera = index;
}

/* The folder `path` names, or the one the file lies in. */
static al_status folder_of(const char *path, char *folder, size_t size, al_error *error)
{
    struct stat about;
    if (snprintf(folder, size, "%s", path) >= (int)size)
        return al_fail(error, AL_BAD_INPUT, "%s: the path is longer than %zu characters", path, size - 1);
    if (stat(path, &about) || S_ISDIR(about.st_mode)) return AL_OK;
    char *slash = strrchr(folder, '/');
    if (slash)
        slash[slash == folder] = 0; /* keeps "/" */
    else
        strcpy(folder, ".");
    return AL_OK;
}

/* Goes on with the time, and with a camera of the scene that moves. */
static void advance(player *p, double seconds)
{
    double length_s = al_runtime_duration_s(p->runtime);
    if (!(length_s > 0)) return;
    if (!p->paused) p->time_s = fmod(p->time_s + seconds, length_s);
    al_runtime_set_time(p->runtime, p->time_s);
    al_runtime_bounds(p->runtime, p->bounds.low, p->bounds.high);
    if (p->camera == p->applied_camera) use_camera(p, p->camera);
}

/* What was open stays when there is no scene to open. Moves neither the eye nor the exposure. */
static al_status open_folder(player *p, const char *path, al_error *error)
{
    char folder[sizeof p->folder], title[sizeof p->folder + 16];
    al_status status = folder_of(path, folder, sizeof folder, error);
    if (!status) status = al_runtime_load(p->runtime, folder, error);
    if (status) return status;
    memcpy(p->folder, folder, sizeof folder);
    snprintf(title, sizeof title, "%s - airlight", folder);
    glfwSetWindowTitle(p->window, title);
    al_watch_begin(&p->watch, folder, glfwGetTime());
    const al_scene *scene = al_runtime_scene(p->runtime);
    p->load = (al_load_state){0};
    p->time_s = 0;
    p->message[0] = 0;
    p->bounds = al_bounds_of_scene(scene);
    if (p->camera >= (int)scene->camera_count) p->camera = p->applied_camera = -1;
    return AL_OK;
}

static al_status open_first_folder(player *p, al_error *error)
{
    const al_camera *camera;
    if (!p->options->folder) return AL_OK;
    al_status status = open_folder(p, p->options->folder, error);
    if (status) return status;
    const al_scene *scene = al_runtime_scene(p->runtime);
    p->exposure_ev = (float)al_play_exposure(p->options, scene);
    status = al_play_camera(p->options, scene, &camera, error);
    if (!status) use_camera(p, (int)(camera - scene->cameras));
    return status;
}

static void reload_when_changed(player *p)
{
    al_error error;
    if (!p->options->watch || !*p->folder || !al_watch_changed(&p->watch, p->folder, glfwGetTime())) return;
    if (open_folder(p, p->folder, &error)) show_message(p, &error);
}

/* --- what the user does --- */

static void on_drop(GLFWwindow *window, int count, const char **paths)
{
    player *p = glfwGetWindowUserPointer(window);
    al_error error;
    if (count < 1) return;
    if (open_folder(p, paths[0], &error)) {
        show_message(p, &error);
        return;
    }
    p->exposure_ev = (float)al_play_exposure(p->options, al_runtime_scene(p->runtime));
    use_camera(p, 0);
    al_program_say(p->program, "opened %s", p->folder);
}

static void on_scroll(GLFWwindow *window, double x, double y)
{
    player *p = glfwGetWindowUserPointer(window);
    (void)x;
    if (al_panel_wants_mouse()) return;
    al_eye_zoom(&p->eye, powf(0.9f, (float)y));
    p->camera = p->applied_camera = -1;
}

/* The first free airlight-NNNN.exr and .png in the working folder. */
static void take_screenshot(player *p)
{
    char exr[32], png[32];
    al_error error;
    al_image image = {0};
    for (int i = 1; i < 10000; i++) {
        snprintf(exr, sizeof exr, "airlight-%04d.exr", i);
        snprintf(png, sizeof png, "airlight-%04d.png", i);
        if (access(exr, F_OK) && access(png, F_OK)) break;
    }
    bool is_light = al_pass_is_light(p->settings.pass);
    al_status status = al_target_read(&p->target, &image, &error);
    if (!status) status = al_picture_write(exr, &image, is_light, p->exposure_ev, &error);
    if (!status) status = al_picture_write(png, &image, is_light, p->exposure_ev, &error);
    al_image_free(&image);
    if (status) {
        show_message(p, &error);
        return;
    }
    snprintf(p->message, sizeof p->message, "wrote %s and %s", exr, png);
    al_program_say(p->program, "%s", p->message);
}

static void on_key(GLFWwindow *window, int key, int code, int action, int mods)
{
    player *p = glfwGetWindowUserPointer(window);
    (void)code, (void)mods;
    if (action != GLFW_PRESS || al_panel_wants_keyboard()) return;
    if (key >= GLFW_KEY_1 && key <= GLFW_KEY_9) use_camera(p, key - GLFW_KEY_1);
    switch (key) {
    case GLFW_KEY_ESCAPE:
        glfwSetWindowShouldClose(window, GLFW_TRUE);
        break;
    case GLFW_KEY_TAB:
        p->panel_hidden = !p->panel_hidden;
        break;
    case GLFW_KEY_H:
        p->help = !p->help;
        break;
    case GLFW_KEY_G:
        p->settings.fog_off = !p->settings.fog_off;
        break;
    case GLFW_KEY_L:
        p->settings.scattered_off = !p->settings.scattered_off;
        break;
    case GLFW_KEY_SPACE:
        p->paused = !p->paused;
        break;
    case GLFW_KEY_P:
        p->screenshot = true;
        break;
    case GLFW_KEY_EQUAL:
    case GLFW_KEY_KP_ADD:
        p->exposure_ev += 0.25f;
        break;
    case GLFW_KEY_MINUS:
    case GLFW_KEY_KP_SUBTRACT:
        p->exposure_ev -= 0.25f;
        break;
    case GLFW_KEY_F:
        al_eye_frame(&p->eye, &p->bounds);
        p->camera = p->applied_camera = -1;
        break;
    default:
        break;
    }
}

/* An event, not a look once per frame: a quick drag counts however long frames take. */
static void on_cursor(GLFWwindow *window, double x, double y)
{
    const float radians_per_pixel = 0.006f;
    player *p = glfwGetWindowUserPointer(window);
    float yaw = -radians_per_pixel * (float)(x - p->mouse[0]),
          pitch = -radians_per_pixel * (float)(y - p->mouse[1]);
    p->mouse[0] = x;
    p->mouse[1] = y;
    if (al_panel_wants_mouse()) return;
    if (glfwGetMouseButton(p->window, GLFW_MOUSE_BUTTON_LEFT))
        al_eye_orbit(&p->eye, yaw, -pitch);
    else if (glfwGetMouseButton(p->window, GLFW_MOUSE_BUTTON_RIGHT))
        al_eye_look(&p->eye, 0.5f * yaw, 0.5f * pitch);
    else
        return;
    p->camera = p->applied_camera = -1;
}

static float key_axis(GLFWwindow *window, int forward, int back)
{
    return (float)(glfwGetKey(window, forward) - glfwGetKey(window, back));
}

static void fly(player *p, double seconds)
{
    if (al_panel_wants_keyboard()) return;
    float size = 0;
    for (int i = 0; i < 3; i++) size += fabsf(p->eye.target[i] - p->eye.position[i]);
    float step = size * (float)seconds * (glfwGetKey(p->window, GLFW_KEY_LEFT_SHIFT) ? 3 : 0.7f);
    float right = key_axis(p->window, GLFW_KEY_D, GLFW_KEY_A),
          up = key_axis(p->window, GLFW_KEY_E, GLFW_KEY_Q);
    float forward = key_axis(p->window, GLFW_KEY_W, GLFW_KEY_S);
    if (right == 0 && up == 0 && forward == 0) return;
    al_eye_move(&p->eye, step * right, step * up, step * forward);
    p->camera = p->applied_camera = -1;
}

/* --- one frame --- */

static al_status fit_target(player *p, int width, int height, al_error *error)
{
    if (p->target.width == (uint32_t)width && p->target.height == (uint32_t)height) return AL_OK;
    al_target_destroy(&p->target);
    return al_target_create((uint32_t)width, (uint32_t)height, &p->target, error);
}

static al_status draw_scene(player *p, al_error *error)
{
    const float centre[2] = {0, 0};
    if (al_runtime_update(p->runtime, UPLOAD_BUDGET, &p->load, error)) show_message(p, error);
    al_view view = al_eye_view(&p->eye, &p->bounds, centre, p->target.width, p->target.height);
    al_status status = al_runtime_draw(p->runtime, &view, &p->settings, p->target.framebuffer, 0, error);
    if (status) return status;
    uint32_t count = al_runtime_times(p->runtime, p->times, TIMES_LIMIT);
    if (count) p->time_count = count;
    al_present_draw(&p->present, p->target.texture, p->target.width, p->target.height, p->exposure_ev,
                    al_pass_is_light(p->settings.pass));
    return AL_OK;
}

static void draw_panel(player *p)
{
    if (p->panel_hidden) return;
    al_panel_state state = {.runtime = p->runtime,
                            .folder = p->folder,
                            .message = p->message,
                            .load = p->load,
                            .settings = &p->settings,
                            .exposure_ev = &p->exposure_ev,
                            .camera = &p->camera,
                            .time_s = &p->time_s,
                            .paused = &p->paused,
                            .times = p->times,
                            .time_count = p->time_count,
                            .frame_ms = p->frame_ms,
                            .help = p->help};
    al_panel_draw(&state);
    if (p->camera != p->applied_camera) use_camera(p, p->camera);
}

static al_status frame(player *p, al_error *error)
{
    int width, height;
    double now_s = glfwGetTime(), seconds = now_s - p->last_s;
    p->last_s = now_s;
    p->frame_ms += 0.1 * (1e3 * seconds - p->frame_ms);
    glfwGetFramebufferSize(p->window, &width, &height);
    if (width < 1 || height < 1) return glfwWaitEventsTimeout(0.1), AL_OK;
    fly(p, fmin(seconds, 0.1));
    reload_when_changed(p);
    al_status status = fit_target(p, width, height, error);
    if (!status) advance(p, seconds);
    if (!status && al_runtime_scene(p->runtime))
        status = draw_scene(p, error);
    else if (!status)
        glBindFramebuffer(GL_FRAMEBUFFER, 0), glClear(GL_COLOR_BUFFER_BIT);
    if (status) return status;
    if (p->screenshot && al_runtime_scene(p->runtime)) take_screenshot(p);
    p->screenshot = false;
    draw_panel(p);
    glfwSwapBuffers(p->window);
    glfwPollEvents();
    return AL_OK;
}

/* --- the window --- */

static al_status open_window(player *p, al_error *error)
{
    const char *why = NULL;
    if (!glfwInit()) {
        glfwGetError(&why);
        return al_fail(error, AL_NO_DEVICE, "no window: %s; --headless renders without a display",
                       why ? why : "no display");
    }
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_CONTEXT_ROBUSTNESS, GLFW_LOSE_CONTEXT_ON_RESET);
    glfwWindowHint(GLFW_OPENGL_DEBUG_CONTEXT, p->program->verbose);
    p->window = glfwCreateWindow(p->options->size[0], p->options->size[1], "airlight", NULL, NULL);
    if (!p->window) {
        glfwGetError(&why);
        return al_fail(error, AL_NO_DEVICE, "no window with OpenGL 4.5 core: %s",
                       why ? why : "unknown reason");
    }
    glfwSetWindowUserPointer(p->window, p);
    glfwMakeContextCurrent(p->window);
    glfwSwapInterval(1);
    glfwSetDropCallback(p->window, on_drop);
    glfwSetCursorPosCallback(p->window, on_cursor);
    glfwSetScrollCallback(p->window, on_scroll);
    glfwSetKeyCallback(p->window, on_key);
    if (p->program->verbose) al_debug_output_begin();
    p->panel_ready = al_panel_create(p->window);
    return p->panel_ready ? AL_OK : al_fail(error, AL_NO_DEVICE, "the panel does not start on this driver");
}

static al_status run(player *p, al_error *error)
{
    al_status status = open_window(p, error);
    if (!status) status = al_runtime_create(NULL, &p->runtime, error);
    if (!status) status = al_present_create(&p->present, error);
    if (!status) status = open_first_folder(p, error);
    p->last_s = glfwGetTime();
    while (!status && !glfwWindowShouldClose(p->window) && !al_program_cancelled()) status = frame(p, error);
    return status;
}

static void close_window(player *p)
{
    if (p->window) {
        al_target_destroy(&p->target);
        al_present_destroy(&p->present);
        al_runtime_destroy(p->runtime);
        if (p->panel_ready) al_panel_destroy();
        glfwDestroyWindow(p->window);
    }
    glfwTerminate();
}

int al_window_run(const al_program *program, const al_play_options *options)
{
    al_error error;
    player *p = calloc(1, sizeof *p);
    if (!p) {
        al_fail(&error, AL_IO, "out of memory");
        return al_program_fail(program, &error);
    }
    p->program = program;
    p->options = options;
    p->settings = options->settings;
    p->camera = p->applied_camera = -1;
    al_status status = run(p, &error);
    close_window(p);
    free(p);
    return status ? al_program_fail(program, &error) : AL_OK;
}
