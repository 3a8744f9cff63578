/* The bounced z-buffer from seen surfaces: rays, a carrier that finds what they hit, what arrives from there, and the filter
 * over the pixels around, sample by sample. Ambient occlusion and light of one bounce. */
#include <stdio.h>

#include "state.h"

al_carrier al_bounce_carrier(const al_draw *draw, al_bounce_effect effect)
{
    return effect == AL_BOUNCE_OCCLUSION ? draw->settings.occlusion_carrier : draw->settings.indirect_carrier;
}

bool al_bounce_sums(const al_draw *draw, al_bounce_effect effect)
{
    al_carrier carrier = al_bounce_carrier(draw, effect);
    return carrier == AL_CARRIER_SURFELS_BLENDED || carrier == AL_CARRIER_VOLUMES_BLENDED;
}

/* Levels padded so that every block is whole, as the medium's; the outermost shell is open. Surfels alone need several. */
static al_shell_block shell_block(const al_draw *draw, al_carrier carrier)
{
    int32_t levels = carrier == AL_CARRIER_SURFELS ? (int32_t)draw->settings.shell_levels : 1,
            blur = (int32_t)draw->settings.blur_mips, edge = 1 << (levels - 1 > blur ? levels - 1 : blur);
    al_shell_block block = {.counts = {levels, 1, (int32_t)draw->runtime->frame_number, 0}, .reach = {0, 0, 0, 1}};
    for (int k = 0; k < 2; k++) {
        block.size[k] = (draw->tile[2 + k] + edge - 1) / edge * edge;
        block.size[2 + k] = draw->tile[2 + k];
    }
    return block;
}

/* Discs of the walls' own area cover it as points at random would: a share exp(-overlap) of the rays passes. */
static al_bounce_block bounce_block(const al_draw *draw, al_bounce_effect effect)
{
    const al_settings *settings = &draw->settings;
    float extent = draw->runtime->model.has_opaque ? al_bounce_extent(draw->runtime) : 1;
    bool near = effect == AL_BOUNCE_OCCLUSION && settings->occlusion_radius_m > 0;
    return (al_bounce_block){
        .reach = {settings->bounce_radius_m > 0 ? settings->bounce_radius_m : extent / 4, 1e4f * extent,
                  settings->bounce_overlap > 0 ? settings->bounce_overlap : 3,
                  near ? settings->occlusion_radius_m : 1e15f},
        .sample = {0, (int32_t)settings->bounce_samples, settings->bounce_near_off,
                   settings->bounce_filter_off ? 0 : (int32_t)settings->bounce_filter}};
}

static al_status fit(al_draw *draw, bool rays, const al_shell_block *block)
{
    al_runtime *runtime = draw->runtime;
    al_bounce *bounce = &runtime->bounce;
    al_gl_texture *const pictures[] = {&bounce->arriving, &bounce->light};
    al_status status = rays ? al_bounce_fit(draw, block) : AL_OK;
    for (int i = !rays; i < 2 && !status; i++)
        status = al_gl_texture_fit(&runtime->memory, GL_TEXTURE_2D, GL_RGBA32F, (uint32_t)draw->tile[2],
                                   (uint32_t)draw->tile[3], 1, pictures[i], draw->error);
    if (!status) status = al_gl_buffer_fit(&runtime->memory, sizeof(al_bounce_block), &bounce->constants, draw->error);
    if (!status) status = al_gl_buffer_fit(&runtime->memory, sizeof *block, &bounce->shells, draw->error);
    return status;
}

/* Of shaders that know how the surface receives. */
static const char *receiver_define(const al_draw *draw, al_bounce_effect effect)
{
    if (effect == AL_BOUNCE_INDIRECT) return "#define AL_INDIRECT\n";
    return draw->settings.occlusion_uniform ? "#define AL_UNIFORM\n" : "";
}

static void bind_surfaces(const al_runtime *runtime, GLuint first)
{
    al_gl_bind_texture(AL_UNIT_PASS, first);
    al_gl_bind_texture(AL_UNIT_PASS + 1, runtime->targets.geometry.id);
    al_gl_bind_texture(AL_UNIT_PASS + 2, runtime->targets.material.id);
}

