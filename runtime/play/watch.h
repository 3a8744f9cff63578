/* Sees when a baked folder has changed. Looks at names, sizes and times, so that it works on every file
 * system. */
#ifndef AIRLIGHT_WATCH_H
#define AIRLIGHT_WATCH_H

#include <stdbool.h>
#include <stdint.h>

typedef struct al_watch {
    uint64_t loaded, seen; /* signatures of the folder: as loaded, and at the last look */
    double looked_s;
} al_watch;

/* Call when the folder is loaded. */
void al_watch_begin(al_watch *watch, const char *folder, double now_s);
/* True once for each change, as soon as two looks half a second apart see the same files. */
bool al_watch_changed(al_watch *watch, const char *folder, double now_s);

#endif
