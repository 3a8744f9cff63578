/* GGX: Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces", with Schlick's Fresnel
 * term and the separable Smith masking G1(v) G1(l),
 *   f cos_l = ((1 - F) diffuse / pi + F D G1(v) G1(l) / (4 cos_v cos_l)) cos_l.
 * Microfacet normals are drawn as the eye sees them (Heitz 2018, "Sampling the GGX Distribution of Visible
 * Normals"): density of the light's direction G1(v) D / (4 cos_v). */
#include "reflection.h"

#include <math.h>

#include "directions.h"

static double mean_of(const double v[3])
{
    return (v[0] + v[1] + v[2]) / 3;
}

/* Schlick's reflectance at grazing angles is 1, but an index-matched surface reflects nothing (Lagarde and de
 * Rousiers 2014). */
static double fresnel(double f0, double cosine)
{
    double grazing = fmin(50 * f0, 1);
    return f0 + (grazing - f0) * pow(fmax(1 - cosine, 0), 5);
}

/* Where the eye looks from below the interpolated normal, as in the player; no microfacets are drawn there.
 */
static const double least_seen = 1e-4;

static double seen(const al_reflection *r)
{
    return fmax(al_dot(r->normal, r->view), least_seen);
}

al_reflection al_reflection_of(const al_surface_colors *colors, const al_surface_hit *hit,
                               const double view[3])
{
    al_reflection r;
    double roughness, side = hit->front ? 1 : -1, mirrored = 0;
    al_surface_gloss(colors, hit->material, hit->uv0, r.f0, &roughness);
    for (int k = 0; k < 3; k++) {
        r.normal[k] = side * hit->shading_normal[k];
        r.face[k] = side * hit->normal[k];
        r.view[k] = view[k];
        r.diffuse[k] = hit->albedo[k];
    }
    r.alpha = fmax(roughness * roughness, 1e-3);
    for (int c = 0; c < 3; c++) mirrored += fresnel(r.f0[c], fmax(al_dot(r.normal, view), 0)) / 3;
    double diffuse = mean_of(r.diffuse) * (1 - fmin(mirrored, 1));
    r.lambert_share =
        mirrored > 0 && al_dot(r.normal, view) > least_seen ? diffuse / (diffuse + mirrored) : 1;
    return r;
}

/* D, with 1 - cos^2 (1 - alpha^2) as a sum of what does not cancel near the peak. */
static double distribution(const al_reflection *r, const double middle[3])
{
    double facing = al_dot(r->normal, middle), square = 0, alpha2 = r->alpha * r->alpha;
    for (int k = 0; k < 3; k++) {
        double across = middle[k] - facing * r->normal[k];
        square += across * across;
    }
    double spread = square + facing * facing * alpha2;
    return facing > 0 ? alpha2 / (AL_PI * spread * spread) : 0;
}

/* G1 / (2 cos): 1 / (cos + sqrt(alpha^2 + (1 - alpha^2) cos^2)). */
static double masking(const al_reflection *r, double cosine)
{
    double alpha2 = r->alpha * r->alpha;
    return 1 / (cosine + sqrt(alpha2 + (1 - alpha2) * cosine * cosine));
}

static void half_way(const al_reflection *r, const double towards[3], double middle[3])
{
    double square = 0;
    for (int k = 0; k < 3; k++) {
        middle[k] = towards[k] + r->view[k];
        square += middle[k] * middle[k];
    }
    for (int k = 0; k < 3; k++) middle[k] = square > 0 ? middle[k] / sqrt(square) : r->normal[k];
}

void al_reflection_value(const al_reflection *r, const double towards[3], double value[3])
{
    double cosine = al_dot(r->normal, towards), middle[3];
    value[0] = value[1] = value[2] = 0;
    if (!(cosine > 0) || !(al_dot(r->face, towards) > 0)) return;
    half_way(r, towards, middle);
    double lobe = distribution(r, middle) * masking(r, cosine) * masking(r, seen(r));
    for (int c = 0; c < 3; c++) {
        double mirrored = fresnel(r->f0[c], fmax(al_dot(r->view, middle), 0));
        value[c] = ((1 - mirrored) * r->diffuse[c] / AL_PI + mirrored * lobe) * cosine;
    }
}

double al_reflection_density(const al_reflection *r, const double towards[3])
{
    double middle[3], cosine = fmax(al_dot(r->normal, towards), 0);
    half_way(r, towards, middle);
    return r->lambert_share * cosine / AL_PI +
           (1 - r->lambert_share) * 0.5 * masking(r, seen(r)) * distribution(r, middle);
}

/* In axes whose third is the normal: the view is stretched to a hemisphere, of which the part it sees is
 * drawn. */
static void draw_microfacet(const al_reflection *r, double u0, double u1, double middle[3])
{
    double x[3], y[3], v[3], a[3] = {1, 0, 0}, n[3];
    al_axes_across(r->normal, x, y);
    v[0] = r->alpha * al_dot(x, r->view), v[1] = r->alpha * al_dot(y, r->view), v[2] = seen(r);
    double length = sqrt(al_dot(v, v));
    for (int k = 0; k < 3; k++) v[k] /= length;
    double flat = hypot(v[0], v[1]);
    if (flat > 0) a[0] = -v[1] / flat, a[1] = v[0] / flat;
    double b[3] = {-v[2] * a[1], v[2] * a[0], v[0] * a[1] - v[1] * a[0]};
    double radius = sqrt(u0), phi = 2 * AL_PI * u1, across = radius * cos(phi), up = radius * sin(phi),
           share = 0.5 * (1 + v[2]);
    up = (1 - share) * sqrt(fmax(0, 1 - across * across)) + share * up;
    double along = sqrt(fmax(0, 1 - across * across - up * up));
    for (int k = 0; k < 3; k++) n[k] = across * a[k] + up * b[k] + along * v[k];
    n[0] *= r->alpha, n[1] *= r->alpha, n[2] = fmax(n[2], 1e-12);
    length = sqrt(al_dot(n, n));
    for (int k = 0; k < 3; k++) middle[k] = (n[0] * x[k] + n[1] * y[k] + n[2] * r->normal[k]) / length;
}

void al_reflection_draw(const al_reflection *r, const double u[3], double towards[3])
{
    if (u[0] < r->lambert_share) {
        al_direction_about(r->normal, sqrt(1 - u[1]), 2 * AL_PI * u[2], towards);
        return;
    }
    double middle[3];
    draw_microfacet(r, u[1], u[2], middle);
    double twice = 2 * al_dot(r->view, middle);
    for (int k = 0; k < 3; k++) towards[k] = twice * middle[k] - r->view[k];
}
