#include "random_scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/formulas.h"
#include "airlight/medium.h"
#include "airlight/probes.h"
#include "../random.h"
#include "sphere.h"

enum { MESHES = 6, FOGS = 4, VOXELS = 6, SKY_WIDTH = 8, SKY_HEIGHT = 4, TRIANGLES = 24, EDGE = 4 };

typedef struct grid { /* of a fog */
    uint32_t size[3];
    float density[VOXELS * VOXELS * VOXELS];
} grid;

typedef struct builder {
    uint64_t state;
    const char *folder;
    random_scene *out;
    const random_change *change;
    float length, strength, unit; /* the change's factors; m */
    sphere_scene s;               /* the translucent objects' mesh, instances and lights */
    al_mesh meshes[MESHES];
    al_submesh submeshes[MESHES];
    al_material materials[MESHES];
    al_texture textures[MESHES];
    al_medium media[FOGS + 1];
    al_fog fogs[FOGS];
    grid grid;
    float positions[MESHES][3 * TRIANGLES][3], normals[MESHES][3 * TRIANGLES][3], uv[MESHES][3 * TRIANGLES][2];
    float sky[SKY_HEIGHT][SKY_WIDTH][3];
    uint32_t indices[MESHES][3 * TRIANGLES];
    uint8_t pixels[MESHES][EDGE * EDGE * 4];
} builder;

/* --- numbers --- */

static float uniform(builder *b, float low, float high)
{
    return low + (high - low) * (float)((double)(random_bits(&b->state) >> 40) * 0x1p-24);
}

static uint32_t below(builder *b, uint32_t count)
{
    return (uint32_t)((random_bits(&b->state) >> 32) * count >> 32);
}

static bool chance(builder *b, float share)
{
    return uniform(b, 0, 1) < share;
}

static float spread(builder *b, float low, float high) /* its logarithm is uniform; both ends come up */
{
    const float x = uniform(b, -0.05f, 1.05f);
    return fminf(fmaxf(low * powf(high / low, x), low), high);
}

static void place(builder *b, float radius, float out[3])
{
    for (int k = 0; k < 3; k++) out[k] = uniform(b, -radius, radius) * b->unit;
}

static void direction(builder *b, float out[3])
{
    const double z = (double)uniform(b, -1, 1), angle = (double)uniform(b, 0, 6.2831853f), r = sqrt(1 - z * z);
    out[0] = (float)(r * cos(angle));
    out[1] = (float)(r * sin(angle));
    out[2] = (float)z;
}

static void color(builder *b, float largest, float out[3])
{
    const bool grey = chance(b, 0.3f);
    for (int c = 0; c < 3; c++) out[c] = largest * (chance(b, 0.15f) ? (float)below(b, 2) : uniform(b, 0, 1));
    for (int c = 1; c < 3 && grey; c++) out[c] = out[0];
}

/* --- surfaces --- */

static void normal_of(const float p[3][3], float out[3])
{
    double n[3], length = 0;
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        n[k] = ((double)p[1][i] - p[0][i]) * ((double)p[2][j] - p[0][j]) - ((double)p[1][j] - p[0][j]) * ((double)p[2][i] - p[0][i]);
        length += n[k] * n[k];
    }
    for (int k = 0; k < 3; k++) out[k] = length > 0 ? (float)(n[k] / sqrt(length)) : (float)(k == 1);
}

