/* What the passes share: the runtime's state, the frame being drawn, and the blocks shaders read (std140). */
#ifndef AIRLIGHT_RUNTIME_STATE_H
#define AIRLIGHT_RUNTIME_STATE_H

#include "airlight/runtime.h"
#include "gl.h"
#include "loader.h"
#include "shader.h"
#include "timing.h"

enum {
    AL_LIGHT_LIMIT = 64,
    AL_FOG_LIMIT = 8,
    AL_CASTER_LIMIT = 8,  /* translucent objects that shadow others; further ones do not */
    AL_TILE_WIDTH = 2048, /* larger views are drawn in tiles, so that targets stay below 400 MiB */
    AL_TILE_HEIGHT = 1088,
    AL_KNOT_LIMIT = 32,
    AL_ENVIRONMENT_BANDS = 9,
    AL_PLAN_LIMIT = 32
};

/* Texture units of shaders/: the first two and the last eight keep their texture through a frame, and that of
 * the fog where a pass does not need it otherwise. */
enum { AL_UNIT_SHADOW = 0, AL_UNIT_ENVIRONMENT = 1, AL_UNIT_PASS = 2, AL_UNIT_LIGHTMAP = 6, AL_UNIT_FOG = 7, AL_UNIT_CASTERS = 8 };

/* shaders/frame.glsl */
typedef struct al_light_block {
    float vector[4], intensity[4], shadow[4], to_shadow[16];
} al_light_block;

typedef struct al_caster_block {
    float to_object[16], box_min[4], box_size[4], sigma_t[4];
} al_caster_block;

typedef struct al_frame_block {
    float view_projection[16], view_projection_inverse[16], eye[4], ray[6][4];
    int32_t tile[4], counts[4];
    float background[4], environment[AL_ENVIRONMENT_BANDS][4];
    al_light_block lights[AL_LIGHT_LIMIT];
    al_caster_block casters[AL_CASTER_LIMIT];
} al_frame_block;
_Static_assert(sizeof(al_frame_block) == 128 + 16 + 96 + 32 + 16 + 144 + 64 * 112 + 8 * 112, "std140");

/* shaders/object.glsl */
typedef struct al_object_block {
    float object_to_world[16], world_to_object[16], ray[6][4];
    float box_min[4], box_size[4], albedo[4], sigma_s[4], ratio[4], march[4], prefix[4];
    int32_t sizes[4], toggles[4];
    float environment[AL_ENVIRONMENT_ORDER * AL_ENVIRONMENT_ORDER][4];
} al_object_block;
_Static_assert(sizeof(al_object_block) == 128 + 96 + 7 * 16 + 32 + 1024, "std140");

/* shaders/fogs.glsl */
typedef struct al_fog_entry {
    float to_index[16], low[4], extent[4], sigma_t[4], sigma_s[4];
    int32_t size[4], cells[4];
    float march[4];
    int32_t sky_size[4], sky_place[4];
    float sky_grade[4];
} al_fog_entry;

typedef struct al_fog_block {
    int32_t counts[4], atlas[4];
    float texel[4];
    al_fog_entry fogs[AL_FOG_LIMIT];
} al_fog_block;
_Static_assert(sizeof(al_fog_block) == 48 + 8 * (64 + 10 * 16), "std140");

enum { AL_FOG_SLOTS = 3 };

typedef struct al_fog_slot { /* for a frame, in the atlas */
    al_medium_frame frame;
    uint32_t index;               /* of the frame */
    bool filled;                  /* with that frame, as far as it is loaded */
    uint32_t first_brick, loaded; /* bricks on the GPU */
    uint64_t first_cell;
    const uint16_t *depths; /* as al_medium_read_depths, the loader's */
} al_fog_slot;

