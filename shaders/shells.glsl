// Shell splatting of surfels onto the intervals of the view (Nalbach et al. 2014): what its passes share.
// Mirrored by al_shell_block in runtime/state.h (std140).
//
// The levels are pictures of one size. Level l is cut into 2^l x 2^l sub-buffers; every block of as many pixels of
// the view hands each sub-buffer one of its pixels, at the block's place. Which one follows from a hash, by a
// bijection of [0, 4^l) that both sides can compute, so that no table is stored.
#ifndef AL_SHELLS_GLSL
#define AL_SHELLS_GLSL

#include "frame.glsl"
#include "hash.glsl"

layout(std140, binding = 3) uniform Shells {
    ivec3 shell_counts; // levels; samples on a ray; seed of the frame
    ivec4 shell_size;   // xy: size of a level; zw: of the tile
    vec4 shell_reach;   // x: epsilon in W/(m2 sr); y: radius of the innermost shell in m, 0: by epsilon;
                        // z: the phase functions' maximum in 1/sr; w: 1 when the outermost shell is open
    vec4 shell_medium;  // rgb: albedo where one holds for all media; w: Henyey-Greenstein g, likewise
    ivec4 shell_blur;   // x: mips above a level's own, -1 for no blur; y: 1 blurs light apart from the depletion;
                        // z: 1 clamps squared distances as published; w: 1 draws nothing at random on the rays: xi and jitter are 0
};

// Pixels of a block of level l are multiplied and folded modulo 4^l; both steps can be undone. `block`: of the tile; tiles
// that overlap deal alike.
uint deal_seed(ivec2 block, int level)
{
    block += tile.xy >> level;
    return hash(uint(block.x), uint(block.y), uint(level) ^ uint(shell_counts.z) << 4);
}

uint odd_inverse(uint a) // modulo 2^24: each step doubles the correct bits, three at first
{
    uint x = a;
    for (int i = 0; i < 3; i++) x *= 2u - a * x;
    return x;
}

const uint deal_factor = 0x9e3779b1u;

uint deal(uint pixel, int level, uint seed)
{
    uint mask = (1u << uint(2 * level)) - 1u;
    uint x = ((pixel + seed) * (seed >> 8 | 1u)) & mask;
    x ^= x >> uint(level);
    return (x * deal_factor + (seed >> 16)) & mask;
}

uint undeal(uint part, int level, uint seed)
{
    uint mask = (1u << uint(2 * level)) - 1u;
    uint x = ((part - (seed >> 16)) * odd_inverse(deal_factor)) & mask;
    x ^= x >> uint(level);
    return (x * odd_inverse(seed >> 8 | 1u) - seed) & mask;
}

ivec2 part_corner(uint part, int level)
{
    uvec2 place = uvec2(part & ((1u << uint(level)) - 1u), part >> uint(level));
    return ivec2(place) * (shell_size.xy >> level);
}

// The pixel of the tile that a texel of level l stands for, and back.
ivec2 pixel_of_texel(ivec2 texel, int level)
{
    ivec2 size = shell_size.xy >> level, part = texel / size, block = texel - part * size;
    uint pixel = undeal(uint(part.y << level | part.x), level, deal_seed(block, level));
    return (block << level) + ivec2(pixel & ((1u << uint(level)) - 1u), pixel >> uint(level));
}

ivec2 texel_of_pixel(ivec2 pixel, int level)
{
    ivec2 block = pixel >> level, inside = pixel - (block << level);
    uint part = deal(uint(inside.y << level | inside.x), level, deal_seed(block, level));
    return part_corner(part, level) + block;
}

#endif
