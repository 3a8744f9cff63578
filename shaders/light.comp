#version 450 core
// The light that each sample scatters towards the eye, once per frame, all lights in one loop:
//   J_c = sum over lights of p(cos) E_c psi_c(towards the light) V_c + integral of p L_environment,c psi_c,
// p the phase function, E the irradiance facing the light, psi the sample's transmittance in SH, V what other
// objects let through. The environment's integral is a dot product of coefficients: those of p L come from
// the host, with p about the direction from the object's middle to the eye (exact for g = 0, and for g != 0
// as far as the object is seen from one direction).
//
// Marched view leg: the result is albedo_c J_c; the interval map brings extinction and the transmittance to
// the eye. Beside it goes its relative slope: to first order J(x) = J(b) exp(s.(x - b)) with s = sum of
// J_light grad psi / psi over J. Along the direction w to its light psi(x, w) grows by sigma_t(x) psi per metre,
// in any medium. Across w it grows as the way to the boundary gets shorter: below a flat boundary with the outward
// normal n, tau(x, w) = sigma_t depth / mu with mu = n.w, hence
//   grad psi / psi = sigma_t n / mu = sigma_t (w + (n - mu w) / mu).
// n is guessed from band 1 of psi: m = mean of w psi over mean of psi points to the nearest boundary, from where
// most light comes. Below a flat boundary |m| = E3(tau) / E2(tau) >= 1/2 (exponential integrals of the depth); deep
// inside, or where little is lost at all, it is near 0 and says nothing: the part across w is weighted by
// min(2 |m|, 1). Where the light grazes the boundary or comes from behind, its way ends elsewhere: 1 / mu becomes
// mu / 0.3^2 below 0.3 and 0 below 0. (The slope of the environment's light is taken as 0.)
//
// AL_VIEW_SH, as published: sigma_s,c at the sample times psi_c(towards the eye) times J_c, 1/m. Beside it what
// the reference transmittance loses there, 1/m: the mean over the channels that have extinction of sigma_t,c
// psi_c(towards the eye).
//
// AL_ORDER, AL_BAKED_ORDER: bands used and bands stored. AL_CHANNELS: 1 or 3 sets of coefficients.
// AL_FORMAT: 0 float32, 1 binary16, 2 int8 with a scale per sample and set.
#extension GL_GOOGLE_include_directive : enable
#include "formulas.glsl"
#include "shadows.glsl"
#include "object.glsl"
#ifdef AL_FOG
#include "fogs.glsl"
#endif

#ifndef AL_ORDER
#define AL_ORDER 5
#define AL_BAKED_ORDER 5
#define AL_CHANNELS 1
#define AL_FORMAT 0
#endif
#define AL_STORED (AL_BAKED_ORDER * AL_BAKED_ORDER)

layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Positions { float positions[]; };
// a in 1/m^2, weight, radius in m, density.
layout(std430, binding = 1) readonly buffer Gaussians { vec4 gaussians[]; };
layout(std430, binding = 2) readonly buffer Coefficients { uint coefficients[]; }; // from sample `first` on
layout(std430, binding = 3) readonly buffer Scales { float scales[]; };
layout(std430, binding = 4) writeonly buffer Lit { vec4 lit[]; }; // rgb, loss; then the slope, 1/m
layout(location = 0) uniform uint first; // sample of this dispatch; a block holds no more than GL allows

float coefficient(uint index)
{
#if AL_FORMAT == 0
    return uintBitsToFloat(coefficients[index]);
#elif AL_FORMAT == 1
    return unpackHalf2x16(coefficients[index >> 1])[index & 1u];
#else
    return float(bitfieldExtract(int(coefficients[index >> 2]), int(index & 3u) * 8, 8)) / 127.0;
#endif
}

// Coefficients of the sample, all sets, kept while the lights pass by.
float psi[AL_CHANNELS * AL_ORDER * AL_ORDER];

void load_psi(uint index)
{
    for (int channel = 0; channel < AL_CHANNELS; channel++) {
        float scale = 1.0;
#if AL_FORMAT == 2
        scale = scales[index * AL_CHANNELS + channel];
#endif
        uint set = ((index - first) * AL_CHANNELS + channel) * AL_STORED;
        for (int k = 0; k < AL_ORDER * AL_ORDER; k++)
            psi[channel * AL_ORDER * AL_ORDER + k] = coefficient(set + k) * scale;
    }
}

