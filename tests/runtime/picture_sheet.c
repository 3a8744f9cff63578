/* Pictures of one size side by side, for docs/: picture_sheet OUT.png BRIGHTNESS COLUMNS PICTURE.exr...
 * Linear values times the brightness are shown in sRGB, clamped. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/image.h"

enum { MARGIN = 4 };

static void draw(const al_image *image, float brightness, uint32_t left, uint32_t top, uint32_t stride, uint8_t *pixels)
{
    for (uint32_t y = 0; y < image->height; y++)
        for (uint32_t x = 0; x < image->width; x++)
            for (uint32_t c = 0; c < 3; c++)
                pixels[((size_t)(top + y) * stride + left + x) * 3 + c] = al_srgb_byte(
                    brightness *
                    image->pixels[((size_t)y * image->width + x) * image->channels + (image->channels < 3 ? 0 : c)]);
}

int main(int argc, char **argv)
{
    al_error error = {0};
    al_image image = {0};
    uint32_t width = 0, height = 0, columns = argc > 4 ? (uint32_t)atoi(argv[3]) : 0;
    uint8_t *pixels = NULL;
    if (columns == 0) {
        fprintf(stderr, "usage: picture_sheet OUT.png BRIGHTNESS COLUMNS PICTURE.exr...\n");
        return AL_USAGE;
    }
    uint32_t count = (uint32_t)argc - 4, stride = 0, rows = (count + columns - 1) / columns;
    al_status status = AL_OK;
    for (uint32_t i = 0; i < count && !status; i++) {
        status = al_image_read_exr(argv[4 + i], &image, &error);
        if (status) break;
        if (i == 0) {
            width = image.width;
            height = image.height;
            stride = columns * (width + MARGIN) - MARGIN;
            pixels = malloc((size_t)stride * rows * (height + MARGIN) * 3);
            if (pixels) memset(pixels, 255, (size_t)stride * rows * (height + MARGIN) * 3);
        }
        if (!pixels || image.width != width || image.height != height)
            status = al_fail(&error, AL_BAD_INPUT, "%s: not %u x %u as the first picture", argv[4 + i], width, height);
        else
            draw(&image, (float)atof(argv[2]), i % columns * (width + MARGIN), i / columns * (height + MARGIN), stride,
                 pixels);
        al_image_free(&image);
    }
    if (!status)
        status = al_image_write_png(argv[1], stride, rows * (height + MARGIN) - MARGIN, 3, pixels, &error);
    if (status) fprintf(stderr, "picture_sheet: %s\n", error.message);
    free(pixels);
    return (int)status;
}
