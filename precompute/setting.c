#include "setting.h"

bool al_setting_at(al_scene_description *d, int index, al_setting *setting)
{
    const al_setting settings[] = {{"bake.samples", &d->bake.samples, 10000000},
                                   {"bake.directions", &d->bake.directions, 4096},
                                   {"bake.sh_order", &d->bake.sh_order, 8},
                                   {"bake.grid_resolution", &d->bake.grid_resolution, 512},
                                   {"lightmap.samples", &d->lightmap.samples, 10000000},
                                   {"lightmap.bounces", &d->lightmap.bounces, 1000},
                                   {"lightmap.fog_points", &d->lightmap.fog_points, 64},
                                   {"probes.samples", &d->probes.samples, 10000000}};
    if (index < 0 || index >= (int)(sizeof settings / sizeof *settings)) return false;
    *setting = settings[index];
    return true;
}
