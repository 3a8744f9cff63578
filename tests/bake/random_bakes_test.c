/* usage: bake_random_test FOLDER_OF_PROGRAMS [--seed S] [--from N] [--count N] [--show]
 *
 * Draws small scene files at random, over all that docs/scene.md allows, and bakes them by airlight-bake.
 * Each is either refused as bad input in one line, the same one every time, or baked; every asset that is
 * there is the same bytes from one thread as from two, and `airlight-inspect --check` finds nothing wrong
 * with it (all numbers finite, a lightmap's light not negative). A scene that fails is named by its number:
 * --from N --count 1 --show prints it. */
#include <dirent.h>
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "../random.h"
#include "../refusals.h"
#include "../test.h"

enum { MESHES = 4, MEDIA = 3 };

static const char *programs;
static uint64_t state;
static FILE *scene;
static double unit; /* m, about the scene's size */
static bool probes;

static int baked, assets;

/* --- numbers --- */

static double uniform(double low, double high)
{
    return low + (high - low) * (double)(random_bits(&state) >> 11) * 0x1p-53;
}

static int below(int count)
{
    return (int)((random_bits(&state) >> 32) * (uint64_t)count >> 32);
}

static bool chance(double share)
{
    return uniform(0, 1) < share;
}

static double spread(double low, double high) /* its logarithm is uniform; both ends come up */
{
    return fmin(fmax(low * pow(high / low, uniform(-0.05, 1.05)), low), high);
}

/* Mostly in [low, high]; seldom an end of all that is allowed. */
static double within(double low, double high, double least, double most)
{
    return chance(0.98) ? spread(low, high) : chance(0.5) ? least : most;
}

/* --- the scene file --- */

__attribute__((format(printf, 1, 2))) static void put(const char *format, ...)
{
    va_list list;
    va_start(list, format);
    vfprintf(scene, format, list);
    va_end(list);
}

static void put_place(const char *key, double radius)
{
    put("\"%s\": [%.9g, %.9g, %.9g]", key, uniform(-radius, radius) * unit, uniform(-radius, radius) * unit,
        uniform(-radius, radius) * unit);
}

/* One number for grey; channels of 0 come up. */
static void put_color(const char *key, double largest)
{
    double c[3];
    for (int k = 0; k < 3; k++) c[k] = largest * (chance(0.15) ? below(2) : uniform(0, 1));
    if (chance(0.3))
        put("\"%s\": %.9g", key, c[0]);
    else
        put("\"%s\": [%.9g, %.9g, %.9g]", key, c[0], c[1], c[2]);
}

static void put_shape(int kind)
{
    const double size = spread(0.1, 2) * unit;
    if (kind == 0)
        put("{\"type\": \"sphere\", \"radius_m\": %.9g, \"subdivisions\": %d}",
            within(size, size, 1e-9, 1e9) / 2, below(3));
    else if (kind == 1)
        put("{\"type\": \"box\", \"size_m\": [%.9g, %.9g, %.9g]}", size, within(size / 100, size, 1e-9, 1e9),
            size);
    else if (kind == 2)
        put("{\"type\": \"torus\", \"major_radius_m\": %.9g, \"minor_radius_m\": %.9g, \"major_segments\": "
            "%d, \"minor_segments\": %d}",
            size / 2, size / spread(2.1, 100), 3 + below(6), 3 + below(6));
    else
        put("{\"type\": \"plane\", \"width_m\": %.9g, \"depth_m\": %.9g}", size,
            within(size / 100, size, 1e-9, 1e9));
}

