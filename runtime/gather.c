/* The levels back in the view's order, blurred, and their sum over what the tile holds. */
#include "state.h"

al_status al_shells_fit_light(al_draw *draw, uint32_t layers)
{
    al_shells *shells = &draw->runtime->shells;
    const al_shell_block *block = &shells->block;
    uint32_t mips = block->blur[0] > 0 ? layers + (uint32_t)block->blur[0] : 1;
    return al_gl_texture_fit_mips(&draw->runtime->memory, GL_TEXTURE_2D_ARRAY, GL_RGBA32F, (uint32_t)block->size[0],
                                  (uint32_t)block->size[1], layers, mips, &shells->light, draw->error);
}

static void dispatch(const al_shell_block *block, uint32_t mip, uint32_t layers)
{
    GLuint width = (GLuint)block->size[0] >> mip, height = (GLuint)block->size[1] >> mip;
    glDispatchCompute((width + 7) / 8, (height + 7) / 8, layers);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

static al_status unshuffle(al_draw *draw)
{
    al_runtime *runtime = draw->runtime;
    al_shells *shells = &runtime->shells;
    const al_shell_block *block = &shells->block;
    GLuint program;
    al_status status = al_shells_fit_light(draw, (uint32_t)block->counts[0]);
    if (!status) status = al_shaders_get(runtime->shaders, "unshuffle.comp", "", &program, draw->error);
    if (status) return status;
    al_timing_begin(&runtime->timing, AL_STAGE_UNSHUFFLE);
    glUseProgram(program);
    al_gl_bind_texture(AL_UNIT_PASS + 1, shells->ends.id);
    al_gl_bind_texture(AL_UNIT_PASS + 3, shells->levels.id);
    glBindImageTexture(0, shells->light.id, 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    dispatch(block, 0, 1);
    al_timing_end(&runtime->timing);
    return AL_OK;
}

static al_status blur(al_draw *draw)
{
    al_runtime *runtime = draw->runtime;
    al_shells *shells = &runtime->shells;
    const al_shell_block *block = &shells->block;
    GLuint program;
    al_status status = al_shaders_get(runtime->shaders, "blur.comp", "", &program, draw->error);
    if (status) return status;
    al_timing_begin(&runtime->timing, AL_STAGE_BLUR);
    glUseProgram(program);
    al_gl_bind_texture(AL_UNIT_PASS + 3, shells->light.id);
    for (uint32_t mip = 1; mip < shells->light.levels; mip++) {
        int32_t first = (int32_t)mip - block->blur[0]; /* the level that reads this mip */
        if (first < 0) first = 0;
        glUniform1i(0, (GLint)mip - 1);
        glUniform1i(1, first);
        glBindImageTexture(0, shells->light.id, (GLint)mip, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA32F);
        dispatch(block, mip, shells->light.depth - (uint32_t)first);
    }
    al_timing_end(&runtime->timing);
    return AL_OK;
}

static al_status sum(al_draw *draw, const char *defines, GLuint framebuffer)
{
    al_runtime *runtime = draw->runtime;
    GLuint program;
    al_status status =
        al_shaders_get(runtime->shaders, "fullscreen.vert gather.frag", defines, &program, draw->error);
    if (status) return status;
    al_timing_begin(&runtime->timing, AL_STAGE_GATHER);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glViewport(0, 0, draw->tile[2], draw->tile[3]);
    glUseProgram(program);
    al_gl_bind_texture(AL_UNIT_PASS, runtime->shells.steps.id);
    al_gl_bind_texture(AL_UNIT_PASS + 1, runtime->shells.ends.id);
    al_gl_bind_texture(AL_UNIT_PASS + 3, runtime->shells.light.id);
    al_gl_bind_texture(AL_UNIT_PASS + 4, runtime->targets.boundary.id);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE);
    glBindVertexArray(runtime->empty_vertex_array);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glDisable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ZERO);
    al_timing_end(&runtime->timing);
    return AL_OK;
}

al_status al_shells_gather(al_draw *draw)
{
    const al_shell_block *block = &draw->runtime->shells.block;
    al_status status = draw->settings.visibility ? AL_OK : unshuffle(draw);
    if (!status && block->blur[0] > 0) status = blur(draw);
    return status ? status : sum(draw, "", draw->runtime->targets.radiance_framebuffer);
}

al_status al_shells_gather_front(al_draw *draw)
{
    static const float nothing[4] = {0};
    if (draw->settings.pass == AL_PASS_SURFACE_SCATTERING) /* else it holds the fog's own light */
        glClearNamedFramebufferfv(draw->runtime->targets.fog_framebuffer, GL_COLOR, 0, nothing);
    return sum(draw, "#define AL_FRONT\n", draw->runtime->targets.fog_framebuffer);
}
