/* The texels of an atlas: for each that a surface touches, a point of the surface in it. */
#ifndef AIRLIGHT_TEXELS_H
#define AIRLIGHT_TEXELS_H

#include "atlas.h"

typedef struct al_texel {
    uint32_t page, cell; /* cell = row * page width + column */
    uint32_t chart;      /* parts of uv1 that hang together, numbered over all instances */
    float edge_m;        /* of the texel on the surface: square root of its area there */
    float normal[3];     /* unit, interpolated, on the side of the triangle's own */
    double position[3];  /* world, metres */
} al_texel;

typedef struct al_texels {
    uint32_t count;
    al_texel *texels; /* by page, then cell */
} al_texels;

/* A texel belongs to the triangle that covers its centre and takes its point there, else to the one with the
 * largest share of it, at the middle of that share. Triangles without area are left out. Deterministic. */
al_status al_texels_make(const al_scene *scene, const al_atlas *atlas, al_texels *texels, al_error *error);
void al_texels_free(al_texels *texels);

/* Page coordinates, in texels, of a corner of a mesh. */
void al_texels_corner(const al_mesh *mesh, const al_atlas_instance *instance, uint32_t vertex, double at[2]);

#endif
