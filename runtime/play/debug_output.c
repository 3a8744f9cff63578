#include "debug_output.h"

#include <epoxy/gl.h>
#include <stdio.h>

static void print_message(GLenum source, GLenum type, GLuint id, GLenum severity, GLsizei length,
                          const GLchar *text, const void *user)
{
    (void)source, (void)type, (void)length, (void)user;
    if (severity != GL_DEBUG_SEVERITY_NOTIFICATION)
        fprintf(stderr, "airlight-play: OpenGL %u: %s\n", id, text);
}

void al_debug_output_begin(void)
{
    glEnable(GL_DEBUG_OUTPUT);
    glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    glDebugMessageCallback(print_message, NULL);
    fprintf(stderr, "airlight-play: %s, %s\n", (const char *)glGetString(GL_RENDERER),
            (const char *)glGetString(GL_VERSION));
}
