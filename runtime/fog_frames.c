/* Density sequences: which frame of a medium is shown at a time, and the slots of the bricks' atlas that frames come
 * into while another is shown. A medium of one frame has one slot; a sequence has three: the frame that is shown, and
 * the next ones of the loop, or, after a jump, the one that is wanted and its successor. What is shown changes when
 * all bricks of the wanted frame are there, so that nothing waits and no frame is ever seen in part. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "state.h"

uint32_t al_fog_slot_count(const al_medium_info *info)
{
    return info->frame_count < AL_FOG_SLOTS ? info->frame_count : AL_FOG_SLOTS;
}

/* The last frame lasts as long as the others do on average. */
static double length_of(const al_fog_medium *medium)
{
    uint32_t last = medium->info.frame_count - 1;
    if (!last) return 0;
    return medium->times_s[last] + ((double)medium->times_s[last] - medium->times_s[0]) / last;
}

/* The nearest in time; of two as near the later. */
static uint32_t frame_at(const al_fog_medium *medium, double time_s)
{
    uint32_t low = 0, high = medium->info.frame_count - 1;
    while (low < high) { /* the first frame that is no nearer than the next one is not the one */
        uint32_t middle = low + (high - low) / 2;
        if (time_s >= 0.5 * ((double)medium->times_s[middle] + medium->times_s[middle + 1]))
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static void show(al_fog_medium *medium, uint32_t slot)
{
    const al_fog_slot *s = &medium->slots[slot];
    medium->shown = slot;
    medium->frame = s->frame;
    medium->first_brick = s->first_brick;
    medium->first_cell = s->first_cell;
    medium->loaded = s->loaded;
    medium->depths = s->depths;
}

static bool is_whole(const al_fog_slot *slot)
{
    return slot->filled && slot->loaded == slot->frame.brick_count;
}

/* The slot that holds the whole of a frame, or AL_NO_INDEX. */
static uint32_t slot_of(const al_fog_medium *medium, uint32_t frame)
{
    for (uint32_t i = 0; i < al_fog_slot_count(&medium->info); i++)
        if (is_whole(&medium->slots[i]) && medium->slots[i].index == frame) return i;
    return AL_NO_INDEX;
}

void al_fog_begin_frame(al_fog_medium *medium, uint32_t index, const al_medium_frame *frame)
{
    al_fog_slot *slot = &medium->slots[medium->incoming];
    slot->frame = *frame;
    slot->index = index;
    slot->loaded = 0;
    slot->filled = true;
    al_fog_take_bricks(medium, 0);
}

void al_fog_take_bricks(al_fog_medium *medium, uint32_t count)
{
    al_fog_slot *slot = &medium->slots[medium->incoming];
    slot->loaded += count;
    if (medium->incoming == medium->shown) show(medium, medium->shown);
    if (is_whole(slot)) medium->incoming = AL_NO_INDEX;
}

/* Of the frames from the wanted one on, in the order of the loop, the first that no slot holds, if there is a slot for
 * it: none that is shown, nor one that holds a frame before it in that order. */
static bool choose_next(const al_fog_medium *medium, uint32_t wanted, uint32_t *frame, uint32_t *slot)
{
    uint32_t slots = al_fog_slot_count(&medium->info);
    bool kept[AL_FOG_SLOTS] = {false};
    kept[medium->shown] = true;
    for (uint32_t ahead = 0; ahead < slots; ahead++) {
        *frame = (wanted + ahead) % medium->info.frame_count;
        uint32_t held = slot_of(medium, *frame);
        if (held != AL_NO_INDEX) {
            kept[held] = true;
            continue;
        }
        for (*slot = 0; *slot < slots; ++*slot)
            if (!kept[*slot]) return true;
        return false;
    }
    return false;
}

void al_fog_follow(al_runtime *runtime)
{
    for (uint32_t i = 0; i < runtime->scene.fog_count; i++) {
        al_fog_medium *medium = &runtime->fogs.media[i];
        uint32_t frame, slot;
        if (!medium->present || medium->failed || medium->info.frame_count < 2) continue;
        medium->wanted = frame_at(medium, runtime->moving.time_s);
        uint32_t held = slot_of(medium, medium->wanted);
        if (held != AL_NO_INDEX && held != medium->shown) show(medium, held);
        if (medium->incoming != AL_NO_INDEX || !choose_next(medium, medium->wanted, &frame, &slot)) continue;
        medium->incoming = slot;
        medium->slots[slot].filled = false;
        al_loader_request(runtime->loader, i, frame);
    }
}

bool al_fog_is_current(const al_runtime *runtime)
{
    for (uint32_t i = 0; i < runtime->scene.fog_count; i++) {
        const al_fog_medium *medium = &runtime->fogs.media[i];
        if (!medium->present || medium->failed || medium->info.frame_count < 2) continue;
        if (!is_whole(&medium->slots[medium->shown]) || medium->slots[medium->shown].index != medium->wanted)
            return false;
    }
    return true;
}

double al_fog_length_s(const al_runtime *runtime)
{
    double length_s = 0;
    for (uint32_t i = 0; i < runtime->scene.fog_count; i++)
        if (runtime->fogs.media[i].present) length_s = fmax(length_s, length_of(&runtime->fogs.media[i]));
    return length_s;
}
