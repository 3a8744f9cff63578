/* The lightmap on the GPU: an array texture for each page, its layers those of irradiance, then of SH. */
#include <stdlib.h>
#include <string.h>

#include "state.h"

static al_status begin(al_runtime *runtime, const al_arrival *arrival, al_error *error)
{
    al_lightmap *map = &runtime->lightmap;
    map->pages = calloc(arrival->lightmap.page_count + (size_t)1, sizeof *map->pages);
    map->instances = calloc(runtime->scene.instance_count + (size_t)1, sizeof *map->instances);
    if (!map->pages || !map->instances)
        return al_fail(error, AL_IO, "%s: no memory for its pages", runtime->scene.baked.lightmap);
    map->page_count = arrival->lightmap.page_count;
    map->directional_order = arrival->lightmap.directional_order;
    map->half = arrival->lightmap.format == AL_LIGHTMAP_HALF;
    for (uint32_t i = 0; i < arrival->lightmap.instance_count; i++) {
        const al_lightmap_instance *from = &arrival->instances[i];
        if (from->instance < runtime->scene.instance_count) map->instances[from->instance] = from;
    }
    return AL_OK;
}

static const void *layer_values(const al_lightmap *map, const al_lightmap_page *page, uint64_t index)
{
    uint64_t each = (uint64_t)map->directional_order * map->directional_order, k = index - AL_LAYER_COUNT;
    if (index < AL_LAYER_COUNT) return page->irradiance[index];
    return (const uint8_t *)page->sh[k / each] + k % each * page->width * page->height * (map->half ? 6 : 12);
}

/* Layer by layer; the page counts as there once its last one is. */
static al_status take_page(al_runtime *runtime, const al_arrival *arrival, uint64_t *budget, bool *done,
                           al_error *error)
{
    const al_lightmap_page *page = &arrival->texels;
    al_light_page *out = &runtime->lightmap.pages[arrival->texels_index];
    const al_lightmap *map = &runtime->lightmap;
    bool half = map->half;
    uint32_t layers = AL_LAYER_COUNT * (1 + map->directional_order * map->directional_order);
    if (!runtime->arrived) {
        al_status status =
            al_gl_texture_create(&runtime->memory, GL_TEXTURE_2D_ARRAY, half ? GL_RGB16F : GL_RGB32F,
                                 page->width, page->height, layers, 1, &out->texels, error);
        if (status) return status;
        glTextureParameteri(out->texels.id, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        glTextureParameteri(out->texels.id, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    }
    uint64_t layer = (uint64_t)page->width * page->height * (half ? 6 : 12);
    uint64_t count = al_budget_share(budget, layer, layers - runtime->arrived);
    for (uint64_t i = runtime->arrived; i < runtime->arrived + count; i++)
        glTextureSubImage3D(out->texels.id, 0, 0, 0, (GLint)i, (GLsizei)page->width, (GLsizei)page->height, 1,
                            GL_RGB, half ? GL_HALF_FLOAT : GL_FLOAT, layer_values(map, page, i));
    runtime->arrived += (uint32_t)count;
    *done = runtime->arrived == layers;
    if (*done) {
        memcpy(out->scale, page->scale, sizeof out->scale);
        memcpy(out->sh_scale, page->sh_scale, sizeof out->sh_scale);
    }
    return AL_OK;
}

al_status al_lightmap_accept(al_runtime *runtime, const al_arrival *arrival, uint64_t *budget, bool *done,
                             al_error *error)
{
    *done = true;
    if (arrival->kind == AL_ARRIVAL_LIGHTMAP) return begin(runtime, arrival, error);
    return runtime->lightmap.pages ? take_page(runtime, arrival, budget, done, error) : AL_OK;
}

void al_lightmap_free(al_runtime *runtime)
{
    al_lightmap *map = &runtime->lightmap;
    for (uint32_t i = 0; i < map->page_count; i++)
        al_gl_texture_free(&runtime->memory, &map->pages[i].texels);
    free(map->pages);
    free(map->instances);
    memset(map, 0, sizeof *map);
}

uint64_t al_lightmap_bytes(const al_runtime *runtime)
{
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < runtime->lightmap.page_count; i++)
        bytes += runtime->lightmap.pages[i].texels.bytes;
    for (uint32_t i = 0; i < runtime->model.mesh_count; i++) bytes += runtime->model.meshes[i].uv1.size;
    return bytes;
}

void al_baked_layers(const al_draw *draw, float shares[AL_LAYER_COUNT])
{
    bool fog = draw->runtime->fogs.drawn;
    shares[AL_LAYER_SURFACE] = fog ? 0 : 1;
    shares[AL_LAYER_ATTENUATED] = fog ? 1 : 0;
    shares[AL_LAYER_SCATTERED] = fog && !draw->settings.scattered_off ? 1 : 0;
}

bool al_lightmap_exists(const al_runtime *runtime, uint32_t instance)
{
    const al_lightmap *map = &runtime->lightmap;
    const al_lightmap_instance *place = map->instances ? map->instances[instance] : NULL;
    return place && map->pages[place->page].scale[0] > 0 &&
           runtime->model.meshes[runtime->scene.instances[instance].mesh].uv1.id;
}

void al_lightmap_bind(const al_draw *draw, uint32_t instance)
{
    const al_lightmap_instance *place = draw->runtime->lightmap.instances[instance];
    const al_light_page *page = &draw->runtime->lightmap.pages[place->page];
    float layers[AL_LAYER_COUNT], sh[AL_LAYER_COUNT];
    al_baked_layers(draw, layers);
    for (int i = 0; i < AL_LAYER_COUNT; i++) {
        sh[i] = layers[i] * page->sh_scale[i];
        layers[i] *= page->scale[i];
    }
    glUniform4f(6, place->scale[0], place->scale[1], place->offset[0], place->offset[1]);
    glUniform3fv(7, 1, layers);
    glUniform4f(17, sh[0], sh[1], sh[2], (float)draw->runtime->lightmap.directional_order);
    al_gl_bind_texture(AL_UNIT_LIGHTMAP, page->texels.id);
}
