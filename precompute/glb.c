/* Specification: Khronos, glTF 2.0. A .glb is a header, the chunk JSON and the chunk BIN, each a multiple of
 * four bytes; everything in BIN is found over bufferViews (byte ranges) and accessors (their numbers). */
#include "glb.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/image.h"

enum { FLOATS = 5126, UNSIGNED_INTS = 5125, VERTICES = 34962, INDICES = 34963 };

#define NEAR_M 0.01

typedef struct glb {
    const al_scene *scene;
    const char *path;
    al_error *error;
    al_status status;
    unsigned char *bin;
    size_t size, room;
    json_t *views, *accessors;
} glb;

static void out_of_memory(glb *g)
{
    if (g->status == AL_OK) g->status = al_fail(g->error, AL_IO, "%s: out of memory", g->path);
}

/* --- BIN --- */

/* A bufferView of its own for the bytes; answers its number. */
static json_int_t add_view(glb *g, const void *data, size_t size, int target)
{
    size_t padded = (size + 3) & ~(size_t)3;
    if (g->size + padded > g->room) {
        size_t room = 2 * (g->size + padded);
        unsigned char *grown = realloc(g->bin, room);
        if (!grown) {
            out_of_memory(g);
            return 0;
        }
        g->bin = grown;
        g->room = room;
    }
    memcpy(g->bin + g->size, data, size);
    memset(g->bin + g->size + size, 0, padded - size);
    json_t *view = json_pack("{s:i, s:I, s:I}", "buffer", 0, "byteOffset", (json_int_t)g->size, "byteLength",
                             (json_int_t)size);
    if (target) json_object_set_new(view, "target", json_integer(target));
    g->size += padded;
    json_array_append_new(g->views, view);
    return (json_int_t)json_array_size(g->views) - 1;
}

static json_t *add_accessor(glb *g, json_int_t view, size_t offset, int type, uint32_t count,
                            const char *shape)
{
    json_t *accessor =
        json_pack("{s:I, s:I, s:i, s:I, s:s}", "bufferView", view, "byteOffset", (json_int_t)offset,
                  "componentType", type, "count", (json_int_t)count, "type", shape);
    json_array_append_new(g->accessors, accessor);
    return accessor;
}

static json_t *last_accessor(const glb *g)
{
    return json_integer((json_int_t)json_array_size(g->accessors) - 1);
}

/* --- meshes --- */

static json_t *add_floats(glb *g, const float *values, uint32_t count, int width)
{
    static const char *const shapes[] = {"", "SCALAR", "VEC2", "VEC3"};
    json_int_t view = add_view(g, values, (size_t)count * (size_t)width * sizeof *values, VERTICES);
    return add_accessor(g, view, 0, FLOATS, count, shapes[width]);
}

static void set_bounds(json_t *accessor, const float *points, uint32_t count)
{
    json_t *low = json_array(), *high = json_array();
    for (int k = 0; k < 3; k++) {
        float least = points[k], most = points[k];
        for (size_t i = 0; i < count; i++) {
            least = fminf(least, points[3 * i + (size_t)k]);
            most = fmaxf(most, points[3 * i + (size_t)k]);
        }
        json_array_append_new(low, json_real(least));
        json_array_append_new(high, json_real(most));
    }
    json_object_set_new(accessor, "min", low);
    json_object_set_new(accessor, "max", high);
}

