#version 450 core
// Fog to the eye: light that is scattered once, on the pixel's ray up to the nearest surface, and what the fog
// leaves of what lies behind. AL_FRONT: up to the front of a translucent object, into two targets.
//
// With T(t) the transmittance from the eye to distance t,
//   L = sum over lights of the integral of T(t) sum_i sigma_s,i(t) p_i(cos) E(t) V(t) dt,
// p_i the phase function of fog i, E the light's irradiance facing it, V what surfaces, translucent objects
// and the fogs leave of it. The ray is cut into cells. What T loses in a cell is exact for a constant density
// (and as exact as the march for a grid), so that thick cells need no resolving:
//   integral of T sigma_s p dt = T(a) (1 - exp(-d))/d sum_i p_i s_i,  d and s_i the cell's optical depth and
//   its depth in scattering of fog i;
// so is the mean of a point light's irradiance I/r^2, whose cells are equal in the angle phi seen from the light
// (Kulla and Fajardo 2012): with D the light's distance to the ray, integral of I/r^2 dt = I dphi/D. Their
// product per cell leaves the covariance of the two inside it, of second order in the cell's size. V and the
// phase function are taken at one place in each cell, drawn (stratified, by pixel and frame) as T is lost there in
// one of the channels, and weighted by the balance heuristic (Veach and Guibas 1995) for all three: an even
// draw would miss the lit skin of a thick cell.
// Light of the environment comes from the bake (fog_sky.glsl). It varies slowly: its cells are even, halved where
// much is lost, and its place in a cell is the mean of where T is lost there. No noise.
#extension GL_GOOGLE_include_directive : enable
#include "shadows.glsl"
#include "fogs.glsl"
#include "fog_sky.glsl"

layout(binding = 2) uniform sampler2D geometry; // of the opaque surfaces: w distance, 0 none
layout(binding = 3) uniform sampler2D boundary; // of the object: w distance, negative: the eye is inside

#ifdef AL_FRONT
layout(location = 0) out vec4 added;
layout(location = 1) out vec4 kept;
#else
layout(location = 0, index = 0) out vec4 added;
layout(location = 0, index = 1) out vec4 kept;
#endif

const float sky_nothing_left = 10.0; // exp(-10) = 5e-5
const float sky_cell_depth = 0.2;

// Random bits from pixel and frame: the 32-bit mixer of Wellons's "lowbias32" search.
uint random_bits(ivec2 pixel)
{
    uint h = uint(pixel.x) * 0x9e3779b9u ^ uint(pixel.y) * 0x85ebca6bu ^ uint(fog_counts.z) * 0xc2b2ae35u;
    h = (h ^ (h >> 16)) * 0x7feb352du;
    h = (h ^ (h >> 15)) * 0x846ca68bu;
    return h ^ (h >> 16);
}

// Where the cell boundaries of a light lie on the ray.
struct Cells {
    float from, end;
    float foot, away;   // point light: t of its foot on the ray, its distance to the ray
    float start, angle; // from - foot; angle between both ends seen from the light, 0 for a directional one
};

Cells cells_of(Light light, vec3 origin, vec3 direction, float from, float end)
{
    Cells c = Cells(from, end, 0.0, 0.0, 0.0, 0.0);
    if (light.vector.w == 0.0) return c;
    vec3 path = light.vector.xyz - origin;
    c.foot = dot(path, direction);
    // A ray through the light has no bound; what is nearer than 2^-20 of the foot's distance is rounding, and so are its cells.
    c.away = max(length(path - c.foot * direction), max(abs(c.foot) * 9.5367431640625e-7, sqrt(light.intensity.w)));
    c.start = from - c.foot;
    c.angle = atan(c.away * (end - from), c.away * c.away + c.start * (end - c.foot));
    return c;
}

// The distance at share u of the cells: tan of the sum of two angles, without tan's pole.
float cell_place(Cells c, float u)
{
    if (c.angle == 0.0) return mix(c.from, c.end, u);
    float s = sin(u * c.angle), k = cos(u * c.angle);
    float x = c.away * (c.start * k + c.away * s) / max(c.away * k - c.start * s, 1e-30);
    return clamp(c.foot + x, c.from, c.end);
}

// Density over [0, 1], the cell, of T's loss to optical depth d.
float loss_density(float d, float x)
{
    return d < 1e-3 ? 1.0 : d * exp(-d * x) / al_one_minus_exp(d);
}

// A place in the cell drawn so for channel c; the weight of each channel there.
float loss_place(vec3 d, int c, float random, out vec3 weight)
{
    float x = d[c] < 1e-3 ? random : min(-log(max(1.0 - random * al_one_minus_exp(d[c]), 1e-30)) / d[c], 1.0);
    weight = vec3(loss_density(d.r, x), loss_density(d.g, x), loss_density(d.b, x));
    weight *= 3.0 / max(weight.r + weight.g + weight.b, 1e-30);
    return x;
}

// The share lost / depth of what a cell scatters that leaves it towards the eye.
vec3 leaving(vec3 depth)
{
    vec3 lost = vec3(al_one_minus_exp(depth.r), al_one_minus_exp(depth.g), al_one_minus_exp(depth.b));
    return mix(lost / max(depth, vec3(1e-30)), vec3(1.0), lessThan(depth, vec3(1e-6)));
}

