#define _POSIX_C_SOURCE 200809L
#include "airlight/image.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <openexr.h>
#include <png.h>

#include "airlight/container.h"

/* Larger pictures are refused: a damaged header must not ask for all memory. 16384 x 16384 pixels. */
#define PIXEL_LIMIT ((uint64_t)1 << 28)
/* Of width and height: a line's bytes must fit OpenEXR's 32-bit strides. */
#define EDGE_LIMIT ((int64_t)1 << 24)

/* A whole file in memory: what OpenEXR reads from or writes to. `error` collects its first message. */
typedef struct memory_stream {
    const char *path;
    uint8_t *bytes;
    size_t size, capacity;
    al_error *error;
    bool failed;
} memory_stream;

uint8_t al_srgb_byte(float linear)
{
    if (!(linear > 0)) return 0;
    if (linear >= 1) return 255;
    double encoded = linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
    return (uint8_t)(encoded * 255 + 0.5);
}

void al_image_free(al_image *image)
{
    if (!image) return;
    free(image->pixels);
    *image = (al_image){0};
}

static al_status read_whole_file(memory_stream *stream)
{
    FILE *file = fopen(stream->path, "rb");
    if (!file) return al_fail_errno(stream->error, stream->path, "open");
    al_status status = AL_OK;
    for (;;) {
        if (stream->size == stream->capacity) {
            size_t capacity = stream->capacity ? 2 * stream->capacity : 1 << 16;
            uint8_t *bytes = realloc(stream->bytes, capacity);
            if (!bytes) {
                status = al_fail(stream->error, AL_IO, "%s: out of memory", stream->path);
                goto cleanup;
            }
            stream->bytes = bytes;
            stream->capacity = capacity;
        }
        size_t count = fread(stream->bytes + stream->size, 1, stream->capacity - stream->size, file);
        stream->size += count;
        if (count == 0) break;
    }
    if (ferror(file)) status = al_fail_errno(stream->error, stream->path, "read");

cleanup:
    fclose(file);
    return status;
}

static int64_t stream_read(exr_const_context_t context, void *user, void *buffer, uint64_t size,
                           uint64_t offset, exr_stream_error_func_ptr_t on_error)
{
    (void)context, (void)on_error;
    memory_stream *stream = user;
    if (offset >= stream->size) return 0;
    uint64_t count = stream->size - offset < size ? stream->size - offset : size;
    memcpy(buffer, stream->bytes + offset, count);
    return (int64_t)count;
}

static int64_t stream_size(exr_const_context_t context, void *user)
{
    (void)context;
    return (int64_t)((memory_stream *)user)->size;
}

/* The chunk table is written last, at an offset that lies before the end: writes may overlap. */
static int64_t stream_write(exr_const_context_t context, void *user, const void *buffer, uint64_t size,
                            uint64_t offset, exr_stream_error_func_ptr_t on_error)
{
    memory_stream *stream = user;
    uint64_t end = offset + size;
    if (end > stream->capacity) {
        size_t capacity = end < SIZE_MAX / 2 ? 2 * end : end;
        uint8_t *bytes = realloc(stream->bytes, capacity);
        if (!bytes) {
            on_error(context, EXR_ERR_OUT_OF_MEMORY, "out of memory");
            return -1;
        }
        memset(bytes + stream->size, 0, capacity - stream->size);
        stream->bytes = bytes;
        stream->capacity = capacity;
    }
    memcpy(stream->bytes + offset, buffer, size);
    if (end > stream->size) stream->size = end;
    return (int64_t)size;
}

static void on_exr_error(exr_const_context_t context, exr_result_t code, const char *message)
{
    memory_stream *stream = NULL;
    if (exr_get_user_data(context, (void **)&stream) != EXR_ERR_SUCCESS || !stream || stream->failed) return;
    stream->failed = true;
    al_status status = code == EXR_ERR_OUT_OF_MEMORY ? AL_IO : AL_BAD_INPUT;
    size_t length = strcspn(message, "\n");
    al_fail(stream->error, status, "%s: not a readable OpenEXR file: %.*s", stream->path, (int)length,
            message);
}

