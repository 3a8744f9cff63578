#define _GNU_SOURCE /* memfd_create */
#include "tetrahedra.h"

#include <errno.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "beside.h"

extern char **environ;

enum { HEADER_SIZE = 24 };
static const char columns_magic[] = "ALTETCO1";

/* The program's three streams are files in memory: nothing can block, and nothing is left on a disk. */
typedef struct exchange {
    int in, out, err;
} exchange;

static al_status open_exchange(exchange *files, al_error *error)
{
    files->in = memfd_create("surface", MFD_CLOEXEC);
    files->out = memfd_create("tetrahedra", MFD_CLOEXEC);
    files->err = memfd_create("messages", MFD_CLOEXEC);
    if (files->in >= 0 && files->out >= 0 && files->err >= 0) return AL_OK;
    return al_fail_errno(error, "airlight-tetrahedra", "make files in memory for");
}

static void close_exchange(const exchange *files)
{
    const int all[3] = {files->in, files->out, files->err};
    for (int i = 0; i < 3; i++)
        if (all[i] >= 0) close(all[i]);
}

static bool write_all(int file, const void *data, size_t size)
{
    const char *at = data;
    while (size) {
        ssize_t written = write(file, at, size);
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) return false;
        at += written;
        size -= (size_t)written;
    }
    return true;
}

/* The layout: precompute/tetrahedra/main.cpp. */
static al_status write_surface(int file, const al_triangles *surface, al_error *error)
{
    char header[HEADER_SIZE] = "ALTETIN1";
    const uint64_t counts[2] = {surface->vertex_count, surface->triangle_count};
    memcpy(header + 8, counts, sizeof counts);
    if (write_all(file, header, sizeof header) &&
        write_all(file, surface->positions, surface->vertex_count * sizeof(double[3])) &&
        write_all(file, surface->indices, surface->triangle_count * sizeof(uint32_t[3])) &&
        lseek(file, 0, SEEK_SET) == 0)
        return AL_OK;
    return al_fail_errno(error, "airlight-tetrahedra", "hand the surface to");
}

