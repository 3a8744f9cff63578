/* What passes with very many legs ask for extinction along them: the coarse grid of all gridded media, made anew each
 * frame, as media may move, or the baked optical depths. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "state.h"

enum { EDGE = 32 };

/* The box around the gridded fogs of the frame; false: there are none. */
static bool fill(const al_fog_block *fogs, uint32_t steps, al_legs_block *block)
{
    float high[3] = {-INFINITY, -INFINITY, -INFINITY};
    *block = (al_legs_block){.low = {INFINITY, INFINITY, INFINITY, (float)steps}};
    for (int32_t i = 0; i < fogs->counts[0]; i++) {
        const al_fog_entry *fog = &fogs->fogs[i];
        if (!fog->cells[0]) continue;
        for (int k = 0; k < 3; k++) {
            block->low[k] = fminf(block->low[k], fog->low[k]);
            high[k] = fmaxf(high[k], fog->low[k] + fog->extent[k]);
        }
        block->extent[3] = 1;
    }
    for (int k = 0; k < 3 && block->extent[3] > 0; k++) block->extent[k] = high[k] - block->low[k];
    return block->extent[3] > 0;
}

al_status al_legs_run(al_draw *draw)
{
    al_runtime *runtime = draw->runtime;
    al_legs *legs = &runtime->legs;
    al_legs_block block;
    GLuint program;
    al_status status = al_gl_buffer_fit(&runtime->memory, sizeof block, &legs->constants, draw->error);
    if (status) return status;
    bool gridded = fill(&runtime->fogs.block, draw->settings.second_leg_steps, &block);
    legs->order = 0;
    if (draw->settings.second_leg == AL_SECOND_LEG_BAKED) status = al_fog_depth_run(draw, &block, &legs->order);
    if (status) return status;
    block.stride[0] = runtime->fogs.depth_stride;
    glNamedBufferSubData(legs->constants.id, 0, sizeof block, &block);
    glBindBufferBase(GL_UNIFORM_BUFFER, 5, legs->constants.id);
    if (!gridded || legs->order) return AL_OK;
    status = al_gl_texture_fit(&runtime->memory, GL_TEXTURE_3D, GL_RGBA32F, EDGE, EDGE, EDGE, &legs->extinction,
                               draw->error);
    if (!status) status = al_shaders_get(runtime->shaders, "legs.comp", "", &program, draw->error);
    if (status) return status;
    glTextureParameteri(legs->extinction.id, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(legs->extinction.id, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    al_timing_begin(&runtime->timing, AL_STAGE_LEGS);
    glUseProgram(program);
    glBindImageTexture(0, legs->extinction.id, 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    glDispatchCompute(EDGE / 4, EDGE / 4, EDGE / 4);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    al_timing_end(&runtime->timing);
    return AL_OK;
}

void al_legs_define(const al_draw *draw, char defines[64])
{
    uint32_t order = draw->runtime->legs.order;
    if (draw->settings.second_leg_off)
        *defines = 0;
    else if (order)
        snprintf(defines, 64, "#define AL_LEG\n#define AL_DEPTH_ORDER %u\n", order);
    else
        snprintf(defines, 64, "#define AL_LEG\n");
}

GLuint al_legs_texture(const al_runtime *runtime)
{
    return runtime->legs.order ? runtime->fogs.depth.id : runtime->legs.extinction.id;
}

void al_legs_sweep(al_runtime *runtime)
{
    al_gl_texture_sweep(&runtime->memory, &runtime->legs.extinction);
    al_gl_buffer_sweep(&runtime->memory, &runtime->legs.constants);
    al_gl_texture_sweep(&runtime->memory, &runtime->fogs.depth);
}
