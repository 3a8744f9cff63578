#include "airlight/scene_description.h"

#include <errno.h>
#include <jansson.h>
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/medium.h"

enum { TEXT_LIMIT = 64 << 20, LIGHT_LIMIT = 64, PATH_LIMIT = 256, SENTENCE_LIMIT = 512 };

/* --- what one parse works on --- */

typedef struct source {
    const char *path;
    char *text;          /* whole file, terminated */
    size_t *line_starts; /* byte offset of every line */
    size_t line_count;
    al_scene_description *out;
} source;

/* A value with its place in the text; jansson keeps neither lines nor paths. */
typedef struct node {
    const source *from;
    const struct node *parent; /* NULL: the whole file */
    const char *key;           /* NULL: element `index` of a list */
    size_t index;
    json_t *value; /* NULL: the key is absent */
    const char *at;
} node;

/* --- memory: everything a description owns hangs on one list --- */

typedef struct block {
    struct block *next;
    max_align_t payload[];
} block;

static void *allocate(al_scene_description *out, size_t count, size_t size)
{
    if (size && count > (SIZE_MAX - sizeof(block)) / size) return NULL;
    block *made = calloc(1, sizeof(block) + count * size);
    if (!made) return NULL;
    made->next = out->storage;
    out->storage = made;
    return made->payload;
}

static char *copy_text(al_scene_description *out, const char *text)
{
    size_t size = strlen(text) + 1;
    char *copy = allocate(out, size, 1);
    if (copy) memcpy(copy, text, size);
    return copy;
}

static al_status out_of_memory(const source *from, al_error *error)
{
    return al_fail(error, AL_IO, "%s: out of memory while reading the scene", from->path);
}

/* --- places in the text: only ever used on text that jansson has accepted --- */

static const char *skip_space(const char *at)
{
    return at + strspn(at, " \t\r\n");
}

static const char *skip_string(const char *at)
{
    for (at++; *at && *at != '"'; at++)
        if (*at == '\\' && at[1]) at++;
    return *at ? at + 1 : at;
}

static const char *skip_value(const char *at)
{
    int depth = 0;
    do {
        at = skip_space(at);
        if (!*at) return at;
        if (*at == '"')
            at = skip_string(at);
        else if (strchr("{[", *at))
            depth++, at++;
        else if (strchr("}]", *at))
            depth--, at++;
        else if (strchr(",:", *at))
            at++;
        else
            at += strcspn(at, ",:]}{[\" \t\r\n");
    } while (depth > 0);
    return at;
}

/* Start of the first key or element inside a list or object, or of what follows the value at `at`. */
static const char *first_inside(const char *at)
{
    return skip_space(at + 1);
}

static const char *after_value(const char *at)
{
    at = skip_space(skip_value(at));
    return *at == ',' ? skip_space(at + 1) : at;
}

static const char *after_key(const char *at)
{
    at = skip_space(skip_string(at));
    return skip_space(*at == ':' ? at + 1 : at);
}

static int line_of(const source *from, const char *at)
{
    size_t offset = (size_t)(at - from->text), low = 0, high = from->line_count;
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (from->line_starts[middle] <= offset)
            low = middle;
        else
            high = middle;
    }
    return (int)low + 1;
}

/* Messages are one line, whatever keys and files hold. */
static void flatten(char *text)
{
    for (; *text; text++)
        if ((unsigned char)*text < ' ') *text = ' ';
}

static void append_path(const node *place, char path[PATH_LIMIT])
{
    if (place->parent) append_path(place->parent, path);
    size_t used = strlen(path);
    if (place->key)
        snprintf(path + used, PATH_LIMIT - used, used ? ".%s" : "%s", place->key);
    else if (place->parent)
        snprintf(path + used, PATH_LIMIT - used, "[%zu]", place->index);
}

/* FILE:LINE: key path: sentence */
static al_status fail_at(const node *place, al_error *error, const char *format, ...) AL_PRINTF(3, 4);
static al_status fail_at(const node *place, al_error *error, const char *format, ...)
{
    char path[PATH_LIMIT] = "", sentence[SENTENCE_LIMIT];
    append_path(place, path);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(sentence, sizeof sentence, format, arguments);
    va_end(arguments);
    flatten(path);
    flatten(sentence);
    return al_fail(error, AL_BAD_INPUT, "%s:%d: %s: %s", place->from->path, line_of(place->from, place->at),
                   *path ? path : "the scene", sentence);
}

/* --- the keys: one table for the parser, the schema's test and the documents --- */

typedef struct transform_fields {
    double translate_m[3], rotate_degrees[3], scale[3], matrix[16];
} transform_fields;

typedef struct scene_fields {
    char *schema, *comment;
    double unit_m;
    node meshes, materials, lights, environment, cameras, media, translucents, fogs, lightmap, probes, bake,
        play;
} scene_fields;

typedef struct mesh_fields {
    char *name, *file, *node_name, *material, *lighting, *animation;
    double unit_m;
    bool hidden, import_lights, import_cameras;
    node shape, transform, motion;
} mesh_fields;

typedef struct key_fields {
    double time_s, translate_m[3], rotate_degrees[3], scale[3];
} key_fields;

typedef struct material_fields {
    char *name;
    double base_color[3], emission_w_m2_sr[3], metallic, roughness, ior;
    bool double_sided;
} material_fields;

typedef struct light_fields {
    char *name, *type;
    double direction[3], irradiance_w_m2[3], position_m[3], intensity_w_sr[3];
    node motion;
} light_fields;

typedef struct camera_fields {
    char *name;
    double position_m[3], target_m[3], up[3], fov_y_degrees;
    node motion;
} camera_fields;

typedef struct medium_fields {
    char *name;
    double sigma_s_per_m[3], sigma_a_per_m[3], albedo[3], mean_free_path_m[3], g, optical_depth_order;
    node absorption_from, density;
} medium_fields;

typedef struct absorption_fields {
    char *mesh, *material;
} absorption_fields;

typedef struct density_fields {
    char *type, *file, *grid;
    double scale, unit_m, bounds_min_m[3], bounds_max_m[3], axis[3], period_m, thickness_m, offset_m, low,
        high, first_frame, frame_count, frames_per_second;
    node transform, motion;
} density_fields;

typedef struct translucent_fields {
    char *name, *mesh, *medium;
    node blockers;
} translucent_fields;

typedef struct environment_fields {
    char *file;
    double radiance_w_m2_sr[3], scale, rotation_degrees;
} environment_fields;

typedef struct shape_fields {
    char *type;
    double radius_m, size_m[3], width_m, depth_m, major_radius_m, minor_radius_m, subdivisions,
        major_segments, minor_segments;
} shape_fields;

typedef struct lightmap_fields {
    double texel_m, samples, bounces, fog_points, back_scatter_shift_m, directional_order, padding_texels,
        page_size, seed;
    char *walls, *uv;
    bool back_scatter;
} lightmap_fields;

typedef struct probes_fields {
    double order, samples, spacing_m;
    node points;
} probes_fields;

typedef struct point_fields {
    double position_m[3];
} point_fields;

typedef struct bake_fields {
    double directions, grid_resolution, samples, radius_m, sh_order, seed;
    char *coefficient_format, *too_dense;
} bake_fields;

typedef struct play_fields {
    double exposure_ev, background[3];
} play_fields;

