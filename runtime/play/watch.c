#define _POSIX_C_SOURCE 200809L
#include "watch.h"

#include <dirent.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

static const double look_every_s = 0.5;

/* FNV-1a; the files' hashes are summed, so that their order does not count. */
static uint64_t hash_file(const char *name, const struct stat *about)
{
    uint64_t hash = 14695981039346656037u;
    const uint64_t numbers[3] = {(uint64_t)about->st_size, (uint64_t)about->st_mtim.tv_sec,
                                 (uint64_t)about->st_mtim.tv_nsec};
    for (; *name; name++) hash = (hash ^ (unsigned char)*name) * 1099511628211u;
    for (int i = 0; i < 24; i++) hash = (hash ^ (numbers[i / 8] >> (i % 8 * 8) & 255)) * 1099511628211u;
    return hash;
}

static uint64_t signature(const char *folder)
{
    uint64_t sum = 0;
    DIR *dir = opendir(folder);
    if (!dir) return 0;
    for (struct dirent *entry; (entry = readdir(dir));) {
        char path[4096];
        struct stat about;
        size_t length = strlen(entry->d_name);
        if (length < 4 || strcmp(entry->d_name + length - 4, ".air")) continue;
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        if (!stat(path, &about)) sum += hash_file(entry->d_name, &about);
    }
    closedir(dir);
    return sum;
}

void al_watch_begin(al_watch *watch, const char *folder, double now_s)
{
    watch->loaded = watch->seen = signature(folder);
    watch->looked_s = now_s;
}

bool al_watch_changed(al_watch *watch, const char *folder, double now_s)
{
    if (now_s - watch->looked_s < look_every_s) return false;
    uint64_t now = signature(folder);
    bool settled = now == watch->seen && now != watch->loaded && now != 0;
    watch->seen = now;
    watch->looked_s = now_s;
    if (settled) watch->loaded = now;
    return settled;
}
