/* Golden files: today's writer makes them, today's reader reads them, nothing that is not whole is read. */
#include <stdlib.h>
#include <unistd.h>

#include "../test.h"
#include "folder.h"
#include "golden_data.h"
#include "refusals.h"
#include "rules.h"

static const char *const valid[] = {"translucent_float_1_0", "translucent_half_1_0", "translucent_byte_1_0",
                                    "scene_1_0",            "scene_lit_1_0",
                                    "scene_moving_1_0",
                                    "impulse_tables_1_0",   "lightmap_float_1_0", "lightmap_half_1_0",
                                    "medium_1_0",           "medium_sky_1_0",     "medium_depth_1_0",
                                    "probes_1_0",           "translucent_measured_1_0"};

static forged load_golden(const char *name)
{
    char path[1024];
    snprintf(path, sizeof path, "%s/%s.air", AIRLIGHT_GOLDEN, name);
    forged f = forge_load(path);
    if (!f.data) {
        fprintf(stderr, "%s: cannot be read\n", path);
        exit(1);
    }
    return f;
}

static void refusal_file(const refusal *r, char *name, size_t size)
{
    if (r->rule)
        snprintf(name, size, "refuse_%d_%s", r->rule, r->name);
    else
        snprintf(name, size, "%s", r->name);
}

/* --- reading --- */

typedef struct seen {
    int rule; /* looked for */
    int times, all;
} seen;

static void see(void *user, int rule, const char *message)
{
    seen *s = user;
    s->all++;
    s->times += rule == s->rule;
    CHECK(message[0] != 0 && !strchr(message, '\n'));
}

static al_status read_lightmap(const al_file *file, al_error *error)
{
    static const float position[3] = {0.25f, 0.5f, 0.25f}, normal[3] = {0, 2, 0};
    al_lightmap_info info;
    al_lightmap_page page;
    al_lightmap_answer answer; /* evaluating looks at instances and geometry */
    al_status status = al_lightmap_read(file, &info, error);
    for (uint32_t p = 0; status == AL_OK && p < info.page_count; p++)
        status = al_lightmap_read_page(file, &info, p, &page, error);
    if (status == AL_OK) status = al_lightmap_evaluate(file, &info, position, normal, &answer, error);
    return status;
}

static al_status read_medium(const al_file *file, al_error *error)
{
    al_medium_info info;
    al_medium_frame frame;
    al_medium_page page;
    al_medium_sky sky;
    al_medium_depth depth;
    const uint16_t *depths;
    al_status status = al_medium_read(file, &info, error);
    for (uint32_t i = 0; status == AL_OK && i < info.frame_count; i++) {
        status = al_medium_read_frame(file, &info, i, &frame, error);
        for (uint32_t p = 0; status == AL_OK && p < al_medium_page_count(&info, &frame); p++)
            status = al_medium_read_page(file, &info, i, p, &page, error);
    }
    if (status == AL_OK) status = al_medium_read_sky(file, &sky, error);
    if (status == AL_OK) status = al_medium_read_depth(file, &info, &depth, error);
    for (uint32_t i = 0; status == AL_OK && depth.size[0] && i < info.frame_count; i++)
        status = al_medium_read_depths(file, &depth, i, &depths, error);
    return status;
}

/* Opens and reads all of it, as the runtime would. */
static al_status read_whole(const char *name, forged f, al_error *error)
{
    al_file *file;
    al_status status = al_file_from_memory(name, f.data, f.size, NULL, &file, error);
    if (status != AL_OK) return status;
    if (al_file_kind(file) == AL_KIND_SCENE) {
        al_scene scene;
        status = al_scene_read(file, &scene, error);
        al_scene_free(&scene);
    } else if (al_file_kind(file) == AL_KIND_IMPULSE_TABLES) {
        al_impulse_tables *tables;
        status = al_impulse_tables_read(file, &tables, error);
        al_impulse_tables_free(tables);
    } else if (al_file_kind(file) == AL_KIND_LIGHTMAP) {
        status = read_lightmap(file, error);
    } else if (al_file_kind(file) == AL_KIND_PROBES) {
        al_probes probes;
        status = al_probes_read(file, &probes, error);
    } else if (al_file_kind(file) == AL_KIND_MEDIUM) {
        status = read_medium(file, error);
    } else {
        al_translucent_info info;
        al_translucent_page page;
        const uint16_t *density;
        const uint8_t *blockers;
        status = al_translucent_read(file, &info, error);
        if (status == AL_OK) status = al_translucent_read_grid(file, &info, &density, &blockers, error);
        for (uint32_t p = 0; status == AL_OK && p < al_translucent_page_count(&info); p++)
            status = al_translucent_read_page(file, &info, p, &page, error);
    }
    for (uint32_t i = 0; status == AL_OK && i < al_measured_count(file); i++) {
        al_measured measured;
        status = al_measured_read(file, i, &measured, error);
    }
    al_file_close(file);
    return status;
}

