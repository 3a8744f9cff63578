#include "timing.h"

#include <string.h>

const char *al_stage_name(al_stage stage)
{
    static const char *const names[AL_STAGE_COUNT] = {
        "skin",          "shadow",         "surfels",           "surfel light",     "light",
        "surface",       "direct-scattering", "interval-map",   "span",             "legs",
        "shells",        "bounce-rays",    "bounce",            "bounce-light",     "occlusion-rays",
        "occlusion-hits", "occlusion-arrive", "occlusion-filter", "occlusion-history", "indirect-rays",
        "indirect-hits", "indirect-arrive", "indirect-filter", "indirect-history", "unshuffle",      "blur",             "gather",
        "intervals",     "splat",          "composite"};
    return names[stage];
}

/* Takes over a pending frame whose last query is back; false when it is not yet. */
static bool collect(al_timing *timing, al_timing_frame *frame)
{
    GLuint available = 1;
    if (frame->count)
        glGetQueryObjectuiv(frame->queries[frame->count - 1], GL_QUERY_RESULT_AVAILABLE, &available);
    if (!available) return false;
    memset(timing->ms, 0, sizeof timing->ms);
    memset(timing->runs, 0, sizeof timing->runs);
    for (uint32_t i = 0; i + 1 < frame->count; i += 2) {
        GLuint64 begin = 0, end = 0; /* nanoseconds */
        glGetQueryObjectui64v(frame->queries[i], GL_QUERY_RESULT, &begin);
        glGetQueryObjectui64v(frame->queries[i + 1], GL_QUERY_RESULT, &end);
        timing->ms[frame->stages[i / 2]] += end > begin ? (double)(end - begin) * 1e-6 : 0;
        timing->runs[frame->stages[i / 2]]++;
    }
    frame->pending = false;
    return true;
}

void al_timing_collect(al_timing *timing)
{
    for (uint32_t i = 1; i <= AL_TIMING_RING; i++) { /* oldest first */
        al_timing_frame *frame = &timing->ring[(timing->current + i) % AL_TIMING_RING];
        if (frame->pending && !collect(timing, frame)) break;
    }
}

void al_timing_begin_frame(al_timing *timing)
{
    al_timing_collect(timing);
    memset(timing->ran, 0, sizeof timing->ran);
    timing->current = (timing->current + 1) % AL_TIMING_RING;
    timing->active = !timing->ring[timing->current].pending;
    if (timing->active) timing->ring[timing->current].count = 0;
}

void al_timing_end_frame(al_timing *timing)
{
    if (timing->active) timing->ring[timing->current].pending = true;
    timing->active = false;
}

static void mark(al_timing *timing)
{
    al_timing_frame *frame = &timing->ring[timing->current];
    if (!timing->active) return;
    GLuint *query = &frame->queries[frame->count++];
    if (!*query) glCreateQueries(GL_TIMESTAMP, 1, query);
    if (timing->waits) glFinish();
    glQueryCounter(*query, GL_TIMESTAMP);
    if (timing->waits) glFinish(); /* or it would be taken after work that follows it */
}

void al_timing_begin(al_timing *timing, al_stage stage)
{
    al_timing_frame *frame = &timing->ring[timing->current];
    const char *name = al_stage_name(stage);
    timing->ran[stage] = true;
    glPushDebugGroup(GL_DEBUG_SOURCE_APPLICATION, (GLuint)stage, -1, name);
    if (timing->active && frame->count == AL_TIMING_QUERIES) timing->active = false; /* too many: not timed */
    if (timing->active) frame->stages[frame->count / 2] = (uint8_t)stage;
    mark(timing);
}

void al_timing_end(al_timing *timing)
{
    mark(timing);
    glPopDebugGroup();
}

void al_timing_free(al_timing *timing)
{
    for (int i = 0; i < AL_TIMING_RING; i++)
        for (int k = 0; k < AL_TIMING_QUERIES; k++)
            if (timing->ring[i].queries[k]) glDeleteQueries(1, &timing->ring[i].queries[k]);
    memset(timing, 0, sizeof *timing);
}
