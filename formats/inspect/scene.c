/* Statistics and pictures of scenes. */
#include "airlight/scene.h"

#include <math.h>

#include "canvas.h"
#include "inspect.h"

static void transform(const float m[16], const float point[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] =
            (double)m[i] * point[0] + (double)m[4 + i] * point[1] + (double)m[8 + i] * point[2] + m[12 + i];
}

static void grow(double low[3], double high[3], const double point[3])
{
    for (int i = 0; i < 3; i++) {
        low[i] = fmin(low[i], point[i]);
        high[i] = fmax(high[i], point[i]);
    }
}

/* The box of all instances in the world, empty (low above high) without any. */
static void scene_bounds(const al_scene *scene, double low[3], double high[3])
{
    double point[3];
    for (int i = 0; i < 3; i++) {
        low[i] = INFINITY;
        high[i] = -INFINITY;
    }
    for (uint32_t i = 0; i < scene->instance_count; i++) {
        const al_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        for (uint32_t v = 0; v < mesh->vertex_count; v++) {
            transform(scene->instances[i].world, mesh->positions + 3 * (size_t)v, point);
            grow(low, high, point);
        }
    }
}

/* --- statistics --- */

static json_t *box_corner(const double corner[3])
{
    return json_pack("[o,o,o]", json_number(corner[0]), json_number(corner[1]), json_number(corner[2]));
}

static json_t *translucent_list(const al_scene *scene)
{
    json_t *list = json_array();
    for (uint32_t i = 0; i < scene->translucent_count; i++) {
        const al_translucent_object *t = &scene->translucents[i];
        json_array_append_new(list, json_pack("{s:o,s:o,s:o}", "name", json_text(t->name), "asset",
                                              json_text(t->asset), "medium",
                                              json_text(scene->media[t->medium].name)));
    }
    return list;
}

static json_t *fog_list(const al_scene *scene)
{
    json_t *list = json_array();
    for (uint32_t i = 0; i < scene->fog_count; i++) {
        const al_fog *f = &scene->fogs[i];
        json_array_append_new(
            list, json_pack("{s:o,s:o,s:o,s:o,s:o}", "medium", json_text(scene->media[f->medium].name),
                            "asset", json_text(f->asset), "density", json_number(f->density), "bounds_min_m",
                            f->bounded ? json_numbers(f->bounds_min_m, 3) : json_null(), "bounds_max_m",
                            f->bounded ? json_numbers(f->bounds_max_m, 3) : json_null()));
    }
    return list;
}

/* How many opaque instances are lit in each way. */
static json_t *lighting_counts(const al_scene *scene)
{
    int counts[3] = {0};
    for (uint32_t i = 0; i < scene->instance_count; i++)
        if (scene->instances[i].role == AL_ROLE_OPAQUE && scene->instances[i].lighting < 3)
            counts[scene->instances[i].lighting]++;
    return json_pack("{s:i,s:i,s:i}", "dynamic", counts[AL_LIGHTING_DYNAMIC], "lightmap",
                     counts[AL_LIGHTING_LIGHTMAP], "probes", counts[AL_LIGHTING_PROBES]);
}

static json_t *motion_counts(const al_scene *scene)
{
    const al_motion *m = &scene->motion;
    int bound[4] = {0};
    for (uint32_t i = 0; i < m->binding_count; i++) bound[m->bindings[i].kind]++;
    return json_pack("{s:o,s:i,s:i,s:i,s:i,s:i,s:i,s:i}", "duration_s", json_number(al_motion_length_s(m)), "nodes",
                     (int)m->node_count, "channels", (int)m->channel_count, "instances", bound[AL_MOTION_INSTANCE],
                     "lights", bound[AL_MOTION_LIGHT], "cameras", bound[AL_MOTION_CAMERA], "fogs", bound[AL_MOTION_FOG], "deformed",
                     (int)m->deform_count);
}

static json_t *camera_list(const al_scene *scene)
{
    json_t *list = json_array();
    for (uint32_t i = 0; i < scene->camera_count; i++)
        json_array_append_new(list, json_text(scene->cameras[i].name));
    return list;
}

