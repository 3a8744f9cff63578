// Random bits from counters: the 32-bit mixer of Wellons's "lowbias32" search.
#ifndef AL_HASH_GLSL
#define AL_HASH_GLSL

uint mix_bits(uint h)
{
    h = (h ^ (h >> 16)) * 0x7feb352du;
    h = (h ^ (h >> 15)) * 0x846ca68bu;
    return h ^ (h >> 16);
}

uint hash(uint a, uint b, uint c)
{
    return mix_bits(mix_bits(mix_bits(a) ^ b * 0x9e3779b9u) ^ c * 0x85ebca6bu);
}

float unit_float(uint bits) // in [0, 1)
{
    return float(bits >> 8) / 16777216.0;
}

#endif
