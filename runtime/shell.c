/* The surfels' shells, splatted into the levels; before it the mips by which splats are left out. */
#include <stdio.h>

#include "state.h"

static uint32_t mip_count(uint32_t width, uint32_t height)
{
    uint32_t count = 1;
    while (width >> count || height >> count) count++;
    return count;
}

al_status al_span_run(al_draw *draw, al_stage stage, const al_shell_block *block, al_gl_texture *span, const char *choice)
{
    al_runtime *runtime = draw->runtime;
    al_shells *shells = &runtime->shells;
    uint32_t width = (uint32_t)block->size[0], height = (uint32_t)block->size[1], mips = mip_count(width, height);
    GLuint programs[2];
    char defines[64];
    al_status status = al_gl_texture_fit_mips(&runtime->memory, GL_TEXTURE_2D, GL_RG32F, width, height, 1, mips,
                                              span, draw->error);
    for (int i = 0; i < 2 && !status; i++) {
        snprintf(defines, sizeof defines, "%s%s", choice, i ? "" : "#define AL_FIRST\n");
        status = al_shaders_get(runtime->shaders, "span.comp", defines, &programs[i], draw->error);
    }
    if (status) return status;
    al_timing_begin(&runtime->timing, stage);
    al_gl_bind_texture(AL_UNIT_PASS, shells->steps.id);
    al_gl_bind_texture(AL_UNIT_PASS + 1, shells->ends.id);
    al_gl_bind_texture(AL_UNIT_PASS + 2, runtime->targets.geometry.id);
    al_gl_bind_texture(AL_UNIT_PASS + 3, span->id);
    for (uint32_t mip = 0; mip < mips; mip++) {
        uint32_t w = width >> mip ? width >> mip : 1, h = height >> mip ? height >> mip : 1;
        glUseProgram(programs[mip > 0]);
        if (mip) glUniform1i(0, (GLint)mip - 1);
        glBindImageTexture(0, span->id, (GLint)mip, GL_FALSE, 0, GL_WRITE_ONLY, GL_RG32F);
        glDispatchCompute((w + 7) / 8, (h + 7) / 8, 1);
        glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    }
    al_timing_end(&runtime->timing);
    return AL_OK;
}

al_status al_shells_draw(al_draw *draw)
{
    static const float nothing[4] = {0};
    al_runtime *runtime = draw->runtime;
    al_shells *shells = &runtime->shells;
    const al_shell_block *block = &shells->block;
    char defines[192], leg[64];
    GLuint program;
    al_legs_define(draw, leg);
    snprintf(defines, sizeof defines, "#define AL_LEVELS %d\n%s%s%s", block->counts[0],
             al_interval_map_define(runtime), leg,
             draw->settings.shells_clamped ? "#define AL_CLAMPED\n" : "");
    al_status status = al_gl_texture_fit(&runtime->memory, GL_TEXTURE_2D_ARRAY, GL_RGBA32F, (uint32_t)block->size[0],
                                         (uint32_t)block->size[1], (uint32_t)block->counts[0], &shells->levels,
                                         draw->error);
    if (!status)
        status = al_shaders_get(runtime->shaders, "shell.vert shell.geom shell.frag", defines, &program, draw->error);
    if (status) return status;
    if (!shells->framebuffer) glCreateFramebuffers(1, &shells->framebuffer);
    glNamedFramebufferTexture(shells->framebuffer, GL_COLOR_ATTACHMENT0, shells->levels.id, 0);
    al_timing_begin(&runtime->timing, AL_STAGE_SHELLS);
    glBindFramebuffer(GL_FRAMEBUFFER, shells->framebuffer);
    glDisable(GL_SCISSOR_TEST);
    glClearNamedFramebufferfv(shells->framebuffer, GL_COLOR, 0, nothing);
    glViewport(0, 0, block->size[0], block->size[1]);
    glUseProgram(program);
    al_gl_bind_texture(AL_UNIT_PASS, shells->steps.id);
    al_gl_bind_texture(AL_UNIT_PASS + 1, shells->ends.id);
    al_gl_bind_texture(AL_UNIT_PASS + 2, shells->weights.id);
    al_gl_bind_texture(AL_UNIT_PASS + 3, shells->span.id);
    al_gl_bind_texture(AL_UNIT_PASS + 4, al_legs_texture(runtime));
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE);
    al_surfels_draw_points(draw);
    glDisable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ZERO);
    al_timing_end(&runtime->timing);
    return AL_OK;
}
