/* Which triangles of a mesh meet at an edge. */
#ifndef AIRLIGHT_EDGES_H
#define AIRLIGHT_EDGES_H

#include "airlight/scene.h"

typedef struct al_edges {
    uint32_t group_count;
    uint32_t *starts; /* [group_count + 1] into sides */
    uint32_t *sides;  /* [index_count] 3 * triangle + edge, grouped: edge k runs from corner k to k + 1 */
    uint32_t *group;  /* [index_count] of a side */
    uint32_t *points; /* [vertex_count] vertices at exactly the same place have the same point */
} al_edges;

al_status al_edges_make(const al_mesh *mesh, al_edges *edges, al_error *error);
void al_edges_free(al_edges *edges);

#endif
