/* Seams: a chart's border reads its light, bilinear, from other texels than the border of the chart beside
 * it, and the eye sees the step. At places along such an edge the sums of both sides, a.x and b.x over at
 * most four texels each, should agree; and texels should stay what they are, x0. Minimised is
 *
 *     sum over places (a.x - b.x)^2  +  sum over texels w (x - x0)^2
 *
 * (Iwanicki, "Lighting Technology of The Last of Us", SIGGRAPH 2013), for each channel by itself. The matrix
 * of the normal equations is D + C'C with D the weights and C the rows a - b: conjugate gradients, begun at
 * x0, need only products with C. Texels of the padding hold no light of their own and move ten times as
 * easily. */
#include "light_page.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "edges.h"
#include "texels.h"

#define WEIGHT_BAKED 0.1
#define WEIGHT_DILATED 0.01
#define SAME_NORMAL 0.99 /* cosine: across sharper edges the light really differs */

enum { ROW_TEXELS = 8, ITERATIONS = 100 };

typedef struct row { /* a.x - b.x at one place */
    uint32_t texels[ROW_TEXELS];
    double factors[ROW_TEXELS];
    double share[ROW_TEXELS]; /* |factor| / 2: for the mean of both sides */
} row;

typedef struct seam_system {
    const al_light_page *page;
    row *rows;
    uint32_t row_count, room;
    uint32_t *variables; /* [height][width] 1 + number, 0: none */
    uint32_t *cells;     /* [variable_count] */
    uint32_t variable_count;
    bool out_of_memory;
} seam_system;

/* --- rows --- */

/* Four texels around a place of the page, weights times `sign`. */
static void read_bilinear(const al_light_page *page, const double at[2], double sign, uint32_t *texels,
                          double *factors)
{
    double x = at[0] - 0.5, y = at[1] - 0.5, total = 0;
    for (int i = 0; i < 4; i++) {
        double column = floor(x) + i % 2, line = floor(y) + i / 2;
        double weight = fmax(1 - fabs(x - column), 0) * fmax(1 - fabs(y - line), 0);
        uint32_t cell = (uint32_t)fmin(fmax(line, 0), page->height - 1.0) * page->width +
                        (uint32_t)fmin(fmax(column, 0), page->width - 1.0);
        texels[i] = cell;
        factors[i] = page->state[cell] == AL_TEXEL_EMPTY ? 0 : weight;
        total += factors[i];
    }
    for (int i = 0; i < 4; i++) factors[i] = total > 0 ? sign * factors[i] / total : 0;
}

static void add_row(seam_system *s, const double a[2], const double b[2])
{
    if (s->row_count == s->room) {
        uint32_t room = s->room ? 2 * s->room : 1024;
        row *grown = realloc(s->rows, room * sizeof *grown);
        if (!grown) {
            s->out_of_memory = true;
            return;
        }
        s->rows = grown;
        s->room = room;
    }
    row *r = &s->rows[s->row_count++];
    read_bilinear(s->page, a, 1, r->texels, r->factors);
    read_bilinear(s->page, b, -1, r->texels + 4, r->factors + 4);
    for (int i = 0; i < ROW_TEXELS; i++) r->share[i] = fabs(r->factors[i]) / 2;
}

typedef struct end { /* of an edge, seen from one triangle */
    uint32_t vertex;
    double at[2];
} end;

static void ends_of(const al_mesh *mesh, const al_atlas_instance *placed, uint32_t side, end ends[2])
{
    for (uint32_t k = 0; k < 2; k++) {
        ends[k].vertex = mesh->indices[side - side % 3 + (side + k) % 3];
        al_texels_corner(mesh, placed, ends[k].vertex, ends[k].at);
    }
}

static bool same_normal(const al_mesh *mesh, uint32_t a, uint32_t b)
{
    const float *m = mesh->normals + 3 * (size_t)a, *n = mesh->normals + 3 * (size_t)b;
    return (double)m[0] * n[0] + (double)m[1] * n[1] + (double)m[2] * n[2] > SAME_NORMAL;
}

