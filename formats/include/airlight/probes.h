/* The probes asset: light that arrives at points in the air, and a tetrahedral mesh between them.
 *
 * Each probe holds incident radiance as real SH in world axes, W/(m2 sr), not convolved with anything, in the
 * layers of a lightmap (airlight/lightmap.h), but for what point and directional lights send straight to it: who
 * draws with them adds that himself, with shadows. Light in between is the barycentric mean of the four probes of
 * the tetrahedron around a point. Cupisz 2012, "Light Probe Interpolation Using Tetrahedral Tessellations".
 * Thread safety and lifetime: as al_file; every pointer is valid until al_file_close. */
#ifndef AIRLIGHT_PROBES_H
#define AIRLIGHT_PROBES_H

#include "airlight/lightmap.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { AL_PROBES_MAX_ORDER = 8, AL_PROBES_MAX_COUNT = 64 };

typedef struct al_probes_info {
    uint32_t probe_count;       /* 1 or more */
    uint32_t tetrahedron_count; /* 0: the nearest probe answers everywhere */
    uint32_t order;             /* SH bands, 1 to 8 */
} al_probes_info;

typedef struct al_probes {
    al_probes_info info;
    const float *positions;     /* [probe_count][3] m */
    const uint32_t *tetrahedra; /* [tetrahedron_count][4] probes, of positive volume */
    const uint32_t *neighbours; /* [tetrahedron_count][4] behind the face across from corner k; AL_NO_INDEX */
    const float *coefficients;  /* [probe_count][AL_LAYER_COUNT][3 channels][order^2] */
} al_probes;

/* Reads and validates everything; `file` must be of kind probes. */
al_status al_probes_read(const al_file *file, al_probes *probes, al_error *error);

typedef struct al_probe_place {
    uint32_t tetrahedron; /* where the next search begins; 0 at first */
    uint32_t probes[4];
    float weights[4]; /* sum 1, none negative */
} al_probe_place;

/* Finds the four probes around a finite position and their weights. Walks from place->tetrahedron to the
 * neighbour across the face that the position lies farthest behind: for a point that moves a little, few
 * steps. Where that leads out of the mesh all tetrahedra are looked at, and the nearest point of the mesh
 * answers: it moves steadily with the position. */
void al_probes_locate(const al_probes *probes, const float position[3], al_probe_place *place);

/* Incident radiance of one layer there: sh[channel][0 .. order^2). */
void al_probes_blend(const al_probes *probes, const al_probe_place *place, al_lightmap_layer layer,
                     float sh[3][AL_PROBES_MAX_COUNT]);

/* What a writer hands over; arrays as in al_probes but for the neighbours, which it finds. */
typedef struct al_probes_data {
    al_probes_info info;
    const float *positions;
    const uint32_t *tetrahedra;
    const float *coefficients;
    const char *provenance_json;
    const al_measured *measured; /* chunks MEAS */
    uint32_t measured_count;
} al_probes_data;

/* Writes the whole asset atomically. bytes may be NULL. */
al_status al_probes_write(const char *path, const al_probes_data *data, uint64_t *bytes, al_error *error);

#ifdef __cplusplus
}
#endif
#endif
