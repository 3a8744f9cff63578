#include "options.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "picture.h"

/* What the parser writes to before it becomes settings. */
typedef struct raw_options {
    const char *pass, *view_leg, *second_leg, *scattered, *interval_weights, *occlusion_carrier, *indirect_carrier;
    int samples, sh_order, intervals, fog_steps, shell_levels, shown_level, second_leg_steps, blur, bounce_samples, surfel_limit,
        bounce_filter, screen_steps, temporal;
    double march_step, shell_epsilon, shell_radius, surfel_size, surfel_margin, bounce_radius, bounce_overlap, occlusion_radius,
        screen_thickness;
    bool surfels_plain, no_surface, no_background, no_clip, no_normalise, no_shadows, no_lod, no_fog, no_surface_scattering,
        shells_closed, shells_clamped, no_second_leg, blur_plain, visibility, bounce_near_off, occlusion_uniform,
        indirect, lambert_senders, ambient_occlusion, temporal_undoubted;
} raw_options;

static int refuse(const al_program *program, const char *format, ...) AL_PRINTF(2, 3);
static int refuse(const al_program *program, const char *format, ...)
{
    al_error error = {.status = AL_USAGE};
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error.message, sizeof error.message, format, arguments);
    va_end(arguments);
    return al_program_fail(program, &error);
}

static int set_pass(const al_program *program, const char *name, al_pass *pass)
{
    char names[512] = "";
    for (int i = 0; i < AL_PASS_COUNT; i++) {
        const char *known = al_pass_name((al_pass)i);
        if (!strcmp(name, known)) return *pass = (al_pass)i, -1;
        size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%s", used ? ", " : "", known);
    }
    return refuse(program, "--pass takes one of %s, not '%s'", names, name);
}

static int set_view_leg(const al_program *program, const char *name, al_view_leg *leg)
{
    if (!strcmp(name, "marched")) return *leg = AL_VIEW_LEG_MARCHED, -1;
    if (!strcmp(name, "sh")) return *leg = AL_VIEW_LEG_SH, -1;
    return refuse(program, "--view-leg takes marched or sh, not '%s'", name);
}

static int set_second_leg(const al_program *program, const char *name, al_settings *settings)
{
    if (!strcmp(name, "none")) settings->second_leg_off = true;
    settings->second_leg = !strcmp(name, "baked") ? AL_SECOND_LEG_BAKED : AL_SECOND_LEG_MARCHED;
    if (settings->second_leg == AL_SECOND_LEG_BAKED || !strcmp(name, "none") || !strcmp(name, "marched")) return -1;
    return refuse(program, "--second-leg takes marched, baked or none, not '%s'", name);
}

static int set_scattered(const al_program *program, const char *word, bool *off)
{
    if (!strcmp(word, "on")) return *off = false, -1;
    if (!strcmp(word, "off")) return *off = true, -1;
    return refuse(program, "--scattered takes on or off, not '%s'", word);
}

static int set_interval_weights(const al_program *program, const char *word, al_interval_weights *weights)
{
    static const char *const words[AL_INTERVAL_WEIGHTS_COUNT] = {"auto", "coloured", "coefficients"};
    for (int i = 0; i < AL_INTERVAL_WEIGHTS_COUNT; i++)
        if (!strcmp(word, words[i])) return *weights = (al_interval_weights)i, -1;
    return refuse(program, "--interval-weights takes auto, coloured or coefficients, not '%s'", word);
}

/* -1, or what a wrong word is answered with. `hides`: of what is hidden; blended volumes know nothing of what is sent. */
static int set_carrier(const al_program *program, const char *option, const char *word, bool hides, al_carrier *carrier)
{
    static const char *const words[AL_CARRIER_COUNT] = {"surfels", "surfels-blended", "volumes", "volumes-blended", "screen"};
    for (int i = 0; i < AL_CARRIER_COUNT; i++)
        if (!strcmp(word, words[i]) && (hides || i != AL_CARRIER_VOLUMES_BLENDED)) return *carrier = (al_carrier)i, -1;
    return refuse(program, "%s takes surfels, surfels-blended, volumes%s or screen, not '%s'", option,
                  hides ? ", volumes-blended" : "", word);
}

/* Rays that --pass could show: not by carriers that add up. */
static bool sends_rays(const al_settings *s)
{
    al_carrier carrier = s->indirect ? s->indirect_carrier : s->occlusion_carrier;
    return s->visibility || (carrier != AL_CARRIER_SURFELS_BLENDED && carrier != AL_CARRIER_VOLUMES_BLENDED);
}