/* Triangles at random, or the faces of a box; of unit size. Some have no area, some coincide, some normals are not their own. */
static void make_mesh(builder *b, uint32_t m)
{
    const bool box = chance(b, 0.5f), odd = chance(b, 0.2f);
    const uint32_t count = box ? 12 : 1 + below(b, TRIANGLES);
    for (uint32_t t = 0; t < count; t++) {
        float (*p)[3] = &b->positions[m][3 * t];
        for (uint32_t v = 0; v < 3; v++)
            for (uint32_t k = 0; k < 3; k++) p[v][k] = uniform(b, -0.5f, 0.5f);
        if (box) { /* the faces of axis t / 4, of its two ends; counter-clockwise from outside */
            static const float corners[2][3][2] = {{{-1, -1}, {1, -1}, {1, 1}}, {{-1, -1}, {1, 1}, {-1, 1}}};
            const uint32_t axis = t / 4, end = t / 2 % 2;
            for (uint32_t v = 0; v < 3; v++) {
                const float *corner = corners[t % 2][v];
                p[v][axis] = end ? 0.5f : -0.5f;
                p[v][(axis + 1) % 3] = 0.5f * corner[end ? 0 : 1];
                p[v][(axis + 2) % 3] = 0.5f * corner[end ? 1 : 0];
            }
        } else if (t && chance(b, 0.1f)) {
            memcpy(p, b->positions[m][3 * (t - 1)], sizeof(float[3][3]));
        } else if (chance(b, 0.05f)) {
            memcpy(p[2], p[1], sizeof p[2]);
        }
        for (uint32_t v = 0; v < 3; v++) {
            if (odd)
                direction(b, b->normals[m][3 * t + v]);
            else
                normal_of((const float(*)[3])p, b->normals[m][3 * t + v]);
            for (int k = 0; k < 2; k++) b->uv[m][3 * t + v][k] = uniform(b, -1, 2);
            b->indices[m][3 * t + v] = 3 * t + v;
        }
    }
    b->submeshes[m] = (al_submesh){0, 3 * count, m};
    b->meshes[m] = (al_mesh){.name = "mesh",
                             .vertex_count = 3 * count,
                             .index_count = 3 * count,
                             .submesh_count = 1,
                             .positions = b->positions[m][0],
                             .normals = b->normals[m][0],
                             .uv0 = b->uv[m][0],
                             .indices = b->indices[m],
                             .submeshes = &b->submeshes[m]};
}

static uint32_t texture_of(builder *b, uint32_t m)
{
    return chance(b, 0.15f) ? m : AL_NO_INDEX;
}

static void make_material(builder *b, uint32_t m)
{
    al_material *material = &b->materials[m];
    const bool glows = b->out->kind == RANDOM_ANY && chance(b, 0.2f);
    material->name = "material";
    material->metallic = chance(b, 0.5f) ? (float)below(b, 2) : uniform(b, 0, 1);
    material->roughness = chance(b, 0.3f) ? (float)below(b, 2) : uniform(b, 0, 1);
    material->ior = chance(b, 0.7f) ? 1.5f : uniform(b, 1, 3);
    material->double_sided = chance(b, 0.5f);
    material->base_color_texture = texture_of(b, m);
    material->emission_texture = texture_of(b, m);
    material->metallic_roughness_texture = texture_of(b, m);
    material->normal_texture = texture_of(b, m);
    color(b, 1, material->base_color);
    if (glows) color(b, spread(b, 1e-6f, 1e6f) * b->strength, material->emission_w_m2_sr);
    for (int i = 0; i < EDGE * EDGE * 4; i++) b->pixels[m][i] = (uint8_t)below(b, 256);
    b->textures[m] = (al_texture){"texture", EDGE, EDGE, chance(b, 0.5f), b->pixels[m]};
}

/* Turned and scaled at random, some flat or mirrored. */
static void add_instance(builder *b, uint32_t mesh)
{
    al_instance *instance = &b->s.instances[b->s.scene.instance_count++];
    float axes[3][3], size = spread(b, 0.05f, 4) * b->unit;
    direction(b, axes[0]);
    direction(b, axes[1]);
    normal_of((const float[3][3]){{0}, {axes[0][0], axes[0][1], axes[0][2]}, {axes[1][0], axes[1][1], axes[1][2]}}, axes[2]);
    normal_of((const float[3][3]){{0}, {axes[2][0], axes[2][1], axes[2][2]}, {axes[0][0], axes[0][1], axes[0][2]}}, axes[1]);
    *instance = (al_instance){.name = "instance", .mesh = mesh, .translucent = AL_NO_INDEX};
    for (int i = 0; i < 3; i++) {
        const float scale = size * (chance(b, 0.03f) ? 0 : chance(b, 0.1f) ? -1 : chance(b, 0.2f) ? spread(b, 1e-3f, 1) : 1);
        for (int k = 0; k < 3; k++) instance->world[4 * i + k] = scale * axes[i][k];
    }
    place(b, 1, instance->world + 12);
    instance->world[15] = 1;
    if (*b->s.scene.baked.probes && chance(b, 0.5f)) instance->lighting = AL_LIGHTING_PROBES;
}

