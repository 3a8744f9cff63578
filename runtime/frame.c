/* One frame: what every pass must know, then tile by tile. */
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "matrix.h"
#include "state.h"

static bool in_range(double value, double low, double high)
{
    return value >= (float)low && value <= (float)high; /* bounds as settings hold them; false for NaN */
}

static al_status check(const al_view *view, const al_settings *settings, al_error *error)
{
    if (!view->width || !view->height || view->width > 32768 || view->height > 32768)
        return al_fail(error, AL_USAGE, "view: %u x %u pixels; use 1 to 32768 each", view->width,
                       view->height);
    for (int i = 0; i < 16; i++)
        if (!isfinite(view->view[i]) || !isfinite(view->projection[i]))
            return al_fail(error, AL_USAGE, "view: a matrix holds a number that is not finite");
    if (settings->interval_count && !in_range(settings->interval_count, 4, AL_KNOT_LIMIT))
        return al_fail(error, AL_USAGE, "settings: %u interval knots; use 4 to %d, or 0 for 16",
                       settings->interval_count, AL_KNOT_LIMIT);
    if (settings->march_voxels != 0 && !in_range(settings->march_voxels, 0.01f, 100))
        return al_fail(error, AL_USAGE, "settings: march step of %g voxels; use 0.01 to 100, or 0 for 0.5",
                       (double)settings->march_voxels);
    if (settings->surfel_pixels != 0 && !in_range(settings->surfel_pixels, 0.1, 1000))
        return al_fail(error, AL_USAGE, "settings: surfels of %g pixels; use 0.1 to 1000, or 0 for 4.6",
                       (double)settings->surfel_pixels);
    if (settings->surfel_limit && !in_range(settings->surfel_limit, 64, 1 << 22))
        return al_fail(error, AL_USAGE, "settings: at most %u surfels; use 64 to 4194304, or 0 for 1048576",
                       settings->surfel_limit);
    if (settings->surfel_margin_m != 0 && !in_range(settings->surfel_margin_m, 1e-6, 1e6))
        return al_fail(error, AL_USAGE, "settings: surfels up to %g m outside of the view; use 1e-6 to 1e6, or 0 for all",
                       (double)settings->surfel_margin_m);
    if (settings->shell_epsilon_w_m2_sr != 0 && !in_range(settings->shell_epsilon_w_m2_sr, 1e-12, 1e12))
        return al_fail(error, AL_USAGE, "settings: shell epsilon of %g W/(m2 sr); use 1e-12 to 1e12, or 0 for 0.06 as "
                       "the exposure shows it", (double)settings->shell_epsilon_w_m2_sr);
    if (settings->shell_radius_m != 0 && !in_range(settings->shell_radius_m, 1e-6, 1e6))
        return al_fail(error, AL_USAGE, "settings: shell radius of %g m; use 1e-6 to 1e6, or 0 for epsilon's",
                       (double)settings->shell_radius_m);
    if (settings->shell_levels > 7 || settings->blur_mips > 4 || settings->second_leg_steps > 64)
        return al_fail(error, AL_USAGE, "settings: %u shell levels, blur of %u mips, %u steps of the second leg; use at "
                       "most 7, 4 and 64", settings->shell_levels, settings->blur_mips, settings->second_leg_steps);
    if (settings->bounce_samples > 64 || (settings->bounce_radius_m != 0 && !in_range(settings->bounce_radius_m, 1e-6, 1e6)) ||
        (settings->bounce_overlap != 0 && !in_range(settings->bounce_overlap, 1, 16)))
        return al_fail(error, AL_USAGE, "settings: bounce of %u samples, radius %g m, overlap %g; use at most 64, 1e-6 to "
                       "1e6 and 1 to 16, or 0", settings->bounce_samples, (double)settings->bounce_radius_m,
                       (double)settings->bounce_overlap);
    if (settings->bounce_filter > 16 || (settings->occlusion_radius_m != 0 && !in_range(settings->occlusion_radius_m, 1e-6, 1e6)))
        return al_fail(error, AL_USAGE, "settings: filter of %u pixels, occlusion radius of %g m; use at most 16, 1e-6 to "
                       "1e6, or 0", settings->bounce_filter, (double)settings->occlusion_radius_m);
    if ((unsigned)settings->indirect_carrier >= AL_CARRIER_COUNT || settings->indirect_carrier == AL_CARRIER_VOLUMES_BLENDED)
        return al_fail(error, AL_USAGE, "settings: indirect carrier %u; use %d to %d, but not %d", (unsigned)settings->indirect_carrier,
                       0, AL_CARRIER_COUNT - 1, AL_CARRIER_VOLUMES_BLENDED);
    if ((unsigned)settings->occlusion_carrier >= AL_CARRIER_COUNT || settings->screen_steps > 1024 ||
        (settings->screen_thickness_m != 0 && !in_range(settings->screen_thickness_m, 1e-6, 1e6)))
        return al_fail(error, AL_USAGE, "settings: occlusion carrier %u, screen march of %u steps, thickness %g m; use 0 to "
                       "%d, at most 1024 and 1e-6 to 1e6, or 0", (unsigned)settings->occlusion_carrier,
                       settings->screen_steps, (double)settings->screen_thickness_m, AL_CARRIER_COUNT - 1);
    if (settings->temporal > 1024)
        return al_fail(error, AL_USAGE, "settings: history of %u frames; use at most 1024, or 0 for none", settings->temporal);
    if ((unsigned)settings->interval_weights >= AL_INTERVAL_WEIGHTS_COUNT)
        return al_fail(error, AL_USAGE, "settings: no such interval weights");
    if ((unsigned)settings->second_leg >= AL_SECOND_LEG_COUNT)
        return al_fail(error, AL_USAGE, "settings: no such second leg");
    if (settings->fog_steps > 1024)
        return al_fail(error, AL_USAGE, "settings: %u fog steps; use 1 to 1024, or 0 for 32",
                       settings->fog_steps);
    if (settings->sh_order > 8)
        return al_fail(error, AL_USAGE, "settings: SH order %u; use 1 to 8, or 0 for the baked one",
                       settings->sh_order);
    if ((unsigned)settings->pass >= AL_PASS_COUNT || (unsigned)settings->view_leg > AL_VIEW_LEG_SH)
        return al_fail(error, AL_USAGE, "settings: no such pass or view leg");
    return AL_OK;
}

