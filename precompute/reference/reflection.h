/* How the surface that the eye sees reflects: Lambert and a GGX lobe, in glTF's metallic-roughness terms, as
 * the player shades (shaders/shade.glsl). */
#ifndef AIRLIGHT_REFLECTION_H
#define AIRLIGHT_REFLECTION_H

#include "ray_scene.h"
#include "surface_color.h"

typedef struct al_reflection {
    double normal[3], face[3], view[3]; /* unit: interpolated; of the triangle; towards the eye */
    double diffuse[3], f0[3];
    double alpha;         /* of GGX: roughness squared, at least 0.001 */
    double lambert_share; /* of the directions drawn */
} al_reflection;

/* Of a hit that is seen from `view`: its normals on the eye's side; normal maps are left out. */
al_reflection al_reflection_of(const al_surface_colors *colors, const al_surface_hit *hit,
                               const double view[3]);

/* BRDF times the cosine towards the light, per steradian; 0 below the normal or the face. */
void al_reflection_value(const al_reflection *r, const double towards[3], double value[3]);
/* A direction for u in [0,1)^3, and the probability per steradian of drawing one. */
void al_reflection_draw(const al_reflection *r, const double u[3], double towards[3]);
double al_reflection_density(const al_reflection *r, const double towards[3]);

#endif
