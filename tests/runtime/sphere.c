#include "sphere.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "airlight/formulas.h"

enum { QUADRATURE = 64, SLICES = 96, STACKS = 48 };

/* Gauss-Legendre nodes and weights on [-1, 1] by Newton's method on P_n. */
static void gauss_legendre(double *nodes, double *weights)
{
    for (int i = 0; i < QUADRATURE; i++) {
        double x = cos(AL_PI * (i + 0.75) / (QUADRATURE + 0.5)), derivative = 1;
        for (int step = 0; step < 50; step++) {
            double before = 1, here = x;
            for (int l = 1; l < QUADRATURE; l++) {
                double next = ((2 * l + 1) * x * here - l * before) / (l + 1);
                before = here;
                here = next;
            }
            derivative = QUADRATURE * (before - x * here) / (1 - x * x);
            x -= here / derivative;
        }
        nodes[i] = x;
        weights[i] = 2 / ((1 - x * x) * derivative * derivative);
    }
}

/* SH of exp(-sigma * distance to the sphere) from `place`: zonal about the radial direction u, with
 * distance(mu) = -r mu + sqrt(R^2 - r^2 (1 - mu^2)). The zonal coefficient 2 pi int T P_l sqrt((2l+1)/4pi)
 * dmu spreads over m as sqrt(4 pi/(2l+1)) Y_lm(u), so that f_lm = 2 pi Y_lm(u) int T P_l dmu. */
static void project(int order, double sigma, double radius, const float place[3], float *out)
{
    static double nodes[QUADRATURE], weights[QUADRATURE];
    double r = sqrt((double)place[0] * place[0] + (double)place[1] * place[1] + (double)place[2] * place[2]);
    double basis[AL_SH_MAX_COUNT], moments[AL_SH_MAX_ORDER] = {0};
    if (weights[0] == 0) gauss_legendre(nodes, weights);
    al_sh_basis(order, r > 0 ? place[0] / r : 0, r > 0 ? place[1] / r : 0, r > 0 ? place[2] / r : 1, basis);
    for (int i = 0; i < QUADRATURE; i++) {
        double mu = nodes[i], distance = -r * mu + sqrt(radius * radius - r * r * (1 - mu * mu));
        double value = weights[i] * exp(-sigma * distance), before = 0, here = 1;
        for (int l = 0; l < order; l++) {
            moments[l] += value * here;
            double next = ((2 * l + 1) * mu * here - l * before) / (l + 1);
            before = here;
            here = next;
        }
    }
    for (int l = 0; l < order; l++)
        for (int i = l * l; i < (l + 1) * (l + 1); i++) out[i] = (float)(2 * AL_PI * moments[l] * basis[i]);
}

/* Share of each voxel inside the sphere, by 6^3 points. */
static uint16_t *make_grid(uint32_t n, double radius, double voxel)
{
    uint16_t *grid = calloc((size_t)n * n * n, sizeof *grid);
    double corner = -0.5 * n * voxel;
    for (uint32_t z = 0; z < n; z++)
        for (uint32_t y = 0; y < n; y++)
            for (uint32_t x = 0; x < n; x++) {
                int inside = 0;
                for (int k = 0; k < 216; k++) {
                    double px = corner + (x + (k % 6 + 0.5) / 6) * voxel,
                           py = corner + (y + (k / 6 % 6 + 0.5) / 6) * voxel;
                    double pz = corner + (z + (k / 36 + 0.5) / 6) * voxel;
                    inside += px * px + py * py + pz * pz < radius * radius;
                }
                grid[((size_t)z * n + y) * n + x] = (uint16_t)lround(65535.0 * inside / 216);
            }
    return grid;
}

static uint8_t *make_blockers(uint32_t n)
{
    uint8_t *shares = calloc((size_t)n * n * n, 1);
    memset(shares, 255, (size_t)n * n * (n / 2)); /* z is slowest */
    return shares;
}

static void fill_info(const sphere_options *o, al_translucent_info *info)
{
    double radius = o->radius > 0 ? o->radius : 1, albedo = o->albedo > 0 ? o->albedo : 0.9;
    info->page_size = o->page_size ? o->page_size : 512;
    info->order = o->order ? o->order : 5;
    info->format = o->format;
    info->direction_count = 512;
    uint32_t n = o->grid ? o->grid : 64;
    info->voxel_m = (float)(2 * radius * 1.05 / n);
    float first = o->vacuum ? 0 : o->sigma_t[0] > 0 ? o->sigma_t[0] : 2;
    info->channel_count = o->sigma_t[1] > 0 && o->sigma_t[1] != first ? 3 : 1;
    for (int k = 0; k < 3; k++) {
        float sigma = info->channel_count == 3 ? o->sigma_t[k] : first;
        info->grid_size[k] = n;
        info->grid_origin_m[k] = -0.5f * (float)n * info->voxel_m;
        info->sigma_s_per_m[k] = (float)(albedo * sigma);
        info->sigma_a_per_m[k] = (float)((1 - albedo) * sigma);
        info->bounds_min_m[k] = (float)-radius;
        info->bounds_max_m[k] = (float)radius;
    }
    info->density_max = 1;
    info->g = o->g;
    info->ior = 1;
    info->volume_m3 = 4 * AL_PI / 3 * radius * radius * radius;
}