/* The view's rays. With M the inverse of view-projection, the pixel's points on the near and far plane are
 * M (x, y, -1, 1) and M (x, y, 1, 1), n and f; the ray's direction is f/f.w - n/n.w, or f n.w - n f.w, which
 * holds for a far plane at infinity too (f.w = 0). All rays of a perspective view meet in M (0, 0, 1, 0),
 * whose w is 0 for an orthographic one: there rays start on the near plane. Both n and the direction are
 * linear in x and y, n.w and f.w being the same for all pixels of such views. */
static al_status fill_view(al_draw *draw)
{
    const al_view *view = draw->view;
    double projection[16], inverse[16], near[3][4], far[3][4], pole[4] = {0, 0, 1, 0};
    static const double corners[3][2] = {{-1, -1}, {1, -1}, {-1, 1}};
    al_matrix_from_float(view->view, draw->view_projection);
    al_matrix_from_float(view->projection, projection);
    al_matrix_multiply(projection, draw->view_projection, draw->view_projection);
    if (!al_matrix_inverse(draw->view_projection, inverse))
        return al_fail(draw->error, AL_USAGE, "view: view times projection cannot be inverted");
    al_matrix_to_float(draw->view_projection, draw->block.view_projection);
    al_matrix_to_float(inverse, draw->block.view_projection_inverse);
    for (int i = 0; i < 3; i++) {
        double n[4] = {corners[i][0], corners[i][1], -1, 1}, f[4] = {corners[i][0], corners[i][1], 1, 1};
        al_matrix_transform(inverse, n, near[i]);
        al_matrix_transform(inverse, f, far[i]);
    }
    al_matrix_transform(inverse, pole, pole);
    bool perspective = fabs(pole[3]) > 1e-12 * (fabs(pole[0]) + fabs(pole[1]) + fabs(pole[2]));
    double origin[3][3], direction[3][3], length = 0;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            origin[i][k] = perspective ? pole[k] / pole[3] : near[i][k] / near[i][3];
            direction[i][k] = far[i][k] * near[i][3] - near[i][k] * far[i][3];
        }
    for (int k = 0; k < 3; k++) length += direction[0][k] * direction[0][k];
    length = length > 0 ? sqrt(length) : 1;
    for (int k = 0; k < 3; k++) {
        draw->eye[k] = perspective ? origin[0][k] : -direction[0][k] / length;
        draw->block.eye[k] = (float)draw->eye[k];
        draw->block.ray[0][k] = (float)origin[0][k];
        draw->block.ray[1][k] = (float)((origin[1][k] - origin[0][k]) / view->width);
        draw->block.ray[2][k] = (float)((origin[2][k] - origin[0][k]) / view->height);
        draw->block.ray[3][k] = (float)(direction[0][k] / length);
        draw->block.ray[4][k] = (float)((direction[1][k] - direction[0][k]) / length / view->width);
        draw->block.ray[5][k] = (float)((direction[2][k] - direction[0][k]) / length / view->height);
    }
    draw->eye[3] = draw->block.eye[3] = perspective;
    draw->block.tile[2] = (int32_t)view->width;
    draw->block.tile[3] = (int32_t)view->height;
    return AL_OK;
}

