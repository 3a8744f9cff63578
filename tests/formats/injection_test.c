/* Every allocation and every system call that writes or maps is made to fail once: the status is AL_IO,
 * nothing leaks, nothing half-written stays. The linker's --wrap puts the functions below between the library
 * and libc. */
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

#include "../test.h"
#include "folder.h"
#include "forge.h"
#include "golden_data.h"

static long calls_left = -1; /* the call that finds 0 fails; below 0 none does */
static long blocks, mappings, descriptors;

static bool fails_now(void)
{
    return calls_left >= 0 && calls_left-- == 0;
}

#define WRAPPED(type, name, ...) \
    type __real_##name(__VA_ARGS__); \
    type __wrap_##name(__VA_ARGS__)

WRAPPED(void *, malloc, size_t size);
WRAPPED(void *, calloc, size_t count, size_t size);
WRAPPED(void *, realloc, void *old, size_t size);
WRAPPED(void, free, void *block);
WRAPPED(int, open, const char *path, int flags, ...);
WRAPPED(ssize_t, pwrite, int descriptor, const void *data, size_t size, off_t offset);
WRAPPED(int, fsync, int descriptor);
WRAPPED(int, close, int descriptor);
WRAPPED(int, rename, const char *from, const char *to);
WRAPPED(void *, mmap, void *at, size_t size, int protection, int flags, int descriptor, off_t offset);
WRAPPED(int, munmap, void *at, size_t size);

void *__wrap_malloc(size_t size)
{
    void *block = fails_now() ? NULL : __real_malloc(size);
    blocks += block != NULL;
    return block;
}

void *__wrap_calloc(size_t count, size_t size)
{
    void *block = fails_now() ? NULL : __real_calloc(count, size);
    blocks += block != NULL;
    return block;
}

void *__wrap_realloc(void *old, size_t size)
{
    void *block = fails_now() ? NULL : __real_realloc(old, size);
    blocks += block != NULL && old == NULL;
    return block;
}

void __wrap_free(void *block)
{
    blocks -= block != NULL;
    __real_free(block);
}

int __wrap_open(const char *path, int flags, ...)
{
    va_list arguments;
    va_start(arguments, flags);
    int mode = va_arg(arguments, int), descriptor = -1;
    va_end(arguments);
    if (fails_now())
        errno = EIO;
    else
        descriptor = __real_open(path, flags, mode);
    descriptors += descriptor >= 0;
    return descriptor;
}

ssize_t __wrap_pwrite(int descriptor, const void *data, size_t size, off_t offset)
{
    if (!fails_now()) return __real_pwrite(descriptor, data, size, offset);
    errno = ENOSPC;
    return -1;
}

int __wrap_fsync(int descriptor)
{
    if (!fails_now()) return __real_fsync(descriptor);
    errno = EIO;
    return -1;
}

int __wrap_close(int descriptor)
{
    bool fails = fails_now();
    int result = __real_close(descriptor); /* the descriptor is gone even when close fails */
    descriptors--;
    if (fails) errno = EIO;
    return fails ? -1 : result;
}

int __wrap_rename(const char *from, const char *to)
{
    if (!fails_now()) return __real_rename(from, to);
    errno = EIO;
    return -1;
}

void *__wrap_mmap(void *at, size_t size, int protection, int flags, int descriptor, off_t offset)
{
    void *mapping = MAP_FAILED;
    if (fails_now())
        errno = ENOMEM;
    else
        mapping = __real_mmap(at, size, protection, flags, descriptor, offset);
    mappings += mapping != MAP_FAILED;
    return mapping;
}

int __wrap_munmap(void *at, size_t size)
{
    mappings--;
    return __real_munmap(at, size);
}

/* --- what is made to fail --- */

static const char *path; /* where the writers write */

static al_status write_impulse(al_error *error)
{
    golden_impulse golden;
    golden_fill_impulse(&golden);
    return al_impulse_tables_write(path, &golden.data, NULL, error);
}

static al_status write_translucent(al_error *error)
{
    golden_translucent golden;
    golden_fill_translucent(AL_COEFFICIENT_BYTE, &golden);
    return al_translucent_write(path, &golden.data, NULL, error);
}

static al_status write_scene(al_error *error)
{
    al_scene scene;
    golden_fill_moving_scene(&scene);
    return al_scene_write(path, &scene, "{}", NULL, error);
}

static al_status write_lightmap(al_error *error)
{
    golden_lightmap golden;
    golden_fill_lightmap(AL_LIGHTMAP_HALF, &golden);
    return al_lightmap_write(path, &golden.data, NULL, error);
}

static al_status write_medium(al_error *error)
{
    al_medium_data medium, depth;
    golden_fill_medium_sky(&medium);
    golden_fill_medium_depth(&depth);
    medium.depth = depth.depth;
    medium.depths = depth.depths;
    medium.depths_user = &medium;
    return al_medium_write(path, &medium, NULL, error);
}

static al_status write_probes(al_error *error)
{
    al_probes_data probes;
    golden_fill_probes(&probes);
    return al_probes_write(path, &probes, NULL, error);
}

