/* What the parts of a gather share. */
#ifndef AIRLIGHT_GATHER_STATE_H
#define AIRLIGHT_GATHER_STATE_H

#include "gather.h"
#include "gather_fog.h"
#include "gather_light.h"

typedef struct al_fog_points al_fog_points;       /* fog_points.h */
typedef struct al_gather_kernel al_gather_kernel; /* gather_kernel.h */

struct al_gather {
    al_gather_options options;
    const char *path; /* of the scene, for messages */
    al_ray_scene *rays;
    al_gather_lights lights;
    al_fog_media fog; /* empty without fog */
    const al_impulse_tables *tables;
    al_fog_points *points;        /* bounded and traced walls, where fog scatters */
    al_gather_kernel *kernels[3]; /* published walls, by channel; NULL: the tables themselves are asked */
    bool responds;                /* published walls and fog that scatters */
};

struct al_gather_scratch {
    al_fog_path fog;
    struct al_fog_records *record; /* not NULL while fog points are made */
};

/* A point that light arrives at. */
typedef struct al_gather_vertex {
    double position[3], normal[3];
    double offset_m; /* rays begin so far along the normal */
    bool in_air;     /* there is no normal; light from everywhere counts */
    bool asks;       /* published walls: responses of the fog count */
    bool scatters;   /* other walls: light that the fog scatters into its ways counts */
    bool looks_back; /* directions behind it are drawn too, for back-scatter */
    bool glows;      /* fog scatters a point lamp's light to it: directions about `lamp` are drawn too */
    double lamp[3];  /* unit, towards that lamp */
} al_gather_vertex;

/* By layer and channel, but the third is everything: attenuated + scattered. */
enum { AL_GATHER_TOTAL = AL_GATHER_SCATTERED };
typedef double al_gather_layers[AL_GATHER_LAYER_COUNT][3];

#endif
