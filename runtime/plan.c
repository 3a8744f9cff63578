/* Which passes the last frame ran and which not, why, and what they hold. A row is needed where one of its stages ran, so
 * that it says what was done, not what was meant; bytes count where they are held, each in one row. */
#include "state.h"

static uint64_t target_bytes(const al_runtime *runtime, bool objects)
{
    const al_targets *t = &runtime->targets;
    return objects ? t->boundary.bytes + t->back.bytes + t->reflection.bytes + t->light.bytes
                   : t->radiance.bytes + t->geometry.bytes + t->depth.bytes + t->host.bytes;
}

static uint64_t object_bytes(const al_runtime *runtime, bool grid)
{
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < runtime->scene.translucent_count; i++) {
        const al_object *o = &runtime->objects[i];
        bytes += grid ? o->density.bytes
                      : o->positions.size + o->gaussians.size + o->coefficients.size + o->scales.size +
                            o->lit.size + o->constants.size;
    }
    return bytes;
}

#define STAGE(name) (1ull << AL_STAGE_##name)
enum { EFFECT_STAGES = 4 }; /* from AL_STAGE_OCCLUSION_RAYS and _INDIRECT_RAYS on */
static const uint64_t effect_stages[AL_BOUNCE_EFFECTS] = {((1ull << EFFECT_STAGES) - 1) << AL_STAGE_OCCLUSION_RAYS,
                                                          ((1ull << EFFECT_STAGES) - 1) << AL_STAGE_INDIRECT_RAYS},
                      surfel_stages = STAGE(SURFELS) | STAGE(SURFEL_LIGHT),
                      scattering_stages = STAGE(SPAN) | STAGE(LEGS) | STAGE(SHELLS) | STAGE(UNSHUFFLE) | STAGE(BLUR) |
                                          STAGE(GATHER),
                      visibility_stages = STAGE(BOUNCE_RAYS) | STAGE(BOUNCE) | STAGE(BOUNCE_LIGHT);
_Static_assert(AL_STAGE_COUNT <= 64, "one bit each");

static bool ran(const al_runtime *runtime, uint64_t stages)
{
    for (int i = 0; i < AL_STAGE_COUNT; i++)
        if (stages >> i & 1 && runtime->timing.ran[i]) return true;
    return false;
}

static void add(al_runtime *runtime, uint32_t *count, const char *step, bool needed, const char *why, uint64_t stages,
                uint64_t bytes)
{
    double ms = 0;
    for (int i = 0; i < AL_STAGE_COUNT && needed; i++)
        if (stages >> i & 1) ms += runtime->timing.ms[i];
    runtime->plan[(*count)++] = (al_plan_row){step, needed, why, ms * 1e-3, bytes};
}

/* Why the last frame did without what the scene has: `off`, a setting, where all is shown. */
static const char *left_out(const al_runtime *runtime, const char *off)
{
    if (!runtime->drawn) return "no frame was drawn yet";
    return runtime->settings.pass == AL_PASS_COMPOSITE ? off : "the picture that is shown does without";
}

