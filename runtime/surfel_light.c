/* The light that surfels send, and the cloud as a picture. */
#include "state.h"

enum { GROUP = 128 };

/* One thread for each surfel there is room for, so that nobody waits to know how many there are; the buffer
 * is little larger than the cloud. */
al_status al_surfels_light(al_draw *draw)
{
    al_runtime *runtime = draw->runtime;
    GLuint program;
    al_status status =
        al_shaders_get(runtime->shaders, "surfel_light.comp", al_fog_define(draw), &program, draw->error);
    if (status) return status;
    al_timing_begin(&runtime->timing, AL_STAGE_SURFEL_LIGHT);
    glUseProgram(program);
    glUniform1i(0, !draw->settings.shadows_off);
    glDispatchCompute((GLuint)((runtime->surfels.cloud.size / AL_SURFEL_SIZE + GROUP - 1) / GROUP), 1, 1);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_TRANSFORM_FEEDBACK_BARRIER_BIT);
    al_timing_end(&runtime->timing);
    return AL_OK;
}

al_status al_surfels_show(al_draw *draw)
{
    static const float black[4] = {0, 0, 0, 1}, far[1] = {1};
    al_runtime *runtime = draw->runtime;
    GLuint program, framebuffer = runtime->targets.scene_framebuffer;
    al_status status = al_shaders_get(runtime->shaders, "surfel_disc.vert surfel_disc.geom surfel_disc.frag",
                                      "", &program, draw->error);
    if (status) return status;
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glDisable(GL_SCISSOR_TEST);
    glClearNamedFramebufferfv(framebuffer, GL_COLOR, 0, black);
    glClearNamedFramebufferfv(framebuffer, GL_DEPTH, 0, far);
    if (!draw->needs_surfels) return AL_OK;
    glViewport(-draw->tile[0], -draw->tile[1], (GLsizei)draw->view->width, (GLsizei)draw->view->height);
    glEnable(GL_DEPTH_TEST);
    glUseProgram(program);
    glBindVertexArray(runtime->empty_vertex_array);
    al_surfels_draw_points(draw);
    glDisable(GL_DEPTH_TEST);
    return AL_OK;
}
