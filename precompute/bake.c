/* airlight-bake: imports a scene, plans, bakes every asset the scene needs. */
#define _POSIX_C_SOURCE 200809L
#include <errno.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include "airlight/program.h"
#include "airlight/trade_table.h"
#include "airlight/translucent.h"
#include "bake_lightmap.h"
#include "bake_medium.h"
#include "bake_object.h"
#include "bake_probes.h"
#include "glb.h"
#include "impulse_steps.h"
#include "report.h"
#include "setting.h"

typedef struct arguments {
    const char *folder, *quality, *devices, *tables;
    int table_bands, table_events, table_distances, table_cosines;
    double table_g;
    bool table_all_in_one;
    bool plan, list_devices;
    int threads;
    double memory_limit_mib, target_error;
} arguments;

typedef struct bake {
    const al_program *program;
    const arguments *arguments;
    al_import *import;
    al_plan plan;
    al_report report;
    unsigned device_numbers[8], device_count;
    al_device *devices[8]; /* opened when first needed */
    al_file *tables_file;  /* opened when rays need them */
    al_impulse_tables *tables;
    al_atlas atlas;
    uint64_t lightmap_key; /* 0 without a lightmap */
} bake;

static al_status read_quality(const char *text, al_quality *quality, al_error *error)
{
    static const char *const names[] = {"preview", "medium", "final"};
    for (int i = 0; i < 3; i++)
        if (!strcmp(text, names[i])) return *quality = (al_quality)i, AL_OK;
    return al_fail(error, AL_USAGE, "--quality takes preview, medium or final, not '%s'", text);
}

static al_status read_devices(const char *text, bake *b, al_error *error)
{
    for (const char *at = text; b->device_count < 8;) {
        char *end;
        long number = strtol(at, &end, 10);
        if (end == at || number < 0 || number > 1000 || (*end && *end != ',')) break;
        b->device_numbers[b->device_count++] = (unsigned)number;
        if (!*end) return AL_OK;
        at = end + 1;
    }
    return al_fail(error, AL_USAGE, "--device takes numbers of --list-devices, such as 0 or 0,1, not '%s'",
                   text);
}

static al_status list_devices(al_error *error)
{
    al_device_names names;
    al_status status = al_device_list(&names, error);
    for (unsigned i = 0; status == AL_OK && i < names.count; i++) printf("%u  %s\n", i, names.names[i]);
    return status;
}

/* Creates the folder and what is missing above it. */
static al_status make_folder(const char *path, al_error *error)
{
    char part[1024];
    struct stat facts;
    if (snprintf(part, sizeof part, "%s", path) >= (int)sizeof part)
        return al_fail(error, AL_USAGE, "-o: the folder's name is too long");
    for (char *at = part + 1;; at++) {
        char end = *at;
        if (end != '/' && end != 0) continue;
        *at = 0;
        if (mkdir(part, 0777) != 0 && !(errno == EEXIST && stat(part, &facts) == 0 && S_ISDIR(facts.st_mode)))
            return al_fail(error, AL_IO, "%s: cannot create the folder: %s", part,
                           errno == EEXIST ? "a file of that name is there" : strerror(errno));
        if (end == 0) return AL_OK;
        *at = end;
    }
}

/* The key an asset was baked under, kept in its PROV chunk. False: none, or not readable, or not valid. */
static bool asset_key(const char *path, al_kind kind, uint64_t *key)
{
    al_open_options options = {.kind = kind};
    al_file *file;
    const void *data;
    size_t size;
    bool found = false;
    if (al_file_open(path, &options, &file, NULL) != AL_OK) return false;
    ptrdiff_t chunk = al_file_find(file, "PROV", 0);
    if (chunk >= 0 && al_file_data(file, (size_t)chunk, &data, &size, NULL) == AL_OK) {
        json_t *json = json_loadb(data, size, JSON_DISABLE_EOF_CHECK, NULL);
        const char *text = json_string_value(json_object_get(json, "key"));
        if (text) {
            *key = strtoull(text, NULL, 16);
            found = true;
        }
        json_decref(json);
    }
    al_file_close(file);
    return found && al_file_check(path, NULL, NULL, NULL) == AL_OK;
}

