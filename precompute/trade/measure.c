#include "measure.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include "airlight/container.h"
#include "airlight/trade_table.h"
#include "scene.h"
#include "sibling.h"

/* FOLDER/..., which must fit. */
static void path_in(const al_trade *trade, char path[PATH_MAX], const char *format, ...) AL_PRINTF(3, 4);
static void path_in(const al_trade *trade, char path[PATH_MAX], const char *format, ...)
{
    va_list arguments;
    int used = snprintf(path, PATH_MAX, "%s/", trade->folder); /* main refuses longer ones */
    va_start(arguments, format);
    vsnprintf(path + used, (size_t)(PATH_MAX - used), format, arguments);
    va_end(arguments);
}

static al_status write_json(const char *path, json_t *root, al_error *error)
{
    char *text = json_dumps(root, JSON_INDENT(2) | JSON_REAL_PRECISION(12));
    al_status status = text ? al_write_file(path, text, strlen(text), error) : al_fail(error, AL_IO, "%s: out of memory", path);
    free(text);
    json_decref(root);
    return status;
}

static json_t *parse(const char *text, const char *name, al_error *error)
{
    json_t *root = json_loads(text, 0, NULL);
    if (!root) al_fail(error, AL_IO, "%s: its answer is no JSON", name);
    return root;
}

static double number(const json_t *object, const char *key)
{
    const json_t *value = json_object_get(object, key);
    return json_is_number(value) ? json_number_value(value) : NAN;
}

al_status al_truth_make(al_trade *trade, int camera, char stem[PATH_MAX], al_error *error)
{
    char words[256], scene[PATH_MAX], path[PATH_MAX];
    snprintf(words, sizeof words, "%s volume-path %d %d %d %dx%d %s %016llx", AIRLIGHT_VERSION, trade->spp, trade->max_events,
             trade->max_bounces, trade->size[0], trade->size[1], trade->cameras[camera],
             (unsigned long long)trade->camera_content[camera]);
    path_in(trade, stem, "truth/%016llx", (unsigned long long)XXH64(words, strlen(words), trade->content));
    snprintf(path, sizeof path, "%.*s.exr", PATH_MAX - 8, stem);
    path_in(trade, scene, "scene.json");
    if (access(path, R_OK) == 0) return AL_OK;
    al_program_say(trade->program, "ground truth from \"%s\": %d samples a pixel, kept for the next time", trade->cameras[camera],
                   trade->spp);
    al_progress_begin(&trade->progress, trade->program, "ground truth");
    al_command command;
    al_command_begin(&command, "airlight-reference");
    al_command_add(&command, "%s", scene);
    al_command_add(&command, "--quiet");
    al_command_add(&command, "--mode=volume-path");
    al_command_add(&command, "--spp=%d", trade->spp);
    al_command_add(&command, "--size=%dx%d", trade->size[0], trade->size[1]);
    al_command_add(&command, "--camera=%s", trade->cameras[camera]);
    if (trade->max_events >= 0) al_command_add(&command, "--max-events=%d", trade->max_events);
    if (trade->max_bounces >= 0) al_command_add(&command, "--max-bounces=%d", trade->max_bounces);
    al_command_add(&command, "-o");
    al_command_add(&command, "%s", path);
    return al_command_run(trade, &command, NULL, error);
}

static uint64_t bake_key(const al_trade *trade, const char *scene_text)
{
    return XXH64(scene_text, strlen(scene_text), trade->content);
}

static void bake_folder(const al_trade *trade, const char *scene_text, char folder[PATH_MAX])
{
    path_in(trade, folder, "bakes/%016llx", (unsigned long long)bake_key(trade, scene_text));
}

