/* The transmittance interval map of one object. */
#include "state.h"

al_status al_intervals_run(al_draw *draw, al_object *object, const int32_t area[4])
{
    al_runtime *runtime = draw->runtime;
    al_targets *targets = &runtime->targets;
    GLuint program;
    al_status status =
        al_shaders_get(runtime->shaders, "intervals.comp", object->chromatic ? "#define AL_CHROMATIC\n" : "",
                       &program, draw->error);
    if (status) return status;
    al_timing_begin(&runtime->timing, AL_STAGE_INTERVALS);
    glUseProgram(program);
    al_gl_bind_texture(AL_UNIT_PASS, object->density.id);
    al_gl_bind_texture(AL_UNIT_PASS + 1, targets->geometry.id);
    al_gl_bind_texture(AL_UNIT_PASS + 2, targets->boundary.id);
    glBindImageTexture(0, targets->knots.id, 0, GL_TRUE, 0, GL_WRITE_ONLY, targets->knots.format);
    glBindImageTexture(1, targets->ends.id, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    glUniform4iv(0, 1, area);
    glDispatchCompute(((GLuint)area[2] + 7) / 8, ((GLuint)area[3] + 7) / 8, 1);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    al_timing_end(&runtime->timing);
    return AL_OK;
}
