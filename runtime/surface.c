/* Background and opaque instances, then the boundary of one translucent object and where rays leave it. */
#include <math.h>
#include <stdio.h>

#include "state.h"

static float dielectric_reflectance(float ior)
{
    float ratio = ior > 0 ? (ior - 1) / (ior + 1) : 0;
    return ratio * ratio;
}

static bool has_texture(const al_runtime *runtime, uint32_t index)
{
    return index < runtime->model.texture_count && runtime->model.textures[index].id;
}

static void set_material(const al_runtime *runtime, const al_material *m, float reflectance)
{
    const uint32_t maps[4] = {m->base_color_texture, m->emission_texture, m->metallic_roughness_texture,
                              m->normal_texture};
    GLint present[4];
    for (uint32_t i = 0; i < 4; i++) {
        present[i] = has_texture(runtime, maps[i]);
        al_gl_bind_texture(AL_UNIT_PASS + i, present[i] ? runtime->model.textures[maps[i]].id : 0);
    }
    glUniform4f(1, m->base_color[0], m->base_color[1], m->base_color[2], m->metallic);
    glUniform4f(2, m->emission_w_m2_sr[0], m->emission_w_m2_sr[1], m->emission_w_m2_sr[2], m->roughness);
    glUniform4f(3, reflectance, m->double_sided ? 1 : 0, 0, 0);
    glUniform4iv(4, 1, present);
}

const al_material *al_material_bind(const al_runtime *runtime, const al_submesh *part)
{
    static const al_material plain = {.base_color = {0.8f, 0.8f, 0.8f},
                                      .roughness = 1,
                                      .ior = 1.5f,
                                      .base_color_texture = AL_NO_INDEX,
                                      .emission_texture = AL_NO_INDEX,
                                      .metallic_roughness_texture = AL_NO_INDEX,
                                      .normal_texture = AL_NO_INDEX};
    const al_scene *scene = &runtime->scene;
    const al_material *m =
        part->material < scene->material_count ? &scene->materials[part->material] : &plain;
    set_material(runtime, m, dielectric_reflectance(m->ior));
    return m;
}

bool al_instance_mirrors(const al_instance *instance)
{
    const float *w = instance->world;
    return w[0] * (w[5] * w[10] - w[6] * w[9]) - w[4] * (w[1] * w[10] - w[2] * w[9]) +
               w[8] * (w[1] * w[6] - w[2] * w[5]) <
           0;
}

static void draw_instance(const al_runtime *runtime, const al_instance *instance, bool boundary)
{
    const al_mesh *mesh = &runtime->scene.meshes[instance->mesh];
    if (!runtime->model.meshes[instance->mesh].vertex_array) return;
    glFrontFace(al_instance_mirrors(instance) ? GL_CW : GL_CCW);
    glUniformMatrix4fv(0, 1, GL_FALSE, instance->world);
    glBindVertexArray(runtime->model.meshes[instance->mesh].vertex_array);
    for (uint32_t i = 0; i < mesh->submesh_count; i++) {
        const al_submesh *part = &mesh->submeshes[i];
        const al_material *m = al_material_bind(runtime, part);
        if (boundary || m->double_sided)
            glDisable(GL_CULL_FACE);
        else
            glEnable(GL_CULL_FACE);
        glDrawElements(GL_TRIANGLES, (GLsizei)part->index_count, GL_UNSIGNED_INT,
                       (const void *)((uintptr_t)part->first_index * sizeof(uint32_t)));
    }
    glDisable(GL_CULL_FACE);
    glFrontFace(GL_CCW);
}

static void set_viewport(const al_draw *draw)
{
    glViewport(-draw->tile[0], -draw->tile[1], (GLsizei)draw->view->width, (GLsizei)draw->view->height);
    glScissor(0, 0, draw->tile[2], draw->tile[3]);
    glEnable(GL_SCISSOR_TEST);
}

