/* Translucent assets: what goes in comes out, within the error of its encoding; questions; refusals. */
#include "airlight/translucent.h"

#include <stdlib.h>
#include <unistd.h>

#include "../test.h"
#include "airlight/formulas.h"
#include "folder.h"
#include "forge.h"

enum { SAMPLES = 1000, PAGE_SIZE = 300, ORDER = 5, SET = ORDER * ORDER, CHANNELS = 3 };

typedef struct cloud {
    al_translucent_data data;
    float positions[SAMPLES * 3], gaussians[SAMPLES * 4], coefficients[SAMPLES * CHANNELS * SET];
    uint16_t density[4 * 5 * 6];
    uint8_t blockers[4 * 5 * 6];
} cloud;

static double random_unit(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) / 0x1p53;
}

static cloud *make_cloud(al_coefficient_format format)
{
    uint64_t state = 5;
    cloud *c = calloc(1, sizeof *c);
    if (!c) exit(1);
    for (int i = 0; i < SAMPLES * 3; i++) c->positions[i] = (float)(2 * random_unit(&state) - 1);
    for (int i = 0; i < SAMPLES; i++) {
        c->gaussians[4 * i] = (float)(50 + 50 * random_unit(&state));
        c->gaussians[4 * i + 1] = (float)random_unit(&state);
        c->gaussians[4 * i + 2] = (float)(0.1 + 0.2 * random_unit(&state));
        c->gaussians[4 * i + 3] = (float)random_unit(&state);
    }
    for (int i = 0; i < SAMPLES * CHANNELS * SET; i++)
        c->coefficients[i] =
            (float)(i % SET == 0 ? 1 + random_unit(&state) : (random_unit(&state) - 0.5) / (1 + i % SET));
    for (int i = 0; i < 4 * 5 * 6; i++) {
        c->density[i] = (uint16_t)(i * 500);
        c->blockers[i] = (uint8_t)i;
    }
    c->data = (al_translucent_data){{.sample_count = SAMPLES,
                                     .page_size = PAGE_SIZE,
                                     .order = ORDER,
                                     .channel_count = CHANNELS,
                                     .format = format,
                                     .direction_count = 512,
                                     .grid_size = {4, 5, 6},
                                     .grid_origin_m = {-1, -1, -1},
                                     .voxel_m = 0.4f,
                                     .density_max = 3,
                                     .sigma_s_per_m = {1, 2, 3},
                                     .sigma_a_per_m = {0.1f, 0.2f, 0.3f},
                                     .g = 0.3f,
                                     .ior = 1.3f,
                                     .bounds_min_m = {-1, -1, -1},
                                     .bounds_max_m = {1, 1, 1},
                                     .volume_m3 = 8,
                                     .radius_m = 0.1,
                                     .rho_quantile = 2,
                                     .unity_mean = 1,
                                     .unity_deviation = 0.1f,
                                     .unity_worst = 0.4f},
                                    c->positions,
                                    c->gaussians,
                                    c->coefficients,
                                    c->density,
                                    c->blockers,
                                    "{\"seed\": 1}",
                                    NULL,
                                    0};
    return c;
}

static bool same_info(const al_translucent_info *a, const al_translucent_info *b)
{
    al_translucent_info left = *a;
    left.has_blockers = b->has_blockers;
    return !memcmp(&left, b, sizeof left); /* no padding: 34 words, two doubles */
}

/* Largest error of a coefficient, as a share of what its encoding allows. */
static double encoding_error(const al_translucent_info *info, const float *wanted, const float *found)
{
    double worst = 0, largest = 0;
    for (int k = 0; k < SET; k++) largest = fmax(largest, fabs(wanted[k]));
    for (int k = 0; k < SET; k++) {
        /* half: 2^-11 of the value, 2^-25 below 2^-14. byte: half a step of largest/127, and float rounding.
         */
        double allowed = info->format == AL_COEFFICIENT_FLOAT  ? 0
                         : info->format == AL_COEFFICIENT_HALF ? fmax(fabs(wanted[k]) * 0x1p-11, 0x1p-25)
                                                               : largest / 254 * (1 + 1e-5);
        double error = fabs((double)found[k] - wanted[k]);
        worst = fmax(worst, error == 0 ? 0 : error / allowed);
    }
    return worst;
}