/* One of the steps of a sample, a thread per pixel of the tile, which reads these two textures besides. */
static al_status run(al_draw *draw, al_stage stage, const char *shader, const char *defines, GLuint first, GLuint second)
{
    al_runtime *runtime = draw->runtime;
    al_bounce *bounce = &runtime->bounce;
    GLuint program;
    al_status status = al_shaders_get(runtime->shaders, shader, defines, &program, draw->error);
    if (status) return status;
    al_timing_begin(&runtime->timing, stage);
    glUseProgram(program);
    al_gl_bind_texture(AL_UNIT_PASS, bounce->rays.id);
    al_gl_bind_texture(AL_UNIT_PASS + 1, first);
    al_gl_bind_texture(AL_UNIT_PASS + 2, second);
    al_bounce_bind_hits(bounce);
    glBindImageTexture(0, bounce->rays.id, 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    glBindImageTexture(1, bounce->arriving.id, 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
    glBindImageTexture(2, bounce->light.id, 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
    glDispatchCompute(((GLuint)draw->tile[2] + 7) / 8, ((GLuint)draw->tile[3] + 7) / 8, 1);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    al_timing_end(&runtime->timing);
    return AL_OK;
}

static void draw_fullscreen(const al_runtime *runtime)
{
    glBindVertexArray(runtime->empty_vertex_array);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

static al_status march(al_draw *draw, al_stage stage, const al_shell_block *block)
{
    al_runtime *runtime = draw->runtime;
    const al_settings *settings = &draw->settings;
    float thickness_m = settings->screen_thickness_m;
    GLuint program;
    al_status status = al_shaders_get(runtime->shaders, "fullscreen.vert bounce_march.frag", "", &program, draw->error);
    if (status) return status;
    al_timing_begin(&runtime->timing, stage);
    al_bounce_clear(draw, block);
    glUseProgram(program);
    glUniform2f(0, (float)settings->screen_steps, thickness_m > 0 ? thickness_m : al_bounce_extent(runtime) / 32);
    al_gl_bind_texture(AL_UNIT_PASS, runtime->bounce.rays.id);
    al_gl_bind_texture(AL_UNIT_PASS + 1, runtime->targets.geometry.id);
    glEnable(GL_DEPTH_TEST); /* so that depth is written */
    draw_fullscreen(runtime);
    glDisable(GL_DEPTH_TEST);
    al_timing_end(&runtime->timing);
    return AL_OK;
}

GLuint al_bounce_begin_sum(const al_draw *draw)
{
    static const float nothing[4] = {0, 0, 0, 1};
    GLuint framebuffer;
    glCreateFramebuffers(1, &framebuffer); /* kept, it would keep its texture once that is replaced */
    glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, draw->runtime->bounce.light.id, 0);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glDisable(GL_SCISSOR_TEST);
    glClearNamedFramebufferfv(framebuffer, GL_COLOR, 0, nothing);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE);
    return framebuffer;
}

void al_bounce_end_sum(GLuint framebuffer)
{
    glDeleteFramebuffers(1, &framebuffer);
    glDisable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ZERO);
}

/* What every surfel sends or hides. */
static al_status sum_surfels(al_draw *draw, al_bounce_effect effect, al_stage stage, const al_shell_block *block)
{
    al_runtime *runtime = draw->runtime;
    GLuint program, framebuffer;
    const char *choice = effect == AL_BOUNCE_INDIRECT ? "#define AL_INDIRECT\n" : "";
    al_status status = al_shaders_get(runtime->shaders, "shell.vert bounce.geom bounce_sum.frag", choice, &program, draw->error);
    if (status) return status;
    al_timing_begin(&runtime->timing, stage);
    framebuffer = al_bounce_begin_sum(draw);
    glViewport(0, 0, block->size[0], block->size[1]);
    glUseProgram(program);
    bind_surfaces(runtime, 0);
    al_gl_bind_texture(AL_UNIT_PASS + 3, runtime->bounce.span.id);
    if (draw->needs_surfels) al_surfels_draw_points(draw);
    al_bounce_end_sum(framebuffer);
    al_timing_end(&runtime->timing);
    return AL_OK;
}

static al_status splat(al_draw *draw, al_stage stage, const al_shell_block *block)
{
    al_runtime *runtime = draw->runtime;
    al_gl_bind_texture(AL_UNIT_PASS + 1, runtime->targets.geometry.id);
    return al_bounce_splat(draw, stage, block, &runtime->bounce.span, "#define AL_SURFACE\n");
}

/* Fills bounce.hits and .depths. */
static al_status find_hits(al_draw *draw, al_bounce_effect effect, al_stage stage, const al_shell_block *block)
{
    switch (al_bounce_carrier(draw, effect)) {
    case AL_CARRIER_VOLUMES:
        return al_volumes_trace(draw, effect, stage, block);
    case AL_CARRIER_SCREEN:
        return march(draw, stage, block);
    default:
        return splat(draw, stage, block);
    }
}

static al_status arrive(al_draw *draw, al_stage stage, al_bounce_effect effect)
{
    const al_runtime *runtime = draw->runtime;
    const al_settings *settings = &draw->settings;
    al_carrier carrier = al_bounce_carrier(draw, effect);
    bool shown = carrier == AL_CARRIER_SCREEN;
    char defines[160] = "";
    if (effect == AL_BOUNCE_INDIRECT)
        snprintf(defines, sizeof defines, "#define AL_INDIRECT\n%s%s%s%s",
                 shown                           ? "#define AL_SHOWN\n"
                 : carrier == AL_CARRIER_VOLUMES ? "#define AL_TRACED\n"
                                                 : "",
                 settings->indirect_lambert || shown ? "" : "#define AL_GLOSSY\n",
                 settings->shadows_off ? "" : "#define AL_SHADOWS\n", al_fog_define(draw));
    return run(draw, stage, "bounce_arrive.comp", defines, shown ? runtime->targets.radiance.id : runtime->bounce.senders.id,
               runtime->bounce.glows.id);
}

static al_stage first_stage(al_bounce_effect effect)
{
    return effect == AL_BOUNCE_INDIRECT ? AL_STAGE_INDIRECT_RAYS : AL_STAGE_OCCLUSION_RAYS;
}

static al_status take_sample(al_draw *draw, al_bounce_effect effect, const al_shell_block *shells)
{
    al_stage stage = first_stage(effect);
    const al_targets *targets = &draw->runtime->targets;
    const char *receiver = receiver_define(draw, effect);
    al_status status = run(draw, stage, "bounce_surface.comp", receiver, targets->geometry.id, targets->material.id);
    if (!status) status = find_hits(draw, effect, stage + 1, shells);
    if (!status) status = arrive(draw, stage + 2, effect);
    return status ? status : run(draw, stage + 3, "bounce_filter.comp", receiver, targets->geometry.id, targets->material.id);
}

/* Adds the mean of the samples to the radiance. */
static al_status add(al_draw *draw, al_bounce_effect effect)
{
    al_runtime *runtime = draw->runtime;
    bool hidden = effect == AL_BOUNCE_OCCLUSION && al_bounce_sums(draw, effect);
    GLuint program;
    const char *defines = effect == AL_BOUNCE_OCCLUSION && draw->needs_shading ? "#define AL_AMBIENT\n"
                          : draw->settings.pass == AL_PASS_INDIRECT            ? al_fog_define(draw)
                                                                               : "";
    char all[96];
    snprintf(all, sizeof all, "%s%s", hidden ? "#define AL_HIDDEN\n" : "", defines);
    al_status status = al_shaders_get(runtime->shaders, "fullscreen.vert bounce_show.frag", all, &program, draw->error);
    if (status) return status;
    glBindFramebuffer(GL_FRAMEBUFFER, runtime->targets.radiance_framebuffer);
    glDisable(GL_SCISSOR_TEST);
    glViewport(0, 0, draw->tile[2], draw->tile[3]);
    glUseProgram(program);
    bind_surfaces(runtime, runtime->bounce.light.id);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE);
    draw_fullscreen(runtime);
    glDisable(GL_BLEND);
    return AL_OK;
}

