/* binary16: every value there is, and the rounding of floats between them. */
#include "half.h"

#include <stdbool.h>

#include "../test.h"

/* What IEEE 754 says of the bits, in double. */
static double meaning(uint16_t half)
{
    int exponent = half >> 10 & 31, fraction = half & 0x3ff;
    double magnitude = exponent == 0 ? ldexp(fraction, -24) : ldexp(1024 + fraction, exponent - 25);
    return half & 0x8000 ? -magnitude : magnitude;
}

static void test_every_half(void)
{
    uint32_t wrong = 0;
    for (uint32_t i = 0; i < 65536; i++) {
        uint16_t half = (uint16_t)i;
        float value = al_half_to_float(half);
        if ((half & 0x7c00) == 0x7c00) {
            bool nan = (half & 0x3ff) != 0;
            wrong += nan ? !isnan(value) || !isnan(al_half_to_float(al_half_from_float(value)))
                         : !isinf(value) || al_half_from_float(value) != half;
        } else {
            wrong += value != meaning(half) || (signbit(value) != 0) != (half >> 15) ||
                     al_half_from_float(value) != half;
        }
    }
    CHECK(wrong == 0);
}

/* Between each pair of neighbours: the middle goes to the even one, a float less or more to the nearer one.
 */
static void test_rounding(void)
{
    uint32_t wrong = 0;
    for (uint16_t half = 0; half < 0x7bff; half++) {
        float middle = (float)(0.5 * (meaning(half) + meaning((uint16_t)(half + 1)))); /* exact: 12 bits */
        uint16_t even = half % 2 ? (uint16_t)(half + 1) : half;
        wrong += al_half_from_float(middle) != even;
        wrong += al_half_from_float(nextafterf(middle, 0)) != half;
        wrong += al_half_from_float(nextafterf(middle, 1e9f)) != half + 1;
        wrong += al_half_from_float(-middle) != (even | 0x8000);
    }
    CHECK(wrong == 0);
    CHECK(al_half_from_float(65519.99f) == 0x7bff);
    CHECK(al_half_from_float(65520) == 0x7c00);
    CHECK(al_half_from_float(1e30f) == 0x7c00);
    CHECK(al_half_from_float(1e-30f) == 0);
    CHECK(al_half_from_float(-1e-30f) == 0x8000);
    CHECK(al_half_from_float(0x1p-149f) == 0);
}

int main(void)
{
    test_every_half();
    test_rounding();
    return test_end();
}
