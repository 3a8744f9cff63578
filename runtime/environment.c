/* The environment: its picture with mips, and its coefficients for surfaces and for each object's samples. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/formulas.h"
#include "state.h"

enum { COEFFICIENTS = AL_ENVIRONMENT_ORDER * AL_ENVIRONMENT_ORDER, NODES = 2 * AL_ENVIRONMENT_ORDER - 1 };

bool al_environment_exists(const al_environment *environment)
{
    if (environment->width && environment->height && environment->pixels) return true;
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < COEFFICIENTS; i++)
            if (environment->sh[c][i] != 0) return true;
    return false;
}

/* The picture as halfs of radiance over a unit: the power of two that puts the brightest number into [2^14,
 * 2^15). A sun of 1e6 W/(m2 sr) would overflow a half and a night of 1e-6 fall below the normal ones. */
static al_status upload_pixels(al_runtime *runtime, const al_environment *environment, al_error *error)
{
    size_t row_count = 3 * (size_t)environment->width;
    float largest = 0, *row = malloc(row_count * sizeof *row);
    int exponent = 15;
    if (!row) return al_fail(error, AL_IO, "no memory for a row of the environment");
    for (size_t i = 0; i < row_count * environment->height; i++)
        largest = fmaxf(largest, environment->pixels[i]);
    if (largest > 0x1p-100f) frexpf(largest, &exponent);
    runtime->environment_unit = ldexpf(1, exponent - 15);
    for (uint32_t y = 0; y < environment->height; y++) {
        for (size_t i = 0; i < row_count; i++)
            row[i] = ldexpf(environment->pixels[y * row_count + i], 15 - exponent);
        glTextureSubImage2D(runtime->environment.id, 0, 0, (GLint)y, (GLsizei)environment->width, 1, GL_RGB,
                            GL_FLOAT, row);
    }
    free(row);
    return AL_OK;
}

