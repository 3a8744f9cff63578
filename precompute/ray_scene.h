/* Rays against the scene: where a line lies inside translucent objects, what opaque surfaces stop it, and
 * what those look like there.
 *
 * Embree finds the triangles in single precision; distances and positions are computed again in double
 * precision from the triangles' vertices. World space, metres; directions are unit vectors.
 * Thread safety: any number of threads may ask a scene. Nothing is allocated per ray, but in al_line. */
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

typedef enum al_ray_scene_content {
    AL_RAY_SCENE_ALL = 0,
    AL_RAY_SCENE_STILL = 1 /* without opaque instances that move or are lit by probes: those may */
} al_ray_scene_content;

typedef struct al_ray_scene al_ray_scene;
/* The import must outlive the scene. */
al_status al_ray_scene_create(const al_import *import, al_ray_scene_content content, al_ray_scene **scene,
                              al_error *error);
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

/* A point of an opaque surface. Blockers are black. */
typedef struct al_surface_hit {
    double distance_m, position[3];
    double normal[3]; /* geometric, unit, on the side from which the triangle runs counter-clockwise */
    double shading_normal[3]; /* of the vertices, interpolated, unit, on the same side */
    double offset_m;          /* how far off the surface a ray must begin, or end: al_surface_offset */
    bool front;               /* the ray meets the side of the normal */
    uint32_t instance, triangle;
    double uv0[2]; /* 0 where the mesh has none */
    const al_material *material;
    double albedo[3];           /* base colour times 1 - metallic, textured, linear */
    double emission_w_m2_sr[3]; /* textured, given off against the ray: from the front, or double-sided */
} al_surface_hit;

/* The first opaque surface or blocker nearer than `end_m` (INFINITY allowed); false when there is none. */
bool al_ray_scene_hit(const al_ray_scene *scene, const al_ray *ray, double end_m, al_surface_hit *hit);

/* Triangles of an instance; 0 for what is not in the scene or not opaque. */
uint32_t al_ray_scene_triangle_count(const al_ray_scene *scene, uint32_t instance);
/* The point (1 - u - v) a + u b + v c of a triangle, seen from its front; distance 0. */
void al_ray_scene_point(const al_ray_scene *scene, uint32_t instance, uint32_t triangle, double u, double v,
                        al_surface_hit *point);

/* Where rays begin that leave the point along `direction` (or end that arrive against it): offset_m along the
 * normal, on the side of `direction`. Then Embree's rounding cannot make a ray meet the surface it left. */
void al_surface_offset(const al_surface_hit *hit, const double direction[3], double origin[3]);
/* The same offset for a point on a surface that is not known: enough for any of the scene. */
double al_ray_scene_offset_m(const al_ray_scene *scene);
/* The box around all surfaces, boundaries of translucent objects included; a point when there are none. */
void al_ray_scene_bounds(const al_ray_scene *scene, double low[3], double high[3]);

#endif