/* clang-format off */
#define TEXT(object, key) \
    {#object, #key, AL_SCENE_STRING, false, 0, 0, "", offsetof(object##_fields, key)}
#define NAME(object, key) \
    {#object, #key, AL_SCENE_STRING, true, 0, 0, "", offsetof(object##_fields, key)}
#define FLAG(object, key) \
    {#object, #key, AL_SCENE_BOOL, false, 0, 0, "", offsetof(object##_fields, key)}
#define NUMBER(object, key, low, high) \
    {#object, #key, AL_SCENE_NUMBER, false, low, high, "", offsetof(object##_fields, key)}
#define INTEGER(object, key, low, high) \
    {#object, #key, AL_SCENE_INTEGER, false, low, high, "", offsetof(object##_fields, key)}
#define TRIPLE(object, key, low, high) \
    {#object, #key, AL_SCENE_TRIPLE, false, low, high, "", offsetof(object##_fields, key)}
#define VECTOR(object, key, must) \
    {#object, #key, AL_SCENE_VECTOR, must, -FAR_M, FAR_M, "", offsetof(object##_fields, key)}
#define CHOICE(object, key, must, words) \
    {#object, #key, AL_SCENE_CHOICE, must, 0, 0, words, offsetof(object##_fields, key)}
#define OBJECT(object, key, kind) \
    {#object, #key, AL_SCENE_OBJECT, false, 0, 0, kind, offsetof(object##_fields, key)}
#define LIST(object, key, kind) \
    {#object, #key, AL_SCENE_LIST, false, 0, 0, kind, offsetof(object##_fields, key)}
/* clang-format on */

#define FAR_M 1e9   /* coordinates and lengths */
#define BRIGHT 1e12 /* radiometric values */
#define LONG_S 1e6  /* eleven days */
#define TINY 1e-9   /* smallest length, unit and scale */

static const al_scene_key keys[] = {
    {"scene", "$schema", AL_SCENE_STRING, false, 0, 0, "", offsetof(scene_fields, schema)},
    TEXT(scene, comment),
    NUMBER(scene, unit_m, TINY, FAR_M),
    LIST(scene, meshes, "mesh"),
    LIST(scene, materials, "material"),
    LIST(scene, lights, "light"),
    OBJECT(scene, environment, "environment"),
    LIST(scene, cameras, "camera"),
    LIST(scene, media, "medium"),
    LIST(scene, translucents, "translucent"),
    {"scene", "fogs", AL_SCENE_NAMES, false, 0, 0, "", offsetof(scene_fields, fogs)},
    OBJECT(scene, lightmap, "lightmap"),
    OBJECT(scene, probes, "probes"),
    OBJECT(scene, bake, "bake"),
    OBJECT(scene, play, "play"),

    NAME(mesh, name),
    TEXT(mesh, file),
    OBJECT(mesh, shape, "shape"),
    {"mesh", "node", AL_SCENE_STRING, false, 0, 0, "", offsetof(mesh_fields, node_name)},
    NUMBER(mesh, unit_m, TINY, FAR_M),
    OBJECT(mesh, transform, "transform"),
    TEXT(mesh, material),
    CHOICE(mesh, lighting, false, "dynamic|lightmap|probes"),
    FLAG(mesh, hidden),
    FLAG(mesh, import_lights),
    FLAG(mesh, import_cameras),
    TEXT(mesh, animation),
    LIST(mesh, motion, "key"),

    CHOICE(shape, type, true, "sphere|box|plane|torus"),
    NUMBER(shape, radius_m, TINY, FAR_M),
    INTEGER(shape, subdivisions, 0, 8),
    TRIPLE(shape, size_m, TINY, FAR_M),
    NUMBER(shape, width_m, TINY, FAR_M),
    NUMBER(shape, depth_m, TINY, FAR_M),
    NUMBER(shape, major_radius_m, TINY, FAR_M),
    NUMBER(shape, minor_radius_m, TINY, FAR_M),
    INTEGER(shape, major_segments, 3, 4096),
    INTEGER(shape, minor_segments, 3, 4096),

    VECTOR(transform, translate_m, false),
    VECTOR(transform, rotate_degrees, false),
    TRIPLE(transform, scale, -FAR_M, FAR_M),
    {"transform", "matrix", AL_SCENE_MATRIX, false, -FAR_M, FAR_M, "", offsetof(transform_fields, matrix)},

    {"key", "time_s", AL_SCENE_NUMBER, true, 0, LONG_S, "", offsetof(key_fields, time_s)},
    VECTOR(key, translate_m, false),
    {"key", "rotate_degrees", AL_SCENE_VECTOR, false, -36000, 36000, "", offsetof(key_fields, rotate_degrees)},
    TRIPLE(key, scale, 0, FAR_M),

    NAME(material, name),
    TRIPLE(material, base_color, 0, 1),
    NUMBER(material, metallic, 0, 1),
    NUMBER(material, roughness, 0, 1),
    TRIPLE(material, emission_w_m2_sr, 0, BRIGHT),
    NUMBER(material, ior, 1, 10),
    FLAG(material, double_sided),

    TEXT(light, name),
    CHOICE(light, type, true, "directional|point"),
    VECTOR(light, direction, false),
    TRIPLE(light, irradiance_w_m2, 0, BRIGHT),
    VECTOR(light, position_m, false),
    TRIPLE(light, intensity_w_sr, 0, BRIGHT),
    LIST(light, motion, "key"),

    TEXT(environment, file),
    TRIPLE(environment, radiance_w_m2_sr, 0, BRIGHT),
    NUMBER(environment, scale, 0, BRIGHT),
    NUMBER(environment, rotation_degrees, -36000, 36000),

    TEXT(camera, name),
    VECTOR(camera, position_m, true),
    VECTOR(camera, target_m, true),
    VECTOR(camera, up, false),
    NUMBER(camera, fov_y_degrees, 0.01, 179),
    LIST(camera, motion, "key"),

    NAME(medium, name),
    TRIPLE(medium, sigma_s_per_m, 0, FAR_M),
    TRIPLE(medium, sigma_a_per_m, 0, FAR_M),
    TRIPLE(medium, albedo, 0, 1),
    TRIPLE(medium, mean_free_path_m, TINY, FAR_M),
    OBJECT(medium, absorption_from, "absorption"),
    NUMBER(medium, g, -0.99, 0.99),
    INTEGER(medium, optical_depth_order, 0, AL_DEPTH_ORDER_LIMIT),
    OBJECT(medium, density, "density"),

    NAME(absorption, mesh),
    NAME(absorption, material),

    CHOICE(density, type, true, "constant|grid|layers"),
    NUMBER(density, scale, TINY, FAR_M),
    TEXT(density, file),
    TEXT(density, grid),
    NUMBER(density, unit_m, TINY, FAR_M),
    INTEGER(density, first_frame, 0, 1000000),
    INTEGER(density, frame_count, 1, 100000),
    NUMBER(density, frames_per_second, 0.001, 1000000),
    OBJECT(density, transform, "transform"),
    LIST(density, motion, "key"),
    VECTOR(density, bounds_min_m, false),
    VECTOR(density, bounds_max_m, false),
    VECTOR(density, axis, false),
    NUMBER(density, period_m, TINY, FAR_M),
    NUMBER(density, thickness_m, 0, FAR_M),
    NUMBER(density, offset_m, -FAR_M, FAR_M),
    NUMBER(density, low, 0, FAR_M),
    NUMBER(density, high, 0, FAR_M),

    TEXT(translucent, name),
    NAME(translucent, mesh),
    NAME(translucent, medium),
    {"translucent", "blockers", AL_SCENE_NAMES, false, 0, 0, "", offsetof(translucent_fields, blockers)},

    NUMBER(lightmap, texel_m, TINY, FAR_M),
    INTEGER(lightmap, samples, 1, 10000000),
    INTEGER(lightmap, bounces, 0, 1000),
    CHOICE(lightmap, walls, false, "published|bounded|traced"),
    INTEGER(lightmap, fog_points, 1, 64),
    FLAG(lightmap, back_scatter),
    NUMBER(lightmap, back_scatter_shift_m, TINY, FAR_M),
    CHOICE(lightmap, uv, false, "auto|file|atlas"),
    INTEGER(lightmap, directional_order, 0, 4),
    INTEGER(lightmap, padding_texels, 1, 64),
    INTEGER(lightmap, page_size, 16, 16384),
    INTEGER(lightmap, seed, 0, UINT32_MAX),

    INTEGER(probes, order, 1, 8),
    INTEGER(probes, samples, 1, 10000000),
    NUMBER(probes, spacing_m, TINY, FAR_M),
    LIST(probes, points, "point"),

    VECTOR(point, position_m, true),

    INTEGER(bake, directions, 2, 4096),
    INTEGER(bake, grid_resolution, 1, 512),
    INTEGER(bake, samples, 1, 10000000),
    NUMBER(bake, radius_m, TINY, FAR_M),
    INTEGER(bake, sh_order, 1, 8),
    CHOICE(bake, coefficient_format, false, "float|half|byte"),
    INTEGER(bake, seed, 0, UINT32_MAX),
    CHOICE(bake, too_dense, false, "refuse|bake"),

    NUMBER(play, exposure_ev, -30, 30),
    TRIPLE(play, background, 0, BRIGHT),
};
enum { KEY_COUNT = sizeof keys / sizeof keys[0] };

const al_scene_key *al_scene_keys(size_t *count)
{
    *count = KEY_COUNT;
    return keys;
}

/* --- values --- */

static void describe(const al_scene_key *key, char text[SENTENCE_LIMIT])
{
    static const char *const names[] = {[AL_SCENE_STRING] = "a text",
                                        [AL_SCENE_NUMBER] = "a number",
                                        [AL_SCENE_INTEGER] = "a whole number",
                                        [AL_SCENE_BOOL] = "true or false",
                                        [AL_SCENE_TRIPLE] = "a number or a list of 3 numbers",
                                        [AL_SCENE_VECTOR] = "a list of 3 numbers",
                                        [AL_SCENE_MATRIX] = "a list of 16 numbers",
                                        [AL_SCENE_CHOICE] = "one of",
                                        [AL_SCENE_NAMES] = "a list of texts",
                                        [AL_SCENE_OBJECT] = "an object {...}",
                                        [AL_SCENE_LIST] = "a list [...] of objects"};
    if (key->type == AL_SCENE_CHOICE)
        snprintf(text, SENTENCE_LIMIT, "one of %s", key->words);
    else if (key->minimum < key->maximum)
        snprintf(text, SENTENCE_LIMIT, "%s from %.10g to %.10g", names[key->type], key->minimum,
                 key->maximum);
    else
        snprintf(text, SENTENCE_LIMIT, "%s", names[key->type]);
}

static al_status wrong_value(const node *place, const al_scene_key *key, al_error *error)
{
    char found[64] = "", right[SENTENCE_LIMIT];
    size_t size = (size_t)(skip_value(place->at) - place->at), used = 0;
    for (size_t i = 0; i < size && used < 40; i++) found[used++] = place->at[i];
    if (size > used) memcpy(found + used, "...", 4);
    describe(key, right);
    return fail_at(place, error, "is %s; %s is right", found, right);
}

static bool number_in_range(const json_t *value, const al_scene_key *key, double *out)
{
    if (!json_is_number(value)) return false;
    *out = json_number_value(value);
    if (key->type == AL_SCENE_INTEGER && *out != floor(*out)) return false;
    return *out >= key->minimum && *out <= key->maximum;
}

static bool read_numbers(const node *place, const al_scene_key *key, size_t count, double *out)
{
    if (json_array_size(place->value) != count) return false;
    for (size_t i = 0; i < count; i++)
        if (!number_in_range(json_array_get(place->value, i), key, out + i)) return false;
    return true;
}

static bool read_triple(const node *place, const al_scene_key *key, double *out)
{
    if (json_is_array(place->value)) return read_numbers(place, key, 3, out);
    if (!number_in_range(place->value, key, out)) return false;
    out[1] = out[2] = out[0];
    return true;
}

static bool is_choice(const char *word, const char *words)
{
    size_t size = strlen(word);
    for (const char *at = words; size && at; at = strchr(at, '|')) {
        at += *at == '|';
        if (strncmp(at, word, size) == 0 && (at[size] == '|' || !at[size])) return true;
    }
    return false;
}

/* Names appear in one-line messages and in file names: no control characters. */
static bool is_clean(const char *text)
{
    for (; *text; text++)
        if ((unsigned char)*text < ' ' || *text == 0x7f) return false;
    return true;
}

static bool read_text(const node *place, const al_scene_key *key, char **out)
{
    const char *text = json_string_value(place->value);
    if (!text || !*text || !is_clean(text)) return false;
    if (key->type == AL_SCENE_CHOICE && !is_choice(text, key->words)) return false;
    *out = (char *)(uintptr_t)text; /* the JSON tree lives until the whole parse has ended */
    return true;
}

static bool read_names(const node *place, node *out)
{
    if (!json_is_array(place->value)) return false;
    for (size_t i = 0; i < json_array_size(place->value); i++) {
        const char *text = json_string_value(json_array_get(place->value, i));
        if (!text || !*text || !is_clean(text)) return false;
    }
    *out = *place;
    return true;
}

static al_status read_value(const node *place, const al_scene_key *key, void *fields, al_error *error)
{
    void *out = (char *)fields + key->offset;
    bool good = false;
    switch (key->type) {
    case AL_SCENE_STRING:
    case AL_SCENE_CHOICE:
        good = read_text(place, key, out);
        break;
    case AL_SCENE_NUMBER:
    case AL_SCENE_INTEGER:
        good = number_in_range(place->value, key, out);
        break;
    case AL_SCENE_BOOL:
        good = json_is_boolean(place->value);
        *(bool *)out = json_is_true(place->value);
        break;
    case AL_SCENE_TRIPLE:
        good = read_triple(place, key, out);
        break;
    case AL_SCENE_VECTOR:
        good = read_numbers(place, key, 3, out);
        break;
    case AL_SCENE_MATRIX:
        good = read_numbers(place, key, 16, out);
        break;
    case AL_SCENE_NAMES:
        good = read_names(place, out);
        break;
    case AL_SCENE_OBJECT:
        good = json_is_object(place->value);
        *(node *)out = *place;
        break;
    case AL_SCENE_LIST:
        good = json_is_array(place->value);
        *(node *)out = *place;
        break;
    }
    return good ? AL_OK : wrong_value(place, key, error);
}

static const al_scene_key *find_key(const char *object, const char *name)
{
    for (size_t i = 0; i < KEY_COUNT; i++)
        if (strcmp(keys[i].object, object) == 0 && strcmp(keys[i].key, name) == 0) return &keys[i];
    return NULL;
}

static al_status unknown_key(const node *place, const char *object, al_error *error)
{
    char known[SENTENCE_LIMIT] = "";
    for (size_t i = 0; i < KEY_COUNT; i++) {
        size_t used = strlen(known);
        if (strcmp(keys[i].object, object) == 0)
            snprintf(known + used, sizeof known - used, "%s%s", used ? ", " : "", keys[i].key);
    }
    return fail_at(place, error, "unknown key; known here: %s", known);
}

static bool has(const node *object, const char *key)
{
    return object->value && json_object_get(object->value, key);
}

/* Reads every key of `place` (an object of kind `object`) into `fields`; absent ones keep what is there. */
static al_status read_object(const node *place, const char *object, void *fields, al_error *error)
{
    if (!json_is_object(place->value)) return fail_at(place, error, "is not an object; {...} is right");
    const char *at = first_inside(place->at);
    for (void *entry = json_object_iter(place->value); entry;
         entry = json_object_iter_next(place->value, entry)) {
        node child = {place->from,  place, json_object_iter_key(entry), 0, json_object_iter_value(entry),
                      after_key(at)};
        at = after_value(child.at);
        const al_scene_key *key = find_key(object, child.key);
        al_status status = key ? read_value(&child, key, fields, error) : unknown_key(&child, object, error);
        if (status) return status;
    }
    for (size_t i = 0; i < KEY_COUNT; i++)
        if (keys[i].required && strcmp(keys[i].object, object) == 0 && !has(place, keys[i].key))
            return fail_at(place, error, "\"%s\" is missing", keys[i].key);
    return AL_OK;
}

/* Refuses keys of `place` that are not in `allowed` ("|type|file|"), for objects whose keys depend on a
 * choice. */
static al_status allow_only(const node *place, const char *allowed, const char *choice, al_error *error)
{
    for (void *entry = json_object_iter(place->value); entry;
         entry = json_object_iter_next(place->value, entry))
        if (!is_choice(json_object_iter_key(entry), allowed))
            return fail_at(place, error, "\"%s\" does not go with \"%s\"; these do: %s",
                           json_object_iter_key(entry), choice, allowed);
    return AL_OK;
}

static al_status need(const node *place, const char *key, const char *choice, al_error *error)
{
    return has(place, key) ? AL_OK : fail_at(place, error, "\"%s\" is missing; \"%s\" needs it", key, choice);
}

static size_t list_size(const node *list)
{
    return list->value ? json_array_size(list->value) : 0;
}

/* Walks a list: start with *element zeroed; false after the last. */
static bool next_element(const node *list, node *element)
{
    size_t index = element->from ? element->index + 1 : 0;
    if (index >= list_size(list)) return false;
    const char *at = element->from ? after_value(element->at) : first_inside(list->at);
    *element = (node){list->from, list, NULL, index, json_array_get(list->value, index), at};
    return true;
}

static void to_floats(const double in[3], float out[3])
{
    for (int i = 0; i < 3; i++) out[i] = (float)in[i];
}

static bool normalise(double v[3])
{
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    if (!(length > 0)) return false;
    for (int i = 0; i < 3; i++) v[i] /= length;
    return true;
}

/* A file name relative to the scene file's folder. */
static char *resolve(al_scene_description *out, const char *file)
{
    if (!file || !*file) return copy_text(out, "");
    if (*file == '/' || strcmp(out->folder, ".") == 0) return copy_text(out, file);
    size_t size = strlen(out->folder) + strlen(file) + 2;
    char *path = allocate(out, size, 1);
    if (path) snprintf(path, size, "%s/%s", out->folder, file);
    return path;
}

static char *text_or(al_scene_description *out, const char *text, const char *kind, size_t index)
{
    char made[64];
    snprintf(made, sizeof made, "%s %zu", kind, index);
    return copy_text(out, text ? text : made);
}

/* --- transforms --- */

static void identity(double m[16])
{
    for (int i = 0; i < 16; i++) m[i] = i % 5 == 0;
}

/* Column-major T R S: scale, then rotate about x, y, z in this order (fixed axes), then translate. */
static void compose(const transform_fields *fields, double m[16])
{
    double c[3], s[3];
    for (int i = 0; i < 3; i++) {
        double angle = fields->rotate_degrees[i] * (3.14159265358979323846 / 180);
        c[i] = cos(angle);
        s[i] = sin(angle);
    }
    /* R = Rz Ry Rx, written out */
    const double rotation[3][3] = {
        {c[2] * c[1], c[2] * s[1] * s[0] - s[2] * c[0], c[2] * s[1] * c[0] + s[2] * s[0]},
        {s[2] * c[1], s[2] * s[1] * s[0] + c[2] * c[0], s[2] * s[1] * c[0] - c[2] * s[0]},
        {-s[1], c[1] * s[0], c[1] * c[0]}};
    identity(m);
    for (int column = 0; column < 3; column++)
        for (int row = 0; row < 3; row++) m[column * 4 + row] = rotation[row][column] * fields->scale[column];
    for (int row = 0; row < 3; row++) m[12 + row] = fields->translate_m[row];
}

static double determinant(const double m[16])
{
    return m[0] * (m[5] * m[10] - m[9] * m[6]) - m[4] * (m[1] * m[10] - m[9] * m[2]) +
           m[8] * (m[1] * m[6] - m[5] * m[2]);
}

static al_status read_transform(const node *place, double m[16], al_error *error)
{
    transform_fields fields = {.scale = {1, 1, 1}};
    identity(m);
    if (!place->value) return AL_OK;
    al_status status = read_object(place, "transform", &fields, error);
    if (!status && has(place, "matrix")) {
        status = allow_only(place, "matrix", "matrix", error);
        memcpy(m, fields.matrix, sizeof fields.matrix);
        if (!status && (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1))
            status = fail_at(place, error,
                             "matrix is projective or not column-major; elements 4, 8, 12 must "
                             "be 0 and element 16 must be 1");
    } else if (!status) {
        compose(&fields, m);
    }
    if (!status && !(fabs(determinant(m)) > 1e-300))
        status = fail_at(place, error, "squeezes space flat (determinant 0); every scale must differ from 0");
    return status;
}

/* --- motion --- */

static al_status read_motion(const node *place, al_scene_description *out, al_motion_description *motion,
                             al_error *error)
{
    size_t count = list_size(place);
    node element = {0};
    al_status status = AL_OK;
    *motion = (al_motion_description){0};
    if (!count) return AL_OK;
    motion->keys = allocate(out, count, sizeof *motion->keys);
    if (!motion->keys) return out_of_memory(place->from, error);
    motion->line = line_of(place->from, place->at);
    while (!status && next_element(place, &element)) {
        key_fields f = {.scale = {1, 1, 1}};
        al_motion_key_description *key = &motion->keys[motion->count];
        status = read_object(&element, "key", &f, error);
        key->time_s = f.time_s;
        memcpy(key->translate_m, f.translate_m, sizeof f.translate_m);
        memcpy(key->rotate_degrees, f.rotate_degrees, sizeof f.rotate_degrees);
        memcpy(key->scale, f.scale, sizeof f.scale);
        /* Times are kept as floats. */
        if (!status && motion->count && !((float)f.time_s > (float)key[-1].time_s))
            status = fail_at(&element, error, "time_s %g does not follow %g; times that rise are right", f.time_s,
                             key[-1].time_s);
        motion->count++;
    }
    return status;
}

/* --- the parts of a scene --- */

static al_status read_shape(const node *place, al_shape_description *out, al_error *error)
{
    shape_fields f = {.radius_m = 0.5,
                      .size_m = {1, 1, 1},
                      .width_m = 1,
                      .depth_m = 1,
                      .subdivisions = 5,
                      .major_radius_m = 0.35,
                      .minor_radius_m = 0.15,
                      .major_segments = 96,
                      .minor_segments = 48};
    al_status status = read_object(place, "shape", &f, error);
    if (status) return status;
    if (strcmp(f.type, "sphere") == 0) {
        out->type = AL_SHAPE_SPHERE;
        status = allow_only(place, "type|radius_m|subdivisions", f.type, error);
    } else if (strcmp(f.type, "box") == 0) {
        out->type = AL_SHAPE_BOX;
        status = allow_only(place, "type|size_m", f.type, error);
    } else if (strcmp(f.type, "plane") == 0) {
        out->type = AL_SHAPE_PLANE;
        status = allow_only(place, "type|width_m|depth_m", f.type, error);
    } else {
        out->type = AL_SHAPE_TORUS;
        status = allow_only(place, "type|major_radius_m|minor_radius_m|major_segments|minor_segments", f.type,
                            error);
        if (!status && f.minor_radius_m >= f.major_radius_m)
            status = fail_at(place, error,
                             "minor_radius_m %g is not below major_radius_m %g; the torus would "
                             "run into itself",
                             f.minor_radius_m, f.major_radius_m);
    }
    out->radius_m = f.radius_m;
    memcpy(out->size_m, f.size_m, sizeof f.size_m);
    out->width_m = f.width_m;
    out->depth_m = f.depth_m;
    out->major_radius_m = f.major_radius_m;
    out->minor_radius_m = f.minor_radius_m;
    out->subdivisions = (uint32_t)f.subdivisions;
    out->major_segments = (uint32_t)f.major_segments;
    out->minor_segments = (uint32_t)f.minor_segments;
    return status;
}

static al_status read_mesh(const node *place, al_scene_description *out, al_mesh_description *mesh,
                           al_error *error)
{
    mesh_fields f = {.unit_m = out->unit_m, .import_lights = true, .import_cameras = true};
    al_status status = read_object(place, "mesh", &f, error);
    if (status) return status;
    if (!f.file == !f.shape.value)
        return fail_at(place, error, "has %s; give either \"file\" or \"shape\"",
                       f.file ? "both \"file\" and \"shape\"" : "neither \"file\" nor \"shape\"");
    if (f.shape.value) {
        status = allow_only(place, "name|shape|transform|material|lighting|hidden|motion", "shape", error);
        if (!status) status = read_shape(&f.shape, &mesh->shape, error);
        if (status) return status;
        f.unit_m = 1;
    }
    mesh->line = line_of(place->from, place->at);
    mesh->name = copy_text(out, f.name);
    mesh->file = resolve(out, f.file);
    mesh->node = copy_text(out, f.node_name ? f.node_name : "");
    mesh->material = copy_text(out, f.material ? f.material : "");
    mesh->unit_m = f.unit_m;
    mesh->lighting = !f.lighting                           ? AL_LIGHTING_DYNAMIC
                     : strcmp(f.lighting, "lightmap") == 0 ? AL_LIGHTING_LIGHTMAP
                     : strcmp(f.lighting, "probes") == 0   ? AL_LIGHTING_PROBES
                                                           : AL_LIGHTING_DYNAMIC;
    mesh->animation = copy_text(out, f.animation ? f.animation : "");
    mesh->hidden = f.hidden;
    mesh->import_lights = f.import_lights && f.file;
    mesh->import_cameras = f.import_cameras && f.file;
    if (!mesh->name || !mesh->file || !mesh->node || !mesh->material || !mesh->animation)
        return out_of_memory(place->from, error);
    status = read_motion(&f.motion, out, &mesh->motion, error);
    return status ? status : read_transform(&f.transform, mesh->transform, error);
}

static al_status read_material(const node *place, al_scene_description *out, al_material *material,
                               al_error *error)
{
    material_fields f = {.base_color = {0.8, 0.8, 0.8}, .roughness = 1, .ior = 1.5};
    al_status status = read_object(place, "material", &f, error);
    if (status) return status;
    *material = (al_material){.metallic = (float)f.metallic,
                              .roughness = (float)f.roughness,
                              .ior = (float)f.ior,
                              .double_sided = f.double_sided,
                              .base_color_texture = AL_NO_INDEX,
                              .emission_texture = AL_NO_INDEX,
                              .metallic_roughness_texture = AL_NO_INDEX,
                              .normal_texture = AL_NO_INDEX};
    to_floats(f.base_color, material->base_color);
    to_floats(f.emission_w_m2_sr, material->emission_w_m2_sr);
    material->name = copy_text(out, f.name);
    return material->name ? AL_OK : out_of_memory(place->from, error);
}

static al_status read_light(const node *place, al_scene_description *out, al_light *light, al_error *error)
{
    light_fields f = {0};
    al_status status = read_object(place, "light", &f, error);
    if (status) return status;
    bool directional = strcmp(f.type, "directional") == 0;
    status = allow_only(
        place, directional ? "name|type|direction|irradiance_w_m2|motion" : "name|type|position_m|intensity_w_sr|motion",
        f.type, error);
    if (!status) status = need(place, directional ? "direction" : "position_m", f.type, error);
    if (!status) status = need(place, directional ? "irradiance_w_m2" : "intensity_w_sr", f.type, error);
    if (status) return status;
    if (directional && !normalise(f.direction))
        return fail_at(place, error, "direction has no length; the way the light travels is right");
    light->type = directional ? AL_LIGHT_DIRECTIONAL : AL_LIGHT_POINT;
    to_floats(directional ? f.direction : f.position_m, light->vector);
    to_floats(directional ? f.irradiance_w_m2 : f.intensity_w_sr, light->intensity);
    light->name = text_or(out, f.name, "light", place->index);
    if (!light->name) return out_of_memory(place->from, error);
    return read_motion(&f.motion, out, &out->light_motions[place->index], error);
}

static al_status read_camera(const node *place, al_scene_description *out, al_camera *camera, al_error *error)
{
    camera_fields f = {.up = {0, 1, 0}, .fov_y_degrees = 40};
    al_status status = read_object(place, "camera", &f, error);
    if (status) return status;
    double view[3], side[3];
    for (int i = 0; i < 3; i++) view[i] = f.target_m[i] - f.position_m[i];
    if (!normalise(view)) return fail_at(place, error, "position_m and target_m are the same point");
    if (!normalise(f.up)) return fail_at(place, error, "up has no length; [0, 1, 0] is usual");
    for (int i = 0; i < 3; i++)
        side[i] = view[(i + 1) % 3] * f.up[(i + 2) % 3] - view[(i + 2) % 3] * f.up[(i + 1) % 3];
    if (side[0] * side[0] + side[1] * side[1] + side[2] * side[2] < 1e-12)
        return fail_at(place, error, "looks along its own up; choose another \"up\", such as [0, 0, -1]");
    to_floats(f.position_m, camera->position);
    to_floats(f.target_m, camera->target);
    to_floats(f.up, camera->up);
    camera->fov_y_radians = (float)(f.fov_y_degrees * (3.14159265358979323846 / 180));
    camera->name = text_or(out, f.name, "camera", place->index);
    if (!camera->name) return out_of_memory(place->from, error);
    return read_motion(&f.motion, out, &out->camera_motions[place->index], error);
}

static al_status read_bounds(const node *place, const density_fields *f, al_density_description *out,
                             al_error *error)
{
    bool low = has(place, "bounds_min_m"), high = has(place, "bounds_max_m");
    if (low != high) return fail_at(place, error, "bounds_min_m and bounds_max_m go together");
    out->has_bounds = low;
    for (int i = 0; i < 3; i++) {
        out->bounds_min_m[i] = f->bounds_min_m[i];
        out->bounds_max_m[i] = f->bounds_max_m[i];
        if (low && !(f->bounds_min_m[i] < f->bounds_max_m[i]))
            return fail_at(place, error, "bounds_min_m is not below bounds_max_m on axis %c", "xyz"[i]);
    }
    return AL_OK;
}

static al_status read_layers(const node *place, density_fields *f, al_density_description *out,
                             al_error *error)
{
    al_status status = need(place, "period_m", f->type, error);
    if (!status) status = need(place, "thickness_m", f->type, error);
    if (status) return status;
    if (!normalise(f->axis)) return fail_at(place, error, "axis has no length; [0, 1, 0] is usual");
    if (f->thickness_m > f->period_m)
        return fail_at(place, error, "thickness_m %g exceeds period_m %g", f->thickness_m, f->period_m);
    if (f->low == 0 && f->high == 0)
        return fail_at(place, error, "low and high are both 0: there is no medium");
    memcpy(out->axis, f->axis, sizeof f->axis);
    out->period_m = f->period_m;
    out->thickness_m = f->thickness_m;
    out->offset_m = f->offset_m;
    out->low = f->low;
    out->high = f->high;
    return AL_OK;
}

static al_status read_grid(const node *place, const density_fields *f, al_density_description *out,
                           al_error *error)
{
    al_status status = need(place, "file", f->type, error);
    if (!status) status = read_transform(&f->transform, out->grid_to_world, error);
    for (int i = 0; i < 12; i++) out->grid_to_world[i] *= f->unit_m;
    return status;
}

/* The "%d" or "%04d" of a sequence's file names: where it begins and ends, and how many digits at least; NULL: none. */
static const char *find_number(const char *files, const char **end, int *digits)
{
    for (const char *at = files; (at = strchr(at, '%')) != NULL; at++) {
        char *behind = (char *)(uintptr_t)at + 1;
        *digits = *behind == '0' ? (int)strtol(behind, &behind, 10) : 0;
        if (*behind == 'd' && *digits >= 0 && *digits < 20) return *end = behind + 1, at;
    }
    return NULL;
}

bool al_density_frame_file(const al_density_description *density, uint32_t index, char *path, size_t size)
{
    const char *end;
    int digits, used;
    const char *at = find_number(density->files, &end, &digits);
    if (!at)
        used = snprintf(path, size, "%s", density->file);
    else
        used = snprintf(path, size, "%.*s%0*u%s", (int)(at - density->files), density->files, digits,
                        density->first_frame + index, end);
    return used >= 0 && (size_t)used < size;
}

/* A name with a number in it is one of a sequence. */
static al_status read_sequence(const node *place, const density_fields *f, al_scene_description *all,
                               al_density_description *out, al_error *error)
{
    static const char *const keys_of_sequences[] = {"first_frame", "frame_count", "frames_per_second"};
    char first[4096];
    const char *end;
    int digits;
    out->frame_count = 1;
    if (!f->file || !find_number(f->file, &end, &digits)) {
        for (size_t i = 0; i < sizeof keys_of_sequences / sizeof *keys_of_sequences; i++)
            if (has(place, keys_of_sequences[i]))
                return fail_at(place, error, "%s goes with a file name that has %%04d, or another number of digits, for "
                               "the frame's number", keys_of_sequences[i]);
        return AL_OK;
    }
    if (!has(place, "frame_count")) return need(place, "frame_count", "a sequence of files", error);
    out->files = out->file;
    out->first_frame = (uint32_t)f->first_frame;
    out->frame_count = (uint32_t)f->frame_count;
    out->frames_per_second = f->frames_per_second;
    if (!al_density_frame_file(out, 0, first, sizeof first)) return fail_at(place, error, "file is too long a name");
    out->file = copy_text(all, first);
    return out->file ? AL_OK : out_of_memory(place->from, error);
}

/* Coefficients are per metre and bounds lie along the world's axes: only grids that end where they end can turn, and
 * nothing grows. */
static al_status check_density_motion(const node *place, const al_density_description *density, al_error *error)
{
    bool may_turn = density->type == AL_DENSITY_GRID && !density->has_bounds;
    for (uint32_t i = 0; i < density->motion.count; i++)
        for (int k = 0; k < 3; k++) {
            const al_motion_key_description *key = &density->motion.keys[i];
            if (key->scale[k] != 1) return fail_at(place, error, "its motion changes its scale; a density only turns and moves");
            if (key->rotate_degrees[k] != 0 && !may_turn)
                return fail_at(place, error, "its motion turns it; only a grid without bounds of its own turns, others move");
        }
    if (density->motion.count && !may_turn && !density->has_bounds)
        return fail_at(place, error, "has no end and cannot move; give it bounds");
    return AL_OK;
}

static al_status read_density(const node *place, al_scene_description *all, al_density_description *out,
                              al_error *error)
{
    density_fields f = {.scale = 1, .unit_m = all->unit_m, .axis = {0, 1, 0}, .high = 1, .frames_per_second = 24};
    identity(out->grid_to_world);
    out->scale = 1;
    al_status status = place->value ? read_object(place, "density", &f, error) : AL_OK;
    if (status) return status;
    out->scale = f.scale;
    out->file = resolve(all, f.file);
    out->grid = copy_text(all, f.grid ? f.grid : "");
    out->files = copy_text(all, "");
    out->frame_count = 1;
    if (!out->file || !out->grid || !out->files) return out_of_memory(place->from, error);
    if (!place->value) return AL_OK;
    out->line = line_of(place->from, place->at);
    if (strcmp(f.type, "grid") == 0) {
        out->type = AL_DENSITY_GRID;
        status = allow_only(place, "type|scale|file|grid|first_frame|frame_count|frames_per_second|unit_m|transform|"
                            "motion|bounds_min_m|bounds_max_m", f.type, error);
        if (!status) status = read_grid(place, &f, out, error);
        if (!status) status = read_sequence(place, &f, all, out, error);
    } else if (strcmp(f.type, "layers") == 0) {
        out->type = AL_DENSITY_LAYERS;
        status = allow_only(
            place, "type|scale|axis|period_m|thickness_m|offset_m|low|high|motion|bounds_min_m|bounds_max_m", f.type,
            error);
        if (!status) status = read_layers(place, &f, out, error);
    } else {
        status = allow_only(place, "type|scale|motion|bounds_min_m|bounds_max_m", f.type, error);
    }
    if (!status) status = read_bounds(place, &f, out, error);
    if (!status) status = read_motion(&f.motion, all, &out->motion, error);
    return status ? status : check_density_motion(place, out, error);
}

/* Either sigma_s and sigma_a (which may come from a file's KHR_materials_volume), or as artists say it:
 * sigma_t = 1 / mean free path, sigma_s = albedo sigma_t, sigma_a = (1 - albedo) sigma_t. */
static al_status read_coefficients(const node *place, const medium_fields *f, al_medium_description *medium,
                                   al_error *error)
{
    bool sigmas = has(place, "sigma_s_per_m") || has(place, "sigma_a_per_m") || has(place, "absorption_from");
    bool artists = has(place, "albedo") || has(place, "mean_free_path_m");
    if (sigmas == artists)
        return fail_at(place, error,
                       "%s; give either sigma_s_per_m and sigma_a_per_m, or albedo and mean_free_path_m",
                       sigmas ? "is described twice" : "has no coefficients");
    if (artists && !(has(place, "albedo") && has(place, "mean_free_path_m")))
        return fail_at(place, error, "albedo and mean_free_path_m go together");
    if (has(place, "sigma_a_per_m") && has(place, "absorption_from"))
        return fail_at(place, error, "sigma_a_per_m and absorption_from exclude each other");
    double sum = 0;
    for (int i = 0; i < 3; i++) {
        medium->sigma_s_per_m[i] = artists ? f->albedo[i] / f->mean_free_path_m[i] : f->sigma_s_per_m[i];
        medium->sigma_a_per_m[i] =
            artists ? (1 - f->albedo[i]) / f->mean_free_path_m[i] : f->sigma_a_per_m[i];
        sum += medium->sigma_s_per_m[i] + medium->sigma_a_per_m[i];
    }
    if (sum == 0 && !has(place, "absorption_from"))
        return fail_at(place, error, "sigma_s_per_m and sigma_a_per_m are 0 everywhere: there is no medium");
    return AL_OK;
}

static al_status read_medium(const node *place, al_scene_description *out, al_medium_description *medium,
                             al_error *error)
{
    medium_fields f = {0};
    absorption_fields absorption = {0};
    al_status status = read_object(place, "medium", &f, error);
    if (!status) status = read_coefficients(place, &f, medium, error);
    if (!status && f.absorption_from.value)
        status = read_object(&f.absorption_from, "absorption", &absorption, error);
    if (status) return status;
    medium->line = line_of(place->from, place->at);
    medium->g = f.g;
    medium->optical_depth_order = (uint32_t)f.optical_depth_order;
    medium->name = copy_text(out, f.name);
    medium->absorption_mesh = copy_text(out, absorption.mesh ? absorption.mesh : "");
    medium->absorption_material = copy_text(out, absorption.material ? absorption.material : "");
    if (!medium->name || !medium->absorption_mesh || !medium->absorption_material)
        return out_of_memory(place->from, error);
    if (!f.density.value) f.density = (node){.from = place->from};
    return read_density(&f.density, out, &medium->density, error);
}

static al_status read_translucent(const node *place, al_scene_description *out,
                                  al_translucent_description *object, al_error *error)
{
    translucent_fields f = {0};
    al_status status = read_object(place, "translucent", &f, error);
    if (status) return status;
    object->line = line_of(place->from, place->at);
    object->name = text_or(out, f.name, "translucent", place->index);
    object->mesh = copy_text(out, f.mesh);
    object->medium = copy_text(out, f.medium);
    object->blocker_count = (uint32_t)list_size(&f.blockers);
    object->blockers = allocate(out, object->blocker_count, sizeof(char *));
    if (!object->name || !object->mesh || !object->medium || !object->blockers)
        return out_of_memory(place->from, error);
    for (uint32_t i = 0; i < object->blocker_count; i++) {
        object->blockers[i] = copy_text(out, json_string_value(json_array_get(f.blockers.value, i)));
        if (!object->blockers[i]) return out_of_memory(place->from, error);
    }
    return AL_OK;
}

static al_status read_environment(const node *place, al_scene_description *out, al_error *error)
{
    environment_fields f = {.scale = 1};
    al_environment_description *environment = &out->environment;
    al_status status = place->value ? read_object(place, "environment", &f, error) : AL_OK;
    if (status) return status;
    if (place->value && has(place, "file") == has(place, "radiance_w_m2_sr"))
        return fail_at(place, error, "give either \"file\" or \"radiance_w_m2_sr\"");
    environment->line = place->value ? line_of(place->from, place->at) : 0;
    environment->file = resolve(out, f.file);
    environment->scale = f.scale;
    environment->rotation_y_radians = f.rotation_degrees * (3.14159265358979323846 / 180);
    memcpy(environment->radiance, f.radiance_w_m2_sr, sizeof f.radiance_w_m2_sr);
    return environment->file ? AL_OK : out_of_memory(place->from, error);
}

al_bake_settings al_bake_settings_for(al_quality quality)
{
    static const al_bake_settings settings[] = {
        [AL_QUALITY_PREVIEW] = {128, 32, 5000, 0, 5, AL_COEFFICIENT_HALF, 0, AL_TOO_DENSE_REFUSE},
        [AL_QUALITY_MEDIUM] = {128, 64, 20000, 0, 5, AL_COEFFICIENT_HALF, 0, AL_TOO_DENSE_REFUSE},
        [AL_QUALITY_FINAL] = {512, 128, 50000, 0, 8, AL_COEFFICIENT_HALF, 0, AL_TOO_DENSE_REFUSE}};
    return settings[quality];
}

static al_status read_bake(const node *place, al_bake_settings *bake, al_error *error)
{
    bake_fields f = {bake->directions,
                     bake->grid_resolution,
                     bake->samples,
                     bake->radius_m,
                     bake->sh_order,
                     bake->seed,
                     NULL,
                     NULL};
    if (!place->value) return AL_OK;
    al_status status = read_object(place, "bake", &f, error);
    if (status) return status;
    if (has(place, "samples") && has(place, "radius_m"))
        return fail_at(place, error,
                       "samples and radius_m exclude each other: the count follows from the radius");
    if (fmod(f.directions, 2) != 0)
        return fail_at(place, error, "directions is %g; an even number is right", f.directions);
    bake->directions = (uint32_t)f.directions;
    bake->grid_resolution = (uint32_t)f.grid_resolution;
    bake->samples = has(place, "radius_m") ? 0 : (uint32_t)f.samples;
    bake->radius_m = f.radius_m;
    bake->sh_order = (uint32_t)f.sh_order;
    bake->seed = (uint32_t)f.seed;
    if (f.coefficient_format)
        bake->coefficient_format = *f.coefficient_format == 'f'   ? AL_COEFFICIENT_FLOAT
                                   : *f.coefficient_format == 'h' ? AL_COEFFICIENT_HALF
                                                                  : AL_COEFFICIENT_BYTE;
    if (f.too_dense) bake->too_dense = *f.too_dense == 'b' ? AL_TOO_DENSE_BAKE : AL_TOO_DENSE_REFUSE;
    return AL_OK;
}

al_lightmap_settings al_lightmap_settings_for(al_quality quality)
{
    static const uint32_t across[] = {128, 256, 512}, samples[] = {32, 128, 512}, bounces[] = {2, 4, 8};
    return (al_lightmap_settings){.texels_across = across[quality],
                                  .samples = samples[quality],
                                  .bounces = bounces[quality],
                                  .walls = AL_WALLS_BOUNDED,
                                  .fog_points = 16,
                                  .padding_texels = 2,
                                  .page_size = 2048};
}

static al_status read_lightmap(const node *place, al_lightmap_settings *out, al_error *error)
{
    lightmap_fields f = {.samples = out->samples,
                         .bounces = out->bounces,
                         .fog_points = out->fog_points,
                         .directional_order = out->directional_order,
                         .padding_texels = out->padding_texels,
                         .page_size = out->page_size};
    al_status status = place->value ? read_object(place, "lightmap", &f, error) : AL_OK;
    if (status) return status;
    if (f.back_scatter_shift_m > 0 && !f.back_scatter)
        return fail_at(place, error, "back_scatter_shift_m needs \"back_scatter\": true");
    out->texel_m = f.texel_m;
    out->samples = (uint32_t)f.samples;
    out->bounces = (uint32_t)f.bounces;
    out->fog_points = (uint32_t)f.fog_points;
    out->back_scatter = f.back_scatter;
    out->back_scatter_shift_m = f.back_scatter_shift_m;
    out->directional_order = (uint32_t)f.directional_order;
    out->padding_texels = (uint32_t)f.padding_texels;
    out->page_size = (uint32_t)f.page_size;
    out->seed = (uint32_t)f.seed;
    if (f.walls)
        out->walls = *f.walls == 'p'   ? AL_WALLS_PUBLISHED
                     : *f.walls == 'b' ? AL_WALLS_BOUNDED
                                       : AL_WALLS_TRACED;
    if (f.uv) out->uv = *f.uv == 'f' ? AL_UV_FILE : strcmp(f.uv, "atlas") == 0 ? AL_UV_ATLAS : AL_UV_AUTO;
    return AL_OK;
}

al_probe_settings al_probe_settings_for(al_quality quality)
{
    static const uint32_t samples[] = {256, 1024, 4096};
    return (al_probe_settings){.order = 3, .samples = samples[quality]};
}

static al_status read_probes(const node *place, al_scene_description *out, al_error *error)
{
    al_probe_settings *probes = &out->probes;
    probes_fields f = {.order = probes->order, .samples = probes->samples};
    al_status status = place->value ? read_object(place, "probes", &f, error) : AL_OK;
    if (status) return status;
    if (f.spacing_m > 0 && list_size(&f.points))
        return fail_at(place, error,
                       "spacing_m and points exclude each other: points are the probes' places");
    out->has_probes = place->value != NULL;
    probes->order = (uint32_t)f.order;
    probes->samples = (uint32_t)f.samples;
    probes->spacing_m = f.spacing_m;
    probes->point_count = (uint32_t)list_size(&f.points);
    probes->points = allocate(out, probes->point_count, sizeof *probes->points);
    if (!probes->points)
        return out_of_memory(place->from ? place->from : &(source){.path = out->path}, error);
    node element = {0};
    while (!status && next_element(&f.points, &element)) {
        point_fields point = {0};
        status = read_object(&element, "point", &point, error);
        memcpy(probes->points[element.index], point.position_m, sizeof point.position_m);
    }
    return status;
}

static al_status read_play(const node *place, al_play_settings *play, al_error *error)
{
    play_fields f = {0};
    if (!place->value) return AL_OK;
    al_status status = read_object(place, "play", &f, error);
    play->exposure_ev = (float)f.exposure_ev;
    to_floats(f.background, play->background);
    return status;
}

/* --- lists --- */

typedef al_status read_element_fn(const node *, al_scene_description *, void *, al_error *);

#define ELEMENT_READER(kind, type) \
    static al_status read_##kind##_element(const node *place, al_scene_description *out, void *element, \
                                           al_error *error) \
    { \
        return read_##kind(place, out, (type *)element, error); \
    }
ELEMENT_READER(mesh, al_mesh_description)
ELEMENT_READER(material, al_material)
ELEMENT_READER(light, al_light)
ELEMENT_READER(camera, al_camera)
ELEMENT_READER(medium, al_medium_description)
ELEMENT_READER(translucent, al_translucent_description)

/* Every element begins with its name. */
static al_status refuse_same_names(const node *list, const void *elements, size_t size, al_error *error)
{
    node element = {0};
    while (next_element(list, &element)) {
        const char *name = *(char *const *)((const char *)elements + element.index * size);
        for (size_t other = 0; other < element.index; other++)
            if (strcmp(name, *(char *const *)((const char *)elements + other * size)) == 0)
                return fail_at(&element, error, "the name \"%s\" is taken by element %zu; names must differ",
                               name, other);
    }
    return AL_OK;
}

static al_status read_list(const node *list, al_scene_description *out, size_t size, read_element_fn *read,
                           void *elements, uint32_t *count, al_error *error)
{
    size_t length = list_size(list);
    char *array = allocate(out, length, size);
    if (!array) return out_of_memory(list->from ? list->from : &(source){.path = out->path}, error);
    node element = {0};
    while (next_element(list, &element)) {
        al_status status = read(&element, out, array + element.index * size, error);
        if (status) return status;
    }
    memcpy(elements, &array, sizeof array);
    *count = (uint32_t)length;
    return refuse_same_names(list, array, size, error);
}

/* --- references between the parts --- */

static const al_mesh_description *find_mesh(const al_scene_description *out, const char *name)
{
    for (uint32_t i = 0; i < out->mesh_count; i++)
        if (strcmp(out->meshes[i].name, name) == 0) return &out->meshes[i];
    return NULL;
}

static uint32_t find_medium(const al_scene_description *out, const char *name)
{
    for (uint32_t i = 0; i < out->medium_count; i++)
        if (strcmp(out->media[i].name, name) == 0) return i;
    return AL_NO_INDEX;
}

static bool has_material(const al_scene_description *out, const char *name)
{
    for (uint32_t i = 0; i < out->material_count; i++)
        if (strcmp(out->materials[i].name, name) == 0) return true;
    return false;
}

/* A mesh is the boundary or a blocker of one object only: its triangles live in that object's space. */
static al_status take_mesh(const node *place, const al_scene_description *out, const char *name,
                           uint32_t *uses, al_error *error)
{
    const al_mesh_description *mesh = find_mesh(out, name);
    if (!mesh) return fail_at(place, error, "no mesh is named \"%s\"; name one of \"meshes\"", name);
    if (uses[mesh - out->meshes]++)
        return fail_at(place, error,
                       "mesh \"%s\" is already a boundary or blocker; give a second mesh with the same "
                       "file",
                       name);
    return AL_OK;
}

/* Boundaries only turn and move, and take their blockers along. */
static al_status check_motion(const node *place, const al_scene_description *out,
                              const al_translucent_description *object, al_error *error)
{
    const al_motion_description *motion = &find_mesh(out, object->mesh)->motion;
    for (uint32_t i = 0; i < motion->count; i++)
        for (int k = 0; k < 3; k++)
            if (motion->keys[i].scale[k] != 1)
                return fail_at(place, error, "its boundary \"%s\" changes its scale; translucent objects only turn and move",
                               object->mesh);
    for (uint32_t i = 0; i < object->blocker_count; i++)
        if (find_mesh(out, object->blockers[i])->motion.count)
            return fail_at(place, error, "blocker \"%s\" has a motion; it moves with its boundary", object->blockers[i]);
    return AL_OK;
}

static al_status check_translucents(const node *list, al_scene_description *out, al_error *error)
{
    uint32_t *uses = allocate(out, out->mesh_count, sizeof *uses);
    if (!uses) return out_of_memory(&(source){.path = out->path}, error);
    node place = {0};
    while (next_element(list, &place)) {
        const al_translucent_description *object = &out->translucents[place.index];
        al_status status = take_mesh(&place, out, object->mesh, uses, error);
        for (uint32_t i = 0; i < object->blocker_count && !status; i++)
            status = take_mesh(&place, out, object->blockers[i], uses, error);
        if (!status) status = check_motion(&place, out, object, error);
        uint32_t medium = find_medium(out, object->medium);
        if (!status && medium == AL_NO_INDEX)
            status =
                fail_at(&place, error, "no medium is named \"%s\"; name one of \"media\"", object->medium);
        if (!status && out->media[medium].density.motion.count)
            status = fail_at(&place, error, "the density of \"%s\" has a motion; a translucent object moves with its "
                             "boundary, by the motion of mesh \"%s\"", object->medium, object->mesh);
        if (status) return status;
    }
    return AL_OK;
}

static al_status read_fogs(const node *list, al_scene_description *out, al_error *error)
{
    out->fog_count = (uint32_t)list_size(list);
    out->fogs = allocate(out, out->fog_count, sizeof *out->fogs);
    if (!out->fogs) return out_of_memory(list->from ? list->from : &(source){.path = out->path}, error);
    for (uint32_t i = 0; i < out->fog_count; i++) {
        const char *name = json_string_value(json_array_get(list->value, i));
        out->fogs[i] = find_medium(out, name);
        if (out->fogs[i] == AL_NO_INDEX)
            return fail_at(list, error, "no medium is named \"%s\"; name one of \"media\"", name);
        for (uint32_t k = 0; k < i; k++)
            if (out->fogs[k] == out->fogs[i])
                return fail_at(list, error, "\"%s\" stands there twice; once is right", name);
        const al_density_description *density = &out->media[out->fogs[i]].density;
        if (density->type == AL_DENSITY_LAYERS && !density->has_bounds)
            return fail_at(list, error, "the layers of \"%s\" have no end; give its density bounds", name);
    }
    return AL_OK;
}

/* Objects and instances that a lightmap or probes would not reach. */
static al_status check_lighting(const node *list, const al_scene_description *out, al_error *error)
{
    node place = {0};
    while (next_element(list, &place)) {
        const al_mesh_description *mesh = &out->meshes[place.index];
        if (mesh->lighting == AL_LIGHTING_PROBES && !out->has_probes)
            return fail_at(&place, error, "is lit by probes; the scene needs \"probes\" for that");
        if (mesh->lighting == AL_LIGHTING_LIGHTMAP && mesh->motion.count)
            return fail_at(&place, error, "moves and cannot keep a lightmap; \"probes\" or \"dynamic\" is right");
        for (uint32_t i = 0; mesh->lighting != AL_LIGHTING_DYNAMIC && i < out->translucent_count; i++) {
            const al_translucent_description *object = &out->translucents[i];
            bool is_part = strcmp(object->mesh, mesh->name) == 0;
            for (uint32_t k = 0; k < object->blocker_count; k++)
                is_part = is_part || strcmp(object->blockers[k], mesh->name) == 0;
            if (is_part)
                return fail_at(&place, error,
                               "is part of translucent \"%s\", which no lightmap or probe lights",
                               object->name);
        }
    }
    return AL_OK;
}

static al_status check_references(const scene_fields *f, al_scene_description *out, al_error *error)
{
    node place = {0};
    while (next_element(&f->meshes, &place)) {
        const char *material = out->meshes[place.index].material;
        if (*material && !has_material(out, material))
            return fail_at(&place, error, "no material is named \"%s\"; name one of \"materials\"", material);
    }
    place = (node){0};
    while (next_element(&f->media, &place)) {
        const char *name = out->media[place.index].absorption_mesh;
        const al_mesh_description *mesh = *name ? find_mesh(out, name) : NULL;
        if (*name && !(mesh && *mesh->file))
            return fail_at(&place, error, "absorption_from: no mesh with a file is named \"%s\"", name);
    }
    al_status status = check_translucents(&f->translucents, out, error);
    return status ? status : check_lighting(&f->meshes, out, error);
}

static al_status read_scene(const node *root, al_scene_description *out, al_error *error)
{
    scene_fields f = {.unit_m = 1};
    al_status status = read_object(root, "scene", &f, error);
    if (status) return status;
    out->unit_m = f.unit_m;
#define READ_LIST(list, kind, elements, count) \
    if (!status) \
    status = read_list(&f.list, out, sizeof *out->elements, read_##kind##_element, &out->elements, \
                       &out->count, error)
    out->light_motions = allocate(out, list_size(&f.lights), sizeof *out->light_motions);
    out->camera_motions = allocate(out, list_size(&f.cameras), sizeof *out->camera_motions);
    if (!out->light_motions || !out->camera_motions) return out_of_memory(root->from, error);
    READ_LIST(materials, material, materials, material_count);
    READ_LIST(meshes, mesh, meshes, mesh_count);
    READ_LIST(lights, light, lights, light_count);
    READ_LIST(cameras, camera, cameras, camera_count);
    READ_LIST(media, medium, media, medium_count);
    READ_LIST(translucents, translucent, translucents, translucent_count);
#undef READ_LIST
    if (!status && out->light_count > LIGHT_LIMIT)
        status = fail_at(&f.lights, error, "there are %u lights; at most %d are right", out->light_count,
                         LIGHT_LIMIT);
    if (!status) status = read_environment(&f.environment, out, error);
    if (!status) status = read_fogs(&f.fogs, out, error);
    if (!status) status = read_lightmap(&f.lightmap, &out->lightmap, error);
    if (!status) status = read_probes(&f.probes, out, error);
    if (!status) status = read_bake(&f.bake, &out->bake, error);
    if (!status) status = read_play(&f.play, &out->play, error);
    return status ? status : check_references(&f, out, error);
}

/* --- the file --- */

static al_status read_text_file(const char *path, char **text, al_error *error)
{
    al_status status = AL_OK;
    char *bytes = NULL;
    FILE *file = fopen(path, "rb");
    if (!file) return al_fail_errno(error, path, "open the scene");
    size_t used = 0, room = 0;
    do {
        char *grown = used + 1 < room ? bytes : realloc(bytes, room = room ? room * 2 : 65536);
        if (!grown) {
            status = al_fail(error, AL_IO, "%s: out of memory while reading the scene", path);
            goto cleanup;
        }
        bytes = grown;
        used += fread(bytes + used, 1, room - 1 - used, file);
    } while (used + 1 == room && used <= TEXT_LIMIT);
    if (ferror(file))
        status = al_fail_errno(error, path, "read the scene");
    else if (used > TEXT_LIMIT)
        status = al_fail(error, AL_BAD_INPUT, "%s: larger than %d MiB; this is no scene file", path,
                         TEXT_LIMIT >> 20);
    bytes[used] = 0;
cleanup:
    fclose(file);
    if (status) free(bytes);
    *text = status ? NULL : bytes;
    return status;
}

static al_status index_lines(source *from, al_error *error)
{
    size_t count = 1;
    for (const char *at = from->text; (at = strchr(at, '\n')); at++) count++;
    from->line_starts = calloc(count, sizeof *from->line_starts);
    if (!from->line_starts) return out_of_memory(from, error);
    from->line_count = 1;
    for (const char *at = from->text; (at = strchr(at, '\n')); at++)
        from->line_starts[from->line_count++] = (size_t)(at + 1 - from->text);
    return AL_OK;
}

static al_status parse_json(const source *from, json_t **root, al_error *error)
{
    json_error_t where;
    *root = json_loads(from->text, JSON_REJECT_DUPLICATES, &where);
    if (*root) return AL_OK;
    flatten(where.text);
    return al_fail(error, AL_BAD_INPUT, "%s:%d: not valid JSON: %s", from->path, where.line, where.text);
}

static al_status start_description(const char *path, al_quality quality, al_scene_description **out,
                                   al_error *error)
{
    *out = calloc(1, sizeof **out);
    if (!*out) return al_fail(error, AL_IO, "%s: out of memory while reading the scene", path);
    const char *slash = strrchr(path, '/');
    (*out)->path = copy_text(*out, path);
    (*out)->folder = copy_text(*out, slash ? path : ".");
    if (!(*out)->path || !(*out)->folder) return al_fail(error, AL_IO, "%s: out of memory", path);
    if (slash) (*out)->folder[slash == path ? 1 : slash - path] = 0;
    (*out)->bake = al_bake_settings_for(quality);
    (*out)->lightmap = al_lightmap_settings_for(quality);
    (*out)->probes = al_probe_settings_for(quality);
    return AL_OK;
}

al_status al_scene_description_read(const char *path, al_quality quality, al_scene_description **description,
                                    al_error *error)
{
    source from = {.path = path};
    json_t *root = NULL;
    *description = NULL;
    al_status status = start_description(path, quality, &from.out, error);
    if (!status) status = read_text_file(path, &from.text, error);
    if (!status) status = index_lines(&from, error);
    if (!status) status = parse_json(&from, &root, error);
    if (!status) {
        node place = {.from = &from, .value = root, .at = skip_space(from.text)};
        status = read_scene(&place, from.out, error);
    }
    json_decref(root);
    free(from.line_starts);
    free(from.text);
    if (status)
        al_scene_description_free(from.out);
    else
        *description = from.out;
    return status;
}

void al_scene_description_free(al_scene_description *description)
{
    if (!description) return;
    for (block *at = description->storage, *next; at; at = next) {
        next = at->next;
        free(at);
    }
    free(description);
}
