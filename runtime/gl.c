#include "gl.h"

static uint32_t texel_size(GLenum format)
{
    switch (format) {
    case GL_R8:
        return 1;
    case GL_R16:
    case GL_R16F:
        return 2;
    case GL_RGBA32F:
    case GL_RGBA32UI:
        return 16;
    case GL_RGB32F:
        return 12;
    case GL_RGB16F:
        return 6;
    case GL_RG32F:
    case GL_RG32UI:
    case GL_RGBA16F:
        return 8;
    default:
        return 4; /* R32F, RG16, RGBA8, SRGB8_ALPHA8, DEPTH_COMPONENT32F */
    }
}

/* The driver's answer to an allocation; older errors are dropped first by the caller. */
static al_status allocation_status(const char *what, uint64_t bytes, al_error *error)
{
    GLenum code = glGetError();
    if (code == GL_NO_ERROR) return AL_OK;
    return al_fail(error, AL_IO,
                   "OpenGL: no memory for %s of %llu bytes (error 0x%04x); use a smaller view or asset", what,
                   (unsigned long long)bytes, code);
}

al_status al_gl_check_lost(al_error *error)
{
    const char *why = "for an unknown reason";
    GLenum code = glGetGraphicsResetStatus();
    if (code == GL_NO_ERROR) return AL_OK;
    if (code == GL_GUILTY_CONTEXT_RESET) why = "while it drew for this program";
    if (code == GL_INNOCENT_CONTEXT_RESET) why = "while it drew for another program";
    return al_fail(error, AL_NO_DEVICE, "OpenGL: the context is lost, the device was reset %s; start anew with a new context",
                   why);
}

static void drop_errors(void)
{
    for (int i = 0; i < 16 && glGetError() != GL_NO_ERROR; i++) {
    }
}

al_status al_gl_buffer_create(al_gl_memory *memory, uint64_t size, const void *data, al_gl_buffer *buffer,
                              al_error *error)
{
    *buffer = (al_gl_buffer){0};
    if (!size) return AL_OK;
    if (size > INT64_MAX)
        return al_fail(error, AL_IO, "OpenGL: a buffer of %llu bytes is too large", (unsigned long long)size);
    drop_errors();
    glCreateBuffers(1, &buffer->id);
    glNamedBufferStorage(buffer->id, (GLsizeiptr)size, data, GL_DYNAMIC_STORAGE_BIT);
    al_status status = allocation_status("a buffer", size, error);
    if (status) {
        glDeleteBuffers(1, &buffer->id);
        *buffer = (al_gl_buffer){0};
        return status;
    }
    buffer->size = size;
    memory->bytes += size;
    return AL_OK;
}

void al_gl_buffer_free(al_gl_memory *memory, al_gl_buffer *buffer)
{
    if (buffer->id) glDeleteBuffers(1, &buffer->id);
    memory->bytes -= buffer->size;
    *buffer = (al_gl_buffer){0};
}

al_status al_gl_buffer_fit(al_gl_memory *memory, uint64_t size, al_gl_buffer *buffer, al_error *error)
{
    al_status status = AL_OK;
    if (buffer->size != size) {
        al_gl_buffer_free(memory, buffer);
        status = al_gl_buffer_create(memory, size, NULL, buffer, error);
    }
    buffer->frame = memory->frame;
    return status;
}

void al_gl_buffer_sweep(al_gl_memory *memory, al_gl_buffer *buffer)
{
    if (buffer->frame != memory->frame) al_gl_buffer_free(memory, buffer);
}

static uint64_t texture_bytes(const al_gl_texture *t, uint32_t levels)
{
    uint64_t bytes = 0, width = t->width, height = t->height;
    for (uint32_t level = 0; level < levels; level++) {
        bytes += width * height * t->depth * texel_size(t->format);
        width = width > 1 ? width / 2 : 1;
        height = height > 1 ? height / 2 : 1;
    }
    return bytes;
}