/* A bake that was stopped begins anew: its seconds would not be those of the whole. */
static al_status bake(al_trade *trade, const char *scene_text, const char *folder, al_error *error)
{
    char scene[PATH_MAX], seconds[PATH_MAX];
    snprintf(scene, sizeof scene, "%.*s.json", PATH_MAX - 8, folder);
    snprintf(seconds, sizeof seconds, "%.*s.seconds.json", PATH_MAX - 16, folder);
    if (access(seconds, R_OK) == 0) return AL_OK;
    char report[PATH_MAX];
    snprintf(report, sizeof report, "%.*s/report.json", PATH_MAX - 16, folder);
    al_status status = al_write_file(scene, scene_text, strlen(scene_text), error);
    if (status) return status;
    al_command command;
    al_command_begin(&command, "airlight-bake");
    al_command_add(&command, "%s", scene);
    al_command_add(&command, "-o");
    al_command_add(&command, "%s", folder);
    al_command_add(&command, "--quiet");
    double begun = al_program_seconds();
    status = al_command_run(trade, &command, NULL, error);
    if (status) return status;
    return write_json(seconds, json_pack("{s:f}", "seconds", al_program_seconds() - begun), error);
}

static al_status read_bake(const char *folder, al_point *point, al_error *error)
{
    char path[PATH_MAX];
    size_t i;
    json_t *asset, *report, *seconds;
    snprintf(path, sizeof path, "%.*s.seconds.json", PATH_MAX - 16, folder);
    seconds = json_load_file(path, 0, NULL);
    snprintf(path, sizeof path, "%.*s/report.json", PATH_MAX - 16, folder);
    report = json_load_file(path, 0, NULL);
    point->seconds = number(seconds, "seconds");
    point->asset_bytes = 0;
    json_array_foreach(json_object_get(report, "assets"), i, asset) point->asset_bytes += number(asset, "bytes");
    bool good = report && isfinite(point->seconds) && isfinite(point->asset_bytes);
    json_decref(seconds);
    json_decref(report);
    return good ? AL_OK : al_fail(error, AL_BAD_INPUT, "%s: not the report of a whole bake; remove %s and run again", path, folder);
}

static void add_play_knobs(const al_trade *trade, const al_point *point, al_command *command)
{
    for (int k = 0; k < trade->knobs.count; k++) {
        const char *name = trade->knobs.knobs[k].name, *value = trade->knobs.knobs[k].values[point->chosen[k]];
        char words[2][2 * AL_TRADE_TEXT_SIZE];
        int count = al_trade_knob_words(name, value, words);
        for (int i = 0; i < count; i++) al_command_add(command, "%s", words[i]);
    }
}

static void begin_play(const al_trade *trade, const al_point *point, int camera, const char *folder, al_command *command)
{
    al_command_begin(command, "airlight-play");
    al_command_add(command, "%s", folder);
    al_command_add(command, "--headless");
    al_command_add(command, "--quiet");
    al_command_add(command, "--size=%dx%d", trade->size[0], trade->size[1]);
    al_command_add(command, "--frames=%d", trade->frames);
    al_command_add(command, "--fps=1000000"); /* nothing moves */
    al_command_add(command, "--accumulate");
    al_command_add(command, "--no-surface");
    al_command_add(command, "--camera=%s", trade->cameras[camera]);
    add_play_knobs(trade, point, command);
}

static al_status compare(al_trade *trade, const char *picture, const char *truth, const char *difference, json_t **metrics,
                         al_error *error)
{
    char *text = NULL;
    al_command command;
    al_command_begin(&command, "airlight-compare");
    al_command_add(&command, "%s", picture);
    al_command_add(&command, "%s.exr", truth);
    al_command_add(&command, "--error=%s.error.exr", truth);
    if (difference) al_command_add(&command, "--diff=%s", difference);
    al_command_add(&command, "--json");
    *metrics = NULL;
    al_status status = al_command_run(trade, &command, &text, error);
    if (!status && !(*metrics = parse(text, command.program, error))) status = AL_IO;
    free(text);
    return status;
}

/* A point's file: what was baked, played and held against what. */
static void name_point(const al_trade *trade, const char *scene_text, const char *truth, al_point *point)
{
    al_command command;
    begin_play(trade, point, 0, "", &command);
    uint64_t key = bake_key(trade, scene_text);
    key = XXH64(command.text, command.used, key);
    key = XXH64(truth + strlen(truth) - 16, 16, key);
    snprintf(point->picture, sizeof point->picture, "%016llx", (unsigned long long)key);
}

