/* Lat-long maps. Pixel column u in [0,1), row v in [0,1): polar angle theta = pi v from +y, and
 *   direction = (sin theta sin phi, cos theta, -sin theta cos phi),  phi = 2 pi (u - 1/2):
 * the middle of the map lies at -z, its right quarter at +x, both its ends at +z. */
#include "environment.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "airlight/formulas.h"
#include "geometry.h"
#include "inputs.h"
#include "picture.h"

enum { ORDER = AL_ENVIRONMENT_ORDER, COUNT = ORDER * ORDER, GAUSS = 8, AROUND = 2 * ORDER };

/* Nodes and weights of Gauss-Legendre quadrature on [-1, 1] by Newton's method on P_n (DLMF 3.5(v)). */
static void gauss_legendre(double nodes[GAUSS], double weights[GAUSS])
{
    for (int i = 0; i < GAUSS; i++) {
        double x = cos(AL_PI * (i + 0.75) / (GAUSS + 0.5)), slope = 1;
        for (int step = 0; step < 50; step++) {
            double before = 1, here = x;
            for (int n = 2; n <= GAUSS; n++) {
                double next = ((2 * n - 1) * x * here - (n - 1) * before) / n;
                before = here;
                here = next;
            }
            slope = GAUSS * (before - x * here) / (1 - x * x);
            x -= here / slope;
        }
        nodes[i] = x;
        weights[i] = 2 / ((1 - x * x) * slope * slope);
    }
}

/* About the map's own pole: out[l(l+1)+-m] += row[m] * integral over the row of P(l,m) sin theta d theta.
 * The basis at azimuth 0 is Y(l, m) without its cosine. A row is cut into pieces of at most pi/8, over which
 * eight Gauss points integrate trigonometric polynomials of degree 9 to rounding error. */
static void add_row(double top, double bottom, const double cosines[3][ORDER], const double sines[3][ORDER],
                    const double nodes[GAUSS], const double weights[GAUSS], double out[3][COUNT])
{
    int pieces = (int)ceil((bottom - top) / (AL_PI / 8));
    double half = (bottom - top) / (2 * pieces);
    for (int i = 0; i < pieces * GAUSS; i++) {
        double theta = top + half * (1 + 2 * (i / GAUSS) + nodes[i % GAUSS]), basis[AL_SH_MAX_COUNT];
        double weight = half * weights[i % GAUSS] * sin(theta);
        al_sh_basis(ORDER, sin(theta), 0, cos(theta), basis);
        for (int c = 0; c < 3; c++)
            for (int l = 0; l < ORDER; l++)
                for (int m = 0; m <= l; m++) {
                    double value = weight * basis[l * (l + 1) + m];
                    out[c][l * (l + 1) + m] += value * cosines[c][m];
                    if (m) out[c][l * (l + 1) - m] += value * sines[c][m];
                }
    }
}

/* The same function in the other axes. The map's pole is +y and its azimuth turns from z to x, so its axes
 * (x', y', z') are the world's (z, x, y). Gauss points in z' and equal steps around it integrate products of
 * two functions of order 8 exactly (degree 14 <= 15 in both). */
static void turn_axes(const double nodes[GAUSS], const double weights[GAUSS], double in[3][COUNT],
                      float sh[3][COUNT])
{
    double sum[3][COUNT] = {{0}};
    for (int i = 0; i < GAUSS * AROUND; i++) {
        double z = nodes[i / AROUND], azimuth = 2 * AL_PI * (i % AROUND) / AROUND, s = sqrt(1 - z * z);
        double x = s * cos(azimuth), y = s * sin(azimuth), weight = weights[i / AROUND] * 2 * AL_PI / AROUND;
        double own[AL_SH_MAX_COUNT], world[AL_SH_MAX_COUNT];
        al_sh_basis(ORDER, x, y, z, own);
        al_sh_basis(ORDER, y, z, x, world);
        for (int c = 0; c < 3; c++) {
            double value = 0;
            for (int k = 0; k < COUNT; k++) value += in[c][k] * own[k];
            for (int k = 0; k < COUNT; k++) sum[c][k] += weight * value * world[k];
        }
    }
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < COUNT; k++) sh[c][k] = (float)sum[c][k];
}

/* Integral over columns: pixels times the integrals of cos(m a) and sin(m a) over each column, where the
 * azimuth a = -2 pi u runs backwards (phi turns from -z to +x, a from +z to +x). */
static void fourier_row(uint32_t width, const float *row, const double *tables, double cosines[3][ORDER],
                        double sines[3][ORDER])
{
    memset(cosines, 0, 3 * sizeof cosines[0]);
    memset(sines, 0, 3 * sizeof sines[0]);
    for (int m = 0; m < ORDER; m++) {
        const double *table = tables + (size_t)m * width * 2;
        for (size_t column = 0; column < width; column++)
            for (int c = 0; c < 3; c++) {
                cosines[c][m] += row[column * 3 + c] * table[column * 2];
                sines[c][m] += row[column * 3 + c] * table[column * 2 + 1];
            }
    }
}

static void fill_tables(uint32_t width, double *tables)
{
    for (int m = 0; m < ORDER; m++)
        for (uint32_t column = 0; column < width; column++) {
            double *out = tables + ((size_t)m * width + column) * 2;
            double a = -2 * AL_PI * (column + 1) / width, b = -2 * AL_PI * column / width;
            out[0] = m ? (sin(m * b) - sin(m * a)) / m : b - a;
            out[1] = m ? (cos(m * a) - cos(m * b)) / m : 0;
        }
}

