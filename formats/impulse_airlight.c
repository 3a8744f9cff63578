/* Event 1 along one ray: the airlight integral.
 *
 * In the triangle of receiver O, emitter E at distance d and scattering point P at t on the ray, with the
 * angles theta at O and alpha at E, dt/r^2 = dalpha/(d sin(theta)) (Kulla and Fajardo 2012). With half the
 * angle of scattering as u = tan((theta + alpha)/2), from u0 = tan(theta/2) on, t + r = d + d sin(theta) (u -
 * u0),   dalpha = 2 du/(1 + u^2), so that the light's loss is linear in u (Sun, Ramamoorthi, Narasimhan,
 * Nayar 2005): L = sigma_s exp(-sigma_t d)/(d sin(theta)) int p(u) exp(-k (u - u0)) 2 du/(1 + u^2),  k =
 * sigma_t d sin(theta), up to u at alpha = atan2(length sin(theta), d - length cos(theta)). Henyey-Greenstein
 * is a quotient in u: 4 pi p = (1 - g^2) ((1 + u^2)/((1 - g)^2 + (1 + g)^2 u^2))^(3/2). All of it has
 * features at u = 1, (1 - g)/(1 + g) and 1/k and is smooth on a logarithmic scale.
 *
 * A directional light scatters by the same angle all along the ray: at depth d the point at t receives
 * exp(-sigma_t (d - t mu)), and the integral of exp(-sigma_t t (1 - mu)) is elementary. */
#include <assert.h>
#include <math.h>

#include "airlight/formulas.h"
#include "airlight/impulse_tables.h"

enum { NODES = 6 };

static const double nodes[NODES / 2] = {0.2386191860831969, 0.6612093864662645, 0.9324695142031521};
static const double weights[NODES / 2] = {0.4679139345726910, 0.3607615730481386, 0.1713244923791704};

typedef struct triangle {
    const al_impulse_ray *ray;
    double theta, start, k; /* start: u0 */
    double lateral;         /* cosine of the ray's azimuth from the side of the normal */
} triangle;

static double integrand(const triangle *t, double u)
{
    double g = t->ray->g, square = 1 + u * u,
           ratio = square / ((1 - g) * (1 - g) + (1 + g) * (1 + g) * u * u);
    double value = ratio * sqrt(ratio) * exp(-t->k * (u - t->start)) / square;
    if (t->ray->emitter != AL_IMPULSE_AREA) return value;
    double c = t->ray->cos_normal, sine = sqrt(fmax(0, 1 - c * c)), alpha = 2 * atan(u) - t->theta;
    return value * fmax(0, c * cos(alpha) + sine * sin(alpha) * t->lateral);
}

/* From u0 to `end`: Gauss-Legendre on panels of ln w, w = u - u0 + scale, with `scale` no larger than the
 * smallest feature of the integrand at u0. */
static double integrate(const triangle *t, double end, double scale)
{
    const double widest = 1.4;
    double span = log1p((end - t->start) / scale), shift = t->start - scale, sum = 0;
    int panels = (int)ceil(span / widest);
    if (panels < 1) return 0;
    double half = 0.5 * span / panels, middle = scale * exp(half), ratio = exp(2 * half);
    double stretch[NODES / 2]; /* the nodes' places, as factors of a panel's middle */
    for (int i = 0; i < NODES / 2; i++) stretch[i] = exp(half * nodes[i]);
    for (int p = 0; p < panels; p++, middle *= ratio)
        for (int i = 0; i < NODES / 2; i++) {
            double high = middle * stretch[i], low = middle / stretch[i];
            sum += weights[i] * (high * integrand(t, high + shift) + low * integrand(t, low + shift));
        }
    return half * sum;
}

static double directional(const al_impulse_ray *ray, double sigma_t)
{
    double mu = ray->direction_z, rate = sigma_t * (1 - mu), length = ray->length_m;
    if (mu > 0) length = fmin(length, ray->distance_m / mu); /* up to the plane */
    /* the integral of exp(-rate t); rate can be 0 only towards the light, where the plane bounds the length
     */
    double inside = rate * length > 1e-12 ? -expm1(-rate * length) / rate : length;
    return ray->sigma_s_per_m * al_phase(ray->g, mu) * exp(-sigma_t * ray->distance_m) * inside;
}

double al_impulse_airlight(const al_impulse_ray *ray)
{
    const double smallest = 1e-6, light_left = 14, tail = 4e4;
    double sigma_t = ray->sigma_s_per_m + ray->sigma_a_per_m, d = ray->distance_m, g = ray->g;
    assert(d > 0 && fabs(g) < 1);
    if (!(ray->sigma_s_per_m > 0) || !(ray->length_m > 0)) return 0;
    if (ray->emitter == AL_IMPULSE_DIRECTIONAL) return directional(ray, sigma_t);
    double z = ray->direction_z, across = sqrt(fmax(0, 1 - z * z));
    double theta = fmin(fmax(atan2(across, z), smallest), AL_PI - smallest), start = tan(theta / 2);
    triangle t = {ray, theta, start, sigma_t * d * sin(theta), across > 0 ? ray->direction_x / across : 0};
    double end = fmin(start + light_left / t.k, tail * (1 + start)); /* beyond it 2/u is 5e-5 of the whole */
    if (isfinite(ray->length_m)) {
        double alpha = atan2(ray->length_m * sin(theta), d - ray->length_m * cos(theta));
        double u = tan(0.5 * fmin(theta + alpha, AL_PI));
        if (u > start) end = fmin(end, u);
    }
    double feature = fmax(start, 0.5 * (1 - fabs(g)) / (1 + fabs(g)));
    double sum = integrate(&t, end, fmin(feature, 1 / t.k));
    return ray->sigma_s_per_m * exp(-sigma_t * d) * (1 - g * g) * 2 / (4 * AL_PI) * sum / (d * sin(theta));
}
