#include "half.h"

#include <string.h>

/* binary32: 8 exponent bits (bias 127), 23 of fraction. binary16: 5 (bias 15) and 10. */

uint16_t al_half_from_float(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    uint16_t sign = (uint16_t)(bits >> 16 & 0x8000);
    uint32_t magnitude = bits & 0x7fffffff;
    if (magnitude > 0x7f800000) return sign | 0x7e00;  /* NaN */
    if (magnitude >= 0x477ff000) return sign | 0x7c00; /* from 65520 on, half way above 65504 */
    if (magnitude < 0x33000000) return sign;           /* below 2^-25, half the smallest subnormal; */
                                                       /* 2^-25 itself is a tie and goes to zero below */
    uint32_t exponent = magnitude >> 23, shift, kept;
    if (exponent >= 113) { /* normal: from 2^-14 on; rounding up may carry into the exponent, as it should */
        shift = 13;
        kept = magnitude - (112u << 23);
    } else { /* subnormal: the value is kept * 2^-24 once shifted */
        shift = 126 - exponent;
        kept = (magnitude & 0x7fffff) | 0x800000;
    }
    uint32_t rest = kept & ((1u << shift) - 1), half_way = 1u << (shift - 1);
    uint32_t result = kept >> shift;
    if (rest > half_way || (rest == half_way && (result & 1))) result++;
    return (uint16_t)(sign | result);
}

float al_half_to_float(uint16_t half)
{
    uint32_t sign = (uint32_t)(half & 0x8000) << 16, exponent = half >> 10 & 31, fraction = half & 0x3ff,
             bits;
    if (exponent == 31) {
        bits = 0x7f800000 | fraction << 13;
    } else if (exponent) {
        bits = (exponent + 112) << 23 | fraction << 13;
    } else { /* zero or subnormal: fraction * 2^-24, exact in binary32 */
        float value = (float)fraction * 0x1p-24f;
        memcpy(&bits, &value, sizeof bits);
    }
    bits |= sign;
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}
