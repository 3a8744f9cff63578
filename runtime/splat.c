/* The balls of one object's samples, added up. */
#include <stdio.h>

#include "state.h"

al_status al_splat_draw(al_draw *draw, al_object *object)
{
    static const float nothing[4] = {0};
    al_runtime *runtime = draw->runtime;
    al_targets *targets = &runtime->targets;
    char defines[96];
    GLuint program;
    snprintf(defines, sizeof defines, "%s%s", object->chromatic ? "#define AL_CHROMATIC\n" : "",
             draw->settings.pass == AL_PASS_UNITY        ? "#define AL_UNITY\n"
             : draw->settings.view_leg == AL_VIEW_LEG_SH ? "#define AL_VIEW_SH\n"
                                                         : "");
    al_status status =
        al_shaders_get(runtime->shaders, "splat.vert splat.frag", defines, &program, draw->error);
    if (status) return status;
    al_timing_begin(&runtime->timing, AL_STAGE_SPLAT);
    glBindFramebuffer(GL_FRAMEBUFFER, targets->light_framebuffer);
    glClearNamedFramebufferfv(targets->light_framebuffer, GL_COLOR, 0, nothing);
    glViewport(-draw->tile[0], -draw->tile[1], (GLsizei)draw->view->width, (GLsizei)draw->view->height);
    glUseProgram(program);
    al_gl_bind_texture(AL_UNIT_PASS, targets->ends.id);
    al_gl_bind_texture(AL_UNIT_PASS + 1, targets->knots.id);
    al_gl_bind_texture(AL_UNIT_PASS + 2, targets->boundary.id);
    al_gl_bind_texture(AL_UNIT_PASS + 3, targets->geometry.id);
    al_gl_bind_texture(AL_UNIT_PASS + 4, targets->back.id);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, object->positions.id);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, object->gaussians.id);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, object->lit.id);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE);
    glBindVertexArray(runtime->empty_vertex_array);
    if (object->drawn) glDrawArrays(GL_TRIANGLES, 0, (GLsizei)(6 * object->drawn));
    glDisable(GL_BLEND);
    al_timing_end(&runtime->timing);
    return AL_OK;
}
