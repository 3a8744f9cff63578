/* Probes: linear fields are met exactly, walks and searches agree, points outside get their nearest side. */
#include <stdlib.h>
#include <unistd.h>

#include "../test.h"
#include "airlight/probes.h"
#include "airlight/scene.h"
#include "folder.h"

enum { EDGE = 7, PROBES = EDGE * EDGE * EDGE, CUBES = (EDGE - 1) * (EDGE - 1) * (EDGE - 1) };

/* A sheared grid of cubes, each cut into the six tetrahedra of its corner orders: every path from corner 0 to
 * corner 7 along edges. */
typedef struct mesh {
    float positions[PROBES * 3], coefficients[PROBES * AL_LAYER_COUNT * 3];
    uint32_t tetrahedra[CUBES * 6 * 4];
} mesh;

static double field(const float p[3], int layer, int channel)
{
    return 3 + layer + 0.5 * channel + 0.25 * p[0] - 0.5 * p[1] + (layer + 1) * 0.125 * p[2];
}

static uint32_t probe_at(uint32_t cube, int corner)
{
    uint32_t x = cube % (EDGE - 1), y = cube / (EDGE - 1) % (EDGE - 1), z = cube / (EDGE - 1) / (EDGE - 1);
    x += corner & 1;
    y += corner >> 1 & 1;
    z += corner >> 2 & 1;
    return (z * EDGE + y) * EDGE + x;
}

static void fill(mesh *m)
{
    static const int orders[6][2] = {{1, 2}, {2, 4}, {4, 1}, {2, 1}, {4, 2}, {1, 4}};
    for (int i = 0; i < PROBES; i++) {
        float x = (float)(i % EDGE), y = (float)(i / EDGE % EDGE), z = (float)(i / EDGE / EDGE);
        float *p = m->positions + 3 * i;
        p[0] = x + 0.25f * y;
        p[1] = 0.5f * y;
        p[2] = 2 * z - 0.125f * x;
        for (int k = 0; k < AL_LAYER_COUNT * 3; k++)
            m->coefficients[i * AL_LAYER_COUNT * 3 + k] = (float)field(p, k / 3, k % 3);
    }
    for (uint32_t t = 0; t < CUBES * 6; t++) {
        const int *o = orders[t % 6];
        /* the first three orders turn one way, the others the other */
        int second = t % 6 < 3 ? o[0] : o[0] | o[1], third = t % 6 < 3 ? o[0] | o[1] : o[0];
        const int corners[4] = {0, second, third, 7};
        for (int k = 0; k < 4; k++) m->tetrahedra[4 * t + k] = probe_at(t / 6, corners[k]);
    }
}

static float random_part(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return (float)(*state >> 8) * 0x1p-24f;
}

static void check_linear(const al_probes *probes)
{
    al_probe_place walked = {0};
    uint32_t state = 1;
    for (int n = 0; n < 5000; n++) {
        float x = 6 * random_part(&state), y = 6 * random_part(&state), z = 6 * random_part(&state);
        const float p[3] = {x + 0.25f * y, 0.5f * y, 2 * z - 0.125f * x};
        float sh[3][AL_PROBES_MAX_COUNT];
        al_probe_place fresh = {0};
        al_probes_locate(probes, p, &walked); /* from where the last point was */
        al_probes_locate(probes, p, &fresh);
        for (int layer = 0; layer < AL_LAYER_COUNT; layer++) {
            al_probes_blend(probes, &walked, (al_lightmap_layer)layer, sh);
            /* weights and coefficients are floats of 24 bits, the field is below 16 */
            for (int c = 0; c < 3; c++) CHECK_NEAR(sh[c][0], field(p, layer, c), 16 * 8 * 0x1p-24);
            al_probes_blend(probes, &fresh, (al_lightmap_layer)layer, sh);
            CHECK_NEAR(sh[1][0], field(p, layer, 1), 16 * 8 * 0x1p-24);
        }
    }
}

/* Far outside beyond a corner only that corner's probe is left, wherever the search began. Below the lowest
 * layer the answer is the foot of the perpendicular. */
static void check_outside(const al_probes *probes)
{
    const float corner[3] = {-100, -100, -100};
    /* the lowest layer is spanned by (1, 0, -0.125) and (0.25, 0.5, 0); its normal: */
    const float normal[3] = {0.0625f, -0.03125f, 0.5f}, on_it[3] = {3.75f, 1.5f, -0.375f};
    float below[3], sh[3][AL_PROBES_MAX_COUNT];
    al_probe_place place = {0};
    for (uint32_t start = 0; start < CUBES * 6; start += 97) {
        float found[3] = {0, 0, 0}, sum = 0;
        place = (al_probe_place){.tetrahedron = start};
        al_probes_locate(probes, corner, &place);
        for (int k = 0; k < 4; k++) {
            for (int i = 0; i < 3; i++)
                found[i] += place.weights[k] * probes->positions[3 * place.probes[k] + i];
            sum += place.weights[k];
        }
        CHECK(found[0] == 0 && found[1] == 0 && found[2] == 0);
        CHECK_NEAR(sum, 1, 1e-6);
    }
    for (int i = 0; i < 3; i++) below[i] = on_it[i] - 20 * normal[i];
    al_probes_locate(probes, below, &place);
    al_probes_blend(probes, &place, AL_LAYER_SURFACE, sh);
    CHECK_NEAR(sh[0][0], field(on_it, 0, 0), 1e-5);
}

static void check_nearest(const char *path, mesh *m)
{
    al_probes_data data = {{2, 0, 1}, m->positions, NULL, m->coefficients, NULL, NULL, 0};
    const float near_second[3] = {0.75f, 5, 0};
    al_error error = {0};
    al_file *file;
    al_probes probes;
    al_probe_place place = {0};
    CHECK(al_probes_write(path, &data, NULL, &error) == AL_OK);
    CHECK(al_file_open(path, NULL, &file, &error) == AL_OK);
    CHECK(al_probes_read(file, &probes, &error) == AL_OK);
    al_probes_locate(&probes, near_second, &place);
    CHECK(place.probes[0] == 1 && place.weights[0] == 1 && place.weights[1] == 0);
    al_file_close(file);
}

int main(void)
{
    static mesh m;
    char folder[256], path[512];
    al_error error = {0};
    al_file *file;
    al_probes probes;
    if (!folder_make(folder, sizeof folder)) return test_skip("no temporary folder");
    snprintf(path, sizeof path, "%s/probes.air", folder);
    fill(&m);
    al_probes_data data = {{PROBES, CUBES * 6, 1}, m.positions, m.tetrahedra, m.coefficients, NULL, NULL, 0};
    CHECK(al_probes_write(path, &data, NULL, &error) == AL_OK);
    CHECK(al_file_open(path, NULL, &file, &error) == AL_OK);
    if (!file) return test_end();
    CHECK(al_probes_read(file, &probes, &error) == AL_OK);
    if (probes.info.probe_count == PROBES) {
        check_linear(&probes);
        check_outside(&probes);
    }
    al_file_close(file);
    check_nearest(path, &m);
    m.tetrahedra[0] = PROBES;
    CHECK(al_probes_write(path, &data, NULL, &error) == AL_BAD_INPUT);
    unlink(path);
    CHECK(rmdir(folder) == 0);
    return test_end();
}
