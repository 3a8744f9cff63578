/* The impulse-tables asset: light that an endless medium scatters onto a receiver, per emitter.
 *
 * After Dubouchet, Sloan, Jarosz, Nowrouzezahrai, Impulse Responses for Precomputing Light from Volumetric
 * Media (EGSR 2019). Emitters: a point of 1 W/sr; a directional light of 1 W/m2 that enters a half-space of
 * medium through a plane that faces it, vacuum before the plane, the receiver at depth `distance_m`; a
 * differential area of intensity max(0, normal . v) W/sr. The tables hold the canonical medium
 * sigma_s = sigma_t = 1 (distances in mean free paths); the look-up scales them to any other. What they mean,
 * byte by byte, and how they are interpolated: docs/formats.md. How they are made: docs/methods.md.
 *
 * A response is the radiance that arrives at the receiver, over the directions it arrives FROM, as real
 * orthonormal spherical harmonics Y(l, m) in the frame of the receiver: z towards the emitter, x towards the
 * side of the emitter's normal (any x for the other emitters); by symmetry only cos(m phi) occurs, m >= 0.
 * Band 0 is fluence / sqrt(4 pi).
 *
 * Thread safety: tables and media may be read by many threads. Look-ups are pure and allocate nothing. */
#ifndef AIRLIGHT_IMPULSE_TABLES_H
#define AIRLIGHT_IMPULSE_TABLES_H

#include "airlight/measured.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    AL_IMPULSE_BAND_LIMIT = 16,
    AL_IMPULSE_EVENT_LIMIT = 16,
    AL_IMPULSE_M_COUNT = 3,      /* orders m = 0, 1, 2 of the area emitter */
    AL_IMPULSE_NUMBER_LIMIT = 48 /* of one entry */
};

typedef enum al_impulse_emitter {
    AL_IMPULSE_POINT = 0,
    AL_IMPULSE_DIRECTIONAL = 1,
    AL_IMPULSE_AREA = 2
} al_impulse_emitter;

typedef enum al_impulse_axis {
    AL_IMPULSE_AXIS_EMITTER = 0, /* about the direction to the emitter; area: m = 0, 1, 2 */
    AL_IMPULSE_AXIS_FITTED = 1   /* zonal about an axis that is stored: the paper's area emitter */
} al_impulse_axis;

typedef struct al_impulse_info {
    uint32_t band_count;  /* 3 to AL_IMPULSE_BAND_LIMIT */
    uint32_t event_count; /* scattering events tabulated one by one, 1 to AL_IMPULSE_EVENT_LIMIT */
    uint32_t table_count;
    double distance_min, distance_max; /* mean free paths, of every table */
    /* Achieved errors, the largest over all entries and bands, relative to the entry's band 0: */
    double rounding_error;      /* device in float32 against double precision */
    double interpolation_error; /* halfway between the tabulated distances */
} al_impulse_info;

/* One table: f32 values [angle][cosine][distance][number], each divided by its asymptote. */
typedef struct al_impulse_table {
    uint32_t emitter, axis;
    uint32_t first_event, last_event; /* equal, or a sum; 0 is the beam */
    uint32_t distance_count;          /* equal steps of the logarithm */
    uint32_t cosine_count;            /* area: odd, equal steps of sign(c) sqrt(|c|), c = cos_normal; else 1 */
    uint32_t angle_count;             /* 0: not resolved; else event 1 split by its angle of scattering */
    uint32_t number_count;
    float g;             /* Henyey-Greenstein of event 1; 0 where there is none or it is resolved */
    const float *angles; /* [angle_count] ln tan(s/2), rising or in rising runs; NULL when there are none */
    const float *values;
} al_impulse_table;

typedef struct al_impulse_tables al_impulse_tables;

/* Reads and validates an asset of kind impulse-tables. The file must stay open as long as the tables. */
al_status al_impulse_tables_read(const al_file *file, al_impulse_tables **tables, al_error *error);
void al_impulse_tables_free(al_impulse_tables *tables); /* NULL is allowed */
const al_impulse_info *al_impulse_tables_info(const al_impulse_tables *tables);
const al_impulse_table *al_impulse_tables_table(const al_impulse_tables *tables, uint32_t index);

typedef enum al_impulse_variant {
    AL_IMPULSE_BEST = 0,     /* area: m <= 2; phase functions without interpolation */
    AL_IMPULSE_PUBLISHED = 1 /* area: fitted axis; g interpolated between the tables, not beyond them; the beam out
                              * of the table with all in one, where there is one and it applies */
} al_impulse_variant;

typedef struct al_impulse_query {
    al_impulse_emitter emitter;
    al_impulse_variant variant;
    uint32_t first_event, last_event; /* 0 (the beam) to info.event_count, first <= last */
    double distance_m;                /* above 0 */
    double cos_normal;                /* area: emitter's normal . direction from emitter to receiver */
    double sigma_s_per_m, sigma_a_per_m; /* from 0; scattering of nothing is 0 */
    double g;                            /* Henyey-Greenstein, in (-1, 1) */
    /* Another phase function by its Legendre moments f(n) = 2 pi integral of p P(n), f(0) = 1; g is then f(1).
     * NULL: Henyey-Greenstein, f(n) = g^n. Best variant only. */
    const double *moments;
    uint32_t moment_count;
} al_impulse_query;

