#include "geometry.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "weld.h"

/* --- matrices --- */

void al_matrix_multiply(const double a[16], const double b[16], double out[16])
{
    double product[16];
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 4; row++) {
            product[column * 4 + row] = 0;
            for (int k = 0; k < 4; k++) product[column * 4 + row] += a[k * 4 + row] * b[column * 4 + k];
        }
    memcpy(out, product, sizeof product);
}

void al_matrix_point(const double m[16], const double in[3], double out[3])
{
    double point[3];
    for (int i = 0; i < 3; i++) point[i] = m[i] * in[0] + m[4 + i] * in[1] + m[8 + i] * in[2] + m[12 + i];
    memcpy(out, point, sizeof point);
}

/* Row i, column j of the cofactor matrix of the upper 3x3 part: cyclic indices carry the sign. */
static double cofactor(const double m[16], int row, int column)
{
    int r1 = (row + 1) % 3, r2 = (row + 2) % 3, c1 = (column + 1) % 3, c2 = (column + 2) % 3;
    return m[c1 * 4 + r1] * m[c2 * 4 + r2] - m[c2 * 4 + r1] * m[c1 * 4 + r2];
}

double al_matrix_determinant(const double m[16])
{
    return m[0] * cofactor(m, 0, 0) + m[4] * cofactor(m, 0, 1) + m[8] * cofactor(m, 0, 2);
}

void al_matrix_invert(const double m[16], double out[16])
{
    double inverse[16] = {0}, determinant = al_matrix_determinant(m);
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 3; column++)
            inverse[column * 4 + row] = cofactor(m, column, row) / determinant;
    inverse[15] = 1;
    double back[3];
    al_matrix_point(inverse, m + 12, back);
    for (int i = 0; i < 3; i++) inverse[12 + i] = -back[i];
    memcpy(out, inverse, sizeof inverse);
}

static double column_dot(const double m[16], int a, int b)
{
    return m[a * 4] * m[b * 4] + m[a * 4 + 1] * m[b * 4 + 1] + m[a * 4 + 2] * m[b * 4 + 2];
}

/* Gram-Schmidt on the columns. */
static void orthonormalise(const double m[16], double rotation[16])
{
    for (int column = 0; column < 3; column++) {
        double v[3] = {m[column * 4], m[column * 4 + 1], m[column * 4 + 2]}, length = 0;
        for (int earlier = 0; earlier < column; earlier++) {
            double along = 0;
            for (int i = 0; i < 3; i++) along += v[i] * rotation[earlier * 4 + i];
            for (int i = 0; i < 3; i++) v[i] -= along * rotation[earlier * 4 + i];
        }
        for (int i = 0; i < 3; i++) length += v[i] * v[i];
        for (int i = 0; i < 3; i++) rotation[column * 4 + i] = v[i] / sqrt(length);
    }
}

bool al_matrix_split(const double m[16], double rigid[16], double rest[16])
{
    const double tolerance = 1e-6; /* mesh files hold single precision */
    double even = cbrt(fabs(al_matrix_determinant(m))), square = even * even;
    bool similar = al_matrix_determinant(m) > 0;
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++)
            similar = similar && fabs(column_dot(m, a, b) - (a == b ? square : 0)) <= tolerance * square;
    for (int i = 0; i < 16; i++) rigid[i] = i % 5 == 0;
    if (similar) orthonormalise(m, rigid);
    for (int i = 0; i < 3; i++) rigid[12 + i] = m[12 + i];
    double back[16];
    al_matrix_invert(rigid, back);
    al_matrix_multiply(back, m, rest);
    for (int i = 0; i < 3; i++) rest[12 + i] = 0;
    return similar;
}

/* --- memory --- */

void *al_scene_array(al_scene *scene, size_t count, size_t size)
{
    return size && count > SIZE_MAX / size ? NULL : al_scene_allocate(scene, count * size);
}

