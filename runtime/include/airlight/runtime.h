/* airlight's OpenGL 4.5 runtime. The host owns the context, the window and the final targets.
 *
 * It does not: create contexts, open windows, load anything but baked folders, follow a camera that moves.
 *   1. Make a core 4.5 context current; al_runtime_create.
 *   2. al_runtime_load starts a loader thread; it never touches GL.
 *   3. Every frame: al_runtime_update uploads what has arrived, al_runtime_set_time says which time is shown,
 *      al_runtime_draw draws.
 * GL state: al_runtime_draw changes program, vertex array, framebuffer, viewport, blend, depth, cull,
 * texture, image and buffer bindings, clip control, depth range, pixel unpacking and sampler bindings, and
 * restores none but the framebuffer bindings and the viewport (al_runtime_load and _update restore nothing):
 * hosts set what they need. Passes run in KHR_debug groups named as in al_runtime_times.
 *
 * Thread safety: all calls from the thread whose context is current. */
#ifndef AIRLIGHT_RUNTIME_H
#define AIRLIGHT_RUNTIME_H

#include <stdbool.h>
#include <stdint.h>

#include "airlight/scene.h"
#include "airlight/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct al_runtime al_runtime;

typedef struct al_runtime_options {
    const char *shader_folder; /* NULL: the embedded shaders; else *.glsl and stages from this folder */
} al_runtime_options;

/* AL_NO_DEVICE without OpenGL 4.5. options may be NULL. Shaders are built when first drawn: an error there
 * names the file, and a file with the whole log. */
al_status al_runtime_create(const al_runtime_options *options, al_runtime **runtime, al_error *error);
void al_runtime_destroy(al_runtime *runtime);

/* Opens DIR/scene.air, then starts the loader thread for everything it names. Replaces what was loaded. */
al_status al_runtime_load(al_runtime *runtime, const char *folder, al_error *error);

typedef struct al_load_state {
    uint64_t samples_loaded, samples_total; /* of all translucent objects */
    bool ready;                             /* something can be drawn */
    bool complete; /* and every density sequence shows its frame at the time of al_runtime_set_time */
} al_load_state;

/* Uploads what has arrived, at most `byte_budget` bytes (0: no limit), but at least one sample or one slice
 * of a density grid. A failed asset: its error, once. */
al_status al_runtime_update(al_runtime *runtime, uint64_t byte_budget, al_load_state *state, al_error *error);

/* The loaded scene; lights, instances' world matrices, fogs' `moved` and play settings may be changed between frames.
 * NULL before a load. Valid until the next load. */
al_scene *al_runtime_scene(al_runtime *runtime);

/* Shows the scene as it is at `seconds` after its start from the next frame on: instances, lights and cameras that
 * move get their places in al_runtime_scene, overwriting what was changed there. Begins anew after
 * al_runtime_duration_s; any finite number is allowed, others and calls before a load do nothing. A loaded scene is
 * at 0. Of a density sequence the nearest frame is shown, from the next al_runtime_update that finds it loaded on: frames
 * are streamed, two ahead, and never waited for; al_load_state.complete says when they are there. */
void al_runtime_set_time(al_runtime *runtime, double seconds);
/* Time of the last key, or end of the longest density sequence where that is later, once it has arrived; 0: nothing
 * moves. */
double al_runtime_duration_s(const al_runtime *runtime);
/* World box of what can be seen, at the time shown; never too small. False: there is nothing. */
bool al_runtime_bounds(const al_runtime *runtime, float low[3], float high[3]);

typedef enum al_view_leg {
    AL_VIEW_LEG_MARCHED = 0, /* transmittance towards the eye from a transmittance interval map */
    AL_VIEW_LEG_SH = 1       /* from each sample's spherical harmonics; as published with normalise_off */
} al_view_leg;

