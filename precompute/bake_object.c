/* The bake of one translucent object, step by step. */
#include "bake_object.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <xxhash.h>

#include "airlight/formulas.h"
#include "airlight/translucent.h"
#include "checkpoint.h"
#include "measure.h"
#include "sample.h"
#include "sweep.h"
#include "tetrahedra.h"

/* Part of every key: raise it when a step's result changes for the same input. */
static const uint32_t bake_version = 5;

enum stage { STAGE_MOMENT = 1, STAGE_SAMPLE = 2, STAGE_PROJECT = 3 };

typedef struct work {
    const al_import *import;
    uint32_t index; /* of the object */
    const al_translucent_object *object;
    const al_medium *medium;
    const al_bake_settings *settings;
    const al_bake_options *options;
    al_device *device;
    al_steps *steps;
    uint64_t key;
    char path[1200], partial_path[1210];
    al_triangles boundary, blockers;
    al_solid *blocker_solid; /* NULL without blockers */
    al_tetrahedra tetrahedra;
    al_density_field field;
    al_grid grid;
    al_sweep sweep;
    al_moment_state moment;
    al_project_state project;
    al_samples samples;
    float *rho;          /* [z][y][x] */
    float *coefficients; /* [sample][channel][order^2] */
    uint32_t channel_count, channel;
    double sigma_t[3], sigma_mean;
    uint32_t stage;
} work;

void al_bake_object_file(const al_translucent_object *object, char *name, size_t size)
{
    al_asset_file(object->name, "translucent", name, size);
}

static al_status load_surfaces(const al_import *import, uint32_t index, al_triangles *boundary,
                               al_triangles *blockers, al_error *error)
{
    al_status status = al_import_boundary(import, index, boundary, error);
    return status == AL_OK ? al_import_blockers(import, index, blockers, error) : status;
}

static void hash_triangles(XXH64_state_t *state, const al_triangles *triangles)
{
    XXH64_update(state, triangles->positions,
                 3 * (size_t)triangles->vertex_count * sizeof *triangles->positions);
    XXH64_update(state, triangles->indices,
                 3 * (size_t)triangles->triangle_count * sizeof *triangles->indices);
}

void al_hash_density(XXH64_state_t *state, const al_import *import, const al_density_description *density)
{
    double numbers[] = {density->type,        density->scale,    density->has_bounds, density->period_m,
                        density->thickness_m, density->offset_m, density->low,        density->high};
    XXH64_update(state, numbers, sizeof numbers);
    XXH64_update(state, density->grid_to_world, sizeof density->grid_to_world);
    XXH64_update(state, density->bounds_min_m, sizeof density->bounds_min_m);
    XXH64_update(state, density->bounds_max_m, sizeof density->bounds_max_m);
    XXH64_update(state, density->axis, sizeof density->axis);
    XXH64_update(state, density->grid, strlen(density->grid));
    for (uint32_t i = 0; i < import->input_count; i++)
        if (!strcmp(import->inputs[i].path, density->file))
            XXH64_update(state, &import->inputs[i].xxh64, sizeof(uint64_t));
}

al_status al_bake_object_key(const al_import *import, uint32_t index, uint64_t *key, al_error *error)
{
    const al_translucent_object *object = &import->scene.translucents[index];
    const al_medium *medium = &import->scene.media[object->medium];
    const al_bake_settings *s = &import->description->bake;
    al_triangles boundary = {0}, blockers = {0};
    XXH64_state_t *state = XXH64_createState();
    al_status status = state ? load_surfaces(import, index, &boundary, &blockers, error)
                             : al_fail(error, AL_IO, "out of memory");
    if (status == AL_OK) {
        uint32_t settings[] = {bake_version, s->directions, s->grid_resolution,
                               s->samples,   s->sh_order,   s->coefficient_format,
                               s->seed,      s->too_dense};
        XXH64_reset(state, 0);
        XXH64_update(state, settings, sizeof settings);
        XXH64_update(state, &s->radius_m, sizeof s->radius_m);
        XXH64_update(state, medium->sigma_s_per_m, sizeof medium->sigma_s_per_m);
        XXH64_update(state, medium->sigma_a_per_m, sizeof medium->sigma_a_per_m);
        XXH64_update(state, &medium->g, sizeof medium->g);
        const al_density_description *density = &import->description->media[object->medium].density;
        if (density->type != AL_DENSITY_CONSTANT)
            XXH64_update(state, import->scene.instances[object->instance].world, sizeof(float[16]));
        al_hash_density(state, import, density);
        hash_triangles(state, &boundary);
        hash_triangles(state, &blockers);
        *key = XXH64_digest(state);
    }
    al_triangles_free(&boundary);
    al_triangles_free(&blockers);
    XXH64_freeState(state);
    return status;
}

