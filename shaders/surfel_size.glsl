// How large surfels should be, and how finely a triangle must be cut for it.
//
// A surfel should cover the same area of the picture wherever it is, whichever way it faces and whether it is in
// view: a disc whose radius is so many pixels, at the surfel's distance to the eye,
//   A*(x) = A1 max(|x - eye|, d0)^2 (perspective), A1 (orthographic).
// It is the distance, not the depth, so that turning the camera changes nothing. d0, the distance of the near plane,
// keeps a camera on a wall from asking for endlessly many; what is nearer is never seen.
//
// The counts of what the tessellator makes of a triangle whose levels are all n: in concentric triangles, of
// n, n - 2, ... segments a side, down to a point or a triangle of one segment. So points: 1 + 3 (2 + 4 + ... + n)
// or 3 (1 + 3 + ... + n), which is 3/4 (n + 1)^2, and 1/4 more where n is even; and about 3/2 n^2 triangles.
#ifndef AL_SURFEL_SIZE_GLSL
#define AL_SURFEL_SIZE_GLSL

#include "frame.glsl"

layout(location = 6) uniform vec2 surfel_size; // A1 in m2 per m2, or m2; d0 in m

// OpenGL allows 64, but Mesa 22.3 without a GPU counts the points of a run of up to 1365 triangles in 16 bits: 48 each.
const float most_level = 7.0;

float wanted_area(float distance)
{
    float held = max(distance, surfel_size.y);
    return eye.w > 0.0 ? surfel_size.x * held * held : surfel_size.x;
}

float fine_count(float level)
{
    return floor((3.0 * (level + 1.0) * (level + 1.0) + 1.0) / 4.0);
}

// The least level that makes at least `count` points, as far as there is one.
float fine_level(float count)
{
    return clamp(ceil(sqrt(count * 4.0 / 3.0) - 1.0), 1.0, most_level);
}

float distance_to_segment(vec3 p, vec3 a, vec3 b)
{
    precise vec3 along = b - a;
    precise float t = clamp(dot(p - a, along) / max(dot(along, along), 1e-37), 0.0, 1.0);
    precise vec3 off = p - a - t * along;
    return length(off);
}

// From the eye to the nearest point of the triangle, in m.
float nearest_distance(vec3 a, vec3 b, vec3 c)
{
    precise vec3 p = eye.xyz, normal = cross(b - a, c - a);
    precise vec3 sides = vec3(dot(cross(b - a, p - a), normal), dot(cross(c - b, p - b), normal),
                              dot(cross(a - c, p - c), normal));
    precise float above = abs(dot(p - a, normal)) / max(length(normal), 1e-37);
    if (all(greaterThanEqual(sides, vec3(0.0)))) return above;
    return min(min(distance_to_segment(p, a, b), distance_to_segment(p, b, c)), distance_to_segment(p, c, a));
}

// Into how many a huge triangle's edges are cut before it is cut into surfels, 0 where that is not needed. The
// surfels of one triangle are of one size, that wanted at its nearest point, and thinned where it is larger. So a
// triangle is too large when the tessellator cannot make as many as it needs, or makes far more than are kept
// because distances vary much over it. The decision is taken twice, by the pass that splits and by that which
// leaves these triangles to it: `precise` makes them agree. There are two levels only, so that parts, and so the
// surfels on them, seldom change while the camera moves.
float split_level(vec3 a, vec3 b, vec3 c)
{
    precise vec3 ab = b - a, bc = c - b, ca = a - c, across = cross(ab, c - a);
    precise float area = 0.5 * length(across), nearest = nearest_distance(a, b, c);
    precise float longest = sqrt(max(max(dot(ab, ab), dot(bc, bc)), dot(ca, ca)));
    precise float count = area / wanted_area(nearest);
    precise float level = sqrt(count / fine_count(most_level));
    if (eye.w > 0.0 && count > fine_count(2.0)) level = max(level, longest / max(nearest, surfel_size.y));
    return level > 3.0 ? 6.0 : level > 1.0 ? 3.0 : 0.0;
}

#endif
