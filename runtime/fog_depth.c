/* Baked optical depths of the fogs as one texture, for legs.glsl: texels of four coefficients stand side by side along x,
 * those of odd bands first, the fogs one after the other along z. Made when it is asked for; of a sequence the frame that
 * is shown is uploaded when it changes. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "matrix.h"
#include "state.h"

enum { TERM_ROOM = AL_DEPTH_TERMS_LIMIT + 6 };

/* Which coefficient each channel takes: odd bands, then even ones, both filled up to whole texels by -1. */
static int channel_list(uint32_t order, int terms[TERM_ROOM])
{
    int count = 0;
    for (uint32_t parity = 2; parity-- > 0;) {
        for (uint32_t l = parity; l < order; l += 2)
            for (uint32_t k = l * l; k < (l + 1) * (l + 1); k++) terms[count++] = (int)k;
        while (count % 4) terms[count++] = -1;
    }
    return count;
}

static al_status fit_texture(al_runtime *runtime, uint32_t order, al_error *error)
{
    al_fogs *fogs = &runtime->fogs;
    int terms[TERM_ROOM];
    uint32_t size[3] = {0}, texels = (uint32_t)channel_list(order, terms) / 4;
    GLint most = 0;
    GLuint before = fogs->depth.id;
    for (uint32_t i = 0; i < runtime->scene.fog_count; i++) {
        const al_medium_depth *depth = &fogs->media[i].depth;
        for (int k = 0; k < 2; k++) size[k] = size[k] > depth->size[k] ? size[k] : depth->size[k];
        fogs->media[i].depth_slice = (int32_t)size[2];
        size[2] += depth->size[2];
    }
    glGetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &most);
    if (size[0] * texels > (uint32_t)most || size[2] > (uint32_t)most)
        return al_fail(error, AL_BAD_INPUT,
                       "fogs: their optical depths, %u points of %u texels by %u slices, are more than this OpenGL's textures "
                       "hold, %d along an edge", size[0], texels, size[2], most);
    al_status status = al_gl_texture_fit(&runtime->memory, GL_TEXTURE_3D, GL_RGBA16F, size[0] * texels, size[1], size[2],
                                         &fogs->depth, error);
    if (status || fogs->depth.id == before) return status;
    glTextureParameteri(fogs->depth.id, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(fogs->depth.id, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    fogs->depth_stride = (int32_t)size[0];
    for (uint32_t i = 0; i < runtime->scene.fog_count; i++) fogs->media[i].depths_uploaded = NULL;
    return AL_OK;
}

static al_status upload(const al_fogs *fogs, al_fog_medium *medium, uint32_t order, al_error *error)
{
    const al_medium_depth *depth = &medium->depth;
    size_t points = (size_t)depth->size[0] * depth->size[1] * depth->size[2];
    int terms[TERM_ROOM], count = channel_list(order, terms);
    if (medium->depths_uploaded == medium->depths) return AL_OK;
    uint16_t *texels = malloc(points * 4 * sizeof *texels);
    if (!texels) return al_fail(error, AL_IO, "no memory for the optical depths of a fog");
    for (int first = 0; first < count; first += 4) {
        for (size_t i = 0; i < 4 * points; i++) {
            int term = terms[first + (int)(i % 4)];
            texels[i] = term < 0 || term >= (int)(depth->order * depth->order) ? 0 : medium->depths[(size_t)term * points + i / 4];
        }
        glTextureSubImage3D(fogs->depth.id, 0, first / 4 * fogs->depth_stride, 0, medium->depth_slice, (GLsizei)depth->size[0],
                            (GLsizei)depth->size[1], (GLsizei)depth->size[2], GL_RGBA, GL_HALF_FLOAT, texels);
    }
    free(texels);
    medium->depths_uploaded = medium->depths;
    return AL_OK;
}

/* The lattice's place, moved with the fog, and what a stored 1 stands for where the fog's sigma_t is of density
 * density_max / AL_MEDIUM_UNIT. */
static void fill(const al_fog *fog, const al_fog_medium *medium, al_leg_depth *entry)
{
    double share[16] = {[15] = 1}, moved[16], back[16];
    for (int k = 0; k < 3; k++) {
        double low = medium->info.bounds_min_m[k], edge = medium->info.bounds_max_m[k] - low;
        share[5 * k] = 1 / edge;
        share[12 + k] = -low / edge;
        entry->edge[k] = (float)edge;
        entry->size[k] = (int32_t)medium->depth.size[k];
    }
    al_matrix_from_float(fog->moved, moved);
    if (al_matrix_inverse(moved, back)) al_matrix_multiply(share, back, share);
    al_matrix_to_float(share, entry->to_share);
    entry->edge[3] = (float)(al_medium_depth_unit_m(&medium->info, AL_MEDIUM_UNIT));
    entry->size[3] = medium->depth_slice;
}

al_status al_fog_depth_run(al_draw *draw, al_legs_block *block, uint32_t *order)
{
    al_runtime *runtime = draw->runtime;
    al_fogs *fogs = &runtime->fogs;
    al_status status = AL_OK;
    *order = 0;
    for (int32_t i = 0; i < fogs->block.counts[0]; i++) {
        const al_fog *fog = &runtime->scene.fogs[fogs->shown[i]];
        const al_fog_medium *medium = &fogs->media[fogs->shown[i]];
        if (!fogs->block.fogs[i].cells[0]) continue;
        if (!medium->depth.size[0])
            return al_fail(draw->error, AL_BAD_INPUT,
                           "%s: medium \"%s\" keeps no optical depths for a second leg by baked ones; give it "
                           "\"optical_depth_order\": 5 in the scene file and bake again, or march the leg",
                           fog->asset, runtime->scene.media[fog->medium].name);
        if (*order < medium->depth.order) *order = medium->depth.order;
    }
    if (*order) status = fit_texture(runtime, *order, draw->error);
    for (int32_t i = 0; i < fogs->block.counts[0] && !status; i++) {
        al_fog_medium *medium = &fogs->media[fogs->shown[i]];
        if (!fogs->block.fogs[i].cells[0]) continue;
        status = upload(fogs, medium, *order, draw->error);
        fill(&runtime->scene.fogs[fogs->shown[i]], medium, &block->depths[i]);
    }
    return status;
}

bool al_runtime_keeps_depths(const al_runtime *runtime)
{
    bool any = false;
    for (uint32_t i = 0; runtime->loaded && i < runtime->scene.fog_count; i++) {
        const al_fog_medium *medium = &runtime->fogs.media[i];
        bool gridded = medium->present && (medium->info.size[0] > 1 || medium->info.size[1] > 1 || medium->info.size[2] > 1);
        if (gridded && !medium->depth.size[0]) return false;
        any = any || gridded;
    }
    return any;
}
