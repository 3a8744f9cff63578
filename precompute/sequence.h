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

/* Owen's scrambling of the bits of a fraction, given and answered with its first digit as the lowest bit:
 * each is flipped by a hash of the bits below it. Laine and Karras 2011, with Burley's constants. */
static inline uint32_t al_scramble_reversed(uint32_t x, uint32_t seed)
{
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return x;
}

/* The next two numbers, in [0, 1). The first dimension is van der Corput's, the second Sobol's. Its direction
 * numbers v(k+1) = v(k) xor (v(k) >> 1) are the rows of Pascal's triangle mod 2, where C(k, j) is odd when j
 * holds no bit that k lacks: digit j is the sum of all digits k of the index that hold j's bits. */
static inline void al_sequence_pair(al_sequence *sequence, double u[2])
{
    uint64_t key = al_mix_bits(sequence->seed + 0x9e3779b97f4a7c15u * ++sequence->dimension);
    uint64_t more = al_mix_bits(key + 0x9e3779b97f4a7c15u);
    uint32_t first = al_reverse_bits(al_scramble_reversed(al_reverse_bits(sequence->index), (uint32_t)key));
    uint32_t second = first;
    second ^= second >> 16;
    second ^= (second >> 8) & 0x00ff00ffu;
    second ^= (second >> 4) & 0x0f0f0f0fu;
    second ^= (second >> 2) & 0x33333333u;
    second ^= (second >> 1) & 0x55555555u;
    u[0] = al_reverse_bits(al_scramble_reversed(first, (uint32_t)more)) * 0x1p-32;
    u[1] = al_reverse_bits(al_scramble_reversed(second, (uint32_t)(more >> 32))) * 0x1p-32;
}

#endif