/* The part of the object's place in the view that lies in the tile, tile coordinates; false: none. */
static bool clip_to_tile(const al_draw *draw, const al_object *object, int32_t area[4])
{
    for (int k = 0; k < 2; k++) {
        int32_t low = object->rectangle[k] - draw->tile[k], high = low + object->rectangle[k + 2];
        area[k] = low > 0 ? low : 0;
        area[k + 2] = (high < draw->tile[k + 2] ? high : draw->tile[k + 2]) - area[k];
        if (area[k + 2] <= 0) return false;
    }
    return true;
}

static bool shows_surface_scattering(const al_draw *draw)
{
    return draw->needs_map &&
           (draw->settings.pass == AL_PASS_COMPOSITE || draw->settings.pass == AL_PASS_SURFACE_SCATTERING);
}

static al_status draw_object(al_draw *draw, uint32_t index)
{
    al_object *object = &draw->runtime->objects[index];
    int32_t area[4];
    if (!clip_to_tile(draw, object, area)) return AL_OK;
    glEnable(GL_SCISSOR_TEST);
    glScissor(area[0], area[1], area[2], area[3]);
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, object->constants.id);
    al_status status = al_boundary_draw(draw, object, index);
    if (!status && draw->settings.view_leg == AL_VIEW_LEG_SH) status = al_back_draw(draw, index);
    if (!status) status = al_fog_draw_front(draw);
    if (!status && shows_surface_scattering(draw)) status = al_shells_gather_front(draw);
    if (!status) status = al_intervals_run(draw, object, area);
    if (!status) status = al_splat_draw(draw, object);
    if (!status) status = al_object_join(draw);
    return status;
}

/* Passes that show one level. */
static bool shows_level(al_pass pass)
{
    return pass == AL_PASS_SHELLS || pass == AL_PASS_UNSHUFFLED || pass == AL_PASS_BLURRED;
}

static bool shows_effect(al_pass pass)
{
    return pass == AL_PASS_AMBIENT_OCCLUSION || pass == AL_PASS_INDIRECT;
}

