#include "atlas.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "chart.h"
#include "geometry.h"
#include "pack.h"
#include "second_uv.h"
#include "weld.h"

#define LEAST_RATIO 0.25 /* of texels along an edge, smallest to largest instance of a mesh */

/* --- sizes in space --- */

static bool is_lightmapped(const al_instance *instance)
{
    return instance->lighting == AL_LIGHTING_LIGHTMAP;
}

bool al_atlas_needed(const al_scene *scene)
{
    for (uint32_t i = 0; i < scene->instance_count; i++)
        if (is_lightmapped(&scene->instances[i])) return true;
    return false;
}

static void world_of(const al_instance *instance, double world[16])
{
    for (int i = 0; i < 16; i++) world[i] = instance->world[i];
}

static void world_corners(const al_mesh *mesh, const double world[16], uint32_t triangle, double p[3][3])
{
    for (size_t k = 0; k < 3; k++) {
        const float *from = mesh->positions + 3 * (size_t)mesh->indices[3 * (size_t)triangle + k];
        al_matrix_point(world, (double[3]){from[0], from[1], from[2]}, p[k]);
    }
}

static double area_in_space(const al_scene *scene, const al_instance *instance)
{
    const al_mesh *mesh = &scene->meshes[instance->mesh];
    double world[16], p[3][3], sum = 0;
    world_of(instance, world);
    for (uint32_t t = 0; t < mesh->index_count / 3; t++) {
        double square = 0;
        world_corners(mesh, world, t, p);
        for (int k = 0; k < 3; k++) {
            int i = (k + 1) % 3, j = (k + 2) % 3;
            double n = (p[1][i] - p[0][i]) * (p[2][j] - p[0][j]) - (p[1][j] - p[0][j]) * (p[2][i] - p[0][i]);
            square += n * n;
        }
        sum += sqrt(square) / 2;
    }
    return sum;
}

/* Diagonal of the box around everything with a lightmap. */
static double diagonal_m(const al_scene *scene)
{
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, square = 0;
    for (uint32_t i = 0; i < scene->instance_count; i++) {
        const al_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        double world[16], p[3];
        if (!is_lightmapped(&scene->instances[i])) continue;
        world_of(&scene->instances[i], world);
        for (size_t v = 0; v < mesh->vertex_count; v++) {
            const float *from = mesh->positions + 3 * v;
            al_matrix_point(world, (double[3]){from[0], from[1], from[2]}, p);
            for (int k = 0; k < 3; k++) {
                low[k] = fmin(low[k], p[k]);
                high[k] = fmax(high[k], p[k]);
            }
        }
    }
    for (int k = 0; k < 3; k++) square += high[k] > low[k] ? (high[k] - low[k]) * (high[k] - low[k]) : 0;
    return sqrt(square);
}

static double texel_m(const al_import *import)
{
    const al_lightmap_settings *settings = &import->description->lightmap;
    return settings->texel_m > 0 ? settings->texel_m : diagonal_m(&import->scene) / settings->texels_across;
}

double al_atlas_texels(const al_import *import)
{
    double area = 0, edge = texel_m(import);
    for (uint32_t i = 0; i < import->scene.instance_count; i++)
        if (is_lightmapped(&import->scene.instances[i]))
            area += area_in_space(&import->scene, &import->scene.instances[i]);
    return edge > 0 ? area / (edge * edge) : 0;
}

/* --- the second UV set of one mesh --- */

typedef struct mesh_use {    /* of one mesh by the lightmapped instances */
    uint32_t largest;        /* instance with the largest area */
    double area, least_area; /* m2, of the largest and the smallest one */
    uint32_t width, height;  /* texels of [0, 1] for the largest one; 0: not lightmapped */
} mesh_use;

static double least_ratio(const mesh_use *use)
{
    double ratio = use->area > 0 ? sqrt(use->least_area / use->area) : 1;
    return fmax(ratio, LEAST_RATIO);
}

static double uv1_area(const al_mesh *mesh)
{
    double sum = 0;
    for (size_t i = 0; i < mesh->index_count; i += 3) {
        const float *a = mesh->uv1 + 2 * (size_t)mesh->indices[i],
                    *b = mesh->uv1 + 2 * (size_t)mesh->indices[i + 1],
                    *c = mesh->uv1 + 2 * (size_t)mesh->indices[i + 2];
        sum += fabs(((double)b[0] - a[0]) * ((double)c[1] - a[1]) -
                    ((double)b[1] - a[1]) * ((double)c[0] - a[0])) /
               2;
    }
    return sum;
}