/* One set of coefficients for media that are grey in extinction, else one per channel. */
static void choose_channels(work *w)
{
    for (int c = 0; c < 3; c++)
        w->sigma_t[c] = (double)w->medium->sigma_s_per_m[c] + w->medium->sigma_a_per_m[c];
    w->channel_count = w->sigma_t[0] == w->sigma_t[1] && w->sigma_t[1] == w->sigma_t[2] ? 1 : 3;
    w->sigma_mean = (w->sigma_t[0] + w->sigma_t[1] + w->sigma_t[2]) / 3;
}

/* Blockers must stop the clearest channel too, but a channel without extinction would ask for an infinite
 * density: 1e-4 of the mean is the least that is cared for. */
static double smallest_sigma(const work *w)
{
    double smallest = w->sigma_mean > 0 ? w->sigma_mean : 1;
    for (int c = 0; c < 3; c++)
        if (w->sigma_t[c] > 0) smallest = fmin(smallest, w->sigma_t[c]);
    return fmax(smallest, 1e-4 * w->sigma_mean);
}

static al_status voxelise(work *w, al_error *error)
{
    double started = al_program_seconds();
    const float *world = w->import->scene.instances[w->object->instance].world;
    w->field.density = w->import->densities[w->object->medium];
    for (int i = 0; i < 16; i++) w->field.to_world[i] = world[i];
    al_status status = al_grid_voxelise(w->object->name, &w->boundary, &w->blockers, &w->field,
                                        w->settings->grid_resolution, w->options->threads, &w->grid, error);
    if (status == AL_OK)
        status = al_sweep_create(w->device, &w->grid, w->settings->directions, smallest_sigma(w),
                                 w->options->memory_limit, &w->sweep, error);
    al_steps_add(w->steps, "voxelise", started, 0, al_grid_count(&w->grid));
    return status;
}

static al_status compute_moment(work *w, al_checkpoint *checkpoint, al_error *error)
{
    double started = al_program_seconds();
    al_progress progress;
    al_status status = al_moment_begin(&w->sweep, &w->moment, error);
    if (status != AL_OK) return status;
    if (checkpoint->stage == STAGE_MOMENT) {
        uint64_t total_size = 3 * al_grid_count(&w->grid) * sizeof(float),
                 plane_size = 3 * w->moment.plane_size * sizeof(float);
        float *total = al_checkpoint_take(checkpoint, 0, total_size),
              *planes = al_checkpoint_take(checkpoint, 1, plane_size);
        if (total && planes) {
            memcpy(w->moment.total, total, total_size);
            memcpy(w->moment.planes, planes, plane_size);
            w->moment.axis = checkpoint->axis;
            w->moment.next = checkpoint->next;
        }
        free(total);
        free(planes);
    }
    w->stage = STAGE_MOMENT;
    w->sweep.seconds = 0;
    al_progress_begin(&progress, w->options->program, "optical depth");
    status = al_moment_run(&w->sweep, w->sigma_mean, &w->moment, &progress, error);
    if (status != AL_OK) return status;
    al_moment_finish(&w->sweep, &w->moment);
    al_progress_end(&progress);
    al_steps_add(w->steps, "optical depth", al_program_seconds() - w->sweep.seconds, 0,
                 al_grid_count(&w->grid) * w->settings->directions);
    al_steps_add(w->steps, "moment", started + w->sweep.seconds, 0, al_grid_count(&w->grid));
    return AL_OK;
}

/* Optical depth, moment and divergence; or what a cancelled bake left of them. */
static al_status compute_rho(work *w, al_checkpoint *checkpoint, al_error *error)
{
    uint64_t size = al_grid_count(&w->grid) * sizeof *w->rho;
    w->rho = checkpoint->stage == STAGE_SAMPLE ? al_checkpoint_take(checkpoint, 0, size) : NULL;
    if (w->rho) return AL_OK;
    al_status status = compute_moment(w, checkpoint, error);
    if (status != AL_OK) return status;
    double started = al_program_seconds();
    w->rho = malloc(size);
    if (!w->rho) return al_fail(error, AL_IO, "%s: out of memory for the divergence", w->object->name);
    status = al_divergence(w->device, &w->grid, w->moment.total, w->rho, error);
    al_moment_free(&w->moment);
    al_steps_add(w->steps, "divergence", started, 0, al_grid_count(&w->grid));
    return status;
}

