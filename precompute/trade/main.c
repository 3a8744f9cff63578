/* airlight-trade: error against time, memory and size over the knobs that a scene needs. */
#define _POSIX_C_SOURCE 200809L
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "front.h"
#include "measure.h"
#include "results.h"
#include "scene.h"
#include "sweep.h"

static al_status make_folder(const char *folder, const char *inner, al_error *error)
{
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s%s%s", folder, *inner ? "/" : "", inner);
    return mkdir(path, 0777) == 0 || errno == EEXIST ? AL_OK : al_fail(error, AL_IO, "%s: cannot make the folder: %s", path, strerror(errno));
}

static al_status make_folders(const al_trade *trade, al_error *error)
{
    static const char *const inner[] = {"", "truth", "bakes", "points"};
    if (strlen(trade->folder) > PATH_MAX - 256)
        return al_fail(error, AL_USAGE, "-o takes a name of at most %d bytes", PATH_MAX - 256);
    al_status status = AL_OK;
    for (int i = 0; i < 4 && !status; i++) status = make_folder(trade->folder, inner[i], error);
    return status;
}

/* The paths that a frame can show with everything asked for. Baked light holds all orders. */
static void choose_truth(al_trade *trade, const al_plans *plans)
{
    bool baked = al_plans_need(plans, true, "lightmap") || al_plans_need(plans, true, "probes");
    trade->max_events = baked ? -1 : 1;
    trade->max_bounces = baked ? -1 : al_plans_need(plans, false, "indirect") ? 2 : 1;
}

static al_status measure_from(al_trade *trade, const json_t *root, const char *truth, int first, al_error *error)
{
    al_status status = AL_OK;
    for (int i = first; i < trade->points.count && !status; i++)
        status = al_point_measure(trade, root, truth, &trade->points.points[i], error);
    return status;
}

static void mark_front(al_points *points)
{
    double errors[AL_POINT_LIMIT], times[AL_POINT_LIMIT];
    bool front[AL_POINT_LIMIT];
    for (int i = 0; i < points->count; i++) {
        errors[i] = points->points[i].left_out ? NAN : points->points[i].relative_rmse;
        times[i] = points->points[i].frame_ms;
    }
    al_front(errors, times, (size_t)points->count, front);
    for (int i = 0; i < points->count; i++) points->points[i].front = front[i];
}

static al_status hold_out(al_trade *trade, const json_t *root, al_error *error)
{
    char truth[PATH_MAX];
    al_status status = al_truth_make(trade, 1, truth, error);
    for (int i = 0; i < trade->points.count && !status; i++)
        if (trade->points.points[i].front) status = al_point_hold_out(trade, root, truth, &trade->points.points[i], error);
    return status;
}

static al_status sweep(al_trade *trade, const json_t *root, al_error *error)
{
    char truth[PATH_MAX];
    al_status status = al_truth_make(trade, 0, truth, error);
    if (status) return status;
    al_sweep_begin(&trade->points, &trade->knobs, trade->only.count > 0);
    al_progress_begin(&trade->progress, trade->program, "points");
    status = measure_from(trade, root, truth, 0, error);
    int first = trade->points.count;
    if (!status) al_sweep_combine(&trade->points, &trade->knobs, trade->combinations);
    if (!status) status = measure_from(trade, root, truth, first, error);
    if (status) return status;
    mark_front(&trade->points);
    status = hold_out(trade, root, error);
    if (!status) al_progress_end(&trade->progress);
    if (!status) status = al_results_csv(trade, error);
    return status ? status : al_results_page(trade, truth, error);
}

static al_status run(al_trade *trade, al_error *error)
{
    json_t *root = NULL;
    al_plans plans = {0};
    al_status status = al_scene_open(trade, &root, error);
    if (!status) status = make_folders(trade, error);
    if (!status) al_progress_begin(&trade->progress, trade->program, "plans");
    if (!status) status = al_plans_make(trade, root, &plans, error);
    if (!status) choose_truth(trade, &plans);
    if (!status)
        status = al_knobs_choose(&trade->knobs, al_plans_need, &plans, al_scene_value, root, &trade->only, error);
    if (!status) status = sweep(trade, root, error);
    if (!status) printf("%s/trade.csv\n%s/trade.html\n", trade->folder, trade->folder);
    al_plans_free(&plans);
    json_decref(root);
    return status;
}

int main(int argc, char **argv)
{
    static al_trade trade = {.size = {192, 192}, .spp = 128, .frames = 4, .combinations = 8};
    const al_option options[] = {
        {"-o", "DIR", AL_OPTION_STRING, &trade.folder, "folder of all that is measured; created when it is missing", 0, 0},
        {"--size", "WxH", AL_OPTION_SIZE, trade.size, "of the pictures (192x192)", 1, 4096},
        {"--spp", "N", AL_OPTION_INT, &trade.spp, "samples a pixel of the truth (128)", 2, 100000000},
        {"--frames", "N", AL_OPTION_INT, &trade.frames, "a point's picture is their mean, its time their median (4)", 1, 10000},
        {"--knob", "NAME[=V,V]", AL_OPTION_LIST, &trade.only,
         "only this knob and medium, with these values, from fast to exact; repeatable", 0, 0},
        {"--combinations", "N", AL_OPTION_INT, &trade.combinations,
         "points where several knobs are turned, chosen by what the others brought (8)", 0, 64},
    };
    al_program program = {
        .name = "airlight-trade",
        .usage = "SCENE.json -o DIR [options]",
        .summary =
            "Measures error against time, memory and size over the knobs that the plans of airlight-bake and\n"
            "airlight-play say this scene needs; writes DIR/trade.csv and DIR/trade.html. Presets, each knob alone\n"
            "around medium (the scene's own bake settings, the player's defaults), then combinations.\n"
            "What is held: the mean of some frames of the player's composite from the scene's first camera, without\n"
            "the shading of translucent surfaces, against airlight-reference --mode volume-path with the paths that\n"
            "frames can show: one scattering event; one reflection, two where surfaces light surfaces; any number\n"
            "where lightmaps or probes are baked. The truth's noise is taken out.\n"
            "What no knob removes: the truth's surfaces are Lambert, the player's also shine and mirror; the truth\n"
            "also has light that media scatter onto surfaces, which frames have only where it was baked.\n"
            "held_out_relative_rmse is the error of front points from the scene's second camera, or the first one\n"
            "turned by 30 degrees. Nothing moves: time is 0. frame_ms is this machine's, while nothing else runs.\n"
            "Ctrl-C stops; what is finished is kept in DIR, and the same command goes on from there.",
        .options = options,
        .option_count = sizeof options / sizeof *options,
    };
    size_t count;
    int code = al_program_parse(&program, argc, argv, &trade.scene, 1, 1, &count);
    if (code >= 0) return code;
    trade.program = &program;
    al_program_catch_signals();
    al_error error = {0};
    al_status status = trade.folder ? run(&trade, &error) : al_fail(&error, AL_USAGE, "-o DIR is missing; see %s --help", program.name);
    return al_program_end(&program, status ? al_program_fail(&program, &error) : AL_OK);
}