/* Passes that show the bounced z-buffer: the medium's with visibility, else the surfaces'. */
static bool shows_bounce(al_pass pass)
{
    return pass == AL_PASS_BOUNCE_RAYS || pass == AL_PASS_BOUNCE_HITS;
}

static al_status draw_surface_scattering(al_draw *draw)
{
    al_pass pass = draw->settings.pass;
    al_status status = al_interval_map_run(draw);
    if (status) return status;
    if (pass == AL_PASS_INTERVAL_MAP || pass == AL_PASS_DEPLETION) return al_shells_inspect(draw);
    status = al_span_run(draw, AL_STAGE_SPAN, &draw->runtime->shells.block, &draw->runtime->shells.span, "");
    if (!status) status = draw->settings.visibility ? al_bounce_medium(draw) : al_shells_draw(draw);
    if (status) return status;
    if (pass == AL_PASS_SHELLS) return al_shells_inspect(draw);
    if (shows_bounce(pass)) return al_bounce_inspect(draw);
    status = al_shells_gather(draw);
    return !status && shows_level(pass) ? al_shells_inspect(draw) : status;
}

static al_status draw_tile(al_draw *draw)
{
    static const float black[4] = {0, 0, 0, 1};
    al_runtime *runtime = draw->runtime;
    draw->block.tile[0] = draw->tile[0];
    draw->block.tile[1] = draw->tile[1];
    glNamedBufferSubData(runtime->frame_block.id, offsetof(al_frame_block, tile), sizeof draw->block.tile,
                         draw->block.tile);
    al_status status = al_targets_fit(draw);
    if (!status) status = al_surface_draw(draw);
    if (status) return status;
    if (draw->settings.pass == AL_PASS_SURFELS) {
        status = al_surfels_show(draw);
        return status ? status : al_output_draw(draw);
    }
    if (!draw->needs_shading) {
        glDisable(GL_SCISSOR_TEST);
        glClearNamedFramebufferfv(runtime->targets.radiance_framebuffer, GL_COLOR, 0, black);
    }
    if (draw->settings.pass == AL_PASS_NORMAL || draw->settings.pass == AL_PASS_DEPTH)
        status = al_inspect_draw(draw);
    if (draw->settings.pass == AL_PASS_SHADOW_MAP) status = al_shells_inspect(draw);
    for (int i = 0; i < AL_BOUNCE_EFFECTS && !status; i++)
        if (draw->effects[i]) status = al_bounce_surface(draw, (al_bounce_effect)i);
    if (!status && shows_bounce(draw->settings.pass) && !draw->needs_map) status = al_bounce_inspect(draw);
    if (shows_effect(draw->settings.pass)) return status ? status : al_output_draw(draw);
    if (!status) status = al_fog_draw(draw);
    if (!status && draw->needs_map) status = draw_surface_scattering(draw);
    for (uint32_t i = 0; i < runtime->scene.translucent_count && !status; i++)
        if (runtime->sorted[i] != AL_NO_INDEX) status = draw_object(draw, runtime->sorted[i]);
    return status ? status : al_output_draw(draw);
}

/* A tile is finished, `done` of `total`: tells the caller, who may want no more. */
static al_status report(const al_draw *draw, int32_t done, int32_t total)
{
    const al_settings *settings = &draw->settings;
    if (!settings->progress) return AL_OK;
    if (done < total) glFinish();
    return settings->progress(settings->progress_user, done, total)
               ? al_fail(draw->error, AL_CANCELLED, "stopped")
               : AL_OK;
}

/* The pixels beyond a tile's sides that its own take light from by the blur: a spline across three texels of the mip, and
 * three halves of a texel for what binomial kernels gathered into each, so three texels in all. *unit: blocks of
 * pixels and texels of mips lie alike in all tiles that begin at its multiples. Mips above the seventh reach too far;
 * their tiles meet with a seam. Likewise by the filter over rays from surfaces. */
