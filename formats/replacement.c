#define _POSIX_C_SOURCE 200809L
#include "replacement.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "airlight/container.h"

enum { WRITE_LIMIT = 1 << 30 }; /* bytes per system call: Linux ends each one at 2 GiB */

static al_status fail_io(const char *path, const char *action, al_error *error)
{
    return al_fail(error, AL_IO, "%s: cannot %s: %s", path, action, strerror(errno));
}

/* A name that no living writer uses; O_EXCL decides. */
static int open_temporary(al_replacement *replacement, size_t size)
{
    enum { TRIES = 1000 };
    int descriptor = -1;
    for (int i = 0; i < TRIES; i++) {
        snprintf(replacement->temporary, size, "%s.%ld-%d.tmp", replacement->path, (long)getpid(), i);
        descriptor = open(replacement->temporary, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (descriptor >= 0 || errno != EEXIST) break;
    }
    return descriptor;
}

al_status al_replacement_open(const char *path, al_replacement *replacement, al_error *error)
{
    struct stat about;
    size_t length = strlen(path), size = length + 40;
    *replacement = (al_replacement){.descriptor = -1};
    if (stat(path, &about) == 0 && !S_ISREG(about.st_mode)) /* /dev/null would become a file */
        return al_fail(error, AL_IO, "%s: is no regular file and stays; give another name", path);
    replacement->path = malloc(length + 1);
    replacement->temporary = malloc(size);
    if (!replacement->path || !replacement->temporary) {
        al_fail(error, AL_IO, "%s: out of memory", path);
        goto cleanup;
    }
    memcpy(replacement->path, path, length + 1);
    replacement->descriptor = open_temporary(replacement, size);
    if (replacement->descriptor >= 0) return AL_OK;
    fail_io(path, "create a file beside it", error);
cleanup:
    free(replacement->path);
    free(replacement->temporary);
    *replacement = (al_replacement){.descriptor = -1};
    return AL_IO;
}

al_status al_replacement_write(al_replacement *replacement, uint64_t offset, const void *data, size_t size,
                               al_error *error)
{
    const char *bytes = data;
    while (size) {
        ssize_t written =
            pwrite(replacement->descriptor, bytes, size < WRITE_LIMIT ? size : WRITE_LIMIT, (off_t)offset);
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) {
            if (written == 0) errno = ENOSPC;
            return fail_io(replacement->path, "write", error);
        }
        bytes += written;
        size -= (size_t)written;
        offset += (uint64_t)written;
    }
    return AL_OK;
}

void al_replacement_discard(al_replacement *replacement)
{
    if (replacement->descriptor >= 0) close(replacement->descriptor);
    if (replacement->temporary) unlink(replacement->temporary);
    free(replacement->path);
    free(replacement->temporary);
    *replacement = (al_replacement){.descriptor = -1};
}

/* The rename is durable once the folder is. Some file systems cannot sync a folder (EINVAL) and need not. */
static al_status sync_folder(const char *path, al_error *error)
{
    const char *slash = strrchr(path, '/');
    size_t length = slash ? (size_t)(slash - path) + 1 : 1;
    char *folder = malloc(length + 1);
    if (!folder) return al_fail(error, AL_IO, "%s: out of memory", path);
    memcpy(folder, slash ? path : ".", length);
    folder[length] = 0;
    al_status status = AL_OK;
    int descriptor = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0 || (fsync(descriptor) != 0 && errno != EINVAL))
        status = fail_io(path, "make its name in the folder last", error);
    if (descriptor >= 0) close(descriptor);
    free(folder);
    return status;
}

al_status al_replacement_commit(al_replacement *replacement, al_error *error)
{
    al_status status = AL_OK;
    int descriptor = replacement->descriptor;
    if (fsync(descriptor) != 0) {
        status = fail_io(replacement->path, "write", error);
        goto cleanup;
    }
    replacement->descriptor = -1;
    if (close(descriptor) != 0) {
        status = fail_io(replacement->path, "write", error);
        goto cleanup;
    }
    if (rename(replacement->temporary, replacement->path) != 0) {
        status = fail_io(replacement->path, "replace", error);
        goto cleanup;
    }
    free(replacement->temporary);
    replacement->temporary = NULL;
    status = sync_folder(replacement->path, error);
cleanup:
    al_replacement_discard(replacement);
    return status;
}

al_status al_write_file(const char *path, const void *data, size_t size, al_error *error)
{
    al_replacement replacement;
    al_status status = al_replacement_open(path, &replacement, error);
    if (status == AL_OK) status = al_replacement_write(&replacement, 0, data, size, error);
    if (status == AL_OK) return al_replacement_commit(&replacement, error);
    al_replacement_discard(&replacement);
    return status;
}