static al_status summary(const al_file *file, json_t **out, al_error *error)
{
    al_scene scene;
    uint64_t vertices = 0, triangles = 0, texels = 0;
    double low[3], high[3];
    al_status status = al_scene_read(file, &scene, error);
    if (status != AL_OK) return status;
    for (uint32_t i = 0; i < scene.mesh_count; i++) {
        vertices += scene.meshes[i].vertex_count;
        triangles += scene.meshes[i].index_count / 3;
    }
    for (uint32_t i = 0; i < scene.texture_count; i++)
        texels += (uint64_t)scene.textures[i].width * scene.textures[i].height;
    scene_bounds(&scene, low, high);
    json_t *o = json_object();
    json_object_set_new(o, "meshes", json_integer(scene.mesh_count));
    json_object_set_new(o, "instances", json_integer(scene.instance_count));
    json_object_set_new(o, "vertices", json_integer((json_int_t)vertices));
    json_object_set_new(o, "triangles", json_integer((json_int_t)triangles));
    json_object_set_new(o, "materials", json_integer(scene.material_count));
    json_object_set_new(o, "textures", json_integer(scene.texture_count));
    json_object_set_new(o, "texels", json_integer((json_int_t)texels));
    json_object_set_new(o, "media", json_integer(scene.medium_count));
    json_object_set_new(o, "lights", json_integer(scene.light_count));
    json_object_set_new(o, "environment",
                        json_pack("[i,i]", (int)scene.environment.width, (int)scene.environment.height));
    json_object_set_new(o, "bounds_min_m", box_corner(low));
    json_object_set_new(o, "bounds_max_m", box_corner(high));
    json_object_set_new(o, "exposure_ev", json_number(scene.play.exposure_ev));
    json_object_set_new(o, "translucents", translucent_list(&scene));
    json_object_set_new(o, "fogs", fog_list(&scene));
    json_object_set_new(o, "lighting", lighting_counts(&scene));
    json_object_set_new(o, "baked",
                        json_pack("{s:o,s:o}", "lightmap", json_text(scene.baked.lightmap), "probes",
                                  json_text(scene.baked.probes)));
    json_object_set_new(o, "cameras", camera_list(&scene));
    json_object_set_new(o, "motion", motion_counts(&scene));
    json_object_set_new(o, "provenance", json_provenance(file));
    *out = o;
    al_scene_free(&scene);
    return AL_OK;
}

/* --- picture: wireframes from the right, from above, from the front, and what the first camera sees --- */

enum { EDGE = 480 };

typedef struct eye { /* rows of a matrix that takes the world to right, up, towards the eye */
    double right[3], up[3], towards[3], position[3];
    double slope; /* of the picture's edge, 0: parallel projection */
} eye;

