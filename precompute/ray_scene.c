#include "ray_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <embree3/rtcore.h>

#include "geometry.h"
#include "surface_color.h"

/* A ray's crossing of a boundary. */
typedef struct al_crossing {
    double distance_m;
    uint32_t object;
    int sign;   /* +1 leaves the object, -1 enters it */
    float edge; /* least barycentric coordinate: 0 on the triangle's edge */
} crossing;

typedef struct surface {
    double *positions; /* [vertex_count][3] world */
    float *embree;     /* the same less the centre, padded by a float as Embree wants */
    uint32_t *indices; /* [triangle_count][3], counter-clockwise seen from outside */
    uint32_t vertex_count, triangle_count;
    uint32_t object; /* AL_NO_INDEX for opaque ones */
    /* of opaque ones */
    uint32_t instance;
    double rotation[9]; /* of normals, row-major; the vertices' normals are made unit after it */
    bool mirrored;      /* the transform turns triangles round */
    const al_mesh *mesh;
    uint32_t *materials; /* [triangle_count] */
} surface;

struct al_ray_scene {
    RTCDevice device;
    RTCScene boundaries, opaques;
    surface *surfaces; /* [surface_count]; Embree's geometry number is the place in here, in both scenes */
    uint32_t surface_count, object_count;
    const al_scene *from;
    uint32_t *instance_surfaces; /* [from->instance_count], AL_NO_INDEX for what is not in `opaques` */
    al_surface_colors colors;
    double low[3], high[3], centre[3], radius_m;
};

/* --- building --- */

static al_status out_of_memory(al_error *error)
{
    return al_fail(error, AL_IO, "out of memory for the rays' scene");
}

static al_status allocate_surface(uint32_t vertices, uint32_t triangles, surface *out, al_error *error)
{
    out->vertex_count = vertices;
    out->triangle_count = triangles;
    out->positions = malloc(sizeof(double) * 3 * (vertices + (size_t)1));
    out->embree = malloc(sizeof(float) * (3 * (size_t)vertices + 1));
    out->indices = malloc(sizeof(uint32_t) * 3 * (triangles + (size_t)1));
    return out->positions && out->embree && out->indices ? AL_OK : out_of_memory(error);
}

static void to_double(const float in[16], double out[16])
{
    for (int i = 0; i < 16; i++) out[i] = in[i];
}

/* The welded boundary of a translucent object in the world; a mirroring transform turns its triangles round.
 */
static al_status add_boundary(const al_import *import, uint32_t object, surface *out, al_error *error)
{
    al_triangles triangles = {0};
    double world[16];
    to_double(import->scene.instances[import->scene.translucents[object].instance].world, world);
    al_status status = al_import_boundary(import, object, &triangles, error);
    if (!status) status = allocate_surface(triangles.vertex_count, triangles.triangle_count, out, error);
    if (status) goto cleanup;
    for (size_t i = 0; i < triangles.vertex_count; i++)
        al_matrix_point(world, triangles.positions + 3 * i, out->positions + 3 * i);
    memcpy(out->indices, triangles.indices, sizeof(uint32_t) * 3 * triangles.triangle_count);
    if (al_matrix_determinant(world) < 0)
        for (size_t i = 0; i < triangles.triangle_count; i++) {
            uint32_t swapped = out->indices[3 * i];
            out->indices[3 * i] = out->indices[3 * i + 1];
            out->indices[3 * i + 1] = swapped;
        }
    out->object = object;

cleanup:
    al_triangles_free(&triangles);
    return status;
}

static void fill_materials(const al_mesh *mesh, uint32_t *materials)
{
    for (uint32_t i = 0; i < mesh->submesh_count; i++) {
        const al_submesh *part = &mesh->submeshes[i];
        for (uint32_t t = 0; t < part->index_count / 3; t++)
            materials[part->first_index / 3 + t] = part->material;
    }
}

/* Of the upper 3x3 part; cyclic indices carry the sign. */
static double cofactor(const double m[16], int row, int column)
{
    int r1 = (row + 1) % 3, r2 = (row + 2) % 3, c1 = 4 * ((column + 1) % 3), c2 = 4 * ((column + 2) % 3);
    return m[c1 + r1] * m[c2 + r2] - m[c2 + r1] * m[c1 + r2];
}