/* A square of texels in which the mean triangle has its size; checked for the smallest instance. */
static al_status use_file_uv(const al_mesh *mesh, double wanted_m, uint32_t page_size, mesh_use *use,
                             bool *coarse, al_error *error)
{
    double area = uv1_area(mesh), edge = area > 0 ? ceil(sqrt(use->area / area) / wanted_m) : 1;
    *coarse = edge > page_size;
    use->width = use->height = edge < 1 ? 1 : *coarse ? page_size : (uint32_t)edge;
    uint32_t smallest = (uint32_t)ceil(use->width * least_ratio(use));
    return al_uv_check(mesh, smallest, smallest, error);
}

/* Charts and their padding on a page; 0 x 0 when it does not take them all. */
static al_status pack_charts(const al_charts *charts, uint32_t padding, uint32_t page_size,
                             al_pack_rectangle *rectangles, uint32_t *width, uint32_t *height,
                             al_error *error)
{
    uint32_t packed;
    *width = *height = 0;
    for (uint32_t i = 0; i < charts->count; i++) {
        double size[2]; /* what rounding adds to a straight border needs no texel more */
        for (int k = 0; k < 2; k++) size[k] = fmax(ceil(charts->size[i][k] - 1e-3), 1) + padding;
        if (fmax(size[0], size[1]) > (double)page_size + padding) return AL_OK;
        rectangles[i] = (al_pack_rectangle){.width = (uint32_t)size[0], .height = (uint32_t)size[1]};
    }
    al_status status = al_pack(rectangles, charts->count, page_size + padding, &packed, error);
    if (status != AL_OK || packed < charts->count) return status;
    *width = *height = 1;
    for (uint32_t i = 0; i < charts->count; i++) {
        uint32_t right = rectangles[i].x + rectangles[i].width - padding,
                 below = rectangles[i].y + rectangles[i].height - padding;
        *width = right > *width ? right : *width;
        *height = below > *height ? below : *height;
    }
    return AL_OK;
}

static void *copy_elements(al_scene *scene, const float *from, size_t width, const uint32_t *sources,
                           uint32_t count)
{
    float *made = from ? al_scene_array(scene, count, width * sizeof *made) : NULL;
    for (uint32_t i = 0; made && i < count; i++)
        memcpy(made + i * width, from + sources[i] * width, width * sizeof *made);
    return made;
}

/* Gives the mesh uv1 from its charts; a vertex that several charts share becomes several. */
static al_status set_uv1(al_scene *scene, al_mesh *mesh, const al_charts *charts,
                         const al_pack_rectangle *rectangles, const mesh_use *use, al_error *error)
{
    uint32_t corners = mesh->index_count, count = 0;
    uint32_t(*records)[2] = malloc((corners + (size_t)1) * sizeof *records);
    uint32_t *sources = malloc((corners + (size_t)1) * sizeof *sources);
    uint32_t *indices = al_scene_array(scene, corners, sizeof *indices);
    al_status status = AL_IO;
    if (!records || !sources || !indices) goto cleanup;
    for (uint32_t i = 0; i < corners; i++) {
        records[i][0] = mesh->indices[i];
        records[i][1] = charts->chart[i / 3];
    }
    status = al_weld(records, sizeof *records, corners, indices, &count, error);
    if (status != AL_OK) goto cleanup;
    status = AL_IO;
    float *uv1 = al_scene_array(scene, count, 2 * sizeof *uv1);
    if (!uv1) goto cleanup;
    for (uint32_t i = 0; i < corners; i++) {
        uint32_t chart = charts->chart[i / 3], v = indices[i];
        sources[v] = mesh->indices[i];
        if (chart == AL_NO_CHART) continue;
        uv1[2 * (size_t)v] = (float)fmin(fmax((rectangles[chart].x + charts->uv[i][0]) / use->width, 0), 1);
        uv1[2 * (size_t)v + 1] =
            (float)fmin(fmax((rectangles[chart].y + charts->uv[i][1]) / use->height, 0), 1);
    }
    al_mesh made = *mesh;
    made.vertex_count = count;
    made.positions = copy_elements(scene, mesh->positions, 3, sources, count);
    made.normals = copy_elements(scene, mesh->normals, 3, sources, count);
    made.uv0 = copy_elements(scene, mesh->uv0, 2, sources, count);
    made.uv1 = uv1;
    made.indices = indices;
    if (!made.positions || !made.normals || (mesh->uv0 && !made.uv0)) goto cleanup;
    *mesh = made;
    status = AL_OK;
cleanup:
    free(records);
    free(sources);
    return status == AL_IO ? al_fail(error, AL_IO, "mesh \"%s\": out of memory", mesh->name) : status;
}