al_status al_environment_project(uint32_t width, uint32_t height, const float *pixels, float sh[3][COUNT],
                                 al_error *error)
{
    double *tables = malloc((size_t)width * ORDER * 2 * sizeof *tables);
    double sum[3][COUNT] = {{0}}, cosines[3][ORDER], sines[3][ORDER], nodes[GAUSS], weights[GAUSS];
    if (!tables) return al_fail(error, AL_IO, "out of memory for an environment of %u x %u", width, height);
    gauss_legendre(nodes, weights);
    fill_tables(width, tables);
    for (uint32_t row = 0; row < height; row++) {
        fourier_row(width, pixels + (size_t)row * width * 3, tables, cosines, sines);
        add_row(AL_PI * row / height, AL_PI * (row + 1) / height, cosines, sines, nodes, weights, sum);
    }
    turn_axes(nodes, weights, sum, sh);
    free(tables);
    return AL_OK;
}

/* Turned by an angle about +y, the map shows in phi what it showed in phi + angle: columns move by a share
 * of the width, between two columns linearly (which keeps each row's sum). Scale applied. */
static void place(const al_environment_description *from, uint32_t width, uint32_t height, const float *in,
                  float *out)
{
    double shift = from->rotation_y_radians / (2 * AL_PI), whole;
    shift = (shift - floor(shift)) * width;
    double share = modf(shift, &whole);
    for (size_t row = 0; row < height; row++)
        for (size_t column = 0; column < width; column++) {
            size_t a = (column + (size_t)whole) % width, b = (a + 1) % width;
            for (size_t c = 0; c < 3; c++) {
                double value =
                    (1 - share) * in[(row * width + a) * 3 + c] + share * in[(row * width + b) * 3 + c];
                out[(row * width + column) * 3 + c] = (float)(value * from->scale);
            }
        }
}

/* Lossy compression leaves values a little below 0 beside bright ones: down to a hundredth of the map's mean
 * they count as 0. */
static al_status check_pixels(const char *path, uint32_t width, uint32_t height, float *pixels,
                              al_error *error)
{
    size_t count = (size_t)width * height * 3;
    double sum = 0;
    for (size_t i = 0; i < count; i++) sum += fabs(pixels[i]);
    double allowed = isfinite(sum) ? sum / (double)count / 100 : 0;
    for (size_t i = 0; i < count; i++) {
        if (!(pixels[i] >= -allowed && isfinite(pixels[i])))
            return al_fail(error, AL_BAD_INPUT,
                           "%s: pixel (%zu, %zu), counted from the upper left, channel %c is %g; "
                           "finite radiance of 0 or more is right",
                           path, i / 3 % width, i / 3 / width, "RGB"[i % 3], pixels[i]);
        if (pixels[i] < 0) pixels[i] = 0;
    }
    return AL_OK;
}

static al_status read_map(al_import *import, uint32_t *width, uint32_t *height, float **pixels,
                          al_error *error)
{
    const char *path = import->description->environment.file, *ending = strrchr(path, '.');
    uint8_t *bytes;
    size_t size;
    bool exr = ending && strcasecmp(ending, ".exr") == 0;
    if (!exr && (!ending || strcasecmp(ending, ".hdr") != 0))
        return al_fail(error, AL_BAD_INPUT, "%s: unknown kind of environment map; .exr or .hdr is right",
                       path);
    al_status status = al_inputs_read(import, path, &bytes, &size, error);
    if (status) return status;
    status = (exr ? al_picture_decode_exr : al_picture_decode_hdr)(path, bytes, size, width, height, pixels,
                                                                   error);
    free(bytes);
    if (!status) status = check_pixels(path, *width, *height, *pixels, error);
    return status;
}

/* One pixel is enough for a sky that is the same everywhere. */
static al_status constant_map(const al_environment_description *from, uint32_t *width, uint32_t *height,
                              float **pixels, al_error *error)
{
    *width = *height = 1;
    *pixels = calloc(3, sizeof **pixels);
    if (!*pixels) return al_fail(error, AL_IO, "out of memory for the environment");
    for (int i = 0; i < 3; i++) (*pixels)[i] = (float)from->radiance[i];
    return AL_OK;
}

al_status al_environment_import(al_import *import, al_error *error)
{
    const al_environment_description *from = &import->description->environment;
    al_environment *out = &import->scene.environment;
    uint32_t width, height;
    float *pixels = NULL;
    bool constant = from->radiance[0] > 0 || from->radiance[1] > 0 || from->radiance[2] > 0;
    if (!from->scale || (!*from->file && !constant)) return AL_OK;
    al_status status = *from->file ? read_map(import, &width, &height, &pixels, error)
                                   : constant_map(from, &width, &height, &pixels, error);
    if (status) goto cleanup;
    out->pixels = al_scene_array(&import->scene, (size_t)width * height, 3 * sizeof(float));
    if (!out->pixels) {
        status = al_fail(error, AL_IO, "out of memory for an environment of %u x %u", width, height);
        goto cleanup;
    }
    place(from, width, height, pixels, out->pixels);
    status = al_environment_project(width, height, out->pixels, out->sh, error);
    out->width = width;
    out->height = height;
cleanup:
    free(pixels);
    return status;
}
