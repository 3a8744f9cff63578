/* What each sample sends to the eye, by compute shader, in parts that GL's block size allows. */
#include <stdio.h>

#include "state.h"

enum { GROUP = 64, PART_GRAIN = 1024 };

static al_status get_program(al_draw *draw, const al_object *object, GLuint *program)
{
    char defines[256];
    snprintf(
        defines, sizeof defines,
        "#define AL_ORDER %u\n#define AL_BAKED_ORDER %u\n#define AL_CHANNELS %u\n#define AL_FORMAT %u\n%s%s",
        object->order, object->info.order, object->info.channel_count, object->info.format,
        draw->settings.view_leg == AL_VIEW_LEG_SH ? "#define AL_VIEW_SH\n" : "", al_fog_define(draw));
    return al_shaders_get(draw->runtime->shaders, "light.comp", defines, program, draw->error);
}

/* Samples per dispatch: a multiple of PART_GRAIN, whose bytes start on every alignment GL may ask for. */
static uint32_t part_size(uint64_t sample_size)
{
    GLint64 limit = 0;
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &limit);
    uint64_t count = (uint64_t)limit / sample_size / PART_GRAIN * PART_GRAIN;
    if (count < PART_GRAIN) count = PART_GRAIN;
    return count > 65535u * GROUP ? 65535u * GROUP / PART_GRAIN * PART_GRAIN : (uint32_t)count;
}

al_status al_light_run(al_draw *draw, al_object *object)
{
    al_runtime *runtime = draw->runtime;
    GLuint program;
    if (!object->drawn) return AL_OK;
    al_status status = get_program(draw, object, &program);
    if (status) return status;
    uint64_t sample_size = al_object_coefficient_size(&object->info);
    uint32_t part = part_size(sample_size);
    al_timing_begin(&runtime->timing, AL_STAGE_LIGHT);
    glUseProgram(program);
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, object->constants.id);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, object->positions.id);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, object->gaussians.id);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, object->scales.id);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, object->lit.id);
    for (uint32_t first = 0; first < object->drawn; first += part) {
        uint32_t count = object->drawn - first < part ? object->drawn - first : part;
        uint64_t offset = first * sample_size, end = (first + (uint64_t)count) * sample_size;
        end = (end + 3) / 4 * 4;
        glBindBufferRange(GL_SHADER_STORAGE_BUFFER, 2, object->coefficients.id, (GLintptr)offset,
                          (GLsizeiptr)(end - offset));
        glUniform1ui(0, first);
        glDispatchCompute((count + GROUP - 1) / GROUP, 1, 1);
    }
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    al_timing_end(&runtime->timing);
    return AL_OK;
}
