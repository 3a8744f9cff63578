/* Light of the bounced z-buffer on surfaces, averaged over frames: that of the frame before is taken from where it saw the
 * same places, and weighs as much as its frames and what has changed since let it (shaders/reproject.comp, history.comp).
 * Kept for the whole view, also where that is drawn in tiles. */
#include <string.h>

#include "state.h"

/* What is blended is not drawn at random. */
static bool takes_part(const al_draw *draw, int effect)
{
    return draw->effects[effect] && !al_bounce_sums(draw, (al_bounce_effect)effect);
}

static bool is_wanted(const al_draw *draw)
{
    al_pass pass = draw->settings.pass;
    bool shows = pass == AL_PASS_COMPOSITE || pass == AL_PASS_AMBIENT_OCCLUSION || pass == AL_PASS_INDIRECT;
    return draw->settings.temporal && shows && (takes_part(draw, AL_BOUNCE_OCCLUSION) || takes_part(draw, AL_BOUNCE_INDIRECT));
}

static al_status fit(const al_draw *draw, GLenum format, al_gl_texture textures[2])
{
    al_status status = AL_OK;
    for (int i = 0; i < 2 && !status; i++)
        status = al_gl_texture_fit(&draw->runtime->memory, GL_TEXTURE_2D, format, draw->view->width, draw->view->height, 1,
                                   &textures[i], draw->error);
    return status;
}

static void free_pair(al_runtime *runtime, al_gl_texture textures[2])
{
    for (int i = 0; i < 2; i++) al_gl_texture_free(&runtime->memory, &textures[i]);
}

void al_history_free(al_runtime *runtime)
{
    al_history *history = &runtime->history;
    for (int i = 0; i < AL_BOUNCE_EFFECTS; i++) free_pair(runtime, history->light[i]);
    free_pair(runtime, history->places);
    al_gl_buffer_free(&runtime->memory, &history->constants);
    memset(history, 0, sizeof *history);
}

al_status al_history_begin(al_draw *draw)
{
    al_runtime *runtime = draw->runtime;
    al_history *history = &runtime->history;
    al_status status = AL_OK;
    if (!is_wanted(draw) || history->places[0].width != draw->view->width || history->places[0].height != draw->view->height)
        al_history_free(runtime);
    if (!is_wanted(draw)) return AL_OK;
    if (!history->constants.id)
        status = al_gl_buffer_create(&runtime->memory, sizeof history->block, NULL, &history->constants, draw->error);
    if (!status) status = fit(draw, GL_RG32UI, history->places);
    for (int i = 0; i < AL_BOUNCE_EFFECTS && !status; i++) {
        if (takes_part(draw, i))
            status = fit(draw, GL_RGBA32F, history->light[i]);
        else
            free_pair(runtime, history->light[i]);
    }
    history->runs = !status;
    history->now ^= 1;
    return status;
}

static al_status run(al_draw *draw, al_stage stage, const char *shader, const char *defines)
{
    al_runtime *runtime = draw->runtime;
    GLuint program;
    al_status status = al_shaders_get(runtime->shaders, shader, defines, &program, draw->error);
    if (status) return status;
    al_timing_begin(&runtime->timing, stage);
    glUseProgram(program);
    glDispatchCompute(((GLuint)draw->tile[2] + 7) / 8, ((GLuint)draw->tile[3] + 7) / 8, 1);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    al_timing_end(&runtime->timing);
    return AL_OK;
}

al_status al_history_run(al_draw *draw, al_bounce_effect effect)
{
    al_runtime *runtime = draw->runtime;
    al_history *history = &runtime->history;
    al_bounce *bounce = &runtime->bounce;
    const al_gl_texture *light = history->light[effect];
    uint32_t now = history->now, before = now ^ 1;
    al_stage stage = effect == AL_BOUNCE_INDIRECT ? AL_STAGE_INDIRECT_HISTORY : AL_STAGE_OCCLUSION_HISTORY;
    const char *defines = effect == AL_BOUNCE_INDIRECT ? "#define AL_INDIRECT\n" : "";
    if (!history->runs) return AL_OK;
    bool exists = runtime->frame_number && history->next_frame[effect] == runtime->frame_number;
    const int32_t kept[4] = {draw->kept[0] - draw->tile[0], draw->kept[1] - draw->tile[1], draw->kept[2], draw->kept[3]};
    const int32_t rule[4] = {exists, (int32_t)draw->settings.temporal, draw->settings.temporal_undoubted, 0};
    memcpy(history->block.kept, kept, sizeof kept);
    memcpy(history->block.rule, rule, sizeof rule);
    glNamedBufferSubData(history->constants.id, 0, sizeof history->block, &history->block);
    glBindBufferBase(GL_UNIFORM_BUFFER, 6, history->constants.id);
    al_gl_bind_texture(AL_UNIT_PASS, light[before].id);
    al_gl_bind_texture(AL_UNIT_PASS + 1, runtime->targets.geometry.id);
    al_gl_bind_texture(AL_UNIT_PASS + 2, runtime->targets.material.id);
    al_gl_bind_texture(AL_UNIT_PASS + 3, history->places[before].id);
    glBindImageTexture(0, bounce->rays.id, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    glBindImageTexture(1, bounce->arriving.id, 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
    glBindImageTexture(2, bounce->light.id, 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
    glBindImageTexture(3, history->places[now].id, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RG32UI);
    al_status status = run(draw, stage, "reproject.comp", defines);
    glBindImageTexture(3, light[now].id, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    if (!status) status = run(draw, stage, "history.comp", defines);
    const al_gl_texture result = bounce->rays; /* no longer needed: it and the light change places */
    bounce->rays = bounce->light;
    bounce->light = result;
    return status;
}

void al_history_end(al_draw *draw)
{
    al_history *history = &draw->runtime->history;
    if (!history->runs) return;
    for (int i = 0; i < AL_BOUNCE_EFFECTS; i++)
        history->next_frame[i] = takes_part(draw, i) ? draw->runtime->frame_number + 1 : 0;
    memcpy(history->block.view_projection, draw->block.view_projection, sizeof history->block.view_projection);
    memcpy(history->block.ray, draw->block.ray, sizeof history->block.ray);
}

uint64_t al_history_bytes(const al_runtime *runtime)
{
    const al_history *history = &runtime->history;
    uint64_t bytes = history->constants.size;
    for (int i = 0; i < 2; i++) {
        bytes += history->places[i].bytes;
        for (int k = 0; k < AL_BOUNCE_EFFECTS; k++) bytes += history->light[k][i].bytes;
    }
    return bytes;
}