static al_status read_medium(al_error *error)
{
    al_file *file;
    al_medium_info info;
    al_medium_field *field = NULL;
    al_status status = al_file_open(AIRLIGHT_GOLDEN "/medium_1_0.air", NULL, &file, error);
    if (status == AL_OK) status = al_medium_read(file, &info, error);
    if (status == AL_OK) status = al_medium_field_open(file, &info, &field, error);
    CHECK((status == AL_OK) == (field != NULL));
    al_medium_field_close(field);
    al_file_close(file);
    return status;
}

static al_status write_text(al_error *error)
{
    return al_write_file(path, "text", 4, error);
}

static al_status read_scene(al_error *error)
{
    al_file *file;
    al_scene scene;
    al_status status = al_file_open(AIRLIGHT_GOLDEN "/scene_moving_1_0.air", NULL, &file, error);
    if (status != AL_OK) {
        CHECK(!file);
        return status;
    }
    status = al_scene_read(file, &scene, error);
    CHECK((status == AL_OK) == (scene.meshes != NULL));
    al_scene_free(&scene);
    al_file_close(file);
    return status;
}

static al_status check_scene(al_error *error)
{
    return al_file_check(AIRLIGHT_GOLDEN "/scene_1_0.air", NULL, NULL, error);
}

static al_status read_impulse(al_error *error)
{
    al_file *file;
    al_impulse_tables *tables = NULL;
    al_status status = al_file_open(AIRLIGHT_GOLDEN "/impulse_tables_1_0.air", NULL, &file, error);
    if (status != AL_OK) return status;
    status = al_impulse_tables_read(file, &tables, error);
    al_impulse_tables_free(tables);
    al_file_close(file);
    return status;
}

static al_status check_impulse(al_error *error)
{
    return al_file_check(AIRLIGHT_GOLDEN "/impulse_tables_1_0.air", NULL, NULL, error);
}

static al_status check_translucent(al_error *error)
{
    return al_file_check(AIRLIGHT_GOLDEN "/translucent_byte_1_0.air", NULL, NULL, error);
}

static al_status check_lightmap(al_error *error)
{
    return al_file_check(AIRLIGHT_GOLDEN "/lightmap_half_1_0.air", NULL, NULL, error);
}

/* Fails call after call until the work runs out of calls. `result` is the file that success leaves, or "". A
 * failed close of what was only read, or of the folder after its sync, loses nothing: the work may succeed.
 */
static void fail_every_call(const char *folder, const char *name, al_status (*work)(al_error *error),
                            const char *before, const char *result)
{
    enum { LIMIT = 10000 };
    forged old = forge_load(before), made = forge_load(result);
    long number = 0, survived = 0;
    bool failed = true;
    for (; failed && number < LIMIT; number++) {
        al_error error = {0};
        if (old.data) forge_save(path, old);
        long before_blocks = blocks;
        calls_left = number;
        al_status status = work(&error);
        failed = calls_left < 0;
        calls_left = -1;
        survived += failed && status == AL_OK;
        CHECK(blocks == before_blocks && mappings == 0 && descriptors == 0);
        CHECK(status == AL_OK || (failed && status == AL_IO && error.status == AL_IO && error.message[0]));
        if (!old.data) continue;
        CHECK(folder_count(folder) == 1);
        forged now = forge_load(path);
        bool is_old = now.size == old.size && !memcmp(now.data, old.data, old.size);
        bool is_new = now.size == made.size && !memcmp(now.data, made.data, made.size);
        CHECK(status == AL_OK ? is_new : is_old || is_new); /* the folder's sync comes after the rename */
        free(now.data);
    }
    printf("%s: %ld calls failed one by one, %ld without harm\n", name, number - 1, survived);
    CHECK(!failed && number > 3 && survived <= 2);
    free(old.data);
    free(made.data);
}

int main(void)
{
    char folder[256], target[512], made[7][512];
    if (!folder_make(folder, sizeof folder)) return test_skip("no temporary folder");
    static const char *const names[] = {"write translucent", "write scene", "write text", "write impulse",
                                        "write lightmap", "write medium",
                                        "write probes"};
    al_status (*const writers[])(al_error *) = {write_translucent, write_scene, write_text, write_impulse,
                                                write_lightmap, write_medium,
                                                write_probes};
    for (int i = 0; i < 7; i++) { /* what success leaves, in another folder */
        snprintf(made[i], sizeof made[i], "%s.%d", folder, i);
        path = made[i];
        CHECK(writers[i](NULL) == AL_OK);
    }
    snprintf(target, sizeof target, "%s/file", folder);
    path = target;
    for (int i = 0; i < 7; i++) fail_every_call(folder, names[i], writers[i], made[(i + 1) % 7], made[i]);
    unlink(path);
    fail_every_call(folder, "read scene", read_scene, "", "");
    fail_every_call(folder, "read medium", read_medium, "", "");
    fail_every_call(folder, "check scene", check_scene, "", "");
    fail_every_call(folder, "read impulse", read_impulse, "", "");
    fail_every_call(folder, "check impulse", check_impulse, "", "");
    fail_every_call(folder, "check translucent", check_translucent, "", "");
    fail_every_call(folder, "check lightmap", check_lightmap, "", "");
    for (int i = 0; i < 7; i++) unlink(made[i]);
    CHECK(rmdir(folder) == 0);
    return test_end();
}