static al_status open_device(bake *b, unsigned slot, al_device **device, al_error *error)
{
    if (!b->devices[slot]) {
        al_status status =
            al_device_open(b->device_numbers[slot], (unsigned)b->arguments->threads, b->arguments->folder,
                           b->program->verbose, &b->devices[slot], error);
        if (status != AL_OK) return status;
        if (slot == 0) b->report.device = b->devices[0]->name;
        if (b->program->verbose)
            al_program_say(b->program, "device %u: %s", b->device_numbers[slot], b->devices[slot]->name);
    }
    *device = b->devices[slot];
    return AL_OK;
}

/* Objects go to the devices in turn. */
static al_status bake_objects(bake *b, al_error *error)
{
    al_bake_options options = {.program = b->program,
                               .folder = b->arguments->folder,
                               .threads = (unsigned)b->arguments->threads,
                               .memory_limit = (size_t)(b->arguments->memory_limit_mib * 1048576)};
    for (uint32_t i = 0; i < b->import->scene.translucent_count; i++) {
        al_translucent_object *object = &b->import->scene.translucents[i];
        char path[1400];
        uint64_t key, present;
        al_device *device;
        al_status status = al_bake_object_key(b->import, i, &key, error);
        if (status != AL_OK) return status;
        snprintf(path, sizeof path, "%s/%s", b->arguments->folder, object->asset);
        if (asset_key(path, AL_KIND_TRANSLUCENT, &present) && present == key) {
            al_program_say(b->program, "%s is up to date", path);
            continue;
        }
        status = open_device(b, i % b->device_count, &device, error);
        if (status == AL_OK)
            status = al_bake_object(b->import, i, key, device, &options, &b->report.objects[i], error);
        if (status != AL_OK) return status;
        al_program_say(b->program, "wrote %s", path);
    }
    return AL_OK;
}

/* Fogs whose density varies, or that an environment lights. */
static al_status bake_fogs(bake *b, al_error *error)
{
    al_bake_options options = {.program = b->program,
                               .folder = b->arguments->folder,
                               .threads = (unsigned)b->arguments->threads,
                               .memory_limit = (size_t)(b->arguments->memory_limit_mib * 1048576)};
    al_status status = AL_OK;
    for (uint32_t i = 0; i < b->import->scene.fog_count && status == AL_OK; i++) {
        char path[1400];
        uint64_t key, present;
        if (!al_fog_has_asset(b->import, i)) continue;
        status = al_bake_medium_key(b->import, i, &key, error);
        if (status != AL_OK) return status;
        snprintf(path, sizeof path, "%s/%s", b->arguments->folder, b->import->scene.fogs[i].asset);
        if (asset_key(path, AL_KIND_MEDIUM, &present) && present == key) {
            al_program_say(b->program, "%s is up to date", path);
            continue;
        }
        status = al_bake_medium(b->import, i, key, &options, &b->report.steps, error);
        if (status != AL_OK) return status;
        al_program_say(b->program, "wrote %s", path);
    }
    return status;
}

/* Of everything scene.air is made from: the scene file and all it names, and the lightmap's second UV sets.
 */
static uint64_t scene_key(const bake *b)
{
    static const uint32_t scene_version = 1; /* raise it when scene.air changes for the same inputs */
    uint64_t key = XXH64(AIRLIGHT_VERSION, sizeof AIRLIGHT_VERSION, scene_version);
    for (uint32_t i = 0; i < b->import->input_count; i++)
        key = XXH64(&b->import->inputs[i].xxh64, sizeof(uint64_t), key);
    return b->lightmap_key ? XXH64(&b->lightmap_key, sizeof b->lightmap_key, key) : key;
}

