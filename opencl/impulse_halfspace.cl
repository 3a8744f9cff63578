/* One scattering event more, in the light of a directional source that enters a half-space.
 *
 * Receiver at depth d, z towards the light. On the ray that arrives from the cosine mu, the point at distance t
 * lies at depth d - mu t; rays with mu > 0 end at the plane. With the fluence of the event before at depth x,
 * exp(-x) a(x) F(ln x) sqrt(4 pi), a its asymptote, and exp(-d) taken out,
 *   zh(l) = (1/2) int dmu Y(l, 0; mu) int dt exp(-t (1 - mu)) sqrt(4 pi) a F(d - mu t).
 * Trapezoidal sums: |mu| = 1/(1 + exp(-w)) on either side of 0, where the radiance of a thin layer jumps;
 * t = (d/mu)/(1 + exp(-z)) up to the plane, so that both its ends lie on a logarithmic scale, and t = exp(z)
 * away from it. */
#include "impulse.cl"

/* Global size: (distances, 1, rows of mu). rows: [row][3] |mu|, 1 - mu, side (1: towards the plane, 0: away);
 * steps: [z][5] x = 1/(1 + exp(-z)), 1 - x, x (1 - x) dz, and for the other side t = exp(z') and its weight
 * t dz'; columns: [row][band] weight dmu Y(l, 0; mu); source: [source distance] F; event, distances,
 * first, scale: as in impulse_scatter.cl. shares: [row][distance][band], to be multiplied by sqrt(4 pi)/2. */
kernel void impulse_halfspace(global const AL_REAL *rows, global const AL_REAL *steps,
                              global const AL_REAL *columns, global const AL_REAL *source,
                              global const AL_REAL *distances, int z_count, int bands, int source_count,
                              int event, AL_REAL first, AL_REAL scale, global AL_REAL *shares)
{
    int i = get_global_id(0), row = get_global_id(2), distance_count = get_global_size(0);
    AL_REAL d = distances[i], mu = rows[3 * row], slope = rows[3 * row + 1], sum = 0.0f;
    bool up = rows[3 * row + 2] > 0.5f;
    for (int z = 0; z < z_count; z++) {
        global const AL_REAL *step = steps + 5 * z;
        AL_REAL length = d / mu, t = up ? length * step[0] : step[3], weights[4];
        AL_REAL depth = up ? d * step[1] : d + mu * t, weight = up ? length * step[2] : step[4];
        AL_REAL loss = t * slope;
        if (loss > 40.0f) continue;
        int place = al_stencil((log(depth) - first) * scale, source_count, weights);
        AL_REAL value = 0.0f;
        for (int k = 0; k < 4; k++) value += weights[k] * source[place + k];
        sum += weight * exp(-loss) * al_event_growth(event, depth) * value;
    }
    global AL_REAL *out = shares + ((size_t)row * distance_count + i) * bands;
    for (int l = 0; l < bands; l++) out[l] = sum * columns[row * bands + l];
}
