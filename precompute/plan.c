#include "plan.h"

#include <math.h>

#include "atlas.h"
#include "bake_medium.h"
#include "fog_depth.h"
#include "place_probes.h"
#include "sky_light.h"

/* Measured on two cores of a 2020s server with PoCL (docs/performance.md): seconds per unit of work. */
static const double seconds_per_voxel_direction = 4e-9;
static const double seconds_per_sample_direction = 5e-7;
static const double seconds_per_sample = 3e-4;
static const double seconds_per_measured_sample = 3e-6; /* 1024 points */

static const double seconds_per_sky_fog = 5;
static const double seconds_per_depth_frame = 5;

/* On one core, room of docs/methods.md; a path is one sample of a texel. */
static const double seconds_per_path_segment = 1.5e-6;

static void add(al_plan *plan, const char *step, bool needed, const char *why, double seconds, double bytes)
{
    plan->steps[plan->count++] =
        (al_plan_step){step, needed, why, needed ? seconds : 0, needed ? (uint64_t)bytes : 0};
}

bool al_plan_needs_tables(const al_import *import)
{
    return (al_atlas_needed(&import->scene) || import->description->has_probes) &&
           import->scene.fog_count > 0 && import->description->lightmap.walls == AL_WALLS_PUBLISHED;
}

static void add_tables(const al_import *import, al_plan *plan)
{
    bool needed = al_plan_needs_tables(import),
         light = al_atlas_needed(&import->scene) || import->description->has_probes;
    add(plan, "impulse tables", needed,
        needed                         ? "walls as published: fog's scattered light is looked up in tables"
        : !light                       ? "neither lightmap nor probes are baked"
        : import->scene.fog_count == 0 ? "the scene has no fog"
                                       : "walls are not as published: rays gather the fog's light themselves",
        40, 5.4e8);
}

static void add_sky_light(const al_import *import, al_plan *plan)
{
    const char *why = "the scene has no fog";
    uint32_t lit = 0;
    for (uint32_t i = 0; i < import->scene.fog_count; i++) {
        const char *missing = al_sky_light_missing(import, i);
        if (missing && !lit) why = missing;
        lit += !missing;
    }
    add(plan, "sky light", lit > 0, lit ? "fog scatters light of the environment to the eye" : why,
        lit * seconds_per_sky_fog, lit * 8e6);
}

static void add_fog_depth(const al_import *import, al_plan *plan)
{
    const char *why = "the scene has no fog";
    double frames = 0;
    for (uint32_t i = 0; i < import->scene.fog_count; i++) {
        const char *missing = al_fog_depth_missing(import, i);
        if (!missing) frames += import->description->media[import->scene.fogs[i].medium].density.frame_count;
        if (missing && !frames) why = missing;
    }
    add(plan, "fog depth", frames > 0,
        frames > 0 ? "optical_depth_order: the player may take light from surfaces to the fog through baked depths" : why,
        frames * seconds_per_depth_frame, 2e6);
}

static void add_lightmap(const al_import *import, al_plan *plan)
{
    const al_lightmap_settings *s = &import->description->lightmap;
    bool any = al_atlas_needed(&import->scene), directional = any && s->directional_order > 0;
    double texels = any ? al_atlas_texels(import) : 0,
           bands = (double)s->directional_order * s->directional_order;
    const char *none = "no mesh is lit by a lightmap";
    add(plan, "atlas", any, any ? "each texel of a lightmap belongs to one place of the surfaces" : none,
        texels * 1e-6, texels * 120);
    add(plan, "lightmap", any,
        any ? "meshes with \"lighting\": \"lightmap\" keep all their light in it" : none,
        texels * s->samples * (s->bounces + 1.0) * seconds_per_path_segment, texels * (9 + 9 * bands) * 8);
    add(plan, "directional lightmap", directional,
        directional ? "directional_order asks for incident radiance at each texel, for normal maps"
        : any       ? "directional_order is 0: irradiance alone is kept"
                    : none,
        0, texels * 9 * bands * 8);
    add(plan, "seams", any, any ? "where charts part, both sides should show the same light" : none,
        texels * 1e-6, texels * 40);
}

