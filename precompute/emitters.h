/* Emissive triangles as a light to sample: points in proportion to the power given off there. */
#ifndef AIRLIGHT_EMITTERS_H
#define AIRLIGHT_EMITTERS_H

#include "ray_scene.h"

typedef struct al_emitters al_emitters;

/* Of the opaque instances in `scene`, which was made from `import`; both must outlive the emitters. */
al_status al_emitters_create(const al_import *import, const al_ray_scene *scene, al_emitters **emitters,
                             al_error *error);
void al_emitters_free(al_emitters *emitters); /* NULL is allowed */

uint32_t al_emitters_count(const al_emitters *emitters); /* triangles; 0: nothing to sample */

/* A point for u in [0,1)^3 and its probability per square metre. Its emission is that of the front, and of
 * the back too when the material is double-sided. There must be emitters. */
double al_emitters_sample(const al_emitters *emitters, const double u[3], al_surface_hit *point);
/* Probability per square metre of drawing a point of this material: the same all over it. */
double al_emitters_density(const al_emitters *emitters, const al_material *material);

#endif