static bool read_point(const char *path, al_point *point)
{
    json_t *root = json_load_file(path, 0, NULL);
    if (!root) return false;
    point->left_out = json_is_true(json_object_get(root, "left_out"));
    point->relative_rmse = number(root, "relative_rmse");
    point->flip_ldr = number(root, "flip_ldr");
    point->seconds = number(root, "seconds");
    point->frame_ms = number(root, "frame_ms");
    point->memory_bytes = number(root, "memory_bytes");
    point->asset_bytes = number(root, "asset_bytes");
    json_decref(root);
    return true;
}

static al_status play(al_trade *trade, const char *folder, const char *truth, al_point *point, al_error *error)
{
    char picture[PATH_MAX], difference[PATH_MAX], stats_path[PATH_MAX];
    path_in(trade, picture, "points/%s.exr", point->picture);
    path_in(trade, difference, "points/%s.difference.png", point->picture);
    path_in(trade, stats_path, "points/%s.stats.json", point->picture);
    al_command command;
    begin_play(trade, point, 0, folder, &command);
    al_command_add(&command, "--out=%s", picture);
    al_command_add(&command, "--stats=%s", stats_path);
    json_t *metrics = NULL;
    al_status status = al_command_run(trade, &command, NULL, error);
    if (!status) status = compare(trade, picture, truth, difference, &metrics, error);
    if (status) return status;
    json_t *stats = json_load_file(stats_path, 0, NULL);
    point->frame_ms = number(stats, "frame_ms_median");
    point->memory_bytes = number(stats, "memory_bytes");
    point->relative_rmse = number(metrics, "relative_rmse_without_noise");
    point->flip_ldr = number(metrics, "flip_ldr");
    json_decref(stats);
    json_decref(metrics);
    unlink(stats_path);
    return isfinite(point->frame_ms) && isfinite(point->relative_rmse)
               ? AL_OK
               : al_fail(error, AL_BAD_INPUT, "%s: nothing to measure: the truth is black from camera \"%s\"", trade->scene,
                         trade->cameras[0]);
}

al_status al_point_measure(al_trade *trade, const json_t *root, const char *truth, al_point *point, al_error *error)
{
    char folder[PATH_MAX], path[PATH_MAX], description[512];
    char *text = al_scene_derive(root, &trade->knobs, point);
    if (!text) return al_fail(error, AL_IO, "out of memory for a scene");
    al_point named = *point;
    name_point(trade, text, truth, &named);
    path_in(trade, path, "points/%s.json", named.picture);
    bake_folder(trade, text, folder);
    al_status status = AL_OK;
    if (!read_point(path, &named)) {
        status = bake(trade, text, folder, error);
        if (status == AL_BAD_INPUT && point != trade->points.points) { /* medium must bake */
            al_point_describe(trade, point, description, sizeof description);
            al_program_say(trade->program, "%s is left out: %s", description, error->message);
            named.left_out = true;
            status = write_json(path, json_pack("{s:b}", "left_out", 1), error);
        } else if (!status) {
            status = read_bake(folder, &named, error);
            if (!status) status = play(trade, folder, truth, &named, error);
            if (!status)
                status = write_json(path, json_pack("{s:f, s:f, s:f, s:f, s:f, s:f}", "relative_rmse", named.relative_rmse,
                                                    "flip_ldr", named.flip_ldr, "seconds", named.seconds, "frame_ms",
                                                    named.frame_ms, "memory_bytes", named.memory_bytes, "asset_bytes",
                                                    named.asset_bytes), error);
        }
    }
    if (!status) *point = named;
    free(text);
    return status;
}

