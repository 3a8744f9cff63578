/* The bake of a scene's lightmap: light at every texel of the atlas, texels behind surfaces replaced,
 * padding, seams, and the files: NAME.lightmap.air and, from it, lightmap_PAGE.exr. */
#ifndef AIRLIGHT_BAKE_LIGHTMAP_H
#define AIRLIGHT_BAKE_LIGHTMAP_H

#include "airlight/impulse_tables.h"
#include "airlight/lightmap.h"
#include "atlas.h"
#include "bake_step.h"

/* Name of the asset's file in the folder, from the scene file's name. */
void al_bake_lightmap_file(const al_import *import, char *name, size_t size);

/* Content hash of everything the lightmap depends on: surfaces, materials, lights, environment, media,
 * settings, and the key of the tables (0 without). Call it before the atlas is made. */
al_status al_bake_lightmap_key(const al_import *import, uint64_t tables_key, uint64_t *key, al_error *error);

/* Bakes the lightmap of an atlas that has been made into the folder. Finished tiles of texels are kept beside
 * the asset as NAME.partial, so that after a stop, however sudden, the next call with the same key goes on
 * from there, to the same bytes. Any number of threads gives the same bytes. tables may be NULL where the
 * gathering needs none. */
al_status al_bake_lightmap(const al_import *import, const al_atlas *atlas, uint64_t key,
                           const al_impulse_tables *tables, const al_bake_options *options, al_steps *steps,
                           al_error *error);

/* Name of the picture of a page in the folder. */
void al_bake_lightmap_page_file(uint32_t page, char *name, size_t size);
/* Writes page `index` of a baked lightmap as OpenEXR: irradiance in W/m2 as the asset says it, three layers
 * of float32, "surface.R" to "scattered.B", the first row on top. The same asset gives the same bytes.
 * Atomic. */
al_status al_bake_lightmap_page(const al_file *file, const al_lightmap_info *info, uint32_t index,
                                const char *path, al_error *error);

#endif
