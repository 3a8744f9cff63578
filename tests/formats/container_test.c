/* The container: what a writer writes a reader reads; options; whole small files; nothing half-written. */
#include "airlight/container.h"

#include <stdlib.h>
#include <unistd.h>

#include "../test.h"
#include "folder.h"
#include "forge.h"

/* A minimal valid translucent asset is the smallest thing that may be committed; see translucent_test. */
static const char *const golden = AIRLIGHT_GOLDEN "/translucent_byte_1_0.air";

static void test_reading(void)
{
    al_error error = {0};
    al_file *file;
    const void *data;
    size_t size;
    CHECK(al_file_open(golden, NULL, &file, &error) == AL_OK);
    if (!file) return;
    CHECK(al_file_kind(file) == AL_KIND_TRANSLUCENT);
    CHECK(al_file_major(file) == 1 && al_file_minor(file) == 0);
    CHECK(!strncmp(al_file_writer(file), "airlight ", 9));
    CHECK(!strcmp(al_file_name(file), golden));
    CHECK(al_file_find(file, "PAGE", 2) >= 0);
    CHECK(al_file_find(file, "PAGE", 3) == -1);
    CHECK(al_file_find(file, "NONE", 0) == -1);
    for (size_t i = 0; i < al_file_chunk_count(file); i++) {
        const al_chunk *chunk = al_file_chunk(file, i);
        CHECK(al_file_data(file, i, &data, &size, &error) == AL_OK);
        CHECK(size == chunk->size && chunk->raw_size == chunk->size && chunk->offset % 64 == 0);
        CHECK((uintptr_t)data % 64 == 0); /* mapped at a page */
    }
    al_file_close(file);
}

static void test_options(void)
{
    al_error error = {0};
    al_file *file;
    const al_open_options scene = {0, AL_KIND_SCENE}, translucent = {0, AL_KIND_TRANSLUCENT},
                          small = {100, AL_KIND_NONE};
    CHECK(al_file_open(golden, &translucent, &file, &error) == AL_OK);
    al_file_close(file);
    CHECK(al_file_open(golden, &scene, &file, &error) == AL_BAD_INPUT && !file &&
          strstr(error.message, "wanted is scene"));
    CHECK(al_file_open(golden, &small, &file, &error) == AL_BAD_INPUT && !file &&
          strstr(error.message, "limit"));
    CHECK(al_file_open(AIRLIGHT_GOLDEN "/absent.air", NULL, &file, &error) == AL_BAD_INPUT && !file &&
          strstr(error.message, "absent.air"));
    CHECK(al_file_open(AIRLIGHT_GOLDEN, NULL, &file, &error) == AL_BAD_INPUT && !file);
    CHECK(al_file_open("/dev/null", NULL, &file, NULL) == AL_BAD_INPUT && !file);
    al_file_close(NULL);
}

static void test_kind_names(void)
{
    CHECK(!strcmp(al_kind_name(AL_KIND_SCENE), "scene"));
    CHECK(!strcmp(al_kind_name(AL_KIND_TRANSLUCENT), "translucent"));
    CHECK(!strcmp(al_kind_name(AL_KIND_IMPULSE_TABLES), "impulse-tables"));
    CHECK(!strcmp(al_kind_name(AL_KIND_LIGHTMAP), "lightmap"));
    CHECK(!strcmp(al_kind_name(AL_KIND_PROBES), "probes"));
    CHECK(!strcmp(al_kind_name(AL_KIND_MEDIUM), "medium"));
    CHECK(!strcmp(al_kind_name((al_kind)77), "unknown"));
}

static bool file_is(const char *path, const char *text)
{
    forged f = forge_load(path);
    bool good = f.data && f.size == strlen(text) && !memcmp(f.data, text, f.size);
    free(f.data);
    return good;
}

static void test_whole_files(const char *folder)
{
    char path[512], under_file[600];
    al_error error = {0};
    snprintf(path, sizeof path, "%s/report.json", folder);
    snprintf(under_file, sizeof under_file, "%s/report.json", path);
    CHECK(al_write_file(path, "first", 5, &error) == AL_OK && file_is(path, "first"));
    CHECK(al_write_file(path, "second text", 11, &error) == AL_OK && file_is(path, "second text"));
    CHECK(al_write_file(path, NULL, 0, &error) == AL_OK && file_is(path, ""));
    CHECK(al_write_file(under_file, "x", 1, &error) == AL_IO && strstr(error.message, under_file));
    CHECK(al_write_file(folder, "x", 1, &error) == AL_IO &&
          strstr(error.message, folder)); /* a folder's name */
    CHECK(folder_count(folder) == 1);
    unlink(path);
}

/* A writer that would publish what its own reader refuses, or that is given up, leaves nothing. */
static void test_writer(const char *folder)
{
    char path[512];
    al_error error = {0};
    al_writer *writer;
    uint64_t bytes = 1;
    snprintf(path, sizeof path, "%s/asset.air", folder);
    CHECK(al_writer_open(path, AL_KIND_TRANSLUCENT, &writer, &error) == AL_OK);
    CHECK(al_writer_add(writer, "INFO", 1, 0, "0123", 4, &error) == AL_OK);
    CHECK(al_writer_commit(writer, &bytes, &error) == AL_BAD_INPUT && bytes == 0);
    CHECK(strstr(error.message, "asset.air: ") && strstr(error.message, "(rule 120)") &&
          !strstr(error.message, ".tmp"));
    CHECK(folder_count(folder) == 0);
    CHECK(al_writer_open(path, AL_KIND_TRANSLUCENT, &writer, &error) == AL_OK && folder_count(folder) == 1);
    al_writer_discard(writer);
    CHECK(folder_count(folder) == 0);
    al_writer_discard(NULL);
    snprintf(path, sizeof path, "%s/absent/asset.air", folder);
    CHECK(al_writer_open(path, AL_KIND_SCENE, &writer, &error) == AL_IO && !writer &&
          strstr(error.message, "absent/asset.air"));
}

int main(void)
{
    char folder[256];
    if (!folder_make(folder, sizeof folder)) return test_skip("no temporary folder");
    test_reading();
    test_options();
    test_kind_names();
    test_whole_files(folder);
    test_writer(folder);
    CHECK(rmdir(folder) == 0);
    return test_end();
}
