#include "place_probes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "geometry.h"

static const double probe_limit = 1 << 24, cells_across = 12, margin = 0.05 /* of a cell */;

static bool is_counted(const al_instance *instance, bool any_lightmap)
{
    if (instance->role != AL_ROLE_OPAQUE) return false;
    return any_lightmap ? instance->lighting == AL_LIGHTING_LIGHTMAP
                        : instance->lighting == AL_LIGHTING_DYNAMIC;
}

static bool find_box(const al_scene *scene, double low[3], double high[3])
{
    bool any_lightmap = false;
    for (uint32_t i = 0; i < scene->instance_count; i++)
        any_lightmap = any_lightmap || scene->instances[i].lighting == AL_LIGHTING_LIGHTMAP;
    for (int k = 0; k < 3; k++) low[k] = INFINITY, high[k] = -INFINITY;
    for (uint32_t i = 0; i < scene->instance_count; i++) {
        const al_mesh *mesh = &scene->meshes[scene->instances[i].mesh];
        double world[16], point[3];
        if (!is_counted(&scene->instances[i], any_lightmap)) continue;
        for (int k = 0; k < 16; k++) world[k] = scene->instances[i].world[k];
        for (size_t v = 0; v < mesh->vertex_count; v++) {
            for (int k = 0; k < 3; k++) point[k] = mesh->positions[3 * v + k];
            al_matrix_point(world, point, point);
            for (int k = 0; k < 3; k++) {
                low[k] = fmin(low[k], point[k]);
                high[k] = fmax(high[k], point[k]);
            }
        }
    }
    return low[0] <= high[0];
}

typedef struct lattice {
    double low[3], step[3], spacing_m;
    double cells[3]; /* whole numbers */
} lattice;

static double count_of(const lattice *l)
{
    double corners = 1, middles = 1;
    for (int k = 0; k < 3; k++) {
        corners *= l->cells[k] + 1;
        middles *= l->cells[k];
    }
    return corners + middles;
}

static bool lay_lattice(const al_import *import, lattice *l)
{
    double high[3], square = 0;
    if (!find_box(&import->scene, l->low, high)) return false;
    for (int k = 0; k < 3; k++) square += (high[k] - l->low[k]) * (high[k] - l->low[k]);
    l->spacing_m = import->description->probes.spacing_m;
    if (!(l->spacing_m > 0)) l->spacing_m = square > 0 ? sqrt(square) / cells_across : 1;
    for (int k = 0; k < 3; k++) {
        l->cells[k] = fmax(1, round((high[k] - l->low[k]) / l->spacing_m));
        l->step[k] = (high[k] - l->low[k]) / l->cells[k];
    }
    return true;
}

/* Corners of the cells, then their middles. */
static void fill_lattice(al_probe_places *places, const lattice *l)
{
    for (int middle = 0; middle < 2; middle++)
        for (int z = 0; z < l->cells[2] + 1 - middle; z++)
            for (int y = 0; y < l->cells[1] + 1 - middle; y++)
                for (int x = 0; x < l->cells[0] + 1 - middle; x++) {
                    double *point = places->points[places->count++];
                    const int at[3] = {x, y, z};
                    for (int k = 0; k < 3; k++) {
                        double inside = fmin(fmax(at[k] + 0.5 * middle, margin), l->cells[k] - margin);
                        point[k] = l->low[k] + inside * l->step[k];
                    }
                }
}

static al_status make_lattice(const al_import *import, al_probe_places *places, al_error *error)
{
    lattice l;
    if (!lay_lattice(import, &l))
        return al_fail(
            error, AL_BAD_INPUT,
            "probes: no mesh stands still, so there is no box to place them in; \"points\" are right");
    if (count_of(&l) > probe_limit)
        return al_fail(error, AL_BAD_INPUT,
                       "probes.spacing_m: %g m would take %.3g probes; at most %.3g are right", l.spacing_m,
                       count_of(&l), probe_limit);
    places->points = malloc((size_t)count_of(&l) * sizeof *places->points);
    if (!places->points) return al_fail(error, AL_IO, "out of memory for %.0f probes", count_of(&l));
    places->spacing_m = l.spacing_m;
    fill_lattice(places, &l);
    return AL_OK;
}

double al_probe_count(const al_import *import)
{
    lattice l;
    if (import->description->probes.point_count) return import->description->probes.point_count;
    return lay_lattice(import, &l) && count_of(&l) <= probe_limit ? count_of(&l) : 0;
}

al_status al_probe_places_make(const al_import *import, al_probe_places *places, al_error *error)
{
    const al_probe_settings *settings = &import->description->probes;
    *places = (al_probe_places){0};
    if (!settings->point_count) return make_lattice(import, places, error);
    places->points = malloc(settings->point_count * sizeof *places->points);
    if (!places->points) return al_fail(error, AL_IO, "out of memory for %u probes", settings->point_count);
    memcpy(places->points, settings->points, settings->point_count * sizeof *places->points);
    places->count = settings->point_count;
    return AL_OK;
}

void al_probe_places_free(al_probe_places *places)
{
    free(places->points);
    *places = (al_probe_places){0};
}
