/* In place of the passes of media, translucent objects and light between surfaces, where AIRLIGHT_SURFACES_ONLY leaves them
 * out: scenes and settings that need one are refused, all others draw as in the whole runtime. */
#include "state.h"

static al_status refuse(al_draw *draw)
{
    return al_fail(draw->error, AL_USAGE, "settings: this build draws surfaces alone; another without AIRLIGHT_SURFACES_ONLY "
                   "shows what the fog, translucent objects or other surfaces add");
}

/* Called once for every scene that is loaded. */
al_status al_fog_create(al_runtime *runtime, al_error *error)
{
    const al_scene *scene = &runtime->scene;
    if (!scene->fog_count && !scene->translucent_count) return AL_OK;
    return al_fail(error, AL_BAD_INPUT, "scene.air: %u fogs and %u translucent objects; this build draws surfaces alone, use one "
                   "without AIRLIGHT_SURFACES_ONLY", scene->fog_count, scene->translucent_count);
}

/* Nothing of these arrives. */
al_status al_object_accept(al_runtime *runtime, const al_arrival *arrival, uint64_t *budget, bool *done, al_error *error)
{
    return AL_OK;
}

al_status al_fog_accept(al_runtime *runtime, const al_arrival *arrival, uint64_t *budget, bool *done, al_error *error)
{
    return AL_OK;
}

void al_fog_fail(al_runtime *runtime, uint32_t index) {}
void al_object_free(al_runtime *runtime, al_object *object) {}
void al_fog_free(al_runtime *runtime) {}
void al_fog_follow(al_runtime *runtime) {}
void al_history_free(al_runtime *runtime) {}
void al_surfels_free(al_runtime *runtime) {}
void al_shells_sweep(al_runtime *runtime) {}
void al_bounce_sweep(al_runtime *runtime) {}
void al_legs_sweep(al_runtime *runtime) {}
bool al_fog_is_current(const al_runtime *runtime) { return true; }
bool al_fog_sky_exists(const al_runtime *runtime) { return false; }
bool al_runtime_keeps_depths(const al_runtime *runtime) { return false; }
uint64_t al_fog_bytes(const al_runtime *runtime) { return 0; }
uint64_t al_fog_grid_bytes(const al_runtime *runtime) { return 0; }
uint64_t al_fog_sky_bytes(const al_runtime *runtime) { return 0; }
uint64_t al_interval_map_bytes(const al_runtime *runtime) { return 0; }
uint64_t al_shells_bytes(const al_runtime *runtime) { return 0; }
uint64_t al_bounce_bytes(const al_runtime *runtime) { return 0; }
uint64_t al_bounce_surface_bytes(const al_runtime *runtime) { return 0; }
uint64_t al_history_bytes(const al_runtime *runtime) { return 0; }
uint64_t al_surfels_bytes(const al_runtime *runtime) { return 0; }
uint64_t al_surfels_count(const al_runtime *runtime) { return 0; }
const char *al_fog_define(const al_draw *draw) { return ""; }
al_carrier al_bounce_carrier(const al_draw *draw, al_bounce_effect effect) { return AL_CARRIER_SCREEN; }

/* Every frame. */
void al_objects_prepare(al_draw *draw) {}
void al_fog_prepare(al_draw *draw) {}
al_status al_history_begin(al_draw *draw) { return AL_OK; }
void al_history_end(al_draw *draw) {}
al_status al_surfels_run(al_draw *draw) { return draw->needs_surfels ? refuse(draw) : AL_OK; }
al_status al_fog_draw(al_draw *draw) { return draw->settings.pass == AL_PASS_DIRECT_SCATTERING ? refuse(draw) : AL_OK; }

/* Only of what has been refused. */
al_status al_fog_draw_front(al_draw *draw) { return refuse(draw); }
al_status al_interval_map_run(al_draw *draw) { return refuse(draw); }
al_status al_shells_prepare(al_draw *draw) { return refuse(draw); }
al_status al_shells_draw(al_draw *draw) { return refuse(draw); }
al_status al_shells_gather(al_draw *draw) { return refuse(draw); }
al_status al_shells_gather_front(al_draw *draw) { return refuse(draw); }
al_status al_bounce_medium(al_draw *draw) { return refuse(draw); }
al_status al_bounce_inspect(al_draw *draw) { return refuse(draw); }
al_status al_surfels_show(al_draw *draw) { return refuse(draw); }
al_status al_bounce_surface(al_draw *draw, al_bounce_effect effect) { return refuse(draw); }
al_status al_splat_draw(al_draw *draw, al_object *object) { return refuse(draw); }
al_status al_light_run(al_draw *draw, al_object *object) { return refuse(draw); }
al_status al_intervals_run(al_draw *draw, al_object *object, const int32_t area[4]) { return refuse(draw); }
al_status al_span_run(al_draw *draw, al_stage stage, const al_shell_block *block, al_gl_texture *span, const char *choice)
{
    return refuse(draw);
}