vec3 scattered_light(int index, vec3 origin, vec3 direction, float from, float end, uint bits)
{
    Light light = lights[index];
    Cells c = cells_of(light, origin, direction, from, end);
    int count = fog_counts.y;
    float random = float(bits >> 8) / 16777216.0; // in [0, 1)
    int channel = int(bits & 255u);
    float a = from;
    vec3 sum = vec3(0.0), tau = vec3(0.0);
    for (int k = 0; k < count; k++) {
        float b = k + 1 == count ? end : cell_place(c, float(k + 1) / float(count));
        float shares[AL_FOG_LIMIT], reach;
        vec3 depth = vec3(0.0), source = vec3(0.0), weight, toward;
        for (int i = 0; i < fog_counts.x; i++) {
            shares[i] = fog_depth(i, origin, direction, a, b, 32.0);
            depth += fogs[i].sigma_t.rgb * shares[i];
        }
        float drawn = fract(random + 0.618034 * float(k + 7 * index)); // the golden ratio's sequence
        float at = mix(a, b, loss_place(depth, (channel + k) % 3, drawn, weight));
        vec3 here = origin + direction * at;
        light_arrival(index, here, 0.0, toward, reach);
        for (int i = 0; i < fog_counts.x; i++)
            source += fogs[i].sigma_s.rgb * shares[i] * al_phase(fogs[i].sigma_t.w, dot(toward, direction));
        float arriving = light.vector.w == 0.0
                             ? 1.0
                             : c.angle / (float(count) * c.away * max(b - a, 1e-6 * c.away));
        vec3 part = exp(-tau) * leaving(depth) * source * weight * arriving;
        if (dot(part, vec3(1.0)) > 0.0) {
            part *= fog_transmittance(here, toward, reach, 64.0);
            if (fog_counts.w != 0)
                part *= opaque_visibility(index, here, vec3(0.0)) *
                        translucent_visibility(here, toward, reach, -1);
            sum += part;
        }
        tau += depth;
        a = b;
    }
    return min(sum * light.intensity.rgb, vec3(1e30));
}

// The mean of the loss density's x over [0, 1]: 1/d - 1/(exp(d) - 1); its series below 1/8, error 1e-6.
float mean_loss_place(float d)
{
    return d < 0.125 ? 0.5 - d / 12.0 * (1.0 - d * d / 60.0) : 1.0 / d - exp(-d) / al_one_minus_exp(d);
}

// A quarter of a light's cells is enough, as nothing is drawn in them; those that lose much are halved, up to
// five times: where a grid is dense, the light falls off within a few voxels.
vec3 scattered_sky(vec3 origin, vec3 direction, float from, float end)
{
    float widest = (end - from) / float((fog_counts.y + 3) / 4), width = widest, a = from;
    vec3 sum = vec3(0.0), tau = vec3(0.0);
    sky_begin(direction);
    while (a < end - 1e-3 * widest && any(lessThan(tau, vec3(sky_nothing_left)))) {
        float b = min(a + width, end), shares[AL_FOG_LIMIT];
        if (!(b > a)) break; // cells below float's resolution
        vec3 depth = vec3(0.0), source = vec3(0.0);
        for (int i = 0; i < fog_counts.x; i++) {
            shares[i] = fog_depth(i, origin, direction, a, b, 32.0);
            depth += fogs[i].sigma_t.rgb * shares[i];
        }
        float mean = dot(depth, vec3(1.0 / 3.0));
        if (mean > sky_cell_depth && width > 0.05 * widest) {
            width *= 0.5;
            continue;
        }
        vec3 here = origin + direction * mix(a, b, mean_loss_place(mean));
        for (int i = 0; i < fog_counts.x; i++)
            if (shares[i] > 0.0 && fogs[i].sky_size.w > 0)
                source += fogs[i].sigma_s.rgb * shares[i] * sky_towards(i, here);
        sum += exp(-tau) * leaving(depth) * source;
        tau += depth;
        a = b;
        width = min(2.0 * width, widest);
    }
    return min(sum, vec3(1e30));
}

void main()
{
    ivec2 place = ivec2(gl_FragCoord.xy);
    vec3 origin, direction;
    view_ray(view_pixel(gl_FragCoord.xy), origin, direction);
#ifdef AL_FRONT
    float to = max(texelFetch(boundary, place, 0).w, 0.0);
#else
    float to = texelFetch(geometry, place, 0).w;
    if (to == 0.0) to = 1e30;
#endif
    added = vec4(0.0);
    kept = vec4(1.0);
    float from, end;
    if (!fog_range(origin, direction, to, from, end)) return;
    kept.rgb = fog_transmittance(origin, direction, to, 512.0);
    uint bits = random_bits(place + tile.xy);
    for (int i = 0; i < counts.x; i++)
        added.rgb += scattered_light(i, origin, direction, from, end, bits);
    if (fog_atlas.z != 0) added.rgb += scattered_sky(origin, direction, from, end);
}
