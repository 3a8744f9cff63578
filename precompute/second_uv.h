/* Whether a mesh's second UV set can hold a lightmap. */
#ifndef AIRLIGHT_SECOND_UV_H
#define AIRLIGHT_SECOND_UV_H

#include "airlight/scene.h"

/* Numbers the parts of uv1 that hang together: [index_count / 3]. Their count in *count. */
al_status al_uv_parts(const al_mesh *mesh, uint32_t *parts, uint32_t *count, al_error *error);

/* uv1 stretched over width x height texels must lie in [0, 1], give every triangle that has an area one,
 * cover no texel's centre twice, and keep parts a texel apart, so that none reads what is another's between
 * texel centres. AL_BAD_INPUT says which of it is not so, and where. */
al_status al_uv_check(const al_mesh *mesh, uint32_t width, uint32_t height, al_error *error);

#endif