static al_status add_opaque(const al_import *import, uint32_t index, surface *out, al_error *error)
{
    const al_instance *instance = &import->scene.instances[index];
    const al_mesh *mesh = &import->scene.meshes[instance->mesh];
    double world[16];
    to_double(instance->world, world);
    al_status status = allocate_surface(mesh->vertex_count, mesh->index_count / 3, out, error);
    if (status) return status;
    out->materials = calloc(out->triangle_count + (size_t)1, sizeof *out->materials);
    if (!out->materials) return out_of_memory(error);
    fill_materials(mesh, out->materials);
    out->mesh = mesh;
    out->instance = index;
    out->mirrored = al_matrix_determinant(world) < 0;
    /* Instances that stand still are only turned, moved and scaled evenly: their normals turn like vectors. Others
     * may be squeezed by their motion: theirs turn with the cofactors. */
    bool even = !al_motion_moves(&import->scene.motion, index);
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 3; column++)
            out->rotation[3 * row + column] = even            ? world[4 * column + row]
                                              : out->mirrored ? -cofactor(world, row, column)
                                                              : cofactor(world, row, column);
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        double position[3] = {mesh->positions[3 * i], mesh->positions[3 * i + 1], mesh->positions[3 * i + 2]};
        al_matrix_point(world, position, out->positions + 3 * i);
    }
    memcpy(out->indices, mesh->indices, sizeof(uint32_t) * 3 * out->triangle_count);
    out->object = AL_NO_INDEX;
    return AL_OK;
}

/* What moves is in no bake of other things' light. */
static bool is_wanted(const al_scene *scene, uint32_t index, al_ray_scene_content content)
{
    const al_instance *instance = &scene->instances[index];
    if (instance->role == AL_ROLE_TRANSLUCENT) return false;
    return content == AL_RAY_SCENE_ALL ||
           (instance->lighting != AL_LIGHTING_PROBES && !al_motion_moves(&scene->motion, index));
}

static al_status add_surfaces(al_ray_scene *scene, const al_import *import, al_ray_scene_content content,
                              al_error *error)
{
    const al_scene *from = scene->from = &import->scene;
    al_status status = AL_OK;
    scene->instance_surfaces = malloc(sizeof(uint32_t) * (from->instance_count + (size_t)1));
    scene->object_count = from->translucent_count;
    scene->surfaces = calloc((size_t)from->translucent_count + from->instance_count + 1, sizeof(surface));
    if (!scene->surfaces || !scene->instance_surfaces) return out_of_memory(error);
    for (uint32_t i = 0; i < from->translucent_count && !status; i++)
        status = add_boundary(import, i, &scene->surfaces[scene->surface_count++], error);
    for (uint32_t i = 0; i < from->instance_count && !status; i++) {
        scene->instance_surfaces[i] = AL_NO_INDEX;
        if (!is_wanted(from, i, content)) continue;
        scene->instance_surfaces[i] = scene->surface_count;
        status = add_opaque(import, i, &scene->surfaces[scene->surface_count++], error);
    }
    return status;
}

static void measure(al_ray_scene *scene)
{
    for (int k = 0; k < 3; k++) scene->low[k] = INFINITY, scene->high[k] = -INFINITY;
    for (uint32_t s = 0; s < scene->surface_count; s++)
        for (size_t i = 0; i < 3 * (size_t)scene->surfaces[s].vertex_count; i++) {
            scene->low[i % 3] = fmin(scene->low[i % 3], scene->surfaces[s].positions[i]);
            scene->high[i % 3] = fmax(scene->high[i % 3], scene->surfaces[s].positions[i]);
        }
    double square = 0;
    for (int k = 0; k < 3; k++) {
        if (scene->low[k] > scene->high[k]) scene->low[k] = scene->high[k] = 0;
        scene->centre[k] = 0.5 * (scene->low[k] + scene->high[k]);
        square += 0.25 * (scene->high[k] - scene->low[k]) * (scene->high[k] - scene->low[k]);
    }
    scene->radius_m = sqrt(square);
}

static void attach(al_ray_scene *scene, uint32_t index)
{
    surface *s = &scene->surfaces[index];
    for (size_t i = 0; i < 3 * (size_t)s->vertex_count; i++)
        s->embree[i] = (float)(s->positions[i] - scene->centre[i % 3]);
    s->embree[3 * (size_t)s->vertex_count] = 0;
    if (!s->triangle_count) return;
    RTCGeometry geometry = rtcNewGeometry(scene->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, s->embree, 0,
                               3 * sizeof(float), s->vertex_count);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, s->indices, 0,
                               3 * sizeof(uint32_t), s->triangle_count);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(s->object == AL_NO_INDEX ? scene->opaques : scene->boundaries, geometry, index);
    rtcReleaseGeometry(geometry);
}

