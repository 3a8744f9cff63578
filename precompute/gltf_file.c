#include "gltf_file.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "inputs.h"

enum { GLB_HEADER = 20, CHUNK_HEADER = 8, PATH_ROOM = 4096, COUNT_LIMIT = 1 << 28 };

typedef struct buffer {
    uint8_t *bytes; /* NULL: not read yet */
    size_t size;
} buffer;

struct al_gltf {
    al_import *import;
    const char *name;
    char folder[PATH_ROOM]; /* of the file, with its slash */
    json_t *root;
    bool is_glb;
    uint8_t *binary; /* the .glb's own buffer; NULL: it has none */
    size_t binary_size;
    buffer *buffers;
    size_t buffer_count;
};

static uint32_t little(const uint8_t *bytes)
{
    return bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

/* --- the file --- */

static al_status copy_binary(al_gltf *file, const uint8_t *bytes, size_t size, al_error *error)
{
    if (size < CHUNK_HEADER || memcmp(bytes + 4, "BIN", 4)) return AL_OK; /* "BIN" and a zero */
    size_t length = little(bytes);
    if (length > size - CHUNK_HEADER)
        return al_fail(error, AL_BAD_INPUT, "%s: is cut off in its binary chunk", file->name);
    file->binary = malloc(length + 1);
    if (!file->binary) return al_fail(error, AL_IO, "%s: out of memory", file->name);
    memcpy(file->binary, bytes + CHUNK_HEADER, length);
    file->binary_size = length;
    return AL_OK;
}

static al_status parse(al_gltf *file, const uint8_t *bytes, size_t size, al_error *error)
{
    const char *text = (const char *)bytes;
    size_t length = size;
    al_status status = AL_OK;
    if (size >= GLB_HEADER && memcmp(bytes, "glTF", 4) == 0) {
        file->is_glb = true;
        length = little(bytes + 12);
        if (length > size - GLB_HEADER) return al_fail(error, AL_BAD_INPUT, "%s: is not valid glTF 2.0", file->name);
        text += GLB_HEADER;
        status = copy_binary(file, bytes + GLB_HEADER + length, size - GLB_HEADER - length, error);
    }
    if (status) return status;
    file->root = json_loadb(text, length, 0, NULL);
    if (!file->root) return al_fail(error, AL_BAD_INPUT, "%s: is not valid glTF 2.0", file->name);
    file->buffer_count = json_array_size(json_object_get(file->root, "buffers"));
    file->buffers = calloc(file->buffer_count + 1, sizeof *file->buffers);
    return file->buffers ? AL_OK : al_fail(error, AL_IO, "%s: out of memory", file->name);
}

al_status al_gltf_open(al_import *import, const char *name, const char *path, const uint8_t *bytes, size_t size,
                       al_gltf **file, al_error *error)
{
    *file = NULL;
    al_gltf *made = calloc(1, sizeof *made);
    if (!made) return al_fail(error, AL_IO, "%s: out of memory", name);
    made->import = import;
    made->name = name;
    const char *slash = strrchr(path, '/');
    snprintf(made->folder, sizeof made->folder, "%.*s", slash ? (int)(slash - path) + 1 : 0, path);
    al_status status = parse(made, bytes, size, error);
    if (status)
        al_gltf_close(made);
    else
        *file = made;
    return status;
}

void al_gltf_close(al_gltf *file)
{
    if (!file) return;
    for (size_t i = 0; file->buffers && i < file->buffer_count; i++)
        if (file->buffers[i].bytes != file->binary) free(file->buffers[i].bytes);
    free(file->buffers);
    free(file->binary);
    json_decref(file->root);
    free(file);
}

const json_t *al_gltf_root(const al_gltf *file)
{
    return file->root;
}

const json_t *al_gltf_element(const al_gltf *file, const char *list, uint32_t index)
{
    return json_array_get(json_object_get(file->root, list), index);
}

uint32_t al_gltf_index(const json_t *object, const char *key)
{
    const json_t *value = json_object_get(object, key);
    json_int_t number = json_is_integer(value) ? json_integer_value(value) : -1;
    return number >= 0 && number < AL_NO_INDEX ? (uint32_t)number : AL_NO_INDEX;
}

/* --- the file as assimp gets it --- */

static bool remove_key(json_t *object, const char *key)
{
    return json_object_del(object, key) == 0;
}

static bool strip_primitive(json_t *primitive)
{
    static const char *const keys[] = {"JOINTS_0", "WEIGHTS_0", "JOINTS_1", "WEIGHTS_1"};
    bool any = remove_key(primitive, "targets");
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++)
        any = remove_key(json_object_get(primitive, "attributes"), keys[i]) || any;
    return any;
}