static void check_pages(const al_file *file, const al_translucent_info *info, const cloud *c)
{
    float coefficients[SET];
    al_translucent_page page;
    al_error error = {0};
    double worst = 0;
    CHECK(al_translucent_page_count(info) == 4);
    for (uint32_t p = 0, next = 0; p < al_translucent_page_count(info); p++, next += PAGE_SIZE) {
        CHECK(al_translucent_read_page(file, info, p, &page, &error) == AL_OK);
        CHECK(page.first == next && page.count == (p < 3 ? PAGE_SIZE : SAMPLES - 3 * PAGE_SIZE));
        CHECK((page.scales != NULL) == (info->format == AL_COEFFICIENT_BYTE));
        CHECK((uintptr_t)page.positions % 64 == 0 && (uintptr_t)page.gaussians % 64 == 0 &&
              (uintptr_t)page.coefficients % 64 == 0);
        CHECK(!memcmp(page.positions, c->positions + 3 * next, page.count * 12));
        CHECK(!memcmp(page.gaussians, c->gaussians + 4 * next, page.count * 16));
        for (uint32_t i = 0; i < page.count; i++)
            for (uint32_t channel = 0; channel < CHANNELS; channel++) {
                al_translucent_decode(info, &page, i, channel, coefficients);
                worst = fmax(worst,
                             encoding_error(info, c->coefficients + ((next + i) * CHANNELS + channel) * SET,
                                            coefficients));
            }
    }
    CHECK(worst <= 1);
    if (info->format != AL_COEFFICIENT_FLOAT) CHECK(worst > 0.5); /* the bound is one, not an excuse */
}

/* The definition, straight from the numbers that were written. */
static uint32_t brute_force(const cloud *c, const double x[3], const double w[3], double transmittance[3])
{
    double basis[AL_SH_MAX_COUNT], total = 0, sums[3] = {0};
    uint32_t used = 0;
    al_sh_basis(ORDER, w[0], w[1], w[2], basis);
    for (int i = 0; i < SAMPLES; i++) {
        double d[3] = {x[0] - c->positions[3 * i], x[1] - c->positions[3 * i + 1],
                       x[2] - c->positions[3 * i + 2]};
        double square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        if (square > (double)c->gaussians[4 * i + 2] * c->gaussians[4 * i + 2]) continue;
        double gamma = c->gaussians[4 * i + 1] * exp(-c->gaussians[4 * i] * square);
        used++;
        total += gamma;
        for (int channel = 0; channel < CHANNELS; channel++)
            for (int k = 0; k < SET; k++)
                sums[channel] += gamma * basis[k] * c->coefficients[(i * CHANNELS + channel) * SET + k];
    }
    for (int channel = 0; channel < CHANNELS; channel++)
        transmittance[channel] = fmin(fmax(used ? sums[channel] / total : 1, 0), 1);
    return used;
}

/* psi is a sum of 25 coefficients of at most 2 times harmonics below 1.1 (sqrt(9/(4 pi)) is 0.85, the
 * tesseral ones of band 4 reach 1.07). An encoding error e of each gives at most 25 x 1.1 e: e is 2 x 2^-11
 * for halves, 2/254 for bytes; floats leave the rounding of the answer itself. */
static void check_answers(const al_file *file, const al_translucent_info *info, const cloud *c)
{
    static const double bounds[] = {1e-6, 25 * 1.1 * 2 * 0x1p-11, 25 * 1.1 * 2 / 254};
    uint64_t state = 6;
    al_error error = {0};
    for (int trial = 0; trial < 20; trial++) {
        float x[3], w[3], answer[3];
        double exact_x[3], exact_w[3], length = 0, wanted[3];
        uint32_t used;
        for (int i = 0; i < 3; i++) {
            exact_x[i] = x[i] = (float)(2 * random_unit(&state) - 1);
            w[i] = (float)(6 * random_unit(&state) - 3); /* any length */
            length += (double)w[i] * w[i];
        }
        for (int i = 0; i < 3; i++) exact_w[i] = w[i] / sqrt(length);
        CHECK(al_translucent_evaluate(file, info, x, w, answer, &used, &error) == AL_OK);
        CHECK(used == brute_force(c, exact_x, exact_w, wanted));
        for (int i = 0; i < 3; i++) CHECK_NEAR(answer[i], wanted[i], bounds[info->format]);
    }
}

static void test_format(const char *path, al_coefficient_format format)
{
    cloud *c = make_cloud(format);
    al_error error = {0};
    al_file *file = NULL;
    al_translucent_info info;
    const uint16_t *density;
    const uint8_t *blockers;
    uint64_t bytes = 0;
    CHECK(al_translucent_write(path, &c->data, &bytes, &error) == AL_OK);
    CHECK(al_file_open(path, NULL, &file, &error) == AL_OK && al_file_size(file) == bytes);
    if (!file) exit(1);
    CHECK(al_translucent_read(file, &info, &error) == AL_OK && same_info(&c->data.info, &info) &&
          info.has_blockers);
    CHECK(al_translucent_read_grid(file, &info, &density, &blockers, &error) == AL_OK);
    CHECK(!memcmp(density, c->density, sizeof c->density) &&
          !memcmp(blockers, c->blockers, sizeof c->blockers));
    check_pages(file, &info, c);
    check_answers(file, &info, c);
    al_file_close(file);
    unlink(path);
    free(c);
}