static al_status build(al_ray_scene *scene, al_error *error)
{
    scene->device = rtcNewDevice(NULL);
    if (!scene->device)
        return al_fail(error, AL_IO, "Embree cannot start: error %d", (int)rtcGetDeviceError(NULL));
    scene->boundaries = rtcNewScene(scene->device);
    scene->opaques = rtcNewScene(scene->device);
    rtcSetSceneFlags(scene->boundaries, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
    rtcSetSceneFlags(scene->opaques, RTC_SCENE_FLAG_ROBUST);
    for (uint32_t i = 0; i < scene->surface_count; i++) attach(scene, i);
    rtcCommitScene(scene->boundaries);
    rtcCommitScene(scene->opaques);
    enum RTCError code = rtcGetDeviceError(scene->device);
    if (code == RTC_ERROR_OUT_OF_MEMORY) return out_of_memory(error);
    if (code != RTC_ERROR_NONE)
        return al_fail(error, AL_IO, "Embree cannot build the scene: error %d", (int)code);
    return AL_OK;
}

al_status al_ray_scene_create(const al_import *import, al_ray_scene_content content, al_ray_scene **scene,
                              al_error *error)
{
    *scene = NULL;
    al_ray_scene *made = calloc(1, sizeof *made);
    if (!made) return out_of_memory(error);
    made->colors = al_surface_colors_of(&import->scene);
    al_status status = add_surfaces(made, import, content, error);
    measure(made);
    if (!status) status = build(made, error);
    if (status)
        al_ray_scene_free(made);
    else
        *scene = made;
    return status;
}

void al_ray_scene_free(al_ray_scene *scene)
{
    if (!scene) return;
    if (scene->boundaries) rtcReleaseScene(scene->boundaries);
    if (scene->opaques) rtcReleaseScene(scene->opaques);
    if (scene->device) rtcReleaseDevice(scene->device);
    for (uint32_t i = 0; i < scene->surface_count; i++) {
        free(scene->surfaces[i].positions);
        free(scene->surfaces[i].embree);
        free(scene->surfaces[i].indices);
        free(scene->surfaces[i].materials);
    }
    free(scene->instance_surfaces);
    free(scene->surfaces);
    free(scene);
}

void al_line_free(al_line *line)
{
    free(line->crossings);
    free(line->segments);
    free(line->depths);
    free(line->ends);
    *line = (al_line){0};
}

/* --- rays --- */

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The ray in Embree's units, begun where it enters the scene's box, or up to `back_m` before its origin: far
 * origins would lose digits. `shift_m` is that distance. False when the ray misses the box. */
static bool embree_ray(const al_ray_scene *scene, const al_ray *ray, double back_m, double *shift_m,
                       struct RTCRay *out)
{
    double enter = -INFINITY, leave = INFINITY, slack = 1e-6 * scene->radius_m;
    for (int k = 0; k < 3; k++) {
        double low = scene->low[k] - slack - ray->origin[k], high = scene->high[k] + slack - ray->origin[k];
        if (ray->direction[k] == 0) {
            if (low > 0 || high < 0) return false;
            continue;
        }
        double a = low / ray->direction[k], b = high / ray->direction[k];
        enter = fmax(enter, fmin(a, b));
        leave = fmin(leave, fmax(a, b));
    }
    if (enter > leave || leave < 0) return false;
    double shift = *shift_m = fmax(enter, -back_m);
    *out = (struct RTCRay){.tnear = 0, .tfar = INFINITY, .mask = ~0u};
    out->org_x = (float)(ray->origin[0] + shift * ray->direction[0] - scene->centre[0]);
    out->org_y = (float)(ray->origin[1] + shift * ray->direction[1] - scene->centre[1]);
    out->org_z = (float)(ray->origin[2] + shift * ray->direction[2] - scene->centre[2]);
    out->dir_x = (float)ray->direction[0];
    out->dir_y = (float)ray->direction[1];
    out->dir_z = (float)ray->direction[2];
    return true;
}

/* Distance to the triangle's plane, n.(v - o) / n.d, and the sign of n.d. Where the ray runs along the plane,
 * and where the plane is met far from where Embree met the triangle, Embree's distance stands. */
static double plane_distance(const al_ray_scene *scene, const surface *s, uint32_t triangle,
                             const al_ray *ray, double embree_m, int *sign)
{
    const uint32_t *index = s->indices + 3 * (size_t)triangle;
    const double *v[3] = {s->positions + 3 * (size_t)index[0], s->positions + 3 * (size_t)index[1],
                          s->positions + 3 * (size_t)index[2]};
    double a[3], b[3], to[3];
    for (int k = 0; k < 3; k++) {
        a[k] = v[1][k] - v[0][k];
        b[k] = v[2][k] - v[0][k];
        to[k] = v[0][k] - ray->origin[k];
    }
    double normal[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    double slope = dot(normal, ray->direction), distance = dot(normal, to) / slope;
    *sign = slope > 0 ? 1 : -1;
    return fabs(distance - embree_m) <= 1e-4 * scene->radius_m ? distance : embree_m;
}

typedef struct gathering {
    struct RTCIntersectContext base; /* first: Embree hands this to the filter */
    const al_ray_scene *scene;
    const al_ray *ray;
    double shift_m;
    al_line *line;
} gathering;

/* Doubles an array. */
static bool make_room(void *array, uint32_t count, uint32_t *room, size_t size)
{
    if (count < *room) return true;
    uint32_t wanted = *room ? 2 * *room : 64;
    void *grown = wanted > *room ? realloc(*(void **)array, wanted * size) : NULL;
    if (!grown) return false;
    *(void **)array = grown;
    *room = wanted;
    return true;
}

/* Keeps every hit and refuses it, so that Embree goes on to the next. */
static void on_hit(const struct RTCFilterFunctionNArguments *arguments)
{
    gathering *g = (gathering *)arguments->context;
    const struct RTCHit *hit = (const struct RTCHit *)arguments->hit;
    const struct RTCRay *ray = (const struct RTCRay *)arguments->ray;
    al_line *line = g->line;
    arguments->valid[0] = 0;
    if (!make_room(&line->crossings, line->crossing_count, &line->crossing_room, sizeof(crossing))) {
        line->failed = true;
        return;
    }
    const surface *s = &g->scene->surfaces[hit->geomID];
    crossing made = {.object = s->object, .edge = fminf(fminf(hit->u, hit->v), 1 - hit->u - hit->v)};
    made.distance_m = plane_distance(g->scene, s, hit->primID, g->ray, ray->tfar + g->shift_m, &made.sign);
    if (made.distance_m > 0) line->crossings[line->crossing_count++] = made;
}

static int compare_crossings(const void *a, const void *b)
{
    const crossing *x = a, *y = b;
    if (x->distance_m != y->distance_m) return x->distance_m < y->distance_m ? -1 : 1;
    if (x->object != y->object) return x->object < y->object ? -1 : 1;
    return x->sign - y->sign;
}

/* A ray through a shared edge or corner meets each of its triangles: one crossing, not several. */
static void drop_twins(const al_ray_scene *scene, al_line *line)
{
    const double near_m = 1e-6 * scene->radius_m;
    const float near_edge = 1e-4f;
    uint32_t kept = 0;
    for (uint32_t i = 0; i < line->crossing_count; i++) {
        const crossing *c = &line->crossings[i];
        bool twin = false;
        for (uint32_t k = kept; k > 0 && !twin; k--) {
            const crossing *before = &line->crossings[k - 1];
            if (c->distance_m - before->distance_m > near_m) break;
            twin = before->object == c->object && before->sign == c->sign && before->edge < near_edge &&
                   c->edge < near_edge;
        }
        if (!twin) line->crossings[kept++] = *c;
    }
    line->crossing_count = kept;
}

static bool push_segment(al_line *line, double begin_m, double end_m, uint32_t object)
{
    if (!(begin_m < end_m)) return true;
    if (!make_room(&line->segments, line->segment_count, &line->segment_room, sizeof(al_segment)))
        return false;
    line->segments[line->segment_count++] = (al_segment){begin_m, end_m, object};
    return true;
}

/* Far away every ray is outside: from there back, leaving crossings count up, entering ones down, and the ray
 * is inside an object where its count is positive. */
static bool walk_back(const al_ray_scene *scene, double end_m, al_line *line)
{
    memset(line->depths, 0, sizeof(int32_t) * scene->object_count);
    for (uint32_t i = line->crossing_count; i-- > 0;) {
        const crossing *c = &line->crossings[i];
        int before = line->depths[c->object], after = line->depths[c->object] = before + c->sign;
        if (before <= 0 && after > 0) line->ends[c->object] = c->distance_m;
        if (before > 0 && after <= 0 &&
            !push_segment(line, c->distance_m, fmin(line->ends[c->object], end_m), c->object))
            return false;
    }
    for (uint32_t object = 0; object < scene->object_count; object++)
        if (line->depths[object] > 0 && !push_segment(line, 0, fmin(line->ends[object], end_m), object))
            return false;
    return true;
}

bool al_ray_scene_segments(const al_ray_scene *scene, const al_ray *ray, double end_m, al_line *line)
{
    line->crossing_count = line->segment_count = 0;
    line->failed = false;
    if (!line->depths) line->depths = malloc(sizeof(int32_t) * (scene->object_count + (size_t)1));
    if (!line->ends) line->ends = malloc(sizeof(double) * (scene->object_count + (size_t)1));
    if (!line->depths || !line->ends) return false;
    struct RTCRayHit query = {
        .hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .instID = {RTC_INVALID_GEOMETRY_ID}}};
    gathering g = {.scene = scene, .ray = ray, .line = line};
    /* Begun a little before the origin, so that rounding loses no crossing just in front of it. */
    if (!embree_ray(scene, ray, 1e-4 * scene->radius_m, &g.shift_m, &query.ray)) return true;
    rtcInitIntersectContext(&g.base);
    g.base.filter = on_hit;
    rtcIntersect1(scene->boundaries, &g.base, &query);
    if (line->failed) return false;
    if (!line->crossing_count) return true;
    qsort(line->crossings, line->crossing_count, sizeof(crossing), compare_crossings);
    drop_twins(scene, line);
    return walk_back(scene, end_m, line);
}

double al_ray_scene_opaque_m(const al_ray_scene *scene, const al_ray *ray)
{
    struct RTCRayHit query = {
        .hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .instID = {RTC_INVALID_GEOMETRY_ID}}};
    struct RTCIntersectContext context;
    double shift_m;
    int sign;
    if (!embree_ray(scene, ray, 0, &shift_m, &query.ray)) return INFINITY;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene->opaques, &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return INFINITY;
    return fmax(0, plane_distance(scene, &scene->surfaces[query.hit.geomID], query.hit.primID, ray,
                                  query.ray.tfar + shift_m, &sign));
}