typedef struct al_fog_medium { /* of one al_scene.fogs whose density varies */
    bool present, failed;
    al_medium_info info;
    al_medium_frame frame;        /* the one that is shown, and where its slot is */
    uint32_t first_brick, loaded; /* in the atlas; bricks on the GPU */
    uint64_t first_cell;
    const float *times_s;      /* [info.frame_count], the loader's */
    uint32_t brick_limit;      /* of all frames */
    al_fog_slot slots[AL_FOG_SLOTS];
    uint32_t shown, incoming;  /* slots; incoming AL_NO_INDEX: nothing is on its way */
    uint32_t wanted;           /* the frame at the time */
    al_medium_sky sky;           /* the loader's; size 0: none */
    int32_t sky_slice, sky_cell; /* its first ones along z of the textures */
    al_medium_depth depth;       /* size 0: none */
    const uint16_t *depths, *depths_uploaded; /* of the frame that is shown; what the texture holds */
    int32_t depth_slice;         /* its first one along z */
} al_fog_medium;

typedef struct al_fogs {
    al_fog_medium *media; /* [scene.fog_count] */
    al_gl_buffer constants, cells;
    al_gl_texture bricks, sky_light, sky_planes, depth;
    int32_t atlas[3];   /* bricks along its axes */
    int32_t sky_stride; /* texels along x from number to number of sky_light */
    int32_t depth_stride; /* likewise of depth, from texel to texel of a point */
    uint32_t shown[AL_FOG_LIMIT]; /* number among scene.fogs of each of block.fogs */
    bool placed;        /* all media have their place in bricks, and the sky's light is uploaded */
    bool drawn;         /* in the frame being drawn */
    al_fog_block block; /* of that frame */
} al_fogs;

/* shaders/shells.glsl */
typedef struct al_shell_block {
    int32_t counts[4], size[4]; /* counts: three, and std140's room */
    float reach[4], medium[4];
    int32_t blur[4];
} al_shell_block;
_Static_assert(sizeof(al_shell_block) == 80, "std140");

typedef struct al_shells {      /* what surfaces send into the media; all of one tile */
    al_gl_texture steps, ends;  /* the view's transmittance interval map */
    al_gl_texture weights;      /* of its samples, unless one albedo holds for all */
    al_gl_texture span;         /* start and end of the medium, mips */
    al_gl_texture levels, light; /* as splatted; in the view's order, mips */
    GLuint framebuffer;
    al_gl_buffer constants;
    /* of the frame being drawn */
    al_shell_block block;
    al_interval_weights weighing;
    float cell_m;
} al_shells;

/* shaders/legs.glsl */
typedef struct al_leg_depth {
    float to_share[16], edge[4];
    int32_t size[4];
} al_leg_depth;

typedef struct al_legs_block {
    float low[4], extent[4];
    int32_t stride[4];
    al_leg_depth depths[AL_FOG_LIMIT];
} al_legs_block;
_Static_assert(sizeof(al_legs_block) == 48 + 8 * 96, "std140");

typedef struct al_legs {
    al_gl_texture extinction; /* of all gridded media, coarse */
    al_gl_buffer constants;
    uint32_t order; /* of the baked depths that this frame's legs are taken from, 0: none are */
} al_legs;

/* shaders/bounce.glsl */
typedef struct al_bounce_block {
    float reach[4];
    int32_t sample[4];
} al_bounce_block;

typedef enum al_bounce_effect { /* of the bounced z-buffer on seen surfaces */
    AL_BOUNCE_OCCLUSION,
    AL_BOUNCE_INDIRECT,
    AL_BOUNCE_EFFECTS
} al_bounce_effect;

typedef struct al_bounce { /* the bounced z-buffer of one tile */
    al_gl_texture rays, hits, depths; /* hits and depths: of one level at a time, one layer */
    al_gl_texture nearest;            /* of the levels before it, shaders/bounce_hits.glsl; one level has none */
    GLuint framebuffer;
    al_gl_buffer constants;
    al_gl_texture span, arriving, light; /* from surfaces: their distances' mips; along the rays; samples' sum */
    al_gl_buffer shells;                 /* likewise */
    al_gl_texture senders, glows;        /* what a met triangle is made of, shaders/material.glsl; its emission */
} al_bounce;

/* shaders/history.glsl */
typedef struct al_history_block {
    float view_projection[16], ray[6][4]; /* of the frame before */
    int32_t kept[4], rule[4];
} al_history_block;
_Static_assert(sizeof(al_history_block) == 192, "std140");

