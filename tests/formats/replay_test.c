/* The fuzz target on the corpus, on the golden files, and on golden files with random changes. Every corpus
 * and golden file is also read through a file, which must say the same as memory. */
#include <dirent.h>
#include <stdbool.h>
#include <sys/stat.h>

#include "../test.h"
#include "airlight/container.h"
#include "forge.h"
#include "fuzz_container.h"

enum { CHANGED_FILES = 60000 };

static uint64_t random_bits(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return *state >> 24;
}

static void note(void *user, int rule, const char *message)
{
    uint64_t *hash = user;
    *hash = XXH64(message, strlen(message), *hash + (uint64_t)rule);
}

static void compare_paths(const char *path, forged f)
{
    uint64_t in_memory = 0, in_file = 0;
    al_error memory_error = {0}, file_error = {0};
    al_status status = al_file_check_memory(path, f.data, f.size, note, &in_memory, &memory_error);
    CHECK(al_file_check(path, note, &in_file, &file_error) == status);
    CHECK(in_memory == in_file && !strcmp(memory_error.message, file_error.message));
    al_file *one, *other;
    status = al_file_from_memory(path, f.data, f.size, NULL, &one, &memory_error);
    CHECK(al_file_open(path, NULL, &other, &file_error) == status &&
          !strcmp(memory_error.message, file_error.message));
    al_file_close(one);
    al_file_close(other);
}

/* Changes a few bytes, words or chunk entries: small numbers and extremes more often than chance would. */
static void change(forged f, uint64_t *state)
{
    static const uint64_t extremes[] = {0,
                                        1,
                                        2,
                                        3,
                                        63,
                                        64,
                                        65,
                                        127,
                                        128,
                                        255,
                                        0x7f800000,
                                        0x7fc00000,
                                        0xff7fffff,
                                        0x80000000,
                                        0xffffffff,
                                        0x7fffffffffffffff,
                                        0xffffffffffffffff,
                                        0xffffffffffffffc0};
    int changes = 1 + (int)(random_bits(state) % 4);
    size_t count, table = forge_table(f, &count);
    for (int i = 0; i < changes && f.size; i++) {
        unsigned width = 1u << random_bits(state) % 4;
        bool in_table = table && random_bits(state) % 3 == 0;
        size_t from = in_table ? table : 0, room = f.size - from;
        if (room < width) continue;
        size_t at = from + (size_t)(random_bits(state) % (room / width)) * width;
        uint64_t value = random_bits(state) % 2
                             ? extremes[random_bits(state) % (sizeof extremes / sizeof *extremes)]
                             : random_bits(state);
        forge_put(f.data + at, value, width);
    }
}

static int replay_folder(const char *folder, bool compare, forged *kept, int kept_limit)
{
    int count = 0;
    DIR *open_folder = opendir(folder);
    for (struct dirent *entry; open_folder && (entry = readdir(open_folder));) {
        char path[1024];
        struct stat about;
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        if (stat(path, &about) != 0 || !S_ISREG(about.st_mode)) continue;
        forged f = forge_load(path);
        CHECK(f.data != NULL);
        if (!f.data) continue;
        LLVMFuzzerTestOneInput(f.data, f.size);
        if (compare) compare_paths(path, f);
        if (count < kept_limit)
            kept[count] = f;
        else
            free(f.data);
        count++;
    }
    if (open_folder) closedir(open_folder);
    return count;
}

int main(void)
{
    enum { KEPT = 256 };
    static forged kept[KEPT];
    uint64_t state = 11;
    int golden = replay_folder(AIRLIGHT_GOLDEN, true, kept, KEPT),
        corpus = replay_folder(AIRLIGHT_CORPUS, true, NULL, 0);
    CHECK(golden > 50 && golden <= KEPT);
    for (int i = 0; i < CHANGED_FILES && golden; i++) {
        forged f = forge_copy(kept[random_bits(&state) % (uint64_t)golden]);
        change(f, &state);
        LLVMFuzzerTestOneInput(f.data, f.size);
        free(f.data);
    }
    printf("%d golden files, %d of the corpus, %d changed files\n", golden, corpus, CHANGED_FILES);
    for (int i = 0; i < golden && i < KEPT; i++) free(kept[i].data);
    return test_end();
}