static bool strip(json_t *root)
{
    bool any = remove_key(root, "animations");
    any = remove_key(root, "skins") || any;
    json_t *list, *element;
    size_t i, k;
    json_array_foreach(json_object_get(root, "nodes"), i, element) any = remove_key(element, "skin") || any;
    json_array_foreach(json_object_get(root, "meshes"), i, list)
        json_array_foreach(json_object_get(list, "primitives"), k, element) any = strip_primitive(element) || any;
    return any;
}

static void put_little(uint8_t *bytes, size_t value)
{
    for (int i = 0; i < 4; i++) bytes[i] = (uint8_t)(value >> 8 * i);
}

/* A .glb again: header, JSON chunk filled up with blanks, binary chunk with zeros (glTF 2.0, section 4.4). */
static size_t pack_binary(const al_gltf *file, const char *text, uint8_t *out)
{
    size_t length = strlen(text), json = (length + 3) / 4 * 4, binary = (file->binary_size + 3) / 4 * 4;
    size_t size = GLB_HEADER + json + (file->binary ? CHUNK_HEADER + binary : 0);
    if (!out) return size;
    memcpy(out, "glTF\2\0\0", 8);
    put_little(out + 8, size);
    put_little(out + 12, json);
    memcpy(out + 16, "JSON", 4);
    memset(out + GLB_HEADER, ' ', json);
    memcpy(out + GLB_HEADER, text, length);
    if (!file->binary) return size;
    put_little(out + GLB_HEADER + json, binary);
    memcpy(out + GLB_HEADER + json + 4, "BIN", 4);
    memcpy(out + GLB_HEADER + json + CHUNK_HEADER, file->binary, file->binary_size);
    return size;
}

al_status al_gltf_without_motion(const al_gltf *file, uint8_t **bytes, size_t *size, al_error *error)
{
    *bytes = NULL;
    *size = 0;
    json_t *copy = json_deep_copy(file->root);
    bool any = copy && strip(copy);
    char *text = any ? json_dumps(copy, JSON_COMPACT | JSON_PRESERVE_ORDER) : NULL;
    size_t wanted = text ? (file->is_glb ? pack_binary(file, text, NULL) : strlen(text)) : 0;
    uint8_t *made = text ? calloc(wanted + 16, 1) : NULL;
    if (made && file->is_glb) pack_binary(file, text, made);
    if (made && !file->is_glb) memcpy(made, text, wanted);
    free(text);
    json_decref(copy);
    if (!copy || (any && !made)) return al_fail(error, AL_IO, "%s: out of memory", file->name);
    *bytes = made;
    *size = wanted;
    return AL_OK;
}

/* --- buffers --- */

static int base64_digit(char c)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const char *at = c ? strchr(digits, c) : NULL;
    return at ? (int)(at - digits) : -1;
}

/* RFC 4648, as far as the digits go; NULL without memory. */
static uint8_t *decode_base64(const char *text, size_t *size)
{
    uint8_t *bytes = malloc(strlen(text) / 4 * 3 + 4);
    uint32_t bits = 0;
    int held = 0;
    *size = 0;
    for (; bytes && base64_digit(*text) >= 0; text++) {
        bits = bits << 6 | (uint32_t)base64_digit(*text);
        held += 6;
        if (held < 8) continue;
        held -= 8;
        bytes[(*size)++] = (uint8_t)(bits >> held);
    }
    return bytes;
}