static al_status start(const char *path, const exchange *files, pid_t *child, al_error *error)
{
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    sigset_t none; /* Ctrl-C ends the child at once, although it waits here */
    char program[PATH_MAX];
    snprintf(program, sizeof program, "%s", path);
    char *arguments[] = {program, NULL};
    if (posix_spawn_file_actions_init(&actions)) return al_fail(error, AL_IO, "%s: out of memory", path);
    if (posix_spawnattr_init(&attributes)) {
        posix_spawn_file_actions_destroy(&actions);
        return al_fail(error, AL_IO, "%s: out of memory", path);
    }
    sigemptyset(&none);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
    int failed = posix_spawn_file_actions_adddup2(&actions, files->in, STDIN_FILENO);
    if (!failed) failed = posix_spawn_file_actions_adddup2(&actions, files->out, STDOUT_FILENO);
    if (!failed) failed = posix_spawn_file_actions_adddup2(&actions, files->err, STDERR_FILENO);
    if (!failed) failed = posix_spawn(child, path, &actions, &attributes, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
    if (failed)
        return al_fail(error, AL_IO, "%s: cannot be started: %s; it belongs beside the program that runs",
                       path, strerror(failed));
    return AL_OK;
}

/* The program's own line without its name, or how it ended. */
static al_status explain(const char *name, int ended, int messages, al_error *error)
{
    char text[AL_ERROR_SIZE / 2] = "";
    ssize_t size = pread(messages, text, sizeof text - 1, 0);
    text[size > 0 ? size : 0] = 0;
    text[strcspn(text, "\n")] = 0;
    const char *line = strstr(text, "standard input: ");
    line = line ? line + strlen("standard input: ") : text;
    if (WIFSIGNALED(ended) && (WTERMSIG(ended) == SIGINT || WTERMSIG(ended) == SIGTERM))
        return al_fail(error, AL_CANCELLED, "%s: cancelled while filling it with tetrahedra", name);
    if (WIFEXITED(ended) && WEXITSTATUS(ended) == AL_IO) return al_fail(error, AL_IO, "%s: %s", name, line);
    return al_fail(error, AL_BAD_INPUT, "%s: %s", name,
                   *line ? line
                         : "cannot be filled with tetrahedra; airlight-tetrahedra ended without a word");
}

static al_status run_program(const char *name, const exchange *files, al_error *error)
{
    char path[PATH_MAX];
    pid_t child;
    int ended = 0;
    al_status status = al_find_beside("airlight-tetrahedra", path, error);
    if (!status) status = start(path, files, &child, error);
    if (status) return status;
    while (waitpid(child, &ended, 0) < 0)
        if (errno != EINTR) return al_fail_errno(error, path, "wait for");
    return WIFEXITED(ended) && WEXITSTATUS(ended) == 0 ? AL_OK : explain(name, ended, files->err, error);
}

static bool is_result(const char *bytes, size_t size, uint64_t counts[2])
{
    if (size < HEADER_SIZE || (memcmp(bytes, "ALTETOU1", 8) != 0 && memcmp(bytes, columns_magic, 8) != 0))
        return false;
    memcpy(counts, bytes + 8, 2 * sizeof *counts);
    if (counts[0] > UINT32_MAX || counts[1] > UINT32_MAX) return false;
    return size == HEADER_SIZE + counts[0] * sizeof(double[3]) + counts[1] * sizeof(uint32_t[4]);
}

static al_status read_result(int file, al_tetrahedra *out, al_error *error)
{
    struct stat facts;
    uint64_t counts[2];
    al_status status = AL_OK;
    char *bytes = MAP_FAILED;
    if (fstat(file, &facts) == 0 && facts.st_size > 0)
        bytes = mmap(NULL, (size_t)facts.st_size, PROT_READ, MAP_PRIVATE, file, 0);
    if (bytes == MAP_FAILED || !is_result(bytes, (size_t)facts.st_size, counts)) {
        status = al_fail(error, AL_IO, "airlight-tetrahedra: its answer is not whole");
        goto cleanup;
    }
    size_t points_size = counts[0] * sizeof(double[3]), corners_size = counts[1] * sizeof(uint32_t[4]);
    *out = (al_tetrahedra){(uint32_t)counts[0], (uint32_t)counts[1], malloc(points_size),
                           malloc(corners_size), memcmp(bytes, columns_magic, 8) != 0};
    if (!out->points || !out->corners) {
        status = al_fail(error, AL_IO, "out of memory for %u tetrahedra", out->count);
        goto cleanup;
    }
    memcpy(out->points, bytes + HEADER_SIZE, points_size);
    memcpy(out->corners, bytes + HEADER_SIZE + points_size, corners_size);
    for (size_t i = 0; i < counts[1] * 4 && !status; i++)
        if (out->corners[i] >= out->point_count)
            status = al_fail(error, AL_IO, "airlight-tetrahedra: its answer names a point that is not there");
cleanup:
    if (bytes != MAP_FAILED) munmap(bytes, (size_t)facts.st_size);
    if (status) al_tetrahedra_free(out);
    return status;
}

al_status al_tetrahedralise(const char *name, const al_triangles *surface, al_tetrahedra *tetrahedra,
                            al_error *error)
{
    exchange files = {-1, -1, -1};
    *tetrahedra = (al_tetrahedra){0};
    al_status status = open_exchange(&files, error);
    if (!status) status = write_surface(files.in, surface, error);
    if (!status) status = run_program(name, &files, error);
    if (!status) status = read_result(files.out, tetrahedra, error);
    close_exchange(&files);
    return status;
}

void al_tetrahedra_free(al_tetrahedra *tetrahedra)
{
    free(tetrahedra->points);
    free(tetrahedra->corners);
    *tetrahedra = (al_tetrahedra){0};
}
