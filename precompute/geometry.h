/* Triangles on their way into the scene: loose corners, transforms, normals. */
#ifndef AIRLIGHT_GEOMETRY_H
#define AIRLIGHT_GEOMETRY_H

#include "import.h"

/* Zeroed memory of the scene for `count` elements; NULL without memory. */
void *al_scene_array(al_scene *scene, size_t count, size_t size);
/* Room for one more element of an array that lives in the scene; NULL without memory. */
void *al_scene_append(al_scene *scene, void *array, uint32_t *count, size_t size);

/* Triangle corners, three in a row for each triangle, nothing shared. Owned by the caller. */
typedef struct al_corners {
    uint32_t count, room; /* corners; a multiple of 3 */
    float *positions;     /* [count][3] */
    float *normals;       /* [count][3], (0,0,0) where the file gives none */
    float *uv0, *uv1;     /* [count][2] */
    uint32_t *marks;      /* [count] corners with different marks are never joined; 0 unless set */
    bool has_uv0, has_uv1;
} al_corners;

/* Makes room for `more` corners behind `count`. */
al_status al_corners_reserve(al_corners *corners, uint32_t more, al_error *error);
void al_corners_free(al_corners *corners);

/* Applies a column-major affine matrix to corners first to count-1; keeps triangles facing the same side. */
void al_corners_transform(al_corners *corners, uint32_t first, const double matrix[16]);

/* Fills missing normals (see docs/scene.md: smooth up to 60 degrees), joins equal corners and adds the mesh
 * to the scene. Submeshes stay for the caller to set: index_count is corners->count, in the same order. */
al_status al_corners_to_mesh(al_scene *scene, al_corners *corners, const char *name, uint32_t *mesh_index,
                             al_error *error);

/* Procedural shapes. */
al_status al_shape_corners(const al_shape_description *shape, al_corners *corners, al_error *error);

/* --- column-major 4x4 matrices with last row 0 0 0 1 --- */
void al_matrix_multiply(const double a[16], const double b[16], double out[16]);
void al_matrix_point(const double m[16], const double in[3], double out[3]);
double al_matrix_determinant(const double m[16]);
/* The determinant must not be 0. */
void al_matrix_invert(const double m[16], double out[16]);
/* m = rigid * rest: a rotation with m's translation, and what is left. The rotation is m's own when m turns
 * and scales evenly, else none. Answers whether m was a rotation with even, positive scale. */
bool al_matrix_split(const double m[16], double rigid[16], double rest[16]);

#endif
