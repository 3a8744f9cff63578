/* Light of the environment in the fogs: the baked lattices of all of them as two textures (fog_sky.glsl). */
#include <stdlib.h>
#include <string.h>

#include "state.h"

enum { UNIT_LIGHT = AL_UNIT_PASS + 2, UNIT_PLANES = AL_UNIT_PASS + 3 };

static uint32_t larger(uint32_t a, uint32_t b)
{
    return a > b ? a : b;
}

static uint32_t number_count(const al_medium_sky *sky)
{
    return 1 + sky->order * sky->order;
}

/* Makes the textures as large as the largest lattice across and all of them along z. */
static al_status make_textures(al_runtime *runtime, al_error *error)
{
    al_fogs *fogs = &runtime->fogs;
    uint32_t light[3] = {0}, planes[3] = {0}, numbers = 0;
    GLint edge = 0;
    for (uint32_t i = 0; i < runtime->scene.fog_count; i++) {
        al_fog_medium *medium = &fogs->media[i];
        const al_medium_sky *sky = &medium->sky;
        if (!sky->size[0]) continue;
        medium->sky_slice = (int32_t)light[2];
        medium->sky_cell = sky->walled ? (int32_t)planes[2] : -1;
        for (int k = 0; k < 2; k++) {
            light[k] = larger(light[k], sky->size[k]);
            if (sky->walled) planes[k] = larger(planes[k], sky->size[k] - 1);
        }
        light[2] += sky->size[2];
        if (sky->walled) planes[2] += sky->size[2] - 1;
        numbers = larger(numbers, number_count(sky));
    }
    if (!numbers) return AL_OK;
    fogs->sky_stride = (int32_t)light[0];
    glGetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &edge);
    if (light[0] * numbers > (uint32_t)edge || light[2] > (uint32_t)edge)
        return al_fail(
            error, AL_BAD_INPUT,
            "fogs: the sky's light, %u points of %u numbers by %u slices, is more than this OpenGL's "
            "textures hold, %d along an edge",
            light[0], numbers, light[2], edge);
    al_status status = al_gl_texture_create(&runtime->memory, GL_TEXTURE_3D, GL_RGBA16F, light[0] * numbers,
                                            light[1], light[2], 1, &fogs->sky_light, error);
    if (!status && planes[2])
        status = al_gl_texture_create(&runtime->memory, GL_TEXTURE_3D, GL_RG32UI, planes[0], planes[1],
                                      planes[2], 1, &fogs->sky_planes, error);
    if (status) return status;
    glTextureParameteri(fogs->sky_light.id, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(fogs->sky_light.id, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    return AL_OK;
}

static al_status upload(const al_fogs *fogs, const al_fog_medium *medium, al_error *error)
{
    const al_medium_sky *sky = &medium->sky;
    const GLsizei size[3] = {(GLsizei)sky->size[0], (GLsizei)sky->size[1], (GLsizei)sky->size[2]};
    size_t points = (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
    if (!points) return AL_OK;
    for (uint32_t i = 0; i < number_count(sky); i++)
        glTextureSubImage3D(fogs->sky_light.id, 0, (GLint)i * fogs->sky_stride, 0, medium->sky_slice, size[0],
                            size[1], size[2], GL_RGB, GL_HALF_FLOAT, sky->values + 3 * points * i);
    if (!sky->walled) return AL_OK;
    size_t cells = (size_t)(size[0] - 1) * (size_t)(size[1] - 1) * (size_t)(size[2] - 1);
    uint32_t *words = malloc(2 * cells * sizeof *words); /* eighth 0 lowest, on any host */
    if (!words) return al_fail(error, AL_IO, "no memory for the walls in a fog");
    for (size_t i = 0; i < 2 * cells; i++) {
        const uint8_t *c = sky->planes + 4 * i;
        words[i] = c[0] | (uint32_t)c[1] << 8 | (uint32_t)c[2] << 16 | (uint32_t)c[3] << 24;
    }
    glTextureSubImage3D(fogs->sky_planes.id, 0, 0, 0, medium->sky_cell, size[0] - 1, size[1] - 1, size[2] - 1,
                        GL_RG_INTEGER, GL_UNSIGNED_INT, words);
    free(words);
    return AL_OK;
}

al_status al_fog_sky_upload(al_runtime *runtime, al_error *error)
{
    al_status status = make_textures(runtime, error);
    for (uint32_t i = 0; !status && i < runtime->scene.fog_count; i++)
        status = upload(&runtime->fogs, &runtime->fogs.media[i], error);
    return status;
}

void al_fog_sky_fill(const al_runtime *runtime, const al_fog_medium *medium, al_fog_entry *entry)
{
    const al_medium_sky *sky = &medium->sky;
    if (!sky->size[0] || !al_fog_sky_exists(runtime)) return;
    for (int k = 0; k < 3; k++) {
        entry->sky_size[k] = (int32_t)sky->size[k];
        entry->sky_grade[k] = sky->grade[k];
    }
    entry->sky_size[3] = (int32_t)sky->order;
    entry->sky_place[0] = medium->sky_slice;
    entry->sky_place[1] = medium->sky_cell;
    entry->sky_grade[3] = sky->unit_w_m2_sr;
}

void al_fog_sky_bind(const al_runtime *runtime)
{
    al_gl_bind_texture(UNIT_LIGHT, runtime->fogs.sky_light.id);
    al_gl_bind_texture(UNIT_PLANES, runtime->fogs.sky_planes.id);
}

bool al_fog_sky_exists(const al_runtime *runtime)
{
    return runtime->fogs.sky_light.id != 0;
}

uint64_t al_fog_sky_bytes(const al_runtime *runtime)
{
    return runtime->fogs.sky_light.bytes + runtime->fogs.sky_planes.bytes;
}

void al_fog_sky_free(al_runtime *runtime)
{
    al_gl_texture_free(&runtime->memory, &runtime->fogs.sky_light);
    al_gl_texture_free(&runtime->memory, &runtime->fogs.sky_planes);
}
