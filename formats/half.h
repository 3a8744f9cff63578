/* IEEE 754 binary16 and back. */
#ifndef AIRLIGHT_HALF_H
#define AIRLIGHT_HALF_H

#include <stdint.h>

/* Round to nearest, ties to even; beyond 65504 infinity; NaN stays NaN. For finite results the error is at
 * most 2^-11 |value|, below 2^-14 at most 2^-25. */
uint16_t al_half_from_float(float value);
float al_half_to_float(uint16_t half); /* exact */

#endif
