/* One object over what lies behind it, and the finished tile into the host's framebuffer. */
#include <float.h>

#include "state.h"

al_status al_object_join(al_draw *draw)
{
    al_runtime *runtime = draw->runtime;
    al_targets *targets = &runtime->targets;
    GLuint program;
    al_status status = al_shaders_get(runtime->shaders, "fullscreen.vert object.frag", al_fog_define(draw),
                                      &program, draw->error);
    if (status) return status;
    al_timing_begin(&runtime->timing, AL_STAGE_COMPOSITE);
    glBindFramebuffer(GL_FRAMEBUFFER, targets->radiance_framebuffer);
    glViewport(0, 0, draw->tile[2], draw->tile[3]);
    glUseProgram(program);
    al_gl_bind_texture(AL_UNIT_PASS, targets->ends.id);
    al_gl_bind_texture(AL_UNIT_PASS + 1, targets->knots.id);
    al_gl_bind_texture(AL_UNIT_PASS + 2, targets->boundary.id);
    al_gl_bind_texture(AL_UNIT_PASS + 3, targets->geometry.id);
    al_gl_bind_texture(AL_UNIT_PASS + 4, targets->light.id);
    al_gl_bind_texture(AL_UNIT_PASS + 5, targets->reflection.id);
    if (runtime->fogs.drawn) {
        glBindImageTexture(2, targets->fog_light.id, 0, GL_FALSE, 0, GL_READ_ONLY, GL_RGBA32F);
        glBindImageTexture(3, targets->fog_kept.id, 0, GL_FALSE, 0, GL_READ_ONLY, GL_RGBA16F);
        glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    }
    glUniform1i(0, (GLint)draw->settings.pass);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_SRC1_COLOR);
    glBindVertexArray(runtime->empty_vertex_array);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    if (runtime->fogs.drawn) al_gl_bind_texture(AL_UNIT_FOG, runtime->fogs.bricks.id); /* as it was */
    glDisable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ZERO); /* a second source forbids two colour targets, blending or not */
    al_timing_end(&runtime->timing);
    return AL_OK;
}

al_status al_inspect_draw(al_draw *draw)
{
    al_runtime *runtime = draw->runtime;
    GLuint program;
    al_status status =
        al_shaders_get(runtime->shaders, "fullscreen.vert inspect.frag", "", &program, draw->error);
    if (status) return status;
    glBindFramebuffer(GL_FRAMEBUFFER, runtime->targets.radiance_framebuffer);
    glViewport(0, 0, draw->tile[2], draw->tile[3]);
    glUseProgram(program);
    al_gl_bind_texture(AL_UNIT_PASS, runtime->targets.geometry.id);
    glUniform1i(0, draw->settings.pass == AL_PASS_NORMAL ? 0 : 1);
    glBindVertexArray(runtime->empty_vertex_array);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    return AL_OK;
}

/* Which texture array the pass looks at. */
static GLuint shown_array(const al_runtime *runtime, al_pass pass)
{
    switch (pass) {
    case AL_PASS_SHELLS: return runtime->shells.levels.id;
    case AL_PASS_UNSHUFFLED:
    case AL_PASS_BLURRED: return runtime->shells.light.id;
    case AL_PASS_SHADOW_MAP: return runtime->shadow.depth.id;
    default: return 0;
    }
}

al_status al_shells_inspect(al_draw *draw)
{
    al_runtime *runtime = draw->runtime;
    al_pass pass = draw->settings.pass;
    GLuint program, array = shown_array(runtime, pass);
    al_status status =
        al_shaders_get(runtime->shaders, "fullscreen.vert inspect_shells.frag", "", &program, draw->error);
    if (status) return status;
    if (pass == AL_PASS_SHADOW_MAP && !array) return AL_OK; /* nothing casts one */
    glBindFramebuffer(GL_FRAMEBUFFER, runtime->targets.radiance_framebuffer);
    glViewport(0, 0, draw->tile[2], draw->tile[3]);
    glUseProgram(program);
    al_gl_bind_texture(AL_UNIT_PASS, runtime->shells.steps.id);
    al_gl_bind_texture(AL_UNIT_PASS + 1, runtime->shells.ends.id);
    al_gl_bind_texture(AL_UNIT_PASS + 3, array);
    if (pass == AL_PASS_SHADOW_MAP) glTextureParameteri(array, GL_TEXTURE_COMPARE_MODE, GL_NONE);
    glUniform2i(0, (GLint)(pass - AL_PASS_INTERVAL_MAP), (GLint)draw->settings.shown_level);
    glUniform2f(1, (float)draw->tile[2], (float)draw->tile[3]);
    glBindVertexArray(runtime->empty_vertex_array);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    if (pass == AL_PASS_SHADOW_MAP) glTextureParameteri(array, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    return AL_OK;
}

/* Largest finite number of the framebuffer's colour 0. */
static float framebuffer_limit(GLuint framebuffer)
{
    GLint bits = 32;
    GLenum attachment = framebuffer ? GL_COLOR_ATTACHMENT0 : GL_BACK_LEFT;
    glGetNamedFramebufferAttachmentParameteriv(framebuffer, attachment, GL_FRAMEBUFFER_ATTACHMENT_RED_SIZE,
                                               &bits);
    return bits == 16 ? 65504.0f : FLT_MAX;
}

al_status al_output_draw(al_draw *draw)
{
    al_runtime *runtime = draw->runtime;
    GLuint program;
    al_status status =
        al_shaders_get(runtime->shaders, "fullscreen.vert output.frag", "", &program, draw->error);
    if (status) return status;
    al_timing_begin(&runtime->timing, AL_STAGE_COMPOSITE);
    glBindFramebuffer(GL_FRAMEBUFFER, draw->framebuffer);
    glViewport(draw->tile[0], draw->tile[1], draw->tile[2], draw->tile[3]);
    glEnable(GL_SCISSOR_TEST);
    glScissor(draw->kept[0], draw->kept[1], draw->kept[2], draw->kept[3]);
    glUseProgram(program);
    al_gl_bind_texture(AL_UNIT_PASS, runtime->targets.radiance.id);
    glUniform2i(0, draw->tile[0], draw->tile[1]);
    glUniform1f(1, framebuffer_limit(draw->framebuffer));
    glBindVertexArray(runtime->empty_vertex_array);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glDisable(GL_SCISSOR_TEST);
    al_timing_end(&runtime->timing);
    return AL_OK;
}