/* The status of a failed OpenEXR call, with its message if no callback gave a better one. */
static al_status exr_failure(memory_stream *stream, exr_result_t code)
{
    if (!stream->failed)
        al_fail(stream->error, code == EXR_ERR_OUT_OF_MEMORY ? AL_IO : AL_BAD_INPUT,
                "%s: not a readable OpenEXR file: %s", stream->path, exr_get_default_error_message(code));
    stream->failed = true;
    return code == EXR_ERR_OUT_OF_MEMORY ? AL_IO : AL_BAD_INPUT;
}

static int channel_slot(const char *name, uint32_t channels)
{
    if (channels == 1) return strcmp(name, "Y") ? -1 : 0;
    const char *found = strlen(name) == 1 ? strchr("RGB", name[0]) : NULL;
    return found ? (int)(found - "RGB") : -1;
}

/* 3 when R, G and B are there, 1 when Y is, else 0. */
static uint32_t choose_channels(const exr_attr_chlist_t *list)
{
    uint32_t colors = 0, luminances = 0;
    for (int i = 0; i < list->num_channels; i++) {
        colors += channel_slot(list->entries[i].name.str, 3) >= 0;
        luminances += channel_slot(list->entries[i].name.str, 1) >= 0;
    }
    return colors == 3 ? 3 : luminances == 1 ? 1 : 0;
}

static al_status check_header(exr_context_t context, memory_stream *stream, al_image *image)
{
    exr_storage_t storage;
    exr_compression_t compression;
    exr_attr_box2i_t window;
    const exr_attr_chlist_t *list;
    exr_result_t code;
    if ((code = exr_get_storage(context, 0, &storage)) ||
        (code = exr_get_compression(context, 0, &compression)) ||
        (code = exr_get_data_window(context, 0, &window)) || (code = exr_get_channels(context, 0, &list)))
        return exr_failure(stream, code);
    if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED)
        return al_fail(stream->error, AL_BAD_INPUT, "%s: deep OpenEXR data is not read; flatten it",
                       stream->path);
    if (compression == EXR_COMPRESSION_DWAA || compression == EXR_COMPRESSION_DWAB)
        return al_fail(
            stream->error, AL_BAD_INPUT,
            "%s: DWA-compressed OpenEXR is not read here; save it with ZIP, PIZ, RLE or no compression",
            stream->path);
    image->channels = choose_channels(list);
    if (!image->channels)
        return al_fail(stream->error, AL_BAD_INPUT, "%s: has neither channels R, G, B nor channel Y",
                       stream->path);
    for (int i = 0; i < list->num_channels; i++) {
        const exr_attr_chlist_entry_t *entry = &list->entries[i];
        if (channel_slot(entry->name.str, image->channels) >= 0 &&
            (entry->x_sampling != 1 || entry->y_sampling != 1))
            return al_fail(stream->error, AL_BAD_INPUT,
                           "%s: channel %s is subsampled; save it at full resolution", stream->path,
                           entry->name.str);
    }
    int64_t width = (int64_t)window.max.x - window.min.x + 1,
            height = (int64_t)window.max.y - window.min.y + 1;
    if (width < 1 || height < 1 || width > EDGE_LIMIT || height > EDGE_LIMIT ||
        (uint64_t)(width * height) > PIXEL_LIMIT)
        return al_fail(stream->error, AL_BAD_INPUT, "%s: %lld x %lld pixels; at most 2^28 are read",
                       stream->path, (long long)width, (long long)height);
    image->width = (uint32_t)width;
    image->height = (uint32_t)height;
    return AL_OK;
}

