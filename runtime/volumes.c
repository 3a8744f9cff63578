/* Ambient occlusion volumes (McGuire 2010): a prism around every triangle of the opaque instances, drawn where it may hide
 * something from the seen surfaces. With the bounced z-buffer every pixel keeps the nearest triangle on its ray; without,
 * the shares of the hemisphere that triangles hide are added up. */
#include <math.h>

#include "state.h"

/* Diagonal of the box around everything: no two surfaces are farther apart. A little more, for rounding. */
static float reach_m(const al_draw *draw)
{
    float low[3], high[3], squared = 0, radius = draw->settings.occlusion_radius_m;
    if (!al_runtime_bounds(draw->runtime, low, high)) return 0;
    for (int k = 0; k < 3; k++) squared += (high[k] - low[k]) * (high[k] - low[k]);
    return 1.001f * (radius > 0 ? fminf(radius, sqrtf(squared)) : sqrtf(squared));
}

/* Volumes of all opaque instances into the framebuffer and state that are set. */
static void draw_volumes(const al_draw *draw)
{
    const al_runtime *runtime = draw->runtime;
    GLint first = 0;
    glViewport(-draw->tile[0], -draw->tile[1], (GLsizei)draw->view->width, (GLsizei)draw->view->height);
    glUniform1f(1, reach_m(draw));
    glEnable(GL_CULL_FACE);
    glCullFace(GL_FRONT);
    for (uint32_t i = 0; i < runtime->scene.instance_count; i++) {
        const al_instance *instance = &runtime->scene.instances[i];
        GLuint vertex_array = runtime->model.meshes[instance->mesh].vertex_array;
        GLsizei indices = (GLsizei)runtime->scene.meshes[instance->mesh].index_count;
        if (instance->role != AL_ROLE_OPAQUE || !vertex_array) continue;
        glUniformMatrix4fv(0, 1, GL_FALSE, instance->world);
        glUniform1i(2, first);
        glBindVertexArray(vertex_array);
        glDrawElements(GL_TRIANGLES, indices, GL_UNSIGNED_INT, NULL);
        first += indices / 3;
    }
    glCullFace(GL_BACK);
    glDisable(GL_CULL_FACE);
}

al_status al_volumes_trace(al_draw *draw, al_stage stage, const al_shell_block *block)
{
    al_runtime *runtime = draw->runtime;
    GLuint program;
    al_status status = al_shaders_get(runtime->shaders, "volume.vert volume.geom volume_trace.frag", "", &program, draw->error);
    if (status) return status;
    al_timing_begin(&runtime->timing, stage);
    al_bounce_clear(draw, block);
    glUseProgram(program);
    al_gl_bind_texture(AL_UNIT_PASS, runtime->bounce.rays.id);
    al_gl_bind_texture(AL_UNIT_PASS + 1, runtime->targets.geometry.id);
    al_gl_bind_texture(AL_UNIT_PASS + 3, runtime->bounce.span.id);
    glEnable(GL_DEPTH_TEST);
    draw_volumes(draw);
    glDisable(GL_DEPTH_TEST);
    al_timing_end(&runtime->timing);
    return AL_OK;
}

al_status al_volumes_sum(al_draw *draw, al_stage stage)
{
    static const float nothing[4] = {0};
    al_runtime *runtime = draw->runtime;
    al_bounce *bounce = &runtime->bounce;
    GLuint program, framebuffer;
    al_status status = al_shaders_get(runtime->shaders, "volume.vert volume.geom volume_sum.frag", "", &program, draw->error);
    if (status) return status;
    al_timing_begin(&runtime->timing, stage);
    glCreateFramebuffers(1, &framebuffer); /* kept, it would keep its texture once that is replaced */
    glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, bounce->light.id, 0);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glDisable(GL_SCISSOR_TEST);
    glClearNamedFramebufferfv(framebuffer, GL_COLOR, 0, nothing);
    glUseProgram(program);
    al_gl_bind_texture(AL_UNIT_PASS + 1, runtime->targets.geometry.id);
    al_gl_bind_texture(AL_UNIT_PASS + 3, bounce->span.id);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE);
    draw_volumes(draw);
    glDisable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ZERO);
    glDeleteFramebuffers(1, &framebuffer);
    al_timing_end(&runtime->timing);
    return AL_OK;
}
