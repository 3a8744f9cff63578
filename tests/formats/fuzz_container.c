/* Everything that reads an asset, on bytes that anyone may have written: nothing may crash, and what the
 * checker accepts must be readable. Checksums would stop nearly every input at the door, so each is tried
 * twice, the second time with its checksums put right.
 *
 * The libFuzzer target (AIRLIGHT_FUZZ) and the replay in the tests run the same function. */
#include "fuzz_container.h"

#include <math.h>

#include "airlight/impulse_tables.h"
#include "airlight/lightmap.h"
#include "airlight/medium.h"
#include "airlight/probes.h"
#include "airlight/scene.h"
#include "airlight/translucent.h"
#include "forge.h"

#define REQUIRE(condition) \
    do { \
        if (!(condition)) { \
            fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition); \
            abort(); \
        } \
    } while (0)

static bool read_translucent(const al_file *file)
{
    al_translucent_info info;
    al_translucent_page page;
    const uint16_t *density;
    const uint8_t *blockers;
    float coefficients[64], answer[3];
    uint32_t used;
    const float position[3] = {0.1f, 0.05f, 0.1f}, direction[3] = {1, 2, 3};
    if (al_translucent_read(file, &info, NULL) != AL_OK) return false;
    bool good = al_translucent_read_grid(file, &info, &density, &blockers, NULL) == AL_OK;
    for (uint32_t p = 0; p < al_translucent_page_count(&info); p++) {
        if (al_translucent_read_page(file, &info, p, &page, NULL) != AL_OK) return false;
        for (uint32_t i = 0; i < page.count; i++)
            al_translucent_decode(&info, &page, i, info.channel_count - 1, coefficients);
    }
    REQUIRE(al_translucent_evaluate(file, &info, position, direction, answer, &used, NULL) == AL_OK);
    for (int c = 0; c < 3; c++) REQUIRE(answer[c] >= 0 && answer[c] <= 1);
    return good;
}

static bool read_measured(const al_file *file)
{
    for (uint32_t i = 0; i < al_measured_count(file); i++) {
        al_measured m;
        if (al_measured_read(file, i, &m, NULL) != AL_OK) return false;
        REQUIRE(m.count > 0 && isfinite(m.rmse) && isfinite(m.largest) && strlen(m.compared) < al_file_size(file));
    }
    return true;
}

static bool read_lightmap(const al_file *file)
{
    al_lightmap_info info;
    al_lightmap_page page;
    al_lightmap_answer answer;
    const float position[3] = {0.25f, 0.5f, 0.25f}, normal[3] = {0, 2, 0};
    if (al_lightmap_read(file, &info, NULL) != AL_OK) return false;
    for (uint32_t p = 0; p < info.page_count; p++) {
        if (al_lightmap_read_page(file, &info, p, &page, NULL) != AL_OK) return false;
        float value[3];
        al_lightmap_texel(&info, &page, AL_LAYER_SCATTERED, (size_t)page.width * page.height - 1, value);
        REQUIRE(isfinite(value[0]) && value[0] >= 0);
    }
    al_status status = al_lightmap_evaluate(file, &info, position, normal, &answer, NULL);
    if (status == AL_OK)
        for (int i = 0; i < 9; i++) REQUIRE(answer.irradiance[i / 3][i % 3] >= 0);
    return status == AL_OK || status == AL_USAGE; /* no triangle may face that way */
}

static bool read_scene(const al_file *file)
{
    al_scene scene;
    if (al_scene_read(file, &scene, NULL) != AL_OK) return false;
    double sum = 0;
    for (uint32_t m = 0; m < scene.mesh_count; m++) {
        const al_mesh *mesh = &scene.meshes[m];
        for (uint32_t i = 0; i < mesh->index_count; i++)
            sum += mesh->positions[3 * (size_t)mesh->indices[i]] * 1e-30;
        sum += (double)strlen(mesh->name);
    }
    for (uint32_t i = 0; i < scene.instance_count; i++)
        sum += scene.meshes[scene.instances[i].mesh].vertex_count;
    REQUIRE(isfinite(sum) && scene.camera_count > 0);
    al_scene_free(&scene);
    return true;
}

static bool read_impulse(const al_file *file)
{
    al_impulse_tables *tables;
    al_impulse_answer answer;
    if (al_impulse_tables_read(file, &tables, NULL) != AL_OK) return false;
    uint32_t events = al_impulse_tables_info(tables)->event_count;
    for (int i = 0; i < 12; i++) {
        al_impulse_query q = {.emitter = (al_impulse_emitter)(i % 3), .variant = (al_impulse_variant)(i / 6),
                              .first_event = 0, .last_event = events, .distance_m = i % 2 ? 1e-9 : 0.7,
                              .cos_normal = i / 3 % 2 ? -0.3 : 1, .sigma_s_per_m = 1.5, .sigma_a_per_m = i % 2,
                              .g = i / 3 % 2 ? 0.4 : 0};
        al_impulse_response(tables, &q, &answer);
        REQUIRE(answer.band_count == al_impulse_tables_info(tables)->band_count);
    }
    al_impulse_tables_free(tables);
    return true;
}