static int hex_digit(char c)
{
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

/* The folder and the name, whose %XX stand for bytes. */
static void path_of(const al_gltf *file, const char *uri, char path[PATH_ROOM])
{
    size_t at = strlen(file->folder);
    memcpy(path, file->folder, at);
    for (; *uri && at + 1 < PATH_ROOM; at++) {
        bool escaped = *uri == '%' && hex_digit(uri[1]) >= 0 && hex_digit(uri[2]) >= 0;
        path[at] = escaped ? (char)(16 * hex_digit(uri[1]) + hex_digit(uri[2])) : *uri;
        uri += escaped ? 3 : 1;
    }
    path[at] = 0;
}

static al_status read_buffer(al_gltf *file, uint32_t index, al_error *error)
{
    buffer *b = &file->buffers[index];
    const char *uri = json_string_value(json_object_get(al_gltf_element(file, "buffers", index), "uri"));
    if (b->bytes) return AL_OK;
    if (!uri && !index && file->binary) {
        *b = (buffer){file->binary, file->binary_size};
        return AL_OK;
    }
    if (!uri) return al_fail(error, AL_BAD_INPUT, "%s: buffer %u has no uri", file->name, index);
    if (strncmp(uri, "data:", 5)) {
        char path[PATH_ROOM];
        path_of(file, uri, path);
        return al_inputs_read(file->import, path, &b->bytes, &b->size, error);
    }
    const char *comma = strstr(uri, ";base64,");
    if (!comma) return al_fail(error, AL_BAD_INPUT, "%s: the data of buffer %u is not base64", file->name, index);
    b->bytes = decode_base64(comma + 8, &b->size);
    return b->bytes ? AL_OK : al_fail(error, AL_IO, "%s: out of memory for buffer %u", file->name, index);
}

/* `size` bytes from `offset` of a buffer view on; *stride is the view's own, or 0. */
static al_status view_bytes(al_gltf *file, uint32_t view, uint64_t offset, const uint8_t **bytes, uint64_t *room,
                            uint32_t *stride, const char *what, al_error *error)
{
    const json_t *v = al_gltf_element(file, "bufferViews", view);
    uint32_t index = al_gltf_index(v, "buffer"), begin = al_gltf_index(v, "byteOffset"),
             length = al_gltf_index(v, "byteLength");
    if (begin == AL_NO_INDEX) begin = 0;
    *stride = al_gltf_index(v, "byteStride");
    if (*stride == AL_NO_INDEX) *stride = 0;
    if (!v || index >= file->buffer_count || length == AL_NO_INDEX)
        return al_fail(error, AL_BAD_INPUT, "%s: %s: buffer view %u is not there or names no buffer", file->name, what,
                       view);
    al_status status = read_buffer(file, index, error);
    if (status) return status;
    if ((uint64_t)begin + length > file->buffers[index].size || offset > length)
        return al_fail(error, AL_BAD_INPUT, "%s: %s: buffer view %u ends behind its buffer of %zu bytes", file->name,
                       what, view, file->buffers[index].size);
    *bytes = file->buffers[index].bytes + begin + offset;
    *room = length - offset;
    return AL_OK;
}

/* --- accessors --- */

typedef struct component {
    uint32_t type, size;
    double unit; /* of a normalised one: its 1 */
    bool is_signed;
} component;

static const component components[] = {{5120, 1, 127, true},   {5121, 1, 255, false},        {5122, 2, 32767, true},
                                       {5123, 2, 65535, false}, {5125, 4, 4294967295.0, false}, {5126, 4, 1, true}};

static const component *find_component(uint32_t type)
{
    for (size_t i = 0; i < sizeof components / sizeof *components; i++)
        if (components[i].type == type) return &components[i];
    return NULL;
}

static uint32_t width_of(const char *type)
{
    static const struct {
        const char *type;
        uint32_t width;
    } known[] = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT4", 16}};
    for (size_t i = 0; type && i < sizeof known / sizeof *known; i++)
        if (!strcmp(type, known[i].type)) return known[i].width;
    return 0;
}

static double read_component(const uint8_t *bytes, const component *c, bool normalised)
{
    uint32_t raw = 0;
    float real;
    for (uint32_t i = 0; i < c->size; i++) raw |= (uint32_t)bytes[i] << 8 * i;
    if (c->type == 5126) {
        memcpy(&real, &raw, sizeof real);
        return real;
    }
    double number = raw;
    if (c->is_signed && raw >> (8 * c->size - 1)) number -= c->size == 1 ? 256 : 65536;
    return normalised ? fmax(number / c->unit, -1) : number; /* glTF 2.0, section 3.6.2.2 */
}

typedef struct shape { /* of an accessor's elements */
    const component *component;
    uint32_t width, count;
    bool normalised;
} shape;

/* `count` elements from a view to values[place ? place[i] : i]. */
static al_status read_elements(al_gltf *file, uint32_t view, uint64_t offset, const shape *s, uint32_t count,
                               const float *place, const char *what, float *values, al_error *error)
{
    const uint8_t *bytes = NULL;
    uint64_t room = 0, size = (uint64_t)s->component->size * s->width;
    uint32_t stride = 0;
    al_status status = view_bytes(file, view, offset, &bytes, &room, &stride, what, error);
    if (status) return status;
    if (!stride) stride = (uint32_t)size;
    if (count && (uint64_t)(count - 1) * stride + size > room)
        return al_fail(error, AL_BAD_INPUT, "%s: %s: %u elements do not fit buffer view %u", file->name, what, count,
                       view);
    for (uint32_t i = 0; i < count; i++) {
        if (place && !(place[i] >= 0 && place[i] < s->count))
            return al_fail(error, AL_BAD_INPUT, "%s: %s: its sparse part names element %g of %u", file->name, what,
                           (double)place[i], s->count);
        float *to = values + (place ? (size_t)place[i] : i) * s->width;
        for (uint32_t k = 0; k < s->width; k++)
            to[k] = (float)read_component(bytes + (uint64_t)i * stride + k * s->component->size, s->component,
                                          s->normalised);
    }
    return AL_OK;
}

static uint32_t offset_of(const json_t *object)
{
    uint32_t offset = al_gltf_index(object, "byteOffset");
    return offset == AL_NO_INDEX ? 0 : offset;
}

/* Element numbers go through floats: exact up to 2^24, which the count is held to. */
static al_status read_sparse(al_gltf *file, const json_t *sparse, const shape *s, const char *what, float *values,
                             al_error *error)
{
    const json_t *indices = json_object_get(sparse, "indices"), *from = json_object_get(sparse, "values");
    uint32_t count = al_gltf_index(sparse, "count");
    const shape place = {find_component(al_gltf_index(indices, "componentType")), 1, s->count, false};
    if (!place.component || count > s->count || s->count > 1u << 24)
        return al_fail(error, AL_BAD_INPUT, "%s: %s: its sparse part is not valid", file->name, what);
    float *places = calloc(count + (size_t)1, sizeof *places);
    if (!places) return al_fail(error, AL_IO, "%s: out of memory", file->name);
    al_status status = read_elements(file, al_gltf_index(indices, "bufferView"), offset_of(indices), &place, count,
                                     NULL, what, places, error);
    if (!status)
        status = read_elements(file, al_gltf_index(from, "bufferView"), offset_of(from), s, count, places, what,
                               values, error);
    free(places);
    return status;
}

al_status al_gltf_numbers(al_gltf *file, uint32_t accessor, uint32_t width, const char *what, float **values,
                          uint32_t *count, al_error *error)
{
    const json_t *a = al_gltf_element(file, "accessors", accessor), *sparse = json_object_get(a, "sparse");
    shape s = {find_component(al_gltf_index(a, "componentType")),
               width_of(json_string_value(json_object_get(a, "type"))), al_gltf_index(a, "count"),
               json_is_true(json_object_get(a, "normalized"))};
    *values = NULL;
    *count = 0;
    if (!s.component || !s.width || s.count > COUNT_LIMIT || (width && s.width != width))
        return al_fail(error, AL_BAD_INPUT, "%s: %s: accessor %" PRId64 " is not there or has not %u numbers each",
                       file->name, what, accessor == AL_NO_INDEX ? -1 : (int64_t)accessor, width);
    float *made = calloc((size_t)s.count * s.width + 1, sizeof *made);
    if (!made) return al_fail(error, AL_IO, "%s: out of memory", file->name);
    al_status status = AL_OK;
    if (json_object_get(a, "bufferView"))
        status = read_elements(file, al_gltf_index(a, "bufferView"), offset_of(a), &s, s.count, NULL, what, made, error);
    if (!status && sparse) status = read_sparse(file, sparse, &s, what, made, error);
    for (size_t i = 0; !status && i < (size_t)s.count * s.width; i++)
        if (!isfinite(made[i]))
            status = al_fail(error, AL_BAD_INPUT, "%s: %s: number %zu is %g; finite numbers are right", file->name,
                             what, i, (double)made[i]);
    if (status) {
        free(made);
        return status;
    }
    *values = made;
    *count = s.count;
    return AL_OK;
}