typedef enum al_pass {
    AL_PASS_COMPOSITE = 0, /* everything */
    AL_PASS_TRANSLUCENT,   /* the samples' light alone */
    AL_PASS_SURFACE,       /* surface shading alone */
    AL_PASS_NORMAL,        /* of the nearest surface, n * 0.5 + 0.5 */
    AL_PASS_DEPTH,         /* distance to the eye of the nearest surface, metres */
    AL_PASS_INTERVALS,     /* distances of the first three interval knots, metres */
    AL_PASS_UNITY,         /* the line integral of sum gamma over the chord: 1 where it sums to one */
    AL_PASS_DIRECT_SCATTERING, /* light that the fog scatters once towards the eye, alone */
    AL_PASS_SURFACE_SCATTERING, /* light that surfaces send and the fog scatters once towards the eye, alone */
    AL_PASS_SURFELS,       /* the surfel cloud as discs, each in the light that it sends */
    AL_PASS_INTERVAL_MAP, /* distances of the first, middle and last sample of the view's interval map, metres */
    AL_PASS_DEPLETION,    /* what the fog takes of light to the eye, mean of the channels, 0 to 1 */
    AL_PASS_SHELLS,       /* one level as the shells were splatted into it */
    AL_PASS_UNSHUFFLED,   /* that level in the view's order */
    AL_PASS_BLURRED,      /* and blurred, as it is summed */
    AL_PASS_SHADOW_MAP,   /* one layer: a directional light's map or a face of a point light's, depth 0 to 1 */
    AL_PASS_AMBIENT_OCCLUSION, /* share of the cosine-weighted hemisphere over the seen surface that is open, 0 to 1 */
    AL_PASS_INDIRECT, /* light of one bounce from surfaces onto the seen ones, as it arrives at the eye, alone */
    AL_PASS_BOUNCE_RAYS, /* the bounced z-buffer's last ray of each pixel, d * 0.5 + 0.5: from the medium with
                          * `visibility`, else from surfaces, as `indirect` or ambient occlusion sends them */
    AL_PASS_BOUNCE_HITS, /* how far along it what the carrier meets is, metres; 0: none */
    AL_PASS_COUNT
} al_pass;
const char *al_pass_name(al_pass pass); /* "composite", "translucent", ... */

typedef enum al_interval_weights { /* what the view's transmittance interval map stores of the media */
    AL_INTERVAL_WEIGHTS_AUTO = 0,     /* nothing where extinction is grey and one albedo and g hold for all; else: */
    AL_INTERVAL_WEIGHTS_COLOURED,     /* per sample a weight of each channel, and one of the media */
    AL_INTERVAL_WEIGHTS_COEFFICIENTS, /* scattering coefficients, as published: grey media of one g;
                                       * with visibility as AUTO */
    AL_INTERVAL_WEIGHTS_COUNT
} al_interval_weights;

typedef enum al_carrier { /* what finds the surfaces that the bounced z-buffer's rays meet, from surfaces */
    AL_CARRIER_SURFELS = 0,     /* splats of the surfel cloud (Nalbach et al. 2015) */
    AL_CARRIER_SURFELS_BLENDED, /* without the z-buffer: what every surfel sends or hides is added up (Nalbach et al. 2014) */
    AL_CARRIER_VOLUMES,         /* every triangle, drawn where it may be met: exact (McGuire 2010, with the z-buffer) */
    AL_CARRIER_VOLUMES_BLENDED, /* without the z-buffer: what triangles hide is added up, overlaps twice */
    AL_CARRIER_SCREEN,          /* a march through the view's depths, for comparison: what is out of view is not met */
    AL_CARRIER_COUNT
} al_carrier;

typedef enum al_second_leg { /* extinction between surfaces and places in gridded media; constant ones are exact */
    AL_SECOND_LEG_MARCHED = 0, /* through a coarse grid */
    AL_SECOND_LEG_BAKED,       /* from optical depths that the media keep; al_runtime_draw refuses without; with visibility
                                * as marched */
    AL_SECOND_LEG_COUNT
} al_second_leg;

