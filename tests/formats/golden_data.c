#include "golden_data.h"

#include <string.h>

void golden_fill_translucent(al_coefficient_format format, golden_translucent *golden)
{
    static const uint32_t samples[] = {1, 4, 5}, pages[] = {1, 4, 2}, orders[] = {1, 3, 2};
    static const uint32_t channels[] = {1, 1, 3};
    al_translucent_info info = {
        .sample_count = samples[format], .page_size = pages[format], .order = orders[format],
        .channel_count = channels[format], .format = format, .direction_count = 128,
        .grid_size = {3, 2, 2}, .grid_origin_m = {-0.75f, -0.5f, -0.25f}, .voxel_m = 0.5f, .density_max = 2,
        .sigma_s_per_m = {1, 2, 4}, .sigma_a_per_m = {0.5f, 0.25f, 0.125f}, .g = -0.25f, .ior = 1.5f,
        .bounds_min_m = {-0.5f, -0.375f, -0.125f}, .bounds_max_m = {0.5f, 0.375f, 0.625f},
        .volume_m3 = 0.5, .radius_m = 0.0625, .rho_quantile = 3,
        .unity_mean = 0.9375f, .unity_deviation = 0.0625f, .unity_worst = 0.5f,
    };
    uint32_t set = info.order * info.order;
    memset(golden, 0, sizeof *golden);
    for (uint32_t i = 0; i < info.sample_count; i++) {
        float *b = golden->positions + 3 * i, *g = golden->gaussians + 4 * i;
        b[0] = -0.25f + 0.125f * (float)i;
        b[1] = 0.125f - 0.0625f * (float)i;
        b[2] = 0.03125f * (float)i;
        g[0] = 64 + (float)i;
        g[1] = 1 - 0.125f * (float)i;
        g[2] = 0.25f + 0.03125f * (float)i;
        g[3] = 2 - 0.25f * (float)i;
        float *coefficients = golden->coefficients + i * info.channel_count * set;
        for (uint32_t k = 0; k < info.channel_count * set; k++)
            coefficients[k] = k % set == 0 ? 2.5f - 0.125f * (float)i
                                           : 0.375f / (float)(k + 1) * (k % 2 ? 1 : -1);
    }
    for (int v = 0; v < 12; v++) {
        golden->density[v] = (uint16_t)(65535 - 5000 * v);
        golden->blockers[v] = (uint8_t)(20 * v);
    }
    const char *provenance = format == AL_COEFFICIENT_FLOAT ? NULL
                                                            : "{\"key\":\"0123456789abcdef\",\"seed\":7}";
    const uint8_t *blockers = format == AL_COEFFICIENT_BYTE ? golden->blockers : NULL;
    golden->data = (al_translucent_data){info, golden->positions, golden->gaussians, golden->coefficients,
                                         golden->density, blockers, provenance, NULL, 0};
}

void golden_fill_measured(golden_translucent *golden)
{
    static const al_measured measured[] = {
        {"transmittance \xc3\x97 3", "128 directions, order 1", "", 3, 0.125, 0.5, 0.25, 0},
        {"light", "", "W/m2", 1, 0.0625, 0, 0.0625, 0.03125}};
    golden_fill_translucent(AL_COEFFICIENT_FLOAT, golden);
    golden->data.measured = measured;
    golden->data.measured_count = 2;
}

/* --- lightmap --- */

static void fill_lightmap_page(golden_lightmap *golden, uint32_t page, uint32_t width, uint32_t height)
{
    uint32_t texels = width * height, bands = golden->data.info.directional_order;
    for (uint32_t layer = 0; layer < 3; layer++)
        for (uint32_t i = 0; i < 3 * texels; i++) {
            golden->irradiance[page][3 * texels * layer + i] =
                0.125f * (float)(layer + 1) * (float)(i / 3 + 1) + 0.25f * (float)(i % 3);
            for (uint32_t k = 0; k < bands * bands; k++)
                golden->sh[page][3 * texels * (layer * bands * bands + k) + i] =
                    (float)(layer + 1) / (float)(k + 1) * (k % 2 ? -0.5f : 1);
        }
    for (uint32_t i = 0; i < texels; i++) golden->state[page][i] = (uint8_t)(3 - i % 3);
    golden->pages[page] = (al_lightmap_source){width, height, golden->irradiance[page],
                                               bands ? golden->sh[page] : NULL, golden->state[page]};
}

