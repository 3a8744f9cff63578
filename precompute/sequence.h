/* Evenly spread random numbers for the paths of a point: Sobol's points in pairs of dimensions, each pair
 * shuffled and scrambled (Owen 1995) by hashes of its own (Burley 2020, "Practical Hash-based Owen
 * Scrambling"). Any number of dimensions; every pair is spread over the unit square by any count of points,
 * best by powers of two. */
#ifndef AIRLIGHT_SEQUENCE_H
#define AIRLIGHT_SEQUENCE_H

#include <stdint.h>

typedef struct al_sequence {
    uint32_t index;     /* of the path */
    uint64_t seed;      /* of the point */
    uint32_t dimension; /* pairs taken so far */
} al_sequence;

static inline uint32_t al_reverse_bits(uint32_t x)
{
    x = (x >> 16) | (x << 16);
    x = ((x & 0x00ff00ffu) << 8) | ((x & 0xff00ff00u) >> 8);
    x = ((x & 0x0f0f0f0fu) << 4) | ((x & 0xf0f0f0f0u) >> 4);
    x = ((x & 0x33333333u) << 2) | ((x & 0xccccccccu) >> 2);
    return ((x & 0x55555555u) << 1) | ((x & 0xaaaaaaaau) >> 1);
}

/* SplitMix64's finaliser: Steele, Lea and Flood 2014, "Fast Splittable Pseudorandom Number Generators". */
static inline uint64_t al_mix_bits(uint64_t z)
{
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

/* Owen's scrambling of the bits of a fraction: each is flipped by a hash of the bits above it. On reversed
 * bits every step lets lower bits act on higher ones only: Laine and Karras 2011, with Burley's constants. */
static inline uint32_t al_scramble(uint32_t x, uint32_t seed)
{
    x = al_reverse_bits(x);
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return al_reverse_bits(x);
}

/* The next two numbers, in [0, 1). The first dimension is van der Corput's, the second Sobol's, whose
 * direction numbers are v(k+1) = v(k) xor (v(k) >> 1). */
static inline void al_sequence_pair(al_sequence *sequence, double u[2])
{
    uint64_t key = al_mix_bits(sequence->seed + 0x9e3779b97f4a7c15u * ++sequence->dimension);
    uint64_t more = al_mix_bits(key + 0x9e3779b97f4a7c15u);
    uint32_t index = al_scramble(sequence->index, (uint32_t)key);
    uint32_t second = 0, direction = 1u << 31;
    for (uint32_t i = index; i; i >>= 1, direction ^= direction >> 1)
        if (i & 1) second ^= direction;
    u[0] = al_scramble(al_reverse_bits(index), (uint32_t)more) * 0x1p-32;
    u[1] = al_scramble(second, (uint32_t)(more >> 32)) * 0x1p-32;
}

#endif