typedef struct al_history { /* of the whole view; pairs: of the frame being drawn, [now], and of the one before */
    al_gl_texture light[AL_BOUNCE_EFFECTS][2], places[2];
    al_gl_buffer constants;
    al_history_block block;
    uint32_t now, next_frame[AL_BOUNCE_EFFECTS]; /* number of the frame that it is the history of, 0: of none */
    bool runs;                                   /* in the last frame */
} al_history;

typedef struct al_light_page { /* of the lightmap */
    al_gl_texture texels; /* array: surface, attenuated, scattered; then the SH of each, if there are any */
    float scale[AL_LAYER_COUNT], sh_scale[AL_LAYER_COUNT];
} al_light_page;

typedef struct al_lightmap {
    al_light_page *pages;                   /* [page_count] */
    const al_lightmap_instance **instances; /* [scene.instance_count], NULL: none; the loader's */
    uint32_t page_count;
    bool half;                  /* its texels' format */
    uint32_t directional_order; /* bands of SH, 0: none */
} al_lightmap;

typedef struct al_probe_lights {
    bool present;
    al_probes probes;      /* the loader's */
    al_probe_place *places; /* [scene.instance_count]: where each was found last */
} al_probe_lights;

typedef struct al_model_mesh {
    GLuint vertex_array;
    al_gl_buffer vertices, indices; /* position, normal, uv; uint32 */
    al_gl_buffer uv1;               /* only where an instance of it has a lightmap */
    float low[3], high[3];          /* box of the positions */
    float longest_edge;             /* of its triangles; of a deformed mesh a bound */
} al_model_mesh;

typedef struct al_model {
    al_model_mesh *meshes;
    al_gl_texture *textures;
    uint32_t mesh_count, texture_count;
    bool has_opaque, has_blockers, has_emission;
} al_model;

typedef struct al_object { /* one of al_scene.translucents */
    bool present, failed;
    bool chromatic; /* extinction differs between the channels that have any */
    al_translucent_info info;
    al_gl_buffer positions, gaussians, coefficients, scales, lit, constants;
    al_gl_texture density;
    uint32_t loaded; /* samples on the GPU */
    uint64_t slices; /* of the density grid, on the GPU */
    /* of the frame being drawn */
    al_object_block block;
    uint32_t drawn, order;
    int32_t rectangle[4];      /* x, y, width, height in the view; width 0: not in view */
    double distance_m;         /* of its middle, to sort */
    float environment_key[20]; /* what block.environment was computed for */
    bool environment_good;
} al_object;

enum { AL_DEFORM_BUFFERS = 7 }; /* of skin.comp: what a mesh is made from, then its pose */

typedef struct al_box {
    float low[3], high[3]; /* low above high: empty */
} al_box;

typedef struct al_deformed { /* one of al_scene.motion.deforms */
    al_gl_buffer buffers[AL_DEFORM_BUFFERS];
    float *pose; /* [pose_count] as skin.comp wants it */
    size_t pose_count;
    double (*palette)[16], *weights;
    al_box *boxes;  /* [joint_count, at least 1] of the vertices that hang on each joint, bound */
    al_box *deltas; /* [target_count] */
} al_deformed;

typedef struct al_moving {
    double time_s, length_s; /* in the loop; 0: nothing moves */
    bool placed;             /* everything is where it is at time_s */
    double (*world)[16];     /* [node_count] of al_scene.motion */
    double *scratch;
    al_deformed *deforms; /* [deform_count] */
    uint32_t deform_count;
    uint32_t poses, posed; /* how often the pose has changed, and up to which the vertices have followed */
} al_moving;

typedef struct al_shadow_maps {
    al_gl_texture depth; /* array of layers */
    GLuint framebuffer;
    float *key;      /* lights and instances the maps were drawn for */
    size_t key_size; /* floats */
} al_shadow_maps;

typedef struct al_surfel_rule { /* shaders/surfel_size.glsl */
    double eye[4];             /* as al_draw's */
    double area;               /* wanted at a distance of 1 m, m2; for an orthographic view everywhere */
    double nearest_m;          /* distances are held above this */
} al_surfel_rule;