/* Positions are those of the additive sequence of the root of x^4 = x + 1 (Roberts 2018) that fall inside:
 * every prefix is well spread. Gaussians of s = 0.55 spacings, cut at `reach` s, weighted so that they sum to
 * one inside. */
static void fill_samples(al_translucent_data *data, float *positions, float *gaussians, float *coefficients,
                         uint32_t wanted, double reach)
{
    static const double step[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    al_translucent_info *info = &data->info;
    double radius = info->bounds_max_m[0];
    uint32_t count = 0, set = info->order * info->order;
    for (uint32_t i = 1; count < wanted; i++) {
        float p[3];
        for (int k = 0; k < 3; k++) p[k] = (float)((2 * fmod(0.5 + i * step[k], 1) - 1) * radius);
        if (p[0] * p[0] + p[1] * p[1] + p[2] * p[2] >= radius * radius * 0.9999f) continue;
        memcpy(positions + 3 * count, p, sizeof p);
        for (uint32_t c = 0; c < info->channel_count; c++)
            project((int)info->order, info->sigma_s_per_m[c] + info->sigma_a_per_m[c], radius, p,
                    coefficients + ((size_t)count * info->channel_count + c) * set);
        count++;
    }
    double spacing = cbrt(info->volume_m3 / (count ? count : 1)), s = 0.55 * spacing, a = 1 / (2 * s * s);
    for (uint32_t i = 0; i < count; i++) {
        gaussians[4 * i] = (float)a;
        gaussians[4 * i + 1] = (float)(spacing * spacing * spacing * pow(a / AL_PI, 1.5));
        gaussians[4 * i + 2] = (float)(reach * s);
        gaussians[4 * i + 3] = 1;
    }
    info->sample_count = count;
    info->radius_m = spacing;
}

bool sphere_write_asset(const char *folder, const char *name, const sphere_options *options)
{
    al_translucent_data data = {.provenance_json = "{}"};
    al_error error = {0};
    char path[512];
    fill_info(options, &data.info);
    uint32_t wanted = options->samples == UINT32_MAX ? 0 : options->samples ? options->samples : 4000;
    size_t set = (size_t)data.info.channel_count * data.info.order * data.info.order;
    float *positions = malloc(wanted * 12 + 12), *gaussians = malloc(wanted * 16 + 16);
    float *coefficients = malloc(wanted * set * 4 + 4);
    fill_samples(&data, positions, gaussians, coefficients, wanted,
                 options->reach > 0 ? options->reach : 3.5);
    uint16_t *grid = make_grid(data.info.grid_size[0], data.info.bounds_max_m[0], data.info.voxel_m);
    data.positions = positions;
    data.gaussians = gaussians;
    data.coefficients = coefficients;
    data.density = grid;
    uint8_t *blockers = options->blocked ? make_blockers(data.info.grid_size[0]) : NULL;
    data.blockers = blockers;
    data.info.has_blockers = options->blocked;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    al_status status = al_translucent_write(path, &data, NULL, &error);
    if (status) fprintf(stderr, "sphere asset: %s\n", error.message);
    free(positions);
    free(gaussians);
    free(coefficients);
    free(grid);
    free(blockers);
    return !status;
}

static void make_sphere(al_mesh *mesh)
{
    mesh->name = "sphere";
    mesh->vertex_count = (SLICES + 1) * (STACKS + 1);
    mesh->index_count = SLICES * STACKS * 6;
    mesh->positions = malloc(mesh->vertex_count * 12);
    mesh->normals = malloc(mesh->vertex_count * 12);
    mesh->indices = malloc(mesh->index_count * 4);
    uint32_t *index = mesh->indices;
    for (uint32_t j = 0; j <= STACKS; j++)
        for (uint32_t i = 0; i <= SLICES; i++) {
            double theta = AL_PI * j / STACKS, phi = 2 * AL_PI * i / SLICES;
            float *p = mesh->normals + 3 * (j * (SLICES + 1) + i);
            p[0] = (float)(sin(theta) * cos(phi));
            p[1] = (float)cos(theta);
            p[2] = (float)(sin(theta) * sin(phi));
            if (i == SLICES || j == STACKS) continue;
            uint32_t a = j * (SLICES + 1) + i, b = a + SLICES + 1;
            uint32_t faces[6] = {a, a + 1, b, a + 1, b + 1, b};
            memcpy(index, faces, sizeof faces);
            index += 6;
        }
    memcpy(mesh->positions, mesh->normals, mesh->vertex_count * 12);
}

static void make_square(al_mesh *mesh)
{
    static const float corners[12] = {-0.5f, 0, -0.5f, -0.5f, 0, 0.5f, 0.5f, 0, 0.5f, 0.5f, 0, -0.5f};
    static const uint32_t faces[6] = {0, 1, 2, 0, 2, 3};
    mesh->name = "square";
    mesh->vertex_count = 4;
    mesh->index_count = 6;
    mesh->positions = malloc(sizeof corners);
    mesh->normals = calloc(12, 4);
    mesh->indices = malloc(sizeof faces);
    memcpy(mesh->positions, corners, sizeof corners);
    memcpy(mesh->indices, faces, sizeof faces);
    for (int i = 0; i < 4; i++) mesh->normals[3 * i + 1] = 1;
}

void sphere_lay_grid(al_medium_data *data, const al_fog *fog, const al_medium *medium)
{
    al_medium_info *info = &data->info;
    info->g = medium->g;
    for (int k = 0; k < 3; k++) {
        const float edge = (fog->bounds_max_m[k] - fog->bounds_min_m[k]) / (float)info->size[k];
        info->bounds_min_m[k] = fog->bounds_min_m[k];
        info->bounds_max_m[k] = fog->bounds_max_m[k];
        info->sigma_s_per_m[k] = medium->sigma_s_per_m[k];
        info->sigma_a_per_m[k] = medium->sigma_a_per_m[k];
        info->grid_to_world[5 * k] = edge;
        info->grid_to_world[12 + k] = fog->bounds_min_m[k] + edge / 2;
    }
    info->grid_to_world[15] = 1;
}

void sphere_scene_begin(sphere_scene *s)
{
    memset(s, 0, sizeof *s);
    make_sphere(&s->meshes[0]);
    make_square(&s->meshes[1]);
    for (uint32_t i = 0; i < 2; i++) {
        s->submeshes[i] = (al_submesh){0, s->meshes[i].index_count, i};
        s->meshes[i].submesh_count = 1;
        s->meshes[i].submeshes = &s->submeshes[i];
        s->materials[i] = (al_material){.name = i ? "white" : "matched",
                                        .base_color = {1, 1, 1},
                                        .roughness = 1,
                                        .ior = 1,
                                        .double_sided = true,
                                        .base_color_texture = AL_NO_INDEX,
                                        .emission_texture = AL_NO_INDEX,
                                        .metallic_roughness_texture = AL_NO_INDEX,
                                        .normal_texture = AL_NO_INDEX};
    }
    s->medium = (al_medium){.name = "medium", .sigma_s_per_m = {1, 1, 1}};
    s->camera = (al_camera){.name = "camera", .position = {0, 0, 5}, .up = {0, 1, 0}, .fov_y_radians = 0.7f};
    al_scene *scene = &s->scene;
    scene->material_count = scene->mesh_count = 2;
    scene->materials = s->materials;
    scene->meshes = s->meshes;
    scene->media = &s->medium;
    scene->medium_count = 1;
    scene->cameras = &s->camera;
    scene->camera_count = 1;
    scene->instances = s->instances;
    scene->translucents = s->objects;
    scene->lights = s->lights;
}

static al_instance *add_instance(sphere_scene *s, float scale, const float place[3])
{
    al_instance *instance = &s->instances[s->scene.instance_count++];
    *instance = (al_instance){.name = "instance", .translucent = AL_NO_INDEX};
    for (int k = 0; k < 3; k++) {
        instance->world[5 * k] = scale;
        instance->world[12 + k] = place[k];
    }
    instance->world[15] = 1;
    return instance;
}

/* The mesh is as large as the asset says only for radius 1; a rigid instance cannot scale it, so the mesh
 * does. */
void sphere_scene_add(sphere_scene *s, const char *asset, float radius, const float place[3])
{
    uint32_t index = s->scene.translucent_count++;
    for (uint32_t i = 0; index == 0 && i < 3 * s->meshes[0].vertex_count; i++)
        s->meshes[0].positions[i] = s->meshes[0].normals[i] * radius;
    s->objects[index] = (al_translucent_object){
        .name = "sphere", .instance = s->scene.instance_count, .asset = (char *)asset};
    al_instance *instance = add_instance(s, 1, place);
    instance->role = AL_ROLE_TRANSLUCENT;
    instance->translucent = index;
}

void sphere_scene_add_floor(sphere_scene *s, float size, const float place[3])
{
    add_instance(s, size, place)->mesh = 1;
}

void sphere_scene_add_light(sphere_scene *s, al_light_type type, const float vector[3], float intensity)
{
    al_light *light = &s->lights[s->scene.light_count++];
    *light = (al_light){.name = "light", .type = type, .intensity = {intensity, intensity, intensity}};
    memcpy(light->vector, vector, sizeof light->vector);
}

bool sphere_scene_write(const char *folder, const sphere_scene *s)
{
    al_error error = {0};
    char path[512];
    snprintf(path, sizeof path, "%s/scene.air", folder);
    al_status status = al_scene_write(path, &s->scene, "{}", NULL, &error);
    if (status) fprintf(stderr, "sphere scene: %s\n", error.message);
    return !status;
}

void sphere_scene_end(sphere_scene *s)
{
    for (int i = 0; i < 2; i++) {
        free(s->meshes[i].positions);
        free(s->meshes[i].normals);
        free(s->meshes[i].indices);
    }
}