bool al_ray_scene_is_blocked(const al_ray_scene *scene, const al_ray *ray, double end_m)
{
    struct RTCRay query;
    struct RTCIntersectContext context;
    double shift_m;
    if (!embree_ray(scene, ray, 0, &shift_m, &query) || shift_m >= end_m) return false;
    query.tfar = (float)(end_m - shift_m);
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene->opaques, &context, &query);
    return query.tfar < 0;
}

/* --- points of opaque surfaces --- */

/* Offset of rays from the surface: Embree sees vertices and origins rounded to float about the centre. A
 * triangle moves by at most sqrt(3) 2^-24 m, m the largest coordinate of its vertices (its points are convex
 * combinations of them), the origin of a ray on it by as much; the signed distance of an origin to a plane,
 * computed from differences of up to 2 m, is off by a few times 2^-24 of those. 32 * 2^-24 m is above the
 * sum. */
static const double offset_scale = 32 * 0x1p-24;

static double normalize(double v[3])
{
    double length = sqrt(dot(v, v));
    for (int k = 0; k < 3 && length > 0; k++) v[k] /= length;
    return length;
}

/* Everything but the distance and what is seen of it from the ray. Weights w of the three vertices. */
static void fill_point(const al_ray_scene *scene, const surface *s, uint32_t triangle, const double w[3],
                       al_surface_hit *hit)
{
    const uint32_t *index = s->indices + 3 * (size_t)triangle;
    const al_mesh *mesh = s->mesh;
    double a[3], b[3], largest = 0, vertex_normal[3] = {0}, side = s->mirrored ? -1 : 1;
    const double *v[3];
    for (int i = 0; i < 3; i++) v[i] = s->positions + 3 * (size_t)index[i];
    hit->uv0[0] = hit->uv0[1] = 0;
    for (int k = 0; k < 3; k++) {
        a[k] = v[1][k] - v[0][k];
        b[k] = v[2][k] - v[0][k];
        hit->position[k] = v[0][k] + w[1] * a[k] + w[2] * b[k];
        for (int i = 0; i < 3; i++) {
            largest = fmax(largest, fabs(v[i][k] - scene->centre[k]));
            vertex_normal[k] += w[i] * mesh->normals[3 * (size_t)index[i] + k];
            if (mesh->uv0 && k < 2) hit->uv0[k] += w[i] * mesh->uv0[2 * (size_t)index[i] + k];
        }
    }
    hit->offset_m = offset_scale * largest;
    hit->normal[0] = side * (a[1] * b[2] - a[2] * b[1]);
    hit->normal[1] = side * (a[2] * b[0] - a[0] * b[2]);
    hit->normal[2] = side * (a[0] * b[1] - a[1] * b[0]);
    normalize(hit->normal);
    for (int k = 0; k < 3; k++) hit->shading_normal[k] = dot(s->rotation + 3 * k, vertex_normal);
    bool smooth = normalize(hit->shading_normal) > 0;
    double turn = dot(hit->shading_normal, hit->normal) < 0 ? -1 : 1;
    for (int k = 0; k < 3; k++)
        hit->shading_normal[k] = smooth ? turn * hit->shading_normal[k] : hit->normal[k];
    hit->instance = s->instance;
    hit->triangle = triangle;
    hit->material = &scene->from->materials[s->materials[triangle]];
    al_surface_albedo(&scene->colors, hit->material, hit->uv0, hit->albedo);
    al_surface_emission(&scene->colors, hit->material, hit->uv0, hit->emission_w_m2_sr);
    if (scene->from->instances[s->instance].role == AL_ROLE_BLOCKER)
        for (int c = 0; c < 3; c++) hit->albedo[c] = hit->emission_w_m2_sr[c] = 0;
}

