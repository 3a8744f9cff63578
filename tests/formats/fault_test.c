/* Writers that are killed, that meet a full disk or a folder they may not write to: the old file or the new
 * one, whole, and one clear error. */
#define _GNU_SOURCE
#include <errno.h>
#include <sched.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "../test.h"
#include "airlight/translucent.h"
#include "folder.h"
#include "forge.h"

enum { SAMPLES = 4000, PAGE_SIZE = 500, KILLS = 150 };

/* About 160 kB in ten chunks; `variant` tells two assets of different size apart. */
static al_status write_asset(const char *path, int variant, al_error *error)
{
    static float positions[SAMPLES * 3], gaussians[SAMPLES * 4], coefficients[SAMPLES * 4];
    static uint16_t density[8] = {65535};
    uint32_t count = variant ? SAMPLES : SAMPLES - 700;
    for (uint32_t i = 0; i < 4 * count; i++) {
        gaussians[i] = 1;
        coefficients[i] = (float)variant;
    }
    const al_translucent_data data = {{.sample_count = count,
                                       .page_size = PAGE_SIZE,
                                       .order = 2,
                                       .channel_count = 1,
                                       .direction_count = 32,
                                       .grid_size = {2, 2, 2},
                                       .voxel_m = 1,
                                       .density_max = 1,
                                       .ior = 1,
                                       .bounds_max_m = {1, 1, 1}},
                                      positions,
                                      gaussians,
                                      coefficients,
                                      density,
                                      NULL,
                                      NULL,
                                      NULL,
                                      0};
    return al_translucent_write(path, &data, NULL, error);
}

static bool same_bytes(const char *path, forged wanted)
{
    forged f = forge_load(path);
    bool same = f.data && f.size == wanted.size && !memcmp(f.data, wanted.data, f.size);
    free(f.data);
    return same;
}

static void make_variants(const char *path, forged variants[2])
{
    al_error error = {0};
    for (int v = 0; v < 2; v++) {
        CHECK(write_asset(path, v, &error) == AL_OK);
        variants[v] = forge_load(path);
        if (!variants[v].data) exit(1);
    }
}

/* --- killed at any moment --- */

static void pause_us(long us)
{
    const struct timespec pause = {us / 1000000, us % 1000000 * 1000};
    nanosleep(&pause, NULL);
}

static void test_kill(const char *folder, const char *path, const forged variants[2])
{
    unsigned long state = 9;
    int seen[2] = {0}, interrupted = 0;
    for (int kill_number = 0; kill_number < KILLS; kill_number++) {
        pid_t child = fork();
        if (child == 0)
            for (int v = kill_number % 2;; v = !v)
                if (write_asset(path, v, NULL) != AL_OK) _exit(1);
        state = state * 6364136223846793005u + 1442695040888963407u;
        pause_us(200 + (long)(state >> 40) % 8000);
        kill(child, SIGKILL);
        int status;
        CHECK(waitpid(child, &status, 0) == child && WIFSIGNALED(status));
        CHECK(al_file_check(path, NULL, NULL, NULL) == AL_OK);
        bool first = same_bytes(path, variants[0]), second = same_bytes(path, variants[1]);
        CHECK(first || second);
        seen[0] += first;
        seen[1] += second;
        interrupted += folder_visit(folder, ".tmp", true) > 0;
    }
    printf("%d kills: old or new %d and %d times, %d in the middle of writing\n", KILLS, seen[0], seen[1],
           interrupted);
    CHECK(interrupted > 0); /* else nothing was tested */
}

/* --- no room: a limit on the size of files, at every possible place --- */