static al_status draw_background(al_draw *draw)
{
    al_runtime *runtime = draw->runtime;
    GLuint program;
    al_status status =
        al_shaders_get(runtime->shaders, "fullscreen.vert background.frag", "", &program, draw->error);
    if (status) return status;
    bool shown = draw->settings.pass == AL_PASS_COMPOSITE;
    if (draw->host_depth)
        glBlitNamedFramebuffer(draw->framebuffer, runtime->targets.host_framebuffer, draw->tile[0],
                               draw->tile[1], draw->tile[0] + draw->tile[2], draw->tile[1] + draw->tile[3], 0,
                               0, draw->tile[2], draw->tile[3], GL_COLOR_BUFFER_BIT, GL_NEAREST);
    glUseProgram(program);
    al_gl_bind_texture(AL_UNIT_PASS, draw->host_depth);
    al_gl_bind_texture(AL_UNIT_PASS + 1, runtime->targets.host.id);
    glUniform3i(0, draw->host_depth != 0, shown && !draw->settings.background_off, shown);
    glViewport(0, 0, draw->tile[2], draw->tile[3]);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_ALWAYS);
    glBindVertexArray(runtime->empty_vertex_array);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glDepthFunc(GL_LESS);
    return AL_OK;
}

al_lighting al_instance_lighting(const al_runtime *runtime, uint32_t instance)
{
    al_lighting lighting = (al_lighting)runtime->scene.instances[instance].lighting;
    if (lighting == AL_LIGHTING_LIGHTMAP && al_lightmap_exists(runtime, instance)) return lighting;
    if (lighting == AL_LIGHTING_PROBES && runtime->probes.present) return lighting;
    return AL_LIGHTING_DYNAMIC;
}

/* The opaque instances that are lit in this way. */
static al_status draw_opaque(al_draw *draw, al_lighting lighting)
{
    static const char *const names[] = {"", "#define AL_LIGHTMAP\n", "#define AL_PROBES\n"};
    al_runtime *runtime = draw->runtime;
    const al_scene *scene = &runtime->scene;
    char defines[96];
    GLuint program = 0; /* built when the first instance asks for it */
    bool later = draw->needs_shading && draw->effects[AL_BOUNCE_OCCLUSION]; /* the environment's light */
    snprintf(defines, sizeof defines, "%s%s%s", names[lighting], al_fog_define(draw),
             draw->needs_material ? "#define AL_MATERIAL\n" : "");
    for (uint32_t i = 0; i < scene->instance_count; i++) {
        if (scene->instances[i].role != AL_ROLE_OPAQUE || al_instance_lighting(runtime, i) != lighting) continue;
        if (!program) {
            al_status status =
                al_shaders_get(runtime->shaders, "surface.vert surface.frag", defines, &program, draw->error);
            if (status) return status;
            glUseProgram(program);
            glUniform4i(5, draw->needs_shading, !draw->settings.shadows_off, -1, later);
        }
        if (lighting == AL_LIGHTING_LIGHTMAP) al_lightmap_bind(draw, i);
        if (lighting == AL_LIGHTING_PROBES) al_probes_set(draw, i);
        draw_instance(runtime, &scene->instances[i], false);
    }
    return AL_OK;
}

/* Blockers are black; their own faces end the march sharper than voxels can. */
static al_status draw_blockers(al_draw *draw)
{
    al_runtime *runtime = draw->runtime;
    GLuint program;
    if (!runtime->model.has_blockers) return AL_OK;
    al_status status = al_shaders_get(runtime->shaders, "surface.vert surface.frag", al_fog_define(draw),
                                      &program, draw->error);
    if (status) return status;
    glUseProgram(program);
    glUniform4i(5, 0, 0, -1, 0);
    for (uint32_t i = 0; i < runtime->scene.instance_count; i++)
        if (runtime->scene.instances[i].role == AL_ROLE_BLOCKER)
            draw_instance(runtime, &runtime->scene.instances[i], false);
    return AL_OK;
}