bool al_ray_scene_hit(const al_ray_scene *scene, const al_ray *ray, double end_m, al_surface_hit *hit)
{
    struct RTCRayHit query = {
        .hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .instID = {RTC_INVALID_GEOMETRY_ID}}};
    struct RTCIntersectContext context;
    double shift_m;
    int sign;
    if (!embree_ray(scene, ray, 0, &shift_m, &query.ray) || shift_m >= end_m) return false;
    query.ray.tfar = (float)(end_m - shift_m);
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene->opaques, &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    const surface *s = &scene->surfaces[query.hit.geomID];
    double u = query.hit.u, v = query.hit.v;
    hit->distance_m =
        fmax(0, plane_distance(scene, s, query.hit.primID, ray, query.ray.tfar + shift_m, &sign));
    fill_point(scene, s, query.hit.primID, (double[]){1 - u - v, u, v}, hit);
    hit->front = dot(hit->normal, ray->direction) < 0;
    if (!hit->front && !hit->material->double_sided)
        for (int c = 0; c < 3; c++) hit->emission_w_m2_sr[c] = 0;
    return true;
}

uint32_t al_ray_scene_triangle_count(const al_ray_scene *scene, uint32_t instance)
{
    uint32_t index = scene->instance_surfaces[instance];
    return index == AL_NO_INDEX ? 0 : scene->surfaces[index].triangle_count;
}

void al_ray_scene_point(const al_ray_scene *scene, uint32_t instance, uint32_t triangle, double u, double v,
                        al_surface_hit *point)
{
    const surface *s = &scene->surfaces[scene->instance_surfaces[instance]];
    fill_point(scene, s, triangle, (double[]){1 - u - v, u, v}, point);
    point->distance_m = 0;
    point->front = true;
}

void al_surface_offset(const al_surface_hit *hit, const double direction[3], double origin[3])
{
    double step = dot(hit->normal, direction) < 0 ? -hit->offset_m : hit->offset_m;
    for (int k = 0; k < 3; k++) origin[k] = hit->position[k] + step * hit->normal[k];
}

double al_ray_scene_offset_m(const al_ray_scene *scene)
{
    return offset_scale * scene->radius_m;
}

void al_ray_scene_bounds(const al_ray_scene *scene, double low[3], double high[3])
{
    memcpy(low, scene->low, sizeof scene->low);
    memcpy(high, scene->high, sizeof scene->high);
}
