/* Baked folders made from formulas: homogeneous spheres whose transmittance is known, and what stands around.
 */
#ifndef AIRLIGHT_TEST_SPHERE_H
#define AIRLIGHT_TEST_SPHERE_H

#include <stdbool.h>
#include <stdint.h>

#include "airlight/medium.h"
#include "airlight/scene.h"
#include "airlight/translucent.h"

typedef struct sphere_options { /* zero: the value in brackets */
    float radius;               /* m (1) */
    float sigma_t[3];           /* per metre (2, and the first one for the others) */
    bool vacuum;                /* no extinction */
    bool blocked;               /* opaque matter fills the half z < 0 */
    float albedo;               /* (0.9) */
    float g;
    uint32_t samples;   /* (4000) about as many */
    float reach;        /* standard deviations at which Gaussians are cut off (3.5) */
    uint32_t order;     /* (5) */
    uint32_t grid;      /* voxels along an axis (64) */
    uint32_t page_size; /* (512) */
    al_coefficient_format format;
} sphere_options;

/* Writes FOLDER/NAME; prints the error and answers false on one. */
bool sphere_write_asset(const char *folder, const char *name, const sphere_options *options);

/* Lays data->info.size voxels of the medium out over the fog's box. */
void sphere_lay_grid(al_medium_data *data, const al_fog *fog, const al_medium *medium);

/* A scene under construction; arrays are its own. */
typedef struct sphere_scene {
    al_scene scene;
    al_mesh meshes[2]; /* a unit sphere, a 1 m square in x and z facing +y */
    al_submesh submeshes[2];
    al_material materials[2]; /* index-matched, white Lambert */
    al_medium medium;
    al_instance instances[16];
    al_translucent_object objects[12];
    al_light lights[64];
    al_camera camera;
} sphere_scene;

/* Both meshes, no instances or lights. */
void sphere_scene_begin(sphere_scene *s);
/* A translucent sphere of `radius` at `place`, drawn from FOLDER/asset. */
void sphere_scene_add(sphere_scene *s, const char *asset, float radius, const float place[3]);
/* The square scaled by `size`, its middle at `place`, facing +y. */
void sphere_scene_add_floor(sphere_scene *s, float size, const float place[3]);
void sphere_scene_add_light(sphere_scene *s, al_light_type type, const float vector[3], float intensity);
bool sphere_scene_write(const char *folder, const sphere_scene *s);
void sphere_scene_end(sphere_scene *s);

#endif