static void test_valid(void)
{
    al_error error = {0};
    for (size_t i = 0; i < sizeof valid / sizeof *valid; i++) {
        forged f = load_golden(valid[i]);
        CHECK(al_file_check_memory(valid[i], f.data, f.size, NULL, NULL, &error) == AL_OK);
        CHECK(read_whole(valid[i], f, &error) == AL_OK);
        free(f.data);
    }
}

static void test_refusals(void)
{
    char name[256], path[1024];
    for (size_t i = 0; i < refusal_count; i++) {
        al_error error = {0}, file_error = {0};
        seen found = {.rule = refusals[i].rule}, on_disk = found;
        refusal_file(&refusals[i], name, sizeof name);
        snprintf(path, sizeof path, "%s/%s.air", AIRLIGHT_GOLDEN, name);
        forged f = load_golden(name);
        al_status expected = refusals[i].rule ? AL_BAD_INPUT : AL_OK;
        al_status in_memory = al_file_check_memory(path, f.data, f.size, see, &found, &error);
        al_status in_file = al_file_check(path, see, &on_disk, &file_error);
        if (in_memory != expected || (found.times > 0) != (refusals[i].rule != 0))
            fprintf(stderr, "%s: status %d, rule found %d times: %s\n", name, in_memory, found.times,
                    error.message);
        CHECK(in_memory == expected && in_file == expected);
        CHECK((found.times > 0) == (refusals[i].rule != 0));
        CHECK(found.all == on_disk.all && !strcmp(error.message, file_error.message));
        if (expected != AL_OK) CHECK(!strncmp(error.message, path, strlen(path)));
        /* What the checker refuses, reading refuses, but for the provenance: it is optional. */
        if (refusals[i].rule != AL_RULE_PROVENANCE) CHECK(read_whole(path, f, &error) == expected);
        free(f.data);
    }
}

/* Every rule has a golden file that breaks it. */
static void test_coverage(void)
{
#define COUNT_RULE(name, number, text) {number, #name},
    static const struct {
        int number;
        const char *name;
    } rules[] = {AL_RULES(COUNT_RULE)};
    for (size_t r = 0; r < sizeof rules / sizeof *rules; r++) {
        bool covered = false;
        for (size_t i = 0; i < refusal_count; i++) covered = covered || refusals[i].rule == rules[r].number;
        if (!covered) fprintf(stderr, "no golden file breaks %s\n", rules[r].name);
        CHECK(covered);
    }
}

/* --- damage --- */

static void test_every_bit(const char *name)
{
    forged f = load_golden(name);
    uint64_t accepted = 0;
    for (size_t bit = 0; bit < 8 * f.size; bit++) {
        f.data[bit / 8] ^= (uint8_t)(1 << bit % 8);
        if (al_file_check_memory(name, f.data, f.size, NULL, NULL, NULL) != AL_BAD_INPUT) accepted++;
        if (read_whole(name, f, NULL) != AL_BAD_INPUT) {
            /* The provenance is optional: a reader need not look at it, the checker does. */
            uint8_t *provenance = forge_chunk(f, "PROV", 0);
            if (!provenance || bit / 8 < (size_t)(provenance - f.data) ||
                bit / 8 >= (size_t)(provenance - f.data) + 64)
                accepted++;
        }
        f.data[bit / 8] ^= (uint8_t)(1 << bit % 8);
    }
    CHECK(accepted == 0);
    free(f.data);
}

static void test_every_truncation(const char *name)
{
    forged f = load_golden(name);
    uint64_t accepted = 0;
    for (size_t size = 0; size < f.size; size++) {
        forged cut = {malloc(size ? size : 1),
                      size}; /* of its own, so that a sanitizer sees every read beyond */
        if (!cut.data) break;
        memcpy(cut.data, f.data, size);
        accepted += al_file_check_memory(name, cut.data, size, NULL, NULL, NULL) != AL_BAD_INPUT;
        accepted += read_whole(name, cut, NULL) != AL_BAD_INPUT;
        free(cut.data);
    }
    CHECK(accepted == 0);
    free(f.data);
}