/* Knobs; all zero is the default and the best-looking. */
typedef struct al_settings {
    uint32_t sample_limit; /* per object; 0: all that are loaded */
    uint32_t sh_order;     /* 0: as baked */
    al_view_leg view_leg;
    bool surface_off;   /* no surface shading of translucent objects */
    bool clip_off;      /* splats are not clipped by the object's boundary (published figure 4) */
    bool normalise_off; /* do not divide by the transmittance that the Gaussians together lose */
    bool shadows_off;
    bool detail_off;         /* no level of detail by distance */
    bool background_off;     /* black instead of the environment */
    bool fog_off;            /* the air is clear: lightmaps and probes show their light without fog */
    bool scattered_off;      /* lightmaps and probes without the light that the fog scatters onto surfaces */
    uint32_t fog_steps;      /* cells along a ray for each light, 0: 32; 1 to 1024 */
    bool surface_scattering_off; /* no light from surfaces is scattered by the fog: no surfels */
    float surfel_pixels;     /* radius of a surfel in the picture, 0: 4.6, at most 1/16 of its edges; 0.1 to 1000 */
    uint32_t surfel_seed;    /* another one places all surfels anew: one for each frame of a mean */
    bool surfels_plain;      /* neither split, placed at random nor thinned, as published in 2014: for comparison */
    uint32_t surfel_limit;   /* the most surfels, of which each takes 80 bytes, 0: 2^20; 64 to 2^22; they are coarser
                              * where there would be more */
    uint32_t interval_count; /* knots of the interval maps, 0: 16; 4 to 32 */
    float surfel_margin_m;   /* surfels farther outside of the view are left out, 0: none is; 1e-6 to 1e6 */
    /* Light of surfaces that the fog scatters to the eye: surfels splatted in shells (Nalbach et al. 2014). */
    float shell_epsilon_w_m2_sr; /* what a splat may leave out, 0: 0.06 as the scene's exposure shows it */
    uint32_t shell_levels;       /* 0: 6; 1 to 7 */
    uint32_t shown_level;        /* which one AL_PASS_SHELLS to _BLURRED show, or layer of AL_PASS_SHADOW_MAP */
    float shell_radius_m;        /* of the innermost shell, 0: by epsilon */
    bool shells_closed;          /* the outermost shell ends by epsilon, as published */
    bool shells_clamped;         /* squared distances held above A/pi, as published */
    bool second_leg_off;         /* no extinction between surfel and medium, as published */
    al_second_leg second_leg;
    uint32_t second_leg_steps;   /* marched through gridded media, 0: 4; 1 to 64 */
    bool visibility;             /* surfaces hide others from the medium, by a bounced z-buffer instead of shells */
    /* Light onto opaque surfaces that have no baked light: that holds it already, and nothing is lit twice. */
    bool indirect;          /* light, emission too, that one surface sends to another */
    bool indirect_lambert;  /* as Lambert's surfaces alone send it: no light off highlights */
    bool ambient_occlusion; /* the environment's light, less what other surfaces hide of it */
    /* The bounced z-buffer, of the medium and of surfaces. */
    uint32_t bounce_samples;     /* directions a pixel, 0: 4; 1 to 64 */
    float bounce_radius_m;       /* of its innermost shell, 0: 1/32 of the scene's extent, from surfaces 1/4 */
    float bounce_overlap;        /* what surfels' areas are multiplied by, of surfaces where they poke out nowhere; 0: 3; 1 to 16 */
    bool bounce_near_off;        /* fragments nearer than their level's shell are thrown away */
    al_carrier occlusion_carrier;
    al_carrier indirect_carrier; /* not AL_CARRIER_VOLUMES_BLENDED, which knows shares of the hemisphere only */
    uint32_t screen_steps;       /* of AL_CARRIER_SCREEN's march, 0: 32; 1 to 1024 */
    float screen_thickness_m;    /* of the surfaces it meets, 0: 1/32 of the scene's extent; 1e-6 to 1e6 */
    float occlusion_radius_m;    /* surfaces farther away do not occlude, 0: no limit; 1e-6 to 1e6 */
    bool occlusion_uniform;      /* its directions are drawn evenly, as published, not by the cosine */
    bool bounce_filter_off;      /* a pixel takes its own rays alone, from surfaces */
    uint32_t bounce_filter;      /* pixels to each side whose rays it takes too, 0: 2; 1 to 16 */
    /* Of light and occlusion on surfaces, the mean over frames, as far back as places have stayed in view and light has not
     * changed. The frame before is the last al_runtime_draw; a frame of another size begins anew. */
    uint32_t temporal;       /* frames that what is past may weigh as much as, 0: none; at most 1024 */
    bool temporal_undoubted; /* also where the light has changed: ghosts, for comparison */
    al_interval_weights interval_weights;
    bool interval_jitter_off; /* nothing is drawn at random on the rays */
    bool blur_off;
    bool blur_plain;    /* light is blurred with the medium's outline, as published */
    uint32_t blur_mips; /* above a level's own, 0: 1; 1 to 4 */
    float march_voxels;      /* step of the march in voxels, 0: 0.5 */
    al_pass pass;
    /* Called, unless NULL, when another tile of at most 2048 x 1088 pixels is finished; waits for the device
     * between tiles. Answering true ends the frame there with AL_CANCELLED. */
    bool (*progress)(void *user, double done, double total);
    void *progress_user;
} al_settings;

