#define _POSIX_C_SOURCE 200809L
#include "report.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include "airlight/container.h"
#include "bake_lightmap.h"
#include "setting.h"

static json_t *plan_array(const al_plan *plan)
{
    json_t *array = json_array();
    for (unsigned i = 0; i < plan->count; i++) {
        const al_plan_step *s = &plan->steps[i];
        json_array_append_new(array,
                              json_pack("{s:s, s:b, s:s, s:f, s:I}", "step", s->step, "needed", s->needed,
                                        "why", s->why, "seconds", s->seconds, "bytes", (json_int_t)s->bytes));
    }
    return array;
}

char *al_plan_json(const al_plan *plan)
{
    json_t *root = json_pack("{s:o}", "plan", plan_array(plan));
    char *text = json_dumps(root, JSON_INDENT(2));
    json_decref(root);
    return text;
}

static void append_steps(json_t *array, const al_steps *steps, const char *object)
{
    for (unsigned i = 0; i < steps->count; i++) {
        const al_step *s = &steps->steps[i];
        json_t *step =
            json_pack("{s:s, s:f, s:I, s:I}", "name", s->name, "seconds", s->seconds, "bytes_written",
                      (json_int_t)s->bytes_written, "items", (json_int_t)s->items);
        if (object) json_object_set_new(step, "object", json_string(object));
        json_array_append_new(array, step);
    }
}

static void append_asset(json_t *array, const char *folder, const char *file, const char *kind)
{
    char path[1400];
    struct stat facts;
    snprintf(path, sizeof path, "%s/%s", folder, file);
    if (stat(path, &facts) != 0) return;
    json_array_append_new(
        array, json_pack("{s:s, s:s, s:I}", "path", file, "kind", kind, "bytes", (json_int_t)facts.st_size));
}

/* What is not an asset of ours is of the kind that its name ends with. */
static void append_lightmap(json_t *array, const char *folder, const al_report *report)
{
    append_asset(array, folder, report->import->scene.baked.lightmap, al_kind_name(AL_KIND_LIGHTMAP));
    for (uint32_t i = 0; i < report->lightmap_page_count; i++) {
        char file[64];
        al_bake_lightmap_page_file(i, file, sizeof file);
        append_asset(array, folder, file, "exr");
    }
    append_asset(array, folder, "scene.glb", "glb");
}

/* What the bake was asked for, by which the player knows a point of airlight-trade again. */
static json_t *list_settings(al_scene_description *description)
{
    json_t *list = json_object();
    al_setting setting;
    for (int i = 0; al_setting_at(description, i, &setting); i++)
        json_object_set_new(list, setting.name, json_integer(*setting.value));
    return list;
}

al_status al_report_write(const char *folder, const al_report *report, al_error *error)
{
    const al_scene *scene = &report->import->scene;
    json_t *steps = json_array(), *inputs = json_array(), *assets = json_array();
    char path[1200], hash[17];
    append_steps(steps, &report->steps, NULL);
    append_steps(steps, &report->light, NULL);
    for (uint32_t i = 0; i < scene->translucent_count; i++)
        append_steps(steps, &report->objects[i], scene->translucents[i].name);
    for (uint32_t i = 0; i < report->import->input_count; i++) {
        snprintf(hash, sizeof hash, "%016llx", (unsigned long long)report->import->inputs[i].xxh64);
        json_array_append_new(inputs,
                              json_pack("{s:s, s:s}", "path", report->import->inputs[i].path, "xxh64", hash));
    }
    append_asset(assets, folder, "scene.air", al_kind_name(AL_KIND_SCENE));
    if (al_plan_needs_tables(report->import))
        append_asset(assets, folder, "impulse-tables.air", al_kind_name(AL_KIND_IMPULSE_TABLES));
    for (uint32_t i = 0; i < scene->translucent_count; i++)
        append_asset(assets, folder, scene->translucents[i].asset, al_kind_name(AL_KIND_TRANSLUCENT));
    for (uint32_t i = 0; i < scene->fog_count; i++)
        if (*scene->fogs[i].asset)
            append_asset(assets, folder, scene->fogs[i].asset, al_kind_name(AL_KIND_MEDIUM));
    if (*scene->baked.probes) append_asset(assets, folder, scene->baked.probes, al_kind_name(AL_KIND_PROBES));
    if (*scene->baked.lightmap) append_lightmap(assets, folder, report);
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    json_t *root =
        json_pack("{s:o, s:o, s:o, s:o, s:o, s:s, s:s, s:I}", "plan", plan_array(report->plan), "settings",
                  list_settings(report->import->description), "steps", steps, "inputs", inputs, "assets", assets, "device", report->device, "tool_version",
                  "airlight-bake " AIRLIGHT_VERSION, "peak_memory_bytes", (json_int_t)usage.ru_maxrss * 1024);
    if (report->pick.knob_count)
        json_object_set_new(root, "expected", json_pack("{s:f, s:o, s:f, s:f}", "relative_rmse", report->pick.relative_rmse, "held_out_relative_rmse",
                                                        isfinite(report->pick.held_out_relative_rmse)
                                                            ? json_real(report->pick.held_out_relative_rmse)
                                                            : json_null(), "seconds",
                                                        report->pick.seconds, "frame_ms", report->pick.frame_ms));
    char *text = root ? json_dumps(root, JSON_INDENT(2)) : NULL;
    json_decref(root);
    snprintf(path, sizeof path, "%s/report.json", folder);
    if (!text) return al_fail(error, AL_IO, "%s: out of memory", path);
    al_status status = al_write_file(path, text, strlen(text), error);
    free(text);
    return status;
}