typedef struct al_surfel_count { /* of one frame; [0]: vertices of parts of huge triangles, [1]: surfels */
    GLuint wanted[2], written[2]; /* queries */
    double coarseness;
    bool pending;
} al_surfel_count;

enum { AL_SURFEL_SIZE = 80, AL_SURFEL_RING = 3 };

typedef struct al_surfels {
    al_gl_buffer cloud, count; /* shaders/surfels.glsl */
    al_gl_buffer parts[2];     /* of huge triangles of one submesh, after even and odd rounds: position, uv, key */
    GLuint cloud_feedback, parts_feedback[2], parts_array[2];
    al_surfel_count ring[AL_SURFEL_RING];
    uint32_t current;
    uint64_t drawn;      /* in the last frame whose count has come back */
    double coarseness;   /* surfels are so many times as large as the settings ask for, to stay below the limit */
    al_surfel_rule rule; /* of the last cloud */
} al_surfels;

typedef struct al_targets {                   /* of one tile */
    al_gl_texture radiance, geometry, depth;  /* opaque surfaces, then everything */
    al_gl_texture boundary, back, reflection; /* of one translucent object; back: view leg by SH */
    al_gl_texture ends, knots, light;
    al_gl_texture fog_light, fog_kept; /* of the fog in front of one translucent object */
    al_gl_texture host;                /* the host's own picture */
    al_gl_texture material;            /* of opaque surfaces that light comes to later: shaders/material.glsl */
    GLuint scene_framebuffer, radiance_framebuffer, material_framebuffer, boundary_framebuffer, back_framebuffer, light_framebuffer,
        host_framebuffer, fog_framebuffer;
} al_targets;

struct al_runtime {
    al_shaders *shaders;
    al_gl_memory memory;
    al_file *scene_file;
    al_scene scene;
    bool loaded, ended;
    al_loader *loader;
    al_arrival arrival; /* being uploaded */
    bool arriving;
    uint32_t arrived; /* samples, bricks or layers of the arriving page on the GPU */
    al_model model;
    al_moving moving;
    al_gl_texture environment;
    uint32_t environment_levels;
    float environment_unit; /* radiance of its texture's 1, W/(m2 sr) */
    al_object *objects; /* [scene.translucent_count] */
    uint32_t *sorted;   /* their indices, far to near, in the frame being drawn */
    al_fogs fogs;
    al_shells shells;
    al_bounce bounce;
    al_history history;
    al_legs legs;
    al_lightmap lightmap;
    al_probe_lights probes;
    al_shadow_maps shadow;
    al_surfels surfels;
    al_targets targets;
    al_timing timing;
    al_gl_buffer frame_block;
    GLuint empty_vertex_array;
    uint32_t frame_number;
    uint64_t samples_drawn;
    al_settings settings; /* of the last frame, and whether there was one since the load */
    bool drawn;
    al_plan_row plan[AL_PLAN_LIMIT];
};

/* One call of al_runtime_draw. Passes answer AL_OK or what failed, with `error` filled. */
typedef struct al_draw {
    al_runtime *runtime;
    const al_view *view;
    al_settings settings; /* defaults filled in */
    al_frame_block block;
    double view_projection[16];
    double eye[4];      /* position and 1, or direction to the eye and 0 */
    int32_t tile[4];    /* x, y, width, height in the view */
    int32_t kept[4];    /* likewise, the part of it that goes to the host */
    bool needs_light;   /* samples are splatted */
    bool needs_shading; /* of opaque surfaces */
    bool needs_objects; /* translucent ones are in view */
    bool needs_map;     /* the view's transmittance interval map */
    bool needs_surfels; /* surfaces send light into the fog or to others or hide others, or the cloud is shown */
    bool effects[AL_BOUNCE_EFFECTS]; /* seen surfaces get them */
    bool needs_material; /* light comes to them after they are drawn */
    uint32_t framebuffer, host_depth;
    al_error *error;
} al_draw;

