/* The bounced z-buffer with one level and splats as large as the view: on every pixel's ray, from the medium or from a
 * surface, the same surfel as brute force over all discs, at the same distance. */
#include <epoxy/gl.h>
#include <stdlib.h>
#include <string.h>

#include "../../runtime/state.h"
#include "../test.h"
#include "airlight/formulas.h"
#include "sphere.h"
#include "stage.h"

enum { EDGE = 48 };

typedef struct surfel {
    float place[4], facing[4], front[4], back[4];
    uint32_t edges[4];
} surfel;

typedef struct ray {
    double origin[3], direction[3], normal[3]; /* normal 0: from the medium */
} ray;

static al_runtime *open_scene(const char *folder)
{
    al_runtime *runtime = NULL;
    al_error error = {0};
    sphere_scene s;
    al_fog fog = {.bounded = true, .bounds_min_m = {-1, -1, -1}, .bounds_max_m = {1, 1, 1}, .density = 1, .asset = ""};
    sphere_scene_begin(&s);
    for (int k = 0; k < 3; k++) s.medium.sigma_s_per_m[k] = 0.7f;
    s.medium.g = 0.2f;
    s.scene.fogs = &fog;
    s.scene.fog_count = 1;
    s.scene.baked = (al_baked_light){"", ""};
    sphere_scene_add_floor(&s, 2, (float[3]){0, -0.8f, 0});
    sphere_scene_add_floor(&s, 0.5f, (float[3]){0.3f, -0.1f, 0.2f});
    sphere_scene_add_floor(&s, 0.25f, (float[3]){-0.3f, -0.5f, 0});
    s.instances[s.scene.instance_count - 1].mesh = 0;
    sphere_scene_add_light(&s, AL_LIGHT_POINT, (float[3]){0, 0.5f, 0}, 1);
    CHECK(sphere_scene_write(folder, &s));
    CHECK(al_runtime_create(NULL, &runtime, &error) == AL_OK);
    CHECK(stage_load(runtime, folder));
    sphere_scene_end(&s);
    return runtime;
}

static surfel *read_surfels(const al_runtime *runtime, uint32_t *count)
{
    *count = (uint32_t)al_surfels_count(runtime);
    surfel *surfels = malloc((*count + 1) * sizeof *surfels);
    glGetNamedBufferSubData(runtime->surfels.cloud.id, 0, (GLsizeiptr)(*count * sizeof *surfels), surfels);
    return surfels;
}

static ray pixel_ray(const al_frame_block *frame, uint32_t pixel, const float stored[4], const float normal[4])
{
    ray r;
    double view[3], length = 0;
    for (int k = 0; k < 3; k++) {
        view[k] = frame->ray[3][k] + (pixel % EDGE + 0.5) * frame->ray[4][k] + (pixel / EDGE + 0.5) * frame->ray[5][k];
        length += view[k] * view[k];
    }
    for (int k = 0; k < 3; k++) {
        r.origin[k] = frame->ray[0][k] + (pixel % EDGE + 0.5) * frame->ray[1][k] +
                      (pixel / EDGE + 0.5) * frame->ray[2][k] + stored[3] * view[k] / sqrt(length);
        r.direction[k] = stored[k];
        r.normal[k] = normal ? (double)normal[k] : 0;
    }
    return r;
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* A half-precision number that is positive and normal, or 0. */
static double from_half(uint32_t bits)
{
    return bits & 0x7c00 ? ldexp(1 + (bits & 1023) / 1024.0, (int)(bits >> 10 & 31) - 15) : ldexp(bits & 1023, -24);
}

/* bounce.frag's and surfel_edges.glsl's rules: whether `off` lies behind an edge of the triangle; otherwise the disc's radius
 * squared, and whether all edges end it. How near to an edge, relative. */
static bool passes_edge(const surfel *s, const double off[3], double overlap, double *radius2, bool *whole, double *doubt)
{
    bool overlaps = s->edges[3] >> 24; /* parts of huge triangles */
    if (!overlaps) *radius2 /= overlap;
    double n[3] = {s->facing[0], s->facing[1], s->facing[2]}, radius = sqrt(*radius2), root = sqrt(s->place[3]);
    double sign = n[2] < 0 ? -1 : 1, a = -1 / (sign + n[2]), b = n[0] * n[1] * a;
    double x[3] = {1 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]}, y[3] = {b, sign + n[1] * n[1] * a, -n[1]};
    bool ends[3], behind = false;
    *doubt = 1;
    for (int e = 0; e < 3; e++) {
        double height = exp2(((s->edges[3] >> 8 * e & 255) - 64.0) / 8) * root;
        ends[e] = height >= radius;
        *doubt = fmin(*doubt, fabs(height / radius - 1));
    }
    *whole = ends[0] && ends[1] && ends[2];
    if (*whole) *radius2 *= overlaps ? 4 : 4 * overlap;
    radius = sqrt(*radius2);
    for (int e = 0; e < 3; e++) {
        if (!ends[e]) continue;
        double angle = ((s->edges[e] >> 16) + 0.5) * 2 * AL_PI / 65536, apart = from_half(s->edges[e] & 0xffff) * root;
        double beyond = cos(angle) * dot(off, x) + sin(angle) * dot(off, y) - apart;
        *doubt = fmin(*doubt, fabs(beyond) / radius);
        behind = behind || beyond > 0;
        *radius2 /= 0.5 + 0.5 * fmin(apart / radius, 1);
    }
    return behind;
}