typedef struct al_impulse_answer {
    uint32_t band_count;
    uint32_t m_count; /* 1 for zonal answers, 3 for the area emitter's best */
    /* sh[m][l] times Y(l, m) as above; zonal answers: sh[0][l] is band l about the axis. W/(m2 sr). */
    double sh[AL_IMPULSE_M_COUNT][AL_IMPULSE_BAND_LIMIT];
    double axis_angle; /* radians from the direction to the emitter towards the side of its normal */
} al_impulse_answer;

/* The response of the events first to last, added up. From event 2 on scattering is isotropic by the
 * similarity rule, sigma_s' = (1 - g) sigma_s, sigma_t' = sigma_a + sigma_s'. With dq = sigma_t d a point's and
 * an area's k events scale by sigma_t^2 (sigma_s/sigma_t)^k, a directional light's by (sigma_s/sigma_t)^k.
 * Outside of the tabulated distances the asymptotes go on; what is below 1e-300 may be 0.
 * Several fitted axes in one answer become one, their mean weighted by band 0. */
void al_impulse_response(const al_impulse_tables *tables, const al_impulse_query *query,
                         al_impulse_answer *answer);

/* Irradiance of a surface that the answer arrives at, W/m2: the sum over bands of the clamped cosine's
 * coefficients. normal_z, normal_x: the surface's normal dot z and x of the frame above. */
double al_impulse_irradiance(const al_impulse_answer *answer, double normal_z, double normal_x);

/* Zonal coefficients of the answer about its flux, from the fluence and flux exactly: bands 0 to
 * band_count - 1 in `zh`; returns the axis' angle as in al_impulse_answer. */
double al_impulse_zonal(const al_impulse_answer *answer, double *zh);

/* --- one medium, many look-ups --- */

/* Tables collapsed for one albedo and phase function: a look-up is one interpolation for all events together, at
 * any density. Best variant; no beam. */
typedef struct al_impulse_medium al_impulse_medium;

typedef struct al_impulse_medium_settings {
    uint32_t first_event, last_event; /* 1 to info.event_count */
    double albedo;                    /* sigma_s/sigma_t, 0 to 1 */
    double g;                         /* as in al_impulse_query, moments too */
    const double *moments;
    uint32_t moment_count;
} al_impulse_medium_settings;

/* Independent of the tables and their file once it is made. */
al_status al_impulse_medium_make(const al_impulse_tables *tables, const al_impulse_medium_settings *settings,
                                 al_impulse_medium **medium, al_error *error);
void al_impulse_medium_free(al_impulse_medium *medium); /* NULL is allowed */

/* As al_impulse_response with sigma_s = albedo sigma_t. sigma_t_per_m from 0. */
void al_impulse_medium_response(const al_impulse_medium *medium, al_impulse_emitter emitter,
                                double distance_m, double cos_normal, double sigma_t_per_m,
                                al_impulse_answer *answer);
/* Irradiance of a surface, W/m2: al_impulse_irradiance of that response, quicker. */
double al_impulse_medium_irradiance(const al_impulse_medium *medium, al_impulse_emitter emitter,
                                    double distance_m, double cos_normal, double sigma_t_per_m,
                                    double normal_z, double normal_x);

/* --- event 1 along one ray of bounded length --- */

typedef struct al_impulse_ray {
    al_impulse_emitter emitter;
    double distance_m, cos_normal;           /* as in al_impulse_query */
    double direction_z, direction_x;         /* of the ray from the receiver, unit length, in its frame */
    double length_m;                         /* how far the ray sees; INFINITY: without end */
    double sigma_s_per_m, sigma_a_per_m, g;  /* Henyey-Greenstein */
} al_impulse_ray;

/* Radiance in W/(m2 sr) that one scattering event on the ray brings to the receiver. Directional: exact. Point:
 * within 1e-4 of it (|g| <= 0.99, any density); it grows like the inverse angle to the emitter, below 1e-6 the
 * angle counts as 1e-6. Area: within 1 %, where the ray crosses the emitter's plane; 1e-3 else. */
double al_impulse_airlight(const al_impulse_ray *ray);

/* --- for writers --- */

/* Numbers of an entry: bands; area: m = 0 from band 0, m = 1 from band 1, m = 2 from band 2, after each other;
 * fitted: the axis' angle, then bands. */
uint32_t al_impulse_number_count(uint32_t emitter, uint32_t axis, uint32_t band_count);
/* What values are divided by at `distance` mean free paths, exp(-distance) apart: docs/formats.md. */
double al_impulse_falloff(uint32_t emitter, uint32_t first_event, uint32_t last_event, double distance);

/* Cubic interpolation along one axis: the nodes from `first` on and their weights. */
typedef struct al_impulse_stencil {
    uint32_t first, count; /* count is 4, or 1 on an axis of one node */
    double weights[4];
} al_impulse_stencil;
/* At `distance` mean free paths among `count` distances; at `cosine` among `count` cosines. */
al_impulse_stencil al_impulse_distances(const al_impulse_info *info, uint32_t count, double distance);
al_impulse_stencil al_impulse_cosines(uint32_t count, double cosine);

typedef struct al_impulse_data {
    al_impulse_info info; /* table_count counts `tables` */
    const al_impulse_table *tables;
    const char *provenance_json;
    const al_measured *measured; /* chunks MEAS */
    uint32_t measured_count;
} al_impulse_data;

/* Writes the whole asset atomically. bytes may be NULL. */
al_status al_impulse_tables_write(const char *path, const al_impulse_data *data, uint64_t *bytes,
                                  al_error *error);

#ifdef __cplusplus
}
#endif
#endif