static bool is_fresh(const bake *b, const char *file, al_kind kind, uint64_t key)
{
    char path[1400];
    uint64_t present;
    snprintf(path, sizeof path, "%s/%s", b->arguments->folder, file);
    return asset_key(path, kind, &present) && present == key;
}

/* 0: there is no such file in the folder, or an empty one. */
static uint64_t file_bytes(const bake *b, const char *file)
{
    char path[1400];
    struct stat facts;
    snprintf(path, sizeof path, "%s/%s", b->arguments->folder, file);
    return stat(path, &facts) == 0 && S_ISREG(facts.st_mode) ? (uint64_t)facts.st_size : 0;
}

static al_status lay_atlas(bake *b, al_error *error)
{
    double started = al_program_seconds();
    al_status status = al_atlas_make(b->import, &b->atlas, error);
    if (status != AL_OK) return status;
    b->report.light.steps[b->report.light.count++] =
        (al_step){"atlas", al_program_seconds() - started, 0, b->atlas.instance_count};
    if (b->atlas.coarse_count)
        al_program_say(b->program,
                       "%u meshes do not fit a lightmap page of %u texels and got larger ones than %.3g m; a "
                       "larger page_size or texel_m would do",
                       b->atlas.coarse_count, b->import->description->lightmap.page_size, b->atlas.texel_m);
    return AL_OK;
}

/* Impulse tables, which depend on no scene, by the settings of the command line. */
static al_status make_tables(bake *b, const char *path, al_error *error)
{
    const arguments *a = b->arguments;
    const al_impulse_settings settings = {.bands = (uint32_t)a->table_bands,
                                          .events = (uint32_t)a->table_events,
                                          .distances = (uint32_t)a->table_distances,
                                          .cosines = (uint32_t)a->table_cosines,
                                          .distance_min = 1e-6,
                                          .distance_max = 1e3,
                                          .g_range = a->table_g,
                                          .all_in_one = a->table_all_in_one};
    al_bake_options options = {.program = b->program, .threads = (unsigned)a->threads};
    uint64_t key = al_impulse_tables_key(&settings), present;
    al_device *device;
    al_writer *probe; /* a place that cannot be written to is better known before than after */
    if (settings.cosines % 2 == 0)
        return al_fail(error, AL_USAGE, "--table-cosines takes an odd number, not %u", settings.cosines);
    if (asset_key(path, AL_KIND_IMPULSE_TABLES, &present) && present == key) {
        al_program_say(b->program, "%s is up to date", path);
        return AL_OK;
    }
    al_status status = al_writer_open(path, AL_KIND_IMPULSE_TABLES, &probe, error);
    if (status != AL_OK) return status;
    al_writer_discard(probe);
    status = open_device(b, 0, &device, error);
    if (status == AL_OK)
        status = al_impulse_tables_bake(path, &settings, key, device, &options, &b->report.steps, error);
    if (status == AL_OK) al_program_say(b->program, "wrote %s", path);
    return status;
}

/* Impulse tables in the folder, where the rays of lightmap and probes need them: those that lie there, of whatever
 * settings, else new ones. */
static al_status open_tables(bake *b, al_error *error)
{
    char path[1400];
    al_open_options options = {.kind = AL_KIND_IMPULSE_TABLES};
    if (!al_plan_needs_tables(b->import)) return AL_OK;
    snprintf(path, sizeof path, "%s/impulse-tables.air", b->arguments->folder);
    al_status status = AL_OK;
    if (access(path, F_OK) != 0) status = make_tables(b, path, error);
    if (status == AL_OK) status = al_file_open(path, &options, &b->tables_file, error);
    return status == AL_OK ? al_impulse_tables_read(b->tables_file, &b->tables, error) : status;
}

/* 0 without tables. */
static uint64_t key_of_chunks(const al_file *file)
{
    uint64_t key = 0;
    for (size_t i = 0; file && i < al_file_chunk_count(file); i++)
        key = XXH64(&al_file_chunk(file, i)->checksum, sizeof(uint64_t), key);
    return key;
}

