#include "picture.h"

#include <epoxy/gl.h>
#include <stdlib.h>
#include <string.h>

#include "tone_map.h"

al_status al_target_create(uint32_t width, uint32_t height, al_target *target, al_error *error)
{
    *target = (al_target){.width = width, .height = height};
    GLint limit = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &limit);
    if (width > (uint32_t)limit || height > (uint32_t)limit)
        return al_fail(error, AL_NO_DEVICE,
                       "a picture of %ux%u pixels is larger than this device's limit of %d", width, height,
                       limit);
    while (glGetError() != GL_NO_ERROR) continue;
    glCreateTextures(GL_TEXTURE_2D, 1, &target->texture);
    glTextureStorage2D(target->texture, 1, GL_RGBA32F, (GLsizei)width, (GLsizei)height);
    glCreateFramebuffers(1, &target->framebuffer);
    glNamedFramebufferTexture(target->framebuffer, GL_COLOR_ATTACHMENT0, target->texture, 0);
    GLenum complete = glCheckNamedFramebufferStatus(target->framebuffer, GL_FRAMEBUFFER);
    GLenum code = glGetError();
    if (complete == GL_FRAMEBUFFER_COMPLETE && code == GL_NO_ERROR) return AL_OK;
    al_target_destroy(target);
    return al_fail(error, AL_NO_DEVICE,
                   "the device refuses a picture of %ux%u float pixels (OpenGL error 0x%x)", width, height,
                   code);
}

void al_target_destroy(al_target *target)
{
    glDeleteFramebuffers(1, &target->framebuffer);
    glDeleteTextures(1, &target->texture);
    *target = (al_target){0};
}

al_status al_target_read(const al_target *target, al_image *image, al_error *error)
{
    size_t row = (size_t)target->width * 3;
    *image = (al_image){target->width, target->height, 3, malloc(row * target->height * sizeof(float))};
    if (!image->pixels)
        return al_fail(error, AL_IO, "out of memory for a picture of %ux%u pixels", target->width,
                       target->height);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, target->framebuffer);
    glReadBuffer(GL_COLOR_ATTACHMENT0);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    for (uint32_t y = 0; y < target->height; y++) /* GL's first row is the lowest */
        glReadPixels(0, (GLint)(target->height - 1 - y), (GLsizei)target->width, 1, GL_RGB, GL_FLOAT,
                     image->pixels + y * row);
    return AL_OK;
}

bool al_pass_is_light(al_pass pass)
{
    return pass == AL_PASS_COMPOSITE || pass == AL_PASS_TRANSLUCENT || pass == AL_PASS_SURFACE ||
           pass == AL_PASS_DIRECT_SCATTERING || pass == AL_PASS_SURFACE_SCATTERING || pass == AL_PASS_SURFELS ||
           pass == AL_PASS_SHELLS || pass == AL_PASS_UNSHUFFLED || pass == AL_PASS_BLURRED;
}

bool al_picture_has_ending(const char *path, const char *ending)
{
    size_t length = strlen(path), tail = strlen(ending);
    return length > tail && !strcmp(path + length - tail, ending);
}

static al_status write_png(const char *path, const al_image *image, bool is_light, float factor,
                           al_error *error)
{
    size_t count = (size_t)image->width * image->height * 3;
    uint8_t *bytes = malloc(count);
    if (!bytes)
        return al_fail(error, AL_IO, "%s: out of memory for %ux%u pixels", path, image->width, image->height);
    for (size_t i = 0; i < count; i++) {
        float value = factor * image->pixels[i];
        bytes[i] = al_srgb_byte(is_light ? al_tone_map(value) : value);
    }
    al_status status = al_image_write_png(path, image->width, image->height, 3, bytes, error);
    free(bytes);
    return status;
}

al_status al_picture_write(const char *path, const al_image *image, bool is_light, double exposure_ev,
                           al_error *error)
{
    if (al_picture_has_ending(path, ".exr")) return al_image_write_exr(path, image, error);
    return write_png(path, image, is_light, is_light ? exp2f((float)exposure_ev) : 1, error);
}