void golden_fill_lightmap(al_lightmap_format format, golden_lightmap *golden)
{
    static const float corners[4][2] = {{0, 0}, {0, 1}, {1, 1}, {1, 0}};
    static const uint32_t order[6] = {0, 1, 2, 0, 2, 3};
    uint32_t count = format == AL_LIGHTMAP_HALF ? 2 : 1;
    memset(golden, 0, sizeof *golden);
    golden->data.info = (al_lightmap_info){
        .page_count = count, .instance_count = count, .format = format,
        .directional_order = format == AL_LIGHTMAP_HALF ? 2 : 0,
        .vertex_count = 4 * count, .triangle_count = 2 * count, .texel_m = 0.25f};
    fill_lightmap_page(golden, 0, count == 2 ? 4 : 3, count == 2 ? 3 : 2);
    if (count == 2) fill_lightmap_page(golden, 1, 2, 2);
    for (uint32_t i = 0; i < count; i++) {
        golden->instances[i] = (al_lightmap_instance){2 * i, i, {0.5f, 0.75f}, {0.25f, 0.125f}, 2 * i, 2};
        for (uint32_t k = 0; k < 4; k++) {
            float *v = golden->vertices + 5 * (4 * i + k);
            v[0] = corners[k][0] + 2 * (float)i;
            v[1] = 0.5f * (float)i;
            v[2] = corners[k][1];
            v[3] = 0.25f + 0.5f * corners[k][0];
            v[4] = 0.125f + 0.75f * corners[k][1];
        }
        for (uint32_t k = 0; k < 6; k++) golden->triangles[6 * i + k] = 4 * i + order[k];
    }
    golden->data.instances = golden->instances;
    golden->data.pages = golden->pages;
    golden->data.vertices = golden->vertices;
    golden->data.triangles = golden->triangles;
    golden->data.provenance_json = format == AL_LIGHTMAP_HALF ? "{\"key\":\"00112233aabbccdd\",\"samples\":64}" : NULL;
}

/* --- probes --- */

void golden_fill_probes(al_probes_data *data)
{
    static const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
    static const uint32_t tetrahedra[] = {0, 1, 2, 3, 1, 2, 3, 4};
    static float coefficients[5 * AL_LAYER_COUNT * 3 * 4];
    for (int i = 0; i < 5 * AL_LAYER_COUNT * 3 * 4; i++) {
        int k = i % 4, channel = i / 4 % 3, layer = i / 12 % AL_LAYER_COUNT, probe = i / 36;
        coefficients[i] = k ? -0.03125f * (float)k
                            : 1 + 0.25f * (float)probe + 0.125f * (float)layer + 0.0625f * (float)channel;
    }
    *data = (al_probes_data){{5, 2, 2}, positions, tetrahedra, coefficients, "{\"key\":\"8899aabbccddeeff\"}", NULL, 0};
}

/* --- scene --- */

static float quad_positions[] = {-1, 0, -1, -1, 0, 1, 1, 0, 1, 1, 0, -1};
static float quad_normals[] = {0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0};
static float quad_uv0[] = {0, 0, 0, 1, 1, 1, 1, 0};
static float quad_uv1[] = {0.25f, 0.25f, 0.25f, 0.75f, 0.75f, 0.75f, 0.75f, 0.25f};
static uint32_t quad_indices[] = {0, 1, 2, 0, 2, 3};
static al_submesh quad_submeshes[] = {{0, 3, 0}, {3, 3, 1}};