static bool make_probes(builder *b)
{
    float positions[4][3], coefficients[4][AL_LAYER_COUNT][3][4] = {{{{0}}}};
    static const float corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    static const uint32_t tetrahedron[4] = {0, 1, 2, 3};
    const float light = spread(b, 1e-6f, 1e6f) * b->strength;
    char path[512];
    al_error error = {0};
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < 3; k++) positions[i][k] = (2 * corners[i][k] - 0.6f) * b->unit;
        for (int n = 0; n < AL_LAYER_COUNT * 3; n++) {
            float *sh = coefficients[i][n / 3][n % 3], toward[3];
            direction(b, toward);
            sh[0] = light * uniform(b, 0, 1);
            for (int k = 0; k < 3; k++) sh[1 + k] = sh[0] * toward[k];
        }
    }
    const al_probes_data data = {
        .info = {4, 1, 2}, .positions = positions[0], .tetrahedra = tetrahedron, .coefficients = coefficients[0][0][0]};
    snprintf(path, sizeof path, "%s/probes.air", b->folder);
    if (!al_probes_write(path, &data, NULL, &error)) return true;
    fprintf(stderr, "%s\n", error.message);
    return false;
}

static bool make_surfaces(builder *b)
{
    const uint32_t count = chance(b, 0.1f) ? 0 : 1 + below(b, 5);
    b->s.scene.baked = (al_baked_light){"", ""};
    if (b->out->kind == RANDOM_ANY && chance(b, 0.1f)) {
        b->s.scene.baked.probes = "probes.air";
        if (!make_probes(b)) return false;
    }
    for (uint32_t m = 1; m < MESHES; m++) make_mesh(b, m);
    for (uint32_t m = 0; m < MESHES; m++) make_material(b, m);
    for (uint32_t i = 0; i < count; i++) add_instance(b, 1 + below(b, MESHES - 1));
    b->s.scene.materials = b->materials;
    b->s.scene.textures = b->textures;
    b->s.scene.meshes = b->meshes;
    b->s.scene.material_count = b->s.scene.mesh_count = b->s.scene.texture_count = MESHES;
    return true;
}

/* --- media --- */

/* Per metre; optical depths over the unit of 1e-6 to 1e4. */
static void make_medium(builder *b, al_medium *medium)
{
    const bool grey = chance(b, 0.4f);
    const float depth = chance(b, 0.6f) ? spread(b, 0.01f, 10) : spread(b, 1e-6f, 1e4f), choice = uniform(b, 0, 1);
    *medium = (al_medium){.name = "medium", .g = chance(b, 0.3f)   ? 0
                                                 : chance(b, 0.3f) ? 0.99f * (chance(b, 0.5f) ? 1 : -1)
                                                                   : uniform(b, -0.99f, 0.99f)};
    for (int c = 0; c < 3; c++) {
        const float sigma = depth * (grey ? 1 : spread(b, 1e-2f, 1)) / b->unit;
        const double albedo = choice < 0.2f ? 1 : choice < 0.4f ? 1 - 1e-6 : choice < 0.5f ? 0 : (double)uniform(b, 0, 1);
        medium->sigma_s_per_m[c] = b->out->kind == RANDOM_BLACK ? 0 : (float)(albedo * sigma);
        medium->sigma_a_per_m[c] = (float)((1 - albedo) * sigma);
    }
}

static al_status fill_slice(void *user, uint32_t frame, uint32_t z, float *density, al_error *error)
{
    const grid *g = user;
    const uint32_t count = g->size[0] * g->size[1];
    (void)frame, (void)error;
    memcpy(density, g->density + z * count, count * sizeof *density);
    return AL_OK;
}

/* Noise, nothing at all, or one dense voxel; one voxel to VOXELS^3. */
static bool make_grid(builder *b, const al_fog *fog, const al_medium *medium, const char *name)
{
    grid *g = &b->grid;
    const float dense = chance(b, 0.5f) ? 1e6f : 10, share = uniform(b, 0, 1);
    const uint32_t kind = below(b, 4);
    char path[512];
    al_error error = {0};
    al_medium_data data = {.info = {.frame_count = 1, .extended = chance(b, 0.5f)}, .slice = fill_slice, .user = g};
    for (int k = 0; k < 3; k++) g->size[k] = 1 + below(b, VOXELS);
    const uint32_t count = g->size[0] * g->size[1] * g->size[2], chosen = below(b, count);
    for (uint32_t i = 0; i < count; i++)
        g->density[i] = kind == 0 && i == chosen ? dense : kind == 1 || (kind == 2 && !chance(b, share)) ? 0 : uniform(b, 0, 1);
    memcpy(data.info.size, g->size, sizeof g->size);
    sphere_lay_grid(&data, fog, medium);
    snprintf(path, sizeof path, "%s/%s", b->folder, name);
    if (!al_medium_write(path, &data, NULL, &error)) return true;
    fprintf(stderr, "%s\n", error.message);
    return false;
}

