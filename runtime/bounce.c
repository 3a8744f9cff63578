/* The bounced z-buffer: rays from the pixels' places, the nearest surfel on each of them by the depth test. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "state.h"

/* Diagonal of the box around all opaque instances, m. */
float al_bounce_extent(const al_runtime *runtime)
{
    float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, squared = 0;
    for (uint32_t i = 0; i < runtime->scene.instance_count; i++) {
        float box[2][3];
        if (runtime->scene.instances[i].role != AL_ROLE_OPAQUE) continue;
        al_model_world_box(runtime, &runtime->scene.instances[i], box[0], box[1]);
        for (int k = 0; k < 3; k++) {
            low[k] = fminf(low[k], box[0][k]);
            high[k] = fmaxf(high[k], box[1][k]);
        }
    }
    for (int k = 0; k < 3; k++) squared += (high[k] - low[k]) * (high[k] - low[k]);
    return sqrtf(squared);
}

al_status al_bounce_fit(al_draw *draw, const al_shell_block *shells)
{
    al_runtime *runtime = draw->runtime;
    al_bounce *bounce = &runtime->bounce;
    al_gl_memory *memory = &runtime->memory;
    uint32_t width = (uint32_t)shells->size[0], height = (uint32_t)shells->size[1];
    al_status status = al_gl_buffer_fit(memory, sizeof(al_bounce_block), &bounce->constants, draw->error);
    if (!status)
        status = al_gl_texture_fit(memory, GL_TEXTURE_2D, GL_RGBA32F, (uint32_t)draw->tile[2], (uint32_t)draw->tile[3],
                                   1, &bounce->rays, draw->error);
    if (!status)
        status = al_gl_texture_fit(memory, GL_TEXTURE_2D_ARRAY, GL_R32UI, width, height, 1, &bounce->hits, draw->error);
    if (!status)
        status = al_gl_texture_fit(memory, GL_TEXTURE_2D_ARRAY, GL_DEPTH_COMPONENT32F, width, height, 1, &bounce->depths,
                                   draw->error);
    if (!status && shells->counts[0] > 1)
        status = al_gl_texture_fit(memory, GL_TEXTURE_2D, GL_RG32UI, (uint32_t)draw->tile[2], (uint32_t)draw->tile[3], 1,
                                   &bounce->nearest, draw->error);
    if (status) return status;
    if (!bounce->framebuffer) glCreateFramebuffers(1, &bounce->framebuffer);
    glNamedFramebufferTexture(bounce->framebuffer, GL_COLOR_ATTACHMENT0, bounce->hits.id, 0);
    glNamedFramebufferTexture(bounce->framebuffer, GL_COLOR_ATTACHMENT1, 0, 0); /* volumes.c may add some */
    glNamedFramebufferTexture(bounce->framebuffer, GL_COLOR_ATTACHMENT2, 0, 0);
    glNamedFramebufferTexture(bounce->framebuffer, GL_DEPTH_ATTACHMENT, bounce->depths.id, 0);
    glNamedFramebufferDrawBuffer(bounce->framebuffer, GL_COLOR_ATTACHMENT0);
    return AL_OK;
}

static void bind_intervals(const al_draw *draw)
{
    const al_shells *shells = &draw->runtime->shells;
    al_gl_bind_texture(AL_UNIT_PASS, shells->steps.id);
    al_gl_bind_texture(AL_UNIT_PASS + 1, shells->ends.id);
    al_gl_bind_texture(AL_UNIT_PASS + 2, shells->weights.id);
}

