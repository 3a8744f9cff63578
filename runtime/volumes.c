/* Ambient occlusion volumes (McGuire 2010): a prism around every triangle of the opaque instances, drawn where it may hide
 * something from the seen surfaces. With the bounced z-buffer every pixel keeps the nearest triangle on its ray; without,
 * the shares of the hemisphere that triangles hide are added up. */
#include <math.h>

#include "state.h"

/* Diagonal of the box around everything: no two surfaces are farther apart. A little more, for rounding. */
static float reach_m(const al_draw *draw, al_bounce_effect effect)
{
    float low[3], high[3], squared = 0, radius = effect == AL_BOUNCE_OCCLUSION ? draw->settings.occlusion_radius_m : 0;
    if (!al_runtime_bounds(draw->runtime, low, high)) return 0;
    for (int k = 0; k < 3; k++) squared += (high[k] - low[k]) * (high[k] - low[k]);
    return 1.001f * (radius > 0 ? fminf(radius, sqrtf(squared)) : sqrtf(squared));
}

/* `first`: number of the mesh's first triangle. */
static void draw_parts(const al_runtime *runtime, const al_mesh *mesh, bool senders, GLint first)
{
    for (uint32_t i = 0; i < mesh->submesh_count; i++) {
        const al_submesh *part = &mesh->submeshes[i];
        if (senders) al_material_bind(runtime, part);
        al_gl_bind_texture(AL_UNIT_PASS + 3, runtime->bounce.span.id);
        glUniform1i(7, first + (GLint)part->first_index / 3);
        glDrawElements(GL_TRIANGLES, (GLsizei)part->index_count, GL_UNSIGNED_INT,
                       (const void *)((uintptr_t)part->first_index * sizeof(uint32_t)));
    }
}

/* Volumes of all opaque instances into the framebuffer and state that are set. `senders`: with materials. */
static void draw_volumes(const al_draw *draw, al_bounce_effect effect, bool senders)
{
    const al_runtime *runtime = draw->runtime;
    GLint first = 0;
    glViewport(-draw->tile[0], -draw->tile[1], (GLsizei)draw->view->width, (GLsizei)draw->view->height);
    al_gl_bind_texture(AL_UNIT_LIGHTMAP, runtime->targets.geometry.id);
    glUniform1f(6, reach_m(draw, effect));
    glEnable(GL_CULL_FACE);
    glCullFace(GL_FRONT);
    for (uint32_t i = 0; i < runtime->scene.instance_count; i++) {
        const al_instance *instance = &runtime->scene.instances[i];
        const al_mesh *mesh = &runtime->scene.meshes[instance->mesh];
        GLuint vertex_array = runtime->model.meshes[instance->mesh].vertex_array;
        if (instance->role != AL_ROLE_OPAQUE || !vertex_array) continue;
        glUniformMatrix4fv(0, 1, GL_FALSE, instance->world);
        if (senders) glUniform1f(8, al_instance_mirrors(instance) ? -1 : 1);
        glBindVertexArray(vertex_array);
        draw_parts(runtime, mesh, senders, first);
        first += (GLint)mesh->index_count / 3;
    }
    glCullFace(GL_BACK);
    glDisable(GL_CULL_FACE);
}

/* What hits are made of beside the hits; layered as they are, as a framebuffer's textures must be alike. */
static al_status fit_senders(al_draw *draw, const al_shell_block *block)
{
    static const GLenum buffers[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1, GL_COLOR_ATTACHMENT2};
    al_bounce *bounce = &draw->runtime->bounce;
    al_gl_memory *memory = &draw->runtime->memory;
    uint32_t width = (uint32_t)block->size[0], height = (uint32_t)block->size[1];
    al_status status = al_gl_texture_fit(memory, GL_TEXTURE_2D_ARRAY, GL_RGBA32UI, width, height, 1, &bounce->senders, draw->error);
    if (!status)
        status = al_gl_texture_fit(memory, GL_TEXTURE_2D_ARRAY, GL_RGBA32F, width, height, 1, &bounce->glows, draw->error);
    if (status) return status;
    glNamedFramebufferTexture(bounce->framebuffer, GL_COLOR_ATTACHMENT1, bounce->senders.id, 0);
    glNamedFramebufferTexture(bounce->framebuffer, GL_COLOR_ATTACHMENT2, bounce->glows.id, 0);
    glNamedFramebufferDrawBuffers(bounce->framebuffer, 3, buffers);
    return AL_OK;
}

al_status al_volumes_trace(al_draw *draw, al_bounce_effect effect, al_stage stage, const al_shell_block *block)
{
    al_runtime *runtime = draw->runtime;
    bool senders = effect == AL_BOUNCE_INDIRECT;
    GLuint program;
    al_status status = al_shaders_get(runtime->shaders, "volume.vert volume.geom volume_trace.frag",
                                      senders ? "#define AL_SENDERS\n" : "", &program, draw->error);
    if (!status && senders) status = fit_senders(draw, block);
    if (status) return status;
    al_timing_begin(&runtime->timing, stage);
    al_bounce_clear(draw, block);
    glUseProgram(program);
    glBindImageTexture(0, runtime->bounce.rays.id, 0, GL_FALSE, 0, GL_READ_ONLY, GL_RGBA32F);
    glEnable(GL_DEPTH_TEST);
    draw_volumes(draw, effect, senders);
    glDisable(GL_DEPTH_TEST);
    al_timing_end(&runtime->timing);
    return AL_OK;
}

al_status al_volumes_sum(al_draw *draw, al_stage stage)
{
    al_runtime *runtime = draw->runtime;
    GLuint program, framebuffer;
    al_status status = al_shaders_get(runtime->shaders, "volume.vert volume.geom volume_sum.frag", "", &program, draw->error);
    if (status) return status;
    al_timing_begin(&runtime->timing, stage);
    framebuffer = al_bounce_begin_sum(draw);
    glUseProgram(program);
    draw_volumes(draw, AL_BOUNCE_OCCLUSION, false);
    al_bounce_end_sum(framebuffer);
    al_timing_end(&runtime->timing);
    return AL_OK;
}