static bool make_fogs(builder *b)
{
    static char *const names[FOGS] = {"0.medium.air", "1.medium.air", "2.medium.air", "3.medium.air"};
    const uint32_t count = b->out->kind == RANDOM_BLACK ? 1 + below(b, 2)
                           : chance(b, 0.25f)           ? 0
                                                        : 1 + below(b, chance(b, 0.7f) ? 1 : FOGS);
    b->s.scene.media = b->media;
    b->s.scene.medium_count = FOGS + 1;
    for (uint32_t i = 0; i <= FOGS; i++) b->media[i].name = "medium";
    for (uint32_t i = 0; i < count; i++) {
        al_fog *fog = &b->fogs[i];
        float middle[3];
        *fog = (al_fog){.medium = i, .bounded = chance(b, 0.8f), .density = 1, .asset = ""};
        make_medium(b, &b->media[i]);
        place(b, 0.5f, middle);
        for (int k = 0; k < 3; k++) {
            const float half = spread(b, 0.05f, 2) * b->unit;
            fog->bounds_min_m[k] = fog->bounded ? middle[k] - half : 0;
            fog->bounds_max_m[k] = fog->bounded ? middle[k] + half : 0;
        }
        if (fog->bounded && chance(b, 0.5f)) {
            fog->asset = names[i];
            if (!make_grid(b, fog, &b->media[i], names[i])) return false;
        } else if (chance(b, 0.3f)) {
            fog->density = spread(b, 0.1f, 10);
        }
    }
    b->s.scene.fogs = b->fogs;
    b->s.scene.fog_count = b->change->fog_left_out ? 0 : count;
    return true;
}

/* Spheres of one material. */
static bool make_objects(builder *b)
{
    static const uint32_t orders[] = {1, 3, 5, 8};
    const uint32_t count = b->out->kind == RANDOM_BLACK || chance(b, 0.6f) ? 0 : 1 + below(b, 2);
    const float radius = spread(b, 0.1f, 1) * b->unit, depth = chance(b, 0.7f) ? spread(b, 0.1f, 10) : spread(b, 1e-6f, 1e4f);
    al_medium *medium = &b->media[FOGS];
    make_medium(b, medium);
    sphere_options options = {.radius = radius, .g = medium->g};
    options.blocked = chance(b, 0.1f);
    options.albedo = chance(b, 0.3f) ? 1 : uniform(b, 0, 1);
    options.samples = chance(b, 0.1f) ? 1 + below(b, 3) : 20 + below(b, 200);
    options.reach = uniform(b, 2, 4);
    options.order = orders[below(b, 4)];
    options.grid = 2 + below(b, 7);
    options.page_size = 1 + below(b, 100);
    options.format = (al_coefficient_format)below(b, 3);
    const bool grey = chance(b, 0.5f);
    for (int c = 0; c < 3; c++) options.sigma_t[c] = depth / radius * (grey ? 1 : spread(b, 0.05f, 1));
    b->out->objects = count;
    if (count && !sphere_write_asset(b->folder, "sphere.air", &options)) return false;
    for (uint32_t i = 0; i < count; i++) {
        float middle[3];
        place(b, 1, middle);
        sphere_scene_add(&b->s, "sphere.air", radius, middle);
        b->s.objects[i].medium = FOGS;
    }
    return true;
}

/* --- lights --- */

static void make_lights(builder *b)
{
    const uint32_t count = b->out->kind == RANDOM_FURNACE || chance(b, 0.1f) ? 0 : chance(b, 0.05f) ? 64 : 1 + below(b, 4);
    const float typical = spread(b, 1e-6f, 1e6f);
    for (uint32_t i = 0; i < count; i++) {
        al_light *light = &b->s.lights[i];
        const bool point = chance(b, 0.6f);
        const float strength = (chance(b, 0.8f) ? typical : spread(b, 1e-6f, 1e6f)) * b->strength;
        *light = (al_light){.name = "light", .type = point ? AL_LIGHT_POINT : AL_LIGHT_DIRECTIONAL};
        if (!point)
            direction(b, light->vector);
        else if (b->s.scene.instance_count && chance(b, 0.1f)) /* in a surface */
            memcpy(light->vector, b->s.instances[below(b, b->s.scene.instance_count)].world + 12, sizeof light->vector);
        else
            place(b, 2, light->vector);
        color(b, point ? strength * b->unit * b->unit : strength, light->intensity); /* W/sr: irradiance at the unit's distance */
    }
    b->s.scene.light_count = count;
}