al_status al_gl_texture_create(al_gl_memory *memory, GLenum target, GLenum format, uint32_t width,
                               uint32_t height, uint32_t depth, uint32_t levels, al_gl_texture *texture,
                               al_error *error)
{
    al_gl_texture made = {0, target, format, width, height, depth, levels, 0, memory->frame};
    *texture = (al_gl_texture){0};
    drop_errors();
    glCreateTextures(target, 1, &made.id);
    if (target == GL_TEXTURE_2D)
        glTextureStorage2D(made.id, (GLsizei)levels, format, (GLsizei)width, (GLsizei)height);
    else
        glTextureStorage3D(made.id, (GLsizei)levels, format, (GLsizei)width, (GLsizei)height, (GLsizei)depth);
    glTextureParameteri(made.id, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTextureParameteri(made.id, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTextureParameteri(made.id, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(made.id, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glTextureParameteri(made.id, GL_TEXTURE_WRAP_R, GL_CLAMP_TO_EDGE);
    made.bytes = texture_bytes(&made, levels);
    al_status status = allocation_status("a texture", made.bytes, error);
    if (status) {
        glDeleteTextures(1, &made.id);
        return status;
    }
    memory->bytes += made.bytes;
    *texture = made;
    return AL_OK;
}

void al_gl_texture_free(al_gl_memory *memory, al_gl_texture *texture)
{
    if (texture->id) glDeleteTextures(1, &texture->id);
    memory->bytes -= texture->bytes;
    *texture = (al_gl_texture){0};
}

al_status al_gl_texture_fit_mips(al_gl_memory *memory, GLenum target, GLenum format, uint32_t width,
                                 uint32_t height, uint32_t depth, uint32_t levels, al_gl_texture *texture,
                                 al_error *error)
{
    if (texture->id && texture->target == target && texture->format == format && texture->width == width &&
        texture->height == height && texture->depth == depth && texture->levels == levels) {
        texture->frame = memory->frame;
        return AL_OK;
    }
    al_gl_texture_free(memory, texture);
    return al_gl_texture_create(memory, target, format, width, height, depth, levels, texture, error);
}

al_status al_gl_texture_fit(al_gl_memory *memory, GLenum target, GLenum format, uint32_t width,
                            uint32_t height, uint32_t depth, al_gl_texture *texture, al_error *error)
{
    return al_gl_texture_fit_mips(memory, target, format, width, height, depth, 1, texture, error);
}

void al_gl_texture_sweep(al_gl_memory *memory, al_gl_texture *texture)
{
    if (texture->frame != memory->frame) al_gl_texture_free(memory, texture);
}

void al_gl_framebuffer_sweep(GLuint *framebuffer, const al_gl_texture *first)
{
    if (!*framebuffer || first->id) return;
    glDeleteFramebuffers(1, framebuffer);
    *framebuffer = 0;
}

void al_gl_reset_state(void)
{
    static const GLenum off[] = {GL_BLEND,
                                 GL_CULL_FACE,
                                 GL_STENCIL_TEST,
                                 GL_DEPTH_TEST,
                                 GL_DEPTH_CLAMP,
                                 GL_COLOR_LOGIC_OP,
                                 GL_RASTERIZER_DISCARD,
                                 GL_POLYGON_OFFSET_FILL,
                                 GL_FRAMEBUFFER_SRGB,
                                 GL_PRIMITIVE_RESTART,
                                 GL_PRIMITIVE_RESTART_FIXED_INDEX,
                                 GL_SAMPLE_MASK,
                                 GL_SAMPLE_ALPHA_TO_COVERAGE,
                                 GL_CLIP_DISTANCE0,
                                 GL_SCISSOR_TEST};
    for (unsigned i = 0; i < sizeof off / sizeof off[0]; i++) glDisable(off[i]);
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthMask(GL_TRUE);
    glDepthFunc(GL_LESS);
    glDepthRange(0, 1);
    glFrontFace(GL_CCW);
    glCullFace(GL_BACK);
    glBlendEquation(GL_FUNC_ADD);
    glBlendFunc(GL_ONE, GL_ZERO);
    glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, 0);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
    glPixelStorei(GL_UNPACK_IMAGE_HEIGHT, 0);
    glPixelStorei(GL_UNPACK_SKIP_PIXELS, 0);
    glPixelStorei(GL_UNPACK_SKIP_ROWS, 0);
    glPixelStorei(GL_UNPACK_SKIP_IMAGES, 0);
    glPixelStorei(GL_UNPACK_SWAP_BYTES, GL_FALSE);
    glPatchParameteri(GL_PATCH_VERTICES, 3);
}

void al_gl_bind_texture(uint32_t unit, GLuint id)
{
    glBindTextureUnit(unit, id);
    glBindSampler(unit, 0);
}
