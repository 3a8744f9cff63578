#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/container.h"
#include "airlight/image.h"
#include "front.h"
#include "measure.h"
#include "results.h"

/* --- text --- */

static void write_text(FILE *out, const char *text)
{
    for (; *text; text++) {
        const char *name = *text == '&' ? "&amp;" : *text == '<' ? "&lt;" : *text == '>' ? "&gt;" : *text == '"' ? "&quot;" : NULL;
        if (name)
            fputs(name, out);
        else
            fputc(*text, out);
    }
}

static void write_base64(FILE *out, const uint8_t *bytes, size_t size)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size; i += 3) {
        size_t left = size - i;
        uint32_t v = (uint32_t)bytes[i] << 16 | (left > 1 ? (uint32_t)bytes[i + 1] << 8 : 0) | (left > 2 ? bytes[i + 2] : 0);
        fputc(digits[v >> 18], out);
        fputc(digits[v >> 12 & 63], out);
        fputc(left > 1 ? digits[v >> 6 & 63] : '=', out);
        fputc(left > 2 ? digits[v & 63] : '=', out);
    }
}

/* --- diagrams: the error over one cost, both logarithmic --- */

typedef struct axis {
    double low, high; /* logarithms to base 10 */
} axis;

typedef struct cost {
    const char *title;
    double unit;
    size_t offset; /* of the double in al_point */
} cost;

static const cost costs[] = {
    {"frame time, ms", 1, offsetof(al_point, frame_ms)},
    {"seconds to bake", 1, offsetof(al_point, seconds)},
    {"memory of the player, MB", 1e-6, offsetof(al_point, memory_bytes)},
    {"baked files, MB", 1e-6, offsetof(al_point, asset_bytes)},
};

enum { WIDTH = 560, HEIGHT = 360, LEFT = 58, RIGHT = 16, TOP = 30, BOTTOM = 44 };

static double cost_of(const al_point *point, const cost *c)
{
    double value;
    memcpy(&value, (const char *)point + c->offset, sizeof value);
    return log10(fmax(value * c->unit, 1e-9));
}

static double error_of(const al_point *point)
{
    return log10(fmax(100 * point->relative_rmse, 1e-6));
}

static void widen(axis *a, double value)
{
    a->low = fmin(a->low, value);
    a->high = fmax(a->high, value);
}

static void finish_axis(axis *a)
{
    double margin = fmax(0.06 * (a->high - a->low), 0.02);
    a->low -= margin;
    a->high += margin;
}

static double across(const axis *a, double value)
{
    return LEFT + (WIDTH - LEFT - RIGHT) * (value - a->low) / (a->high - a->low);
}

static double up(const axis *a, double value)
{
    return HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * (value - a->low) / (a->high - a->low);
}

/* At 1, 2 and 5 times powers of ten; evenly spaced where those are fewer than three. */
static int ticks(const axis *a, double values[16])
{
    static const double steps[] = {1, 2, 5};
    int count = 0;
    for (int decade = (int)floor(a->low); decade <= a->high; decade++)
        for (int i = 0; i < 3 && count < 16; i++) {
            double value = steps[i] * pow(10, decade);
            if (log10(value) >= a->low && log10(value) <= a->high) values[count++] = value;
        }
    if (count >= 3) return count;
    for (count = 0; count < 4; count++) values[count] = pow(10, a->low + (a->high - a->low) * (0.5 + count) / 4);
    return count;
}

static void write_axes(FILE *out, const axis *x, const axis *y, const char *title)
{
    double values[16];
    int count = ticks(x, values);
    for (int i = 0; i < count; i++)
        fprintf(out, "<path d=\"M%.1f %dV%d\" stroke=\"#ddd\"/><text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">%.3g</text>\n",
                across(x, log10(values[i])), TOP, HEIGHT - BOTTOM, across(x, log10(values[i])), HEIGHT - BOTTOM + 16, values[i]);
    count = ticks(y, values);
    for (int i = 0; i < count; i++)
        fprintf(out, "<path d=\"M%d %.1fH%d\" stroke=\"#ddd\"/><text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">%.3g</text>\n", LEFT,
                up(y, log10(values[i])), WIDTH - RIGHT, LEFT - 6, up(y, log10(values[i])) + 4, values[i]);
    fprintf(out, "<text x=\"%d\" y=\"%d\" text-anchor=\"middle\">%s</text>\n", (LEFT + WIDTH - RIGHT) / 2, HEIGHT - 8, title);
    fprintf(out, "<text x=\"%d\" y=\"%d\">relative error, %%</text>\n", 6, TOP - 12);
}

