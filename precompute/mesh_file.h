/* Mesh files through assimp: geometry, materials, lights and cameras of one "meshes" entry into the scene. */
#ifndef AIRLIGHT_MESH_FILE_H
#define AIRLIGHT_MESH_FILE_H

#include "import.h"

typedef struct al_mesh_use {
    al_role role;
    uint32_t translucent; /* AL_NO_INDEX for AL_ROLE_OPAQUE */
    const double *object; /* boundary and blockers: the rigid object-to-world matrix they share, else NULL */
    const al_motion_description *motion; /* of the whole */
    double pivot_m[3];                   /* about which that turns and scales: where the mesh is placed */
    const char *name;     /* "FILE:LINE: mesh "NAME" (FILE)", for messages */
} al_mesh_use;

/* Adds everything `mesh` describes; sigma_a of media that name a material of this file. */
al_status al_mesh_file_import(al_import *import, const al_mesh_description *mesh, const al_mesh_use *use,
                              al_error *error);

#endif
