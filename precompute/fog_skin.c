/* A voxel of optical depth tau takes 1 - exp(-tau) of the light that crosses it, and scatters as much. Where tau is large
 * that comes from a skin of a tau-th of the voxel, which neither the view's march nor the second leg's resolves: a grid of
 * zeros but for one voxel of 200 mean free paths is lit 3 % too brightly by surfaces, some places of it 12 %, and one of
 * 200 000 by 41 % (docs/accuracy.md). Beside haze such a voxel is little of the picture. */
#include "fog_skin.h"

#include <math.h>

static const double thick_depth = 200, thick_share = 0.25;

static al_status too_dense(al_fog_skin *skin, al_error *error)
{
    static const char text[] = "medium \"%s\" (line %d): voxels thicker than %g mean free paths stop %.0f %% of its light, in a "
                               "skin too thin for its grid; a finer grid, a thinner medium or an opaque mesh is right, %s";
    double percent = 100 * skin->thick / skin->stopped;
    if (skin->refuses)
        return al_fail(error, AL_BAD_INPUT, text, skin->medium->name, skin->medium->line, thick_depth, percent,
                       "or \"too_dense\": \"bake\" in \"bake\" to have light of surfaces in it wrong");
    if (!skin->said)
        al_program_say(skin->program, text, skin->medium->name, skin->medium->line, thick_depth, percent,
                       "light of surfaces in it will look wrong");
    skin->said = true;
    return AL_OK;
}

static al_status watched_slice(void *user, uint32_t frame, uint32_t z, float *density, al_error *error)
{
    al_fog_skin *skin = user;
    const uint32_t *size = skin->inner.info.size;
    al_status status = skin->inner.slice(skin->inner.user, frame, z, density, error);
    if (status) return status;
    if (z == 0) skin->stopped = skin->thick = 0;
    for (size_t i = 0; i < (size_t)size[0] * size[1]; i++) {
        double tau = skin->depth * (double)density[i], share = -expm1(-tau);
        skin->stopped += share;
        if (tau > thick_depth) skin->thick += share;
    }
    return z + 1 == size[2] && skin->thick > thick_share * skin->stopped ? too_dense(skin, error) : AL_OK;
}

static bool has_surfaces(const al_scene *scene)
{
    for (uint32_t i = 0; i < scene->instance_count; i++)
        if (scene->instances[i].role == AL_ROLE_OPAQUE) return true;
    return false;
}

bool al_fog_skin_refuses(const al_import *import)
{
    return has_surfaces(&import->scene) && import->description->bake.too_dense == AL_TOO_DENSE_REFUSE;
}

void al_fog_skin_watch(const al_import *import, uint32_t fog, const al_bake_options *options, al_medium_data *data,
                       al_fog_skin *skin)
{
    const float *m = data->info.grid_to_world;
    double sigma_t = 0, volume = 0;
    if (!has_surfaces(&import->scene)) return;
    for (int k = 0; k < 3; k++) {
        int a = (k + 1) % 3, b = (k + 2) % 3;
        sigma_t = fmax(sigma_t, (double)data->info.sigma_s_per_m[k] + (double)data->info.sigma_a_per_m[k]);
        volume += (double)m[k] * ((double)m[4 + a] * (double)m[8 + b] - (double)m[4 + b] * (double)m[8 + a]);
    }
    *skin = (al_fog_skin){.medium = &import->description->media[import->scene.fogs[fog].medium],
                          .program = options->program,
                          .refuses = al_fog_skin_refuses(import),
                          .inner = *data,
                          .depth = sigma_t * cbrt(fabs(volume))};
    data->slice = watched_slice;
    data->user = skin;
}