al_status al_environment_upload(al_runtime *runtime, al_error *error)
{
    const al_environment *environment = &runtime->scene.environment;
    uint32_t levels = 1, edge = environment->width;
    if (!environment->width || !environment->height || !environment->pixels) return AL_OK;
    while (edge >> levels) levels++;
    al_status status = al_gl_texture_create(&runtime->memory, GL_TEXTURE_2D, GL_RGBA16F, environment->width,
                                            environment->height, 1, levels, &runtime->environment, error);
    if (status) return status;
    status = upload_pixels(runtime, environment, error);
    if (status) return status;
    GLuint id = runtime->environment.id;
    glGenerateTextureMipmap(id);
    glTextureParameteri(id, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    glTextureParameteri(id, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(id, GL_TEXTURE_WRAP_S, GL_REPEAT);
    runtime->environment_levels = levels;
    return AL_OK;
}

void al_environment_fill(al_draw *draw)
{
    const al_scene *scene = &draw->runtime->scene;
    bool exists = al_environment_exists(&scene->environment);
    draw->block.counts[2] = draw->runtime->environment.id ? 2 : exists ? 1 : 0;
    draw->block.counts[3] = (int32_t)draw->runtime->environment_levels;
    draw->block.background[3] = draw->runtime->environment_unit;
    for (int c = 0; c < 3; c++) {
        draw->block.background[c] = scene->play.background[c];
        for (int i = 0; i < AL_ENVIRONMENT_BANDS; i++)
            draw->block.environment[i][c] = scene->environment.sh[c][i];
    }
}

/* The phase function's Legendre series, sum of (2l + 1) g^l P_l / (4 pi), up to the band that a product of
 * radiance and transmittance, both of AL_ENVIRONMENT_ORDER bands, can hold. */
static double phase_series(double g, double cosine)
{
    double before = 0, here = 1, sum = 0, moment = 1;
    for (int l = 0; l <= 2 * (AL_ENVIRONMENT_ORDER - 1); l++, moment *= g) {
        sum += (2 * l + 1) * moment * here;
        double next = ((2 * l + 1) * cosine * here - l * before) / (l + 1);
        before = here;
        here = next;
    }
    return sum / (4 * AL_PI);
}

/* Gauss-Legendre nodes and weights on [-1, 1] by Newton's method on the Legendre polynomial of degree NODES.
 */
static void gauss_legendre(double nodes[NODES], double weights[NODES])
{
    for (int i = 0; i < NODES; i++) {
        double x = cos(AL_PI * (i + 0.75) / (NODES + 0.5)), slope = 1;
        for (int step = 0; step < 8; step++) {
            double before = 1, here = x;
            for (int l = 1; l < NODES; l++) {
                double next = ((2 * l + 1) * x * here - l * before) / (l + 1);
                before = here;
                here = next;
            }
            slope = NODES * (before - x * here) / (1 - x * x);
            x -= here / slope;
        }
        nodes[i] = x;
        weights[i] = 2 / ((1 - x * x) * slope * slope);
    }
}

/* Adds what the world direction w contributes to the coefficients in object space. */
static void add_direction(const al_environment *environment, double g, const double view[3],
                          const float rotation[9], const double w[3], double weight,
                          double sums[COEFFICIENTS][3])
{
    double object[3], basis[AL_SH_MAX_COUNT], radiance[3] = {0};
    al_sh_basis(AL_ENVIRONMENT_ORDER, w[0], w[1], w[2], basis);
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < COEFFICIENTS; i++) radiance[c] += environment->sh[c][i] * basis[i];
    weight *= phase_series(g, -(w[0] * view[0] + w[1] * view[1] + w[2] * view[2]));
    for (int k = 0; k < 3; k++)
        object[k] = rotation[k] * w[0] + rotation[3 + k] * w[1] + rotation[6 + k] * w[2];
    al_sh_basis(AL_ENVIRONMENT_ORDER, object[0], object[1], object[2], basis);
    for (int i = 0; i < COEFFICIENTS; i++)
        for (int c = 0; c < 3; c++) sums[i][c] += weight * radiance[c] * basis[i];
}

/* Coefficients in object space of environment radiance times the phase function about the direction `view`
 * (world, from the object to the eye); light from w travels along -w. The integrand holds bands up to 4
 * (ORDER - 1) = 28, which NODES = 15 Gauss-Legendre heights of 2 NODES azimuths each integrate exactly.
 * rotation[], row-major, takes object to world. */
static void project(const al_environment *environment, double g, const double view[3],
                    const float rotation[9], float out[][4])
{
    double nodes[NODES], weights[NODES], sums[COEFFICIENTS][3] = {{0}};
    gauss_legendre(nodes, weights);
    for (int i = 0; i < NODES; i++)
        for (int j = 0; j < 2 * NODES; j++) {
            double radius = sqrt(1 - nodes[i] * nodes[i]), angle = AL_PI * j / NODES;
            double w[3] = {radius * cos(angle), radius * sin(angle), nodes[i]};
            add_direction(environment, g, view, rotation, w, weights[i] * AL_PI / NODES, sums);
        }
    for (int i = 0; i < COEFFICIENTS; i++)
        for (int c = 0; c < 3; c++) out[i][c] = (float)sums[i][c];
}

void al_environment_for_object(const al_draw *draw, al_object *object)
{
    const al_environment *environment = &draw->runtime->scene.environment;
    const float *world = object->block.object_to_world;
    float rotation[9], key[20] = {object->info.g};
    double view[3], length = 0;
    if (!al_environment_exists(environment)) return;
    for (int i = 0; i < 9; i++) rotation[i] = world[4 * (i % 3) + i / 3]; /* row-major */
    for (int k = 0; k < 3; k++) {
        double middle = world[12 + k];
        for (int j = 0; j < 3; j++)
            middle += world[4 * j + k] * 0.5 *
                      ((double)object->info.bounds_min_m[j] + object->info.bounds_max_m[j]);
        view[k] = draw->eye[3] > 0 ? draw->eye[k] - middle : draw->eye[k];
        length += view[k] * view[k];
    }
    length = sqrt(length);
    for (int k = 0; k < 3; k++) view[k] = length > 0 ? view[k] / length : k == 2;
    memcpy(key + 1, rotation, sizeof rotation);
    if (object->info.g != 0)
        for (int k = 0; k < 3; k++) key[10 + k] = (float)view[k];
    if (object->environment_good && memcmp(key, object->environment_key, sizeof key) == 0) return;
    memcpy(object->environment_key, key, sizeof key);
    object->environment_good = true;
    project(environment, object->info.g, view, rotation, object->block.environment);
}