al_status al_surface_draw(al_draw *draw)
{
    static const GLuint nothing[4] = {0};
    al_runtime *runtime = draw->runtime;
    al_timing_begin(&runtime->timing, AL_STAGE_SURFACE);
    glBindFramebuffer(GL_FRAMEBUFFER, runtime->targets.scene_framebuffer);
    glEnable(GL_SCISSOR_TEST);
    glScissor(0, 0, draw->tile[2], draw->tile[3]);
    al_status status = draw_background(draw);
    if (!status && (runtime->model.has_opaque || runtime->model.has_blockers)) set_viewport(draw);
    if (draw->needs_material) {
        glBindFramebuffer(GL_FRAMEBUFFER, runtime->targets.material_framebuffer);
        glClearNamedFramebufferuiv(runtime->targets.material_framebuffer, GL_COLOR, 2, nothing);
    }
    for (int lighting = AL_LIGHTING_DYNAMIC; lighting <= AL_LIGHTING_PROBES && !status; lighting++)
        status = draw_opaque(draw, (al_lighting)lighting);
    glBindFramebuffer(GL_FRAMEBUFFER, runtime->targets.scene_framebuffer);
    if (!status) status = draw_blockers(draw);
    glDisable(GL_DEPTH_TEST);
    al_timing_end(&runtime->timing);
    return status;
}

al_status al_boundary_draw(al_draw *draw, al_object *object, uint32_t index)
{
    static const float nothing[4] = {0}, far[1] = {1};
    al_runtime *runtime = draw->runtime;
    const al_scene *scene = &runtime->scene;
    GLuint program, framebuffer = runtime->targets.boundary_framebuffer;
    char defines[64];
    snprintf(defines, sizeof defines, "#define AL_BOUNDARY\n%s", al_fog_define(draw));
    al_status status =
        al_shaders_get(runtime->shaders, "surface.vert surface.frag", defines, &program, draw->error);
    if (status) return status;
    bool shade = (draw->settings.pass == AL_PASS_COMPOSITE || draw->settings.pass == AL_PASS_SURFACE) &&
                 !draw->settings.surface_off;
    al_timing_begin(&runtime->timing, AL_STAGE_SURFACE);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glClearNamedFramebufferfv(framebuffer, GL_COLOR, 0, nothing); /* inside the scissor */
    glClearNamedFramebufferfv(framebuffer, GL_COLOR, 1, nothing);
    glClearNamedFramebufferfv(framebuffer, GL_DEPTH, 0, far);
    glViewport(-draw->tile[0], -draw->tile[1], (GLsizei)draw->view->width, (GLsizei)draw->view->height);
    glEnable(GL_DEPTH_TEST);
    glEnable(GL_DEPTH_CLAMP); /* a boundary nearer than the near plane still begins the medium */
    glUseProgram(program);
    glUniform4i(5, shade, !draw->settings.shadows_off, object->block.sizes[2], 0);
    draw_instance(runtime, &scene->instances[scene->translucents[index].instance], true);
    glDisable(GL_DEPTH_CLAMP);
    glDisable(GL_DEPTH_TEST);
    al_timing_end(&runtime->timing);
    return AL_OK;
}

al_status al_back_draw(al_draw *draw, uint32_t index)
{
    static const float nothing[4] = {0};
    al_runtime *runtime = draw->runtime;
    const al_instance *instance = &runtime->scene.instances[runtime->scene.translucents[index].instance];
    GLuint program, framebuffer = runtime->targets.back_framebuffer,
                    vertex_array = runtime->model.meshes[instance->mesh].vertex_array;
    al_status status = al_shaders_get(runtime->shaders, "surface.vert back.frag", "", &program, draw->error);
    if (status) return status;
    al_timing_begin(&runtime->timing, AL_STAGE_SURFACE);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glClearNamedFramebufferfv(framebuffer, GL_COLOR, 0, nothing); /* inside the scissor */
    glViewport(-draw->tile[0], -draw->tile[1], (GLsizei)draw->view->width, (GLsizei)draw->view->height);
    glUseProgram(program);
    glUniformMatrix4fv(0, 1, GL_FALSE, instance->world);
    glBindVertexArray(vertex_array);
    glEnable(GL_DEPTH_CLAMP); /* backs behind the far plane count too */
    glEnable(GL_BLEND);
    glBlendEquation(GL_MAX);
    if (vertex_array)
        glDrawElements(GL_TRIANGLES, (GLsizei)runtime->scene.meshes[instance->mesh].index_count,
                       GL_UNSIGNED_INT, NULL);
    glBlendEquation(GL_FUNC_ADD);
    glDisable(GL_BLEND);
    glDisable(GL_DEPTH_CLAMP);
    al_timing_end(&runtime->timing);
    return AL_OK;
}