/* Along the front, from the fastest point on: a staircase, since nothing is known between two points. */
static void write_front(FILE *out, const al_points *points, const axis *x, const axis *y, const cost *c)
{
    const char *move = "M";
    double last = -INFINITY;
    fputs("<path fill=\"none\" stroke=\"#1f4e9c\" stroke-width=\"1.6\" d=\"", out);
    for (;;) {
        const al_point *next = NULL;
        for (int i = 0; i < points->count; i++) {
            const al_point *p = &points->points[i];
            if (p->front && cost_of(p, c) > last && (!next || cost_of(p, c) < cost_of(next, c))) next = p;
        }
        if (!next) break;
        last = cost_of(next, c);
        if (*move == 'M')
            fprintf(out, "M%.1f %.1f", across(x, last), up(y, error_of(next)));
        else
            fprintf(out, "H%.1fV%.1f", across(x, last), up(y, error_of(next)));
        move = "H";
    }
    fputs("\"/>\n", out);
}

static void write_diagram(FILE *out, const al_trade *trade, const cost *c)
{
    const al_points *points = &trade->points;
    axis x = {INFINITY, -INFINITY}, y = {INFINITY, -INFINITY};
    for (int i = 0; i < points->count; i++) {
        if (points->points[i].left_out) continue;
        widen(&x, cost_of(&points->points[i], c));
        widen(&y, error_of(&points->points[i]));
    }
    finish_axis(&x);
    finish_axis(&y);
    fprintf(out, "<svg width=\"%d\" height=\"%d\" viewBox=\"0 0 %d %d\">\n", WIDTH, HEIGHT, WIDTH, HEIGHT);
    write_axes(out, &x, &y, c->title);
    if (c == costs) write_front(out, points, &x, &y, c);
    for (int i = 0; i < points->count; i++) {
        const al_point *p = &points->points[i];
        char text[512];
        if (p->left_out) continue;
        double px = across(&x, cost_of(p, c)), py = up(&y, error_of(p));
        al_point_describe(trade, p, text, sizeof text);
        fprintf(out, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%s\" fill=\"%s\"><title>", px, py, p->front ? "4.5" : "3",
                p->front ? "#1f4e9c" : "#aaa");
        write_text(out, text);
        fputs("</title></circle>\n", out);
        if (*p->preset)
            fprintf(out, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"8\" fill=\"none\" stroke=\"#c0392b\"/>"
                         "<text x=\"%.1f\" y=\"%.1f\" fill=\"#c0392b\" text-anchor=\"%s\">%s</text>\n",
                    px, py, px > WIDTH - 90 ? px - 11 : px + 11, py - 7, px > WIDTH - 90 ? "end" : "start", p->preset);
    }
    fputs("</svg>\n", out);
}

/* --- pictures --- */

static al_status write_file_inside(FILE *out, const char *path, al_error *error)
{
    uint8_t bytes[3 * 4096];
    size_t size;
    FILE *in = fopen(path, "rb");
    if (!in) return al_fail_errno(error, path, "read");
    fputs("<img src=\"data:image/png;base64,", out);
    while ((size = fread(bytes, 1, sizeof bytes, in)) > 0) write_base64(out, bytes, size);
    fputs("\"/>", out);
    fclose(in);
    return AL_OK;
}

/* Exposed and clamped, sRGB. */
static al_status write_picture(FILE *out, const char *path, float exposure_ev, al_error *error)
{
    al_image image = {0};
    void *png = NULL;
    size_t size = 0;
    al_status status = al_image_read_exr(path, &image, error);
    if (status) return status;
    size_t count = (size_t)image.width * image.height * image.channels;
    uint8_t *pixels = malloc(count);
    if (!pixels) status = al_fail(error, AL_IO, "%s: out of memory", path);
    for (size_t i = 0; i < count && !status; i++) pixels[i] = al_srgb_byte(image.pixels[i] * exp2f(exposure_ev));
    if (!status) status = al_image_encode_png(path, image.width, image.height, image.channels, pixels, &png, &size, error);
    if (!status) {
        fputs("<img src=\"data:image/png;base64,", out);
        write_base64(out, png, size);
        fputs("\"/>", out);
    }
    free(png);
    free(pixels);
    al_image_free(&image);
    return status;
}

static al_status write_point(FILE *out, const al_trade *trade, const char *role, const al_point *p, al_error *error)
{
    char text[512], path[PATH_MAX];
    al_point_describe(trade, p, text, sizeof text);
    fprintf(out, "<figure><figcaption><b>%s</b>: %.1f %%, %.0f ms a frame, %.1f s to bake", role, 100 * p->relative_rmse,
            p->frame_ms, p->seconds);
    if (isfinite(p->held_out_relative_rmse)) fprintf(out, "; held-out view %.1f %%", 100 * p->held_out_relative_rmse);
    fputs("<br/>", out);
    write_text(out, text);
    fputs("</figcaption>", out);
    snprintf(path, sizeof path, "%.*s/points/%s.exr", PATH_MAX - 128, trade->folder, p->picture);
    al_status status = write_picture(out, path, trade->exposure_ev, error);
    snprintf(path, sizeof path, "%.*s/points/%s.difference.png", PATH_MAX - 128, trade->folder, p->picture);
    if (!status) status = write_file_inside(out, path, error);
    fputs("</figure>\n", out);
    return status;
}