/* The surface that the ray begins on has this disc: bounce.frag's rule. How near to it, relative. */
static bool lies_on(const ray *r, const surfel *s, double radius2, bool whole, double *doubt)
{
    const double most = whole ? 0.0002 : 0.09;
    double height = 0, across2 = 0, turned = 0;
    for (int k = 0; k < 3; k++) {
        double path = r->origin[k] - s->place[k];
        height += s->facing[k] * path;
        across2 += path * path;
        turned += s->facing[k] * r->normal[k];
    }
    across2 -= height * height;
    *doubt = fmin(fabs(across2 / radius2 - 1), fabs(height * height / (most * radius2) - 1));
    *doubt = fmin(*doubt, fabs(fabs(turned) - 0.5));
    return across2 <= radius2 && height * height <= most * radius2 && fabs(turned) > 0.5;
}

/* Distance at which the ray meets the disc, INFINITY where it does not; how near its rim, relative; the cosine between
 * them. */
static double meet(const ray *r, const surfel *s, double overlap, double *rim, double *cosine)
{
    double radius2 = s->place[3] / AL_PI * overlap, slope = 0, away = 0, squared = 0, off[3], edge_doubt = 1, own_doubt = 1;
    bool whole = false, hidden = false, surface = dot(r->normal, r->normal) > 0;
    for (int k = 0; k < 3; k++) {
        slope += s->facing[k] * r->direction[k];
        away += s->facing[k] * (s->place[k] - r->origin[k]);
    }
    double t = away / slope;
    *cosine = fabs(slope);
    for (int k = 0; k < 3; k++) {
        off[k] = r->origin[k] + t * r->direction[k] - s->place[k];
        squared += off[k] * off[k];
    }
    if (surface) hidden = passes_edge(s, off, overlap, &radius2, &whole, &edge_doubt);
    if (surface) hidden = lies_on(r, s, radius2, whole, &own_doubt) || hidden;
    *rim = fabs(squared / radius2 - 1);
    if (t > 0 && squared <= radius2 * 2.001) *rim = fmin(*rim, fmin(edge_doubt, own_doubt));
    return t > 0 && squared <= radius2 && !hidden ? t : INFINITY;
}