/* SH as an import makes them, which ring about a bright pixel. */
static void project_sky(builder *b, al_environment *environment)
{
    for (int y = 0; y < SKY_HEIGHT; y++)
        for (int x = 0; x < SKY_WIDTH; x++) {
            const double low = AL_PI * y / SKY_HEIGHT, high = AL_PI * (y + 1) / SKY_HEIGHT, theta = (low + high) / 2,
                         phi = 2 * AL_PI * (x + 0.5) / SKY_WIDTH, weight = 2 * AL_PI / SKY_WIDTH * (cos(low) - cos(high));
            double basis[AL_SH_MAX_COUNT];
            al_sh_basis(AL_ENVIRONMENT_ORDER, -sin(theta) * sin(phi), cos(theta), sin(theta) * cos(phi), basis);
            for (int c = 0; c < 3; c++)
                for (int i = 0; i < AL_ENVIRONMENT_ORDER * AL_ENVIRONMENT_ORDER; i++)
                    environment->sh[c][i] += (float)(weight * (double)b->sky[y][x][c] * basis[i]);
        }
}

static void make_environment(builder *b)
{
    al_environment *environment = &b->s.scene.environment;
    const bool furnace = b->out->kind == RANDOM_FURNACE, picture = chance(b, 0.5f), sun = chance(b, 0.3f);
    const float strength = furnace ? 1 : spread(b, 1e-6f, 1e6f) * b->strength;
    const uint32_t hot = below(b, SKY_WIDTH * SKY_HEIGHT);
    for (uint32_t i = 0; i < SKY_WIDTH * SKY_HEIGHT; i++)
        for (uint32_t c = 0; c < 3; c++)
            b->sky[i / SKY_WIDTH][i % SKY_WIDTH][c] =
                furnace ? 1 : strength * (sun && i == hot ? 1 : sun ? 1e-4f : uniform(b, 0, 1));
    if (!furnace && chance(b, 0.4f)) return;
    b->out->sky = true;
    if (picture) {
        environment->width = SKY_WIDTH;
        environment->height = SKY_HEIGHT;
        environment->pixels = b->sky[0][0];
    }
    if (furnace) /* exactly, in every band */
        for (int c = 0; c < 3; c++) environment->sh[c][0] = 3.5449077f;
    else
        project_sky(b, environment);
}

/* --- what is seen, and how --- */

static void set_view(al_view *view, const float eye[3], const float forward[3], const float up[3])
{
    float side[3], over[3];
    normal_of((const float[3][3]){{0}, {forward[0], forward[1], forward[2]}, {up[0], up[1], up[2]}}, side);
    normal_of((const float[3][3]){{0}, {side[0], side[1], side[2]}, {forward[0], forward[1], forward[2]}}, over);
    memset(view->view, 0, sizeof view->view);
    for (int k = 0; k < 3; k++) {
        view->view[4 * k] = side[k];
        view->view[4 * k + 1] = over[k];
        view->view[4 * k + 2] = -forward[k];
        view->view[12] -= side[k] * eye[k];
        view->view[13] -= over[k] * eye[k];
        view->view[14] += forward[k] * eye[k];
    }
    view->view[15] = 1;
}

