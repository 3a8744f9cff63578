/* Random numbers that depend on pixel and batch alone, so that no thread changes a picture. */
#ifndef AIRLIGHT_SAMPLING_H
#define AIRLIGHT_SAMPLING_H

#include <math.h>
#include <stdint.h>

typedef struct al_random {
    uint64_t state;
} al_random;

/* SplitMix64: Steele, Lea and Flood 2014, "Fast Splittable Pseudorandom Number Generators". */
static inline uint64_t al_random_bits(al_random *random)
{
    uint64_t z = random->state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

/* An independent stream for every pair; the first output of a stream seeds the next key. */
static inline al_random al_random_for(uint64_t pixel, uint64_t batch)
{
    al_random random = {pixel};
    random.state = al_random_bits(&random) + batch;
    random.state = al_random_bits(&random);
    return random;
}

/* In [0, 1). */
static inline double al_random_real(al_random *random)
{
    return (double)(al_random_bits(random) >> 11) * 0x1p-53;
}

/* Latin hypercube (McKay, Beckman and Conover 1979): in each dimension every one of `count` equal strata
 * holds one of the samples, in random order. `points` has room for count * dimensions values in [0, 1),
 * sample by sample. */
static inline void al_sample_hypercube(al_random *random, uint32_t count, uint32_t dimensions, double *points)
{
    const double below_one = 0x1.fffffffffffffp-1;
    for (uint32_t d = 0; d < dimensions; d++) {
        for (uint32_t i = 0; i < count; i++) points[(uint64_t)i * dimensions + d] = i;
        for (uint32_t i = count; i > 1; i--) {
            uint64_t k = (uint64_t)(al_random_real(random) * i) * dimensions + d;
            uint64_t last = (uint64_t)(i - 1) * dimensions + d;
            double swapped = points[k];
            points[k] = points[last];
            points[last] = swapped;
        }
        for (uint32_t i = 0; i < count; i++) {
            double *point = &points[(uint64_t)i * dimensions + d];
            double value = (*point + al_random_real(random)) / count;
            *point = value < below_one ? value : below_one;
        }
    }
}

/* Point `index` of Weyl's sequence (multiples of square roots of primes, modulo 1), which fills space evenly,
 * from a random start: each point is as uniform as that is. At most 16 dimensions. */
static inline void al_sample_turned(const double *start, uint32_t dimensions, uint32_t index, double *point)
{
    static const double primes[] = {2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53};
    for (uint32_t d = 0; d < dimensions; d++) {
        double turned = start[d] + index * sqrt(primes[d]);
        point[d] = fmin(turned - floor(turned), 0x1.fffffffffffffp-1);
    }
}

#endif