/* What seen surfaces get from others. `shared`: bytes of the bounced z-buffer that no row has counted yet. */
static void add_effects(al_runtime *runtime, uint32_t *count, uint64_t shared)
{
    const al_scene *scene = &runtime->scene;
    bool occlusion = ran(runtime, effect_stages[AL_BOUNCE_OCCLUSION]),
         indirect = ran(runtime, effect_stages[AL_BOUNCE_INDIRECT]), baked = false, dynamic = false;
    for (uint32_t i = 0; i < scene->instance_count; i++) {
        if (scene->instances[i].role != AL_ROLE_OPAQUE) continue;
        bool lit = al_instance_lighting(runtime, i) == AL_LIGHTING_DYNAMIC;
        dynamic = dynamic || lit;
        baked = baked || !lit;
    }
    shared += al_bounce_surface_bytes(runtime);
    add(runtime, count, "ambient-occlusion", occlusion,
        occlusion ? baked ? "asked for; baked light knows what hides it, and is left alone" : "asked for"
        : !al_environment_exists(&scene->environment) ? "no environment light to hide"
        : !dynamic                                     ? "no opaque surface without baked light"
                                                       : left_out(runtime, "on request"),
        effect_stages[AL_BOUNCE_OCCLUSION], occlusion ? shared : 0);
    add(runtime, count, "indirect", indirect,
        indirect ? baked ? "asked for; surfaces with baked light hold it already, and get none twice" : "asked for"
        : !dynamic                                             ? "no opaque surface without baked light"
        : !scene->light_count && !runtime->model.has_emission ? "no light and no emission"
                                                               : left_out(runtime, "on request"),
        effect_stages[AL_BOUNCE_INDIRECT], occlusion ? 0 : shared);
    bool gloss = al_model_is_glossy(runtime);
    add(runtime, count, "glossy", indirect && gloss,
        !indirect ? "no light between surfaces"
        : gloss   ? "rays and light between surfaces follow the lobes of glossy ones"
                  : "no glossy surface: rays are drawn by the cosine alone",
        0, 0);
    bool history = ran(runtime, STAGE(OCCLUSION_HISTORY) | STAGE(INDIRECT_HISTORY));
    add(runtime, count, "temporal", history,
        history                 ? "asked for; light between surfaces is averaged over frames"
        : occlusion || indirect ? "on request"
                                : "no light between surfaces is drawn at random",
        STAGE(OCCLUSION_HISTORY) | STAGE(INDIRECT_HISTORY), al_history_bytes(runtime));
}

/* Light of surfaces in the fog, and the surfels that send it, there and to other surfaces. */
static void add_scattering(al_runtime *runtime, uint32_t *count)
{
    const al_scene *scene = &runtime->scene;
    bool surfels = ran(runtime, surfel_stages), map = ran(runtime, STAGE(INTERVAL_MAP)),
         scatters = ran(runtime, scattering_stages), visibility = ran(runtime, visibility_stages);
    const char *why_not = !scene->fog_count            ? "no fog takes light from surfaces"
                          : !runtime->model.has_opaque ? "no opaque object sends light into the fog"
                          : !scene->light_count && !runtime->model.has_emission
                              ? "no light and no emission"
                              : left_out(runtime, "switched off, or no density has arrived");
    add(runtime, count, "surfels", surfels,
        !surfels                            ? why_not
        : runtime->surfels.coarseness > 1.0 ? "surfaces send light; larger surfels, to stay below their limit"
        : scatters                          ? "surfaces send light into the fog"
                                            : "light between surfaces, or what hides it",
        surfel_stages, al_surfels_bytes(runtime));
    add(runtime, count, "interval-map", map, map ? "where the fog scatters along each ray" : why_not, STAGE(INTERVAL_MAP),
        al_interval_map_bytes(runtime));
    add(runtime, count, "surface-scattering", scatters, scatters ? "surfaces send light into the fog" : why_not,
        scattering_stages, al_shells_bytes(runtime));
    add(runtime, count, "visibility", visibility,
        visibility ? "asked for; surfaces hide others from the fog"
        : scatters ? "on request"
                   : why_not,
        visibility_stages, visibility ? al_bounce_bytes(runtime) : 0);
    add_effects(runtime, count, visibility ? 0 : al_bounce_bytes(runtime));
}

static bool any_grid(const al_scene *scene)
{
    for (uint32_t i = 0; i < scene->fog_count; i++)
        if (*scene->fogs[i].asset) return true;
    return false;
}

static void add_fog(al_runtime *runtime, uint32_t *count)
{
    bool fog = ran(runtime, STAGE(FOG));
    add(runtime, count, "direct-scattering", fog,
        fog                          ? "fog scatters light towards the eye and hides what lies behind"
        : !runtime->scene.fog_count ? "no fog"
                                     : left_out(runtime, "switched off, or no density has arrived"),
        STAGE(FOG), al_fog_bytes(runtime));
    uint64_t grid = al_fog_grid_bytes(runtime);
    add(runtime, count, "density grid", grid > 0,
        grid > 0                    ? "the density of a fog varies"
        : !runtime->scene.fog_count ? "no fog"
        : any_grid(&runtime->scene) ? "no density has arrived"
                                    : "the density of every fog is constant",
        0, grid);
}