/* Outside, inside, or in the middle of an instance, of which surfaces or samples may be; perspective or not. */
static void make_views(builder *b)
{
    random_scene *out = b->out;
    float eye[3], target[3], forward[3] = {0}, up[3], step[3];
    const bool flat = chance(b, 0.15f), endless = chance(b, 0.1f);
    const float near = spread(b, 1e-3f, 0.05f) * b->unit, far = 100 * b->unit, scale = 1 / tanf(spread(b, 0.1f, 1.2f));
    const uint32_t width = chance(b, 0.05f) ? 1 : 8 + below(b, 9), height = chance(b, 0.05f) ? 1 : 8 + below(b, 9);
    const float where = uniform(b, 0, 1);
    place(b, where < 0.5f ? 4 : 1, eye);
    if (where > 0.9f && b->s.scene.instance_count)
        memcpy(eye, b->s.instances[below(b, b->s.scene.instance_count)].world + 12, sizeof eye);
    place(b, 0.5f, target);
    place(b, 0.02f, step);
    direction(b, up);
    normal_of((const float[3][3]){{0}, {1, 0, 0}, {0, 1, 0}}, forward);
    float length = 0;
    for (int k = 0; k < 3; k++) length += (target[k] - eye[k]) / b->unit * (target[k] - eye[k]) / b->unit;
    for (int k = 0; k < 3 && length > 0; k++) forward[k] = (target[k] - eye[k]) / b->unit / sqrtf(length);
    for (uint32_t i = 0; i < RANDOM_FRAMES; i++) {
        al_view *view = &out->views[i];
        memset(view, 0, sizeof *view);
        view->width = width;
        view->height = height;
        set_view(view, eye, forward, up);
        for (int k = 0; k < 3; k++) eye[k] += step[k];
        if (flat) {
            view->projection[0] = view->projection[5] = 1 / (2 * b->unit);
            view->projection[10] = -2 / (20 * b->unit);
            view->projection[14] = -1;
            view->projection[15] = 1;
            continue;
        }
        view->projection[0] = scale * (float)height / (float)width;
        view->projection[5] = scale;
        view->projection[10] = endless ? -1 : (far + near) / (near - far);
        view->projection[11] = -1;
        view->projection[14] = endless ? -2 * near : 2 * far * near / (near - far);
    }
}

static uint32_t knob(builder *b, float share, uint32_t low, uint32_t high)
{
    const float x = spread(b, (float)low, (float)high);
    return chance(b, share) ? (uint32_t)x : 0;
}

static float dial(builder *b, float share, float low, float high)
{
    const float x = spread(b, low, high);
    return chance(b, share) ? x : 0;
}