void *al_scene_append(al_scene *scene, void *array, uint32_t *count, size_t size)
{
    void *elements;
    memcpy(&elements, array, sizeof elements);
    if ((*count & (*count - 1)) == 0) { /* 0, 1, 2, 4, ...: full */
        char *grown = al_scene_array(scene, (size_t)*count * 2 + 1, size);
        if (!grown) return NULL;
        if (*count) memcpy(grown, elements, *count * size);
        elements = grown;
        memcpy(array, &elements, sizeof elements);
    }
    return (char *)elements + (*count)++ * size;
}

static bool grow(float **array, uint32_t room, size_t width)
{
    float *grown = realloc(*array, room * width * sizeof **array);
    if (grown) *array = grown;
    return grown != NULL;
}

al_status al_corners_reserve(al_corners *corners, uint32_t more, al_error *error)
{
    if (more > UINT32_MAX / 4 - corners->count)
        return al_fail(error, AL_BAD_INPUT, "more than %u triangle corners in one mesh", UINT32_MAX / 4);
    uint32_t wanted = corners->count + more;
    if (wanted <= corners->room) return AL_OK;
    uint32_t room = corners->room * 2 > wanted ? corners->room * 2 : wanted;
    uint32_t *marks = realloc(corners->marks, room * sizeof *marks);
    if (marks) corners->marks = marks;
    if (!marks || !grow(&corners->positions, room, 3) || !grow(&corners->normals, room, 3) ||
        !grow(&corners->uv0, room, 2) || !grow(&corners->uv1, room, 2))
        return al_fail(error, AL_IO, "out of memory for %u triangle corners", room);
    memset(marks + corners->room, 0, (room - corners->room) * sizeof *marks);
    corners->room = room;
    return AL_OK;
}

void al_corners_free(al_corners *corners)
{
    free(corners->positions);
    free(corners->normals);
    free(corners->uv0);
    free(corners->uv1);
    free(corners->marks);
    *corners = (al_corners){0};
}

/* --- corners --- */

static void swap_corners(al_corners *corners, uint32_t a, uint32_t b)
{
    float *arrays[4] = {corners->positions, corners->normals, corners->uv0, corners->uv1};
    for (int k = 0; k < 4; k++)
        for (uint32_t i = 0, width = k < 2 ? 3 : 2; i < width; i++) {
            float kept = arrays[k][a * (size_t)width + i];
            arrays[k][a * (size_t)width + i] = arrays[k][b * (size_t)width + i];
            arrays[k][b * (size_t)width + i] = kept;
        }
}

/* Unit length, or (0,0,0) when there is no finite direction. */
static void set_unit(float out[3], const double v[3])
{
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    bool good = length > 0 && isfinite(length);
    for (int i = 0; i < 3; i++) out[i] = good ? (float)(v[i] / length) : 0;
}

/* Normals transform with the inverse transpose, which is the cofactor matrix over the determinant. */
static void transform_normal(const double m[16], double sign, float normal[3])
{
    double v[3];
    for (int i = 0; i < 3; i++)
        v[i] = sign * (cofactor(m, i, 0) * normal[0] + cofactor(m, i, 1) * normal[1] +
                       cofactor(m, i, 2) * normal[2]);
    set_unit(normal, v);
}

void al_corners_transform(al_corners *corners, uint32_t first, const double matrix[16])
{
    double sign = al_matrix_determinant(matrix) < 0 ? -1 : 1;
    for (uint32_t i = first; i < corners->count; i++) {
        float *p = corners->positions + i * (size_t)3;
        double moved[3] = {p[0], p[1], p[2]};
        al_matrix_point(matrix, moved, moved);
        for (int k = 0; k < 3; k++) p[k] = (float)moved[k];
        transform_normal(matrix, sign, corners->normals + i * (size_t)3);
    }
    for (uint32_t i = first; sign < 0 && i < corners->count; i += 3) swap_corners(corners, i + 1, i + 2);
}

/* --- normals: at each corner the mean of the faces around the point that lie within the crease angle of the
 * corner's own face, weighted by their angles there (Thuermer and Wuethrich 1998) --- */

typedef struct face_corner {
    double normal[3]; /* of the face, unit; zero for a face without area */
    double angle;
} face_corner;