static double dot3(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross3(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++) out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static void normalise(double v[3])
{
    double length = sqrt(dot3(v, v));
    for (int i = 0; i < 3; i++) v[i] = length > 0 ? v[i] / length : 0;
}

static eye camera_eye(const al_camera *camera)
{
    eye e = {.slope = tan(0.5 * camera->fov_y_radians)};
    double up[3];
    for (int i = 0; i < 3; i++) {
        e.position[i] = camera->position[i];
        e.towards[i] = (double)camera->position[i] - camera->target[i];
        up[i] = camera->up[i];
    }
    normalise(e.towards);
    cross3(up, e.towards, e.right);
    normalise(e.right);
    cross3(e.towards, e.right, e.up);
    return e;
}

/* Draws the part of an edge that lies before the eye. */
static void draw_edge(const panel *p, const eye *e, const double from[3], const double to[3],
                      const float rgb[3])
{
    double ends[2][3], flat[2][2];
    const double *points[2] = {from, to};
    for (int i = 0; i < 2; i++) {
        double d[3] = {points[i][0] - e->position[0], points[i][1] - e->position[1],
                       points[i][2] - e->position[2]};
        ends[i][0] = dot3(d, e->right);
        ends[i][1] = dot3(d, e->up);
        ends[i][2] = -dot3(d, e->towards);
    }
    for (int i = 0; i < 2; i++) {
        const double nearest = 1e-6 * (fabs(ends[0][2]) + fabs(ends[1][2]));
        double scale = 1, point[2] = {ends[i][0], ends[i][1]};
        if (e->slope > 0) {
            const double *a = ends[i], *b = ends[1 - i];
            double depth = a[2];
            if (depth <= nearest) { /* behind the eye: cut where the edge comes before it */
                if (b[2] <= nearest) return;
                double t = (nearest - a[2]) / (b[2] - a[2]);
                point[0] += t * (b[0] - a[0]);
                point[1] += t * (b[1] - a[1]);
                depth = nearest;
            }
            scale = 1 / (depth * e->slope);
        }
        flat[i][0] = scale * point[0];
        flat[i][1] = scale * point[1];
    }
    panel_line(p, flat[0], flat[1], rgb);
}

static void draw_instances(const al_scene *scene, const panel *p, const eye *e)
{
    static const float colors[][3] = {{0.12f, 0.12f, 0.12f}, {0.02f, 0.1f, 0.14f}, {0.25f, 0.04f, 0.02f}};
    for (uint32_t i = 0; i < scene->instance_count; i++) {
        const al_instance *instance = &scene->instances[i];
        const al_mesh *mesh = &scene->meshes[instance->mesh];
        for (uint32_t t = 0; t + 2 < mesh->index_count; t += 3) {
            double corner[3][3];
            for (int k = 0; k < 3; k++)
                transform(instance->world, mesh->positions + 3 * (size_t)mesh->indices[t + k], corner[k]);
            for (int k = 0; k < 3; k++)
                draw_edge(p, e, corner[k], corner[(k + 1) % 3], colors[instance->role]);
        }
    }
}

/* Lights are yellow: a point's cross, the way a directional one travels through the middle. Cameras are
 * green: their place and a line towards the target. */
static void draw_marks(const al_scene *scene, const panel *p, const eye *e, const double middle[3],
                       double size)
{
    static const float yellow[3] = {0.9f, 0.7f, 0.1f}, green[3] = {0.1f, 0.8f, 0.2f};
    for (uint32_t i = 0; i < scene->light_count; i++) {
        const al_light *light = &scene->lights[i];
        for (int k = 0; k < 3; k++) {
            double from[3], to[3];
            for (int c = 0; c < 3; c++) {
                bool parallel = light->type == AL_LIGHT_DIRECTIONAL;
                double reach = c == k ? 0.02 * size : 0;
                from[c] = parallel ? middle[c] - 0.4 * size * light->vector[c] : light->vector[c] - reach;
                to[c] = parallel ? middle[c] : light->vector[c] + reach;
            }
            draw_edge(p, e, from, to, yellow);
        }
    }
    for (uint32_t i = 0; i < scene->camera_count && e->slope == 0; i++) {
        double from[3], to[3];
        for (int c = 0; c < 3; c++) {
            from[c] = scene->cameras[i].position[c];
            to[c] = from[c] + 0.25 * ((double)scene->cameras[i].target[c] - from[c]);
        }
        draw_edge(p, e, from, to, green);
    }
}

static al_status draw(const al_file *file, const char *png_path, al_error *error)
{
    static const eye sides[3] = {{{0, 0, -1}, {0, 1, 0}, {1, 0, 0}, {0}, 0},
                                 {{1, 0, 0}, {0, 0, -1}, {0, 1, 0}, {0}, 0},
                                 {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0}, 0}};
    al_scene scene;
    canvas on = {0};
    double low[3], high[3], middle[3], size = 0;
    al_status status = al_scene_read(file, &scene, error);
    if (status != AL_OK) return status;
    status = canvas_create(2 * EDGE + 3 * CANVAS_MARGIN, 2 * EDGE + 3 * CANVAS_MARGIN, &on, error);
    if (status != AL_OK) goto cleanup;
    scene_bounds(&scene, low, high);
    for (int i = 0; i < 3; i++) {
        if (low[i] > high[i]) low[i] = high[i] = 0;
        middle[i] = 0.5 * (low[i] + high[i]);
        size = fmax(size, high[i] - low[i]);
    }
    for (int v = 0; v < 4; v++) {
        panel p = canvas_panel(&on, v % 2, v / 2, EDGE);
        eye e = v < 3 ? sides[v] : camera_eye(&scene.cameras[0]);
        double centre[2] = {dot3(middle, e.right), dot3(middle, e.up)}, half = fmax(0.5 * size, 1e-6);
        double first[2] = {centre[0] - half, centre[1] - half},
               second[2] = {centre[0] + half, centre[1] + half};
        if (v < 3) panel_show(&p, first, second);
        draw_instances(&scene, &p, &e);
        draw_marks(&scene, &p, &e, middle, size);
    }
    status = canvas_write(&on, png_path, error);
cleanup:
    canvas_free(&on);
    al_scene_free(&scene);
    return status;
}

const inspected_kind inspected_scene = {AL_KIND_SCENE, summary, NULL, draw};