// Transmittance lies in [0, 1]; its band limit overshoots.
vec3 transmittance(vec3 direction)
{
    float basis[AL_SH_MAX_COUNT];
    vec3 sum = vec3(0.0);
    al_sh_basis(AL_ORDER, direction.x, direction.y, direction.z, basis);
    for (int channel = 0; channel < AL_CHANNELS; channel++)
        for (int k = 0; k < AL_ORDER * AL_ORDER; k++)
            sum[channel] += psi[channel * AL_ORDER * AL_ORDER + k] * basis[k];
    if (AL_CHANNELS == 1) sum = sum.rrr;
    return clamp(sum, 0.0, 1.0);
}

// m of the slope: band 0 over sqrt(4 pi) is the mean of psi, band 1 over sqrt(12 pi) that of w psi.
vec3 brightest()
{
    vec3 first = vec3(0.0);
    float zeroth = 0.0;
#if AL_ORDER > 1
    for (int set = 0; set < AL_CHANNELS * AL_ORDER * AL_ORDER; set += AL_ORDER * AL_ORDER) {
        first += vec3(psi[set + 3], psi[set + 1], psi[set + 2]);
        zeroth += psi[set];
    }
#endif
    return zeroth > 0.0 ? first / (sqrt(3.0) * zeroth) : vec3(0.0);
}

// grad psi / psi over sigma_t, towards a light in direction w.
vec3 relative_gradient(vec3 m, vec3 w)
{
    float size = length(m);
    vec3 n = m / max(size, 1e-6);
    float mu = dot(n, w);
    return w + min(2.0 * size, 1.0) * max(mu, 0.0) / max(mu * mu, 0.09) * (n - mu * w);
}

vec3 environment_light()
{
    vec3 sum = vec3(0.0);
    for (int k = 0; k < AL_ORDER * AL_ORDER; k++) {
        vec3 set = AL_CHANNELS == 1 ? vec3(psi[k])
                                    : vec3(psi[k], psi[(AL_CHANNELS > 1 ? AL_ORDER * AL_ORDER : 0) + k],
                                           psi[(AL_CHANNELS > 1 ? 2 * AL_ORDER * AL_ORDER : 0) + k]);
        sum += object_environment[k].rgb * set;
    }
    return max(sum, vec3(0.0));
}

void main()
{
    uint index = first + gl_GlobalInvocationID.x;
    if (index >= uint(sizes.x)) return;
    vec3 place = vec3(positions[3 * index], positions[3 * index + 1], positions[3 * index + 2]);
    vec3 world = (object_to_world * vec4(place, 1.0)).xyz;
    vec3 eye_way = to_eye(world);
    vec4 gaussian = gaussians[index];
    load_psi(index);
    vec3 m = brightest();
    vec3 sum = vec3(0.0), slope = vec3(0.0);
    for (int i = 0; i < counts.x; i++) {
        vec3 direction;
        float reach;
        // No more than the mean over a ball of radius a^(-1/2) about the light, 3 a: the sample stands for
        // its surroundings, so a light inside it has no pole.
        vec3 arriving = light_arrival(i, world, 1.0 / (3.0 * gaussian.x * prefix.x), direction, reach);
        vec3 own = mat3(world_to_object) * direction;
        arriving *= transmittance(own) * al_phase(albedo.w, -dot(direction, eye_way));
#ifdef AL_FOG
        // First: behind the two below, llvmpipe of Mesa 22.3 samples for one invocation of eight alone.
        arriving *= fog_transmittance(world, direction, reach, 64.0);
#endif
        if (toggles.z != 0 && arriving != vec3(0.0))
            arriving *= opaque_visibility(i, world, vec3(0.0)) *
                        translucent_visibility(world, direction, reach, sizes.z);
        sum += arriving;
        slope += dot(arriving, ratio.rgb) * relative_gradient(m, own);
    }
    if (toggles.w != 0) sum += environment_light();
#ifdef AL_VIEW_SH
    vec3 to_boundary = transmittance(mat3(world_to_object) * eye_way);
    float loss = march.z * gaussian.w * dot(ratio.rgb, to_boundary) / max(ratio.w, 1.0);
    sum *= sigma_s.rgb * gaussian.w * to_boundary;
#else
    float loss = 1.0;
    slope *= march.z * gaussian.w / max(dot(sum, vec3(1.0)), 1e-30);
    sum *= albedo.rgb;
#endif
    lit[2 * index] = vec4(sum, loss);
    lit[2 * index + 1] = vec4(slope, 0.0);
}