/* Of the triangle that a side belongs to, not of unit length. */
static void face_normal(const al_mesh *mesh, uint32_t side, double normal[3])
{
    const float *p[3];
    double a[3], b[3];
    for (uint32_t k = 0; k < 3; k++) p[k] = mesh->positions + 3 * (size_t)mesh->indices[side - side % 3 + k];
    for (int k = 0; k < 3; k++) {
        a[k] = (double)p[1][k] - p[0][k];
        b[k] = (double)p[2][k] - p[0][k];
    }
    for (int k = 0; k < 3; k++) normal[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* Files may give both sides of a sheet the same normals. */
static bool same_side(const al_mesh *mesh, uint32_t side_a, uint32_t side_b)
{
    double a[3], b[3];
    face_normal(mesh, side_a, a);
    face_normal(mesh, side_b, b);
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] > 0;
}

/* Places along the edge that two triangles share, if it is a seam between them. */
static void add_edge(seam_system *s, const al_mesh *mesh, const al_edges *edges,
                     const al_atlas_instance *placed, uint32_t side_a, uint32_t side_b)
{
    end a[2], b[2];
    double longest = 0, apart = 0;
    if (!same_side(mesh, side_a, side_b)) return;
    ends_of(mesh, placed, side_a, a);
    ends_of(mesh, placed, side_b, b);
    if (edges->points[a[0].vertex] != edges->points[b[0].vertex]) {
        end kept = b[0];
        b[0] = b[1];
        b[1] = kept;
    }
    for (int k = 0; k < 2; k++) {
        if (!same_normal(mesh, a[k].vertex, b[k].vertex)) return;
        apart = fmax(apart, hypot(a[k].at[0] - b[k].at[0], a[k].at[1] - b[k].at[1]));
    }
    if (apart < 1e-6) return;
    longest = fmax(hypot(a[1].at[0] - a[0].at[0], a[1].at[1] - a[0].at[1]),
                   hypot(b[1].at[0] - b[0].at[0], b[1].at[1] - b[0].at[1]));
    int count = (int)ceil(2 * longest) + 1;
    for (int i = 0; i < count; i++) {
        double t = (i + 0.5) / count, pa[2], pb[2];
        for (int k = 0; k < 2; k++) {
            pa[k] = a[0].at[k] + t * (a[1].at[k] - a[0].at[k]);
            pb[k] = b[0].at[k] + t * (b[1].at[k] - b[0].at[k]);
        }
        add_row(s, pa, pb);
    }
}

static al_status add_instance(seam_system *s, const al_scene *scene, const al_atlas_instance *placed,
                              al_error *error)
{
    const al_mesh *mesh = &scene->meshes[scene->instances[placed->instance].mesh];
    al_edges edges;
    al_status status = al_edges_make(mesh, &edges, error);
    for (uint32_t g = 0; status == AL_OK && g < edges.group_count; g++)
        for (uint32_t i = edges.starts[g] + 1; i < edges.starts[g + 1]; i++)
            add_edge(s, mesh, &edges, placed, edges.sides[edges.starts[g]], edges.sides[i]);
    al_edges_free(&edges);
    return status;
}

/* Numbers the texels that the rows read. */
static bool number_variables(seam_system *s)
{
    size_t cells = (size_t)s->page->width * s->page->height;
    s->variables = calloc(cells + 1, sizeof *s->variables);
    s->cells = malloc(((size_t)s->row_count * ROW_TEXELS + 1) * sizeof *s->cells);
    if (!s->variables || !s->cells) return false;
    for (uint32_t r = 0; r < s->row_count; r++)
        for (int i = 0; i < ROW_TEXELS; i++) {
            uint32_t cell = s->rows[r].texels[i];
            if (!s->variables[cell]) {
                s->cells[s->variable_count++] = cell;
                s->variables[cell] = s->variable_count;
            }
            s->rows[r].texels[i] = s->variables[cell] - 1;
        }
    return true;
}

/* --- solving --- */

static double row_times(const row *r, const double *x)
{
    double sum = 0;
    for (int i = 0; i < ROW_TEXELS; i++) sum += r->factors[i] * x[r->texels[i]];
    return sum;
}

/* out = (D + C'C) x */
static void multiply(const seam_system *s, const double *weights, const double *x, double *out)
{
    for (uint32_t i = 0; i < s->variable_count; i++) out[i] = weights[i] * x[i];
    for (uint32_t r = 0; r < s->row_count; r++) {
        double value = row_times(&s->rows[r], x);
        for (int i = 0; i < ROW_TEXELS; i++) out[s->rows[r].texels[i]] += s->rows[r].factors[i] * value;
    }
}

static double product(const double *a, const double *b, uint32_t count)
{
    double sum = 0;
    for (uint32_t i = 0; i < count; i++) sum += a[i] * b[i];
    return sum;
}

/* Moves x from x0, where the residual is -C'C x0, to the minimum. scratch has room for 3 x variable_count. */
static void solve(const seam_system *s, const double *weights, double *x, double *scratch)
{
    uint32_t n = s->variable_count;
    double *residual = scratch, *direction = scratch + n, *image = scratch + 2 * (size_t)n;
    multiply(s, weights, x, residual);
    for (uint32_t i = 0; i < n; i++) residual[i] = weights[i] * x[i] - residual[i];
    memcpy(direction, residual, n * sizeof *direction);
    double square = product(residual, residual, n), enough = 1e-12 * square + 1e-24 * product(x, x, n);
    for (int k = 0; k < ITERATIONS && square > enough; k++) {
        multiply(s, weights, direction, image);
        double step = square / product(direction, image, n), before = square;
        for (uint32_t i = 0; i < n; i++) {
            x[i] += step * direction[i];
            residual[i] -= step * image[i];
        }
        square = product(residual, residual, n);
        for (uint32_t i = 0; i < n; i++) direction[i] = residual[i] + square / before * direction[i];
    }
}

/* Adds the squares of the jumps and of the light at the seams. */
static void measure(const seam_system *s, const double *x, double *jumps, double *light)
{
    for (uint32_t r = 0; r < s->row_count; r++) {
        double jump = row_times(&s->rows[r], x), mean = 0;
        for (int i = 0; i < ROW_TEXELS; i++) mean += s->rows[r].share[i] * x[s->rows[r].texels[i]];
        *jumps += jump * jump;
        *light += mean * mean;
    }
}

static bool stitch_channels(const seam_system *s, uint32_t positive, al_light_page *page, al_seams *seams)
{
    size_t n = s->variable_count;
    double *weights = malloc((5 * n + 1) * sizeof *weights), *x = weights + n, *scratch = weights + 2 * n;
    double before = 0, after = 0, light = 0, unused = 0;
    if (!weights) return false;
    for (size_t i = 0; i < n; i++)
        weights[i] = page->state[s->cells[i]] == AL_TEXEL_DILATED ? WEIGHT_DILATED : WEIGHT_BAKED;
    for (uint32_t c = 0; c < page->channel_count; c++) {
        for (size_t i = 0; i < n; i++) x[i] = page->light[(size_t)s->cells[i] * page->channel_count + c];
        if (c < positive) measure(s, x, &before, &light);
        solve(s, weights, x, scratch);
        for (size_t i = 0; i < n && c < positive; i++) x[i] = fmax(x[i], 0);
        if (c < positive) measure(s, x, &after, &unused);
        for (size_t i = 0; i < n; i++)
            page->light[(size_t)s->cells[i] * page->channel_count + c] = (float)x[i];
    }
    seams->places = s->row_count;
    seams->jump_before = light > 0 ? sqrt(before / light) : 0;
    seams->jump_after = light > 0 ? sqrt(after / light) : 0;
    free(weights);
    return true;
}

al_status al_light_page_stitch(const al_scene *scene, const al_atlas *atlas, uint32_t index,
                               uint32_t positive, al_light_page *page, al_seams *seams, al_error *error)
{
    seam_system s = {.page = page};
    al_status status = AL_OK;
    *seams = (al_seams){0};
    for (uint32_t i = 0; status == AL_OK && i < atlas->instance_count; i++)
        if (atlas->instances[i].page == index) status = add_instance(&s, scene, &atlas->instances[i], error);
    if (status == AL_OK &&
        (s.out_of_memory || !number_variables(&s) || !stitch_channels(&s, positive, page, seams)))
        status = al_fail(error, AL_IO, "out of memory for %u places along seams", s.row_count);
    free(s.rows);
    free(s.variables);
    free(s.cells);
    return status;
}