static bool read_medium(const al_file *file)
{
    al_medium_info info;
    al_medium_frame frame;
    al_medium_page page;
    al_medium_field *field;
    al_medium_sky sky;
    al_medium_depth depth;
    const uint16_t *depths = NULL;
    double sh[3][AL_SKY_TERMS_LIMIT], depth_sh[AL_DEPTH_TERMS_LIMIT];
    if (al_medium_read(file, &info, NULL) != AL_OK) return false;
    for (uint32_t i = 0; i < info.frame_count; i++) {
        if (al_medium_read_frame(file, &info, i, &frame, NULL) != AL_OK) return false;
        for (uint32_t p = 0; p < al_medium_page_count(&info, &frame); p++)
            if (al_medium_read_page(file, &info, i, p, &page, NULL) != AL_OK) return false;
    }
    if (al_medium_read_sky(file, &sky, NULL) != AL_OK) return false;
    if (al_medium_read_depth(file, &info, &depth, NULL) != AL_OK) return false;
    for (uint32_t i = 0; depth.size[0] && i < info.frame_count; i++)
        if (al_medium_read_depths(file, &depth, i, &depths, NULL) != AL_OK) return false;
    REQUIRE(al_medium_field_open(file, &info, &field, NULL) == AL_OK);
    for (int i = 0; i < 64; i++) {
        double place[3];
        for (int k = 0; k < 3; k++)
            place[k] = info.bounds_min_m[k] +
                       ((double)info.bounds_max_m[k] - info.bounds_min_m[k]) * (i >> 2 * k & 3) / 3;
        REQUIRE(al_medium_evaluate(field, place, i * 0.05) >= 0);
        if (sky.size[0]) al_medium_sky_at(&info, &sky, place, sh);
        if (depth.size[0]) al_medium_depth_at(&info, &depth, depths, 1, place, depth_sh);
    }
    al_medium_field_close(field);
    return true;
}

static bool read_probes(const al_file *file)
{
    al_probes probes;
    al_probe_place place = {.tetrahedron = 7};
    float sh[3][AL_PROBES_MAX_COUNT];
    if (al_probes_read(file, &probes, NULL) != AL_OK) return false;
    for (int i = 0; i < 8; i++) {
        const float position[3] = {(float)(i & 1), 0.3f * (float)i, -0.7f};
        float sum = 0;
        al_probes_locate(&probes, position, &place);
        al_probes_blend(&probes, &place, AL_LAYER_SCATTERED, sh);
        for (int k = 0; k < 4; k++) {
            REQUIRE(place.probes[k] < probes.info.probe_count && place.weights[k] >= 0);
            sum += place.weights[k];
        }
        REQUIRE(fabsf(sum - 1) < 1e-5f);
    }
    return true;
}

/* Number of findings, and a hash of them, to compare two ways of checking. */
static void count_finding(void *user, int rule, const char *message)
{
    uint64_t *sum = user;
    *sum = XXH64(message, strlen(message), *sum + (uint64_t)rule);
}

static void try_bytes(const uint8_t *data, size_t size)
{
    al_file *file;
    al_error error = {0};
    uint64_t first = 0, second = 0;
    al_status checked = al_file_check_memory("input", data, size, count_finding, &first, &error);
    REQUIRE(checked == AL_OK || checked == AL_BAD_INPUT);
    REQUIRE((checked == AL_OK) == (first == 0) && (checked == AL_OK || error.message[0]));
    REQUIRE(al_file_check_memory("input", data, size, count_finding, &second, NULL) == checked &&
            first == second);
    al_status opened = al_file_from_memory("input", data, size, NULL, &file, NULL);
    if (opened == AL_OK) {
        al_kind kind = al_file_kind(file);
        bool read = kind == AL_KIND_SCENE            ? read_scene(file)
                    : kind == AL_KIND_LIGHTMAP       ? read_lightmap(file)
                    : kind == AL_KIND_IMPULSE_TABLES ? read_impulse(file)
                    : kind == AL_KIND_PROBES         ? read_probes(file)
                    : kind == AL_KIND_MEDIUM         ? read_medium(file)
                                                     : read_translucent(file);
        read = read_measured(file) && read;
        REQUIRE(read || checked != AL_OK);
        al_file_close(file);
    } else {
        REQUIRE(checked != AL_OK);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    forged f = {calloc(size ? size : 1, 1),
                size}; /* of its own: aligned, and a sanitizer sees every read beyond */
    if (!f.data) return 0;
    if (size) memcpy(f.data, data, size);
    try_bytes(f.data, size);
    if (size >= 128) forge_put(f.data + 16, size, 8);
    forge_seal(f);
    try_bytes(f.data, size);
    free(f.data);
    return 0;
}