static void dispatch(const int32_t size[2])
{
    glDispatchCompute(((GLuint)size[0] + 7) / 8, ((GLuint)size[1] + 7) / 8, 1);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

static al_status draw_rays(al_draw *draw)
{
    al_runtime *runtime = draw->runtime;
    GLuint program;
    al_status status = al_shaders_get(runtime->shaders, "bounce_medium.comp", al_interval_map_define(runtime), &program,
                                      draw->error);
    if (status) return status;
    al_timing_begin(&runtime->timing, AL_STAGE_BOUNCE_RAYS);
    glUseProgram(program);
    bind_intervals(draw);
    glBindImageTexture(0, runtime->bounce.rays.id, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    dispatch(draw->tile + 2);
    al_timing_end(&runtime->timing);
    return AL_OK;
}

void al_bounce_clear(const al_draw *draw, const al_shell_block *block)
{
    static const GLuint nothing[4] = {0};
    static const float far[1] = {1};
    GLuint framebuffer = draw->runtime->bounce.framebuffer;
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glDisable(GL_SCISSOR_TEST);
    glClearNamedFramebufferuiv(framebuffer, GL_COLOR, 0, nothing);
    glClearNamedFramebufferfv(framebuffer, GL_DEPTH, 0, far);
    glViewport(0, 0, block->size[0], block->size[1]);
}

void al_bounce_bind_hits(const al_bounce *bounce)
{
    al_gl_bind_texture(AL_UNIT_PASS + 3, bounce->hits.id);
    al_gl_bind_texture(AL_UNIT_PASS + 4, bounce->depths.id);
    glBindImageTexture(3, bounce->nearest.id, 0, GL_FALSE, 0, GL_READ_WRITE, GL_RG32UI);
}

static void draw_level(const al_draw *draw, GLuint program, const al_shell_block *block, const al_gl_texture *span, int32_t level)
{
    al_bounce_clear(draw, block);
    glUseProgram(program);
    glUniform1i(0, level);
    al_gl_bind_texture(AL_UNIT_PASS, draw->runtime->bounce.rays.id);
    al_gl_bind_texture(AL_UNIT_PASS + 3, span->id);
    glEnable(GL_DEPTH_TEST);
    if (draw->needs_surfels) al_surfels_draw_points(draw);
    glDisable(GL_DEPTH_TEST);
}

/* All levels but the last, which has none after it, leave their nearest hits to those that follow. */
al_status al_bounce_splat(al_draw *draw, al_stage stage, const al_shell_block *block, const al_gl_texture *span,
                          const char *choice)
{
    al_runtime *runtime = draw->runtime;
    GLuint splat, keep;
    al_status status = al_shaders_get(runtime->shaders, "shell.vert bounce.geom bounce.frag", choice, &splat, draw->error);
    if (!status) status = al_shaders_get(runtime->shaders, "bounce_keep.comp", "", &keep, draw->error);
    if (status) return status;
    al_timing_begin(&runtime->timing, stage);
    for (int32_t level = 0; level < block->counts[0]; level++) {
        draw_level(draw, splat, block, span, level);
        if (level + 1 == block->counts[0]) break;
        glUseProgram(keep);
        glUniform1i(0, level);
        al_bounce_bind_hits(&runtime->bounce);
        dispatch(draw->tile + 2);
    }
    al_timing_end(&runtime->timing);
    return AL_OK;
}

static al_status add_light(al_draw *draw)
{
    al_runtime *runtime = draw->runtime;
    char defines[64];
    GLuint program;
    snprintf(defines, sizeof defines, "%s%s", al_interval_map_define(runtime),
             draw->settings.second_leg_off ? "" : "#define AL_LEG\n");
    al_status status = al_shaders_get(runtime->shaders, "bounce_light.comp", defines, &program, draw->error);
    if (status) return status;
    al_timing_begin(&runtime->timing, AL_STAGE_BOUNCE_LIGHT);
    glUseProgram(program);
    bind_intervals(draw);
    al_bounce_bind_hits(&runtime->bounce);
    glBindImageTexture(0, runtime->shells.light.id, 0, GL_TRUE, 0, GL_READ_WRITE, GL_RGBA32F);
    glBindImageTexture(1, runtime->bounce.rays.id, 0, GL_FALSE, 0, GL_READ_ONLY, GL_RGBA32F);
    dispatch(runtime->shells.block.size);
    al_timing_end(&runtime->timing);
    return AL_OK;
}

al_status al_bounce_medium(al_draw *draw)
{
    al_runtime *runtime = draw->runtime;
    const al_settings *settings = &draw->settings;
    float extent = al_bounce_extent(runtime);
    al_bounce_block block = {
        .reach = {settings->bounce_radius_m > 0 ? settings->bounce_radius_m : extent / 32, 1e4f * extent,
                  settings->bounce_overlap > 0 ? settings->bounce_overlap : 3, 1e15f},
        .sample = {0, (int32_t)settings->bounce_samples, settings->bounce_near_off}};
    al_status status = al_bounce_fit(draw, &runtime->shells.block);
    if (!status) status = al_shells_fit_light(draw, 1);
    for (; block.sample[0] < block.sample[1] && !status; block.sample[0]++) {
        glNamedBufferSubData(runtime->bounce.constants.id, 0, sizeof block, &block);
        glBindBufferBase(GL_UNIFORM_BUFFER, 4, runtime->bounce.constants.id);
        status = draw_rays(draw);
        if (!status) status = al_bounce_splat(draw, AL_STAGE_BOUNCE, &runtime->shells.block, &runtime->shells.span, "");
        if (!status) status = add_light(draw);
    }
    return status;
}

al_status al_bounce_inspect(al_draw *draw)
{
    al_runtime *runtime = draw->runtime;
    const al_bounce *bounce = &runtime->bounce;
    GLuint program;
    if (!draw->needs_map && !draw->effects[AL_BOUNCE_OCCLUSION] && !draw->effects[AL_BOUNCE_INDIRECT])
        return AL_OK; /* none were sent */
    al_status status =
        al_shaders_get(runtime->shaders, "fullscreen.vert inspect_bounce.frag", "", &program, draw->error);
    if (status) return status;
    glBindFramebuffer(GL_FRAMEBUFFER, runtime->targets.radiance_framebuffer);
    glViewport(0, 0, draw->tile[2], draw->tile[3]);
    glUseProgram(program);
    al_gl_bind_texture(AL_UNIT_PASS, bounce->rays.id);
    al_bounce_bind_hits(bounce);
    glUniform1i(0, draw->settings.pass - AL_PASS_BOUNCE_RAYS);
    glBindVertexArray(runtime->empty_vertex_array);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    return AL_OK;
}

void al_bounce_sweep(al_runtime *runtime)
{
    al_bounce *bounce = &runtime->bounce;
    al_gl_texture *const textures[] = {&bounce->rays,     &bounce->hits,  &bounce->depths,  &bounce->nearest, &bounce->span,
                                       &bounce->arriving, &bounce->light, &bounce->senders, &bounce->glows};
    for (size_t i = 0; i < sizeof textures / sizeof textures[0]; i++)
        al_gl_texture_sweep(&runtime->memory, textures[i]);
    al_gl_buffer_sweep(&runtime->memory, &bounce->constants);
    al_gl_buffer_sweep(&runtime->memory, &bounce->shells);
    al_gl_framebuffer_sweep(&bounce->framebuffer, &bounce->hits);
}

uint64_t al_bounce_bytes(const al_runtime *runtime)
{
    const al_bounce *bounce = &runtime->bounce;
    return bounce->rays.bytes + bounce->hits.bytes + bounce->depths.bytes + bounce->nearest.bytes + bounce->constants.size;
}
