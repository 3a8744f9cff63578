#include "stage.h"

#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <ftw.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static void report(GLenum source, GLenum type, GLuint id, GLenum severity, GLsizei length,
                   const char *message, const void *user)
{
    (void)source, (void)id, (void)severity, (void)length, (void)user;
    if (type == GL_DEBUG_TYPE_ERROR) fprintf(stderr, "OpenGL: %s\n", message);
}

bool stage_open(void)
{
    static const EGLint wanted[] = {EGL_CONTEXT_MAJOR_VERSION,
                                    4,
                                    EGL_CONTEXT_MINOR_VERSION,
                                    5,
                                    EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                    EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                    EGL_CONTEXT_OPENGL_DEBUG,
                                    EGL_TRUE,
                                    EGL_NONE};
    EGLDisplay display = eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL);
    if (display == EGL_NO_DISPLAY || !eglInitialize(display, NULL, NULL)) {
        display = eglGetDisplay(EGL_DEFAULT_DISPLAY);
        if (display == EGL_NO_DISPLAY || !eglInitialize(display, NULL, NULL)) return false;
    }
    if (!eglBindAPI(EGL_OPENGL_API)) return false;
    EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, wanted);
    if (context == EGL_NO_CONTEXT || !eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context))
        return false;
    glEnable(GL_DEBUG_OUTPUT);
    glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    glDebugMessageCallback(report, NULL);
    return true;
}

static void cross(const float a[3], const float b[3], float out[3])
{
    for (int k = 0; k < 3; k++) out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static void normalize(float v[3])
{
    float length = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int k = 0; k < 3; k++) v[k] /= length;
}

al_view stage_look(uint32_t width, uint32_t height, const float eye[3], const float target[3], float fov)
{
    al_view view = {.width = width, .height = height};
    float forward[3], right[3], up[3] = {0, 1, 0};
    for (int k = 0; k < 3; k++) forward[k] = target[k] - eye[k];
    normalize(forward);
    cross(forward, up, right);
    normalize(right);
    cross(right, forward, up);
    for (int k = 0; k < 3; k++) {
        view.view[4 * k] = right[k];
        view.view[4 * k + 1] = up[k];
        view.view[4 * k + 2] = -forward[k];
        view.view[12] -= right[k] * eye[k];
        view.view[13] -= up[k] * eye[k];
        view.view[14] += forward[k] * eye[k];
    }
    view.view[15] = 1;
    float near = 0.01f, far = 100, scale = 1 / tanf(fov / 2);
    view.projection[0] = scale * (float)height / (float)width;
    view.projection[5] = scale;
    view.projection[10] = (far + near) / (near - far);
    view.projection[11] = -1;
    view.projection[14] = 2 * far * near / (near - far);
    return view;
}

al_view stage_ortho(uint32_t width, uint32_t height, float half)
{
    al_view view = {.width = width, .height = height};
    view.view[0] = view.view[5] = view.view[10] = view.view[15] = 1;
    view.view[14] = -5;
    view.projection[0] = view.projection[5] = 1 / half;
    view.projection[10] = -2.0f / 10;
    view.projection[14] = -1;
    view.projection[15] = 1;
    return view;
}

bool stage_load(al_runtime *runtime, const char *folder)
{
    al_error error = {0};
    al_load_state state = {0};
    if (al_runtime_load(runtime, folder, &error)) {
        fprintf(stderr, "load: %s\n", error.message);
        return false;
    }
    while (!state.complete) {
        struct timespec pause = {0, 1000000};
        if (al_runtime_update(runtime, 0, &state, &error)) {
            fprintf(stderr, "update: %s\n", error.message);
            return false;
        }
        if (!state.complete) nanosleep(&pause, NULL);
    }
    return true;
}

float *stage_draw(al_runtime *runtime, const al_view *view, const al_settings *settings, uint32_t depth)
{
    al_error error = {0};
    GLuint texture, framebuffer;
    size_t size = (size_t)view->width * view->height * 3 * sizeof(float);
    float *pixels = malloc(size);
    glCreateTextures(GL_TEXTURE_2D, 1, &texture);
    glTextureStorage2D(texture, 1, GL_RGBA32F, (GLsizei)view->width, (GLsizei)view->height);
    glCreateFramebuffers(1, &framebuffer);
    glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, texture, 0);
    al_status status = al_runtime_draw(runtime, view, settings, framebuffer, depth, &error);
    if (status) {
        fprintf(stderr, "draw: %s\n", error.message);
        free(pixels);
        pixels = NULL;
    } else {
        glGetTextureImage(texture, 0, GL_RGB, GL_FLOAT, (GLsizei)size, pixels);
    }
    for (GLenum code; (code = glGetError());) fprintf(stderr, "draw: OpenGL error 0x%04x\n", code);
    glDeleteFramebuffers(1, &framebuffer);
    glDeleteTextures(1, &texture);
    return pixels;
}

static char own_folder[256];

static int remove_entry(const char *path, const struct stat *status, int type, struct FTW *place)
{
    (void)status, (void)type, (void)place;
    return remove(path);
}

static void remove_folder(void)
{
    nftw(own_folder, remove_entry, 8, FTW_DEPTH | FTW_PHYS);
}

const char *stage_folder(void)
{
    const char *folder = getenv("TMPDIR");
    snprintf(own_folder, sizeof own_folder, "%s/airlight-test-XXXXXX", folder && *folder ? folder : "/tmp");
    if (!mkdtemp(own_folder)) return NULL;
    atexit(remove_folder);
    return own_folder;
}

uint64_t stage_bad(const float *pixels, uint64_t count)
{
    uint64_t bad = 0;
    for (uint64_t i = 0; i < count; i++) bad += !(pixels[i] >= 0) || isinf(pixels[i]);
    return bad;
}

double stage_sum(const float *pixels, uint64_t count)
{
    double sum = 0;
    for (uint64_t i = 0; i < count; i++) sum += pixels[i];
    return sum;
}
