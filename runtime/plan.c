/* Which passes the loaded scene needs and which not, and why. */
#include "state.h"

static uint64_t target_bytes(const al_runtime *runtime, bool objects)
{
    const al_targets *t = &runtime->targets;
    return objects ? t->boundary.bytes + t->back.bytes + t->reflection.bytes + t->light.bytes
                   : t->radiance.bytes + t->geometry.bytes + t->depth.bytes;
}

static uint64_t object_bytes(const al_runtime *runtime, bool grid)
{
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < runtime->scene.translucent_count; i++) {
        const al_object *o = &runtime->objects[i];
        bytes += grid ? o->density.bytes
                      : o->positions.size + o->gaussians.size + o->coefficients.size + o->scales.size +
                            o->lit.size;
    }
    return bytes;
}

static void add(al_runtime *runtime, uint32_t *count, const char *step, bool needed, const char *why,
                double ms, uint64_t bytes)
{
    runtime->plan[(*count)++] = (al_plan_row){step, needed, why, needed ? ms * 1e-3 : 0, needed ? bytes : 0};
}

static double effect_ms(const al_runtime *runtime, al_stage first)
{
    const double *ms = runtime->timing.ms + first;
    return ms[0] + ms[1] + ms[2] + ms[3];
}

/* What seen surfaces get from others, as the last frame was asked. */
static void add_effects(al_runtime *runtime, uint32_t *count)
{
    const al_scene *scene = &runtime->scene;
    const bool *ran = runtime->bounce.ran;
    bool baked = false, dynamic = false;
    for (uint32_t i = 0; i < scene->instance_count; i++) {
        if (scene->instances[i].role != AL_ROLE_OPAQUE) continue;
        bool lit = al_instance_lighting(runtime, i) == AL_LIGHTING_DYNAMIC;
        dynamic = dynamic || lit;
        baked = baked || !lit;
    }
    uint64_t bytes = al_bounce_surface_bytes(runtime);
    add(runtime, count, "ambient-occlusion", ran[AL_BOUNCE_OCCLUSION],
        ran[AL_BOUNCE_OCCLUSION] ? baked ? "asked for; baked light knows what hides it, and is left alone" : "asked for"
        : !al_environment_exists(&scene->environment) ? "no environment light to hide"
        : !dynamic                                     ? "no opaque surface without baked light"
                                                       : "on request",
        effect_ms(runtime, AL_STAGE_OCCLUSION_RAYS), bytes);
    add(runtime, count, "indirect", ran[AL_BOUNCE_INDIRECT],
        ran[AL_BOUNCE_INDIRECT] ? baked ? "asked for; surfaces with baked light hold it already, and get none twice" : "asked for"
        : !dynamic                                              ? "no opaque surface without baked light"
        : !scene->light_count && !runtime->model.has_emission ? "no light and no emission"
                                                                : "on request",
        effect_ms(runtime, AL_STAGE_INDIRECT_RAYS),
        (ran[AL_BOUNCE_OCCLUSION] ? 0 : bytes) + runtime->targets.material.bytes);
}