/* Decodes one chunk to (x, y) of the image; the pipeline is made by the first call and reused. */
static exr_result_t decode_chunk(exr_context_t context, const exr_chunk_info_t *chunk, bool first,
                                 exr_decode_pipeline_t *pipeline, uint32_t x, uint32_t y, al_image *image)
{
    exr_result_t code = first ? exr_decoding_initialize(context, 0, chunk, pipeline)
                              : exr_decoding_update(context, 0, chunk, pipeline);
    if (code) return code;
    float *corner = image->pixels + ((size_t)y * image->width + x) * image->channels;
    for (int i = 0; i < pipeline->channel_count; i++) {
        exr_coding_channel_info_t *channel = &pipeline->channels[i];
        int slot = channel_slot(channel->channel_name, image->channels);
        channel->decode_to_ptr = slot < 0 ? NULL : (uint8_t *)(corner + slot);
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_bytes_per_element = sizeof(float);
        channel->user_pixel_stride = (int32_t)(image->channels * sizeof(float));
        channel->user_line_stride = (int32_t)(image->width * image->channels * sizeof(float));
    }
    if (first) code = exr_decoding_choose_default_routines(context, 0, pipeline);
    return code ? code : exr_decoding_run(context, 0, pipeline);
}

static exr_result_t decode_scanlines(exr_context_t context, exr_decode_pipeline_t *pipeline, al_image *image)
{
    exr_attr_box2i_t window;
    int32_t lines;
    exr_result_t code = exr_get_data_window(context, 0, &window);
    if (!code) code = exr_get_scanlines_per_chunk(context, 0, &lines);
    for (uint32_t y = 0; !code && y < image->height; y += (uint32_t)lines) {
        exr_chunk_info_t chunk;
        code = exr_read_scanline_chunk_info(context, 0, window.min.y + (int32_t)y, &chunk);
        if (!code) code = decode_chunk(context, &chunk, y == 0, pipeline, 0, y, image);
    }
    return code;
}

static exr_result_t decode_tiles(exr_context_t context, exr_decode_pipeline_t *pipeline, al_image *image)
{
    int32_t width, height;
    exr_result_t code = exr_get_tile_sizes(context, 0, 0, 0, &width, &height);
    for (uint32_t y = 0; !code && y < image->height; y += (uint32_t)height)
        for (uint32_t x = 0; !code && x < image->width; x += (uint32_t)width) {
            exr_chunk_info_t chunk;
            code = exr_read_tile_chunk_info(context, 0, (int)(x / (uint32_t)width),
                                            (int)(y / (uint32_t)height), 0, 0, &chunk);
            if (!code) code = decode_chunk(context, &chunk, x == 0 && y == 0, pipeline, x, y, image);
        }
    return code;
}

al_status al_image_read_exr(const char *path, al_image *image, al_error *error)
{
    memory_stream stream = {.path = path, .error = error};
    exr_context_t context = NULL;
    exr_decode_pipeline_t pipeline = EXR_DECODE_PIPELINE_INITIALIZER;
    exr_result_t code;
    *image = (al_image){0};
    al_status status = read_whole_file(&stream);
    if (status) goto cleanup;

    exr_context_initializer_t options = EXR_DEFAULT_CONTEXT_INITIALIZER;
    options.error_handler_fn = on_exr_error;
    options.user_data = &stream;
    options.read_fn = stream_read;
    options.size_fn = stream_size;
    options.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    code = exr_start_read(&context, path, &options);
    if (code) {
        status = exr_failure(&stream, code);
        goto cleanup;
    }
    status = check_header(context, &stream, image);
    if (status) goto cleanup;
    image->pixels = calloc((size_t)image->width * image->height * image->channels, sizeof(float));
    if (!image->pixels) {
        status =
            al_fail(error, AL_IO, "%s: out of memory for %u x %u pixels", path, image->width, image->height);
        goto cleanup;
    }
    exr_storage_t storage;
    code = exr_get_storage(context, 0, &storage);
    if (!code)
        code = storage == EXR_STORAGE_TILED ? decode_tiles(context, &pipeline, image)
                                            : decode_scanlines(context, &pipeline, image);
    if (code) status = exr_failure(&stream, code);

cleanup:
    if (context) {
        exr_decoding_destroy(context, &pipeline);
        exr_finish(&context);
    }
    free(stream.bytes);
    if (status) al_image_free(image);
    return status;
}

