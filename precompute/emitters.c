/* The probability per area of a point is in proportion to the mean emission of its material's texture (all
 * channels, both sides where it has two): for a material it is one number, whatever triangle the point is on.
 * A triangle is drawn in proportion to that times its area, then a point evenly in it. */
#include "emitters.h"

#include <math.h>
#include <stdlib.h>

#include "surface_color.h"

typedef struct emitter {
    uint32_t instance, triangle;
    double before; /* cumulative weight without this one */
} emitter;

struct al_emitters {
    const al_scene *from;
    const al_ray_scene *scene;
    double *weights;   /* [material_count] per square metre */
    emitter *emitters; /* [count], then one that holds the total */
    uint32_t count, room;
};

static al_status out_of_memory(al_error *error)
{
    return al_fail(error, AL_IO, "out of memory for the emissive triangles");
}

static void fill_weights(al_emitters *emitters)
{
    al_surface_colors colors = al_surface_colors_of(emitters->from);
    for (uint32_t i = 0; i < emitters->from->material_count; i++) {
        const al_material *material = &emitters->from->materials[i];
        double mean[3];
        al_surface_mean_emission(&colors, material, mean);
        emitters->weights[i] = (mean[0] + mean[1] + mean[2]) * (material->double_sided ? 2 : 1);
    }
}

static double area_m2(const al_ray_scene *scene, uint32_t instance, uint32_t triangle)
{
    al_surface_hit corner[3];
    double a[3], b[3];
    for (int i = 0; i < 3; i++) al_ray_scene_point(scene, instance, triangle, i == 1, i == 2, &corner[i]);
    for (int k = 0; k < 3; k++) {
        a[k] = corner[1].position[k] - corner[0].position[k];
        b[k] = corner[2].position[k] - corner[0].position[k];
    }
    double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
    return 0.5 * sqrt(x * x + y * y + z * z);
}

/* Appends a triangle; its weight goes to the one behind it. */
static bool push(al_emitters *emitters, uint32_t instance, uint32_t triangle, double weight)
{
    if (!(weight > 0)) return true;
    if (emitters->count + 1 == emitters->room) {
        emitter *grown = emitters->room > UINT32_MAX / 2
                             ? NULL
                             : realloc(emitters->emitters, sizeof(emitter) * 2 * emitters->room);
        if (!grown) return false;
        emitters->emitters = grown;
        emitters->room *= 2;
    }
    emitter *here = &emitters->emitters[emitters->count++];
    here->instance = instance;
    here->triangle = triangle;
    here[1] = (emitter){.before = here->before + weight};
    return true;
}

static bool push_instance(al_emitters *emitters, uint32_t instance)
{
    const al_instance *from = &emitters->from->instances[instance];
    const al_mesh *mesh = &emitters->from->meshes[from->mesh];
    if (from->role != AL_ROLE_OPAQUE || !al_ray_scene_triangle_count(emitters->scene, instance)) return true;
    for (uint32_t i = 0; i < mesh->submesh_count; i++) {
        const al_submesh *part = &mesh->submeshes[i];
        double weight = emitters->weights[part->material];
        for (uint32_t t = 0; weight > 0 && t < part->index_count / 3; t++) {
            uint32_t triangle = part->first_index / 3 + t;
            if (!push(emitters, instance, triangle, weight * area_m2(emitters->scene, instance, triangle)))
                return false;
        }
    }
    return true;
}

al_status al_emitters_create(const al_import *import, const al_ray_scene *scene, al_emitters **emitters,
                             al_error *error)
{
    *emitters = NULL;
    al_emitters *made = calloc(1, sizeof *made);
    if (!made) return out_of_memory(error);
    made->from = &import->scene;
    made->scene = scene;
    made->room = 16;
    made->weights = calloc(made->from->material_count + (size_t)1, sizeof *made->weights);
    made->emitters = calloc(made->room, sizeof *made->emitters);
    bool done = made->weights && made->emitters;
    if (done) fill_weights(made);
    for (uint32_t i = 0; done && i < made->from->instance_count; i++) done = push_instance(made, i);
    if (!done) {
        al_emitters_free(made);
        return out_of_memory(error);
    }
    *emitters = made;
    return AL_OK;
}

void al_emitters_free(al_emitters *emitters)
{
    if (!emitters) return;
    free(emitters->weights);
    free(emitters->emitters);
    free(emitters);
}

uint32_t al_emitters_count(const al_emitters *emitters)
{
    return emitters->count;
}

static double total(const al_emitters *emitters)
{
    return emitters->emitters[emitters->count].before;
}

double al_emitters_sample(const al_emitters *emitters, const double u[3], al_surface_hit *point)
{
    double target = u[0] * total(emitters), root = sqrt(u[1]);
    uint32_t low = 0, high = emitters->count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (emitters->emitters[middle].before <= target)
            low = middle;
        else
            high = middle;
    }
    const emitter *from = &emitters->emitters[low];
    al_ray_scene_point(emitters->scene, from->instance, from->triangle, root * (1 - u[2]), root * u[2],
                       point);
    return al_emitters_density(emitters, point->material);
}

double al_emitters_density(const al_emitters *emitters, const al_material *material)
{
    double sum = total(emitters);
    return sum > 0 ? emitters->weights[material - emitters->from->materials] / sum : 0;
}