typedef struct loss { /* of a voxel */
    float density, rho;
} loss;

static int compare_losses(const void *a, const void *b)
{
    float x = ((const loss *)a)->density, y = ((const loss *)b)->density;
    return (x > y) - (x < y);
}

/* The density above which the medium takes a quarter of the light that it takes. Along w the transmittance
 * grows by sigma_t psi, so div T = integral of w . grad psi dw = sigma_t integral of psi dw: what is lost at
 * a place that is lit from all sides, in the mean channel. That is at most 4 pi sigma_t, which holds down the
 * noise of differences in shadows. In an even medium the answer is its density; in an uneven one a dense
 * speck counts by its surface: little in smoke, all in nothing. */
static al_status upper_quarter(const work *w, double *density, al_error *error)
{
    size_t count = 0, total = al_grid_count(&w->grid);
    loss *losses = malloc((total + 1) * sizeof *losses);
    double lost = 0, above = 0;
    if (!losses) return al_fail(error, AL_IO, "%s: out of memory for its densities", w->object->name);
    for (size_t i = 0; i < total; i++) {
        if (!w->grid.inside[i]) continue;
        float most = (float)(4 * AL_PI * w->sigma_mean) * w->grid.density[i];
        losses[count] = (loss){w->grid.density[i], fminf(w->rho[i], most)};
        lost += losses[count++].rho;
    }
    qsort(losses, count, sizeof *losses, compare_losses);
    do above += losses[--count].rho;
    while (count > 0 && above < 0.25 * lost);
    *density = losses[count].density;
    free(losses);
    return AL_OK;
}

/* Light enters a dense medium by about one mean free path, and samples must be denser than that skin:
 * pictures of a sphere err by 4.5 % where the mean free path is two base radii, by an eighth at one, by
 * nearly half at a tenth (docs/accuracy.md). The densest channel decides. The count goes with the inverse
 * cube of r; a tenth is added because r is met only nearly. */
static const double radii_per_path = 2;

static al_status check_skin(const work *w, al_error *error)
{
    double density = 0, sigma_t = fmax(fmax(w->sigma_t[0], w->sigma_t[1]), w->sigma_t[2]);
    al_status status = upper_quarter(w, &density, error);
    if (status != AL_OK) return status;
    double extinction = sigma_t * density, radius = w->samples.radius_m;
    if (radii_per_path * extinction * radius <= 1) return AL_OK;
    double needed = ceil(1.1 * w->samples.count * pow(radii_per_path * extinction * radius, 3));
    if (w->settings->too_dense == AL_TOO_DENSE_REFUSE)
        return al_fail(
            error, AL_BAD_INPUT,
            "translucent '%s': its mean free path of %.3g m is less than two base radii of its "
            "samples, %.3g m each; \"samples\" of about %.0f in \"bake\", a thinner medium or an opaque "
            "mesh is right, or \"too_dense\": \"bake\" to have it wrong",
            w->object->name, 1 / extinction, radius, needed);
    al_program_say(w->options->program,
                   "translucent '%s' will look wrong: its mean free path of %.3g m is less than two base "
                   "radii of its samples, %.3g m each; about %.0f samples would resolve it",
                   w->object->name, 1 / extinction, radius, needed);
    return AL_OK;
}

static al_status place_samples(work *w, al_error *error)
{
    al_progress progress;
    al_sample_options options = {.count = w->settings->radius_m > 0 ? 0 : w->settings->samples,
                                 .radius_m = w->settings->radius_m,
                                 .seed = w->settings->seed,
                                 .threads = w->options->threads};
    double started = al_program_seconds();
    al_status status = al_tetrahedralise(w->object->name, &w->boundary, &w->tetrahedra, error);
    if (status != AL_OK) return status;
    if (w->blockers.triangle_count) status = al_solid_create(&w->blockers, &w->blocker_solid, error);
    if (status != AL_OK) return status;
    al_interior interior = {w->tetrahedra.points, w->tetrahedra.corners, w->tetrahedra.count,
                            w->blocker_solid};
    al_steps_add(w->steps, "tetrahedra", started, 0, interior.count);

    started = al_program_seconds();
    w->stage = STAGE_SAMPLE;
    al_progress_begin(&progress, w->options->program, "sample");
    status = al_sample_interior(w->object->name, &w->grid, w->rho, &interior, &options, &progress,
                                &w->samples, error);
    if (status != AL_OK) return status;
    al_progress_end(&progress);
    al_steps_add(w->steps, "sample", started, 0, w->samples.count);
    status = check_skin(w, error);
    if (status != AL_OK) return status;

    started = al_program_seconds();
    al_progress_begin(&progress, w->options->program, "gaussians");
    status = al_sample_gaussians(w->object->name, &w->grid, &interior, &w->field, &options, &progress,
                                 &w->samples, error);
    if (status != AL_OK) return status;
    al_progress_end(&progress);
    al_steps_add(w->steps, "gaussians", started, 0, w->samples.count);
    return AL_OK;
}

