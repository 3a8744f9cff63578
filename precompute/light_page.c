#include "light_page.h"

#include <stdlib.h>
#include <string.h>

al_status al_light_page_make(uint32_t width, uint32_t height, uint32_t channel_count, al_light_page *page,
                             al_error *error)
{
    size_t texels = (size_t)width * height;
    *page = (al_light_page){.width = width,
                            .height = height,
                            .channel_count = channel_count,
                            .light = calloc(texels * channel_count + 1, sizeof(float)),
                            .state = calloc(texels + 1, 1),
                            .chart = calloc(texels + 1, sizeof(uint32_t))};
    if (page->light && page->state && page->chart) return AL_OK;
    al_light_page_free(page);
    return al_fail(error, AL_IO, "out of memory for a page of %u x %u texels", width, height);
}

void al_light_page_free(al_light_page *page)
{
    free(page->light);
    free(page->state);
    free(page->chart);
    *page = (al_light_page){0};
}

/* The mean of the eight texels around that have light: those of `chart`, or of the chart with the lowest
 * number when it is NULL. False when there is none. */
static bool mean_around(const al_light_page *page, const uint8_t *has_light, size_t cell,
                        const uint32_t *chart, float *mean, uint32_t *from)
{
    int x = (int)(cell % page->width), y = (int)(cell / page->width), count = 0;
    *from = chart ? *chart : UINT32_MAX;
    for (int pass = chart ? 1 : 0; pass < 2; pass++)
        for (int i = 0; i < 9; i++) {
            int column = x + i % 3 - 1, row = y + i / 3 - 1;
            if (i == 4 || column < 0 || row < 0 || column >= (int)page->width || row >= (int)page->height)
                continue;
            size_t other = (size_t)row * page->width + (size_t)column;
            if (!has_light[other]) continue;
            if (pass == 0 && page->chart[other] < *from) *from = page->chart[other];
            if (pass == 0 || page->chart[other] != *from) continue;
            const float *light = page->light + other * page->channel_count;
            for (uint32_t c = 0; c < page->channel_count; c++) mean[c] = (count ? mean[c] : 0) + light[c];
            count++;
        }
    for (uint32_t c = 0; count && c < page->channel_count; c++) mean[c] /= (float)count;
    return count > 0;
}

/* Gives light to the pending cells that have some around them; the others stay pending. What a round gives is
 * not looked at before the next. */
static uint32_t run_round(al_light_page *page, uint8_t *has_light, uint32_t *pending, uint32_t count,
                          bool same_chart, uint32_t *reached)
{
    uint32_t left = 0, found = 0;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t cell = pending[i], from;
        float *light = page->light + (size_t)cell * page->channel_count;
        if (!mean_around(page, has_light, cell, same_chart ? &page->chart[cell] : NULL, light, &from)) {
            pending[left++] = cell;
            continue;
        }
        page->chart[cell] = from;
        reached[found++] = cell;
    }
    for (uint32_t i = 0; i < found; i++) has_light[reached[i]] = 1;
    return left;
}

/* Up to `rounds` rounds over the cells of one state. light_at[cell] tells which texels have light in the end.
 */
static al_status spread(al_light_page *page, al_texel_state state, bool same_chart, uint32_t rounds,
                        uint32_t *reached_count, uint8_t **light_at, al_error *error)
{
    size_t texels = (size_t)page->width * page->height;
    uint32_t count = 0;
    for (size_t i = 0; i < texels; i++) count += page->state[i] == state;
    uint8_t *has_light = malloc(texels + 1);
    uint32_t *pending = malloc((count + (size_t)1) * sizeof *pending);
    uint32_t *reached = malloc((count + (size_t)1) * sizeof *reached);
    al_status status = AL_OK;
    *reached_count = 0;
    if (!has_light || !pending || !reached) {
        status = al_fail(error, AL_IO, "out of memory for %u texels", count);
        free(has_light);
        has_light = NULL;
        goto cleanup;
    }
    uint32_t left = 0;
    for (size_t i = 0; i < texels; i++) {
        has_light[i] = page->state[i] != state && page->state[i] != AL_TEXEL_EMPTY;
        if (page->state[i] == state) pending[left++] = (uint32_t)i;
    }
    for (uint32_t round = 0, before = left + 1; round < rounds && left < before && left; round++) {
        before = left;
        left = run_round(page, has_light, pending, left, same_chart, reached);
    }
    *reached_count = count - left;
cleanup:
    free(pending);
    free(reached);
    *light_at = has_light;
    return status;
}

al_status al_light_page_replace(al_light_page *page, uint32_t *replaced, al_error *error)
{
    uint8_t *has_light;
    al_status status = spread(page, AL_TEXEL_REPLACED, true, UINT32_MAX, replaced, &has_light, error);
    for (size_t i = 0; status == AL_OK && i < (size_t)page->width * page->height; i++)
        if (page->state[i] == AL_TEXEL_REPLACED && !has_light[i]) page->state[i] = AL_TEXEL_BAKED;
    free(has_light);
    return status;
}

al_status al_light_page_dilate(al_light_page *page, uint32_t rings, al_error *error)
{
    uint8_t *has_light;
    uint32_t reached;
    al_status status = spread(page, AL_TEXEL_EMPTY, false, rings, &reached, &has_light, error);
    for (size_t i = 0; status == AL_OK && i < (size_t)page->width * page->height; i++)
        if (page->state[i] == AL_TEXEL_EMPTY && has_light[i]) page->state[i] = AL_TEXEL_DILATED;
    free(has_light);
    return status;
}