typedef struct al_view {
    float view[16], projection[16]; /* column-major, OpenGL clip space, depth 0 to 1 after the viewport */
    uint32_t width, height;
} al_view;

/* Draws linear radiance before exposure into `framebuffer` (its colour 0, cleared by the call; RGBA16F or
 * RGBA32F, not multisampled) at view.width x view.height; numbers beyond what it holds become its largest.
 * `depth_texture` (0 for none, GL_DEPTH_COMPONENT32F, same size) holds the host's own opaque geometry: it
 * hides and clips ours. Colour 0 is not cleared then: it is the host's picture, kept where the depth is below
 * 1, seen through our media, and replaced by our background elsewhere. The projection is perspective or
 * orthographic. AL_NO_DEVICE when the context is lost, which one that was made with the reset notification strategy
 * LOSE_CONTEXT_ON_RESET tells; al_runtime_update likewise. */
al_status al_runtime_draw(al_runtime *runtime, const al_view *view, const al_settings *settings,
                          uint32_t framebuffer, uint32_t depth_texture, al_error *error);

typedef struct al_pass_time {
    const char *name;
    double ms;
} al_pass_time;
/* GPU times of the last frame whose timer queries have come back; answers how many were written. */
uint32_t al_runtime_times(al_runtime *runtime, al_pass_time *times, uint32_t limit);
/* Bytes of buffers and textures the runtime holds; samples drawn in the last frame. */
uint64_t al_runtime_memory(const al_runtime *runtime);
uint64_t al_runtime_samples(const al_runtime *runtime);
/* Whether AL_SECOND_LEG_BAKED can be drawn: there are gridded media, and all that have arrived keep optical depths. */
bool al_runtime_keeps_depths(const al_runtime *runtime);
/* Surfels of the last frame whose count has come back, 0 when it needed none; never waits. */
uint64_t al_runtime_surfels(al_runtime *runtime);

typedef struct al_plan_row {
    const char *step;
    bool needed;
    const char *why;
    double seconds; /* per frame, as last measured; 0 before the first frame */
    uint64_t bytes;
} al_plan_row;
/* What the last frame ran of what the scene may make the runtime run, and what not, why, and what each step holds, needed
 * or not: what is loaded stays. Before the first frame nothing has run. Valid until the next load. */
const al_plan_row *al_runtime_plan(al_runtime *runtime, uint32_t *count);

#ifdef __cplusplus
}
#endif
#endif