/* Costly ends of the ranges are rare. */
static void make_settings(builder *b)
{
    static const al_pass passes[] = {AL_PASS_TRANSLUCENT, AL_PASS_SURFACE, AL_PASS_UNITY, AL_PASS_DIRECT_SCATTERING,
                                     AL_PASS_SURFACE_SCATTERING, AL_PASS_SURFELS, AL_PASS_INTERVAL_MAP, AL_PASS_DEPLETION,
                                     AL_PASS_AMBIENT_OCCLUSION, AL_PASS_INDIRECT, AL_PASS_BLURRED, AL_PASS_BOUNCE_HITS};
    const bool rare = chance(b, 0.1f);
    al_settings *s = &b->out->settings;
    s->sample_limit = knob(b, 0.2f, 1, 100);
    s->sh_order = knob(b, 0.2f, 1, 8);
    s->view_leg = (al_view_leg)below(b, 2);
    s->surface_off = chance(b, 0.2f);
    s->clip_off = chance(b, 0.2f);
    s->normalise_off = chance(b, 0.2f);
    s->shadows_off = chance(b, 0.5f);
    s->detail_off = chance(b, 0.3f);
    s->background_off = chance(b, 0.1f);
    s->fog_off = chance(b, 0.05f);
    s->scattered_off = chance(b, 0.1f);
    s->fog_steps = knob(b, 0.7f, 1, rare ? 1024 : 40);
    s->surface_scattering_off = chance(b, 0.2f);
    s->surfel_pixels = dial(b, 0.4f, rare ? 0.1f : 0.4f, 1000);
    s->surfel_seed = below(b, 1000);
    s->surfels_plain = chance(b, 0.2f);
    s->surfel_limit = knob(b, 1, 64, rare ? 20000 : 2000);
    s->interval_count = knob(b, 0.4f, 4, 32);
    s->surfel_margin_m = dial(b, 0.2f, fmaxf(1e-6f, 1e-2f * b->unit), fminf(1e6f, 10 * b->unit));
    s->shell_epsilon_w_m2_sr = dial(b, 0.3f, 1e-6f, 1e6f);
    s->shell_levels = knob(b, 0.4f, 1, 7);
    s->shell_radius_m = dial(b, 0.2f, fmaxf(1e-6f, 1e-2f * b->unit), fminf(1e6f, b->unit));
    s->shells_closed = chance(b, 0.1f);
    s->shells_clamped = chance(b, 0.1f);
    s->second_leg_off = chance(b, 0.1f);
    s->second_leg = chance(b, 0.05f) ? AL_SECOND_LEG_BAKED : AL_SECOND_LEG_MARCHED;
    s->second_leg_steps = knob(b, 0.3f, 1, 64);
    s->visibility = chance(b, 0.3f);
    s->indirect = chance(b, 0.4f);
    s->indirect_lambert = chance(b, 0.2f);
    s->ambient_occlusion = chance(b, 0.4f);
    s->bounce_samples = knob(b, 0.5f, 1, rare ? 64 : 8);
    s->bounce_radius_m = dial(b, 0.2f, fmaxf(1e-6f, 1e-2f * b->unit), fminf(1e6f, 10 * b->unit));
    s->bounce_overlap = dial(b, 0.2f, 1, 16);
    s->bounce_near_off = chance(b, 0.2f);
    s->occlusion_carrier = (al_carrier)below(b, AL_CARRIER_COUNT);
    s->indirect_carrier = (al_carrier)below(b, AL_CARRIER_COUNT);
    s->screen_steps = knob(b, 0.3f, 1, rare ? 1024 : 64);
    s->screen_thickness_m = dial(b, 0.2f, fmaxf(1e-6f, 1e-2f * b->unit), fminf(1e6f, 10 * b->unit));
    s->occlusion_radius_m = dial(b, 0.2f, fmaxf(1e-6f, 1e-2f * b->unit), fminf(1e6f, 10 * b->unit));
    s->occlusion_uniform = chance(b, 0.2f);
    s->bounce_filter_off = chance(b, 0.3f);
    s->bounce_filter = knob(b, 0.2f, 1, 16);
    s->temporal = knob(b, 0.4f, 1, 1024);
    s->temporal_undoubted = chance(b, 0.2f);
    s->interval_weights = (al_interval_weights)below(b, AL_INTERVAL_WEIGHTS_COUNT);
    s->interval_jitter_off = chance(b, 0.2f);
    s->blur_off = chance(b, 0.2f);
    s->blur_plain = chance(b, 0.2f);
    s->blur_mips = knob(b, 0.2f, 1, 4);
    s->march_voxels = dial(b, 0.3f, rare ? 0.01f : 0.1f, 100);
    s->shown_level = below(b, s->shell_levels ? s->shell_levels : 6);
    if (s->indirect_carrier == AL_CARRIER_VOLUMES_BLENDED && chance(b, 0.9f)) s->indirect_carrier = AL_CARRIER_VOLUMES;
    if (chance(b, 0.35f)) s->pass = passes[below(b, sizeof passes / sizeof *passes)];
    s->shell_epsilon_w_m2_sr *= b->strength;
    b->out->frames = s->temporal ? 1 + below(b, RANDOM_FRAMES) : 1;
}

bool random_scene_write(const char *folder, uint64_t seed, uint32_t index, const random_change *change, random_scene *scene)
{
    static builder all;
    builder *b = &all;
    memset(b, 0, sizeof *b);
    memset(scene, 0, sizeof *scene);
    b->state = random_begin(seed, index);
    b->folder = folder;
    b->out = scene;
    b->change = change;
    b->strength = ldexpf(1, change->strength);
    b->length = ldexpf(1, change->size);
    b->unit = chance(b, 0.4f) ? 1 : spread(b, 1e-4f, 1e4f);
    scene->unit = b->unit *= b->length;
    scene->kind = chance(b, 0.6f) ? RANDOM_ANY : chance(b, 0.5f) ? RANDOM_FURNACE : RANDOM_BLACK;
    sphere_scene_begin(&b->s);
    bool good = make_surfaces(b) && make_fogs(b) && make_objects(b);
    b->meshes[0] = b->s.meshes[0]; /* as large as the objects */
    make_lights(b);
    make_environment(b);
    make_views(b);
    make_settings(b);
    scene->surfaces = b->s.scene.instance_count - scene->objects;
    scene->fogs = b->s.scene.fog_count;
    scene->lights = b->s.scene.light_count;
    scene->probes = *b->s.scene.baked.probes;
    b->s.scene.play.exposure_ev = uniform(b, -10, 10) > 5 ? uniform(b, -10, 10) - (float)change->strength : -(float)change->strength;
    if (chance(b, 0.2f) && scene->kind == RANDOM_ANY) color(b, spread(b, 1e-6f, 1e6f) * b->strength, b->s.scene.play.background);
    good = good && sphere_scene_write(folder, &b->s);
    sphere_scene_end(&b->s);
    return good;
}