static float solid_positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
static float solid_normals[] = {-0.6f, -0.8f, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
static uint32_t solid_indices[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
static al_submesh solid_submeshes[] = {{0, 12, 1}};

static uint8_t pixels[] = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 128};
static float sky[] = {0.5f, 0.75f, 1, 0.25f, 0.25f, 0.25f};

static al_texture textures[] = {{"checker", 2, 2, true, pixels}};
static al_material materials[] = {
    {"ground", {0.5f, 0.25f, 0.125f}, 0, 0.75f, {0, 0, 0}, 1.5f, true,
     0, AL_NO_INDEX, AL_NO_INDEX, AL_NO_INDEX},
    {"wax", {1, 1, 1}, 0.25f, 0.5f, {0, 2, 0}, 1.25f, false, AL_NO_INDEX, 0, AL_NO_INDEX, AL_NO_INDEX},
};
static al_mesh meshes[] = {
    {"quad", 4, 6, 2, quad_positions, quad_normals, quad_uv0, quad_uv1, quad_indices, quad_submeshes},
    {"solid", 4, 12, 1, solid_positions, solid_normals, NULL, NULL, solid_indices, solid_submeshes},
};
static al_instance instances[] = {
    {"floor", 0, AL_ROLE_OPAQUE, AL_NO_INDEX, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1}, 0},
    {"candle", 1, AL_ROLE_TRANSLUCENT, 0, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, 0},
    {"wick", 1, AL_ROLE_BLOCKER, 0,
     {0.25f, 0, 0, 0, 0, 0.25f, 0, 0, 0, 0, 0.25f, 0, 0.125f, 0.125f, 0.125f, 1}, 0},
};
static al_medium media[] = {{"wax", {8, 6, 4}, {0.25f, 0.5f, 1}, 0.5f}};
static al_translucent_object translucents[] = {{"candle", 1, 0, "candle.translucent.air"}};
static al_light lights[] = {
    {"sun", AL_LIGHT_DIRECTIONAL, {0, -0.6f, -0.8f}, {3, 2.5f, 2}},
    {"lamp", AL_LIGHT_POINT, {1, 2, 3}, {10, 20, 30}},
};
static al_camera cameras[] = {{"main", {2, 1.5f, 3}, {0, 0.25f, 0}, {0, 1, 0}, 0.75f}};

void golden_fill_scene(al_scene *scene)
{
    *scene = (al_scene){
        1, 2, 2, 3, 1, 1, 2, 1, textures, materials, meshes, instances, media, translucents, lights, cameras,
        {.width = 2, .height = 1, .pixels = sky}, {0.5f, {0.125f, 0.25f, 0.5f}}, 0, NULL, {"", ""}, {0}, NULL,
    };
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < AL_ENVIRONMENT_ORDER * AL_ENVIRONMENT_ORDER; i++)
            scene->environment.sh[c][i] = (float)(c + 1) / (float)(i + 1);
}

static al_fog fogs[] = {
    {0, false, {0, 0, 0}, {0, 0, 0}, 0.5f, "", {0}},
    {0, true, {-2, -1, -0.5f}, {2, 1, 0.5f}, 0, "smoke.medium.air", {0}},
};

void golden_fill_lit_scene(al_scene *scene)
{
    static al_instance lit[sizeof instances / sizeof *instances];
    golden_fill_scene(scene);
    memcpy(lit, instances, sizeof instances);
    lit[0].lighting = AL_LIGHTING_LIGHTMAP;
    scene->instances = lit;
    scene->fogs = fogs;
    scene->fog_count = 2;
    scene->baked = (al_baked_light){"room.lightmap.air", "room.probes.air"};
}

#define UNIT_MATRIX {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}

