/* One page of a lightmap in the making: light, texel by texel, and what makes it whole: texels behind
 * surfaces, padding, seams. */
#ifndef AIRLIGHT_LIGHT_PAGE_H
#define AIRLIGHT_LIGHT_PAGE_H

#include "airlight/lightmap.h"
#include "atlas.h"

typedef struct al_light_page {
    uint32_t width, height, channel_count;
    float *light;    /* [height][width][channel_count] */
    uint8_t *state;  /* [height][width] al_texel_state */
    uint32_t *chart; /* [height][width], where the state is not AL_TEXEL_EMPTY */
} al_light_page;

al_status al_light_page_make(uint32_t width, uint32_t height, uint32_t channel_count, al_light_page *page,
                             al_error *error);
void al_light_page_free(al_light_page *page);

/* Texels of state AL_TEXEL_REPLACED take the mean of the texels around them that have light, of the same
 * chart, from its rim inwards. A chart that is all behind surfaces keeps what was baked, and the state says
 * so. Answers how many were replaced. */
al_status al_light_page_replace(al_light_page *page, uint32_t *replaced, al_error *error);

/* Empty texels beside others take the mean of those around them, `rings` times. */
al_status al_light_page_dilate(al_light_page *page, uint32_t rings, al_error *error);

typedef struct al_seams {
    uint32_t places; /* along edges where two charts meet with the same normals */
    double jump_before,
        jump_after; /* root mean square of the difference across, over that of the light there */
} al_seams;

/* Changes texels along charts' borders so that both sides read the same, as nearly as they can, of the first
 * `positive` channels none below 0: least squares over places half a texel apart against staying as they are.
 * The instances that lie on page `index`. */
al_status al_light_page_stitch(const al_scene *scene, const al_atlas *atlas, uint32_t index,
                               uint32_t positive, al_light_page *page, al_seams *seams, al_error *error);

#endif
