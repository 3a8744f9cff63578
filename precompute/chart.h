/* Charts: parts of a mesh that lie flat enough to be projected onto a plane without overlapping themselves.
 */
#ifndef AIRLIGHT_CHART_H
#define AIRLIGHT_CHART_H

#include "edges.h"

#define AL_NO_CHART UINT32_MAX

typedef struct al_charts {
    uint32_t count;
    uint32_t *chart;   /* [triangle_count]; AL_NO_CHART for a triangle without area away from all charts */
    double (*uv)[2];   /* [index_count] of each corner, in texels from the chart's lower corner */
    double (*size)[2]; /* [count] texels */
} al_charts;

/* Cuts the mesh, placed by the column-major matrix, into charts with texels of `texel_m`. A chart has the
 * area of its triangles. No texel's centre is covered twice by one chart whose lower corner lies on a texel's
 * corner. Deterministic. */
al_status al_charts_make(const al_mesh *mesh, const al_edges *edges, const double to_world[16],
                         double texel_m, al_charts *charts, al_error *error);
void al_charts_free(al_charts *charts);

#endif