/* The lightmap's pages as pictures. They are made from the asset, so no light is gathered for those that are
 * gone. scene.air is written after them: where it is up to date, so are the pictures that lie there. */
static al_status write_pages(bake *b, bool scene_fresh, al_error *error)
{
    double started = al_program_seconds();
    const al_open_options options = {.kind = AL_KIND_LIGHTMAP};
    char path[1400], picture[64];
    uint64_t bytes = 0, count = 0;
    al_file *file;
    al_lightmap_info info;
    snprintf(path, sizeof path, "%s/%s", b->arguments->folder, b->import->scene.baked.lightmap);
    al_status status = al_file_open(path, &options, &file, error);
    if (status != AL_OK) return status;
    status = al_lightmap_read(file, &info, error);
    for (uint32_t p = 0; status == AL_OK && p < info.page_count; p++) {
        al_bake_lightmap_page_file(p, picture, sizeof picture);
        if (scene_fresh && file_bytes(b, picture)) continue;
        snprintf(path, sizeof path, "%s/%s", b->arguments->folder, picture);
        status = al_bake_lightmap_page(file, &info, p, path, error);
        if (status == AL_OK) al_program_say(b->program, "wrote %s", path);
        bytes += file_bytes(b, picture);
        count++;
    }
    al_file_close(file);
    if (count) al_steps_add(&b->report.light, "pages", started, bytes, count);
    b->report.lightmap_page_count = info.page_count;
    return status;
}

/* The atlas is laid out whenever the lightmap or what holds the second UV sets, scene.air or scene.glb, is to
 * be made. */
static al_status bake_lightmap(bake *b, const al_bake_options *options, uint64_t tables_key, al_error *error)
{
    const char *name = b->import->scene.baked.lightmap;
    al_status status = al_bake_lightmap_key(b->import, tables_key, &b->lightmap_key, error);
    bool fresh = status == AL_OK && is_fresh(b, name, AL_KIND_LIGHTMAP, b->lightmap_key);
    bool scene_fresh = status == AL_OK && is_fresh(b, "scene.air", AL_KIND_SCENE, scene_key(b));
    if (status == AL_OK && !(fresh && scene_fresh && file_bytes(b, "scene.glb")))
        status = lay_atlas(b, error);
    if (status == AL_OK && !fresh)
        status = al_bake_lightmap(b->import, &b->atlas, b->lightmap_key, b->tables, options, &b->report.light,
                                  error);
    if (status == AL_OK)
        al_program_say(b->program, fresh ? "%s/%s is up to date" : "wrote %s/%s", b->arguments->folder, name);
    return status == AL_OK ? write_pages(b, scene_fresh, error) : status;
}

static al_status bake_probes(bake *b, const al_bake_options *options, uint64_t tables_key, al_error *error)
{
    const char *name = b->import->scene.baked.probes;
    uint64_t key;
    al_status status = al_bake_probes_key(b->import, tables_key, &key, error);
    bool fresh = status == AL_OK && is_fresh(b, name, AL_KIND_PROBES, key);
    if (status == AL_OK && !fresh)
        status = al_bake_probes(b->import, key, b->tables, options, &b->report.light, error);
    if (status == AL_OK)
        al_program_say(b->program, fresh ? "%s/%s is up to date" : "wrote %s/%s", b->arguments->folder, name);
    return status;
}

/* Probes first: the lightmap's atlas gives meshes their second UV sets. */
static al_status bake_light(bake *b, al_error *error)
{
    al_bake_options options = {
        .program = b->program, .folder = b->arguments->folder, .threads = (unsigned)b->arguments->threads};
    bool lightmap = al_atlas_needed(&b->import->scene), probes = b->import->description->has_probes;
    if (!lightmap && !probes) return AL_OK;
    al_status status = open_tables(b, error);
    uint64_t tables_key = key_of_chunks(b->tables_file);
    if (status == AL_OK && probes) status = bake_probes(b, &options, tables_key, error);
    if (status == AL_OK && lightmap) status = bake_lightmap(b, &options, tables_key, error);
    return status;
}

