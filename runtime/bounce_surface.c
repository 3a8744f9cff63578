/* The bounced z-buffer from seen surfaces: ambient occlusion. Rays begin on the surface target's places. */
#include "state.h"

/* Levels padded so that every block is whole; the outermost shell is open. */
static al_shell_block shell_block(const al_draw *draw)
{
    int32_t levels = (int32_t)draw->settings.shell_levels, edge = 1 << (levels - 1);
    al_shell_block block = {.counts = {levels, 1, (int32_t)draw->runtime->frame_number, 0}, .reach = {0, 0, 0, 1}};
    for (int k = 0; k < 2; k++) {
        block.size[k] = (draw->tile[2 + k] + edge - 1) / edge * edge;
        block.size[2 + k] = draw->tile[2 + k];
    }
    return block;
}

/* Discs of the walls' own area cover it as points at random would: a share exp(-overlap) of the rays passes. */
static al_bounce_block bounce_block(const al_draw *draw)
{
    const al_settings *settings = &draw->settings;
    float extent = draw->needs_surfels ? al_bounce_extent(draw->runtime) : 1;
    return (al_bounce_block){
        .reach = {settings->bounce_radius_m > 0 ? settings->bounce_radius_m : extent / 4, 1e4f * extent,
                  settings->bounce_overlap > 0 ? settings->bounce_overlap : 3,
                  settings->occlusion_radius_m > 0 ? settings->occlusion_radius_m : 1e15f},
        .sample = {0, (int32_t)settings->bounce_samples, settings->bounce_near_off,
                   settings->bounce_filter_off ? 0 : (int32_t)settings->bounce_filter}};
}

static al_status fit(al_draw *draw, const al_shell_block *block)
{
    al_runtime *runtime = draw->runtime;
    al_bounce *bounce = &runtime->bounce;
    al_gl_texture *const pictures[] = {&bounce->arriving, &bounce->light};
    al_status status = al_bounce_fit(draw, block);
    for (int i = 0; i < 2 && !status; i++)
        status = al_gl_texture_fit(&runtime->memory, GL_TEXTURE_2D, GL_RGBA32F, (uint32_t)draw->tile[2],
                                   (uint32_t)draw->tile[3], 1, pictures[i], draw->error);
    if (!status && !bounce->shells.id)
        status = al_gl_buffer_create(&runtime->memory, sizeof *block, NULL, &bounce->shells, draw->error);
    return status;
}

/* One of the three steps of a sample, each a thread per pixel of the tile. */
static al_status run(al_draw *draw, al_stage stage, const char *shader, const char *defines)
{
    al_runtime *runtime = draw->runtime;
    al_bounce *bounce = &runtime->bounce;
    GLuint program;
    al_status status = al_shaders_get(runtime->shaders, shader, defines, &program, draw->error);
    if (status) return status;
    al_timing_begin(&runtime->timing, stage);
    glUseProgram(program);
    al_gl_bind_texture(AL_UNIT_PASS, bounce->rays.id);
    al_gl_bind_texture(AL_UNIT_PASS + 1, runtime->targets.geometry.id);
    al_gl_bind_texture(AL_UNIT_PASS + 3, bounce->hits.id);
    al_gl_bind_texture(AL_UNIT_PASS + 4, bounce->depths.id);
    glBindImageTexture(0, bounce->rays.id, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    glBindImageTexture(1, bounce->arriving.id, 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
    glBindImageTexture(2, bounce->light.id, 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
    glDispatchCompute(((GLuint)draw->tile[2] + 7) / 8, ((GLuint)draw->tile[3] + 7) / 8, 1);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    al_timing_end(&runtime->timing);
    return AL_OK;
}

static al_status splat(al_draw *draw, const al_shell_block *block)
{
    al_runtime *runtime = draw->runtime;
    al_gl_bind_texture(AL_UNIT_PASS + 1, runtime->targets.geometry.id);
    return al_bounce_splat(draw, block, &runtime->bounce.span, "#define AL_SURFACE\n");
}

static al_status show(al_draw *draw)
{
    al_runtime *runtime = draw->runtime;
    GLuint program;
    al_status status = al_shaders_get(runtime->shaders, "fullscreen.vert bounce_show.frag", "", &program, draw->error);
    if (status) return status;
    glBindFramebuffer(GL_FRAMEBUFFER, runtime->targets.radiance_framebuffer);
    glViewport(0, 0, draw->tile[2], draw->tile[3]);
    glUseProgram(program);
    al_gl_bind_texture(AL_UNIT_PASS, runtime->bounce.light.id);
    glBindVertexArray(runtime->empty_vertex_array);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    return AL_OK;
}

al_status al_bounce_surface(al_draw *draw)
{
    al_runtime *runtime = draw->runtime;
    al_bounce *bounce = &runtime->bounce;
    const al_shell_block shells = shell_block(draw);
    al_bounce_block block = bounce_block(draw);
    const char *choice = draw->settings.occlusion_uniform ? "#define AL_UNIFORM\n" : "";
    al_status status = fit(draw, &shells);
    if (status) return status;
    glNamedBufferSubData(bounce->shells.id, 0, sizeof shells, &shells);
    glBindBufferBase(GL_UNIFORM_BUFFER, 3, bounce->shells.id);
    status = al_span_run(draw, &shells, &bounce->span, "#define AL_SURFACE\n");
    for (; block.sample[0] < block.sample[1] && !status; block.sample[0]++) {
        glNamedBufferSubData(bounce->constants.id, 0, sizeof block, &block);
        glBindBufferBase(GL_UNIFORM_BUFFER, 4, bounce->constants.id);
        status = run(draw, AL_STAGE_BOUNCE_RAYS, "bounce_surface.comp", choice);
        if (!status) status = splat(draw, &shells);
        if (!status) status = run(draw, AL_STAGE_BOUNCE_LIGHT, "bounce_arrive.comp", "");
        if (!status) status = run(draw, AL_STAGE_BOUNCE_LIGHT, "bounce_filter.comp", "");
    }
    return status ? status : show(draw);
}

uint64_t al_bounce_surface_bytes(const al_runtime *runtime)
{
    const al_bounce *bounce = &runtime->bounce;
    return bounce->span.bytes + bounce->arriving.bytes + bounce->light.bytes + bounce->shells.size;
}
