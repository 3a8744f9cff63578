#include "present.h"

#include <epoxy/gl.h>
#include <math.h>
#include <string.h>

#include "play_shaders.h"

static const char *find_text(const char *name)
{
    for (unsigned i = 0; i < play_shaders_count; i++)
        if (!strcmp(play_shaders_names[i], name)) return play_shaders_texts[i];
    return "";
}

static GLuint compile(GLenum stage, const char *name, int count, const char *const *texts, al_error *error)
{
    char log[512] = "";
    GLint good = 0;
    GLuint shader = glCreateShader(stage);
    glShaderSource(shader, count, texts, NULL);
    glCompileShader(shader);
    glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
    if (good) return shader;
    glGetShaderInfoLog(shader, sizeof log, NULL, log);
    log[strcspn(log, "\n")] = 0;
    al_fail(error, AL_NO_DEVICE, "%s: the OpenGL driver refuses it: %s", name, log);
    glDeleteShader(shader);
    return 0;
}

al_status al_present_create(al_present *present, al_error *error)
{
    const char *vertex_text = find_text("present.vert");
    const char *const fragment_texts[] = {"#version 450 core\n#define AL_GLSL\n", find_text("tone_map.h"),
                                          find_text("present.frag")};
    al_status status = AL_NO_DEVICE;
    GLint good = 0;
    *present = (al_present){0};
    GLuint vertex = compile(GL_VERTEX_SHADER, "present.vert", 1, &vertex_text, error);
    GLuint fragment = vertex ? compile(GL_FRAGMENT_SHADER, "present.frag", 3, fragment_texts, error) : 0;
    if (!fragment) goto cleanup;
    present->program = glCreateProgram();
    glAttachShader(present->program, vertex);
    glAttachShader(present->program, fragment);
    glLinkProgram(present->program);
    glGetProgramiv(present->program, GL_LINK_STATUS, &good);
    status = good ? AL_OK : al_fail(error, AL_NO_DEVICE, "present.frag: the OpenGL driver cannot link it");
    glCreateVertexArrays(1, &present->vertex_array);
cleanup:
    glDeleteShader(vertex);
    glDeleteShader(fragment);
    if (status) al_present_destroy(present);
    return status;
}

void al_present_destroy(al_present *present)
{
    glDeleteProgram(present->program);
    glDeleteVertexArrays(1, &present->vertex_array);
    *present = (al_present){0};
}

void al_present_draw(const al_present *present, uint32_t texture, uint32_t width, uint32_t height,
                     double exposure_ev, bool is_light)
{
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glViewport(0, 0, (GLsizei)width, (GLsizei)height);
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glUseProgram(present->program);
    glBindVertexArray(present->vertex_array);
    glBindTextureUnit(0, texture);
    glUniform1f(0, is_light ? exp2f((float)exposure_ev) : 1);
    glUniform1i(1, is_light);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}