/* scene.air comes last: where it is up to date, the scene.glb that lies there is. */
static al_status write_scene(bake *b, al_error *error)
{
    double started = al_program_seconds();
    char path[1400], provenance[64];
    uint64_t bytes = 0, glb_bytes = 0, key = scene_key(b);
    snprintf(path, sizeof path, "%s/scene.air", b->arguments->folder);
    bool fresh = is_fresh(b, "scene.air", AL_KIND_SCENE, key);
    bool glb = b->lightmap_key && !(fresh && file_bytes(b, "scene.glb"));
    al_status status = AL_OK;
    if (fresh) al_program_say(b->program, "%s is up to date", path);
    if (fresh && !glb) return AL_OK;
    if (glb) {
        char glb_path[1400];
        snprintf(glb_path, sizeof glb_path, "%s/scene.glb", b->arguments->folder);
        status = al_glb_write(glb_path, &b->import->scene, &glb_bytes, error);
        if (status != AL_OK) return status;
        al_program_say(b->program, "wrote %s", glb_path);
    }
    snprintf(provenance, sizeof provenance, "{\"key\":\"%016llx\"}", (unsigned long long)key);
    if (!fresh) status = al_scene_write(path, &b->import->scene, provenance, &bytes, error);
    b->report.steps.steps[b->report.steps.count++] = (al_step){
        "scene", al_program_seconds() - started, bytes + glb_bytes, b->import->scene.instance_count};
    return status;
}

static al_status name_assets(bake *b, al_error *error)
{
    for (uint32_t i = 0; i < b->import->scene.translucent_count; i++) {
        char file[160];
        al_bake_object_file(&b->import->scene.translucents[i], file, sizeof file);
        b->import->scene.translucents[i].asset = al_scene_text(&b->import->scene, file);
        if (!b->import->scene.translucents[i].asset) return al_fail(error, AL_IO, "out of memory");
    }
    for (uint32_t i = 0; i < b->import->scene.fog_count; i++) {
        char file[160];
        if (!al_fog_has_asset(b->import, i)) continue;
        al_bake_medium_file(b->import, i, file, sizeof file);
        b->import->scene.fogs[i].asset = al_scene_text(&b->import->scene, file);
        if (!b->import->scene.fogs[i].asset) return al_fail(error, AL_IO, "out of memory");
    }
    if (al_atlas_needed(&b->import->scene)) {
        char file[160];
        al_bake_lightmap_file(b->import, file, sizeof file);
        b->import->scene.baked.lightmap = al_scene_text(&b->import->scene, file);
        if (!b->import->scene.baked.lightmap) return al_fail(error, AL_IO, "out of memory");
    }
    if (b->import->description->has_probes) {
        char file[160];
        al_bake_probes_file(b->import, file, sizeof file);
        b->import->scene.baked.probes = al_scene_text(&b->import->scene, file);
        if (!b->import->scene.baked.probes) return al_fail(error, AL_IO, "out of memory");
    }
    return AL_OK;
}

/* What is wrong with an object is wrong in its scene: puts that file in front. */
static al_status in_scene(const char *scene, al_status status, al_error *error)
{
    char message[AL_ERROR_SIZE];
    if (status != AL_BAD_INPUT) return status;
    snprintf(message, sizeof message, "%s", error->message);
    return al_fail(error, status, "%s: %s", scene, message);
}

/* The place of a setting that airlight-trade turns; NULL: none of this name, or not of this value. */
static uint32_t *find_setting(al_scene_description *d, const char *name, long value)
{
    al_setting setting;
    for (int i = 0; al_setting_at(d, i, &setting); i++)
        if (!strcmp(name, setting.name) && value >= 1 && value <= setting.limit) return setting.value;
    return NULL;
}

