#include "bake_medium.h"

#include "bake_object.h"
#include "grid_sequence.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "airlight/medium.h"
#include "fog_depth.h"
#include "fog_skin.h"
#include "light_key.h"
#include "sky_light.h"

/* Part of every key: raise it when the asset changes for the same input. */
static const uint32_t bake_version = 2, depth_version = 1;

enum { LAYER_SHARE = 8, LAYER_VOXELS = 256, LAYER_POINTS = 2 };

typedef struct source {
    const al_density *density;
    al_density_voxels voxels; /* of a grid; values NULL: sampled */
    const al_medium_info *info;
} source;

static const al_medium_description *description_of(const al_import *import, uint32_t fog)
{
    return &import->description->media[import->scene.fogs[fog].medium];
}

bool al_fog_varies(const al_import *import, uint32_t fog)
{
    return description_of(import, fog)->density.type != AL_DENSITY_CONSTANT;
}

bool al_fog_has_asset(const al_import *import, uint32_t fog)
{
    return al_fog_varies(import, fog) || !al_sky_light_missing(import, fog);
}

void al_bake_medium_file(const al_import *import, uint32_t fog, char *name, size_t size)
{
    al_asset_file(import->scene.media[import->scene.fogs[fog].medium].name, "medium", name, size);
}

al_status al_bake_medium_key(const al_import *import, uint32_t fog, uint64_t *key, al_error *error)
{
    const al_medium *medium = &import->scene.media[import->scene.fogs[fog].medium];
    XXH64_state_t *state = XXH64_createState();
    if (!state) return al_fail(error, AL_IO, "out of memory");
    XXH64_reset(state, 0);
    XXH64_update(state, &bake_version, sizeof bake_version);
    XXH64_update(state, medium->sigma_s_per_m, sizeof medium->sigma_s_per_m);
    XXH64_update(state, medium->sigma_a_per_m, sizeof medium->sigma_a_per_m);
    XXH64_update(state, &medium->g, sizeof medium->g);
    al_hash_density(state, import, &description_of(import, fog)->density);
    al_grid_sequence_hash(state, import, &description_of(import, fog)->density);
    if (!al_fog_depth_missing(import, fog)) {
        XXH64_update(state, &depth_version, sizeof depth_version);
        XXH64_update(state, &description_of(import, fog)->optical_depth_order, sizeof(uint32_t));
    }
    bool refuses = al_fog_varies(import, fog) && al_fog_skin_refuses(import);
    XXH64_update(state, &refuses, sizeof refuses); /* what was baked all the same is not good enough then */
    al_status status = AL_OK;
    if (!al_sky_light_missing(import, fog)) {
        uint64_t light;
        status = al_light_key(import, &light, error);
        XXH64_update(state, &light, sizeof light);
    }
    *key = XXH64_digest(state);
    XXH64_freeState(state);
    return status;
}

static al_status grid_slice(void *user, uint32_t frame, uint32_t z, float *density, al_error *error)
{
    const source *s = user;
    size_t count = (size_t)s->voxels.size[0] * s->voxels.size[1];
    const float *values = s->voxels.values + z * count;
    (void)frame, (void)error;
    for (size_t i = 0; i < count; i++) density[i] = (float)(s->voxels.scale * values[i]);
    return AL_OK;
}

/* One voxel, which holds for all of the bounds. */
static al_status constant_slice(void *user, uint32_t frame, uint32_t z, float *density, al_error *error)
{
    const source *s = user;
    (void)frame, (void)z, (void)error;
    *density = (float)al_density_max(s->density);
    return AL_OK;
}

/* The mean over 2^3 points of each voxel. */
static al_status sampled_slice(void *user, uint32_t frame, uint32_t z, float *density, al_error *error)
{
    const source *s = user;
    const float *m = s->info->grid_to_world;
    (void)frame, (void)error;
    for (uint32_t y = 0; y < s->info->size[1]; y++)
        for (uint32_t x = 0; x < s->info->size[0]; x++) {
            double sum = 0;
            for (int point = 0; point < LAYER_POINTS * LAYER_POINTS * LAYER_POINTS; point++) {
                double place[3] = {x + 0.5 * (point & 1) - 0.25, y + 0.5 * (point >> 1 & 1) - 0.25,
                                   z + 0.5 * (point >> 2) - 0.25};
                for (int k = 0; k < 3; k++) place[k] = place[k] * m[5 * k] + m[12 + k];
                sum += al_density_at(s->density, place);
            }
            *density++ = (float)(sum / (LAYER_POINTS * LAYER_POINTS * LAYER_POINTS));
        }
    return AL_OK;
}

/* Voxels of an eighth of the thinnest layer, but no more than 256 along the longest edge of the bounds. A
 * constant density has one. */