/* --- writing --- */

/* The same bytes, once the golden file's writer name stands in both: versions of airlight may differ. */
static void compare_bytes(const char *name, const char *path)
{
    forged wanted = load_golden(name), made = forge_load(path);
    CHECK(made.data && made.size == wanted.size);
    if (made.data && made.size == wanted.size) {
        memcpy(made.data + 40, wanted.data + 40, 64);
        forge_seal_header(made);
        CHECK(!memcmp(made.data, wanted.data, made.size));
    }
    free(wanted.data);
    free(made.data);
    unlink(path);
}

static void test_same_bytes(const char *folder)
{
    char path[512];
    al_error error = {0};
    golden_translucent golden;
    al_scene scene;
    snprintf(path, sizeof path, "%s/made.air", folder);
    for (int format = 0; format < 3; format++) {
        golden_fill_translucent((al_coefficient_format)format, &golden);
        CHECK(al_translucent_write(path, &golden.data, NULL, &error) == AL_OK);
        compare_bytes(valid[format], path);
    }
    golden_fill_measured(&golden);
    CHECK(al_translucent_write(path, &golden.data, NULL, &error) == AL_OK);
    compare_bytes("translucent_measured_1_0", path);
    for (int format = 0; format < 2; format++) {
        golden_lightmap lightmap;
        golden_fill_lightmap((al_lightmap_format)format, &lightmap);
        CHECK(al_lightmap_write(path, &lightmap.data, NULL, &error) == AL_OK);
        compare_bytes(format ? "lightmap_half_1_0" : "lightmap_float_1_0", path);
    }
    golden_fill_scene(&scene);
    CHECK(al_scene_write(path, &scene, "{\"key\":\"fedcba9876543210\"}", NULL, &error) == AL_OK);
    compare_bytes("scene_1_0", path);
    golden_fill_lit_scene(&scene);
    CHECK(al_scene_write(path, &scene, NULL, NULL, &error) == AL_OK);
    compare_bytes("scene_lit_1_0", path);
    golden_fill_moving_scene(&scene);
    CHECK(al_scene_write(path, &scene, NULL, NULL, &error) == AL_OK);
    compare_bytes("scene_moving_1_0", path);
    golden_impulse impulse;
    golden_fill_impulse(&impulse);
    CHECK(al_impulse_tables_write(path, &impulse.data, NULL, &error) == AL_OK);
    compare_bytes("impulse_tables_1_0", path);
    al_medium_data medium;
    golden_fill_medium(&medium);
    CHECK(al_medium_write(path, &medium, NULL, &error) == AL_OK);
    compare_bytes("medium_1_0", path);
    golden_fill_medium_sky(&medium);
    CHECK(al_medium_write(path, &medium, NULL, &error) == AL_OK);
    compare_bytes("medium_sky_1_0", path);
    golden_fill_medium_depth(&medium);
    CHECK(al_medium_write(path, &medium, NULL, &error) == AL_OK);
    compare_bytes("medium_depth_1_0", path);
    al_probes_data probes;
    golden_fill_probes(&probes);
    CHECK(al_probes_write(path, &probes, NULL, &error) == AL_OK);
    compare_bytes("probes_1_0", path);
    for (size_t i = 0; i < refusal_count; i++) {
        char name[256];
        refusal_file(&refusals[i], name, sizeof name);
        forged base = load_golden(refusals[i].base), wanted = load_golden(name),
               made = refusal_make(&refusals[i], base);
        CHECK(made.data && made.size == wanted.size && !memcmp(made.data, wanted.data, made.size));
        free(base.data);
        free(wanted.data);
        free(made.data);
    }
}

int main(void)
{
    char folder[256];
    if (!folder_make(folder, sizeof folder)) return test_skip("no temporary folder");
    test_valid();
    test_refusals();
    test_coverage();
    for (size_t i = 0; i < sizeof valid / sizeof *valid; i++) {
        test_every_bit(valid[i]);
        test_every_truncation(valid[i]);
    }
    test_same_bytes(folder);
    CHECK(rmdir(folder) == 0);
    return test_end();
}
