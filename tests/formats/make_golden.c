/* Writes the golden files into a folder: make_golden FOLDER. */
#include <stdio.h>
#include <sys/stat.h>

#include "golden_data.h"
#include "refusals.h"

static int report(const al_error *error)
{
    fprintf(stderr, "make_golden: %s\n", error->message);
    return (int)error->status;
}

static al_status write_valid(const char *folder, al_error *error)
{
    static const char *const names[] = {"float", "half", "byte"};
    char path[4096];
    al_scene scene;
    golden_translucent golden;
    for (int format = 0; format < 3; format++) {
        snprintf(path, sizeof path, "%s/translucent_%s_1_0.air", folder, names[format]);
        golden_fill_translucent((al_coefficient_format)format, &golden);
        al_status status = al_translucent_write(path, &golden.data, NULL, error);
        if (status != AL_OK) return status;
    }
    golden_fill_measured(&golden);
    snprintf(path, sizeof path, "%s/translucent_measured_1_0.air", folder);
    al_status status = al_translucent_write(path, &golden.data, NULL, error);
    if (status != AL_OK) return status;
    for (int format = 0; format < 2; format++) {
        golden_lightmap lightmap;
        snprintf(path, sizeof path, "%s/lightmap_%s_1_0.air", folder, names[format]);
        golden_fill_lightmap((al_lightmap_format)format, &lightmap);
        status = al_lightmap_write(path, &lightmap.data, NULL, error);
        if (status != AL_OK) return status;
    }
    golden_fill_scene(&scene);
    snprintf(path, sizeof path, "%s/scene_1_0.air", folder);
    status = al_scene_write(path, &scene, "{\"key\":\"fedcba9876543210\"}", NULL, error);
    if (status != AL_OK) return status;
    golden_fill_lit_scene(&scene);
    snprintf(path, sizeof path, "%s/scene_lit_1_0.air", folder);
    status = al_scene_write(path, &scene, NULL, NULL, error);
    if (status != AL_OK) return status;
    golden_fill_moving_scene(&scene);
    snprintf(path, sizeof path, "%s/scene_moving_1_0.air", folder);
    status = al_scene_write(path, &scene, NULL, NULL, error);
    if (status != AL_OK) return status;
    golden_impulse impulse;
    golden_fill_impulse(&impulse);
    snprintf(path, sizeof path, "%s/impulse_tables_1_0.air", folder);
    status = al_impulse_tables_write(path, &impulse.data, NULL, error);
    if (status != AL_OK) return status;
    al_probes_data probes;
    golden_fill_probes(&probes);
    snprintf(path, sizeof path, "%s/probes_1_0.air", folder);
    status = al_probes_write(path, &probes, NULL, error);
    if (status != AL_OK) return status;
    al_medium_data medium;
    golden_fill_medium(&medium);
    snprintf(path, sizeof path, "%s/medium_1_0.air", folder);
    status = al_medium_write(path, &medium, NULL, error);
    if (status != AL_OK) return status;
    golden_fill_medium_sky(&medium);
    snprintf(path, sizeof path, "%s/medium_sky_1_0.air", folder);
    status = al_medium_write(path, &medium, NULL, error);
    if (status != AL_OK) return status;
    golden_fill_medium_depth(&medium);
    snprintf(path, sizeof path, "%s/medium_depth_1_0.air", folder);
    return al_medium_write(path, &medium, NULL, error);
}

static al_status write_refusal(const char *folder, const refusal *r, al_error *error)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/%s.air", folder, r->base);
    forged base = forge_load(path), made = base.data ? refusal_make(r, base) : base;
    if (r->rule)
        snprintf(path, sizeof path, "%s/refuse_%d_%s.air", folder, r->rule, r->name);
    else
        snprintf(path, sizeof path, "%s/%s.air", folder, r->name);
    al_status status = made.data
                           ? al_write_file(path, made.data, made.size, error)
                           : al_fail(error, AL_BAD_INPUT, "%s: its changes do not fit %s", path, r->base);
    if (made.data != base.data) free(made.data);
    free(base.data);
    return status;
}

int main(int argc, char **argv)
{
    al_error error;
    if (argc != 2) {
        fprintf(stderr, "usage: make_golden FOLDER\n");
        return AL_USAGE;
    }
    mkdir(argv[1], 0777);
    if (write_valid(argv[1], &error) != AL_OK) return report(&error);
    for (size_t i = 0; i < refusal_count; i++)
        if (write_refusal(argv[1], &refusals[i], &error) != AL_OK) return report(&error);
    return 0;
}