static al_status write_pictures(FILE *out, const al_trade *trade, const char *truth, al_error *error)
{
    double errors[AL_POINT_LIMIT], times[AL_POINT_LIMIT];
    bool front[AL_POINT_LIMIT];
    size_t count = (size_t)trade->points.count, cheapest = SIZE_MAX, best = SIZE_MAX;
    const al_point *points = trade->points.points;
    for (size_t i = 0; i < count; i++) {
        errors[i] = points[i].relative_rmse;
        times[i] = points[i].frame_ms;
        front[i] = points[i].front;
        if (!front[i]) continue;
        if (cheapest == SIZE_MAX || times[i] < times[cheapest]) cheapest = i;
        if (best == SIZE_MAX || errors[i] < errors[best]) best = i;
    }
    if (cheapest == SIZE_MAX) return AL_OK;
    size_t knee = al_front_knee(errors, times, front, count);
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%.*s.exr", PATH_MAX - 8, truth);
    fputs("<h2>Pictures</h2><p>Each with its HDR-FLIP difference from the reference: black none, blue, red, yellow, white 1."
          "</p>\n<figure><figcaption><b>reference</b></figcaption>", out);
    al_status status = write_picture(out, path, trade->exposure_ev, error);
    fputs("</figure>\n", out);
    if (!status) status = write_point(out, trade, "cheapest", &points[cheapest], error);
    if (!status && knee != cheapest && knee != best) status = write_point(out, trade, "knee", &points[knee], error);
    if (!status && best != cheapest) status = write_point(out, trade, "most exact", &points[best], error);
    return status;
}

/* --- the whole page --- */

static void write_front_table(FILE *out, const al_trade *trade)
{
    fputs("<h2>The front</h2><table><tr><th>settings, where they differ from medium</th><th>error</th><th>held-out view</th>"
          "<th>ms a frame</th><th>s to bake</th><th>MB held</th><th>MB of files</th></tr>\n", out);
    double last = -INFINITY;
    for (;;) {
        const al_point *p = NULL;
        for (int i = 0; i < trade->points.count; i++) {
            const al_point *q = &trade->points.points[i];
            if (q->front && q->frame_ms > last && (!p || q->frame_ms < p->frame_ms)) p = q;
        }
        if (!p) break;
        last = p->frame_ms;
        char text[512];
        al_point_describe(trade, p, text, sizeof text);
        fputs("<tr><td>", out);
        write_text(out, text);
        fprintf(out, "</td><td>%.2f %%</td><td>%.2f %%</td><td>%.1f</td><td>%.1f</td><td>%.1f</td><td>%.1f</td></tr>\n",
                100 * p->relative_rmse, 100 * p->held_out_relative_rmse, p->frame_ms, p->seconds, p->memory_bytes * 1e-6,
                p->asset_bytes * 1e-6);
    }
    fputs("</table>\n", out);
}

static void write_limit(FILE *out, int limit)
{
    if (limit < 0)
        fputs("any number of", out);
    else
        fprintf(out, "at most %d", limit);
}

static void write_head(FILE *out, const al_trade *trade)
{
    fputs("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/><title>Error against cost</title>\n<style>"
          "body{font:14px sans-serif;max-width:1180px;margin:24px auto;padding:0 12px}svg{font-size:11px}"
          "table{border-collapse:collapse}td,th{border:1px solid #ccc;padding:3px 8px;text-align:left}"
          "figure{display:inline-block;margin:8px 16px 8px 0;vertical-align:bottom;max-width:480px}img{margin:4px 4px 0 0}"
          "</style></head><body>\n<h1>Error against cost: ", out);
    write_text(out, trade->scene);
    fprintf(out, "</h1>\n<p>Pictures of %dx%d pixels from camera \"", trade->size[0], trade->size[1]);
    write_text(out, trade->cameras[0]);
    fprintf(out, "\", the mean of %d frames, without the shading of translucent surfaces, against a path-traced one of %d samples a "
                 "pixel with ", trade->frames, trade->spp);
    write_limit(out, trade->max_events);
    fputs(" scattering events and ", out);
    write_limit(out, trade->max_bounces);
    fputs(" reflections on a path; its noise is taken out of the error. Held out: camera \"", out);
    write_text(out, trade->cameras[1]);
    fputs("\". Blue: no other point is both faster and more exact. Red: presets. Point at a dot to read its settings.</p>\n", out);
}

al_status al_results_page(const al_trade *trade, const char *truth, al_error *error)
{
    char path[PATH_MAX], *text = NULL;
    size_t size = 0;
    snprintf(path, sizeof path, "%s/trade.html", trade->folder);
    FILE *out = open_memstream(&text, &size);
    if (!out) return al_fail(error, AL_IO, "%s: out of memory", path);
    write_head(out, trade);
    for (size_t i = 0; i < sizeof costs / sizeof *costs; i++) write_diagram(out, trade, &costs[i]);
    write_front_table(out, trade);
    al_status status = write_pictures(out, trade, truth, error);
    fputs("</body></html>\n", out);
    if (fclose(out) && !status) status = al_fail(error, AL_IO, "%s: out of memory", path);
    if (!status) status = al_write_file(path, text, size, error);
    free(text);
    return status;
}
