/* Draws tables of light at points as a picture of panels, side by side in rows: the figures of
 * docs/accuracy.md. usage: light_figure OUT.png WIDTH COLUMNS PANEL.csv:BRIGHTNESS... A table holds lines of
 * x,y,z,nx,ny,nz,r,g,b with WIDTH points a line of the panel, first line on top; other lines are left out.
 * Linear values times the brightness are shown in sRGB, clamped. */
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/image.h"

enum { POINT_PIXELS = 4, MARGIN = 4, ROW_LIMIT = 4096 };

typedef struct panel {
    uint32_t count;
    float rgb[ROW_LIMIT][3];
} panel;

/* "FILE.csv:BRIGHTNESS" */
static bool read_panel(const char *argument, panel *out)
{
    char path[1024], line[1024];
    const char *colon = strrchr(argument, ':');
    if (!colon || colon - argument >= (ptrdiff_t)sizeof path) return false;
    memcpy(path, argument, (size_t)(colon - argument));
    path[colon - argument] = 0;
    double brightness = atof(colon + 1), v[3];
    FILE *file = fopen(path, "r");
    if (!file) return false;
    out->count = 0;
    while (fgets(line, sizeof line, file) && out->count < ROW_LIMIT)
        if (sscanf(line, "%*f,%*f,%*f,%*f,%*f,%*f,%lf,%lf,%lf", v, v + 1, v + 2) == 3) {
            for (int c = 0; c < 3; c++) out->rgb[out->count][c] = (float)(brightness * v[c]);
            out->count++;
        }
    fclose(file);
    return out->count > 0;
}

static void draw(const panel *p, uint32_t width, uint32_t left, uint32_t top, uint32_t stride,
                 uint8_t *pixels)
{
    for (uint32_t y = 0; y < p->count / width * POINT_PIXELS; y++)
        for (uint32_t x = 0; x < width * POINT_PIXELS; x++)
            for (uint32_t c = 0; c < 3; c++)
                pixels[((size_t)(top + y) * stride + left + x) * 3 + c] =
                    al_srgb_byte(p->rgb[y / POINT_PIXELS * width + x / POINT_PIXELS][c]);
}

int main(int argc, char **argv)
{
    static panel p;
    al_error error = {0};
    uint32_t width = argc > 4 ? (uint32_t)atoi(argv[2]) : 0, columns = argc > 4 ? (uint32_t)atoi(argv[3]) : 0;
    if (width == 0 || columns == 0 || !read_panel(argv[4], &p) || p.count % width) {
        fprintf(stderr,
                "usage: light_figure OUT.png WIDTH COLUMNS PANEL.csv:BRIGHTNESS..., panels of whole lines\n");
        return AL_USAGE;
    }
    uint32_t count = p.count, panels = (uint32_t)argc - 4, rows = (panels + columns - 1) / columns;
    uint32_t step_x = width * POINT_PIXELS + MARGIN, step_y = count / width * POINT_PIXELS + MARGIN;
    uint32_t stride = columns * step_x - MARGIN, height = rows * step_y - MARGIN;
    uint8_t *pixels = malloc((size_t)stride * height * 3);
    if (!pixels) return AL_IO;
    memset(pixels, 255, (size_t)stride * height * 3);
    for (uint32_t i = 0; i < panels; i++) {
        if (!read_panel(argv[4 + i], &p) || p.count != count) {
            fprintf(stderr, "light_figure: %s: not %u points and a brightness\n", argv[4 + i], count);
            free(pixels);
            return AL_BAD_INPUT;
        }
        draw(&p, width, i % columns * step_x, i / columns * step_y, stride, pixels);
    }
    al_status status = al_image_write_png(argv[1], stride, height, 3, pixels, &error);
    if (status) fprintf(stderr, "light_figure: %s\n", error.message);
    free(pixels);
    return (int)status;
}