/* Texels grow until all charts fit the page. */
static al_status make_own_uv(al_scene *scene, uint32_t index, const al_lightmap_settings *settings,
                             double wanted_m, mesh_use *use, bool *coarse, al_error *error)
{
    al_mesh *mesh = &scene->meshes[index];
    uint32_t padding = (uint32_t)ceil(settings->padding_texels / least_ratio(use));
    double world[16], edge_m = fmax(wanted_m, sqrt(use->area) / settings->page_size);
    al_edges edges;
    al_status status = al_edges_make(mesh, &edges, error);
    if (status != AL_OK) return status;
    world_of(&scene->instances[use->largest], world);
    while (status == AL_OK && use->width == 0) {
        al_charts charts;
        al_pack_rectangle *rectangles = NULL;
        status = al_charts_make(mesh, &edges, world, edge_m, &charts, error);
        if (status != AL_OK) break;
        rectangles = calloc(charts.count + (size_t)1, sizeof *rectangles);
        status = rectangles ? pack_charts(&charts, padding, settings->page_size, rectangles, &use->width,
                                          &use->height, error)
                            : al_fail(error, AL_IO, "mesh \"%s\": out of memory", mesh->name);
        if (status == AL_OK && use->width) status = set_uv1(scene, mesh, &charts, rectangles, use, error);
        if (status == AL_OK && !use->width && edge_m > sqrt(use->area)) /* each chart is one texel by now */
            status =
                al_fail(error, AL_BAD_INPUT,
                        "mesh \"%s\": %u charts do not fit a page of %u texels; a larger page_size is right",
                        mesh->name, charts.count, settings->page_size);
        *coarse = edge_m > wanted_m;
        edge_m *= 1.1;
        free(rectangles);
        al_charts_free(&charts);
    }
    al_edges_free(&edges);
    return status;
}

static al_status prepare_mesh(al_import *import, uint32_t index, al_atlas *atlas, mesh_use *use,
                              al_error *error)
{
    const al_lightmap_settings *settings = &import->description->lightmap;
    const al_mesh *mesh = &import->scene.meshes[index];
    bool coarse = false;
    al_status status = AL_BAD_INPUT;
    if (settings->uv == AL_UV_FILE && !mesh->uv1)
        return al_fail(
            error, AL_BAD_INPUT,
            "mesh \"%s\" has no second UV set, which \"uv\": \"file\" asks for; \"auto\" makes one",
            mesh->name);
    if (settings->uv != AL_UV_ATLAS && mesh->uv1)
        status = use_file_uv(mesh, atlas->texel_m, settings->page_size, use, &coarse, error);
    if (status == AL_BAD_INPUT && settings->uv != AL_UV_FILE) {
        use->width = use->height = 0;
        status = make_own_uv(&import->scene, index, settings, atlas->texel_m, use, &coarse, error);
        atlas->own_count++;
    }
    atlas->coarse_count += coarse;
    return status;
}

static void measure_uses(const al_scene *scene, mesh_use *uses)
{
    for (uint32_t i = 0; i < scene->instance_count; i++) {
        if (!is_lightmapped(&scene->instances[i])) continue;
        mesh_use *use = &uses[scene->instances[i].mesh];
        double area = area_in_space(scene, &scene->instances[i]);
        bool first = use->largest == AL_NO_INDEX;
        if (first || area > use->area) {
            use->largest = i;
            use->area = area;
        }
        use->least_area = first ? area : fmin(use->least_area, area);
    }
}

/* --- pages --- */