/* runtime.c */
/* Frees the buffers and textures of passes that the frame did without */
void al_runtime_sweep(al_runtime *runtime);
/* How many units of `size` bytes fit the budget, at least one and at most `left`; takes them off. */
uint64_t al_budget_share(uint64_t *budget, uint64_t size, uint64_t left);

/* model.c */
al_status al_model_create(al_runtime *runtime, al_error *error);
void al_model_free(al_runtime *runtime);
bool al_model_is_glossy(const al_runtime *runtime); /* an opaque surface has a lobe beside Lambert's */
uint64_t al_model_bytes(const al_runtime *runtime); /* without second UV sets, which are the lightmap's */
void al_model_world_box(const al_runtime *runtime, const al_instance *instance, float low[3], float high[3]);

/* motion.c: al_runtime_set_time, and what follows it on the GPU */
al_status al_motion_create(al_runtime *runtime, al_error *error); /* after al_model_create */
void al_motion_free(al_runtime *runtime);
al_status al_motion_draw(al_draw *draw); /* before anything draws a mesh */
uint64_t al_motion_bytes(const al_runtime *runtime);

/* environment.c */
al_status al_environment_upload(al_runtime *runtime, al_error *error);
bool al_environment_exists(const al_environment *environment);
void al_environment_fill(al_draw *draw);
void al_environment_for_object(const al_draw *draw, al_object *object);

/* object.c */
/* Uploads a part of `arrival` within *budget bytes (at least something) and takes what it used off it; *done
 * when nothing of it is left. */
al_status al_object_accept(al_runtime *runtime, const al_arrival *arrival, uint64_t *budget, bool *done,
                           al_error *error);
void al_object_free(al_runtime *runtime, al_object *object);
uint64_t al_object_coefficient_size(const al_translucent_info *info); /* bytes per sample */
/* Fills draw->block's casters and every object's block, prefix, order and place in view; sorts. */
void al_objects_prepare(al_draw *draw);

/* fog.c */
al_status al_fog_create(al_runtime *runtime, al_error *error); /* nothing where the scene has no fog */
al_status al_fog_accept(al_runtime *runtime, const al_arrival *arrival, uint64_t *budget, bool *done,
                        al_error *error);
void al_fog_fail(al_runtime *runtime, uint32_t index);
void al_fog_free(al_runtime *runtime);
/* fog_motion.c: the entry of a fog that has been moved */
void al_fog_move(const al_fog *fog, al_fog_entry *entry);

/* fog_frames.c */
uint32_t al_fog_slot_count(const al_medium_info *info);
/* A frame comes into the slot `incoming`: what it is, then its bricks. */
void al_fog_begin_frame(al_fog_medium *medium, uint32_t index, const al_medium_frame *frame);
void al_fog_take_bricks(al_fog_medium *medium, uint32_t count);
/* Shows the frames at the time where they have arrived, and asks the loader for the next ones. */
void al_fog_follow(al_runtime *runtime);
bool al_fog_is_current(const al_runtime *runtime); /* every sequence shows its frame at the time */
double al_fog_length_s(const al_runtime *runtime); /* of the longest sequence that has arrived, 0: none */
/* Chooses what the frame draws and binds it for every pass. */
void al_fog_prepare(al_draw *draw);
const char *al_fog_define(const al_draw *draw); /* of shaders that attenuate light by the fogs; "" without */
al_status al_fog_draw(al_draw *draw);           /* over the opaque surfaces */
al_status al_fog_draw_front(al_draw *draw);     /* up to the boundary of one translucent object */
uint64_t al_fog_bytes(const al_runtime *runtime);
uint64_t al_fog_grid_bytes(const al_runtime *runtime); /* of densities that vary, not in al_fog_bytes */