static uint64_t coefficient_bytes(const work *w)
{
    return (uint64_t)w->samples.count * w->channel_count * w->settings->sh_order * w->settings->sh_order *
           sizeof(float);
}

/* Puts back the samples and sums of a bake that was cancelled while projecting. */
static bool resume_projection(work *w, al_checkpoint *checkpoint, al_error *error)
{
    if (checkpoint->stage != STAGE_PROJECT) return false;
    uint32_t count = (uint32_t)checkpoint->numbers[0];
    w->samples = (al_samples){.count = count,
                              .radius_m = checkpoint->numbers[1],
                              .volume_m3 = checkpoint->numbers[2],
                              .rho_quantile = (float)checkpoint->numbers[3],
                              .unity_mean = (float)checkpoint->numbers[4],
                              .unity_deviation = (float)checkpoint->numbers[5],
                              .unity_worst = (float)checkpoint->numbers[6]};
    w->samples.positions = al_checkpoint_take(checkpoint, 0, 3 * (uint64_t)count * sizeof(float));
    w->samples.gaussians = al_checkpoint_take(checkpoint, 1, 4 * (uint64_t)count * sizeof(float));
    w->coefficients = al_checkpoint_take(checkpoint, 3, coefficient_bytes(w));
    bool good = w->samples.positions && w->samples.gaussians && w->coefficients &&
                al_project_begin(count, w->settings->sh_order, &w->project, error) == AL_OK;
    float *sums = good ? al_checkpoint_take(checkpoint, 2, w->project.sum_count * sizeof(float)) : NULL;
    if (!sums) {
        al_samples_free(&w->samples);
        free(w->coefficients);
        w->coefficients = NULL;
        al_project_free(&w->project);
        return false;
    }
    free(w->project.sums);
    w->project.sums = sums;
    w->project.axis = checkpoint->axis;
    w->project.next = checkpoint->next;
    w->channel = checkpoint->channel;
    return true;
}

static al_status project(work *w, al_error *error)
{
    uint32_t order = w->settings->sh_order, count = w->samples.count;
    size_t stride = (size_t)w->channel_count * order * order;
    double started = al_program_seconds();
    al_progress progress;
    al_status status = AL_OK;
    w->stage = STAGE_PROJECT;
    if (!w->coefficients) {
        w->coefficients = calloc(1, coefficient_bytes(w) + 1);
        if (!w->coefficients)
            return al_fail(error, AL_IO, "%s: out of memory for coefficients", w->object->name);
        status = al_project_begin(count, order, &w->project, error);
    }
    al_progress_begin(&progress, w->options->program, "project");
    while (status == AL_OK && w->channel < w->channel_count) {
        double sigma = w->channel_count == 1 ? w->sigma_mean : w->sigma_t[w->channel];
        status = al_project_run(&w->sweep, sigma, order, w->samples.positions, count, &w->project, &progress,
                                error);
        if (status != AL_OK) break;
        al_project_finish(&w->project, w->settings->directions, order, count,
                          w->coefficients + (size_t)w->channel * order * order, stride);
        al_project_free(&w->project);
        w->channel++;
        if (w->channel < w->channel_count) status = al_project_begin(count, order, &w->project, error);
    }
    if (status != AL_OK) return status;
    al_progress_end(&progress);
    al_steps_add(w->steps, "project", started, 0,
                 (uint64_t)count * w->settings->directions * w->channel_count);
    return AL_OK;
}