static void add_probes(const al_import *import, al_plan *plan)
{
    const al_probe_settings *s = &import->description->probes;
    bool any = import->description->has_probes, moving = false;
    for (uint32_t i = 0; i < import->scene.instance_count; i++)
        moving = moving || import->scene.instances[i].lighting == AL_LIGHTING_PROBES;
    double count = any ? al_probe_count(import) : 0, bounces = import->description->lightmap.bounces;
    add(plan, "probes", any,
        !any     ? "the scene asks for no probes"
        : moving ? "meshes with \"lighting\": \"probes\" take their indirect light from them"
                 : "the scene asks for them, though no mesh takes its light from probes",
        count * s->samples * (bounces + 1) * seconds_per_path_segment,
        count * (9.0 * s->order * s->order + 1) * 4);
}

void al_plan_make(const al_import *import, al_plan *plan)
{
    const al_scene *scene = &import->scene;
    const al_bake_settings *s = &import->description->bake;
    double objects = scene->translucent_count, voxels = pow(s->grid_resolution + 2.0, 3);
    bool any = objects > 0, chromatic = false, blockers = false;
    for (uint32_t i = 0; i < scene->translucent_count; i++) {
        const al_medium *m = &scene->media[scene->translucents[i].medium];
        double t[3];
        for (int c = 0; c < 3; c++) t[c] = (double)m->sigma_s_per_m[c] + m->sigma_a_per_m[c];
        if (t[0] != t[1] || t[1] != t[2]) chromatic = true;
    }
    for (uint32_t i = 0; i < scene->instance_count; i++)
        blockers = blockers || scene->instances[i].role == AL_ROLE_BLOCKER;
    double channels = chromatic ? 3 : 1, directions = s->directions, samples = s->samples;
    bool varies = false, kept = false;
    for (uint32_t i = 0; i < scene->fog_count; i++) {
        varies = varies || al_fog_varies(import, i);
        kept = kept || al_fog_has_asset(import, i);
    }
    const char *none = "the scene has no translucent object";

    plan->count = 0;
    add(plan, "scene", true, "what the player draws: meshes, materials, lights, cameras", 0.1, 0);
    bool moves = scene->motion.binding_count || scene->motion.deform_count;
    add(plan, "motion", moves,
        moves ? "keys move meshes, lights or cameras; what moves is in no lightmap and no probe" : "nothing moves", 0, 0);
    add(plan, "voxelise", any, any ? "translucent objects are swept as voxels" : none,
        objects * voxels * 2e-7, voxels * 5);
    add(plan, "blockers", any && blockers,
        blockers ? "opaque meshes lie inside translucent objects"
                 : "no opaque mesh lies inside a translucent object",
        objects * voxels * 1e-7, voxels * 4);
    add(plan, "optical depth", any, any ? "the moment needs the transmittance in every direction" : none,
        objects * voxels * directions * seconds_per_voxel_direction, voxels * 4 * 40);
    add(plan, "moment", any, any ? "its divergence says where samples must be dense" : none, 0, voxels * 24);
    add(plan, "divergence", any, any ? "sampling follows |div T|" : none, objects * voxels * 1e-8,
        voxels * 4);
    add(plan, "sample", any, any ? "samples carry the light" : none, objects * samples * seconds_per_sample,
        samples * 200);
    add(plan, "project", any, any ? "each sample keeps its transmittance as spherical harmonics" : none,
        objects * channels * directions *
            (samples * seconds_per_sample_direction + voxels * seconds_per_voxel_direction / 2),
        samples * channels * s->sh_order * s->sh_order * 8.0);
    add(plan, "measure", any, any ? "each object's asset carries its measured error" : none,
        objects * (0.1 + samples * seconds_per_measured_sample), 0);
    add(plan, "colour channels", any && chromatic,
        chromatic ? "extinction differs between red, green and blue: three sets of coefficients"
                  : "extinction is grey: one set of coefficients serves",
        0, 0);
    add(plan, "medium", kept,
        varies             ? "the density of a fog varies: its voxels become bricks"
        : kept             ? "the sky's light in a fog is kept in its asset"
        : scene->fog_count ? "the density of every fog is constant"
                           : "the scene has no fog",
        0.1, 0);
    add(plan, "environment", scene->environment.width > 0,
        scene->environment.width > 0 ? "the scene has an environment light"
                                     : "the scene has no environment light",
        0.1, 12.0 * scene->environment.width * scene->environment.height);
    add_sky_light(import, plan);
    add_fog_depth(import, plan);
    add_tables(import, plan);
    add_lightmap(import, plan);
    add_probes(import, plan);
}
