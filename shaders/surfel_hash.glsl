#ifndef AL_SURFEL_HASH_GLSL
#define AL_SURFEL_HASH_GLSL

// Three random words from three: a linear congruential step of each, then twice a round in which each word
// takes in the product of the two others, as "pcg3d" does (Jarzynski and Olano 2020, Hash Functions for GPU
// Rendering).
uvec3 hash(uvec3 v)
{
    v = v * 1664525u + 1013904223u;
    for (int round = 0; round < 2; round++) {
        v.x += v.y * v.z;
        v.y += v.z * v.x;
        v.z += v.x * v.y;
        if (round == 0) v ^= v >> 16u;
    }
    return v;
}

#endif
