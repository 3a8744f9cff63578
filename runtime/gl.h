/* Buffers, textures and framebuffers with their bytes counted, and the GL state the passes rely on. */
#ifndef AIRLIGHT_RUNTIME_GL_H
#define AIRLIGHT_RUNTIME_GL_H

#include <epoxy/gl.h>
#include <stdbool.h>
#include <stdint.h>

#include "airlight/status.h"

typedef struct al_gl_memory {
    uint64_t bytes; /* held now */
    uint32_t frame; /* number of the one being drawn */
} al_gl_memory;

typedef struct al_gl_buffer {
    GLuint id;
    uint64_t size; /* bytes */
    uint32_t frame; /* the last one that asked for it by al_gl_buffer_fit */
} al_gl_buffer;

typedef struct al_gl_texture {
    GLuint id;
    GLenum target, format;
    uint32_t width, height, depth; /* depth: layers of an array */
    uint32_t levels;
    uint64_t bytes;
    uint32_t frame; /* the last one that asked for it by al_gl_texture_fit */
} al_gl_texture;

/* AL_NO_DEVICE when the context is lost: nothing drawn since is to be trusted, and all of its objects are gone. Contexts
 * tell only when they were made with the reset notification strategy LOSE_CONTEXT_ON_RESET. */
al_status al_gl_check_lost(al_error *error);

/* Zero `size` makes no buffer. AL_IO when GL has no memory left. Contents undefined when data is NULL. */
al_status al_gl_buffer_create(al_gl_memory *memory, uint64_t size, const void *data, al_gl_buffer *buffer,
                              al_error *error);
void al_gl_buffer_free(al_gl_memory *memory, al_gl_buffer *buffer);

/* Makes `buffer` have this size, keeping it when it has. */
al_status al_gl_buffer_fit(al_gl_memory *memory, uint64_t size, al_gl_buffer *buffer, al_error *error);

/* target: GL_TEXTURE_2D, _2D_ARRAY or _3D; nearest filtering, clamped to the edge, one level unless `levels`
 * says more. */
al_status al_gl_texture_create(al_gl_memory *memory, GLenum target, GLenum format, uint32_t width,
                               uint32_t height, uint32_t depth, uint32_t levels, al_gl_texture *texture,
                               al_error *error);
void al_gl_texture_free(al_gl_memory *memory, al_gl_texture *texture);

/* Makes `texture` have this format and size, keeping it when it has. */
al_status al_gl_texture_fit_mips(al_gl_memory *memory, GLenum target, GLenum format, uint32_t width,
                                 uint32_t height, uint32_t depth, uint32_t levels, al_gl_texture *texture,
                                 al_error *error);
al_status al_gl_texture_fit(al_gl_memory *memory, GLenum target, GLenum format, uint32_t width,
                            uint32_t height, uint32_t depth, al_gl_texture *texture, al_error *error);

/* What the frame did not ask for by a _fit goes, and a framebuffer whose `first` texture is gone. */
void al_gl_buffer_sweep(al_gl_memory *memory, al_gl_buffer *buffer);
void al_gl_texture_sweep(al_gl_memory *memory, al_gl_texture *texture);
void al_gl_framebuffer_sweep(GLuint *framebuffer, const al_gl_texture *first);

/* Sets every state that may change what a pass draws and that a host may have left otherwise. */
void al_gl_reset_state(void);

/* Binds texture `id` to `unit` and takes away the host's sampler object. */
void al_gl_bind_texture(uint32_t unit, GLuint id);

#endif
