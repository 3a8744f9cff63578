#include "readback.h"

#include <epoxy/gl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

readback readback_take(const al_runtime *runtime)
{
    const al_gl_texture *geometry = &runtime->targets.geometry;
    readback r = {.fogs = runtime->fogs.block, .width = geometry->width, .height = geometry->height};
    size_t texels = (size_t)r.width * r.height;
    r.surfel_count = (uint32_t)al_surfels_count(runtime);
    r.surfels = malloc((r.surfel_count + 1) * sizeof *r.surfels);
    r.geometry = malloc(texels * 16);
    glGetNamedBufferSubData(runtime->surfels.cloud.id, 0, (GLsizeiptr)(r.surfel_count * sizeof *r.surfels), r.surfels);
    glGetNamedBufferSubData(runtime->frame_block.id, 0, sizeof r.frame, &r.frame);
    if (runtime->scene.fog_count && runtime->fogs.media[0].present) {
        const al_fog_medium *medium = &runtime->fogs.media[0];
        r.grid_unit = (double)medium->frame.density_max / AL_MEDIUM_UNIT;
        for (int k = 0; k < 3; k++) {
            r.grid_low[k] = medium->info.grid_to_world[12 + k];
            r.grid_voxel[k] = medium->info.grid_to_world[5 * k];
        }
    }
    glGetTextureImage(geometry->id, 0, GL_RGBA, GL_FLOAT, (GLsizei)(texels * 16), r.geometry);
    return r;
}

void readback_free(readback *r)
{
    free(r->surfels);
    free(r->geometry);
}

ray readback_ray(const al_frame_block *frame, double x, double y)
{
    ray r;
    double length = 0;
    for (int k = 0; k < 3; k++) {
        r.origin[k] = frame->ray[0][k] + x * frame->ray[1][k] + y * frame->ray[2][k];
        r.direction[k] = frame->ray[3][k] + x * frame->ray[4][k] + y * frame->ray[5][k];
        length += r.direction[k] * r.direction[k];
    }
    for (int k = 0; k < 3; k++) r.direction[k] /= sqrt(length);
    return r;
}

bool readback_clip(const al_fog_entry *fog, const ray *r, double to, double span[2])
{
    span[0] = 0;
    span[1] = to;
    for (int k = 0; k < 3 && fog->low[3] > 0; k++) {
        double low = (double)fog->low[k] - r->origin[k], high = low + fog->extent[k];
        if (r->direction[k] == 0) {
            if (low > 0 || high < 0) return false;
            continue;
        }
        double a = low / r->direction[k], b = high / r->direction[k];
        span[0] = fmax(span[0], fmin(a, b));
        span[1] = fmin(span[1], fmax(a, b));
    }
    return span[0] < span[1];
}

double readback_density(const readback *r, int32_t i, const ray *along, double t)
{
    double place[3];
    if (!r->fogs.fogs[i].cells[0]) return 1;
    for (int k = 0; k < 3; k++) place[k] = along->origin[k] + t * along->direction[k];
    return al_medium_evaluate(r->field, place, 0) / r->grid_unit;
}

/* Between planes through voxel centres a trilinear density is a cubic along a ray, which two places of Gauss integrate
 * exactly. */
static double grid_depth(const readback *r, int32_t i, const ray *along, const double span[2])
{
    double sum = 0, t = span[0];
    while (t < span[1]) {
        double next = span[1];
        for (int k = 0; k < 3; k++) {
            double speed = along->direction[k] / r->grid_voxel[k];
            if (speed == 0) continue;
            double index = (along->origin[k] - r->grid_low[k]) / r->grid_voxel[k] + t * speed;
            double plane = speed > 0 ? floor(index + 1e-9) + 1 : ceil(index - 1e-9) - 1;
            next = fmin(next, t + (plane - index) / speed);
        }
        double middle = 0.5 * (t + next), half = 0.5 * (next - t), off = half / sqrt(3.0);
        sum += half * (readback_density(r, i, along, middle - off) + readback_density(r, i, along, middle + off));
        t = next;
    }
    return sum;
}

void readback_depth(const readback *r, const ray *along, double to, double tau[3])
{
    memset(tau, 0, 3 * sizeof *tau);
    for (int32_t i = 0; i < r->fogs.counts[0]; i++) {
        const al_fog_entry *fog = &r->fogs.fogs[i];
        double span[2];
        if (!readback_clip(fog, along, to, span)) continue;
        double length = fog->cells[0] ? grid_depth(r, i, along, span) : span[1] - span[0];
        for (int c = 0; c < 3; c++) tau[c] += fog->sigma_t[c] * length;
    }
}