/* --target-error: settings of a point that airlight-trade measured, in place of the scene's. */
static al_status take_target(bake *b, al_error *error)
{
    char text[AL_ERROR_SIZE];
    al_trade_pick *pick = &b->report.pick;
    al_scene_description *description = b->import->description;
    if (!(b->arguments->target_error > 0)) return AL_OK;
    al_status status = al_trade_pick_point(b->arguments->folder, b->arguments->target_error, 0, false, pick, error);
    for (int i = 0; i < pick->knob_count && !status; i++) {
        const al_trade_knob *knob = &pick->knobs[i];
        if (!strchr(knob->name, '.')) continue;
        char *end;
        long value = strtol(knob->value, &end, 10);
        uint32_t *setting = find_setting(description, knob->name, value);
        if (!setting || *end || (setting == &description->bake.directions && value % 2))
            return al_fail(error, AL_BAD_INPUT, "%s/trade.csv: %s=%s is no setting of this bake; run airlight-trade again",
                           b->arguments->folder, knob->name, knob->value);
        *setting = (uint32_t)value;
        if (setting == &description->bake.samples) description->bake.radius_m = 0;
    }
    if (status) return status;
    al_trade_pick_describe(pick, text, sizeof text);
    al_program_say(b->program, "--target-error %g: expects %s", b->arguments->target_error, text);
    return AL_OK;
}

static al_status bake_scene(bake *b, const char *scene, al_quality quality, al_error *error)
{
    double started = al_program_seconds();
    al_status status = al_import_scene(scene, quality, &b->import, error);
    if (status != AL_OK) return status;
    b->report.steps.steps[b->report.steps.count++] =
        (al_step){"import", al_program_seconds() - started, 0, b->import->input_count};
    status = take_target(b, error);
    if (status != AL_OK) return status;
    al_plan_make(b->import, &b->plan);
    if (b->arguments->plan) {
        char *text = al_plan_json(&b->plan);
        if (text) puts(text);
        free(text);
        return text ? AL_OK : al_fail(error, AL_IO, "out of memory");
    }
    b->report.import = b->import;
    b->report.plan = &b->plan;
    b->report.device = "";
    b->report.objects = calloc(b->import->scene.translucent_count + 1, sizeof *b->report.objects);
    if (!b->report.objects) return al_fail(error, AL_IO, "out of memory");
    status = make_folder(b->arguments->folder, error);
    if (status == AL_OK) status = name_assets(b, error);
    if (status == AL_OK) status = in_scene(scene, bake_objects(b, error), error);
    if (status == AL_OK) status = in_scene(scene, bake_fogs(b, error), error);
    if (status == AL_OK) status = in_scene(scene, bake_light(b, error), error);
    if (status == AL_OK) status = write_scene(b, error);
    if (status == AL_OK) status = al_report_write(b->arguments->folder, &b->report, error);
    return status;
}