static json_t *make_mesh(glb *g, const al_mesh *mesh)
{
    json_t *attributes = json_object(), *primitives = json_array();
    set_bounds(add_floats(g, mesh->positions, mesh->vertex_count, 3), mesh->positions, mesh->vertex_count);
    json_object_set_new(attributes, "POSITION", last_accessor(g));
    add_floats(g, mesh->normals, mesh->vertex_count, 3);
    json_object_set_new(attributes, "NORMAL", last_accessor(g));
    /* TEXCOORD_1 alone would not be valid: TEXCOORD_0 stands in. */
    if (mesh->uv0 || mesh->uv1) {
        add_floats(g, mesh->uv0 ? mesh->uv0 : mesh->uv1, mesh->vertex_count, 2);
        json_object_set_new(attributes, "TEXCOORD_0", last_accessor(g));
    }
    if (mesh->uv1) {
        add_floats(g, mesh->uv1, mesh->vertex_count, 2);
        json_object_set_new(attributes, "TEXCOORD_1", last_accessor(g));
    }
    json_int_t view = add_view(g, mesh->indices, mesh->index_count * sizeof *mesh->indices, INDICES);
    for (uint32_t i = 0; i < mesh->submesh_count; i++) {
        const al_submesh *part = &mesh->submeshes[i];
        if (!part->index_count) continue;
        add_accessor(g, view, part->first_index * sizeof *mesh->indices, UNSIGNED_INTS, part->index_count,
                     "SCALAR");
        json_array_append_new(primitives,
                              json_pack("{s:O, s:o, s:I}", "attributes", attributes, "indices",
                                        last_accessor(g), "material", (json_int_t)part->material));
    }
    json_decref(attributes);
    return json_pack("{s:s, s:o}", "name", mesh->name, "primitives", primitives);
}

/* --- materials --- */

static json_t *triple(const float v[3], double scale, double limit)
{
    return json_pack("[f, f, f]", fmin(v[0] * scale, limit), fmin(v[1] * scale, limit),
                     fmin(v[2] * scale, limit));
}

static void set_texture(json_t *object, const char *key, uint32_t texture)
{
    if (texture != AL_NO_INDEX)
        json_object_set_new(object, key, json_pack("{s:I}", "index", (json_int_t)texture));
}

static double largest(const float v[3])
{
    return fmax(fmax(v[0], v[1]), v[2]);
}

static json_t *make_material(const al_material *m)
{
    json_t *color = triple(m->base_color, 1, 1), *extensions = json_object();
    json_array_append_new(color, json_real(1));
    json_t *metal = json_pack("{s:o, s:f, s:f}", "baseColorFactor", color, "metallicFactor",
                              (double)m->metallic, "roughnessFactor", (double)m->roughness);
    set_texture(metal, "baseColorTexture", m->base_color_texture);
    set_texture(metal, "metallicRoughnessTexture", m->metallic_roughness_texture);
    json_t *made = json_pack("{s:s, s:o, s:b}", "name", m->name, "pbrMetallicRoughness", metal, "doubleSided",
                             (int)m->double_sided);
    double strength = largest(m->emission_w_m2_sr);
    if (strength > 0) {
        json_object_set_new(made, "emissiveFactor", triple(m->emission_w_m2_sr, 1 / strength, 1));
        json_object_set_new(extensions, "KHR_materials_emissive_strength",
                            json_pack("{s:f}", "emissiveStrength", strength));
    }
    json_object_set_new(extensions, "KHR_materials_ior", json_pack("{s:f}", "ior", (double)m->ior));
    set_texture(made, "emissiveTexture", m->emission_texture);
    set_texture(made, "normalTexture", m->normal_texture);
    json_object_set_new(made, "extensions", extensions);
    return made;
}

/* A view, an image and a texture for each. */
static void add_textures(glb *g, json_t *root)
{
    json_t *images = json_array(), *textures = json_array();
    for (uint32_t i = 0; i < g->scene->texture_count && g->status == AL_OK; i++) {
        const al_texture *t = &g->scene->textures[i];
        void *png;
        size_t size;
        g->status = al_image_encode_png(g->path, t->width, t->height, 4, t->pixels, &png, &size, g->error);
        if (g->status != AL_OK) break;
        json_array_append_new(images, json_pack("{s:s, s:s, s:I}", "name", t->name, "mimeType", "image/png",
                                                "bufferView", add_view(g, png, size, 0)));
        json_array_append_new(textures, json_pack("{s:I}", "source", (json_int_t)i));
        free(png);
    }
    if (json_array_size(textures)) {
        json_object_set(root, "images", images);
        json_object_set(root, "textures", textures);
    }
    json_decref(images);
    json_decref(textures);
}