static al_status fill_pages(al_atlas *atlas, uint32_t padding, uint32_t page_size, al_error *error)
{
    al_pack_rectangle *rectangles = calloc(atlas->instance_count + (size_t)1, sizeof *rectangles);
    bool *before = calloc(atlas->instance_count + (size_t)1, sizeof *before);
    uint32_t done = 0, packed;
    al_status status = AL_OK;
    atlas->pages = calloc(atlas->instance_count + (size_t)1, sizeof *atlas->pages);
    if (!rectangles || !before || !atlas->pages) {
        status = al_fail(error, AL_IO, "out of memory for %u rectangles", atlas->instance_count);
        goto cleanup;
    }
    for (uint32_t i = 0; i < atlas->instance_count; i++)
        rectangles[i] = (al_pack_rectangle){.width = atlas->instances[i].width + padding,
                                            .height = atlas->instances[i].height + padding};
    for (; done < atlas->instance_count; done += packed) {
        uint32_t *page = atlas->pages[atlas->page_count];
        for (uint32_t i = 0; i < atlas->instance_count; i++) before[i] = rectangles[i].packed;
        status = al_pack(rectangles, atlas->instance_count, page_size + padding, &packed, error);
        if (status != AL_OK) break;
        for (uint32_t i = 0; i < atlas->instance_count; i++) {
            al_atlas_instance *to = &atlas->instances[i];
            if (before[i] || !rectangles[i].packed) continue;
            to->page = atlas->page_count;
            to->x = rectangles[i].x;
            to->y = rectangles[i].y;
            page[0] = to->x + to->width > page[0] ? to->x + to->width : page[0];
            page[1] = to->y + to->height > page[1] ? to->y + to->height : page[1];
        }
        atlas->page_count++;
    }
cleanup:
    free(rectangles);
    free(before);
    return status;
}

static al_status size_instances(const al_scene *scene, const mesh_use *uses, al_atlas *atlas, al_error *error)
{
    atlas->instances = calloc(scene->instance_count + (size_t)1, sizeof *atlas->instances);
    if (!atlas->instances)
        return al_fail(error, AL_IO, "out of memory for %u instances", scene->instance_count);
    for (uint32_t i = 0; i < scene->instance_count; i++) {
        if (!is_lightmapped(&scene->instances[i])) continue;
        const mesh_use *use = &uses[scene->instances[i].mesh];
        double area = area_in_space(scene, &scene->instances[i]);
        double ratio = use->area > 0 ? fmax(sqrt(area / use->area), LEAST_RATIO) : 1;
        atlas->instances[atlas->instance_count++] =
            (al_atlas_instance){.instance = i,
                                .width = (uint32_t)ceil(use->width * ratio - 1e-9),
                                .height = (uint32_t)ceil(use->height * ratio - 1e-9)};
    }
    return AL_OK;
}

al_status al_atlas_make(al_import *import, al_atlas *atlas, al_error *error)
{
    const al_lightmap_settings *settings = &import->description->lightmap;
    al_scene *scene = &import->scene;
    *atlas = (al_atlas){.texel_m = texel_m(import)};
    mesh_use *uses = calloc(scene->mesh_count + (size_t)1, sizeof *uses);
    al_status status = uses ? AL_OK : al_fail(error, AL_IO, "out of memory for %u meshes", scene->mesh_count);
    for (uint32_t m = 0; uses && m < scene->mesh_count; m++) uses[m].largest = AL_NO_INDEX;
    if (status == AL_OK && !(atlas->texel_m > 0))
        status = al_fail(error, AL_BAD_INPUT, "the lightmapped meshes have no extent");
    if (status == AL_OK) measure_uses(scene, uses);
    for (uint32_t m = 0; status == AL_OK && m < scene->mesh_count; m++)
        if (uses[m].largest != AL_NO_INDEX) status = prepare_mesh(import, m, atlas, &uses[m], error);
    if (status == AL_OK) status = size_instances(scene, uses, atlas, error);
    if (status == AL_OK) status = fill_pages(atlas, settings->padding_texels, settings->page_size, error);
    free(uses);
    if (status != AL_OK) al_atlas_free(atlas);
    return status;
}

void al_atlas_free(al_atlas *atlas)
{
    free(atlas->pages);
    free(atlas->instances);
    *atlas = (al_atlas){0};
}
