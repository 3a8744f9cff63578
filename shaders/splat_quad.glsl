// Where a surfel's splat lies in a level: part of one sub-buffer.
#ifndef AL_SPLAT_QUAD_GLSL
#define AL_SPLAT_QUAD_GLSL

#include "ball.glsl"
#include "shells.glsl"

layout(binding = 5) uniform sampler2D interval_span; // of the places on the pixels' rays: nearest and farthest, mips

// Level l takes the distances reach 2^(l-1) to reach 2^l; the innermost begins at 0, the outermost may be open.
vec2 shell_radii(float reach, int level)
{
    vec2 radii = vec2(level == 0 ? 0.0 : reach * exp2(float(level - 1)), reach * exp2(float(level)));
    if (level + 1 == shell_counts.x && shell_reach.w > 0.0) radii.y = 1e15;
    return radii;
}

// Whether the rays of these pixels have places inside the ball; the mip at which they are at most two texels wide.
bool meets(ivec2 low, ivec2 high, vec3 center, float radius)
{
    ivec2 size = high - low;
    int mip = min(findMSB(max(max(size.x, size.y), 1)) + 1, textureQueryLevels(interval_span) - 1);
    if (max(size.x, size.y) == 0) mip = 0;
    float nearest = 1e30, farthest = 0.0;
    ivec2 last = textureSize(interval_span, mip) - 1; // holds what is left over of an odd number, too
    for (int y = low.y >> mip; y <= high.y >> mip; y++)
        for (int x = low.x >> mip; x <= high.x >> mip; x++) {
            vec2 span = texelFetch(interval_span, min(ivec2(x, y), last), mip).xy;
            nearest = min(nearest, span.x);
            farthest = max(farthest, span.y);
        }
    vec3 from_eye = center - ray_origin.xyz; // orthographic: the ray's start, a plane across the view
    float away = eye.w > 0.0 ? length(from_eye) : -dot(from_eye, eye.xyz);
    return away - radius <= farthest && away + radius >= nearest;
}

// The quad over the pixels whose rays can reach the ball, in a sub-buffer of the level that is drawn by the surfel's
// number: normalised device coordinates. False: there are none.
bool splat_bounds(vec3 center, float radius, int level, int surfel, out vec4 bounds)
{
    vec2 x, y, size = vec2(tile.zw);
    ball_bounds(transpose(view_projection), center, radius, x, y);
    x = clamp(x, -2.0, 2.0); // far beyond the view, whole numbers of pixels would be too large for an int
    y = clamp(y, -2.0, 2.0);
    ivec2 low = ivec2(floor((vec2(x.x, y.x) * 0.5 + 0.5) * size)) - tile.xy;
    ivec2 high = ivec2(floor((vec2(x.y, y.y) * 0.5 + 0.5) * size)) - tile.xy;
    low = max(low, ivec2(0));
    high = min(high, shell_size.zw - 1);
    if (any(greaterThan(low, high)) || !meets(low, high, center, radius)) return false;
    uint part = hash(uint(surfel), uint(level), uint(shell_counts.z)) & ((1u << uint(2 * level)) - 1u);
    ivec2 corner = part_corner(part, level);
    bounds = vec4(corner + (low >> level), corner + (high >> level) + 1) / vec4(shell_size.xyxy) * 2.0 - 1.0;
    return true;
}

#endif