static void place_samples(double detail_m, al_medium_info *info)
{
    double longest = 0;
    for (int k = 0; k < 3; k++)
        longest = fmax(longest, (double)info->bounds_max_m[k] - info->bounds_min_m[k]);
    double voxel = fmax(detail_m > 0 ? detail_m / LAYER_SHARE : longest, longest / LAYER_VOXELS);
    for (int k = 0; k < 3; k++) {
        double edge = (double)info->bounds_max_m[k] - info->bounds_min_m[k];
        info->size[k] = detail_m > 0 ? (uint32_t)fmax(1, ceil(edge / voxel - 1e-6)) : 1;
        info->grid_to_world[5 * k] = (float)(edge / info->size[k]);
        info->grid_to_world[12 + k] = info->bounds_min_m[k] + 0.5f * info->grid_to_world[5 * k];
    }
    info->grid_to_world[15] = 1;
}

static void describe(const al_import *import, uint32_t fog, source *s, al_medium_info *info)
{
    const al_fog *f = &import->scene.fogs[fog];
    const al_medium *medium = &import->scene.media[f->medium];
    *info = (al_medium_info){.frame_count = 1, .g = medium->g};
    for (int k = 0; k < 3; k++) {
        info->bounds_min_m[k] = f->bounds_min_m[k];
        info->bounds_max_m[k] = f->bounds_max_m[k];
        info->sigma_s_per_m[k] = medium->sigma_s_per_m[k];
        info->sigma_a_per_m[k] = medium->sigma_a_per_m[k];
    }
    s->density = import->densities[f->medium];
    s->info = info;
    if (!al_density_grid(s->density, &s->voxels)) {
        info->extended = !al_fog_varies(import, fog);
        place_samples(al_density_detail_m(s->density), info);
        return;
    }
    info->extended = s->voxels.extended;
    memcpy(info->size, s->voxels.size, sizeof info->size);
    for (int i = 0; i < 16; i++) info->grid_to_world[i] = (float)s->voxels.index_to_world[i];
}

static al_status check_size(const al_import *import, uint32_t fog, const al_medium_info *info,
                            size_t memory_limit, al_error *error)
{
    const al_medium_description *medium = description_of(import, fog);
    double bytes = 4.0 * info->size[0] * info->size[1] * info->size[2];
    if (bytes <= (double)memory_limit) return AL_OK;
    return al_fail(error, AL_BAD_INPUT,
                   "medium \"%s\" (line %d): its %u x %u x %u voxels take %.0f MiB as floats, --memory-limit "
                   "allows %.0f MiB: raise it, or crop or resample the grid",
                   medium->name, medium->line, info->size[0], info->size[1], info->size[2], bytes / 1048576,
                   (double)memory_limit / 1048576);
}

al_status al_bake_medium(const al_import *import, uint32_t fog, uint64_t key, const al_bake_options *options,
                         al_steps *steps, al_error *error)
{
    double started = al_program_seconds();
    char file[160], path[1400], provenance[64];
    uint64_t bytes = 0;
    source s = {0};
    al_sky_light light = {0};
    al_fog_depths depths = {0};
    al_fog_skin skin;
    al_medium_data data = {.user = &s, .provenance_json = provenance};
    describe(import, fog, &s, &data.info);
    data.slice = s.voxels.values              ? grid_slice
                 : al_fog_varies(import, fog) ? sampled_slice
                                              : constant_slice;
    al_grid_sequence *sequence = NULL;
    al_status status = AL_OK;
    if (description_of(import, fog)->density.frame_count > 1)
        status = al_grid_sequence_open(import, description_of(import, fog), &data, &sequence, error);
    if (status == AL_OK) status = check_size(import, fog, &data.info, options->memory_limit, error);
    if (status == AL_OK && !al_sky_light_missing(import, fog)) {
        status = al_sky_light_make(import, fog, &data.info, options, &light, error);
        data.sky = &light.sky;
        data.sky_values = light.values;
        if (status == AL_OK)
            al_steps_add(steps, "sky light", started, 0,
                         (uint64_t)light.sky.size[0] * light.sky.size[1] * light.sky.size[2]);
        started = al_program_seconds();
    }
    if (al_fog_varies(import, fog)) al_fog_skin_watch(import, fog, options, &data, &skin);
    if (!al_fog_depth_missing(import, fog)) al_fog_depths_place(import, fog, options, &data, &depths);
    al_bake_medium_file(import, fog, file, sizeof file);
    snprintf(path, sizeof path, "%s/%s", options->folder, file);
    snprintf(provenance, sizeof provenance, "{\"key\":\"%016llx\"}", (unsigned long long)key);
    if (status == AL_OK) status = al_medium_write(path, &data, &bytes, error);
    if (status == AL_OK && data.depth)
        al_steps_add(steps, "fog depth", al_program_seconds() - depths.seconds, 0,
                     (uint64_t)data.depth->size[0] * data.depth->size[1] * data.depth->size[2] * data.info.frame_count);
    if (status == AL_OK)
        al_steps_add(steps, "medium", started + depths.seconds, bytes,
                     (uint64_t)data.info.size[0] * data.info.size[1] * data.info.size[2] * data.info.frame_count);
    al_sky_light_free(&light);
    al_grid_sequence_close(sequence);
    return status;
}
