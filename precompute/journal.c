#define _POSIX_C_SOURCE 200809L
#include "journal.h"

#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <xxhash.h>

/* Layout: head, then entries: u64 checksum, u64 index, the piece. */
typedef struct head {
    char magic[16];
    uint64_t key, size, count;
} head;

static const char magic[16] = "airlight tiles1";

struct al_journal {
    FILE *file;
    char *path;
    char *pieces;
    size_t size;
    bool *done;
    pthread_mutex_t lock;
    int failure; /* errno of the first write that failed */
};

static uint64_t checksum(uint64_t index, const char *piece, size_t size)
{
    return XXH64(piece, size, XXH64(&index, sizeof index, 0));
}

/* Takes whole entries; answers where the first that is not whole begins. */
static long read_entries(al_journal *j, uint32_t count)
{
    long end = ftell(j->file);
    uint64_t words[2];
    char *piece = malloc(j->size);
    while (piece && fread(words, sizeof words, 1, j->file) == 1 && words[1] < count &&
           fread(piece, j->size, 1, j->file) == 1 && checksum(words[1], piece, j->size) == words[0]) {
        memcpy(j->pieces + words[1] * j->size, piece, j->size);
        j->done[words[1]] = true;
        end = ftell(j->file);
    }
    free(piece);
    return end;
}

/* Goes on behind the whole entries of the same work, else begins anew. */
static bool begin(al_journal *j, const head *wanted)
{
    head found;
    long end = 0;
    j->file = fopen(j->path, "r+b");
    if (j->file && fread(&found, sizeof found, 1, j->file) == 1 && !memcmp(&found, wanted, sizeof found))
        end = read_entries(j, (uint32_t)wanted->count);
    if (!j->file) j->file = fopen(j->path, "w+b");
    if (!j->file || fseek(j->file, end, SEEK_SET) != 0 || ftruncate(fileno(j->file), end) != 0) return false;
    return end > 0 || (fwrite(wanted, sizeof *wanted, 1, j->file) == 1 && fflush(j->file) == 0);
}

al_status al_journal_open(const char *path, uint64_t key, void *pieces, size_t size, bool *done,
                          uint32_t count, al_journal **journal, al_error *error)
{
    head wanted = {.key = key, .size = size, .count = count};
    memcpy(wanted.magic, magic, sizeof magic);
    *journal = NULL;
    al_journal *j = calloc(1, sizeof *j);
    if (!j || !(j->path = strdup(path))) {
        free(j);
        return al_fail(error, AL_IO, "%s: out of memory", path);
    }
    j->pieces = pieces;
    j->size = size;
    j->done = done;
    memset(done, 0, count * sizeof *done);
    if (!begin(j, &wanted)) {
        al_status status = al_fail_errno(error, path, "write");
        if (j->file) fclose(j->file);
        free(j->path);
        free(j);
        return status == AL_OK ? AL_IO : status;
    }
    pthread_mutex_init(&j->lock, NULL);
    *journal = j;
    return AL_OK;
}

bool al_journal_append(al_journal *j, uint32_t index)
{
    const char *piece = j->pieces + index * j->size;
    uint64_t words[2] = {checksum(index, piece, j->size), index};
    pthread_mutex_lock(&j->lock);
    if (!j->failure && (fwrite(words, sizeof words, 1, j->file) != 1 ||
                        fwrite(piece, j->size, 1, j->file) != 1 || fflush(j->file) != 0))
        j->failure = errno ? errno : EIO;
    bool good = !j->failure;
    pthread_mutex_unlock(&j->lock);
    j->done[index] = true;
    return good;
}

al_status al_journal_close(al_journal *j, al_error *error)
{
    al_status status = AL_OK;
    if (!j) return AL_OK;
    if (fclose(j->file) != 0 && !j->failure) j->failure = errno;
    if (j->failure)
        status =
            al_fail(error, AL_IO, "%s: cannot write what is finished: %s", j->path, strerror(j->failure));
    pthread_mutex_destroy(&j->lock);
    free(j->path);
    free(j);
    return status;
}
