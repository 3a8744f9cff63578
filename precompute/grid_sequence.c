#include "grid_sequence.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "geometry.h"

enum { PATH_ROOM = 4096 };

struct al_grid_sequence {
    const al_import *import;
    const al_medium_description *medium;
    al_density *frame; /* the one in memory, `index` */
    uint32_t index;
    double lattice[16], to_lattice[16]; /* the first frame's index space to the world, and back */
    int64_t low[3], high[3];            /* box of all frames on the lattice, high not included */
    float *times_s;
};

static al_status open_frame(al_grid_sequence *s, uint32_t index, al_error *error)
{
    char path[PATH_ROOM];
    al_medium_description medium = *s->medium;
    if (s->frame && s->index == index) return AL_OK;
    al_density_free(s->frame);
    s->frame = NULL;
    al_density_frame_file(&medium.density, index, path, sizeof path);
    medium.density.file = path;
    s->index = index;
    return al_density_open(s->import->description, &medium, &s->frame, error);
}

/* Where on the lattice the frame in memory begins; its voxels must be the lattice's. */
static al_status place_frame(const al_grid_sequence *s, al_density_voxels *voxels, int64_t begin[3], al_error *error)
{
    const double tolerance = 0.01; /* voxels, at the far end of the box */
    double relative[16];
    char path[PATH_ROOM];
    bool same = true;
    al_density_grid(s->frame, voxels);
    al_matrix_multiply(s->to_lattice, voxels->index_to_world, relative);
    for (int k = 0; k < 3; k++) {
        begin[k] = llround(relative[12 + k]);
        same = same && fabs(relative[12 + k] - (double)begin[k]) < tolerance && llabs(begin[k]) < INT32_MAX;
        for (int i = 0; i < 3; i++) same = same && fabs(relative[4 * i + k] - (i == k)) * voxels->size[i] < tolerance;
    }
    if (same) return AL_OK;
    al_density_frame_file(&s->medium->density, s->index, path, sizeof path);
    return al_fail(error, AL_BAD_INPUT,
                   "medium \"%s\" (line %d): the voxels of %s are not those of the first frame; one size and one lattice "
                   "for all frames are right",
                   s->medium->name, s->medium->line, path);
}

static al_status measure(al_grid_sequence *s, uint32_t frame_count, al_error *error)
{
    al_density_voxels voxels;
    int64_t begin[3];
    al_status status = AL_OK;
    for (uint32_t f = 0; f < frame_count && status == AL_OK; f++) {
        status = open_frame(s, f, error);
        if (status == AL_OK) status = place_frame(s, &voxels, begin, error);
        for (int k = 0; k < 3 && status == AL_OK; k++) {
            int64_t end = begin[k] + voxels.size[k];
            s->low[k] = f && s->low[k] < begin[k] ? s->low[k] : begin[k];
            s->high[k] = f && s->high[k] > end ? s->high[k] : end;
        }
    }
    return status;
}

static al_status slice(void *user, uint32_t frame, uint32_t z, float *density, al_error *error)
{
    al_grid_sequence *s = user;
    al_density_voxels voxels;
    int64_t begin[3];
    size_t width = (size_t)(s->high[0] - s->low[0]), height = (size_t)(s->high[1] - s->low[1]);
    al_status status = open_frame(s, frame, error);
    if (status == AL_OK) status = place_frame(s, &voxels, begin, error);
    if (status != AL_OK) return status;
    memset(density, 0, width * height * sizeof *density);
    int64_t layer = s->low[2] + z - begin[2];
    for (size_t y = 0; y < voxels.size[1] && layer >= 0 && layer < voxels.size[2]; y++) {
        const float *from = voxels.values + ((size_t)layer * voxels.size[1] + y) * voxels.size[0];
        float *to = density + ((size_t)(begin[1] - s->low[1]) + y) * width + (size_t)(begin[0] - s->low[0]);
        for (uint32_t x = 0; x < voxels.size[0]; x++) to[x] = (float)(voxels.scale * from[x]);
    }
    return AL_OK;
}

/* Bounds that the scene file does not give are those of the box. */
static void fill_info(const al_grid_sequence *s, al_medium_info *info)
{
    double corner[3] = {(double)s->low[0], (double)s->low[1], (double)s->low[2]};
    al_matrix_point(s->lattice, corner, corner);
    for (int k = 0; k < 3; k++) {
        info->size[k] = (uint32_t)(s->high[k] - s->low[k]);
        info->grid_to_world[12 + k] = (float)corner[k];
    }
    for (int i = 0; i < 8 && !info->extended; i++) {
        double point[3];
        for (int k = 0; k < 3; k++) point[k] = (double)(i >> k & 1 ? s->high[k] : s->low[k]) - 0.5;
        al_matrix_point(s->lattice, point, point);
        for (int k = 0; k < 3; k++) {
            info->bounds_min_m[k] = fminf(info->bounds_min_m[k], (float)point[k]);
            info->bounds_max_m[k] = fmaxf(info->bounds_max_m[k], (float)point[k]);
        }
    }
    info->frame_count = s->medium->density.frame_count;
}

al_status al_grid_sequence_open(const al_import *import, const al_medium_description *medium, al_medium_data *data,
                                al_grid_sequence **sequence, al_error *error)
{
    const al_density_description *density = &medium->density;
    al_density_voxels voxels;
    *sequence = NULL;
    al_grid_sequence *s = calloc(1, sizeof *s);
    if (!s) return al_fail(error, AL_IO, "out of memory for the frames of \"%s\"", medium->name);
    s->import = import;
    s->medium = medium;
    s->times_s = calloc(density->frame_count, sizeof *s->times_s);
    al_status status =
        s->times_s ? open_frame(s, 0, error) : al_fail(error, AL_IO, "out of memory for the frames of \"%s\"", medium->name);
    if (status == AL_OK) {
        al_density_grid(s->frame, &voxels);
        memcpy(s->lattice, voxels.index_to_world, sizeof s->lattice);
        al_matrix_invert(s->lattice, s->to_lattice);
        status = measure(s, density->frame_count, error);
    }
    if (status != AL_OK) {
        al_grid_sequence_close(s);
        return status;
    }
    for (uint32_t f = 0; f < density->frame_count; f++) s->times_s[f] = (float)(f / density->frames_per_second);
    fill_info(s, &data->info);
    data->times_s = s->times_s;
    data->slice = slice;
    data->user = s;
    *sequence = s;
    return AL_OK;
}

void al_grid_sequence_close(al_grid_sequence *s)
{
    if (!s) return;
    al_density_free(s->frame);
    free(s->times_s);
    free(s);
}

void al_grid_sequence_hash(XXH64_state_t *state, const al_import *import, const al_density_description *density)
{
    for (uint32_t f = 1; f < density->frame_count; f++) {
        char path[PATH_ROOM];
        double time_s = f / density->frames_per_second;
        al_density_frame_file(density, f, path, sizeof path);
        XXH64_update(state, &time_s, sizeof time_s);
        for (uint32_t i = 0; i < import->input_count; i++)
            if (!strcmp(import->inputs[i].path, path))
                XXH64_update(state, &import->inputs[i].xxh64, sizeof(uint64_t));
    }
}
