/* The light that arrives at a point: what a lightmap texel or a light probe holds.
 *
 * Three layers: `surface`, as if there were no fog; `attenuated`, the fog only absorbs and takes away what it
 * scatters; `scattered`, what the fog adds to that: everything that was scattered once or more often, on any
 * part of its way. Final light is attenuated + scattered. Surfaces reflect as two-sided Lambert ones. The
 * method: docs/methods.md.
 *
 * Thread safety: any number of threads may ask one gather, each with a scratch of its own. What is answered
 * depends on the arguments alone. */
#ifndef AIRLIGHT_GATHER_H
#define AIRLIGHT_GATHER_H

#include "airlight/impulse_tables.h"
#include "import.h"

enum { AL_GATHER_SH_COUNT = 64 }; /* of order 8 */

typedef struct al_gather_options {
    /* Paths a point, 1 or more; powers of two are spread best. Of bounded walls scattered light is gathered
     * along the first ways of 128 of them, of a quarter if that is more, and along 64 if there are fewer. */
    uint32_t samples;
    uint32_t bounces;  /* diffuse reflections on a path; 0: light that comes straight from lights and fog */
    bool fog;          /* false: `scattered` is 0 and `attenuated` equals `surface` */
    al_walls walls;    /* how scattered light is kept from passing through walls */
    bool back_scatter; /* published walls: gather over the whole sphere, the receiver shifted */
    double back_scatter_shift_m; /* along its normal; 0: 0.125 of the texel's edge */
    uint32_t sh_order;           /* bands of incident radiance, 0 (none) to 8 */
    bool lamps_apart;            /* leave out what point and directional lights send straight to the point */
    unsigned threads;            /* of al_gather_open; 0: one per core */
    uint32_t seed;               /* of al_gather_open */
    /* Bounded and traced walls: points in the fog along the longest edge of their box; 0: 16. */
    uint32_t fog_points;
    uint32_t fog_samples; /* paths from each; 0: as many as `samples`, 32 to 128 */
    /* Called by the caller's thread now and then while opening; true stops (AL_CANCELLED). May be NULL. */
    bool (*on_progress)(void *user, double done, double total);
    void *user;
} al_gather_options;

typedef struct al_gather al_gather;

/* Builds what all points share. The import and the tables must outlive it. `tables` may be NULL unless there
 * is fog and the walls are as published. Instances lit by probes may move and are left out.
 * AL_BAD_INPUT: published walls where every path would grow from segment to segment, see docs/methods.md. */
al_status al_gather_open(const al_import *import, const al_impulse_tables *tables,
                         const al_gather_options *options, al_gather **gather, al_error *error);
void al_gather_close(al_gather *gather); /* NULL is allowed */

/* Memory of one thread. */
typedef struct al_gather_scratch al_gather_scratch;
al_gather_scratch *al_gather_scratch_new(const al_gather *gather); /* NULL without memory */
void al_gather_scratch_free(al_gather_scratch *scratch);           /* NULL is allowed */

typedef enum al_gather_layer {
    AL_GATHER_SURFACE = 0,
    AL_GATHER_ATTENUATED = 1,
    AL_GATHER_SCATTERED = 2,
    AL_GATHER_LAYER_COUNT = 3
} al_gather_layer;

typedef struct al_gathered {
    double surface[3], attenuated[3], scattered[3]; /* irradiance, W/m2, per channel; 0 for a probe */
    /* [layer][channel][l(l+1)+m]: incident radiance over the directions it arrives from, W/(m2 sr), below
     * sh_order; of a point with a normal only what arrives from its side. */
    double sh[AL_GATHER_LAYER_COUNT][3][AL_GATHER_SH_COUNT];
    double back_share; /* of the first rays, those that met the back of a one-sided surface */
} al_gathered;

/* At a surface point with its unit `normal` on the side that is asked for, or in the air when `normal` is
 * NULL (a probe). `texel_m` is the edge of the texel, for the shift of back-scatter. Rays begin a rounding
 * step off the surface. Every seed gives another set of paths. False without memory. */
bool al_gather_point(const al_gather *gather, al_gather_scratch *scratch, const double position[3],
                     const double *normal, double texel_m, uint64_t seed, al_gathered *out);

#endif
