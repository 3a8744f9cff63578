/* From radiance to what a PNG file or a window shows, before the sRGB curve. In the common subset of C and
 * GLSL: present.frag is compiled with this text in front of it.
 *
 * Exposed values up to the knee stay as they are, so that mid-tones read true. Above it an exponential
 * shoulder y = k + (1 - k) (1 - exp(-(x - k) / (1 - k))) leaves the straight line with slope one and tends to
 * 1: nothing clips, and bright colours turn paler. */
#ifndef AIRLIGHT_TONE_MAP_H
#define AIRLIGHT_TONE_MAP_H

#ifdef AL_GLSL
#define AL_TONE_FUNCTION
#define AL_TONE_EXP exp
#else
#include <math.h>
#define AL_TONE_FUNCTION static inline
#define AL_TONE_EXP expf
#endif

AL_TONE_FUNCTION float al_tone_map(float exposed)
{
    const float knee = 0.6f;
    if (exposed <= knee) return exposed;
    return knee + (1.0f - knee) * (1.0f - AL_TONE_EXP((knee - exposed) / (1.0f - knee)));
}

#endif