static int check(const al_program *program, al_play_options *options)
{
    if (options->headless && !options->folder)
        return refuse(program, "--headless needs the baked folder to draw; see %s --help", program->name);
    if (!options->headless && (options->out.count || options->stats || options->accumulate ||
                               options->first_picture || options->frames || options->fps > 0))
        return refuse(program,
                      "--out, --stats, --frames, --fps, --accumulate and --first-picture need --headless");
    if (options->plan && (options->out.count || options->stats || options->watch))
        return refuse(program, "--plan writes no files and ends; leave out --out, --stats and --watch");
    const al_settings *s = &options->settings;
    if ((s->pass == AL_PASS_BOUNCE_RAYS || s->pass == AL_PASS_BOUNCE_HITS) && !sends_rays(s))
        return refuse(program, "blended carriers send no rays that --pass %s could show; take another one", al_pass_name(s->pass));
    if (!options->frames) options->frames = 1;
    if (!(options->fps > 0)) options->fps = 60;
    for (int i = 0; i < options->out.count; i++) {
        const char *path = options->out.values[i];
        if (!al_picture_has_ending(path, ".exr") && !al_picture_has_ending(path, ".png"))
            return refuse(program, "--out takes a name that ends in .exr or .png, not '%s'", path);
    }
    return -1;
}

static int apply(const al_program *program, const raw_options *raw, al_play_options *options)
{
    al_settings *s = &options->settings;
    s->sample_limit = (uint32_t)raw->samples;
    s->sh_order = (uint32_t)raw->sh_order;
    s->interval_count = (uint32_t)raw->intervals;
    s->march_voxels = (float)raw->march_step;
    s->surface_off = raw->no_surface;
    s->background_off = raw->no_background;
    s->clip_off = raw->no_clip;
    s->normalise_off = raw->no_normalise;
    s->shadows_off = raw->no_shadows;
    s->detail_off = raw->no_lod;
    s->fog_off = raw->no_fog;
    s->fog_steps = (uint32_t)raw->fog_steps;
    s->surface_scattering_off = raw->no_surface_scattering;
    s->surfel_pixels = (float)raw->surfel_size;
    s->surfels_plain = raw->surfels_plain;
    s->surfel_limit = (uint32_t)raw->surfel_limit;
    s->surfel_margin_m = (float)raw->surfel_margin;
    s->shell_epsilon_w_m2_sr = (float)raw->shell_epsilon;
    s->shell_levels = (uint32_t)raw->shell_levels;
    s->shown_level = (uint32_t)raw->shown_level;
    s->shell_radius_m = (float)raw->shell_radius;
    s->shells_closed = raw->shells_closed;
    s->shells_clamped = raw->shells_clamped;
    s->second_leg_off = raw->no_second_leg;
    s->second_leg_steps = (uint32_t)raw->second_leg_steps;
    s->visibility = raw->visibility;
    s->indirect = raw->indirect;
    s->indirect_lambert = raw->lambert_senders;
    s->ambient_occlusion = raw->ambient_occlusion;
    s->bounce_samples = (uint32_t)raw->bounce_samples;
    s->bounce_radius_m = (float)raw->bounce_radius;
    s->bounce_overlap = (float)raw->bounce_overlap;
    s->bounce_near_off = raw->bounce_near_off;
    s->bounce_filter_off = raw->bounce_filter == 0;
    s->bounce_filter = raw->bounce_filter > 0 ? (uint32_t)raw->bounce_filter : 0;
    s->occlusion_radius_m = (float)raw->occlusion_radius;
    s->occlusion_uniform = raw->occlusion_uniform;
    s->screen_steps = (uint32_t)raw->screen_steps;
    s->screen_thickness_m = (float)raw->screen_thickness;
    s->temporal = (uint32_t)raw->temporal;
    s->temporal_undoubted = raw->temporal_undoubted;
    s->blur_off = raw->blur == 0;
    s->blur_mips = raw->blur > 0 ? (uint32_t)raw->blur : 0;
    s->blur_plain = raw->blur_plain;
    options->headless |= options->plan;
    int code = set_pass(program, raw->pass, &s->pass);
    if (code < 0) code = set_view_leg(program, raw->view_leg, &s->view_leg);
    if (code < 0) code = set_second_leg(program, raw->second_leg, s);
    if (code < 0) code = set_scattered(program, raw->scattered, &s->scattered_off);
    if (code < 0) code = set_interval_weights(program, raw->interval_weights, &s->interval_weights);
    if (code < 0) code = set_carrier(program, "--occlusion-carrier", raw->occlusion_carrier, true, &s->occlusion_carrier);
    if (code < 0) code = set_carrier(program, "--indirect-carrier", raw->indirect_carrier, false, &s->indirect_carrier);
    return code < 0 ? check(program, options) : code;
}