/* --- nodes --- */

/* Column-major, turned so that -z points along `forward`, as cameras and lights of glTF look. */
static json_t *look_along(const double forward[3], const double up[3], const double position[3])
{
    double z[3], x[3], y[3],
        length = sqrt(forward[0] * forward[0] + forward[1] * forward[1] + forward[2] * forward[2]);
    for (int k = 0; k < 3; k++) z[k] = -forward[k] / length;
    for (int k = 0; k < 3; k++) x[k] = up[(k + 1) % 3] * z[(k + 2) % 3] - up[(k + 2) % 3] * z[(k + 1) % 3];
    length = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
    for (int k = 0; k < 3; k++) x[k] /= length;
    for (int k = 0; k < 3; k++) y[k] = z[(k + 1) % 3] * x[(k + 2) % 3] - z[(k + 2) % 3] * x[(k + 1) % 3];
    return json_pack("[f,f,f,i, f,f,f,i, f,f,f,i, f,f,f,i]", x[0], x[1], x[2], 0, y[0], y[1], y[2], 0, z[0],
                     z[1], z[2], 0, position[0], position[1], position[2], 1);
}

static json_t *camera_node(const al_camera *c, json_int_t index)
{
    double forward[3], up[3], position[3];
    for (int k = 0; k < 3; k++) {
        forward[k] = (double)c->target[k] - c->position[k];
        up[k] = c->up[k];
        position[k] = c->position[k];
    }
    return json_pack("{s:s, s:I, s:o}", "name", c->name, "camera", index, "matrix",
                     look_along(forward, up, position));
}

static json_t *light_node(const al_light *l, json_int_t index)
{
    double direction[3] = {0, 0, -1}, position[3] = {0}, up[3] = {0};
    for (int k = 0; k < 3; k++) {
        if (l->type == AL_LIGHT_DIRECTIONAL)
            direction[k] = l->vector[k];
        else
            position[k] = l->vector[k];
    }
    up[fabs(direction[1]) < 0.9 ? 1 : 0] = 1;
    return json_pack("{s:s, s:o, s:{s:{s:I}}}", "name", l->name, "matrix",
                     look_along(direction, up, position), "extensions", "KHR_lights_punctual", "light",
                     index);
}

static json_t *instance_node(const al_instance *instance)
{
    json_t *matrix = json_array();
    for (int i = 0; i < 16; i++) json_array_append_new(matrix, json_real(instance->world[i]));
    return json_pack("{s:s, s:I, s:o}", "name", instance->name, "mesh", (json_int_t)instance->mesh, "matrix",
                     matrix);
}

static json_t *make_light(const al_light *l)
{
    double intensity = largest(l->intensity);
    return json_pack("{s:s, s:s, s:o, s:f}", "name", l->name, "type",
                     l->type == AL_LIGHT_DIRECTIONAL ? "directional" : "point", "color",
                     triple(l->intensity, intensity > 0 ? 1 / intensity : 0, 1), "intensity", intensity);
}

/* --- all of it --- */

static void set_unless_empty(json_t *root, const char *key, json_t *array)
{
    if (json_array_size(array)) json_object_set(root, key, array);
    json_decref(array);
}

