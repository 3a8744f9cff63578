/* What a material reflects and gives off at a point: factors times textures, as the runtime draws them. */
#ifndef AIRLIGHT_SURFACE_COLOR_H
#define AIRLIGHT_SURFACE_COLOR_H

#include "airlight/scene.h"

typedef struct al_surface_colors {
    const al_scene *scene;
    float linear[256]; /* of an sRGB byte */
} al_surface_colors;

/* The scene must outlive it. */
al_surface_colors al_surface_colors_of(const al_scene *scene);

/* Of the Lambert part: base colour times 1 - metallic. Metals have none: their light is mirrored. */
void al_surface_albedo(const al_surface_colors *colors, const al_material *material, const double uv[2],
                       double albedo[3]);
/* Of the mirrored part: reflectance along the normal, glTF's mix of the dielectric's and the base colour, and
 * roughness. */
void al_surface_gloss(const al_surface_colors *colors, const al_material *material, const double uv[2],
                      double f0[3], double *roughness);
void al_surface_emission(const al_surface_colors *colors, const al_material *material, const double uv[2],
                         double emission_w_m2_sr[3]);
/* The emission's mean over the whole texture. */
void al_surface_mean_emission(const al_surface_colors *colors, const al_material *material,
                              double emission_w_m2_sr[3]);

#endif