static al_motion_node nodes[] = {
    {"root", AL_NO_INDEX, {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0.5f, 0, 0, 1}, {0, 0, 0}, {0, 0, 0, 1}, {1, 1, 1}},
    {"hand", 0, UNIT_MATRIX, {0, 1, 0}, {0, 0.6f, 0, 0.8f}, {1, 0.5f, 1}},
};
static float slide_times[] = {0, 0.5f, 2}, slide_values[] = {0, 0, 0, 1, 0, 0, 1, 0, -1};
static float turn_times[] = {0.25f, 1.25f};
static float turn_values[] = {0, 0, 0, 0, 0, 0, 0, 1, 0.5f, 0, 0, 0, 0.25f, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0};
static float bulge_times[] = {0, 1}, bulge_values[] = {0, 0.75f};
static al_motion_channel channels[] = {
    {0, AL_MOTION_TRANSLATION, AL_MOTION_LINEAR, 3, 3, slide_times, slide_values},
    {1, AL_MOTION_ROTATION, AL_MOTION_CUBIC, 2, 4, turn_times, turn_values},
    {1, AL_MOTION_WEIGHTS, AL_MOTION_STEP, 2, 1, bulge_times, bulge_values},
};
static al_motion_binding bindings[] = {
    {AL_MOTION_INSTANCE, 0, 0, {0.5f, 0, 0, 0, 0, 0.5f, 0, 0, 0, 0, 0.5f, 0, 0, -0.5f, 0, 1}},
    {AL_MOTION_LIGHT, 1, 1, UNIT_MATRIX},
    {AL_MOTION_CAMERA, 0, 1, UNIT_MATRIX},
};
static al_motion_joint joints[] = {{0, UNIT_MATRIX}, {1, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1}}};
static uint16_t influences[] = {0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0};
static float shares[] = {1, 0, 0, 0, 0.75f, 0.25f, 0, 0, 0.5f, 0.5f, 0, 0, 1, 0, 0, 0};
static float position_deltas[] = {0, 0, 0, 0.25f, 0, 0, 0, 0, 0, 0, 0, 0.125f};
static float normal_deltas[] = {0, 0, 0, 0, 0.5f, 0, 0, 0, 0, 0, 0, 0};
static al_motion_deform deforms[] = {
    {3, 1, 0, 2, 1, true, solid_positions, solid_normals, influences, shares, position_deltas, normal_deltas}};

void golden_fill_moving_scene(al_scene *scene)
{
    static al_mesh more[3];
    static al_instance moved[4];
    golden_fill_scene(scene);
    memcpy(more, meshes, sizeof meshes);
    more[2] = meshes[1];
    more[2].name = "arm";
    memcpy(moved, instances, sizeof instances);
    moved[3] = (al_instance){"arm", 2, AL_ROLE_OPAQUE, AL_NO_INDEX, UNIT_MATRIX, 0};
    scene->meshes = more;
    scene->mesh_count = 3;
    scene->instances = moved;
    scene->instance_count = 4;
    scene->motion = (al_motion){2, 3, 3, 2, 1, nodes, channels, bindings, joints, deforms};
}

/* --- impulse tables --- */

void golden_fill_impulse(golden_impulse *golden)
{
    enum { POINT = AL_IMPULSE_POINT, SUN = AL_IMPULSE_DIRECTIONAL, AREA = AL_IMPULSE_AREA };
    static const al_impulse_table tables[GOLDEN_TABLES] = {
        {POINT, 0, 1, 1, 4, 1, 0, 3, 0, NULL, NULL},      {POINT, 0, 2, 2, 4, 1, 0, 3, 0, NULL, NULL},
        {SUN, 0, 1, 1, 4, 1, 0, 3, 0, NULL, NULL},        {SUN, 0, 2, 2, 4, 1, 0, 3, 0, NULL, NULL},
        {AREA, 0, 1, 1, 4, 7, 0, 6, 0, NULL, NULL},       {AREA, 0, 2, 2, 4, 7, 0, 6, 0, NULL, NULL},
        {AREA, 1, 1, 1, 4, 7, 0, 4, 0, NULL, NULL},       {POINT, 0, 1, 1, 4, 1, 2, 3, 0, NULL, NULL},
        {POINT, 0, 1, 1, 4, 1, 0, 3, -0.5f, NULL, NULL},  {POINT, 0, 1, 2, 4, 1, 0, 3, 0, NULL, NULL},
    };
    memset(golden, 0, sizeof *golden);
    golden->angles[0] = -1.5f;
    golden->angles[1] = 0.75f;
    for (int t = 0; t < GOLDEN_TABLES; t++) {
        al_impulse_table *table = &golden->tables[t];
        *table = tables[t];
        table->values = golden->values[t];
        if (table->angle_count) table->angles = golden->angles;
        for (uint32_t i = 0; i < 7 * 4 * 6; i++)
            golden->values[t][i] = i % table->number_count == 0 ? 1 + (float)i / 64 : (float)(t + 1) / (float)(i + 2);
    }
    golden->data = (al_impulse_data){{3, 2, GOLDEN_TABLES, 0.0009765625, 1024, 0.0000152587890625, 0.0001220703125},
                                     golden->tables, "{\"key\":\"00112233445566aa\"}", NULL, 0};
}