static int32_t tile_reach(const al_draw *draw, int32_t *unit)
{
    const al_settings *settings = &draw->settings;
    int32_t level = (int32_t)settings->shell_levels - 1, mip = (int32_t)settings->blur_mips;
    bool blurs = draw->needs_map && draw->needs_surfels && !settings->blur_off,
         filters = (draw->effects[AL_BOUNCE_OCCLUSION] || draw->effects[AL_BOUNCE_INDIRECT]) && !settings->bounce_filter_off;
    *unit = 1;
    if (!blurs && !filters) return 0;
    if (!settings->visibility) mip += level;
    if (mip > 7) mip = 7;
    int32_t reach = filters ? (int32_t)settings->bounce_filter : 0;
    *unit = 1 << (blurs && mip > level ? mip : level);
    if (blurs && reach < 3 * (1 << mip)) reach = 3 * (1 << mip);
    return (reach + *unit - 1) / *unit * *unit;
}

/* Length of equal parts, with `reach` on both sides at most `most`, of `total`; a multiple of `unit` where there are several. */
static int32_t part_length(int32_t total, int32_t most, int32_t reach, int32_t unit)
{
    if (total <= most) return total;
    int32_t limit = (most - 2 * reach) / unit * unit, count = (total + limit - 1) / limit;
    return ((total + count - 1) / count + unit - 1) / unit * unit;
}

/* Equal tiles of at most AL_TILE_WIDTH x AL_TILE_HEIGHT; the last of a row or column may be smaller. They overlap by what
 * the blur reaches, so that no seam shows. */
static al_status draw_tiles(al_draw *draw)
{
    const int32_t size[2] = {(int32_t)draw->view->width, (int32_t)draw->view->height},
                  most[2] = {AL_TILE_WIDTH, AL_TILE_HEIGHT};
    int32_t unit, reach = tile_reach(draw, &unit), part[2], done = 0, total = 1;
    al_status status = AL_OK;
    for (int k = 0; k < 2; k++) {
        part[k] = part_length(size[k], most[k], reach, unit);
        total *= (size[k] + part[k] - 1) / part[k];
    }
    for (int32_t y = 0; y < size[1] && !status; y += part[1])
        for (int32_t x = 0; x < size[0] && !status; x += part[0]) {
            const int32_t corner[2] = {x, y};
            for (int k = 0; k < 2; k++) {
                int32_t end = corner[k] + part[k] < size[k] ? corner[k] + part[k] : size[k];
                int32_t low = corner[k] > reach ? corner[k] - reach : 0,
                        high = end + reach < size[k] ? end + reach : size[k];
                draw->kept[k] = corner[k];
                draw->kept[2 + k] = end - corner[k];
                draw->tile[k] = low;
                draw->tile[2 + k] = high - low;
            }
            status = draw_tile(draw);
            if (!status) status = report(draw, ++done, total);
        }
    return status;
}

static bool surfaces_send(const al_runtime *runtime)
{
    return runtime->model.has_opaque && (runtime->scene.light_count || runtime->model.has_emission);
}

/* Surfaces send light into the fog. */
static bool sends_into_fog(const al_draw *draw)
{
    if (!draw->runtime->fogs.drawn || draw->settings.surface_scattering_off || !surfaces_send(draw->runtime))
        return false;
    switch (draw->settings.pass) {
    case AL_PASS_COMPOSITE:
    case AL_PASS_SURFACE_SCATTERING:
    case AL_PASS_SHELLS:
    case AL_PASS_UNSHUFFLED:
    case AL_PASS_BLURRED:
        return true;
    case AL_PASS_BOUNCE_RAYS:
    case AL_PASS_BOUNCE_HITS:
        return draw->settings.visibility;
    default:
        return false;
    }
}

/* An opaque surface has no baked light. */
static bool any_dynamic(const al_runtime *runtime)
{
    for (uint32_t i = 0; i < runtime->scene.instance_count; i++)
        if (runtime->scene.instances[i].role == AL_ROLE_OPAQUE &&
            al_instance_lighting(runtime, i) == AL_LIGHTING_DYNAMIC)
            return true;
    return false;
}