/* Channels stand in alphabetical order in the file. */
static exr_result_t add_channels(exr_context_t context, int part, const al_image_channels *image)
{
    exr_result_t code = EXR_ERR_SUCCESS;
    const char *last = "";
    for (uint32_t i = 0; !code && i < image->count; i++) {
        const char *next = NULL;
        for (uint32_t k = 0; k < image->count; k++)
            if (strcmp(image->names[k], last) > 0 && (!next || strcmp(image->names[k], next) < 0))
                next = image->names[k];
        if (!next) return EXR_ERR_INVALID_ARGUMENT; /* a name stands twice */
        code = exr_add_channel(context, part, next, EXR_PIXEL_FLOAT, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
        last = next;
    }
    return code;
}

static exr_result_t encode_header(exr_context_t context, const al_image_channels *image)
{
    int part;
    exr_result_t code = exr_add_part(context, "image", EXR_STORAGE_SCANLINE, &part);
    if (!code)
        code = exr_initialize_required_attr_simple(context, part, (int32_t)image->width,
                                                   (int32_t)image->height, EXR_COMPRESSION_ZIP);
    if (!code) code = add_channels(context, part, image);
    return code ? code : exr_write_header(context);
}

static uint32_t name_slot(const al_image_channels *image, const char *name)
{
    uint32_t slot = 0;
    while (slot + 1 < image->count && strcmp(image->names[slot], name)) slot++;
    return slot;
}

typedef exr_result_t (*compress_function)(exr_encode_pipeline_t *pipeline);

/* A chunk whose size is that of its pixels is read as pixels that are not compressed, but OpenEXR 3.1.5 leaves out
 * compression only where it makes a chunk larger. */
static exr_result_t compress(exr_encode_pipeline_t *pipeline)
{
    exr_result_t code = (*(const compress_function *)pipeline->encoding_user_data)(pipeline);
    if (!code && pipeline->compressed_bytes == pipeline->packed_bytes)
        memcpy(pipeline->compressed_buffer, pipeline->packed_buffer, pipeline->packed_bytes);
    return code;
}

static exr_result_t encode_pixels(exr_context_t context, const al_image_channels *image,
                                  exr_encode_pipeline_t *pipeline)
{
    int32_t lines;
    compress_function deflate;
    exr_result_t code = exr_get_scanlines_per_chunk(context, 0, &lines);
    for (uint32_t y = 0; !code && y < image->height; y += (uint32_t)lines) {
        exr_chunk_info_t chunk;
        code = exr_write_scanline_chunk_info(context, 0, (int)y, &chunk);
        if (code) break;
        code = y == 0 ? exr_encoding_initialize(context, 0, &chunk, pipeline)
                      : exr_encoding_update(context, 0, &chunk, pipeline);
        if (code) break;
        const float *corner = image->pixels + (size_t)y * image->width * image->count;
        for (int i = 0; i < pipeline->channel_count; i++) {
            exr_coding_channel_info_t *channel = &pipeline->channels[i];
            channel->encode_from_ptr = (const uint8_t *)(corner + name_slot(image, channel->channel_name));
            channel->user_data_type = EXR_PIXEL_FLOAT;
            channel->user_bytes_per_element = sizeof(float);
            channel->user_pixel_stride = (int32_t)(image->count * sizeof(float));
            channel->user_line_stride = (int32_t)(image->width * image->count * sizeof(float));
        }
        if (y == 0) {
            code = exr_encoding_choose_default_routines(context, 0, pipeline);
            deflate = pipeline->compress_fn;
            pipeline->compress_fn = compress;
            pipeline->encoding_user_data = &deflate;
        }
        if (!code) code = exr_encoding_run(context, 0, pipeline);
    }
    return code;
}

static bool is_writable_size(uint32_t width, uint32_t height)
{
    return width && height && width <= EDGE_LIMIT && height <= EDGE_LIMIT &&
           (uint64_t)width * height <= PIXEL_LIMIT;
}

al_status al_image_write_exr_channels(const char *path, const al_image_channels *image, al_error *error)
{
    if (!is_writable_size(image->width, image->height) || !image->count)
        return al_fail(error, AL_USAGE, "%s: cannot write %u x %u pixels of %u channels", path, image->width,
                       image->height, image->count);
    memory_stream stream = {.path = path, .error = error};
    exr_context_t context = NULL;
    exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_context_initializer_t options = EXR_DEFAULT_CONTEXT_INITIALIZER;
    options.error_handler_fn = on_exr_error;
    options.user_data = &stream;
    options.write_fn = stream_write;
    exr_result_t code = exr_start_write(&context, path, EXR_WRITE_FILE_DIRECTLY, &options);
    if (!code) code = encode_header(context, image);
    if (!code) code = encode_pixels(context, image, &pipeline);
    if (context) {
        exr_encoding_destroy(context, &pipeline);
        exr_result_t finished = exr_finish(&context);
        if (!code) code = finished;
    }
    al_status status;
    if (code)
        status =
            al_fail(error, AL_IO, "%s: cannot encode OpenEXR: %s", path, exr_get_default_error_message(code));
    else
        status = al_write_file(path, stream.bytes, stream.size, error);
    free(stream.bytes);
    return status;
}

al_status al_image_write_exr(const char *path, const al_image *image, al_error *error)
{
    static const char *const grey[] = {"Y"}, *const rgb[] = {"R", "G", "B"};
    const al_image_channels all = {image->width, image->height, image->channels,
                                   image->channels == 1 ? grey : rgb, image->pixels};
    if (image->channels != 1 && image->channels != 3)
        return al_fail(error, AL_USAGE, "%s: cannot write %u x %u pixels of %u channels", path, image->width,
                       image->height, image->channels);
    return al_image_write_exr_channels(path, &all, error);
}

al_status al_image_encode_png(const char *path, uint32_t width, uint32_t height, uint32_t channels,
                              const uint8_t *pixels, void **bytes, size_t *size, al_error *error)
{
    *bytes = NULL;
    *size = 0;
    if (!is_writable_size(width, height) || (channels != 1 && channels != 3 && channels != 4))
        return al_fail(error, AL_USAGE, "%s: cannot write %u x %u pixels of %u channels", path, width, height,
                       channels);
    png_image png = {.version = PNG_IMAGE_VERSION, .width = width, .height = height};
    png.format = channels == 1 ? PNG_FORMAT_GRAY : channels == 3 ? PNG_FORMAT_RGB : PNG_FORMAT_RGBA;
    png_alloc_size_t room = PNG_IMAGE_PNG_SIZE_MAX(png);
    *bytes = malloc(room);
    if (!*bytes) return al_fail(error, AL_IO, "%s: out of memory for %u x %u pixels", path, width, height);
    al_status status = AL_OK;
    if (png_image_write_to_memory(&png, *bytes, &room, 0, pixels, 0, NULL)) {
        *size = room;
    } else {
        status = al_fail(error, AL_IO, "%s: cannot encode PNG: %s", path, png.message);
        free(*bytes);
        *bytes = NULL;
    }
    png_image_free(&png);
    return status;
}

al_status al_image_write_png(const char *path, uint32_t width, uint32_t height, uint32_t channels,
                             const uint8_t *pixels, al_error *error)
{
    void *bytes;
    size_t size;
    al_status status = al_image_encode_png(path, width, height, channels, pixels, &bytes, &size, error);
    if (status == AL_OK) status = al_write_file(path, bytes, size, error);
    free(bytes);
    return status;
}