/* `kind` by the shapes above; those of translucent objects are only turned and moved. */
static void put_mesh(int index, int kind, bool boundary)
{
    static const char *const lighting[] = {"dynamic", "lightmap", "probes"};
    put("%s{\"name\": \"m%d\", \"shape\": ", index ? ", " : "", index);
    put_shape(kind);
    put(", \"transform\": {");
    put_place("translate_m", 0.7);
    if (chance(0.5))
        put(", \"rotate_degrees\": [%.9g, %.9g, %.9g]", uniform(-180, 180), uniform(-180, 180),
            uniform(-180, 180));
    if (!boundary && chance(0.3))
        put(", \"scale\": [%.9g, %.9g, %.9g]", uniform(0.5, 2), spread(0.01, 1), uniform(-1, 1));
    put("}");
    if (!boundary)
        put(", \"lighting\": \"%s\"", lighting[chance(0.6) ? 1 : below(probes || chance(0.05) ? 3 : 2)]);
    if (chance(0.7)) put(", \"material\": \"a%d\"", below(2));
    if (chance(0.1)) put(", \"hidden\": true");
    put("}");
}

static void put_materials(void)
{
    put("\"materials\": [");
    for (int i = 0; i < 2; i++) {
        put("%s{\"name\": \"a%d\", ", i ? ", " : "", i);
        put_color("base_color", 1);
        put(", \"metallic\": %.9g, \"roughness\": %.9g, \"ior\": %.9g",
            chance(0.5) ? below(2) : uniform(0, 1), chance(0.3) ? below(2) : uniform(0, 1),
            within(1, 3, 1, 10));
        if (chance(0.3)) {
            put(", ");
            put_color("emission_w_m2_sr", within(1e-6, 1e6, 0, 1e12));
        }
        put(", \"double_sided\": %s}", chance(0.5) ? "true" : "false");
    }
    put("],\n");
}

static void put_bounds(void)
{
    double low[3], high[3];
    for (int k = 0; k < 3; k++) {
        low[k] = uniform(-1, 0) * unit;
        high[k] = low[k] + spread(0.05, 2) * unit;
    }
    put(", \"bounds_min_m\": [%.9g, %.9g, %.9g], \"bounds_max_m\": [%.9g, %.9g, %.9g]", low[0], low[1],
        low[2], high[0], high[1], high[2]);
}