/* Shares and light of everything that may hide or send, in one draw. */
static al_status add_up(al_draw *draw, al_bounce_effect effect, const al_shell_block *shells)
{
    al_stage stage = first_stage(effect) + 1;
    if (al_bounce_carrier(draw, effect) == AL_CARRIER_VOLUMES_BLENDED) return al_volumes_sum(draw, stage);
    return sum_surfels(draw, effect, stage, shells);
}

static al_status take_samples(al_draw *draw, al_bounce_effect effect, const al_shell_block *shells, al_bounce_block block)
{
    al_status status = AL_OK;
    for (; block.sample[0] < block.sample[1] && !status; block.sample[0]++) {
        glNamedBufferSubData(draw->runtime->bounce.constants.id, 0, sizeof block, &block);
        status = take_sample(draw, effect, shells);
    }
    return status ? status : al_history_run(draw, effect);
}

/* Shaded surfaces, whose light the screen's march took, are not part of a picture of what is reflected alone. */
static void clear_shown(const al_draw *draw)
{
    static const float black[4] = {0, 0, 0, 1};
    glDisable(GL_SCISSOR_TEST);
    glClearNamedFramebufferfv(draw->runtime->targets.radiance_framebuffer, GL_COLOR, 0, black);
}

al_status al_bounce_surface(al_draw *draw, al_bounce_effect effect)
{
    al_bounce *bounce = &draw->runtime->bounce;
    const al_carrier carrier = al_bounce_carrier(draw, effect);
    const al_shell_block shells = shell_block(draw, carrier);
    const al_bounce_block block = bounce_block(draw, effect);
    bool sums = al_bounce_sums(draw, effect);
    al_status status = fit(draw, !sums, &shells);
    if (status) return status;
    glNamedBufferSubData(bounce->shells.id, 0, sizeof shells, &shells);
    glBindBufferBase(GL_UNIFORM_BUFFER, 3, bounce->shells.id);
    glNamedBufferSubData(bounce->constants.id, 0, sizeof block, &block);
    glBindBufferBase(GL_UNIFORM_BUFFER, 4, bounce->constants.id);
    if (carrier != AL_CARRIER_SCREEN) status = al_span_run(draw, first_stage(effect), &shells, &bounce->span, "#define AL_SURFACE\n");
    if (!status) status = sums ? add_up(draw, effect, &shells) : take_samples(draw, effect, &shells, block);
    if (!status && carrier == AL_CARRIER_SCREEN && draw->settings.pass == AL_PASS_INDIRECT) clear_shown(draw);
    return status ? status : add(draw, effect);
}

uint64_t al_bounce_surface_bytes(const al_runtime *runtime)
{
    const al_bounce *bounce = &runtime->bounce;
    return bounce->span.bytes + bounce->arriving.bytes + bounce->light.bytes + bounce->senders.bytes +
           bounce->glows.bytes + bounce->shells.size + runtime->targets.material.bytes;
}
