/* GPU time per pass by pairs of timestamps that are read frames later, so that nothing waits; and the
 * KHR_debug group of each pass. */
#ifndef AIRLIGHT_RUNTIME_TIMING_H
#define AIRLIGHT_RUNTIME_TIMING_H

#include <epoxy/gl.h>
#include <stdbool.h>
#include <stdint.h>

#include "airlight/runtime.h"

typedef enum al_stage {
    AL_STAGE_SKIN,
    AL_STAGE_SHADOW,
    AL_STAGE_SURFELS,
    AL_STAGE_SURFEL_LIGHT,
    AL_STAGE_LIGHT,
    AL_STAGE_SURFACE,
    AL_STAGE_FOG,
    AL_STAGE_INTERVAL_MAP,
    AL_STAGE_SPAN,
    AL_STAGE_LEGS,
    AL_STAGE_SHELLS,
    AL_STAGE_BOUNCE_RAYS,
    AL_STAGE_BOUNCE,
    AL_STAGE_BOUNCE_LIGHT,
    AL_STAGE_OCCLUSION_RAYS, /* and what follows, in the order of al_bounce_surface's steps */
    AL_STAGE_OCCLUSION_HITS,
    AL_STAGE_OCCLUSION_ARRIVE,
    AL_STAGE_OCCLUSION_FILTER,
    AL_STAGE_OCCLUSION_HISTORY,
    AL_STAGE_INDIRECT_RAYS, /* likewise */
    AL_STAGE_INDIRECT_HITS,
    AL_STAGE_INDIRECT_ARRIVE,
    AL_STAGE_INDIRECT_FILTER,
    AL_STAGE_INDIRECT_HISTORY,
    AL_STAGE_UNSHUFFLE,
    AL_STAGE_BLUR,
    AL_STAGE_GATHER,
    AL_STAGE_INTERVALS,
    AL_STAGE_SPLAT,
    AL_STAGE_COMPOSITE,
    AL_STAGE_COUNT
} al_stage;

enum { AL_TIMING_RING = 3, AL_TIMING_QUERIES = 2048 };

typedef struct al_timing_frame {
    GLuint queries[AL_TIMING_QUERIES]; /* timestamps, a pair for each run of a stage; made on first use */
    uint8_t stages[AL_TIMING_QUERIES / 2];
    uint32_t count;
    bool pending;
} al_timing_frame;

typedef struct al_timing {
    al_timing_frame ring[AL_TIMING_RING];
    uint32_t current;
    bool active;                   /* this frame is timed */
    bool waits;                    /* all work ends before each timestamp or begins after it: software renderers do vertices
                                    * outside the queue, whose time would be nobody's; frames take longer */
    double ms[AL_STAGE_COUNT];     /* of the last frame that came back */
    uint32_t runs[AL_STAGE_COUNT]; /* how often each stage ran in it */
    bool ran[AL_STAGE_COUNT];      /* in the last frame, back or not */
} al_timing;

const char *al_stage_name(al_stage stage);
/* Takes over the frames whose queries have come back; never waits. */
void al_timing_collect(al_timing *timing);
void al_timing_begin_frame(al_timing *timing);
void al_timing_end_frame(al_timing *timing);
void al_timing_begin(al_timing *timing, al_stage stage);
void al_timing_end(al_timing *timing);
void al_timing_free(al_timing *timing);

#endif