static void measure_face(const float *p, face_corner out[3])
{
    double edge[3][3], normal[3], length = 0;
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++) edge[k][i] = (double)p[(k + 1) % 3 * 3 + i] - p[k * 3 + i];
    for (int i = 0; i < 3; i++) {
        normal[i] = edge[0][(i + 1) % 3] * edge[1][(i + 2) % 3] - edge[0][(i + 2) % 3] * edge[1][(i + 1) % 3];
        length += normal[i] * normal[i];
    }
    length = sqrt(length);
    for (int k = 0; k < 3; k++) {
        const double *ahead = edge[k], *behind = edge[(k + 2) % 3];
        double dot = -(ahead[0] * behind[0] + ahead[1] * behind[1] + ahead[2] * behind[2]);
        for (int i = 0; i < 3; i++) out[k].normal[i] = length > 0 ? normal[i] / length : 0;
        out[k].angle = length > 0 ? atan2(length, dot) : 0; /* |a x b| is twice the area at every corner */
    }
}

static void smooth_normal(const face_corner *faces, const uint32_t *around, uint32_t count,
                          const face_corner *own, float out[3])
{
    const double crease = 0.5; /* cos 60 degrees */
    double sum[3] = {0};
    for (uint32_t k = 0; k < count; k++) {
        const face_corner *face = &faces[around[k]];
        double cosine = 0;
        for (int i = 0; i < 3; i++) cosine += face->normal[i] * own->normal[i];
        for (int i = 0; i < 3 && cosine >= crease; i++) sum[i] += face->angle * face->normal[i];
    }
    set_unit(out, sum);
}

static bool is_zero(const float v[3])
{
    return !(v[0] != 0 || v[1] != 0 || v[2] != 0);
}

/* Triangles without area have no direction of their own: +y is as good as any. */
static void fill_normals(const al_corners *corners, const face_corner *faces, const uint32_t *starts,
                         const uint32_t *around, const uint32_t *points)
{
    for (uint32_t i = 0; i < corners->count; i++) {
        float *normal = corners->normals + i * (size_t)3;
        uint32_t point = points[i];
        if (is_zero(normal))
            smooth_normal(faces, around + starts[point], starts[point + 1] - starts[point], &faces[i],
                          normal);
        if (is_zero(normal)) normal[1] = 1;
    }
}

static al_status generate_normals(al_corners *corners, al_error *error)
{
    uint32_t count = corners->count, point_count;
    face_corner *faces = malloc(count * sizeof *faces);
    uint32_t *points = malloc(count * sizeof *points), *around = malloc(count * sizeof *around);
    uint32_t *starts = calloc(count + (size_t)2, sizeof *starts);
    al_status status = AL_OK;
    if (!faces || !points || !around || !starts) {
        status = al_fail(error, AL_IO, "out of memory for the normals of %u corners", count);
        goto cleanup;
    }
    status = al_weld(corners->positions, 3 * sizeof(float), count, points, &point_count, error);
    if (status) goto cleanup;
    for (uint32_t i = 0; i < count; i += 3) measure_face(corners->positions + i * (size_t)3, faces + i);
    for (uint32_t i = 0; i < count; i++) starts[points[i] + 2]++;
    for (uint32_t i = 2; i < point_count + 2; i++) starts[i] += starts[i - 1];
    for (uint32_t i = 0; i < count; i++) around[starts[points[i] + 1]++] = i;
    fill_normals(corners, faces, starts, around, points);
cleanup:
    free(faces);
    free(points);
    free(around);
    free(starts);
    return status;
}

/* --- into the scene --- */

enum { VERTEX_FLOATS = 11 }; /* the last is the mark's bits */

static void gather_vertex(const al_corners *corners, uint32_t i, float out[VERTEX_FLOATS])
{
    memcpy(out, corners->positions + i * (size_t)3, 3 * sizeof *out);
    memcpy(out + 3, corners->normals + i * (size_t)3, 3 * sizeof *out);
    memcpy(out + 6, corners->uv0 + i * (size_t)2, 2 * sizeof *out);
    memcpy(out + 8, corners->uv1 + i * (size_t)2, 2 * sizeof *out);
    memcpy(out + 10, corners->marks + i, sizeof *out);
}

