/* How a game embeds airlight: its own window, context, colour and depth targets, its own triangle among the
 * baked objects. airlight-host-example DIR [FRAMES]: with FRAMES the window stays hidden and the program ends
 * after them. */
#include <epoxy/gl.h>
#include <GLFW/glfw3.h>
#include <cglm/cglm.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/runtime.h"

enum { WIDTH = 960, HEIGHT = 600 };

typedef struct host {
    GLFWwindow *window;
    GLuint color, depth, framebuffer; /* the game's own targets: linear radiance, and depth as a texture */
    GLuint program, vertex_array;
    al_runtime *runtime;
} host;

static const char *const vertex_text =
    "#version 450 core\n"
    "layout(location = 0) uniform mat4 view_projection;\n"
    "layout(location = 1) uniform vec3 middle;\n"
    "layout(location = 2) uniform float size;\n"
    "void main() {\n"
    "    vec2 corner[3] = vec2[](vec2(-1.0, -0.6), vec2(1.0, -0.6), vec2(0.0, 1.0));\n"
    "    gl_Position = view_projection * vec4(middle + vec3(corner[gl_VertexID] * size, 0.0), 1.0);\n"
    "}\n";
static const char *const fragment_text = "#version 450 core\n"
                                         "layout(location = 0) out vec4 radiance;\n"
                                         "void main() { radiance = vec4(0.1, 0.4, 0.9, 1.0); }\n";

static int fail(al_status status, const char *what)
{
    fprintf(stderr, "airlight-host-example: %s\n", what);
    return (int)status;
}

static void add_shader(GLuint program, GLenum stage, const char *text)
{
    GLuint shader = glCreateShader(stage);
    glShaderSource(shader, 1, &text, NULL);
    glCompileShader(shader);
    glAttachShader(program, shader);
    glDeleteShader(shader);
}

static int open_window(host *h, int hidden)
{
    if (!glfwInit()) return fail(AL_NO_DEVICE, "GLFW does not start: is there a display?");
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_VISIBLE, hidden ? GLFW_FALSE : GLFW_TRUE);
    glfwWindowHint(GLFW_RESIZABLE, GLFW_FALSE);
    h->window = glfwCreateWindow(WIDTH, HEIGHT, "airlight in a game", NULL, NULL);
    if (!h->window) return fail(AL_NO_DEVICE, "no window with OpenGL 4.5");
    glfwMakeContextCurrent(h->window);
    return 0;
}

static void make_targets(host *h)
{
    glCreateTextures(GL_TEXTURE_2D, 1, &h->color);
    glTextureStorage2D(h->color, 1, GL_RGBA16F, WIDTH, HEIGHT);
    glCreateTextures(GL_TEXTURE_2D, 1, &h->depth);
    glTextureStorage2D(h->depth, 1, GL_DEPTH_COMPONENT32F, WIDTH, HEIGHT);
    glCreateFramebuffers(1, &h->framebuffer);
    glNamedFramebufferTexture(h->framebuffer, GL_COLOR_ATTACHMENT0, h->color, 0);
    glNamedFramebufferTexture(h->framebuffer, GL_DEPTH_ATTACHMENT, h->depth, 0);
    h->program = glCreateProgram();
    add_shader(h->program, GL_VERTEX_SHADER, vertex_text);
    add_shader(h->program, GL_FRAGMENT_SHADER, fragment_text);
    glLinkProgram(h->program);
    glCreateVertexArrays(1, &h->vertex_array);
}

/* The scene's first camera, swaying. */
static void make_view(const al_scene *scene, double time, al_view *view, vec3 middle, float *size)
{
    const al_camera *camera = &scene->cameras[0];
    vec3 eye, target, up, path;
    mat4 matrix;
    memcpy(eye, camera->position, sizeof eye);
    memcpy(target, camera->target, sizeof target);
    memcpy(up, camera->up, sizeof up);
    glm_vec3_sub(eye, target, path);
    glm_vec3_rotate(path, 0.3f * sinf((float)time), up);
    glm_vec3_add(target, path, eye);
    float distance = glm_vec3_norm(path);
    *size = 0.1f * distance;
    glm_vec3_copy(target, middle);
    glm_lookat(eye, target, up, matrix);
    memcpy(view->view, matrix, sizeof view->view);
    glm_perspective(camera->fov_y_radians, (float)WIDTH / HEIGHT, 0.02f * distance, 50 * distance, matrix);
    memcpy(view->projection, matrix, sizeof view->projection);
    view->width = WIDTH;
    view->height = HEIGHT;
}

/* The game's own drawing; it sets all the state it needs, for the library restores little. */
static void draw_own(const host *h, const al_view *view, vec3 middle, float size)
{
    mat4 matrix, projection;
    memcpy(matrix, view->view, sizeof matrix);
    memcpy(projection, view->projection, sizeof projection);
    glm_mat4_mul(projection, matrix, matrix);
    glBindFramebuffer(GL_FRAMEBUFFER, h->framebuffer);
    glViewport(0, 0, WIDTH, HEIGHT);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_TRUE);
    glClearColor(0, 0, 0, 1);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glUseProgram(h->program);
    glUniformMatrix4fv(0, 1, GL_FALSE, matrix[0]);
    glUniform3fv(1, 1, middle);
    glUniform1f(2, size);
    glBindVertexArray(h->vertex_array);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

static int run(host *h, const char *folder, int frames)
{
    al_error error = {0};
    const al_settings settings = {0};
    if (al_runtime_load(h->runtime, folder, &error)) return fail(error.status, error.message);
    for (int i = 0; (!frames || i < frames) && !glfwWindowShouldClose(h->window); i++) {
        al_view view = {0};
        al_load_state state;
        vec3 middle;
        float size;
        /* A megabyte a frame, so that streaming never costs a frame; errors concern one asset each. */
        if (al_runtime_update(h->runtime, 1 << 20, &state, &error)) fail(error.status, error.message);
        make_view(al_runtime_scene(h->runtime), glfwGetTime(), &view, middle, &size);
        draw_own(h, &view, middle, size);
        /* With a depth texture the library draws over the game's picture and is hidden by its triangle. */
        if (al_runtime_draw(h->runtime, &view, &settings, h->framebuffer, h->depth, &error))
            return fail(error.status, error.message);
        /* A game would tone-map here. */
        glBlitNamedFramebuffer(h->framebuffer, 0, 0, 0, WIDTH, HEIGHT, 0, 0, WIDTH, HEIGHT,
                               GL_COLOR_BUFFER_BIT, GL_NEAREST);
        glfwSwapBuffers(h->window);
        glfwPollEvents();
    }
    return 0;
}

int main(int argc, char **argv)
{
    host h = {0};
    al_error error = {0};
    int frames = argc > 2 ? atoi(argv[2]) : 0;
    if (argc < 2) return fail(AL_USAGE, "usage: airlight-host-example DIR [FRAMES]");
    int code = open_window(&h, frames > 0);
    if (!code && al_runtime_create(NULL, &h.runtime, &error)) code = fail(error.status, error.message);
    if (!code) {
        make_targets(&h);
        code = run(&h, argv[1], frames);
    }
    if (h.window) {
        al_runtime_destroy(h.runtime);
        glDeleteFramebuffers(1, &h.framebuffer);
        glDeleteTextures(1, &h.color);
        glDeleteTextures(1, &h.depth);
        glDeleteVertexArrays(1, &h.vertex_array);
        glDeleteProgram(h.program);
        glfwDestroyWindow(h.window);
    }
    glfwTerminate();
    return code;
}
