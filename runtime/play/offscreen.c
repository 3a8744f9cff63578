#define _POSIX_C_SOURCE 200809L
#include "offscreen.h"

#include <epoxy/egl.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { DEVICE_LIMIT = 32 };

static bool open_config(EGLDisplay display, EGLConfig *config)
{
    static const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                                    EGL_NONE};
    EGLint count = 0;
    return eglChooseConfig(display, wanted, config, 1, &count) && count > 0;
}

/* Everything on one display; NULL, or which call failed. */
static const char *try_display(EGLDisplay display, bool debug, al_offscreen *offscreen)
{
    static const EGLint pbuffer[] = {EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE};
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                 4,
                                 EGL_CONTEXT_MINOR_VERSION,
                                 5,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                 EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                 EGL_CONTEXT_OPENGL_DEBUG,
                                 debug,
                                 EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY,
                                 EGL_LOSE_CONTEXT_ON_RESET,
                                 EGL_NONE};
    EGLint without[sizeof attributes / sizeof *attributes];
    memcpy(without, attributes, sizeof without);
    without[sizeof attributes / sizeof *attributes - 3] = EGL_NONE; /* drivers that do not notify */
    EGLConfig config;
    EGLContext context = EGL_NO_CONTEXT;
    EGLSurface surface = EGL_NO_SURFACE;
    const char *failed = NULL;
    if (display == EGL_NO_DISPLAY) return "eglGetPlatformDisplay";
    if (!eglInitialize(display, NULL, NULL)) return "eglInitialize";
    if (!eglBindAPI(EGL_OPENGL_API))
        failed = "eglBindAPI";
    else if (!open_config(display, &config))
        failed = "eglChooseConfig";
    else if ((context = eglCreateContext(display, config, EGL_NO_CONTEXT, attributes)) == EGL_NO_CONTEXT &&
             (context = eglCreateContext(display, config, EGL_NO_CONTEXT, without)) == EGL_NO_CONTEXT)
        failed = "eglCreateContext";
    else if (!epoxy_has_egl_extension(display, "EGL_KHR_surfaceless_context") &&
             (surface = eglCreatePbufferSurface(display, config, pbuffer)) == EGL_NO_SURFACE)
        failed = "eglCreatePbufferSurface";
    else if (!eglMakeCurrent(display, surface, surface, context))
        failed = "eglMakeCurrent";
    *offscreen = (al_offscreen){display, surface, context};
    if (failed) al_offscreen_destroy(offscreen);
    return failed;
}

static const char *try_devices(bool debug, al_offscreen *offscreen)
{
    EGLDeviceEXT devices[DEVICE_LIMIT];
    EGLint count = 0;
    const char *failed = "eglQueryDevicesEXT";
    if (!epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_device") ||
        !eglQueryDevicesEXT(DEVICE_LIMIT, devices, &count))
        return failed;
    for (EGLint i = 0; i < count && failed; i++)
        failed = try_display(eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[i], NULL), debug,
                             offscreen);
    return failed;
}

static const char *try_surfaceless(bool debug, al_offscreen *offscreen)
{
    if (!epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless"))
        return "EGL_MESA_platform_surfaceless";
    return try_display(eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL),
                       debug, offscreen);
}

al_status al_offscreen_create(bool debug, al_offscreen *offscreen, al_error *error)
{
    *offscreen = (al_offscreen){0};
    if (!debug) setenv("EGL_LOG_LEVEL", "fatal", 0); /* our one line says what failed */
    const char *device = try_devices(debug, offscreen);
    if (!device) return AL_OK;
    const char *surfaceless = try_surfaceless(debug, offscreen);
    if (!surfaceless) return AL_OK;
    const char *display = try_display(eglGetDisplay(EGL_DEFAULT_DISPLAY), debug, offscreen);
    if (!display) return AL_OK;
    return al_fail(
        error, AL_NO_DEVICE,
        "no OpenGL 4.5 core context without a display (EGL devices: %s failed; surfaceless: %s; default "
        "display: %s); a driver with OpenGL 4.5 is needed, Mesa's llvmpipe will do",
        device, surfaceless, display);
}

void al_offscreen_destroy(al_offscreen *offscreen)
{
    if (!offscreen->display) return;
    eglMakeCurrent(offscreen->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (offscreen->surface) eglDestroySurface(offscreen->display, offscreen->surface);
    if (offscreen->context) eglDestroyContext(offscreen->display, offscreen->context);
    eglTerminate(offscreen->display);
    *offscreen = (al_offscreen){0};
}
