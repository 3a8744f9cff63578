#include "airlight/scene.h"

#include <stdlib.h>
#include <string.h>

/* --- memory: everything a scene owns hangs on one list --- */

typedef struct block {
    struct block *next;
    max_align_t payload[];
} block;

void *al_scene_allocate(al_scene *scene, size_t size)
{
    if (size > SIZE_MAX - sizeof(block)) return NULL;
    block *made = calloc(1, sizeof(block) + size);
    if (!made) return NULL;
    made->next = scene->storage;
    scene->storage = made;
    return made->payload;
}

char *al_scene_text(al_scene *scene, const char *text)
{
    size_t size = strlen(text) + 1;
    char *copy = al_scene_allocate(scene, size);
    if (copy) memcpy(copy, text, size);
    return copy;
}

void al_scene_free(al_scene *scene)
{
    for (block *here = scene->storage, *next; here; here = next) {
        next = here->next;
        free(here);
    }
    *scene = (al_scene){0};
}
