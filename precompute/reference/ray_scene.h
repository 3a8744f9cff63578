/* Rays against the scene: where a line lies inside translucent objects, and what opaque surfaces stop it.
 *
 * Embree finds the triangles in single precision; distances are computed again in double precision from the
 * triangles' planes. World space, metres; directions are unit vectors. */
#ifndef AIRLIGHT_RAY_SCENE_H
#define AIRLIGHT_RAY_SCENE_H

#include "import.h"

typedef struct al_ray {
    double origin[3], direction[3];
} al_ray;

/* A stretch of a ray inside one translucent object, distances from the origin. */
typedef struct al_segment {
    double begin_m, end_m;
    uint32_t object; /* index into scene.translucents */
} al_segment;

typedef struct al_ray_scene al_ray_scene;
al_status al_ray_scene_create(const al_import *import, al_ray_scene **scene, al_error *error);
void al_ray_scene_free(al_ray_scene *scene);

/* Memory of one thread, reused from ray to ray. Zero before the first use. */
typedef struct al_line {
    struct al_crossing *crossings;
    uint32_t crossing_count, crossing_room;
    al_segment *segments; /* the answer; they overlap where objects do, and are in no order */
    uint32_t segment_count, segment_room;
    int32_t *depths; /* [translucent_count] */
    double *ends;    /* [translucent_count] */
    bool failed;
} al_line;
void al_line_free(al_line *line);

/* Fills line->segments for the ray from its origin to `end_m` (INFINITY allowed). False without memory. */
bool al_ray_scene_segments(const al_ray_scene *scene, const al_ray *ray, double end_m, al_line *line);

/* Distance to the first opaque surface or blocker, INFINITY when there is none. */
double al_ray_scene_opaque_m(const al_ray_scene *scene, const al_ray *ray);
/* Whether one is nearer than `end_m`. */
bool al_ray_scene_is_blocked(const al_ray_scene *scene, const al_ray *ray, double end_m);

#endif