static void keep_partial(const work *w)
{
    al_checkpoint c = {.key = w->key, .stage = w->stage, .channel = w->channel};
    if (w->stage == STAGE_MOMENT) {
        c.axis = w->moment.axis;
        c.next = w->moment.next;
        c.arrays[0].data = w->moment.total;
        c.arrays[0].size = 3 * al_grid_count(&w->grid) * sizeof(float);
        c.arrays[1].data = w->moment.planes;
        c.arrays[1].size = 3 * w->moment.plane_size * sizeof(float);
    } else if (w->stage == STAGE_SAMPLE) {
        c.arrays[0].data = w->rho;
        c.arrays[0].size = al_grid_count(&w->grid) * sizeof(float);
    } else if (w->stage == STAGE_PROJECT && w->project.sums) {
        double numbers[] = {w->samples.count,        w->samples.radius_m,   w->samples.volume_m3,
                            w->samples.rho_quantile, w->samples.unity_mean, w->samples.unity_deviation,
                            w->samples.unity_worst};
        memcpy(c.numbers, numbers, sizeof numbers);
        c.axis = w->project.axis;
        c.next = w->project.next;
        c.arrays[0].data = w->samples.positions;
        c.arrays[0].size = 3 * (uint64_t)w->samples.count * sizeof(float);
        c.arrays[1].data = w->samples.gaussians;
        c.arrays[1].size = 4 * (uint64_t)w->samples.count * sizeof(float);
        c.arrays[2].data = w->project.sums;
        c.arrays[2].size = w->project.sum_count * sizeof(float);
        c.arrays[3].data = w->coefficients;
        c.arrays[3].size = coefficient_bytes(w);
    } else {
        return;
    }
    /* What cannot be kept costs time on the next run, nothing else. */
    al_checkpoint_write(w->partial_path, &c, NULL);
}

/* The unit of the stored density, of which 65535 steps count. A voxel of optical depth 16 is opaque, and no
 * more can be seen of a denser one; but as the unit it would leave nothing of the thin voxels beside it. With
 * 16 a step is 2.4e-4 of optical depth. */
static float density_unit(const work *w)
{
    static const double opaque = 16;
    return (float)fmin(w->grid.density_max, opaque / (smallest_sigma(w) * w->grid.voxel_m));
}

static void describe(const work *w, al_translucent_info *info)
{
    const al_medium *m = w->medium;
    *info = (al_translucent_info){.sample_count = w->samples.count,
                                  .order = w->settings->sh_order,
                                  .channel_count = w->channel_count,
                                  .format = w->settings->coefficient_format,
                                  .direction_count = w->settings->directions,
                                  .voxel_m = (float)w->grid.voxel_m,
                                  .density_max = density_unit(w),
                                  .g = m->g,
                                  .ior = 1,
                                  .volume_m3 = w->samples.volume_m3,
                                  .radius_m = w->samples.radius_m,
                                  .rho_quantile = w->samples.rho_quantile,
                                  .unity_mean = w->samples.unity_mean,
                                  .unity_deviation = w->samples.unity_deviation,
                                  .unity_worst = w->samples.unity_worst,
                                  .has_blockers = w->grid.blockers != NULL};
    for (int i = 0; i < 3; i++) {
        info->grid_size[i] = w->grid.size[i];
        info->grid_origin_m[i] = (float)w->grid.origin_m[i];
        info->sigma_s_per_m[i] = m->sigma_s_per_m[i];
        info->sigma_a_per_m[i] = m->sigma_a_per_m[i];
        info->bounds_min_m[i] = INFINITY;
        info->bounds_max_m[i] = -INFINITY;
    }
    for (uint32_t v = 0; v < 3 * w->boundary.vertex_count; v++) {
        info->bounds_min_m[v % 3] = fminf(info->bounds_min_m[v % 3], (float)w->boundary.positions[v]);
        info->bounds_max_m[v % 3] = fmaxf(info->bounds_max_m[v % 3], (float)w->boundary.positions[v]);
    }
}

/* Adds the asset's measured error, its texts in `settings` (160 bytes are enough). */
static al_status measure(const work *w, al_translucent_data *data, al_measured *measured, char *settings, size_t size,
                         al_error *error)
{
    static const char *const formats[] = {"float", "half", "byte"};
    const al_measured_object object = {.import = w->import,
                                       .index = w->index,
                                       .boundary = &w->boundary,
                                       .blockers = &w->blockers,
                                       .seed = w->settings->seed,
                                       .threads = w->options->threads};
    double started = al_program_seconds();
    al_measure sums = {0};
    al_status status = al_measure_object(&object, data, &sums, error);
    if (status != AL_OK) return status;
    snprintf(settings, size, "%u directions, %u samples, order %u, %u voxels, %s coefficients",
             w->settings->directions, w->samples.count, w->settings->sh_order, w->settings->grid_resolution,
             formats[data->info.format]);
    if (sums.count) {
        *measured = al_measure_result(&sums,
                                      "transmittance at random points towards random directions with a march through "
                                      "the density in double precision",
                                      settings, "");
        data->measured = measured;
        data->measured_count = 1;
    }
    al_steps_add(w->steps, "measure", started, 0, sums.count);
    return AL_OK;
}

