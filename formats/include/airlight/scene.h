/* The scene as it is drawn: filled by the import, written to `scene.air`, read back by the runtime.
 *
 * Right-handed, +y up, metres, linear RGB (Rec. 709). Matrices are column-major float[16] (OpenGL).
 * Lifetime: an al_scene from al_scene_read points into its al_file where it can; one from the import owns
 * everything. al_scene_free handles both. Strings are never NULL ("" when absent). */
#ifndef AIRLIGHT_SCENE_H
#define AIRLIGHT_SCENE_H

#include <stdbool.h>

#include "airlight/container.h"
#include "airlight/motion.h"

#ifdef __cplusplus
extern "C" {
#endif

#define AL_NO_INDEX UINT32_MAX

typedef struct al_texture { /* 8 bits a channel, RGBA, first row on top */
    char *name;
    uint32_t width, height;
    bool srgb;
    uint8_t *pixels; /* [height][width][4] */
} al_texture;

typedef struct al_material { /* glTF 2.0 metallic-roughness */
    char *name;
    float base_color[3];
    float metallic, roughness;
    float emission_w_m2_sr[3];
    float ior; /* Fresnel reflectance of the dielectric lobe: ((ior-1)/(ior+1))^2 */
    bool double_sided;
    uint32_t base_color_texture, emission_texture, metallic_roughness_texture, normal_texture; /* AL_NO_INDEX */
} al_material;

typedef struct al_submesh {
    uint32_t first_index, index_count; /* range in al_mesh.indices, multiples of 3 */
    uint32_t material;
} al_submesh;

typedef struct al_mesh {
    char *name;
    uint32_t vertex_count, index_count, submesh_count;
    float *positions; /* [vertex_count][3] */
    float *normals;   /* [vertex_count][3] unit */
    float *uv0;       /* [vertex_count][2] or NULL */
    float *uv1;       /* [vertex_count][2] or NULL */
    uint32_t *indices;
    al_submesh *submeshes;
} al_mesh;

typedef enum al_role {
    AL_ROLE_OPAQUE = 0,      /* drawn and shadowing */
    AL_ROLE_TRANSLUCENT = 1, /* boundary of a translucent object */
    AL_ROLE_BLOCKER = 2      /* inside a translucent object: part of its asset; drawn black */
} al_role;

typedef enum al_lighting { /* what lights an opaque instance besides the lights themselves */
    AL_LIGHTING_DYNAMIC = 0,  /* nothing baked */
    AL_LIGHTING_LIGHTMAP = 1, /* it stands still: a lightmap holds all its light, direct light included */
    AL_LIGHTING_PROBES = 2    /* it moves: direct light, and the probes' indirect light */
} al_lighting;

typedef struct al_instance {
    char *name;
    uint32_t mesh;
    uint32_t role;        /* al_role */
    uint32_t translucent; /* index into translucents for AL_ROLE_TRANSLUCENT and _BLOCKER, else AL_NO_INDEX */
    float world[16];      /* object space to world */
    uint32_t lighting;    /* al_lighting; AL_LIGHTING_DYNAMIC unless the role is AL_ROLE_OPAQUE */
} al_instance;

typedef struct al_medium { /* coefficients at density 1 */
    char *name;
    float sigma_s_per_m[3], sigma_a_per_m[3];
    float g; /* in (-1, 1) */
} al_medium;

typedef struct al_fog { /* a medium that fills the air between the surfaces */
    uint32_t medium;
    bool bounded;                         /* false: it reaches everywhere and the bounds are 0 */
    float bounds_min_m[3], bounds_max_m[3]; /* world axes; outside there is nothing */
    float density; /* of a constant medium (asset ""): multiplies the medium's coefficients */
    char *asset;   /* file name of its `medium` asset beside scene.air; "" for a constant density */
    float moved[16]; /* from there to where it is; the identity as read, but for what moves. Not stored */
} al_fog;

typedef struct al_baked_light { /* file names beside scene.air, "" where there is none */
    char *lightmap, *probes;
} al_baked_light;

typedef struct al_translucent_object {
    char *name;
    uint32_t instance; /* the boundary's instance */
    uint32_t medium;
    char *asset; /* file name beside scene.air, "" before it is baked */
} al_translucent_object;

typedef enum al_light_type { AL_LIGHT_DIRECTIONAL = 0, AL_LIGHT_POINT = 1 } al_light_type;

typedef struct al_light {
    char *name;
    uint32_t type;      /* al_light_type */
    float vector[3];    /* directional: unit direction of travel; point: position */
    float intensity[3]; /* directional: irradiance in W/m2 facing the light; point: W/sr */
} al_light;

enum { AL_ENVIRONMENT_ORDER = 8 };

typedef struct al_environment { /* lat-long: first row +y, middle column -z, right quarter +x */
    uint32_t width, height;     /* 0: none */
    float *pixels;              /* [height][width][3] radiance, W/(m2 sr), scale and rotation applied */
    float sh[3][AL_ENVIRONMENT_ORDER * AL_ENVIRONMENT_ORDER]; /* of incident radiance, world axes */
} al_environment;

typedef struct al_camera {
    char *name;
    float position[3], target[3], up[3];
    float fov_y_radians;
} al_camera;

typedef struct al_play_settings {
    float exposure_ev; /* pixel = radiance * 2^exposure */
    float background[3];
} al_play_settings;

typedef struct al_scene {
    uint32_t texture_count, material_count, mesh_count, instance_count, medium_count, translucent_count,
        light_count, camera_count;
    al_texture *textures;
    al_material *materials;
    al_mesh *meshes;
    al_instance *instances;
    al_medium *media;
    al_translucent_object *translucents;
    al_light *lights;
    al_camera *cameras; /* at least one after the import */
    al_environment environment;
    al_play_settings play;
    uint32_t fog_count;
    al_fog *fogs;
    al_baked_light baked;
    al_motion motion; /* what moves: motion.h; the rest of the scene is as at time 0 */
    void *storage; /* private: what al_scene_free frees */
} al_scene;

al_status al_scene_read(const al_file *file, al_scene *scene, al_error *error);
/* Writes scene.air atomically; bytes may be NULL. */
al_status al_scene_write(const char *path, const al_scene *scene, const char *provenance_json, uint64_t *bytes,
                         al_error *error);
void al_scene_free(al_scene *scene); /* safe on a zeroed scene */

/* Memory of the scene, for who fills one: zeroed, aligned for any type, freed by al_scene_free alone. NULL
 * when there is none left; a size of 0 is allowed. Not for two threads at once on the same scene. */
void *al_scene_allocate(al_scene *scene, size_t size);
char *al_scene_text(al_scene *scene, const char *text); /* a copy of the text; NULL as above */

#ifdef __cplusplus
}
#endif
#endif
