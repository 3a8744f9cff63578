/* Light of moving instances from the probes around them. */
#include <stdlib.h>
#include <string.h>

#include "state.h"

enum { BANDS = 9 }; /* order 3: what a cosine keeps beyond is below 3 % of the light from one direction */

al_status al_probes_accept(al_runtime *runtime, const al_arrival *arrival, al_error *error)
{
    al_probe_lights *lights = &runtime->probes;
    lights->places = calloc(runtime->scene.instance_count + (size_t)1, sizeof *lights->places);
    if (!lights->places) return al_fail(error, AL_IO, "%s: no memory", runtime->scene.baked.probes);
    lights->probes = arrival->probes;
    lights->present = true;
    return AL_OK;
}

void al_probes_free(al_runtime *runtime)
{
    free(runtime->probes.places);
    memset(&runtime->probes, 0, sizeof runtime->probes);
}

void al_probes_set(const al_draw *draw, uint32_t instance)
{
    al_runtime *runtime = draw->runtime;
    const al_probes *probes = &runtime->probes.probes;
    al_probe_place *place = &runtime->probes.places[instance];
    float low[3], high[3], shares[AL_LAYER_COUNT], layer[3][AL_PROBES_MAX_COUNT], sh[BANDS][3] = {{0}};
    uint32_t count = probes->info.order * probes->info.order;
    al_model_world_box(runtime, &runtime->scene.instances[instance], low, high);
    for (int k = 0; k < 3; k++) low[k] = 0.5f * (low[k] + high[k]);
    al_probes_locate(probes, low, place);
    al_baked_layers(draw, shares);
    for (int l = 0; l < AL_LAYER_COUNT; l++) {
        if (shares[l] == 0) continue;
        al_probes_blend(probes, place, (al_lightmap_layer)l, layer);
        for (uint32_t i = 0; i < BANDS && i < count; i++)
            for (int c = 0; c < 3; c++) sh[i][c] += shares[l] * layer[c][i];
    }
    glUniform3fv(8, BANDS, sh[0]);
}
