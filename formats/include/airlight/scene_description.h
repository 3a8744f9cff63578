/* The JSON scene file, parsed and checked but not yet imported. Keys, units and defaults: docs/scene.md.
 * File names are made relative to the scene file's folder. Strings are never NULL. */
#ifndef AIRLIGHT_SCENE_DESCRIPTION_H
#define AIRLIGHT_SCENE_DESCRIPTION_H

#include <stdbool.h>
#include <stdint.h>

#include "airlight/scene.h"
#include "airlight/translucent.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum al_shape_type {
    AL_SHAPE_NONE = 0,   /* the mesh comes from a file */
    AL_SHAPE_SPHERE = 1, /* icosphere, vertices on the sphere */
    AL_SHAPE_BOX = 2,
    AL_SHAPE_PLANE = 3, /* rectangle in the plane y = 0, facing +y: not closed */
    AL_SHAPE_TORUS = 4  /* about the y axis */
} al_shape_type;

typedef struct al_shape_description { /* centred on the origin; which fields count depends on the type */
    al_shape_type type;
    double radius_m;
    double size_m[3];
    double width_m, depth_m; /* along x and z */
    double major_radius_m, minor_radius_m;
    uint32_t subdivisions; /* 20 * 4^subdivisions triangles, at most 8 */
    uint32_t major_segments, minor_segments;
} al_shape_description;

typedef struct al_motion_key_description { /* scaled, turned as al_mesh_description.transform, moved */
    double time_s, translate_m[3], rotate_degrees[3], scale[3];
} al_motion_key_description;

typedef struct al_motion_description { /* keys of something that moves; count 0: it stands still */
    uint32_t count;
    al_motion_key_description *keys; /* times rise, from 0 */
    int line;
} al_motion_description;

typedef struct al_mesh_description {
    char *name;
    char *file;          /* "" for a shape */
    char *node;          /* only this node of the file and what hangs on it; "": all */
    int line;            /* in the scene file, for messages */
    al_shape_description shape;
    double unit_m;       /* metres per file unit */
    double transform[16]; /* column-major, metres */
    char *material;      /* overrides every material of the file when not "" */
    bool hidden;         /* imported only as a boundary, blocker or light of others */
    bool import_lights, import_cameras; /* those in the file */
    char *animation; /* the only one of the file's to take; "": all of them */
    al_motion_description motion;
    al_lighting lighting;
} al_mesh_description;

typedef enum al_density_type { AL_DENSITY_CONSTANT = 0, AL_DENSITY_GRID = 1, AL_DENSITY_LAYERS = 2 } al_density_type;

typedef struct al_density_description {
    al_density_type type;
    int line;
    double scale;       /* density = scale * value */
    char *file, *grid;  /* grid: OpenVDB file and grid name ("" when the file has one float grid), "name[i]" */
    char *files;        /* of a sequence: names with %04d for the frame's number, `file` being the first; else "" */
    uint32_t first_frame, frame_count; /* frame_count 1: no sequence */
    double frames_per_second;
    double grid_to_world[16]; /* places the grid's own world space in the scene's, column-major */
    bool has_bounds;
    double bounds_min_m[3], bounds_max_m[3]; /* of the medium; default: the grid's active box */
    double axis[3], period_m, thickness_m, offset_m; /* layers along a unit axis: `high` where */
    al_motion_description motion; /* of the whole fog; only turns and moves */
    double low, high;   /* fract((x.axis - offset)/period) * period < thickness, else `low` */
} al_density_description;

typedef struct al_medium_description {
    char *name;
    int line;
    double sigma_s_per_m[3], sigma_a_per_m[3]; /* albedo and mean free path are converted */
    char *absorption_mesh, *absorption_material; /* sigma_a from this mesh file's material, or "" */
    double g;
    uint32_t optical_depth_order; /* bands of SH that a fog of varying density keeps; 0: none */
    al_density_description density;
} al_medium_description;

typedef struct al_translucent_description {
    char *name, *mesh, *medium;
    char **blockers;
    uint32_t blocker_count;
    int line;
} al_translucent_description;

typedef struct al_environment_description {
    char *file; /* "" : none or constant */
    double radiance[3]; /* of a constant environment, W/(m2 sr) */
    double scale, rotation_y_radians;
    int line;
} al_environment_description;

/* A medium whose mean free path is shorter than the samples' base radius. */
typedef enum al_too_dense { AL_TOO_DENSE_REFUSE = 0, AL_TOO_DENSE_BAKE = 1 } al_too_dense;

typedef struct al_bake_settings {
    uint32_t directions;     /* even, 2 to 4096 */
    uint32_t grid_resolution;/* voxels along the longest axis of the boundary's box, 1 to 512 */
    uint32_t samples;        /* asked count; 0 with radius_m > 0: the count follows from the radius */
    double radius_m;         /* > 0: base radius as published */
    uint32_t sh_order;       /* 1 to 8 */
    uint32_t coefficient_format; /* al_coefficient_format */
    uint32_t seed;
    al_too_dense too_dense;
} al_bake_settings;