static int parse(al_program *program, int argc, char **argv, al_play_options *options)
{
    raw_options raw = {.pass = "composite", .view_leg = "marched", .second_leg = "marched", .scattered = "on",
                       .interval_weights = "auto", .occlusion_carrier = "surfels", .indirect_carrier = "surfels", .blur = -1, .bounce_filter = -1};
    *options = (al_play_options){.size = {1280, 720}, .exposure_ev = NAN};
    const al_option table[] = {
        {"--headless", NULL, AL_OPTION_FLAG, &options->headless, "render without a display, then end", 0, 0},
        {"--size", "WxH", AL_OPTION_SIZE, options->size, "picture or window size (1280x720)", 1, 8192},
        {"--frames", "N", AL_OPTION_INT, &options->frames, "headless: how many frames (1)", 1, 1e6},
        {"--fps", "F", AL_OPTION_REAL, &options->fps, "headless: frame i shows time i / F, begun anew after the last key (60)", 1e-3, 1e6},
        {"--out", "FILE", AL_OPTION_LIST, &options->out,
         "headless: FILE.exr (linear) or FILE.png; %04d for every frame; may be repeated", 0, 0},
        {"--accumulate", NULL, AL_OPTION_FLAG, &options->accumulate,
         "headless: average the frames, antialiased", 0, 0},
        {"--stats", "FILE", AL_OPTION_STRING, &options->stats, "headless: write times and sizes as JSON", 0,
         0},
        {"--first-picture", NULL, AL_OPTION_FLAG, &options->first_picture,
         "headless: draw while loading, to time the first picture", 0, 0},
        {"--camera", "NAME", AL_OPTION_STRING, &options->camera, "a camera of the scene (its first)", 0, 0},
        {"--exposure", "EV", AL_OPTION_REAL, &options->exposure_ev,
         "brightness 2^EV of windows and PNG (the scene's)", -60, 60},
        {"--pass", "NAME", AL_OPTION_STRING, &raw.pass, "show one intermediate buffer; a wrong NAME lists them (composite)", 0, 0},
        {"--plan", NULL, AL_OPTION_FLAG, &options->plan,
         "only say which passes a frame with the other options runs, why, their times and the bytes held", 0, 0},
        {"--target-error", "E", AL_OPTION_REAL, &options->target_error,
         "knobs of the fastest point of DIR/trade.csv that errs by at most E (airlight-trade makes it)", 1e-9, 1e9},
        {"--frame-ms", "T", AL_OPTION_REAL, &options->frame_ms,
         "knobs of its most exact point that takes at most T ms; with both the fastest that meets both", 1e-6, 1e9},
        {"--watch", NULL, AL_OPTION_FLAG, &options->watch, "load what was baked anew", 0, 0},
        {"--samples", "N", AL_OPTION_INT, &raw.samples, "samples per object, at most (all)", 1, 2147483647},
        {"--sh-order", "N", AL_OPTION_INT, &raw.sh_order, "bands of spherical harmonics (as baked)", 1, 8},
        {"--view-leg", "KIND", AL_OPTION_STRING, &raw.view_leg,
         "transmittance to the eye: marched or sh (marched)", 0, 0},
        {"--intervals", "N", AL_OPTION_INT, &raw.intervals, "knots of the interval maps (16)", 4, 32},
        {"--march-step", "V", AL_OPTION_REAL, &raw.march_step, "step of the march in voxels (0.5)", 0.01,
         100},
        {"--no-surface", NULL, AL_OPTION_FLAG, &raw.no_surface, "no shading of translucent surfaces", 0, 0},
        {"--no-background", NULL, AL_OPTION_FLAG, &raw.no_background, "black instead of the environment", 0,
         0},
        {"--no-clip", NULL, AL_OPTION_FLAG, &raw.no_clip, "splats are not clipped by the boundary", 0, 0},
        {"--no-normalise", NULL, AL_OPTION_FLAG, &raw.no_normalise,
         "do not divide by what the Gaussians lose", 0, 0},
        {"--no-shadows", NULL, AL_OPTION_FLAG, &raw.no_shadows, "no shadow maps, no tinted shadows", 0, 0},
        {"--no-lod", NULL, AL_OPTION_FLAG, &raw.no_lod, "all samples at any distance", 0, 0},
        {"--no-fog", NULL, AL_OPTION_FLAG, &raw.no_fog, "clear air; lightmaps and probes show their light without fog", 0, 0},
        {"--scattered", "WORD", AL_OPTION_STRING, &raw.scattered,
         "light in lightmaps and probes that fog has scattered: on or off (on)", 0, 0},
        {"--fog-steps", "N", AL_OPTION_INT, &raw.fog_steps,
         "cells along a ray through fog, for each light (32)", 1, 1024},
        {"--no-surface-scattering", NULL, AL_OPTION_FLAG, &raw.no_surface_scattering,
         "no light from surfaces in the fog", 0, 0},
        {"--surfel-size", "PIXELS", AL_OPTION_REAL, &raw.surfel_size,
         "radius of the surfels that send light into the fog (4.6, less where the picture is smaller than 74)", 0.1, 1000},
        {"--surfel-margin", "M", AL_OPTION_REAL, &raw.surfel_margin,
         "surfels farther outside of the view, metres, are left out (none is)", 1e-6, 1e6},
        {"--surfels-plain", NULL, AL_OPTION_FLAG, &raw.surfels_plain, "surfels as published in 2014, for comparison", 0, 0},
        {"--surfel-limit", "N", AL_OPTION_INT, &raw.surfel_limit,
         "the most surfels; they are larger where there would be more (1048576)", 64, 4194304},
        {"--shell-epsilon", "L", AL_OPTION_REAL, &raw.shell_epsilon,
         "radiance a splat may leave out, W/(m2 sr) (0.06 as the exposure shows it)", 1e-12, 1e12},
        {"--shell-levels", "N", AL_OPTION_INT, &raw.shell_levels, "levels of the splatted picture (6)", 1, 7},
        {"--shown-level", "N", AL_OPTION_INT, &raw.shown_level, "the level or layer that --pass shells, unshuffled, blurred and shadow-map show (0)", 0, 400},
        {"--shell-radius", "M", AL_OPTION_REAL, &raw.shell_radius, "radius of the innermost shell in m (by epsilon)", 1e-6,
         1e6},
        {"--shells-closed", NULL, AL_OPTION_FLAG, &raw.shells_closed, "the outermost shell ends by epsilon too", 0, 0},
        {"--shells-clamped", NULL, AL_OPTION_FLAG, &raw.shells_clamped, "light of near surfels is clamped", 0, 0},
        {"--second-leg", "KIND", AL_OPTION_STRING, &raw.second_leg,
         "extinction between surfaces and fog: marched, baked (media with optical_depth_order) or none (marched)", 0, 0},
        {"--no-second-leg", NULL, AL_OPTION_FLAG, &raw.no_second_leg, "the same as --second-leg none", 0, 0},
        {"--second-leg-steps", "N", AL_OPTION_INT, &raw.second_leg_steps, "steps between surface and fog through grids (4)", 1, 64},
        {"--interval-weights", "KIND", AL_OPTION_STRING, &raw.interval_weights,
         "what the interval map stores: auto, coloured or coefficients (auto)", 0, 0},
        {"--blur", "N", AL_OPTION_INT, &raw.blur, "mips of the blur, 0: none (1; with --visibility 3)", 0, 4},
        {"--blur-plain", NULL, AL_OPTION_FLAG, &raw.blur_plain, "blurs the medium's outline too", 0, 0},
        {"--visibility", NULL, AL_OPTION_FLAG, &raw.visibility, "surfaces hide others from the fog", 0, 0},
        {"--indirect", NULL, AL_OPTION_FLAG, &raw.indirect, "light off one surface onto others, where nothing baked holds it", 0, 0},
        {"--lambert-senders", NULL, AL_OPTION_FLAG, &raw.lambert_senders, "it comes off matt surfaces alone, not off highlights", 0, 0},
        {"--ambient-occlusion", NULL, AL_OPTION_FLAG, &raw.ambient_occlusion, "surfaces hide the environment's light from each other", 0, 0},
        {"--bounce-samples", "N", AL_OPTION_INT, &raw.bounce_samples, "directions a pixel of --visibility, --indirect and ambient occlusion (4)", 1, 64},
        {"--bounce-radius", "M", AL_OPTION_REAL, &raw.bounce_radius, "radius of their innermost shell in m (1/32 of the scene, from surfaces 1/4)", 1e-6,
         1e6},
        {"--bounce-overlap", "F", AL_OPTION_REAL, &raw.bounce_overlap, "what their discs' areas are multiplied by, on surfaces where they do not poke out (3)", 1, 16},
        {"--bounce-near-off", NULL, AL_OPTION_FLAG, &raw.bounce_near_off, "they throw near fragments away", 0, 0},
        {"--bounce-filter", "N", AL_OPTION_INT, &raw.bounce_filter,
         "pixels to each side whose rays a surface takes too, 0: none (2)", 0, 16},
        {"--temporal", "N", AL_OPTION_INT, &raw.temporal,
         "frames that earlier light on surfaces may weigh as much as (0: none)", 0, 1024},
        {"--temporal-undoubted", NULL, AL_OPTION_FLAG, &raw.temporal_undoubted,
         "also where light has changed: it ghosts, for comparison", 0, 0},
        {"--occlusion-radius", "M", AL_OPTION_REAL, &raw.occlusion_radius, "farther surfaces do not occlude, m (no limit)",
         1e-6, 1e6},
        {"--occlusion-carrier", "KIND", AL_OPTION_STRING, &raw.occlusion_carrier,
         "what finds what occludes: surfels or volumes; -blended: no z-buffer; screen (surfels)", 0, 0},
        {"--indirect-carrier", "KIND", AL_OPTION_STRING, &raw.indirect_carrier,
         "what finds what sends: surfels, surfels-blended, volumes or screen (surfels)", 0, 0},
        {"--screen-steps", "N", AL_OPTION_INT, &raw.screen_steps, "steps of the screen's march (32)", 1, 1024},
        {"--screen-thickness", "M", AL_OPTION_REAL, &raw.screen_thickness,
         "of the surfaces that it meets, m (1/32 of the scene)", 1e-6, 1e6},
        {"--occlusion-uniform", NULL, AL_OPTION_FLAG, &raw.occlusion_uniform, "directions of ambient occlusion even, not by the cosine", 0, 0},
    };
    program->options = table;
    program->option_count = sizeof table / sizeof table[0];
    size_t count = 0;
    int code = al_program_parse(program, argc, argv, &options->folder, 0, 1, &count);
    program->options = NULL;
    program->option_count = 0;
    return code < 0 ? apply(program, &raw, options) : code;
}