static void choose_effects(al_draw *draw)
{
    const al_runtime *runtime = draw->runtime;
    const al_settings *settings = &draw->settings;
    bool composite = settings->pass == AL_PASS_COMPOSITE, receives = any_dynamic(runtime);
    bool ambient = composite && settings->ambient_occlusion && receives &&
                   al_environment_exists(&runtime->scene.environment);
    bool rays = shows_bounce(settings->pass) && !settings->visibility;
    bool indirect = settings->pass == AL_PASS_INDIRECT || ((composite || rays) && settings->indirect);
    draw->effects[AL_BOUNCE_OCCLUSION] =
        ambient || settings->pass == AL_PASS_AMBIENT_OCCLUSION || (rays && !settings->indirect);
    draw->effects[AL_BOUNCE_INDIRECT] = indirect && receives && surfaces_send(runtime);
    draw->needs_material = ambient || draw->effects[AL_BOUNCE_INDIRECT];
}

static bool takes_surfels(const al_draw *draw, al_bounce_effect effect)
{
    al_carrier carrier = al_bounce_carrier(draw, effect);
    return draw->effects[effect] && (carrier == AL_CARRIER_SURFELS || carrier == AL_CARRIER_SURFELS_BLENDED);
}

/* Surfaces are shaded so that others can take their light from the picture. */
static bool shows_senders(const al_draw *draw)
{
    return draw->effects[AL_BOUNCE_INDIRECT] && draw->settings.indirect_carrier == AL_CARRIER_SCREEN;
}

/* How many levels or layers the pass can show one of. */
static uint32_t shown_limit(const al_draw *draw)
{
    if (draw->settings.pass != AL_PASS_SHADOW_MAP) return draw->settings.shell_levels;
    return draw->runtime->shadow.depth.id ? draw->runtime->shadow.depth.depth : 1;
}

static al_status check_shown(const al_draw *draw)
{
    const al_settings *settings = &draw->settings;
    if (!shows_level(settings->pass) && settings->pass != AL_PASS_SHADOW_MAP) return AL_OK;
    if (settings->shown_level < shown_limit(draw)) return AL_OK;
    return al_fail(draw->error, AL_USAGE, "settings: number %u is shown of %u levels or layers, from 0",
                   settings->shown_level, shown_limit(draw));
}

/* What the host has drawn, depth and all, stays. */
static void clear(const al_draw *draw)
{
    static const float black[4] = {0, 0, 0, 1};
    glDisable(GL_SCISSOR_TEST);
    if (!draw->host_depth) glClearNamedFramebufferfv(draw->framebuffer, GL_COLOR, 0, black);
}

static al_status draw_frame(al_draw *draw)
{
    al_runtime *runtime = draw->runtime;
    al_pass pass = draw->settings.pass;
    draw->needs_light = pass == AL_PASS_COMPOSITE || pass == AL_PASS_TRANSLUCENT || pass == AL_PASS_UNITY;
    al_status status = fill_view(draw);
    if (!status) status = al_motion_draw(draw); /* before what binds buffers for the whole frame */
    if (status) return status;
    al_environment_fill(draw);
    al_gl_bind_texture(AL_UNIT_ENVIRONMENT, runtime->environment.id);
    al_gl_bind_texture(AL_UNIT_SHADOW, 0);
    al_objects_prepare(draw);
    al_fog_prepare(draw);
    choose_effects(draw);
    bool into_fog = sends_into_fog(draw);
    draw->needs_shading = pass == AL_PASS_COMPOSITE || pass == AL_PASS_SURFACE || shows_senders(draw);
    draw->needs_surfels = runtime->model.has_opaque &&
                          (pass == AL_PASS_SURFELS || into_fog || takes_surfels(draw, AL_BOUNCE_OCCLUSION) ||
                           takes_surfels(draw, AL_BOUNCE_INDIRECT));
    draw->needs_objects = runtime->scene.translucent_count && runtime->sorted[0] != AL_NO_INDEX &&
                          pass != AL_PASS_SURFELS && !shows_effect(pass);
    draw->needs_map = into_fog || (runtime->fogs.drawn && (pass == AL_PASS_INTERVAL_MAP || pass == AL_PASS_DEPLETION));
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, runtime->frame_block.id);
    if (shows_level(pass)) draw->settings.visibility = false;
    status = al_shadow_draw(draw);
    if (!status) status = check_shown(draw);
    if (!status) clear(draw);
    if (!status) status = al_surfels_run(draw);
    if (!status && draw->needs_map) status = al_shells_prepare(draw);
    for (uint32_t i = 0; i < runtime->scene.translucent_count && !status; i++)
        if (runtime->objects[i].present && runtime->objects[i].rectangle[2])
            status = al_light_run(draw, &runtime->objects[i]);
    if (!status) status = al_history_begin(draw);
    if (!status) status = draw_tiles(draw);
    if (!status) al_history_end(draw);
    return status;
}

