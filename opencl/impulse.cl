/* What the steps of the impulse tables share. The same text is compiled for the host in double precision
 * (precompute/impulse_double.c), which checks what the device computes in single: constants are whole or exact
 * in binary, angles and weights come from the host. */
#ifndef AIRLIGHT_IMPULSE_CL
#define AIRLIGHT_IMPULSE_CL

#ifndef AL_REAL
#define AL_REAL float
#endif

/* (1 + r)^(event/3): what the asymptotes of docs/formats.md say of each event. */
static inline AL_REAL al_event_growth(int event, AL_REAL r)
{
    return exp(log(1.0f + r) * event / 3.0f);
}

/* The factor r^2 a(r) of a point's or area's source, a its asymptote without exp(-r), after `event` events. */
static inline AL_REAL al_source_factor(int event, AL_REAL r)
{
    AL_REAL near = r / (1.0f + r);
    if (event == 0) return 1.0f;
    AL_REAL factor = event == 1 ? near : event == 2 ? near * near * (1.0f + log(1.0f + 1.0f / r)) : near * near;
    return factor * al_event_growth(event, r);
}

/* Cubic interpolation at `place` in steps of an axis of `count` nodes: index of the first of the four nearest,
 * their weights. Places beyond the ends count as the ends. */
static inline int al_stencil(AL_REAL place, int count, AL_REAL *weights)
{
    AL_REAL inside = fmin(fmax(place, (AL_REAL)0.0f), (AL_REAL)(count - 1));
    int first = (int)inside - 1;
    first = first < 0 ? 0 : first > count - 4 ? count - 4 : first;
    AL_REAL a = inside - first, b = a - 1.0f, c = a - 2.0f, d = a - 3.0f;
    weights[0] = -b * c * d / 6.0f;
    weights[1] = a * c * d / 2.0f;
    weights[2] = -a * b * d / 2.0f;
    weights[3] = a * b * c / 6.0f;
    return first;
}

#endif