int main(int argc, char **argv)
{
    arguments a = {.quality = "medium", .devices = "0", .memory_limit_mib = 512, .table_bands = 11,
                   .table_events = 10, .table_distances = 256, .table_cosines = 21, .table_g = 0.5};
    const al_option options[] = {
        {"-o", "DIR", AL_OPTION_STRING, &a.folder, "folder of the baked assets; created when it is missing",
         0, 0},
        {"--plan", NULL, AL_OPTION_FLAG, &a.plan, "only say what would be done and why (JSON)", 0, 0},
        {"--quality", "Q", AL_OPTION_STRING, &a.quality,
         "preview, medium or final: settings the scene leaves open (medium)", 0, 0},
        {"--target-error", "E", AL_OPTION_REAL, &a.target_error,
         "settings of the fastest point of DIR/trade.csv that errs by at most E (airlight-trade makes it)", 1e-9, 1e9},
        {"--list-devices", NULL, AL_OPTION_FLAG, &a.list_devices, "list the OpenCL devices and end", 0, 0},
        {"--device", "N[,N]", AL_OPTION_STRING, &a.devices,
         "OpenCL devices by number; objects go to them in turn (0)", 0, 0},
        {"--threads", "N", AL_OPTION_INT, &a.threads, "CPU threads (one per core)", 1, 256},
        {"--memory-limit", "MIB", AL_OPTION_REAL, &a.memory_limit_mib,
         "memory for swept fields on the device, and for a fog's grid (512)", 16, 1 << 20},
        {"--tables", "FILE.air", AL_OPTION_STRING, &a.tables,
         "make impulse tables alone, of an endless medium; no scene is read", 0, 0},
        {"--table-bands", "N", AL_OPTION_INT, &a.table_bands, "their bands (11)", 3, AL_IMPULSE_BAND_LIMIT},
        {"--table-events", "N", AL_OPTION_INT, &a.table_events, "their scattering events (10)", 1,
         AL_IMPULSE_EVENT_LIMIT},
        {"--table-distances", "N", AL_OPTION_INT, &a.table_distances, "their distances (256)", 16, 512},
        {"--table-cosines", "N", AL_OPTION_INT, &a.table_cosines,
         "their angles of the area emitter, an odd number (21)", 7, 33},
        {"--table-g", "G", AL_OPTION_REAL, &a.table_g,
         "event 1 is also tabulated at g = -G and G, as published (0.5)", 0.01, 0.99},
        {"--table-all-in-one", NULL, AL_OPTION_FLAG, &a.table_all_in_one,
         "also the published single table: beam and all events of a medium that absorbs nothing", 0, 0},
    };
    al_program program = {
        .name = "airlight-bake",
        .usage = "SCENE.json -o DIR [options]",
        .summary =
            "Imports a scene and bakes every asset it needs into DIR, with DIR/report.json. What is up to\n"
            "date is not baked again. Ctrl-C stops cleanly; the same command goes on from there.",
        .options = options,
        .option_count = sizeof options / sizeof *options};
    const char *scene = NULL;
    size_t count;
    int code = al_program_parse(&program, argc, argv, &scene, 0, 1, &count);
    if (code >= 0) return code;

    al_error error = {0};
    al_quality quality = AL_QUALITY_MEDIUM;
    bake b = {.program = &program, .arguments = &a};
    al_status status;
    al_program_catch_signals();
    if (a.list_devices)
        status = list_devices(&error);
    else if (a.tables && scene)
        status = al_fail(&error, AL_USAGE, "--tables makes tables alone: it takes no scene, '%s' is one too many",
                         scene);
    else if (a.tables) {
        status = read_devices(a.devices, &b, &error);
        if (status == AL_OK) status = make_tables(&b, a.tables, &error);
        for (unsigned i = 0; status == AL_OK && program.verbose && i < b.report.steps.count; i++)
            al_program_say(&program, "%s: %.2f s", b.report.steps.steps[i].name, b.report.steps.steps[i].seconds);
    } else if (!scene)
        status = al_fail(&error, AL_USAGE, "a scene file is missing; usage: airlight-bake SCENE.json -o DIR");
    else if (!a.folder && !a.plan)
        status = al_fail(&error, AL_USAGE, "-o DIR is missing: the folder to bake into");
    else if (!a.folder && a.target_error > 0)
        status = al_fail(&error, AL_USAGE, "--target-error needs -o DIR, the folder that airlight-trade filled");
    else {
        status = read_quality(a.quality, &quality, &error);
        if (status == AL_OK) status = read_devices(a.devices, &b, &error);
        if (status == AL_OK) status = bake_scene(&b, scene, quality, &error);
    }
    for (int i = 0; i < 8; i++) al_device_close(b.devices[i]);
    free(b.report.objects);
    al_atlas_free(&b.atlas);
    al_impulse_tables_free(b.tables);
    al_file_close(b.tables_file);
    al_import_free(b.import);
    return al_program_end(&program, status == AL_OK ? 0 : al_program_fail(&program, &error));
}