al_status al_runtime_draw(al_runtime *runtime, const al_view *view, const al_settings *settings,
                          uint32_t framebuffer, uint32_t depth_texture, al_error *error)
{
    al_draw draw = {.runtime = runtime,
                    .view = view,
                    .framebuffer = framebuffer,
                    .host_depth = depth_texture,
                    .error = error};
    GLint drawn_to = 0, read_from = 0, viewport[4];
    if (settings) draw.settings = *settings;
    al_status status = check(view, &draw.settings, error);
    if (!status) status = al_gl_check_lost(error);
    if (status) return status;
    if (!draw.settings.fog_steps) draw.settings.fog_steps = 32;
    if (!draw.settings.interval_count) draw.settings.interval_count = 16;
    if (!draw.settings.shell_levels) draw.settings.shell_levels = 6;
    if (!draw.settings.blur_mips) draw.settings.blur_mips = draw.settings.visibility ? 3 : 1;
    if (!draw.settings.bounce_samples) draw.settings.bounce_samples = 4;
    if (!draw.settings.bounce_filter) draw.settings.bounce_filter = 2;
    if (!draw.settings.screen_steps) draw.settings.screen_steps = 32;
    if (!draw.settings.second_leg_steps) draw.settings.second_leg_steps = 4;
    if (draw.settings.shell_epsilon_w_m2_sr == 0)
        draw.settings.shell_epsilon_w_m2_sr = 0.06f * exp2f(-runtime->scene.play.exposure_ev);
    if (draw.settings.march_voxels == 0) draw.settings.march_voxels = 0.5f;
    if (draw.settings.surfel_pixels == 0) /* or a 16th of what is too small a picture for such surfels */
        draw.settings.surfel_pixels = fminf(4.6f, (float)(view->width < view->height ? view->width : view->height) / 16);
    if (!draw.settings.surfel_limit) draw.settings.surfel_limit = 1 << 20;
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &drawn_to);
    glGetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &read_from);
    glGetIntegerv(GL_VIEWPORT, viewport);
    al_gl_reset_state();
    if (!runtime->loaded) {
        clear(&draw);
    } else {
        runtime->settings = draw.settings;
        runtime->drawn = true;
        runtime->memory.frame++;
        al_timing_begin_frame(&runtime->timing);
        status = draw_frame(&draw);
        al_timing_end_frame(&runtime->timing);
        al_runtime_sweep(runtime);
        runtime->frame_number++;
    }
    glDisable(GL_SCISSOR_TEST);
    glUseProgram(0);
    glBindVertexArray(0);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, (GLuint)drawn_to);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, (GLuint)read_from);
    glViewport(viewport[0], viewport[1], viewport[2], viewport[3]);
    al_status lost = al_gl_check_lost(error); /* the cause of whatever else went wrong */
    return lost ? lost : status;
}