al_status al_point_hold_out(al_trade *trade, const json_t *root, const char *truth, al_point *point, al_error *error)
{
    char folder[PATH_MAX], path[PATH_MAX], picture[PATH_MAX];
    const char *name = truth + strlen(truth) - 16;
    path_in(trade, path, "points/%s.%s.held_out.json", point->picture, name);
    path_in(trade, picture, "points/%s.%s.held_out.exr", point->picture, name);
    json_t *metrics = json_load_file(path, 0, NULL);
    al_status status = AL_OK;
    if (!metrics) {
        char *text = al_scene_derive(root, &trade->knobs, point);
        if (!text) return al_fail(error, AL_IO, "out of memory for a scene");
        bake_folder(trade, text, folder);
        free(text);
        al_command command;
        begin_play(trade, point, 1, folder, &command);
        al_command_add(&command, "--out=%s", picture);
        status = al_command_run(trade, &command, NULL, error);
        if (!status) status = compare(trade, picture, truth, NULL, &metrics, error);
        if (!status) status = write_json(path, json_incref(metrics), error);
        unlink(picture);
    }
    if (!status) point->held_out_relative_rmse = number(metrics, "relative_rmse_without_noise");
    json_decref(metrics);
    return status;
}

void al_point_describe(const al_trade *trade, const al_point *point, char *text, size_t size)
{
    snprintf(text, size, "%s", point->preset);
    for (int k = 0; k < trade->knobs.count && !*point->preset; k++) {
        const al_knob *knob = &trade->knobs.knobs[k];
        if (point->chosen[k] == knob->medium) continue;
        size_t used = strlen(text);
        snprintf(text + used, size - used, "%s%s=%s", used ? ", " : "", knob->name, knob->values[point->chosen[k]]);
    }
}

al_status al_plans_make(al_trade *trade, const json_t *root, al_plans *plans, al_error *error)
{
    static const al_knobs none = {0};
    static const al_point medium = {0};
    char folder[PATH_MAX], scene[PATH_MAX], *text = al_scene_derive(root, &none, &medium), *answer = NULL;
    *plans = (al_plans){0};
    if (!text) return al_fail(error, AL_IO, "out of memory for a scene");
    path_in(trade, scene, "scene.json");
    bake_folder(trade, text, folder);
    al_status status = al_write_file(scene, text, strlen(text), error);
    al_command command;
    al_command_begin(&command, "airlight-bake");
    al_command_add(&command, "%s", scene);
    al_command_add(&command, "-o");
    al_command_add(&command, "%s", folder);
    al_command_add(&command, "--plan");
    if (!status) status = al_command_run(trade, &command, &answer, error);
    if (!status && !(plans->bake = parse(answer, command.program, error))) status = AL_IO;
    if (!status) status = bake(trade, text, folder, error);
    al_command_begin(&command, "airlight-play");
    al_command_add(&command, "%s", folder);
    al_command_add(&command, "--plan");
    al_command_add(&command, "--quiet");
    al_command_add(&command, "--size=%dx%d", trade->size[0], trade->size[1]);
    if (!status) status = al_command_run(trade, &command, &plans->play, error);
    free(answer);
    free(text);
    if (status) al_plans_free(plans);
    return status;
}

void al_plans_free(al_plans *plans)
{
    json_decref(plans->bake);
    free(plans->play);
    *plans = (al_plans){0};
}

/* A line of the player's plan: the step, spaces, yes or no, time and bytes, why. */
static bool play_needs(const char *plan, const char *step)
{
    size_t length = strlen(step);
    for (const char *line = plan; line && *line; line = strchr(line, '\n'), line += line != NULL) {
        if (strncmp(line, step, length) || line[length] != ' ') continue;
        const char *word = line + length + strspn(line + length, " "), *request = strstr(word, "on request");
        return !strncmp(word, "yes", 3) || (request && request < word + strcspn(word, "\n"));
    }
    return false;
}

bool al_plans_need(const void *both, bool bake, const char *step)
{
    const al_plans *plans = both;
    size_t i;
    json_t *row;
    if (!bake) return play_needs(plans->play, step);
    json_array_foreach(json_object_get(plans->bake, "plan"), i, row) {
        const char *name = json_string_value(json_object_get(row, "step"));
        if (name && !strcmp(name, step)) return json_is_true(json_object_get(row, "needed"));
    }
    return false;
}