/* --- medium --- */

/* 2 at the end of x alone, then a box of 4 before a slope of 1 + y / 2 + z / 8. */
float golden_density(uint32_t frame, uint32_t x, uint32_t y, uint32_t z)
{
    if (frame == 0) return x == 9 ? 2 : 0;
    return x < 8 ? 4 : 1 + 0.5f * (float)y + 0.125f * (float)z;
}

static al_status golden_slice(void *user, uint32_t frame, uint32_t z, float *density, al_error *error)
{
    (void)user, (void)error;
    for (uint32_t i = 0; i < 20; i++) density[i] = golden_density(frame, i % 10, i / 10, z);
    return AL_OK;
}

void golden_fill_medium(al_medium_data *data)
{
    static const float times_s[] = {0.5f, 1};
    *data = (al_medium_data){
        .info = {.size = {10, 2, 9}, .page_size = 1, .frame_count = 2, .extended = true,
                 .grid_to_world = {0.5f, 0, 0, 0, 0, 0.25f, 0, 0, 0, 0, 0.125f, 0, -2, -1, 3, 1},
                 .bounds_min_m = {-2.5f, -1.5f, 2.5f}, .bounds_max_m = {2.75f, 0.5f, 4.25f},
                 .sigma_s_per_m = {1, 2, 4}, .sigma_a_per_m = {0.5f, 0.25f, 0}, .g = 0.75f},
        .times_s = times_s, .slice = golden_slice, .provenance_json = "{\"key\":\"00000000deadbeef\"}"};
}

/* 3 x 2 x 2 points of order 2, a wall in the second cell. Number n of channel c at point i: depth i / 4, then
 * n + c / 4 - i / 16. */
void golden_fill_medium_sky(al_medium_data *data)
{
    static float values[5 * 12 * 3];
    static uint8_t planes[2 * 8];
    static al_medium_sky lattice = {
        .size = {3, 2, 2}, .order = 2, .grade = {0, 1.5f, 0}, .walled = true, .planes = planes};
    for (int k = 0; k < 5 * 12 * 3; k++) {
        int n = k / 36, i = k / 3 % 12, c = k % 3;
        values[k] = n ? (float)n + 0.25f * (float)c - 0.0625f * (float)i : 0.25f * (float)i;
    }
    for (int k = 0; k < 16; k++) planes[k] = k < 8 ? 63 : k % 2 ? 62 : 55;
    golden_fill_medium(data);
    data->sky = &lattice;
    data->sky_values = values;
}

/* 2 x 2 x 2 points of order 2. Number n at point i of frame f: n + 1 - i / 4 + 8 f units. */
static al_status golden_depths(void *user, uint32_t frame, float *coefficients, al_error *error)
{
    const al_medium_data *data = user;
    double unit_m = al_medium_depth_unit_m(&data->info, frame ? 4 : 2);
    (void)error;
    for (uint32_t k = 0; k < 4 * 8; k++)
        coefficients[k] = (float)(unit_m * (k / 8 + 1 - 0.25 * (k % 8) + 8 * frame));
    return AL_OK;
}

void golden_fill_medium_depth(al_medium_data *data)
{
    static const al_medium_depth depth = {.size = {2, 2, 2}, .order = 2};
    golden_fill_medium(data);
    data->depth = &depth;
    data->depths = golden_depths;
    data->depths_user = data;
}