static void test_questions(const char *path)
{
    cloud *c = make_cloud(AL_COEFFICIENT_FLOAT);
    al_error error = {0};
    al_file *file;
    al_translucent_info info;
    float answer[3];
    uint32_t used;
    const float far[3] = {50, 0, 0}, up[3] = {0, 1, 0}, nowhere[3] = {0}, wild[3] = {NAN, 0, 0};
    CHECK(al_translucent_write(path, &c->data, NULL, &error) == AL_OK);
    CHECK(al_file_open(path, NULL, &file, &error) == AL_OK &&
          al_translucent_read(file, &info, &error) == AL_OK);
    CHECK(al_translucent_evaluate(file, &info, far, up, answer, &used, &error) == AL_OK && used == 0);
    CHECK(answer[0] == 1 && answer[1] == 1 && answer[2] == 1);
    CHECK(al_translucent_evaluate(file, &info, far, nowhere, answer, &used, &error) == AL_USAGE);
    CHECK(al_translucent_evaluate(file, &info, wild, up, answer, &used, &error) == AL_USAGE);
    al_file_close(file);
    unlink(path);
    free(c);
}

/* No samples: an object of vacuum, or one that only its grid describes. */
static void test_no_samples(const char *path)
{
    cloud *c = make_cloud(AL_COEFFICIENT_HALF);
    al_error error = {0};
    al_file *file;
    al_translucent_info info;
    float answer[3];
    uint32_t used;
    const float up[3] = {0, 1, 0};
    c->data.info.sample_count = 0;
    c->data.info.page_size = 0; /* default */
    CHECK(al_translucent_write(path, &c->data, NULL, &error) == AL_OK);
    CHECK(al_file_open(path, NULL, &file, &error) == AL_OK &&
          al_translucent_read(file, &info, &error) == AL_OK);
    CHECK(info.page_size > 0 && al_translucent_page_count(&info) == 0);
    CHECK(al_translucent_evaluate(file, &info, up, up, answer, &used, &error) == AL_OK && used == 0 &&
          answer[0] == 1);
    al_file_close(file);
    unlink(path);
    free(c);
}

/* Bad numbers are refused before anything is written; the old file stays. */
static void test_refusals(const char *folder, const char *path)
{
    cloud *c = make_cloud(AL_COEFFICIENT_BYTE);
    al_error error = {0};
    CHECK(al_translucent_write(path, &c->data, NULL, &error) == AL_OK);
    forged before = forge_load(path);
    c->coefficients[7] = NAN;
    CHECK(al_translucent_write(path, &c->data, NULL, &error) == AL_BAD_INPUT &&
          strstr(error.message, "(rule 131)"));
    c->coefficients[7] = 0;
    c->data.info.order = 9;
    CHECK(al_translucent_write(path, &c->data, NULL, &error) == AL_BAD_INPUT &&
          strstr(error.message, "order is 9"));
    c->data.info.order = ORDER;
    c->gaussians[4 * 400 + 2] = 0;
    CHECK(al_translucent_write(path, &c->data, NULL, &error) == AL_BAD_INPUT &&
          strstr(error.message, "sample 400"));
    c->gaussians[4 * 400 + 2] = 1;
    c->data.provenance_json = "not JSON";
    CHECK(al_translucent_write(path, &c->data, NULL, &error) == AL_BAD_INPUT &&
          strstr(error.message, "(rule 134)"));
    c->data.provenance_json = NULL;
    c->data.info.format = AL_COEFFICIENT_HALF;
    c->coefficients[0] = 70000; /* no half is that large */
    CHECK(al_translucent_write(path, &c->data, NULL, &error) == AL_BAD_INPUT &&
          strstr(error.message, "(rule 131)"));
    forged after = forge_load(path);
    CHECK(after.size == before.size && !memcmp(after.data, before.data, before.size));
    CHECK(folder_count(folder) == 1);
    free(before.data);
    free(after.data);
    unlink(path);
    free(c);
}

int main(void)
{
    char folder[256], path[512];
    if (!folder_make(folder, sizeof folder)) return test_skip("no temporary folder");
    snprintf(path, sizeof path, "%s/cloud.air", folder);
    for (int format = 0; format < 3; format++) test_format(path, (al_coefficient_format)format);
    test_questions(path);
    test_no_samples(path);
    test_refusals(folder, path);
    CHECK(rmdir(folder) == 0);
    return test_end();
}
