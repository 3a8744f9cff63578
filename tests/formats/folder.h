/* A temporary folder of a test's own. */
#ifndef AIRLIGHT_FOLDER_H
#define AIRLIGHT_FOLDER_H

#include <dirent.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static inline bool folder_make(char *folder, size_t size)
{
    const char *base = getenv("TMPDIR");
    snprintf(folder, size, "%s/airlight-formats-XXXXXX", base && *base ? base : "/tmp");
    return mkdtemp(folder) != NULL;
}

/* Files in the folder whose name ends in `suffix`; those are removed when `remove` is set. */
static inline int folder_visit(const char *folder, const char *suffix, bool remove)
{
    int count = 0;
    char path[1024];
    DIR *open_folder = opendir(folder);
    for (struct dirent *entry; open_folder && (entry = readdir(open_folder));) {
        size_t length = strlen(entry->d_name), end = strlen(suffix);
        if (entry->d_name[0] == '.' || length < end || strcmp(entry->d_name + length - end, suffix)) continue;
        count++;
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        if (remove) unlink(path);
    }
    if (open_folder) closedir(open_folder);
    return count;
}

static inline int folder_count(const char *folder)
{
    return folder_visit(folder, "", false);
}

#endif