/* Equal numbers get equal bytes; file values that are not finite get none of their own. */
static void tidy(al_corners *corners)
{
    for (size_t i = 0; i < corners->count * (size_t)3; i++) {
        corners->positions[i] += 0.0f;
        if (!isfinite(corners->normals[i])) corners->normals[i - i % 3] = NAN;
    }
    for (size_t i = 0; i < corners->count; i++) {
        float *normal = corners->normals + i * 3;
        set_unit(normal, (double[3]){normal[0], normal[1], normal[2]});
        for (int k = 0; k < 3; k++) normal[k] += 0.0f;
    }
    for (size_t i = 0; i < corners->count * (size_t)2; i++) {
        corners->uv0[i] = corners->has_uv0 && isfinite(corners->uv0[i]) ? corners->uv0[i] + 0.0f : 0;
        corners->uv1[i] = corners->has_uv1 && isfinite(corners->uv1[i]) ? corners->uv1[i] + 0.0f : 0;
    }
}

static al_status store_vertices(al_scene *scene, const al_corners *corners, const float *vertices,
                                al_mesh *mesh, al_error *error)
{
    uint32_t count = mesh->vertex_count;
    mesh->positions = al_scene_array(scene, count * (size_t)3, sizeof(float));
    mesh->normals = al_scene_array(scene, count * (size_t)3, sizeof(float));
    mesh->uv0 = corners->has_uv0 ? al_scene_array(scene, count * (size_t)2, sizeof(float)) : NULL;
    mesh->uv1 = corners->has_uv1 ? al_scene_array(scene, count * (size_t)2, sizeof(float)) : NULL;
    if (!mesh->positions || !mesh->normals || (corners->has_uv0 && !mesh->uv0) ||
        (corners->has_uv1 && !mesh->uv1))
        return al_fail(error, AL_IO, "out of memory for %u vertices", count);
    for (uint32_t i = 0; i < corners->count; i++) {
        const float *vertex = vertices + i * (size_t)VERTEX_FLOATS;
        uint32_t to = mesh->indices[i];
        memcpy(mesh->positions + to * (size_t)3, vertex, 3 * sizeof(float));
        memcpy(mesh->normals + to * (size_t)3, vertex + 3, 3 * sizeof(float));
        if (mesh->uv0) memcpy(mesh->uv0 + to * (size_t)2, vertex + 6, 2 * sizeof(float));
        if (mesh->uv1) memcpy(mesh->uv1 + to * (size_t)2, vertex + 8, 2 * sizeof(float));
    }
    return AL_OK;
}

al_status al_corners_to_mesh(al_scene *scene, al_corners *corners, const char *name, uint32_t *mesh_index,
                             al_error *error)
{
    tidy(corners);
    al_status status = generate_normals(corners, error);
    if (status) return status;
    al_mesh mesh = {.name = al_scene_text(scene, name), .index_count = corners->count};
    float *vertices = malloc(corners->count * sizeof(float[VERTEX_FLOATS]));
    mesh.indices = al_scene_array(scene, corners->count, sizeof *mesh.indices);
    if (!vertices || !mesh.name || !mesh.indices) {
        status = al_fail(error, AL_IO, "out of memory for %u vertices", corners->count);
        goto cleanup;
    }
    for (uint32_t i = 0; i < corners->count; i++)
        gather_vertex(corners, i, vertices + i * (size_t)VERTEX_FLOATS);
    status = al_weld(vertices, sizeof(float[VERTEX_FLOATS]), corners->count, mesh.indices, &mesh.vertex_count,
                     error);
    if (!status) status = store_vertices(scene, corners, vertices, &mesh, error);
    if (status) goto cleanup;
    *mesh_index = scene->mesh_count;
    al_mesh *place = al_scene_append(scene, &scene->meshes, &scene->mesh_count, sizeof *place);
    if (place)
        *place = mesh;
    else
        status = al_fail(error, AL_IO, "out of memory for mesh %u", scene->mesh_count);
cleanup:
    free(vertices);
    return status;
}
