/* The loader thread: opens and verifies assets and hands verified pages over, a bounded number at a time.
 * It never touches GL. What an arrival points to lives until al_loader_free. */
#ifndef AIRLIGHT_RUNTIME_LOADER_H
#define AIRLIGHT_RUNTIME_LOADER_H

#include <stdbool.h>

#include "airlight/medium.h"
#include "airlight/probes.h"
#include "airlight/scene.h"
#include "airlight/translucent.h"

typedef struct al_loader al_loader;

typedef enum al_arrival_kind {
    AL_ARRIVAL_OBJECT, /* info and density grid */
    AL_ARRIVAL_PAGE,
    AL_ARRIVAL_MEDIUM,  /* info, times, and index of bricks of a fog's first frame */
    AL_ARRIVAL_FRAME,   /* index of bricks of a frame that was asked for */
    AL_ARRIVAL_BRICKS,  /* a page of the frame that came last */
    AL_ARRIVAL_LIGHTMAP, /* info and instances */
    AL_ARRIVAL_TEXELS,   /* a page of them */
    AL_ARRIVAL_PROBES,   /* all of them */
    AL_ARRIVAL_FAILURE, /* of this asset: nothing more of it comes */
    AL_ARRIVAL_END      /* all there is has arrived, but for frames that are asked for */
} al_arrival_kind;

typedef struct al_arrival {
    al_arrival_kind kind;
    al_kind asset;   /* that it belongs to */
    uint32_t object; /* index into al_scene.translucents, or into al_scene.fogs */
    al_translucent_info info;
    const uint16_t *density; /* as al_translucent_read_grid */
    const uint8_t *blockers;
    al_translucent_page page;
    al_medium_info medium;
    const float *times_s; /* [medium.frame_count] */
    uint32_t brick_limit; /* bricks of the frame with the most */
    al_medium_frame frame;
    uint32_t frame_index;
    al_medium_sky sky; /* with AL_ARRIVAL_MEDIUM */
    al_medium_depth depth; /* likewise */
    const uint16_t *depths; /* of the frame, where there are some */
    al_medium_page bricks;
    al_lightmap_info lightmap;
    const al_lightmap_instance *instances; /* [lightmap.instance_count] */
    uint32_t texels_index;                 /* of the page */
    al_lightmap_page texels;
    al_probes probes;
    al_error error;
} al_arrival;

/* Starts the thread for every asset that the scene names; the names are copied. */
al_status al_loader_create(const char *folder, const al_scene *scene, al_loader **loader, al_error *error);
/* Answers whether something has arrived, without waiting. */
bool al_loader_take(al_loader *loader, al_arrival *arrival);
/* Asks for frame `frame` of a fog's medium, which has arrived; the next request for the same fog only when all of it
 * has come. */
void al_loader_request(al_loader *loader, uint32_t fog, uint32_t frame);
/* Stops the thread (at most one page later), closes the files. NULL is allowed. */
void al_loader_free(al_loader *loader);

#endif