static al_status write_asset(work *w, al_error *error)
{
    double started = al_program_seconds();
    size_t count = al_grid_count(&w->grid);
    uint64_t bytes = 0;
    char provenance[512], settings[160];
    al_measured measured;
    al_status status;
    al_translucent_data data = {.positions = w->samples.positions,
                                .gaussians = w->samples.gaussians,
                                .coefficients = w->coefficients,
                                .provenance_json = provenance};
    uint16_t *density = malloc(count * sizeof *density);
    uint8_t *blockers = w->grid.blockers ? malloc(count) : NULL;
    describe(w, &data.info);
    snprintf(provenance, sizeof provenance,
             "{\"key\":\"%016llx\",\"directions\":%u,\"grid_resolution\":%u,\"samples\":%u,\"radius_m\":%.9g,"
             "\"sh_order\":%u,\"seed\":%u}",
             (unsigned long long)w->key, w->settings->directions, w->settings->grid_resolution,
             w->settings->samples, w->settings->radius_m, w->settings->sh_order, w->settings->seed);
    if (!density || (w->grid.blockers && !blockers)) {
        status = al_fail(error, AL_IO, "%s: out of memory", w->path);
        goto cleanup;
    }
    for (size_t i = 0; i < count; i++) {
        density[i] = (uint16_t)lrintf(65535 * fminf(w->grid.density[i] / data.info.density_max, 1));
        if (blockers) blockers[i] = (uint8_t)lrintf(255 * fminf(w->grid.blockers[i], 1));
    }
    data.density = density;
    data.blockers = blockers;
    status = measure(w, &data, &measured, settings, sizeof settings, error);
    started = al_program_seconds();
    if (status == AL_OK) status = al_translucent_write(w->path, &data, &bytes, error);
    al_steps_add(w->steps, "write", started, bytes, w->samples.count);
cleanup:
    free(density);
    free(blockers);
    return status;
}

static al_status run_steps(work *w, al_error *error)
{
    al_checkpoint checkpoint;
    al_status status = voxelise(w, error);
    if (status != AL_OK) return status;
    al_checkpoint_read(w->partial_path, w->key, &checkpoint);
    if (!resume_projection(w, &checkpoint, error)) {
        status = compute_rho(w, &checkpoint, error);
        if (status == AL_OK) status = place_samples(w, error);
    }
    al_checkpoint_free(&checkpoint);
    if (status == AL_OK) status = project(w, error);
    if (status == AL_OK) status = write_asset(w, error);
    return status;
}

al_status al_bake_object(const al_import *import, uint32_t index, uint64_t key, al_device *device,
                         const al_bake_options *options, al_steps *steps, al_error *error)
{
    work *w = calloc(1, sizeof *w);
    char file[160];
    if (!w) return al_fail(error, AL_IO, "out of memory");
    w->import = import;
    w->index = index;
    w->object = &import->scene.translucents[index];
    w->medium = &import->scene.media[w->object->medium];
    w->settings = &import->description->bake;
    w->options = options;
    w->device = device;
    w->steps = steps;
    w->key = key;
    al_bake_object_file(w->object, file, sizeof file);
    snprintf(w->path, sizeof w->path, "%s/%s", options->folder, file);
    snprintf(w->partial_path, sizeof w->partial_path, "%s.partial", w->path);
    choose_channels(w);
    al_status status = load_surfaces(import, index, &w->boundary, &w->blockers, error);
    if (status == AL_OK) status = run_steps(w, error);
    if (status == AL_CANCELLED) keep_partial(w);
    if (status == AL_OK) unlink(w->partial_path);

    al_triangles_free(&w->boundary);
    al_triangles_free(&w->blockers);
    al_solid_free(w->blocker_solid);
    al_tetrahedra_free(&w->tetrahedra);
    al_grid_free(&w->grid);
    if (w->sweep.device) al_sweep_free(&w->sweep);
    al_moment_free(&w->moment);
    al_project_free(&w->project);
    al_samples_free(&w->samples);
    free(w->rho);
    free(w->coefficients);
    free(w);
    return status;
}
