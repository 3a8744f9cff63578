/* Numbers of which tests draw what they try. */
#ifndef AIRLIGHT_TEST_RANDOM_H
#define AIRLIGHT_TEST_RANDOM_H

#include <stdint.h>

/* The next 64 bits; Steele, Lea and Flood 2014. */
static inline uint64_t random_bits(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

/* Where the numbers of case `index` of `seed` begin. */
static inline uint64_t random_begin(uint64_t seed, uint32_t index)
{
    uint64_t state = seed;
    state = random_bits(&state) + index;
    return random_bits(&state);
}

#endif
