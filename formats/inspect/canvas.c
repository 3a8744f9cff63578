#include "canvas.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "airlight/image.h"

al_status canvas_create(int width, int height, canvas *made, al_error *error)
{
    *made = (canvas){width, height, malloc((size_t)width * height * 3 * sizeof *made->pixels)};
    if (!made->pixels)
        return al_fail(error, AL_IO, "out of memory for a picture of %d x %d pixels", width, height);
    for (size_t i = 0; i < (size_t)width * height * 3; i++) made->pixels[i] = 0.006f;
    return AL_OK;
}

void canvas_free(canvas *c)
{
    free(c->pixels);
    c->pixels = NULL;
}

al_status canvas_write(const canvas *c, const char *png_path, al_error *error)
{
    size_t count = (size_t)c->width * c->height * 3;
    uint8_t *bytes = malloc(count);
    if (!bytes) return al_fail(error, AL_IO, "%s: out of memory", png_path);
    for (size_t i = 0; i < count; i++) bytes[i] = al_srgb_byte(c->pixels[i]);
    al_status status = al_image_write_png(png_path, (uint32_t)c->width, (uint32_t)c->height, 3, bytes, error);
    free(bytes);
    return status;
}

panel canvas_panel(canvas *on, int column, int row, int edge)
{
    panel p = {on,
               CANVAS_MARGIN + column * (edge + CANVAS_MARGIN),
               CANVAS_MARGIN + row * (edge + CANVAS_MARGIN),
               edge,
               {0, 0},
               1};
    const float black[3] = {0, 0, 0};
    for (int y = 0; y < edge; y++)
        for (int x = 0; x < edge; x++) panel_set(&p, x, y, black);
    return p;
}

void panel_show(panel *p, const double low[2], const double high[2])
{
    p->half = 0;
    for (int i = 0; i < 2; i++) {
        p->middle[i] = 0.5 * (low[i] + high[i]);
        p->half = fmax(p->half, 0.525 * (high[i] - low[i]));
    }
    if (!(p->half > 0)) p->half = 1;
}

void panel_point(const panel *p, int x, int y, double point[2])
{
    point[0] = p->middle[0] + ((x + 0.5) / p->edge * 2 - 1) * p->half;
    point[1] = p->middle[1] - ((y + 0.5) / p->edge * 2 - 1) * p->half;
}

static void pixel_of(const panel *p, const double point[2], double pixel[2])
{
    pixel[0] = ((point[0] - p->middle[0]) / p->half * 0.5 + 0.5) * p->edge;
    pixel[1] = (0.5 - (point[1] - p->middle[1]) / p->half * 0.5) * p->edge;
}

static float *at(const panel *p, int x, int y)
{
    if (x < 0 || y < 0 || x >= p->edge || y >= p->edge) return NULL;
    return p->on->pixels + 3 * ((size_t)(p->top + y) * p->on->width + p->left + x);
}

void panel_set(const panel *p, int x, int y, const float rgb[3])
{
    float *pixel = at(p, x, y);
    for (int c = 0; pixel && c < 3; c++) pixel[c] = rgb[c];
}

/* The part of the line inside the panel, as shares of its length (Liang and Barsky 1984). */
static int clip(const panel *p, const double a[2], const double d[2], double *begin, double *end)
{
    *begin = 0;
    *end = 1;
    for (int i = 0; i < 2; i++) {
        double low = -a[i], high = p->edge - a[i];
        if (d[i] == 0) {
            if (low > 0 || high < 0) return 0;
            continue;
        }
        double first = low / d[i], second = high / d[i];
        *begin = fmax(*begin, fmin(first, second));
        *end = fmin(*end, fmax(first, second));
    }
    return *begin < *end;
}

void panel_line(const panel *p, const double from[2], const double to[2], const float rgb[3])
{
    double a[2], b[2], begin, end;
    pixel_of(p, from, a);
    pixel_of(p, to, b);
    double d[2] = {b[0] - a[0], b[1] - a[1]};
    if (!isfinite(d[0] + d[1]) || !clip(p, a, d, &begin, &end)) return;
    int steps = (int)ceil(fmax(fabs(d[0]), fabs(d[1])) * (end - begin)) + 1;
    for (int i = 0; i < steps; i++) {
        double t = begin + (end - begin) * (i + 0.5) / steps;
        float *pixel = at(p, (int)floor(a[0] + t * d[0]), (int)floor(a[1] + t * d[1]));
        for (int c = 0; pixel && c < 3; c++) pixel[c] += rgb[c] * (1 - pixel[c]);
    }
}

void panel_disc(const panel *p, const double middle[2], double radius_pixels, const float rgb[3])
{
    double m[2];
    pixel_of(p, middle, m);
    if (!(fabs(m[0]) < 1e6 && fabs(m[1]) < 1e6)) return;
    int reach = (int)ceil(radius_pixels), x0 = (int)floor(m[0]), y0 = (int)floor(m[1]);
    for (int y = y0 - reach; y <= y0 + reach; y++)
        for (int x = x0 - reach; x <= x0 + reach; x++)
            if (hypot(x + 0.5 - m[0], y + 0.5 - m[1]) <= radius_pixels) panel_set(p, x, y, rgb);
}

void heat_color(double value, float rgb[3])
{
    static const float knots[][3] = {{0.02f, 0.01f, 0.08f},
                                     {0.03f, 0.12f, 0.35f},
                                     {0.05f, 0.42f, 0.35f},
                                     {0.5f, 0.7f, 0.1f},
                                     {1, 0.95f, 0.55f}};
    enum { LAST = sizeof knots / sizeof *knots - 1 };
    double place = fmin(fmax(value, 0), 1) * LAST;
    int below = place < LAST ? (int)place : LAST - 1;
    for (int c = 0; c < 3; c++)
        rgb[c] = (float)(knots[below][c] + (place - below) * (knots[below + 1][c] - knots[below][c]));
}