/* interval_map.c */
/* Fills the block of the frame's shells; surfels are splatted. */
al_status al_shells_prepare(al_draw *draw);
al_status al_interval_map_run(al_draw *draw);
const char *al_interval_map_define(const al_runtime *runtime); /* of shaders that read its weights */
void al_shells_sweep(al_runtime *runtime);
uint64_t al_interval_map_bytes(const al_runtime *runtime);
uint64_t al_shells_bytes(const al_runtime *runtime); /* what splats onto it and gathers, besides */
al_status al_shells_draw(al_draw *draw);  /* shell.c: the surfels' shells into the levels */
al_status al_bounce_medium(al_draw *draw);  /* bounce.c: instead, the light along drawn rays, with what hides it */
/* bounce_surface.c: of seen surfaces, added to the radiance; ambient occlusion as light of the environment where that is
 * still missing, else alone */
al_status al_bounce_surface(al_draw *draw, al_bounce_effect effect);
al_status al_bounce_inspect(al_draw *draw); /* bounce.c: its last rays, and what they hit */
uint64_t al_bounce_surface_bytes(const al_runtime *runtime); /* beside what the medium's has too */
float al_bounce_extent(const al_runtime *runtime); /* diagonal of the box around all opaque instances, m */
al_status al_bounce_fit(al_draw *draw, const al_shell_block *shells);
/* The nearest surfel on every ray of bounce.rays, level by level, timed as `stage`; `choice`: defines. */
al_status al_bounce_splat(al_draw *draw, al_stage stage, const al_shell_block *block, const al_gl_texture *span,
                          const char *choice);
void al_bounce_clear(const al_draw *draw, const al_shell_block *block); /* no hits; ready to draw into all of a level */
void al_bounce_bind_hits(const al_bounce *bounce); /* for shaders/bounce_hits.glsl */
al_carrier al_bounce_carrier(const al_draw *draw, al_bounce_effect effect);
bool al_bounce_sums(const al_draw *draw, al_bounce_effect effect); /* its carrier sends no rays */
GLuint al_bounce_begin_sum(const al_draw *draw); /* into bounce.light, cleared, of 1 sample, by blending; a framebuffer */
void al_bounce_end_sum(GLuint framebuffer);      /* deletes it */
/* volumes.c: into a cleared level of the bounced z-buffer, the nearest triangle on every ray, and where light is asked for
 * its material; or into bounce.light the sum of what each triangle hides. Blocks are bound and bounce.span is filled. */
al_status al_volumes_trace(al_draw *draw, al_bounce_effect effect, al_stage stage, const al_shell_block *block);
al_status al_volumes_sum(al_draw *draw, al_stage stage);
uint64_t al_bounce_bytes(const al_runtime *runtime); /* of the z-buffer, the medium's and surfaces' alike */
void al_bounce_sweep(al_runtime *runtime);
/* history.c: once a frame before and after its tiles (only of a frame that is whole); for each effect of a tile, the mean of
 * bounce.light and its history takes its place */
al_status al_history_begin(al_draw *draw);
al_status al_history_run(al_draw *draw, al_bounce_effect effect);
void al_history_end(al_draw *draw);
uint64_t al_history_bytes(const al_runtime *runtime);
void al_history_free(al_runtime *runtime);
/* legs.c: what leg_transmittance needs in this frame, its defines (at most 64 bytes) and its texture. */
al_status al_legs_run(al_draw *draw);
void al_legs_define(const al_draw *draw, char defines[64]);
GLuint al_legs_texture(const al_runtime *runtime);
void al_legs_sweep(al_runtime *runtime); /* fog_depth.c's texture too */
/* shell.c: by which splats are left out, start and end of the medium on every ray, or the surface's distance with
 * AL_SURFACE as `choice`, and of the nearest and farthest among ever more of them; timed as `stage` */
al_status al_span_run(al_draw *draw, al_stage stage, const al_shell_block *block, al_gl_texture *span, const char *choice);
al_status al_shells_fit_light(al_draw *draw, uint32_t layers); /* gather.c: what is blurred and summed */
al_status al_shells_gather_front(al_draw *draw); /* gather.c: what of it comes from before an object, to its fog's light */
al_status al_shells_inspect(al_draw *draw); /* composite.c */
al_status al_shells_gather(al_draw *draw); /* gather.c: the levels' sum over what the tile holds */