const al_plan_row *al_runtime_plan(al_runtime *runtime, uint32_t *count)
{
    const al_scene *scene = &runtime->scene;
    const double *ms = runtime->timing.ms;
    bool objects = scene->translucent_count > 0, opaque = runtime->model.has_opaque,
         lights = scene->light_count > 0;
    bool environment = al_environment_exists(&scene->environment);
    *count = 0;
    if (!runtime->loaded) return runtime->plan;
    bool deforms = scene->motion.deform_count > 0;
    add(runtime, count, "skin", deforms,
        deforms ? "skinned or morphed meshes, whenever the time changes" : "no mesh has a skin or morph targets that move",
        ms[AL_STAGE_SKIN], al_motion_bytes(runtime));
    add(runtime, count, "shadow", opaque && lights,
        !opaque  ? "no opaque object casts a shadow"
        : lights ? "opaque objects and lights"
                 : "no light",
        ms[AL_STAGE_SHADOW], runtime->shadow.depth.bytes);
    add(runtime, count, "light", objects,
        objects ? "samples of translucent objects" : "no translucent object", ms[AL_STAGE_LIGHT],
        object_bytes(runtime, false));
    add(runtime, count, "surface", true, opaque ? "opaque objects" : "background and boundaries",
        ms[AL_STAGE_SURFACE], target_bytes(runtime, false));
    bool lightmap = *scene->baked.lightmap != 0, probes = *scene->baked.probes != 0;
    add(runtime, count, "lightmap", lightmap,
        lightmap ? "meshes lit by their lightmap alone" : "no mesh has a lightmap", 0,
        al_lightmap_bytes(runtime));
    add(runtime, count, "probes", probes,
        probes ? "moving meshes take indirect light from probes" : "no probes", 0, 0);
    add(runtime, count, "direct-scattering", scene->fog_count > 0,
        scene->fog_count ? "fog scatters light towards the eye and hides what lies behind" : "no fog",
        ms[AL_STAGE_FOG], al_fog_bytes(runtime));
    bool glow = lights || runtime->model.has_emission, surfels = scene->fog_count > 0 && opaque && glow,
         bounced = runtime->bounce.ran[AL_BOUNCE_OCCLUSION] || runtime->bounce.ran[AL_BOUNCE_INDIRECT];
    const char *into_fog = !scene->fog_count ? "no fog takes light from surfaces"
                           : !opaque         ? "no opaque object sends light into the fog"
                           : !glow           ? "no light and no emission"
                                             : "surfaces send light into the fog";
    add(runtime, count, "surfels", surfels || bounced,
        !surfels && bounced ? "light between surfaces, or what hides it"
        : runtime->surfels.coarseness > 1.0 ? "surfaces send light into the fog; larger surfels, to stay below their limit"
                                          : into_fog,
        ms[AL_STAGE_SURFELS] + ms[AL_STAGE_SURFEL_LIGHT], al_surfels_bytes(runtime));
    add(runtime, count, "interval-map", surfels, into_fog, ms[AL_STAGE_INTERVAL_MAP],
        al_interval_map_bytes(runtime));
    add(runtime, count, "surface-scattering", surfels, into_fog,
        ms[AL_STAGE_SPAN] + ms[AL_STAGE_LEGS] + ms[AL_STAGE_SHELLS] + ms[AL_STAGE_BOUNCE_RAYS] + ms[AL_STAGE_BOUNCE] +
            ms[AL_STAGE_BOUNCE_LIGHT] + ms[AL_STAGE_UNSHUFFLE] + ms[AL_STAGE_BLUR] + ms[AL_STAGE_GATHER],
        al_shells_bytes(runtime));
    add_effects(runtime, count);
    bool sky = al_fog_sky_exists(runtime);
    add(runtime, count, "sky light", sky,
        sky                 ? "fog scatters light of the environment towards the eye"
        : !scene->fog_count ? "no fog"
        : environment       ? "no fog that scatters has an end"
                            : "no environment light",
        0, al_fog_sky_bytes(runtime));
    add(runtime, count, "environment", environment,
        environment ? "environment light" : "no environment light", 0, runtime->environment.bytes);
    add(runtime, count, "intervals", objects,
        objects ? "transmittance of translucent objects to the eye" : "no translucent object",
        ms[AL_STAGE_INTERVALS],
        object_bytes(runtime, true) + runtime->targets.knots.bytes + runtime->targets.ends.bytes);
    add(runtime, count, "splat", objects,
        objects ? "samples of translucent objects" : "no translucent object", ms[AL_STAGE_SPLAT],
        target_bytes(runtime, true));
    add(runtime, count, "composite", true, "every frame", ms[AL_STAGE_COMPOSITE], 0);
    return runtime->plan;
}