static int run_limited(const char *path, size_t limit, al_status (*work)(const char *path, al_error *error))
{
    pid_t child = fork();
    if (child == 0) {
        al_error error = {0};
        const struct rlimit room = {limit, limit};
        signal(SIGXFSZ, SIG_IGN);
        if (setrlimit(RLIMIT_FSIZE, &room) != 0) _exit(99);
        al_status status = work(path, &error);
        bool clear =
            status == AL_OK || (!strncmp(error.message, path, strlen(path)) && !strchr(error.message, '\n'));
        _exit(clear ? (int)status : 98);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static al_status write_second(const char *path, al_error *error)
{
    return write_asset(path, 1, error);
}

static al_status write_text(const char *path, al_error *error)
{
    return al_write_file(path, "0123456789", 10, error);
}

static void test_no_room(const char *folder, const char *path, const forged variants[2])
{
    enum { STEP = 997 };
    CHECK(write_asset(path, 0, NULL) == AL_OK);
    for (size_t limit = 0; limit < variants[1].size; limit += STEP) {
        CHECK(run_limited(path, limit, write_second) == AL_IO);
        CHECK(folder_count(folder) == 1);
    }
    CHECK(run_limited(path, variants[1].size - 1, write_second) == AL_IO);
    CHECK(same_bytes(path, variants[0]));
    CHECK(run_limited(path, variants[1].size, write_second) == AL_OK);
    CHECK(same_bytes(path, variants[1]));
    for (size_t limit = 0; limit < 10; limit++) CHECK(run_limited(path, limit, write_text) == AL_IO);
    CHECK(same_bytes(path, variants[1]) && folder_count(folder) == 1);
}

/* --- a full and a read-only file system, where mounting is allowed --- */

static bool enter_mounts(const char *folder)
{
    if (unshare(CLONE_NEWNS) != 0 && unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) return false;
    if (mount(NULL, "/", NULL, MS_REC | MS_PRIVATE, NULL) != 0) return false;
    return mount("tmpfs", folder, "tmpfs", 0, "size=64k") == 0;
}

static void check_mounts(const char *folder)
{
    char path[600];
    al_error error = {0};
    snprintf(path, sizeof path, "%s/asset.air", folder);
    CHECK(write_asset(path, 1, &error) == AL_IO && strstr(error.message, strerror(ENOSPC)) &&
          strstr(error.message, path));
    CHECK(folder_count(folder) == 0);
    CHECK(al_write_file(path, "text", 4, &error) == AL_OK);
    CHECK(mount(NULL, folder, NULL, MS_REMOUNT | MS_RDONLY, NULL) == 0);
    CHECK(al_write_file(path, "other", 5, &error) == AL_IO && strstr(error.message, strerror(EROFS)));
    CHECK(write_asset(path, 1, &error) == AL_IO && strstr(error.message, strerror(EROFS)));
    CHECK(folder_count(folder) == 1);
}

static void test_mounts(const char *folder)
{
    char inside[512];
    int status = 0;
    snprintf(inside, sizeof inside, "%s/mounted", folder);
    CHECK(mkdir(inside, 0777) == 0);
    pid_t child = fork();
    if (child == 0) {
        test_failures = 0;
        if (!enter_mounts(inside)) _exit(77);
        check_mounts(inside);
        _exit(test_failures ? 1 : 0);
    }
    waitpid(child, &status, 0);
    int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    if (code == 77)
        printf("SKIP of one part: mounting a small and a read-only file system is not allowed here\n");
    CHECK(code == 0 || code == 77);
    rmdir(inside);
}

/* Folders that are not there, or are files: what even root may not write to. */
static void test_unwritable(const char *path)
{
    char under[600];
    al_error error = {0};
    snprintf(under, sizeof under, "%s/asset.air", path);
    CHECK(write_asset(under, 0, &error) == AL_IO && strstr(error.message, under) &&
          strstr(error.message, strerror(ENOTDIR)));
    CHECK(write_asset("/absent/folder/asset.air", 0, &error) == AL_IO &&
          strstr(error.message, strerror(ENOENT)));
}

int main(void)
{
    char folder[256], path[512];
    forged variants[2];
    if (!folder_make(folder, sizeof folder)) return test_skip("no temporary folder");
    snprintf(path, sizeof path, "%s/asset.air", folder);
    make_variants(path, variants);
    test_kill(folder, path, variants);
    test_no_room(folder, path, variants);
    test_unwritable(path);
    unlink(path);
    test_mounts(folder);
    CHECK(rmdir(folder) == 0);
    free(variants[0].data);
    free(variants[1].data);
    return test_end();
}
