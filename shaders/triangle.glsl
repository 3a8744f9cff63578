// Triangles as seen from a place on a surface, which corners are relative to.
#ifndef AL_TRIANGLE_GLSL
#define AL_TRIANGLE_GLSL

#include "formulas.glsl"

// Whether the triangle may hide something from the place, which lies on a surface with the unit normal: not where the
// place is in its plane as far as rounding lets know, and the surface is turned as it by 60 degrees at most. That is the triangle
// itself or continues it evenly. One that is turned otherwise meets the surface there and hides up to half of all: it is moved
// off by the rounding. A place is known within a few roundings of its own and the eye's coordinates; `scale`: these, m.
// m: the triangle's unit normal; height: of the place over it.
bool may_hide(inout vec3 corner[3], vec3 normal, float scale, out vec3 m, out float height)
{
    vec3 across = cross(corner[1] - corner[0], corner[2] - corner[0]);
    if (!(dot(across, across) > 0.0)) return false; // no area
    m = normalize(across);
    height = -dot(m, corner[0]);
    float rounding = 4e-6 * scale;
    if (abs(height) > rounding) return true;
    for (int i = 0; i < 3; i++) corner[i] += (height - rounding) * m;
    height = rounding;
    return abs(dot(m, normal)) < 0.5;
}

// Distance along the unit direction at which it meets the triangle, -1: it does not. The three volumes spanned by the
// direction and a side have the sign of the side that the direction passes on; a side that two triangles share gives both the
// same number, so that nothing passes between them. The same volumes weigh the corners at the meeting point.
float meet_triangle(vec3 a, vec3 b, vec3 c, vec3 direction)
{
    precise vec3 bc = cross(b, c), ca = cross(c, a), ab = cross(a, b);
    precise float x = dot(direction, bc), y = dot(direction, ca), z = dot(direction, ab);
    float sum = x + y + z;
    bool inside = (x >= 0.0 && y >= 0.0 && z >= 0.0) || (x <= 0.0 && y <= 0.0 && z <= 0.0);
    if (!inside || sum == 0.0) return -1.0;
    return dot(x / sum * a + y / sum * b + z / sum * c, direction);
}

// 2 pi times the form factor of a region on both of whose sides light is hidden, seen from a place with normal n, is
//   |n . J|, J = contour integral of r x dr / r^2 around the region (Lambert; Sparrow 1963).
// A segment from p to q gives the angle between them times the unit vector along p x q. The region here is the triangle
// over the horizon and nearer than `radius`: its contour runs along sides inside the ball and along arcs of the circle in
// which the ball cuts the triangle's plane, of radius rho about the foot h m of the place. On an arc r = h m + rho e:
//   r x dr = rho^2 m dphi - rho h e dphi, and the integral of e over the arc is m x (e_begin - e_end).
// Fans of the foot over the sides add up to the triangle; those of the region over what is inside of each side and the
// arcs over what is outside, with the sign of the angle.

vec3 segment_integral(vec3 p, vec3 q)
{
    vec3 across = cross(p, q);
    float size = length(across);
    return size > 0.0 ? atan(size, dot(p, q)) / size * across : vec3(0.0);
}

vec3 arc_integral(vec3 p, vec3 q, vec3 m, float h, float rho)
{
    vec3 e = normalize(p - h * m), f = normalize(q - h * m);
    float angle = atan(dot(m, cross(e, f)), dot(e, f));
    return (rho * rho * angle * m - rho * h * cross(m, e - f)) / (rho * rho + h * h);
}

vec3 side_integral(vec3 p, vec3 q, vec3 m, float h, float rho)
{
    vec3 along = q - p;
    float size = length(along);
    if (!(size > 0.0)) return vec3(0.0);
    along /= size;
    float middle = -dot(p, along);
    vec3 off = p + middle * along - h * m;
    float square = rho * rho - dot(off, off), reach = square > 0.0 ? sqrt(square) : 0.0;
    float enters = clamp(middle - reach, 0.0, size), leaves = clamp(middle + reach, 0.0, size);
    if (!(leaves > enters)) return arc_integral(p, q, m, h, rho);
    vec3 from = p + enters * along, to = p + leaves * along, sum = segment_integral(from, to);
    if (enters > 0.0) sum += arc_integral(p, from, m, h, rho);
    if (leaves < size) sum += arc_integral(to, q, m, h, rho);
    return sum;
}

// Share of the cosine-weighted hemisphere about `normal` that the triangle hides within the radius. `height`: of the place
// over it, on the side of the unit normal m.
float form_factor(vec3 corner[3], vec3 normal, vec3 m, float height, float radius)
{
    float square = radius * radius - height * height;
    if (!(square > 0.0)) return 0.0;
    float over[3] = float[3](dot(normal, corner[0]), dot(normal, corner[1]), dot(normal, corner[2]));
    vec3 sum = vec3(0.0), first, last;
    int count = 0;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        vec3 places[2] = vec3[2](corner[i], mix(corner[i], corner[j], over[i] / (over[i] - over[j])));
        bool kept[2] = bool[2](over[i] >= 0.0, over[i] >= 0.0 != over[j] >= 0.0);
        for (int k = 0; k < 2; k++) {
            if (!kept[k]) continue;
            if (count++ > 0)
                sum += side_integral(last, places[k], m, -height, sqrt(square));
            else
                first = places[k];
            last = places[k];
        }
    }
    if (count > 2) sum += side_integral(last, first, m, -height, sqrt(square));
    return abs(dot(normal, sum)) / (2.0 * AL_PI);
}

#endif
