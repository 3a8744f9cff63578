#include "bake_step.h"

#include <stdio.h>
#include <string.h>
#include <xxhash.h>

void al_steps_add(al_steps *steps, const char *name, double started_s, uint64_t bytes_written, uint64_t items)
{
    if (steps->count < AL_STEP_LIMIT)
        steps->steps[steps->count++] =
            (al_step){name, al_program_seconds() - started_s, bytes_written, items};
}

void al_asset_file(const char *name, const char *kind, char *file, size_t size)
{
    char safe[120];
    size_t n = 0;
    bool changed = false;
    const char *c = name;
    for (; *c && n + 1 < sizeof safe; c++) {
        safe[n] = *c == '/' || *c == '\\' ? '_' : *c;
        changed = changed || safe[n++] != *c;
    }
    if (*c)
        while (n && (*c & 0xC0) == 0x80) c--, n--; /* UTF-8 is cut between characters */
    changed = changed || *c;
    safe[n] = 0;
    if (changed)
        snprintf(file, size, "%s-%016llx.%s.air", safe, (unsigned long long)XXH64(name, strlen(name), 0),
                 kind);
    else
        snprintf(file, size, "%s.%s.air", safe, kind);
}

void al_scene_asset_file(const al_import *import, const char *kind, char *file, size_t size)
{
    const char *path = import->description->path, *slash = strrchr(path, '/'),
               *base = slash ? slash + 1 : path, *dot = strrchr(base, '.');
    char stem[1024];
    snprintf(stem, sizeof stem, "%.*s", (int)(dot && dot > base ? (size_t)(dot - base) : strlen(base)), base);
    al_asset_file(stem, kind, file, size);
}