/* Translucent objects: their samples' light, the way to the eye, and what comes along it. */
static void add_objects(al_runtime *runtime, uint32_t *count, al_stage stage, const char *why, uint64_t bytes)
{
    bool runs = ran(runtime, 1ull << stage);
    add(runtime, count, al_stage_name(stage), runs,
        runs                                ? why
        : !runtime->scene.translucent_count ? "no translucent object"
                                            : left_out(runtime, "no translucent object in view"),
        1ull << stage, bytes);
}

const al_plan_row *al_runtime_plan(al_runtime *runtime, uint32_t *count)
{
    const al_scene *scene = &runtime->scene;
    *count = 0;
    if (!runtime->loaded) return runtime->plan;
    bool opaque = runtime->model.has_opaque, environment = al_environment_exists(&scene->environment),
         lightmap = *scene->baked.lightmap != 0, probes = *scene->baked.probes != 0,
         deforms = scene->motion.deform_count > 0, shadow = runtime->shadow.depth.id != 0,
         surface = ran(runtime, STAGE(SURFACE)), composite = ran(runtime, STAGE(COMPOSITE)),
         sky = al_fog_sky_exists(runtime) && ran(runtime, STAGE(FOG));
    add(runtime, count, "scene", true, "meshes, textures, and what all passes read", 0,
        al_model_bytes(runtime) + runtime->frame_block.size);
    add(runtime, count, "skin", deforms,
        deforms ? "skinned or morphed meshes, whenever the time changes" : "no mesh has a skin or morph targets that move",
        STAGE(SKIN), al_motion_bytes(runtime));
    add(runtime, count, "shadow", shadow,
        shadow                 ? "opaque objects and lights, whenever one moves"
        : !opaque              ? "no opaque object casts a shadow"
        : !scene->light_count ? "no light"
        : !runtime->drawn      ? "no frame was drawn yet"
                               : "switched off",
        STAGE(SHADOW), runtime->shadow.depth.bytes);
    add_objects(runtime, count, AL_STAGE_LIGHT, "samples of translucent objects", object_bytes(runtime, false));
    add(runtime, count, "surface", surface,
        !surface ? "no frame was drawn yet"
        : opaque ? "opaque objects"
                 : "background and boundaries",
        STAGE(SURFACE), target_bytes(runtime, false));
    add(runtime, count, "lightmap", lightmap,
        lightmap ? "meshes lit by their lightmap alone" : "no mesh has a lightmap", 0,
        al_lightmap_bytes(runtime));
    add(runtime, count, "probes", probes,
        probes ? "moving meshes take indirect light from probes" : "no probes", 0, 0);
    add_fog(runtime, count);
    add_scattering(runtime, count);
    add(runtime, count, "sky light", sky,
        sky                 ? "fog scatters light of the environment towards the eye"
        : !scene->fog_count ? "no fog"
        : !environment      ? "no environment light"
        : al_fog_sky_exists(runtime) ? left_out(runtime, "switched off")
                                     : "no fog that scatters has an end",
        0, al_fog_sky_bytes(runtime));
    add(runtime, count, "environment", environment,
        environment ? "environment light" : "no environment light", 0, runtime->environment.bytes);
    add_objects(runtime, count, AL_STAGE_INTERVALS, "transmittance of translucent objects to the eye",
                object_bytes(runtime, true) + runtime->targets.knots.bytes + runtime->targets.ends.bytes);
    add_objects(runtime, count, AL_STAGE_SPLAT, "samples of translucent objects", target_bytes(runtime, true));
    add(runtime, count, "composite", composite, composite ? "every frame" : "no frame was drawn yet", STAGE(COMPOSITE), 0);
    return runtime->plan;
}
