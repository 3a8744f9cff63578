#include "picture.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_ONLY_HDR
#define STBI_NO_STDIO
#include <stb/stb_image.h>

static al_status measure(const char *name, const uint8_t *data, size_t size, const char *right,
                         al_error *error)
{
    int width, height, channels;
    if (size > INT_MAX || !stbi_info_from_memory(data, (int)size, &width, &height, &channels))
        return al_fail(error, AL_BAD_INPUT, "%s: cannot be read as a picture; %s is right", name, right);
    if (width < 1 || height < 1 || width > AL_PICTURE_EDGE_LIMIT || height > AL_PICTURE_EDGE_LIMIT)
        return al_fail(error, AL_BAD_INPUT, "%s: is %d x %d pixels; 1 to %d along each edge is right", name,
                       width, height, AL_PICTURE_EDGE_LIMIT);
    return AL_OK;
}

al_status al_picture_decode_bytes(const char *name, const uint8_t *data, size_t size, uint32_t *width,
                                  uint32_t *height, uint8_t **rgba, al_error *error)
{
    int w = 0, h = 0, channels;
    *rgba = NULL;
    al_status status = measure(name, data, size, "PNG or JPEG", error);
    if (status) return status;
    *rgba = stbi_load_from_memory(data, (int)size, &w, &h, &channels, 4);
    if (!*rgba) return al_fail(error, AL_BAD_INPUT, "%s: broken picture: %s", name, stbi_failure_reason());
    *width = (uint32_t)w;
    *height = (uint32_t)h;
    return AL_OK;
}

al_status al_picture_decode_hdr(const char *name, const uint8_t *data, size_t size, uint32_t *width,
                                uint32_t *height, float **rgb, al_error *error)
{
    int w = 0, h = 0, channels;
    *rgb = NULL;
    al_status status = measure(name, data, size, "Radiance .hdr", error);
    if (status) return status;
    if (!stbi_is_hdr_from_memory(data, (int)size))
        return al_fail(error, AL_BAD_INPUT, "%s: holds no radiance; Radiance .hdr or OpenEXR is right", name);
    *rgb = stbi_loadf_from_memory(data, (int)size, &w, &h, &channels, 3);
    if (!*rgb) return al_fail(error, AL_BAD_INPUT, "%s: broken picture: %s", name, stbi_failure_reason());
    *width = (uint32_t)w;
    *height = (uint32_t)h;
    return AL_OK;
}
