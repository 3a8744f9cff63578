/* A glTF file's JSON and the numbers its accessors name, for what assimp does not hand on as it is in the file:
 * motion, skins and morph targets. glTF 2.0, sections 3.6 and 4.4. */
#ifndef AIRLIGHT_GLTF_FILE_H
#define AIRLIGHT_GLTF_FILE_H

#include <jansson.h>

#include "import.h"

typedef struct al_gltf al_gltf;

/* `bytes` hold the whole .gltf or .glb `path` and are copied where needed; `name` begins messages. Buffers are
 * read when first needed and noted in `import`. */
al_status al_gltf_open(al_import *import, const char *name, const char *path, const uint8_t *bytes, size_t size,
                       al_gltf **file, al_error *error);
void al_gltf_close(al_gltf *file); /* NULL is allowed */

const json_t *al_gltf_root(const al_gltf *file);
/* Element `index` of a list of the root; NULL: there is none. */
const json_t *al_gltf_element(const al_gltf *file, const char *list, uint32_t index);
/* A whole number from 0, or AL_NO_INDEX when the key is absent or something else. */
uint32_t al_gltf_index(const json_t *object, const char *key);

/* The file without animations, skins and morph targets, for assimp, which trusts the joints that vertices name and
 * reads the rest for nothing. NULL, and no failure: it has none. Else free() the bytes; 16 of zero follow. */
al_status al_gltf_without_motion(const al_gltf *file, uint8_t **bytes, size_t *size, al_error *error);

/* Accessor `accessor` as numbers [count][width], normalised integers as fractions; sparse ones are filled in.
 * Refused unless its elements have `width` numbers (0: any), all finite; `what` says for whom. free() them. */
al_status al_gltf_numbers(al_gltf *file, uint32_t accessor, uint32_t width, const char *what, float **values,
                          uint32_t *count, al_error *error);

#endif
