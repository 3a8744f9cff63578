/* The lightmap's atlas: every lightmapped mesh gets a second UV set that serves, every instance a rectangle
 * of texels on a page. */
#ifndef AIRLIGHT_ATLAS_H
#define AIRLIGHT_ATLAS_H

#include "import.h"

typedef struct al_atlas_instance {
    uint32_t instance; /* of the scene, ascending */
    uint32_t page;
    uint32_t x, y, width, height; /* texels that [0, 1] of the mesh's uv1 covers */
} al_atlas_instance;

typedef struct al_atlas {
    uint32_t page_count, instance_count;
    uint32_t (*pages)[2]; /* [page_count] width and height in texels */
    al_atlas_instance *instances;
    double texel_m;        /* edge of a texel that was asked for */
    uint32_t own_count;    /* meshes that got our own uv1 */
    uint32_t coarse_count; /* meshes that would not fit a page and got larger texels */
} al_atlas;

/* True when any instance is lit by a lightmap. */
bool al_atlas_needed(const al_scene *scene);

/* Texels that the lightmapped surfaces will fill, from their area. */
double al_atlas_texels(const al_import *import);

/* Lays the atlas out as description->lightmap says. Where a mesh has no second UV set that serves, and the
 * settings allow it, its uv1 becomes our own, its vertices split where charts part; indices keep their order.
 * Instances of one mesh share its uv1; smaller ones get fewer texels, but not below a quarter of the largest
 * one's along each edge. AL_BAD_INPUT names the mesh. Deterministic. */
al_status al_atlas_make(al_import *import, al_atlas *atlas, al_error *error);
void al_atlas_free(al_atlas *atlas);

#endif
