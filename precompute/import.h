/* Import: a scene description becomes triangles, materials, lights and densities. */
#ifndef AIRLIGHT_IMPORT_H
#define AIRLIGHT_IMPORT_H

#include "airlight/scene.h"
#include "airlight/scene_description.h"
#include "density.h"

typedef struct al_input { /* a file that was read, for the report and for content hashes */
    char *path;
    uint64_t xxh64;
} al_input;

typedef struct al_import {
    al_scene_description *description;
    al_scene scene;
    al_density **densities; /* [scene.medium_count] */
    al_input *inputs;
    uint32_t input_count;
} al_import;

/* Reads the scene file and everything it names. Boundary and blocker meshes are checked: watertight,
 * outward-facing, finite, not empty; their vertices are welded by exact position for the check. */
al_status al_import_scene(const char *path, al_quality quality, al_import **import, al_error *error);
void al_import_free(al_import *import);

/* A boundary or blocker as plain welded triangles in object space (the instance's), for the bake. */
typedef struct al_triangles {
    uint32_t vertex_count, triangle_count;
    double *positions; /* [vertex_count][3] metres */
    uint32_t *indices; /* [triangle_count][3], counter-clockwise seen from outside */
} al_triangles;

/* All triangles of the translucent object's boundary, and of its blockers in the same object space (their
 * instances share the boundary's world matrix, which only turns and moves: its metres are the world's). */
al_status al_import_boundary(const al_import *import, uint32_t translucent, al_triangles *boundary,
                             al_error *error);
al_status al_import_blockers(const al_import *import, uint32_t translucent, al_triangles *blockers,
                             al_error *error);
void al_triangles_free(al_triangles *triangles);

/* One mesh of the scene, welded, in its object space. */
al_status al_triangles_from_mesh(const al_mesh *mesh, al_triangles *triangles, al_error *error);

/* Refuses what is no closed surface: no triangles, vertices that are not finite, open edges, edges of more
 * than two triangles, mixed winding, inside out. `name` begins the message. Triangles without area are
 * allowed. */
al_status al_triangles_check(const char *name, const al_triangles *triangles, al_error *error);

/* Signed volume in m3, positive when the triangles face outwards. */
double al_triangles_volume(const al_triangles *triangles);

#endif