/* fog_sky.c: when every medium has arrived and none has been drawn */
al_status al_fog_sky_upload(al_runtime *runtime, al_error *error);
void al_fog_sky_fill(const al_runtime *runtime, const al_fog_medium *medium, al_fog_entry *entry);
void al_fog_sky_bind(const al_runtime *runtime);
bool al_fog_sky_exists(const al_runtime *runtime);
uint64_t al_fog_sky_bytes(const al_runtime *runtime);
void al_fog_sky_free(al_runtime *runtime);

/* fog_depth.c: the baked depths of the fogs in fogs.depth and the block; AL_BAD_INPUT where one keeps none. */
al_status al_fog_depth_run(al_draw *draw, al_legs_block *block, uint32_t *order);

/* lightmap.c */
al_status al_lightmap_accept(al_runtime *runtime, const al_arrival *arrival, uint64_t *budget, bool *done,
                             al_error *error);
void al_lightmap_free(al_runtime *runtime);
bool al_lightmap_exists(const al_runtime *runtime, uint32_t instance); /* its page has arrived */
/* Binds the instance's page, which exists, and sets the uniforms of surface.frag's AL_LIGHTMAP. */
void al_lightmap_bind(const al_draw *draw, uint32_t instance);
/* Shares of a baked light's layers that this frame shows: without fog `surface`, else the two others. */
void al_baked_layers(const al_draw *draw, float shares[AL_LAYER_COUNT]);
uint64_t al_lightmap_bytes(const al_runtime *runtime);

/* probes.c */
al_status al_probes_accept(al_runtime *runtime, const al_arrival *arrival, al_error *error);
void al_probes_free(al_runtime *runtime);
/* Sets the uniforms of surface.frag's AL_PROBES; the probes are present. */
void al_probes_set(const al_draw *draw, uint32_t instance);

/* shadow.c: fills draw->block's lights */
al_status al_shadow_draw(al_draw *draw);
void al_shadow_free(al_runtime *runtime);

/* surfel.c: the cloud of the frame, lit, when draw->needs_surfels; what it holds stays until the next frame */
al_status al_surfels_run(al_draw *draw);
void al_surfels_free(al_runtime *runtime);
uint64_t al_surfels_bytes(const al_runtime *runtime);
uint64_t al_surfels_count(const al_runtime *runtime); /* of the last frame that has come back */
/* Draws a point per surfel, gl_VertexID being its number, with the program, vertex array and state that are bound; surfels
 * and their count are bound as shaders/surfels.glsl says. */
void al_surfels_draw_points(const al_draw *draw);
al_status al_surfels_light(al_draw *draw); /* surfel_light.c */
al_status al_surfels_show(al_draw *draw);  /* surfel_light.c: AL_PASS_SURFELS into one tile */
/* surfel_count.c: expected number of surfels of the scene's opaque instances */
double al_surfels_expected(const al_scene *scene, const al_surfel_rule *rule);

/* targets.c: makes the targets fit the tile */
al_status al_targets_fit(al_draw *draw);
void al_targets_sweep(al_runtime *runtime);

/* surface.c */
/* Sets the part's material as uniforms 1 to 4 and textures of surface.frag, and answers it. */
const al_material *al_material_bind(const al_runtime *runtime, const al_submesh *part);
/* How it is lit now: where what is baked has not arrived yet, the lights light it. */
al_lighting al_instance_lighting(const al_runtime *runtime, uint32_t instance);
bool al_instance_mirrors(const al_instance *instance); /* the front is where vertices turn clockwise */
al_status al_surface_draw(al_draw *draw);
al_status al_boundary_draw(al_draw *draw, al_object *object, uint32_t index);
al_status al_back_draw(al_draw *draw, uint32_t index);

al_status al_light_run(al_draw *draw, al_object *object);                            /* light.c */
al_status al_intervals_run(al_draw *draw, al_object *object, const int32_t area[4]); /* intervals.c */
al_status al_splat_draw(al_draw *draw, al_object *object);                           /* splat.c */
al_status al_object_join(al_draw *draw);                                             /* composite.c */
al_status al_inspect_draw(al_draw *draw); /* composite.c: normals or distances instead of radiance */
al_status al_output_draw(al_draw *draw);  /* composite.c */

#endif
