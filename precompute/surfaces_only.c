/* In place of the bakes of media, translucent objects, lightmaps and probes, where AIRLIGHT_SURFACES_ONLY leaves them out:
 * scenes that need one are refused, all others are baked as by the whole program. */
#include "atlas.h"
#include "bake_lightmap.h"
#include "bake_medium.h"
#include "bake_object.h"
#include "bake_probes.h"
#include "fog_depth.h"
#include "glb.h"
#include "impulse_steps.h"
#include "place_probes.h"
#include "sky_light.h"
#include "vdb_bridge.h"

static const char left_out[] = "this build bakes surfaces alone, use one without AIRLIGHT_SURFACES_ONLY";

static al_status refuse(const char *what, const char *name, al_error *error)
{
    return al_fail(error, AL_BAD_INPUT, "%s \"%s\": %s", what, name, left_out);
}

static al_status refuse_device(al_error *error)
{
    return al_fail(error, AL_NO_DEVICE, "OpenCL: %s", left_out);
}

static void no_file(char *name, size_t size)
{
    if (size) *name = 0;
}

/* --- what a scene needs --- */

bool al_atlas_needed(const al_scene *scene)
{
    for (uint32_t i = 0; i < scene->instance_count; i++)
        if (scene->instances[i].lighting == AL_LIGHTING_LIGHTMAP) return true;
    return false;
}

bool al_fog_varies(const al_import *import, uint32_t fog) { return false; }

/* So that every fog comes to al_bake_medium_key. */
bool al_fog_has_asset(const al_import *import, uint32_t fog) { return true; }
const char *al_sky_light_missing(const al_import *import, uint32_t fog) { return left_out; }
const char *al_fog_depth_missing(const al_import *import, uint32_t fog) { return left_out; }
double al_atlas_texels(const al_import *import) { return 0; }
double al_probe_count(const al_import *import) { return 0; }

/* --- the first that is asked of each bake --- */

al_status al_bake_object_key(const al_import *import, uint32_t index, uint64_t *key, al_error *error)
{
    return refuse("translucent object", import->scene.translucents[index].name, error);
}

al_status al_bake_medium_key(const al_import *import, uint32_t fog, uint64_t *key, al_error *error)
{
    return refuse("fog", import->scene.media[import->scene.fogs[fog].medium].name, error);
}

al_status al_bake_lightmap_key(const al_import *import, uint64_t tables_key, uint64_t *key, al_error *error)
{
    return refuse("lightmap of", import->description->path, error);
}

al_status al_bake_probes_key(const al_import *import, uint64_t tables_key, uint64_t *key, al_error *error)
{
    return refuse("probes of", import->description->path, error);
}

al_status al_vdb_read(const char *path, const char *grid_name, uint64_t size_limit, al_vdb_grid *grid, al_error *error)
{
    return al_fail(error, AL_BAD_INPUT, "%s: grid \"%s\": %s", path, grid_name, left_out);
}

al_status al_device_list(al_device_names *names, al_error *error) { return refuse_device(error); }
al_status al_device_open(unsigned number, unsigned threads, const char *log_folder, bool verbose, al_device **device,
                         al_error *error)
{
    return refuse_device(error);
}

uint64_t al_impulse_tables_key(const al_impulse_settings *settings) { return 0; }

/* --- names, and what follows a refusal --- */

void al_bake_object_file(const al_translucent_object *object, char *name, size_t size) { no_file(name, size); }
void al_bake_medium_file(const al_import *import, uint32_t fog, char *name, size_t size) { no_file(name, size); }
void al_bake_lightmap_file(const al_import *import, char *name, size_t size) { no_file(name, size); }
void al_bake_probes_file(const al_import *import, char *name, size_t size) { no_file(name, size); }
void al_bake_lightmap_page_file(uint32_t page, char *name, size_t size) { no_file(name, size); }
void al_device_close(al_device *device) {}
void al_atlas_free(al_atlas *atlas) {}
al_status al_atlas_make(al_import *import, al_atlas *atlas, al_error *error) { return AL_BAD_INPUT; }
al_status al_bake_object(const al_import *import, uint32_t index, uint64_t key, al_device *device,
                         const al_bake_options *options, al_steps *steps, al_error *error)
{
    return AL_BAD_INPUT;
}

al_status al_bake_medium(const al_import *import, uint32_t fog, uint64_t key, const al_bake_options *options,
                         al_steps *steps, al_error *error)
{
    return AL_BAD_INPUT;
}

al_status al_bake_lightmap(const al_import *import, const al_atlas *atlas, uint64_t key, const al_impulse_tables *tables,
                           const al_bake_options *options, al_steps *steps, al_error *error)
{
    return AL_BAD_INPUT;
}

al_status al_bake_lightmap_page(const al_file *file, const al_lightmap_info *info, uint32_t index, const char *path,
                                al_error *error)
{
    return AL_BAD_INPUT;
}

al_status al_bake_probes(const al_import *import, uint64_t key, const al_impulse_tables *tables,
                         const al_bake_options *options, al_steps *steps, al_error *error)
{
    return AL_BAD_INPUT;
}

al_status al_impulse_tables_bake(const char *path, const al_impulse_settings *settings, uint64_t key, al_device *device,
                                 const al_bake_options *options, al_steps *steps, al_error *error)
{
    return AL_BAD_INPUT;
}

al_status al_glb_write(const char *path, const al_scene *scene, uint64_t *bytes, al_error *error) { return AL_BAD_INPUT; }
