/* A small picture to draw on: linear RGB, first row on top. */
#ifndef AIRLIGHT_CANVAS_H
#define AIRLIGHT_CANVAS_H

#include "airlight/status.h"

typedef struct canvas {
    int width, height;
    float *pixels; /* [height][width][3] */
} canvas;

/* A square part of a canvas that shows a box of the plane, its aspect kept; drawing is cut off at its edge.
 */
typedef struct panel {
    canvas *on;
    int left, top, edge;    /* pixels */
    double middle[2], half; /* what is shown: middle +- half, second axis upwards */
} panel;

al_status canvas_create(int width, int height, canvas *made, al_error *error);
void canvas_free(canvas *c);
al_status canvas_write(const canvas *c, const char *png_path, al_error *error);

/* Panel `column`, `row` of panels of `edge` pixels with a margin around each. */
enum { CANVAS_MARGIN = 8 };
panel canvas_panel(canvas *on, int column, int row, int edge);
/* Shows the box low..high with a little room around it. */
void panel_show(panel *p, const double low[2], const double high[2]);
/* The point that pixel x, y of the panel shows. */
void panel_point(const panel *p, int x, int y, double point[2]);
void panel_set(const panel *p, int x, int y, const float rgb[3]);
/* Adds light along the line between two points; many lines over each other stay below white. */
void panel_line(const panel *p, const double from[2], const double to[2], const float rgb[3]);
void panel_disc(const panel *p, const double middle[2], double radius_pixels, const float rgb[3]);

/* 0 to 1 from dark blue over green to yellow, rising in luminance. */
void heat_color(double value, float rgb[3]);

#endif
