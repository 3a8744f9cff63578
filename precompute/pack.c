#include "pack.h"

#include <math.h>
#include <stdlib.h>

#define STBRP_STATIC
#define STB_RECT_PACK_IMPLEMENTATION
#include <stb/stb_rect_pack.h>

static bool pack_into(stbrp_node *nodes, stbrp_rect *rects, int count, int edge)
{
    stbrp_context context;
    stbrp_init_target(&context, edge, edge, nodes, edge);
    return stbrp_pack_rects(&context, rects, count) == 1;
}

/* The square grows by 3 % until it takes all or is at the limit. */
static void pack_all(stbrp_node *nodes, stbrp_rect *rects, int count, int limit)
{
    double area = 0, edge = 1;
    for (int i = 0; i < count; i++) {
        area += (double)rects[i].w * rects[i].h;
        edge = fmax(edge, rects[i].w > rects[i].h ? rects[i].w : rects[i].h);
    }
    edge = fmin(fmax(edge, ceil(sqrt(area))), limit);
    while (!pack_into(nodes, rects, count, (int)edge) && edge < limit)
        edge = fmin(floor(edge * 1.03) + 1, limit);
}

al_status al_pack(al_pack_rectangle *rectangles, uint32_t count, uint32_t limit, uint32_t *packed,
                  al_error *error)
{
    stbrp_node *nodes = malloc((limit + (size_t)1) * sizeof *nodes);
    stbrp_rect *rects = malloc((count + (size_t)1) * sizeof *rects);
    int open = 0;
    *packed = 0;
    if (!nodes || !rects) {
        free(nodes);
        free(rects);
        return al_fail(error, AL_IO, "out of memory for %u rectangles", count);
    }
    for (uint32_t i = 0; i < count; i++)
        if (!rectangles[i].packed)
            rects[open++] = (stbrp_rect){
                .id = (int)i, .w = (stbrp_coord)rectangles[i].width, .h = (stbrp_coord)rectangles[i].height};
    pack_all(nodes, rects, open, (int)limit);
    for (int i = 0; i < open; i++) {
        if (!rects[i].was_packed) continue;
        al_pack_rectangle *r = &rectangles[rects[i].id];
        r->x = (uint32_t)rects[i].x;
        r->y = (uint32_t)rects[i].y;
        r->packed = true;
        ++*packed;
    }
    free(nodes);
    free(rects);
    return AL_OK;
}
