/* The textures one tile is drawn into; those of translucent objects exist only where the scene has some. */
#include <string.h>

#include "state.h"

static al_status fit(al_draw *draw, GLenum target, GLenum format, uint32_t layers, al_gl_texture *texture)
{
    return al_gl_texture_fit(&draw->runtime->memory, target, format, (uint32_t)draw->tile[2],
                             (uint32_t)draw->tile[3], layers, texture, draw->error);
}

static const GLenum buffers[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1, GL_COLOR_ATTACHMENT2};

static void attach(GLuint *framebuffer, GLuint first, GLuint second, GLuint depth)
{
    if (!*framebuffer) glCreateFramebuffers(1, framebuffer);
    glNamedFramebufferTexture(*framebuffer, GL_COLOR_ATTACHMENT0, first, 0);
    if (second) glNamedFramebufferTexture(*framebuffer, GL_COLOR_ATTACHMENT1, second, 0);
    if (depth) glNamedFramebufferTexture(*framebuffer, GL_DEPTH_ATTACHMENT, depth, 0);
    glNamedFramebufferDrawBuffers(*framebuffer, second ? 2 : 1, buffers);
}

static al_status fit_object_targets(al_draw *draw)
{
    al_targets *t = &draw->runtime->targets;
    bool chromatic =
        false; /* extinction differs between channels: the interval map holds optical depths too */
    for (uint32_t i = 0; i < draw->runtime->scene.translucent_count; i++)
        chromatic = chromatic || draw->runtime->objects[i].chromatic;
    al_status status = fit(draw, GL_TEXTURE_2D, GL_RGBA32F, 1, &t->boundary);
    if (!status) status = fit(draw, GL_TEXTURE_2D, GL_RGBA32F, 1, &t->reflection);
    if (!status) status = fit(draw, GL_TEXTURE_2D, GL_RGBA32F, 1, &t->ends);
    if (!status)
        status = fit(draw, GL_TEXTURE_2D_ARRAY, GL_RGBA32F,
                     (draw->settings.interval_count + 1) / 4 * (chromatic ? 2 : 1), &t->knots);
    if (!status) status = fit(draw, GL_TEXTURE_2D, GL_RGBA32F, 1, &t->light);
    if (status) return status;
    attach(&t->boundary_framebuffer, t->reflection.id, t->boundary.id, t->depth.id);
    attach(&t->light_framebuffer, t->light.id, 0, 0);
    if (draw->settings.view_leg == AL_VIEW_LEG_SH) {
        status = fit(draw, GL_TEXTURE_2D, GL_R32F, 1, &t->back);
        if (status) return status;
        attach(&t->back_framebuffer, t->back.id, 0, 0);
    }
    if (!draw->runtime->fogs.drawn) return AL_OK;
    status = fit(draw, GL_TEXTURE_2D, GL_RGBA32F, 1, &t->fog_light);
    if (!status) status = fit(draw, GL_TEXTURE_2D, GL_RGBA16F, 1, &t->fog_kept);
    if (status) return status;
    attach(&t->fog_framebuffer, t->fog_light.id, t->fog_kept.id, 0);
    return AL_OK;
}

/* What the scene's framebuffer holds, and materials. */
static al_status fit_material(al_draw *draw)
{
    al_targets *t = &draw->runtime->targets;
    al_status status = fit(draw, GL_TEXTURE_2D, GL_RGBA32UI, 1, &t->material);
    if (status) return status;
    attach(&t->material_framebuffer, t->radiance.id, t->geometry.id, t->depth.id);
    glNamedFramebufferTexture(t->material_framebuffer, GL_COLOR_ATTACHMENT2, t->material.id, 0);
    glNamedFramebufferDrawBuffers(t->material_framebuffer, 3, buffers);
    return AL_OK;
}

al_status al_targets_fit(al_draw *draw)
{
    al_targets *t = &draw->runtime->targets;
    al_status status = fit(draw, GL_TEXTURE_2D, GL_RGBA32F, 1, &t->radiance);
    if (!status) status = fit(draw, GL_TEXTURE_2D, GL_RGBA32F, 1, &t->geometry);
    if (!status) status = fit(draw, GL_TEXTURE_2D, GL_DEPTH_COMPONENT32F, 1, &t->depth);
    if (status) return status;
    attach(&t->scene_framebuffer, t->radiance.id, t->geometry.id, t->depth.id);
    attach(&t->radiance_framebuffer, t->radiance.id, 0, 0);
    if (draw->needs_material) {
        status = fit_material(draw);
        if (status) return status;
    }
    if (draw->host_depth) {
        status = fit(draw, GL_TEXTURE_2D, GL_RGBA32F, 1, &t->host);
        if (status) return status;
        attach(&t->host_framebuffer, t->host.id, 0, 0);
    }
    return draw->needs_objects ? fit_object_targets(draw) : AL_OK;
}

void al_targets_sweep(al_runtime *runtime)
{
    al_targets *t = &runtime->targets;
    al_gl_texture *const textures[] = {&t->radiance,   &t->geometry,  &t->depth,    &t->boundary,
                                       &t->reflection, &t->ends,      &t->knots,    &t->light,
                                       &t->host,       &t->fog_light, &t->fog_kept, &t->back,
                                       &t->material};
    const struct {
        GLuint *framebuffer;
        const al_gl_texture *first;
    } framebuffers[] = {{&t->scene_framebuffer, &t->radiance},    {&t->radiance_framebuffer, &t->radiance},
                        {&t->material_framebuffer, &t->material}, {&t->boundary_framebuffer, &t->reflection},
                        {&t->back_framebuffer, &t->back},         {&t->light_framebuffer, &t->light},
                        {&t->host_framebuffer, &t->host},         {&t->fog_framebuffer, &t->fog_light}};
    for (size_t i = 0; i < sizeof textures / sizeof textures[0]; i++)
        al_gl_texture_sweep(&runtime->memory, textures[i]);
    for (size_t i = 0; i < sizeof framebuffers / sizeof framebuffers[0]; i++)
        al_gl_framebuffer_sweep(framebuffers[i].framebuffer, framebuffers[i].first);
}
