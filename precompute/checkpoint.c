#include "checkpoint.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "airlight/container.h"

/* A private file of one machine and one version of the program: host byte order, and anything unexpected is
 * simply not used. Layout: head, then the arrays one behind the other. */
typedef struct head {
    char magic[16];
    uint64_t checksum; /* XXH64 of everything behind the head's checksum */
    uint64_t key;
    uint32_t stage, channel, axis, next;
    double numbers[8];
    uint64_t sizes[AL_CHECKPOINT_ARRAYS];
} head;

static const char magic[16] = "airlight part 1";

al_status al_checkpoint_write(const char *path, const al_checkpoint *checkpoint, al_error *error)
{
    size_t size = sizeof(head);
    for (int i = 0; i < AL_CHECKPOINT_ARRAYS; i++) size += checkpoint->arrays[i].size;
    unsigned char *bytes = calloc(size, 1);
    if (!bytes) return al_fail(error, AL_IO, "%s: out of memory", path);
    head h = {.key = checkpoint->key,
              .stage = checkpoint->stage,
              .channel = checkpoint->channel,
              .axis = checkpoint->axis,
              .next = checkpoint->next};
    memcpy(h.magic, magic, sizeof magic);
    memcpy(h.numbers, checkpoint->numbers, sizeof h.numbers);
    size_t at = sizeof h;
    for (int i = 0; i < AL_CHECKPOINT_ARRAYS; i++) {
        h.sizes[i] = checkpoint->arrays[i].size;
        if (h.sizes[i]) memcpy(bytes + at, checkpoint->arrays[i].data, h.sizes[i]);
        at += h.sizes[i];
    }
    memcpy(bytes, &h, sizeof h);
    h.checksum = XXH64(bytes + offsetof(head, key), size - offsetof(head, key), 0);
    memcpy(bytes, &h, sizeof h);
    al_status status = al_write_file(path, bytes, size, error);
    free(bytes);
    return status;
}

static bool read_whole(const char *path, unsigned char **bytes, size_t *size)
{
    FILE *file = fopen(path, "rb");
    *bytes = NULL;
    if (!file) return false;
    long length = fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
    bool good = length >= (long)sizeof(head) && fseek(file, 0, SEEK_SET) == 0;
    if (good) *bytes = malloc((size_t)length);
    good = *bytes && fread(*bytes, 1, (size_t)length, file) == (size_t)length;
    *size = good ? (size_t)length : 0;
    fclose(file);
    return good;
}

void al_checkpoint_read(const char *path, uint64_t key, al_checkpoint *checkpoint)
{
    unsigned char *bytes;
    size_t size, at = sizeof(head);
    head h;
    *checkpoint = (al_checkpoint){.key = key};
    if (!read_whole(path, &bytes, &size)) goto cleanup;
    memcpy(&h, bytes, sizeof h);
    if (memcmp(h.magic, magic, sizeof magic) || h.key != key ||
        h.checksum != XXH64(bytes + offsetof(head, key), size - offsetof(head, key), 0))
        goto cleanup;
    for (int i = 0; i < AL_CHECKPOINT_ARRAYS; i++) {
        void *data = h.sizes[i] ? malloc(h.sizes[i]) : NULL;
        if (h.sizes[i] && !data) {
            al_checkpoint_free(checkpoint);
            goto cleanup;
        }
        if (data) memcpy(data, bytes + at, h.sizes[i]);
        checkpoint->arrays[i].data = data;
        checkpoint->arrays[i].size = h.sizes[i];
        at += h.sizes[i];
    }
    checkpoint->stage = h.stage;
    checkpoint->channel = h.channel;
    checkpoint->axis = h.axis;
    checkpoint->next = h.next;
    memcpy(checkpoint->numbers, h.numbers, sizeof h.numbers);
cleanup:
    free(bytes);
}

void al_checkpoint_free(al_checkpoint *checkpoint)
{
    for (int i = 0; i < AL_CHECKPOINT_ARRAYS; i++) free(checkpoint->arrays[i].data);
    *checkpoint = (al_checkpoint){.key = checkpoint->key};
}

void *al_checkpoint_take(al_checkpoint *checkpoint, unsigned index, uint64_t size)
{
    if (checkpoint->arrays[index].size != size) return NULL;
    void *data = checkpoint->arrays[index].data;
    checkpoint->arrays[index].data = NULL;
    checkpoint->arrays[index].size = 0;
    return data;
}