/* The picked point's options, then those that were given, which count where both say something. */
static int parse_with_pick(al_program *program, int argc, char **argv, const al_trade_pick *pick, al_play_options *options)
{
    char(*words)[2 * AL_TRADE_TEXT_SIZE] = calloc(2 * AL_TRADE_KNOB_LIMIT, sizeof *words);
    char **all = calloc((size_t)argc + 2 * AL_TRADE_KNOB_LIMIT + 1, sizeof *all);
    int code = AL_IO, count = 0;
    if (words && all) {
        for (int i = 0; i < pick->knob_count; i++)
            count += al_trade_knob_words(pick->knobs[i].name, pick->knobs[i].value, words + count);
        all[0] = argv[0];
        for (int i = 0; i < count; i++) all[1 + i] = words[i];
        for (int i = 1; i < argc; i++) all[count + i] = argv[i];
        code = parse(program, argc + count, all, options);
        options->pick = *pick;
    }
    free(all);
    free(words);
    return code;
}

int al_play_options_parse(al_program *program, int argc, char **argv, al_play_options *options)
{
    al_error error = {0};
    al_trade_pick pick;
    char text[AL_ERROR_SIZE];
    int code = parse(program, argc, argv, options);
    if (code >= 0 || !(options->target_error > 0 || options->frame_ms > 0)) return code;
    if (!options->folder)
        return refuse(program, "--target-error and --frame-ms need the baked folder, with its trade.csv; see %s --help", program->name);
    if (al_trade_pick_point(options->folder, options->target_error, options->frame_ms, true, &pick, &error))
        return al_program_fail(program, &error);
    al_trade_pick_describe(&pick, text, sizeof text);
    al_program_say(program, "expects %s", text);
    return parse_with_pick(program, argc, argv, &pick, options);
}

double al_play_exposure(const al_play_options *options, const al_scene *scene)
{
    return isnan(options->exposure_ev) ? scene->play.exposure_ev : options->exposure_ev;
}

al_status al_play_camera(const al_play_options *options, const al_scene *scene, const al_camera **camera,
                         al_error *error)
{
    char names[512] = "";
    *camera = NULL;
    for (uint32_t i = 0; i < scene->camera_count && !*camera; i++) {
        const char *name = scene->cameras[i].name;
        if (!options->camera || !strcmp(options->camera, name)) *camera = &scene->cameras[i];
        size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%s", used ? ", " : "", name);
    }
    if (*camera) return AL_OK;
    if (!options->camera) return al_fail(error, AL_BAD_INPUT, "%s: the scene has no camera", options->folder);
    return al_fail(error, AL_USAGE, "%s: no camera is named '%s'; there are: %s", options->folder,
                   options->camera, names);
}