static void put_media(void)
{
    put("\"media\": [");
    for (int i = 0; i < MEDIA; i++) {
        const double depth = chance(0.6) ? spread(0.01, 10) : spread(1e-6, 1e4); /* over the unit */
        put("%s{\"name\": \"f%d\", \"g\": %.9g, ", i ? ", " : "", i,
            chance(0.3)   ? 0
            : chance(0.3) ? (chance(0.5) ? 0.99 : -0.99)
                          : uniform(-0.99, 0.99));
        if (chance(0.5)) {
            put_color("sigma_s_per_m", within(depth / unit, depth / unit, 0, 1e9));
            put(", ");
            put_color("sigma_a_per_m", within(depth / unit, depth / unit, 0, 1e9));
        } else {
            put_color("albedo", 1);
            put(", \"mean_free_path_m\": %.9g", within(unit / depth, unit / depth, 1e-9, 1e9));
        }
        if (chance(0.3)) put(", \"optical_depth_order\": %d", below(6));
        if (chance(0.5)) {
            const double period = spread(0.2, 2) * unit;
            put(", \"density\": {\"type\": \"layers\", \"period_m\": %.9g, \"thickness_m\": %.9g, \"low\": "
                "%.9g, \"high\": %.9g",
                period, period * (chance(0.1) ? below(2) : uniform(0.3, 0.7)),
                chance(0.5) ? 0 : within(1e-3, 1, 0, 1e9), within(0.1, 10, 0, 1e9));
            if (chance(0.3))
                put(", \"axis\": [%.9g, %.9g, %.9g]", uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
            if (chance(0.95)) put_bounds();
            put("}");
        } else if (chance(0.7)) {
            put(", \"density\": {\"type\": \"constant\", \"scale\": %.9g", within(0.1, 10, 1e-9, 1e9));
            if (chance(0.8)) put_bounds();
            put("}");
        }
        put("}");
    }
    put("],\n");
    if (chance(0.7)) put("\"fogs\": [\"f0\"%s],\n", chance(0.3) ? ", \"f1\"" : "");
}

static void put_lights(void)
{
    const int count = below(4);
    put("\"lights\": [");
    for (int i = 0; i < count; i++) {
        const bool point = chance(0.6);
        put("%s{\"type\": \"%s\", ", i ? ", " : "", point ? "point" : "directional");
        put_color(point ? "intensity_w_sr" : "irradiance_w_m2", within(1e-6, 1e6, 0, 1e12));
        put(", ");
        put_place(point ? "position_m" : "direction", 1);
        put("}");
    }
    put("],\n");
    if (!chance(0.5)) return;
    put("\"environment\": {");
    put_color("radiance_w_m2_sr", within(1e-6, 1e6, 0, 1e12));
    put(", \"scale\": %.9g},\n", within(0.1, 10, 0, 1e12));
}

static void put_settings(void)
{
    static const char *const uv[] = {"auto", "file", "atlas"}, *const formats[] = {"float", "half", "byte"};
    put("\"lightmap\": {\"texel_m\": %.9g, \"samples\": %d, \"bounces\": %d, \"walls\": \"%s\", "
        "\"fog_points\": %d, \"back_scatter\": %s, ",
        unit * spread(0.2, 2), 1 + below(3), below(4), chance(0.5) ? "bounded" : "traced", 1 + below(4),
        chance(0.3) ? "true" : "false");
    put("\"uv\": \"%s\", \"directional_order\": %d, \"padding_texels\": %d, \"page_size\": %d, \"seed\": "
        "%d},\n",
        uv[chance(0.9) ? 2 * below(2) : 1], chance(0.5) ? 0 : below(5), 1 + below(4),
        chance(0.1) ? 16 : 64 << below(3), below(1000));
    if (probes) {
        put("\"probes\": {\"order\": %d, \"samples\": %d, ", 1 + below(8), 1 + below(16));
        if (chance(0.5)) {
            put("\"spacing_m\": %.9g},\n", unit * spread(0.5, 10));
        } else {
            put("\"points\": [");
            for (int i = 0, count = 1 + below(6); i < count; i++) {
                put("%s{", i ? ", " : "");
                put_place("position_m", 1);
                put("}");
            }
            put("]},\n");
        }
    }
    put("\"bake\": {\"directions\": %d, \"grid_resolution\": %d, \"samples\": %d, \"sh_order\": %d, "
        "\"coefficient_format\": \"%s\", \"too_dense\": \"%s\"},\n",
        2 + 2 * below(8), chance(0.1) ? 1 : 4 + below(5), 1 + below(60), 1 + below(8), formats[below(3)],
        chance(0.8) ? "bake" : "refuse");
}

static bool write_scene(uint64_t seed, uint32_t index)
{
    state = random_begin(seed, index);
    unit = chance(0.4) ? 1 : spread(1e-4, 1e4);
    scene = fopen("scene.json", "w");
    if (!scene) return false;
    const bool object = chance(0.35);
    probes = chance(0.4);
    const int meshes = chance(0.05) ? 0 : 1 + below(MESHES);
    put("{\"meshes\": [");
    for (int i = 0; i < meshes; i++) put_mesh(i, object && !i ? below(3) : below(4), object && !i);
    put("],\n");
    if (object && meshes) put("\"translucents\": [{\"mesh\": \"m0\", \"medium\": \"f%d\"}],\n", MEDIA - 1);
    put_materials();
    put_media();
    put_lights();
    put_settings();
    put("\"comment\": \"scene %u of seed %llu, %.9g m\"}\n", index, (unsigned long long)seed, unit);
    return !fclose(scene);
}

/* --- what becomes of it --- */

/* Exit code of a shell's command; its words go to the file "words". */
__attribute__((format(printf, 1, 2))) static int run(const char *format, ...)
{
    char command[2048];
    va_list list;
    va_start(list, format);
    const int size = vsnprintf(command, sizeof command - 32, format, list);
    va_end(list);
    snprintf(command + size, sizeof command - (size_t)size, " >words 2>&1 </dev/null");
    const int status = system(command);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 255;
}

static size_t read_words(char *text, size_t limit)
{
    FILE *file = fopen("words", "r");
    const size_t size = file ? fread(text, 1, limit - 1, file) : 0;
    if (file) fclose(file);
    text[size] = 0;
    return size;
}

static bool check_assets(void)
{
    DIR *folder = opendir("one");
    bool good = true;
    for (struct dirent *entry; good && folder && (entry = readdir(folder));) {
        const size_t size = strlen(entry->d_name);
        if (size < 4 || strcmp(entry->d_name + size - 4, ".air") != 0) continue;
        assets++;
        good = !run("%s/airlight-inspect --check \"one/%s\"", programs, entry->d_name) &&
               !run("cmp \"one/%s\" \"two/%s\"", entry->d_name, entry->d_name);
        char words[4096];
        if (!good && read_words(words, sizeof words)) fprintf(stderr, "%s: %s", entry->d_name, words);
    }
    if (folder) closedir(folder);
    return good;
}

static bool check_scene(uint64_t seed, uint32_t index)
{
    static char first[4096], second[4096];
    int status[2];
    if (run("rm -rf one two") || !write_scene(seed, index)) return false;
    status[0] = run("timeout 300 %s/airlight-bake scene.json -o one --threads 1 --quiet", programs);
    read_words(first, sizeof first);
    status[1] = run("timeout 300 %s/airlight-bake scene.json -o two --threads 2 --quiet", programs);
    read_words(second, sizeof second);
    const char *end = strchr(first, '\n');
    if (!status[0] && !status[1]) {
        baked++;
        return check_assets();
    }
    if (status[0] == 3 && status[1] == 3 && end && !end[1] && !strcmp(first, second)) {
        count_refusal(first);
        return check_assets();
    }
    fprintf(stderr, "exit codes %d and %d: %s%s", status[0], status[1], first, second);
    return false;
}

int main(int argc, char **argv)
{
    char folder[256];
    uint64_t seed = 1;
    uint32_t from = 0, count = 30;
    bool show = false;
    if (argc < 2) return 2;
    programs = argv[1];
    for (int i = 2; i < argc; i++) {
        const char *value = i + 1 < argc ? argv[i + 1] : "";
        if (!strcmp(argv[i], "--seed")) seed = strtoull(value, NULL, 10);
        if (!strcmp(argv[i], "--from")) from = (uint32_t)strtoul(value, NULL, 10);
        if (!strcmp(argv[i], "--count")) count = (uint32_t)strtoul(value, NULL, 10);
        if (!strcmp(argv[i], "--show")) show = true;
    }
    const char *parent = getenv("TMPDIR");
    snprintf(folder, sizeof folder, "%s/airlight-test-XXXXXX", parent && *parent ? parent : "/tmp");
    CHECK(mkdtemp(folder) && !chdir(folder));
    if (test_failures) return test_end();
    if (run("%s/airlight-bake --list-devices", programs)) return test_skip("no OpenCL device");
    for (uint32_t i = from; i < from + count; i++) {
        test_checks++;
        if (!check_scene(seed, i)) {
            test_failures++;
            fprintf(stderr, "failed: scene %u of seed %llu\n", i, (unsigned long long)seed);
        }
        if (show && !system("cat scene.json words")) fflush(stdout);
        if ((i + 1 - from) % 100 == 0) {
            printf("%u scenes, %d refused, %d failed\n", i + 1 - from, refused, test_failures);
            fflush(stdout);
        }
    }
    print_refusals();
    printf("seed %llu, scenes %u to %u: %d baked, %d assets, %d refused\n", (unsigned long long)seed, from,
           from + count - 1, baked, assets, refused);
    CHECK(!chdir("/") && !run("rm -rf %s", folder));
    return test_end();
}