/* How a lightmap or probe ray's response is kept from passing through walls: docs/methods.md. */
typedef enum al_walls { AL_WALLS_PUBLISHED = 0, AL_WALLS_BOUNDED = 1, AL_WALLS_TRACED = 2 } al_walls;

typedef enum al_uv_source {
    AL_UV_AUTO = 0,  /* the file's second UV set where it serves, else our own atlas */
    AL_UV_FILE = 1,  /* the file's, refused where it does not serve */
    AL_UV_ATLAS = 2  /* always our own */
} al_uv_source;

typedef struct al_lightmap_settings {
    double texel_m;           /* edge of a texel; 0: the lightmapped meshes' box diagonal / texels_across */
    uint32_t texels_across;
    uint32_t samples;         /* paths a texel */
    uint32_t bounces;         /* diffuse reflections after the first surface that a path meets; 0: direct only */
    al_walls walls;
    uint32_t fog_points;      /* bounded and traced walls: points in the fog along the longest edge of its box */
    bool back_scatter;        /* gather over the whole sphere, the receiver shifted along its normal */
    double back_scatter_shift_m; /* 0: 0.125 texel edges */
    al_uv_source uv;
    uint32_t directional_order; /* bands of SH a texel beside the irradiance; 0: none */
    uint32_t padding_texels;  /* between charts */
    uint32_t page_size;       /* largest edge of a page, texels */
    uint32_t seed;
} al_lightmap_settings;

typedef struct al_probe_settings {
    uint32_t order;      /* SH bands, 1 to 8 */
    uint32_t samples;    /* paths a probe */
    double spacing_m;    /* of automatic placement; 0: the lightmapped meshes' box diagonal / 12 */
    uint32_t point_count;
    double (*points)[3]; /* given places; none: automatic */
} al_probe_settings;

typedef struct al_scene_description {
    char *path, *folder;
    double unit_m;
    uint32_t mesh_count, material_count, light_count, camera_count, medium_count, translucent_count;
    al_mesh_description *meshes;
    al_material *materials; /* textures are AL_NO_INDEX here */
    al_light *lights;
    al_motion_description *light_motions; /* [light_count] */
    al_camera *cameras;
    al_motion_description *camera_motions; /* [camera_count] */
    al_medium_description *media;
    al_translucent_description *translucents;
    al_environment_description environment;
    uint32_t fog_count;
    uint32_t *fogs;         /* [fog_count] media that fill the air */
    bool has_probes;
    al_lightmap_settings lightmap;
    al_probe_settings probes;
    al_bake_settings bake;  /* what the scene file says over the defaults of `quality` */
    al_play_settings play;
    void *storage; /* private: what al_scene_description_free frees */
} al_scene_description;

typedef enum al_quality { AL_QUALITY_PREVIEW = 0, AL_QUALITY_MEDIUM = 1, AL_QUALITY_FINAL = 2 } al_quality;

/* The settings a quality stands for: where the scene file says nothing. */
al_bake_settings al_bake_settings_for(al_quality quality);
al_lightmap_settings al_lightmap_settings_for(al_quality quality);
al_probe_settings al_probe_settings_for(al_quality quality);

/* Parses and validates. Unknown keys, wrong types and ranges: AL_BAD_INPUT naming file, line and key path. */
al_status al_scene_description_read(const char *path, al_quality quality, al_scene_description **description,
                                    al_error *error);
void al_scene_description_free(al_scene_description *description); /* NULL is allowed */

/* The file of frame `index` of a sequence, from 0; false where it does not fit `size`. */
bool al_density_frame_file(const al_density_description *density, uint32_t index, char *path, size_t size);

/* --- the keys of a scene file, for the schema and its test --- */
typedef enum al_scene_type {
    AL_SCENE_STRING,
    AL_SCENE_NUMBER,  /* within [minimum, maximum] */
    AL_SCENE_INTEGER, /* within [minimum, maximum] */
    AL_SCENE_BOOL,
    AL_SCENE_TRIPLE,  /* one number for all, or three; each within [minimum, maximum] */
    AL_SCENE_VECTOR,  /* three numbers */
    AL_SCENE_MATRIX,  /* 16 numbers, column-major */
    AL_SCENE_CHOICE,  /* one of `words` */
    AL_SCENE_NAMES,   /* list of strings */
    AL_SCENE_OBJECT,  /* an object of kind `words` */
    AL_SCENE_LIST     /* list of objects of kind `words` */
} al_scene_type;

typedef struct al_scene_key {
    const char *object, *key;
    al_scene_type type;
    bool required;
    double minimum, maximum;
    const char *words; /* "a|b|c", or the kind of object */
    size_t offset;     /* private */
} al_scene_key;

const al_scene_key *al_scene_keys(size_t *count);

#ifdef __cplusplus
}
#endif
#endif