static json_t *describe(glb *g)
{
    const al_scene *s = g->scene;
    json_t *meshes = json_array(), *materials = json_array(), *nodes = json_array(), *cameras = json_array(),
           *lights = json_array(), *all = json_array();
    json_t *root = json_pack("{s:{s:s, s:s}, s:[s, s, s], s:i}", "asset", "version", "2.0", "generator",
                             "airlight " AIRLIGHT_VERSION, "extensionsUsed", "KHR_lights_punctual",
                             "KHR_materials_emissive_strength", "KHR_materials_ior", "scene", 0);
    for (uint32_t i = 0; i < s->mesh_count; i++) json_array_append_new(meshes, make_mesh(g, &s->meshes[i]));
    for (uint32_t i = 0; i < s->material_count; i++)
        json_array_append_new(materials, make_material(&s->materials[i]));
    for (uint32_t i = 0; i < s->instance_count; i++)
        json_array_append_new(nodes, instance_node(&s->instances[i]));
    for (uint32_t i = 0; i < s->camera_count; i++) {
        json_array_append_new(cameras, json_pack("{s:s, s:s, s:{s:f, s:f}}", "name", s->cameras[i].name,
                                                 "type", "perspective", "perspective", "yfov",
                                                 (double)s->cameras[i].fov_y_radians, "znear", NEAR_M));
        json_array_append_new(nodes, camera_node(&s->cameras[i], i));
    }
    for (uint32_t i = 0; i < s->light_count; i++) {
        json_array_append_new(lights, make_light(&s->lights[i]));
        json_array_append_new(nodes, light_node(&s->lights[i], i));
    }
    for (size_t i = 0; i < json_array_size(nodes); i++)
        json_array_append_new(all, json_integer((json_int_t)i));
    add_textures(g, root);
    json_object_set_new(root, "scenes", json_pack("[{s:o}]", "nodes", all));
    if (json_array_size(lights))
        json_object_set_new(root, "extensions",
                            json_pack("{s:{s:O}}", "KHR_lights_punctual", "lights", lights));
    json_decref(lights);
    set_unless_empty(root, "nodes", nodes);
    set_unless_empty(root, "meshes", meshes);
    set_unless_empty(root, "materials", materials);
    set_unless_empty(root, "cameras", cameras);
    set_unless_empty(root, "bufferViews", json_incref(g->views));
    set_unless_empty(root, "accessors", json_incref(g->accessors));
    json_object_set_new(root, "buffers", json_pack("[{s:I}]", "byteLength", (json_int_t)g->size));
    return root;
}

static void put_u32(unsigned char *at, size_t value)
{
    for (int i = 0; i < 4; i++) at[i] = (unsigned char)(value >> 8 * i);
}

static al_status write_file(const glb *g, const char *text, uint64_t *bytes)
{
    size_t length = strlen(text), padded = (length + 3) & ~(size_t)3, size = 12 + 8 + padded + 8 + g->size;
    if (size > UINT32_MAX) return al_fail(g->error, AL_IO, "%s: more than 4 GiB do not fit a .glb", g->path);
    unsigned char *whole = malloc(size);
    if (!whole) return al_fail(g->error, AL_IO, "%s: out of memory", g->path);
    memcpy(whole, "glTF", 4);
    put_u32(whole + 4, 2);
    put_u32(whole + 8, size);
    put_u32(whole + 12, padded);
    memcpy(whole + 16, "JSON", 4);
    memcpy(whole + 20, text, length);
    memset(whole + 20 + length, ' ', padded - length);
    put_u32(whole + 20 + padded, g->size);
    memcpy(whole + 24 + padded, "BIN", 4);
    if (g->size) memcpy(whole + 28 + padded, g->bin, g->size);
    al_status status = al_write_file(g->path, whole, size, g->error);
    if (bytes) *bytes = status == AL_OK ? size : 0;
    free(whole);
    return status;
}

al_status al_glb_write(const char *path, const al_scene *scene, uint64_t *bytes, al_error *error)
{
    glb g = {.scene = scene, .path = path, .error = error, .views = json_array(), .accessors = json_array()};
    json_t *root = describe(&g);
    char *text = root ? json_dumps(root, JSON_COMPACT | JSON_REAL_PRECISION(9)) : NULL;
    if (!text) out_of_memory(&g);
    if (g.status == AL_OK) g.status = write_file(&g, text, bytes);
    free(text);
    free(g.bin);
    json_decref(root);
    json_decref(g.views);
    json_decref(g.accessors);
    return g.status;
}
