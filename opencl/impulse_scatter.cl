/* One scattering event more, in the light of a point or of a differential area.
 *
 * Receiver O, emitter E at distance d, scattering point P. With the angles theta at O and alpha at E of the
 * triangle, s = theta + alpha the angle of scattering, |OP| = t, |EP| = r:
 *   t = d sin(alpha)/sin(s),  r = d sin(theta)/sin(s),  dt at fixed theta = r^2 dalpha/(d sin(theta)),
 *   t + r - d = 2 d sin(theta/2) sin(alpha/2)/cos(s/2) = d excess.
 * The radiance that k events bring to O is the integral along the ray of exp(-t) J(P), J = fluence of k - 1
 * events / (4 pi), so that with the equi-angular measure above
 *   sh(l, m) = (1/d) int_0^pi ds int_0^s dtheta Y(l, m; theta, 0) exp(-t) int dphi {1, sqrt 2 cos(m phi)} r^2 J
 * and the inner integrand is smooth: r^2 J carries no singularity. Sources are kept as r^2 J =
 * exp(-r) r^2 a(r) F(ln r, cosine) / sqrt(4 pi), F the table of the event before; exp(-d) is taken out of all.
 *
 * Both integrals are trapezoidal sums over the whole line, s = 2 atan(exp(y)), theta = s/(1 + exp(-z)): the
 * integrand is analytic in a strip and dies out at both ends, so that the sums converge exponentially, and the
 * layers that theta and alpha have where d is large lie on a logarithmic scale. */
#include "impulse.cl"

/* Global size: (distances, cosines of the receiver, angles y).
 * rays: [y][z][3] ln(r/d), excess, weight; columns: [y][z][numbers] Y(l, m; theta, 0), m by m;
 * turns: [y][z][cosine][m][source cosine] azimuth integrals of the source's interpolation (point: ones);
 * spans: [y][z][cosine][2] first source cosine with a turn that is not 0, and the one behind the last;
 * source: [source distance][cosine] F; distances: [distance] d; first, scale: ln of the first source distance
 * and the inverse of its logarithmic step; event: of the source.
 * shares: [y][cosine][distance][number], to be multiplied by sqrt(4 pi)/(2 d). */
kernel void impulse_scatter(global const AL_REAL *rays, global const AL_REAL *columns,
                            global const AL_REAL *turns, global const int *spans, global const AL_REAL *source,
                            global const AL_REAL *distances, int z_count, int bands, int m_count,
                            int source_count, int event, AL_REAL first, AL_REAL scale, global AL_REAL *shares)
{
    int i = get_global_id(0), c = get_global_id(1), y = get_global_id(2);
    int distance_count = get_global_size(0), cosines = get_global_size(1);
    int numbers = m_count == 1 ? bands : 3 * bands - 3;
    AL_REAL d = distances[i], log_d = log(d), sums[48];
    for (int n = 0; n < numbers; n++) sums[n] = 0.0f;
    for (int z = 0; z < z_count; z++) {
        size_t node = (size_t)y * z_count + z;
        global const AL_REAL *ray = rays + 3 * node, *column = columns + node * numbers;
        global const AL_REAL *turn = turns + (node * cosines + c) * m_count * cosines;
        AL_REAL loss = d * ray[1], weights[4], log_r = log_d + ray[0];
        if (loss > 40.0f || ray[2] == 0.0f) continue; /* exp(-40) is nothing beside the rest */
        int place = al_stencil((log_r - first) * scale, source_count, weights);
        AL_REAL here = ray[2] * exp(-loss) * al_source_factor(event, exp(log_r));
        AL_REAL parts[3] = {0.0f, 0.0f, 0.0f};
        global const AL_REAL *rows = source + (size_t)place * cosines;
        global const int *span = spans + 2 * (node * cosines + c);
        for (int j = span[0]; j < span[1]; j++) {
            AL_REAL value = 0.0f;
            for (int k = 0; k < 4; k++) value += weights[k] * rows[k * cosines + j];
            for (int m = 0; m < m_count; m++) parts[m] += turn[m * cosines + j] * value;
        }
        for (int m = 0, n = 0; m < m_count; m++)
            for (int l = m; l < bands; l++, n++) sums[n] += here * parts[m] * column[n];
    }
    global AL_REAL *out = shares + (((size_t)y * cosines + c) * distance_count + i) * numbers;
    for (int n = 0; n < numbers; n++) out[n] = sums[n];
}