static void check_frame(const al_runtime *runtime, float overlap, bool surface)
{
    const al_bounce *bounce = &runtime->bounce;
    static float rays[EDGE * EDGE][4], normals[EDGE * EDGE][4];
    al_frame_block frame;
    al_bounce_block block;
    uint32_t count, width = bounce->hits.width, hits = 0, rims = 0;
    surfel *surfels = read_surfels(runtime, &count);
    uint32_t *numbers = malloc((size_t)width * bounce->hits.height * 4);
    float *depths = malloc((size_t)width * bounce->hits.height * 4);
    glGetNamedBufferSubData(runtime->frame_block.id, 0, sizeof frame, &frame);
    glGetNamedBufferSubData(bounce->constants.id, 0, sizeof block, &block);
    glGetTextureImage(bounce->rays.id, 0, GL_RGBA, GL_FLOAT, sizeof rays, rays);
    glGetTextureImage(runtime->targets.geometry.id, 0, GL_RGBA, GL_FLOAT, sizeof normals, normals);
    glGetTextureImage(bounce->hits.id, 0, GL_RED_INTEGER, GL_UNSIGNED_INT, (GLsizei)(width * bounce->hits.height * 4),
                      numbers);
    glGetTextureImage(bounce->depths.id, 0, GL_DEPTH_COMPONENT, GL_FLOAT, (GLsizei)(width * bounce->hits.height * 4),
                      depths);
    for (uint32_t i = 0; i < EDGE * EDGE; i++) {
        if (rays[i][3] == 0) continue;
        ray r = pixel_ray(&frame, i, rays[i], surface ? normals[i] : NULL);
        uint32_t found = 0, at = i / EDGE * width + i % EDGE;
        double nearest = INFINITY, rim, closest_rim = 1, cosine, slope = 1;
        for (uint32_t s = 0; s < count; s++) {
            double t = meet(&r, &surfels[s], (double)overlap, &rim, &cosine);
            closest_rim = fmin(closest_rim, rim);
            if (t >= nearest) continue;
            nearest = t;
            slope = cosine;
            found = s + 1;
        }
        /* The place on the view ray and the disc's middle are rounded to half a unit of 2^-22 m in three coordinates, twice,
         * the cosine to 2^-24 three times: the height above the disc over the cosine is off by no more than this. */
        double depth = sqrt((double)depths[at]) * block.reach[1], bound = (6 * 0x1p-23 + 3 * 0x1p-24 * nearest) / slope;
        if (numbers[at] != found && closest_rim < 1e-4) {
            rims++; /* a ray through a rim: rounding decides */
            continue;
        }
        hits += found > 0;
        CHECK(numbers[at] == found || fabs(depth - nearest) <= bound); /* coplanar discs: either is nearest */
        if (found && numbers[at]) CHECK_NEAR(depth, nearest, bound);
    }
    printf("%u rays hit one of %u discs, %u met a rim\n", hits, count, rims);
    CHECK(hits > EDGE * EDGE / (surface ? 40 : 8));
    CHECK(rims < EDGE * EDGE / 100);
    free(surfels);
    free(numbers);
    free(depths);
}

int main(void)
{
    if (!stage_open()) return test_skip("no OpenGL 4.5 context");
    const char *folder = stage_folder();
    CHECK(folder != NULL);
    if (!folder) return test_end();
    al_runtime *runtime = open_scene(folder);
    al_view view = stage_look(EDGE, EDGE, (float[3]){0.2f, 0.1f, 3}, (float[3]){0, 0, 0}, 0.7f);
    for (int i = 0; i < 2; i++) {
        al_settings settings = {.pass = AL_PASS_SURFACE_SCATTERING,
                                .visibility = true,
                                .surfel_pixels = 1,
                                .shell_levels = 1,
                                .bounce_samples = 1,
                                .bounce_overlap = i ? 1 : 4};
        free(stage_draw(runtime, &view, &settings, 0));
        check_frame(runtime, settings.bounce_overlap, false);
        settings.pass = AL_PASS_AMBIENT_OCCLUSION;
        free(stage_draw(runtime, &view, &settings, 0));
        check_frame(runtime, settings.bounce_overlap, true);
        settings.pass = AL_PASS_INDIRECT;
        free(stage_draw(runtime, &view, &settings, 0));
        check_frame(runtime, settings.bounce_overlap, true);
    }
    al_runtime_destroy(runtime);
    return test_end();
}
